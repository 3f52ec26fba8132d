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
#define DEMLAWS_ADD DEMLAWS_MODEL("13add_sub_modelEPPciiNS0_12SubModelTypeE")
#define DEMLAWS_CONSTRUCT DEMLAWS_MODEL("19construct_sub_modelE" DEMLAWS_STRING "NS0_12SubModelTypeE")
#define DEMLAWS_INIT DEMLAWS_MODEL("4initEv")
#define DEMLAWS_ADD_COMPUTE "_ZN9LAMMPS_NS6Modify11add_computeEiPPci"
#define DEMLAWS_PAIR_MAKE "_ZN9LAMMPS_NS12PairGranularC1EPNS_6LAMMPSE"
#define DEMLAWS_PAIR_COEFF "_ZN9LAMMPS_NS12PairGranular5coeffEiPPc"
#define DEMLAWS_PAIR_RESTART "_ZN9LAMMPS_NS12PairGranular12read_restartEP8_IO_FILE"
#define DEMLAWS_PAIR_INIT "_ZN9LAMMPS_NS12PairGranular10init_styleEv"
#define DEMLAWS_PAIR_FORCES "_ZN9LAMMPS_NS12PairGranular7computeEii"
#define DEMLAWS_WALL_FORCES "_ZN9LAMMPS_NS11FixWallGran10post_forceEi"
#define DEMLAWS_REGION_FORCES "_ZN9LAMMPS_NS17FixWallGranRegion10post_forceEi"
#define DEMLAWS_POST_RUN "_ZN9LAMMPS_NS6Modify8post_runEv"
#define DEMLAWS_DELETE "_ZN9LAMMPS_NS11DeleteAtoms7commandEiPPc"
#define DEMLAWS_RESET "_ZN9LAMMPS_NS12ResetAtomsID7commandEiPPc"
#define DEMLAWS_HISTORY(rest) "_ZN9LAMMPS_NS15FixNeighHistory" rest
#define DEMLAWS_CHECK DEMLAWS_MODEL("13check_contactEv")
#define DEMLAWS_COMPUTE DEMLAWS_MODEL("16calculate_forcesEv")

namespace {

enum { NORMAL = 0, DAMPING, TANGENTIAL, ROLLING, TWISTING, HEAT };
const char here = 0; // an address in this object

// Where this object stands in memory.
struct Here {
  static bool has(const void *place) { return (ElfW(Addr))place - from() < size(); }
  static void look() { dl_iterate_phdr(&Here::list, NULL); }

private:
  static ElfW(Addr) & from() {
    static ElfW(Addr) from = 0;
    return from;
  }
  static ElfW(Addr) & size() {
    static ElfW(Addr) size = 0;
    return size;
  }
  static int list(struct dl_phdr_info *object, size_t, void *) {
    ElfW(Addr) first = ~(ElfW(Addr))0, last = 0;
    for (int k = 0; k < object->dlpi_phnum; k++) {
      const ElfW(Phdr) &part = object->dlpi_phdr[k];
      if (part.p_type != PT_LOAD) continue;
      first = std::min(first, (ElfW(Addr))(object->dlpi_addr + part.p_vaddr));
      last = std::max(last, (ElfW(Addr))(object->dlpi_addr + part.p_vaddr + part.p_memsz));
    }
    if ((ElfW(Addr)) & here < first || (ElfW(Addr)) & here >= last) return 0;
    from() = first;
    size() = last - first;
    return 1;
  }
};

// The instance that an object of a class derived from LAMMPS's Pointers belongs to.
inline void *instance_of(void *object) { return ((void **)object)[1]; }
// Its list of fixes and computes: the eleventh of the references that Pointers holds.
inline void *modify_of(void *object) { return *((void ***)object)[12]; }

struct Stock {
  int (*add)(void *, char **, int, int, int);
  void (*construct)(void *, std::string, int);
  void (*make)(void *, void *);
  void (*unmake)(void *);
  void (*init)(void *);
  bool (*check)(void *);
  void (*compute)(void *);
  void (*all)(void *, const std::string &, int, const std::string &);
  void (*one)(void *, const std::string &, int, const std::string &);
  void (*all4)(void *, const std::string &, int, int, const std::string &);
  void (*one4)(void *, const std::string &, int, int, const std::string &);
  void (*warn)(void *, const std::string &, int, const std::string &);
  void *(*global)(void *, const char *);
  void *(*atom)(void *, const char *);
  int (*setting)(void *, const char *);
  void (*pair_make)(void *, void *);
  void (*pair_settings)(void *, int, char **);
  void (*pair_coeff)(void *, int, char **);
  void (*pair_restart)(void *, FILE *);
  void (*pair_init)(void *);
  void (*pair_forces)(void *, int, int);
  void (*wall_forces)(void *, int);
  void (*region_forces)(void *, int);
  void *(*pair_match)(void *, const std::string &, int, int);
  void *(*add_compute)(void *, int, char **, int);
  void *(*add_fix)(void *, int, char **, int);
  void (*delete_fix)(void *, const std::string &);
  void *(*find_compute)(const void *, const std::string &);
  void *(*find_fix)(const void *, const std::string &);
  void *reduce_one;
  const void *reduce_table;
  size_t reduce_table_size;
  void (*pair_local)(void *);
  void (*post_run)(void *);
  int (*communicator)(void *);
  void (*delete_atoms)(void *, int, char **);
  void (*reset_atoms)(void *, int, char **);
  int (*id_count)(void *, const char *);
  int (*id_name)(void *, const char *, int, char *, int);
  const void *history_table;
  int (*history_size)(void *, int);
  int (*history_pack)(void *, int, double *);
  int (*history_unpack)(void *, int, double *);
  std::string missing; // the first function that this LAMMPS does not have

