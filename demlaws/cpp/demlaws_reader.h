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

// Number of doubles a contact must keep: the first so many of STATE_NAMES.
constexpr int state_size(Unloading rule) { return STATE_SIZES[rule]; }
// Among them R_p/R, along whose Hertz curve the contact unloads.
constexpr bool keeps_radius(Unloading rule) { return state_size(rule) == 3; }

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
  explicit Table(const std::string &path) { parse(contents(path), path); }

  // Reads the bytes of a file, which messages call `path`; throws std::runtime_error("FILE, line N: reason") and leaves
  // the table unusable then. Where processes share nothing but messages one calls contents(), all get its bytes and
  // parse them.
  void parse(const std::string &data, const std::string &path);
  // The bytes of a file; throws std::runtime_error that names it.
  static std::string contents(const std::string &path);

  const std::string &path() const { return path_; }
  // CRC-32 of the text up to the mark of its last line: tables with one fingerprint are one table.
  uint32_t fingerprint() const { return fingerprint_; }
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
    return number(name == "roughness" ? name : "effective_" + name, otherwise);
  }
  // A law that collapses has one curve for every radius and modulus; another holds for its own contact only.
  bool collapses() const { return text("collapses") == "yes"; }
  Unloading unloading() const { return unloads_; }
  // The lines limit_1, limit_2, ... of the header.
  const std::vector<Limit> &limits() const { return limits_; }

  // The curve to unload along; empty unless unloading() is GIVEN.
  const Curve &unloading_curve() const { return unloading_; }
  // That of first loading.
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

  // That from which a contact unloads to the residual overlap of finite elements (rule JACKSON; laws/etsion.py).
  inline double fitted_area(double u, double s) const {
    const double w = std::min(std::max(u / numbers_[0], 1.), 145.);
    const double growth = s / (u * (1. - 1.02 * (1. - pow((w + 5.9) / 6.9, -0.54))));
    return s * growth * growth;
  }

  // Stiffness of rule LINEAR over E* sqrt(R length), by the largest overlap; of EEPA over E* sqrt(R).
  inline double linear_stiffness(double largest) const {
    const double stiffness = numbers_[0] + numbers_[1] * largest;
    return stiffness <= numbers_[2] ? stiffness : numbers_[2];
  }
  inline double eepa_stiffness() const { return numbers_[0]; }
  inline double eepa_plastic() const { return numbers_[1]; } // plastic over largest overlap

private:
  std::string path_;
  uint32_t fingerprint_ = 0;
  std::map<std::string, std::string> header_;
  std::map<std::string, int> lines_; // where a key stands
  Unloading unloads_ = ELASTIC;
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
  // A whole number of at most 9 digits, without sign or leading zeros; -1: it is none.
  static long whole(const std::string &text) {
    const bool good = !text.empty() && text.size() <= 9 && text[0] != '0';
    return good && text.find_first_not_of("0123456789") == std::string::npos ? strtol(text.c_str(), NULL, 10) : -1;
  }
  // The steps of reading; class Reader of demlaws/curves/table_grammar.py has the same.
  struct Lines {
    std::vector<Row> rows[2]; // of loading and unloading
    double last_force = 0.;
    int into = -1, first_line[2] = {0, 0}, titles = 0, end = 0;
  };
  void read_lines(const std::string &bytes, Lines &lines);
  void read_line(int line, const std::string &body, Lines &lines);
  void read_row(int line, const std::string &body, Lines &lines) const;
  void read_key(int line, const std::string &body);
  void check_keys(const Lines &lines);
  void check_key(const std::string &name, Kind kind, const Lines &lines);
  void check_scales(const Lines &lines);
  void check_limits();
  void build(Curve &curve, int which, const Lines &lines, double until);
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

inline void Table::parse(const std::string &bytes, const std::string &path) {
  path_ = path;
  header_.clear();
  lines_.clear();
  Lines lines;
  read_lines(bytes, lines);
  check_keys(lines);
  check_scales(lines);
  build(loading_, 0, lines, 0.);
  if (yield_s_ >= loading_.last_s()) yield_s_ = HUGE_VAL;
  if (unloads_ != GIVEN) return;
  // its power law goes as far down in force as the other's, so that it stays the stiffer one
  build(unloading_, 1, lines, loading_.seat() > 0. ? 0. : loading_.floor_s());
  reverse_.build_reverse(unloading_);
}

