// LAMMPS, by its own headers: what src/stock.h finds by name in a running one.
#ifndef DEMLAWS_STOCK_H
#define DEMLAWS_STOCK_H

#include "comm.h"
#include "compute.h"
#include "error.h"
#include "fix.h"
#include "lammps.h"
#include "library.h"
#include "modify.h"

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

namespace {

inline LAMMPS_NS::LAMMPS *instance(void *lmp) { return (LAMMPS_NS::LAMMPS *)lmp; }
inline void *error_of(void *lmp) { return instance(lmp)->error; }
inline void *modify_of(void *lmp) { return instance(lmp)->modify; }
inline LAMMPS_NS::Modify *as_modify(void *modify) { return (LAMMPS_NS::Modify *)modify; }

struct Stock {
  static const Stock &get() {
    static const Stock stock = {&warning};
    return stock;
  }
  void (*warn)(void *, const std::string &, int, const std::string &);

  void *global(void *lmp, const char *name) const { return lammps_extract_global(lmp, name); }
  void *atom(void *lmp, const char *name) const { return lammps_extract_atom(lmp, name); }
  int setting(void *lmp, const char *name) const { return lammps_extract_setting(lmp, name); }
  void *find_fix(void *modify, const char *id) const { return as_modify(modify)->get_fix_by_id(id); }
  void *find_compute(void *modify, const char *id) const { return as_modify(modify)->get_compute_by_id(id); }
  void add_fix(void *modify, int count, char **arg, int) const { as_modify(modify)->add_fix(count, arg); }
  void add_compute(void *modify, int count, char **arg, int) const { as_modify(modify)->add_compute(count, arg); }
  void pair_local(void *compute) const { ((LAMMPS_NS::Compute *)compute)->compute_local(); }

private:
  static void warning(void *error, const std::string &, int, const std::string &text) {
    ((LAMMPS_NS::Error *)error)->warning(FLERR, text);
  }
};

// Error::all (every rank comes here) or Error::one; they print, flush and throw.
[[noreturn]] void raise(void *lmp, bool every_rank, const std::string &what) {
  LAMMPS_NS::Error *const of = instance(lmp)->error;
  if (every_rank) of->all(FLERR, what);
  of->one(FLERR, what);
}

} // namespace
#endif
