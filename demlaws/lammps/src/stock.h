// The functions of the LAMMPS that runs in this process: found by name, never linked.
#ifndef DEMLAWS_STOCK_H
#define DEMLAWS_STOCK_H

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <dlfcn.h>
#include <link.h>
#include <string>
#include <vector>

// mangled names: GCC's, with std::string as it is since GCC 5
#define DEMLAWS_STRING "NSt7__cxx1112basic_stringIcSt11char_traitsIcESaIcEEE"
#define DEMLAWS_MODEL(rest) "_ZN9LAMMPS_NS11Granular_NS13GranularModel" rest
#define DEMLAWS_ERROR(which) "_ZN9LAMMPS_NS5Error3" which "ERK" DEMLAWS_STRING "i"

// Functions of LAMMPS that demlaws replaces, and calls: result, name here, arguments, symbol.
// clang-format off
#define DEMLAWS_PAIRS(DO) \
  DO(bool, check, (void *), DEMLAWS_MODEL("13check_contactEv")) \
  DO(void, compute, (void *), DEMLAWS_MODEL("16calculate_forcesEv"))
#define DEMLAWS_HOOKS(DO) \
  DO(int, add, (void *, char **, int, int, int), DEMLAWS_MODEL("13add_sub_modelEPPciiNS0_12SubModelTypeE")) \
  DO(void, construct, (void *, std::string, int), \
     DEMLAWS_MODEL("19construct_sub_modelE" DEMLAWS_STRING "NS0_12SubModelTypeE")) \
  DO(void, init, (void *), DEMLAWS_MODEL("4initEv")) \
  DO(void *, add_compute, (void *, int, char **, int), "_ZN9LAMMPS_NS6Modify11add_computeEiPPci") \
  DO(void, pair_make, (void *, void *), "_ZN9LAMMPS_NS12PairGranularC1EPNS_6LAMMPSE") \
  DO(void, pair_coeff, (void *, int, char **), "_ZN9LAMMPS_NS12PairGranular5coeffEiPPc") \
  DO(void, pair_restart, (void *, FILE *), "_ZN9LAMMPS_NS12PairGranular12read_restartEP8_IO_FILE") \
  DO(void, pair_init, (void *), "_ZN9LAMMPS_NS12PairGranular10init_styleEv") \
  DO(void, pair_forces, (void *, int, int), "_ZN9LAMMPS_NS12PairGranular7computeEii") \
  DO(void, wall_forces, (void *, int), "_ZN9LAMMPS_NS11FixWallGran10post_forceEi") \
  DO(void, region_forces, (void *, int), "_ZN9LAMMPS_NS17FixWallGranRegion10post_forceEi") \
  DO(void, post_run, (void *), "_ZN9LAMMPS_NS6Modify8post_runEv") \
  DO(void, delete_atoms, (void *, int, char **), "_ZN9LAMMPS_NS11DeleteAtoms7commandEiPPc") \
  DO(void, reset_atoms, (void *, int, char **), "_ZN9LAMMPS_NS12ResetAtomsID7commandEiPPc") \
  DO(void, rerun, (void *, int, char **), "_ZN9LAMMPS_NS5Rerun7commandEiPPc")
// Those that it calls only.
#define DEMLAWS_CALLED(DO) \
  DO(void, make, (void *, void *), DEMLAWS_MODEL("C1EPNS_6LAMMPSE")) \
  DO(void, unmake, (void *), DEMLAWS_MODEL("D1Ev")) \
  DO(int, mix, (void *, void *, void *), DEMLAWS_MODEL("10mix_coeffsEPS1_S2_")) \
  DO(void *, global, (void *, const char *), "lammps_extract_global") \
  DO(void *, atom, (void *, const char *), "lammps_extract_atom") \
  DO(int, setting, (void *, const char *), "lammps_extract_setting") \
  DO(void, pair_settings, (void *, int, char **), "_ZN9LAMMPS_NS12PairGranular8settingsEiPPc") \
  DO(void *, pair_match, (void *, const std::string &, int, int), \
     "_ZN9LAMMPS_NS5Force10pair_matchERK" DEMLAWS_STRING "ii") \
  DO(void, pair_local, (void *), "_ZN9LAMMPS_NS16ComputePairLocal13compute_localEv") \
  DO(void *, add_fix, (void *, int, char **, int), "_ZN9LAMMPS_NS6Modify7add_fixEiPPci") \
  DO(void *, find_compute, (const void *, const std::string &), \
     "_ZNK9LAMMPS_NS6Modify17get_compute_by_idERK" DEMLAWS_STRING) \
  DO(void *, find_fix, (const void *, const std::string &), \
     "_ZNK9LAMMPS_NS6Modify13get_fix_by_idERK" DEMLAWS_STRING)
// clang-format on

