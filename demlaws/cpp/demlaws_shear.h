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

// What a contact keeps: K_t, and the stretch Q / K_t as a vector. All zeros: no shear force.
struct Stretch {
  double stiffness, vector[3];
};
static const int STRETCH_SIZE = 4;

inline double stretch_energy(const Stretch &s) {
  return 0.5 * s.stiffness * (s.vector[0] * s.vector[0] + s.vector[1] * s.vector[1] + s.vector[2] * s.vector[2]);
}

// One step: K_t, Coulomb's limit mu P [N], unit normal and tangential displacement of the step, all of now. The shear
// force against the displacement is s.stiffness * s.vector. `slides` tells whether the limit acts. Returns the energy
// that friction and the opening parts of the contact took.
inline double shear_step(double stiffness, double limit, const double *normal, const double *displacement, Stretch &s,
                         bool &slides) {
  const double before = stretch_energy(s), kept = stiffness > s.stiffness ? s.stiffness / stiffness : 1.;
  double work = 0., along = 0., square = 0.;
  for (int k = 0; k < 3; k++) work += 0.5 * s.stiffness * s.vector[k] * displacement[k];
  for (int k = 0; k < 3; k++) {
    s.vector[k] = kept * s.vector[k] + displacement[k];
    along += s.vector[k] * normal[k];
  }
  for (int k = 0; k < 3; k++) {
    s.vector[k] -= along * normal[k]; // the tangent plane has turned
    square += s.vector[k] * s.vector[k];
  }
  s.stiffness = stiffness;
  slides = stiffness * stiffness * square > limit * limit;
  const double scale = slides ? limit / (stiffness * std::sqrt(square)) : 1.;
  for (int k = 0; k < 3; k++) {
    s.vector[k] *= scale;
    work += 0.5 * stiffness * s.vector[k] * displacement[k];
  }
  return work - (stretch_energy(s) - before);
}

} // namespace demlaws
#endif
