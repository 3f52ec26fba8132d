// demlaws_rule.h: the code of a user-defined unloading rule (rule OWN of demlaws_table.h). Linux.
//
// `Table.save` writes it beside the table: FILE.so, whose check value and size are in FILE. Where processes share
// nothing but messages each loads the object that it finds itself; `problem` then says on which there is none, or
// another.
#ifndef DEMLAWS_RULE_H
#define DEMLAWS_RULE_H

#include "demlaws_table.h"
#include <dlfcn.h>
#include <map>
#include <sys/mman.h>
#include <unistd.h>

namespace demlaws {

// Loads the object of a table's rule and attaches it; "" where that went well (or the table has no such rule), else
// what is wrong. The checked bytes are loaded: the bytes, not the file again. An object stays loaded.
inline std::string attach_rule(Table &table) {
  if (table.unloading() != OWN) return "";
  static std::map<std::string, OwnRule> loaded;
  const std::string path = table.path() + ".so", mark = table.object();
  std::map<std::string, OwnRule>::const_iterator known = loaded.find(mark);
  if (known == loaded.end()) {
    std::string data;
    try {
      data = Table::contents(path);
    } catch (const std::exception &problem) {
      return std::string(problem.what()) + ": it holds the code of unloading rule '" + table.text("rule") +
             "' and must lie beside the table on every machine; write the table again";
    }
    char found[40];
    snprintf(found, sizeof found, "%08x %zu", (unsigned)crc32(0, data.data(), data.size()), data.size());
    if (mark != found)
      return path + " is not the object that the table was written with (" + found + ", the table has " + mark +
             "); write the table again";
    const int file = memfd_create("demlaws_rule", MFD_CLOEXEC);
    size_t written = 0;
    while (file >= 0 && written < data.size()) {
      const ssize_t now = write(file, data.data() + written, data.size() - written);
      if (now <= 0) break;
      written += now;
    }
    char name[64];
    snprintf(name, sizeof name, "/proc/self/fd/%d", file);
    void *const object = written == data.size() ? dlopen(name, RTLD_NOW | RTLD_LOCAL) : NULL;
    const char *const reason = object ? NULL : dlerror();
    if (file >= 0) close(file);
    if (!object) return path + " cannot be loaded: " + (reason ? reason : "no memory for it");
    OwnRule rule;
    *(void **)&rule.step = dlsym(object, "demlaws_rule_contact");
    *(void **)&rule.energies = dlsym(object, "demlaws_rule_energies");
    if (!rule.step || !rule.energies) return path + " holds no rule of this version of demlaws; write the table again";
    known = loaded.insert(std::make_pair(mark, rule)).first;
  }
  table.attach(&known->second);
  return "";
}

} // namespace demlaws
#endif
