// A DEM code's contact in 30 lines: reads overlaps [m] of one contact, one a line, prints force [N], tangent stiffness
// [N/m], maximum and plastic overlap [m], stored and dissipated energy [J]. No other file of demlaws is needed.
//     g++ -std=c++11 -O2 -I "$(python -c 'import demlaws.liggghts as lg; print(lg.header_folder())')" example.cpp -o
//     example
//     ./example granite.tbl 32.32e9 4.35e-3 2.4e-6 < overlaps.txt
#include "demlaws_table.h"

int main(int count, char **arguments) {
  if (count != 5) {
    fprintf(stderr, "usage: example TABLE EFFECTIVE_MODULUS EFFECTIVE_RADIUS ROUGHNESS < OVERLAPS\n");
    return 2;
  }
  try {
    const demlaws::Table table(arguments[1]);
    const double modulus = atof(arguments[2]), radius = atof(arguments[3]), roughness = atof(arguments[4]);
    const demlaws::Pair pair(table, modulus, roughness);
    demlaws::State state; // a virgin contact
    double overlap, stored, dissipated;
    while (scanf("%lf", &overlap) == 1) {
      const demlaws::Force now = demlaws::step(pair, radius, overlap, state);
      if (now.outside) throw std::runtime_error("overlap beyond the table");
      demlaws::stored_and_dissipated(pair, radius, overlap, &state.maximum_overlap, stored, dissipated);
      printf("%.17g %.17g %.17g %.17g %.17g %.17g\n", now.force, now.stiffness, state.maximum_overlap,
             state.plastic_overlap, stored, dissipated);
    }
  } catch (const std::exception &problem) {
    fprintf(stderr, "%s\n", problem.what());
    return 1;
  }
  return 0;
}
