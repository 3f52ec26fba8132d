// compute demlaws/energy, and the fixes that the plugin adds by itself: sums, tables and particle numbers that outlive
// a run.
#ifndef DEMLAWS_ENERGY_H
#define DEMLAWS_ENERGY_H
#include "stock.h"

#include "instance.h"
#include <algorithm>
#include <cstdio>

namespace demlaws {

// Names a private member: an explicit instantiation may.
template <class TAG, typename TAG::type MEMBER> struct Access {
  friend typename TAG::type get(TAG) { return MEMBER; }
};
// where a style is registered at run time
struct ComputeMap {
  typedef std::map<std::string, Compute *(*)(LAMMPS *, int, int, char **)> *Modify::*type;
  friend type get(ComputeMap);
};
template struct Access<ComputeMap, &Modify::compute_map>;
struct FixMap {
  typedef std::map<std::string, Fix *(*)(LAMMPS *, int, char **)> *Modify::*type;
  friend type get(FixMap);
};
template struct Access<FixMap, &Modify::fix_map>;
// numbers of the particles that each particle touches
struct Partners {
  typedef int **FixContactHistory::*type;
  friend type get(Partners);
};
template struct Access<Partners, &FixContactHistory::partner_>;

// A number kept for each particle, which moves with it; NULL where nothing keeps it.
inline double *kept_for_particles(Modify *modify, const char *name) {
  Fix *const fix = modify->find_fix_id(name);
  return fix ? fix->vector_atom : NULL;
}
inline void keep_for_particles(Modify *modify, const char *name, bool in_restart_files) {
  if (modify->find_fix_id(name)) return;
  const char *words[] = {name, "all", "property/atom", name, "scalar", in_restart_files ? "yes" : "no", "no",
                         "no", "0."};
  modify->add_fix(9, const_cast<char **>(words));
  static_cast<FixPropertyAtom *>(modify->find_fix_id(name))->set_internal();
}

// compute ID GROUP demlaws/energy: stored and dissipated energy of the contacts of the group's particles,
// [1] and [2], pairs and walls. Each particle of a pair has half.
class ComputeEnergy : public Compute {
public:
  ComputeEnergy(LAMMPS *lmp, int &iarg, int narg, char **arg)
      : Compute(lmp, iarg, narg, arg), instance_(Instance::of(lmp)) {
    if (iarg != narg) error->all(FLERR, "compute demlaws/energy takes no arguments");
    vector_flag = 1;
    size_vector = 2;
    extvector = 1;
    vector = new double[2]();
    instance_->ledger.readers++;
    if (igroup != group->find("all")) keep_for_particles(modify, taken(), true);
  }
  ~ComputeEnergy() {
    instance_->ledger.readers--;
    delete[] vector;
  }
  void init() {
    if (!instance_->source) error->all(FLERR, "compute demlaws/energy needs pair_style gran model demlaws/table");
  }
  void compute_vector() {
    invoked_vector = update->ntimestep;
    const bool everyone = igroup == group->find("all");
    double mine[2] = {0., 0.};
    instance_->source->energies(everyone ? ~0 : groupbit, mine[0], mine[1]);
    const Ledger &ledger = instance_->ledger;
    if (everyone) mine[1] += ledger.taken;
    else {
      const double *const taken_of = kept_for_particles(modify, taken());
      for (int i = 0; i < atom->nlocal; i++)
        if (atom->mask[i] & groupbit) mine[1] += taken_of[i];
    }
    for (const Ledger::WallContact &contact : ledger.at_walls) {
      if (ledger.step != update->ntimestep || !(everyone || (atom->mask[contact.particle] & groupbit))) continue;
      mine[0] += contact.stored;
      mine[1] += contact.pending;
    }
    MPI_Allreduce(mine, vector, 2, MPI_DOUBLE, MPI_SUM, world);
  }
  static Compute *create(LAMMPS *lmp, int iarg, int narg, char **arg) {
    return new ComputeEnergy(lmp, iarg, narg, arg);
  }
  static const char *taken() { return "demlaws_taken"; }

private:
  const std::shared_ptr<Instance> instance_;
};

// Takes the ledger's sum through restart files, reports the counts of a run, and keeps the histories with their
// contacts where delete_atoms gives the particles new numbers. The plugin makes it; there is one.
class FixEnergy : public Fix {
public:
  FixEnergy(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg), instance_(Instance::of(lmp)) {
    restart_global = 1;
    instance_->ledger.taken = 0.;
  }
  ~FixEnergy() { instance_->ledger.taken = 0.; }
  int setmask() { return FixConst::PRE_FORCE; }
  void init() {
    keep_for_particles(modify, numbers(), false);
    follow_new_numbers();
    keep_neighbour_lists();
    if (instance_->source) look_at_walls();
  }
  void setup_pre_force(int vflag) {
    look_across();
    pre_force(vflag);
  }
  void pre_force(int) {
    Ledger &ledger = instance_->ledger;
    ledger.taken_of = kept_for_particles(modify, ComputeEnergy::taken()); // it grows with the number of particles
    ledger.at_walls.clear();
  }
  void post_run() {
    double *const number = kept_for_particles(modify, numbers());
    for (int i = 0; number && i < atom->nlocal; i++) number[i] = atom->tag[i];
    for (const std::string &line : instance_->counts.summaries(Mpi(lmp)))
      for (FILE *file : {screen, logfile})
        if (comm->me == 0 && file) fprintf(file, "%s\n", line.c_str());
  }
  void write_restart(FILE *file) {
    double sum = 0.;
    MPI_Reduce(&instance_->ledger.taken, &sum, 1, MPI_DOUBLE, MPI_SUM, 0, world);
    if (comm->me != 0) return;
    const int size = sizeof sum;
    fwrite(&size, sizeof size, 1, file);
    fwrite(&sum, sizeof sum, 1, file);
  }
  void restart(char *data) {
    if (comm->me == 0) memcpy(&instance_->ledger.taken, data, sizeof instance_->ledger.taken);
  }
  static Fix *create(LAMMPS *lmp, int narg, char **arg) { return new FixEnergy(lmp, narg, arg); }
  static const char *name() { return "demlaws/energy"; }
  static const char *numbers() { return "demlaws_numbers"; }

private:
  const std::shared_ptr<Instance> instance_;
  bool told_ = false;
  int page_ = -1, one_ = -1; // sizes in the run before

