// What the parts of the plugin share within one instance of LIGGGHTS: the line being read, the tables of the pair
// style, fingerprints, energies, counts. It lives as long as one of those parts: nothing stays behind after `clear`, or
// for a second instance that is made at the same address.
#ifndef DEMLAWS_INSTANCE_H
#define DEMLAWS_INSTANCE_H
#include "stock.h"

#include "demlaws_range.h"
#include "demlaws_rule.h"
#include "demlaws_table.h"
#include <algorithm>
#include <cstring>
#include <map>
#include <memory>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace demlaws {
using namespace LAMMPS_NS;

typedef std::pair<int, int> Types; // i <= j; (0, 0) stands for all pairs without a table of their own
typedef std::map<Types, std::string> Files;
typedef std::map<Types, uint32_t> Fingerprints;

inline Types types_of(int i, int j) { return i < j ? Types(i, j) : Types(j, i); }

// The words of one pair_style or wall/gran line that are ours, and the settings that were given in so many words.
struct Line {
  Files files;
  std::set<std::string> given;
  Shear shear;
  Line() : shear(ELASTIC_SHEAR) {}
};

// What walls take over from the pair style except for the words of their own line.
struct PairSettings {
  Files files;
  std::map<std::string, std::shared_ptr<Table>> tables; // as read: since then the folder, or the file, may be another
  bool use_roughness, extrapolate;
  double radius_tolerance, springs;
  Shear shear; // the normal stiffness used to compute K_t
  PairSettings()
      : use_roughness(false), extrapolate(false), radius_tolerance(0.01), springs(12.), shear(ELASTIC_SHEAR) {}
};

// Holds the wall contacts of the last step, for what they store.
class WallBook {
public:
  virtual ~WallBook() {}
  // Adds what the contacts of particles in the group hold [energy], and what their plastic flow has taken that no step
  // has booked yet.
  virtual void add_energies(int groupbit, double &stored, double &pending) const = 0;
  virtual void forget() = 0; // before forces are computed again
};

// Energy of this rank that no pair contact holds: `taken` is what plastic flow took in pair contacts that have ended
// and in all wall contacts. A mesh drops contacts, and hands them from triangle to triangle, without notice to the
// model; so the dissipation of walls is added up while it happens, not when a contact ends.
struct Ledger {
  double taken;
  double *taken_of; // the same, shared out to the particles of this rank; NULL unless a compute asks for a group
  int readers;      // computes that will ask for what walls store
  std::set<WallBook *> walls;
  Ledger() : taken(0.), taken_of(NULL), readers(0) {}
  void take(double energy, int i, int j, int nlocal) {
    taken += j < nlocal ? energy : 0.5 * energy; // the other rank has the other half
    if (!taken_of) return;
    taken_of[i] += 0.5 * energy;
    if (j < nlocal) taken_of[j] += 0.5 * energy;
  }
  void take_at_wall(double energy, int i) {
    taken += energy;
    if (taken_of) taken_of[i] += energy;
  }
};

struct EnergySource {
  virtual ~EnergySource() {}
  // of this rank; each particle of a pair has half
  virtual void energies(int groupbit, double &stored, double &dissipated) = 0;
};

struct Instance {
  Line line;         // of the line being read
  std::string owner; // whose properties are being connected: "pair" or "wall ID"
  PairSettings pair;
  Ledger ledger;
  Counts counts; // of the run that goes on
  EnergySource *source;
  std::map<std::string, Fingerprints> used, stored; // by owner: of this run, of the restart file
  std::set<std::string> walls;                      // IDs of the walls whose model is demlaws/table

  static std::shared_ptr<Instance> of(LAMMPS *lmp) {
    std::weak_ptr<Instance> &slot = all()[lmp];
    std::shared_ptr<Instance> found = slot.lock();
    if (!found) {
      found.reset(new Instance(lmp));
      slot = found;
    }
    return found;
  }
  ~Instance() {
    std::map<LAMMPS *, std::weak_ptr<Instance>>::iterator it = all().find(key_);
    if (it != all().end() && it->second.expired()) all().erase(it);
  }

private:
  LAMMPS *const key_;
  explicit Instance(LAMMPS *lmp) : source(NULL), key_(lmp) {}
  static std::map<LAMMPS *, std::weak_ptr<Instance>> &all() {
    static std::map<LAMMPS *, std::weak_ptr<Instance>> instances;
    return instances;
  }
};

// How much of the engine's unit a metre and a pascal are.
struct Units {
  double length, pressure;
  static bool of(const std::string &style, Units &units) {
    static const struct {
      const char *style;
      double length, pressure;
    } known[] = {{"si", 1., 1.}, {"cgs", 1e2, 10.}, {"micro", 1e6, 1e-3}, {"nano", 1e9, 1e-6}};
    for (size_t k = 0; k < sizeof known / sizeof *known; k++)
      if (style == known[k].style) {
        units.length = known[k].length;
        units.pressure = known[k].pressure;
        return true;
      }
    return false;
  }
};

// Rank 0 reads the file and all ranks get it: one that cannot see it, or sees another, neither hangs nor differs.
inline std::shared_ptr<Table> load(LAMMPS *lmp, const std::string &path) {
  MPI_Comm world = lmp->world;
  std::string data, problem;
  if (lmp->comm->me == 0) {
    try {
      data = Table::contents(path);
    } catch (const std::exception &caught) {
      problem = caught.what();
    }
  }
  for (std::string *text : {&problem, &data}) {
    long size = (long)text->size();
    MPI_Bcast(&size, 1, MPI_LONG, 0, world);
    text->resize(size);
    if (size) MPI_Bcast(&(*text)[0], (int)size, MPI_CHAR, 0, world);
  }
  std::shared_ptr<Table> table(new Table);
  if (problem.empty()) {
    try {
      table->parse(data, path);
    } catch (const std::exception &caught) {
      problem = caught.what();
    }
  }
  if (!problem.empty()) lmp->error->all(FLERR, ("model demlaws/table: " + problem).c_str());
  problem = attach_rule(*table); // each rank's own: the first that has none, or another, speaks for all
  int mine = problem.empty() ? lmp->comm->nprocs : lmp->comm->me, first;
  MPI_Allreduce(&mine, &first, 1, MPI_INT, MPI_MIN, world);
  if (first < lmp->comm->nprocs) {
    long size = (long)problem.size();
    MPI_Bcast(&size, 1, MPI_LONG, first, world);
    problem.resize(size);
    MPI_Bcast(&problem[0], (int)size, MPI_CHAR, first, world);
    std::ostringstream what;
    what << "model demlaws/table: rank " << first << ": " << problem;
    lmp->error->all(FLERR, what.str().c_str());
  }
  return table;
}

} // namespace demlaws
#endif
