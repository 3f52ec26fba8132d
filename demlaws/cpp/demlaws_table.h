// demlaws_table.h: contact-law tables of demlaws for any DEM code. C++11, this one header, no other dependency.
//
// A table file (written by `demlaws table`) is a normal contact law without units:
//     u = overlap / length,   s(u) = Hertz-equivalent overlap / length,
//     force P = (4/3) E* sqrt(R) S^1.5 with S = s length,   tangent stiffness K = 2 E* sqrt(R S) ds/du.
// With `unloading: table` the file holds a second curve of the same kind, which a contact unloads along.
// One table serves every pair of radii and moduli of a law that collapses; length comes from the roughness.
// docs/table-format.md has the grammar of the file, and what holds below its first row and beyond its last.
//
//     demlaws::Table table("granite.tbl");                        // throws std::runtime_error that names file and line
//     demlaws::Pair pair(table, modulus, roughness);              // E* in Pa, combined rms roughness in m
//     demlaws::State state;                                       // zeros: a virgin contact; keep one for each contact
//     demlaws::Force now = demlaws::step(pair, radius, overlap, state);
//     if (now.outside) ...                                        // overlap beyond the last row: no certified value
//
// Where many processes need a table one reads the bytes, `Table::contents(path)`, and sends them; each then calls
// `table.parse(bytes, path)`. `table.fingerprint()` tells whether two tables, or a restarted run's, are the same.
//
// Licence: GPL-2.0-or-later, as the package demlaws.
#ifndef DEMLAWS_TABLE_H
#define DEMLAWS_TABLE_H

#include <algorithm>
#include <cerrno>
#include <clocale>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace demlaws {

const double LEAST_MODULUS = 1e3;     // admissible E* [Pa], as in demlaws/admissible.py
const double LARGEST_ROUGHNESS = 0.5; // admissible sigma over R

// The first four any law may have; the others are rules of single laws, with numbers of their own in the file. OWN is a
// user-defined rule: code in an object beside the file (demlaws_rule.h).
enum Unloading { ELASTIC = 0, HERTZ = 1, THORNTON = 2, GIVEN = 3, LINEAR = 4, EEPA = 5, ETSION = 6, OWN = 7 };
constexpr int RULES = 7; // that this header has itself

inline const char *unloading_name(int rule) {
  static const char *const names[] = {"elastic", "hertz", "thornton", "table", "linear", "eepa", "etsion", "own"};
  return names[rule];
}

// Number of doubles a contact must keep: the first so many of state_name().
constexpr int state_size(Unloading rule) {
  return rule == ELASTIC ? 0 : rule == THORNTON || rule == ETSION || rule == OWN ? 3 : 2;
}

// Keys of the numbers that a rule needs, without units; NULL beyond the last.
inline const char *rule_key(Unloading rule, int i) {
  static const char *const keys[RULES + 1][4] = {{NULL},
                                                 {NULL},
                                                 {NULL},
                                                 {NULL},
                                                 {"linear_first", "linear_growth", "linear_largest", NULL},
                                                 {"eepa_stiffness", "eepa_plastic", NULL},
                                                 {"etsion_overlap", "etsion_power", NULL},
                                                 {NULL}};
  return keys[rule][i];
}

inline const char *state_name(int i) {
  static const char *const names[] = {"maximum_overlap", "plastic_overlap", "radius_ratio"};
  return names[i];
}

inline bool unloading_from_name(const std::string &name, Unloading &rule) {
  for (int i = ELASTIC; i <= OWN; i++)
    if (name == unloading_name(i)) {
      rule = (Unloading)i;
      return true;
    }
  return false;
}

// CRC-32 of zlib (polynomial 0xEDB88320), continued from an earlier value.
inline uint32_t crc32(uint32_t crc, const char *data, size_t size) {
  crc = ~crc;
  for (size_t i = 0; i < size; i++) {
    crc ^= (unsigned char)data[i];
    for (int k = 0; k < 8; k++) crc = (crc & 1) ? 0xEDB88320u ^ (crc >> 1) : crc >> 1;
  }
  return ~crc;
}

// Grids of 2^bits linear parts in each octave: the part that a positive double lies in, and where a part begins.
inline int64_t grid_number(double x, int bits) {
  int64_t b;
  memcpy(&b, &x, 8);
  return b >> (52 - bits);
}
inline double grid_point(int64_t number, int bits) {
  const int64_t b = number << (52 - bits);
  double x;
  memcpy(&x, &b, 8);
  return x;
}

// One grid cell: s = c[0] + t (c[1] + t (c[2] + t c[3])), t from where the cell begins. Cells are a power of 2 wide.
struct Cell {
  double c[4];
};

// A row of a curve: u, s(u), ds/du.
struct Row {
  double u, s, slope;
};

// A curve s(u): cells on a grid of 2^bits linear parts in each octave, whose number is in the bits of the double u.
class Curve {
public:
  static const int MOST_BITS = 12, MOST_KINKS = 32;
  Curve() : bits_(0), first_(0), count_(0) {}

  // s(u) and its slope from floor() to before last(); returns false outside (then use outside()).
  inline bool look_up(double u, double &s, double &slope) const {
    uint64_t b; // positive doubles have the order of their bits; negative ones and NaN lie beyond all of them
    memcpy(&b, &u, 8);
    uint64_t k = (b >> shift_) - first_;
    k += b >= kink_[0];
    k += b >= kink_[1];
    if (__builtin_expect(b >= kink_[2], 0)) return behind_kinks(u, s, slope);
    if (__builtin_expect(k >= count_, 0)) return false;
    read(k, b & cell_, u, s, slope);
    return true;
  }

  // Below floor(): straight to 0, or to the seat. At the last row: its values. Beyond it: not certified, returns false
  // with the power law of the last row. NaN gives NaN and true.
  bool outside(double u, double &s, double &slope) const {
    if (u != u) {
      s = slope = u;
      return true;
    }
    if (u < floor_) {
      slope = slope_floor_;
      s = seat_ + slope * u;
      return true;
    }
    s = s_last_ * pow(u / u_last_, slope_last_ * u_last_ / s_last_);
    slope = slope_last_ * u_last_ / s_last_ * s / u;
    return u <= u_last_;
  }

  // s(u), slope; false beyond the table.
  inline bool evaluate(double u, double &s, double &slope) const {
    return look_up(u, s, slope) || outside(u, s, slope);
  }

  // Dimensionless work of virgin loading from 0 to u: integral of f du; Gauss quadrature, for output only.
  double energy(double u) const {
    if (!(u > 0.)) return u > 0. || u <= 0. ? 0. : u;
    if (u < u_first_) return energy_below(u);
    const size_t low = std::upper_bound(nodes_.begin() + 1, nodes_.end() - 1, u) - nodes_.begin() - 1;
    return work_[low] + gauss(nodes_[low], u);
  }

