// demlaws_shear.h: shear force of a contact that sticks until it slides, without creating energy. C++11, no dependency.
//
// The springs of a contact in at most M levels, ordered by the K_t at which they touched. Where K_t falls, the springs
// above it open and take their force and their energy along; where K_t rises, the springs that touch are not stretched.
// Then the displacement and Coulomb's limit, the same for all. So no path returns more than was put in, and a contact
// whose overlap vibrates keeps its shear force (docs/shear.md) [our derivation]. Twin of
// demlaws/core/levels.py.
//
// Licence: GPL-2.0-or-later, as the package demlaws.
#ifndef DEMLAWS_SHEAR_H
#define DEMLAWS_SHEAR_H
#include <algorithm>
#include <cmath>

namespace demlaws {

// One step of the shear of a contact.
struct ShearStep {
  double force[3];             // against the displacement [N]
  double work, before, energy; // done on the contact; stored before the step and after it [J]
  bool slides;                 // Coulomb's limit acts on the whole contact

  // Taken by friction and by the parts of the contact that opened [J].
  double lost() const { return work - (energy - before); }
};

static const int LEVELS = 3, MOST_LEVELS = 8; // by default; at most
static const double EMPTY_LEVEL = 1e-9;       // of K_t: a level of less stiffness counts as empty
inline bool may_have_levels(double count) { return count == (int)count && count >= 1. && count <= MOST_LEVELS; }
inline int levels_size(int count) { return 4 * count; }

// What a contact keeps: for each level the upper bound of K_t [N/m], rising, the last one K_t itself; then the stretch
// of each level [m], a vector in the tangent plane. All zeros: no shear force. A level between equal bounds is empty.
// The numbers are the caller's. M: number of levels, known when compiled; 0: only when run.
template <int M> class Levels {
public:
  Levels(double *numbers, int count)
      : bound_(numbers), stretch_(numbers + (M ? M : count)), last_((M ? M : count) - 1) {}

  double energy() const {
    double sum = 0.;
    for (int i = 0; i <= last(); i++) sum += stiffness(i) * dot(stretch(i), stretch(i));
    return 0.5 * sum;
  }

  __attribute__((noinline)) static ShearStep step_of(int count, double now, double limit, const double *normal,
                                                     const double *displacement, double *numbers) {
    return Levels(numbers, count).step(now, limit, normal, displacement);
  }
  // One step: K_t, Coulomb's limit mu P [N], unit normal and tangential displacement of the step, all of now.
  inline ShearStep step(double now, double limit, const double *normal, const double *displacement) {
    ShearStep step;
    step.before = energy();
    sum_forces(step.force);
    step.work = 0.5 * dot(step.force, displacement);
    press(now);
    for (int i = 0; i <= last(); i++) {
      double *const s = stretch(i);
      for (int k = 0; k < 3; k++) s[k] += displacement[k];
      const double along = dot(s, normal);
      for (int k = 0; k < 3; k++) s[k] -= along * normal[k]; // the tangent plane has turned
    }
    sum_forces(step.force);
    const double square = dot(step.force, step.force);
    step.slides = square > limit * limit;
    if (step.slides) {
      const double scale = limit / std::sqrt(square);
      for (int k = 0; k < 3; k++) step.force[k] *= scale;
      for (int k = 0; k < 3 * last() + 3; k++) stretch_[k] *= scale;
    }
    step.work += 0.5 * dot(step.force, displacement);
    step.energy = energy();
    return step;
  }

private:
  double *const bound_, *const stretch_;
  const int last_;
  int last() const { return M ? M - 1 : last_; }
  double *stretch(int i) const { return stretch_ + 3 * i; }
  double stiffness(int i) const { return i ? bound_[i] - bound_[i - 1] : bound_[0]; }
  static double dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

  void sum_forces(double *force) const {
    force[0] = force[1] = force[2] = 0.;
    for (int i = 0; i <= last(); i++)
      for (int k = 0; k < 3; k++) force[k] += stiffness(i) * stretch(i)[k];
  }

  // K_t is now `now`. The springs that touch make one level too many: the two neighbours with the smallest
  // (k1 + k2) |s1 - s2|^2 become one, the lowest of equals; an empty level joins any other.
  inline void press(double now) {
    const bool rises = now > bound_[last()];
    for (int i = 0; i <= last(); i++) bound_[i] = std::min(bound_[i], now);
    double *const top = stretch(last());
    const double empty = EMPTY_LEVEL * now, held = stiffness(last()), fresh = now - bound_[last()], all = held + fresh;
    int lowest = last();
    double least = held > empty && fresh > empty ? all * dot(top, top) : 0.;
    for (int i = last() - 1; i >= 0; i--) {
      double difference[3];
      for (int k = 0; k < 3; k++) difference[k] = stretch(i)[k] - stretch(i + 1)[k];
      const double low = stiffness(i), high = stiffness(i + 1),
                   apart = low > empty && high > empty ? (low + high) * dot(difference, difference) : 0.;
      if (rises && apart <= least) {
        lowest = i;
        least = apart;
      }
    }
    if (__builtin_expect(lowest < last(), 0)) return join(lowest, now);
    const double share = held < all ? held / all : 1.;
    for (int k = 0; k < 3; k++) top[k] *= share;
    bound_[last()] = now;
  }
  // Levels i and i + 1 become one, the new level stands on top.
  __attribute__((noinline)) void join(int i, double now) {
    const double both = stiffness(i) + stiffness(i + 1), share = both > 0. ? stiffness(i) / both : 0.;
    for (int k = 0; k < 3; k++) stretch(i)[k] = share * stretch(i)[k] + (1. - share) * stretch(i + 1)[k];
    std::copy(stretch(i + 1) + 3, stretch(last()) + 3, stretch(i + 1));
    std::copy(bound_ + i + 1, bound_ + last() + 1, bound_ + i);
    std::fill(stretch(last()), stretch(last()) + 3, 0.);
    bound_[last()] = now;
  }
};

// One step of a contact with `count` levels: see Levels.
inline ShearStep shear_step(int count, double stiffness, double limit, const double *normal, const double *displacement,
                            double *numbers) {
  switch (count) {
  case 1:
    return Levels<1>(numbers, count).step(stiffness, limit, normal, displacement);
  case 2:
    return Levels<2>(numbers, count).step(stiffness, limit, normal, displacement);
  case 3:
    return Levels<3>(numbers, count).step(stiffness, limit, normal, displacement);
  }
  return Levels<0>::step_of(count, stiffness, limit, normal, displacement, numbers);
}

} // namespace demlaws
#endif
