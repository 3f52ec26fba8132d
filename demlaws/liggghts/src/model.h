// The contact model that the pair loop and the walls are made from.
#ifndef DEMLAWS_MODEL_H
#define DEMLAWS_MODEL_H
#include "stock.h"

#include "contact_models.h"
#include "normal_model_demlaws.h"
#include "tangential_model_demlaws.h"

namespace demlaws {
using namespace LAMMPS_NS;
using namespace LIGGGHTS;
using namespace LIGGGHTS::ContactModels;

// The sub-models of one contact, composed when compiled, as the stock ContactModel is; none of cohesion.
template <int TANGENTIAL, int ROLLING> class Model : public ContactModelBase {
public:
  SurfaceModel<SURFACE_DEFAULT> surface;
  NormalModel<DEMLAWS_TABLE> normal;
  TangentialModel<TANGENTIAL> tangential;
  RollingModel<ROLLING> rolling;

  // the order of the members is the order in which they claim history
  Model(LAMMPS *lmp, IContactHistorySetup *setup, bool wall, const int64_t)
      : ContactModelBase(lmp, wall), surface(lmp, setup, this), normal(lmp, setup, this), tangential(lmp, setup, this),
        rolling(lmp, setup, this) {
    join(tangential);
  }
  int64_t hashcode() {
    return Utils::generate_gran_hashcode(DEMLAWS_TABLE, TANGENTIAL, COHESION_OFF, ROLLING, SURFACE_DEFAULT);
  }
  void registerSettings(Settings &s) {
    surface.registerSettings(s);
    normal.registerSettings(s);
    tangential.registerSettings(s);
    rolling.registerSettings(s);
  }
  void postSettings(IContactHistorySetup *h) {
    surface.postSettings(h, this);
    tangential.postSettings(h, this);
    rolling.postSettings(h, this);
    normal.postSettings(h, this);
  }
  void connectToProperties(PropertyRegistry &p) {
    if (TANGENTIAL == TANGENTIAL_HISTORY) normal.warn_of_history();
    surface.connectToProperties(p);
    normal.connectToProperties(p);
    tangential.connectToProperties(p);
    rolling.connectToProperties(p);
  }
  // empty in all of these sub-models
  void beginPass(SurfacesIntersectData &, ForceData &, ForceData &) {}
  void endPass(SurfacesIntersectData &, ForceData &, ForceData &) {}
  void tally_pp(double, int, int, int) {}
  void tally_pw(double, int, int, int) {}
  double stressStrainExponent() { return normal.stressStrainExponent(); }
  bool checkSurfaceIntersect(SurfacesIntersectData &d) { return surface.checkSurfaceIntersect(d); }
  inline void surfacesIntersect(SurfacesIntersectData &d, ForceData &i, ForceData &j) {
    if (d.is_wall) touch<true>(d, i, j);
    else touch<false>(d, i, j);
  }
  template <bool IS_WALL> inline void touch(SurfacesIntersectData &d, ForceData &i, ForceData &j) {
    surface.surfacesIntersect(d, i, j);
    normal.template touch<IS_WALL>(d, i, j);
    shear<IS_WALL>(tangential, d, i, j);
    rolling.surfacesIntersect(d, i, j);
  }
  void endSurfacesIntersect(SurfacesIntersectData &d, class TriMesh *mesh, ForceData &i, ForceData &) {
    surface.endSurfacesIntersect(d, mesh, i.delta_F);
  }
  inline void surfacesClose(SurfacesCloseData &d, ForceData &i, ForceData &j) {
    surface.surfacesClose(d, i, j);
    normal.surfacesClose(d, i, j);
    tangential.surfacesClose(d, i, j);
    rolling.surfacesClose(d, i, j);
  }
  // Energy of a contact: what normal and shear force store; what its plastic flow took, less the part of the booked
  // work of shear that is stored.
  void energies(const SurfacesCloseData &data, double overlap, double &stored, double &dissipated) const {
    normal.energies(data, overlap, stored, dissipated);
    const double shear = shear_energy(tangential, data);
    stored += shear;
    dissipated -= normal.instance().ledger.booked(shear);
  }
  bool contact_match(const std::string kind, const std::string name) {
    Factory &known = Factory::instance();
    if (kind == "surface") return known.getSurfaceModelId(name) == SURFACE_DEFAULT;
    if (kind == "normal") return known.getNormalModelId(name) == DEMLAWS_TABLE;
    if (kind == "cohesion") return known.getCohesionModelId(name) == COHESION_OFF;
    if (kind == "tangential") return known.getTangentialModelId(name) == TANGENTIAL;
    if (kind == "rolling_friction") return known.getRollingModelId(name) == ROLLING;
    return false;
  }

private:
  typedef TangentialModel<TANGENTIAL_DEMLAWS> ShearModel;
  template <class OTHER> void join(OTHER &) {}
  void join(ShearModel &shear_model) { shear_model.connect(normal); }
  template <bool, class OTHER> static void shear(OTHER &other, SurfacesIntersectData &d, ForceData &i, ForceData &j) {
    other.surfacesIntersect(d, i, j);
  }
  template <bool IS_WALL>
  static void shear(ShearModel &shear_model, SurfacesIntersectData &d, ForceData &i, ForceData &j) {
    shear_model.template touch<IS_WALL>(d, i, j);
  }
  template <class OTHER> static double shear_energy(const OTHER &, const SurfacesCloseData &) { return 0.; }
  static double shear_energy(const ShearModel &shear_model, const SurfacesCloseData &data) {
    return shear_model.stored(data);
  }
};

} // namespace demlaws
#endif
