// Where a shared object keeps the address of a function that it calls, or holds in a table of virtual functions: found
// by the function's name in the object's relocations, and written.
#ifndef DEMLAWS_SLOTS_H
#define DEMLAWS_SLOTS_H

#include <cstring>
#include <link.h>
#include <sys/mman.h>
#include <unistd.h>
#include <vector>

namespace {

struct Patch {
  const char *name;
  void *function;
  int slots;
};

class Slots {
public:
  // Counts the places that hold `patches[...].name`; with `write` the function's address goes there.
  static void visit(std::vector<Patch> &patches, bool write) {
    Visit visit = {patches, write};
    for (Patch &patch : patches) patch.slots = 0;
    dl_iterate_phdr(&Slots::object, &visit);
  }
  // What was there before comes back.
  static void undo() {
    for (size_t n = written().size(); n-- > 0;) put(written()[n].place, written()[n].before, written()[n].protect);
    written().clear();
  }

private:
  struct Visit {
    std::vector<Patch> &patches;
    bool write;
  };
  struct Written {
    void **place;
    void *before;
    bool protect; // RELRO: the linker made it read-only after relocation
  };
  static std::vector<Written> &written() {
    static std::vector<Written> all;
    return all;
  }
  static void put(void **place, void *value, bool protect) {
    const ElfW(Addr) page = sysconf(_SC_PAGESIZE), begin = (ElfW(Addr))place & ~(page - 1);
    if (protect && mprotect((void *)begin, page, PROT_READ | PROT_WRITE)) return;
    *place = value;
    if (protect) mprotect((void *)begin, page, PROT_READ);
  }
  static void write(struct dl_phdr_info *object, ElfW(Addr) at, void *function) {
    const ElfW(Addr) page = sysconf(_SC_PAGESIZE);
    void **const place = (void **)at;
    if (*place == function) return;
    Written one = {place, *place, false};
    for (int k = 0; k < object->dlpi_phnum; k++) {
      const ElfW(Phdr) &part = object->dlpi_phdr[k];
      const ElfW(Addr) from = object->dlpi_addr + part.p_vaddr;
      if (part.p_type == PT_GNU_RELRO && at >= (from & ~(page - 1)) && at < ((from + part.p_memsz) & ~(page - 1)))
        one.protect = true;
    }
    put(place, function, one.protect);
    written().push_back(one);
  }
  static int object(struct dl_phdr_info *object, size_t, void *data) {
    const Visit &visit = *(Visit *)data;
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
    for (int t = 0; t < 2; t++)
      for (size_t n = 0; tables[t] && n < sizes[t]; n++) {
        const ElfW(Rela) &one = tables[t][n];
        const unsigned kind = (unsigned)ELF64_R_TYPE(one.r_info);
        if ((kind != kinds[0] && kind != kinds[1] && kind != kinds[2]) || one.r_addend) continue;
        const char *const name = strings + symbols[ELF64_R_SYM(one.r_info)].st_name;
        if (name[0] != '_' || name[1] != 'Z') continue;
        for (Patch &patch : visit.patches)
          if (!strcmp(name, patch.name)) {
            if (visit.write) write(object, object->dlpi_addr + one.r_offset, patch.function);
            patch.slots++;
          }
      }
    return 0;
  }
};

} // namespace
#endif
