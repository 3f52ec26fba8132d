// demlaws_table.h: contact-law tables of demlaws for any DEM code. C++11, this one header, no other dependency.
//
// A table file (written by `demlaws table`) is a normal contact law without units:
//     u = overlap / length,   s(u) = Hertz-equivalent overlap / length,
//     force P = (4/3) E* sqrt(R) S^1.5 with S = s length,   tangent stiffness K = 2 E* sqrt(R S) ds/du.
// With `unloading: table` the file holds a second curve of the same kind, which a contact unloads along.
// One table serves every pair of radii and moduli of a law that collapses; length comes from the roughness.
//
//     demlaws::Table table("granite.tbl");                        // throws std::runtime_error that names file and line
//     demlaws::Pair pair(table, modulus, roughness);              // E* in Pa, combined rms roughness in m
//     demlaws::State state;                                       // zeros: a virgin contact; keep one for each contact
//     demlaws::Force now = demlaws::step(pair, radius, overlap, state);
//     if (now.outside) ...                                        // overlap beyond the last row: no certified value
//
// Licence: GPL-2.0-or-later, as the package demlaws.
#ifndef DEMLAWS_TABLE_H
#define DEMLAWS_TABLE_H

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace demlaws {

enum Unloading { ELASTIC = 0, HERTZ = 1, THORNTON = 2, GIVEN = 3 };

inline const char *unloading_name(Unloading rule) {
  return rule == ELASTIC ? "elastic" : rule == HERTZ ? "hertz" : rule == THORNTON ? "thornton" : "table";
}

// Number of doubles a contact must keep: elastic 0, hertz 2, thornton 3, table (a given curve) 2.
inline int state_size(Unloading rule) { return rule == ELASTIC ? 0 : rule == THORNTON ? 3 : 2; }

inline bool unloading_from_name(const std::string &name, Unloading &rule) {
  if (name == "elastic") rule = ELASTIC;
  else if (name == "hertz") rule = HERTZ;
  else if (name == "thornton") rule = THORNTON;
  else if (name == "table") rule = GIVEN;
  else return false;
  return true;
}

// CRC-32 of zlib (polynomial 0xEDB88320), continued from an earlier value.
inline uint32_t crc32(uint32_t crc, const char *data, size_t size) {
  struct Entries {
    uint32_t value[256];
    Entries() {
      for (uint32_t n = 0; n < 256; n++) {
        uint32_t c = n;
        for (int k = 0; k < 8; k++) c = (c & 1) ? 0xEDB88320u ^ (c >> 1) : c >> 1;
        value[n] = c;
      }
    }
  };
  static const Entries entries;
  crc = ~crc;
  for (size_t i = 0; i < size; i++) crc = entries.value[(crc ^ (unsigned char)data[i]) & 0xff] ^ (crc >> 8);
  return ~crc;
}

// One grid cell: s(t) = c[0] + t (c[1] + t (c[2] + t c[3])), t in [0, 1) from the cell's start to its end.
struct Cell {
  double c[4];
};

// A row of a curve: u, s(u), ds/du, and the line of the file where it stands.
struct Row {
  double u, s, slope;
  int line;
};

// What is wrong with a row.
struct BadRow {
  int line;
  std::string what;
};

// A curve s(u): cells on a grid of 2^bits linear parts in each octave, whose number stands in the bits of the double u.
class Curve {
public:
  Curve() : bits_(0), first_(0), count_(0) {}

  // s(u) and its slope for first <= u < last; returns false outside (then use outside()).
  inline bool look_up(double u, double &s, double &slope) const {
    uint64_t b;
    memcpy(&b, &u, 8);
    int64_t k = (int64_t)(b >> shift_) - first_;
    k += (int64_t)(u >= kink_[0]) + (int64_t)(u >= kink_[1]);
    if ((uint64_t)k >= (uint64_t)count_) return false;
    const double *const c = cells_[k].c;
    // the mantissa bits below the cell number are t; the exponent alone gives 1 / width
    const uint64_t fraction = ((b << bits_) & 0x000fffffffffffffULL) | 0x3ff0000000000000ULL;
    const uint64_t inverse = inverse_width_ - (b & 0x7ff0000000000000ULL);
    double t, per_width;
    memcpy(&t, &fraction, 8);
    memcpy(&per_width, &inverse, 8);
    t -= 1.0;
    s = c[0] + t * (c[1] + t * (c[2] + t * c[3]));
    slope = (c[1] + t * (2. * c[2] + t * (3. * c[3]))) * per_width;
    return true;
  }

  // Below the first row: power law; a law that starts from a seating force (exponent below 0.5: its stiffness would grow
  // without bound) goes on straight. At the last row: its values. Beyond it: not certified, returns false with the
  // power law of the last row. NaN gives NaN and true.
  bool outside(double u, double &s, double &slope) const {
    if (u != u) {
      s = slope = u;
      return true;
    }
    if (u < u_first_) {
      below(u, s, slope);
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
    size_t low = 0, high = nodes_.size() - 1;
    while (high - low > 1) {
      const size_t middle = (low + high) / 2;
      if (nodes_[middle] <= u) low = middle;
      else high = middle;
    }
    return work_[low] + gauss(nodes_[low], u);
  }

  // u at which the curve reaches s > 0, by bisection and secant; between the first and the last row, and below.
  double invert(double s) const;

  double first() const { return u_first_; }
  double last() const { return u_last_; }
  double first_s() const { return s_first_; }
  double last_s() const { return s_last_; }
  // s at u = 0+: 0, but for a law that starts from a seating force.
  double seat() const { return straight_ ? s_first_ * (1. - power_first_) : 0.; }
  const std::vector<double> &kinks() const { return kinks_; }
  int bits() const { return bits_; }

  // From its rows; throws BadRow. straight: whether it goes on straight below the first row, -1: if it must (seat()).
  void build(const std::vector<Row> &rows, int bits, double rtol, int straight = -1);
  // The reverse of a curve: u over s - seat, on a grid of its own that ends within the last cell of the curve.
  void build_reverse(const Curve &curve, double rtol);

private:
  int bits_, shift_;
  int64_t first_, count_;
  uint64_t inverse_width_;
  double kink_[2]; // those that split a cell
  bool straight_;
  double u_first_, s_first_, power_first_, u_last_, s_last_, slope_last_;
  std::vector<Cell> storage_; // kept so that cells_ can be aligned
  const Cell *cells_;
  std::vector<double> nodes_, work_, kinks_;

  Curve(const Curve &); // cells_ points into storage_: not copied
  Curve &operator=(const Curve &);

  static void bad(int line, const std::string &what) {
    BadRow row = {line, what};
    throw row;
  }
  int64_t index(double u) const {
    uint64_t b;
    memcpy(&b, &u, 8);
    return (int64_t)(b >> shift_);
  }
  double start(int64_t grid) const {
    const uint64_t b = (uint64_t)grid << shift_;
    double u;
    memcpy(&u, &b, 8);
    return u;
  }
  double gauss(double a, double b) const {
    const double middle = 0.5 * (a + b), half = 0.5 * (b - a);
    double sum = 0., s, slope;
    for (int i = 0; i < 8; i++) {
      evaluate(middle + half * gauss_place(i), s, slope);
      sum += gauss_weight(i) * (4. / 3.) * s * sqrt(s);
    }
    return half * sum;
  }
  void extend_below(std::vector<Cell> &cells, double rtol);
  static Row reversed(const Curve &curve, double y, double seat, double beside);
  bool seated() const { return straight_; }
  void below(double u, double &s, double &slope) const {
    if (seated()) {
      slope = power_first_ * s_first_ / u_first_;
      s = s_first_ + slope * (u - u_first_);
      return;
    }
    s = u > 0. ? s_first_ * pow(u / u_first_, power_first_) : 0.;
    slope = u > 0. ? power_first_ * s / u : 0.;
  }
  double energy_below(double u) const {
    double s, slope;
    below(u, s, slope);
    if (!seated()) return (4. / 3.) * s * sqrt(s) * u / (1.5 * power_first_ + 1.);
    double sum = 0.; // f = (4/3) s^1.5 with s straight in u
    for (int i = 0; i < 8; i++) {
      double value;
      below(0.5 * u * (1. + gauss_place(i)), value, slope);
      sum += gauss_weight(i) * (4. / 3.) * value * sqrt(value);
    }
    return 0.5 * u * sum;
  }
  static double gauss_place(int i) {
    static const double x[4] = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363};
    return i & 1 ? x[i / 2] : -x[i / 2];
  }
  static double gauss_weight(int i) {
    static const double w[4] = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763};
    return w[i / 2];
  }
};

