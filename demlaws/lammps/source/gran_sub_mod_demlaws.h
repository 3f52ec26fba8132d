// Granular sub-models of demlaws in LAMMPS itself: normal demlaws/table, damping demlaws/tangent, tangential demlaws.
// Copied with the files beside it into src/GRANULAR; `demlaws lammps source` writes them. Licence: GPL-2.0-or-later.
#ifdef GRAN_SUB_MOD_CLASS
// clang-format off
GranSubModStyle(demlaws/table,GranSubModNormalDemlaws,NORMAL);
GranSubModStyle(demlaws/tangent,GranSubModDampingDemlaws,DAMPING);
GranSubModStyle(demlaws,GranSubModTangentialDemlaws,TANGENTIAL);
// clang-format on
#else

#ifndef LMP_GRAN_SUB_MOD_DEMLAWS_H
#define LMP_GRAN_SUB_MOD_DEMLAWS_H

#include "gran_sub_mod_damping.h"
#include "gran_sub_mod_normal.h"
#include "gran_sub_mod_tangential.h"

#include <utility>
#include <vector>

namespace LAMMPS_NS {
class LAMMPS;
namespace Granular_NS {

// LAMMPS makes these by their names alone. As soon as their coefficients are known, which name a table and its rule of
// unloading, the sub-models of demlaws come in their place (gran_sub_mod_demlaws.cpp).

class GranSubModNormalDemlaws : public GranSubModNormal {
public:
  GranSubModNormalDemlaws(class GranularModel *, class LAMMPS *);
  void coeffs_to_local() override;
  void mix_coeffs(double *, double *) override;
  double calculate_forces() override { return 0.0; }
  LAMMPS *instance() const { return lmp; }

private:
  std::string file;                              // from an input line, as what follows; else empty
  double material[3];                            // E, eta, nu
  std::vector<double> options;                   // NaN: not given
  std::vector<std::pair<char **, char *>> words; // of the line that is being read, and where they stand

  void read_line(char **, int, int);
};

class GranSubModDampingDemlaws : public GranSubModDamping {
public:
  GranSubModDampingDemlaws(class GranularModel *, class LAMMPS *);
  void coeffs_to_local() override;
  double calculate_forces() override { return 0.0; }
  LAMMPS *instance() const { return lmp; }
};

class GranSubModTangentialDemlaws : public GranSubModTangential {
public:
  GranSubModTangentialDemlaws(class GranularModel *, class LAMMPS *);
  void coeffs_to_local() override;
  void calculate_forces() override {}
  LAMMPS *instance() const { return lmp; }
};

} // namespace Granular_NS
} // namespace LAMMPS_NS

#endif
#endif
