// demlaws_plugin.h: common parts of the plugins of LIGGGHTS and LAMMPS: messages between the ranks of a run, the tables
// of a process, the law of two materials.
#ifndef DEMLAWS_PLUGIN_H
#define DEMLAWS_PLUGIN_H

#include "demlaws_range.h"
#include "demlaws_slip.h"
#include <cctype>
#include <cmath>
#include <cstring>
#include <map>
#include <memory>
#include <unistd.h>

namespace demlaws {

const int OCTAVES_COMPARED = 16; // of curves, from their last row down

// Messages between the ranks of a run: bytes only.
class Ranks {
public:
  int me = 0, count = 1;
  virtual ~Ranks() {}
  // Before the first message: a rank without the plugin stops with an error and waits for the others for ever, and they
  // for it. Ends the run then.
  void wait_for_all() const {
    if (count == 1) return;
    start();
    for (int n = 0; !arrived(); n++) {
      if (n == 1000 * PATIENCE)
        end("demlaws/table: rank " + std::to_string(me) + " has waited for the others for " + std::to_string(PATIENCE) +
            " s: there is a rank that runs without the plugin; give LD_PRELOAD or LAMMPS_PLUGIN_PATH to all ranks " +
            "(mpirun -x LD_PRELOAD), as `demlaws liggghts run` and `demlaws lammps run` do");
      usleep(1000);
    }
  }
  // Rank 0's bytes to all.
  void share(std::string &bytes) const {
    if (count == 1) return;
    long size = (long)bytes.size();
    broadcast(&size, sizeof size);
    bytes.resize(size);
    if (size) broadcast(&bytes[0], (int)size);
  }
  // What every rank has, in their order.
  template <class T> std::vector<T> gather(const T &mine) const {
    std::vector<T> all(count, mine);
    if (count > 1) collect(&mine, sizeof mine, &all[0]);
    return all;
  }

private:
  static const int PATIENCE = 10; // [s]
  virtual void start() const {}   // a barrier that does not block; where all ranks have the same code it is not needed
  virtual bool arrived() const { return true; }
  virtual void end(const std::string &why) const { throw std::runtime_error(why); } // ends all ranks, whatever they do
  virtual void broadcast(void *bytes, int size) const = 0;
  virtual void collect(const void *mine, int size, void *all) const = 0;
};

// A table, kept as long as its file stays what it was. Rank 0 reads the file and all ranks
// get it: one that cannot see it, or sees another, neither hangs nor differs. Throws on all ranks.
inline const Table &load_table(const Ranks &ranks, const std::string &path) {
  static std::map<std::pair<std::string, uint32_t>, std::unique_ptr<Table>> tables;
  std::string data, problem;
  ranks.wait_for_all();
  if (ranks.me == 0) {
    try {
      data = Table::contents(path);
    } catch (const std::exception &caught) {
      problem = caught.what();
    }
  }
  ranks.share(problem);
  ranks.share(data);
  if (!problem.empty()) throw std::runtime_error(problem);
  std::unique_ptr<Table> &table = tables[std::make_pair(path, crc32(0, data.data(), data.size()))];
  if (!table) {
    std::unique_ptr<Table> fresh(new Table);
    fresh->parse(data, path);
    table = std::move(fresh);
  }
  return *table;
}

// A number to 16 bits, a part in 65,536, as text.
inline std::string rounded(double x) {
  int exponent;
  const long mantissa = std::lround(std::frexp(x, &exponent) * 65536.);
  return std::labs(mantissa) == 65536 ? rounded(std::ldexp(mantissa / 65536., exponent))
                                      : std::to_string(mantissa) + "p" + std::to_string(exponent);
}
// The same of the numbers in a text; a digit within a word is none.
inline std::string rounded(const std::string &text) {
  static const char *const digits = "0123456789";
  std::string out;
  for (size_t at = 0; at < text.size();) {
    const bool begins =
        strchr(digits, text[at]) && !(at && (isalnum((unsigned char)text[at - 1]) || text[at - 1] == '_'));
    size_t end = begins ? std::min(text.find_first_not_of("0123456789.eE+-", at), text.size()) : at + 1;
    double x;
    if (begins && plain_number(text.substr(at, end - at), x)) out += rounded(x);
    else out += text.substr(at, end - at);
    at = end;
  }
  return out;
}
// What histories depend on: law, options, contact, rule, the certified range, and the curves at powers of 2 of the
// overlap, which are rows of every table. Tables of one command have the same, whatever processor made them: they may
// differ in their last bits.
inline uint32_t identity(const Table &table) {
  std::string text = table.text("unloading") + table.text("collapses");
  for (const char *prefix : {"", "unloading_"})
    for (const char *key : {"law", "options", "effective_radius", "effective_modulus", "roughness", "fractal_dimension",
                            "hardness", "range_overlap"})
      text += "\n" + rounded(table.text(std::string(prefix) + key));
  for (const Curve *curve : {&table.loading_curve(), &table.unloading_curve()}) {
    if (curve == &table.unloading_curve() && table.unloading() != GIVEN) continue;
    int exponent;
    std::frexp(curve->last(), &exponent);
    for (int k = 1; k <= OCTAVES_COMPARED; k++) {
      double s, slope;
      curve->evaluate(std::ldexp(1., exponent - k), s, slope);
      text += "\n" + rounded(s);
    }
  }
  return crc32(0, text.data(), text.size());
}

// The law of two materials.
struct Law {
  Pair pair;
  Watch watch;
  bool slips = false; // in parts

  // modulus: E*; roughness [m]. Returns a doubt about the modulus, or ""; throws for a pair that the table does not
  // serve.
  std::string set(const Table &table, double modulus, double roughness, Shear shear) {
    pair = Pair::checked(table, modulus, roughness);
    watch = Watch(pair);
    const float numbers[2] = {(float)modulus, (float)roughness}; // another computer may round a mixed modulus otherwise
    checksum_ = crc32(identity(table), (const char *)numbers, sizeof numbers);
    slips = shear == SLIP_SHEAR;
    if (slips && !HAS_SPRINGS[pair.rule])
      throw std::runtime_error("'shear slip' needs unloading elastic, hertz, thornton, table, etsion or jackson, " +
                               table.path() + " has " + table.text("unloading"));
    return judge_modulus(table, modulus);
  }
  // Of the contacts that begin under this law and keep so many values: never 0.
  double mark(int values) const { return ONE_SHAPE * (2 * values + (slips ? 2 : 1)) + checksum_; }
  // Whether a contact with another mark goes on: it keeps nothing that depends on the law, and as many values.
  static bool goes_on(double mark, double now, bool keeps) {
    return mark == 0. || (!keeps && std::floor(mark / ONE_SHAPE) == std::floor(now / ONE_SHAPE));
  }
  // After a step with this force [N].
  UnloadingCurve unloading_curve(double force, double overlap, const double *state) const {
    return {force, pair.rule == ELASTIC ? overlap : overlap - state[1], pair.rule != ELASTIC && pair.rule != GIVEN};
  }

private:
  static constexpr double ONE_SHAPE = 4294967296.; // below it is the checksum of law, modulus and roughness
  uint32_t checksum_ = 0;
};

// What remains for contacts whose history cannot be continued.
static const std::string FROM_POSITIONS = "start again from positions (write_data, read_data)";

// Of a contact that does not go on.
inline std::string other_law() {
  return "this contact began under another law (table, modulus or roughness of its types) or another line ('levels', "
         "'shear', 'springs', rolling or twisting models), whose numbers it keeps; give bodies another law while they "
         "do not touch, or " +
         FROM_POSITIONS;
}

} // namespace demlaws
#endif
