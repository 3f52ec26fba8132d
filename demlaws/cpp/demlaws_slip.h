// demlaws_slip.h: partial slip of a contact, a row of springs sorted by normal stiffness. C++11, needs demlaws_shear.h.
//
// A contact is a row of springs, one for each stiffness that it had while it grew: the method of dimensionality
// reduction of Popov and Hess. Springs between two bounds of the stiffness are one spring; the bounds are a ladder,
// graded towards the springs that touched last. Twin of demlaws/core/slip.py, which explains it.
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
// overlaps at which they touched [m], but for the last one; their stretches [m], the first components, then the second
// ones; the first unit vector (Motion). All zeros: no shear force. The numbers are the caller's.
class SpringRow {
public:
  static const int MOST = 22; // LIGGGHTS has room for 99 values per contact
  static int size(int springs) { return 4 * springs + 2; }
  static const int MOST_SIZE = 4 * MOST + 2;
  static bool may_have(double springs) { return springs == (int)springs && springs >= 2. && springs <= MOST; }
  // Whether a number has the other sign seen from the other body: see Motion.
  static bool changes_sign(int number, int springs) { return number >= 2 * springs - 1 && number < 3 * springs - 1; }
  SpringRow(double *numbers, int springs)
      : bound_(numbers), rest_(numbers + springs), u_(numbers + 2 * springs - 1), v_(numbers + 3 * springs - 1),
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
    if (!curve.hertzian) std::copy(rest_, rest_ + last_, rest);
    set(stiffness, curve, rest);
    if (!curve.hertzian) std::copy(rest, rest + last_, rest_);
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

