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
// E* sqrt(R) length^1.5; BULK_YIELD: central pressure over hardness (demlaws/solvers/criterion.py).
struct Limit {
  enum Kind { FORCE_ABOVE, FORCE_BELOW, BULK_YIELD } kind;
  double value;
  std::string reason;
};

class Table {
public:
  // Of the bytes of a file, which messages call `path`; throws std::runtime_error("FILE, line N: reason"). Where
  // processes share nothing but messages one calls contents(), and all get its bytes.
  Table(const std::string &bytes, const std::string &path);
  explicit Table(const std::string &path) : Table(contents(path), path) {}
  // The bytes of a file; throws std::runtime_error that names it.
  static std::string contents(const std::string &path);

  const std::string &path() const { return path_; }
  // CRC-32 of the text: tables with one fingerprint are one table.
  uint32_t fingerprint() const { return fingerprint_; }
  // The text of a key of the loading curve; "" where it is absent.
  std::string text(const std::string &key) const { return sections_[0].text(key); }
  // The same as a number; `otherwise` where it is absent or not one number.
  double number(const std::string &key, double otherwise) const { return sections_[0].number(key, otherwise); }
  // Whether overlaps are divided by sigma; else by R.
  bool scales_with_sigma() const { return text("length") == "sigma"; }
  // A law that collapses has one curve for every radius and modulus; another holds for its own contact only.
  bool collapses() const { return text("collapses") == "yes"; }
  Unloading unloading() const { return unloads_; }
  // The keys limit_1, limit_2, ... of the header.
  const std::vector<Limit> &limits() const { return limits_; }

