// Tangential model `demlaws` of LIGGGHTS: sticks until it slides, and creates no energy (demlaws_shear.h).
#ifndef DEMLAWS_TANGENTIAL_MODEL_H
#define DEMLAWS_TANGENTIAL_MODEL_H
#include "stock.h"

#include "contact_models.h"
#include "demlaws_shear.h"
#include "global_properties.h"
#include "instance.h"
#include "tangential_model_base.h"

namespace LIGGGHTS {
namespace ContactModels {

static const int TANGENTIAL_DEMLAWS = 60; // a free 6-bit id (stock uses 0 to 4)

template <> class TangentialModel<TANGENTIAL_DEMLAWS> : public TangentialModelBase {
public:
  TangentialModel(LAMMPS *lmp, IContactHistorySetup *setup, class ContactModelBase *base)
      : TangentialModelBase(lmp, setup, base), instance_(demlaws::Instance::of(lmp)), friction_(NULL) {
    offset_ = setup->add_history_value("demlaws_shearStiffness", "0"); // the same seen from either particle
    setup->add_history_value("demlaws_stretchx", "1");
    setup->add_history_value("demlaws_stretchy", "1");
    setup->add_history_value("demlaws_stretchz", "1");
  }
  void registerSettings(Settings &) {}
  void postSettings(IContactHistorySetup *, ContactModelBase *) {}
  void connectToProperties(PropertyRegistry &registry) {
    registry.registerProperty("coeffFrict", &MODEL_PARAMS::createCoeffFrict);
    registry.connect("coeffFrict", friction_, "tangential model demlaws");
  }

  inline void surfacesIntersect(const SurfacesIntersectData &data, ForceData &on_i, ForceData &on_j) {
    if (data.contact_flags) *data.contact_flags |= CONTACT_TANGENTIAL_MODEL;
    demlaws::Stretch &kept = stretch(data.contact_history), now = kept;
    const bool update = data.computeflag && data.shearupdate;
    const double dt = update ? this->update->dt : 0., limit = friction_[data.itype][data.jtype] * fabs(data.Fn);
    const double displacement[3] = {data.vtr1 * dt, data.vtr2 * dt, data.vtr3 * dt};
    bool slides;
    const double lost = demlaws::shear_step(data.kt, limit, data.en, displacement, now, slides);
    if (update) {
      kept = now;
      if (data.is_wall) instance_->ledger.take_at_wall(lost * data.area_ratio, data.i);
      else instance_->ledger.take(lost, data.i, data.j, atom->nlocal);
    }
    const double damping = slides ? 0. : data.gammat;
    const double force[3] = {-now.stiffness * now.vector[0] - damping * data.vtr1,
                             -now.stiffness * now.vector[1] - damping * data.vtr2,
                             -now.stiffness * now.vector[2] - damping * data.vtr3};
    const double share = data.is_wall ? data.area_ratio : 1.;
    const double *const n = data.en;
    const double moment[3] = {n[1] * force[2] - n[2] * force[1], n[2] * force[0] - n[0] * force[2],
                              n[0] * force[1] - n[1] * force[0]};
    for (int k = 0; k < 3; k++) {
      on_i.delta_F[k] += share * force[k];
      on_i.delta_torque[k] -= share * data.cri * moment[k];
      if (data.is_wall) continue;
      on_j.delta_F[k] -= force[k];
      on_j.delta_torque[k] -= data.crj * moment[k];
    }
  }
  inline void surfacesClose(SurfacesCloseData &data, ForceData &, ForceData &) {
    if (data.contact_flags) *data.contact_flags &= ~CONTACT_TANGENTIAL_MODEL;
    if (!data.contact_history) return;
    demlaws::Stretch &kept = stretch(data.contact_history);
    if (!data.is_wall) instance_->ledger.take(demlaws::stretch_energy(kept), data.i, data.j, atom->nlocal);
    else instance_->ledger.take_at_wall(demlaws::stretch_energy(kept), data.i);
    kept = demlaws::Stretch();
  }
  void beginPass(SurfacesIntersectData &, ForceData &, ForceData &) {}
  void endPass(SurfacesIntersectData &, ForceData &, ForceData &) {}

  // Energy that the shear of a contact stores.
  double stored(double *contact_history) const { return demlaws::stretch_energy(stretch(contact_history)); }

private:
  demlaws::Stretch &stretch(double *contact_history) const {
    return *reinterpret_cast<demlaws::Stretch *>(contact_history + offset_);
  }
  const std::shared_ptr<demlaws::Instance> instance_;
  double **friction_;
  int offset_;
};

} // namespace ContactModels
} // namespace LIGGGHTS
#endif
