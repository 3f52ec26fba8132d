// Normal model `demlaws/table` of LIGGGHTS: force and tangent stiffness from a table file, unloading with history.
//
//   pair_style gran model demlaws/table tangential history table granite.tbl
//   pair_style gran model demlaws/table tangential history table granite.tbl pairtable 1 2 granite-steel.tbl
//   fix w all wall/gran model demlaws/table tangential history primitive type 1 zplane 0.0       (tables of the pair style)
//
// Settings: tangential_damping on|off (on), limitForce on|off (off), surfaceRoughness on|off (off: the length of the
// file; on: sigma = sqrt(sigma_i^2 + sigma_j^2) from property/global surfaceRoughness peratomtype),
// radius_tolerance X (0.01: for tables of laws that do not collapse, how far R of a contact may be from the table's).
#ifndef DEMLAWS_NORMAL_MODEL_H
#define DEMLAWS_NORMAL_MODEL_H
#include <memory>
#include <set>
#include "contact_models.h"
#include "normal_model_base.h"
#include "global_properties.h"
#include "neighbor.h"
#include "comm.h"
#include "update.h"
#include "demlaws_table.h"

namespace demlaws {

typedef std::map<std::pair<int, int>, std::string> Files; // (0, 0) is the table of all pairs without their own

// What `table` and `pairtable` of the line being parsed said, and what the pair style of each instance said.
struct Pending {
  static Files &now() {
    static Files files;
    return files;
  }
  static std::map<void *, Files> &of_pair_style() {
    static std::map<void *, Files> files;
    return files;
  }
};

struct TypePair {
  Pair pair;
  double damping;            // -2 sqrt(5/6) beta
  double tangential;         // kt / K = 4 G* / E*
  double tangential_damping; // gamma_t / gamma_n, or 0
  double radius;             // > 0: the only radius the table is valid for
};

// The wall contacts of one wall in the last step, for their stored energy.
class WallContacts {
public:
  WallContacts() : step_(-1) {}
  void add(bigint step, const Pair &pair, double radius, double overlap, const double *state, int size) {
    if (step != step_) forget();
    step_ = step;
    contacts_.push_back(Contact(pair, radius, overlap));
    states_.insert(states_.end(), state, state + size);
  }
  void forget() {
    contacts_.clear();
    states_.clear();
  }
  double stored(bigint step, int size) const {
    double sum = 0., stored, dissipated;
    for (size_t n = 0; step == step_ && n < contacts_.size(); n++) {
      const Contact &c = contacts_[n];
      stored_and_dissipated(*c.pair, c.radius, c.overlap, size ? &states_[n * size] : NULL, stored, dissipated);
      sum += stored;
    }
    return sum;
  }

private:
  struct Contact {
    const Pair *pair;
    double radius, overlap;
    Contact(const Pair &p, double r, double o) : pair(&p), radius(r), overlap(o) {}
  };
  bigint step_;
  std::vector<Contact> contacts_;
  std::vector<double> states_;
};

// Energy of this rank that no pair contact holds: `taken` is what plastic flow took in pair contacts that have ended and
// in all wall contacts. A mesh drops contacts, and hands them from triangle to triangle, without a word to the model; so
// the dissipation of walls is added up while it happens, not when a contact ends.
struct Ledger {
  double taken;
  int readers; // computes that will ask for what walls store
  std::set<class WallBook *> walls;
  Ledger() : taken(0.), readers(0) {}
  static Ledger &of(void *lmp) {
    static std::map<void *, Ledger> ledgers;
    return ledgers[lmp];
  }
};
class WallBook {
public:
  virtual ~WallBook() {}
  virtual double stored() const = 0; // [J]
  virtual void forget() = 0;         // before forces are computed anew
};

} // namespace demlaws

namespace MODEL_PARAMS {
inline VectorProperty *createSurfaceRoughness(PropertyRegistry &registry, const char *caller, bool checks) {
  return createPerTypeProperty(registry, "surfaceRoughness", caller, checks, 0., 1.);
}
} // namespace MODEL_PARAMS

