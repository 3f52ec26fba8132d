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

// Any other combination of sub-models: LIGGGHTS itself would call it an unknown normal model.
template <class STYLE, class PARENT> STYLE *refuse(LAMMPS *lmp, PARENT *, const int64_t) {
  lmp->error->all(
      FLERR, "model demlaws/table works with tangential off, no_history, history, demlaws; rolling_friction off, cdt, "
             "epsd, epsd2; cohesion off; surface default: leave the other sub-model out");
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
  // The stock ids go up to 4 for tangential models, 8 for cohesion, 6 for rolling friction and 5 for surfaces.
  static void add_refused() {
    for (int tangential : {0, 1, 2, 3, 4, TANGENTIAL_DEMLAWS + 0})
      for (int cohesion = 0; cohesion <= 8; cohesion++)
        for (int rolling = 0; rolling <= 6; rolling++)
          for (int surface = 0; surface <= 5; surface++) {
            const bool shears = tangential <= TANGENTIAL_HISTORY || tangential == TANGENTIAL_DEMLAWS;
            if (shears && cohesion == COHESION_OFF && rolling <= ROLLING_EPSD2 && surface == SURFACE_DEFAULT) continue;
            const int64_t hash = Utils::generate_gran_hashcode(DEMLAWS_TABLE, tangential, cohesion, rolling, surface);
            PairStyles::Factory::instance().addStyle("gran", hash, &refuse<PairStyles::IGranularPairStyle, PairGran>);
            Walls::Factory::instance().addStyle("gran", hash, &refuse<Walls::IGranularWall, FixWallGran>);
          }
  }
  Registration() {
    setvbuf(stdout, NULL, _IOLBF, BUFSIZ); // or the reason of an MPI_Abort is lost where the output goes to a pipe
    ContactModels::Factory::instance().addNormalModel("demlaws/table", DEMLAWS_TABLE);
    ContactModels::Factory::instance().addTangentialModel("demlaws", TANGENTIAL_DEMLAWS);
    add_refused();
    add_rolling<TANGENTIAL_OFF>();
    add_rolling<TANGENTIAL_NO_HISTORY>();
    add_rolling<TANGENTIAL_HISTORY>();
    add_rolling<TANGENTIAL_DEMLAWS>();
  }
};
static Registration registration;

} // namespace demlaws
