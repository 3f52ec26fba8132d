// The granular sub-models of demlaws, included once for each layout after granular_abi.h (no include guard).
//   normal   demlaws/table FILE E eta nu [roughness SIGMA] [against E2 nu2] [radius_tolerance X] [extrapolation on]
//            [shear elastic|tangent|loading]
//            E, eta, nu as those of hertz/material; SIGMA: combined rms roughness of the two bodies [m] (without it:
//            the length in FILE); against: the other body is of another material; shear: what K_t goes by
//   damping  demlaws/tangent
//            eta is the coefficient of restitution; c = c(e) sqrt(m K) with the tangent stiffness K of the table
namespace DEMLAWS_LAYOUT {

__attribute__((noinline)) bool check_elsewhere(Model *m) { return Stock::get().check(m); }
__attribute__((noinline)) void compute_elsewhere(Model *m) { Stock::get().compute(m); }

class Table : public NormalMod {
public:
  enum { YOUNG, ETA, POISSON, ROUGHNESS, TOLERANCE, EXTRAPOLATE, SHEAR, FINGERPRINT, COEFFICIENTS };
  enum { MAXIMUM, PLASTIC, STORED, DISSIPATED, STIFFNESS, OUTPUTS }; // p13 to p17 of compute pair/local
  enum { MOST_STATE = 3 };

  // `named`: "demlaws/table FILE". The file goes into restarts, and must agree for mixing, because it is in the name.
  Table(Model *m, const std::string &named, const demlaws::Table &table)
      : NormalMod(m, COEFFICIENTS, OUTPUTS), table_(table), ledger_(Ledger::of(m->of.lmp)), stiffness_(0.),
        per_stiffness_(0.), radius_(0.), shear_(demlaws::ELASTIC_SHEAR), whole_(false), speed_(true),
        damped_(OTHERWISE) {
    name = named;
    material_properties = 1;
    // Always the largest state: PairGranular::transfer_history moves the values of a pair of types whose sub-models
    // have other sizes than those of another pair to the wrong place.
    size_history = MOST_STATE;
    nondefault_history_transfer =
        1; // the state is the same seen from either particle: the default factor -1 is not for it
    transfer_history_factor = new double[MOST_STATE];
    std::fill(transfer_history_factor, transfer_history_factor + MOST_STATE, 1.);
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
      refuse("Young's modulus must be positive, eta, roughness and radius_tolerance not negative, Poisson's ratio from "
             "-1 to 0.5");
    if (coeffs[FINGERPRINT] != (double)table_.fingerprint())
      refuse("this is not the table that the restart file was written with: bring that file back, or write pair_coeff "
             "anew");
    try { // two bodies of one material
      pair_ = demlaws::Pair(table_, Emod / (2. * (1. - poiss * poiss)), table_.collapses() ? coeffs[ROUGHNESS] : 0.);
    } catch (const std::exception &problem) {
      refuse(problem.what());
    }
    per_stiffness_ = 0.5 / pair_.modulus;
    shear_ = (demlaws::Shear)(int)coeffs[SHEAR];
    radius_ = 0.;
    if (table_.collapses()) return;
    radius_ = table_.of_contact("radius", 0.);
    const double made_for = table_.of_contact("modulus", 0.);
    if (!(radius_ > 0.) || !(made_for > 0.)) refuse("the table says 'collapses: no' but has no radius and modulus");
    if (coeffs[ROUGHNESS] > 0.)
      refuse("law " + table_.text("law") + " does not collapse, the table holds for its own roughness only");
    if (!(fabs(pair_.modulus - made_for) <= 1e-6 * made_for)) {
      std::ostringstream what;
      what << "law " << table_.text("law") << " does not collapse, the table holds for the effective modulus "
           << made_for << " Pa only, here it is " << pair_.modulus << " Pa; make a table of this pair of types";
      refuse(what.str());
    }
  }

