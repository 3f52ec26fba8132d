// demlaws_reader.h: table files of demlaws: rules of unloading, grammar and checks of the file. C++11; part of
// demlaws_table.h.
//
// Licence: GPL-2.0-or-later, as the package demlaws.
#ifndef DEMLAWS_READER_H
#define DEMLAWS_READER_H
#include "demlaws_curve.h"
#include <cerrno>
#include <clocale>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>

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

} // namespace demlaws
#endif
