// What left the range of its law in one instance of LAMMPS (demlaws_range.h): reported at once, counted for each run.
#ifndef DEMLAWS_REPORTS_H
#define DEMLAWS_REPORTS_H

#include "ranks.h"
#include <cstring>
#include <map>

namespace {

const char *const MIXED_SIZES =
    "demlaws/table: the pair_coeff lines, those of a restart file included, keep different numbers of history values, "
    "which LAMMPS mixes up whenever neighbour lists are rebuilt; give every pair of types demlaws/table (Hertz is a "
    "table, too) and the same tangential, rolling and twisting models; after a restart file of other models start "
    "again from positions (write_data, read_data)";

// The number of this rank's particle at place i.
inline long long tag_of(void *lmp, long i) {
  const void *const tags = Stock::get().atom(lmp, "id");
  if (!tags) return i;
  return Stock::get().setting(lmp, "tagint") == 8 ? ((const long long *)tags)[i] : ((const int *)tags)[i];
}

// Whether delete_atoms, with these words, leaves the particles their numbers.
inline bool keeps_numbers(int count, char **arg) {
  bool keeps = false;
  for (int n = 1; n < count; n++)
    if (!strcmp(arg[n - 1], "compress")) keeps = !strcmp(arg[n], "no");
  return keeps;
}

// The pairs of types of a pair_coeff line, each with the lower type first; none: by labels.
typedef std::set<std::pair<int, int>> TypePairs;
inline bool range_of_types(const char *text, int most, int &low, int &high) {
  const char *const star = strchr(text, '*');
  char *end;
  low = high = star == text ? 1 : (int)strtol(text, &end, 10);
  if (star != text && (end == text || (star ? end != star : *end))) return false;
  if (!star) return true;
  high = star[1] ? (int)strtol(star + 1, &end, 10) : most;
  return !star[1] || !*end;
}
inline TypePairs pairs_of(const char *first, const char *second, int most) {
  TypePairs pairs;
  int low[2], high[2];
  if (range_of_types(first, most, low[0], high[0]) && range_of_types(second, most, low[1], high[1]))
    for (int i = low[0]; i <= high[0]; i++)
      for (int j = std::max(i, low[1]); j <= high[1]; j++) pairs.insert(std::make_pair(i, j));
  return pairs;
}

// Of one instance of LAMMPS.
struct Range {
  void *lmp = NULL;
  demlaws::Counts counts;
  int tables = 0;            // of this instance, pairs' and walls'
  bool has_contacts = false; // forces were computed, or a restart file was read
  long long checked = -1;    // the step in which positions were checked

  static Range &of(void *lmp) {
    static std::map<void *, Range> &all = *new std::map<void *, Range>; // models may outlive what is static
    Range &one = all[lmp];
    one.lmp = lmp;
    return one;
  }
  bool used() const { return tables > 0; }
  // Where the last table goes, as with `clear`: nothing that was kept is of what follows.
  void drop_table() {
    if (--tables == 0) *this = Range();
  }
  // For another pair style: walls keep their tables.
  void renew() {
    const int kept = tables;
    *this = Range();
    tables = kept;
  }
  // On whatever rank the contact is: LAMMPS shows only what rank 0 warns of.
  void warn(const std::string &text) const {
    const Stock &stock = Stock::get();
    if (stock.setting(lmp, "world_rank") == 0 && stock.warn) stock.warn(error_of(lmp), "demlaws", 0, text);
    else fprintf(stderr, "WARNING: %s\n", text.c_str());
  }
  // Once, of what all ranks know: rank 0 says it.
  void announce(const std::string &what, const std::string &text) {
    if (counts.reported.insert(what).second && Stock::get().setting(lmp, "world_rank") == 0) warn(text);
  }
  // At the end of a run, on all ranks: the sums.
  void print_counts() {
    if (!used()) return;
    const Ranks ranks(lmp);
    for (const std::string &line : counts.summaries(ranks))
      if (ranks.me == 0) warn(line);
  }

