// Normal model `demlaws/table` of LIGGGHTS: force and tangent stiffness from a table file, unloading with history.
// Its words and settings: docs/liggghts.md.
#ifndef DEMLAWS_NORMAL_MODEL_H
#define DEMLAWS_NORMAL_MODEL_H
#include "contact_models.h"
#include "global_properties.h"
#include "instance.h"
#include "normal_model_base.h"

namespace demlaws {

struct TypePair : Law {
  double damping;            // -2 sqrt(5/6) beta
  double tangential;         // kt / K = 4 G* / E*
  double tangential_damping; // gamma_t / gamma_n, or 0
  double identity;           // of its contacts
  PressureFriction friction;
};

// Energies of a contact at `overlap`: what it holds, what its plastic flow took. In a contact that has not been updated
// at this overlap, as none has before the first step, the state is the one that the step will give it.
inline void energies_at(const Pair &pair, double radius, double overlap, const double *state, int size, double &stored,
                        double &dissipated) {
  double now[MOST_STATE] = {0., 0., 0.};
  for (int k = 0; k < size; k++) now[k] = state ? state[k] : 0.;
  if (overlap > 0.) step(pair, radius, overlap, now, true);
  stored_and_dissipated(pair, radius, overlap, now, stored, dissipated);
}

} // namespace demlaws

namespace MODEL_PARAMS {
inline VectorProperty *createSurfaceRoughness(PropertyRegistry &registry, const char *caller, bool checks) {
  return createPerTypeProperty(registry, "surfaceRoughness", caller, checks, 0., 1e9);
}
} // namespace MODEL_PARAMS