// Header and rows of a file whose check marks fit.
inline void Table::read_lines(const std::string &bytes, Lines &lines) {
  std::string data; // a line may end in CR LF: the CR is no part of the text
  data.reserve(bytes.size());
  for (size_t i = 0; i < bytes.size(); i++)
    if (bytes[i] != '\r' || i + 1 == bytes.size() || bytes[i + 1] != '\n') data += bytes[i];
  const std::string format = FORMAT, head = data.substr(0, data.find('\n')) + "\n";
  if (head != format + "\n")
    fail(1, head.compare(0, format.size() - 1, format, 0, format.size() - 1) == 0
                ? "a table of another format: write it again with this version of demlaws"
                : "not a demlaws table (the first line must be '" + format + "')");
  uint32_t crc = crc32(0, head.data(), head.size());
  int line = 1;
  for (size_t at = std::min(head.size(), data.size()), next; at < data.size(); at = next) {
    line++;
    const size_t newline = std::min(data.find('\n', at), data.size());
    next = newline + 1;
    if (lines.end) fail(line, "text follows the 'end:' line");
    const size_t blank = newline - at < 9 ? newline : newline - 9; // before the mark
    if (blank == newline || data[blank] != ' ') fail(line, "no checksum (a blank and 8 hex digits) ends this line");
    crc = crc32(crc, data.data() + at, blank - at);
    char mark[16];
    snprintf(mark, sizeof mark, " %08x\n", (unsigned)crc);
    if (data.compare(blank, 9, mark, 9) != 0)
      fail(line, "checksum does not match: this line was changed after the table was written; write it again");
    fingerprint_ = crc;
    crc = crc32(crc, mark, 10);
    read_line(line, data.substr(at, blank - at), lines);
  }
  if (!lines.end) fail(line + (data[data.size() - 1] == '\n'), "the file stops before its 'end:' line");
}

// A line without its mark: end, titles, row or key.
inline void Table::read_line(int line, const std::string &body, Lines &lines) {
  if (body.compare(0, 5, "end: ") == 0) {
    const std::string read = std::to_string(lines.rows[0].size() + lines.rows[1].size()) + " rows";
    if (body != "end: " + read) fail(line, "'" + body + "', but " + read + " were read");
    lines.end = line;
  } else if (body == (lines.into < 0 ? "" : "unloading ") + std::string("overlap force stiffness") && lines.into < 1) {
    if (++lines.into == 0) lines.titles = line;
    lines.first_line[lines.into] = line + 1;
  } else if (lines.into >= 0) read_row(line, body, lines);
  else read_key(line, body);
}

// Three numbers with a blank between, within the limits of a table, which must follow the rows before.
inline void Table::read_row(int line, const std::string &body, Lines &lines) const {
  double value[3];
  size_t p = 0;
  for (int i = 0; i < 3; i++) {
    const size_t q = i < 2 ? body.find(' ', p) : body.size();
    if (q == std::string::npos || !plain_number(body.substr(p, q - p), value[i]))
      fail(line, "'" + body + "' is not three numbers with a blank between: overlap, force, stiffness");
    const double largest = i ? LARGEST_ROW_FORCE : LARGEST_ROW_OVERLAP;
    if (!(value[i] >= 1. / largest && value[i] <= largest))
      fail(line, "a value in '" + body + "' is too large or too small");
    p = q + 1;
  }
  const double force = value[1];
  std::vector<Row> &rows = lines.rows[lines.into];
  if (!rows.empty() && !(value[0] > rows.back().u && force > lines.last_force) &&
      !(value[0] == rows.back().u && force >= lines.last_force))
    fail(line, "overlap and force must increase from row to row");
  const double root = cbrt(0.75 * force), s = root * root; // s = (3f/4)^(2/3), ds/du = k / (2 sqrt(s))
  rows.push_back({value[0], s, value[2] / (2. * sqrt(s))});
  lines.last_force = force;
}

inline void Table::read_key(int line, const std::string &body) {
  size_t colon = body.find(": ");
  const bool empty = colon == std::string::npos && body.size() > 1 && body[body.size() - 1] == ':';
  if (empty) colon = body.size() - 1;
  if (colon == std::string::npos || colon == 0) fail(line, "'" + body + "' is not 'key: value'");
  const std::string key = body.substr(0, colon);
  if (has(key)) fail(line, "key '" + key + "' occurs twice");
  header_[key] = empty ? "" : body.substr(colon + 2);
  lines_[key] = line;
}

// Values of the keys that this file needs.
inline void Table::check_keys(const Lines &lines) {
  for (const Key &key : CURVE_KEYS) check_key(key.name, key.kind, lines);
  for (const Key &key : SHARED_KEYS) check_key(key.name, key.kind, lines);
  unloads_ = (Unloading)(std::find(RULE_NAMES, RULE_NAMES + RULES, text("unloading")) - RULE_NAMES);
  const bool yields = std::any_of(YIELD_KEYS, YIELD_KEYS + 4, [this](const Key &key) { return has(key.name); });
  for (const Key &key : YIELD_KEYS)
    if (yields) check_key(key.name, key.kind, lines);
  std::fill(numbers_, numbers_ + 3, 0.);
  for (int i = 0; RULE_KEYS[unloads_][i]; i++) {
    // the second is a growth: it may be 0
    check_key(RULE_KEYS[unloads_][i], i == 1 ? Kind::NOT_NEGATIVE : Kind::POSITIVE, lines);
    numbers_[i] = number(RULE_KEYS[unloads_][i], 0.);
  }
  for (const Key &key : CURVE_KEYS)
    if (unloads_ == GIVEN) check_key(std::string("unloading_") + key.name, key.kind, lines);
  for (const std::string key : {"roughness", "unloading_roughness"}) // not of a contact whose law does not need it
    if (has(key) && (key == "roughness" || unloads_ == GIVEN)) check_key(key, Kind::NOT_NEGATIVE, lines);
  check_limits();
}

