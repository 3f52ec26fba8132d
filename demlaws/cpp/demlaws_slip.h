// demlaws_slip.h: partial slip of a contact, a row of springs sorted by normal stiffness. C++11, needs demlaws_shear.h.
//
// A contact is a row of springs, one for each stiffness that it had while it grew: the method of dimensionality
// reduction of Popov and Hess. Springs between two bounds of the stiffness are one spring, of which parts may slip; the
// bounds are close to each other near the springs that touched last. Twin of demlaws/core/slip.py, which explains it.
//
// Licence: GPL-2.0-or-later, as the package demlaws.
#ifndef DEMLAWS_SLIP_H
#define DEMLAWS_SLIP_H
#include "demlaws_shear.h"

// The plugins are compiled without vectors; here one vector has several springs.
#if defined(__GNUC__) && !defined(__clang__)
#define DEMLAWS_VECTORS __attribute__((noinline, optimize("tree-vectorize")))
#else
#define DEMLAWS_VECTORS __attribute__((noinline))
#endif

namespace demlaws {

// The curve along which a contact would unload now: its force [N] and length up to here [m]; whether it is Hertz's.
struct UnloadingCurve {
  double force, depth;
  bool hertzian;
};

// What a contact keeps: the bounds of the springs' stiffnesses [N/m], rising, the last one the contact's own; the mean
// overlaps at which they touched [m]; their stretches [m], the first components, then the second
// ones; the first unit vector (Motion). All zeros: no shear force. The numbers are the caller's.
class SpringRow {
public:
  static const int MOST = 22; // LIGGGHTS has room for 99 values per contact
  static int size(int springs) { return 4 * springs + 3; }
  static const int MOST_SIZE = 4 * MOST + 3;
  static bool may_have(double springs) { return springs == (int)springs && springs >= 2. && springs <= MOST; }
  // Whether a number has the other sign seen from the other body: see Motion.
  static bool changes_sign(int number, int springs) { return number >= 2 * springs && number < 3 * springs; }
  SpringRow(double *numbers, int springs)
      : bound_(numbers), rest_(numbers + springs), u_(numbers + 2 * springs), v_(numbers + 3 * springs),
        springs_(springs), last_(springs - 1) {}

  double energy(double ratio) const {
    double force[2];
    return ratio * sum(force);
  }

  // One step: the stiffness K with which the contact would unload along a curve, K_t / K, Coulomb's limit mu P [N] and
  // the motion of the step, all of now.
  ShearStep step(double stiffness, const UnloadingCurve &curve, double ratio, double limit, const Motion &motion) {
    const double *const d = motion.displacement;
    double before[2], after[2], kept[2];
    ShearStep step;
    step.before = ratio * sum(before);
    if (!(stiffness > 0.) || !(curve.force > 0.)) { // an overlap that carries no force: every spring has opened
      std::fill(bound_, v_ + springs_, 0.);
      step.force[0] = step.force[1] = step.work = step.energy = step.stuck = 0.;
      return step;
    }
    double rest[MOST], most[MOST];
    if (!curve.hertzian) std::copy(rest_, rest_ + springs_, rest);
    set(stiffness, curve, rest);
    if (!curve.hertzian) std::copy(rest, rest + springs_, rest_);
    slip(stiffness, curve, limit / ratio, d, rest, most, kept, after, step.energy);
    step.energy *= ratio;
    step.work = 0.;
    double moved = 0., gained = 0.;
    for (int k = 0; k < 2; k++) {
      step.work += 0.5 * ratio * (kept[k] + after[k]) * d[k];
      gained += (after[k] - kept[k]) * d[k];
      moved += stiffness * d[k] * d[k];
      step.force[k] = ratio * after[k];
    }
    step.stuck = moved > 0. ? std::min(std::max(gained / moved, 0.), 1.) : 1.;
    return step;
  }

private:
  double *const bound_, *const rest_, *const u_, *const v_;
  const int springs_, last_;

  double below(int i) const { return i > 0 ? bound_[i - 1] : 0.; }

  // Force [N] and energy [J] for K_t / K = 1.
  double sum(double *force) const {
    double first = 0., second = 0., energy = 0., low = 0.;
    for (int i = 0; i < springs_; i++) {
      const double stiffness = bound_[i] - low, u = u_[i], v = v_[i];
      first += stiffness * u;
      second += stiffness * v;
      energy += stiffness * (u * u + v * v);
      low = bound_[i];
    }
    force[0] = first;
    force[1] = second;
    return 0.5 * energy;
  }

