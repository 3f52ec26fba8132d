// Granular sub-models of demlaws for a LAMMPS binary as it stands: no headers, no MPI, no symbol of LAMMPS is linked.
//
//   plugin load /path/demlawsplugin.so             (package PLUGIN), or LAMMPS_PLUGIN_PATH=/path
//   LD_PRELOAD=/path/demlawsplugin.so lmp ...      (any other)
//   pair_coeff * * demlaws/table granite.tbl 70e9 0.5 0.25 tangential mindlin NULL 1.0 0.5 damping demlaws/tangent
//   fix w all wall/gran granular demlaws/table granite.tbl 70e9 0.5 0.25 tangential mindlin NULL 1.0 0.5 zplane 0 NULL
//   compute e all demlaws/energy
//
// GranularModel::add_sub_model and construct_sub_model are where every granular style turns names into sub-models.
// LAMMPS reaches them, and the other functions below, through addresses that the linker filled in by name: preloaded,
// our functions of the same names come first; loaded later, their addresses are written there. Every one of them does
// what LAMMPS's own does for whatever is not of demlaws.
#include "demlaws_rule.h"
#include "demlaws_table.h"
#include "energy.h"
#include "numbers.h"
#include "range.h"
#include "slots.h"
#include "stock.h"
#include <cmath>
#include <memory>

