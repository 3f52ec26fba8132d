// demlaws_facts.h: unloading rules, keys of table files and limits. Written by `make facts` from the records in Python
// (core/unloading.py, core/shear.py, core/slip.py, curves/table_grammar.py, units.py and the laws): change them there.
//
// Licence: GPL-2.0-or-later, as the package demlaws.
// clang-format off
#ifndef DEMLAWS_FACTS_H
#define DEMLAWS_FACTS_H
#include <cmath>
// Where a page of the documentation is.
#define DEMLAWS_PAGE(NAME) "docs/" NAME ".md"
namespace demlaws {

// Rules that any law may have, then those of single laws.
enum Unloading { ELASTIC, HERTZ, THORNTON, GIVEN, LINEAR, EEPA, ETSION, JACKSON };
constexpr int RULES = 8;
constexpr const char *const RULE_NAMES[] = {"elastic", "hertz", "thornton", "table", "linear", "eepa", "etsion", "jackson"};
constexpr int STATE_SIZES[] = {0, 2, 3, 2, 2, 2, 3, 3}; // of STATE_NAMES, so many from the first
constexpr const char *const STATE_NAMES[] = {"maximum_overlap", "plastic_overlap", "radius_ratio"};
constexpr int MOST_STATE = 3;
constexpr bool HAS_SPRINGS[] = {true, true, true, true, false, false, true, true}; // of partial slip
// Numbers that a rule of a single law has in a file.
constexpr const char *const RULE_KEYS[][4] = {{}, {}, {}, {}, {"linear_first", "linear_growth", "linear_largest"}, {"eepa_stiffness", "eepa_plastic"}, {"etsion_overlap", "etsion_power"}, {"jackson_overlap"}};

// Normal stiffness that the tangential stiffness is a multiple of; restart files have the numbers.
enum Shear { ELASTIC_SHEAR = 1, LOADING_SHEAR = 2, SLIP_SHEAR = 3 };
constexpr const char *const SHEAR_NAMES[] = {"", "elastic", "loading", "slip"};
constexpr int LEVELS = 3, MOST_LEVELS = 8; // by default; at most
constexpr double EMPTY_LEVEL = 1e-09; // of K_t: a level of less stiffness counts as empty
constexpr double LARGEST_SHEAR_RATIO = 1.3333333333333333; // K_t/K
// Partial slip: springs by default, and where they are divided or joined; see core/slip.py.
constexpr int SPRINGS = 11;
constexpr double SPRING_THIN = 0.047619047619047616, SPRING_WIDE = 1.5, SPRING_LARGE_CYCLES = 3.0,
                 SPRING_LOST = 60.0, SPRING_SPARE = 4.0, SPRING_FARTHEST = 1.6;
// Error of a spring from which it is divided, by the number of springs.
constexpr double SPRING_COARSE[] = {0., 0., 13.97017417543854, 7.629140160458417, 4.908034376228026, 3.465495510534134, 2.598846964834025, 2.0330136655659676, 1.64093792888888, 1.356835149130206, 1.1436623578022187, 0.9791705962248356, 0.8492940564949281, 0.7447615105556349, 0.6592465096265637, 0.5883038571549387, 0.5287309726151321, 0.4781699366147087, 0.43485147053332185, 0.39742558285867524, 0.36484676977109, 0.3362944897524308, 0.31111699613780885};

// First line of a table file, and its keys. need: "always", "" (optional), or a rule or key with which it is needed.
// words: a blank between, "number", "triples" of numbers, "" for any text. both: of an unloading curve, too.
constexpr const char *const FORMAT = "# demlaws-table 4";
struct Key { const char *name, *need, *words, *meaning; double low, high; bool included, both; };
constexpr Key KEYS[] = {{"law", "always", "", "a text", 0.0, 0.0, false, true}, {"description", "", "", "a text", 0.0, 0.0, false, true}, {"radius", "always", "number", "a number from 1e-30 up to 1e+30", 1e-30, 1e+30, true, true}, {"modulus", "always", "number", "a number above 1000 up to 1e+30", 1000.0, 1e+30, false, true}, {"sigma", "", "number", "a number from 0 up to 1e+30", 0.0, 1e+30, true, true}, {"fractal_dimension", "", "number", "a number from 2 up to 3", 2.0, 3.0, true, true}, {"hardness", "", "number", "a number above 0 up to 1e+30", 0.0, 1e+30, false, true}, {"length", "always", "sigma radius", "one of sigma, radius", 0.0, 0.0, false, false}, {"collapses", "always", "yes no", "one of yes, no", 0.0, 0.0, false, false}, {"unloading", "always", "elastic hertz thornton table etsion jackson linear eepa", "one of elastic, hertz, thornton, table, etsion, jackson, linear, eepa", 0.0, 0.0, false, false}, {"below", "always", "power straight", "one of power, straight", 0.0, 0.0, false, true}, {"bits", "always", "1 2 3 4 5 6 7 8 9 10 11 12", "one of 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12", 0.0, 0.0, false, true}, {"force_error", "always", "number", "a number from 0 up to 0.1", 0.0, 0.1, true, true}, {"stiffness_error", "always", "number", "a number from 0 up to 0.1", 0.0, 0.1, true, true}, {"rtol", "always", "number", "a number from 0 up to 0.1", 0.0, 0.1, true, false}, {"yield_area", "", "number", "a number from 1e-60 up to 1e+60", 1e-60, 1e+60, true, false}, {"yield_slope", "yield_area", "number", "a number from 1e-60 up to 1e+60", 1e-60, 1e+60, true, false}, {"area", "", "known", "one of known", 0.0, 0.0, false, false}, {"points", "", "number", "a number from 1 up to 1e+09", 1.0, 1000000000.0, true, false}, {"departure", "points", "number", "a number from 0 up to 1e+60", 0.0, 1e+60, true, false}, {"smoothing", "points", "", "a text", 0.0, 0.0, false, false}, {"knots", "points", "triples", "numbers three by three with a blank between", 0.0, 0.0, false, false}, {"etsion_overlap", "etsion", "number", "a number from 1e-60 up to 1e+60", 1e-60, 1e+60, true, false}, {"etsion_power", "etsion", "number", "a number from 0 up to 1e+60", 0.0, 1e+60, true, false}, {"jackson_overlap", "jackson", "number", "a number from 1e-60 up to 1e+60", 1e-60, 1e+60, true, false}, {"linear_first", "linear", "number", "a number from 1e-60 up to 1e+60", 1e-60, 1e+60, true, false}, {"linear_growth", "linear", "number", "a number from 0 up to 1e+60", 0.0, 1e+60, true, false}, {"linear_largest", "linear", "number", "a number from 1e-60 up to 1e+60", 1e-60, 1e+60, true, false}, {"eepa_stiffness", "eepa", "number", "a number from 1e-60 up to 1e+60", 1e-60, 1e+60, true, false}, {"eepa_plastic", "eepa", "number", "a number from 0 up to 1e+60", 0.0, 1e+60, true, false}};
// Laws of demlaws, their options, the quantities that they need; the key and default of the law before yield.
constexpr const char *const LAWS[] = {"hertz", "rms", "pohrt-popov", "goddard", "rough-plastic", "bahrami", "yip-venart", "greenwood-tripp", "asperity", "thornton-ning", "jackson-green", "kogut-etsion", "conical-damage", "walton-braun", "luding", "eepa"};
constexpr int LAW_COUNT = 16;
struct LawKey { const char *law; Key key; };
constexpr LawKey LAW_KEYS[] = {{"rms", {"sigma", "always", "number", "a number from 0 up to 1e+30", 0.0, 1e+30, true, true}}, {"pohrt-popov", {"sigma", "always", "number", "a number from 0 up to 1e+30", 0.0, 1e+30, true, true}}, {"pohrt-popov", {"fractal_dimension", "always", "number", "a number from 2 up to 3", 2.0, 3.0, true, true}}, {"goddard", {"option_slope", "always", "number", "a number from 0 up to 1", 0.0, 1.0, true, true}}, {"rough-plastic", {"option_yield_pressure", "always", "number", "a number above 0 up to inf", 0.0, HUGE_VAL, false, true}}, {"rough-plastic", {"option_loading", "", "", "a text", 0.0, 0.0, false, true}}, {"rough-plastic", {"option_yield_at", "", "", "a text", 0.0, 0.0, false, true}}, {"rough-plastic", {"option_bulk_radius", "", "number", "a number above 0 up to inf", 0.0, HUGE_VAL, false, true}}, {"bahrami", {"option_constant", "", "number", "a number from 1.5 up to 1.7", 1.5, 1.7, true, true}}, {"bahrami", {"sigma", "always", "number", "a number from 0 up to 1e+30", 0.0, 1e+30, true, true}}, {"bahrami", {"hardness", "always", "number", "a number above 0 up to 1e+30", 0.0, 1e+30, false, true}}, {"yip-venart", {"option_seating_share", "", "number", "a number from 1e-07 up to 1", 1e-07, 1.0, true, true}}, {"yip-venart", {"sigma", "always", "number", "a number from 0 up to 1e+30", 0.0, 1e+30, true, true}}, {"yip-venart", {"hardness", "always", "number", "a number above 0 up to 1e+30", 0.0, 1e+30, false, true}}, {"greenwood-tripp", {"option_mu", "", "number", "a number from 0.05 up to 100000", 0.05, 100000.0, true, true}}, {"greenwood-tripp", {"option_seating_share", "", "number", "a number from 1e-07 up to 1", 1e-07, 1.0, true, true}}, {"greenwood-tripp", {"sigma", "always", "number", "a number from 0 up to 1e+30", 0.0, 1e+30, true, true}}, {"asperity", {"option_surface", "always", "", "a text", 0.0, 0.0, false, true}}, {"asperity", {"option_max_force", "", "number", "a number above 0 up to inf", 0.0, HUGE_VAL, false, true}}, {"asperity", {"option_poisson", "", "number", "a number above -1 up to 0.5", -1.0, 0.5, false, true}}, {"asperity", {"option_plastic_factor", "", "number", "a number above 0 up to inf", 0.0, HUGE_VAL, false, true}}, {"asperity", {"option_plastic_ratio", "", "number", "a number above 0 up to inf", 0.0, HUGE_VAL, false, true}}, {"thornton-ning", {"option_yield_pressure", "always", "number", "a number above 0 up to inf", 0.0, HUGE_VAL, false, true}}, {"jackson-green", {"option_yield_strength", "always", "number", "a number above 0 up to inf", 0.0, HUGE_VAL, false, true}}, {"jackson-green", {"option_poisson", "", "number", "a number from 0 up to 0.5", 0.0, 0.5, true, true}}, {"kogut-etsion", {"option_yield_strength", "always", "number", "a number above 0 up to inf", 0.0, HUGE_VAL, false, true}}, {"kogut-etsion", {"option_poisson", "", "number", "a number from 0 up to 0.5", 0.0, 0.5, true, true}}, {"conical-damage", {"option_strength", "always", "number", "a number above 0 up to inf", 0.0, HUGE_VAL, false, true}}, {"conical-damage", {"option_angle", "always", "number", "a number above 0 up to 1.5708", 0.0, 1.5707963267948966, false, true}}, {"walton-braun", {"option_loading_stiffness", "always", "number", "a number above 0 up to inf", 0.0, HUGE_VAL, false, true}}, {"walton-braun", {"option_stiffness_ratio", "", "number", "a number from 1 up to 1e+06", 1.0, 1000000.0, true, true}}, {"walton-braun", {"option_growth", "", "number", "a number from 0 up to inf", 0.0, HUGE_VAL, true, true}}, {"luding", {"option_loading_stiffness", "always", "number", "a number above 0 up to inf", 0.0, HUGE_VAL, false, true}}, {"luding", {"option_stiffness_ratio", "always", "number", "a number above 1 up to 1e+06", 1.0, 1000000.0, false, true}}, {"luding", {"option_plasticity_depth", "always", "number", "a number above 0 up to 1", 0.0, 1.0, false, true}}, {"eepa", {"option_stiffness_ratio", "always", "number", "a number from 1 up to 1e+06", 1.0, 1000000.0, true, true}}, {"eepa", {"option_softness", "", "number", "a number above 0 up to 1000", 0.0, 1000.0, false, true}}};
constexpr const char *const INNER[] = {"option_loading", "pohrt-popov"};

constexpr int MOST_BITS = 12, MOST_KINKS = 32; // of a curve
constexpr long MOST_ROWS = 2000000;
constexpr double LARGEST_ROW_OVERLAP = 1e+20, LARGEST_ROW_FORCE = 1e+60;
constexpr double STEEPEST = 10.0, JUMP = 2.0, ROUNDING = 1e-09; // of rows
constexpr double LEAST_MODULUS = 1000.0, LOWEST_HARDNESS = 1e-06; // of E* [Pa]; of hardness over E*
constexpr double SMALLEST_LENGTH = 1e-30; // [m]
// Over R: a warning beyond the first, an error beyond the second.
constexpr double LARGE_ROUGHNESS = 0.1, LARGEST_ROUGHNESS = 0.5;
constexpr double SMALL_OVERLAP = 0.1, LARGEST_OVERLAP = 1.0;

} // namespace demlaws
#endif
