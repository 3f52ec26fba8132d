// Nanoseconds a contact of the law's step alone, without a DEM code around it: the least of several rounds.
//     ./cost TABLE EFFECTIVE_MODULUS EFFECTIVE_RADIUS ROUGHNESS LARGEST_OVERLAP CONTACTS ROUNDS
#include "demlaws_rule.h"
#include "demlaws_table.h"
#include <algorithm>
#include <chrono>
#include <random>
#include <vector>

int main(int count, char **arguments) {
  if (count != 8) return 2;
  try {
    demlaws::Table table(arguments[1]);
    const std::string problem = demlaws::attach_rule(table);
    if (!problem.empty()) throw std::runtime_error(problem);
    const double modulus = atof(arguments[2]), radius = atof(arguments[3]), roughness = atof(arguments[4]);
    const double largest = atof(arguments[5]);
    const int contacts = atoi(arguments[6]), rounds = atoi(arguments[7]);
    const demlaws::Pair pair(table, modulus, roughness);
    std::vector<demlaws::State> states(contacts);
    std::vector<double> overlaps(contacts);
    std::mt19937 random(1);
    std::uniform_real_distribution<double> uniform(0., 1.);
    for (int i = 0; i < contacts; i++) { // loaded to different peaks, some of them unloading
      const double top = largest * std::pow(0.03, uniform(random));
      demlaws::step(pair, radius, top, states[i]);
      overlaps[i] = uniform(random) < 0.3 ? top : top * (0.3 + 0.7 * uniform(random));
    }
    double best = 1e300, sum = 0.;
    for (int round = 0; round < rounds; round++) {
      const auto begin = std::chrono::steady_clock::now();
      for (int i = 0; i < contacts; i++) {
        const demlaws::Force now = demlaws::step(pair, radius, overlaps[i], states[i]);
        sum += now.force + now.stiffness;
      }
      const std::chrono::duration<double, std::nano> taken = std::chrono::steady_clock::now() - begin;
      best = std::min(best, taken.count() / contacts);
    }
    printf("%.6g %.6g\n", best, sum);
  } catch (const std::exception &problem) {
    fprintf(stderr, "%s\n", problem.what());
    return 1;
  }
  return 0;
}
