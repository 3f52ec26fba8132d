// Friction that falls with the mean pressure, of a contact along a path; what tests compare with Python. Words: table,
// shear, K_t / K, mu0, C1, C2. Lines: overlap and displacement of a step along two directions [m].
#include "demlaws_plugin.h"

int main(int, char **words) {
  const demlaws::Table table(words[1]);
  const double R = table.number("radius", 0.), modulus = table.number("modulus", 0.), ratio = atof(words[3]);
  demlaws::Shear shear;
  if (!demlaws::shear_from_name(words[2], shear)) return 2;
  demlaws::PressureFriction friction;
  friction.c1 = atof(words[5]);
  friction.c2 = atof(words[6]);
  demlaws::Law law;
  law.set(table, modulus, 0., shear);
  std::vector<double> numbers(demlaws::SpringRow::MOST_SIZE);
  double stored = 0., state[3] = {0., 0., 0.}, overlap, slip[3] = {0., 0., 0.};
  const double normal[3] = {0., 0., 1.}, none[3] = {0., 0., 0.};
  while (scanf("%lf %lf %lf", &overlap, slip, slip + 1) == 3) {
    const double read_only = demlaws::mean_pressure(law.pair, demlaws::step(law.pair, R, overlap, state, false));
    const demlaws::Force now = demlaws::step(law.pair, R, overlap, state);
    const double K = demlaws::shear_stiffness(shear, law.pair, R, overlap, now, state);
    const double pressure = demlaws::mean_pressure(law.pair, now),
                 limit = (atof(words[4]) + friction.above_constant(pressure)) * now.force;
    if (overlap <= 0.) { // the contact has ended, and what its springs stored is lost
      printf("0 0 0 0 0 0 %.17g\n", stored);
      stored = 0.;
      std::fill(numbers.begin(), numbers.end(), 0.);
      continue;
    }
    double first[3] = {1., 0., 0.};
    const demlaws::Motion motion(normal, slip, none, none, none, 1., first);
    const demlaws::ShearStep step =
        law.slips ? demlaws::SpringRow(&numbers[0], demlaws::SPRINGS)
                        .step(K, law.unloading_curve(now.force, overlap, state), ratio, limit, motion)
                  : demlaws::shear_step(demlaws::LEVELS, ratio * K, limit, motion, &numbers[0]);
    stored = step.energy;
    printf("%.17g %.17g %.17g %.17g %.17g %.17g %.17g\n", pressure, read_only, limit, step.force[0], step.force[1],
           step.energy, step.lost());
  }
}