class Table {
public:
  Table() : fingerprint_(0), rule_(ELASTIC), seat_(0.) {}
  explicit Table(const std::string &path) : fingerprint_(0), rule_(ELASTIC), seat_(0.) { read(path); }

  // Reads a file; throws std::runtime_error("FILE, line N: what is wrong") and leaves the table unusable then.
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
    const std::string value = text(key);
    char *end = NULL;
    const double x = strtod(value.c_str(), &end);
    return value.empty() || end == value.c_str() || *end ? otherwise : x;
  }
  // A number of the contact (SI) that the table was made for: "radius", "modulus", "roughness", ...
  double of_contact(const std::string &name, double otherwise) const {
    const std::string json = text("contact"), key = "\"" + name + "\":";
    const size_t at = json.find(key);
    if (at == std::string::npos) return otherwise;
    const char *const begin = json.c_str() + at + key.size();
    char *end = NULL;
    const double x = strtod(begin, &end);
    return end == begin ? otherwise : x;
  }
  // A law that collapses has one curve for every radius and modulus; another holds for its own contact only.
  bool collapses() const { return text("collapses") != "no"; }
  double rtol() const { return number("rtol", 0.); }
  Unloading unloading() const { return rule_; }
  double first_overlap() const { return loading_.first(); }
  double last_overlap() const { return loading_.last(); }
  double last_force() const { return f_last_; }
  bool yields() const { return yield_force_ < HUGE_VAL; }

  // s(u) and its slope; false beyond the table. See Curve.
  inline bool look_up(double u, double &s, double &slope) const { return loading_.look_up(u, s, slope); }
  bool outside(double u, double &s, double &slope) const { return loading_.outside(u, s, slope); }
  inline bool evaluate(double u, double &s, double &slope) const { return loading_.evaluate(u, s, slope); }

  // The curve to unload along; empty unless unloading() is GIVEN.
  const Curve &unloading_curve() const { return unloading_; }
  // u at which the unloading curve reaches s: its reverse, then one step of Newton's method.
  inline double recover(double s) const {
    const double above = s - seat_;
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
    return yield_s_ + ((4. / 3.) * s * sqrt(s) - yield_force_) * yield_area_slope_;
  }

  // Dimensionless work of virgin loading from 0 to u.
  double energy(double u) const { return loading_.energy(u); }

