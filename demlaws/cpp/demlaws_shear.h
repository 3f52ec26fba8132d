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
// The displacement belongs to the half step as velocities and spins do, and so do the normal and the levers with which
// it is computed. With the normal h = n - (n - n_previous)/2 of the half step the surfaces part at v - (r1 w1 + r2 w2)
// x h, of which the part in the plane of h counts. The state of a contact in its tangent plane turns with the normal,
// and about it by the mean spin of both bodies [our derivation]. So it keeps components along two unit vectors that
// turn: the first one is among its numbers, the second one is n x first.
struct Motion {
  double first[3], second[3]; // of now
  double velocity[2];         // of the surfaces at the half step, along both [m/s]
  double displacement[2];     // of the step, along both [m]

  // n: of now. v: velocity of the first body's centre against the second one. change: n - n_previous in the plane of n.
  // arms: r1 w1 + r2 w2 with the levers of the half step. spin: w1 + w2. dt: 0 where nothing is to be kept. kept: the
  // first vector, which is turned; zeros: of a new contact.
  DEMLAWS_INLINE Motion(const double *n, const double *v, const double *change, const double *arms, const double *spin,
                        double dt, double *kept) {
    double a[3], h[3];
    for (int k = 0; k < 3; k++) h[k] = n[k] - 0.5 * change[k];
    // First n_previous to n: a - (a n) g with g = (n + n_previous)/(1 + n n_previous), here h.
    const double normal = dot(kept, n);
    for (int k = 0; k < 3; k++) a[k] = kept[k] - normal * h[k];
    const double square = dot(a, a);
    if (__builtin_expect(!(std::fabs(square - 1.) < 1e-5), 0)) make_unit(n, square, a);
    else
      for (int k = 0; k < 3; k++) a[k] *= 1.5 - 0.5 * square;
    // Then by the angle about n, twice `half`.
    const double half = 0.25 * dt * dot(spin, h), sine = half - half * half * half * (1. / 6.),
                 cosine = 1. - 0.5 * half * half, sine2 = 2. * sine * cosine, cosine2 = 1. - 2. * sine * sine;
    const double b[3] = {n[1] * a[2] - n[2] * a[1], n[2] * a[0] - n[0] * a[2], n[0] * a[1] - n[1] * a[0]};
    for (int k = 0; k < 3; k++) {
      kept[k] = first[k] = cosine2 * a[k] + sine2 * b[k];
      second[k] = cosine2 * b[k] - sine2 * a[k];
    }
    // v - arms x h with the unit vector of h, turned from the plane of h to that of n.
    const double half_along = 0.5 * parting(n, v, change), unit = 1. - 0.125 * dot(change, change),
                 apart[3] = {v[0] + half_along * change[0] - unit * (arms[1] * h[2] - arms[2] * h[1]),
                             v[1] + half_along * change[1] - unit * (arms[2] * h[0] - arms[0] * h[2]),
                             v[2] + half_along * change[2] - unit * (arms[0] * h[1] - arms[1] * h[0])};
    velocity[0] = dot(apart, first);
    velocity[1] = dot(apart, second);
    // The displacement belongs to the half step: it turns by half of that angle, else springs gain or lose energy.
    displacement[0] = dt * (cosine * velocity[0] - sine * velocity[1]);
    displacement[1] = dt * (cosine * velocity[1] + sine * velocity[0]);
  }
  // The part of v along the normal of the half step: with that of now an orbit would seem to widen.
  DEMLAWS_INLINE static double parting(const double *n, const double *v, const double *change) {
    return dot(v, n) - 0.5 * dot(v, change);
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
    const double along = dot(kept, n);
    for (int k = 0; k < 3; k++) {
      change[k] = known ? along * n[k] - kept[k] : 0.;
      if (keep) kept[k] = n[k];
    }
  }
  // The vector with these components along `first` and `second`.
  DEMLAWS_INLINE void in_space(const double *components, double *vector) const {
    for (int k = 0; k < 3; k++) vector[k] = components[0] * first[k] + components[1] * second[k];
  }

private:
  DEMLAWS_INLINE static double dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
  // a, of which the square is known, to a unit vector; of a new contact any across n.
  __attribute__((noinline, cold)) static void make_unit(const double *n, double square, double *a) {
    if (!(square > 1e-6)) {
      int least = std::fabs(n[0]) < std::fabs(n[1]) ? 0 : 1;
      if (std::fabs(n[2]) < std::fabs(n[least])) least = 2;
      for (int k = 0; k < 3; k++) a[k] = (k == least) - n[least] * n[k];
      square = dot(a, a);
    }
    const double length = std::sqrt(square);
    for (int k = 0; k < 3; k++) a[k] /= length;
  }
};

// Numbers of a contact: scalars, the components of vectors along `Motion`'s two unit vectors, the first unit vector.
inline int numbers_of_shear(int scalars, int vectors) { return scalars + 2 * vectors + 3; }
// Where the unit vector is among all `count` numbers.
inline double *unit_vector(double *numbers, int count) { return numbers + count - 3; }
// Whether a number has the other sign seen from the other body: components along the first unit vector. The second one,
// n x first, changes its sign with n.
inline bool changes_sign(int number, int scalars, int vectors) {
  return number >= scalars && number < scalars + 2 * vectors && (number - scalars) % 2 == 0;
}

