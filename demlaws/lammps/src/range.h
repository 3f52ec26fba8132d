// What left the range of its law in one instance of LAMMPS (demlaws_range.h): reported at once, counted for each run.
#ifndef DEMLAWS_REPORTS_H
#define DEMLAWS_REPORTS_H

#include "ranks.h"
#include <map>

namespace {

// Of one instance of LAMMPS.
struct Range {
  demlaws::Counts counts;
  bool used = false;         // there is a table
  bool has_contacts = false; // forces were computed, or a restart file was read
  long long checked = -1;    // the step in which positions were checked
  int of_restart = 0;        // until the first run: what the tangential models of a restart file keep per contact

  static Range &of(void *lmp) {
    static std::map<void *, Range> all;
    return all[lmp];
  }
  // On whatever rank the contact is: LAMMPS shows only what rank 0 warns of.
  static void warn(void *lmp, void *error, const std::string &text) {
    const Stock &stock = Stock::get();
    if (stock.setting(lmp, "world_rank") == 0 && stock.warn) stock.warn(error, "demlaws", 0, text);
    else fprintf(stderr, "WARNING: %s\n", text.c_str());
  }
  // Once, of what all ranks know: rank 0 says it.
  void announce(void *lmp, void *error, const std::string &what, const std::string &text) {
    if (counts.reported.insert(what).second && Stock::get().setting(lmp, "world_rank") == 0) warn(lmp, error, text);
  }
  // At the end of a run, on all ranks: the sums.
  void tell(void *lmp, void *error) {
    if (!used) return;
    const Ranks ranks(lmp, error);
    for (const std::string &line : counts.summaries(ranks))
      if (ranks.me == 0) warn(lmp, error, line);
  }

  void look_across(void *lmp, void *error) {
    const Stock &stock = Stock::get();
    const int *const periodic = (const int *)stock.global(lmp, "periodicity");
    if (!periodic) return;
    const double *const radius = (const double *)stock.atom(lmp, "radius");
    const int local = radius ? stock.setting(lmp, "nlocal") : 0;
    const std::vector<double> all = Ranks(lmp, error).gather(local ? *std::max_element(radius, radius + local) : 0.);
    const double reach = 2. * *std::max_element(all.begin(), all.end());
    static const char *const ends[3][2] = {{"boxxlo", "boxxhi"}, {"boxylo", "boxyhi"}, {"boxzlo", "boxzhi"}};
    for (int k = 0; k < stock.setting(lmp, "dimension"); k++) {
      const double *const low = (const double *)stock.global(lmp, ends[k][0]);
      const double *const high = (const double *)stock.global(lmp, ends[k][1]);
      if (!periodic[k] || !low || !high || *high - *low >= 2. * reach) continue;
      return announce(lmp, error, "thin box", demlaws::thin_box(k, *high - *low, 2. * reach, "LAMMPS"));
    }
  }
};

} // namespace
#endif