  // After `neigh_modify page` or `one` LIGGGHTS makes new neighbour lists at the start of every run, not of the next
  // one only, and contacts lose their history.
  void keep_neighbour_lists() {
    if (page_ == neighbor->pgsize) neighbor->old_pgsize = page_;
    if (one_ == neighbor->oneatom) neighbor->old_oneatom = one_;
    page_ = neighbor->pgsize;
    one_ = neighbor->oneatom;
  }

  void look_across() {
    bool keeps = false;
    for (const auto &one : instance_->pair.tables) keeps = keeps || state_size(one.second->unloading()) > 0;
    const double reach = neighbor->cutneighmax - neighbor->skin;
    for (int k = 0; k < domain->dimension && keeps && !told_; k++) {
      if (!domain->periodicity[k] || domain->prd[k] >= 2. * reach) continue;
      told_ = true;
      if (comm->me == 0) error->warning(FLERR, thin_box(k, domain->prd[k], 2. * reach, "LIGGGHTS").c_str());
    }
  }

  // A wall whose line still has a stock model: its contacts have another law than the pairs.
  void look_at_walls() {
    for (int k = 0; k < modify->nfix; k++) {
      const Fix *const fix = modify->fix[k];
      if (strncmp(fix->style, "wall/gran", 9) != 0 || instance_->walls.count(fix->id)) continue;
      const std::string what =
          std::string("fix ") + fix->id + " wall/gran has a model of LIGGGHTS, the pair style has " +
          "demlaws/table: its contacts do not follow the law; write 'model demlaws/table' at the " +
          "wall, too (`demlaws liggghts convert`)";
      if (instance_->counts.reported.insert(what).second && comm->me == 0) error->warning(FLERR, what.c_str());
    }
  }