  static Stock &get() {
    static Stock stock;
    if (!stock.add) stock.look();
    return stock;
  }

  // A function, or other object, that LAMMPS or a library of its has; NULL where there is none.
  template <class F> void look_for(const char *name, F &found) const { found = (F)dlsym(library_, name); }

private:
  void *library_;
  struct Object {
    std::string name;
    ElfW(Addr) from, to;
    bool holds(const void *place) const { return (ElfW(Addr))place >= from && (ElfW(Addr))place < to; }
  };
  Stock() : add(NULL) {}
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
  template <class F> void find(const char *name, F &function, bool needed = true) {
    look_for(name, function);
    if (needed && !function && missing.empty()) missing = name;
  }
  // In the loaded object, other than this one, that holds add_sub_model itself.
  void look() {
    std::vector<Object> objects;
    dl_iterate_phdr(&Stock::list, &objects);
    for (size_t n = 0; n < objects.size() && !add; n++) {
      if (objects[n].holds(&here)) continue;
      library_ = dlopen(objects[n].name.empty() ? NULL : objects[n].name.c_str(), RTLD_LAZY | RTLD_NOLOAD);
      void *const found = library_ ? dlsym(library_, DEMLAWS_ADD) : NULL;
      if (!found || !objects[n].holds(found)) continue;
      find(DEMLAWS_CONSTRUCT, construct);
      find(DEMLAWS_MODEL("C1EPNS_6LAMMPSE"), make);
      find(DEMLAWS_MODEL("D1Ev"), unmake);
      find(DEMLAWS_INIT, init);
      find(DEMLAWS_CHECK, check);
      find(DEMLAWS_COMPUTE, compute);
      find(DEMLAWS_ERROR("all") "S8_", all, false);
      find(DEMLAWS_ERROR("one") "S8_", one, false);
      find(DEMLAWS_ERROR("all") "iS8_", all4, false);
      find(DEMLAWS_ERROR("one") "iS8_", one4, false);
      find("_ZN9LAMMPS_NS5Error7warningERK" DEMLAWS_STRING "iS8_", warn, false);
      find("lammps_extract_global", global);
      find("lammps_extract_atom", atom);
      find("lammps_extract_setting", setting);
      find(DEMLAWS_PAIR_MAKE, pair_make);
      find("_ZN9LAMMPS_NS12PairGranular8settingsEiPPc", pair_settings);
      find(DEMLAWS_PAIR_COEFF, pair_coeff);
      find(DEMLAWS_PAIR_RESTART, pair_restart);
      find(DEMLAWS_PAIR_INIT, pair_init);
      find(DEMLAWS_PAIR_FORCES, pair_forces);
      find(DEMLAWS_WALL_FORCES, wall_forces);
      find(DEMLAWS_REGION_FORCES, region_forces);
      find("_ZN9LAMMPS_NS5Force10pair_matchERK" DEMLAWS_STRING "ii", pair_match);
      find(DEMLAWS_ADD_COMPUTE, add_compute);
      find("_ZN9LAMMPS_NS6Modify7add_fixEiPPci", add_fix);
      find("_ZN9LAMMPS_NS6Modify10delete_fixERK" DEMLAWS_STRING, delete_fix);
      find("_ZNK9LAMMPS_NS6Modify17get_compute_by_idERK" DEMLAWS_STRING, find_compute);
      find("_ZNK9LAMMPS_NS6Modify13get_fix_by_idERK" DEMLAWS_STRING, find_fix);
      find("_ZN9LAMMPS_NS13ComputeReduce11compute_oneEii", reduce_one);
      find("_ZTVN9LAMMPS_NS13ComputeReduceE", reduce_table);
      find("_ZN9LAMMPS_NS16ComputePairLocal13compute_localEv", pair_local);
      find(DEMLAWS_POST_RUN, post_run);
      find(DEMLAWS_DELETE, delete_atoms);
      find(DEMLAWS_RESET, reset_atoms);
      find("lammps_id_count", id_count);
      find("lammps_id_name", id_name);
      find("_ZTVN9LAMMPS_NS15FixNeighHistoryE", history_table);
      find(DEMLAWS_HISTORY("12size_restartEi"), history_size);
      find(DEMLAWS_HISTORY("13pack_exchangeEiPd"), history_pack);
      find(DEMLAWS_HISTORY("15unpack_exchangeEiPd"), history_unpack);
      find("lammps_get_mpi_comm", communicator, false);
      if (!all && !all4 && missing.empty()) missing = DEMLAWS_ERROR("all") "S8_";
      Dl_info place;
      const ElfW(Sym) *symbol = NULL;
      reduce_table_size = 0;
      if (reduce_table && dladdr1(reduce_table, &place, (void **)&symbol, RTLD_DL_SYMENT) && symbol)
        reduce_table_size = symbol->st_size;
      add = (int (*)(void *, char **, int, int, int))found;
    }
  }
};

// Error::all (every rank comes here) or Error::one; they throw.
__attribute__((noinline, cold, noreturn)) void raise(void *error, bool every_rank, const std::string &what) {
  const Stock &stock = Stock::get();
  const std::string file = "demlaws";
  fflush(stdout); // in a pipe the message would be lost where mpirun ends this rank because another one has stopped
  setvbuf(stdout, NULL, _IONBF, 0);
  if (every_rank && stock.all4) stock.all4(error, file, 0, -2, what);
  if (every_rank && stock.all) stock.all(error, file, 0, what);
  if (stock.one4) stock.one4(error, file, 0, -2, what);
  if (stock.one) stock.one(error, file, 0, what);
  fprintf(stderr, "%s\n", what.c_str());
  abort();
}

} // namespace
#endif
