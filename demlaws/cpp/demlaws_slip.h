// demlaws_slip.h: partial slip of a contact, a row of springs sorted by normal stiffness. C++11, with demlaws_table.h.
//
// A contact is a row of springs, one for each stiffness that it had while it grew: the method of dimensionality
// reduction of Popov and Hess. Twin of slip_loop in demlaws/core/slip.py, which explains it. The springs share the
// stiffness equally; when the contact has become twice as stiff as the row, springs are joined in pairs.
//
// Licence: GPL-2.0-or-later, as the package demlaws.
#ifndef DEMLAWS_SLIP_H
#define DEMLAWS_SLIP_H
#include "demlaws_shear.h"
#include "demlaws_table.h"

namespace demlaws {

// The integral of overlap over stiffness along a curve: G(k) = u k - f where the curve has the stiffness k (the
// Legendre transform of the force), without units. G' = u, so that cubics between the nodes have exact slopes.
class SpringCurve {
public:
  explicit SpringCurve(const Curve &curve) {
    const double lowest = curve.last() * std::ldexp(1., -40);
    double force;
    const double least = stiffness(curve, lowest, force), most = stiffness(curve, curve.last(), force);
    first_ = number(least) + 1;
    for (int64_t n = first_; node(n) < most; n++) {
      double low = lowest, high = curve.last();
      for (int i = 0; i < 200 && high - low > 1e-15 * high; i++) {
        const double middle = 0.5 * (low + high);
        if (stiffness(curve, middle, force) < node(n)) low = middle;
        else high = middle;
      }
      stiffness(curve, high, force);
      const Node found = {node(n), high * node(n) - force, high, 0., 0.};
      nodes_.push_back(found);
    }
    stiffness(curve, curve.last(), force);
    const Node end = {most, curve.last() * most - force, curve.last(), 0., 0.};
    nodes_.push_back(end);
    for (size_t n = 0; n + 1 < nodes_.size(); n++) {
      Node &a = nodes_[n];
      const Node &b = nodes_[n + 1];
      const double width = b.k - a.k, rise = b.integral - a.integral;
      a.c2 = (3. * rise / width - 2. * a.overlap - b.overlap) / width;
      a.c3 = (a.overlap + b.overlap - 2. * rise / width) / (width * width);
    }
  }
  double integral(double k) const {
    if (k <= nodes_[0].k) { // a power law
      const double exponent = nodes_[0].integral > 0. ? nodes_[0].overlap * nodes_[0].k / nodes_[0].integral : 1.;
      return nodes_[0].integral * pow(k / nodes_[0].k, exponent);
    }
    const size_t n = (size_t)(number(k) - first_);
    if (n + 1 >= nodes_.size()) return nodes_.back().integral + nodes_.back().overlap * (k - nodes_.back().k);
    const Node &a = nodes_[n];
    const double t = k - a.k;
    return a.integral + t * (a.overlap + t * (a.c2 + t * a.c3));
  }

private:
  struct Node {
    double k, integral, overlap, c2, c3; // to the next node: integral + t (overlap + t (c2 + t c3)), t from k on
  };
  static const int BITS = 4; // nodes for each doubling of the stiffness: 2^BITS
  int64_t first_;
  std::vector<Node> nodes_;

  static double stiffness(const Curve &curve, double u, double &force) {
    double s, slope;
    curve.evaluate(u, s, slope);
    force = (4. / 3.) * s * sqrt(s);
    return 2. * sqrt(s) * slope;
  }
  static int64_t number(double k) { return grid_number(k, BITS); }
  static double node(int64_t number) { return grid_point(number, BITS); }
};

// Compression of the springs of one contact, from the curve along which it would unload now.
class Compression {
public:
  // curve: that of the pair's table, loading (ELASTIC) or unloading (GIVEN); not read for Hertz's curve.
  Compression(const Pair &pair, const SpringCurve *curve, double radius, double overlap, const double *state)
      : curve_(pair.rule == ELASTIC || pair.rule == GIVEN ? curve : NULL),
        recoverable_(pair.rule == ELASTIC ? overlap : overlap - state[1]) {
    if (curve_) {
      const double length = pair.length_of(radius), stiffness = pair.modulus * sqrt(radius * length);
      unit_ = 1. / stiffness;
      scale_ = stiffness * length;
    } else {
      const double root = 2. * pair.modulus * sqrt(keeps_radius(pair.rule) ? radius * state[2] : radius);
      scale_ = 1. / (3. * root * root); // K = root sqrt(z)
    }
  }
  // Means of springs that share the stiffness equally, at least 0; returns their integral over the stiffness [N].
  double means(double share, double stiffness, int count, double *mean) const {
    double carried = 0., low = 0., below = 0., inverse = 1. / share;
    for (int k = 0; k < count; k++) {
      const bool last = k == count - 1;
      const double high = last ? stiffness : (k + 1) * share;
      double lacks; // mean overlap at which the spring touched
      if (curve_) {
        const double up_to = scale_ * curve_->integral(high * unit_);
        lacks = last ? (up_to - below) / (high - low) : (up_to - below) * inverse;
        below = up_to;
      } else lacks = scale_ * (high * high + high * low + low * low);
      mean[k] = std::max(recoverable_ - lacks, 0.);
      carried += (high - low) * mean[k];
      low = high;
    }
    return carried;
  }

private:
  const SpringCurve *curve_;
  double recoverable_, unit_, scale_;
};

// What a contact keeps: its stiffness, the share of each spring, their stretches, 2 numbers each, and the first unit
// vector (Motion). All zeros: no shear force. The numbers are the caller's; MOST springs at most: LIGGGHTS has room for
// 99 values per contact.
class SpringRow {
public:
  static const int MOST = 30, MOST_SIZE = 2 + 2 * MOST + 3;
  static int size(int springs) { return numbers_of_shear(2, springs); }
  static bool may_have(double springs) {
    return springs == 2 * (int)(0.5 * springs) && springs >= 2. && springs <= MOST;
  }
  SpringRow(double *numbers, int springs)
      : stiffness_(numbers[0]), share_(numbers[1]), stretch_(numbers + 2), springs_(springs) {}

