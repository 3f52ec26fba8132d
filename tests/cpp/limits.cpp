// Findings on quantities, and on roughness beside radius: lines "NAME VALUE" or "roughness VALUE RADIUS" from standard
// input.
#include <demlaws_limits.h>
#include <iostream>
#include <sstream>

int main() {
  std::string line, name;
  while (std::getline(std::cin, line)) {
    std::istringstream words(line);
    double value = 0., radius = 0.;
    words >> name >> value;
    const demlaws::Finding found =
        words >> radius ? demlaws::judge_roughness(value, radius) : demlaws::judge(name, value);
    std::cout << found.admissible << found.text << "\n";
  }
}
