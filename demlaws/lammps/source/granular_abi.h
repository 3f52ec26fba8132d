// LAMMPS's own classes, in the place of those that src/granular_abi.h mirrors.
#ifndef DEMLAWS_GRANULAR_ABI_H
#define DEMLAWS_GRANULAR_ABI_H

#include "atom.h"
#include "force.h"
#include "gran_sub_mod_demlaws.h"
#include "granular_model.h"
#include "input.h"
#include "pair_granular.h"
#include "range.h"

namespace {

using namespace LAMMPS_NS::Granular_NS;
const int LAST_TYPE = 3; // SURFACE, of package GRANSURF, which releases before 4 Jul 2026 have not

// LAMMPS deals the history for pair_coeff lines that later ones have replaced, too, and writes them into restart files:
// they become copies of the line that is being read. Histories that exist keep their size, also those
// of a restart file with its models, which hybrid styles leave out.
inline void replace_unused(LAMMPS_NS::LAMMPS *lmp, GranularModel *now) {
  const int count = lmp->input->narg;
  char **const arg = lmp->input->arg;
  int at = 2; // behind the types, also where PairHybrid has moved them
  while (at < count && strcmp(arg[at], "demlaws/table")) at++;
  if (strcmp(lmp->input->command, "pair_coeff") || at >= count) return;
  const bool restored =
      lmp->modify->nfix_restart_peratom && !LAMMPS_NS::utils::strmatch(lmp->force->pair_style, "^hybrid");
  const bool sized = restored || !lmp->modify->get_fix_by_style("^NEIGH_HISTORY").empty();
  const TypePairs taken = pairs_of(arg[at - 2], arg[at - 1], lmp->atom->ntypes);
  LAMMPS_NS::PairGranular *pair = NULL, *last = NULL;
  for (int n = 1; !pair || pair->models_list[pair->nmodels - 1] != now;
       n++, last = pair) { // of hybrid there may be several
    pair = dynamic_cast<LAMMPS_NS::PairGranular *>(lmp->force->pair_match("granular", 0, n));
    if (!pair || pair == last) return;
  }
  std::set<int> used;
  for (int i = 1; i <= lmp->atom->ntypes; i++)
    for (int j = i; j <= lmp->atom->ntypes; j++)
      if (pair->setflag[i][j] && !taken.count({i, j})) used.insert(pair->types_indices[i][j]);
  for (int n = 0; n < pair->nmodels - 1; n++) {
    GranularModel *const model = pair->models_list[n];
    bool equal = true;
    for (int k = 0; k < NSUBMODELS; k++)
      equal = equal && model->sub_models[k]->size_history == now->sub_models[k]->size_history;
    if (equal || used.count(n)) continue;
    if (sized) raise(lmp, true, MIXED_SIZES);
    model->mix_coeffs(now, now);
    model->init();
  }
}

struct Abi {
  typedef GranularModel Model;
  typedef GranSubMod SubMod;
  static void after_init(LAMMPS_NS::LAMMPS *lmp, Model *m) { replace_unused(lmp, m); }

  // A sub-model in the place of the one that LAMMPS made by the name.
  struct NormalMod : public GranSubModNormal {
  protected:
    NormalMod(Model *m, int numbers, int outputs)
        : GranSubModNormal(m, ((GranSubModNormalDemlaws *)m->sub_models[NORMAL])->instance()) {
      num_coeffs = numbers;
      nsvector = outputs;
      allocate_coeffs();
      std::fill(coeffs, coeffs + numbers, 0.);
    }
  };
  struct DampingMod : public GranSubModDamping {
  protected:
    explicit DampingMod(Model *m)
        : GranSubModDamping(m, ((GranSubModDampingDemlaws *)m->sub_models[DAMPING])->instance()) {
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
  protected:
    TangentialMod(Model *m, int numbers)
        : GranSubModTangential(m, ((GranSubModTangentialDemlaws *)m->sub_models[TANGENTIAL])->instance()) {
      num_coeffs = numbers;
      allocate_coeffs();
      synchronize(this, 0);
    }
  };
};

} // namespace
#endif
