// Findings on a modulus, or on a roughness beside a radius: lines "modulus VALUE" or "roughness VALUE RADIUS" from
// standard input.
#include <demlaws_range.h>
#include <iostream>

int main() {
  std::string name;
  double value, radius;
  while (std::cin >> name >> value) {
    const bool of_modulus = name == "modulus";
    if (!of_modulus) std::cin >> radius;
    const demlaws::Finding found = of_modulus ? demlaws::judge_modulus(value) : demlaws::judge_roughness(value, radius);
    std::cout << found.admissible << found.text << "\n";
  }
}
