// Plugin for the stock LIGGGHTS 3.8.0: LD_PRELOAD=libdemlaws_liggghts.so liggghts -in in.case
// Adds the normal model `demlaws/table` for particle pairs, primitive walls and mesh walls.
#include <mpi.h>
#include <cfloat>
#include <cmath>
#include <cstring>
#include "lammps.h"
#include "pointers.h"
#include "memory.h"
#include "compute.h"
#include "error.h"
#include "atom.h"
#include "comm.h"
#include "force.h"
#include "update.h"
#include "modify.h"
#include "domain.h"
#include "neighbor.h"
#include "neigh_list.h"
#include "pair.h"
#include "fix_insert_stream.h"
#include "fix_insert_stream_predefined.h"
#include "granular_pair_style.h"
#include "granular_wall.h"
#include "contact_models.h"
#include "normal_model_demlaws.h"
#include "fix_wall_gran_base.h"

namespace demlaws {
using namespace LAMMPS_NS;
using namespace LIGGGHTS;
using namespace LIGGGHTS::ContactModels;

// The sub-models of one contact, composed when compiled, as the stock ContactModel is; cohesion is off.
template <int TANGENTIAL, int ROLLING> class Model : public ContactModelBase {
public:
  SurfaceModel<SURFACE_DEFAULT> surface;
  NormalModel<DEMLAWS_TABLE> normal;
  TangentialModel<TANGENTIAL> tangential;
  RollingModel<ROLLING> rolling;

  // the order of the members is the order in which they claim history
  Model(LAMMPS *lmp, IContactHistorySetup *setup, bool wall, const int64_t)
      : ContactModelBase(lmp, wall), surface(lmp, setup, this), normal(lmp, setup, this), tangential(lmp, setup, this),
        rolling(lmp, setup, this) {}
  int64_t hashcode() { return Utils::generate_gran_hashcode(DEMLAWS_TABLE, TANGENTIAL, COHESION_OFF, ROLLING, SURFACE_DEFAULT); }
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
    surface.connectToProperties(p);
    normal.connectToProperties(p);
    tangential.connectToProperties(p);
    rolling.connectToProperties(p);
  }
  void beginPass(SurfacesIntersectData &d, ForceData &i, ForceData &j) {
    surface.beginPass(d, i, j);
    normal.beginPass(d, i, j);
    tangential.beginPass(d, i, j);
    rolling.beginPass(d, i, j);
  }
  void endPass(SurfacesIntersectData &d, ForceData &i, ForceData &j) {
    rolling.endPass(d, i, j);
    tangential.endPass(d, i, j);
    normal.endPass(d, i, j);
    surface.endPass(d, i, j);
  }
  double stressStrainExponent() { return normal.stressStrainExponent(); }
  void tally_pp(double value, int i, int j, int index) { surface.tally_pp(value, i, j, index); }
  void tally_pw(double value, int i, int j, int index) { surface.tally_pw(value, i, j, index); }
  bool checkSurfaceIntersect(SurfacesIntersectData &d) { return surface.checkSurfaceIntersect(d); }
  inline void surfacesIntersect(SurfacesIntersectData &d, ForceData &i, ForceData &j) {
    surface.surfacesIntersect(d, i, j);
    normal.surfacesIntersect(d, i, j);
    tangential.surfacesIntersect(d, i, j);
    rolling.surfacesIntersect(d, i, j);
  }
  inline void pairsIntersect(SurfacesIntersectData &d, ForceData &i, ForceData &j) {
    surface.surfacesIntersect(d, i, j);
    normal.template touch<false>(d, i, j);
    tangential.surfacesIntersect(d, i, j);
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
  bool contact_match(const std::string kind, const std::string name) {
    Factory &known = Factory::instance();
    if (kind == "surface") return known.getSurfaceModelId(name) == SURFACE_DEFAULT;
    if (kind == "normal") return known.getNormalModelId(name) == DEMLAWS_TABLE;
    if (kind == "cohesion") return known.getCohesionModelId(name) == COHESION_OFF;
    if (kind == "tangential") return known.getTangentialModelId(name) == TANGENTIAL;
    if (kind == "rolling_friction") return known.getRollingModelId(name) == ROLLING;
    return false;
  }
};

// Takes 'table FILE' and 'pairtable I J FILE' out of the arguments: the stock Settings know no strings.
class Arguments {
public:
  Arguments(LAMMPS *lmp, int &count, char **&arguments) {
    Files &files = Pending::now();
    files.clear();
    for (int i = 0; i < count; i++) {
      if (!strcmp(arguments[i], "table")) {
        if (i + 1 >= count) lmp->error->all(FLERR, "model demlaws/table: 'table' needs a file name");
        files[std::make_pair(0, 0)] = arguments[++i];
      } else if (!strcmp(arguments[i], "pairtable")) {
        if (i + 3 >= count) lmp->error->all(FLERR, "model demlaws/table: 'pairtable' needs two types and a file name");
        const int a = type(lmp, arguments[i + 1]), b = type(lmp, arguments[i + 2]);
        files[std::make_pair(a, b)] = arguments[i + 3];
        i += 3;
      } else
        kept_.push_back(arguments[i]);
    }
    count = (int)kept_.size();
    kept_.push_back(NULL);
    arguments = &kept_[0];
  }
  ~Arguments() { Pending::now().clear(); }

private:
  static int type(LAMMPS *lmp, const char *text) {
    char *end;
    const long value = strtol(text, &end, 10);
    if (*end || value < 1 || value > lmp->atom->ntypes)
      lmp->error->all(FLERR, (std::string("model demlaws/table: 'pairtable' names type ") + text +
                              ", which the simulation box does not have").c_str());
    return (int)value;
  }
  std::vector<char *> kept_;
};

// compute ID GROUP demlaws/energy: what the contacts of this model hold and what their plastic flow took, [1] and [2] [J],
// pairs and walls.
struct EnergySource {
  virtual ~EnergySource() {}
  virtual void energies(double &stored, double &dissipated) = 0; // of this rank; a pair across ranks counts half
  static EnergySource *&of(LAMMPS *lmp) {
    static std::map<LAMMPS *, EnergySource *> sources;
    return sources[lmp];
  }
};

class ComputeEnergy : public Compute {
public:
  ComputeEnergy(LAMMPS *lmp, int &iarg, int narg, char **arg) : Compute(lmp, iarg, narg, arg) {
    if (iarg != narg) error->all(FLERR, "compute demlaws/energy takes no arguments");
    vector_flag = 1;
    size_vector = 2;
    extvector = 1;
    vector = new double[2]();
    Ledger::of(lmp).readers++;
  }
  ~ComputeEnergy() {
    Ledger::of(lmp).readers--;
    delete[] vector;
  }
  void init() {
    if (!EnergySource::of(lmp)) error->all(FLERR, "compute demlaws/energy needs pair_style gran model demlaws/table");
  }
  void compute_vector() {
    invoked_vector = update->ntimestep;
    double mine[2] = {0., 0.};
    EnergySource::of(lmp)->energies(mine[0], mine[1]);
    MPI_Allreduce(mine, vector, 2, MPI_DOUBLE, MPI_SUM, world);
  }
  static Compute *create(LAMMPS *lmp, int iarg, int narg, char **arg) { return new ComputeEnergy(lmp, iarg, narg, arg); }
};

// Modify::compute_map, where a style is registered at run time, is private; an explicit instantiation may name it.
struct ComputeMap {
  typedef std::map<std::string, Compute *(*)(LAMMPS *, int, int, char **)> *Modify::*type;
  friend type get(ComputeMap);
};
template <class TAG, typename TAG::type MEMBER> struct Access {
  friend typename TAG::type get(TAG) { return MEMBER; }
};
template struct Access<ComputeMap, &Modify::compute_map>;
struct FixMap {
  typedef std::map<std::string, Fix *(*)(LAMMPS *, int, char **)> *Modify::*type;
  friend type get(FixMap);
};
template struct Access<FixMap, &Modify::fix_map>;

// Takes the ledger's sum through restart files. The pair style makes it; there is one.
class FixEnergy : public Fix {
public:
  FixEnergy(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg), ledger_(Ledger::of(lmp)) {
    restart_global = 1;
    ledger_.taken = 0.;
  }
  ~FixEnergy() { ledger_.taken = 0.; }
  int setmask() { return FixConst::PRE_FORCE; }
  void setup_pre_force(int vflag) { pre_force(vflag); }
  void pre_force(int) {
    for (std::set<WallBook *>::iterator it = ledger_.walls.begin(); it != ledger_.walls.end(); ++it) (*it)->forget();
  }
  void write_restart(FILE *file) {
    double sum = 0.;
    MPI_Reduce(&ledger_.taken, &sum, 1, MPI_DOUBLE, MPI_SUM, 0, world);
    if (comm->me != 0) return;
    const int size = sizeof sum;
    fwrite(&size, sizeof size, 1, file);
    fwrite(&sum, sizeof sum, 1, file);
  }
  void restart(char *data) {
    if (comm->me == 0) memcpy(&ledger_.taken, data, sizeof ledger_.taken);
  }
  static Fix *create(LAMMPS *lmp, int narg, char **arg) { return new FixEnergy(lmp, narg, arg); }
  static void ensure(Modify *modify) {
    if (modify->find_fix_style_strict(name(), 0)) return;
    const char *words[] = {"demlaws_energy", "all", name()};
    modify->add_fix(3, const_cast<char **>(words));
  }
  static const char *name() { return "demlaws/energy"; }

private:
  Ledger &ledger_;
};

// The pair loop: what the stock loop does for spheres, in two passes. The first finds the touching neighbours without a
// branch for each (whether a neighbour touches is what the processor cannot predict); the second computes the contacts.
// A contact that opens is seen by its flag, so its history starts anew whatever contact_distance_factor is.
template <class MODEL> class PairStyle : public PairStyles::IGranularPairStyle, public EnergySource, private Pointers {
public:
  PairStyle(LAMMPS *lmp, PairGran *parent, const int64_t hash)
      : Pointers(lmp), model_(lmp, parent, false, hash), parent_(parent) {
    EnergySource::of(lmp) = this;
    ((*modify).*get(ComputeMap()))->operator[](FixEnergy::name()) = &ComputeEnergy::create;
    ((*modify).*get(FixMap()))->operator[](FixEnergy::name()) = &FixEnergy::create;
  }
  ~PairStyle() {
    if (EnergySource::of(lmp) == this) EnergySource::of(lmp) = NULL;
  }
  int64_t hashcode() { return model_.hashcode(); }
  void settings(int count, char **arguments, IContactHistorySetup *setup) {
    Arguments own(lmp, count, arguments);
    Settings settings(lmp);
    model_.registerSettings(settings);
    const bool good = settings.parseArguments(count, arguments);
    if (!good) error->all(FLERR, settings.error_message.c_str());
    model_.postSettings(setup);
  }
  void init_granular() {
    model_.connectToProperties(force->registry);
    FixEnergy::ensure(modify); // here what a restart file holds for it is still there
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
    std::vector<FixInsertStreamPredefined *> inserted;
    const int streams = modify->n_fixes_style("insert/stream/predefined");
    for (int i = 0; i < streams; i++) {
      FixInsertStreamPredefined *fix =
          static_cast<FixInsertStreamPredefined *>(modify->find_fix_style("insert/stream/predefined", i));
      if (fix->has_inserted()) inserted.push_back(fix);
    }
    memset(&data_, 0, sizeof data_);
    data_.area_ratio = 1.;
    data_.computeflag = parent->computeflag();
    data_.shearupdate = parent->shearupdate();
    ForceData on_i, on_j;
    model_.beginPass(data_, on_i, on_j);

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
        if (__builtin_expect(!inserted.empty(), 0))
          for (size_t k = 0; k < inserted.size(); k++)
            inserted[k]->copy_history(i, j, all_history ? &all_history[i][size * jj] : NULL);
        if (flags && __builtin_expect(!touching && (flags[jj] & MODELS), 0))
          opened(i, j, squared, &flags[jj], &all_history[i][size * jj]);
      }
    }
    contacts(parent, count, slow, addflag, all_flags, all_history, size);
    model_.endPass(data_, on_i, on_j);
    if (parent->cpl() && addflag) parent->cpl_pair_finalize();
    if (parent->storeContactForces()) parent->fix_contact_forces()->do_forward_comm();
    if (parent->storeContactForcesStress()) parent->fix_contact_forces_stress()->do_forward_comm();
  }

  void energies(double &stored, double &dissipated) {
    const Ledger &ledger = Ledger::of(lmp);
    stored = 0.;
    dissipated = ledger.taken;
    for (std::set<WallBook *>::const_iterator it = ledger.walls.begin(); it != ledger.walls.end(); ++it)
      stored += (*it)->stored();
    const NeighList *const list = parent_->list;
    if (!list) return;
    const NeighList *const past = parent_->listgranhistory;
    double **const x = atom->x;
    SurfacesCloseData data;
    for (int ii = 0; ii < list->inum; ii++) {
      data.i = list->ilist[ii];
      for (int jj = 0; jj < list->numneigh[data.i]; jj++) {
        data.j = list->firstneigh[data.i][jj] & NEIGHMASK;
        data.radi = atom->radius[data.i];
        data.radj = atom->radius[data.j];
        const double overlap = data.radi + data.radj - sqrt(distance(x[data.i], x[data.j]));
        if (!(overlap > 0.)) continue;
        data.itype = atom->type[data.i];
        data.jtype = atom->type[data.j];
        data.contact_history = past ? &past->firstdouble[data.i][parent_->dnum() * jj] : NULL;
        double s, d;
        model_.normal.energies(data, overlap, s, d);
        const double share = data.j < atom->nlocal || force->newton_pair ? 1. : 0.5;
        stored += share * s;
        dissipated += share * d;
      }
    }
  }

