// demlaws_shear.h: shear force of a contact that sticks until it slides, without creating energy. C++11, needs
// demlaws_facts.h.
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
#include "demlaws_facts.h"
#include <algorithm>
#include <cmath>

#define DEMLAWS_INLINE __attribute__((always_inline)) inline

namespace demlaws {

// One step of the shear of a contact.
struct ShearStep {
  double force[3];             // against the displacement [N]
  double work, before, energy; // done on the contact; stored before the step and after it [J]
  bool slides;                 // Coulomb's limit acts on the whole contact

  // Taken by friction and by the parts of the contact that opened [J].
  double lost() const { return work - (energy - before); }
};

inline bool may_have_levels(double count) { return count == (int)count && count >= 1. && count <= MOST_LEVELS; }
inline int levels_size(int count) { return 4 * count; }

// What a contact keeps: for each level the upper bound of K_t [N/m], rising, the last one K_t itself; then the stretch
// of each level [m], a vector in the tangent plane. All zeros: no shear force. A level between equal bounds is empty.
// The numbers are the caller's. M: number of levels, known when compiled; 0: only when run.
template <int M> class Levels {
public:
  DEMLAWS_INLINE Levels(double *numbers, int count)
      : bound_(numbers), stretch_(numbers + (M ? M : count)), count_(count) {}

  DEMLAWS_INLINE double energy() const {
    double sum = 0.;
    for (int i = 0; i < count(); i++) sum += stiffness(i) * dot(stretch(i), stretch(i));
    return 0.5 * sum;
  }

  // One step: K_t, Coulomb's limit mu P [N], unit normal and tangential displacement of the step, all of now. Energies
  // that the caller does not read are not computed.
  DEMLAWS_INLINE ShearStep step(double now, double limit, const double *normal, const double *displacement) {
    // copies, since the compiler cannot know that they do not change with the stretches
    const double n[3] = {normal[0], normal[1], normal[2]}, d[3] = {displacement[0], displacement[1], displacement[2]};
    double moved[M ? M : MOST_LEVELS][3], force[3] = {0., 0., 0.};
    ShearStep step;
    step.before = energy();
    for (int i = 0; i < count(); i++) add(stiffness(i), stretch(i), force);
    step.work = 0.5 * dot(force, d);

    const double kept = press(now);
    std::fill(force, force + 3, 0.);
    for (int i = 0; i < count(); i++) {
      const double share = i == count() - 1 ? kept : 1.;
      for (int k = 0; k < 3; k++) moved[i][k] = share * stretch(i)[k] + d[k];
      add(-dot(moved[i], n), n, moved[i]); // the tangent plane has turned
      add(stiffness(i), moved[i], force);
    }
    const double square = dot(force, force);
    step.slides = square > limit * limit;
    const double scale = step.slides ? limit / std::sqrt(square) : 1.;
    for (int i = 0; i < count(); i++)
      for (int k = 0; k < 3; k++) stretch(i)[k] = scale * moved[i][k];
    for (int k = 0; k < 3; k++) step.force[k] = scale * force[k];
    step.work += 0.5 * dot(step.force, d);
    step.energy = energy();
    return step;
  }
  __attribute__((noinline)) static ShearStep step_of(int count, double now, double limit, const double *normal,
                                                     const double *displacement, double *numbers) {
    return Levels(numbers, count).step(now, limit, normal, displacement);
  }

private:
  // The numbers are read and written in place: with copies of all of them the processor runs out of registers, which
  // cost a third of a step.
  double *const bound_, *const stretch_;
  const int count_;

  DEMLAWS_INLINE int count() const { return M ? M : count_; }
  DEMLAWS_INLINE double *stretch(int i) const { return stretch_ + 3 * i; }
  DEMLAWS_INLINE double stiffness(int i) const { return i ? bound_[i] - bound_[i - 1] : bound_[0]; }
  DEMLAWS_INLINE static double dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
  DEMLAWS_INLINE static void add(double factor, const double *a, double *sum) {
    for (int k = 0; k < 3; k++) sum[k] += factor * a[k];
  }
  // (k1 + k2) |s1 - s2|^2 of levels i and i + 1, neither of which is empty.
  DEMLAWS_INLINE double apart(int i) const {
    double difference[3];
    for (int k = 0; k < 3; k++) difference[k] = stretch(i)[k] - stretch(i + 1)[k];
    return (stiffness(i) + stiffness(i + 1)) * dot(difference, difference);
  }

  // K_t is now `now`. Where it falls, springs open; where it rises, those that touch make one level too many: the two
  // neighbours with the smallest (k1 + k2) |s1 - s2|^2 become one, the lowest of equals; an empty level joins any
  // other. They are nearly always the last level and the new one, whose mean stretch is a share of the last one's: the
  // share is returned, for the caller to multiply by, since a stretch that was just written is slow to read.
  DEMLAWS_INLINE double press(double now) {
    const int last = count() - 1;
    const double rise = now - bound_[last];
    if (!(rise > 0.)) {
      for (int i = 0; i < last; i++) bound_[i] = std::min(bound_[i], now);
      bound_[last] = now;
      return 1.;
    }
    const double empty = EMPTY_LEVEL * now, held = stiffness(last), both = held + rise,
                 with_new = both * dot(stretch(last), stretch(last));
    double least = held, nearest = 0.;
    for (int i = 0; i < last; i++) {
      least = std::min(least, stiffness(i));
      nearest = i ? std::min(nearest, apart(i)) : apart(i);
    }
    if (__builtin_expect(last > 0 && rise > empty && (least <= empty || nearest <= with_new), 0)) {
      join(bound_, count_, now);
      return 1.;
    }
    bound_[last] = now;
    return held / both;
  }
  // The two nearest of the old levels become one; the new level is the top one.
  __attribute__((noinline)) static void join(double *numbers, int count, double now) {
    Levels(numbers, count).join(now);
  }
  DEMLAWS_INLINE void join(double now) {
    const double empty = EMPTY_LEVEL * now;
    int i = 0;
    double smallest = HUGE_VAL;
    for (int n = 0; n + 1 < count(); n++) {
      const bool free = std::min(stiffness(n), stiffness(n + 1)) <= empty;
      const double distance = free ? 0. : apart(n);
      if (distance < smallest) smallest = distance, i = n;
    }
    const double both = stiffness(i) + stiffness(i + 1), share = both > 0. ? stiffness(i) / both : 0.;
    for (int k = 0; k < 3; k++) stretch(i)[k] = share * stretch(i)[k] + (1. - share) * stretch(i + 1)[k];
    std::copy(bound_ + i + 1, bound_ + count(), bound_ + i);
    std::copy(stretch(i + 2), stretch(count()), stretch(i + 1));
    bound_[count() - 1] = now;
    std::fill(stretch(count() - 1), stretch(count()), 0.);
  }
};

// One step of a contact with `count` levels: see Levels.
DEMLAWS_INLINE ShearStep shear_step(int count, double stiffness, double limit, const double *normal,
                                    const double *displacement, double *numbers) {
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