inline void Table::check_key(const std::string &name, Kind kind, const Lines &lines) {
  if (!has(name)) fail(lines.titles ? lines.titles : lines.end, "the lines above lack '" + name + "'");
  const std::string value = text(name);
  const long count = whole(value);
  const bool good = kind == Kind::NAME           ? !value.empty()
                    : kind == Kind::BITS         ? count >= 1 && count <= MOST_BITS
                    : kind == Kind::ROWS         ? count >= 2 && count <= MOST_ROWS
                    : kind == Kind::POSITIVE     ? number(name, -1.) > 0.
                    : kind == Kind::NOT_NEGATIVE ? number(name, -1.) >= 0.
                    : kind == Kind::BELOW        ? value == "power" || value == "straight"
                    : kind == Kind::RULE         ? std::count(RULE_NAMES, RULE_NAMES + RULES, value) > 0
                                                 : value == "yes" || value == "no";
  if (!good) fail(lines_[name], name + ": '" + value + "' is not " + KIND_NAMES[(int)kind]);
}

// 'limit_1: above|below|pressure NUMBER REASON', and so on.
inline void Table::check_limits() {
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

// Values that depend on one another: lengths, contacts, bulk yield, the unloading curve.
inline void Table::check_scales(const Lines &lines) {
  if ((number("length_over_roughness", 0.) > 0.) == (number("length_over_radius", 0.) > 0.))
    fail(lines_["length_over_radius"], "one of length_over_roughness and length_over_radius is positive, the other 0");
  for (const std::string prefix : {"", "unloading_"}) {
    if (!prefix.empty() && unloads_ != GIVEN) continue;
    const std::string roughness = prefix + "roughness", radius = prefix + "effective_radius";
    if (!has(roughness) && number("length_over_roughness", 0.) > 0.)
      fail(lines_["length_over_roughness"], "overlaps over the roughness, but no " + roughness + " is given");
    if (number(roughness, 0.) > LARGEST_ROUGHNESS * number(radius, 0.) ||
        !(number(prefix + "effective_modulus", 0.) > LEAST_MODULUS))
      fail(lines_[has(roughness) ? roughness : radius],
           roughness + " is above half the effective radius, or the modulus not above 1e3 Pa");
  }
  yield_s_ = HUGE_VAL;
  yield_area_slope_ = 0.;
  if (has("yield_area")) {
    const double area = number("yield_area", 0.), expected = pow(0.75 * number("yield_force", 0.), 2. / 3.);
    if (!(fabs(area - expected) <= 1e-9 * expected))
      fail(lines_["yield_area"], "yield_area does not go with yield_force");
    yield_s_ = area;
    yield_area_slope_ = number("yield_area_slope", 0.) / 0.75; // by s^1.5, not by f
  }
  if ((unloads_ == GIVEN) != (lines.into == 1))
    fail(lines_["unloading"], "rows of an unloading curve belong to 'unloading: table', and only to it");
}

inline void Table::build(Curve &curve, int which, const Lines &lines, double until) {
  const std::string prefix = which ? "unloading_" : "", count = text(prefix + "rows");
  const std::vector<Row> &rows = lines.rows[which];
  const std::string held = std::to_string(rows.size());
  if (count != held) fail(lines_[prefix + "rows"], prefix + "rows: " + count + ", but the table has " + held);
  const int bits = (int)whole(text(prefix + "bits"));
  const int wrong = Curve::off_grid(rows, bits);
  if (wrong >= 0)
    fail(lines.first_line[which] + wrong,
         "a row is missing before this one, or its overlap is neither on the grid of the header's bits nor one of at "
         "most " +
             std::to_string(MOST_KINKS) + " kinks, an overlap in two rows, between other rows");
  const bool straight = text(prefix + "below_first_row") == "straight";
  if (straight && Curve::exponent(rows[0]) > 1. + 1e-9)
    fail(lines_[prefix + "below_first_row"],
         "straight below the first row, this curve would have a force below 0 at overlap 0");
  curve.build(rows, bits, straight, until);
}

} // namespace demlaws
#endif