private:
  static double distance(const double *a, const double *b) {
    return (a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]);
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

  // A position that is no number touches nothing: without this the particle would drop out of the model silently.
  __attribute__((noinline, cold)) void refuse_position(int i) const {
    const double *const x = atom->x[i], *const v = atom->v[i];
    std::ostringstream what;
    what << "model demlaws/table: particle " << atom->tag[i] << " is at (" << x[0] << ", " << x[1] << ", " << x[2]
         << ") m with velocity (" << v[0] << ", " << v[1] << ", " << v[2]
         << ") m/s, which is not finite; take a smaller time step, look at what was done to this particle";
    error->one(FLERR, what.str().c_str());
  }
  __attribute__((noinline, cold)) void opened(int i, int j, double squared, int *flags, double *history) {
    SurfacesCloseData data;
    data.i = i;
    data.j = j;
    data.radi = atom->radius[i];
    data.radj = atom->radius[j];
    data.radsum = data.radi + data.radj;
    data.rsq = squared;
    data.itype = atom->type[i];
    data.jtype = atom->type[j];
    data.contact_flags = flags;
    data.contact_history = history;
    data.computeflag = data_.computeflag;
    data.shearupdate = data_.shearupdate;
    ForceData on_i, on_j;
    model_.surfacesClose(data, on_i, on_j);
  }

  __attribute__((flatten)) void contacts(PairGran *parent, size_t count, bool slow, int addflag, int *const *all_flags, double *const *all_history,
                int size) {
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
      data.delta[0] = touch.delta[0];
      data.delta[1] = touch.delta[1];
      data.delta[2] = touch.delta[2];
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
      data.en[0] = touch.delta[0] * inverse;
      data.en[1] = touch.delta[1] * inverse;
      data.en[2] = touch.delta[2] * inverse;
      ForceData on_i, on_j;
      model_.pairsIntersect(data, on_i, on_j);
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

  // What other parts of LIGGGHTS want to know about a contact. The stored energy is tallied as the pair energy (compute pe).
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
      if (parent->eflag_either) model_.normal.energies(data, data.deltan, stored, dissipated);
      parent->ev_tally_xyz(i, j, atom->nlocal, force->newton_pair, stored, 0., on_i.delta_F[0], on_i.delta_F[1],
                           on_i.delta_F[2], data.delta[0], data.delta[1], data.delta[2]);
    }
    if (parent->storeContactForces() && update->ntimestep % parent->storeContactForcesEvery() == 0) {
      double forces[6];
      if (parent->fix_contact_forces()->has_partner(i, tag[j]) == -1) {
        vectorCopy3D(on_i.delta_F, forces);
        vectorCopy3D(on_i.delta_torque, forces + 3);
        parent->fix_contact_forces()->add_partner(i, tag[j], forces);
      }
      if (parent->fix_contact_forces()->has_partner(j, tag[i]) == -1) {
        vectorCopy3D(on_j.delta_F, forces);
        vectorCopy3D(on_j.delta_torque, forces + 3);
        parent->fix_contact_forces()->add_partner(j, tag[i], forces);
      }
    }
    if (parent->storeContactForcesStress()) {
      double forces[4];
      if (parent->fix_contact_forces_stress()->has_partner(i, tag[j]) == -1) {
        vectorCopy3D(on_i.delta_F, forces);
        forces[3] = (double)j;
        parent->fix_contact_forces_stress()->add_partner(i, tag[j], forces);
      }
      if (parent->fix_contact_forces_stress()->has_partner(j, tag[i]) == -1) {
        vectorCopy3D(on_j.delta_F, forces);
        forces[3] = (double)i;
        parent->fix_contact_forces_stress()->add_partner(j, tag[i], forces);
      }
    }
  }
};