  // Displaces the springs under their limits, which together are `limit`. kept: force before the displacement.
  DEMLAWS_VECTORS void slip(double top, const UnloadingCurve &curve, double limit, const double *d, double *rest,
                            double *most, double *kept, double *force, double &energy) {
    const int n = springs_;
    const double depth = curve.depth, du = d[0], dv = d[1];
    double onset[MOST], width[MOST];
    if (curve.hertzian) set_rest(top, depth, rest);
    double carried = 0., low = 0.;
    for (int i = 0; i < n; i++) most[i] = std::max(depth - rest[i], 0.);
    for (int i = 0; i < n; i++) {
      width[i] = bound_[i] - low;
      carried += width[i] * most[i];
      low = bound_[i];
    }
    const double scale = carried > 0. ? limit / carried : 0.;
    for (int i = 0; i < n; i++) most[i] *= scale;
    for (int i = 0; i < n - 1; i++)
      onset[i] = std::min((most[i] * width[i + 1] + most[i + 1] * width[i]) / std::max(width[i] + width[i + 1], 1e-300),
                          most[i]);
    onset[n - 1] = 0.;
    shorten(n, most, u_, v_); // the compression fell: slip without displacement
    sum(kept);
    displace(n, du, dv, onset, most, u_, v_);
    energy = sum(force);
  }
  // Loops without a branch, where there is anything to do.
  DEMLAWS_INLINE static void shorten(int n, const double *most, double *u, double *v) {
    int longer = 0;
    for (int i = 0; i < n; i++) longer += u[i] * u[i] + v[i] * v[i] > most[i] * most[i];
    if (longer == 0) return;
    for (int i = 0; i < n; i++) {
      const double square = std::max(u[i] * u[i] + v[i] * v[i], most[i] * most[i]),
                   share = most[i] / std::sqrt(std::max(square, 1e-300));
      u[i] *= share;
      v[i] *= share;
    }
  }
  // A spring stretched beyond `onset` follows less and less, up to its limit.
  DEMLAWS_INLINE static void displace(int n, double du, double dv, const double *onset, const double *most, double *u,
                                      double *v) {
    double before[MOST];
    int yields = 0;
    for (int i = 0; i < n; i++) {
      before[i] = std::max(u[i] * u[i] + v[i] * v[i], onset[i] * onset[i]);
      u[i] += du;
      v[i] += dv;
      yields += u[i] * u[i] + v[i] * v[i] > before[i];
    }
    if (yields == 0) return;
    for (int i = 0; i < n; i++) {
      const double from = std::sqrt(before[i]), length = std::sqrt(u[i] * u[i] + v[i] * v[i]),
                   wide = std::max(most[i] - onset[i], 1e-300),
                   stuck = std::max(std::sqrt(std::max(1. - (from - onset[i]) / wide, 0.)) -
                                        0.5 * std::max(length - from, 0.) / wide,
                                    0.),
                   reached = (onset[i] + wide * (1. - stuck * stuck)) / std::max(length, 1e-300),
                   share = length > from ? reached : 1.;
      u[i] *= share;
      v[i] *= share;
    }
  }
  DEMLAWS_INLINE void set_rest(double top, double depth, double *rest) const {
    const double unit = depth / (3. * top * top);
    rest[0] = unit * bound_[0] * bound_[0];
    for (int i = 1; i < springs_; i++)
      rest[i] = unit * (bound_[i] * bound_[i] + bound_[i] * bound_[i - 1] + bound_[i - 1] * bound_[i - 1]);
  }

