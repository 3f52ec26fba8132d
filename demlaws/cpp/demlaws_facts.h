// demlaws_facts.h: unloading rules, keys of table files and limits. Written by `make facts` from the records in Python
// (core/unloading.py, core/shear.py, core/slip.py, curves/table_grammar.py, units.py and the laws): change them there.
//
// Licence: GPL-2.0-or-later, as the package demlaws.
// clang-format off
#ifndef DEMLAWS_FACTS_H
#define DEMLAWS_FACTS_H
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
// Partial slip: springs by default, their ladder; see core/slip.py.
constexpr int SPRINGS = 11;
constexpr double LADDER[] = {0.3377, 0.5869, 0.7335, 0.8272, 0.8891, 0.932, 0.9583, 0.9745, 0.9855, 0.996, 1.0}, LADDER_SLACK = 1.3, LADDER_FARTHEST = 3.0;

// First line of a table file, its keys and kinds of their values.
constexpr const char *const FORMAT = "# demlaws-table 3";
enum class Kind { NAME, BITS, ROWS, POSITIVE, NOT_NEGATIVE, BELOW, RULE, YES_OR_NO };
constexpr const char *const KIND_NAMES[] = {"a name", "a whole number from 1 to 12", "a whole number from 2 to 2000000", "a positive number", "a number from 0", "power or straight", "an unloading rule that is known here", "yes or no"};
struct Key { const char *name; Kind kind; };
constexpr Key CURVE_KEYS[] = {{"law", Kind::NAME}, {"effective_radius", Kind::POSITIVE}, {"effective_modulus", Kind::POSITIVE}, {"bits", Kind::BITS}, {"rows", Kind::ROWS}, {"force_error", Kind::NOT_NEGATIVE}, {"stiffness_error", Kind::NOT_NEGATIVE}, {"below_first_row", Kind::BELOW}};
constexpr Key SHARED_KEYS[] = {{"unloading", Kind::RULE}, {"collapses", Kind::YES_OR_NO}, {"length", Kind::POSITIVE}, {"length_over_roughness", Kind::NOT_NEGATIVE}, {"length_over_radius", Kind::NOT_NEGATIVE}, {"rtol", Kind::NOT_NEGATIVE}};
constexpr Key YIELD_KEYS[] = {{"yield_overlap", Kind::POSITIVE}, {"yield_force", Kind::POSITIVE}, {"yield_area", Kind::POSITIVE}, {"yield_area_slope", Kind::POSITIVE}};

constexpr int MOST_BITS = 12, MOST_KINKS = 32; // of a curve
constexpr long MOST_ROWS = 2000000;
constexpr double LARGEST_ROW_OVERLAP = 1e+60, LARGEST_ROW_FORCE = 1e+200;
constexpr double LEAST_MODULUS = 1000.0; // of E* [Pa]
// Over R: a warning beyond the first, an error beyond the second.
constexpr double LARGE_ROUGHNESS = 0.1, LARGEST_ROUGHNESS = 0.5;
constexpr double SMALL_OVERLAP = 0.1, LARGEST_OVERLAP = 1.0;

} // namespace demlaws
#endif