namespace {

double number(void *error, const std::string &of, const char *text) {
  char *end;
  const double value = strtod(text, &end);
  if (end == text || *end || !(value - value == 0.))
    raise(error, true, "demlaws/table: " + of + " is '" + text + "', not a finite number");
  return value;
}

// Every table is read once and kept, as long as its file stays what it was. Rank 0 reads it and all ranks get it: one
// that cannot see the file, or sees another, neither hangs nor differs.
class Tables {
public:
  const demlaws::Table &get(const std::string &path, void *lmp, void *error) {
    const Ranks ranks(lmp, error);
    std::string data, problem;
    if (ranks.me == 0) {
      try {
        data = demlaws::Table::contents(path);
      } catch (const std::exception &caught) {
        problem = caught.what();
      }
    }
    ranks.share(problem);
    ranks.share(data);
    std::unique_ptr<demlaws::Table> &table = tables_[std::make_pair(path, demlaws::crc32(0, data.data(), data.size()))];
    if (problem.empty() && !table) {
      std::unique_ptr<demlaws::Table> fresh(new demlaws::Table);
      try {
        fresh->parse(data, path);
        table = std::move(fresh);
      } catch (const std::exception &caught) {
        problem = caught.what();
      }
    }
    if (!problem.empty()) raise(error, true, "demlaws/table: " + problem);
    problem = demlaws::attach_rule(*table); // each rank's own
    const std::vector<int> failed = ranks.gather((int)!problem.empty());
    for (size_t rank = 0; rank < failed.size(); rank++)
      if (failed[rank]) {
        std::ostringstream what;
        what << "demlaws/table: rank " << rank << ": ";
        if (problem.empty()) what << "it finds no " << path << ".so, or another than the table was written with";
        raise(error, true, what.str() + problem);
      }
    return *table;
  }

private:
  std::map<std::pair<std::string, uint32_t>, std::unique_ptr<demlaws::Table>> tables_;
};
Tables &tables() {
  static Tables all;
  return all;
}

#define DEMLAWS_LAYOUT early
#define DEMLAWS_SYNCHRONIZED 0
#include "granular_abi.h"
#include "granular_models.h"
#undef DEMLAWS_LAYOUT
#undef DEMLAWS_SYNCHRONIZED
#define DEMLAWS_LAYOUT late
#define DEMLAWS_SYNCHRONIZED 1
#include "granular_abi.h"
#include "granular_models.h"

int add_here(void *model, char **arg, int at, int count, int type);
void construct_here(void *model, const std::string &name, int type);
void init_here(void *model);
void *add_compute_here(void *modify, int count, char **arg, int suffix);
void pair_make_here(void *pair, void *lmp);
void pair_coeff_here(void *pair, int count, char **arg);
void pair_restart_here(void *pair, FILE *file);
void pair_init_here(void *pair);
void pair_forces_here(void *pair, int eflag, int vflag);
void wall_forces_here(void *wall, int vflag);
void region_forces_here(void *wall, int vflag);
void post_run_here(void *modify);
void delete_atoms_here(void *command, int count, char **arg);
void reset_atoms_here(void *command, int count, char **arg);

// LAMMPS's Force, which holds the constants of the units; NULL where it is not where it should be.
void *force_of(void *lmp) {
  std::vector<double> buffer(2048);
  const Stock &stock = Stock::get();
  early::Model *const m = (early::Model *)&buffer[0]; // what both begin with
  stock.make(m, lmp);
  char *const force = m->of.lmp == lmp && m->of.force ? *(char **)m->of.force : NULL;
  stock.unmake(m);
  const char *const constant = (const char *)stock.global(lmp, "nktv2p");
  return force && constant > force && constant < force + 1024 ? force : NULL;
}

enum Layout { UNKNOWN, EARLY, LATE, NONE };
Layout layout = UNKNOWN;
bool pairs_proved = false; // pairs of particles are computed here

void take_pairs();

// Finds the layout, or why there is none.
std::string prove(void *lmp) {
  const Stock &stock = Stock::get();
  if (layout == EARLY || layout == LATE) return "";
  std::string why;
  if (!stock.add) why = "it has no GranularModel (package GRANULAR of 2023 or later)";
  else if (!stock.missing.empty()) why = "it has no function " + stock.missing;
  else if (!force_of(lmp)) why = "the first members of its classes are other ones";
  else if (early::abi_fits(lmp, stock)) layout = EARLY;
  else if (late::abi_fits(lmp, stock)) layout = LATE;
  else why = "its granular models are laid out in another way than those of 4 Feb 2025 to 4 Jul 2026";
  if (why.empty()) {
    Here::look();
    pairs_proved = layout == LATE ? late::pairs_fit(lmp, stock) : early::pairs_fit(lmp, stock);
    if (pairs_proved) take_pairs();
    if (!pairs_proved && stock.setting(lmp, "world_rank") == 0)
      printf("demlaws: pairs of particles are computed by LAMMPS's own code\n");
    return "";
  }
  layout = NONE;
  return "demlaws cannot be added to this LAMMPS: " + why + "; nothing of it was changed";
}

Patch *patches() {
  static Patch all[] = {{DEMLAWS_ADD, (void *)&add_here, 0},
                        {DEMLAWS_CONSTRUCT, (void *)&construct_here, 0},
                        {DEMLAWS_INIT, (void *)&init_here, 0},
                        {DEMLAWS_ADD_COMPUTE, (void *)&add_compute_here, 0},
                        {DEMLAWS_PAIR_MAKE, (void *)&pair_make_here, 0},
                        {DEMLAWS_PAIR_COEFF, (void *)&pair_coeff_here, 0},
                        {DEMLAWS_PAIR_RESTART, (void *)&pair_restart_here, 0},
                        {DEMLAWS_PAIR_INIT, (void *)&pair_init_here, 0},
                        {DEMLAWS_PAIR_FORCES, (void *)&pair_forces_here, 0},
                        {DEMLAWS_WALL_FORCES, (void *)&wall_forces_here, 0},
                        {DEMLAWS_REGION_FORCES, (void *)&region_forces_here, 0},
                        {DEMLAWS_POST_RUN, (void *)&post_run_here, 0},
                        {DEMLAWS_DELETE, (void *)&delete_atoms_here, 0},
                        {DEMLAWS_RESET, (void *)&reset_atoms_here, 0},
                        {NULL, NULL, 0}};
  for (Patch *p = all; p->name; p++) p->slots = 0;
  return all;
}

// Redirects the functions; the name of one that LAMMPS calls directly (static or -Bsymbolic), and nothing changed then.
std::string install() {
  Patch *const all = patches();
  Slots::visit(all, false);
  for (Patch *p = all; p->name; p++)
    if (!p->slots)
      return std::string("demlaws cannot be added to this LAMMPS: it calls ") + p->name +
             " directly; nothing of it was changed";
  Slots::visit(all, true);
  return "";
}

// Pairs of particles: where LAMMPS calls these two functions directly it goes on to do so.
void take_pairs() {
  Patch pairs[] = {{DEMLAWS_CHECK, layout == LATE ? (void *)&late::check : (void *)&early::check, 0},
                   {DEMLAWS_COMPUTE, layout == LATE ? (void *)&late::compute : (void *)&early::compute, 0},
                   {NULL, NULL, 0}};
  Slots::visit(pairs, true);
  pairs_proved = pairs[0].slots && pairs[1].slots;
}

// Before anything of ours is made.
bool is_late(void *model) {
  if (layout == EARLY || layout == LATE) return layout == LATE;
  early::Model *const m = (early::Model *)model; // what both begin with
  void *const lmp = m->of.lmp, *const error = *m->of.error;
  const std::string why = prove(lmp);
  if (!why.empty()) {
    Slots::undo();
    raise(error, true, why);
  }
  return layout == LATE;
}

bool ours(const char *name, int type) {
  return (type == NORMAL && !strncmp(name, "demlaws/table", 13) && (!name[13] || name[13] == ' ')) ||
         (type == DAMPING && !strcmp(name, "demlaws/tangent"));
}

void need_metres(void *model) {
  early::Model *const m = (early::Model *)model;
  const char *const units = (const char *)Stock::get().global(m->of.lmp, "units");
  if (!units || strcmp(units, "si"))
    raise(*m->of.error, true, "demlaws: a table's length is in metres; use 'units si'");
}

// PairHybrid keeps room for the outputs that its styles had when they were made: more would be written beyond its end.
bool under_hybrid(void *model) {
  early::Model *const m = (early::Model *)model;
  try {
    return Stock::get().pair_match(*(void **)m->of.force, "^hybrid", 0, 0) != NULL;
  } catch (...) { // no pair style at all: a wall
    return false;
  }
}

int add_here(void *model, char **arg, int at, int count, int type) {
  if (at >= count || !ours(arg[at], type)) return Stock::get().add(model, arg, at, count, type);
  const bool is = is_late(model);
  need_metres(model);
  const bool outputs = !under_hybrid(model);
  return is ? late::add((late::Model *)model, arg, at, count, type, outputs)
            : early::add((early::Model *)model, arg, at, count, type, outputs);
}

// What the sub-models of a pair style keep in the history, one entry a pair_coeff line.
struct Histories {
  std::vector<std::vector<int>> sizes;
  bool ours, kept; // there are tables; with unloading of their own
  Histories() : ours(false), kept(false) {}
  static std::map<void *, Histories> &all() {
    static std::map<void *, Histories> histories;
    return histories;
  }
};
void *pair_now = NULL; // the pair style whose lines are being read

// A std::string by value is passed by its address.
void construct_here(void *model, const std::string &name, int type) {
  if (!ours(name.c_str(), type)) return Stock::get().construct(model, name, type);
  const bool is = is_late(model);
  need_metres(model);
  if (is) late::construct((late::Model *)model, name, type, !under_hybrid(model));
  else early::construct((early::Model *)model, name, type, !under_hybrid(model));
}

void init_here(void *model) {
  Stock::get().init(model);
  if (layout != EARLY && layout != LATE) return;
  if (layout == LATE) late::keep_signs((late::Model *)model);
  else early::keep_signs((early::Model *)model);
  if (layout == LATE) late::plan((late::Model *)model, pairs_proved);
  else early::plan((early::Model *)model, pairs_proved);
  if (!pair_now) return;
  Histories &kept = Histories::all()[pair_now];
  kept.sizes.push_back(layout == LATE ? late::sizes_of((late::Model *)model) : early::sizes_of((early::Model *)model));
  if (layout == LATE ? late::has_table((late::Model *)model) : early::has_table((early::Model *)model))
    kept.ours = true;
  if (layout == LATE ? late::keeps((late::Model *)model) : early::keeps((early::Model *)model)) kept.kept = true;
}

struct PairNow {
  explicit PairNow(void *pair) { pair_now = pair; }
  ~PairNow() { pair_now = NULL; }
};

void pair_make_here(void *pair, void *lmp) {
  Stock::get().pair_make(pair, lmp);
  prove(lmp); // preloaded, nobody asked before; the lines of stock models are to be counted, too
  Histories::all().erase(pair);
  Numbers::forget(lmp);
  Range::of(lmp) = Range();
}
void pair_coeff_here(void *pair, int count, char **arg) {
  PairNow now(pair);
  Stock::get().pair_coeff(pair, count, arg);
}
void pair_restart_here(void *pair, FILE *file) {
  PairNow now(pair);
  Stock::get().pair_restart(pair, file);
  // the cut-off of the pair style is not in the file, and LAMMPS leaves its memory as it was
  if (Histories::all()[pair].ours) Stock::get().pair_settings(pair, 0, NULL);
}
void pair_init_here(void *pair) {
  std::map<void *, Histories>::const_iterator kept = Histories::all().find(pair);
  if (kept != Histories::all().end() && kept->second.ours)
    for (size_t n = 1; n < kept->second.sizes.size(); n++)
      if (kept->second.sizes[n] != kept->second.sizes[0])
        raise(*((void ***)pair)[3], true,
              "demlaws/table: the pair_coeff lines keep different numbers of history values, which LAMMPS mixes up "
              "whenever "
              "neighbour lists are rebuilt; give every pair of types demlaws/table (Hertz is a table, too) and the "
              "same tangential, "
              "rolling and twisting models");
  Stock::get().pair_init(pair);
  Numbers::after_init(pair);
  if (kept != Histories::all().end() && kept->second.kept)
    Range::of(instance_of(pair)).look_across(instance_of(pair), *((void ***)pair)[3]);
}

// A position that is no number touches nothing: a particle with one would drop out of the model silently.
void check_positions(void *object) {
  void *const lmp = instance_of(object), *const error = *((void ***)object)[3];
  const Stock &stock = Stock::get();
  Range &range = Range::of(lmp);
  const void *const now = range.used ? stock.global(lmp, "ntimestep") : NULL;
  if (!now || *(const long long *)now == range.checked) return;
  range.checked = *(const long long *)now;
  const double *const *const x = (const double *const *)stock.atom(lmp, "x");
  const long count = 3 * (long)stock.setting(lmp, "nlocal");
  if (!x || !count) return;
  double sum[8] = {0., 0., 0., 0., 0., 0., 0., 0.};
  long k = 0;
  for (; k + 8 <= count; k += 8)
    for (int n = 0; n < 8; n++) sum[n] += 0. * x[0][k + n]; // 0, or no number for ever
  for (; k < count; k++) sum[0] += 0. * x[0][k];
  if (__builtin_expect(sum[0] + sum[1] + sum[2] + sum[3] + sum[4] + sum[5] + sum[6] + sum[7] == 0., 1)) return;
  const void *const tags = stock.atom(lmp, "id");
  const bool large = stock.setting(lmp, "tagint") == 8;
  for (k = 0; 3 * k < count; k++) {
    const double *const p = x[0] + 3 * k;
    if (0. * (p[0] + p[1] + p[2]) == 0.) continue;
    std::ostringstream what;
    what << "demlaws/table: particle " << (large ? ((const long long *)tags)[k] : ((const int *)tags)[k]) << " is at ("
         << p[0] << ", " << p[1] << ", " << p[2]
         << ") m, which is not finite; take a smaller time step, look at what was done to this particle";
    raise(error, false, what.str());
  }
}

void pair_forces_here(void *pair, int eflag, int vflag) {
  check_positions(pair);
  Ledger::of(instance_of(pair)).begin(NULL);
  Stock::get().pair_forces(pair, eflag, vflag);
}
void wall_forces_here(void *wall, int vflag) {
  check_positions(wall); // there may be no pair style
  Ledger &ledger = Ledger::of(instance_of(wall));
  ledger.begin(wall);
  Stock::get().wall_forces(wall, vflag);
  ledger.end();
}
void region_forces_here(void *wall, int vflag) {
  check_positions(wall); // there may be no pair style
  Ledger &ledger = Ledger::of(instance_of(wall));
  ledger.begin(wall);
  Stock::get().region_forces(wall, vflag);
  ledger.end();
}

void post_run_here(void *modify) {
  Stock::get().post_run(modify);
  Range::of(instance_of(modify)).tell(instance_of(modify), *((void ***)modify)[3]);
}

void delete_atoms_here(void *command, int count, char **arg) {
  Numbers::follow(Stock::get().delete_atoms, command, count, arg);
}
void reset_atoms_here(void *command, int count, char **arg) {
  Numbers::follow(Stock::get().reset_atoms, command, count, arg);
}

void *add_compute_here(void *modify, int count, char **arg, int suffix) {
  if (count < 3 || strcmp(arg[2], "demlaws/energy")) return Stock::get().add_compute(modify, count, arg, suffix);
  return Ledger::of(instance_of(modify)).add_compute(modify, count, arg, suffix);
}

// `import ctypes; ctypes.CDLL("demlawsplugin.so")` is enough where LAMMPS is loaded already; there is no instance to
// prove the layout on yet, so that is done when the first name of ours is met.
__attribute__((constructor)) void start() {
  if (!Stock::get().add) return;
  const std::string why = install();
  if (!why.empty()) fprintf(stderr, "%s\n", why.c_str());
}

} // namespace

