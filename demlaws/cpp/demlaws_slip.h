// demlaws_slip.h: partial slip of a contact, a row of springs sorted by normal stiffness. C++11, needs demlaws_shear.h.
//
// A contact is a row of springs, one for each stiffness that it had while it grew: the method of dimensionality
// reduction of Popov and Hess. Springs between two bounds of the stiffness are one spring, of which parts may slip; the
// bounds are close to each other near the springs that touched last. Twin of demlaws/core/slip.py, which explains it.
//
// The springs of a contact are computed together and stay in registers during a step (demlaws_lanes.h): half the time.
//
// Licence: GPL-2.0-or-later, as the package demlaws.
#ifndef DEMLAWS_SLIP_H
#define DEMLAWS_SLIP_H
#include "demlaws_lanes.h"
#include "demlaws_shear.h"

namespace demlaws {

// The curve along which a contact would unload now: its force [N] and length up to here [m]; whether it is Hertz's.
struct UnloadingCurve {
  double force, depth;
  bool hertzian;
};

// One step of the springs of a contact, of which there are at most N. Places beyond them have no stiffness.
template <int N> class SpringStep {
  typedef SpringLanes<N> Lanes;
  typedef typename Lanes::Masks Masks;
  static const int NONE = N; // no place

public:
  DEMLAWS_INLINE SpringStep(double *numbers, int springs, double stiffness, const UnloadingCurve &curve)
      : numbers_(numbers), last_(springs - 1), top_(stiffness), curve_(curve),
        thin_(SPRING_THIN / springs * stiffness) {}

  __attribute__((noinline)) static void step_of(double *numbers, int springs, double stiffness,
                                                const UnloadingCurve &curve, double ratio, double limit,
                                                const double *d, ShearStep &step) {
    SpringStep(numbers, springs, stiffness, curve).slip(ratio, limit, d, step);
  }
  // Displaces the springs by d under Coulomb's limit [N].
  DEMLAWS_INLINE void slip(double ratio, double limit, const double *d, ShearStep &step) {
    const int n = last_ + 1;
    const double held = numbers_[last_];
    bound_ = Lanes(numbers_, n, held);
    u_ = Lanes(numbers_ + 2 * n, n, 0.);
    v_ = Lanes(numbers_ + 3 * n, n, 0.);
    step.before = 0.5 * ratio * ((bound_ - bound_.inside(0.)) * (u_ * u_ + v_ * v_)).sum();
    if (!curve_.hertzian) rest_ = Lanes(numbers_ + n, n, 0.);
    set(held);
    const Lanes low = bound_.inside(0.), width = bound_ - low;
    Lanes most;
    double carried;
    if (curve_.hertzian) {
      const double unit = curve_.depth / (3. * top_ * top_);
      most = larger(Lanes(curve_.depth) - (bound_ * (bound_ + low) + low * low) * unit, 0.);
      carried = (2. / 3.) * curve_.depth * top_;
    } else {
      most = larger(Lanes(curve_.depth) - rest_, 0.);
      carried = (width * most).sum();
      rest_.store(numbers_ + n, n);
    }
    most = most * (carried > 0. ? limit / (ratio * carried) : 0.);
    const Lanes beyond = width.outside(0.),
                onset = smaller((most * beyond + most.outside(0.) * width) / larger(width + beyond, 1e-300), most);
    // The compression fell: slip without displacement.
    const Lanes square = u_ * u_ + v_ * v_, longer = square.root(), held_length = smaller(longer, most);
    const Masks shorter = longer > most;
    if (shorter.any()) {
      const Lanes share = where(shorter, most / larger(longer, 1e-300), 1.);
      u_ = u_ * share;
      v_ = v_ * share;
    }
    const double kept[2] = {(width * u_).sum(), (width * v_).sum()};
    // A spring stretched beyond `onset` follows less and less, up to its limit, on the part of the way on which its
    // outer neighbour slips at its own limit.
    u_ = u_ + d[0];
    v_ = v_ + d[1];
    const Lanes held_or_onset = larger(held_length, onset), moved = u_ * u_ + v_ * v_;
    if ((moved > held_or_onset * held_or_onset).any()) {
      const Lanes length = moved.root(), wide = larger(most - onset, 1e-100),
                  beyond = larger(length - most, 0.).outside(HUGE_VAL),
                  start = smaller(larger(held_or_onset, length - beyond), most),
                  stuck = larger(((most - start) * wide).root() - (length - start) * 0.5, 0.),
                  share = where(length > start, (most * wide - stuck * stuck) / (wide * length), 1.);
      u_ = u_ * share;
      v_ = v_ * share;
    }
    const double after[2] = {(width * u_).sum(), (width * v_).sum()};
    step.energy = 0.5 * ratio * (width * (u_ * u_ + v_ * v_)).sum();
    bound_.store(numbers_, n);
    u_.store(numbers_ + 2 * n, n);
    v_.store(numbers_ + 3 * n, n);
    step.work = 0.;
    double moves = 0., gained = 0.;
    for (int k = 0; k < 2; k++) {
      step.work += 0.5 * ratio * (kept[k] + after[k]) * d[k];
      gained += (after[k] - kept[k]) * d[k];
      moves += top_ * d[k] * d[k];
      step.force[k] = ratio * after[k];
    }
    step.stuck = moves > 0. ? std::min(std::max(gained / moves, 0.), 1.) : 1.;
  }

private:
  double *numbers_;
  int last_;
  double top_;
  UnloadingCurve curve_;
  double thin_;
  Lanes bound_, rest_, u_, v_;

  DEMLAWS_INLINE double below(int i) const { return i > 0 ? bound_[i - 1] : 0.; }

  // The contact had the stiffness `held` and has `top_` now.
  DEMLAWS_INLINE void set(double held) {
    // lowest: not of springs that rounding makes
    const double lowest = std::min(top_, held) * (1. - EMPTY_LEVEL);
    int edge = held > 0. ? (bound_ < lowest).count() : last_;
    double low = edge > 0 ? numbers_[edge - 1] : 0., share = 1.;
    bool opened = held == 0. || (edge < last_ && top_ < held);
    if (held > 0. && top_ > held) {
      if (top_ - low <= thin_) share = (held - low) / (top_ - low);
      else {
        if (edge == last_) join(held);
        else edge++;
        share = 0.;
        low = held;
      }
    }
    const Lanes place = Lanes::places();
    if (held == 0.) {
      SpringStep copy = *this; // an object that has no address is kept in registers
      edge = copy.begin();
      *this = copy;
      low = below(edge);
    }
    const Masks inner = place < edge;
    bound_ = where(inner, bound_, top_);
    u_ = where(inner, u_, where(place > edge, 0., u_ * share));
    v_ = where(inner, v_, where(place > edge, 0., v_ * share));
    if (!curve_.hertzian) rest_ = where(inner, rest_, curve_.depth - outermost(edge));
    if (opened || top_ - low > SPRING_WIDE * thin_) {
      SpringStep copy = *this;
      edge = copy.grade(edge);
      *this = copy;
    }
    if (!curve_.hertzian) rest_ = where(place > edge, curve_.depth, rest_);
  }
  // A new contact: its curve is taken as a power law. Returns the outermost spring.
  __attribute__((noinline, cold)) int begin() {
    const double power = curve_.force / std::max(top_ * curve_.depth - curve_.force, 1e-12 * curve_.force);
    double share = 1., low = 0., integral_below = 0.;
    int edge = 0;
    bound_ = u_ = v_ = rest_ = Lanes(0.);
    for (; edge < last_ && share > SPRING_WIDE * SPRING_THIN / (last_ + 1); edge++) {
      share *= 0.5;
      const double bound = (1. - share) * top_,
                   integral = curve_.depth * top_ * pow(1. - share, power + 1.) / (power + 1.);
      bound_.set(edge, bound);
      rest_.set(edge, (integral - integral_below) / (bound - low));
      low = bound;
      integral_below = integral;
    }
    return edge;
  }
  // Mean compression of the outermost spring, which carries the rest of the force.
  DEMLAWS_INLINE double outermost(int edge) const {
    const double low = below(edge), width = top_ - low;
    const Lanes compressed = larger(Lanes(curve_.depth) - rest_, 0.);
    const double carried = where(Lanes::places() < edge, (bound_ - bound_.inside(0.)) * compressed, 0.).sum(),
                 mean = width > 0. ? std::max(curve_.force - carried, 0.) / width : 0.;
    if (edge == 0) return mean;
    const double straight =
        std::max(curve_.depth - rest_[edge - 1], 0.) * 0.5 * width / (top_ - 0.5 * (low + below(edge - 1)));
    return std::min(std::max(mean, straight / SPRING_FARTHEST), straight * SPRING_FARTHEST);
  }
  // Error of the loss that one spring makes: in small cycles and in large ones.
  DEMLAWS_INLINE static Lanes error(const Lanes &low, const Lanes &high, double top) {
    const Lanes width = high - low, small = width / (Lanes(top) - low), large = width * (1. / top);
    return small * small + large * large * SPRING_LARGE_CYCLES;
  }
  // Of the first `unions` springs, each with its outer neighbour.
  DEMLAWS_INLINE Lanes union_errors(const Lanes &low, int unions, double top) const {
    return where(Lanes::places() < unions, error(low, bound_.outside(top), top), HUGE_VAL);
  }
  // Joins the two neighbours whose union errs and loses least; the outermost spring is free then.
  DEMLAWS_INLINE void join(double top) {
    const Lanes place = Lanes::places(), low = bound_.inside(0.), outer = bound_.outside(top), u = u_.outside(0.),
                v = v_.outside(0.), first = bound_ - low, second = outer - bound_;
    const double stored = 0.5 * (first * (u_ * u_ + v_ * v_)).sum();
    const Lanes lost =
                    first * second / larger(first + second, 1e-300) * ((u - u_) * (u - u_) + (v - v_) * (v - v_)) * 0.5,
                errors = union_errors(low, last_ - 1, top) + lost * (SPRING_LOST / std::max(stored, 1e-300));
    const double at = where(errors > errors.smallest(), NONE, place).smallest();
    const Lanes share = first / larger(outer - low, 1e-300), other = Lanes(1.) - share;
    const Masks inner = place < at, here = place == at;
    u_ = where(inner, u_, where(here, share * u_ + other * u, u));
    v_ = where(inner, v_, where(here, share * v_ + other * v, v));
    if (!curve_.hertzian) {
      const Lanes rest = rest_.outside(0.);
      rest_ = where(inner, rest_, where(here, share * rest_ + other * rest, rest));
    }
    bound_ = where(inner, bound_, outer);
  }
  // The spring inside the outermost one that is worth a division; -1: none.
  DEMLAWS_INLINE int widest(int edge) const {
    const Lanes place = Lanes::places(), low = bound_.inside(0.),
                errors = where(place < edge, error(low, bound_, top_), -1.);
    const double most = errors.largest();
    if (!(most > 0.)) return -1;
    const int at = (int)where(errors < most, NONE, place).smallest();
    const double least = union_errors(low, edge, top_).smallest();
    return most > std::min(SPRING_SPARE * least, SPRING_COARSE[last_ + 1]) ? at : -1;
  }
  // Divides springs, the outermost one first, and joins others for it where none is free; returns the outermost.
  __attribute__((noinline)) int grade(int edge) {
    while (true) {
      int at = edge;
      if (top_ - below(edge) > SPRING_WIDE * thin_ && (edge < last_ || last_ > 1)) { // of two springs none is left
        if (edge == last_) {
          join(top_);
          at = --edge;
        }
      } else at = edge < last_ ? widest(edge) : -1;
      if (at < 0) return edge;
      divide(at, edge++);
    }
  }
  // Divides a spring in the middle.
  DEMLAWS_INLINE void divide(int at, int edge) {
    const Lanes place = Lanes::places(), low = bound_.inside(0.);
    const Masks outer = place > at, here = place == at;
    if (!curve_.hertzian) {
      const double mean = curve_.depth - rest_[at],
                   quarter = 0.25 * std::min(std::max(fall_within(at, edge), 0.), 3. * mean);
      rest_ = where(outer, rest_.inside(0.), rest_);
      rest_.set(at, curve_.depth - mean - quarter);
      rest_.set(at + 1, curve_.depth - mean + quarter);
    }
    bound_ = where(outer, low, where(here, (low + bound_) * 0.5, bound_));
    u_ = where(outer, u_.inside(0.), u_);
    v_ = where(outer, v_.inside(0.), v_);
  }
  // Fall of the compression from the inner to the outer bound of a spring.
  double fall_within(int at, int edge) const {
    const double depth = curve_.depth;
    if (edge == 0) return depth;
    const double before = at > 0 ? bound_[at - 1] - below(at - 1) : 0., width = bound_[at] - below(at),
                 after = at < edge ? bound_[at + 1] - bound_[at] : 0., mean = depth - rest_[at];
    if (at == 0)
      return (rest_[1] * width * width + rest_[0] * after * (2. * after + 3. * width)) /
             ((width + after) * (width + after));
    if (at == edge)
      return ((depth - rest_[at - 1]) * width * width + mean * before * (2. * before + 3. * width)) /
             ((width + before) * (width + before));
    const double outside = (2. * before + width) / (after + width) * (rest_[at + 1] - rest_[at]),
                 inside = (2. * after + width) / (before + width) * (rest_[at] - rest_[at - 1]);
    return width / (before + width + after) * (outside + inside);
  }
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
  SpringRow(double *numbers, int springs) : numbers_(numbers), springs_(springs) {}

  double energy(double ratio) const {
    const double *const bound = numbers_, *const u = bound + 2 * springs_, *const v = u + springs_;
    double energy = 0., low = 0.;
    for (int i = 0; i < springs_; i++) {
      energy += (bound[i] - low) * (u[i] * u[i] + v[i] * v[i]);
      low = bound[i];
    }
    return 0.5 * ratio * energy;
  }

  // One step: the stiffness K with which the contact would unload along a curve, K_t / K, Coulomb's limit mu P [N] and
  // the motion of the step, all of now.
  ShearStep step(double stiffness, const UnloadingCurve &curve, double ratio, double limit, const Motion &motion) {
    ShearStep step;
    if (!(stiffness > 0.) || !(curve.force > 0.)) { // an overlap that carries no force: every spring has opened
      step.before = energy(ratio);
      std::fill(numbers_, numbers_ + 4 * springs_, 0.);
      step.force[0] = step.force[1] = step.work = step.energy = step.stuck = 0.;
    } else if (springs_ <= 12)
      SpringStep<12>::step_of(numbers_, springs_, stiffness, curve, ratio, limit, motion.displacement, step);
    else SpringStep<24>::step_of(numbers_, springs_, stiffness, curve, ratio, limit, motion.displacement, step);
    return step;
  }

private:
  double *const numbers_;
  const int springs_;
};

} // namespace demlaws
#endif