  double first() const { return u_first_; }
  double last() const { return u_last_; }
  double last_s() const { return s_last_; }
  // Where the cells below the first row begin, and s there.
  double floor() const { return floor_; }
  double floor_s() const { return seat_ + slope_floor_ * floor_; }
  // s at u = 0+: 0, but for a law that starts from a force.
  double seat() const { return seat_; }
  // ds/du where the curve reaches s, up to its last row.
  double slope_where(double s) const {
    double value, slope;
    evaluate(where(s), value, slope);
    return slope;
  }
  // u at which the curve reaches s, up to its last row: Newton's method between bounds.
  double where(double s) const;
  // d ln s / d ln u of a row: the exponent of the power law below it.
  static double exponent(const Row &row) { return row.u * row.slope / row.s; }

  // Number of the first row that the grid does not allow, with what is wrong; -1: they are a curve.
  static int off_grid(const std::vector<Row> &rows, int bits, std::string &what);
  // From rows on the grid. straight: below the first row; else a power law, for 40 octaves or about down to s =
  // `until`.
  void build(const std::vector<Row> &rows, int bits, bool straight, double until = 0.);
  // The reverse of a curve: u over s - seat, on a grid of its own that ends within the last cell of the curve.
  void build_reverse(const Curve &curve);

private:
  int bits_, shift_;
  uint64_t first_, count_;
  uint64_t cell_;    // the bits of u that its cell begins with
  uint64_t kink_[3]; // bits of the first three that split a cell, or of infinity
  double u_first_, s_first_, power_first_, u_last_, s_last_, slope_last_, floor_, slope_floor_, seat_;
  std::vector<Cell> storage_; // kept so that cells_ can be aligned
  const Cell *cells_;
  std::vector<double> nodes_, work_, kinks_, splits_;

  Curve(const Curve &); // cells_ points into storage_: not copied
  Curve &operator=(const Curve &);

  inline void read(uint64_t cell, uint64_t begin, double u, double &s, double &slope) const {
    const double *const c = cells_[cell].c;
    double t;
    memcpy(&t, &begin, 8);
    t = u - t; // exact
    const double third = t * c[3], second = c[2] + third;
    const double first = c[1] + t * second;
    s = c[0] + t * first;
    slope = first + t * (second + third);
  }
  // As look_up() where three kinks or more that split a cell lie below u.
  __attribute__((noinline)) bool behind_kinks(double u, double &s, double &slope) const {
    const uint64_t b = (uint64_t)grid_number(u, 52);
    uint64_t k = (b >> shift_) - first_ + 3;
    for (size_t i = 3; i < splits_.size() && u >= splits_[i]; i++) k++;
    if (k >= count_) return false;
    read(k, b & cell_, u, s, slope);
    return true;
  }
  static Cell hermite(double t0, double t1, double width, const Row &left, const Row &right);
  void below(std::vector<Cell> &cells, bool straight, double until);
  Row reversed(double y, double beside) const;
  double gauss(double a, double b) const {
    static const double x[4] = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363};
    static const double w[4] = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763};
    const double middle = 0.5 * (a + b), half = 0.5 * (b - a);
    double sum = 0., s, slope;
    for (int i = 0; i < 8; i++) {
      evaluate(middle + (i & 1 ? half : -half) * x[i / 2], s, slope);
      sum += w[i / 2] * (4. / 3.) * s * sqrt(s);
    }
    return half * sum;
  }
  double energy_below(double u) const {
    double s, slope;
    evaluate(u, s, slope);
    if (!(seat_ > 0.)) return (4. / 3.) * s * sqrt(s) * u / (1.5 * power_first_ + 1.);
    return gauss(0., u); // f = (4/3) s^1.5 with s straight in u
  }
};

// A finite number in decimal digits, whatever the locale's decimal point: [+-] digits [. [digits]] [e|E [+-] digits].
inline bool plain_number(const std::string &text, double &x) {
  const size_t first = !text.empty() && (text[0] == '+' || text[0] == '-'), point = text.find('.');
  if (text.find_first_not_of("0123456789.eE+-") != std::string::npos ||
      text.find_first_of("0123456789", first) != first)
    return false; // else strtod would read hexadecimal digits, blanks, a bare fraction
  std::string local = text;
  if (point != std::string::npos) local.replace(point, 1, localeconv()->decimal_point);
  char *end;
  x = strtod(local.c_str(), &end);
  return !*end && x - x == 0.;
}

// Code of a rule OWN, in SI; `first_loading` is the address of a FirstLoading.
struct OwnRule {
  // Writes force, stiffness, and the stiffness with which the contact would unload now.
  void (*step)(int64_t first_loading, double radius, double modulus, double roughness, double overlap, double *state,
               double *answer);
  void (*energies)(int64_t first_loading, double radius, double modulus, double roughness, double overlap,
                   double *state, double *stored_and_dissipated);
};

// A range of force outside which the law's source does not support it, and why. FORCE_ABOVE, FORCE_BELOW: force over
// E* sqrt(R) length^1.5; BULK_YIELD: central pressure over hardness (demlaws/criterion.py).
struct Limit {
  enum Kind { FORCE_ABOVE, FORCE_BELOW, BULK_YIELD } kind;
  double value;
  std::string reason;
};

class Table {
public:
  Table() {}
  explicit Table(const std::string &path) { read(path); }

  // Reads a file; throws std::runtime_error("FILE, line N: reason") and leaves the table unusable then.
  void read(const std::string &path) { parse(contents(path), path); }
  // Reads the bytes of a file, which messages call `path`. Where processes share nothing but messages one calls
  // contents(), all get its bytes and parse them.
  void parse(const std::string &data, const std::string &path);
  // The bytes of a file; throws std::runtime_error that names it.
  static std::string contents(const std::string &path);

  const std::string &path() const { return path_; }
  // CRC-32 of the text up to the mark of its last line: tables with one fingerprint are one table.
  uint32_t fingerprint() const { return fingerprint_; }
  const std::map<std::string, std::string> &header() const { return header_; }
  bool has(const std::string &key) const { return header_.count(key) != 0; }
  std::string text(const std::string &key) const {
    std::map<std::string, std::string>::const_iterator it = header_.find(key);
    return it == header_.end() ? std::string() : it->second;
  }
  // A header value as a number; `otherwise` when the key is absent or not one number.
  double number(const std::string &key, double otherwise) const {
    double x;
    return plain_number(text(key), x) ? x : otherwise;
  }
  // A number of the contact (SI) that the table was made for: "radius", "modulus", "roughness", ...
  double of_contact(const std::string &name, double otherwise) const {
    if (version_ > 2) return number(name == "roughness" ? name : "effective_" + name, otherwise);
    const std::string contact = text("contact"), key = "\"" + name + "\": "; // versions 1 and 2: one line of JSON
    const size_t at = contact.find(key), end = contact.find_first_of(",}", at);
    double x;
    return at != std::string::npos && plain_number(contact.substr(at + key.size(), end - at - key.size()), x)
               ? x
               : otherwise;
  }
  // A law that collapses has one curve for every radius and modulus; another holds for its own contact only.
  bool collapses() const { return text("collapses") == "yes"; }
  int version() const { return version_; }
  Unloading unloading() const { return unloads_; }
  // The lines limit_1, limit_2, ... of the header.
  const std::vector<Limit> &limits() const { return limits_; }
  double last_overlap() const { return loading_.last(); }

