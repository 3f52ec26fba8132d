// The words of the normal model demlaws/table in an input line; see docs/lammps.md.
#ifndef DEMLAWS_LAMMPS_WORDS_H
#define DEMLAWS_LAMMPS_WORDS_H

#include "demlaws_shear.h"
#include "stock.h"

namespace {

// A number of an input line.
inline double number(void *lmp, const std::string &of, const char *text) {
  char *end;
  const double value = strtod(text, &end);
  if (end == text || *end || !(value - value == 0.))
    raise(lmp, true, "demlaws/table: " + of + " is '" + text + "', not a finite number");
  return value;
}

// The material that makes E* and G* of the pair those of the two materials: stock hertz/material takes E* for E here,
// so that `mindlin NULL` is too soft by about half.
inline void join(double E1, double nu1, double E2, double nu2, double &E, double &nu) {
  const double modulus = 1. / ((1. - nu1 * nu1) / E1 + (1. - nu2 * nu2) / E2);
  const double shear = 1. / (2. * (2. - nu1) * (1. + nu1) / E1 + 2. * (2. - nu2) * (1. + nu2) / E2);
  const double ratio = modulus / shear;
  nu = (ratio - 4.) / (ratio - 2.);
  E = 2. * (1. - nu * nu) * modulus;
}

// TABLE: the normal model, which names the places of its numbers.
template <class TABLE> struct Words {
  // The words FILE E eta nu from arg[at] on; goes behind them.
  static std::string read_material(void *lmp, char **arg, int &at, int count, double *into) {
    if (at + 4 > count)
      raise(lmp, true,
            "demlaws/table needs FILE E eta nu, then [roughness SIGMA] [against E2 nu2] [radius_tolerance X] "
            "[extrapolation on] [shear elastic|loading|slip] [shear_ratio X] [levels N] [springs N] "
            "[friction_pressure C1 C2]");
    const std::string file = arg[at++];
    static const char *const names[3] = {"E", "eta", "nu"};
    for (int k = 0; k < 3; k++, at++) into[k] = number(lmp, std::string("(in FILE E eta nu) ") + names[k], arg[at]);
    return file;
  }
  // The keywords from arg[at] on, which may change E and nu; returns the place behind them.
  static int read_options(void *lmp, char **arg, int at, int count, double *into) {
    bool levels = false;
    for (int values; at < count; at += values + 1) {
      const std::string word = arg[at], value = at + 1 < count ? arg[at + 1] : "nothing";
      values = word == "against" || word == "friction_pressure" ? 2 : 1;
      const auto given = [&](int n) {
        if (at + values >= count)
          raise(lmp, true, "demlaws/table: " + word + (values == 2 ? " needs two numbers" : " needs a number"));
        return number(lmp, word, arg[at + n]);
      };
      demlaws::Shear shear;
      if (word == "extrapolation") {
        if (value != "on" && value != "off")
          raise(lmp, true, "demlaws/table: extrapolation is on or off, not " + value);
        into[TABLE::EXTRAPOLATION] = value == "on";
      } else if (word == "shear") {
        if (!demlaws::shear_from_name(value, shear))
          raise(lmp, true, "demlaws/table: shear is elastic, loading or slip, not " + value);
        into[TABLE::SHEAR] = shear;
      } else if (word == "roughness") {
        into[TABLE::ROUGHNESS] = given(1);
        if (!(given(1) > 0.)) raise(lmp, true, "demlaws/table: roughness " + value + " m: must be positive");
      } else if (word == "shear_ratio") {
        into[TABLE::RATIO] = given(1);
        if (!(given(1) > 0.))
          raise(lmp, true, "demlaws/table: shear_ratio " + value + ": K_t/K must be above 0 and at most 4/3");
      } else if (word == "springs") into[TABLE::SPRINGS] = given(1);
      else if (word == "levels") {
        into[TABLE::LEVELS] = given(1);
        levels = true;
      } else if (word == "friction_pressure") {
        into[TABLE::FRICTION_C1] = given(1);
        into[TABLE::FRICTION_C2] = given(2);
      } else if (word == "radius_tolerance") into[TABLE::TOLERANCE] = given(1);
      else if (word == "against") {
        const double E = given(1), nu = given(2);
        if (!(E > 0.) || !(nu > -1. && nu <= 0.5) || !(into[0] > 0.) || !(into[2] > -1. && into[2] <= 0.5))
          raise(lmp, true,
                std::string("demlaws/table: E ") + std::to_string(into[0]) + " Pa against " + value + " Pa, nu " +
                    std::to_string(into[2]) + " against " + arg[at + 2] +
                    ": Young's moduli must be positive, Poisson's ratios are from -1 to 0.5");
        join(into[0], into[2], E, nu, into[0], into[2]);
      } else break;
    }
    if (levels && into[TABLE::SHEAR] == demlaws::SLIP_SHEAR)
      raise(lmp, true, "demlaws/table: partial slip has springs, not levels: leave 'levels' out");
    return at;
  }
};

} // namespace

#endif
