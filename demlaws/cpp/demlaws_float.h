// demlaws_float.h: a curve of a table in single precision, for accelerators: plain arrays and a function without memory
// or exceptions of its own. C++11, CUDA, HIP. Its errors, and where single precision is not enough:
// docs/how-to/own-code.md.
//
// Licence: GPL-2.0-or-later, as the package demlaws.
#ifndef DEMLAWS_FLOAT_H
#define DEMLAWS_FLOAT_H
#include "demlaws_curve.h"
#include <stdexcept>

#if defined(__CUDACC__) || defined(__HIPCC__)
#define DEMLAWS_DEVICE __host__ __device__
#else
#define DEMLAWS_DEVICE
#endif

namespace demlaws {

// What a device needs of a curve: copy `cells` (4 floats each) and `splits` there, then pass this by value.
struct FloatCurve {
  const float *cells, *splits; // cubics in 0 <= t < 1; the kinks, each of which divides a cell
  uint32_t first, count;       // number of the grid's first cell; cells
  int shift, split_count;      // mantissa bits within a cell
  float floor, seat, slope;    // below floor, s = seat + slope u
};

// s(u) and ds/du; false beyond the last row, where the last cubic goes on without a certificate. Then
//   force P = (4/3) E* sqrt(R) S^1.5 with S = s length, stiffness K = 2 E* sqrt(R S) ds/du, u = overlap / length.
DEMLAWS_DEVICE inline bool look_up(const FloatCurve &curve, float u, float &s, float &slope) {
  if (u < curve.floor) {
    s = curve.seat + curve.slope * u;
    slope = curve.slope;
    return true;
  }
  uint32_t bits, low;
  memcpy(&bits, &u, 4);
  const bool inside = (bits >> curve.shift) - curve.first + (uint32_t)curve.split_count < curve.count;
  uint32_t cell = inside ? (bits >> curve.shift) - curve.first : curve.count - 1 - (uint32_t)curve.split_count;
  low = (cell + curve.first) << curve.shift;
  const uint32_t high = (cell + curve.first + 1) << curve.shift;
  float begin, end;
  memcpy(&begin, &low, 4);
  memcpy(&end, &high, 4);
  const float width = end - begin;
  for (int i = 0; i < curve.split_count; i++)
    if (u >= curve.splits[i]) {
      cell++;
      if (curve.splits[i] > begin) begin = curve.splits[i];
    }
  const float *const c = curve.cells + 4 * cell, t = (u - begin) / width; // exact
  s = c[0] + t * (c[1] + t * (c[2] + t * c[3]));
  slope = (c[1] + t * (2.f * c[2] + t * 3.f * c[3])) / width;
  return inside || u != u;
}

// The arrays on the host, made from a curve of a table: Table::loading_curve(), Table::unloading_curve().
class FloatCells {
public:
  explicit FloatCells(const Curve &curve) {
    if (!(curve.floor() > 1e-30 && curve.last() < 1e30)) throw std::runtime_error("a curve beyond single precision");
    const int bits = curve.bits();
    for (double kink : curve.kinks()) {
      const float split = (float)kink;
      const bool divides = grid_point(grid_number(split, bits), bits) != split;
      if (divides && (splits_.empty() || splits_.back() < split)) splits_.push_back(split);
    }
    const int64_t begin = grid_number(curve.floor(), bits), end = grid_number(curve.last(), bits);
    size_t next = 0;
    for (int64_t k = begin; k < end; k++) {
      const double low = grid_point(k, bits), high = grid_point(k + 1, bits);
      double from = low;
      for (; next < splits_.size() && splits_[next] < high; next++) {
        add(curve, from, splits_[next], high - low);
        from = splits_[next];
      }
      add(curve, from, high, high - low);
    }
    double s, slope;
    curve.evaluate(0.5 * curve.floor(), s, slope);
    const float floor = (float)curve.floor();
    uint32_t first;
    memcpy(&first, &floor, 4);
    view_ = {&cells_[0],
             splits_.data(),
             first >> (23 - bits),
             (uint32_t)(cells_.size() / 4),
             23 - bits,
             (int)splits_.size(),
             floor,
             (float)curve.seat(),
             (float)slope};
  }
  const FloatCurve &view() const { return view_; }
  const std::vector<float> &cells() const { return cells_; }
  const std::vector<float> &splits() const { return splits_; }

private:
  std::vector<float> cells_, splits_;
  FloatCurve view_;
  FloatCells(const FloatCells &); // view_ points into the arrays
  FloatCells &operator=(const FloatCells &);

  // The kink that a float is, or itself.
  static double kink_at(const Curve &curve, double u) {
    for (double kink : curve.kinks())
      if ((float)kink == (float)u) return kink;
    return u;
  }
  // The cubic from `from` to `to` in t = (u - from) / width.
  void add(const Curve &curve, double from, double to, double width) {
    double s[2], slope[2];
    from = kink_at(curve, from);
    to = kink_at(curve, to);
    curve.evaluate(from, s[0], slope[0]);
    curve.evaluate(std::nextafter(to, 0.), s[1], slope[1]);
    const double h = (to - from) / width, a = slope[0] * width, b = slope[1] * width, rise = (s[1] - s[0]) / h;
    double c[4] = {s[0], a, (3. * rise - 2. * a - b) / h, (a + b - 2. * rise) / (h * h)};
    if (a * h < 1e-7 * s[0]) { // beside a seat: the rise is rounding noise of s
      c[2] = 0.5 * (b - a) / h;
      c[3] = 0.;
    }
    for (double one : c) cells_.push_back((float)one);
  }
};

} // namespace demlaws
#endif
