// demlaws_curve.h: a curve s(u) of a table of demlaws: cells on a grid, look-up, energy, the reversed curve. C++11;
// part of demlaws_table.h.
//
// Licence: GPL-2.0-or-later, as the package demlaws.
#ifndef DEMLAWS_CURVE_H
#define DEMLAWS_CURVE_H
#include "demlaws_facts.h"
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace demlaws {

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
  Curve() {}

  // s(u) and its slope from the lowest cell to before last(); returns false outside (then use outside()).
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

  // Below all cells: straight to 0, or to the seat. At the last row: its values. Beyond it: not certified, returns
  // false with the power law of the last row. NaN gives NaN and true.
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

  // Dimensionless work of first loading from 0 to u: integral of f du; Gauss quadrature, for output only.
  double energy(double u) const {
    if (!(u > 0.)) return u > 0. || u <= 0. ? 0. : u;
    if (u < u_first_) return energy_below(u);
    const size_t low = std::upper_bound(nodes_.begin() + 1, nodes_.end() - 1, u) - nodes_.begin() - 1;
    return work_[low] + gauss(nodes_[low], u);
  }

  double last() const { return u_last_; }
  double last_s() const { return s_last_; }
  // s where the cells below the first row begin.
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

  // Number of the first row that the grid does not allow; -1: they are a curve.
  static int off_grid(const std::vector<Row> &rows, int bits);
  // From rows on the grid. straight: below the first row; else a power law, for 40 octaves of u or s, or about down to
  // s = `until`.
  void build(const std::vector<Row> &rows, int bits, bool straight, double until = 0.);
  // The reverse of a curve: u over s - seat, on a grid of its own that ends within the last cell of the curve.
  void build_reverse(const Curve &curve);

private:
  int bits_ = 0, shift_ = 0;
  uint64_t first_ = 0, count_ = 0;
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

// Each grid point has a row; between the first and the last one kinks, an overlap in two rows, may lie anywhere.
inline int Curve::off_grid(const std::vector<Row> &rows, int bits) {
  const int last = (int)rows.size() - 1;
  int64_t next = grid_number(rows[0].u, bits);
  for (int i = 0, kinks = 0; i <= last; i++) {
    const double u = rows[i].u, coming = grid_point(next, bits);
    const bool ends = i == 0 || i == last;
    if (i > 0 && u == rows[i - 1].u) { // the second row of a kink
      if (ends || i == 1 || u == rows[i - 2].u || ++kinks > MOST_KINKS) return i;
    } else if (u == coming) next++;
    else if (u > coming || ends || rows[i + 1].u != u) return i;
  }
  return -1;
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
  double octaves = straight ? 40. : 40. / std::max(power_first_, 1.);
  if (until > 0. && !straight)
    octaves = std::min(std::max(1., std::min(log2(s_first_ / until), 100.) / power_first_), 200.);
  const int64_t last = grid_number(u_first_, bits_);
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

} // namespace demlaws
#endif