  // s(u) and its slope; false beyond the table. See Curve.
  inline bool look_up(double u, double &s, double &slope) const { return loading_.look_up(u, s, slope); }
  bool outside(double u, double &s, double &slope) const { return loading_.outside(u, s, slope); }
  inline bool evaluate(double u, double &s, double &slope) const { return loading_.evaluate(u, s, slope); }

  // u where first loading reaches s, likewise.
  double overlap_where(double s) const { return loading_.where(s); }

  // Code of rule OWN: check value and size of the object that holds it, and what was loaded of it (`attach`).
  std::string object() const { return text("rule_object"); }
  void attach(const OwnRule *rule) { own_ = rule; }
  const OwnRule *own_rule() const { return own_; }

  // The curve to unload along; empty unless unloading() is GIVEN.
  const Curve &unloading_curve() const { return unloading_; }
  const Curve &loading_curve() const { return loading_; }
  // u at which the unloading curve reaches s: its reverse, then one step of Newton's method.
  inline double recover(double s) const {
    const double above = s - unloading_.seat();
    if (above <= 0.) return 0.;
    double u, slope, here;
    reverse_.evaluate(above, u, slope);
    unloading_.evaluate(u, here, slope);
    const double found = u - (slope > 0. ? (here - s) / slope : 0.);
    return found <= 0. ? 0. : found;
  }

  // Squared contact radius over (R length): s, or what Thornton's limit pressure makes of it after yield
  // (a^2 = a_y^2 + (P - P_y)/(pi p_y)).
  inline double area(double s) const {
    if (s <= yield_s_) return s;
    return yield_s_ + (s * sqrt(s) - yield_s_ * sqrt(yield_s_)) * yield_area_slope_;
  }

  // The same of a law that has a contact radius of its own (rule ETSION): by the overlap, not by the force.
  inline double area_of_overlap(double u) const { return u <= numbers_[0] ? u : u * pow(u / numbers_[0], numbers_[1]); }

  // Stiffness of rule LINEAR over E* sqrt(R length), by the largest overlap; of EEPA over E* sqrt(R).
  inline double linear_stiffness(double largest) const {
    const double stiffness = numbers_[0] + numbers_[1] * largest;
    return stiffness <= numbers_[2] ? stiffness : numbers_[2];
  }
  inline double eepa_stiffness() const { return numbers_[0]; }
  inline double eepa_plastic() const { return numbers_[1]; } // plastic over largest overlap

  // Dimensionless work of virgin loading from 0 to u.
  double energy(double u) const { return loading_.energy(u); }

private:
  std::string path_;
  int version_ = 0;
  uint32_t fingerprint_ = 0;
  std::map<std::string, std::string> header_;
  std::map<std::string, int> lines_; // where a key stands
  Unloading unloads_ = ELASTIC;
  const OwnRule *own_ = NULL;
  double numbers_[3]; // numbers of a single law's rule
  Curve loading_, unloading_, reverse_;
  double yield_s_, yield_area_slope_;
  std::vector<Limit> limits_;

  Table(const Table &); // a curve is not copied
  Table &operator=(const Table &);

  void fail(int line, const std::string &what) const {
    std::ostringstream out;
    out << path_ << ", line " << line << ": ";
    for (size_t i = 0; i < what.size(); i++) out << ((unsigned char)what[i] < 0x20 ? '?' : what[i]); // one line
    throw std::runtime_error(out.str());
  }
  enum Kind { NAME, BITS, ROWS, POSITIVE, NOT_NEGATIVE, BELOW, RULE, YES_OR_NO, MARK };
  void check(const std::string &name, Kind kind, int titles);
  void check_curve(const std::string &prefix, int titles);
  // A whole number of at most 9 digits, without sign or leading zeros; -1: it is none.
  static long whole(const std::string &text) {
    const bool good = !text.empty() && text.size() <= 9 && text[0] != '0';
    return good && text.find_first_not_of("0123456789") == std::string::npos ? strtol(text.c_str(), NULL, 10) : -1;
  }
  void read_limits();
  Row read_row(const std::string &body, int line, double &force) const;
  void build(Curve &curve, const std::vector<Row> &rows, const std::string &prefix, int first_line, double until);
};

inline std::string Table::contents(const std::string &path) {
  std::ifstream file(path.c_str(), std::ios::binary);
  if (!file)
    throw std::runtime_error(path + ": cannot be opened (" + strerror(errno) + "); make it with `demlaws table`");
  file.peek(); // of a folder, say
  if (file.bad()) throw std::runtime_error(path + ": cannot be read");
  std::ostringstream data;
  data << file.rdbuf();
  return data.str();
}

// Three numbers with a blank between, within the limits of a table.
inline Row Table::read_row(const std::string &body, int line, double &force) const {
  double value[3];
  size_t p = 0;
  for (int i = 0; i < 3; i++) {
    const size_t q = i < 2 ? body.find(' ', p) : body.size();
    if (q == std::string::npos || !plain_number(body.substr(p, q - p), value[i]))
      fail(line, "'" + body + "' is not three numbers with a blank between: overlap, force, stiffness");
    const double high = i ? 1e200 : 1e60;
    if (!(value[i] >= 1. / high && value[i] <= high))
      fail(line, "a value in '" + body + "' is not between " + (i ? "1e-200 and 1e200" : "1e-60 and 1e60"));
    p = q + 1;
  }
  force = value[1];
  const double root = cbrt(0.75 * force), s = root * root; // s = (3f/4)^(2/3), ds/du = k / (2 sqrt(s))
  const Row row = {value[0], s, value[2] / (2. * sqrt(s))};
  return row;
}

// 'limit_1: above|below|pressure NUMBER REASON', and so on.
inline void Table::read_limits() {
  static const char *const kinds[] = {"above", "below", "pressure"};
  limits_.clear();
  for (;;) {
    const std::string key = "limit_" + std::to_string(limits_.size() + 1), body = text(key);
    if (!has(key)) return;
    const size_t first = body.find(' '), second = body.find(' ', first + 1);
    const size_t kind = std::find(kinds, kinds + 3, body.substr(0, first)) - kinds;
    Limit limit = {(Limit::Kind)kind, 0., second == std::string::npos ? "" : body.substr(second + 1)};
    if (kind == 3 || limit.reason.empty() || !plain_number(body.substr(first + 1, second - first - 1), limit.value) ||
        !(limit.value > 0.))
      fail(lines_[key], key + ": '" + body + "' is not above, below or pressure, a positive number, a reason");
    limits_.push_back(limit);
  }
}

