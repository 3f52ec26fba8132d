// demlaws_shear.h: shear force of a contact that sticks until it slides, without creating energy. C++11, no dependency.
//
// dQ = K_t ds. Where K_t falls, the part of the contact that opens takes its share of the force and its energy along;
// where K_t rises, the new part is not stretched and the force is kept. Then Coulomb's limit. A force kept while K_t
// falls, or a displacement kept while K_t rises, creates energy (docs/shear.md). Twin of one_spring_loop in
// demlaws/core/slip.py.
//
// Licence: GPL-2.0-or-later, as the package demlaws.
#ifndef DEMLAWS_SHEAR_H
#define DEMLAWS_SHEAR_H
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

// What a contact keeps: K_t, and the stretch Q / K_t as a vector. All zeros: no shear force.
struct Stretch {
  double stiffness, vector[3];
};
static const int STRETCH_SIZE = 4;

inline double stretch_energy(const Stretch &s) {
  return 0.5 * s.stiffness * (s.vector[0] * s.vector[0] + s.vector[1] * s.vector[1] + s.vector[2] * s.vector[2]);
}

// One step: K_t, Coulomb's limit mu P [N], unit normal and tangential displacement of the step, all of now.
inline ShearStep shear_step(double stiffness, double limit, const double *normal, const double *displacement,
                            Stretch &s) {
  ShearStep step;
  step.before = stretch_energy(s);
  const double kept = stiffness > s.stiffness ? s.stiffness / stiffness : 1.;
  double along = 0., square = 0.;
  step.work = 0.;
  for (int k = 0; k < 3; k++) step.work += 0.5 * s.stiffness * s.vector[k] * displacement[k];
  for (int k = 0; k < 3; k++) {
    s.vector[k] = kept * s.vector[k] + displacement[k];
    along += s.vector[k] * normal[k];
  }
  for (int k = 0; k < 3; k++) {
    s.vector[k] -= along * normal[k]; // the tangent plane has turned
    square += s.vector[k] * s.vector[k];
  }
  s.stiffness = stiffness;
  step.slides = stiffness * stiffness * square > limit * limit;
  const double scale = step.slides ? limit / (stiffness * std::sqrt(square)) : 1.;
  for (int k = 0; k < 3; k++) {
    s.vector[k] *= scale;
    step.force[k] = stiffness * s.vector[k];
    step.work += 0.5 * step.force[k] * displacement[k];
  }
  step.energy = stretch_energy(s);
  return step;
}

} // namespace demlaws
#endif