// One step of the shear of a contact.
struct ShearStep {
  double force[2];             // against the displacement, along the motion's unit vectors [N]
  double work, before, energy; // done on the contact; stored before the step and after it [J]
  double stuck;                // share of the stiffness that has not slipped, from 0 to 1

  // Taken by friction and by the parts of the contact that opened [J].
  double lost() const { return work - (energy - before); }
  // Force of a dashpot on the surfaces, which move with a velocity: of the part that sticks, and not so much that with
  // the springs it exceeds Coulomb's limit [our derivation].
  DEMLAWS_INLINE void damp(double coefficient, double limit, const double *velocity, double *viscous) const {
    double along = 0., square = 0., beyond = -limit * limit;
    for (int k = 0; k < 2; k++) {
      viscous[k] = -coefficient * stuck * velocity[k];
      along -= force[k] * viscous[k];
      square += viscous[k] * viscous[k];
      beyond += force[k] * force[k];
    }
    if (!(square > 0.) || square + 2. * along + beyond <= 0.) return; // the first is the one of a contact that slides
    const double share = (std::sqrt(along * along - square * std::min(beyond, 0.)) - along) / square;
    for (int k = 0; k < 2; k++) viscous[k] *= share;
  }
};

// Friction that falls with the mean pressure p of the contact: mu0 + c1 / (1 + c2 p) (Suhr & Six 2016); see
// demlaws/shear.py. mu0 is the engine's own coefficient; c1 0: constant friction.
struct PressureFriction {
  double c1 = 0., c2 = 0.; // -, 1/Pa
  bool valid() const { return c1 >= 0. && c2 >= 0.; }
  DEMLAWS_INLINE double above_constant(double pressure) const { return c1 / (1. + c2 * pressure); }
};

inline bool may_have_levels(double count) { return count == (int)count && count >= 1. && count <= MOST_LEVELS; }
inline int levels_size(int count) { return numbers_of_shear(count, count); }

// What a contact keeps: for each level the upper bound of K_t [N/m], rising, the last one K_t itself; then the stretch
// of each level [m]; the first unit vector (Motion). All zeros: no shear force. A level between equal bounds is empty.
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

  // One step: K_t, Coulomb's limit mu P [N] and the motion of the step, all of now. The work is the mean of the forces
  // before and after the step times the displacement d. So that no step loses less than nothing, springs of the
  // stiffness k that open carry 1/4 k d^2 more, at most the work of Coulomb's limit or of the force before over
  // d/2, and where a step turns the force round the one before is at most the limit, which may have fallen. Energies
  // that the caller does not read are not computed.
  DEMLAWS_INLINE ShearStep step(double now, double limit, const Motion &motion) {
    const double *const d = motion.displacement;
    double moved[M ? M : MOST_LEVELS][2], start[2] = {0., 0.}, held[2] = {0., 0.}, force[2] = {0., 0.};
    ShearStep step;
    step.before = energy();
    for (int i = 0; i < count(); i++) add(stiffness(i), stretch(i), start);
    const double opened = std::max(bound_[count() - 1] - now, 0.);
    const double kept = press(now);
    for (int i = 0; i < count(); i++) {
      const double share = i == count() - 1 ? kept : 1., left[2] = {share * stretch(i)[0], share * stretch(i)[1]};
      add(stiffness(i), left, held);
      for (int k = 0; k < 2; k++) moved[i][k] = left[k] + d[k];
      add(stiffness(i), moved[i], force);
    }
    const double square = dot(force, force);
    const double scale = shortened(square, limit);
    step.stuck = square > limit * limit ? 0. : 1.;
    for (int i = 0; i < count(); i++)
      for (int k = 0; k < 2; k++) stretch(i)[k] = scale * moved[i][k];
    for (int k = 0; k < 2; k++) step.force[k] = scale * force[k];
    step.work = 0.5 * (dot(start, d) + dot(step.force, d));
    if (opened > 0.) {
      const double moves = dot(d, d), largest = std::max(limit * limit, dot(start, start));
      step.work += opened * opened * moves <= 4. * largest ? 0.25 * opened * moves : 0.5 * std::sqrt(largest * moves);
    }
    if (dot(held, force) < 0.) step.work -= 0.5 * (1. - shortened(dot(held, held), limit)) * dot(held, d);
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
  DEMLAWS_INLINE double *stretch(int i) const { return stretch_ + 2 * i; }
  DEMLAWS_INLINE double stiffness(int i) const { return i ? bound_[i] - bound_[i - 1] : bound_[0]; }
  DEMLAWS_INLINE static double dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1]; }
  DEMLAWS_INLINE static void add(double factor, const double *a, double *sum) {
    for (int k = 0; k < 2; k++) sum[k] += factor * a[k];
  }
  // The share that is left of a force whose square is known where it is at most `limit`.
  DEMLAWS_INLINE static double shortened(double square, double limit) {
    return square > limit * limit ? limit / std::sqrt(square) : 1.;
  }
  // (k1 + k2) |s1 - s2|^2 of levels i and i + 1, neither of which is empty.
  DEMLAWS_INLINE double apart(int i) const {
    double difference[2];
    for (int k = 0; k < 2; k++) difference[k] = stretch(i)[k] - stretch(i + 1)[k];
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
    for (int k = 0; k < 2; k++) stretch(i)[k] = share * stretch(i)[k] + (1. - share) * stretch(i + 1)[k];
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
