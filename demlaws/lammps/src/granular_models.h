// The granular sub-models of demlaws, for each layout of LAMMPS's classes (granular_abi.h).
//   normal   demlaws/table FILE E eta nu [roughness SIGMA] [against E2 nu2] [radius_tolerance X] [extrapolation on]
//            [shear elastic|loading]
//            E, eta, nu as those of hertz/material; SIGMA: combined rms roughness of the two bodies [m] (without it:
//            the length in FILE); against: the other body is of another material; shear: the normal stiffness of K_t
//   damping  demlaws/tangent
//            eta is the coefficient of restitution; c = c(e) sqrt(m K) with the tangent stiffness K of the table
#ifndef DEMLAWS_GRANULAR_MODELS_H
#define DEMLAWS_GRANULAR_MODELS_H

#include "energy.h"
#include "granular_abi.h"
#include "range.h"
#include "tables.h"

namespace {

__attribute__((noinline)) bool check_elsewhere(void *m) { return Stock::get().check(m); }
__attribute__((noinline)) void compute_elsewhere(void *m) { Stock::get().compute(m); }

// The material that makes E* and G* of the pair those of the two materials: stock hertz/material takes E* for E here,
// so that `mindlin NULL` is too soft by about half.
inline void join(double E1, double nu1, double E2, double nu2, double &E, double &nu) {
  const double modulus = 1. / ((1. - nu1 * nu1) / E1 + (1. - nu2 * nu2) / E2);
  const double shear = 1. / (2. * (2. - nu1) * (1. + nu1) / E1 + 2. * (2. - nu2) * (1. + nu2) / E2);
  const double ratio = modulus / shear;
  nu = (ratio - 4.) / (ratio - 2.);
  E = 2. * (1. - nu * nu) * modulus;
}

template <bool LATE> struct Granular {
  typedef typename Abi<LATE>::Model Model;
  typedef typename Abi<LATE>::SubMod SubMod;
  typedef typename Abi<LATE>::NormalMod NormalMod;
  typedef typename Abi<LATE>::DampingMod DampingMod;

  class Table : public NormalMod {
  public:
    using NormalMod::coeffs;
    using NormalMod::damp;
    using NormalMod::Emod;
    using NormalMod::gm;
    using NormalMod::history_index;
    using NormalMod::index_svector;
    using NormalMod::name;
    using NormalMod::nsvector;
    using NormalMod::of;
    using NormalMod::poiss;
    enum { YOUNG, ETA, POISSON, ROUGHNESS, TOLERANCE, EXTRAPOLATE, SHEAR, FINGERPRINT, COEFFICIENTS };
    enum { MAXIMUM, PLASTIC, STORED, DISSIPATED, STIFFNESS, OUTPUTS }; // p13 to p17 of compute pair/local
    enum { MOST_STATE = 3 };

    // `named`: "demlaws/table FILE". The file goes into restarts, and must agree for mixing, because it is in the name.
    Table(Model *m, const std::string &named, const demlaws::Table &table)
        : NormalMod(m, COEFFICIENTS, OUTPUTS), table_(table), ledger_(Ledger::of(m->of.lmp)), stiffness_(0.),
          per_stiffness_(0.), shear_(demlaws::ELASTIC_SHEAR), whole_(false), speed_(true), damped_(OTHERWISE) {
      name = named;
      this->material_properties = 1;
      // Always the largest state: PairGranular::transfer_history moves the values of a pair of types whose sub-models
      // have other sizes than those of another pair to the wrong place.
      this->size_history = MOST_STATE;
      // the state is the same seen from either particle: the default factor -1 is not for it
      this->nondefault_history_transfer = 1;
      this->transfer_history_factor = new double[MOST_STATE];
      std::fill(this->transfer_history_factor, this->transfer_history_factor + MOST_STATE, 1.);
      coeffs[TOLERANCE] = 0.01;
      coeffs[SHEAR] = demlaws::ELASTIC_SHEAR;
      coeffs[FINGERPRINT] = table.fingerprint();
    }

    void coeffs_to_local() {
      Emod = coeffs[YOUNG];
      damp = coeffs[ETA];
      poiss = coeffs[POISSON];
      if (!(Emod > 0.) || !(damp >= 0.) || !(poiss > -1. && poiss <= 0.5) || !(coeffs[ROUGHNESS] >= 0.) ||
          !(coeffs[TOLERANCE] >= 0.))
        refuse(
            "Young's modulus must be positive, eta, roughness and radius_tolerance not negative, Poisson's ratio from "
            "-1 to 0.5");
      if (coeffs[SHEAR] != demlaws::ELASTIC_SHEAR && coeffs[SHEAR] != demlaws::LOADING_SHEAR)
        refuse("the restart file has 'shear tangent', which created energy and is gone: write pair_coeff again");
      if (coeffs[FINGERPRINT] != (double)table_.fingerprint())
        refuse(
            "this is not the table that the restart file was written with: bring that file back, or write pair_coeff "
            "anew");
      try { // two bodies of one material
        pair_ = demlaws::Pair::checked(table_, Emod / (2. * (1. - poiss * poiss)), coeffs[ROUGHNESS]);
      } catch (const std::exception &problem) {
        refuse(problem.what());
      }
      per_stiffness_ = 0.5 / pair_.modulus;
      shear_ = (demlaws::Shear)(int)coeffs[SHEAR];
    }

    void mix_coeffs(double *a, double *b) {
      join(a[YOUNG], a[POISSON], b[YOUNG], b[POISSON], coeffs[YOUNG], coeffs[POISSON]);
      coeffs[ETA] = sqrt(a[ETA] * b[ETA]);
      if ((a[ROUGHNESS] > 0.) != (b[ROUGHNESS] > 0.))
        refuse("either both types or none must have a roughness to be mixed");
      coeffs[ROUGHNESS] = sqrt(0.5 * (a[ROUGHNESS] * a[ROUGHNESS] + b[ROUGHNESS] * b[ROUGHNESS]));
      coeffs[TOLERANCE] = std::min(a[TOLERANCE], b[TOLERANCE]);
      coeffs[EXTRAPOLATE] = std::min(a[EXTRAPOLATE], b[EXTRAPOLATE]);
      if (a[SHEAR] != b[SHEAR]) refuse("both types must have the same 'shear' to be mixed");
      coeffs[SHEAR] = a[SHEAR];
      coeffs[FINGERPRINT] = a[FINGERPRINT];
      coeffs_to_local();
    }

    double calculate_contact_radius() { return 0.; } // asked for before calculate_forces(), which sets it
    double stiffness() const { return stiffness_; }
    bool unloads_otherwise() const { return table_.unloading() != demlaws::ELASTIC; }

    // GranularModel::calculate_forces for a pair of particles, where nothing but this law, a damping and a tangential
    // model are at work; else LAMMPS's own.
    virtual void whole() = 0;
    bool is_whole() const { return whole_; }
    static Table *latest; // of those that are whole, the one met last
    ~Table() { latest = latest == this ? NULL : latest; }
    void plan(bool proved) {
      latest = NULL;
      const Model *const m = gm;
      whole_ = proved && !m->beyond_contact;
      for (int k = ROLLING; k <= HEAT; k++) whole_ = whole_ && m->sub_models[k]->name == "none";
      const std::string &tangential = m->sub_models[TANGENTIAL]->name;
      whole_ = whole_ && tangential != "none";
      speed_ = tangential.compare(0, 7, "mindlin") != 0;
      damped_ = m->damping_model->name == "demlaws/tangent" ? BY_TANGENT
                : m->damping_model->name == "viscoelastic"  ? BY_RADIUS
                                                            : OTHERWISE;
    }

  protected:
    template <demlaws::Unloading RULE> inline double finish(const demlaws::Force now) {
      Model *const m = gm;
      if (__builtin_expect(m->contact_type > WALL_REGION, 0)) refuse_contact();
      if (__builtin_expect(now.outside || m->delta > SMALL_OVERLAP * m->Reff, 0)) far(now.force, now.outside);
      if (__builtin_expect(!pair_.serves(m->Reff, coeffs[TOLERANCE]), 0)) refuse_radius();
      stiffness_ = now.stiffness;
      // K = 2 E* a: what mindlin, viscoelastic and heat scale with
      m->contact_radius =
          demlaws::shear_stiffness<RULE>(shear_, pair_, m->Reff, m->delta, now, m->history + history_index) *
          per_stiffness_;
      return now.force;
    }
    // After a step that somebody wants to know more of: the state that the contact had before, that it keeps, and that
    // the step at this overlap gives it, which is not kept where histories are only looked at (setup, compute
    // pair/local).
    __attribute__((noinline, cold)) void account(const double *before, const double *kept, const double *state) {
      Model *const m = gm;
      double stored = 0., dissipated = 0., none, booked = 0.;
      demlaws::stored_and_dissipated(pair_, m->Reff, m->delta, state, stored, dissipated);
      demlaws::stored_and_dissipated(pair_, m->Reff, m->delta, kept, none, booked);
      const double pending = dissipated - booked;
      if (m->calculate_svector && nsvector) {
        double *const out = m->svector + index_svector;
        const bool keeps = state[0] > 0. && pair_.rule != demlaws::ELASTIC;
        const bool own = pair_.rule == demlaws::OWN; // which remembers what it likes
        out[MAXIMUM] = own ? NAN : keeps ? state[0] : m->delta;
        out[PLASTIC] = own ? NAN : keeps ? state[1] : 0.;
        out[STORED] = stored;
        out[DISSIPATED] = dissipated;
        out[STIFFNESS] = stiffness_;
      }
      if (ledger_.collecting) {
        ledger_.collected += stored;
        ledger_.pending += pending;
        return;
      }
      if (!ledger_.busy) return;
      const bool wall = m->contact_type != PAIR;
      if (m->history_update && !std::equal(before, before + MOST_STATE, state)) {
        double earlier = 0.;
        demlaws::stored_and_dissipated(pair_, m->Reff, m->delta, before, none, earlier);
        ledger_.take(m->vi, wall ? NULL : m->vj, dissipated - earlier);
      }
      if (wall) {
        const WallContact contact = {stored, pending};
        ledger_.enter(contact);
      }
    }

    const demlaws::Table &table_;
    Ledger &ledger_;
    demlaws::Pair pair_;
    double stiffness_, per_stiffness_;
    demlaws::Shear shear_;
    bool whole_, speed_; // speed_: the tangential model asks for that of the surfaces, vrel
    enum { OTHERWISE, BY_TANGENT, BY_RADIUS } damped_; // BY_RADIUS: viscoelastic, whose formula Abi::fits() has checked

  private:
    __attribute__((noinline, cold)) void refuse(const std::string &what) const {
      raise(*of.error, true, name + ": " + what);
    }
    // The bodies by their numbers, as far as they are known: a wall's model is told of its particle's velocity alone.
    __attribute__((noinline, cold)) std::string who() const {
      const Stock &stock = Stock::get();
      const void *const tags = stock.atom(of.lmp, "id");
      const bool wall = gm->contact_type != PAIR;
      const long at[2] = {wall ? ledger_.particle("v", gm->vi) : ledger_.particle("x", gm->xi),
                          wall ? -1 : ledger_.particle("x", gm->xj)};
      std::ostringstream what;
      what << name << ": " << (wall ? "particle " : "particles ");
      for (int k = 0; k < (wall ? 1 : 2); k++) {
        if (k) what << " and ";
        if (!tags || at[k] < 0) what << "?";
        else if (stock.setting(of.lmp, "tagint") == 8) what << ((const long long *)tags)[at[k]];
        else what << ((const int *)tags)[at[k]];
      }
      if (wall) what << " and the wall";
      what << ": ";
      return what.str();
    }
    // An overlap that is large for any law of small strains is warned of and counted; beyond R, or the last row of the
    // table, it is refused, or counted with `extrapolation on`.
    __attribute__((noinline, cold)) void far(double force, bool outside) const {
      const double ratio = gm->delta / gm->Reff, last = table_.last_overlap() * pair_.length_of(gm->Reff);
      const bool extrapolates = coeffs[EXTRAPOLATE] > 0., counted = gm->history_update != 0;
      Range &range = Range::of(of.lmp);
      if (ratio > SMALL_OVERLAP * (1. + 1e-9)) {
        std::ostringstream what;
        const bool none = ratio > LARGEST_OVERLAP;
        what << who() << "overlap " << gm->delta << " m is " << std::setprecision(3) << ratio
             << (none ? " times" : " of") << std::setprecision(6) << " the effective radius R = " << gm->Reff
             << " m: contact laws hold for overlaps up to " << SMALL_OVERLAP << " R"
             << (none ? ", beyond R there is no answer" : "") << "; check units, loads and the step";
        if (none && !extrapolates) raise(*of.error, false, what.str() + ", or say 'extrapolation on'");
        Range::report(of.lmp, *of.error, range.deep, ratio / SMALL_OVERLAP, counted, what.str());
      }
      if (!outside) return;
      std::ostringstream what;
      what << who() << "overlap " << gm->delta << " m is beyond the last row of " << table_.path() << ", " << last
           << " m";
      if (extrapolates) {
        what << ": its last power law goes on, uncertified";
        Range::report(of.lmp, *of.error, range.beyond, gm->delta / last, counted, what.str());
        return;
      }
      what << " (some " << force << " N): make the table with a larger --max-force (`demlaws table --max-force N`), "
           << "take a smaller time step if no such force was meant, or say 'extrapolation on'";
      raise(*of.error, false, what.str());
    }
    __attribute__((noinline, cold)) void refuse_contact() const {
      std::ostringstream what;
      what << name << ": contacts of type " << gm->contact_type
           << " (of a newer LAMMPS) are not known here; use pairs of spheres, wall/gran or wall/gran/region";
      raise(*of.error, false, what.str());
    }
    __attribute__((noinline, cold)) void refuse_radius() const {
      std::ostringstream what;
      what << who() << "contact radius " << gm->Reff << " m, but law " << table_.text("law")
           << " does not collapse and the table holds for " << pair_.only_radius << " m (radius_tolerance "
           << coeffs[TOLERANCE] << "); make a table of this pair of types or widen the tolerance";
      raise(*of.error, false, what.str());
    }
  };

  // The rule of unloading is known when compiled.
  template <demlaws::Unloading RULE> class Ruled : public Table {
  public:
    Ruled(Model *m, const std::string &named, const demlaws::Table &table) : Table(m, named, table) {}
    __attribute__((flatten)) double calculate_forces() {
      return __builtin_expect(this->ledger_.busy | this->gm->calculate_svector, 0) ? watched() : force();
    }

    __attribute__((flatten)) void whole() {
      Model *const m = this->gm;
      if (__builtin_expect(this->ledger_.busy | m->calculate_svector, 0)) return compute_elsewhere(m);
      geometry(m, this->speed_);
      m->Fnormal = force();
      DampingMod *const damped = m->damping_model;
      if (this->damped_ != Table::OTHERWISE) {
        const bool by_tangent = this->damped_ == Table::BY_TANGENT;
        damped->damp_prefactor =
            damped->damp * (by_tangent ? sqrt(m->meff * this->stiffness_) : m->meff * m->contact_radius);
        sum(m, m->Fnormal - damped->damp_prefactor * m->vnnr);
      } else sum(m, m->Fnormal + call<double>(damped, FORCES));
    }

  private:
    inline double force() {
      Model *const m = this->gm;
      double *const state = m->history + this->history_index;
      return this->template finish<RULE>(
          demlaws::step_rule<RULE>(this->pair_, m->Reff, m->delta, state, m->history_update != 0));
    }
    __attribute__((noinline, cold)) double watched() {
      Model *const m = this->gm;
      double *const state = m->history + this->history_index;
      const double before[Table::MOST_STATE] = {state[0], state[1], state[2]};
      const double found = force();
      double now[Table::MOST_STATE] = {state[0], state[1], state[2]};
      if (!m->history_update) demlaws::step_rule<RULE>(this->pair_, m->Reff, m->delta, now, true);
      this->account(before, state, now);
      return found;
    }
  };

  class Tangent : public DampingMod {
  public:
    Tangent(Model *m, const std::string &named) : DampingMod(m), normal_(NULL) { this->name = named; }
    void init() {
      normal_ = dynamic_cast<Table *>(this->gm->normal_model);
      if (!normal_)
        raise(*this->of.error, true, "damping demlaws/tangent goes with the normal model demlaws/table only");
      const double e = normal_->damp, logarithm = e > 0. ? log(e) : 0.;
      if (!(e > 0. && e <= 1.))
        raise(*this->of.error, true, "damping demlaws/tangent: eta is a coefficient of restitution, above 0 to 1");
      this->damp = -2. * sqrt(5. / 6.) * logarithm / sqrt(M_PI * M_PI + logarithm * logarithm);
    }
    double calculate_forces() {
      this->damp_prefactor = this->damp * sqrt(this->gm->meff * normal_->stiffness());
      return -this->damp_prefactor * this->gm->vnnr;
    }

  private:
    const Table *normal_;
  };

  // In the place of GranularModel::check_contact and calculate_forces, for each pair of neighbours at each step.
  static inline bool in_pairs(const Model *m) {
    if (m->contact_type | (int)m->synchronized()) return false;
    const NormalMod *const normal = m->normal_model;
    if (__builtin_expect(normal == Table::latest, 1)) return true;
    if (!this_object.holds(*(const void *const *)normal)) return false; // where the table of virtual functions stands
    if (!((const Table *)normal)->is_whole()) return false;
    Table::latest = (Table *)normal;
    return true;
  }
  static bool check(void *model) {
    Model *const m = (Model *)model;
    return in_pairs(m) ? touching(m) : check_elsewhere(m);
  }
  static void compute(void *model) {
    Model *const m = (Model *)model;
    if (in_pairs(m)) ((Table *)m->normal_model)->whole();
    else compute_elsewhere(m);
  }

  template <int RULE> static Table *make_table(Model *m, const std::string &named, const demlaws::Table &table) {
    if (RULE != table.unloading()) return make_table < RULE == demlaws::OWN ? RULE : RULE + 1 > (m, named, table);
    return new Ruled<(demlaws::Unloading)RULE>(m, named, table);
  }

  // GranularModel::construct_sub_model for the names above; outputs: room for those of compute pair/local.
  static void construct(void *model, const std::string &name, int type, bool outputs) {
    Model *const m = (Model *)model;
    SubMod *made;
    if (type == NORMAL) {
      const size_t space = name.find(' ');
      if (space == std::string::npos)
        raise(*m->of.error, true, "demlaws/table: no file; write  demlaws/table FILE E eta nu");
      made = m->normal_model = make_table<0>(m, name, Tables::get(name.substr(space + 1), m->of.lmp, *m->of.error));
      if (!outputs) made->nsvector = 0;
      Range::of(m->of.lmp).used = true;
    } else made = m->damping_model = new Tangent(m, name);
    delete m->sub_models[type];
    m->sub_models[type] = made;
  }

  // GranularModel::add_sub_model for the names above.
  static int add(void *model, char **arg, int at, int count, int type, bool outputs) {
    Model *const m = (Model *)model;
    std::string name = arg[at++];
    void *const error = *m->of.error;
    if (type == NORMAL) {
      if (at + 4 > count)
        raise(error, true,
              "demlaws/table needs FILE E eta nu, then [roughness SIGMA] [against E2 nu2] [radius_tolerance X] "
              "[extrapolation on] [shear elastic|loading]");
      name += std::string(" ") + arg[at++];
    }
    double c[Table::FINGERPRINT] = {0.};
    static const char *const names[3] = {"E", "eta", "nu"};
    for (int k = 0; type == NORMAL && k < 3; k++) c[k] = number(error, names[k], arg[at++]);
    construct(m, name, type, outputs);
    if (type != NORMAL) return at;
    double *const into = m->sub_models[type]->coeffs;
    std::copy(c, c + 3, into);
    while (at < count) {
      const std::string word = arg[at], value = at + 1 < count ? arg[at + 1] : "nothing";
      const int values = word == "against" ? 2 : 1;
      demlaws::Shear shear;
      if (word == "extrapolation") {
        if (value != "on" && value != "off")
          raise(error, true, "demlaws/table: extrapolation is on or off, not " + value);
        into[Table::EXTRAPOLATE] = value == "on";
      } else if (word == "shear") {
        if (!demlaws::shear_from_name(value, shear) || shear == demlaws::SLIP_SHEAR)
          raise(error, true, "demlaws/table: shear is elastic or loading, not " + value);
        into[Table::SHEAR] = shear;
      } else if (word != "roughness" && word != "against" && word != "radius_tolerance") break;
      else {
        if (at + values >= count)
          raise(error, true, "demlaws/table: " + word + (values == 2 ? " needs two numbers" : " needs a number"));
        const double first = number(error, word, arg[at + 1]);
        if (word == "roughness" && !(first > 0.)) raise(error, true, "demlaws/table: roughness must be positive [m]");
        if (word == "roughness") into[Table::ROUGHNESS] = first;
        else if (word == "radius_tolerance") into[Table::TOLERANCE] = first;
        else {
          const double other = number(error, word, arg[at + 2]);
          if (!(first > 0.) || !(other > -1. && other <= 0.5) || !(into[0] > 0.) || !(into[2] > -1. && into[2] <= 0.5))
            raise(error, true,
                  "demlaws/table: against needs a positive Young's modulus and a Poisson's ratio from -1 to 0.5");
          join(into[0], into[2], first, other, into[0], into[2]);
        }
      }
      at += values + 1;
    }
    m->sub_models[type]->coeffs_to_local();
    return at;
  }

  // After GranularModel::init: whether a model has a table, and one whose unloading is not elastic; the sizes of the
  // history of its sub-models. proved: pairs of particles may be computed here.
  static void after_init(void *model, bool proved, bool &has_table, bool &keeps, std::vector<int> &sizes) {
    Model *const m = (Model *)model;
    Table *const table = dynamic_cast<Table *>(m->normal_model);
    has_table = table != NULL;
    keeps = table && table->unloads_otherwise();
    if (table) table->plan(proved);
    int at = 0;
    for (int k = 0; k < 6; k++) {
      const SubMod *const sub = m->sub_models[k];
      sizes.push_back(sub->size_history);
      // A rolling displacement and an angle of twist are the same seen from either particle (the relative spin and the
      // normal both turn), but LAMMPS turns their signs whenever a pair changes its order, unless the sub-model says
      // otherwise.
      const bool same = table && (k == ROLLING || k == TWISTING) && !sub->nondefault_history_transfer;
      for (int n = 0; n < sub->size_history; n++, at++)
        if (same && m->transfer_history_factor) m->transfer_history_factor[at] = 1.;
    }
  }
};

template <bool LATE> typename Granular<LATE>::Table *Granular<LATE>::Table::latest = NULL;

} // namespace
#endif