inline void Table::check(const std::string &name, Kind kind, int titles) {
  static const char *const wanted[] = {"a name",
                                       "a whole number from 1 to 12",
                                       "a whole number from 2 to 2000000",
                                       "a positive number",
                                       "a number from 0",
                                       "power or straight",
                                       "an unloading rule that is known here",
                                       "yes or no",
                                       "8 hexadecimal digits and a size"};
  if (!has(name)) fail(titles, "the lines above lack '" + name + "'");
  const std::string value = text(name);
  const long count = whole(value);
  const bool good = kind == NAME           ? !value.empty()
                    : kind == BITS         ? count >= 1 && count <= Curve::MOST_BITS
                    : kind == ROWS         ? count >= 2 && count <= 2000000
                    : kind == POSITIVE     ? number(name, -1.) > 0.
                    : kind == NOT_NEGATIVE ? number(name, -1.) >= 0.
                    : kind == BELOW        ? value == "power" || value == "straight"
                    : kind == RULE         ? unloading_from_name(value, unloads_)
                    : kind == YES_OR_NO    ? value == "yes" || value == "no"
                                           : value.find_first_not_of("0123456789abcdef") == 8 && value[8] == ' ' &&
                                              whole(value.substr(9)) > 0;
  if (!good) fail(lines_[name], name + ": '" + value + "' is not " + wanted[kind]);
}

// The keys of a curve; prefix: "" or "unloading_".
inline void Table::check_curve(const std::string &prefix, int titles) {
  static const struct {
    const char *name;
    Kind kind;
    int version; // of the format: the first that has this key
  } keys[] = {{"law", NAME, 1},
              {"effective_radius", POSITIVE, 3},
              {"effective_modulus", POSITIVE, 3},
              {"roughness", NOT_NEGATIVE, 3},
              {"bits", BITS, 1},
              {"rows", ROWS, 1},
              {"force_error", NOT_NEGATIVE, 1},
              {"stiffness_error", NOT_NEGATIVE, 1},
              {"below_first_row", BELOW, 2}};
  for (const auto &key : keys)
    if (key.version <= version_) check(prefix + key.name, key.kind, titles);
}

inline void Table::parse(const std::string &bytes, const std::string &path) {
  path_ = path;
  header_.clear();
  lines_.clear();
  std::string data; // a line may end in CR LF: the CR is no part of the text
  data.reserve(bytes.size());
  for (size_t i = 0; i < bytes.size(); i++)
    if (bytes[i] != '\r' || i + 1 == bytes.size() || bytes[i + 1] != '\n') data += bytes[i];
  const std::string magic = "# demlaws-table ", first = data.substr(0, data.find('\n'));
  const long version = first.compare(0, magic.size(), magic) == 0 ? whole(first.substr(magic.size())) : -1;
  if (version < 1) fail(1, "not a table of demlaws: the first line must be '# demlaws-table 1', 2 or 3");
  if (version > 3)
    fail(1, "a table of format " + std::to_string(version) +
                ", this reader knows 1 to 3: take a newer demlaws, or write the table again");
  version_ = (int)version;
  const std::string head = first + "\n";
  uint32_t crc = crc32(0, head.data(), head.size());
  int line = 1, titles = 0, ended = 0, first_line[2] = {0, 0};
  std::vector<Row> rows[2];
  double last_force = 0.;
  int into = -1;
  for (size_t at = std::min(head.size(), data.size()), next; at < data.size(); at = next) {
    line++;
    const size_t newline = std::min(data.find('\n', at), data.size());
    next = newline + 1;
    if (ended) fail(line, "text follows the 'end:' line");
    const size_t blank = newline - at < 9 ? newline : newline - 9; // before the mark
    if (blank == newline || data[blank] != ' ') fail(line, "no checksum (a blank and 8 hex digits) ends this line");
    crc = crc32(crc, data.data() + at, blank - at);
    char mark[16];
    snprintf(mark, sizeof mark, " %08x", (unsigned)crc);
    if (data.compare(blank, 9, mark) != 0)
      fail(line, "checksum does not match: this line was changed after the table was written; write it again");
    fingerprint_ = crc;
    crc = crc32(crc, mark, 9);
    crc = crc32(crc, "\n", 1);
    const std::string body = data.substr(at, blank - at);
    if (body.compare(0, 5, "end: ") == 0) {
      const std::string read = std::to_string(rows[0].size() + rows[1].size()) + " rows";
      if (body != "end: " + read) fail(line, "'" + body + "', but " + read + " were read");
      ended = line;
    } else if (into < 0 && body == "overlap force stiffness") {
      titles = line;
      into = 0;
      first_line[0] = line + 1;
    } else if (into == 0 && body == "unloading overlap force stiffness") {
      into = 1;
      first_line[1] = line + 1;
    } else if (into >= 0) {
      double force;
      const Row row = read_row(body, line, force);
      if (!rows[into].empty()) {
        const double before = rows[into].back().u;
        if (!(row.u > before && force > last_force) && !(row.u == before && force >= last_force))
          fail(line, "overlap and force must increase from row to row");
      }
      rows[into].push_back(row);
      last_force = force;
    } else {
      size_t colon = body.find(": ");
      const bool empty = colon == std::string::npos && body.size() > 1 && body[body.size() - 1] == ':';
      if (empty) colon = body.size() - 1;
      if (colon == std::string::npos || colon == 0) fail(line, "'" + body + "' is not 'key: value'");
      const std::string key = body.substr(0, colon);
      if (has(key)) fail(line, "key '" + key + "' occurs twice");
      header_[key] = empty ? "" : body.substr(colon + 2);
      lines_[key] = line;
    }
  }
  if (!ended) fail(line + (data[data.size() - 1] == '\n'), "the file stops before its 'end:' line");

  const int lacking = titles ? titles : ended;
  check_curve("", lacking);
  check("unloading", RULE, lacking);
  check("collapses", YES_OR_NO, lacking);
  check("length", POSITIVE, lacking);
  for (const char *key : {"length_over_roughness", "length_over_radius", "rtol"}) check(key, NOT_NEGATIVE, lacking);
  bool yields = false;
  const auto of_yield = {"yield_overlap", "yield_force", "yield_area", "yield_area_slope"};
  for (const char *key : of_yield) yields = yields || has(key);
  for (const char *key : of_yield)
    if (yields) check(key, POSITIVE, lacking);
  std::fill(numbers_, numbers_ + 3, 0.);
  for (int i = 0; rule_key(unloads_, i); i++) {
    check(rule_key(unloads_, i), i == 1 ? NOT_NEGATIVE : POSITIVE, lacking); // the second is a growth: it may be 0
    numbers_[i] = number(rule_key(unloads_, i), 0.);
  }
  if (unloads_ == OWN) {
    check("rule", NAME, lacking);
    check("rule_object", MARK, lacking);
  }
  if (unloads_ == GIVEN) check_curve("unloading_", lacking);
  if ((number("length_over_roughness", 0.) > 0.) == (number("length_over_radius", 0.) > 0.))
    fail(lines_["length_over_radius"], "one of length_over_roughness and length_over_radius is positive, the other 0");
  for (int i = 0; version_ > 2 && i < 1 + (unloads_ == GIVEN); i++) {
    const std::string prefix = i ? "unloading_" : "";
    if (number(prefix + "roughness", 0.) > LARGEST_ROUGHNESS * number(prefix + "effective_radius", 0.) ||
        !(number(prefix + "effective_modulus", 0.) > LEAST_MODULUS))
      fail(lines_[prefix + "roughness"],
           prefix + "roughness is above half the effective radius, or the modulus not above 1e3 Pa");
  }
  yield_s_ = HUGE_VAL;
  yield_area_slope_ = 0.;
  if (yields) {
    const double area = number("yield_area", 0.), expected = pow(0.75 * number("yield_force", 0.), 2. / 3.);
    if (!(fabs(area - expected) <= 1e-9 * expected))
      fail(lines_["yield_area"], "yield_area does not go with yield_force");
    yield_s_ = area;
    yield_area_slope_ = number("yield_area_slope", 0.) / 0.75; // by s^1.5, not by f
  }
  if ((unloads_ == GIVEN) != (into == 1))
    fail(lines_["unloading"], "rows of an unloading curve belong to 'unloading: table', and only to it");
  read_limits();
  build(loading_, rows[0], "", first_line[0], 0.);
  if (yield_s_ >= loading_.last_s()) yield_s_ = HUGE_VAL;
  if (unloads_ != GIVEN) return;
  // its power law goes as far down in force as the other's, so that it stays the stiffer one
  build(unloading_, rows[1], "unloading_", first_line[1], loading_.seat() > 0. ? 0. : loading_.floor_s());
  reverse_.build_reverse(unloading_);
}

