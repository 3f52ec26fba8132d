// Tables of this process, and numbers in input lines.
#ifndef DEMLAWS_TABLES_H
#define DEMLAWS_TABLES_H

#include "demlaws_rule.h"
#include "ranks.h"
#include <map>
#include <memory>
#include <sstream>

namespace {

inline double number(void *error, const std::string &of, const char *text) {
  char *end;
  const double value = strtod(text, &end);
  if (end == text || *end || !(value - value == 0.))
    raise(error, true, "demlaws/table: " + of + " is '" + text + "', not a finite number");
  return value;
}

// Every table is read once and kept, as long as its file stays what it was. Rank 0 reads it and all ranks get it: one
// that cannot see the file, or sees another, neither hangs nor differs.
class Tables {
public:
  static const demlaws::Table &get(const std::string &path, void *lmp, void *error) {
    static std::map<std::pair<std::string, uint32_t>, std::unique_ptr<demlaws::Table>> tables;
    const Ranks ranks(lmp, error);
    std::string data, problem;
    if (ranks.me == 0) {
      try {
        data = demlaws::Table::contents(path);
      } catch (const std::exception &caught) {
        problem = caught.what();
      }
    }
    ranks.share(problem);
    ranks.share(data);
    std::unique_ptr<demlaws::Table> &table = tables[std::make_pair(path, demlaws::crc32(0, data.data(), data.size()))];
    if (problem.empty() && !table) {
      std::unique_ptr<demlaws::Table> fresh(new demlaws::Table);
      try {
        fresh->parse(data, path);
        table = std::move(fresh);
      } catch (const std::exception &caught) {
        problem = caught.what();
      }
    }
    if (!problem.empty()) raise(error, true, "demlaws/table: " + problem);
    problem = demlaws::attach_rule(*table); // each rank's own
    const std::vector<int> failed = ranks.gather((int)!problem.empty());
    for (size_t rank = 0; rank < failed.size(); rank++)
      if (failed[rank]) {
        std::ostringstream what;
        what << "demlaws/table: rank " << rank << ": ";
        if (problem.empty()) what << "it finds no " << path << ".so, or another than the table was written with";
        raise(error, true, what.str() + problem);
      }
    return *table;
  }
};

} // namespace
#endif
