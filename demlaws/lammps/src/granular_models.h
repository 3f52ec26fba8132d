// The granular sub-models of demlaws, for each layout of LAMMPS's classes (granular_abi.h): normal demlaws/table,
// tangential demlaws, which creates no energy (demlaws_shear.h, demlaws_slip.h), and damping demlaws/tangent, whose
// eta is the coefficient of restitution, c = c(e) sqrt(m K). Their words: docs/lammps.md.
#ifndef DEMLAWS_GRANULAR_MODELS_H
#define DEMLAWS_GRANULAR_MODELS_H

#include "energy.h"
#include "granular_abi.h"
#include "range.h"
#include "words.h"

namespace {

// ABI: LAMMPS's classes, mirrored in granular_abi.h, or its own (source/).
template <class ABI> struct Granular {
  typedef typename ABI::Model Model;
  typedef typename ABI::SubMod SubMod;
  typedef typename ABI::NormalMod NormalMod;
  typedef typename ABI::DampingMod DampingMod;
  typedef typename ABI::TangentialMod TangentialMod;

  class Table : public NormalMod {
  public:
    using NormalMod::coeffs;
    using NormalMod::damp;
    using NormalMod::Emod;
    using NormalMod::Fncrit;
    using NormalMod::gm;
    using NormalMod::history_index;
    using NormalMod::index_svector;
    using NormalMod::lmp;
    using NormalMod::name;
    using NormalMod::nsvector;
    using NormalMod::poiss;
    enum {
      YOUNG,
      ETA,
      POISSON,
      ROUGHNESS,
      TOLERANCE,
      EXTRAPOLATION,
      SHEAR,
      SPRINGS,
      FINGERPRINT,
      LEVELS,
      RATIO,
      FRICTION_C1,
      FRICTION_C2,
      COEFFICIENTS
    };
    enum { MAXIMUM, PLASTIC, STORED, DISSIPATED, STIFFNESS, OUTPUTS }; // p13 to p17 of compute pair/local
    // LAMMPS writes a sub-model's numbers into restart files, and nothing else of it: after the coefficients comes the
    // name of the file, BYTES of it in each number, which are exact in a double.
    enum { BYTES = 6, NUMBERS = COEFFICIENTS + 64 };
    static std::string file_of(const double *numbers) {
      std::string file;
      for (int n = 0; n < BYTES * (NUMBERS - COEFFICIENTS); n++) {
        const char letter = (char)((unsigned long long)numbers[COEFFICIENTS + n / BYTES] >> 8 * (n % BYTES) & 255);
        if (!letter) break;
        file += letter;
      }
      return file;
    }

    Table(Model *m, const demlaws::Table &table)
        : NormalMod(m, NUMBERS, OUTPUTS), table_(table), ledger_(Ledger::of(lmp)) {
      name = "demlaws/table";
      const std::string &file = table.path();
      if (file.size() > BYTES * (NUMBERS - COEFFICIENTS))
        raise(lmp, true, title() + ": restart files have no room for so long a name of a file");
      for (size_t n = file.size(); n-- > 0;) {
        double &into = coeffs[COEFFICIENTS + n / BYTES];
        into = 256. * into + (unsigned char)file[n];
      }
      this->material_properties = 1;
      // The largest state, and the identity of the law: PairGranular::transfer_history moves the values of a pair of
      // types whose sub-models have other sizes than those of another pair to the wrong place.
      this->size_history = demlaws::MOST_STATE + 1;
      // the state is the same seen from either particle: the default factor -1 is not for it
      this->nondefault_history_transfer = 1;
      this->transfer_history_factor = new double[demlaws::MOST_STATE + 1];
      std::fill(this->transfer_history_factor, this->transfer_history_factor + demlaws::MOST_STATE + 1, 1.);
      coeffs[TOLERANCE] = 0.01;
      coeffs[SHEAR] = demlaws::ELASTIC_SHEAR;
      coeffs[SPRINGS] = demlaws::SPRINGS;
      coeffs[FINGERPRINT] = table.fingerprint();
      coeffs[LEVELS] = demlaws::LEVELS;
      Range::of(lmp).tables++;
    }

    void coeffs_to_local() {
      Emod = coeffs[YOUNG];
      damp = coeffs[ETA];
      poiss = coeffs[POISSON];
      check(Emod > 0., "E", Emod, " Pa: Young's modulus must be positive");
      check(damp >= 0., "eta", damp, ": must not be negative");
      check(poiss > -1. && poiss <= 0.5, "nu", poiss, ": Poisson's ratio is from -1 to 0.5");
      check(coeffs[ROUGHNESS] >= 0., "roughness", coeffs[ROUGHNESS], " m: must be positive");
      check(coeffs[TOLERANCE] >= 0., "radius_tolerance", coeffs[TOLERANCE], ": must not be negative");
      check(demlaws::SpringRow::may_have(coeffs[SPRINGS]), "springs", coeffs[SPRINGS], ": a whole number from 2 to 22");
      check(demlaws::may_have_levels(coeffs[LEVELS]), "levels", coeffs[LEVELS], ": a whole number from 1 to 8");
      check(coeffs[RATIO] >= 0. && coeffs[RATIO] <= demlaws::LARGEST_SHEAR_RATIO, "shear_ratio", coeffs[RATIO],
            ": K_t/K must be above 0 and at most 4/3");
      friction_.c1 = coeffs[FRICTION_C1];
      friction_.c2 = coeffs[FRICTION_C2];
      check(friction_.c1 >= 0., "friction_pressure C1", friction_.c1, ": must not be negative");
      check(friction_.c2 >= 0., "friction_pressure C2", friction_.c2, " 1/Pa: must not be negative");
      this->num_coeffs = NUMBERS;
      if (coeffs[FINGERPRINT] != (double)table_.fingerprint())
        refuse("this is not the table that the restart file was written with (another law, options, contact or range): "
               "bring that file back, or " +
               demlaws::FROM_POSITIONS);
      const double modulus = Emod / (2. * (1. - poiss * poiss)); // two bodies of one material
      shear_ = (demlaws::Shear)(int)coeffs[SHEAR];
      std::string doubt;
      try {
        if (friction_.c1 > 0.) law_.require_area(table_);
        doubt = law_.set(table_, modulus, coeffs[ROUGHNESS], shear_);
      } catch (const std::exception &problem) {
        refuse(problem.what());
      }
      if (!doubt.empty()) Range::of(lmp).announce(doubt, title() + ": " + doubt);
      per_stiffness_ = 0.5 / modulus;
    }

    void mix_coeffs(double *a, double *b) {
      join(a[YOUNG], a[POISSON], b[YOUNG], b[POISSON], coeffs[YOUNG], coeffs[POISSON]);
      coeffs[ETA] = sqrt(a[ETA] * b[ETA]);
      if ((a[ROUGHNESS] > 0.) != (b[ROUGHNESS] > 0.))
        refuse("either both types or none must have a roughness to be mixed");
      coeffs[ROUGHNESS] = sqrt(0.5 * (a[ROUGHNESS] * a[ROUGHNESS] + b[ROUGHNESS] * b[ROUGHNESS]));
      coeffs[TOLERANCE] = std::min(a[TOLERANCE], b[TOLERANCE]);
      coeffs[EXTRAPOLATION] = std::min(a[EXTRAPOLATION], b[EXTRAPOLATION]);
      for (int word : {SHEAR, SPRINGS, LEVELS, RATIO, FRICTION_C1, FRICTION_C2})
        if (a[word] != b[word])
          refuse("both types must have the same 'shear', 'shear_ratio', 'levels', 'springs' and 'friction_pressure' to "
                 "be mixed; write pair_coeff for this pair of types, too");
      for (int word : {SHEAR, SPRINGS, LEVELS, RATIO, FRICTION_C1, FRICTION_C2, FINGERPRINT}) coeffs[word] = a[word];
      coeffs_to_local();
    }

    // Of numbers as they are typed: with eta and nu exchanged they would be those of the table, to its last digit.
    void check_order() const {
      const double made_for = table_.number("modulus", 0.), E = coeffs[YOUNG] / 2.;
      const double given = E / (1. - coeffs[POISSON] * coeffs[POISSON]), other = E / (1. - coeffs[ETA] * coeffs[ETA]);
      if (fabs(other - made_for) <= 1e-6 * made_for && !(fabs(given - made_for) <= 1e-6 * made_for))
        refuse("eta and nu are exchanged: the order is FILE E eta nu, and with nu = eta E* is that of the table");
    }

    void init() { // after all words of the line
      after_init();
      ABI::after_init(lmp, gm);
    }
    // After GranularModel::init() has dealt the history.
    void after_init() {
      identity_ = law_.identity(gm->size_history);
      // A rolling displacement and an angle of twist are the same seen from either particle (the relative spin and the
      // normal both turn), but LAMMPS turns their signs whenever a pair changes its order, unless told otherwise.
      int at = 0;
      for (int k = 0; k <= HEAT; k++) {
        const bool same = (k == ROLLING || k == TWISTING) && !gm->sub_models[k]->nondefault_history_transfer;
        for (int n = 0; n < gm->sub_models[k]->size_history; n++, at++)
          if (same) gm->transfer_history_factor[at] = 1.;
      }
      const std::string &tangential = gm->tangential_model->name;
      if (tangential == "demlaws") return;
      if (slips()) refuse("'shear slip' needs  tangential demlaws XT MU");
      if (friction_.c1 > 0.) refuse("'friction_pressure' needs  tangential demlaws XT MU");
      if (coeffs[RATIO] > 0.) refuse("'shear_ratio' needs  tangential demlaws XT MU");
      if (tangential.compare(0, 7, "mindlin") || tangential == "mindlin_rescale/force") return;
      Range::of(lmp).announce(
          "tangential",
          "tangential " + tangential +
              " creates energy where the stiffness changes while a contact is sheared: with mindlin a closed "
              "box of rough spheres had 2.4 times its energy after 30 ms; use 'tangential demlaws XT MU' or "
              "mindlin_rescale/force (" DEMLAWS_PAGE("shear") ")");
    }

    double calculate_contact_radius() { return 0.; } // asked for before calculate_forces(), which sets it
    double stiffness() const { return stiffness_; }
    // For the tangential model: that of K_t, and K_t over it; whether there are springs, and how much they are pressed.
    double shear_stiffness() const { return shear_stiffness_; }
    double shear_ratio() const { return coeffs[RATIO] > 0. ? coeffs[RATIO] : 2. * (1. - poiss) / (2. - poiss); }
    bool slips() const { return shear_ == demlaws::SLIP_SHEAR; }
    double friction_above() const { return friction_above_; } // MU, in the step that came last
    demlaws::UnloadingCurve unloading_curve() const {
      return law_.unloading_curve(force_, gm->delta, gm->history + history_index);
    }
    double effective_modulus() const { return law_.pair.modulus; }
    bool unloads_otherwise() const { return table_.unloading() != demlaws::ELASTIC; }

    ~Table() {
      latest = latest == this ? NULL : latest;
      Range::of(lmp).drop_table();
    }
    // What hooks.h computes pairs of particles by.
    static Table *latest;        // of those that it computes, the one met last
    bool computes_pairs = false; // of this table
    bool speed = true;           // the tangential model asks for that of the surfaces, vrel
    enum { OTHERWISE, BY_TANGENT, BY_RADIUS } damped = OTHERWISE; // BY_RADIUS: viscoelastic, which Abi::fits() checks
    bool is_watched() const { return ledger_.busy | gm->calculate_svector; }

    __attribute__((flatten)) double calculate_forces() {
      return __builtin_expect(is_watched(), 0) ? watched() : force();
    }
    inline double force() {
      Model *const m = gm;
      double *const state = m->history + history_index;
      const demlaws::Force now = demlaws::step(law_.pair, m->Reff, m->delta, state, m->history_update != 0);
      if (__builtin_expect(m->contact_type > LAST_TYPE, 0)) refuse_contact();
      if (__builtin_expect(now.outside | law_.watch.exceeds(m->delta, m->Reff), 0)) examine(now);
      if (__builtin_expect(!law_.pair.serves(m->Reff, coeffs[TOLERANCE]), 0)) refuse_radius();
      if (__builtin_expect(state[demlaws::MOST_STATE] != identity_, 0)) check_identity();
      stiffness_ = now.stiffness;
      force_ = now.force;
      shear_stiffness_ = demlaws::shear_stiffness(shear_, law_.pair, m->Reff, m->delta, now, state);
      friction_above_ = 0.;
      if (friction_.c1 > 0.) {
        const double pressure = demlaws::mean_pressure(law_.pair, now);
        friction_above_ = friction_.above_constant(pressure);
        if (__builtin_expect(law_.watch.exceeds_hardness(pressure), 0)) examine_friction(pressure);
      }
      // K = 2 E* a: what mindlin, viscoelastic and heat scale with
      m->contact_radius = shear_stiffness_ * per_stiffness_;
      return now.force;
    }

  private:
    __attribute__((noinline, cold)) double watched() {
      Model *const m = gm;
      double *const state = m->history + history_index;
      const double before[demlaws::MOST_STATE] = {state[0], state[1], state[2]};
      const double found = force();
      double now[demlaws::MOST_STATE] = {state[0], state[1], state[2]};
      if (!m->history_update) demlaws::step(law_.pair, m->Reff, m->delta, now, true);
      account(before, state, now);
      return found;
    }
    // After a step whose energies a compute reads: the state that the contact had before, that it keeps, and that
    // the step at this overlap gives it, which is not kept where histories are only read (setup, compute
    // pair/local).
    __attribute__((noinline, cold)) void account(const double *before, const double *kept, const double *state) {
      Model *const m = gm;
      const demlaws::Pair &pair = law_.pair;
      double stored = 0., dissipated = 0., none, booked = 0.;
      demlaws::stored_and_dissipated(pair, m->Reff, m->delta, state, stored, dissipated);
      demlaws::stored_and_dissipated(pair, m->Reff, m->delta, kept, none, booked);
      const double pending = dissipated - booked;
      if (m->calculate_svector && nsvector) {
        double *const out = m->svector + index_svector;
        const bool keeps = state[0] > 0. && pair.rule != demlaws::ELASTIC;
        out[MAXIMUM] = keeps ? state[0] : m->delta;
        out[PLASTIC] = keeps ? state[1] : 0.;
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
      if (wall) ledger_.begin_wall();
      if (m->history_update && !std::equal(before, before + demlaws::MOST_STATE, state)) {
        double earlier = 0.;
        demlaws::stored_and_dissipated(pair, m->Reff, m->delta, before, none, earlier);
        ledger_.add_dissipated(m->vi, wall ? NULL : m->vj, dissipated - earlier);
      }
      if (wall) ledger_.add_wall(stored, pending);
    }

    const demlaws::Table &table_;
    Ledger &ledger_;
    demlaws::Law law_;
    double force_ = 0., stiffness_ = 0., shear_stiffness_ = 0., per_stiffness_ = 0.;
    double identity_ = 0., friction_above_ = 0.;
    demlaws::PressureFriction friction_;
    demlaws::Shear shear_ = demlaws::ELASTIC_SHEAR;

    std::string title() const { return "demlaws/table " + table_.path(); }
    __attribute__((noinline, cold)) void refuse(const std::string &what) const {
      raise(lmp, true, title() + ": " + what);
    }
    void check(bool good, const char *name, double value, const char *why) const {
      std::ostringstream what;
      what << name << " = " << value << why;
      if (!good) refuse(what.str());
    }
    // The number of body 0 or 1, as far as it is known: a wall's model knows its particle's velocity alone; -1: a wall.
    __attribute__((noinline, cold)) long body(int which) const {
      const bool wall = gm->contact_type != PAIR;
      if (wall && which) return -1;
      const long at = wall ? ledger_.particle("v", gm->vi) : ledger_.particle("x", which ? gm->xj : gm->xi);
      return at < 0 ? at : (long)tag_of(lmp, at);
    }
    __attribute__((noinline, cold)) std::string who() const {
      const std::string first = std::to_string(body(0)), second = std::to_string(body(1));
      return title() + ": particle" +
             (gm->contact_type == PAIR ? "s " + first + " and " + second : " " + first + " and the wall") + ": ";
    }
    // Reports what is wrong with one contact.
    struct Report : demlaws::Findings {
      const Table &table;
      explicit Report(const Table &t) : Findings(Range::of(t.lmp).counts, t.gm->history_update), table(t) {}
      long body(int which) const { return table.body(which); }
      void warn(const std::string &text) {
        Range::of(table.lmp).warn(table.who() + text + " (reported once, counted at the end of the run)");
      }
      void refuse(const std::string &text) { raise(table.lmp, false, table.who() + text); }
    };
    __attribute__((noinline, cold)) void examine(const demlaws::Force &now) const {
      Report report(*this);
      law_.watch.examine(law_.pair, gm->Reff, gm->delta, now, coeffs[EXTRAPOLATION] != 0., !gm->history_update, report);
    }
    __attribute__((noinline, cold)) void examine_friction(double pressure) const {
      Report report(*this);
      law_.watch.examine_friction(pressure, report);
    }
    // A contact that begins, or is of another law, of which an elastic one without springs keeps nothing.
    __attribute__((noinline, cold)) void check_identity() const {
      double *const state = gm->history + history_index, &identity = state[demlaws::MOST_STATE];
      const bool kept =
          unloads_otherwise() || slips() || std::count(state, state + demlaws::MOST_STATE, 0.) < demlaws::MOST_STATE;
      if (!demlaws::Law::can_continue(identity, identity_, kept)) raise(lmp, false, who() + demlaws::other_law());
      if (gm->history_update) identity = identity_;
    }
    __attribute__((noinline, cold)) void refuse_radius() const {
      raise(lmp, false, who() + demlaws::other_radius(law_.pair, gm->Reff, coeffs[TOLERANCE]));
    }
    __attribute__((noinline, cold)) void refuse_contact() const {
      std::ostringstream what;
      what << title() << ": contacts of type " << gm->contact_type
           << " (of a newer LAMMPS) are not known here; use pairs of spheres, wall/gran, wall/gran/region or surfaces";
      raise(lmp, false, what.str());
    }
  };

  class Tangent : public DampingMod {
  public:
    Tangent(Model *m, const std::string &named) : DampingMod(m), normal_(NULL) { this->name = named; }
    void init() {
      normal_ = dynamic_cast<Table *>(this->gm->normal_model);
      if (!normal_) raise(this->lmp, true, "damping demlaws/tangent goes with the normal model demlaws/table only");
      const double e = normal_->damp, logarithm = e > 0. ? log(e) : 0.;
      if (!(e > 0. && e <= 1.))
        raise(this->lmp, true,
              "damping demlaws/tangent: eta = " + std::to_string(e) + " is a coefficient of restitution, above 0 to 1");
      this->damp = -2. * sqrt(5. / 6.) * logarithm / sqrt(M_PI * M_PI + logarithm * logarithm);
    }
    double calculate_forces() {
      this->damp_prefactor = this->damp * sqrt(this->gm->meff * normal_->stiffness());
      return -this->damp_prefactor * this->gm->vnnr;
    }

  private:
    const Table *normal_;
  };

  class ShearModel : public TangentialMod {
  public:
    enum { DAMPING_RATIO, FRICTION, COEFFICIENTS };
    using TangentialMod::coeffs;
    using TangentialMod::gm;
    using TangentialMod::history_index;
    ShearModel(Model *m, const std::string &named)
        : TangentialMod(m, COEFFICIENTS), ledger_(Ledger::of(this->lmp)), normal_(NULL) {
      this->name = named;
      this->nondefault_history_transfer = 1;
    }
    void coeffs_to_local() {
      this->mu = coeffs[FRICTION];
      if (!(coeffs[DAMPING_RATIO] >= 0.) || !(this->mu >= 0.))
        raise(this->lmp, true,
              "tangential demlaws " + std::to_string(coeffs[DAMPING_RATIO]) + " " + std::to_string(this->mu) +
                  ": damping XT and friction MU must not be negative");
      if (coeffs[DAMPING_RATIO] > LARGEST_DAMPING_RATIO)
        raise(this->lmp, true,
              "tangential demlaws: damping XT = " + std::to_string(coeffs[DAMPING_RATIO]) +
                  " times that of the normal force: at most 1000");
      if (this->mu > LARGEST_USUAL_FRICTION)
        Range::of(this->lmp).announce("friction " + std::to_string(this->mu),
                                      "tangential demlaws: friction MU = " + std::to_string(this->mu) +
                                          " is a coefficient (tangent of an angle), and rarely above 2");
    }
    static constexpr double LARGEST_DAMPING_RATIO = 1e3, LARGEST_USUAL_FRICTION = 10.;
    void mix_coeffs(double *a, double *b) {
      for (int k = 0; k < COEFFICIENTS; k++) coeffs[k] = sqrt(a[k] * b[k]);
      coeffs_to_local();
    }
    // The words XT MU from arg[at] on.
    static void read(void *lmp, char **arg, int at, int count, double *into) {
      if (at + COEFFICIENTS > count)
        raise(lmp, true, "tangential demlaws needs XT MU: damping as that of stock models, friction");
      into[DAMPING_RATIO] = number(lmp, "the damping of tangential demlaws", arg[at]);
      into[FRICTION] = number(lmp, "the friction of tangential demlaws", arg[at + 1]);
    }
    // Before GranularModel::init() deals the history: the normal model is known.
    void set_history_size() {
      normal_ = dynamic_cast<Table *>(gm->normal_model);
      if (!normal_) raise(this->lmp, true, "tangential demlaws goes with the normal model demlaws/table only");
      row_.springs = normal_->slips() ? (int)normal_->coeffs[Table::SPRINGS] : 0;
      row_.levels = (int)normal_->coeffs[Table::LEVELS];
      size_ = row_.size();
      // and the normal of the step before: nothing else tells how that of a wall turns
      keeps_normal_ = gm->contact_type != PAIR;
      this->size_history = size_ + 3 * keeps_normal_;
      delete[] this->transfer_history_factor;
      this->transfer_history_factor = new double[this->size_history];
      for (int i = 0; i < this->size_history; i++)
        this->transfer_history_factor[i] = i >= size_ || row_.changes_sign(i) ? -1. : 1.;
      ratio_ = normal_->shear_ratio();
      this->k = 2. * ratio_ * normal_->effective_modulus(); // K_t over the contact radius: twisting
    }
    void init() { synchronized_ = ABI::synchronized(gm); } // after all words of the line
    void calculate_forces() {
      if (__builtin_expect(ledger_.busy, 0)) watched();
      else move();
    }

  private:
    __attribute__((noinline, cold)) void watched() {
      double viscous = 0.;
      const demlaws::ShearStep step = move(&viscous);
      account(step, viscous);
    }
    // A step; its energies are computed only where somebody uses them. viscous: power that the dashpot takes, added.
    __attribute__((always_inline)) inline demlaws::ShearStep move(double *viscous = NULL) {
      Model *const m = gm;
      double copy[demlaws::ShearRow::MOST_SIZE], *numbers = m->history + history_index;
      const bool keep = m->history_update != 0;
      if (!keep) {
        std::copy(numbers, numbers + size_, copy);
        numbers = copy;
      }
      const double limit = (this->mu + normal_->friction_above()) * normal_->Fncrit;
      const demlaws::Motion motion = motion_of(keep ? m->dt : 0., demlaws::unit_vector(numbers, size_));
      const demlaws::ShearStep step =
          row_.step(normal_->shear_stiffness(), normal_->unloading_curve(), ratio_, limit, motion, numbers);
      this->damp = coeffs[DAMPING_RATIO] * m->damping_model->get_damp_prefactor();
      double damped[2];
      step.damp(this->damp, limit, motion.velocity, damped);
      const double force[2] = {damped[0] - step.force[0], damped[1] - step.force[1]};
      if (viscous)
        for (int k = 0; k < 2; k++) *viscous -= damped[k] * motion.velocity[k];
      motion.in_space(force, m->fs);
      return step;
    }
    // dt: 0 where nothing is to be kept. unit_vector: that of the contact.
    __attribute__((noinline)) demlaws::Motion motion_of(double dt, double *unit_vector) {
      Model *const m = gm;
      const double *const v = m->vr, *n = m->nx;
      double along = m->vnnr, change[3] = {0., 0., 0.}, now[3], spin[3], arms[3];
      if (__builtin_expect(synchronized_, 0)) { // LAMMPS has that of the half step
        for (int k = 0; k < 3; k++) now[k] = m->rinv * m->dx[k];
        along = v[0] * now[0] + v[1] * now[1] + v[2] * now[2];
        n = now;
      }
      const bool pair = m->contact_type == PAIR;
      if (pair) demlaws::Motion::change_of_spheres(n, v, along, m->rinv, dt, change);
      else if (keeps_normal_) demlaws::Motion::change_of_kept(n, m->history + history_index + size_, dt > 0., change);
      // LAMMPS's velocities have radii as levers, its torques those of the contact, which keep the energy: radius -
      // delta/2, with the overlap of the half step.
      const double shorter = pair ? 0.5 * m->delta + 0.25 * dt * demlaws::Motion::parting(n, v, change) : 0.;
      for (int k = 0; k < 3; k++) {
        spin[k] = m->omegai[k] + m->omegaj[k];
        arms[k] = m->wr[k] - shorter * spin[k];
      }
      return demlaws::Motion(n, v, change, arms, spin, dt, unit_vector);
    }
    // Records the work of shear, less the energy that the contact stores, and the work of both dashpots.
    void account(const demlaws::ShearStep &step, double viscous) {
      if (ledger_.collecting) {
        ledger_.collected += step.before;
        ledger_.pending -= step.before;
        return;
      }
      const bool wall = gm->contact_type != PAIR, keep = gm->history_update != 0;
      const double work = (keep ? step.work : 0.) + (ledger_.first ? step.before : 0.);
      const double *const vj = wall ? NULL : gm->vj;
      if (work != 0.) ledger_.add_dissipated(gm->vi, vj, work);
      viscous += (gm->Fnormal - gm->Fntot) * gm->vnnr;
      if (keep && viscous != 0.) ledger_.add_viscous(gm->vi, vj, viscous * gm->dt);
      if (!wall) return;
      const double stored = keep ? step.energy : step.before;
      ledger_.add_wall(stored, -stored);
    }
    Ledger &ledger_;
    const Table *normal_;
    demlaws::ShearRow row_;
    int size_ = 0; // of the row
    bool keeps_normal_ = false, synchronized_ = false;
    double ratio_ = 0.; // K_t / K
  };

  // The normal model with this file; outputs: room for those of compute pair/local. Their former content is not
  // deleted.
  static Table *set_table(Model *m, void *lmp, const std::string &file, bool outputs) {
    Table *made;
    try {
      made = new Table(m, demlaws::load_table(Ranks(lmp), file));
    } catch (const std::runtime_error &problem) {
      raise(lmp, true, std::string("demlaws/table: ") + problem.what());
    }
    if (!outputs) made->nsvector = 0;
    m->normal_model = made;
    m->sub_models[NORMAL] = made;
    return made;
  }

  // A normal model whose file only its numbers will name, those of a restart file or of two types: the table then comes
  // in its place.
  class DeferredTable : public NormalMod {
  public:
    DeferredTable(Model *m, bool outputs) : NormalMod(m, Table::NUMBERS, 0), outputs_(outputs) {
      this->name = "demlaws/table";
    }
    void coeffs_to_local() {
      Table *const made = set_table(this->gm, this->lmp, Table::file_of(this->coeffs), outputs_);
      std::copy(this->coeffs, this->coeffs + Table::NUMBERS, made->coeffs);
      made->coeffs_to_local();
      delete this;
    }
    void mix_coeffs(double *a, double *b) {
      set_mixed(this->gm, this->lmp, a, b, outputs_);
      delete this;
    }
    double calculate_forces() { return 0.; }

  private:
    const bool outputs_;
  };
  static void set_mixed(Model *m, void *lmp, double *a, double *b, bool outputs) {
    const std::string file = Table::file_of(a), other = Table::file_of(b);
    if (file != other)
      raise(lmp, true,
            "demlaws/table: particle types with the tables " + file + " and " + other +
                " cannot be mixed: write the pair_coeff line of the two types");
    set_table(m, lmp, file, outputs)->mix_coeffs(a, b);
  }
};

template <class ABI> typename Granular<ABI>::Table *Granular<ABI>::Table::latest = NULL;

} // namespace
#endif