  double energy(double ratio) const {
    double force[2];
    return sum(ratio, force);
  }

  // One step: the stiffness K with which the contact would unload, K_t / K, Coulomb's limit mu P [N] and the motion of
  // the step, all of now.
  ShearStep step(double stiffness, double ratio, double limit, const Compression &compression, const Motion &motion) {
    const double *const displacement = motion.displacement;
    ShearStep step;
    step.before = sum(ratio, step.force);
    if (!(stiffness > 0.)) { // an overlap that carries no force: every spring has opened
      std::fill(step.force, step.force + 2, step.work = step.energy = 0.);
      step.slides = false;
      stiffness_ = share_ = 0.;
      std::fill(stretch_, stretch_ + 2 * springs_, 0.);
      return step;
    }
    step.work = 0.5 * dot(step.force, displacement);
    grow(stiffness);
    const int count = touch(stiffness);
    double mean[MOST]; // compression of each spring
    const double carried = compression.means(share_, stiffness, count, mean),
                 scale = carried > 0. ? limit / (carried * ratio) : 0.;
    for (int k = 0; k < count; k++) {
      double *const u = stretch_ + 2 * k, most = scale * mean[k], square = most * most;
      shorten(u, most, square);
      for (int d = 0; d < 2; d++) u[d] += displacement[d];
      shorten(u, most, square);
    }
    step.energy = sum(ratio, step.force);
    step.work += 0.5 * dot(step.force, displacement);
    step.slides = dot(step.force, step.force) >= limit * limit * (1. - 1e-9);
    return step;
  }

private:
  double &stiffness_, &share_, *const stretch_;
  const int springs_;

  // Part of spring k that a contact has whose stiffness is `filled` shares.
  static double part(double filled, int k) { return std::min(std::max(filled - k, 0.), 1.); }
  int touching() const {
    const int whole = std::min((int)(stiffness_ / share_), springs_ - 1);
    return whole * share_ < stiffness_ ? whole + 1 : whole;
  }
  // Force [N] of the springs that touch; returns their energy [J].
  double sum(double ratio, double *force) const {
    double energy = 0.;
    force[0] = force[1] = 0.;
    const int count = share_ > 0. ? touching() : 0;
    for (int k = 0; k < count; k++) {
      const double *const u = stretch_ + 2 * k, stiffness = k < count - 1 ? share_ : stiffness_ - k * share_;
      for (int d = 0; d < 2; d++) force[d] += stiffness * u[d];
      energy += stiffness * dot(u, u);
    }
    for (int d = 0; d < 2; d++) force[d] *= ratio;
    return 0.5 * ratio * energy;
  }
  // The contact has this stiffness now; a spring that begins to touch is not stretched. Returns how many touch.
  int touch(double stiffness) {
    const double held = stiffness_ / share_, filled = stiffness / share_;
    stiffness_ = stiffness;
    const int count = touching();
    for (int k = std::min((int)held, count - 1); k < count; k++) {
      const double was = part(held, k), is = part(filled, k);
      if (is > was) multiply(stretch_ + 2 * k, was / is);
    }
    return count;
  }
  // Joins springs in pairs, with the mean of their stretches, until the row is as stiff as the contact.
  void grow(double stiffness) {
    if (!(share_ > 0.)) share_ = stiffness / springs_;
    while (stiffness > springs_ * share_) {
      const double filled = stiffness_ / share_;
      for (int k = 0; k < springs_; k++) {
        const double first = 2 * k < springs_ ? part(filled, 2 * k) : 0.,
                     second = 2 * k < springs_ ? part(filled, 2 * k + 1) : 0.;
        for (int d = 0; d < 2; d++)
          stretch_[2 * k + d] =
              first > 0. ? (first * stretch_[4 * k + d] + second * stretch_[4 * k + 2 + d]) / (first + second) : 0.;
      }
      share_ *= 2.;
    }
  }
  static double dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1]; }
  static void multiply(double *u, double factor) {
    for (int d = 0; d < 2; d++) u[d] *= factor;
  }
  // To a length of at most `most`, of which this is the square.
  static void shorten(double *u, double most, double most_square) {
    const double square = dot(u, u);
    if (square > most_square) multiply(u, most / sqrt(square));
  }
};

} // namespace demlaws
#endif