inline void Table::build(Curve &curve, const std::vector<Row> &rows, const std::string &prefix, int first_line,
                         double until) {
  const std::string count = text(prefix + "rows"), held = std::to_string(rows.size());
  if (count != held) fail(lines_[prefix + "rows"], prefix + "rows: " + count + ", but the table has " + held);
  const int bits = (int)whole(text(prefix + "bits"));
  std::string what;
  const int wrong = Curve::off_grid(rows, bits, what);
  if (wrong >= 0) fail(first_line + wrong, what);
  const double exponent = Curve::exponent(rows[0]);
  // version 1 does not say: there a curve that would have a stiffness without bound starts from a force
  const bool straight = version_ == 1 ? exponent < 0.5 : text(prefix + "below_first_row") == "straight";
  if (straight && exponent > 1. + 1e-9)
    fail(lines_[prefix + "below_first_row"],
         "straight below the first row, this curve would have a force below 0 at overlap 0");
  curve.build(rows, bits, straight, until);
}

inline int Curve::off_grid(const std::vector<Row> &rows, int bits, std::string &what) {
  const int n = (int)rows.size();
  int64_t next = grid_number(rows[0].u, bits) + 1;
  int kinks = 0;
  what = "the overlap is not on the grid of the header's bits";
  if (grid_point(next - 1, bits) != rows[0].u) return 0;
  for (int i = 1; i < n; i++) {
    const double u = rows[i].u, coming = grid_point(next, bits);
    if (u == rows[i - 1].u) {
      if (i == 1 || i == n - 1 || u == rows[i - 2].u) {
        what = "a kink, an overlap in two rows, lies between other rows";
        return i;
      }
      if (++kinks > MOST_KINKS) {
        what = "more than " + std::to_string(MOST_KINKS + 0) + " kinks";
        return i;
      }
    } else if (u == coming) next++;
    else if (u > coming) {
      what = "a row is missing before this one";
      return i;
    } else if (i == n - 1 || rows[i + 1].u != u) return i;
  }
  return grid_point(next - 1, bits) == rows[n - 1].u ? -1 : n - 1;
}

// The cubic that has the rows' values and slopes at parts t0 and t1 of a cell of this width in u.
inline Cell Curve::hermite(double t0, double t1, double width, const Row &left, const Row &right) {
  const double h = t1 - t0, end = right.slope * width * h, rise = right.s - left.s;
  double b = left.slope * width * h;
  const bool sliver = h < 1e-3; // a part beside a kink so narrow that a cubic through it would be rounding noise
  const double c = (sliver ? 0.5 * (end - b) : 3. * rise - 2. * b - end) / (h * h);
  const double d = (sliver ? 0. : b + end - 2. * rise) / (h * h * h);
  b /= h;
  Cell cell = {
      {left.s - b * t0 + c * t0 * t0 - d * t0 * t0 * t0, b - 2. * c * t0 + 3. * d * t0 * t0, c - 3. * d * t0, d}};
  for (int i = 1; i < 4; i++)
    for (int k = i; k < 4; k++) cell.c[k] /= width; // exact: a power of 2
  return cell;
}

inline void Curve::build(const std::vector<Row> &rows, int bits, bool straight, double until) {
  bits_ = bits;
  shift_ = 52 - bits_;
  cell_ = ~(((uint64_t)1 << shift_) - 1);
  kinks_.clear();
  splits_.clear();
  nodes_.clear();
  const size_t n = rows.size();
  u_first_ = rows[0].u;
  s_first_ = rows[0].s;
  power_first_ = exponent(rows[0]);
  u_last_ = rows[n - 1].u;
  s_last_ = rows[n - 1].s;
  slope_last_ = rows[n - 1].slope;
  std::vector<Cell> cells;
  below(cells, straight && power_first_ < 1. - 1e-9, until); // Hertz is straight from 0
  for (size_t i = 0; i + 1 < n; i++) {
    const double u0 = rows[i].u, u1 = rows[i + 1].u;
    const int64_t cell = grid_number(u0, bits_);
    const double a = grid_point(cell, bits_), width = grid_point(cell + 1, bits_) - a;
    if (u1 == u0) { // a kink
      kinks_.push_back(u0);
      if (u0 != a) splits_.push_back(u0); // one on a grid point splits no cell
      continue;
    }
    cells.push_back(hermite((u0 - a) / width, (u1 - a) / width, width, rows[i], rows[i + 1]));
    nodes_.push_back(u0);
  }
  nodes_.push_back(u_last_);
  for (size_t i = 0; i < 3; i++) {
    const double split = i < splits_.size() ? splits_[i] : HUGE_VAL;
    memcpy(&kink_[i], &split, 8);
  }
  storage_.resize(cells.size() + 1);
  const uintptr_t raw = (uintptr_t)&storage_[0];
  Cell *const aligned = (Cell *)((raw + 31) & ~(uintptr_t)31);
  std::copy(cells.begin(), cells.end(), aligned);
  cells_ = aligned;
  count_ = cells.size();
  work_.assign(nodes_.size(), 0.);
  work_[0] = energy_below(u_first_);
  for (size_t i = 1; i < nodes_.size(); i++) work_[i] = work_[i - 1] + gauss(nodes_[i - 1], nodes_[i]);
}

