// Reads tables and steps contacts as its input says, one answer a line; what tests compare with Python.
//     rules                              names and state of the unloading rules
//     table FILE MODULUS RADIUS ROUGHNESS -> "good FINGERPRINT" or "refused MESSAGE"; a virgin contact
//     contact MODULUS RADIUS ROUGHNESS   -> "served 0" or "served 1" by the table, or "refused MESSAGE"
//     virgin                             another virgin contact, no answer
//     overlap X                       -> force, stiffness, three values of state, stored, dissipated, outside (0 or 1)
//     shears                             names of the stiffnesses for K_t
//     shear X                         -> the stiffnesses for K_t at X: without a step, then after a step to
//     X
//     recoverable FORCE X PLASTIC RATIO -> the stiffnesses for K_t of rules hertz and thornton, elastic shear, in that
//     state
#include "demlaws_table.h"
#include <iostream>
#include <memory>

int main() {
  std::unique_ptr<demlaws::Table> table;
  demlaws::Pair pair;
  double radius = 0.;
  demlaws::State state;
  std::string word;
  while (std::cin >> word) {
    if (word == "rules") {
      for (int i = demlaws::ELASTIC; i < demlaws::RULES; i++) {
        printf("%s", demlaws::RULE_NAMES[i]);
        for (int k = 0; k < demlaws::state_size((demlaws::Unloading)i); k++) printf(" %s", demlaws::STATE_NAMES[k]);
        printf("\n");
      }
    } else if (word == "table") {
      std::string file;
      double modulus, roughness;
      std::cin >> file >> modulus >> radius >> roughness;
      state = demlaws::State();
      try {
        table.reset(new demlaws::Table(file));
        pair = demlaws::Pair(*table, modulus, roughness);
        printf("good %u\n", (unsigned)table->fingerprint());
      } catch (const std::exception &problem) {
        printf("refused %s\n", problem.what());
      }
    } else if (word == "contact") {
      double modulus, other, roughness;
      std::cin >> modulus >> other >> roughness;
      try {
        printf("served %d\n", (int)demlaws::Pair::checked(*table, modulus, roughness).serves(other, 0.01));
      } catch (const std::exception &problem) {
        printf("refused %s\n", problem.what());
      }
    } else if (word == "virgin") state = demlaws::State();
    else if (word == "overlap") {
      double overlap, stored, dissipated;
      std::cin >> overlap;
      const demlaws::Force now = demlaws::step(pair, radius, overlap, state);
      demlaws::stored_and_dissipated(pair, radius, overlap, &state.maximum_overlap, stored, dissipated);
      printf("%.17g %.17g %.17g %.17g %.17g %.17g %.17g %d\n", now.force, now.stiffness, state.maximum_overlap,
             state.plastic_overlap, state.radius_ratio, stored, dissipated, (int)now.outside);
    } else if (word == "shear") { // as engines ask: in a step, and of a contact without a step
      double overlap;
      std::cin >> overlap;
      double *const own = &state.maximum_overlap;
      for (int update = 0; update < 2; update++) {
        const demlaws::Force now = demlaws::step(pair, radius, overlap, own, update != 0);
        for (int i = demlaws::ELASTIC_SHEAR; i <= demlaws::LOADING_SHEAR; i++)
          printf("%.17g ", demlaws::shear_stiffness((demlaws::Shear)i, pair, radius, overlap, now, own));
      }
      printf("\n");
    } else if (word == "recoverable") {
      demlaws::Force now = demlaws::Force();
      double state[3];
      std::cin >> now.force >> state[0] >> state[1] >> state[2];
      printf("%.17g ",
             demlaws::shear_stiffness<demlaws::HERTZ>(demlaws::ELASTIC_SHEAR, pair, radius, state[0], now, state));
      printf("%.17g\n",
             demlaws::shear_stiffness<demlaws::THORNTON>(demlaws::ELASTIC_SHEAR, pair, radius, state[0], now, state));
    } else return 2;
  }
  return 0;
}