extern "C" {
#define EXPORTED __attribute__((visibility("default")))
EXPORTED int demlaws_add(void *, char **, int, int, int) __asm__(DEMLAWS_ADD);
EXPORTED void demlaws_construct(void *, std::string, int) __asm__(DEMLAWS_CONSTRUCT);
EXPORTED void demlaws_init(void *) __asm__(DEMLAWS_INIT);
EXPORTED void *demlaws_add_compute(void *, int, char **, int) __asm__(DEMLAWS_ADD_COMPUTE);
EXPORTED void demlaws_pair_make(void *, void *) __asm__(DEMLAWS_PAIR_MAKE);
EXPORTED void demlaws_pair_coeff(void *, int, char **) __asm__(DEMLAWS_PAIR_COEFF);
EXPORTED void demlaws_pair_restart(void *, FILE *) __asm__(DEMLAWS_PAIR_RESTART);
EXPORTED void demlaws_pair_init(void *) __asm__(DEMLAWS_PAIR_INIT);
EXPORTED void demlaws_pair_forces(void *, int, int) __asm__(DEMLAWS_PAIR_FORCES);
EXPORTED void demlaws_wall_forces(void *, int) __asm__(DEMLAWS_WALL_FORCES);
EXPORTED void demlaws_region_forces(void *, int) __asm__(DEMLAWS_REGION_FORCES);
EXPORTED void demlaws_post_run(void *) __asm__(DEMLAWS_POST_RUN);
EXPORTED void demlaws_delete_atoms(void *, int, char **) __asm__(DEMLAWS_DELETE);
EXPORTED void demlaws_reset_atoms(void *, int, char **) __asm__(DEMLAWS_RESET);
EXPORTED bool demlaws_check(void *) __asm__(DEMLAWS_CHECK);
EXPORTED void demlaws_compute(void *) __asm__(DEMLAWS_COMPUTE);
EXPORTED void lammpsplugin_init(void *, void *, void *);
}

