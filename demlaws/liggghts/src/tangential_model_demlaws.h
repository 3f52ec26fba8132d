// Tangential model `demlaws` of LIGGGHTS, which creates no energy: the contact sticks until it slides (demlaws_shear.h)
// or, with 'shear slip', slips in parts (demlaws_slip.h).
#ifndef DEMLAWS_TANGENTIAL_MODEL_H
#define DEMLAWS_TANGENTIAL_MODEL_H
#include "stock.h"

#include "contact_models.h"
#include "demlaws_shear.h"
#include "normal_model_demlaws.h"
#include "tangential_model_base.h"

namespace LIGGGHTS {
namespace ContactModels {

static const int TANGENTIAL_DEMLAWS = 60; // a free 6-bit id (stock uses 0 to 4)

template <> class TangentialModel<TANGENTIAL_DEMLAWS> : public TangentialModelBase {
public:
  TangentialModel(LAMMPS *lmp, IContactHistorySetup *setup, class ContactModelBase *base)
      : TangentialModelBase(lmp, setup, base), instance_(demlaws::Instance::of(lmp)), wall_(base->is_wall()) {}
  void connect(NormalModel<DEMLAWS_TABLE> &normal) { normal_ = &normal; }

  void registerSettings(Settings &settings) {
    settings.registerDoubleSetting("springs", springs_, demlaws::SPRINGS);
    settings.registerDoubleSetting("levels", levels_, demlaws::LEVELS);
  }
  // A wall takes what its line does not give from the pair style, as the normal model does.
  void postSettings(IContactHistorySetup *setup, ContactModelBase *) {
    const demlaws::Line &line = instance_->line;
    const bool own = !wall_ || line.given.count("shear");
    const bool slips = (own ? line.shear : instance_->pair.shear) == demlaws::SLIP_SHEAR;
    if (wall_ && !line.given.count("springs")) springs_ = instance_->springs;
    own_levels_ = line.given.count("levels");
    if (wall_ && !own_levels_) levels_ = instance_->levels;
    if (!wall_) instance_->springs = springs_, instance_->levels = levels_;
    if (!demlaws::SpringRow::may_have(springs_)) stop("'springs' must be a whole number from 2 to 22");
    if (!demlaws::may_have_levels(levels_)) stop("'levels' must be a whole number from 1 to 8");
    if (slips && own_levels_) stop("partial slip has springs, not levels: leave 'levels' out");
    row_.levels = (int)levels_;
    row_.springs = slips ? (int)springs_ : 0;
    size_ = row_.size();
    normal_->shear_keeps(size_);
    // At a wall also the normal of the step before: nothing else tells how it turns.
    for (int i = 0; i < size_ + 3 * wall_; i++) {
      const bool turns = i >= size_ || row_.changes_sign(i);
      const int at = setup->add_history_value("demlaws_shear" + std::to_string(i), turns ? "1" : "0");
      if (i == 0) offset_ = at;
    }
  }
  void connectToProperties(PropertyRegistry &registry) {
    registry.registerProperty("coeffFrict", &MODEL_PARAMS::createCoeffFrict);
    registry.connect("coeffFrict", friction_, "tangential model demlaws");
    const int types = registry.max_type(); // the matrix has no row for a type that no particle or wall has
    for (int i = 1; i <= types; ++i)
      for (int j = 1; j <= types; ++j)
        if (!(friction_[i][j] >= 0.)) stop("coefficientFriction must not be negative");
    instance_->see_contacts_end(wall_);
    const bool other_shear = (row_.springs > 0) != (normal_->shear() == demlaws::SLIP_SHEAR),
               other_levels = wall_ && !row_.springs && !own_levels_ && levels_ != instance_->levels;
    if (other_shear || other_levels)
      stop(std::string("this wall was defined before the pair style's '") + (other_shear ? "shear" : "levels") +
           "' was known: define it below the pair_style line");
    PairGran *const pair = static_cast<PairGran *>(force->pair_match("gran", 0));
    if (pair && !wall_) demlaws::refuse_small_pages(lmp, pair->dnum(), "tangential model demlaws: a contact");
  }

  inline void surfacesIntersect(const SurfacesIntersectData &data, ForceData &on_i, ForceData &on_j) {
    if (data.is_wall) touch<true>(data, on_i, on_j);
    else touch<false>(data, on_i, on_j);
  }
  template <bool WALL> inline void touch(const SurfacesIntersectData &data, ForceData &on_i, ForceData &on_j) {
    if (data.contact_flags) *data.contact_flags |= CONTACT_TANGENTIAL_MODEL;
    const bool keep = data.computeflag && data.shearupdate;
    const double limit = (friction_[data.itype][data.jtype] + normal_->friction_above()) * fabs(data.Fn);
    double copy[demlaws::ShearRow::MOST_SIZE], *const kept = data.contact_history + offset_;
    if (!keep) std::copy(kept, kept + size_, copy);
    double *const numbers = keep ? kept : copy;
    const demlaws::Motion motion = motion_of<WALL>(data, keep ? update->dt : 0., demlaws::unit_vector(numbers, size_));
    const bool counts = keep && instance_->ledger.readers;
    if (__builtin_expect(counts && instance_->ledger.adds_stored, 0)) add_work(energy(kept, data), data);
    demlaws::ShearStep step;
    const auto move = [&] {
      step = row_.step(normal_->shear_stiffness(), normal_->unloading_curve(data), normal_->shear_ratio(data), limit,
                       motion, numbers);
    };
    if (counts) {
      move();
      add_work(step.work, data);
    } else move(); // less: no work
    if (WALL && data.computeflag && instance_->ledger.readers) {
      const double stored = energy(numbers, data);
      instance_->ledger.add_wall(update->ntimestep, stored, -instance_->ledger.booked(stored));
    }

    double viscous[2], force[3], moment[3];
    step.damp(data.gammat, limit, motion.velocity, viscous);
    const double share = WALL ? data.area_ratio : 1.;
    const double tangential[2] = {viscous[0] - step.force[0], viscous[1] - step.force[1]};
    if (__builtin_expect(counts, 0)) {
      const double power = -viscous[0] * motion.velocity[0] - viscous[1] * motion.velocity[1];
      instance_->ledger.add_viscous(share * power * update->dt, WALL, data.j, atom->nlocal);
    }
    motion.in_space(tangential, force);
    vectorCross3D(data.en, force, moment);
    for (int k = 0; k < 3; k++) {
      on_i.delta_F[k] += share * force[k];
      on_i.delta_torque[k] -= share * data.cri * moment[k];
      if (WALL) continue;
      on_j.delta_F[k] -= force[k];
      on_j.delta_torque[k] -= data.crj * moment[k];
    }
  }

  inline void surfacesClose(SurfacesCloseData &data, ForceData &, ForceData &) {
    if (data.contact_flags) *data.contact_flags &= ~CONTACT_TANGENTIAL_MODEL;
    if (!data.contact_history) return;
    double *const kept = data.contact_history + offset_;
    if (wall_ || kept[row_.top()] != 0.) std::fill(kept, kept + size_ + 3 * wall_, 0.);
  }
  void beginPass(SurfacesIntersectData &, ForceData &, ForceData &) {}
  void endPass(SurfacesIntersectData &, ForceData &, ForceData &) {}

  // Energy that the shear of a contact stores.
  double stored(const SurfacesCloseData &data) const {
    return data.contact_history ? energy(data.contact_history + offset_, data) : 0.;
  }

private:
  void stop(const std::string &what) const { error->all(FLERR, ("tangential model demlaws: " + what).c_str()); }
  // dt: 0 where nothing is to be kept. unit_vector: that of the contact.
  template <bool WALL>
  __attribute__((noinline)) demlaws::Motion motion_of(const SurfacesIntersectData &data, double dt,
                                                      double *unit_vector) {
    const double *const n = data.en, *const w = data.omega_i, wr[3] = {data.wr1, data.wr2, data.wr3};
    double apart[3], spin[3], arms[3], change[3];
    for (int k = 0; k < 3; k++) apart[k] = data.v_i[k] - data.v_j[k];
    if (WALL) demlaws::Motion::change_of_kept(n, data.contact_history + offset_ + size_, dt > 0., change);
    else demlaws::Motion::change_of_spheres(n, apart, data.vn, data.rinv, dt, change);
    // The lever of each body, radius - overlap/2, was dt/4 times the velocity of parting shorter at the half step.
    const double parting = demlaws::Motion::parting(n, apart, change);
    for (int k = 0; k < 3; k++) {
      spin[k] = WALL ? w[k] : w[k] + data.omega_j[k];
      arms[k] = data.r * wr[k] - 0.25 * dt * parting * spin[k];
    }
    if (!WALL) return demlaws::Motion(n, apart, change, arms, spin, dt, unit_vector);
    double turn[3];
    if (spin_of_wall(data, turn)) {
      // The wall's velocity is that of the place x - r n where the sphere touches it now: at the half step it touched
      // it dt/2 times the velocity of that place before (of a wall that turns about a fixed axis).
      double moved[3], lag[3];
      for (int k = 0; k < 3; k++) moved[k] = 0.5 * (dt * (data.v_i[k] - parting * n[k]) - data.r * change[k]);
      vectorCross3D(turn, moved, lag);
      for (int k = 0; k < 3; k++) {
        apart[k] += lag[k];
        spin[k] += turn[k];
      }
    }
    return demlaws::Motion(n, apart, change, arms, spin, dt, unit_vector);
  }
  // Of a mesh that moves, from the velocities of the triangle's nodes: with its edges e1, e2 and the velocities d1, d2
  // along them, the sum of e^i x d_i (e^i: reciprocal vectors) is the spin and once more its part along the normal.
  bool spin_of_wall(const SurfacesIntersectData &data, double *spin) {
    if (!data.mesh) return false;
    if (data.mesh != mesh_ || update->ntimestep != mesh_step_) {
      mesh_ = data.mesh;
      mesh_step_ = update->ntimestep;
      node_velocities_ = mesh_->prop().getElementProperty<MultiVectorContainer<double, 3, 3>>("v");
    }
    if (!node_velocities_) return false;
    double **const v = node_velocities_->begin()[data.j], at[3][3], e1[3], e2[3], d1[3], d2[3], normal[3], turn[3];
    for (int k = 0; k < 3; k++) mesh_->node(data.j, k, at[k]);
    vectorSubtract3D(at[1], at[0], e1);
    vectorSubtract3D(at[2], at[0], e2);
    vectorSubtract3D(v[1], v[0], d1);
    vectorSubtract3D(v[2], v[0], d2);
    vectorCross3D(e1, e2, normal);
    const double square = vectorDot3D(normal, normal); // reciprocal vectors: e2 x normal, normal x e1, over it
    double first[3], second[3], sum[3];
    vectorCross3D(e2, normal, first);
    vectorCross3D(normal, e1, second);
    vectorCross3D(first, d1, sum);
    vectorCross3D(second, d2, turn);
    for (int k = 0; k < 3; k++) sum[k] = (sum[k] + turn[k]) / square;
    const double half = 0.5 * vectorDot3D(sum, normal) / square;
    for (int k = 0; k < 3; k++) spin[k] = sum[k] - half * normal[k];
    return true;
  }
  double energy(double *numbers, const SurfacesCloseData &data) const {
    return row_.energy(numbers, normal_->shear_ratio(data));
  }
  void add_work(double work, const SurfacesCloseData &data) {
    if (data.is_wall) instance_->ledger.taken += work;
    else instance_->ledger.add_dissipated(work, data.j, atom->nlocal);
  }

  const std::shared_ptr<demlaws::Instance> instance_;
  const bool wall_;
  NormalModel<DEMLAWS_TABLE> *normal_ = NULL;
  double **friction_ = NULL, springs_ = demlaws::SPRINGS, levels_ = demlaws::LEVELS; // as the line says
  demlaws::ShearRow row_;
  int offset_ = -1, size_ = 0; // of the row
  TriMesh *mesh_ = NULL;       // of the contact before, its step and the velocities of its nodes
  bigint mesh_step_ = -1;
  MultiVectorContainer<double, 3, 3> *node_velocities_ = NULL;
  bool own_levels_ = false; // the line has the word
};

} // namespace ContactModels
} // namespace LIGGGHTS
#endif