template <class MODEL> class WallStyle : public Walls::Granular<MODEL> {
  LAMMPS *const lmp_;

public:
  WallStyle(LAMMPS *lmp, FixWallGran *parent, const int64_t hash)
      : Walls::Granular<MODEL>(lmp, parent, hash), lmp_(lmp), step_(-1), mesh_(-1), triangle_(-1) {}
  // Within some 1e-8 m of an edge both coplanar triangles claim a sphere that comes from the one with the higher number,
  // and the stock wall lets both push. Here the second only takes over the history, in case the sphere turns back.
  void compute_force(FixWallGran *wall, SurfacesIntersectData &data, bool intersects, double *velocity,
                     FixMeshSurface *fix_mesh, int number, TriMesh *mesh, int triangle) {
    if (mesh && intersects) {
      const size_t i = data.i;
      if (step_ != lmp_->update->ntimestep || mesh_ != number || triangle < triangle_) faces_.clear();
      step_ = lmp_->update->ntimestep;
      mesh_ = number;
      triangle_ = triangle;
      if (newest_.size() <= i) newest_.resize(lmp_->atom->nmax + 1, none());
      size_t n = newest_[i];
      for (; n < faces_.size() && faces_[n].particle == i; n = faces_[n].earlier) {
        if (faces_[n].triangle == triangle) { // the forces of this step once more
          faces_.clear();
          break;
        }
        if (!mesh->areCoplanarNodeNeighs(mesh->id(triangle), mesh->id(faces_[n].triangle))) continue;
        if (wall->dnum() > 0) std::copy(faces_[n].history, faces_[n].history + wall->dnum(), data.contact_history);
        return;
      }
      const bool first = newest_[i] >= faces_.size() || faces_[newest_[i]].particle != i;
      const Face face = {i, first ? none() : newest_[i], triangle, data.contact_history};
      newest_[i] = faces_.size();
      faces_.push_back(face);
    }
    Walls::Granular<MODEL>::compute_force(wall, data, intersects, velocity, fix_mesh, number, mesh, triangle);
  }
  void settings(int count, char **arguments, IContactHistorySetup *setup) {
    Arguments own(lmp_, count, arguments);
    Walls::Granular<MODEL>::settings(count, arguments, setup);
  }

private:
  static size_t none() { return (size_t)-1; }
  struct Face {
    size_t particle, earlier;
    int triangle;
    double *history;
  };
  bigint step_;
  int mesh_, triangle_;
  std::vector<Face> faces_;    // the triangles that pushed a sphere in this step
  std::vector<size_t> newest_; // the last of them for each sphere; stale where it names another sphere
};

