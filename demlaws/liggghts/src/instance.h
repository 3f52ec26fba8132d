// What the parts of the plugin share within one instance of LIGGGHTS: the line being read, the tables of the pair
// style, energies, counts. It lives as long as one of those parts: nothing stays behind after `clear`, or
// for a second instance that is made at the same address.
#ifndef DEMLAWS_INSTANCE_H
#define DEMLAWS_INSTANCE_H
#include "stock.h"

#include "demlaws_plugin.h"

namespace demlaws {
using namespace LAMMPS_NS;

typedef std::pair<int, int> Types; // i <= j; (0, 0) stands for all pairs without a table of their own
typedef std::map<Types, std::string> Files;

inline Types types_of(int i, int j) { return i < j ? Types(i, j) : Types(j, i); }

// A page of the history must hold what all contacts of one particle keep; LIGGGHTS would write beyond it.
inline void refuse_small_pages(LAMMPS *lmp, int values, const std::string &who) {
  const int room = lmp->neighbor->pgsize / lmp->neighbor->oneatom;
  if (values <= room) return;
  std::ostringstream what;
  what << who << " keeps " << values << " values, LIGGGHTS has room for " << room << ": say 'neigh_modify page "
       << values * lmp->neighbor->oneatom << "', or give fewer 'springs' or 'levels'";
  lmp->error->all(FLERR, what.str().c_str());
}

// The words of one pair_style or wall/gran line that are ours.
struct Words {
  Files files;
  std::map<Types, PressureFriction> friction; // 'friction_pressure', of which the coefficient is not constant
  Shear shear = ELASTIC_SHEAR;                // the normal stiffness used to compute K_t
};

// The line that is read, and the settings that it gives in so many words.
struct Line : Words {
  std::set<std::string> given;
};

// What walls take over from the pair style except for the words of their own line.
struct PairSettings : Words {
  std::map<std::string, const Table *> tables; // as read: since then the folder, or the file, may be another
  bool use_roughness = false, extrapolate = false;
  double radius_tolerance = 0.01, shear_ratio = 0.; // 0: that of Mindlin
};

// Energy of this rank that no pair contact holds: `taken` is what plastic flow took in pair contacts that have ended
// and in all wall contacts, and the work of shear. A mesh drops contacts, and hands them from triangle to triangle,
// without notice to the model; so the dissipation of walls is added up while it happens, not when a contact ends. The
// energy of shear that contacts still store is subtracted on request: in each step it would cost more than the work.
struct Ledger {
  double taken = 0., viscous = 0.; // viscous: what dashpots took while there were readers
  int readers = 0;                 // computes that will ask: without one the work of shear is not added up
  bool counts_stored = false; // `taken` contains the energy of shear that contacts store; else their next step adds it
  bool adds_stored = false, lacks_stored = false; // this step adds it; `taken` lacks it until then
  double wall_stored = 0., wall_pending = 0.;     // pending: taken less booked
  bigint step = -1;                               // of these
  // The part of a contact's stored energy of shear that `taken` contains.
  double booked(double stored) const { return lacks_stored ? 0. : stored; }
  void forget_walls() { wall_stored = wall_pending = 0.; }
  void add_wall(bigint now, double stored, double pending) {
    if (now != step) forget_walls();
    step = now;
    wall_stored += stored;
    wall_pending += pending;
  }
  // Of a pair contact whose second particle is j: where that is another rank's, it has the other half.
  void add_dissipated(double energy, int j, int nlocal) { taken += j < nlocal ? energy : 0.5 * energy; }
  void add_viscous(double energy, bool wall, int j, int nlocal) {
    viscous += wall || j < nlocal ? energy : 0.5 * energy;
  }
};

struct EnergySource {
  virtual ~EnergySource() {}
  virtual void energies(double &stored, double &dissipated) = 0; // of this rank
};

struct Instance {
  Line line; // of the line being read
  PairSettings pair;
  double springs = SPRINGS, levels = LEVELS; // of the pair style
  Ledger ledger;
  Counts counts; // of the run that goes on
  EnergySource *source = NULL;
  std::set<std::string> walls; // IDs of the walls whose model is demlaws/table

  static std::shared_ptr<Instance> of(LAMMPS *lmp) {
    std::weak_ptr<Instance> &slot = all()[lmp];
    std::shared_ptr<Instance> found = slot.lock();
    if (!found) {
      found.reset(new Instance(lmp));
      slot = found;
    }
    return found;
  }
  // Once, of what all ranks know: rank 0 says it.
  void announce(const std::string &what, const std::string &text) {
    if (counts.reported.insert(what).second && key_->comm->me == 0) key_->error->warning(FLERR, text.c_str());
  }
  // LIGGGHTS calls surfacesClose() only with this factor for walls, which have no contact flags, and where a pair opens
  // in a step in which lists are built; there the energy that it had dissipated would be dropped.
  void see_contacts_end(bool wall) const {
    if (wall || ledger.readers) key_->neighbor->register_contact_dist_factor(1.01);
  }
  ~Instance() {
    std::map<LAMMPS *, std::weak_ptr<Instance>>::iterator it = all().find(key_);
    if (it != all().end() && it->second.expired()) all().erase(it);
  }

private:
  LAMMPS *const key_;
  explicit Instance(LAMMPS *lmp) : key_(lmp) {}
  static std::map<LAMMPS *, std::weak_ptr<Instance>> &all() {
    static std::map<LAMMPS *, std::weak_ptr<Instance>> instances;
    return instances;
  }
};

class Mpi : public Ranks {
public:
  explicit Mpi(LAMMPS *lmp) : error_(lmp->error), world_(lmp->world) {
    me = lmp->comm->me;
    count = lmp->comm->nprocs;
  }

private:
  Error *const error_;
  const MPI_Comm world_;
  mutable MPI_Request barrier_;
  void start() const { MPI_Ibarrier(world_, &barrier_); }
  bool arrived() const {
    int all = 0;
    MPI_Test(&barrier_, &all, MPI_STATUS_IGNORE);
    return all != 0;
  }
  void end(const std::string &why) const { error_->one(FLERR, why.c_str()); }
  void broadcast(void *bytes, int size) const { MPI_Bcast(bytes, size, MPI_BYTE, 0, world_); }
  void collect(const void *mine, int size, void *all) const {
    MPI_Allgather(const_cast<void *>(mine), size, MPI_BYTE, all, size, MPI_BYTE, world_);
  }
};

} // namespace demlaws
#endif
