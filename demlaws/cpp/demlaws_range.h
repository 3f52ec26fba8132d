// demlaws_range.h: where a contact leaves the range of its law. Overlaps, roughness, moduli, and the limits that a
// table names: the checks of the plugins of LIGGGHTS and LAMMPS, their messages, their counts.
#ifndef DEMLAWS_RANGE_H
#define DEMLAWS_RANGE_H

#include "demlaws_table.h"
#include <set>

namespace demlaws {

const double SOFTENED = 1e-5, STIFFENED = 10.; // E* over the table's, warned of beyond them

// What a contact can leave. Each kind is counted by itself.
enum Excess { DEEP, BEYOND, ROUGH, YIELDS, ABOVE, BELOW, HARD, EXCESSES };

// Contact steps of one run that left a limit.
struct Count {
  double steps = 0., worst = 0.; // how many; by the largest factor
  long first = -1, second = -1;  // numbers of the particles of that one; second -1: a wall
  void add(const Count &other) {
    steps += other.steps;
    if (other.worst <= worst) return;
    worst = other.worst;
    first = other.first;
    second = other.second;
  }
};

// The counts of one run on one rank, and what was reported already.
struct Counts {
  Count of[EXCESSES];
  std::set<std::string> reported, reasons[EXCESSES];
  const std::string *latest[EXCESSES] = {}; // reason that was counted last: most steps of a run have the same one
  // Lines for the end of a run, from the sums over all ranks; the counts begin again.
  template <class RANKS> std::vector<std::string> summaries(const RANKS &ranks) {
    std::vector<std::string> lines;
    for (int k = 0; k < EXCESSES; k++) {
      Count sum;
      for (const Count &one : ranks.gather(of[k])) sum.add(one);
      of[k] = Count();
      if (sum.steps > 0.) lines.push_back(summary((Excess)k, sum));
    }
    return lines;
  }

private:
  static std::string summary(Excess excess, const Count &sum) {
    static const char *const where[EXCESSES][2] = {
        {"deeper than a tenth of R", "times that: the laws are valid for small overlaps"},
        {"beyond the last row of their table", "times its overlap: extrapolated, not certified"},
        {"rougher than a tenth of R", "times that: the laws assume a roughness far below the radius"},
        {"above the load at which the bulk yields", "times the pressure 0.6 H_m: the law keeps the bulk elastic"},
        {"above the range of force of their law", "times its end"},
        {"below the range of force of their law", "times (its end over the force)"},
        {"above the hardness in mean pressure", "times it: friction by pressure is not known there"}};
    std::ostringstream text;
    text.precision(3);
    text << "demlaws/table: in this run " << (long long)sum.steps << " contact steps were " << where[excess][0]
         << ", by up to " << sum.worst << " " << where[excess][1] << "; worst: particle";
    if (sum.second < 0) text << " " << sum.first << " and a wall";
    else text << "s " << sum.first << " and " << sum.second;
    return text.str();
  }
};

// Text about the modulus of a pair, "" for a plausible value.
inline std::string judge_modulus(const Table &table, double modulus) {
  std::ostringstream what;
  what << "modulus = " << modulus << " Pa";
  const double made_for = table.number("modulus", modulus);
  if (modulus >= SOFTENED * made_for && modulus <= STIFFENED * made_for) return "";
  what << " is " << modulus / made_for << " times the effective modulus of " << table.path() << ", " << made_for
       << " Pa: check the units of Young's modulus and Poisson's ratio";
  return what.str();
}

// Where a box is periodic and less than two contacts long, two particles can touch through both sides: two contacts
// with the same two numbers, by which the engine finds their histories.
inline std::string thin_box(int axis, double length, double enough, const char *engine) {
  std::ostringstream what;
  what << "demlaws/table: the box is " << length << " long in "
       << "xyz"[axis]
       << ", where it is periodic: two particles can touch through both sides, and their two histories are mixed up, "
       << "which " << engine << " finds by their numbers; from " << enough << " on they cannot";
  return what.str();
}

// What an engine does with the findings on one contact.
class Findings {
public:
  Findings(Counts &counts, bool keeps) : counts_(counts), keeps_(keeps) {} // keeps: this step is counted
  virtual ~Findings() {}
  // Counts an excess by this factor; whether its text, which `reason` identifies, is still to be reported.
  bool counts(Excess excess, double factor, const std::string &reason) {
    Count &sum = counts_.of[excess];
    sum.steps += keeps_;
    if (keeps_ && factor > sum.worst) {
      sum.worst = factor;
      sum.first = body(0);
      sum.second = body(1);
    }
    if (counts_.latest[excess] == &reason) return false;
    counts_.latest[excess] = &reason;
    return counts_.reasons[excess].insert(reason).second;
  }
  bool counts(Excess excess, double factor) {
    static const std::string no_reason;
    return counts(excess, factor, no_reason);
  }
  virtual long body(int which) const = 0; // number of the first or second particle, -1: a wall
  virtual void warn(const std::string &text) = 0;
  virtual void refuse(const std::string &text) = 0;

private:
  Counts &counts_;
  const bool keeps_;
};

inline std::string other_radius(const Pair &pair, double radius, double tolerance) {
  std::ostringstream what;
  what << "contact radius " << radius << " m, but law " << pair.table->text("law") << " does not collapse and "
       << pair.table->path() << " holds for " << pair.only_radius << " m (radius_tolerance " << tolerance
       << "); make a table of this pair of types or widen the tolerance";
  return what.str();
}

// Checks of one contact.
class Watch {
public:
  Watch() {}
  explicit Watch(const Pair &pair) {
    const Table &table = *pair.table;
    deep_ = SMALL_OVERLAP * (1. + 1e-9);
    hardness_ = table.number("hardness", HUGE_VAL);
    smallest_ = pair.sigma / LARGE_ROUGHNESS;
    for (const Limit &limit : table.limits()) {
      if (limit.kind == Limit::BULK_YIELD && hardness_ == HUGE_VAL) continue;
      if (limit.kind == Limit::BULK_YIELD) { // what roughness takes from the pressure is left to examine()
        const double root = 0.5 * M_PI * limit.value * hardness_ / pair.modulus;
        deep_ = std::min(deep_, root * root);
        continue;
      }
      const double root = cbrt(0.75 * limit.value), u = table.loading_curve().where(root * root);
      if (limit.kind == Limit::FORCE_BELOW) (pair.length > 0. ? below_ : below_per_radius_) = u * pair.length_of(1.);
      else if (pair.length > 0.) above_ = std::min(above_, u * pair.length);
      else deep_ = std::min(deep_, u * pair.length_per_radius);
    }
  }
  // Whether there may be something to report; asked at every step of every contact.
  inline bool exceeds(double overlap, double radius) const {
    return (overlap > deep_ * radius) | (overlap > above_) | (overlap < below_ + below_per_radius_ * radius) |
           (radius < smallest_);
  }
  // The same of friction by pressure, of a mean pressure [Pa].
  inline bool exceeds_hardness(double pressure) const { return pressure > hardness_; }
  void examine_friction(double pressure, Findings &findings) const {
    if (!findings.counts(HARD, pressure / hardness_)) return;
    std::ostringstream what;
    what.precision(4);
    what << "mean pressure " << pressure << " Pa is above the hardness " << hardness_
         << " Pa: the friction law is not known there";
    findings.warn(what.str());
  }
  // Reports it. starts: in the first forces of a run, before anything has moved.
  void examine(const Pair &pair, double radius, double overlap, const Force &now, bool extrapolates, bool starts,
               Findings &findings) const {
    check_overlap(pair, radius, overlap, now, extrapolates, starts, findings);
    check_roughness(pair, radius, findings);
    if (now.force > 0.)
      for (const Limit &limit : pair.table->limits()) check_limit(limit, pair, radius, now.force, findings);
  }

private:
  double deep_ = SMALL_OVERLAP, above_ = HUGE_VAL, below_ = 0., below_per_radius_ = 0., smallest_ = 0.;
  double hardness_ = HUGE_VAL; // [Pa]; as it is: not known

