"""demlaws/cpp/demlaws_facts.h from the records in Python: rules, keys of table files, limits. `make facts` writes it."""

import sys
from pathlib import Path

import demlaws
from demlaws import units
from demlaws.core import grid, shear, slip
from demlaws.core.unloading import LARGEST_STATE
from demlaws.curves import table_grammar
from demlaws.errors import page

PATH = Path(demlaws.__file__).parent / "cpp" / "demlaws_facts.h"
KINDS = {
    table_grammar._name: ("NAME", "a name"),
    table_grammar.bits: ("BITS", f"a whole number from 1 to {grid.MOST_BITS}"),
    table_grammar.rows_of_file: ("ROWS", f"a whole number from 2 to {table_grammar.MOST_ROWS}"),
    table_grammar._positive: ("POSITIVE", "a positive number"),
    table_grammar._not_negative: ("NOT_NEGATIVE", "a number from 0"),
    table_grammar.power_or_straight: ("BELOW", "power or straight"),
    table_grammar._rule: ("RULE", "an unloading rule that is known here"),
    table_grammar.yes_or_no: ("YES_OR_NO", "yes or no"),
}
"""Of the value of a key: name and meaning in C++; what Python alone reads has none."""
TEXT = """\
// demlaws_facts.h: unloading rules, keys of table files and limits. Written by `make facts` from the records in Python
// (core/unloading.py, core/shear.py, core/slip.py, curves/table_grammar.py, units.py and the laws): change them there.
//
// Licence: GPL-2.0-or-later, as the package demlaws.
// clang-format off
#ifndef DEMLAWS_FACTS_H
#define DEMLAWS_FACTS_H
// Where a page of the documentation is.
#define DEMLAWS_PAGE(NAME) {page}
namespace demlaws {{

// Rules that any law may have, then those of single laws.
enum Unloading {{ {rules} }};
constexpr int RULES = {count};
constexpr const char *const RULE_NAMES[] = {{{names}}};
constexpr int STATE_SIZES[] = {{{sizes}}}; // of STATE_NAMES, so many from the first
constexpr const char *const STATE_NAMES[] = {{{state}}};
constexpr int MOST_STATE = {most};
constexpr bool HAS_SPRINGS[] = {{{springs}}}; // of partial slip
// Numbers that a rule of a single law has in a file.
constexpr const char *const RULE_KEYS[][4] = {{{rule_keys}}};

// Normal stiffness that the tangential stiffness is a multiple of; restart files have the numbers.
enum Shear {{ {shears} }};
constexpr const char *const SHEAR_NAMES[] = {{{shear_names}}};
constexpr int LEVELS = {shear.DEFAULT_LEVELS}, MOST_LEVELS = {shear.MOST_LEVELS}; // by default; at most
constexpr double EMPTY_LEVEL = {shear.EMPTY}; // of K_t: a level of less stiffness counts as empty
constexpr double LARGEST_SHEAR_RATIO = {shear.LARGEST_SHEAR_RATIO!r}; // K_t/K
// Partial slip: springs by default, their ladder; see core/slip.py.
constexpr int SPRINGS = {slip.SPRINGS};
constexpr double LADDER[] = {{{ladder}}}, LADDER_SLACK = {slip.SLACK}, LADDER_FARTHEST = {slip.FARTHEST};

// First line of a table file, its keys and kinds of their values.
constexpr const char *const FORMAT = "{file.FORMAT}";
enum class Kind {{ {kinds} }};
constexpr const char *const KIND_NAMES[] = {{{kind_names}}};
struct Key {{ const char *name; Kind kind; }};
constexpr Key CURVE_KEYS[] = {{{curve}}};
constexpr Key SHARED_KEYS[] = {{{shared}}};
constexpr Key YIELD_KEYS[] = {{{bulk}}};

constexpr int MOST_BITS = {grid.MOST_BITS}, MOST_KINKS = {grid.MOST_KINKS}; // of a curve
constexpr long MOST_ROWS = {file.MOST_ROWS};
constexpr double LARGEST_ROW_OVERLAP = {file.LARGEST_OVERLAP}, LARGEST_ROW_FORCE = {file.LARGEST_FORCE};
constexpr double LEAST_MODULUS = {modulus}; // of E* [Pa]
// Over R: a warning beyond the first, an error beyond the second.
constexpr double LARGE_ROUGHNESS = {units.LARGE_ROUGHNESS}, LARGEST_ROUGHNESS = {units.LARGEST_ROUGHNESS};
constexpr double SMALL_OVERLAP = {units.SMALL_OVERLAP}, LARGEST_OVERLAP = {units.LARGEST_OVERLAP};

}} // namespace demlaws
#endif
"""


def words(values):
    """C++ strings of names."""
    return ", ".join(f'"{value}"' for value in values)


def keys(records):
    """C++ records of the keys that C++ reads."""
    named = [(key.name, KINDS[key.read][0]) for key in records if key.read in KINDS]
    return ", ".join(f'{{"{name}", Kind::{kind}}}' for name, kind in named)


def header():
    """The text of the file."""
    rules = sorted((rule for rule in table_grammar.rules().values() if rule.number is not None), key=lambda rule: rule.number)
    assert [rule.number for rule in rules] == list(range(len(rules)))
    states = max((rule.state for rule in rules), key=len)
    assert all(rule.state == states[: len(rule.state)] for rule in rules) and len(states) == LARGEST_STATE
    names = {"table": "GIVEN"}  # in C++
    choices = [*shear.CHOICES, shear.SLIP]
    assert [choice.number for choice in shear.CHOICES.values()] == list(range(1, len(choices)))
    return TEXT.format(
        rules=", ".join(names.get(rule.name, rule.name.upper()) for rule in rules),
        count=len(rules),
        names=words(rule.name for rule in rules),
        sizes=", ".join(str(len(rule.state)) for rule in rules),
        state=words(states),
        most=LARGEST_STATE,
        springs=", ".join(str(rule.springs is not None).lower() for rule in rules),
        rule_keys=", ".join(f"{{{words(rule.keys)}}}" for rule in rules),
        shears=", ".join(f"{name.upper()}_SHEAR = {number}" for number, name in enumerate(choices, start=1)),
        shear_names=words(["", *choices]),
        kinds=", ".join(name for name, _ in KINDS.values()),
        kind_names=words(meaning for _, meaning in KINDS.values()),
        curve=keys(table_grammar.CURVE),
        shared=keys(table_grammar.SHARED),
        bulk=keys(table_grammar.YIELD),
        modulus=units.RANGES["modulus"].low,
        shear=shear,
        slip=slip,
        ladder=", ".join(map(repr, slip.STEPS)),
        grid=grid,
        file=table_grammar,
        units=units,
        page="".join(('"', page('" NAME "'), '"')),
    )


if __name__ == "__main__":
    PATH.write_text(header())
    sys.exit(0)