// Cells below the first row, so that reading there takes no pow(): a power law, or straight to a force at overlap 0.
inline void Curve::below(std::vector<Cell> &cells, bool straight, double until) {
  double octaves = 40.;
  if (until > 0. && !straight) octaves = std::min(std::max(1., log2(s_first_ / until) / power_first_), 200.);
  const int64_t last = grid_number(u_first_, bits_);
  octaves = std::min(octaves, std::max(1., log2(u_first_ / 1e-90))); // a cell's coefficients are finite numbers
  first_ = (uint64_t)(last - (int64_t)nearbyint(octaves * (double)(1 << bits_)));
  floor_ = grid_point((int64_t)first_, bits_);
  seat_ = straight ? s_first_ * (1. - power_first_) : 0.;
  Row left = {0., 0., 0.};
  for (int64_t cell = (int64_t)first_; cell <= last; cell++) {
    const double u = grid_point(cell, bits_);
    Row right = {u, s_first_ * pow(u / u_first_, power_first_), 0.};
    right.slope = power_first_ * right.s / u;
    if (straight) {
      right.slope = power_first_ * s_first_ / u_first_;
      right.s = seat_ + right.slope * u;
    }
    if (cell == (int64_t)first_) slope_floor_ = straight ? right.slope : right.s / u;
    else {
      const double width = u - left.u;
      const Cell line = {{left.s, right.slope, 0., 0.}};
      cells.push_back(straight ? line : hermite(0., 1., width, left, right));
    }
    left = right;
  }
}

inline double Curve::where(double s) const {
  double low = 0., high = u_last_, value, slope;
  if (s < s_first_) high = u_first_;
  double u = 0.5 * high;
  for (int i = 0; i < 200 && low < high; i++) {
    evaluate(u, value, slope);
    if (value > s) high = u;
    else low = u;
    double next = slope > 0. ? u - (value - s) / slope : low;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    if (fabs(next - u) <= 1e-16 * u) break;
    u = next;
  }
  return u;
}

inline void Curve::build_reverse(const Curve &curve) {
  const int bits = curve.bits_ + 1; // so that one step of Newton's method is exact to rounding
  // from where the curve begins to be straight: the reverse of a straight line is one
  const double seat = curve.seat_, lowest = seat > 0. ? curve.s_first_ - seat : curve.floor_s();
  const int64_t begin = grid_number(lowest, bits), end = grid_number(curve.s_last_ - seat, bits);
  std::vector<Row> rows;
  size_t next = 0;
  for (int64_t cell = begin; cell <= end; cell++) {
    const double y = grid_point(cell, bits);
    bool corner_here = false;
    for (; next < curve.kinks_.size(); next++) { // a corner is in two rows, with the slopes on its either side
      double s, slope;
      curve.evaluate(curve.kinks_[next], s, slope);
      const double corner = s - seat;
      if (corner > y || (corner == y && cell == end)) break;
      if (rows.empty()) continue;
      rows.push_back(curve.reversed(corner, 1. - 1e-14));
      rows.push_back(curve.reversed(corner, 1. + 1e-14));
      rows.back().s = rows[rows.size() - 2].s;
      corner_here = corner == y;
    }
    if (!corner_here) rows.push_back(curve.reversed(y, 1.));
  }
  build(rows, bits, seat > 0., rows[0].s);
}

inline Row Curve::reversed(double y, double beside) const {
  Row row = {y, where(y * beside + seat_), 0.};
  double s, slope;
  evaluate(row.s, s, slope);
  row.slope = 1. / slope;
  return row;
}

// What the contacts between two materials share.
struct Pair {
  const Table *table = NULL;
  Unloading rule = ELASTIC;
  double modulus = 0.;        // effective modulus E* [Pa]
  double length = 0.;         // [m]; 0: length_per_radius * R
  double inverse_length = 0.; // [1/m]; where length is 0, of length_per_radius
  double length_per_radius = 0.;
  double only_radius = 0.; // > 0: the only R that the table is valid for (see checked)
  double sigma = 0.;       // roughness [m], for rule OWN; of the table's contact by default
  double metre = 1.,
         pascal = 1.; // in the units of the lengths and moduli given here, for rule OWN, which knows SI only

  Pair() {}
  // roughness: combined rms roughness sigma [m]; without it the length of the file is taken.
  Pair(const Table &t, double effective_modulus, double roughness = 0.)
      : table(&t), rule(t.unloading()), modulus(effective_modulus),
        sigma(roughness > 0. ? roughness : t.of_contact("roughness", 0.)) {
    if (rule == OWN && !t.own_rule())
      throw std::runtime_error(t.path() + ": its unloading rule '" + t.text("rule") +
                               "' is user-defined code in an object beside the file, which this engine does not load");
    const double over_roughness = t.number("length_over_roughness", 0.);
    if (t.number("length_over_radius", 0.) > 0.) length_per_radius = t.number("length_over_radius", 0.);
    else if (roughness > 0. && over_roughness > 0.) length = over_roughness * roughness;
    else length = t.number("length", 0.);
    if (!(length > 0.) && !(length_per_radius > 0.))
      throw std::runtime_error(t.path() + ": the header gives no length; pass the roughness of the pair [m]");
    if (!(modulus > 0.)) throw std::runtime_error(t.path() + ": the effective modulus must be positive [Pa]");
    inverse_length = 1. / (length > 0. ? length : length_per_radius);
  }
  inline double length_of(double radius) const { return length > 0. ? length : length_per_radius * radius; }

  // As the constructor; a law that does not collapse is refused for another modulus or roughness than its table's, and
  // only_radius is set.
  static Pair checked(const Table &t, double effective_modulus, double roughness = 0.) {
    Pair pair(t, effective_modulus, t.collapses() ? roughness : 0.);
    if (t.collapses()) return pair;
    const double made_for = t.of_contact("modulus", 0.);
    pair.only_radius = t.of_contact("radius", 0.);
    std::ostringstream what;
    what << t.path() << " holds for one contact only, since law " << t.text("law") << " does not collapse";
    if (!(pair.only_radius > 0.) || !(made_for > 0.)) what << ", and names no radius and modulus";
    else if (!(fabs(effective_modulus - made_for) <= 1e-6 * made_for))
      what << ": for the effective modulus " << made_for << " Pa, not " << effective_modulus
           << " Pa; make a table of this pair";
    else if (roughness > 0.) what << ": for its own roughness; give no roughness with it";
    else return pair;
    throw std::runtime_error(what.str());
  }
  // The same in an engine's units, of which a metre and a pascal are so many; the modulus is given in them.
  void in_units(double effective_modulus, double per_metre, double per_pascal) {
    modulus = effective_modulus;
    length *= metre = per_metre;
    inverse_length = 1. / (length > 0. ? length : length_per_radius);
    only_radius *= per_metre;
    pascal = per_pascal;
  }
  inline bool serves(double radius, double tolerance) const {
    return !(only_radius > 0.) || fabs(radius - only_radius) <= tolerance * only_radius;
  }
};

struct State {
  double maximum_overlap = 0., plastic_overlap = 0., radius_ratio = 0.;
};