int demlaws_add(void *model, char **arg, int at, int count, int type) { return add_here(model, arg, at, count, type); }
void demlaws_construct(void *model, std::string name, int type) { construct_here(model, name, type); }
void demlaws_init(void *model) { init_here(model); }
void *demlaws_add_compute(void *modify, int count, char **arg, int suffix) {
  return add_compute_here(modify, count, arg, suffix);
}
void demlaws_pair_make(void *pair, void *lmp) { pair_make_here(pair, lmp); }
void demlaws_pair_coeff(void *pair, int count, char **arg) { pair_coeff_here(pair, count, arg); }
void demlaws_pair_restart(void *pair, FILE *file) { pair_restart_here(pair, file); }
void demlaws_pair_init(void *pair) { pair_init_here(pair); }
void demlaws_pair_forces(void *pair, int eflag, int vflag) { pair_forces_here(pair, eflag, vflag); }
void demlaws_wall_forces(void *wall, int vflag) { wall_forces_here(wall, vflag); }
void demlaws_region_forces(void *wall, int vflag) { region_forces_here(wall, vflag); }
void demlaws_post_run(void *modify) { post_run_here(modify); }
void demlaws_delete_atoms(void *command, int count, char **arg) { delete_atoms_here(command, count, arg); }
void demlaws_reset_atoms(void *command, int count, char **arg) { reset_atoms_here(command, count, arg); }
bool demlaws_check(void *model) { return Stock::get().check(model); } // until take_pairs()
void demlaws_compute(void *model) { Stock::get().compute(model); }

// What `plugin load` and LAMMPS_PLUGIN_PATH call. The layout is proved first: a LAMMPS that does not fit is left alone.
void lammpsplugin_init(void *lmp, void *, void *) {
  std::string why = prove(lmp);
  if (why.empty()) why = install();
  else Slots::undo();
  const Stock &stock = Stock::get();
  if (stock.setting && stock.setting(lmp, "world_rank") != 0) return;
  if (why.empty()) printf("Loading plugin: granular demlaws/table\n");
  else fprintf(stderr, "WARNING: %s\n", why.c_str());
}
