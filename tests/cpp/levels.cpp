// Shear of a contact with levels along a path: what tests compare with Python. Words: table, friction, K_t / K, levels;
// input: overlap and two tangential displacements since the start, one point per line.
#include "demlaws_shear.h"
#include "demlaws_table.h"

int main(int, char **words) {
  const demlaws::Table table(words[1]);
  const double R = table.of_contact("radius", 0.), friction = atof(words[2]), ratio = atof(words[3]);
  const int count = atoi(words[4]);
  const demlaws::Pair pair = demlaws::Pair::checked(table, table.of_contact("modulus", 0.));
  double state[3] = {0., 0., 0.}, levels[4 * demlaws::MOST_LEVELS] = {}, before[2] = {0., 0.}, overlap, here[2];
  const double normal[3] = {0., 0., 1.};
  double work = 0.;
  while (scanf("%lf %lf %lf", &overlap, here, here + 1) == 3) {
    const demlaws::Force now = demlaws::step(pair, R, overlap, state);
    const double k = ratio * demlaws::shear_stiffness(demlaws::ELASTIC_SHEAR, pair, R, overlap, now, state);
    const double moved[3] = {here[0] - before[0], here[1] - before[1], 0.};
    const demlaws::ShearStep step = demlaws::shear_step(count, k, friction * now.force, normal, moved, levels);
    std::copy(here, here + 2, before);
    work += step.work;
    printf("%.17g %.17g %.17g %.17g %.17g\n", now.force, step.force[0], step.force[1], work, step.energy);
  }
}
