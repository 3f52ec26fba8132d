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
static const double MANY = 1e200;             // times any difference of stiffness: above any energy
inline bool may_have_levels(double count) { return count == (int)count && count >= 1. && count <= MOST_LEVELS; }
inline int levels_size(int count) { return 4 * count; }

// What a contact keeps: for each level the upper bound of K_t [N/m], rising, the last one K_t itself; then the stretch
// of each level [m], a vector in the tangent plane. All zeros: no shear force. A level between equal bounds is empty.
// The numbers are the caller's. M: number of levels, known when compiled; 0: only when run.
template <int M> class Levels {
public:
  Levels(double *numbers, int count) : numbers_(numbers), count_(M ? M : count) { read(); }

  double energy() const {
    double sum = 0.;
    for (int i = 0; i < count(); i++) sum += stiffness(i) * dot(stretch_[i], stretch_[i]);
    return 0.5 * sum;
  }

  // One step: K_t, Coulomb's limit mu P [N], unit normal and tangential displacement of the step, all of now.
  __attribute__((always_inline)) inline ShearStep step(double now, double limit, const double *normal,
                                                       const double *displacement) {
    ShearStep step;
    step.before = energy();
    sum_forces(step.force);
    step.work = 0.5 * dot(step.force, displacement);
    press(now);
    for (int i = 0; i < count(); i++) {
      double *const s = stretch_[i];
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
      for (int i = 0; i < count(); i++)
        for (int k = 0; k < 3; k++) stretch_[i][k] *= scale;
    }
    step.work += 0.5 * dot(step.force, displacement);
    step.energy = energy();
    write();
    return step;
  }
  __attribute__((noinline)) static ShearStep step_of(int count, double now, double limit, const double *normal,
                                                     const double *displacement, double *numbers) {
    return Levels(numbers, count).step(now, limit, normal, displacement);
  }

private:
  template <int> friend class Levels;
  double *const numbers_;
  const int count_;
  // copies, since the compiler cannot know that no other number changes with those of the caller
  double bound_[M ? M : MOST_LEVELS], stretch_[M ? M : MOST_LEVELS][3];

  int count() const { return M ? M : count_; }
  double stiffness(int i) const { return i ? bound_[i] - bound_[i - 1] : bound_[0]; }
  static double dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
  void read() {
    for (int i = 0; i < count(); i++) {
      bound_[i] = numbers_[i];
      for (int k = 0; k < 3; k++) stretch_[i][k] = numbers_[count() + 3 * i + k];
    }
  }
  void write() const {
    for (int i = 0; i < count(); i++) {
      numbers_[i] = bound_[i];
      for (int k = 0; k < 3; k++) numbers_[count() + 3 * i + k] = stretch_[i][k];
    }
  }
  void sum_forces(double *force) const {
    force[0] = force[1] = force[2] = 0.;
    for (int i = 0; i < count(); i++)
      for (int k = 0; k < 3; k++) force[k] += stiffness(i) * stretch_[i][k];
  }

  // (k1 + k2) |s1 - s2|^2 of levels i and i + 1, or 0 if one of them is empty; without a branch, since the processor
  // could not predict it.
  double apart(int i, double empty) const {
    double difference[3];
    for (int k = 0; k < 3; k++) difference[k] = stretch_[i][k] - stretch_[i + 1][k];
    return measure(stiffness(i), stiffness(i + 1), dot(difference, difference), empty);
  }
  static double measure(double low, double high, double square, double empty) {
    return std::max(std::min((low + high) * square, MANY * (std::min(low, high) - empty)), 0.);
  }
  // K_t is now `now`. Where it falls, springs open; where it rises, those that touch make one level too many: the two
  // neighbours with the smallest (k1 + k2) |s1 - s2|^2 become one, the lowest of equals; an empty level joins any
  // other. They are nearly always the last level and the new one.
  inline void press(double now) {
    const int last = count() - 1;
    const double empty = EMPTY_LEVEL * now, rise = now - bound_[last];
    for (int i = 0; i <= last; i++) bound_[i] = std::min(bound_[i], now);
    double *const top = stretch_[last];
    const double held = stiffness(last), all = held + std::max(rise, 0.);
    // negative where K_t does not rise: the new level, which is empty, joins the last one
    const double with_new = std::min(measure(held, rise, dot(top, top), empty), MANY * (rise - empty) - 1.);
    double others = MANY;
    for (int i = 0; i < last; i++) others = std::min(others, apart(i, empty));
    if (__builtin_expect(others <= with_new, 0)) {
      Levels<0>::join(numbers_, count(), now);
      return read();
    }
    const double share = all > 0. ? held / all : 0.; // 1 where K_t falls
    for (int k = 0; k < 3; k++) top[k] *= share;
    bound_[last] = now;
  }
  // The two nearest of the old levels become one; the new level stands on top.
  __attribute__((noinline, cold)) static void join(double *numbers, int count, double now) {
    Levels levels(numbers, count);
    levels.join(now);
    levels.write();
  }
  void join(double now) {
    int i = 0;
    for (int n = 1; n + 1 < count(); n++)
      if (apart(n, EMPTY_LEVEL * now) < apart(i, EMPTY_LEVEL * now)) i = n;
    const double both = stiffness(i) + stiffness(i + 1), share = both > 0. ? stiffness(i) / both : 0.;
    for (int k = 0; k < 3; k++) stretch_[i][k] = share * stretch_[i][k] + (1. - share) * stretch_[i + 1][k];
    for (; i + 1 < count(); i++) {
      bound_[i] = bound_[i + 1];
      for (int k = 0; k < 3 && i + 2 < count(); k++) stretch_[i + 1][k] = stretch_[i + 2][k];
    }
    std::fill(stretch_[i], stretch_[i] + 3, 0.);
    bound_[i] = now;
  }
};

// One step of a contact with `count` levels: see Levels.
__attribute__((always_inline)) inline ShearStep shear_step(int count, double stiffness, double limit,
                                                           const double *normal, const double *displacement,
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
