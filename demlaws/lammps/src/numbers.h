// LAMMPS finds the history of a contact by the number of the partner, and `delete_atoms` (with compress yes, its
// default) and `reset_atoms id` deal new numbers without changing it: contacts then start as virgin ones, or go on
// with the history of others. Here the histories follow their contacts.
#ifndef DEMLAWS_NUMBERS_H
#define DEMLAWS_NUMBERS_H

#include "range.h"
#include "ranks.h"
#include <map>

namespace {

class Numbers {
public:
  // Runs a command that may deal new numbers.
  static void follow(void (*command)(void *, int, char **), void *object, int count, char **arg) {
    void *const lmp = instance_of(object), *const error = error_of(object), *const modify = modify_of(object);
    const Stock &stock = Stock::get();
    if (!Range::of(lmp).used || !stock.global(lmp, "boxxlo")) return command(object, count, arg);
    const char *words[] = {kept(), "all", "property/atom", "d_demlaws_numbers", "ghost", "no", "writedata", "no"};
    stock.add_fix(modify, 8, const_cast<char **>(words), 1);
    double *old = (double *)stock.atom(lmp, "d_demlaws_numbers");
    for (int i = 0, n = stock.setting(lmp, "nlocal"); i < n; i++) old[i] = (double)tag_of(lmp, i);
    try {
      command(object, count, arg);
    } catch (...) {
      stock.delete_fix(modify, kept());
      throw;
    }
    old = (double *)stock.atom(lmp, "d_demlaws_numbers"); // the particles may have moved
    std::vector<long long> mine;
    for (int i = 0, n = stock.setting(lmp, "nlocal"); i < n; i++) {
      mine.push_back((long long)old[i]);
      mine.push_back(tag_of(lmp, i));
    }
    stock.delete_fix(modify, kept());
    const std::vector<long long> all = Ranks(lmp, error).join(mine);
    Renamed renamed;
    bool changed = false;
    for (size_t n = 0; n < all.size(); n += 2) {
      renamed[all[n]] = all[n + 1];
      changed = changed || all[n] != all[n + 1];
    }
    if (!changed) return;
    if (stock.setting(lmp, "world_rank") == 0)
      Range::warn(lmp, error, "demlaws/table: particles were given new numbers: the contacts' histories follow them");
    if (rename(lmp, modify, renamed)) return;
    // after read_restart they are still in the restart file's data, which the first init hands out
    Renamed &before = pending()[lmp];
    for (auto &number : before) number.second = now(renamed, number.second);
    before.insert(renamed.begin(), renamed.end());
  }
  // The pair style has its histories now.
  static void after_init(void *object) {
    void *const lmp = instance_of(object);
    const std::map<void *, Renamed>::iterator found = pending().find(lmp);
    if (found == pending().end()) return;
    rename(lmp, modify_of(object), found->second);
    pending().erase(found);
  }
  static void forget(void *lmp) { pending().erase(lmp); }

private:
  typedef std::map<long long, long long> Renamed; // old number, new number
  static const char *kept() { return "demlaws_numbers"; }
  static std::map<void *, Renamed> &pending() {
    static std::map<void *, Renamed> all;
    return all;
  }
  static long long now(const Renamed &renamed, long long old) {
    const Renamed::const_iterator it = renamed.find(old);
    return it == renamed.end() ? -1 : it->second; // -1: a particle that is gone, whose number may be dealt again
  }
  // Goes through the histories that there are, packed as they travel from rank to rank: how many partners, then each
  // one's number (as the bits of an integer; in older versions as a number) and values. False: there are none.
  static bool rename(void *lmp, void *modify, const Renamed &renamed) {
    const Stock &stock = Stock::get();
    bool any = false;
    std::vector<double> packed;
    for (int k = 0, fixes = stock.id_count(lmp, "fix"); k < fixes; k++) {
      char id[256];
      if (!stock.id_name(lmp, "fix", k, id, sizeof id)) continue;
      void *const fix = stock.find_fix(modify, id);
      if (!fix || *(void **)fix != (void *)((void *const *)stock.history_table + 2)) continue;
      any = true;
      for (int i = 0, n = stock.setting(lmp, "nlocal"); i < n; i++) {
        const int size = stock.history_size(fix, i);
        if (size <= 2) continue;
        packed.resize(size + 2);
        const int length = stock.history_pack(fix, i, &packed[0]), partners = (int)packed[0];
        const int each = partners > 0 ? (length - 1) / partners : 0;
        for (int p = 0; p < partners; p++) {
          double &place = packed[1 + p * each];
          long long old;
          const bool bits = !(place >= 1.);
          if (bits) memcpy(&old, &place, sizeof old);
          else old = (long long)place;
          old = now(renamed, old);
          if (bits) memcpy(&place, &old, sizeof old);
          else place = (double)old;
        }
        stock.history_unpack(fix, i, &packed[0]);
      }
    }
    return any;
  }
};

} // namespace
#endif
