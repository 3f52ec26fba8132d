// The classes of LAMMPS's GRANULAR package, as far as demlaws uses them, in two layouts:
//   early, LATE = false: 4 Feb 2025 (Debian 13): before `synchronized_verlet`
//   late, LATE = true: 22 Jul 2025 (PyPI) to 4 Jul 2026 (Debian sid): with it
// The order of members and of virtual functions is that of granular_model.h, gran_sub_mod.h, gran_sub_mod_normal.h and
// gran_sub_mod_damping.h. Nothing here is ever linked against LAMMPS; fits() proves it on the running library.
#ifndef DEMLAWS_GRANULAR_ABI_H
#define DEMLAWS_GRANULAR_ABI_H

#include "stock.h"
#include <cmath>
#include <cstring>

namespace {

// those that demlaws knows; the last one is that of package GRANSURF
enum ContactType { PAIR = 0, WALL = 1, WALL_REGION = 2, LAST_TYPE = 3 };

// Pointers: the instance, then references to 21 members of it.
struct Pointers {
  void *lmp, *memory;
  void **error;
  void *universe, *input, *atom, *update, *neighbor, *comm, *domain, *force;
  void **modify;
  void *others[10];
};

// Virtual function `number` of an object that may be LAMMPS's own: the compiler sees no class but those here, and would
// call them directly. FORCES: calculate_forces of a damping and a tangential model, NORMAL_FORCES: of a normal one.
enum { FORCES = 5, CONTACT_RADIUS = 7, NORMAL_FORCES = 8 };
template <class Result> inline Result call(void *object, int number) {
  return (*(Result(***)(void *))object)[number](object);
}

// What GranularModel::check_contact and calculate_forces do for a pair of particles without rolling, twisting and heat.
// Written out here so that the law and its damping need no virtual calls and no second reading of their numbers.
template <class Model> inline bool touching(Model *m) {
  const double *const a = m->xi, *const b = m->xj, radsum = m->radi + m->radj;
  double rsq = 0.;
  for (int k = 0; k < 3; k++) {
    const double apart = a[k] - b[k];
    m->dx[k] = apart;
    rsq += apart * apart;
  }
  m->rsq = rsq;
  m->radsum = radsum;
  m->touch = rsq < radsum * radsum;
  if (m->touch) m->Reff = m->radi * m->radj / radsum;
  return m->touch;
}
template <class Model> __attribute__((always_inline)) inline void geometry(Model *m, bool speed) {
  const double r = sqrt(m->rsq), rinv = 1. / r, radi = m->radi, radj = m->radj;
  double n[3], v[3], w[3], normal = 0.;
  for (int k = 0; k < 3; k++) {
    n[k] = rinv * m->dx[k];
    v[k] = m->vi[k] - m->vj[k];
    w[k] = radi * m->omegai[k] + radj * m->omegaj[k];
    normal += v[k] * n[k];
  }
  const double t[3] = {v[0] - normal * n[0] - (w[1] * n[2] - w[2] * n[1]),
                       v[1] - normal * n[1] - (w[2] * n[0] - w[0] * n[2]),
                       v[2] - normal * n[2] - (w[0] * n[1] - w[1] * n[0])};
  m->r = r;
  m->rinv = rinv;
  m->delta = m->radsum - r;
  m->vnnr = normal;
  for (int k = 0; k < 3; k++) {
    m->nx[k] = n[k];
    m->vr[k] = v[k];
    m->wr[k] = w[k];
    m->vtr[k] = t[k];
  }
  if (speed) m->vrel = sqrt(t[0] * t[0] + t[1] * t[1] + t[2] * t[2]);
}
template <class Model> __attribute__((always_inline)) inline void sum(Model *m, double total) {
  if (__builtin_expect(m->limit_damping && total < 0., 0)) total = 0.;
  m->Fntot = total;
  m->normal_model->Fncrit = fabs(total);
  call<void>(m->tangential_model, FORCES);
  const double x = m->nx[0], y = m->nx[1], z = m->nx[2], f[3] = {m->fs[0], m->fs[1], m->fs[2]};
  const double moment[3] = {f[1] * z - f[2] * y, f[2] * x - f[0] * z, f[0] * y - f[1] * x}, half = 0.5 * m->delta;
  const double i = m->radi - half, j = m->radj - half;
  for (int k = 0; k < 3; k++) {
    m->forces[k] = total * m->nx[k] + f[k];
    m->torquesi[k] = i * moment[k];
    m->torquesj[k] = j * moment[k];
  }
}

template <bool LATE> struct Abi {
  struct Model;

  struct SubMod : public Pointers {
    virtual ~SubMod() {
      if (allocated) delete[] coeffs;
      delete[] transfer_history_factor;
    }
    virtual void mix_coeffs(double *, double *) {}
    virtual void coeffs_to_local() {}
    virtual void init() {}

    int num_coeffs;
    double *coeffs;
    std::string name;
    int size_history = 0, nondefault_history_transfer = 0;
    double *transfer_history_factor = NULL;
    int history_index = 0, beyond_contact = 0, allow_cohesion = 1;
    int contact_radius_flag = 0;
    int allow_synchronization[LATE ? 1 : 0];
    Model *gm;
    int nsvector, index_svector = 0, allocated = 1;

  protected:
    SubMod(Model *m, int coefficients, int outputs)
        : Pointers(m->of), num_coeffs(coefficients), coeffs(new double[coefficients ? coefficients : 1]()), gm(m),
          nsvector(outputs) {
      std::fill(allow_synchronization, allow_synchronization + LATE, 1);
    }
  };

  struct NormalMod : public SubMod {
    virtual bool touch() { return this->gm->rsq < this->gm->radsum * this->gm->radsum; }
    virtual double pulloff_distance(double, double) { return 0.; }
    virtual double calculate_contact_radius() { return sqrt(this->gm->dR); }
    virtual double calculate_forces() = 0;
    virtual void set_fncrit() { Fncrit = fabs(this->gm->Fntot); }

    double damp = 0., Emod = 0., poiss = 0., Fncrit = 0.;
    int material_properties = 0, cohesive_flag = 0;

  protected:
    NormalMod(Model *m, int coefficients, int outputs) : SubMod(m, coefficients, outputs) {}
  };

  struct DampingMod : public SubMod {
    virtual double calculate_forces() = 0;
    double get_damp_prefactor() const { return damp_prefactor; }
    double damp_prefactor = 0., damp = 0.;

  protected:
    explicit DampingMod(Model *m) : SubMod(m, 0, 0) {}
  };

  struct TangentialMod : public SubMod {
    virtual void calculate_forces() = 0;
    double k = 0., damp = 0., mu = 0.;

  protected:
    TangentialMod(Model *m, int coefficients) : SubMod(m, coefficients, 0) {}
  };

  struct Model {
    void *vtable;
    Pointers of;
    NormalMod *normal_model;
    DampingMod *damping_model;
    TangentialMod *tangential_model;
    void *rolling_model, *twisting_model, *heat_model;
    SubMod *sub_models[6];
    int beyond_contact, limit_damping, history_update;
    int synchronized_verlet[LATE ? 1 : 0];
    int contact_type;
    int i, j, itype, jtype;
    int size_history, nondefault_history_transfer;
    double *transfer_history_factor, *history;
    double Fnormal, forces[3], torquesi[3], torquesj[3], dq;
    double radi, radj, meff, dt, Ti, Tj, contact_radius;
    double Fntot, magtortwist;
    double *xi, *xj, *vi, *vj, *omegai, *omegaj;
    double fs[3], fr[3], ft[3];
    double dx[3], nx[3];
    double nx_unrotated[LATE ? 3 : 0];
    double r, rsq, rinv, Reff, radsum, delta, dR;
    double vr[3], vn[3], vnnr, vt[3], wr[3], vtr[3], vrl[3], relrot[3], vrel;
    double magtwist;
    bool touch;
    int calculate_svector, nsvector;
    double *svector;

    bool synchronized() const { return LATE && synchronized_verlet[0]; }
  };

  static bool synchronized(const Model *m) { return m->synchronized(); }
  static void after_init(void *, Model *) {} // of a normal model of ours

  // A normal model of ours for the proof: its virtual functions must be called where LAMMPS calls its own.
  struct Probe : public NormalMod {
    enum { OUTPUTS = 2 };
    std::string calls;
    bool *gone;
    Probe(Model *m, bool *g) : NormalMod(m, 1, OUTPUTS), gone(g) {
      this->name = "demlaws/probe";
      this->contact_radius_flag = 1;
      this->size_history = 3;
      this->nondefault_history_transfer = 1;
      this->transfer_history_factor = new double[3];
      for (int k = 0; k < 3; k++) this->transfer_history_factor[k] = 7. + k;
    }
    ~Probe() { *gone = true; }
    template <class T> T called(const char *function, T answer) {
      calls += function;
      return answer;
    }
    void init() { calls += "init "; }
    bool touch() { return called("touch ", true); }
    double calculate_contact_radius() { return called("radius ", 0.375); }
    double calculate_forces() { return called("forces ", 5.5); }
    void set_fncrit() { this->Fncrit = called("fncrit", 1.); }
  };

  // A sub-model, from the words that an input has for it.
  static void add_stock_model(const Stock &stock, Model *m, int type, std::vector<std::string> words) {
    std::vector<char *> arg;
    for (std::string &word : words) arg.push_back(&word[0]);
    stock.add(m, &arg[0], 0, (int)arg.size(), type);
  }
  // A contact; bodies: xi, xj, vi, vj, omegai, omegaj. That with a wall comes with dx.
  static void place(Model *m, int type, double (*bodies)[3], double radj, double dt) {
    m->contact_type = type;
    m->history_update = m->calculate_svector = 0;
    if (type == WALL) std::copy(bodies[0], bodies[0] + 3, m->dx);
    m->xi = bodies[0];
    m->xj = bodies[1];
    m->vi = bodies[2];
    m->vj = bodies[3];
    m->omegai = bodies[4];
    m->omegaj = bodies[5];
    m->radi = 0.75;
    m->radj = radj;
    m->meff = 2.;
    m->dt = dt;
  }

  // A model in a buffer that is filled with a pattern.
  static Model *make(void *lmp, const Stock &stock, std::vector<double> &buffer) {
    buffer.resize(2048);
    memset(&buffer[0], 0xAA, buffer.size() * sizeof buffer[0]);
    stock.make(&buffer[0], lmp);
    return (Model *)&buffer[0];
  }

  // Whether this is how the running LAMMPS lays out its objects: one stock model is made in a poisoned buffer,
  // initialised and computed, then once more with a normal model of ours. Every member that demlaws uses is compared.
  static bool fits(void *lmp, const Stock &stock) {
    std::vector<double> buffer;
    Model *const m = make(lmp, stock, buffer);
    const int untouched = (int)0xAAAAAAAA;
    bool good = m->of.lmp == lmp && m->of.error == (void **)lmp + 1 && m->of.modify == (void **)lmp + 10 &&
                !m->normal_model && !m->damping_model && !m->heat_model && !m->beyond_contact && !m->limit_damping &&
                m->contact_type == 0 && m->i == untouched && m->jtype == untouched && !m->nondefault_history_transfer;
    for (int k = 0; k < 6; k++) good = good && !m->sub_models[k];
    // LAMMPS's Force holds the constants of the units
    const char *const force = good ? *(const char **)m->of.force : NULL;
    const char *const constant = (const char *)stock.global(lmp, "nktv2p");
    good = good && constant > force && constant < force + 1024;
    if (!good) return false; // the buffer may be anything: leave it
    add_stock_model(stock, m, NORMAL, {"hertz/material", "3.0", "0.25", "0.125"});
    add_stock_model(stock, m, TANGENTIAL, {"linear_nohistory", "0.0", "0.375"});
    add_stock_model(stock, m, DAMPING, {"viscoelastic"});
    NormalMod *const normal = m->normal_model;
    good = normal && m->sub_models[NORMAL] == normal && normal->gm == m && normal->num_coeffs == 3 &&
           normal->name == "hertz/material" && normal->coeffs[2] == 0.125 && !normal->size_history &&
           !normal->transfer_history_factor && normal->allocated == 1 && normal->contact_radius_flag == 1 &&
           !normal->nsvector && normal->damp == 0.25 && normal->Emod == 3. && normal->poiss == 0.125 &&
           normal->material_properties == 1 && !normal->cohesive_flag && normal->lmp == lmp && m->tangential_model &&
           m->sub_models[TANGENTIAL] == m->tangential_model && !m->tangential_model->k &&
           m->tangential_model->mu == 0.375;
    if (!good) return false;
    stock.init(m);
    double bodies[6][3] = {{0.5, 0., 0.}, {0.}, {-2., 1.5, 0.}, {0.}, {0., 0., 3.}};
    place(m, WALL, bodies, 0.25, 1e-9);
    const double a = sqrt(0.25 * 0.1875), E = 3. / (2. * (1. - 0.125 * 0.125));
    good = stock.check(m) && m->touch && m->radsum == 0.75 && m->rsq == 0.25 && m->Reff == 0.1875;
    if (good) {
      stock.compute(m);
      const double damping = 0.25 * 2. * a * 2.;
      good = m->delta == 0.25 && m->r == 0.5 && m->rinv == 2. && m->dx[0] == 0.5 && m->vr[0] == -2. &&
             m->vr[1] == 1.5 && m->wr[2] == 0.75 * 3. && fabs(m->vnnr + 2.) < 1e-6 && fabs(m->vrel - 0.75) < 1e-6 &&
             fabs(m->contact_radius - a) < 1e-15 && fabs(m->Fnormal - (4. / 3.) * E * a * 0.25) < 1e-14 &&
             fabs(m->damping_model->damp_prefactor - 0.25 * 2. * a) < 1e-15 &&
             fabs(m->Fntot - m->Fnormal - damping) < 1e-6 && fabs(m->normal_model->Fncrit - fabs(m->Fntot)) < 1e-14 &&
             fabs(m->forces[0] - m->Fntot) < 1e-14;
    }
    stock.unmake(m);
    if (!good) return false;

    bool gone = false;
    make(lmp, stock, buffer);
    add_stock_model(stock, m, TANGENTIAL, {"linear_nohistory", "0.0", "0.0"});
    add_stock_model(stock, m, DAMPING, {"viscoelastic"});
    Probe *const probe = new Probe(m, &gone);
    m->sub_models[NORMAL] = probe;
    m->normal_model = probe;
    stock.init(m);
    good = m->size_history == 3 && m->nondefault_history_transfer == 1 && m->transfer_history_factor &&
           m->transfer_history_factor[0] == 7. && m->transfer_history_factor[2] == 9. &&
           m->nsvector == Probe::OUTPUTS && m->svector;
    place(m, WALL, bodies, 0.25, 1e-9);
    good = good && stock.check(m);
    if (good) {
      stock.compute(m);
      good = m->Fnormal == 5.5 && m->contact_radius == 0.375 && probe->calls == "init touch radius forces fncrit";
    }
    stock.unmake(m);
    return good && gone;
  }

  // Whether they do: contacts that touch and that do not, stick and slip, by the running LAMMPS and by the above.
  static bool pairs_fit(void *lmp, const Stock &stock) {
    std::vector<double> buffer;
    Model *const m = make(lmp, stock, buffer);
    add_stock_model(stock, m, NORMAL, {"hertz/material", "3.0", "0.25", "0.125"});
    add_stock_model(stock, m, TANGENTIAL, {"mindlin", "NULL", "0.5", "0.25"});
    add_stock_model(stock, m, DAMPING, {"viscoelastic"});
    stock.init(m);
    bool good = m->size_history == 3 && m->tangential_model == m->sub_models[TANGENTIAL];
    const int CASES = 24, VALUES = 47;
    uint32_t random = 1;
    for (int n = 0; n < CASES && good; n++) {
      double in[6][3], found[2][VALUES], memory[3];
      for (int k = 0; k < 6; k++)
        for (int axis = 0; axis < 3; axis++) {
          random = random * 1664525u + 1013904223u;
          in[k][axis] = ((random >> 8) / 16777216. - 0.5) * (k < 2 ? 0.6 : n % 3 ? 2. : 0.01);
        }
      in[0][0] += 1.15;
      for (int way = 0; way < 2; way++) {
        place(m, PAIR, in, 0.5, 0.01);
        m->history_update = n % 4 != 3;
        m->limit_damping = n % 2;
        std::fill(m->synchronized_verlet, m->synchronized_verlet + LATE, 0);
        m->history = memory;
        for (int axis = 0; axis < 3; axis++) memory[axis] = 0.01 * in[3][axis];
        double *const out = found[way];
        std::fill(out, out + VALUES, 0.);
        int at = 0;
        const bool touch = way ? touching(m) : stock.check(m);
        out[at++] = touch;
        out[at++] = m->touch;
        out[at++] = m->rsq;
        out[at++] = m->radsum;
        if (!touch) continue;
        if (way) {
          geometry(m, true);
          m->contact_radius = call<double>(m->normal_model, CONTACT_RADIUS);
          m->Fnormal = call<double>(m->normal_model, NORMAL_FORCES);
          sum(m, m->Fnormal + call<double>(m->damping_model, FORCES));
        } else stock.compute(m);
        const double fncrit = m->normal_model->Fncrit, damp = m->damping_model->damp,
                     prefactor = way ? damp * m->meff * m->contact_radius : m->damping_model->damp_prefactor;
        for (double number : {m->Reff, m->r, m->rinv, m->delta, m->vnnr, m->vrel, m->contact_radius, m->Fnormal,
                              m->Fntot, fncrit, prefactor})
          out[at++] = number;
        for (double *vector :
             {m->dx, m->nx, m->vr, m->wr, m->vtr, m->fs, m->forces, m->torquesi, m->torquesj, memory + 0})
          for (int axis = 0; axis < 3; axis++) out[at++] = vector[axis];
      }
      for (int k = 0; k < VALUES; k++) good = good && fabs(found[0][k] - found[1][k]) <= 1e-13;
    }
    stock.unmake(m);
    return good;
  }
};

} // namespace
#endif