  // The contact has the stiffness `top` now.
  DEMLAWS_INLINE void set(double top, const UnloadingCurve &curve, double *rest) {
    // lowest: not of springs that rounding makes
    const double held = bound_[last_], lowest = std::min(top, held) * (1. - EMPTY_LEVEL),
                 thin = SPRING_THIN / springs_ * top;
    int edge = last_;
    while (edge > 0 && bound_[edge - 1] >= lowest) edge--;
    const bool opened = held == 0. || (edge < last_ && top < held);
    if (held > 0. && top > held) {
      const double low = below(edge);
      if (top - low <= thin) {
        u_[edge] *= (held - low) / (top - low);
        v_[edge] *= (held - low) / (top - low);
      } else {
        if (edge == last_) join(rest);
        else edge++;
        u_[edge] = v_[edge] = 0.;
      }
    }
    if (held == 0.) edge = begin(top, curve, rest);
    for (int i = edge; i < springs_; i++) bound_[i] = top;
    if (!curve.hertzian) rest[edge] = curve.depth - outermost(top, curve, edge, rest);
    if (opened || top - below(edge) > SPRING_WIDE * thin) {
      if (curve.hertzian) set_rest(top, curve.depth, rest);
      edge = grade(edge, curve.depth, rest);
    }
    for (int i = edge + 1; i < springs_; i++) {
      rest[i] = curve.depth;
      u_[i] = v_[i] = 0.;
    }
  }
  // A new contact: its curve is taken as a power law. Returns the outermost spring.
  __attribute__((noinline, cold)) int begin(double top, const UnloadingCurve &curve, double *rest) {
    const double power = curve.force / std::max(top * curve.depth - curve.force, 1e-12 * curve.force);
    double share = 1., low = 0., integral_below = 0.;
    int edge = 0;
    for (; edge < last_ && share > SPRING_WIDE * SPRING_THIN / springs_; edge++) {
      share *= 0.5;
      bound_[edge] = (1. - share) * top;
      const double integral = curve.depth * top * pow(1. - share, power + 1.) / (power + 1.);
      rest[edge] = (integral - integral_below) / (bound_[edge] - low);
      low = bound_[edge];
      integral_below = integral;
    }
    return edge;
  }
  // Mean compression of the outermost spring, which carries the rest of the force.
  __attribute__((noinline)) double outermost(double top, const UnloadingCurve &curve, int edge,
                                             const double *rest) const {
    double carried = 0., low = 0.;
    for (int i = 0; i < edge; i++) {
      carried += (bound_[i] - low) * std::max(curve.depth - rest[i], 0.);
      low = bound_[i];
    }
    const double width = top - low, mean = width > 0. ? std::max(curve.force - carried, 0.) / width : 0.;
    if (edge == 0) return mean;
    const double straight =
        std::max(curve.depth - rest[edge - 1], 0.) * 0.5 * width / (top - 0.5 * (low + below(edge - 1)));
    return std::min(std::max(mean, straight / SPRING_FARTHEST), straight * SPRING_FARTHEST);
  }
  // Error of the loss that one spring makes: in small cycles and in large ones.
  static double error(double low, double high, double top) {
    const double width = high - low, small = width / (top - low), large = width / top;
    return small * small + SPRING_LARGE_CYCLES * large * large;
  }
  // Joins the two neighbours whose union errs least; the outermost spring is free then.
  __attribute__((noinline)) void join(double *rest) {
    double least = HUGE_VAL;
    int at = 0;
    for (int i = 0; i < last_ - 1; i++) {
      const double one = error(below(i), bound_[i + 1], bound_[last_]);
      if (one < least) {
        least = one;
        at = i;
      }
    }
    const double share = (bound_[at] - below(at)) / (bound_[at + 1] - below(at)), other = 1. - share;
    rest[at] = share * rest[at] + other * rest[at + 1];
    u_[at] = share * u_[at] + other * u_[at + 1];
    v_[at] = share * v_[at] + other * v_[at + 1];
    bound_[at] = bound_[at + 1];
    for (int i = at + 1; i < last_; i++) copy(i + 1, i, rest);
  }
  void copy(int from, int to, double *rest) {
    bound_[to] = bound_[from];
    rest[to] = rest[from];
    u_[to] = u_[from];
    v_[to] = v_[from];
  }
  // The spring inside the outermost one that is worth a division; -1: none.
  int widest(int edge) const {
    double most = 0., least = HUGE_VAL;
    int at = -1;
    for (int i = 0; i < edge; i++) {
      const double one = error(below(i), bound_[i], bound_[edge]);
      if (one > most) {
        most = one;
        at = i;
      }
      least = std::min(least, error(below(i), bound_[i + 1], bound_[edge]));
    }
    const double coarse = SPRING_COARSE * log(springs_ / SPRING_THIN) / springs_;
    return most > std::min(SPRING_SPARE * least, coarse * coarse) ? at : -1;
  }
  // Divides springs, the outermost one first, and joins others for it where none is free; returns the outermost.
  __attribute__((noinline)) int grade(int edge, double depth, double *rest) {
    const double top = bound_[last_];
    while (true) {
      int at = edge;
      const bool wide = top - below(edge) > SPRING_WIDE * SPRING_THIN / springs_ * top;
      if (wide && (edge < last_ || last_ > 1)) { // of two springs none is left to be joined
        if (edge == last_) {
          join(rest);
          at = --edge;
        }
      } else at = edge < last_ ? widest(edge) : -1;
      if (at < 0) return edge;
      const double mean = depth - rest[at],
                   quarter = 0.25 * std::min(std::max(fall_within(at, depth, edge, rest), 0.), 3. * mean);
      for (int i = edge; i >= at; i--) copy(i, i + 1, rest);
      bound_[at] = 0.5 * (below(at) + bound_[at]);
      rest[at] = depth - mean - quarter;
      rest[at + 1] = depth - mean + quarter;
      edge++;
    }
  }
  // Fall of the compression from the inner to the outer bound of a spring.
  double fall_within(int at, double depth, int edge, const double *rest) const {
    if (edge == 0) return depth;
    const double before = at > 0 ? bound_[at - 1] - below(at - 1) : 0., width = bound_[at] - below(at),
                 after = at < edge ? bound_[at + 1] - bound_[at] : 0., mean = depth - rest[at];
    if (at == 0)
      return (rest[1] * width * width + rest[0] * after * (2. * after + 3. * width)) /
             ((width + after) * (width + after));
    if (at == edge)
      return ((depth - rest[at - 1]) * width * width + mean * before * (2. * before + 3. * width)) /
             ((width + before) * (width + before));
    const double outside = (2. * before + width) / (after + width) * (rest[at + 1] - rest[at]),
                 inside = (2. * after + width) / (before + width) * (rest[at] - rest[at - 1]);
    return width / (before + width + after) * (outside + inside);
  }
};

} // namespace demlaws
#endif