namespace LIGGGHTS {
namespace ContactModels {

static const int DEMLAWS_TABLE = 60; // a free 6-bit id (stock uses 0 to 12)

template <> class NormalModel<DEMLAWS_TABLE> : public NormalModelBase {
public:
  NormalModel(LAMMPS *lmp, IContactHistorySetup *setup, class ContactModelBase *base)
      : NormalModelBase(lmp, setup, base), instance_(demlaws::Instance::of(lmp)), wall_(base->is_wall()) {}
  ~NormalModel() {
    if (!wall_) instance_->pair = demlaws::PairSettings();
  }

  void registerSettings(Settings &settings) {
    settings.registerOnOff("tangential_damping", damp_tangentially_, true);
    settings.registerOnOff("limitForce", limit_force_, false);
    settings.registerOnOff("surfaceRoughness", own_.use_roughness, false);
    settings.registerDoubleSetting("radius_tolerance", own_.radius_tolerance, 0.01);
    settings.registerDoubleSetting("shear_ratio", own_.shear_ratio, 0.);
    settings.registerOnOff("extrapolation", own_.extrapolate, false);
  }

  // The tables are known here (Instance::line), so only as much history is kept as their unloading needs; a wall that
  // stands before the pair style, whose tables it will take, keeps room for any.
  void postSettings(IContactHistorySetup *setup, ContactModelBase *base) {
    given_ = instance_->line.given;
    static_cast<demlaws::Words &>(own_) = instance_->line;
    if (!own_.friction.empty() && shear_size_ == 0) stop("'friction_pressure' needs  tangential demlaws");
    if (given_.count("shear_ratio") && !(own_.shear_ratio > 0. && own_.shear_ratio <= demlaws::LARGEST_SHEAR_RATIO))
      stop("shear_ratio " + std::to_string(own_.shear_ratio) + ": K_t/K must be above 0 and at most 4/3");
    if (!wall_) {
      if (own_.files.empty()) stop("no table; add 'table FILE' to the line (`demlaws table` writes one)");
      instance_->pair = own_;
    }
    resolve_settings();
    reserved_ = now_.files.empty() ? demlaws::MOST_STATE : state_size_;
    has_history_ = reserved_ + shear_size_ > 0;
    for (int i = 0; i < reserved_; i++) {
      const std::string name = std::string("demlaws_") + demlaws::STATE_NAMES[i];
      const int at = setup->add_history_value(name, "0"); // the same seen from either particle
      base->add_history_offset(name, at);
      if (i == 0) offset_ = at;
    }
    if (has_history_) identity_at_ = setup->add_history_value("demlaws_law", "0");
  }

  void connectToProperties(PropertyRegistry &registry) {
    const char *const me = "model demlaws/table";
    resolve_settings();
    if (now_.files.empty())
      stop(wall_
               ? "fix wall/gran has no table, nor has the pair style: add 'table FILE' behind 'primitive ...' or 'mesh "
                 "...'"
               : "repeat the pair_style line after read_restart");
    if (state_size_ > reserved_)
      stop("the pair style's tables were changed, and this wall keeps too little history "
           "for them: define the wall again (unfix, fix) below the pair_style line");
    registry.registerProperty("Yeff", &MODEL_PARAMS::createYeff, me);
    registry.registerProperty("Geff", &MODEL_PARAMS::createGeff, me);
    registry.registerProperty("betaeff", &MODEL_PARAMS::createBetaEff, me);
    registry.connect("Yeff", effective_modulus_, me);
    registry.connect("Geff", effective_shear_, me);
    registry.connect("betaeff", beta_, me);
    if (now_.use_roughness) {
      registry.registerProperty("surfaceRoughness", &MODEL_PARAMS::createSurfaceRoughness);
      registry.connect("surfaceRoughness", roughness_, me);
    }
    if (force->cg_active()) error->cg(FLERR, me);
    if (atom->shapetype_flag || atom->superquadric_flag)
      stop("only spheres; superquadric and convex particles are not supported");
    if (strcmp(update->unit_style, "si"))
      stop(std::string("units ") + update->unit_style + ": a table is in metres and pascals; use units si");
    if (state_size_ > 0) instance_->see_contacts_end(wall_);
    types_ = registry.max_type() + 1;
    pairs_.assign(types_ * types_, demlaws::TypePair());
    for (int i = 1; i < types_; i++)
      for (int j = 1; j < types_; j++) connect(i, j);
  }

  // For `area_correction`, which makes the contact area of the unsoftened grains by one power for all overlaps.
  double stressStrainExponent() {
    stop("area_correction holds for a force that is a power of the overlap; leave it "
         "out and give grains their own Young's modulus");
    return 0.;
  }

  inline void surfacesIntersect(SurfacesIntersectData &data, ForceData &on_i, ForceData &on_j) {
    if (data.is_wall) touch<true>(data, on_i, on_j);
    else touch<false>(data, on_i, on_j);
  }

  template <bool WALL> inline void touch(SurfacesIntersectData &data, ForceData &on_i, ForceData &on_j) {
    using demlaws::MOST_STATE;
    if (data.contact_flags) *data.contact_flags |= CONTACT_NORMAL_MODEL;
    const demlaws::TypePair &type = law_of(data);
    const double product = data.radi * data.radj, sum = data.radi + data.radj;
    const double radius = WALL ? data.radi : product / sum;
    if (__builtin_expect(!type.pair.serves(radius, now_.radius_tolerance), 0)) refuse_radius(data, radius, type.pair);
    double *const state = state_size_ ? &data.contact_history[offset_] : NULL;
    const bool update = data.computeflag && data.shearupdate;
    if (__builtin_expect(has_history_ && data.contact_history[identity_at_] != type.identity, 0))
      check_identity(data, type, update);
    double before[MOST_STATE];
    if (WALL && update)
      for (int k = 0; k < state_size_; k++) before[k] = state[k];
    const demlaws::Force now = demlaws::step(type.pair, radius, data.deltan, state, update, WALL ? 0. : sum / product);
    if (__builtin_expect(now.outside | type.watch.exceeds(data.deltan, radius), 0))
      examine(data, radius, type, now, update);

    const double damping = type.damping * sqrt(now.stiffness * data.meff);
    double normal = now.force - damping * data.vn;
    if (limit_force_ && normal < 0.) normal = 0.;
    if (__builtin_expect(update && instance_->ledger.readers, 0))
      instance_->ledger.add_viscous((now.force - normal) * data.vn * this->update->dt * (WALL ? data.area_ratio : 1.),
                                    WALL, data.j, atom->nlocal);
    data.Fn = normal;
    data.kn = data.deltan > 0. ? now.force / data.deltan : 0.;
    shear_stiffness_ = demlaws::shear_stiffness(now_.shear, type.pair, radius, data.deltan, now, state);
    data.kt = type.tangential * shear_stiffness_;
    friction_above_ = 0.;
    if (type.friction.c1 > 0.) {
      const double pressure = demlaws::mean_pressure(type.pair, now);
      friction_above_ = type.friction.above_constant(pressure);
      if (__builtin_expect(type.watch.exceeds_hardness(pressure), 0)) examine_friction(data, type, pressure, update);
    }
    data.gamman = damping;
    data.gammat = damping * type.tangential_damping;
    if (WALL) {
      if (data.computeflag) add_wall_energy(type.pair, radius, data.deltan, state, update ? before : NULL);
      const double share = normal * data.area_ratio;
      for (int k = 0; k < 3; k++) on_i.delta_F[k] += share * data.en[k];
    } else
      for (int k = 0; k < 3; k++) {
        on_i.delta_F[k] += normal * data.en[k];
        on_j.delta_F[k] -= normal * data.en[k];
      }
  }

  inline void surfacesClose(SurfacesCloseData &data, ForceData &, ForceData &) {
    if (data.contact_flags) *data.contact_flags &= ~CONTACT_NORMAL_MODEL;
    if (!data.contact_history) return;
    if (has_history_) data.contact_history[identity_at_] = 0.;
    if (!state_size_) return;
    double *const state = &data.contact_history[offset_];
    if (std::count(state, state + state_size_, 0.) == state_size_) return;
    if (!data.is_wall) {
      double stored, dissipated;
      energies(data, 0., stored, dissipated);
      instance_->ledger.add_dissipated(dissipated, data.j, atom->nlocal);
    }
    for (int i = 0; i < state_size_; i++) state[i] = 0.;
  }

  void beginPass(SurfacesIntersectData &, ForceData &, ForceData &) {}
  void endPass(SurfacesIntersectData &, ForceData &, ForceData &) {}

  // Energies of one contact.
  void energies(const SurfacesCloseData &data, double overlap, double &stored, double &dissipated) const {
    demlaws::energies_at(law_of(data).pair, radius_of(data), overlap, state_of(data), state_size_, stored, dissipated);
  }
  demlaws::Instance &instance() const { return *instance_; }
  void shear_keeps(int size) { shear_size_ = size; } // numbers of a contact that the tangential model keeps

  // Where the tangential model is `history`.
  void warn_of_history() {
    instance_->announce(
        "history",
        "tangential history creates energy where the stiffness rises while a contact is sheared: a closed box of rough "
        "spheres doubled its energy in 30 ms; use 'tangential demlaws' (" DEMLAWS_PAGE("shear") ")");
  }

  // For the tangential model, of the contact whose step came last: K, K_t / K, its curve.
  double shear_stiffness() const { return shear_stiffness_; }
  demlaws::Shear shear() const { return now_.shear; }
  double shear_ratio(const SurfacesCloseData &data) const { return law_of(data).tangential; }
  // By how much the friction of the contact whose step came last is above coefficientFriction.
  double friction_above() const { return friction_above_; }
  demlaws::UnloadingCurve unloading_curve(const SurfacesIntersectData &data) const {
    return law_of(data).unloading_curve(data.kn * data.deltan, data.deltan, state_of(data));
  }

private:
  void stop(const std::string &what) const { error->all(FLERR, ("model demlaws/table: " + what).c_str()); }
  const demlaws::TypePair &law_of(const SurfacesCloseData &data) const {
    return pairs_[data.itype * types_ + data.jtype];
  }
  static double radius_of(const SurfacesCloseData &data) {
    return data.is_wall ? data.radi : data.radi * data.radj / (data.radi + data.radj);
  }
  double *state_of(const SurfacesCloseData &data) const {
    return state_size_ && data.contact_history ? &data.contact_history[offset_] : NULL;
  }
  // A wall contact after its step: what it holds, and what its plastic flow took since `before`.
  inline void add_wall_energy(const demlaws::Pair &pair, double radius, double overlap, const double *state,
                              const double *before) {
    demlaws::Ledger &ledger = instance_->ledger;
    const bool flows = before && !std::equal(before, before + state_size_, state);
    if (!ledger.readers && !flows) return;
    double none, booked = 0., earlier = 0., stored, dissipated;
    if (state_size_) demlaws::stored_and_dissipated(pair, radius, overlap, state, none, booked);
    if (flows) {
      demlaws::stored_and_dissipated(pair, radius, overlap, before, none, earlier);
      ledger.taken += booked - earlier;
    }
    if (!ledger.readers) return;
    demlaws::energies_at(pair, radius, overlap, state, state_size_, stored, dissipated);
    ledger.add_wall(update->ntimestep, stored, dissipated - booked);
  }

  // Tables and settings as they hold now: a wall takes those that its line does not give from the pair style, whether
  // it precedes or follows that.
  void resolve_settings() {
    const demlaws::PairSettings &from = instance_->pair;
    now_ = own_;
    if (wall_) {
      if (own_.files.empty()) {
        now_.files = from.files;
        tables_ = from.tables;
      }
      if (!given_.count("surfaceRoughness")) now_.use_roughness = from.use_roughness;
      if (!given_.count("radius_tolerance")) now_.radius_tolerance = from.radius_tolerance;
      if (!given_.count("shear_ratio")) now_.shear_ratio = from.shear_ratio;
      if (!given_.count("extrapolation")) now_.extrapolate = from.extrapolate;
      if (!given_.count("shear")) now_.shear = from.shear;
      if (!given_.count("friction_pressure")) now_.friction = from.friction;
    }
    state_size_ = 0;
    for (const auto &file : now_.files) {
      const demlaws::Table *&table = tables_[file.second];
      try {
        if (!table) table = &demlaws::load_table(demlaws::Mpi(lmp), file.second);
      } catch (const std::exception &problem) {
        stop(problem.what());
      }
      state_size_ = std::max(state_size_, demlaws::state_size(table->unloading()));
    }
    if (!wall_) instance_->pair.tables = tables_;
  }

  // What two types have: of their own, or of all pairs; else what the type makes of nothing.
  template <class T> static T of_types(const std::map<demlaws::Types, T> &all, int i, int j) {
    typename std::map<demlaws::Types, T>::const_iterator it = all.find(demlaws::types_of(i, j));
    if (it == all.end()) it = all.find(demlaws::Types(0, 0));
    return it == all.end() ? T() : it->second;
  }

  // Makes the law of two types.
  void connect(int i, int j) {
    demlaws::TypePair &type = pairs_[i * types_ + j];
    const std::string who = "types " + std::to_string(i) + " and " + std::to_string(j) + ": ";
    const std::string file = of_types(now_.files, i, j);
    if (file.empty()) stop(who + "no table; add 'table FILE' or 'pairtable I J FILE'");
    const demlaws::Table &table = *tables_[file];
    double sigma = 0.; // [m]
    if (now_.use_roughness) {
      sigma = sqrt(roughness_[i] * roughness_[i] + roughness_[j] * roughness_[j]);
      if (!(sigma > 0.)) stop(who + "combined surfaceRoughness " + std::to_string(sigma) + " m: must be positive");
    }
    std::string doubt;
    try {
      type.friction = of_types(now_.friction, i, j);
      if (type.friction.c1 > 0.) type.require_area(table);
      doubt = type.set(table, effective_modulus_[i][j], sigma, now_.shear);
    } catch (const std::exception &problem) {
      stop(who + problem.what());
    }
    type.identity = type.Law::identity(shear_size_);
    if (!doubt.empty()) instance_->announce(doubt, "model demlaws/table: " + who + doubt);
    type.damping = -2. * 0.91287092917527685576 * beta_[i][j];
    type.tangential = now_.shear_ratio > 0. ? now_.shear_ratio : 4. * effective_shear_[i][j] / effective_modulus_[i][j];
    type.tangential_damping = damp_tangentially_ ? sqrt(type.tangential) : 0.;
  }

  // On the rank that has the contact, at its step.
  __attribute__((noinline, cold)) std::string who(const SurfacesCloseData &data) const {
    std::ostringstream what;
    what << "model demlaws/table: particle" << (data.is_wall ? " " : "s ") << atom->tag[data.i] << " and ";
    if (data.is_wall) what << "the wall";
    else what << atom->tag[data.j];
    what << " (types " << data.itype << " and " << data.jtype << "): ";
    return what.str();
  }
  __attribute__((noinline, cold)) void refuse(const SurfacesCloseData &data, const std::string &text) const {
    error->one(FLERR, (who(data) + text).c_str());
  }
  __attribute__((noinline, cold)) void refuse_radius(const SurfacesCloseData &data, double radius,
                                                     const demlaws::Pair &pair) const {
    refuse(data, demlaws::other_radius(pair, radius, now_.radius_tolerance));
  }
  struct Report : demlaws::Findings {
    const NormalModel &model;
    const SurfacesCloseData &data;
    Report(const NormalModel &m, const SurfacesCloseData &d, bool keeps)
        : Findings(m.instance_->counts, keeps), model(m), data(d) {}
    long body(int which) const { return which && data.is_wall ? -1 : model.atom->tag[which ? data.j : data.i]; }
    void warn(const std::string &text) {
      const std::string what = model.who(data) + text + " (reported once, counted at the end of the run)";
      model.error->warning(FLERR, what.c_str());
    }
    void refuse(const std::string &text) { model.refuse(data, text); }
  };
  // A contact that begins, or is of another law, of which an elastic one without springs keeps nothing.
  __attribute__((noinline, cold)) void check_identity(const SurfacesIntersectData &data, const demlaws::TypePair &type,
                                                      bool update) const {
    double &identity = data.contact_history[identity_at_];
    const double *const state = state_of(data);
    const bool kept = type.pair.rule != demlaws::ELASTIC || type.slips ||
                      (state && std::count(state, state + state_size_, 0.) < state_size_);
    if (!demlaws::Law::can_continue(identity, type.identity, kept)) refuse(data, demlaws::other_law());
    if (update) identity = type.identity;
  }
  // keeps: else the forces of a step are computed once more.
  __attribute__((noinline, cold)) void examine(const SurfacesIntersectData &data, double radius,
                                               const demlaws::TypePair &type, const demlaws::Force &now, bool keeps) {
    Report report(*this, data, keeps);
    const bool starts = update->ntimestep == update->firststep;
    type.watch.examine(type.pair, radius, data.deltan, now, now_.extrapolate, starts, report);
  }
  __attribute__((noinline, cold)) void examine_friction(const SurfacesIntersectData &data,
                                                        const demlaws::TypePair &type, double pressure, bool keeps) {
    Report report(*this, data, keeps);
    type.watch.examine_friction(pressure, report);
  }

  std::shared_ptr<demlaws::Instance> instance_;
  const bool wall_;
  double **effective_modulus_ = NULL, **effective_shear_ = NULL, **beta_ = NULL, *roughness_ = NULL;
  bool damp_tangentially_ = true, limit_force_ = false;
  std::set<std::string> given_;
  demlaws::PairSettings own_, now_; // as the line says; as they hold
  int offset_ = -1, identity_at_ = -1, state_size_ = 0, reserved_ = 0, shear_size_ = 0, types_ = 0;
  bool has_history_ = false; // contacts keep the identity of their law
  double friction_above_ = 0., shear_stiffness_ = 0.;
  std::vector<demlaws::TypePair> pairs_;
  std::map<std::string, const demlaws::Table *> tables_;
};

} // namespace ContactModels
} // namespace LIGGGHTS
#endif
