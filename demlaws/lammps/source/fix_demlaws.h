// What demlaws does before a run, before each computation of forces, and after a run: checks, energies, counts.
#ifdef FIX_CLASS
// clang-format off
FixStyle(DEMLAWS,FixDemlaws);
// clang-format on
#else

#ifndef LMP_FIX_DEMLAWS_H
#define LMP_FIX_DEMLAWS_H

#include "fix.h"

namespace LAMMPS_NS {

class FixDemlaws : public Fix {
public:
  FixDemlaws(class LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg) {}
  ~FixDemlaws() override;
  int setmask() override;
  void init() override;
  void setup_pre_force(int) override;
  void pre_force(int) override { setup_pre_force(0); }
  void min_pre_force(int) override { setup_pre_force(0); }
  void post_run() override;
};

} // namespace LAMMPS_NS

#endif
#endif