template <class MODEL> PairStyles::IGranularPairStyle *make_pair_style(LAMMPS *lmp, PairGran *parent, const int64_t hash) {
  return new PairStyle<MODEL>(lmp, parent, hash);
}
template <class MODEL> Walls::IGranularWall *make_wall(LAMMPS *lmp, FixWallGran *parent, const int64_t hash) {
  return new WallStyle<MODEL>(lmp, parent, hash);
}

// Combinations with a stock model that demlaws/table does not go with: named when a case asks for one.
static void refuse(LAMMPS *lmp, int64_t hash) {
  static const struct {
    int shift, id;
    const char *name;
  } others[] = {{6, 4, "tangential tan_luding"}, {12, 1, "cohesion sjkr"}, {12, 2, "cohesion sjkr2"},
                {12, 7, "cohesion washino/capillary/viscous"}, {12, 8, "cohesion easo/capillary/viscous"},
                {18, 4, "rolling_friction epsd3"}, {18, 6, "rolling_friction luding"}, {24, 2, "surface multicontact"},
                {24, 5, "surface superquadric"}};
  std::string what = "model demlaws/table does not work with";
  const char *separator = " ";
  for (size_t k = 0; k < sizeof others / sizeof *others; k++)
    if (((hash >> others[k].shift) & 63) == others[k].id) {
      what += separator + std::string(others[k].name);
      separator = ", ";
    }
  what += "; it has tangential off, no_history, history, rolling_friction off, cdt, epsd, epsd2, cohesion off, surface default";
  lmp->error->all(FLERR, what.c_str());
}
static PairStyles::IGranularPairStyle *refuse_pair_style(LAMMPS *lmp, PairGran *, const int64_t hash) {
  refuse(lmp, hash);
  return NULL;
}
static Walls::IGranularWall *refuse_wall(LAMMPS *lmp, FixWallGran *, const int64_t hash) {
  refuse(lmp, hash);
  return NULL;
}

