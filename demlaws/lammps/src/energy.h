// Where the energy of the contacts is: what plastic flow took is kept with the particles (fix property/atom
// d_demlaws_dissipated), so that it goes with them from rank to rank and into restart files; what contacts store is
// summed on request. What dashpots took is kept in the same way (d_demlaws_viscous). LAMMPS drops a contact that parts
// without a call of its model, so the work of shear is kept with the particles, and the energy of shear that contacts
// still store is subtracted on request.
// [our derivation: halves of a contact's energy to its two particles]
#ifndef DEMLAWS_ENERGY_H
#define DEMLAWS_ENERGY_H

#include "ranks.h"

namespace {

class Ledger {
public:
  bool busy = false;       // an energy compute is active: the contacts take the slow path
  bool collecting = false; // `compute pair/local` is asking every pair contact once
  double collected = 0.;   // what they store [J]
  double pending = 0.;     // what plastic flow took of them, and of walls, that no step has booked yet [J]
  bool first = false;      // no work of shear was booked before this pass

  // One for each instance of LAMMPS.
  static Ledger &of(void *lmp) {
    static std::map<void *, Ledger> all;
    Ledger &one = all[lmp];
    one.lmp_ = lmp;
    return one;
  }

  // For an instance, which may be at the address of a former one: what that one kept goes.
  void renew() {
    void *const lmp = lmp_, *const modify = modify_of(lmp);
    if (modify == modify_ && Stock::get().find_compute(modify, pairs())) return;
    *this = Ledger();
    lmp_ = lmp;
    modify_ = modify;
  }

  // Before the pair style, or a wall, computes its forces.
  void begin(void *wall) {
    wall_ = wall;
    if (!wall) walls_.clear();
    if (!wanted_) return;
    const Stock &stock = Stock::get();
    taken_ = (double *)stock.atom(lmp_, "d_demlaws_dissipated");
    viscous_ = (double *)stock.atom(lmp_, "d_demlaws_viscous");
    if (!taken_ && stock.setting(lmp_, "nlocal") > 0) wanted_ = false; // `clear`, `unfix`
    busy = wanted_;
    local_ = stock.setting(lmp_, "nlocal");
    newton_ = stock.setting(lmp_, "newton_pair") != 0;
    const long long step = now();
    first = empty_ && known_.insert(wall).second;
    if (wall) walls_[wall] = {step, 0., 0.};
  }
  void end() { wall_ = NULL; }
  // A contact of a wall: where nothing has announced its forces, those of all walls begin with the first one.
  void begin_wall() {
    if (wall_) return;
    const auto known = walls_.find(this);
    if (known == walls_.end() || known->second.step != now()) begin(this);
    wall_ = this;
  }
  // A contact of this wall: what it stores, what its plastic flow took that no step has booked yet.
  void add_wall(double stored, double pending) {
    if (!wall_) return;
    walls_[wall_].stored += stored;
    walls_[wall_].pending += pending;
  }
  // Plastic flow took `energy` from the contact of the particles whose velocities are at vi and vj; NULL: a wall.
  // (The models of walls are not told the number of their particle.)
  void add_dissipated(const double *vi, const double *vj, double energy) { add(taken_, vi, vj, energy); }
  // What a dashpot took.
  void add_viscous(const double *vi, const double *vj, double energy) { add(viscous_, vi, vj, energy); }
  // The number of the particle whose position ("x") or velocity ("v") is at `place`; -1: none.
  long particle(const char *array, const double *place) const {
    const double *const *const all = (const double *const *)Stock::get().atom(lmp_, array);
    const int count = Stock::get().setting(lmp_, "nall");
    if (!all || !count || place < all[0] || place >= all[0] + 3 * (long)count) return -1;
    return (place - all[0]) / 3;
  }

