// What the plugin does in the place of functions of LAMMPS's GranularModel, for each layout of its classes: sub-models
// from the words of an input line, and pairs of particles computed here.
#ifndef DEMLAWS_PLUGIN_HOOKS_H
#define DEMLAWS_PLUGIN_HOOKS_H

#include "granular_models.h"

namespace {

__attribute__((noinline)) bool check_elsewhere(void *m) { return Stock::get().check(m); }
__attribute__((noinline)) void compute_elsewhere(void *m) { Stock::get().compute(m); }

template <class ABI> struct Hooks {
  typedef Granular<ABI> Models;
  typedef typename Models::Model Model;
  typedef typename Models::Table Table;
  typedef typename Models::ShearModel ShearModel;

  // In the place of GranularModel::check_contact and calculate_forces, for each pair of neighbours at each step.
  static inline bool in_pairs(const Model *m) {
    if (m->contact_type | (int)m->synchronized()) return false;
    const typename Models::NormalMod *const normal = m->normal_model;
    if (__builtin_expect(normal == Table::latest, 1)) return true;
    if (!this_object.holds(*(const void *const *)normal)) return false; // where the table of virtual functions stands
    if (!((const Table *)normal)->computes_pairs) return false;
    Table::latest = (Table *)normal;
    return true;
  }
  static bool check(void *model) {
    Model *const m = (Model *)model;
    return in_pairs(m) ? touching(m) : check_elsewhere(m);
  }
  static void compute(void *model) {
    Model *const m = (Model *)model;
    if (in_pairs(m)) return compute_pair((Table *)m->normal_model, m);
    if (m->contact_type != PAIR && !this_object.holds(*(const void *const *)m->normal_model)) look_at_wall(m);
    compute_elsewhere(m);
  }
  // GranularModel::calculate_forces where nothing but a law of ours, a damping and a tangential model are at work.
  __attribute__((flatten)) static void compute_pair(Table *table, Model *m) {
    if (__builtin_expect(table->is_watched(), 0)) return compute_elsewhere(m);
    geometry(m, table->speed);
    m->Fnormal = table->force();
    typename Models::DampingMod *const damping = m->damping_model;
    if (table->damped == Table::OTHERWISE) return sum(m, m->Fnormal + call<double>(damping, FORCES));
    const bool by_tangent = table->damped == Table::BY_TANGENT;
    damping->damp_prefactor =
        damping->damp * (by_tangent ? sqrt(m->meff * table->stiffness()) : m->meff * m->contact_radius);
    sum(m, m->Fnormal - damping->damp_prefactor * m->vnnr);
  }
  static void choose_path(Table *table, const Model *m, bool proved) {
    Table::latest = NULL;
    const std::string &tangential = m->sub_models[TANGENTIAL]->name, &damping = m->damping_model->name;
    table->computes_pairs = proved && !m->beyond_contact && tangential != "none";
    for (int k = ROLLING; k <= HEAT; k++)
      table->computes_pairs = table->computes_pairs && m->sub_models[k]->name == "none";
    table->speed = tangential != "demlaws" && tangential.compare(0, 7, "mindlin") != 0;
    table->damped = damping == "demlaws/tangent" ? Table::BY_TANGENT
                    : damping == "viscoelastic"  ? Table::BY_RADIUS
                                                 : Table::OTHERWISE;
  }
  __attribute__((noinline)) static void look_at_wall(Model *m) {
    Range::of(m->of.lmp).look_at_wall(m->normal_model->name);
  }

  // GranularModel::construct_sub_model for names of demlaws.
  static void construct(void *model, const std::string &name, int type, bool outputs) {
    Model *const m = (Model *)model;
    delete m->sub_models[type];
    m->sub_models[type] = NULL;
    if (type == NORMAL) m->sub_models[type] = m->normal_model = new typename Models::DeferredTable(m, outputs);
    else if (type == DAMPING) m->sub_models[type] = m->damping_model = new typename Models::Tangent(m, name);
    else m->sub_models[type] = m->tangential_model = new ShearModel(m, name);
  }

  // GranularModel::add_sub_model for names of demlaws.
  static int add(void *model, char **arg, int at, int count, int type, bool outputs) {
    Model *const m = (Model *)model;
    const std::string name = arg[at++];
    void *const lmp = m->of.lmp;
    if (type == NORMAL) {
      double c[3];
      const std::string file = Words<typename Models::Table>::read_material(lmp, arg, at, count, c);
      delete m->sub_models[type];
      m->sub_models[type] = NULL;
      Table *const made = Models::set_table(m, lmp, file, outputs);
      std::copy(c, c + 3, made->coeffs);
      made->check_order();
      at = Words<typename Models::Table>::read_options(lmp, arg, at, count, made->coeffs);
      made->coeffs_to_local();
      return at;
    }
    construct(m, name, type, outputs);
    if (type != TANGENTIAL) return at;
    ShearModel::read(lmp, arg, at, count, m->sub_models[type]->coeffs);
    m->sub_models[type]->coeffs_to_local();
    return at + ShearModel::COEFFICIENTS;
  }

  // Before GranularModel::init.
  static void before_init(void *model) {
    ShearModel *const shear_model = dynamic_cast<ShearModel *>(((Model *)model)->tangential_model);
    if (shear_model) shear_model->set_history_size();
  }

  // After GranularModel::init: whether a model has a table; the sizes of the history of its sub-models. proved: pairs
  // of particles may be computed here.
  static bool after_init(void *model, bool proved, std::vector<int> &sizes) {
    Model *const m = (Model *)model;
    Table *const table = dynamic_cast<Table *>(m->normal_model);
    if (table) choose_path(table, m, proved);
    for (const typename Models::SubMod *const sub : m->sub_models) sizes.push_back(sub->size_history);
    return table != NULL;
  }
};

} // namespace
#endif