namespace {

enum { NORMAL = 0, DAMPING, TANGENTIAL, ROLLING, TWISTING, HEAT };
const char here = 0; // an address in this object

// Loaded objects, and their addresses.
struct Object {
  std::string name;
  ElfW(Addr) from, to;
  bool holds(const void *place) const { return (ElfW(Addr))place - from < to - from; }
  static std::vector<Object> all() {
    std::vector<Object> objects;
    dl_iterate_phdr(&Object::list, &objects);
    return objects;
  }

private:
  static int list(struct dl_phdr_info *object, size_t, void *into) {
    Object found = {object->dlpi_name ? object->dlpi_name : "", ~(ElfW(Addr))0, 0};
    for (int k = 0; k < object->dlpi_phnum; k++) {
      const ElfW(Phdr) &part = object->dlpi_phdr[k];
      if (part.p_type != PT_LOAD) continue;
      found.from = std::min(found.from, (ElfW(Addr))(object->dlpi_addr + part.p_vaddr));
      found.to = std::max(found.to, (ElfW(Addr))(object->dlpi_addr + part.p_vaddr + part.p_memsz));
    }
    ((std::vector<Object> *)into)->push_back(found);
    return 0;
  }
};
Object this_object = {"", 0, 0}; // set when the layout is known

// The instance that an object of a class derived from LAMMPS's Pointers belongs to.
inline void *instance_of(void *object) { return ((void **)object)[1]; }

struct Stock {
#define DEMLAWS_MEMBER(RESULT, NAME, ARGUMENTS, SYMBOL) RESULT(*NAME) ARGUMENTS;
  DEMLAWS_PAIRS(DEMLAWS_MEMBER)
  DEMLAWS_HOOKS(DEMLAWS_MEMBER)
  DEMLAWS_CALLED(DEMLAWS_MEMBER)
  void *reduce_one;
  const void *reduce_table;
  size_t reduce_table_size;
  // those of which a LAMMPS has some
  void (*all)(void *, const std::string &, int, const std::string &);
  void (*one)(void *, const std::string &, int, const std::string &);
  void (*all4)(void *, const std::string &, int, int, const std::string &);
  void (*one4)(void *, const std::string &, int, int, const std::string &);
  void (*warn)(void *, const std::string &, int, const std::string &);
  int (*communicator)(void *);
  std::string missing; // the first function that this LAMMPS does not have
  bool exported() const { return dlsym(RTLD_DEFAULT, "lammps_version"); } // whether functions of LAMMPS can be found

  static Stock &get() {
    static Stock stock;
    if (!stock.add) stock.look();
    return stock;
  }

  // A function, or other object, that LAMMPS or a library of its has; NULL: not found.
  template <class F> void look_for(const char *name, F &found) const { found = (F)dlsym(library_, name); }

private:
  void *library_;
  Stock() : add(NULL) {}
  template <class F> void find(const char *name, F &function) {
    look_for(name, function);
    if (!function && missing.empty()) missing = name;
  }
  // In the loaded object, other than this one, that holds add_sub_model itself.
  void look() {
    for (const Object &object : Object::all()) {
      if (object.holds(&here)) continue;
      library_ = dlopen(object.name.empty() ? NULL : object.name.c_str(), RTLD_LAZY | RTLD_NOLOAD);
      if (library_) look_for(DEMLAWS_MODEL("13add_sub_modelEPPciiNS0_12SubModelTypeE"), add);
      if (!library_ || !object.holds((void *)add)) {
        add = NULL;
        continue;
      }
#define DEMLAWS_FIND(RESULT, NAME, ARGUMENTS, SYMBOL) find(SYMBOL, NAME);
      DEMLAWS_PAIRS(DEMLAWS_FIND)
      DEMLAWS_HOOKS(DEMLAWS_FIND)
      DEMLAWS_CALLED(DEMLAWS_FIND)
      find("_ZN9LAMMPS_NS13ComputeReduce11compute_oneEii", reduce_one);
      find("_ZTVN9LAMMPS_NS13ComputeReduceE", reduce_table);
      look_for(DEMLAWS_ERROR("all") "S8_", all);
      look_for(DEMLAWS_ERROR("one") "S8_", one);
      look_for(DEMLAWS_ERROR("all") "iS8_", all4);
      look_for(DEMLAWS_ERROR("one") "iS8_", one4);
      look_for("_ZN9LAMMPS_NS5Error7warningERK" DEMLAWS_STRING "iS8_", warn);
      look_for("lammps_get_mpi_comm", communicator);
      if (!all && !all4 && missing.empty()) missing = DEMLAWS_ERROR("all") "S8_";
      Dl_info place;
      const ElfW(Sym) *symbol = NULL;
      reduce_table_size = 0;
      if (reduce_table && dladdr1(reduce_table, &place, (void **)&symbol, RTLD_DL_SYMENT) && symbol)
        reduce_table_size = symbol->st_size;
      return;
    }
  }
};

// Objects of an instance, which begins with pointers to them: Abi::fits() checks it.
inline void *error_of(void *lmp) { return ((void **)lmp)[1]; }
inline void *modify_of(void *lmp) { return ((void **)lmp)[10]; }

// Error::all (every rank comes here) or Error::one; they print, flush and throw.
__attribute__((noinline, cold, noreturn)) void raise(void *lmp, bool every_rank, const std::string &what) {
  const Stock &stock = Stock::get();
  void *const error = error_of(lmp);
  const std::string file = "demlaws";
  if (every_rank && stock.all4) stock.all4(error, file, 0, -2, what);
  if (every_rank && stock.all) stock.all(error, file, 0, what);
  if (stock.one4) stock.one4(error, file, 0, -2, what);
  if (stock.one) stock.one(error, file, 0, what);
  fprintf(stderr, "%s\n", what.c_str());
  abort();
}

} // namespace
#endif