  // The curve to unload along; empty unless unloading() is GIVEN.
  const Curve &unloading_curve() const { return unloading_; }
  // That of first loading.
  const Curve &loading_curve() const { return loading_; }
  // u at which the unloading curve reaches s: its reverse, then one step of Newton's method.
  inline double inverse_near(double s) const {
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
    return yield_s_ + (s * sqrt(s) - yield_s_ * sqrt(yield_s_)) * yield_slope_;
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
  // Keys and rows of one curve; class Section of demlaws/curves/table_grammar.py has the same steps.
  struct Entry {
    std::string key, text;
    int line;
  };
  struct Section {
    std::vector<Entry> header;
    std::vector<Row> rows;
    double force = 0., stiffness = 0.; // of the last row
    int first_row = 0;
    const Entry *find(const std::string &key) const {
      for (const Entry &one : header)
        if (one.key == key) return &one;
      return NULL;
    }
    std::string text(const std::string &key) const { return find(key) ? find(key)->text : std::string(); }
    double number(const std::string &key, double otherwise = 0.) const {
      double x;
      return plain_number(text(key), x) ? x : otherwise;
    }
    int line(const std::string &key) const { return find(key)->line; }
  };

  std::string path_;
  uint32_t fingerprint_ = 0;
  Section sections_[2]; // loading, unloading
  int last_ = 0;        // the one that is read
  Unloading unloads_ = ELASTIC;
  double numbers_[3]; // numbers of a single law's rule
  Curve loading_, unloading_, reverse_;
  double yield_s_, yield_slope_;
  std::vector<Limit> limits_;

  Table(const Table &); // a curve is not copied
  Table &operator=(const Table &);

  void fail(int line, const std::string &what) const {
    std::ostringstream out;
    out << path_ << ", line " << line << ": ";
    for (size_t i = 0; i < what.size() && i < 400; i++) out << ((unsigned char)what[i] < 0x20 ? '?' : what[i]);
    throw std::runtime_error(out.str());
  }
  void read_key(int line, const std::string &body);
  void read_row(int line, const std::string &body);
  void check_header(int line);
  void check_value(const Entry &entry, const Key *key) const;
  void check_limit(const Entry &entry);
  void build(Curve &curve, const Section &section, int end, double until);
  void refuse_unless_passive() const; // demlaws_contact.h
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

inline Table::Table(const std::string &bytes, const std::string &path) : path_(path) {
  std::vector<std::string> lines(1);
  for (size_t i = 0; i < bytes.size(); i++)
    if (bytes[i] == '\n') lines.push_back("");
    else if (bytes[i] != '\r' || i + 1 == bytes.size() || bytes[i + 1] != '\n') lines.back() += bytes[i];
  if (lines.size() > 1 && lines.back().empty()) lines.pop_back();
  const std::string format = FORMAT;
  if (lines[0] != format)
    fail(1, lines[0].compare(0, format.size() - 1, format, 0, format.size() - 1) == 0
                ? "a table of another format: make it again with 'demlaws table --law NAME ... --out FILE'"
                : "not a demlaws table (the first line must be '" + format + "')");
  const int end = (int)lines.size();
  for (int i = 0; i + 1 < end || i == 0; i++)
    fingerprint_ = crc32(crc32(fingerprint_, lines[i].data(), lines[i].size()), "\n", 1);
  char expected[16];
  snprintf(expected, sizeof expected, "crc: %08x", (unsigned)fingerprint_);
  const std::string &last = lines.back();
  if (last.compare(0, 5, expected, 5) != 0 || last.size() != 13 ||
      last.find_first_not_of("0123456789abcdef", 5) != std::string::npos)
    fail(end, "the last line is not the checksum, 'crc: ...': the file was cut short");
  if (last != expected) fail(end, "the checksum does not match: the text above was changed; make the table again");
  for (int i = 1; i + 1 < end; i++)
    lines[i].find(": ") == std::string::npos ? read_row(i + 1, lines[i]) : read_key(i + 1, lines[i]);
  const bool given = text("unloading") == RULE_NAMES[GIVEN];
  if (given != (last_ == 1)) sections_[0].rows.clear();
  build(loading_, sections_[0], end, 0.);
  if (yield_s_ >= loading_.last_s()) yield_s_ = HUGE_VAL;
  if (given) {
    // its power law goes as far down in force as the other's, so that it stays the stiffer one
    build(unloading_, sections_[1], end, loading_.seat() > 0. ? 0. : loading_.floor_s());
    reverse_.build_reverse(unloading_);
    if (loading_.last_s() - unloading_.seat() > reverse_.last())
      fail(sections_[1].first_row, "the unloading curve ends below the last force of the loading");
  }
  refuse_unless_passive();
}

inline void Table::read_key(int line, const std::string &body) {
  if (!sections_[last_].rows.empty() && last_ == 0) last_ = 1;
  Section &section = sections_[last_];
  const size_t colon = body.find(": ");
  const std::string key = body.substr(0, colon);
  if (!section.rows.empty()) fail(line, "'" + key + "' follows the rows of the last curve");
  if (section.find(key)) fail(line, "key '" + key + "' occurs twice");
  section.header.push_back({key, body.substr(colon + 2), line});
}

// Values of the keys, all of which this curve needs or takes. line: that of the first row.
inline void Table::check_header(int line) {
  const Section &section = sections_[last_];
  const std::string unloading = section.text("unloading");
  std::vector<std::string> laws(1, section.text("law"));
  for (const LawKey &one : LAW_KEYS)
    if (one.law == laws[0] && std::string(one.key.name) == INNER[0])
      laws.push_back(section.find(INNER[0]) ? section.text(INNER[0]) : INNER[1]);
  const bool known = std::all_of(laws.begin(), laws.end(), [](const std::string &law) {
    return std::find(LAWS, LAWS + LAW_COUNT, law) != LAWS + LAW_COUNT;
  });
  std::vector<const Key *> wanted;
  for (const Key &key : KEYS)
    if (last_ == 0 || key.both) wanted.push_back(&key);
  for (const std::string &law : laws)
    for (const LawKey &one : LAW_KEYS)
      if (known && one.law == law) wanted.push_back(&one.key);
  const Key any = {"", "", "", "", 0., 0., false, true};
  for (const Entry &entry : section.header) {
    if (last_ == 0 && entry.key == "limit_" + std::to_string(limits_.size() + 1)) {
      check_limit(entry);
      continue;
    }
    const Key *found = !known && entry.key.compare(0, 7, "option_") == 0 ? &any : NULL;
    for (const Key *key : wanted) {
      const std::string need = key->need;
      if (entry.key == key->name && (need.empty() || need == "always" || need == unloading || section.find(need)))
        found = key;
    }
    check_value(entry, found);
  }
  for (const Key *key : wanted) {
    const std::string need = key->need;
    if (!need.empty() && (need == "always" || need == unloading || section.find(need)) && !section.find(key->name))
      fail(line, "the lines above lack '" + std::string(key->name) + "'");
  }
  if (scales_with_sigma() && !(section.number("sigma") >= SMALLEST_LENGTH))
    fail(section.find("sigma") ? section.line("sigma") : line, "overlaps over sigma need a sigma from 1e-30 m on");
  if (section.number("sigma") > LARGEST_ROUGHNESS * section.number("radius"))
    fail(section.line("sigma"), "sigma is above half the radius");
  if (section.find("hardness") && section.number("hardness") < LOWEST_HARDNESS * section.number("modulus"))
    fail(section.line("hardness"), "hardness is far below the modulus: both are in Pa");
  if (last_ == 1) return;
  unloads_ = (Unloading)(std::find(RULE_NAMES, RULE_NAMES + RULES, unloading) - RULE_NAMES);
  for (int i = 0; i < 3; i++) numbers_[i] = RULE_KEYS[unloads_][i] ? number(RULE_KEYS[unloads_][i], 0.) : 0.;
  yield_s_ = number("yield_area", HUGE_VAL);
  yield_slope_ = number("yield_slope", 0.);
}

inline void Table::check_value(const Entry &entry, const Key *key) const {
  if (!key) fail(entry.line, "'" + entry.key + "' is not a key of this law and rule of unloading");
  const std::string words = key->words;
  double x;
  bool good = !entry.text.empty();
  if (words == "number")
    good = plain_number(entry.text, x) && (key->included ? x >= key->low : x > key->low) && x <= key->high;
  else if (words == "triples") {
    size_t count = 0;
    for (size_t p = 0, q; good && p <= entry.text.size(); p = q + 1, count++) {
      q = std::min(entry.text.find(' ', p), entry.text.size());
      good = plain_number(entry.text.substr(p, q - p), x);
    }
    good = good && count % 3 == 0;
  } else if (!words.empty())
    good = entry.text.find(' ') == std::string::npos &&
           (" " + words + " ").find(" " + entry.text + " ") != std::string::npos;
  if (!good) fail(entry.line, entry.key + ": '" + entry.text.substr(0, 60) + "' is not " + key->meaning);
}

// 'limit_1: above|below|pressure NUMBER REASON', and so on.
inline void Table::check_limit(const Entry &entry) {
  static const char *const kinds[] = {"above", "below", "pressure"};
  const std::string &body = entry.text;
  const size_t first = body.find(' '), second = body.find(' ', first + 1);
  const size_t kind = std::find(kinds, kinds + 3, body.substr(0, first)) - kinds;
  Limit limit = {(Limit::Kind)kind, 0., second == std::string::npos ? "" : body.substr(second + 1)};
  if (kind == 3 || limit.reason.empty() || !plain_number(body.substr(first + 1, second - first - 1), limit.value) ||
      !(limit.value > 0.))
    fail(entry.line,
         entry.key + ": '" + body.substr(0, 60) + "' is not above, below or pressure, a positive number, a reason");
  limits_.push_back(limit);
}

// u, f, k of a line, which must continue the rows before it: order, growth, and a cubic between them that does not
// fall.
inline void Table::read_row(int line, const std::string &body) {
  Section &section = sections_[last_];
  if (section.rows.empty()) {
    check_header(line);
    section.first_row = line;
  }
  double value[3];
  size_t p = 0;
  for (int i = 0; i < 3; i++) {
    const size_t q = i < 2 ? body.find(' ', p) : body.size();
    if (q == std::string::npos || !plain_number(body.substr(p, q - p), value[i]))
      fail(line, "'" + body.substr(0, 60) + "' is neither 'key: value' nor three numbers with a blank between");
    p = q + 1;
  }
  for (int i = 0; i < 3; i++) {
    const double largest = i ? LARGEST_ROW_FORCE : LARGEST_ROW_OVERLAP;
    if (!(value[i] >= 1. / largest && value[i] <= largest))
      fail(line, "a value in '" + body + "' is too large or too small");
  }
  const double u = value[0], force = value[1], stiffness = value[2], root = cbrt(0.75 * force), s = root * root;
  if (u * stiffness > STEEPEST * force)
    fail(line, "the stiffness is that of a force that grows faster than overlap^10");
  if (!section.rows.empty()) {
    const Row &before = section.rows.back();
    if (!(u > before.u && force > section.force) && !(u == before.u && force >= section.force))
      fail(line, "overlap and force must increase from row to row");
    if (log(force / section.force) > log(JUMP) + STEEPEST * log(u / before.u))
      fail(line, "the force grows faster than overlap^10 from the row before");
    if (std::max(section.stiffness / sqrt(before.s), stiffness / root) * (u - before.u) >
        2. * (3. * (s - before.s) + ROUNDING * s))
      fail(line, "a stiffness here or before is above three times the slope between them: the curve falls");
  }
  section.rows.push_back({u, s, stiffness / (2. * root)}); // s = (3f/4)^(2/3), ds/du = k / (2 sqrt(s))
  section.force = force;
  section.stiffness = stiffness;
}

inline void Table::build(Curve &curve, const Section &section, int end, double until) {
  const std::vector<Row> &rows = section.rows;
  if (rows.size() < 2)
    fail(end, "two or more rows of a curve are missing; 'unloading: table', and only it, has a second curve");
  if (rows.size() > (size_t)MOST_ROWS) fail(end, "more than " + std::to_string(MOST_ROWS) + " rows");
  const int bits = (int)section.number("bits"), wrong = Curve::off_grid(rows, bits);
  if (wrong >= 0)
    fail(section.first_row + wrong,
         "a row is missing before this one, or its overlap is neither on the grid of 'bits' nor one of at most " +
             std::to_string(MOST_KINKS) + " kinks, an overlap in two rows, between other rows");
  const bool straight = section.text("below") == "straight";
  if (straight && Curve::exponent(rows[0]) > 1. + 1e-9)
    fail(section.line("below"), "straight below the first row, this curve would have a force below 0 at overlap 0");
  curve.build(rows, bits, straight, until);
}

} // namespace demlaws
#endif