private:
  std::string path_;
  uint32_t fingerprint_;
  std::map<std::string, std::string> header_;
  Unloading rule_;
  Curve loading_, unloading_, reverse_;
  double seat_; // s of the unloading curve at u = 0+
  double f_last_, yield_force_, yield_s_, yield_area_slope_;

  Table(const Table &); // a curve is not copied
  Table &operator=(const Table &);

  void fail(int line, const std::string &what) const {
    std::ostringstream out;
    out << path_;
    if (line > 0) out << ", line " << line;
    out << ": " << what;
    throw std::runtime_error(out.str());
  }
  double to_number(const std::string &token, int line, const char *what) const {
    char *end = NULL;
    errno = 0;
    const double x = strtod(token.c_str(), &end);
    if (token.empty() || *end || !(x - x == 0.))
      fail(line, std::string(what) + " is '" + token + "', not a finite number");
    return x;
  }
  void build(Curve &curve, const std::vector<Row> &rows, int bits) const;
};

inline std::string Table::contents(const std::string &path) {
  FILE *const file = fopen(path.c_str(), "rb");
  if (!file)
    throw std::runtime_error(path + ": cannot be opened (" + strerror(errno) + "); make it with `demlaws table`");
  std::string data;
  char buffer[65536];
  size_t got;
  while ((got = fread(buffer, 1, sizeof buffer, file)) > 0) data.append(buffer, got);
  const bool bad = ferror(file) != 0;
  fclose(file);
  if (bad) throw std::runtime_error(path + ": cannot be read");
  return data;
}

