// Granular sub-models of demlaws compiled with LAMMPS (releases from 4 Feb 2025 on): the models of its plugin,
// demlaws_models.h, with LAMMPS's own classes. Licence: GPL-2.0-or-later.
//
// LAMMPS takes only numbers as coefficients. An input line is the plugin's all the same,
//   demlaws/table FILE E eta nu [keyword value ...]
// because the sub-model, while it is made, reads the words of its line itself, from Input, and has LAMMPS read as many
// zeros. In restart files numbers hold the name of the file.
#include "gran_sub_mod_demlaws.h"

#include "compute_demlaws_energy.h"
#include "fix_demlaws.h"
#include "fix_neigh_history.h"
#include "fix_wall_gran.h"
#include "force.h"
#include "input.h"
#include "pair_granular.h"
#include "update.h"

#include "demlaws_models.h"

#include <limits>

using namespace LAMMPS_NS;
using namespace Granular_NS;

typedef Granular<Abi> Models;

static const char READ[] =
    "demlaws/table"; // the keyword of a line that was read, which may have another model behind it

// PairHybrid keeps room for the outputs that its styles had when they were made: more would be written beyond its end.
static bool has_outputs(LAMMPS *lmp) {
  return !lmp->force->pair || !utils::strmatch(lmp->force->pair_style, "^hybrid");
}

// --- commands that give particles new numbers, or contacts no history

static std::map<std::string, Input::CommandCreator> unguarded;

template <bool DELETES> static Command *guarded(LAMMPS *lmp) {
  Input *const input = lmp->input;
  if (!DELETES || !keeps_numbers(input->narg, input->arg)) Range::of(lmp).keep_numbers();
  return unguarded[DELETES ? "delete_atoms" : "RESET_ATOMS_ID"](lmp);
}
static Command *announced(LAMMPS *lmp) {
  Range::of(lmp).look_at_frames();
  return unguarded["rerun"](lmp);
}
static void guard(LAMMPS *lmp, const char *name, Input::CommandCreator creator) {
  Input::CommandCreator &known = (*lmp->input->command_map)[name];
  if (!known || known == creator) return;
  unguarded[name] = known;
  known = creator;
}

// --- the normal model

GranSubModNormalDemlaws::GranSubModNormalDemlaws(GranularModel *model, LAMMPS *lmp) : GranSubModNormal(model, lmp) {
  if (strcmp(update->unit_style, "si")) error->all(FLERR, "demlaws: a table's length is in metres; use 'units si'");
  num_coeffs = Models::Table::NUMBERS;
  char **const arg = input->arg;
  for (int n = 0; n < input->narg; n++)
    if (arg[n] != READ && !strcmp(arg[n], READ)) {
      read_line(arg, n, input->narg);
      break;
    }
}

// The model's own words, from arg[at] on: LAMMPS is to read a zero for each.
void GranSubModNormalDemlaws::read_line(char **arg, int at, int narg) {
  static char zero[] = "0";
  arg[at++] = const_cast<char *>(READ);
  int end = at;
  file = Words<Models::Table>::read_material(lmp, arg, end, narg, material);
  options.assign(Models::Table::COEFFICIENTS, std::numeric_limits<double>::quiet_NaN());
  options[Models::Table::YOUNG] = material[0];
  options[Models::Table::POISSON] = material[2];
  end = Words<Models::Table>::read_options(lmp, arg, end, narg, options.data());
  num_coeffs = end - at;
  for (; at < end; at++) {
    words.emplace_back(arg + at, arg[at]);
    arg[at] = zero;
  }
}

void GranSubModNormalDemlaws::coeffs_to_local() {
  for (const auto &word : words) *word.first = word.second;
  const bool typed = !words.empty();
  if (!typed) file = Models::Table::file_of(coeffs);
  Models::Table *const table = Models::set_table(gm, lmp, file, has_outputs(lmp));
  if (typed) {
    std::copy(material, material + 3, table->coeffs);
    table->check_order();
    for (size_t n = 0; n < options.size(); n++)
      if (options[n] == options[n]) table->coeffs[n] = options[n];
  } else std::copy(coeffs, coeffs + num_coeffs, table->coeffs);
  table->coeffs_to_local();

  if (!strcmp(input->command, "read_restart")) {
    Range::of(lmp).has_contacts = true;
    // the cut-off of the pair style is not in the file, and LAMMPS leaves its memory as it was
    PairGranular *const pair = dynamic_cast<PairGranular *>(force->pair);
    if (pair) pair->settings(0, nullptr);
  }
  guard(lmp, "delete_atoms", &guarded<true>);
  guard(lmp, "RESET_ATOMS_ID", &guarded<false>);
  guard(lmp, "rerun", &announced);
  if (!modify->get_compute_by_id("DEMLAWS")) modify->add_compute("DEMLAWS all DEMLAWS");
  delete this;
}