  // LIGGGHTS finds a contact's history by the numbers of its particles, and `delete_atoms ... compress yes` deals new
  // ones without notice. The number that each particle had at the end of the last run tells which is which.
  void follow_new_numbers() {
    double *const number = kept_for_particles(modify, numbers());
    const Mpi ranks(lmp);
    std::vector<int> mine; // old and new number of each particle
    int changed = 0;
    for (int i = 0; i < atom->nlocal; i++)
      if (number[i] > 0.) {
        mine.push_back((int)number[i]);
        mine.push_back(atom->tag[i]);
        changed |= (int)number[i] != atom->tag[i];
      }
    const std::vector<int> any = ranks.gather(changed);
    if (std::count(any.begin(), any.end(), 0) == ranks.count) return;
    const std::vector<int> all = ranks.join(mine);
    std::map<int, int> renamed;
    for (size_t k = 0; k < all.size(); k += 2) renamed[all[k]] = all[k + 1];
    FixContactHistory *const history =
        static_cast<FixContactHistory *>(modify->find_fix_style_strict("contacthistory", 0));
    if (history) {
      int **const partner = history->*get(Partners());
      for (int i = 0; i < atom->nlocal; i++)
        for (int n = 0; n < history->n_partner(i); n++) {
          std::map<int, int>::const_iterator it = renamed.find(partner[i][n]);
          partner[i][n] =
              it == renamed.end() ? -1 : it->second; // -1: a deleted particle, whose number may be given again
        }
    }
    for (int i = 0; i < atom->nlocal; i++) number[i] = atom->tag[i];
    if (comm->me == 0)
      error->warning(FLERR,
                     "model demlaws/table: particles were given new numbers (delete_atoms compress yes): the contacts' "
                     "histories follow them");
  }
};

// Takes the fingerprints of the tables through restart files, of the pair style and of each wall.
class FixTables : public Fix {
public:
  FixTables(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg), instance_(Instance::of(lmp)) {
    restart_global = 1;
  }
  int setmask() { return 0; }
  void write_restart(FILE *file) {
    if (comm->me != 0) return;
    std::ostringstream text;
    for (const auto &owner : instance_->used)
      for (const auto &print : owner.second)
        text << print.first.first << ' ' << print.first.second << ' ' << print.second << ' ' << owner.first << '\n';
    const std::string written = text.str();
    const int size = (int)written.size() + 1;
    fwrite(&size, sizeof size, 1, file);
    fwrite(written.c_str(), 1, size, file);
  }
  void restart(char *data) {
    std::istringstream text(data);
    std::string line;
    while (std::getline(text, line)) {
      std::istringstream words(line);
      Types types;
      uint32_t fingerprint;
      std::string owner;
      if (words >> types.first >> types.second >> fingerprint && std::getline(words >> std::ws, owner))
        instance_->stored[owner][types] = fingerprint;
    }
  }
  static Fix *create(LAMMPS *lmp, int narg, char **arg) { return new FixTables(lmp, narg, arg); }
  static const char *name() { return "demlaws/tables"; }

private:
  const std::shared_ptr<Instance> instance_;
};

// Makes the styles known to this instance of LIGGGHTS.
inline void register_styles(Modify *modify) {
  (*(modify->*get(ComputeMap())))[FixEnergy::name()] = &ComputeEnergy::create;
  (*(modify->*get(FixMap())))[FixEnergy::name()] = &FixEnergy::create;
  (*(modify->*get(FixMap())))[FixTables::name()] = &FixTables::create;
}

// Adds the fixes where they are missing; in the first init, when what a restart file holds for them is still there.
inline void ensure_fixes(Modify *modify) {
  static const char *const fixes[][2] = {{"demlaws_energy", FixEnergy::name()}, {"demlaws_tables", FixTables::name()}};
  for (const auto &fix : fixes)
    if (!modify->find_fix_style_strict(fix[1], 0)) {
      const char *words[] = {fix[0], "all", fix[1]};
      modify->add_fix(3, const_cast<char **>(words));
    }
}

} // namespace demlaws
#endif