  // Bounds over the stiffness of the contact.
  static const double *ladder(int springs) {
    if (springs == SPRINGS) return LADDER;
    struct Ladders {
      double values[MOST + 1][MOST];
      Ladders() {
        for (int n = 2; n <= MOST; n++) {
          const double growth = 1. + 6.4 / n, whole = pow(growth, n);
          for (int i = 0; i < n; i++) values[n][i] = (whole - pow(growth, n - 1 - i)) / (whole - 1.);
        }
      }
    };
    static const Ladders ladders;
    return ladders.values[springs];
  }
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
    if (curve.hertzian) set_rest(top, depth, rest);
    double carried = 0., low = 0.;
    for (int i = 0; i < n; i++) most[i] = std::max(depth - rest[i], 0.);
    for (int i = 0; i < n; i++) {
      carried += (bound_[i] - low) * most[i];
      low = bound_[i];
    }
    const double scale = carried > 0. ? limit / carried : 0.;
    for (int i = 0; i < n; i++) most[i] *= scale;
    shorten(n, most, u_, v_); // the compression fell: slip without displacement
    sum(kept);
    for (int i = 0; i < n; i++) {
      u_[i] += du;
      v_[i] += dv;
    }
    shorten(n, most, u_, v_);
    energy = sum(force);
  }
  // Without a branch.
  DEMLAWS_INLINE static void shorten(int n, const double *most, double *u, double *v) {
    for (int i = 0; i < n; i++) {
      const double square = std::max(u[i] * u[i] + v[i] * v[i], most[i] * most[i]),
                   share = most[i] / std::sqrt(std::max(square, 1e-300));
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
    const double held = bound_[last_], *const steps = ladder(springs_);
    int edge = last_;
    if (!(held > 0.)) return begin(top, curve, steps, rest);
    if (top < held) {
      if (top <= bound_[last_ - 1]) {
        edge = 0;
        for (int i = 0; i < last_; i++) edge += bound_[i] < top;
        for (int i = edge; i < last_; i++) bound_[i] = top;
      }
      bound_[last_] = top;
    } else if (top > held) {
      const double low = bound_[last_ - 1], share = (held - low) / (top - low);
      bound_[last_] = top;
      u_[last_] *= share;
      v_[last_] *= share;
    }
    if (!curve.hertzian) rest[edge] = curve.depth - outermost(top, curve, edge, rest);
    if (edge < last_) divide(top, curve, steps, edge, rest);
    else if (top > held && bound_[last_ - 1] < top - LADDER_SLACK * (1. - steps[last_ - 1]) * top)
      lift(top, curve, steps, rest);
  }
  // A new contact: its curve is taken as a power law.
  __attribute__((noinline, cold)) void begin(double top, const UnloadingCurve &curve, const double *steps,
                                             double *rest) {
    const double power = curve.force / std::max(top * curve.depth - curve.force, 1e-12 * curve.force);
    double low = 0., integral_below = 0.;
    for (int i = 0; i < springs_; i++) {
      const double integral = curve.depth * top * pow(steps[i], power + 1.) / (power + 1.);
      bound_[i] = steps[i] * top;
      rest[i] = (integral - integral_below) / (bound_[i] - low);
      low = bound_[i];
      integral_below = integral;
      u_[i] = v_[i] = 0.;
    }
  }
  // Mean compression of the outermost spring: what the others leave of the force.
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
    return std::min(std::max(mean, straight / LADDER_FARTHEST), straight * LADDER_FARTHEST);
  }
  // Moves the bounds that are below their steps.
  __attribute__((noinline)) void lift(double top, const UnloadingCurve &curve, const double *steps, double *rest) {
    double bound[MOST], touched[MOST], u[MOST], v[MOST], start = 0., low = 0.;
    std::copy(bound_, bound_ + springs_, bound);
    if (!curve.hertzian) std::copy(rest, rest + springs_, touched);
    std::copy(u_, u_ + springs_, u);
    std::copy(v_, v_ + springs_, v);
    for (int i = 0, j = 0; i < springs_; i++) {
      const double high = std::max(steps[i] * top, bound[i]), from = low;
      double sums = 0., first = 0., second = 0.;
      while (low < high) {
        const double end = std::min(bound[j], high);
        if (end > low) {
          if (!curve.hertzian)
            sums += (end - low) *
                    (touched[j] + 0.5 * slope(curve.depth, bound, touched, start, j) * (low + end - start - bound[j]));
          first += (end - low) * u[j];
          second += (end - low) * v[j];
          low = end;
        }
        if (low < high) start = bound[j++];
      }
      const double width = high - from;
      bound_[i] = high;
      u_[i] = width > 0. ? first / width : u[j];
      v_[i] = width > 0. ? second / width : v[j];
      if (!curve.hertzian) rest[i] = width > 0. ? sums / width : touched[j];
    }
  }
  // Of the overlap at touch over the stiffness, in spring j above `start`.
  double slope(double depth, const double *bound, const double *touched, double start, int j) const {
    const double width = bound[j] - start;
    if (j == last_) return 2. * (depth - touched[j]) / width;
    const double before = j > 0 ? start - (j > 1 ? bound[j - 2] : 0.) : -width;
    return (touched[j + 1] - touched[std::max(j - 1, 0)]) / (0.5 * (before + bound[j + 1] - bound[j]) + width);
  }
  // Divides springs that contain the most steps of the ladder, while there are empty ones behind `edge`, the outermost.
  __attribute__((noinline)) void divide(double top, const UnloadingCurve &curve, const double *steps, int edge,
                                        double *rest) {
    while (edge < last_) {
      int most = 0, at = -1, step = last_ - 1;
      double place = 0.;
      for (int j = edge; j >= 0; j--) {
        const int highest = step;
        while (step >= 0 && steps[step] * top > below(j)) step--;
        if (highest - step > most) {
          most = highest - step;
          at = j;
          place = steps[(highest + step + 1) / 2] * top;
        }
      }
      if (at < 0) break;
      const double low = below(at), high = bound_[at];
      if (!curve.hertzian) {
        const double whole = (high - low) * rest[at],
                     part = integral(at, place, low, high, whole, curve.depth, top, rest);
        for (int j = edge + 1; j > at; j--) rest[j] = rest[j - 1];
        rest[at] = part / (place - low);
        rest[at + 1] = (whole - part) / (high - place);
      }
      for (int j = edge + 1; j > at; j--) {
        bound_[j] = bound_[j - 1];
        u_[j] = u_[j - 1];
        v_[j] = v_[j - 1];
      }
      bound_[at] = place;
      edge++;
    }
    for (int j = edge + 1; j < springs_; j++) {
      bound_[j] = top;
      rest[j] = curve.depth;
      u_[j] = u_[edge];
      v_[j] = v_[edge];
    }
  }
  // Of the overlap at touch over the stiffness from `low` to `place`, taken as a power from 0 on; whole: to `high`.
  double integral(int at, double place, double low, double high, double whole, double depth, double top,
                  const double *rest) const {
    double inside = 0., part;
    for (int j = 0; j < at; j++) inside += (bound_[j] - below(j)) * rest[j];
    if (inside > 0.) part = inside * pow(place / low, log1p(whole / inside) / log(high / low)) - inside;
    else if (!(whole > 0.)) return 0.;
    else if (high < top)
      part =
          whole * pow(place / high, log1p((bound_[at + 1] - high) * rest[at + 1] / whole) / log(bound_[at + 1] / high));
    else part = whole * pow(place / high, depth * top / whole);
    return std::min(std::max(part, 0.), whole);
  }
};

} // namespace demlaws
#endif
