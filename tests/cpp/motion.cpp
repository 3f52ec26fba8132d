// Shear of a contact of two spheres that move: what tests compare with Python. Words: levels.
// Lines of one step: normal, velocity of the first centre against the second, r1 w1 + r2 w2, w1 + w2 (three numbers
// each), distance of the centres, step of time, K_t, Coulomb's limit.
// Prints the shear force against the displacement in space, the energy stored and that lost in the step.
#include "demlaws_shear.h"
#include <cstdio>
#include <cstdlib>
#include <vector>

int main(int, char **words) {
  const int levels = atoi(words[1]);
  std::vector<double> numbers(demlaws::levels_size(levels));
  double line[16], change[3], force[3];
  while (true) {
    for (double &number : line)
      if (scanf("%lf", &number) != 1) return 0;
    const double *const n = line, *const v = line + 3, *const arms = line + 6, *const spin = line + 9, dt = line[13];
    const double along = n[0] * v[0] + n[1] * v[1] + n[2] * v[2];
    demlaws::Motion::change_of_spheres(n, v, along, 1. / line[12], dt, change);
    const demlaws::Motion motion(n, v, change, arms, spin, dt,
                                 demlaws::unit_vector(&numbers[0], demlaws::levels_size(levels)));
    const demlaws::ShearStep step = demlaws::shear_step(levels, line[14], line[15], motion, &numbers[0]);
    motion.in_space(step.force, force);
    printf("%.17g %.17g %.17g %.17g %.17g\n", force[0], force[1], force[2], step.energy, step.lost());
  }
}