  // A wall whose line has this normal model.
  void look_at_wall(const std::string &model) {
    if (used() && model != "demlaws/table" && counts.reported.insert("wall " + model).second)
      warn("a fix wall/gran has the stock model " + model +
           ", other contacts demlaws/table: contacts with this wall do not follow the law; write "
           "'granular demlaws/table FILE E eta nu ...' at the wall, too (`demlaws lammps convert`)");
  }

  // A pair style of granular models without one of ours.
  void look_at_pairs() {
    if (used())
      announce(
          "stock pairs",
          "a fix wall/gran has demlaws/table, the pairs stock models: contacts between particles do not follow the "
          "law; write 'pair_coeff * * demlaws/table FILE E eta nu ...', too (models of a restart file are those of "
          "the run that wrote it)");
  }
  // rerun: LAMMPS computes each frame as the set-up of a run, which leaves histories as they are.
  void look_at_frames() {
    if (used())
      announce("rerun",
               "rerun: contacts of every frame have the plastic overlap and shear that they have now, before the first "
               "frame (none in an input without a run: first loading), not those of the frame: dump forces and p13, "
               "p14 in the run itself");
  }

  // run_style respa: LAMMPS computes displacements of shear with the step of the outermost level.
  void refuse_respa() const {
    const int *const levels = (const int *)Stock::get().global(lmp, "respa_levels");
    if (levels && *levels > 1)
      raise(lmp, true, "demlaws/table: run_style respa would multiply shear by its steps: write run_style verlet");
  }

  // A position that is not a number touches nothing: a particle with one would drop out of the model silently.
  void check_positions() {
    const Stock &stock = Stock::get();
    const void *const now = used() ? stock.global(lmp, "ntimestep") : NULL;
    if (!now || *(const long long *)now == checked) return;
    checked = *(const long long *)now;
    has_contacts = true;
    const double *const *const x = (const double *const *)stock.atom(lmp, "x");
    const long local = stock.setting(lmp, "nlocal");
    for (long k = 0; x && k < local; k++) {
      const double *const p = x[k];
      if (__builtin_expect(0. * (p[0] + p[1] + p[2]) == 0., 1)) continue;
      std::ostringstream what;
      what << "demlaws/table: particle " << tag_of(lmp, k) << " is at (" << p[0] << ", " << p[1] << ", " << p[2]
           << ") m, which is not finite; take a smaller time step, look at what was done to this particle";
      raise(lmp, false, what.str());
    }
  }

  // LAMMPS finds the history of a contact by the number of the partner: with new numbers contacts would begin again,
  // or go on with the history of others.
  void keep_numbers() const {
    if (has_contacts)
      raise(lmp, true,
            "demlaws/table: contacts would lose their histories, which LAMMPS finds by the numbers of the particles: "
            "write 'delete_atoms ... compress no', and 'reset_atoms id' before the first run");
  }

  void warn_of_thin_box() {
    const Stock &stock = Stock::get();
    const int *const periodic = (const int *)stock.global(lmp, "periodicity");
    if (!periodic) return;
    const double *const radius = (const double *)stock.atom(lmp, "radius");
    const int local = radius ? stock.setting(lmp, "nlocal") : 0;
    const std::vector<double> all = Ranks(lmp).gather(local ? *std::max_element(radius, radius + local) : 0.);
    const double reach = 2. * *std::max_element(all.begin(), all.end());
    static const char *const ends[3][2] = {{"boxxlo", "boxxhi"}, {"boxylo", "boxyhi"}, {"boxzlo", "boxzhi"}};
    for (int k = 0; k < stock.setting(lmp, "dimension"); k++) {
      const double *const low = (const double *)stock.global(lmp, ends[k][0]);
      const double *const high = (const double *)stock.global(lmp, ends[k][1]);
      if (!periodic[k] || !low || !high || *high - *low >= 2. * reach) continue;
      return announce("thin box", demlaws::thin_box(k, *high - *low, 2. * reach, "LAMMPS"));
    }
  }
};

} // namespace
#endif
