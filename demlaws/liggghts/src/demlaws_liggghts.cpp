// Plugin for the stock LIGGGHTS 3.8.0: LD_PRELOAD=libdemlaws_liggghts.so liggghts -in in.case
// Adds the normal model `demlaws/table` for particle pairs, primitive walls and mesh walls.
#include <cstdio>
#include "stock.h"
#include "model.h"
#include "pair_style.h"
#include "wall_style.h"

namespace demlaws {

template <class MODEL> PairStyles::IGranularPairStyle *make_pair_style(LAMMPS *lmp, PairGran *parent, const int64_t hash) {
  return new PairStyle<MODEL>(lmp, parent, hash);
}
template <class MODEL> Walls::IGranularWall *make_wall(LAMMPS *lmp, FixWallGran *parent, const int64_t hash) {
  return new WallStyle<MODEL>(lmp, parent, hash);
}

// Combinations with a stock model that demlaws/table does not go with: named when a case asks for one.
static void refuse(LAMMPS *lmp, int64_t hash) {
  static const struct {
    int shift, id;
    const char *name;
  } others[] = {{6, 4, "tangential tan_luding"}, {12, 1, "cohesion sjkr"}, {12, 2, "cohesion sjkr2"},
                {12, 7, "cohesion washino/capillary/viscous"}, {12, 8, "cohesion easo/capillary/viscous"},
                {18, 4, "rolling_friction epsd3"}, {18, 6, "rolling_friction luding"}, {24, 2, "surface multicontact"},
                {24, 5, "surface superquadric"}};
  std::string what = "model demlaws/table does not work with";
  const char *separator = " ";
  for (size_t k = 0; k < sizeof others / sizeof *others; k++)
    if (((hash >> others[k].shift) & 63) == others[k].id) {
      what += separator + std::string(others[k].name);
      separator = ", ";
    }
  what += "; it has tangential off, no_history, history, rolling_friction off, cdt, epsd, epsd2, cohesion off, surface default";
  lmp->error->all(FLERR, what.c_str());
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
    const int64_t hash = Utils::generate_gran_hashcode(DEMLAWS_TABLE, TANGENTIAL, COHESION_OFF, ROLLING, SURFACE_DEFAULT);
    PairStyles::Factory::instance().addStyle("gran", hash, &make_pair_style<Model<TANGENTIAL, ROLLING> >);
    Walls::Factory::instance().addStyle("gran", hash, &make_wall<Model<TANGENTIAL, ROLLING> >);
  }
  template <int TANGENTIAL> static void add_rolling() {
    add<TANGENTIAL, ROLLING_OFF>();
    add<TANGENTIAL, ROLLING_CDT>();
    add<TANGENTIAL, ROLLING_EPSD>();
    add<TANGENTIAL, ROLLING_EPSD2>();
  }
  Registration() {
    setvbuf(stdout, NULL, _IOLBF, BUFSIZ); // or the reason of an MPI_Abort is lost where the output goes to a pipe
    ContactModels::Factory::instance().addNormalModel("demlaws/table", DEMLAWS_TABLE);
    add_rolling<TANGENTIAL_OFF>();
    add_rolling<TANGENTIAL_NO_HISTORY>();
    add_rolling<TANGENTIAL_HISTORY>();
    static const int tangential[] = {0, 1, 2, 4}, cohesion[] = {0, 1, 2, 7, 8}, rolling[] = {0, 1, 2, 3, 4, 6}, surface[] = {0, 2, 5};
    for (int t : tangential)
      for (int c : cohesion)
        for (int r : rolling)
          for (int s : surface) {
            if (t <= 2 && c == 0 && r <= 3 && s == 0) continue;
            const int64_t hash = Utils::generate_gran_hashcode(DEMLAWS_TABLE, t, c, r, s);
            PairStyles::Factory::instance().addStyle("gran", hash, &refuse_pair_style);
            Walls::Factory::instance().addStyle("gran", hash, &refuse_wall);
          }
  }
};
static Registration registration;

} // namespace demlaws
