// A contact along overlaps; what tests compare with Python. Words: table, overlaps [m].
#include "demlaws_table.h"

int main(int count, char **words) {
  try {
    const demlaws::Table table(words[1]);
    const double R = table.number("radius", 0.);
    const demlaws::Pair pair = demlaws::Pair::checked(table, table.number("modulus", 0.));
    double state[3] = {0., 0., 0.};
    for (int i = 2; i < count; i++) {
      const double overlap = atof(words[i]);
      const demlaws::Force now = demlaws::step(pair, R, overlap, state);
      double stored, lost;
      demlaws::stored_and_dissipated(pair, R, overlap, state, stored, lost);
      printf("%.17g %.17g %.17g %.17g %.17g\n", now.force, now.stiffness,
             demlaws::shear_stiffness(demlaws::ELASTIC_SHEAR, pair, R, overlap, now, state), stored, lost);
    }
  } catch (const std::exception &problem) {
    puts(problem.what());
    return 1;
  }
}
