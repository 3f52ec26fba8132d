// demlaws_contact.h: one contact whose law is a table of demlaws: force and stiffness of a step, the stiffness of
// shear, energies. C++11; part of demlaws_table.h.
//
// Licence: GPL-2.0-or-later, as the package demlaws.
#ifndef DEMLAWS_CONTACT_H
#define DEMLAWS_CONTACT_H
#include "demlaws_reader.h"

namespace demlaws {

// What the contacts between two materials share.
struct Pair {
  const Table *table = NULL;
  Unloading rule = ELASTIC;
  double modulus = 0.;        // effective modulus E* [Pa]
  double length = 0.;         // [m]; 0: length_per_radius * R
  double inverse_length = 0.; // [1/m]; where length is 0, of length_per_radius
  double length_per_radius = 0.;
  double only_radius = 0.; // > 0: the only R that the table is valid for (see checked)
  double sigma = 0.;       // roughness [m]; of the table's contact by default

  Pair() {}
  // roughness: combined rms roughness sigma [m]; without it that of the file is taken.
  Pair(const Table &t, double effective_modulus, double roughness = 0.)
      : table(&t), rule(t.unloading()), modulus(effective_modulus),
        sigma(roughness > 0. ? roughness : t.number("sigma", 0.)) {
    if (t.scales_with_sigma()) length = sigma;
    else length_per_radius = 1.;
    inverse_length = 1. / (length > 0. ? length : length_per_radius);
  }
  inline double length_of(double radius) const { return length > 0. ? length : length_per_radius * radius; }