struct Registration {
  template <int TANGENTIAL, int ROLLING> static void add() {
    const int64_t hash = Utils::generate_gran_hashcode(DEMLAWS_TABLE, TANGENTIAL, COHESION_OFF, ROLLING, SURFACE_DEFAULT);
    PairStyles::Factory::instance().addStyle("gran", hash, &make_pair_style<Model<TANGENTIAL, ROLLING> >);
    Walls::Factory::instance().addStyle("gran", hash, &make_wall<Model<TANGENTIAL, ROLLING> >);
  }
  template <int TANGENTIAL> static void add_rolling() {
    add<TANGENTIAL, ROLLING_OFF>();
    add<TANGENTIAL, ROLLING_CDT>();
    add<TANGENTIAL, ROLLING_EPSD>();
    add<TANGENTIAL, ROLLING_EPSD2>();
  }
  Registration() {
    setvbuf(stdout, NULL, _IOLBF, BUFSIZ); // or the reason of an MPI_Abort is lost where the output goes to a pipe
    ContactModels::Factory::instance().addNormalModel("demlaws/table", DEMLAWS_TABLE);
    add_rolling<TANGENTIAL_OFF>();
    add_rolling<TANGENTIAL_NO_HISTORY>();
    add_rolling<TANGENTIAL_HISTORY>();
    static const int tangential[] = {0, 1, 2, 4}, cohesion[] = {0, 1, 2, 7, 8}, rolling[] = {0, 1, 2, 3, 4, 6}, surface[] = {0, 2, 5};
    for (int t : tangential)
      for (int c : cohesion)
        for (int r : rolling)
          for (int s : surface) {
            if (t <= 2 && c == 0 && r <= 3 && s == 0) continue;
            const int64_t hash = Utils::generate_gran_hashcode(DEMLAWS_TABLE, t, c, r, s);
            PairStyles::Factory::instance().addStyle("gran", hash, &refuse_pair_style);
            Walls::Factory::instance().addStyle("gran", hash, &refuse_wall);
          }
  }
};
static Registration registration;

} // namespace demlaws
