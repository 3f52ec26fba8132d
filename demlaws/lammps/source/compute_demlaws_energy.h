// compute ID all demlaws/energy: [1] energy that contacts store, [2] that they dissipated, [3] that dashpots took [J].
#ifdef COMPUTE_CLASS
// clang-format off
ComputeStyle(demlaws/energy,ComputeDemlawsEnergy);
ComputeStyle(DEMLAWS,ComputeDemlaws);
// clang-format on
#else

#ifndef LMP_COMPUTE_DEMLAWS_ENERGY_H
#define LMP_COMPUTE_DEMLAWS_ENERGY_H

#include "compute.h"

namespace LAMMPS_NS {

class ComputeDemlawsEnergy : public Compute {
public:
  ComputeDemlawsEnergy(class LAMMPS *, int, char **);
  ~ComputeDemlawsEnergy() override;
  void init() override;
  void compute_vector() override;
};

// Made with the first table: has the fix below made, which a fix wall/gran, while it is made itself, could not.
class ComputeDemlaws : public Compute {
public:
  ComputeDemlaws(class LAMMPS *lmp, int narg, char **arg) : Compute(lmp, narg, arg) {}
  void init() override;
};

} // namespace LAMMPS_NS

#endif
#endif
