// The pair style: LIGGGHTS's side of particle contacts.
#ifndef DEMLAWS_PAIR_STYLE_H
#define DEMLAWS_PAIR_STYLE_H
#include "stock.h"

#include "arguments.h"
#include "contact_models.h"
#include "energy.h"
#include <cfloat>
#include <cmath>

namespace demlaws {
using namespace LIGGGHTS;
using namespace LIGGGHTS::ContactModels;

// The pair loop: as the stock loop for spheres, in two passes. The first finds the touching neighbours without a
// branch for each (whether a neighbour touches is what the processor cannot predict); the second computes the contacts.
// A contact that opens is seen by its flag, so its history starts from zeros whatever contact_distance_factor is.
template <class MODEL> class PairStyle : public PairStyles::IGranularPairStyle, public EnergySource, private Pointers {
public:
  PairStyle(LAMMPS *lmp, PairGran *parent, const int64_t hash)
      : Pointers(lmp), model_(lmp, parent, false, hash), parent_(parent) {
    model_.normal.instance().source = this;
    register_styles(modify);
  }
  ~PairStyle() {
    Instance &instance = model_.normal.instance();
    if (instance.source == this) instance.source = NULL;
  }
  int64_t hashcode() { return model_.hashcode(); }
  void settings(int count, char **arguments, IContactHistorySetup *setup) {
    Arguments own(lmp, count, arguments);
    Settings settings(lmp);
    model_.registerSettings(settings);
    const bool good = settings.parseArguments(count, arguments);
    if (!good) error->all(FLERR, settings.error_message.c_str());
    if (domain->box_exist) ensure_fix(modify); // before LIGGGHTS reads the contacts of a restart file
    model_.postSettings(setup);
  }
  void init_granular() {
    ensure_fix(modify);
    if (modify->n_fixes_style("insert/stream/predefined") > 0)
      error->all(FLERR,
                 "model demlaws/table: fix insert/stream/predefined, which brings histories along, is not supported");
    model_.connectToProperties(force->registry);
  }
  void write_restart_settings(FILE *file) {
    int64_t hash = model_.hashcode();
    fwrite(&hash, sizeof hash, 1, file);
  }
  void read_restart_settings(FILE *file, int64_t hash) {
    if (comm->me != 0) return;
    int64_t stored = -1;
    if (fread(&stored, sizeof stored, 1, file) != 1 || (hash != -1 ? hash : stored) != model_.hashcode())
      error->one(FLERR, "model demlaws/table: the restart file was written with other contact models");
  }
  bool contact_match(const std::string kind, const std::string name) { return model_.contact_match(kind, name); }
  int get_history_offset(const std::string name) { return model_.get_history_offset(name); }
  double stressStrainExponent() { return model_.stressStrainExponent(); }

  void compute_force(PairGran *parent, int eflag, int vflag, int addflag) {
    if (eflag || vflag) parent->ev_setup(eflag, vflag);
    else parent->evflag = parent->vflag_fdotr = 0;
    if (parent->storeSumDelta()) error->all(FLERR, "model demlaws/table: multicontact models are not supported");
    memset(static_cast<void *>(&data_), 0, sizeof data_);
    data_.area_ratio = 1.;
    data_.computeflag = parent->computeflag();
    data_.shearupdate = parent->shearupdate();

    double *const *const x = atom->x;
    const double *const radius = atom->radius;
    const int listed = parent->list->inum;
    const int *const list = parent->list->ilist, *const neighbours = parent->list->numneigh;
    int *const *const first = parent->list->firstneigh;
    int *const *const all_flags = parent->listgranhistory ? parent->listgranhistory->firstneigh : NULL;
    double *const *const all_history = parent->listgranhistory ? parent->listgranhistory->firstdouble : NULL;
    const int size = parent->dnum();
    const bool slow = (parent->cpl() && addflag) || parent->evflag || parent->storeContactForces() ||
                      parent->storeContactForcesStress() || parent->store_sum_normal_force();

    touches_.resize(BLOCK);
    size_t count = 0;
    for (int ii = 0; ii < listed; ii++) {
      const int i = list[ii], length = neighbours[i];
      if (count + length > touches_.size()) {
        contacts(parent, count, slow, addflag, all_flags, all_history, size);
        count = 0;
        if ((size_t)length > touches_.size()) touches_.resize(2 * length);
      }
      const double xi = x[i][0], yi = x[i][1], zi = x[i][2], ri = radius[i];
      if (__builtin_expect(!(fabs(xi + yi + zi) <= DBL_MAX), 0)) refuse_position(i);
      const int *const partners = first[i];
      int *const flags = all_flags ? all_flags[i] : NULL;
      Touch *const into = &touches_[0];
      for (int jj = 0; jj < length; jj++) {
        const int j = partners[jj] & NEIGHMASK;
        const double *const xj = x[j];
        const double dx = xi - xj[0], dy = yi - xj[1], dz = zi - xj[2], sum = ri + radius[j];
        const double squared = dx * dx + dy * dy + dz * dz;
        const bool touching = squared < sum * sum;
        Touch &touch = into[count];
        touch.i = i;
        touch.j = j;
        touch.jj = jj;
        touch.delta[0] = dx;
        touch.delta[1] = dy;
        touch.delta[2] = dz;
        touch.squared = squared;
        count += touching;
        // a mask, since a branch on `touching` could not be predicted
        if (flags && __builtin_expect(flags[jj] & MODELS & ((int)touching - 1), 0))
          opened(i, j, squared, &flags[jj], &all_history[i][size * jj]);
      }
    }
    contacts(parent, count, slow, addflag, all_flags, all_history, size);
    if (parent->cpl() && addflag) parent->cpl_pair_finalize();
    if (parent->storeContactForces()) parent->fix_contact_forces()->do_forward_comm();
    if (parent->storeContactForcesStress()) parent->fix_contact_forces_stress()->do_forward_comm();
  }

  void energies(double &stored, double &dissipated) {
    const NeighList *const list = parent_->list;
    if (!list) return;
    const NeighList *const past = parent_->listgranhistory;
    double **const x = atom->x;
    for (int ii = 0; ii < list->inum; ii++) {
      const int i = list->ilist[ii];
      for (int jj = 0; jj < list->numneigh[i]; jj++) {
        const int j = list->firstneigh[i][jj] & NEIGHMASK;
        // with newton off the other rank, too, has a pair that lies across the border
        const double share = j < atom->nlocal || force->newton_pair ? 1. : 0.5;
        SurfacesCloseData data = bodies(i, j);
        double apart[3];
        vectorSubtract3D(x[i], x[j], apart);
        const double overlap = data.radsum - vectorMag3D(apart);
        if (!(overlap > 0.)) continue;
        data.contact_history = past ? &past->firstdouble[i][parent_->dnum() * jj] : NULL;
        double s, d;
        model_.energies(data, overlap, s, d);
        stored += share * s;
        dissipated += share * d;
      }
    }
  }

private:
  SurfacesCloseData bodies(int i, int j) const {
    SurfacesCloseData data;
    data.i = i;
    data.j = j;
    data.radi = atom->radius[i];
    data.radj = atom->radius[j];
    data.radsum = data.radi + data.radj;
    data.itype = atom->type[i];
    data.jtype = atom->type[j];
    data.is_wall = false;
    return data;
  }
  static const size_t BLOCK = 512;
  static const int MODELS = CONTACT_NORMAL_MODEL | CONTACT_COHESION_MODEL | CONTACT_TANGENTIAL_MODEL |
                            CONTACT_ROLLING_MODEL | CONTACT_SURFACE_MODEL;
  struct Touch {
    double delta[3], squared;
    int i, j, jj, pad;
  };
  MODEL model_;
  PairGran *const parent_;
  SurfacesIntersectData data_;
  std::vector<Touch> touches_;

  // A position that is not finite touches nothing: without this the particle would drop out of the model silently.
  __attribute__((noinline, cold)) void refuse_position(int i) const {
    const double *const x = atom->x[i], *const v = atom->v[i];
    std::ostringstream what;
    what << "model demlaws/table: particle " << atom->tag[i] << " is at (" << x[0] << ", " << x[1] << ", " << x[2]
         << ") m with velocity (" << v[0] << ", " << v[1] << ", " << v[2]
         << ") m/s, which is not finite; take a smaller time step, look at what was done to this particle";
    error->one(FLERR, what.str().c_str());
  }
  __attribute__((noinline, cold)) void opened(int i, int j, double squared, int *flags, double *history) {
    SurfacesCloseData data = bodies(i, j);
    data.rsq = squared;
    data.contact_flags = flags;
    data.contact_history = history;
    data.computeflag = data_.computeflag;
    data.shearupdate = data_.shearupdate;
    ForceData on_i, on_j;
    model_.surfacesClose(data, on_i, on_j);
  }

  __attribute__((flatten)) void contacts(PairGran *parent, size_t count, bool slow, int addflag, int *const *all_flags,
                                         double *const *all_history, int size) {
    double *const *const v = atom->v, *const *const omega = atom->omega;
    double *const *const f = atom->f, *const *const torque = atom->torque;
    const double *const radius = atom->radius, *const rmass = atom->rmass, *const mass = atom->mass;
    const double *const rigid = parent->fr_pair() ? parent->mr_pair() : NULL;
    const int *const type = atom->type, *const mask = atom->mask;
    const int local = force->newton_pair ? atom->nlocal + atom->nghost : atom->nlocal;
    const int frozen = parent->freeze_group_bit();
    const bool apply = data_.computeflag;
    SurfacesIntersectData data = data_;
    for (size_t n = 0; n < count; n++) {
      const Touch &touch = touches_[n];
      const int i = touch.i, j = touch.j;
      data.i = i;
      data.j = j;
      data.radi = radius[i];
      data.radj = radius[j];
      data.radsum = data.radi + data.radj;
      data.rsq = touch.squared;
      data.contact_flags = all_flags ? &all_flags[i][touch.jj] : NULL;
      data.contact_history = all_history ? &all_history[i][size * touch.jj] : NULL;
      data.v_i = v[i];
      data.v_j = v[j];
      data.omega_i = omega[i];
      data.omega_j = omega[j];
      data.itype = type[i];
      data.jtype = type[j];
      double mi = rmass ? rmass[i] : mass[data.itype], mj = rmass ? rmass[j] : mass[data.jtype];
      if (rigid) {
        if (rigid[i] > 0.) mi = rigid[i];
        if (rigid[j] > 0.) mj = rigid[j];
      }
      double reduced = mi * mj / (mi + mj);
      if (mask[i] & frozen) reduced = mj;
      if (mask[j] & frozen) reduced = mi;
      data.mi = mi;
      data.mj = mj;
      data.meff = reduced;
      const double r = sqrt(touch.squared), inverse = 1. / r;
      data.r = r;
      data.rinv = inverse;
      for (int k = 0; k < 3; k++) {
        data.delta[k] = touch.delta[k];
        data.en[k] = touch.delta[k] * inverse;
      }
      ForceData on_i, on_j;
      model_.template touch<false>(data, on_i, on_j);
      if (apply) {
        add(parent->relax(i), f[i], torque[i], on_i);
        if (j < local) add(parent->relax(j), f[j], torque[j], on_j);
      }
      if (__builtin_expect(slow, 0)) record(parent, data, on_i, on_j, addflag);
    }
  }

  static inline void add(double relax, double *f, double *torque, const ForceData &force) {
    for (int k = 0; k < 3; k++) {
      f[k] += relax * force.delta_F[k];
      torque[k] += relax * force.delta_torque[k];
    }
  }

  // What other parts of LIGGGHTS want to know about a contact. The stored energy is tallied as the pair energy (compute
  // pe).
  __attribute__((noinline)) void record(PairGran *parent, SurfacesIntersectData data, ForceData on_i, ForceData on_j,
                                        int addflag) {
    const int i = data.i, j = data.j, *const tag = atom->tag;
    if (data.computeflag && parent->store_sum_normal_force()) {
      const double along = vectorDot3D(on_i.delta_F, data.en);
      *parent->get_sum_normal_force_ptr(i) += along;
      if (j < atom->nlocal || force->newton_pair) *parent->get_sum_normal_force_ptr(j) += along;
    }
    if (parent->cpl() && addflag) parent->cpl_add_pair(data, on_i);
    if (parent->evflag) {
      double stored = 0., dissipated = 0.;
      if (parent->eflag_either) model_.energies(data, data.deltan, stored, dissipated);
      parent->ev_tally_xyz(i, j, atom->nlocal, force->newton_pair, stored, 0., on_i.delta_F[0], on_i.delta_F[1],
                           on_i.delta_F[2], data.delta[0], data.delta[1], data.delta[2]);
    }
    const ForceData *const on[2] = {&on_i, &on_j};
    const int bodies[2] = {i, j};
    for (int side = 0; side < 2; side++) {
      const int one = bodies[side], other = bodies[1 - side];
      const double *const f = on[side]->delta_F, *const torque = on[side]->delta_torque;
      double forces[6] = {f[0], f[1], f[2], torque[0], torque[1], torque[2]};
      if (parent->storeContactForces() && update->ntimestep % parent->storeContactForcesEvery() == 0 &&
          parent->fix_contact_forces()->has_partner(one, tag[other]) == -1)
        parent->fix_contact_forces()->add_partner(one, tag[other], forces);
      forces[3] = (double)other;
      if (parent->storeContactForcesStress() && parent->fix_contact_forces_stress()->has_partner(one, tag[other]) == -1)
        parent->fix_contact_forces_stress()->add_partner(one, tag[other], forces);
    }
  }
};

} // namespace demlaws
#endif