  // As the constructor; a law that does not collapse is refused for another modulus or roughness than its table's, and
  // only_radius is set.
  static Pair checked(const Table &t, double effective_modulus, double roughness = 0.) {
    std::ostringstream wrong;
    if (!std::isfinite(effective_modulus) || !(effective_modulus > LEAST_MODULUS))
      wrong << "modulus = " << effective_modulus
            << " Pa: the effective modulus E* must be above 1000 Pa; did you mean GPa (1 GPa = 1e9 Pa)?";
    else if (!(roughness >= 0.)) wrong << "roughness = " << roughness << " m: must not be negative";
    if (!wrong.str().empty()) throw std::runtime_error(wrong.str());
    Pair pair(t, effective_modulus, t.collapses() ? roughness : 0.);
    if (t.collapses()) return pair;
    const double made_for = t.number("modulus", 0.);
    pair.only_radius = t.number("radius", 0.);
    std::ostringstream what;
    what << t.path() << " holds for one contact only, since law " << t.text("law") << " does not collapse";
    if (!(fabs(effective_modulus - made_for) <= 1e-6 * made_for))
      what << ": for the effective modulus " << made_for << " Pa, not " << effective_modulus
           << " Pa; make a table of this pair";
    else if (roughness > 0.) what << ": for its own roughness; give no roughness with it";
    else return pair;
    throw std::runtime_error(what.str());
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
  bool outside;  // the overlap lies beyond the table: force is an uncertified extrapolation
  double square; // a^2 of the contact area [m^2] on first loading; 0 where the contact unloads
};

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
    const double u = overlap * inverse_length;
    double s;
    now.outside = !pair.table->loading_curve().evaluate(u, s, slope);
    hertz_overlap = s * length;
    const double area = RULE == ETSION    ? pair.table->area_of_overlap(u)
                        : RULE == JACKSON ? pair.table->fitted_area(u, s)
                                          : pair.table->area(s);
    now.square = area * length * radius;
    if (RULE != ELASTIC && update && s == s) {
      state[0] = overlap;
      if (RULE == HERTZ) state[1] = overlap - hertz_overlap;
      else if (RULE == GIVEN) state[1] = overlap - pair.table->inverse_near(s) * length;
      else if (RULE == LINEAR) // P/k2
        state[1] = overlap - (4. / 3.) * s * sqrt(s) / pair.table->linear_stiffness(u) * length;
      else if (RULE == EEPA) state[1] = pair.table->eepa_plastic() * overlap;
      else {
        // R_p/R = (area/s)^1.5, recoverable overlap s (R/R_p)^(1/3)
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
    if (keeps_radius(RULE)) effective_radius *= state[2];
  }
  const double root = pair.modulus * sqrt(effective_radius * hertz_overlap);
  now.force = (4. / 3.) * root * hertz_overlap;
  now.stiffness = 2. * root * slope;
  return now;
}

// What a template gives whose rule of unloading is a contact's: Of<RULE>::call.
template <template <Unloading> class Of, int RULE = 0, class... Arguments>
inline auto with_rule(Unloading rule, Arguments &&...arguments) -> decltype(Of<ELASTIC>::call(arguments...)) {
  constexpr int NEXT = RULE + 1 < RULES ? RULE + 1 : RULE;
  return RULE == rule || NEXT == RULE ? Of<(Unloading)RULE>::call(arguments...)
                                      : with_rule<Of, NEXT>(rule, arguments...);
}

template <Unloading RULE> struct StepOf {
  static inline Force call(const Pair &pair, double radius, double overlap, double *state, bool update,
                           double inverse_radius) {
    return step_rule<RULE>(pair, radius, overlap, state, update, inverse_radius);
  }
};
inline Force step(const Pair &pair, double radius, double overlap, double *state, bool update = true,
                  double inverse_radius = 0.) {
  return with_rule<StepOf>(pair.rule, pair, radius, overlap, state, update, inverse_radius);
}

inline Force step(const Pair &pair, double radius, double overlap, State &state) {
  return step(pair, radius, overlap, &state.maximum_overlap);
}

// Integral of x^1.5 - plastic^1.5 from the plastic overlap, as a product: the difference of its terms would cancel.
inline double eepa_energy(double overlap, double plastic) {
  const double a = sqrt(overlap), b = sqrt(plastic);
  return 0.2 * (a - b) * (a - b) * (a * a * (2. * a + 4. * b) + b * b * (6. * a + 3. * b));
}

// Mean pressure P / (pi a^2) [Pa] after a step: a is that of first loading, or K / (2 E*) where the contact unloads.
inline double mean_pressure(const Pair &pair, const Force &now) {
  const double a = 0.5 * now.stiffness / pair.modulus, square = now.square > 0. ? now.square : a * a;
  return now.force > 0. && square > 0. ? now.force / (M_PI * square) : 0.;
}

// Whether `name` is a choice of the normal stiffness that K_t is a multiple of (docs/shear.md); SLIP: that of ELASTIC,
// with partial slip (demlaws_slip.h).
inline bool shear_from_name(const std::string &name, Shear &shear) {
  for (int number : {ELASTIC_SHEAR, LOADING_SHEAR, SLIP_SHEAR})
    if (name == SHEAR_NAMES[number]) return shear = (Shear)number, true;
  return false;
}

// That stiffness [N/m], from the result of step_rule and the state that it left (or, with `update` false, found): the
// stiffness with which the contact would unload now, or that of first loading at the force now carried.
template <Unloading RULE>
inline double shear_stiffness(Shear shear, const Pair &pair, double radius, double overlap, const Force &now,
                              const double *state) {
  if (RULE == ELASTIC || !(now.force > 0.)) return now.stiffness;
  if (shear == SLIP_SHEAR) shear = ELASTIC_SHEAR;
  const bool loads = !(overlap < state[0]);
  if (shear == ELASTIC_SHEAR) {
    if (!loads) return now.stiffness;
    const bool known = overlap == state[0];
    if ((RULE == HERTZ || keeps_radius(RULE)) && known) {
      const double recoverable =
          overlap - state[1]; // K = 1.5 P / recoverable overlap, where rounding leaves some of it
      if (recoverable > 1e-9 * overlap) return 1.5 * now.force / recoverable;
      const double root = sqrt(RULE == HERTZ ? radius : radius * state[2]);
      return 2. * pair.modulus * root * cbrt(0.75 * now.force / (pair.modulus * root));
    }
    double own[3] = {0., 0., 0.};
    for (int i = 0; i < state_size(RULE); i++) own[i] = state[i];
    if (!known) step_rule<RULE>(pair, radius, overlap, own, true);
    own[0] *= 1. + 1. / 4503599627370496.; // to the next number: so the step at this overlap is one of unloading
    return step_rule<RULE>(pair, radius, overlap, own, false).stiffness;
  }
  if (loads) return now.stiffness;
  const double length = pair.length_of(radius), root = cbrt(0.75 * now.force / (pair.modulus * sqrt(radius)));
  return 2. * pair.modulus * sqrt(radius) * root * pair.table->loading_curve().slope_where(root * root / length);
}

template <Unloading RULE> struct ShearStiffnessOf {
  static inline double call(Shear shear, const Pair &pair, double radius, double overlap, const Force &now,
                            const double *state) {
    return shear_stiffness<RULE>(shear, pair, radius, overlap, now, state);
  }
};
inline double shear_stiffness(Shear shear, const Pair &pair, double radius, double overlap, const Force &now,
                              const double *state) {
  return with_rule<ShearStiffnessOf>(pair.rule, shear, pair, radius, overlap, now, state);
}

// Work that a contact with a history gives back from this overlap on, along the curve that it unloads along [J].
inline double given_back(const Pair &pair, double radius, double overlap, const double *state) {
  const double length = pair.length_of(radius), left = std::max(0., overlap - state[1]);
  if (pair.rule == LINEAR)
    return 0.5 * pair.modulus * sqrt(radius * length) * pair.table->linear_stiffness(state[0] / length) * left * left;
  if (pair.rule == EEPA)
    return pair.modulus * sqrt(radius) * pair.table->eepa_stiffness() * eepa_energy(overlap, state[1]);
  // negative at small overlaps of a curve that starts from a force: the part below zero overlap never comes back
  const double below = std::max(0., -state[1]);
  if (pair.rule == GIVEN) {
    const Curve &curve = pair.table->unloading_curve();
    return pair.modulus * sqrt(radius) * length * length * sqrt(length) *
           (curve.energy(left / length) - curve.energy(below / length));
  }
  const double r = keeps_radius(pair.rule) ? radius * state[2] : radius;
  return (8. / 15.) * pair.modulus * sqrt(r) * (left * left * sqrt(left) - below * below * sqrt(below));
}

// Energies of one contact since it was made [J]: what it would give back, and what its plastic flow took.
inline void stored_and_dissipated(const Pair &pair, double radius, double overlap, const double *state, double &stored,
                                  double &dissipated) {
  stored = dissipated = 0.;
  const double length = pair.length_of(radius);
  const double scale = pair.modulus * sqrt(radius) * length * length * sqrt(length);
  if (pair.rule == ELASTIC) {
    if (overlap > 0.) stored = scale * pair.table->loading_curve().energy(overlap / length);
    return;
  }
  if (!(state[0] > 0.)) return;
  if (overlap > 0. && overlap > state[1]) stored = std::max(0., given_back(pair, radius, overlap, state));
  dissipated =
      scale * pair.table->loading_curve().energy(state[0] / length) - given_back(pair, radius, state[0], state);
}

// That no cell of loading makes less heat than none: after it, unloading would return more work than loading took.
inline void Table::refuse_unless_passive() const {
  if (unloads_ == ELASTIC) return;
  const Pair pair(*this, number("modulus", 0.));
  const std::vector<Row> &rows = sections_[0].rows;
  const double radius = number("radius", 0.), length = pair.length_of(radius);
  double share = ROUNDING, work_before = 0., heat_before = 0.;
  for (const Section &section : sections_)
    share += 2. * (section.number("force_error") + section.number("stiffness_error"));
  for (int i = -40; i < (int)rows.size(); i++) { // from 40 octaves below the first row
    double u = i < 0 ? rows[0].u * ldexp(1., i) : rows[i].u, stored, heat;
    const bool behind = i > 0 && rows[i - 1].u == u,
               before = i + 1 == (int)rows.size() || (i >= 0 && rows[i + 1].u == u);
    if (behind || before) u *= behind ? 1. + 1e-12 : 1. - 1e-12; // beside a kink, and where the last row is
    State state;
    step(pair, radius, u * length, state);
    stored_and_dissipated(pair, radius, u * length, &state.maximum_overlap, stored, heat);
    const double work = stored + heat;
    if (i > -40 && !behind && !(heat - heat_before >= -share * (work - work_before) - ROUNDING * work))
      fail(sections_[0].first_row + std::max(i, 0),
           "unloading '" + text("unloading") +
               "' returns more work from here than loading took from the row before: this "
               "table cannot take that rule");
    work_before = work;
    heat_before = heat;
  }
}

} // namespace demlaws
#endif
