// demlaws_lanes.h: numbers of the springs of a contact, computed in vectors of the processor. C++11.
//
// Springs are computed together, without a branch for each, and stay in registers during a step: a vector that is read
// from numbers just written one by one costs 20 cycles of waiting.
//
// Licence: GPL-2.0-or-later, as the package demlaws.
#ifndef DEMLAWS_LANES_H
#define DEMLAWS_LANES_H
#include "demlaws_shear.h"

#if defined(__AVX__)
#include <immintrin.h>
#define DEMLAWS_VECTOR 32 // bytes of a vector of the processor
#define DEMLAWS_OUTSIDE 1, 2, 3, 4
#define DEMLAWS_INSIDE 3, 4, 5, 6
#else
#if defined(__SSE2__)
#include <emmintrin.h>
#endif
#define DEMLAWS_VECTOR 16
#define DEMLAWS_OUTSIDE 1, 2
#define DEMLAWS_INSIDE 1, 2
#endif
#if defined(__clang__)
#define DEMLAWS_SHUFFLE(A, B, ...) __builtin_shufflevector(A, B, __VA_ARGS__)
#else
#define DEMLAWS_SHUFFLE(A, B, ...) __builtin_shuffle(A, B, Lanes::Mask{__VA_ARGS__})
#endif

