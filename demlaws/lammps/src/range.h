// How far overlaps may go: a warning beyond SMALL_OVERLAP of the effective radius, no answer beyond LARGEST_OVERLAP of
// it (both as in demlaws/units.py), and no certified force beyond the last row of a table.
#ifndef DEMLAWS_RANGE_H
#define DEMLAWS_RANGE_H

#include "ranks.h"
#include <iomanip>
#include <map>
#include <sstream>

namespace {

const double SMALL_OVERLAP = 0.1, LARGEST_OVERLAP = 1.0;

// Contact steps of one run on this rank with an overlap above a limit.
struct Excess {
  double count, furthest; // contact steps; largest overlap over the limit
  bool told;              // since the pair style was made
};

// Of one instance of LAMMPS.
struct Range {
  Excess deep, beyond; // than SMALL_OVERLAP; the last row
  bool used;           // there is a table
  bool thin_told;      // that the box is thin
  long long checked;   // the step in which positions were looked at
  Range() : deep(), beyond(), used(false), thin_told(false), checked(-1) {}

  static Range &of(void *lmp) {
    static std::map<void *, Range> all;
    return all[lmp];
  }
  // Tells of the first one at once, on whatever rank it is.
  static void report(void *lmp, void *error, Excess &excess, double ratio, bool counted, const std::string &what) {
    if (counted) {
      excess.count++;
      excess.furthest = std::max(excess.furthest, ratio);
    }
    if (excess.told) return;
    excess.told = true;
    const Stock &stock = Stock::get();
    const std::string text = what + " (told once, counted at the end of the run)";
    if (stock.setting(lmp, "world_rank") == 0 && stock.warn) stock.warn(error, "demlaws", 0, text);
    else fprintf(stderr, "WARNING: %s\n", text.c_str()); // LAMMPS shows only what rank 0 warns of
  }
  // At the end of a run, on all ranks: the sums.
  void tell(void *lmp, void *error) {
    if (!used) return;
    const Ranks ranks(lmp, error);
    sum(ranks, error, deep, "deeper than a tenth of R", "that: the laws hold for small overlaps");
    sum(ranks, error, beyond, "beyond the last row of their table", "its overlap: extrapolated, not certified");
  }

  // Where a box is periodic and less than two contacts long, two particles can touch through both sides: two contacts
  // with the same two numbers, by which LAMMPS finds their histories.
  void look_across(void *lmp, void *error) {
    const Stock &stock = Stock::get();
    const int *const periodic = (const int *)stock.global(lmp, "periodicity");
    if (thin_told || !periodic) return;
    const double *const radius = (const double *)stock.atom(lmp, "radius");
    const int local = radius ? stock.setting(lmp, "nlocal") : 0;
    const std::vector<double> all = Ranks(lmp, error).gather(local ? *std::max_element(radius, radius + local) : 0.);
    const double reach = 2. * *std::max_element(all.begin(), all.end());
    static const char *const ends[3][2] = {{"boxxlo", "boxxhi"}, {"boxylo", "boxyhi"}, {"boxzlo", "boxzhi"}};
    for (int k = 0; k < stock.setting(lmp, "dimension") && !thin_told; k++) {
      const double *const low = (const double *)stock.global(lmp, ends[k][0]), *const high =
                                                                                   (const double *)stock.global(
                                                                                       lmp, ends[k][1]);
      if (!periodic[k] || !low || !high || *high - *low >= 2. * reach) continue;
      thin_told = true;
      std::ostringstream what;
      what << "demlaws/table: the box is " << *high - *low << " m long in "
           << "xyz"[k]
           << ", where it is periodic: two particles can touch through both sides, and their two histories are mixed "
              "up, which LAMMPS finds by their numbers; from "
           << 2. * reach << " m on they cannot";
      if (stock.setting(lmp, "world_rank") == 0 && stock.warn) stock.warn(error, "demlaws", 0, what.str());
    }
  }

private:
  static void sum(const Ranks &ranks, void *error, Excess &excess, const char *where, const char *meaning) {
    const std::vector<Excess> all = ranks.gather(excess);
    double count = 0., furthest = 0.;
    for (size_t n = 0; n < all.size(); n++) {
      count += all[n].count;
      furthest = std::max(furthest, all[n].furthest);
    }
    excess.count = excess.furthest = 0.;
    if (ranks.me != 0 || count == 0.) return;
    std::ostringstream what;
    what.precision(3);
    what << "demlaws/table: in this run " << (long long)count << " contact steps were " << where << ", by up to "
         << furthest << " times " << meaning;
    if (Stock::get().warn) Stock::get().warn(error, "demlaws", 0, what.str());
  }
};

} // namespace
#endif
