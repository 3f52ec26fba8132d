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

// Messages between the ranks of a run: bytes only.
class Ranks {
public:
  int me = 0, count = 1;
  virtual ~Ranks() {}
  // Before the first message: a rank without the plugin blocks forever in its error exit. Ends the run then.
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
  if (!table) table.reset(new Table(data, path));
  return *table;
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
    checksum_ = crc32(table.fingerprint(), (const char *)numbers, sizeof numbers);
    slips = shear == SLIP_SHEAR;
    if (slips && !HAS_SPRINGS[pair.rule])
      throw std::runtime_error("'shear slip' needs unloading elastic, hertz, thornton, table, etsion or jackson, " +
                               table.path() + " has " + table.text("unloading"));
    return judge_modulus(table, modulus);
  }
  // Throws where friction by pressure would have another contact area than the law's.
  static void require_area(const Table &table) {
    if (table.text("area").empty() && !RULE_KEYS[table.unloading()][0])
      throw std::runtime_error("'friction_pressure' needs the contact area of the law, which " + table.path() +
                               " does not contain: make a table of a former version again, others with the unloading "
                               "rule of the law's paper");
  }
  // Of the contacts that begin under this law and keep so many values: never 0.
  double identity(int values) const { return ONE_SHAPE * (2 * values + (slips ? 2 : 1)) + checksum_; }
  // Whether a contact with another identity goes on: it keeps nothing that depends on the law, and as many values.
  static bool can_continue(double identity, double now, bool keeps) {
    return identity == 0. || (!keeps && std::floor(identity / ONE_SHAPE) == std::floor(now / ONE_SHAPE));
  }
  // After a step with this force [N].
  UnloadingCurve unloading_curve(double force, double overlap, const double *state) const {
    return {force, pair.rule == ELASTIC ? overlap : overlap - state[1], pair.rule != ELASTIC && pair.rule != GIVEN};
  }

private:
  static constexpr double ONE_SHAPE = 4294967296.; // below it is the checksum of law, modulus and roughness
  uint32_t checksum_ = 0;
};

// What a contact keeps of its shear, and its step: levels, or the springs of partial slip.
struct ShearRow {
  int levels = LEVELS, springs = 0; // springs 0: the contact sticks until it slides
  static const int MOST_SIZE = SpringRow::MOST_SIZE;
  int size() const { return springs ? SpringRow::size(springs) : levels_size(levels); }
  // Where the stiffness of the last step is: zero in a contact without shear force.
  int top() const { return (springs ? springs : levels) - 1; }
  bool changes_sign(int number) const {
    return springs ? SpringRow::changes_sign(number, springs) : demlaws::changes_sign(number, levels, levels);
  }
  double energy(double *numbers, double ratio) const {
    return springs ? SpringRow(numbers, springs).energy(ratio) : Levels<0>(numbers, levels).energy();
  }
  // stiffness: the normal one that K_t is `ratio` times of.
  DEMLAWS_INLINE ShearStep step(double stiffness, const UnloadingCurve &curve, double ratio, double limit,
                                const Motion &motion, double *numbers) const {
    return springs ? SpringRow(numbers, springs).step(stiffness, curve, ratio, limit, motion)
                   : shear_step(levels, ratio * stiffness, limit, motion, numbers);
  }
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