struct Force {
  double force, stiffness;
  bool outside;     // the overlap lies beyond the table: force is an uncertified extrapolation
  double unloading; // of a rule OWN: the stiffness with which it would unload from here; else 0
};

// First loading of one contact, for a rule OWN; SI. The pointers come first: the rule finds them by their place.
struct FirstLoading {
  void (*at)(const FirstLoading *, double overlap, double *found); // force, stiffness, Hertz-equivalent overlap, a^2/R
  double (*inverse)(const FirstLoading *, double force);
  double (*energy)(const FirstLoading *, double overlap);
  const Table &table;
  double radius, modulus, roughness, length, newton;
  mutable bool outside; // whether an overlap beyond the table was asked for

  FirstLoading(const Pair &pair, double engine_radius)
      : at(&read), inverse(&reverse), energy(&work), table(*pair.table), radius(engine_radius / pair.metre),
        modulus(pair.modulus / pair.pascal), roughness(std::max(pair.sigma, 1e-40 * radius)),
        length(pair.length_of(engine_radius) / pair.metre), newton(pair.pascal * pair.metre * pair.metre),
        outside(false) {}
  int64_t address() const { return (int64_t)(intptr_t)this; }

private:
  static void read(const FirstLoading *p, double overlap, double *found) {
    double s, slope;
    const double u = overlap / p->length;
    if (!p->table.look_up(u, s, slope) && !p->table.outside(u, s, slope)) p->outside = true;
    const double root = p->modulus * sqrt(p->radius * s * p->length);
    found[0] = (4. / 3.) * root * s * p->length;
    found[1] = 2. * root * slope;
    found[2] = s * p->length;
    found[3] = p->table.area(s) * p->length;
  }
  static double reverse(const FirstLoading *p, double force) {
    const double root = cbrt(0.75 * force / (p->modulus * sqrt(p->radius)));
    return p->table.overlap_where(root * root / p->length) * p->length;
  }
  static double work(const FirstLoading *p, double overlap) {
    return p->modulus * sqrt(p->radius * p->length) * p->length * p->length * p->table.energy(overlap / p->length);
  }
};

inline Force own_step(const Pair &pair, double radius, double overlap, double *state, bool update) {
  const FirstLoading loading(pair, radius);
  double now[3] = {state[0], state[1], state[2]}, found[3] = {0., 0., 0.};
  pair.table->own_rule()->step(loading.address(), loading.radius, loading.modulus, loading.roughness,
                               overlap / pair.metre, now, found);
  if (update && found[0] == found[0])
    for (int i = 0; i < 3; i++) state[i] = now[i];
  const double stiffness = loading.newton / pair.metre;
  const Force force = {found[0] * loading.newton, found[1] * stiffness, loading.outside,
                       std::max(0., found[2] * stiffness)};
  return force;
}

// One step of one contact. `state` points to state_size(rule) doubles: maximum overlap [m], plastic overlap [m],
// radius ratio R_p / R; it is written only when `update` is true. overlap <= 0 clears it. RULE is known when compiled.
// inverse_radius: 1 / radius where the engine has it before the radius.
template <Unloading RULE>
inline Force step_rule(const Pair &pair, double radius, double overlap, double *state, bool update,
                       double inverse_radius = 0.) {
  Force now = {0., 0., false, 0.};
  if (overlap <= 0.) {
    if (update)
      for (int i = 0; i < state_size(RULE); i++) state[i] = 0.;
    return now;
  }
  if (RULE == OWN) return own_step(pair, radius, overlap, state, update);
  double hertz_overlap, slope = 1., effective_radius = radius;
  const bool loads = RULE == ELASTIC || !(overlap < state[0]); // NaN, too
  double length = 0., inverse_length = 0.;
  if (RULE == GIVEN || RULE == LINEAR || loads) {
    length = pair.length;
    inverse_length = pair.inverse_length;
    if (!(length > 0.)) {
      length = pair.length_per_radius * radius;
      inverse_length *= inverse_radius > 0. ? inverse_radius : 1. / radius;
    }
  }
  if (loads) {
    double s;
    if (!pair.table->look_up(overlap * inverse_length, s, slope))
      now.outside = !pair.table->outside(overlap * inverse_length, s, slope);
    hertz_overlap = s * length;
    if (RULE != ELASTIC && update && s == s) {
      state[0] = overlap;
      if (RULE == HERTZ) state[1] = overlap - hertz_overlap;
      else if (RULE == GIVEN) state[1] = overlap - pair.table->recover(s) * length;
      else if (RULE == LINEAR) // P/k2
        state[1] = overlap - (4. / 3.) * s * sqrt(s) / pair.table->linear_stiffness(overlap * inverse_length) * length;
      else if (RULE == EEPA) state[1] = pair.table->eepa_plastic() * overlap;
      else {
        // R_p/R = (area/s)^1.5, recoverable overlap s (R/R_p)^(1/3)
        const double area =
            RULE == ETSION ? pair.table->area_of_overlap(overlap * inverse_length) : pair.table->area(s);
        const double ratio = s / area;
        state[1] = overlap - hertz_overlap * sqrt(ratio);
        state[2] = 1. / (ratio * sqrt(ratio));
      }
    }
  } else {
    hertz_overlap = overlap - state[1];
    if (hertz_overlap <= 0.) return now;
    if (RULE == LINEAR) {
      now.stiffness = pair.modulus * sqrt(radius * length) * pair.table->linear_stiffness(state[0] * inverse_length);
      now.force = now.stiffness * hertz_overlap;
      return now;
    }
    if (RULE == EEPA) {
      const double k2 = pair.modulus * sqrt(radius) * pair.table->eepa_stiffness(), root = sqrt(overlap);
      now.force = k2 * (root * overlap - sqrt(state[1]) * state[1]);
      now.stiffness = 1.5 * k2 * root;
      return now;
    }
    if (RULE == GIVEN) {
      double s;
      pair.table->unloading_curve().evaluate(hertz_overlap * inverse_length, s, slope);
      hertz_overlap = s * length;
    }
    if (RULE == THORNTON || RULE == ETSION) effective_radius *= state[2];
  }
  const double root = pair.modulus * sqrt(effective_radius * hertz_overlap);
  now.force = (4. / 3.) * root * hertz_overlap;
  now.stiffness = 2. * root * slope;
  return now;
}

inline Force step(const Pair &pair, double radius, double overlap, double *state, bool update = true,
                  double inverse_radius = 0.) {
  if (pair.rule == ELASTIC) return step_rule<ELASTIC>(pair, radius, overlap, state, update, inverse_radius);
  if (pair.rule == HERTZ) return step_rule<HERTZ>(pair, radius, overlap, state, update, inverse_radius);
  if (pair.rule == THORNTON) return step_rule<THORNTON>(pair, radius, overlap, state, update, inverse_radius);
  if (pair.rule == LINEAR) return step_rule<LINEAR>(pair, radius, overlap, state, update, inverse_radius);
  if (pair.rule == EEPA) return step_rule<EEPA>(pair, radius, overlap, state, update, inverse_radius);
  if (pair.rule == ETSION) return step_rule<ETSION>(pair, radius, overlap, state, update, inverse_radius);
  if (pair.rule == OWN) return step_rule<OWN>(pair, radius, overlap, state, update, inverse_radius);
  return step_rule<GIVEN>(pair, radius, overlap, state, update, inverse_radius);
}

