// The contact of a DEM code with a table of demlaws; no other file of demlaws is needed. Reads the path of one contact,
// per line overlap and two tangential displacements since the start [m], and prints force [N], tangent stiffness [N/m],
// maximum and plastic overlap [m], stored and dissipated energy [J], the two tangential forces [N].
//     g++ -std=c++11 -O2 -I "$(python -c 'import demlaws.liggghts as lg; print(lg.header_folder())')" example.cpp
//     ./a.out granite.tbl 32.32e9 4.35e-3 2.4e-6 0.857 0.5 < path.txt
#include "demlaws_shear.h"
#include "demlaws_table.h"

// --- the contact
// What the grains of two materials share.
struct Materials {
  demlaws::Pair pair; // table, effective modulus E* [Pa], roughness [m]
  double shear_ratio; // K_t/K = 4 G*/E*, at most 4/3
  double friction;    // Coulomb's
  double damping;     // 0: none; for a restitution e about sqrt(5/6) * -2 ln e / sqrt(ln e * ln e + pi * pi)
  int levels;         // of shear, 1 to 8
};

// What a contact keeps from step to step; zeros: bodies that do not touch.
struct Contact {
  demlaws::State state;                             // of the law: maximum and plastic overlap [m], R_p/R
  double normal[3] = {};                            // of the step before
  double levels[3 * demlaws::MOST_LEVELS + 3] = {}; // of the shear force
  double stored = 0., flow = 0., dissipated = 0.; // energies [J]: returned at unloading; of plastic flow; other losses
};

// One step of a contact. radius: R1 R2/(R1 + R2) [m], of a wall that of the sphere; mass: m1 m2/(m1 + m2) [kg]; normal:
// unit vector from body 2 to body 1; velocity: of the centre of body 1 relative to body 2 [m/s]; arms: r1 w1 + r2 w2
// [m/s] and spin: w1 + w2 [1/s] of spins w and distances r of centres to the contact, velocities, spins and distances
// being those of the half step; step: [s]. Writes the force on body 1 [N]; returns the law's force and tangent
// stiffness, from which a stable time step is computed.
demlaws::Force step_contact(const Materials &materials, double radius, double mass, double overlap,
                            const double *normal, const double *velocity, const double *arms, const double *spin,
                            double step, Contact &contact, double *force) {
  const demlaws::Pair &pair = materials.pair;
  const demlaws::Force now = demlaws::step(pair, radius, overlap, contact.state);
  if (now.outside || now.force != now.force) throw std::runtime_error("overlap beyond the table, or not a number");
  std::fill(force, force + 3, 0.);
  if (overlap <= 0.) { // the contact has ended: plastic work, and what its shear still stored, are dissipated
    const double lost =
        contact.dissipated + contact.flow + demlaws::Levels<0>(contact.levels, materials.levels).energy();
    contact = Contact();
    contact.dissipated = lost;
    return now;
  }
  const double opening = normal[0] * velocity[0] + normal[1] * velocity[1] + normal[2] * velocity[2];
  const double pull = materials.damping * sqrt(now.stiffness * mass) * opening, press = now.force - pull;
  double change[3];
  demlaws::Motion::change_of_kept(normal, contact.normal, true, change);
  const demlaws::Motion motion(normal, velocity, change, arms, spin, step,
                               demlaws::unit_vector(contact.levels, demlaws::levels_size(materials.levels)));
  const double stiffness =
      materials.shear_ratio *
      demlaws::shear_stiffness(demlaws::ELASTIC_SHEAR, pair, radius, overlap, now, &contact.state.maximum_overlap);
  const demlaws::ShearStep shear =
      demlaws::shear_step(materials.levels, stiffness, materials.friction * fabs(press), motion, contact.levels);
  double tangential[3];
  motion.in_space(shear.force, tangential);
  for (int k = 0; k < 3; k++) force[k] = press * normal[k] - tangential[k];
  demlaws::stored_and_dissipated(pair, radius, overlap, &contact.state.maximum_overlap, contact.stored, contact.flow);
  contact.stored += shear.energy; // both only where energies are wanted: the force does not need them
  contact.dissipated += shear.lost() + pull * opening * step;
  return now;
}
// --- end of the contact

int main(int count, char **words) {
  if (count < 7 || count > 9) {
    fprintf(stderr, "usage: example TABLE MODULUS RADIUS ROUGHNESS SHEAR_RATIO FRICTION [LEVELS [DAMPING]] < PATH\n");
    return 2;
  }
  try {
    const demlaws::Table table(words[1]);
    const double radius = atof(words[3]), normal[3] = {0., 0., 1.}, none[3] = {}, step = 1e-7, mass = 1e-3;
    const Materials materials = {demlaws::Pair::checked(table, atof(words[2]), atof(words[4])), atof(words[5]),
                                 atof(words[6]), count > 8 ? atof(words[8]) : 0.,
                                 count > 7 ? atoi(words[7]) : demlaws::LEVELS};
    if (materials.pair.sigma > demlaws::LARGEST_ROUGHNESS * radius)
      throw std::runtime_error(std::string("roughness ") + words[4] + " m is of the size of the radius " + words[3] +
                               " m: give both in m");
    if (!materials.pair.serves(radius, 0.01)) throw std::runtime_error("the table is for another effective radius");
    if (!demlaws::may_have_levels(materials.levels)) throw std::runtime_error("levels must be 1 to 8");
    Contact contact; // two bodies that do not touch
    double here[3], before[3] = {0., 0., 0.}, force[3];
    while (scanf("%lf %lf %lf", here, here + 1, here + 2) == 3) {
      const double velocity[3] = {(here[1] - before[1]) / step, (here[2] - before[2]) / step,
                                  (before[0] - here[0]) / step};
      const demlaws::Force now =
          step_contact(materials, radius, mass, here[0], normal, velocity, none, none, step, contact, force);
      std::copy(here, here + 3, before);
      printf("%.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g\n", force[2], now.stiffness,
             contact.state.maximum_overlap, contact.state.plastic_overlap, contact.stored,
             contact.flow + contact.dissipated, force[0], force[1]);
    }
  } catch (const std::exception &problem) {
    fprintf(stderr, "%s\n", problem.what());
    return 1;
  }
  return 0;
}
