// Walls: as the stock wall, but where two triangles claim one and the same contact only one of them pushes.
#ifndef DEMLAWS_WALL_STYLE_H
#define DEMLAWS_WALL_STYLE_H
#include "stock.h"

#include "arguments.h"
#include "energy.h"
#include "fix_wall_gran_base.h"
#include "primitive_wall.h"

namespace demlaws {
using namespace LIGGGHTS;

template <class MODEL> class WallStyle : public Walls::Granular<MODEL> {
public:
  WallStyle(LAMMPS *lmp, FixWallGran *parent, const int64_t hash)
      : Walls::Granular<MODEL>(lmp, parent, hash), lmp_(lmp), parent_(parent), instance_(Instance::of(lmp)), step_(-1),
        mesh_(-1), triangle_(-1) {
    register_styles(lmp->modify);
    instance_->walls.insert(parent->id);
  }
  ~WallStyle() { instance_->walls.erase(parent_->id); }
  void settings(int count, char **arguments, IContactHistorySetup *setup) {
    Arguments own(lmp_, count, arguments);
    Walls::Granular<MODEL>::settings(count, arguments, setup);
  }
  void init_granular() {
    ensure_fix(lmp_->modify);
    Walls::Granular<MODEL>::init_granular();
    if (parent_->is_mesh_wall())
      refuse_small_pages(lmp_, parent_->dnum(), std::string("wall/gran ") + parent_->id + ": a contact with the mesh");
    forget_opened();
  }
  // While the foot of a sphere lies within the mesh's precision (1e-8) of an edge, both coplanar triangles claim it if
  // it comes from the one with the higher number, and the stock wall lets both push. Here the second only takes over
  // the history, in case the sphere turns back. Contacts at different points, as with two edges of a hole, all push.
  void compute_force(FixWallGran *wall, SurfacesIntersectData &data, bool intersects, double *velocity,
                     FixMeshSurface *fix_mesh, int number, TriMesh *mesh, int triangle) {
    if (mesh && intersects) {
      const size_t i = data.i;
      if (step_ != lmp_->update->ntimestep || mesh_ != number || triangle < triangle_) contacts_.clear();
      step_ = lmp_->update->ntimestep;
      mesh_ = number;
      triangle_ = triangle;
      if (newest_.size() <= i) newest_.resize(lmp_->atom->nmax + 1, none());
      for (size_t n = newest_[i]; n < contacts_.size() && contacts_[n].particle == i; n = contacts_[n].earlier) {
        if (contacts_[n].triangle == triangle) { // the forces of this step once more
          contacts_.clear();
          break;
        }
        if (!same(mesh, contacts_[n], triangle, data.delta)) continue;
        if (wall->dnum() > 0)
          std::copy(contacts_[n].history, contacts_[n].history + wall->dnum(), data.contact_history);
        return;
      }
      const bool first = newest_[i] >= contacts_.size() || contacts_[newest_[i]].particle != i;
      const Contact contact = {i,
                               first ? none() : newest_[i],
                               triangle,
                               data.contact_history,
                               {data.delta[0], data.delta[1], data.delta[2]}};
      newest_[i] = contacts_.size();
      contacts_.push_back(contact);
    }
    Walls::Granular<MODEL>::compute_force(wall, data, intersects, velocity, fix_mesh, number, mesh, triangle);
  }

private:
  struct Contact {
    size_t particle, earlier;
    int triangle;
    double *history;
    double delta[3]; // from the contact point to the centre
  };
  static size_t none() { return (size_t)-1; }
  // A primitive wall tests the particles near it only: the history of one that was put elsewhere between two runs
  // (displace_atoms, set) would wait there for it to come back.
  void forget_opened() {
    if (parent_->is_mesh_wall() || parent_->dnum() == 0) return;
    Fix *const kept = lmp_->modify->find_fix_id((std::string("history_") + parent_->id).c_str());
    PrimitiveWall *const wall = parent_->primitiveWall();
    if (!kept || !kept->array_atom || !wall) return;
    double delta[3];
    for (int i = 0; i < lmp_->atom->nlocal; i++) {
      double *const history = kept->array_atom[i];
      if (std::count(history, history + parent_->dnum(), 0.) < parent_->dnum() &&
          wall->resolveContact(lmp_->atom->x[i], lmp_->atom->radius[i], delta) > 0.)
        std::fill(history, history + parent_->dnum(), 0.);
    }
  }
  // Whether two triangles that the mesh takes for one plane touch the sphere at the same point: within the mesh's
  // precision, or both at the foot of the perpendicular, which two planes a hair apart do not have quite in common.
  static bool same(TriMesh *mesh, const Contact &other, int triangle, const double *delta) {
    const double near = Precision::of(mesh);
    double apart = 0.;
    for (int k = 0; k < 3; k++) apart += (other.delta[k] - delta[k]) * (other.delta[k] - delta[k]);
    if (apart > near * near &&
        !(at_foot(mesh, triangle, delta, near) && at_foot(mesh, other.triangle, other.delta, near)))
      return false;
    return mesh->areCoplanarNodeNeighs(mesh->id(triangle), mesh->id(other.triangle));
  }
  static bool at_foot(TriMesh *mesh, int triangle, const double *delta, double near) {
    double normal[3], aside[3];
    mesh->surfaceNorm(triangle, normal);
    vectorCross3D(delta, normal, aside);
    return vectorMag3DSquared(aside) <= near * near;
  }
  // protected in the mesh: a name for it in a class derived from it
  struct Precision : TriMesh {
    static double of(TriMesh *mesh) { return (mesh->*&Precision::precision)(); }
  };

  LAMMPS *const lmp_;
  FixWallGran *const parent_;
  const std::shared_ptr<Instance> instance_;
  bigint step_;
  int mesh_, triangle_;
  std::vector<Contact> contacts_; // of this step, as far as they push
  std::vector<size_t> newest_;    // the last of them for each sphere; stale where it names another sphere
};

} // namespace demlaws
#endif
