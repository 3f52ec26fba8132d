// demlaws_limits.h: admissible values of materials and contacts, in the words of demlaws/admissible.py. C++11.
//
//     const demlaws::Finding found = demlaws::judge("young", E);                 // SI units
//     if (!found.admissible) error(found.text); else if (!found.text.empty()) warn(found.text);
//
// Licence: GPL-2.0-or-later, as the package demlaws.
#ifndef DEMLAWS_LIMITS_H
#define DEMLAWS_LIMITS_H
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>

namespace demlaws {

// An inadmissible value, or an unlikely one, in words; an admissible value has no text.
struct Finding {
  bool admissible;
  std::string text;
};

namespace limits {
const double INFINITE = std::numeric_limits<double>::infinity();
struct Range {
  const char *name, *unit;
  double low, high;
  bool low_included;
  const char *remedy;
};
const Range RANGES[] = {
    {"young", "Pa", 2e3, INFINITE, false,
     "Young's modulus of a grain is above 2000 Pa; did you mean GPa (1 GPa = 1e9 Pa)?"},
    {"poisson", "", -1., 0.5, false, "Poisson's ratio must be above -1 and at most 0.5"},
    {"density", "kg/m³", 10., INFINITE, false,
     "a grain's density is above 10 kg/m³; did you mean g/cm³ (1 g/cm³ = 1000 kg/m³)?"},
    {"radius", "m", 0., INFINITE, false, "the radius must be positive (two flats have no Hertz contact)"},
    {"modulus", "Pa", 1e3, INFINITE, false,
     "the effective modulus E* is above 1000 Pa; did you mean GPa (1 GPa = 1e9 Pa)?"},
    {"roughness", "m", 0., INFINITE, true, "rms roughness Sq cannot be negative"},
};
inline std::string number(const char *format, double value) {
  char text[40];
  snprintf(text, sizeof text, format, value);
  return text;
}
} // namespace limits

// One quantity of limits::RANGES, in SI units.
inline Finding judge(const std::string &name, double value) {
  Finding found = {true, ""};
  for (const limits::Range &range : limits::RANGES)
    if (name == range.name) {
      found.admissible =
          std::isfinite(value) && value <= range.high && (range.low_included ? value >= range.low : value > range.low);
      const std::string what = name + " = " + limits::number("%g", value) + (*range.unit ? " " : "") + range.unit;
      if (!found.admissible) found.text = what + ": " + range.remedy;
      else if (name == "radius" && value > 1.) found.text = what + " is above 1 m; did you mean mm (1 mm = 0.001 m)?";
    }
  return found;
}

// Combined roughness [m] of a contact beside its effective radius [m].
inline Finding judge_roughness(double roughness, double radius) {
  const Finding alone = judge("roughness", roughness);
  if (!alone.admissible || !(roughness > 0.1 * radius)) return alone;
  Finding found = {roughness <= 0.5 * radius, ""};
  found.text = "roughness = " + limits::number("%g", roughness) + " m is " +
               limits::number("%.3g", roughness / radius) + " of the radius " + limits::number("%g", radius) +
               " m, above " + (found.admissible ? "0.1" : "0.5") +
               ": the laws take roughness for small beside the radius; did you mean µm (1 µm = 1e-6 m)?";
  return found;
}

} // namespace demlaws
#endif
