// compute demlaws/energy, and the fix that the plugin adds by itself: a sum, tables and particle numbers that outlive a
// run.
#ifndef DEMLAWS_ENERGY_H
#define DEMLAWS_ENERGY_H
#include "stock.h"

#include "instance.h"
#include <algorithm>
#include <cstdio>

namespace demlaws {

// Names a private member: an explicit instantiation may.
template <class TAG, typename TAG::type MEMBER> struct PrivateMember {
  friend typename TAG::type pointer(TAG) { return MEMBER; }
};
// where a style is registered at run time
struct ComputeMap {
  typedef std::map<std::string, Compute *(*)(LAMMPS *, int, int, char **)> *Modify::*type;
  friend type pointer(ComputeMap);
};
template struct PrivateMember<ComputeMap, &Modify::compute_map>;
struct FixMap {
  typedef std::map<std::string, Fix *(*)(LAMMPS *, int, char **)> *Modify::*type;
  friend type pointer(FixMap);
};
template struct PrivateMember<FixMap, &Modify::fix_map>;
// compute ID all demlaws/energy: stored and dissipated energy of all contacts, [1] and [2], pairs and walls, and what
// dashpots took, [3].
class ComputeEnergy : public Compute {
public:
  ComputeEnergy(LAMMPS *lmp, int &iarg, int narg, char **arg)
      : Compute(lmp, iarg, narg, arg), instance_(Instance::of(lmp)) {
    if (iarg != narg || igroup != group->find("all"))
      error->all(FLERR,
                 "compute demlaws/energy: write  compute ID all demlaws/energy  (all contacts, no further words)");
    vector_flag = 1;
    size_vector = VALUES;
    extvector = 1;
    vector = new double[VALUES]();
    instance_->ledger.readers++;
  }
  ~ComputeEnergy() {
    Ledger &ledger = instance_->ledger;
    if (!--ledger.readers) ledger.taken = ledger.viscous = 0., ledger.counts_stored = false;
    delete[] vector;
  }
  void init() {
    if (!instance_->source) error->all(FLERR, "compute demlaws/energy needs pair_style gran model demlaws/table");
  }
  void compute_vector() {
    invoked_vector = update->ntimestep;
    const Ledger &ledger = instance_->ledger;
    double mine[VALUES] = {0., ledger.taken, ledger.viscous};
    instance_->source->energies(mine[0], mine[1]);
    if (ledger.step == update->ntimestep) {
      mine[0] += ledger.wall_stored;
      mine[1] += ledger.wall_pending;
    }
    MPI_Allreduce(mine, vector, VALUES, MPI_DOUBLE, MPI_SUM, world);
  }
  static Compute *create(LAMMPS *lmp, int iarg, int narg, char **arg) {
    return new ComputeEnergy(lmp, iarg, narg, arg);
  }

private:
  enum { VALUES = 3 };
  const std::shared_ptr<Instance> instance_;
};

// Takes the ledger's sums through restart files, reports the counts of a run, and looks for what would make contacts
// wrong silently. The plugin makes it; there is one.
class FixKept : public Fix {
public:
  FixKept(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg), instance_(Instance::of(lmp)) {
    restart_global = 1;
    instance_->ledger.taken = instance_->ledger.viscous = 0.;
  }
  ~FixKept() { instance_->ledger.taken = instance_->ledger.viscous = 0.; }
  int setmask() { return FixConst::PRE_FORCE; }
  void init() {
    refuse_new_numbers();
    keep_neighbour_lists();
    if (instance_->source) look_at_walls();
    else look_at_pairs();
  }
  void setup_pre_force(int vflag) {
    warn_of_thin_box();
    pre_force(vflag);
  }
  void pre_force(int) {
    Ledger &ledger = instance_->ledger;
    ledger.forget_walls();
    const bool moves = update->ntimestep > update->firststep, lacks = ledger.readers && !ledger.counts_stored;
    ledger.adds_stored = lacks && moves;
    ledger.lacks_stored = lacks && !moves;
    if (moves) ledger.counts_stored = ledger.readers;
  }
  void post_run() {
    double *const number = numbers();
    for (int i = 0; number && i < atom->nlocal; i++) number[i] = atom->tag[i];
    for (const std::string &line : instance_->counts.summaries(Mpi(lmp)))
      for (FILE *file : {screen, logfile})
        if (comm->me == 0 && file) fprintf(file, "%s\n", line.c_str());
  }
  void write_restart(FILE *file) {
    // `restart N` writes the histories as they were when neighbour lists were made, before the step that has just ended
    Fix *const histories = modify->find_fix_style_strict("contacthistory", 0);
    if (histories) histories->setup_pre_exchange();
    const Ledger &ledger = instance_->ledger;
    double kept[] = {ledger.taken, 0., ledger.viscous}, all[3];
    MPI_Reduce(kept, all, 3, MPI_DOUBLE, MPI_SUM, 0, world);
    if (comm->me != 0) return;
    all[1] = WITH_VISCOUS + ledger.counts_stored; // former files: `counts_stored`, and no third number
    std::copy(all, all + 3, kept);
    const int size = sizeof kept;
    fwrite(&size, sizeof size, 1, file);
    fwrite(kept, size, 1, file);
  }
  void restart(char *data) {
    double kept[3] = {};
    memcpy(kept, data, 2 * sizeof *kept);
    const bool viscous = kept[1] >= WITH_VISCOUS;
    if (viscous) memcpy(kept, data, sizeof kept);
    Ledger &ledger = instance_->ledger;
    if (comm->me == 0) ledger.taken = kept[0], ledger.viscous = kept[2];
    ledger.counts_stored = kept[1] - WITH_VISCOUS * viscous != 0.;
  }
  static Fix *create(LAMMPS *lmp, int narg, char **arg) { return new FixKept(lmp, narg, arg); }
  static const char *name() { return "demlaws/kept"; }

private:
  enum { WITH_VISCOUS = 2 };
  const std::shared_ptr<Instance> instance_;
  int page_ = -1, one_ = -1; // sizes in the run before

