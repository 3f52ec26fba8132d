// Where a shared object keeps the address of a function that it calls, or holds in a table of virtual functions: found
// by the function's name in the object's relocations, and written.
#ifndef DEMLAWS_SLOTS_H
#define DEMLAWS_SLOTS_H

#include <cstring>
#include <link.h>
#include <map>
#include <sys/mman.h>
#include <unistd.h>
#include <vector>

namespace {

class Slots {
public:
  // Finds those of all loaded objects, of functions with these names.
  explicit Slots(const std::vector<const char *> &names) {
    for (const char *name : names) found_[name];
    dl_iterate_phdr(&Slots::find_in, this);
  }
  bool has(const char *name) const { return !found_.at(name).empty(); }
  void set(const char *name, void *function) {
    for (const Slot &slot : found_[name]) put(slot.place, function);
  }
  // What was there before comes back.
  void undo() {
    for (const auto &of_name : found_)
      for (const Slot &slot : of_name.second) put(slot.place, slot.before);
  }

private:
  struct Slot {
    void **place, *before;
  };
  struct ByText {
    bool operator()(const char *a, const char *b) const { return strcmp(a, b) < 0; }
  };
  std::map<const char *, std::vector<Slot>, ByText> found_;

  static void put(void **place, void *value) {
    const ElfW(Addr) page = sysconf(_SC_PAGESIZE), begin = (ElfW(Addr))place & ~(page - 1);
    // RELRO: the linker made some of these pages read-only after relocation
    if (!mprotect((void *)begin, page, PROT_READ | PROT_WRITE)) *place = value;
  }
  static int find_in(struct dl_phdr_info *object, size_t, void *slots) {
    const ElfW(Dyn) *dynamic = NULL;
    for (int k = 0; k < object->dlpi_phnum; k++)
      if (object->dlpi_phdr[k].p_type == PT_DYNAMIC)
        dynamic = (const ElfW(Dyn) *)(object->dlpi_addr + object->dlpi_phdr[k].p_vaddr);
    if (!dynamic) return 0;
    const ElfW(Sym) *symbols = NULL;
    const char *strings = NULL;
    const ElfW(Rela) * tables[2] = {NULL, NULL};
    size_t sizes[2] = {0, 0};
    for (; dynamic->d_tag != DT_NULL; dynamic++) {
      const ElfW(Addr) at =
          dynamic->d_un.d_ptr < object->dlpi_addr ? dynamic->d_un.d_ptr + object->dlpi_addr : dynamic->d_un.d_ptr;
      if (dynamic->d_tag == DT_SYMTAB) symbols = (const ElfW(Sym) *)at;
      if (dynamic->d_tag == DT_STRTAB) strings = (const char *)at;
      if (dynamic->d_tag == DT_JMPREL) tables[0] = (const ElfW(Rela) *)at;
      if (dynamic->d_tag == DT_PLTRELSZ) sizes[0] = dynamic->d_un.d_val / sizeof(ElfW(Rela));
      if (dynamic->d_tag == DT_RELA) tables[1] = (const ElfW(Rela) *)at;
      if (dynamic->d_tag == DT_RELASZ) sizes[1] = dynamic->d_un.d_val / sizeof(ElfW(Rela));
    }
    if (!symbols || !strings) return 0;
#if defined(__x86_64__)
    const unsigned kinds[3] = {R_X86_64_JUMP_SLOT, R_X86_64_GLOB_DAT, R_X86_64_64};
#elif defined(__aarch64__)
    const unsigned kinds[3] = {R_AARCH64_JUMP_SLOT, R_AARCH64_GLOB_DAT, R_AARCH64_ABS64};
#else
#error "the relocation types of this processor are not known here"
#endif
    auto &found = ((Slots *)slots)->found_;
    for (int t = 0; t < 2; t++)
      for (size_t n = 0; tables[t] && n < sizes[t]; n++) {
        const ElfW(Rela) &one = tables[t][n];
        const unsigned kind = (unsigned)ELF64_R_TYPE(one.r_info);
        if ((kind != kinds[0] && kind != kinds[1] && kind != kinds[2]) || one.r_addend) continue;
        const auto of_name = found.find(strings + symbols[ELF64_R_SYM(one.r_info)].st_name);
        void **const place = (void **)(object->dlpi_addr + one.r_offset);
        if (of_name != found.end()) of_name->second.push_back({place, *place});
      }
    return 0;
  }
};

} // namespace
#endif