namespace demlaws {

// Numbers of up to N springs, a multiple of four; one operation of the processor has W of them.
template <int N> struct SpringLanes {
  typedef SpringLanes Lanes;
  typedef double Vector __attribute__((vector_size(DEMLAWS_VECTOR)));
  typedef long long Mask __attribute__((vector_size(DEMLAWS_VECTOR)));
  static const int W = DEMLAWS_VECTOR / 8, G = N / W;
  struct Masks {
    Mask of[G];
    DEMLAWS_INLINE Masks() {}
    DEMLAWS_INLINE Masks(const Masks &other) {
      for (int g = 0; g < G; g++) of[g] = other.of[g];
    }
    DEMLAWS_INLINE bool any() const {
      Mask all = of[0];
      for (int g = 1; g < G; g++) all |= of[g];
      long long any = 0;
      for (int k = 0; k < W; k++) any |= all[k];
      return any != 0;
    }
    DEMLAWS_INLINE int count() const {
      Mask all = of[0];
      for (int g = 1; g < G; g++) all += of[g];
      long long sum = 0;
      for (int k = 0; k < W; k++) sum += all[k];
      return -(int)sum;
    }
  };
  Vector of[G];

  DEMLAWS_INLINE SpringLanes() {}
  DEMLAWS_INLINE SpringLanes(double x) {
    for (int g = 0; g < G; g++) of[g] = x - Vector{};
  }
  // Copied one by one: copies of another width would be read before they are written.
  DEMLAWS_INLINE SpringLanes(const SpringLanes &other) { *this = other; }
  DEMLAWS_INLINE SpringLanes &operator=(const SpringLanes &other) {
    for (int g = 0; g < G; g++) of[g] = other.of[g];
    return *this;
  }
  // The numbers of `count` springs, then `rest`. Up to three numbers behind them may be read.
  DEMLAWS_INLINE SpringLanes(const double *numbers, int count, double rest) {
    if (count > N - 4) {
      for (int g = 0; g < G; g++) __builtin_memcpy(&of[g], numbers + W * g, sizeof of[g]);
      *this = where(places() < count, *this, rest);
    } else
      for (int i = 0; i < N; i++) set(i, i < count ? numbers[i] : rest);
  }
  DEMLAWS_INLINE void store(double *numbers, int count) const {
    for (int g = 0; g < G; g++)
      if (W * g + W <= count) __builtin_memcpy(numbers + W * g, &of[g], sizeof of[g]);
      else
        for (int k = 0; k < W; k++)
          if (W * g + k < count) numbers[W * g + k] = of[g][k];
  }
  DEMLAWS_INLINE static Lanes places() {
    static const double NUMBERS[] = {0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11,
                                     12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23};
    Lanes lanes;
    for (int g = 0; g < G; g++) __builtin_memcpy(&lanes.of[g], NUMBERS + W * g, sizeof lanes.of[g]);
    return lanes;
  }
  DEMLAWS_INLINE double operator[](int i) const { return of[i / W][i % W]; }
  DEMLAWS_INLINE void set(int i, double x) { of[i / W][i % W] = x; }

#define DEMLAWS_OF_LANES(RESULT, NAME, EXPRESSION)                                                                     \
  DEMLAWS_INLINE friend RESULT NAME(const Lanes &a, const Lanes &b) {                                                  \
    RESULT c;                                                                                                          \
    for (int g = 0; g < G; g++) c.of[g] = EXPRESSION;                                                                  \
    return c;                                                                                                          \
  }
  DEMLAWS_OF_LANES(Lanes, operator+, a.of[g] + b.of[g])
  DEMLAWS_OF_LANES(Lanes, operator-, a.of[g] - b.of[g])
  DEMLAWS_OF_LANES(Lanes, operator*, a.of[g] * b.of[g])
  DEMLAWS_OF_LANES(Lanes, operator/, a.of[g] / b.of[g])
  DEMLAWS_OF_LANES(Lanes, smaller, a.of[g] < b.of[g] ? a.of[g] : b.of[g])
  DEMLAWS_OF_LANES(Lanes, larger, a.of[g] > b.of[g] ? a.of[g] : b.of[g])
  DEMLAWS_OF_LANES(Masks, operator<, a.of[g] < b.of[g])
  DEMLAWS_OF_LANES(Masks, operator>, a.of[g] > b.of[g])
  DEMLAWS_OF_LANES(Masks, operator==, a.of[g] == b.of[g])
#undef DEMLAWS_OF_LANES
  DEMLAWS_INLINE friend Lanes where(const Masks &mask, const Lanes &a, const Lanes &b) {
    Lanes c;
    for (int g = 0; g < G; g++)
#if defined(__AVX__)
      c.of[g] = mask.of[g] ? a.of[g] : b.of[g];
#else // the processor has no instruction for it
      c.of[g] = (Vector)(((Mask)a.of[g] & mask.of[g]) | ((Mask)b.of[g] & ~mask.of[g]));
#endif
    return c;
  }
  DEMLAWS_INLINE Lanes root() const {
    Lanes c;
    for (int g = 0; g < G; g++)
#if defined(__AVX__)
      c.of[g] = (Vector)_mm256_sqrt_pd((__m256d)of[g]);
#elif defined(__SSE2__)
      c.of[g] = (Vector)_mm_sqrt_pd((__m128d)of[g]);
#else
      for (int k = 0; k < W; k++) c.of[g][k] = std::sqrt(of[g][k]);
#endif
    return c;
  }
  // The number of the neighbour outside, or inside; at the end `x`.
  DEMLAWS_INLINE Lanes outside(double x) const {
    Lanes c;
    const Vector end = x - Vector{};
    for (int g = 0; g < G; g++) c.of[g] = DEMLAWS_SHUFFLE(of[g], g + 1 < G ? of[g + 1] : end, DEMLAWS_OUTSIDE);
    return c;
  }
  DEMLAWS_INLINE Lanes inside(double x) const {
    Lanes c;
    const Vector end = x - Vector{};
    for (int g = 0; g < G; g++) c.of[g] = DEMLAWS_SHUFFLE(g > 0 ? of[g - 1] : end, of[g], DEMLAWS_INSIDE);
    return c;
  }
  DEMLAWS_INLINE double sum() const {
    Vector all = of[0];
    for (int g = 1; g < G; g++) all += of[g];
    return W > 2 ? (all[0] + all[2 % W]) + (all[1] + all[3 % W]) : all[0] + all[1];
  }
  DEMLAWS_INLINE double smallest() const {
    Vector all = of[0];
    for (int g = 1; g < G; g++) all = all < of[g] ? all : of[g];
    return std::min(std::min(all[0], all[2 % W]), std::min(all[1], all[3 % W]));
  }
  DEMLAWS_INLINE double largest() const { return -(Lanes(0.) - *this).smallest(); }
};

} // namespace demlaws
#endif