  // After `neigh_modify page` or `one` LIGGGHTS makes new neighbour lists at the start of every run, not of the next
  // one only, and contacts lose their history.
  void keep_neighbour_lists() {
    if (page_ == neighbor->pgsize) neighbor->old_pgsize = page_;
    if (one_ == neighbor->oneatom) neighbor->old_oneatom = one_;
    page_ = neighbor->pgsize;
    one_ = neighbor->oneatom;
  }

  void warn_of_thin_box() {
    const double reach = neighbor->cutneighmax - neighbor->skin;
    for (int k = 0; k < domain->dimension && instance_->source; k++)
      if (domain->periodicity[k] && domain->prd[k] < 2. * reach)
        return instance_->announce("thin box", thin_box(k, domain->prd[k], 2. * reach, "LIGGGHTS"));
  }

  // A wall whose line still has a stock model: its contacts have another law than the pairs.
  void look_at_walls() {
    for (int k = 0; k < modify->nfix; k++) {
      const Fix *const fix = modify->fix[k];
      if (strncmp(fix->style, "wall/gran", 9) != 0 || instance_->walls.count(fix->id)) continue;
      instance_->announce(
          fix->id, std::string("fix ") + fix->id +
                       " wall/gran has a model of LIGGGHTS, the pair style has demlaws/table: its contacts do not "
                       "follow the law; write 'model demlaws/table' at the wall, too (`demlaws liggghts convert`)");
    }
  }

  // Walls of ours beside a pair style of LIGGGHTS's models.
  void look_at_pairs() {
    if (instance_->walls.empty() || !force->pair_match("gran", 0)) return;
    instance_->announce("stock pairs",
                        "a fix wall/gran has demlaws/table, the pair style a model of LIGGGHTS: contacts between "
                        "particles do not follow the law; write 'pair_style gran model demlaws/table ...', too");
  }

  // The number that each particle had at the end of the last run; NULL before the first init.
  double *numbers() const {
    Fix *const fix = modify->find_fix_id("demlaws_numbers");
    return fix ? fix->vector_atom : NULL;
  }
  // LIGGGHTS finds a contact's history by the numbers of its particles, and `delete_atoms` deals new ones without
  // notice.
  void refuse_new_numbers() {
    const double *const number = numbers();
    if (!number) {
      const char *words[] = {
          "demlaws_numbers", "all", "property/atom", "demlaws_numbers", "scalar", "no", "no", "no", "0."};
      modify->add_fix(9, const_cast<char **>(words));
      return static_cast<FixPropertyAtom *>(modify->find_fix_id(words[0]))->set_internal();
    }
    if (!modify->find_fix_style_strict("contacthistory", 0)) return;
    for (int i = 0; i < atom->nlocal; i++)
      if (number[i] > 0. && (int)number[i] != atom->tag[i])
        error->one(FLERR, "model demlaws/table: delete_atoms gave particles new numbers, by which LIGGGHTS finds the "
                          "histories of contacts: write 'delete_atoms ... compress no'");
  }
};

// Makes the styles known to this instance of LIGGGHTS.
inline void register_styles(Modify *modify) {
  (*(modify->*pointer(ComputeMap())))["demlaws/energy"] = &ComputeEnergy::create;
  (*(modify->*pointer(FixMap())))[FixKept::name()] = &FixKept::create;
}

// Adds the fix where it is missing; in the first init at the latest, when what a restart file holds for it is still
// there.
inline void ensure_fix(Modify *modify) {
  if (modify->find_fix_style_strict(FixKept::name(), 0)) return;
  const char *words[] = {"demlaws_kept", "all", FixKept::name()};
  modify->add_fix(3, const_cast<char **>(words));
}

} // namespace demlaws
#endif
