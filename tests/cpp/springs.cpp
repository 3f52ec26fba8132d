// Partial slip of a contact along a path; what tests compare with Python. Words: table, springs, K_t / K, friction.
// Lines: overlap and displacement of a step along two directions [m].
#include "demlaws_slip.h"
#include "demlaws_plugin.h"

int main(int, char **words) {
  const demlaws::Table table(words[1]);
  const double R = table.number("radius", 0.), modulus = table.number("modulus", 0.), ratio = atof(words[3]);
  const int springs = atoi(words[2]);
  demlaws::Law law;
  law.set(table, modulus, table.number("sigma", 0.), demlaws::SLIP_SHEAR);
  std::vector<double> numbers(demlaws::SpringRow::size(springs));
  double state[3] = {0., 0., 0.}, overlap, slip[3] = {0., 0., 0.};
  const double normal[3] = {0., 0., 1.}, none[3] = {0., 0., 0.};
  while (scanf("%lf %lf %lf", &overlap, slip, slip + 1) == 3) {
    const demlaws::Force now = demlaws::step(law.pair, R, overlap, state);
    const double K = demlaws::shear_stiffness(demlaws::SLIP_SHEAR, law.pair, R, overlap, now, state);
    double first[3] = {1., 0., 0.};
    const demlaws::Motion motion(normal, slip, none, none, none, 1., first);
    const demlaws::ShearStep step =
        demlaws::SpringRow(&numbers[0], springs)
            .step(K, law.unloading_curve(now.force, overlap, state), ratio, atof(words[4]) * now.force, motion);
    printf("%.17g %.17g %.17g %.17g\n", step.force[0], step.force[1], step.energy, step.lost());
  }
}