inline void Table::parse(const std::string &data, const std::string &path) {
  path_ = path;
  header_.clear();
  const std::string magic = "# demlaws-table 1\n";
  if (data.compare(0, magic.size(), magic) != 0)
    fail(1, "the first line must be exactly '# demlaws-table 1'; this is no table of demlaws, or of another version");
  size_t at = magic.size();
  uint32_t crc = crc32(0, data.data(), at);
  size_t summed = at;
  int line = 1, expected_rows = -1, rows_line = 0;
  enum { HEADER, ROWS, ENDED } part = HEADER;
  std::vector<Row> rows, more;
  std::vector<Row> *into = &rows;
  int bits = -1, more_bits = -1, expected_more = 0;
  while (at < data.size()) {
    line++;
    if (part == ENDED) fail(line, "something follows the 'end:' line");
    const size_t newline = data.find('\n', at);
    if (newline == std::string::npos) fail(line, "the file stops in the middle of a line");
    const size_t length = newline - at;
    if (length < 10 || data[newline - 9] != ' ') fail(line, "no checksum (a space and 8 hex digits) ends the line");
    const std::string digits = data.substr(newline - 8, 8);
    uint32_t given = 0;
    for (int i = 0; i < 8; i++) {
      const char c = digits[i];
      if (c >= '0' && c <= '9') given = given * 16 + (c - '0');
      else if (c >= 'a' && c <= 'f') given = given * 16 + (c - 'a' + 10);
      else fail(line, "checksum '" + digits + "' is not 8 hex digits");
    }
    crc = crc32(crc, data.data() + summed, newline - 9 - summed);
    summed = newline - 9;
    if (crc != given) fail(line, "checksum does not match: this line was changed after the table was written; write it anew");
    const std::string body = data.substr(at, length - 9);
    at = newline + 1;
    if (part == HEADER) {
      if (body == "overlap force stiffness") {
        part = ROWS;
        continue;
      }
      const size_t colon = body.find(": ");
      const bool empty_value = body.size() > 1 && body[body.size() - 1] == ':';
      if (colon == std::string::npos && !empty_value) fail(line, "'" + body + "' is not 'key: value'");
      const std::string key = body.substr(0, empty_value && colon == std::string::npos ? body.size() - 1 : colon);
      if (header_.count(key)) fail(line, "key '" + key + "' appears twice");
      const std::string value = colon == std::string::npos ? "" : body.substr(colon + 2);
      header_[key] = value;
      if (key == "rows" || key == "unloading_rows") {
        const double n = to_number(value, line, "rows");
        if (!(n >= 2 && n < 1e8 && n == floor(n))) fail(line, "rows: " + value + " is not a whole number of at least 2");
        (key == "rows" ? expected_rows : expected_more) = (int)n;
        if (key == "rows") rows_line = line;
      } else if (key == "bits" || key == "unloading_bits") {
        const double n = to_number(value, line, "bits");
        if (!(n >= 0 && n <= 20 && n == floor(n))) fail(line, "bits: " + value + " is not a whole number from 0 to 20");
        (key == "bits" ? bits : more_bits) = (int)n;
      } else if (key == "unloading" && !unloading_from_name(value, rule_))
        fail(line, "unloading: " + value + " is none of elastic, hertz, thornton, table");
      continue;
    }
    if (body.compare(0, 5, "end: ") == 0) {
      std::ostringstream wanted;
      wanted << "end: " << rows.size() + more.size() << " rows";
      if (body != wanted.str()) fail(line, "'" + body + "', but " + wanted.str().substr(5) + " were read");
      part = ENDED;
      fingerprint_ = crc;
      continue;
    }
    if (body == "unloading overlap force stiffness" && into == &rows) {
      into = &more;
      continue;
    }
    Row row;
    row.line = line;
    std::string token[3];
    size_t p = 0;
    for (int i = 0; i < 3; i++) {
      const size_t q = i < 2 ? body.find(' ', p) : body.size();
      if (q == std::string::npos) fail(line, "a row needs overlap, force and stiffness");
      token[i] = body.substr(p, q - p);
      p = q + 1;
    }
    row.u = to_number(token[0], line, "overlap");
    const double f = to_number(token[1], line, "force"), k = to_number(token[2], line, "stiffness");
    if (!(row.u > 0.) || !(f > 0.) || !(k > 0.)) fail(line, "overlap, force and stiffness must be positive");
    const double root = cbrt(0.75 * f); // s = (3f/4)^(2/3), ds/du = k / (2 sqrt(s))
    row.s = root * root;
    row.slope = k / (2. * root);
    if (!into->empty() && (row.u < into->back().u || (row.u > into->back().u && !(row.s > into->back().s))))
      fail(line, "overlap and force must increase from row to row");
    if (into == &rows) f_last_ = f;
    into->push_back(row);
  }
  if (part != ENDED) fail(line + 1, "the file stops before its 'end:' line");
  static const char *const needed[] = {"law", "unloading", "bits", "rows"};
  for (int i = 0; i < 4; i++)
    if (!has(needed[i])) fail(0, std::string("the header has no '") + needed[i] + ":'");
  if (number("offset", 0.) != 0.) fail(0, "the table has an offset, which this reader does not know");
  if (expected_rows != (int)rows.size()) {
    std::ostringstream what;
    what << "rows: " << expected_rows << ", but the table has " << rows.size();
    fail(rows_line, what.str());
  }
  if (expected_more != (int)more.size()) {
    std::ostringstream what;
    what << "unloading_rows: " << expected_more << ", but the table has " << more.size();
    fail(0, what.str());
  }
  if ((rule_ == GIVEN) != !more.empty()) fail(0, "rows of an unloading curve belong to 'unloading: table', and only to it");
  build(loading_, rows, bits);
  if (rule_ == GIVEN) {
    if (more_bits < 0) fail(0, "the header has no 'unloading_bits:'");
    build(unloading_, more, more_bits);
    reverse_.build_reverse(unloading_, rtol());
    seat_ = unloading_.seat();
  }
  yield_force_ = yield_s_ = HUGE_VAL;
  yield_area_slope_ = 0.;
  if (has("yield_force") && text("yield_force") != "none") {
    const double f = number("yield_force", -1.), slope = number("yield_area_slope", -1.);
    if (!(f > 0.) || !(slope > 0.)) fail(0, "'yield_force' and 'yield_area_slope' must both be positive numbers");
    yield_force_ = f;
    const double root = cbrt(0.75 * f);
    yield_s_ = root * root;
    yield_area_slope_ = slope;
  }
}