  // For `compute ID all demlaws/energy`: from now on energies are booked, with the particles.
  void open(int count, char **arg) {
    const Stock &stock = Stock::get();
    renew();
    if (count != 3 || strcmp(arg[1], "all"))
      raise(lmp_, true,
            "compute demlaws/energy: write  compute ID all demlaws/energy  (all contacts, no further words)");
    for (const char *id : {"demlaws_dissipated", "demlaws_viscous"}) {
      const std::string column = std::string("d_") + id;
      const char *words[] = {id, "all", "property/atom", column.c_str(), "ghost", "no", "writedata", "no"};
      if (!stock.find_fix(modify_, id)) stock.add_fix(modify_, 8, const_cast<char **>(words), 1);
    }
    wanted_ = true;
    // a restart file may have brought what was booked before; else contacts begin with the energy that they store now
    const std::vector<int> any = Ranks(lmp_).gather((int)(sum("d_demlaws_dissipated") != 0.));
    empty_ = !*std::max_element(any.begin(), any.end());
    known_.clear();
  }
  // A compute that asks every pair contact.
  void ask_pairs() {
    const Stock &stock = Stock::get();
    if (stock.find_compute(modify_, pairs())) return;
    const char *words[] = {pairs(), "all", "pair/local", "force", "cutoff", "radius"};
    stock.add_compute(modify_, 6, const_cast<char **>(words), 1);
  }
  // This rank's share of [0] what contacts store, [1] what was dissipated, [2] by dashpots [J]; asked in this order.
  double share(int which) {
    if (which == 0) return stored();
    return which == 1 ? sum("d_demlaws_dissipated") + pending : sum("d_demlaws_viscous");
  }

private:
  struct Wall {
    long long step; // of the last pass over it
    double stored, pending;
  };
  bool wanted_ = false, newton_ = false, empty_ = false; // empty_: when the compute was defined
  void *lmp_ = NULL, *modify_ = NULL, *wall_ = NULL;
  double *taken_ = NULL, *viscous_ = NULL;
  int local_ = 0;
  std::map<void *, Wall> walls_;
  std::set<void *> known_; // NULL, the pair style, and walls that have computed forces since

  void add(double *sums, const double *vi, const double *vj, double energy) {
    if (!sums) return;
    const long i = particle("v", vi), j = vj ? particle("v", vj) : -1;
    if (i < 0 || i >= local_) raise(lmp_, false, "compute demlaws/energy: a contact of no particle of this rank");
    if (!vj) sums[i] += energy;
    else if (j < local_) {
      sums[i] += 0.5 * energy;
      sums[j] += 0.5 * energy;
    } else sums[i] += newton_ ? energy : 0.5 * energy; // newton off: the other rank has this pair, too
  }
  static const char *pairs() { return "demlaws_pairs"; }
  long long now() const {
    const void *const step = Stock::get().global(lmp_, "ntimestep");
    return step ? *(const long long *)step : 0;
  }

  double sum(const char *column) const {
    const Stock &stock = Stock::get();
    const double *const values = (const double *)stock.atom(lmp_, column);
    const int local = stock.setting(lmp_, "nlocal");
    double sum = 0.;
    for (int i = 0; values && i < local; i++) sum += values[i];
    return sum;
  }
  double stored() {
    const Stock &stock = Stock::get();
    void *const compute = stock.find_compute(modify_, pairs());
    if (!compute)
      raise(lmp_, true, "compute demlaws/energy: its helper, compute demlaws_pairs, was deleted; define it again");
    const bool was = busy;
    busy = collecting = true;
    collected = pending = 0.;
    try {
      stock.pair_local(compute);
    } catch (...) {
      busy = was;
      collecting = false;
      throw;
    }
    busy = was;
    collecting = false;
    double sum = collected;
    const long long step = now();
    for (const auto &wall : walls_)
      if (wall.second.step == step) { // else it is not there any more
        sum += wall.second.stored;
        pending += wall.second.pending;
      }
    return sum;
  }
};

} // namespace
#endif
