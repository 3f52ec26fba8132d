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

// How the surfaces of a contact move in one step of an engine that has positions at the full step, velocities and spins
// at the half step (velocity Verlet, leapfrog): docs/shear.md, "The displacement of a step".
//
// The lever n of a velocity v - (r1 w1 + r2 w2) x n belongs to the half step, as w does: with n of now the velocity
// lacks (r1 w1 + r2 w2) x (n - n_previous)/2. Vectors that the contact keeps in its tangent plane turn with the normal,
// and about it by the mean spin of both bodies [our derivation].
struct Motion {
  double normal[3];       // now
  double velocity[3];     // of the surfaces, in the tangent plane, at the half step [m/s]
  double displacement[3]; // of the step, in the tangent plane of now [m]
  double row[3][3];       // of the matrix that turns a vector of the previous tangent plane into that of now

  // slip: velocity of the surfaces in the tangent plane with n of now. change: n - n_previous in that plane. lever:
  // (r1 w1 + r2 w2) n. spin: (w1 + w2) n. dt: 0 where nothing is to be kept.
  DEMLAWS_INLINE Motion(const double *n, const double *slip, const double *change, double lever, double spin,
                        double dt) {
    const double across[3] = {n[1] * change[2] - n[2] * change[1], n[2] * change[0] - n[0] * change[2],
                              n[0] * change[1] - n[1] * change[0]}; // n x change
    for (int k = 0; k < 3; k++) {
      normal[k] = n[k];
      velocity[k] = slip[k] + 0.5 * lever * across[k];
    }
    // First n_previous to n: s - (s n) g with g = (n + n_previous)/(1 + n n_previous), here n - change/2. Then by the
    // angle about n. Both keep lengths but for an eighth of the fourth power of an angle.
    const double angle = 0.5 * dt * spin, square = angle * angle, sine = angle - angle * square * (1. / 6.),
                 cosine = 1. - square * (0.5 - square * (1. / 24.));
    // The displacement belongs to the half step: it turns by half of that angle, else springs gain or lose energy.
    const double half = 0.5 * angle, side = dt * half * (1. - half * half * (1. / 6.)),
                 ahead = dt * (1. - 0.5 * half * half);
    displacement[0] = ahead * velocity[0] + side * (n[1] * velocity[2] - n[2] * velocity[1]);
    displacement[1] = ahead * velocity[1] + side * (n[2] * velocity[0] - n[0] * velocity[2]);
    displacement[2] = ahead * velocity[2] + side * (n[0] * velocity[1] - n[1] * velocity[0]);
    for (int k = 0; k < 3; k++) {
      const double turned = cosine * (n[k] - 0.5 * change[k]) - 0.5 * sine * across[k]; // g
      for (int d = 0; d < 3; d++) row[k][d] = -turned * n[d];
      row[k][k] += cosine;
    }
    row[0][1] -= sine * n[2], row[1][0] += sine * n[2];
    row[1][2] -= sine * n[0], row[2][1] += sine * n[0];
    row[2][0] -= sine * n[1], row[0][2] += sine * n[1];
  }
  // n - n_previous of two spheres at a distance r, from the velocity v of their centres, whose part along n is `along`;
  // inverse: 1/r.
  DEMLAWS_INLINE static void change_of_spheres(const double *n, const double *v, double along, double inverse,
                                               double dt, double *change) {
    for (int k = 0; k < 3; k++) change[k] = dt * inverse * (v[k] - along * n[k]);
  }
  // The same from a normal that was kept, which now becomes n; all zeros: there was none.
  DEMLAWS_INLINE static void change_of_kept(const double *n, double *kept, bool keep, double *change) {
    const bool known = kept[0] != 0. || kept[1] != 0. || kept[2] != 0.;
    const double along = kept[0] * n[0] + kept[1] * n[1] + kept[2] * n[2];
    for (int k = 0; k < 3; k++) {
      change[k] = known ? along * n[k] - kept[k] : 0.;
      if (keep) kept[k] = n[k];
    }
  }

  // share s, turned.
  DEMLAWS_INLINE void turn(double share, const double *s, double *turned) const {
    for (int k = 0; k < 3; k++) turned[k] = share * (row[k][0] * s[0] + row[k][1] * s[1] + row[k][2] * s[2]);
  }
};

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

  // One step: K_t, Coulomb's limit mu P [N] and the motion of the step, all of now. Energies that the caller does not
  // read are not computed.
  DEMLAWS_INLINE ShearStep step(double now, double limit, const Motion &motion) {
    const double *const d = motion.displacement;
    double moved[M ? M : MOST_LEVELS][3], force[3] = {0., 0., 0.}, turned[3];
    ShearStep step;
    step.before = energy();
    for (int i = 0; i < count(); i++) add(stiffness(i), stretch(i), force);
    motion.turn(1., force, turned);
    step.work = 0.5 * dot(turned, d);

    const double kept = press(now);
    std::fill(force, force + 3, 0.);
    for (int i = 0; i < count(); i++) {
      const double share = i == count() - 1 ? kept : 1.;
      motion.turn(share, stretch(i), moved[i]);
      add(1., d, moved[i]);
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
  __attribute__((noinline)) static ShearStep step_of(int count, double now, double limit, const Motion &motion,
                                                     double *numbers) {
    return Levels(numbers, count).step(now, limit, motion);
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
DEMLAWS_INLINE ShearStep shear_step(int count, double stiffness, double limit, const Motion &motion, double *numbers) {
  switch (count) {
  case 1:
    return Levels<1>(numbers, count).step(stiffness, limit, motion);
  case 2:
    return Levels<2>(numbers, count).step(stiffness, limit, motion);
  case 3:
    return Levels<3>(numbers, count).step(stiffness, limit, motion);
  }
  const Motion copy = motion; // else the compiler reads the motion again after each number that is written
  return Levels<0>::step_of(count, stiffness, limit, copy, numbers);
}

} // namespace demlaws
#endif