inline Force step(const Pair &pair, double radius, double overlap, State &state) {
  return step(pair, radius, overlap, &state.maximum_overlap);
}

// Integral of x^1.5 - plastic^1.5 from the plastic overlap, as a product: the difference of its terms would cancel.
inline double eepa_energy(double overlap, double plastic) {
  const double a = sqrt(overlap), b = sqrt(plastic);
  return 0.2 * (a - b) * (a - b) * (a * a * (2. * a + 4. * b) + b * b * (6. * a + 3. * b));
}

// The normal stiffness that the tangential stiffness K_t of an elastic contact is a multiple of (docs/shear.md); SLIP:
// that of ELASTIC, with partial slip (demlaws_slip.h).
enum Shear { ELASTIC_SHEAR = 1, LOADING_SHEAR = 2, SLIP_SHEAR = 3 }; // restart files have the numbers

inline bool shear_from_name(const std::string &name, Shear &shear) {
  shear = name == "loading" ? LOADING_SHEAR : name == "slip" ? SLIP_SHEAR : ELASTIC_SHEAR;
  return shear != ELASTIC_SHEAR || name == "elastic";
}

// That stiffness [N/m], from the result of step_rule and the state that it left (or, with `update` false, found): the
// stiffness with which the contact would unload now, or that of first loading at the force now carried.
template <Unloading RULE>
inline double shear_stiffness(Shear shear, const Pair &pair, double radius, double overlap, const Force &now,
                              const double *state) {
  if (RULE == ELASTIC || !(now.force > 0.)) return now.stiffness;
  if (shear == SLIP_SHEAR) shear = ELASTIC_SHEAR;
  if (RULE == OWN && shear == ELASTIC_SHEAR) return now.unloading;
  const bool loads = RULE != OWN && !(overlap < state[0]); // what a rule OWN remembers is its own
  if (shear == ELASTIC_SHEAR) {
    if (!loads) return now.stiffness;
    const bool known = overlap == state[0];
    if ((RULE <= THORNTON || RULE == ETSION) && known) {
      const double recoverable =
          overlap - state[1]; // K = 1.5 P / recoverable overlap, where rounding leaves some of it
      if (recoverable > 1e-9 * overlap) return 1.5 * now.force / recoverable;
      const double root = sqrt(RULE == HERTZ ? radius : radius * state[2]);
      return 2. * pair.modulus * root * cbrt(0.75 * now.force / (pair.modulus * root));
    }
    double own[3] = {0., 0., 0.};
    for (int i = 0; i < state_size(RULE); i++) own[i] = state[i];
    if (!known) step_rule<RULE>(pair, radius, overlap, own, true);
    return step_rule<RULE>(pair, radius, overlap * (1. - 1. / 68719476736.), own, false).stiffness; // 2^-36 below
  }
  if (loads) return now.stiffness;
  const double length = pair.length_of(radius), root = cbrt(0.75 * now.force / (pair.modulus * sqrt(radius)));
  return 2. * pair.modulus * sqrt(radius) * root * pair.table->loading_curve().slope_where(root * root / length);
}

inline double shear_stiffness(Shear shear, const Pair &pair, double radius, double overlap, const Force &now,
                              const double *state) {
  if (pair.rule == ELASTIC) return shear_stiffness<ELASTIC>(shear, pair, radius, overlap, now, state);
  if (pair.rule == HERTZ) return shear_stiffness<HERTZ>(shear, pair, radius, overlap, now, state);
  if (pair.rule == THORNTON) return shear_stiffness<THORNTON>(shear, pair, radius, overlap, now, state);
  if (pair.rule == LINEAR) return shear_stiffness<LINEAR>(shear, pair, radius, overlap, now, state);
  if (pair.rule == EEPA) return shear_stiffness<EEPA>(shear, pair, radius, overlap, now, state);
  if (pair.rule == ETSION) return shear_stiffness<ETSION>(shear, pair, radius, overlap, now, state);
  if (pair.rule == OWN) return shear_stiffness<OWN>(shear, pair, radius, overlap, now, state);
  return shear_stiffness<GIVEN>(shear, pair, radius, overlap, now, state);
}

// Work that a contact with a history gives back from this overlap on, along the curve that it unloads along [J].
inline double given_back(const Pair &pair, double radius, double overlap, const double *state) {
  const double length = pair.length_of(radius), left = std::max(0., overlap - state[1]);
  if (pair.rule == LINEAR)
    return 0.5 * pair.modulus * sqrt(radius * length) * pair.table->linear_stiffness(state[0] / length) * left * left;
  if (pair.rule == EEPA)
    return pair.modulus * sqrt(radius) * pair.table->eepa_stiffness() * eepa_energy(overlap, state[1]);
  // a law with a seating load has a negative plastic overlap: its part below zero overlap never comes back
  const double below = std::max(0., -state[1]);
  if (pair.rule == GIVEN) {
    const Curve &curve = pair.table->unloading_curve();
    return pair.modulus * sqrt(radius) * length * length * sqrt(length) *
           (curve.energy(left / length) - curve.energy(below / length));
  }
  const double r = pair.rule == THORNTON || pair.rule == ETSION ? radius * state[2] : radius;
  return (8. / 15.) * pair.modulus * sqrt(r) * (left * left * sqrt(left) - below * below * sqrt(below));
}

// Energies of one contact since it was made [J]: what it would give back, and what its plastic flow took.
inline void stored_and_dissipated(const Pair &pair, double radius, double overlap, const double *state, double &stored,
                                  double &dissipated) {
  stored = dissipated = 0.;
  const double length = pair.length_of(radius);
  const double scale = pair.modulus * sqrt(radius) * length * length * sqrt(length);
  if (pair.rule == ELASTIC) {
    if (overlap > 0.) stored = scale * pair.table->energy(overlap / length);
    return;
  }
  if (pair.rule == OWN) {
    if (state[0] == 0. && state[1] == 0. && state[2] == 0.) return;
    const FirstLoading loading(pair, radius);
    double own[3] = {state[0], state[1], state[2]}, found[2] = {0., 0.};
    pair.table->own_rule()->energies(loading.address(), loading.radius, loading.modulus, loading.roughness,
                                     overlap / pair.metre, own, found);
    stored = found[0] * loading.newton * pair.metre;
    dissipated = found[1] * loading.newton * pair.metre;
    return;
  }
  if (!(state[0] > 0.)) return;
  if (overlap > 0. && overlap > state[1]) stored = std::max(0., given_back(pair, radius, overlap, state));
  dissipated = scale * pair.table->energy(state[0] / length) - given_back(pair, radius, state[0], state);
}

} // namespace demlaws
#endif
