// Plugin for the stock LIGGGHTS 3.8.0: LD_PRELOAD=libdemlaws_liggghts.so liggghts -in in.case
// Adds the normal model `demlaws/table` for particle pairs, primitive walls and mesh walls.
#include "stock.h"

#include "model.h"
#include "pair_style.h"
#include "wall_style.h"
#include <cstdio>

namespace demlaws {

template <class MODEL>
PairStyles::IGranularPairStyle *make_pair_style(LAMMPS *lmp, PairGran *parent, const int64_t hash) {
  return new PairStyle<MODEL>(lmp, parent, hash);
}
template <class MODEL> Walls::IGranularWall *make_wall(LAMMPS *lmp, FixWallGran *parent, const int64_t hash) {
  return new WallStyle<MODEL>(lmp, parent, hash);
}

// LIGGGHTS's sub-models by kind, with the ids of its headers (TANGENTIAL_MODEL(..., 4) and so on), and whether
// demlaws/table goes with them. A combination's number has six bits a kind, in the order of Kind.
enum Kind { NORMAL, TANGENTIAL, COHESION, ROLLING, SURFACE };
struct SubModel {
  Kind kind;
  int id;
  bool works;
  const char *name;
};
static const SubModel SUB_MODELS[] = {
    {TANGENTIAL, TANGENTIAL_OFF, true, "tangential off"},
    {TANGENTIAL, TANGENTIAL_NO_HISTORY, true, "tangential no_history"},
    {TANGENTIAL, TANGENTIAL_HISTORY, true, "tangential history"},
    {TANGENTIAL, TANGENTIAL_DEMLAWS, true, "tangential demlaws"},
    {TANGENTIAL, 4, false, "tangential tan_luding"},
    {COHESION, COHESION_OFF, true, "cohesion off"},
    {COHESION, 1, false, "cohesion sjkr"},
    {COHESION, 2, false, "cohesion sjkr2"},
    {COHESION, 7, false, "cohesion washino/capillary/viscous"},
    {COHESION, 8, false, "cohesion easo/capillary/viscous"},
    {ROLLING, ROLLING_OFF, true, "rolling_friction off"},
    {ROLLING, ROLLING_CDT, true, "rolling_friction cdt"},
    {ROLLING, ROLLING_EPSD, true, "rolling_friction epsd"},
    {ROLLING, ROLLING_EPSD2, true, "rolling_friction epsd2"},
    {ROLLING, 4, false, "rolling_friction epsd3"},
    {ROLLING, 6, false, "rolling_friction luding"},
    {SURFACE, SURFACE_DEFAULT, true, "surface default"},
    {SURFACE, 2, false, "surface multicontact"},
    {SURFACE, 5, false, "surface superquadric"},
};

// Names the sub-models of a combination that demlaws/table does not go with, and those that it does.
static void refuse(LAMMPS *lmp, int64_t hash) {
  std::string without, with;
  for (const SubModel &model : SUB_MODELS) {
    if (model.works) with += (with.empty() ? "" : ", ") + std::string(model.name);
    else if (((hash >> 6 * model.kind) & 63) == model.id)
      without += (without.empty() ? "" : ", ") + std::string(model.name);
  }
  lmp->error->all(FLERR, ("model demlaws/table does not work with " + without + "; it has " + with).c_str());
}
static PairStyles::IGranularPairStyle *refuse_pair_style(LAMMPS *lmp, PairGran *, const int64_t hash) {
  refuse(lmp, hash);
  return NULL;
}
static Walls::IGranularWall *refuse_wall(LAMMPS *lmp, FixWallGran *, const int64_t hash) {
  refuse(lmp, hash);
  return NULL;
}

struct Registration {
  template <int TANGENTIAL, int ROLLING> static void add() {
    const int64_t hash =
        Utils::generate_gran_hashcode(DEMLAWS_TABLE, TANGENTIAL, COHESION_OFF, ROLLING, SURFACE_DEFAULT);
    PairStyles::Factory::instance().addStyle("gran", hash, &make_pair_style<Model<TANGENTIAL, ROLLING>>);
    Walls::Factory::instance().addStyle("gran", hash, &make_wall<Model<TANGENTIAL, ROLLING>>);
  }
  template <int TANGENTIAL> static void add_rolling() {
    add<TANGENTIAL, ROLLING_OFF>();
    add<TANGENTIAL, ROLLING_CDT>();
    add<TANGENTIAL, ROLLING_EPSD>();
    add<TANGENTIAL, ROLLING_EPSD2>();
  }
  // All combinations with a sub-model that demlaws/table does not go with, kind after kind.
  static void add_refused(int kind, int64_t hash, bool works) {
    if (kind > SURFACE) {
      if (works) return;
      PairStyles::Factory::instance().addStyle("gran", hash, &refuse_pair_style);
      Walls::Factory::instance().addStyle("gran", hash, &refuse_wall);
      return;
    }
    for (const SubModel &model : SUB_MODELS)
      if (model.kind == kind) add_refused(kind + 1, hash | (int64_t)model.id << 6 * kind, works && model.works);
  }
  Registration() {
    setvbuf(stdout, NULL, _IOLBF, BUFSIZ); // or the reason of an MPI_Abort is lost where the output goes to a pipe
    ContactModels::Factory::instance().addNormalModel("demlaws/table", DEMLAWS_TABLE);
    ContactModels::Factory::instance().addTangentialModel("demlaws", TANGENTIAL_DEMLAWS);
    add_rolling<TANGENTIAL_OFF>();
    add_rolling<TANGENTIAL_NO_HISTORY>();
    add_rolling<TANGENTIAL_HISTORY>();
    add_rolling<TANGENTIAL_DEMLAWS>();
    add_refused(TANGENTIAL, DEMLAWS_TABLE, true);
  }
};
static Registration registration;

} // namespace demlaws