void GranSubModNormalDemlaws::mix_coeffs(double *a, double *b) {
  Models::set_mixed(gm, lmp, a, b, has_outputs(lmp));
  delete this;
}

// --- damping and the tangential model

GranSubModDampingDemlaws::GranSubModDampingDemlaws(GranularModel *model, LAMMPS *lmp) : GranSubModDamping(model, lmp) {}

void GranSubModDampingDemlaws::coeffs_to_local() {
  Models::Tangent *const made = new Models::Tangent(gm, name);
  gm->sub_models[DAMPING] = gm->damping_model = made;
  delete this;
}

GranSubModTangentialDemlaws::GranSubModTangentialDemlaws(GranularModel *model, LAMMPS *lmp)
    : GranSubModTangential(model, lmp) {
  num_coeffs = Models::ShearModel::COEFFICIENTS;
  double checked[Models::ShearModel::COEFFICIENTS]; // by LAMMPS, too, but in other words
  for (int n = 1; n < input->narg; n++)
    if (!strcmp(input->arg[n - 1], "tangential") && !strcmp(input->arg[n], "demlaws"))
      Models::ShearModel::read(lmp, input->arg, n + 1, input->narg, checked);
}

void GranSubModTangentialDemlaws::coeffs_to_local() {
  Models::ShearModel *const made = new Models::ShearModel(gm, name);
  std::copy(coeffs, coeffs + num_coeffs, made->coeffs);
  gm->sub_models[TANGENTIAL] = gm->tangential_model = made;
  made->coeffs_to_local();
  made->set_history_size();
  delete this;
}

// --- compute demlaws/energy

ComputeDemlawsEnergy::ComputeDemlawsEnergy(LAMMPS *lmp, int narg, char **arg) : Compute(lmp, narg, arg) {
  char *const words[] = {arg[0], arg[1], arg[2]};
  Ledger::of(lmp).open(narg, const_cast<char **>(words));
  vector_flag = extvector = 1;
  size_vector = 3;
  vector = new double[size_vector];
}
ComputeDemlawsEnergy::~ComputeDemlawsEnergy() { delete[] vector; }
void ComputeDemlawsEnergy::init() { Ledger::of(lmp).ask_pairs(); }
void ComputeDemlawsEnergy::compute_vector() {
  invoked_vector = update->ntimestep;
  double mine[3];
  for (int n = 0; n < 3; n++) mine[n] = Ledger::of(lmp).share(n);
  MPI_Allreduce(mine, vector, 3, MPI_DOUBLE, MPI_SUM, world);
}

// --- before, during and after a run

void ComputeDemlaws::init() {
  if (!modify->get_fix_by_id("DEMLAWS")) modify->add_fix("DEMLAWS all DEMLAWS");
}

FixDemlaws::~FixDemlaws() { Range::of(lmp).renew(); }

int FixDemlaws::setmask() { return FixConst::PRE_FORCE | FixConst::MIN_PRE_FORCE; }

void FixDemlaws::init() {
  Range &range = Range::of(lmp);
  range.refuse_respa();
  PairGranular *pair = nullptr, *last;
  for (int n = 1;; n++) { // of hybrid there may be several
    last = pair;
    pair = dynamic_cast<PairGranular *>(force->pair_match("granular", 0, n));
    if (!pair || pair == last) break;
    bool ours = false, equal = true;
    for (int k = 0; k < pair->nmodels; k++) {
      ours = ours || dynamic_cast<Models::Table *>(pair->models_list[k]->normal_model);
      for (int type = 0; type < NSUBMODELS; type++)
        equal = equal && pair->models_list[k]->sub_models[type]->size_history ==
                             pair->models_list[0]->sub_models[type]->size_history;
    }
    if (ours && !equal) error->all(FLERR, MIXED_SIZES);
    if (ours) range.warn_of_thin_box();
    else if (pair->nmodels) range.look_at_pairs();
  }
  // its lists mark no contacts: FixNeighHistory would drop all histories whenever lists are built
  Pair *const surfaces = force->pair_match("surf/granular", 0);
  for (Fix *const fix : modify->get_fix_by_style("^NEIGH_HISTORY")) {
    FixNeighHistory *const kept = dynamic_cast<FixNeighHistory *>(fix);
    if (surfaces && kept && kept->pair == surfaces) kept->use_bit_flag = 0;
  }
  for (Fix *const fix : modify->get_fix_by_style("^wall/gran")) {
    FixWallGran *const wall = dynamic_cast<FixWallGran *>(fix);
    if (wall) range.look_at_wall(wall->model->normal_model->name);
  }
}

void FixDemlaws::setup_pre_force(int) {
  Range::of(lmp).check_positions();
  Ledger::of(lmp).begin(NULL);
}

void FixDemlaws::post_run() { Range::of(lmp).print_counts(); }