inline void Table::build(Curve &curve, const std::vector<Row> &rows, int bits) const {
  try {
    curve.build(rows, bits, rtol());
  } catch (const BadRow &bad) {
    fail(bad.line, bad.what);
  }
}

inline void Curve::build(const std::vector<Row> &rows, int bits, double rtol, int straight) {
  bits_ = bits;
  shift_ = 52 - bits_;
  inverse_width_ = (uint64_t)(2046 + bits_) << 52;
  int split = 0;
  kinks_.clear();
  kink_[0] = kink_[1] = HUGE_VAL;
  const size_t n = rows.size();
  u_first_ = rows[0].u;
  s_first_ = rows[0].s;
  power_first_ = rows[0].slope * rows[0].u / s_first_;
  straight_ = straight < 0 ? power_first_ < 0.5 : straight != 0;
  u_last_ = rows[n - 1].u;
  s_last_ = rows[n - 1].s;
  slope_last_ = rows[n - 1].slope;
  first_ = index(u_first_);
  if (start(first_) != u_first_) bad(rows[0].line, "the first overlap is not on the grid of the header's 'bits'");
  std::vector<Cell> cells;
  nodes_.clear();
  int64_t grid = first_;
  for (size_t i = 0; i + 1 < n; i++) {
    const double a = start(grid), b = start(grid + 1), width = b - a;
    const double u0 = rows[i].u, u1 = rows[i + 1].u;
    if (u1 == u0) { // a kink: the same overlap twice
      if (kinks_.size() == 2) bad(rows[i + 1].line, "more than two kinks");
      if (i == 0 || i + 2 == n || rows[i - 1].u == u0) bad(rows[i + 1].line, "a kink at the end of the table");
      kinks_.push_back(u0);
      if (u0 != a) kink_[split++] = u0; // one on a grid point splits no cell
      continue;
    }
    const bool after_kink = i > 0 && rows[i - 1].u == u0;
    const bool before_kink = i + 2 < n && rows[i + 2].u == u1;
    if (u0 != a && !after_kink) bad(rows[i].line, "overlap is not on the grid of the header's 'bits'");
    if (u1 != b && !before_kink) bad(rows[i + 1].line, "overlap is not on the grid of the header's 'bits'");
    if (u1 > b) bad(rows[i + 1].line, "a row is missing before this one");
    // Hermite in x = (u - u0)/h, then in t = (u - a)/width = t0 + x d
    const double h = u1 - u0, d = h / width, t0 = (u0 - a) / width;
    const double m0 = rows[i].slope * h, m1 = rows[i + 1].slope * h, rise = rows[i + 1].s - rows[i].s;
    double p0 = rows[i].s, p1 = m0 / d, p2, p3;
    if (d > 1e-3) {
      p2 = (3. * rise - 2. * m0 - m1) / (d * d);
      p3 = (m0 + m1 - 2. * rise) / (d * d * d);
    } else { // a sliver beside a kink: a cubic there would be rounding noise
      p2 = 0.5 * (m1 - m0) / (d * d);
      p3 = 0.;
    }
    Cell cell;
    cell.c[0] = p0 - t0 * (p1 - t0 * (p2 - t0 * p3));
    cell.c[1] = p1 - t0 * (2. * p2 - 3. * t0 * p3);
    cell.c[2] = p2 - 3. * t0 * p3;
    cell.c[3] = p3;
    cells.push_back(cell);
    nodes_.push_back(u0);
    if (u1 == b) grid++;
  }
  nodes_.push_back(u_last_);
  if (start(grid) != u_last_) bad(rows[n - 1].line, "the last overlap is not on the grid of the header's 'bits'");
  extend_below(cells, rtol);
  storage_.resize(cells.size() + 1);
  const uintptr_t raw = (uintptr_t)&storage_[0];
  Cell *const aligned = (Cell *)((raw + 31) & ~(uintptr_t)31);
  std::copy(cells.begin(), cells.end(), aligned);
  cells_ = aligned;
  count_ = (int64_t)cells.size();
  work_.assign(nodes_.size(), 0.);
  work_[0] = energy_below(u_first_);
  for (size_t i = 1; i < nodes_.size(); i++) work_[i] = work_[i - 1] + gauss(nodes_[i - 1], nodes_[i]);
}