namespace LIGGGHTS {
namespace ContactModels {

static const int DEMLAWS_TABLE = 60; // a free 6-bit id (stock uses 0 to 12)

template <> class NormalModel<DEMLAWS_TABLE> : public NormalModelBase, private demlaws::WallBook {
public:
  NormalModel(LAMMPS *lmp, IContactHistorySetup *setup, class ContactModelBase *base)
      : NormalModelBase(lmp, setup, base), base_(base), effective_modulus_(NULL), effective_shear_(NULL), beta_(NULL),
        roughness_(NULL), damp_tangentially_(true), limit_force_(false), use_roughness_(false),
        radius_tolerance_(0.01), offset_(-1), state_size_(0), types_(0), ledger_(demlaws::Ledger::of(lmp)) {
    if (base->is_wall()) ledger_.walls.insert(this);
  }
  ~NormalModel() { ledger_.walls.erase(this); }

  void registerSettings(Settings &settings) {
    settings.registerOnOff("tangential_damping", damp_tangentially_, true);
    settings.registerOnOff("limitForce", limit_force_, false);
    settings.registerOnOff("surfaceRoughness", use_roughness_, false);
    settings.registerDoubleSetting("radius_tolerance", radius_tolerance_, 0.01);
  }

  // The tables are known here (Pending), so only as much history is kept as their unloading needs.
  void postSettings(IContactHistorySetup *setup, ContactModelBase *base) {
    files_ = demlaws::Pending::now();
    if (files_.empty() && base_->is_wall()) files_ = demlaws::Pending::of_pair_style()[lmp];
    if (files_.empty()) {
      const char *file = getenv("DEMLAWS_TABLE");
      if (file) files_[std::make_pair(0, 0)] = file;
    }
    if (files_.empty())
      error->all(FLERR, "model demlaws/table: no table; add 'table FILE' to the line (`demlaws table` writes one)");
    if (!base_->is_wall()) demlaws::Pending::of_pair_style()[lmp] = files_;
    for (demlaws::Files::const_iterator it = files_.begin(); it != files_.end(); ++it) {
      std::shared_ptr<demlaws::Table> &table = tables_[it->second];
      if (table) continue;
      table.reset(new demlaws::Table);
      try {
        table->read(it->second);
      } catch (const std::exception &problem) {
        error->all(FLERR, (std::string("model demlaws/table: ") + problem.what()).c_str());
      }
      state_size_ = std::max(state_size_, demlaws::state_size(table->unloading()));
    }
    static const char *const names[MOST_STATE] = {"demlaws_maximumOverlap", "demlaws_plasticOverlap", "demlaws_radiusRatio"};
    for (int i = 0; i < state_size_; i++) {
      const int at = setup->add_history_value(names[i], "0"); // the same seen from either particle
      base->add_history_offset(names[i], at);
      if (i == 0) offset_ = at;
    }
  }

  void connectToProperties(PropertyRegistry &registry) {
    const char *const me = "model demlaws/table";
    registry.registerProperty("Yeff", &MODEL_PARAMS::createYeff, me);
    registry.registerProperty("Geff", &MODEL_PARAMS::createGeff, me);
    registry.registerProperty("betaeff", &MODEL_PARAMS::createBetaEff, me);
    registry.connect("Yeff", effective_modulus_, me);
    registry.connect("Geff", effective_shear_, me);
    registry.connect("betaeff", beta_, me);
    if (use_roughness_) {
      registry.registerProperty("surfaceRoughness", &MODEL_PARAMS::createSurfaceRoughness);
      registry.connect("surfaceRoughness", roughness_, me);
    }
    if (force->cg_active()) error->cg(FLERR, me);
    if (atom->shapetype_flag || atom->superquadric_flag)
      error->all(FLERR, "model demlaws/table: only spheres; superquadric and convex particles are not supported");
    if (tables_.empty()) error->all(FLERR, "model demlaws/table: repeat the pair_style line after read_restart");
    // walls have no contact flags: without this factor surfacesClose() is never called for them
    if (state_size_ > 0 && base_->is_wall()) neighbor->register_contact_dist_factor(1.01);
    types_ = registry.max_type() + 1;
    pairs_.assign(types_ * types_, demlaws::TypePair());
    for (int i = 1; i < types_; i++)
      for (int j = 1; j < types_; j++) connect(i, j);
  }

  double stressStrainExponent() { return 1.5; }

  inline void surfacesIntersect(SurfacesIntersectData &data, ForceData &on_i, ForceData &on_j) {
    if (data.is_wall) touch<true>(data, on_i, on_j);
    else touch<false>(data, on_i, on_j);
  }

  template <bool WALL> inline void touch(SurfacesIntersectData &data, ForceData &on_i, ForceData &on_j) {
    if (data.contact_flags) *data.contact_flags |= CONTACT_NORMAL_MODEL;
    const demlaws::TypePair &type = pairs_[data.itype * types_ + data.jtype];
    const double radius = WALL ? data.radi : data.radi * data.radj / (data.radi + data.radj);
    if (type.radius > 0. && !(fabs(radius - type.radius) <= radius_tolerance_ * type.radius)) refuse_radius(data, radius, type);
    double *const state = state_size_ ? &data.contact_history[offset_] : NULL;
    const bool update = data.computeflag && data.shearupdate;
    double before[MOST_STATE];
    if (WALL && update)
      for (int k = 0; k < state_size_; k++) before[k] = state[k];
    const demlaws::Force now = demlaws::step(type.pair, radius, data.deltan, state, update);
    if (__builtin_expect(now.outside, 0)) refuse_overlap(data, radius, type);

    const double damping = type.damping * sqrt(now.stiffness * data.meff);
    double normal = now.force - damping * data.vn;
    if (limit_force_ && normal < 0.) normal = 0.;
    data.Fn = normal;
    data.kn = data.deltan > 0. ? now.force / data.deltan : 0.;
    data.kt = type.tangential * now.stiffness;
    data.gamman = damping;
    data.gammat = damping * type.tangential_damping;
    if (WALL) {
      if (data.computeflag) enter(type.pair, radius, data.deltan, state, update ? before : NULL);
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
    if (!state_size_ || !data.contact_history) return;
    double *const state = &data.contact_history[offset_];
    if (state[0] == 0.) return;
    if (!data.is_wall) {
      double stored, dissipated;
      energies(data, 0., stored, dissipated);
      ledger_.taken += data.j < atom->nlocal ? dissipated : 0.5 * dissipated;
    }
    for (int i = 0; i < state_size_; i++) state[i] = 0.;
  }

  void beginPass(SurfacesIntersectData &, ForceData &, ForceData &) {}
  void endPass(SurfacesIntersectData &, ForceData &, ForceData &) {}

  // Energies of one contact [J].
  void energies(const SurfacesCloseData &data, double overlap, double &stored, double &dissipated) const {
    const demlaws::TypePair &type = pairs_[data.itype * types_ + data.jtype];
    const double radius = data.is_wall ? data.radi : data.radi * data.radj / (data.radi + data.radj);
    demlaws::stored_and_dissipated(type.pair, radius, overlap, state_size_ ? &data.contact_history[offset_] : NULL, stored,
                                   dissipated);
  }
  int state_size() const { return state_size_; }

private:
  static const int MOST_STATE = 3;
  double stored() const { return contacts_.stored(update->ntimestep, state_size_); }
  void forget() { contacts_.forget(); }
  // A wall contact after its step: what it holds, and what its plastic flow took since `before`.
  inline void enter(const demlaws::Pair &pair, double radius, double overlap, const double *state, const double *before) {
    if (ledger_.readers) contacts_.add(update->ntimestep, pair, radius, overlap, state, state_size_);
    if (!before || std::equal(before, before + state_size_, state)) return;
    double stored, earlier, now;
    demlaws::stored_and_dissipated(pair, radius, overlap, before, stored, earlier);
    demlaws::stored_and_dissipated(pair, radius, overlap, state, stored, now);
    ledger_.taken += now - earlier;
  }
  void connect(int i, int j) {
    demlaws::TypePair &type = pairs_[i * types_ + j];
    demlaws::Files::const_iterator it = files_.find(std::make_pair(i, j));
    if (it == files_.end()) it = files_.find(std::make_pair(j, i));
    if (it == files_.end()) it = files_.find(std::make_pair(0, 0));
    std::ostringstream who;
    who << "model demlaws/table: types " << i << " and " << j << ": ";
    if (it == files_.end()) error->all(FLERR, (who.str() + "no table; add 'table FILE' or 'pairtable I J FILE'").c_str());
    const demlaws::Table &table = *tables_[it->second];
    double sigma = 0.;
    if (use_roughness_) {
      sigma = sqrt(roughness_[i] * roughness_[i] + roughness_[j] * roughness_[j]);
      if (!(sigma > 0.)) error->all(FLERR, (who.str() + "surfaceRoughness must be positive [m]").c_str());
    }
    const double E = effective_modulus_[i][j] / force->nktv2p;
    const bool collapses = table.collapses();
    try {
      type.pair = demlaws::Pair(table, E, collapses ? sigma : 0.);
    } catch (const std::exception &problem) {
      error->all(FLERR, (who.str() + problem.what()).c_str());
    }
    type.radius = 0.;
    if (!collapses) {
      type.radius = table.of_contact("radius", 0.);
      const double made_for = table.of_contact("modulus", 0.);
      if (!(type.radius > 0.) || !(made_for > 0.))
        error->all(FLERR, (who.str() + table.path() + " says 'collapses: no' but has no radius and modulus").c_str());
      if (fabs(E - made_for) > 1e-6 * made_for) {
        who << table.path() << " holds for the effective modulus " << made_for << " Pa only, the case has " << E
            << " Pa; make a table of this pair";
        error->all(FLERR, who.str().c_str());
      }
      if (use_roughness_) {
        who << table.path() << " holds for its own roughness only: law " << table.text("law")
            << " does not collapse; use 'surfaceRoughness off'";
        error->all(FLERR, who.str().c_str());
      }
    }
    type.damping = -2. * 0.91287092917527685576 * beta_[i][j];
    type.tangential = 4. * effective_shear_[i][j] / effective_modulus_[i][j];
    type.tangential_damping = damp_tangentially_ ? sqrt(type.tangential) : 0.;
  }

  __attribute__((noinline, cold)) void place(std::ostringstream &what, const SurfacesCloseData &data) const {
    what << "model demlaws/table: ";
    if (data.is_wall) what << "particle " << atom->tag[data.i] << " and the wall";
    else what << "particles " << atom->tag[data.i] << " and " << atom->tag[data.j];
    what << " (types " << data.itype << " and " << data.jtype << "): ";
  }
  __attribute__((noinline, cold)) void refuse_overlap(const SurfacesIntersectData &data, double radius,
                                                      const demlaws::TypePair &type) const {
    std::ostringstream what;
    place(what, data);
    what << "overlap " << data.deltan << " m is beyond the last row of " << type.pair.table->path() << ", "
         << type.pair.table->last_overlap() * type.pair.length_of(radius) << " m; make a table with a larger range";
    error->one(FLERR, what.str().c_str());
  }
  __attribute__((noinline, cold)) void refuse_radius(const SurfacesIntersectData &data, double radius,
                                                     const demlaws::TypePair &type) const {
    std::ostringstream what;
    place(what, data);
    what << "contact radius " << radius << " m, but law " << type.pair.table->text("law") << " does not collapse and "
         << type.pair.table->path() << " holds for " << type.radius << " m (radius_tolerance " << radius_tolerance_
         << "); make a table of this pair of types or widen the tolerance";
    error->one(FLERR, what.str().c_str());
  }

  class ContactModelBase *base_;
  double **effective_modulus_, **effective_shear_, **beta_, *roughness_;
  bool damp_tangentially_, limit_force_, use_roughness_;
  double radius_tolerance_;
  int offset_, state_size_, types_;
  demlaws::Ledger &ledger_;
  demlaws::WallContacts contacts_;
  std::vector<demlaws::TypePair> pairs_;
  demlaws::Files files_;
  std::map<std::string, std::shared_ptr<demlaws::Table> > tables_;
};

} // namespace ContactModels
} // namespace LIGGGHTS
#endif