  // The material that makes E* and G* of the pair those of the two materials: stock hertz/material takes E* for E here,
  // so that `mindlin NULL` is too soft by about half.
  static void join(double E1, double nu1, double E2, double nu2, double &E, double &nu) {
    const double modulus = 1. / ((1. - nu1 * nu1) / E1 + (1. - nu2 * nu2) / E2);
    const double shear = 1. / (2. * (2. - nu1) * (1. + nu1) / E1 + 2. * (2. - nu2) * (1. + nu2) / E2);
    const double ratio = modulus / shear;
    nu = (ratio - 4.) / (ratio - 2.);
    E = 2. * (1. - nu * nu) * modulus;
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

  // Once for each pair style.
  void judge_shear() const {
    bool &told = Range::of(of.lmp).tangent_told;
    const Stock &stock = Stock::get();
    if (coeffs[SHEAR] != demlaws::TANGENT_SHEAR || table_.unloading() == demlaws::ELASTIC || told) return;
    told = true;
    if (stock.setting(of.lmp, "world_rank") == 0 && stock.warn)
      stock.warn(*of.error, "demlaws", 0, std::string("demlaws/table: ") + demlaws::TANGENT_CREATES_ENERGY);
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
  void plan(bool proved);

protected:
  template <demlaws::Unloading RULE> inline double finish(const demlaws::Force now) {
    Model *const m = gm;
    if (__builtin_expect(now.outside || m->delta > SMALL_OVERLAP * m->Reff, 0)) far(now.force, now.outside);
    if (__builtin_expect(radius_ > 0. && !(fabs(m->Reff - radius_) <= coeffs[TOLERANCE] * radius_), 0)) refuse_radius();
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
    const bool wall = m->contact_type != 0;
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
  double stiffness_, per_stiffness_, radius_; // radius_ > 0: the only one the table holds for
  demlaws::Shear shear_;
  bool whole_, speed_;                               // speed_: the tangential model asks for that of the surfaces, vrel
  enum { OTHERWISE, BY_TANGENT, BY_RADIUS } damped_; // BY_RADIUS: viscoelastic, whose formula abi_fits() has checked

private:
  __attribute__((noinline, cold)) void refuse(const std::string &what) const {
    raise(*of.error, true, name + ": " + what);
  }
  // The bodies by their numbers, as far as they are known: a wall's model is told of its particle's velocity alone.
  __attribute__((noinline, cold)) std::string who() const {
    const Stock &stock = Stock::get();
    const void *const tags = stock.atom(of.lmp, "id");
    const bool wall = gm->contact_type != 0;
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
      what << who() << "overlap " << gm->delta << " m is " << std::setprecision(3) << ratio << (none ? " times" : " of")
           << std::setprecision(6) << " the effective radius R = " << gm->Reff
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
  __attribute__((noinline, cold)) void refuse_radius() const {
    std::ostringstream what;
    what << who() << "contact radius " << gm->Reff << " m, but law " << table_.text("law")
         << " does not collapse and the table holds for " << radius_ << " m (radius_tolerance " << coeffs[TOLERANCE]
         << "); make a table of this pair of types or widen the tolerance";
    raise(*of.error, false, what.str());
  }
};

// The rule of unloading is known when compiled.
template <demlaws::Unloading RULE> class Ruled : public Table {
public:
  Ruled(Model *m, const std::string &named, const demlaws::Table &table) : Table(m, named, table) {}
  __attribute__((flatten)) double calculate_forces() {
    Model *const m = gm;
    if (__builtin_expect(ledger_.busy | m->calculate_svector, 0)) return watched();
    return this->template finish<RULE>(
        demlaws::step_rule<RULE>(pair_, m->Reff, m->delta, m->history + history_index, m->history_update != 0));
  }

  __attribute__((flatten)) void whole() {
    Model *const m = gm;
    if (__builtin_expect(ledger_.busy | m->calculate_svector, 0)) return compute_elsewhere(m);
    geometry(m, speed_);
    m->Fnormal = this->template finish<RULE>(
        demlaws::step_rule<RULE>(pair_, m->Reff, m->delta, m->history + history_index, m->history_update != 0));
    DampingMod *const damped = m->damping_model;
    if (damped_ != OTHERWISE) {
      damped->damp_prefactor =
          damped->damp * (damped_ == BY_TANGENT ? sqrt(m->meff * stiffness_) : m->meff * m->contact_radius);
      sum(m, m->Fnormal - damped->damp_prefactor * m->vnnr);
    } else sum(m, m->Fnormal + call<double>(damped, FORCES));
  }

private:
  __attribute__((noinline, cold)) double watched() {
    Model *const m = gm;
    double *const state = m->history + history_index;
    const double before[MOST_STATE] = {state[0], state[1], state[2]};
    const double force =
        this->template finish<RULE>(demlaws::step_rule<RULE>(pair_, m->Reff, m->delta, state, m->history_update != 0));
    double now[MOST_STATE] = {state[0], state[1], state[2]};
    if (!m->history_update) demlaws::step_rule<RULE>(pair_, m->Reff, m->delta, now, true);
    account(before, state, now);
    return force;
  }
};

class Tangent : public DampingMod {
public:
  Tangent(Model *m, const std::string &named) : DampingMod(m), normal_(NULL) { name = named; }
  void init() {
    normal_ = dynamic_cast<Table *>(gm->normal_model);
    if (!normal_) raise(*of.error, true, "damping demlaws/tangent goes with the normal model demlaws/table only");
    const double e = normal_->damp, logarithm = e > 0. ? log(e) : 0.;
    if (!(e > 0. && e <= 1.))
      raise(*of.error, true, "damping demlaws/tangent: eta is a coefficient of restitution, above 0 to 1");
    damp = -2. * sqrt(5. / 6.) * logarithm / sqrt(M_PI * M_PI + logarithm * logarithm);
  }
  double calculate_forces() {
    damp_prefactor = damp * sqrt(gm->meff * normal_->stiffness());
    return -damp_prefactor * gm->vnnr;
  }

private:
  const Table *normal_;
};

Table *Table::latest = NULL;

inline void Table::plan(bool proved) {
  latest = NULL;
  const Model *const m = gm;
  whole_ = proved && !m->beyond_contact;
  for (int k = ROLLING; k <= HEAT; k++) whole_ = whole_ && m->sub_models[k]->name == "none";
  const std::string &tangential = m->sub_models[TANGENTIAL]->name;
  whole_ = whole_ && tangential != "none";
  speed_ = tangential.compare(0, 7, "mindlin") != 0;
  damped_ = dynamic_cast<Tangent *>(m->damping_model)  ? BY_TANGENT
            : m->damping_model->name == "viscoelastic" ? BY_RADIUS
                                                       : OTHERWISE;
}

// In the place of GranularModel::check_contact and calculate_forces, for each pair of neighbours at each step.
inline bool in_pairs(const Model *m) {
#if DEMLAWS_SYNCHRONIZED
  if (m->contact_type | m->synchronized_verlet) return false;
#else
  if (m->contact_type) return false;
#endif
  const NormalMod *const normal = m->normal_model;
  if (__builtin_expect(normal == Table::latest, 1)) return true;
  if (!Here::has(*(const void *const *)normal)) return false; // where the table of virtual functions stands
  if (!((const Table *)normal)->is_whole()) return false;
  Table::latest = (Table *)normal;
  return true;
}
bool check(Model *m) { return in_pairs(m) ? touching(m) : check_elsewhere(m); }
void compute(Model *m) {
  if (in_pairs(m)) ((Table *)m->normal_model)->whole();
  else compute_elsewhere(m);
}

inline Table *make_table(Model *m, const std::string &named, const demlaws::Table &table) {
  switch (table.unloading()) {
  case demlaws::ELASTIC:
    return new Ruled<demlaws::ELASTIC>(m, named, table);
  case demlaws::HERTZ:
    return new Ruled<demlaws::HERTZ>(m, named, table);
  case demlaws::THORNTON:
    return new Ruled<demlaws::THORNTON>(m, named, table);
  case demlaws::LINEAR:
    return new Ruled<demlaws::LINEAR>(m, named, table);
  case demlaws::EEPA:
    return new Ruled<demlaws::EEPA>(m, named, table);
  case demlaws::ETSION:
    return new Ruled<demlaws::ETSION>(m, named, table);
  case demlaws::OWN:
    return new Ruled<demlaws::OWN>(m, named, table);
  default:
    return new Ruled<demlaws::GIVEN>(m, named, table);
  }
}

// GranularModel::construct_sub_model for the names above.
inline void construct(Model *m, const std::string &name, int type, bool outputs) {
  SubMod *made;
  if (type == NORMAL) {
    const size_t space = name.find(' ');
    if (space == std::string::npos)
      raise(*m->of.error, true, "demlaws/table: no file; write  demlaws/table FILE E eta nu");
    Table *const table = make_table(m, name, tables().get(name.substr(space + 1), m->of.lmp, *m->of.error));
    if (!outputs) table->nsvector = 0;
    Range::of(m->of.lmp).used = true;
    m->normal_model = table;
    made = table;
  } else {
    Tangent *const tangent = new Tangent(m, name);
    m->damping_model = tangent;
    made = tangent;
  }
  delete m->sub_models[type];
  m->sub_models[type] = made;
}

// GranularModel::add_sub_model for the names above.
inline int add(Model *m, char **arg, int at, int count, int type, bool outputs) {
  std::string name = arg[at++];
  void *const error = *m->of.error;
  if (type != NORMAL) {
    construct(m, name, type, outputs);
    return at;
  }
  if (at + 4 > count)
    raise(error, true,
          "demlaws/table needs FILE E eta nu, then [roughness SIGMA] [against E2 nu2] [radius_tolerance X] "
          "[extrapolation on] [shear elastic|tangent|loading]");
  name += std::string(" ") + arg[at++];
  static const char *const names[3] = {"E", "eta", "nu"};
  double c[3];
  for (int k = 0; k < 3; k++) c[k] = number(error, names[k], arg[at++]);
  construct(m, name, type, outputs);
  double *const into = m->sub_models[type]->coeffs;
  std::copy(c, c + 3, into);
  while (at < count) {
    const std::string word = arg[at];
    const int values = word == "against" ? 2 : 1;
    if (word == "extrapolation") {
      const std::string said = at + 1 < count ? arg[at + 1] : "nothing";
      if (said != "on" && said != "off") raise(error, true, "demlaws/table: extrapolation is on or off, not " + said);
      into[Table::EXTRAPOLATE] = said == "on";
      at += 2;
      continue;
    }
    if (word == "shear") {
      const std::string said = at + 1 < count ? arg[at + 1] : "nothing";
      demlaws::Shear shear;
      if (!demlaws::shear_from_name(said, shear))
        raise(error, true, "demlaws/table: shear is elastic, tangent or loading, not " + said);
      into[Table::SHEAR] = shear;
      ((Table *)m->sub_models[type])->judge_shear();
      at += 2;
      continue;
    }
    if (word != "roughness" && word != "against" && word != "radius_tolerance") break;
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
      Table::join(into[0], into[2], first, other, into[0], into[2]);
    }
    at += values + 1;
  }
  m->sub_models[type]->coeffs_to_local();
  return at;
}

inline void plan(Model *m, bool proved) {
  Table *const table = dynamic_cast<Table *>(m->normal_model);
  if (table) table->plan(proved);
}
inline bool keeps(Model *m) {
  const Table *const table = dynamic_cast<Table *>(m->normal_model);
  return table && table->unloads_otherwise();
}
inline bool has_table(Model *m) { return dynamic_cast<Table *>(m->normal_model) != NULL; }
// A rolling displacement and an angle of twist are the same seen from either particle (the relative spin and the normal
// both turn), but LAMMPS turns their signs whenever a pair changes its order, unless the sub-model says otherwise.
inline void keep_signs(Model *m) {
  if (!has_table(m) || !m->transfer_history_factor) return;
  int at = 0;
  for (int k = 0; k < 6; k++) {
    const SubMod *const sub = m->sub_models[k];
    for (int n = 0; n < sub->size_history; n++, at++)
      if ((k == ROLLING || k == TWISTING) && !sub->nondefault_history_transfer) m->transfer_history_factor[at] = 1.;
  }
}
inline std::vector<int> sizes_of(Model *m) {
  std::vector<int> sizes;
  for (int k = 0; k < 6; k++) sizes.push_back(m->sub_models[k]->size_history);
  return sizes;
}

} // namespace DEMLAWS_LAYOUT