  static std::string remedy(bool starts) {
    return starts ? "the particles overlap so before the first step: move them apart"
                  : "take a smaller time step if no such force was meant";
  }
  static void check_overlap(const Pair &pair, double radius, double overlap, const Force &now, bool extrapolates,
                            bool starts, Findings &findings) {
    const double ratio = overlap / radius;
    if (ratio > SMALL_OVERLAP * (1. + 1e-9)) {
      const bool refused = ratio > LARGEST_OVERLAP && !extrapolates;
      if (refused) findings.refuse(too_deep(pair, radius, overlap) + "; " + remedy(starts) + ", or 'extrapolation on'");
      if (findings.counts(DEEP, ratio / SMALL_OVERLAP)) findings.warn(too_deep(pair, radius, overlap));
    }
    if (!now.outside) return;
    const double last = pair.table->loading_curve().last() * pair.length_of(radius);
    if (extrapolates && !findings.counts(BEYOND, overlap / last)) return;
    std::ostringstream what;
    what << "overlap " << overlap << " m is beyond the last row of " << pair.table->path() << ", " << last << " m";
    if (extrapolates) {
      what << ": its last power law goes on, uncertified";
      findings.warn(what.str());
      return;
    }
    what << " (some " << now.force << " N): make the table with a larger --max-force (`demlaws table --max-force N`), "
         << remedy(starts) << ", or say 'extrapolation on'";
    findings.refuse(what.str());
  }
  static std::string too_deep(const Pair &pair, double radius, double overlap) {
    const double ratio = overlap / radius;
    const bool undefined = ratio > LARGEST_OVERLAP;
    const double softened = pair.modulus / pair.table->number("modulus", HUGE_VAL);
    std::ostringstream what;
    what << "overlap " << overlap << " m is ";
    what.precision(3);
    what << ratio << (undefined ? " times" : " of") << " the effective radius R = ";
    what.precision(6);
    what << radius << " m: contact laws are valid for overlaps up to " << SMALL_OVERLAP << " R"
         << (undefined ? " and undefined beyond R" : "") << "; check units, loads and the step";
    if (softened > 0. && softened < 0.99)
      what << "; E* is " << softened << " of the table's: soften the grains less (`demlaws soften`)";
    return what.str();
  }
  static void check_roughness(const Pair &pair, double radius, Findings &findings) {
    const double ratio = pair.sigma / radius;
    if (!(ratio > LARGE_ROUGHNESS)) return;
    const double limit = ratio > LARGEST_ROUGHNESS ? LARGEST_ROUGHNESS : LARGE_ROUGHNESS;
    std::ostringstream what;
    what << "roughness = " << pair.sigma << " m is " << std::round(1000. * ratio) / 1000. << " times the radius "
         << radius << " m, above " << limit
         << ": the laws assume a roughness far below the radius; did you mean µm (1 µm = 1e-6 m)?";
    if (ratio > LARGEST_ROUGHNESS) findings.refuse(what.str());
    if (findings.counts(ROUGH, ratio / LARGE_ROUGHNESS)) findings.warn(what.str());
  }
  // Central pressure over hardness: Hertz's p0 times 1 - exp(-2/(3 alpha^0.6)), alpha = sigma over Hertz's overlap.
  double pressure(const Pair &pair, double radius, double force) const {
    const double root = cbrt(0.75 * force / (pair.modulus * sqrt(radius))), hertz_overlap = root * root;
    const double alpha = pair.sigma / hertz_overlap;
    const double drop = alpha > 0. ? -expm1(-2. / (3. * pow(alpha, 0.6))) : 1.;
    return 2. * pair.modulus / M_PI * sqrt(hertz_overlap / radius) * drop / hardness_;
  }
  void check_limit(const Limit &limit, const Pair &pair, double radius, double force, Findings &findings) const {
    if (limit.kind == Limit::BULK_YIELD && hardness_ == HUGE_VAL) return;
    const double length = pair.length_of(radius);
    const double end = limit.value * pair.modulus * sqrt(radius * length) * length;
    const bool yields = limit.kind == Limit::BULK_YIELD, below = limit.kind == Limit::FORCE_BELOW;
    const double factor = (yields  ? pressure(pair, radius, force) / limit.value
                           : below ? end / force
                                   : force / end) *
                          (1. - 1e-9);
    if (!(factor > 1.) || !findings.counts(yields ? YIELDS : below ? BELOW : ABOVE, factor, limit.reason)) return;
    std::ostringstream what;
    what.precision(3);
    what << "force " << force << " N of law " << pair.table->text("law");
    if (!yields) what << ", " << (below ? "below " : "above ") << end << " N";
    what << ": " << limit.reason;
    findings.warn(what.str());
  }
};

} // namespace demlaws
#endif