inline double Curve::invert(double s) const {
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

inline void Curve::build_reverse(const Curve &curve, double rtol) {
  bits_ = curve.bits_ + 1; // so that one step of Newton's method is exact to rounding
  shift_ = 52 - bits_;
  const double seat = curve.seat();
  const int64_t begin = index(curve.s_first_ - seat), end = index(curve.s_last_ - seat);
  std::vector<double> corners;
  for (size_t i = 0; i < curve.kinks_.size(); i++) {
    double s, slope;
    curve.evaluate(curve.kinks_[i], s, slope);
    corners.push_back(s - seat);
  }
  std::vector<Row> rows;
  size_t corner = 0;
  for (int64_t grid = begin; grid <= end; grid++) {
    const double y = start(grid);
    // a corner stands twice, with the slopes on its either side
    for (; corner < corners.size() && corners[corner] <= y; corner++) {
      if (!(corners[corner] > start(begin)) || rows.empty()) continue;
      for (int side = -1; side <= 1; side += 2) rows.push_back(reversed(curve, corners[corner], seat, 1. + side * 1e-14));
      rows[rows.size() - 1].s = rows[rows.size() - 2].s;
    }
    if (rows.empty() || rows.back().u != y) rows.push_back(reversed(curve, y, seat, 1.));
  }
  build(rows, bits_, rtol, seat > 0.);
}

inline Row Curve::reversed(const Curve &curve, double y, double seat, double beside) {
  Row row = {y, curve.invert(y * beside + seat), 0., 0};
  double s, slope;
  curve.evaluate(row.s, s, slope);
  row.slope = 1. / slope;
  return row;
}

// Cells for the power law below the first row: pow() costs as much as all the rest of a contact. Only where cells of this
// width hold it within the table's own tolerance.
inline void Curve::extend_below(std::vector<Cell> &cells, double rtol) {
  const int octaves = std::min(40, std::max(4, 16384 >> bits_));
  const int64_t start_at = first_ - ((int64_t)octaves << bits_);
  std::vector<Cell> under;
  double worst = 0.;
  for (int64_t grid = start_at; grid < first_; grid++) {
    const double a = start(grid), b = start(grid + 1);
    double s0, m0, s1, m1, exact, slope;
    below(a, s0, m0);
    below(b, s1, m1);
    m0 *= b - a;
    m1 *= b - a;
    const double rise = s1 - s0;
    Cell cell = {{s0, m0, 3. * rise - 2. * m0 - m1, m0 + m1 - 2. * rise}};
    under.push_back(cell);
    for (int i = 1; i < 4; i++) {
      const double t = 0.25 * i;
      below(a + t * (b - a), exact, slope);
      const double s = s0 + t * (m0 + t * (cell.c[2] + t * cell.c[3]));
      const double ds = (m0 + t * (2. * cell.c[2] + 3. * t * cell.c[3])) / (b - a);
      worst = std::max(worst, std::max(1.5 * fabs(s / exact - 1.), fabs(ds / slope - 1.)));
    }
  }
  if (!(worst <= std::max(rtol, 1e-12))) return;
  cells.insert(cells.begin(), under.begin(), under.end());
  first_ = start_at;
}

// What the contacts between two materials share.
struct Pair {
  const Table *table;
  Unloading rule;
  double modulus;        // effective modulus E* [Pa]
  double length;         // [m]; 0: length_per_radius * R
  double inverse_length; // [1/m]
  double length_per_radius;

  Pair() : table(NULL), rule(ELASTIC), modulus(0.), length(0.), inverse_length(0.), length_per_radius(0.) {}

  // roughness: combined rms roughness sigma [m]; without it the length of the file is taken.
  Pair(const Table &t, double effective_modulus, double roughness = 0.)
      : table(&t), rule(t.unloading()), modulus(effective_modulus), length(0.), length_per_radius(0.) {
    const double over_roughness = t.number("length_over_roughness", 0.);
    if (t.number("length_over_radius", 0.) > 0.) length_per_radius = t.number("length_over_radius", 0.);
    else if (roughness > 0. && over_roughness > 0.) length = over_roughness * roughness;
    else length = t.number("length", 0.);
    if (!(length > 0.) && !(length_per_radius > 0.))
      throw std::runtime_error(t.path() + ": the header gives no length; pass the roughness of the pair [m]");
    if (!(modulus > 0.)) throw std::runtime_error(t.path() + ": the effective modulus must be positive [Pa]");
    inverse_length = length > 0. ? 1. / length : 0.;
  }
  inline double length_of(double radius) const { return length > 0. ? length : length_per_radius * radius; }
};

struct State {
  double maximum_overlap, plastic_overlap, radius_ratio;
  State() : maximum_overlap(0.), plastic_overlap(0.), radius_ratio(0.) {}
};

struct Force {
  double force, stiffness;
  bool outside; // the overlap lies beyond the table: force is an uncertified extrapolation
};

// One step of one contact. `state` points to state_size(rule) doubles: maximum overlap [m], plastic overlap [m],
// radius ratio R_p / R; it is written only when `update` is true. overlap <= 0 clears it. RULE is known when compiled.
template <Unloading RULE>
inline Force step_rule(const Pair &pair, double radius, double overlap, double *state, bool update) {
  Force now = {0., 0., false};
  if (overlap <= 0.) {
    if (update)
      for (int i = 0; i < (RULE == ELASTIC ? 0 : RULE == THORNTON ? 3 : 2); i++) state[i] = 0.;
    return now;
  }
  double hertz_overlap, slope = 1., effective_radius = radius;
  const bool loads = RULE == ELASTIC || !(overlap < state[0]); // NaN, too
  double length = 0., inverse_length = 0.;
  if (RULE == GIVEN || loads) {
    length = pair.length;
    inverse_length = pair.inverse_length;
    if (!(length > 0.)) {
      length = pair.length_per_radius * radius;
      inverse_length = 1. / length;
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
      else {
        const double ratio = s / pair.table->area(s); // R_p/R = (area/s)^1.5, recoverable overlap s (R/R_p)^(1/3)
        state[1] = overlap - hertz_overlap * sqrt(ratio);
        state[2] = 1. / (ratio * sqrt(ratio));
      }
    }
  } else {
    hertz_overlap = overlap - state[1];
    if (hertz_overlap <= 0.) return now;
    if (RULE == GIVEN) {
      double s;
      pair.table->unloading_curve().evaluate(hertz_overlap * inverse_length, s, slope);
      hertz_overlap = s * length;
    }
    if (RULE == THORNTON) effective_radius *= state[2];
  }
  const double root = pair.modulus * sqrt(effective_radius * hertz_overlap);
  now.force = (4. / 3.) * root * hertz_overlap;
  now.stiffness = 2. * root * slope;
  return now;
}

inline Force step(const Pair &pair, double radius, double overlap, double *state, bool update = true) {
  if (pair.rule == ELASTIC) return step_rule<ELASTIC>(pair, radius, overlap, state, update);
  if (pair.rule == HERTZ) return step_rule<HERTZ>(pair, radius, overlap, state, update);
  if (pair.rule == THORNTON) return step_rule<THORNTON>(pair, radius, overlap, state, update);
  return step_rule<GIVEN>(pair, radius, overlap, state, update);
}

inline Force step(const Pair &pair, double radius, double overlap, State &state) {
  return step(pair, radius, overlap, &state.maximum_overlap);
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
  if (!(state[0] > 0.)) return;
  if (pair.rule == GIVEN) {
    const Curve &curve = pair.table->unloading_curve();
    const double below = state[1] < 0. ? curve.energy(-state[1] / length) : 0.;
    const double held = curve.energy(std::max(0., state[0] - state[1]) / length);
    if (overlap > 0. && overlap > state[1]) stored = std::max(0., scale * (curve.energy((overlap - state[1]) / length) - below));
    dissipated = scale * (pair.table->energy(state[0] / length) - (held - below));
    return;
  }
  const double r = pair.rule == THORNTON ? radius * state[2] : radius;
  const double recoverable = state[0] - state[1], left = overlap - state[1];
  const double hertz = (8. / 15.) * pair.modulus * sqrt(r);
  // a law with a seating load has a negative plastic overlap: what lies below zero overlap never comes back
  const double lost = state[1] < 0. ? hertz * state[1] * state[1] * sqrt(-state[1]) : 0.;
  if (overlap > 0. && left > 0.) stored = std::max(0., hertz * left * left * sqrt(left) - lost);
  dissipated =
      scale * pair.table->energy(state[0] / length) - (hertz * recoverable * recoverable * sqrt(recoverable) - lost);
}

} // namespace demlaws
#endif
