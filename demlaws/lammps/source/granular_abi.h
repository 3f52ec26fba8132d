// LAMMPS's own classes, in the place of those that src/granular_abi.h mirrors.
#ifndef DEMLAWS_GRANULAR_ABI_H
#define DEMLAWS_GRANULAR_ABI_H

#include "gran_sub_mod_demlaws.h"
#include "granular_model.h"
#include "stock.h"

namespace {

using namespace LAMMPS_NS::Granular_NS;
const int LAST_TYPE = 3; // SURFACE, of package GRANSURF, which releases before 4 Jul 2026 have not

// What a sub-model knows of its instance of LAMMPS.
struct Instance {
  void *lmp, **error;
  explicit Instance(LAMMPS_NS::LAMMPS *instance) : lmp(instance), error((void **)&instance->error) {}
};

struct Abi {
  typedef GranularModel Model;
  typedef GranSubMod SubMod;
  template <class RULED> using DirectPairs = RULED; // LAMMPS computes pairs of particles itself

  // A sub-model in the place of the one that LAMMPS made by the name.
  struct NormalMod : public GranSubModNormal {
    const Instance of;

  protected:
    NormalMod(Model *m, int numbers, int outputs)
        : GranSubModNormal(m, ((GranSubModNormalDemlaws *)m->sub_models[NORMAL])->instance()), of(lmp) {
      num_coeffs = numbers;
      nsvector = outputs;
      allocate_coeffs();
      std::fill(coeffs, coeffs + numbers, 0.);
    }
  };
  struct DampingMod : public GranSubModDamping {
    const Instance of;

  protected:
    explicit DampingMod(Model *m)
        : GranSubModDamping(m, ((GranSubModDampingDemlaws *)m->sub_models[DAMPING])->instance()), of(lmp) {
      allocate_coeffs();
    }
  };
  // For `synchronized_verlet`, which releases from 22 Jul 2025 on have.
  template <class SUB_MOD> static auto synchronize(SUB_MOD *mod, int) -> decltype(mod->allow_synchronization, void()) {
    mod->allow_synchronization = 1;
  }
  template <class SUB_MOD> static void synchronize(SUB_MOD *, long) {}
  template <class MODEL> static auto has_half_step(const MODEL *m, int) -> decltype(m->synchronized_verlet != 0) {
    return m->synchronized_verlet != 0;
  }
  template <class MODEL> static bool has_half_step(const MODEL *, long) { return false; }
  static bool synchronized(const Model *m) { return has_half_step(m, 0); }

  struct TangentialMod : public GranSubModTangential {
    const Instance of;

  protected:
    TangentialMod(Model *m, int numbers)
        : GranSubModTangential(m, ((GranSubModTangentialDemlaws *)m->sub_models[TANGENTIAL])->instance()), of(lmp) {
      num_coeffs = numbers;
      allocate_coeffs();
      synchronize(this, 0);
    }
  };
};

} // namespace
#endif
