// The words of a pair_style or wall/gran line that the stock Settings do not know.
#ifndef DEMLAWS_ARGUMENTS_H
#define DEMLAWS_ARGUMENTS_H
#include "stock.h"

#include "instance.h"
#include <cstdlib>
#include <cstring>

namespace demlaws {

// Takes 'table FILE', 'pairtable I J FILE', 'shear WORD', 'friction_pressure C1 C2' and 'pairfriction_pressure I J C1
// C2' out of the arguments, for as long as it lives.
class Arguments {
public:
  Arguments(LAMMPS *lmp, int &count, char **&arguments) : lmp_(lmp), instance_(Instance::of(lmp)) {
    Line &line = instance_->line;
    line = Line();
    for (int i = 0; i < count; i++) {
      const std::string word = arguments[i];
      const bool pair = word == "pairtable" || word == "pairfriction_pressure";
      const std::string what = word.substr(pair ? 4 : 0);
      const int values = what == "table" || what == "shear" ? 1 : what == "friction_pressure" ? 2 : 0;
      line.given.insert(what);
      if (!values) {
        kept_.push_back(arguments[i]);
        continue;
      }
      char **const first = arguments + i + 1, **const value = first + 2 * pair;
      i += values + 2 * pair;
      if (i >= count)
        refuse("'" + word + "' needs " + (pair ? "two types, then " : "") +
               (what == "table"   ? "a file name"
                : what == "shear" ? "elastic, loading or slip"
                                  : "C1 and C2 [1/Pa]: mu is coefficientFriction + C1/(1 + C2 p)"));
      const Types types = pair ? types_of(type(word, first[0]), type(word, first[1])) : Types(0, 0);
      if (what == "table") add(types, *value);
      else if (what == "shear") {
        if (!shear_from_name(*value, line.shear))
          refuse(std::string("'shear' must be elastic, loading or slip, got '") + *value + "'");
      } else {
        PressureFriction friction;
        friction.c1 = number(word, value[0]);
        friction.c2 = number(word, value[1]);
        if (!friction.valid())
          refuse("'" + word + " " + value[0] + " " + value[1] + "': C1 and C2 [1/Pa] must not be negative");
        if (!line.friction.insert(std::make_pair(types, friction)).second)
          refuse("'" + word + "' is given twice" + (pair ? " for these types" : ""));
      }
    }
    count = (int)kept_.size();
    static const char *const valued[] = {
        "tangential", "rolling_friction", "cohesion",         "surface",     "tangential_damping",
        "limitForce", "surfaceRoughness", "radius_tolerance", "shear_ratio", "extrapolation",
        "springs",    "levels",           "torsionTorque"};
    for (const char *word : valued) // LIGGGHTS would read beyond the line
      if (count && !strcmp(kept_[count - 1], word)) refuse(std::string("'") + word + "' needs a value behind it");
    kept_.push_back(NULL);
    arguments = &kept_[0];
  }
  ~Arguments() { instance_->line = Line(); }

private:
  void refuse(const std::string &what) const { lmp_->error->all(FLERR, ("model demlaws/table: " + what).c_str()); }
  void add(const Types &types, const std::string &file) {
    const std::pair<Files::iterator, bool> put = instance_->line.files.insert(std::make_pair(types, file));
    if (put.second || put.first->second == file) return;
    std::ostringstream what;
    if (types.first) what << "'pairtable' gives types " << types.first << " and " << types.second;
    else what << "'table' gives all other pairs";
    what << " two tables, " << put.first->second << " and " << file
         << ": leave one (a pair has one law, seen from either side)";
    refuse(what.str());
  }
  int type(const std::string &word, const char *text) const {
    char *end;
    const long value = strtol(text, &end, 10);
    if (*end || value < 1 || value > lmp_->atom->ntypes)
      refuse("'" + word + "' names type " + text + ", which the simulation box does not have");
    return (int)value;
  }
  double number(const std::string &word, const char *text) const {
    double value;
    if (!plain_number(text, value)) refuse("'" + word + "' has '" + text + "' where a finite number is needed");
    return value;
  }
  LAMMPS *const lmp_;
  const std::shared_ptr<Instance> instance_;
  std::vector<char *> kept_;
};

} // namespace demlaws
#endif
