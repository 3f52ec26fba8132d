"""demlaws/cpp/demlaws_facts.h from the records in Python: rules, keys of table files, limits. `make facts` writes it."""

import math
import sys
from pathlib import Path

import demlaws
from demlaws import units
from demlaws.contact import LOWEST_HARDNESS
from demlaws.core import grid, shear, slip
from demlaws.core.unloading import LARGEST_STATE
from demlaws.curves import table_grammar
from demlaws.errors import page
from demlaws.laws.definition import Numbers

MOST_SPRINGS = 22  # of a plugin; SpringRow::MOST
PATH = Path(demlaws.__file__).parent / "cpp" / "demlaws_facts.h"
TEXT = """\
// demlaws_facts.h: unloading rules, keys of table files and limits. Written by `make facts` from the records in Python
// (core/unloading.py, core/shear.py, core/slip.py, curves/table_grammar.py, units.py and the laws): change them there.
//
// Licence: GPL-2.0-or-later, as the package demlaws.
// clang-format off
#ifndef DEMLAWS_FACTS_H
#define DEMLAWS_FACTS_H
#include <cmath>
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
// Partial slip: springs by default, and where they are divided or joined; see core/slip.py.
constexpr int SPRINGS = {shear.SPRINGS};
constexpr double SPRING_THIN = {slip.THIN}, SPRING_WIDE = {slip.WIDE}, SPRING_LARGE_CYCLES = {slip.LARGE_CYCLES},
                 SPRING_LOST = {slip.LOST}, SPRING_SPARE = {slip.SPARE}, SPRING_FARTHEST = {slip.FARTHEST};
// Error of a spring from which it is divided, by the number of springs.
constexpr double SPRING_COARSE[] = {{{coarse}}};

// First line of a table file, and its keys. need: "always", "" (optional), or a rule or key with which it is needed.
// words: a blank between, "number", "triples" of numbers, "" for any text. both: of an unloading curve, too.
constexpr const char *const FORMAT = "{file.FORMAT}";
struct Key {{ const char *name, *need, *words, *meaning; double low, high; bool included, both; }};
constexpr Key KEYS[] = {{{keys}}};
// Laws of demlaws, their options, the quantities that they need; the key and default of the law before yield.
constexpr const char *const LAWS[] = {{{laws}}};
constexpr int LAW_COUNT = {law_count};
struct LawKey {{ const char *law; Key key; }};
constexpr LawKey LAW_KEYS[] = {{{law_keys}}};
constexpr const char *const INNER[] = {{{inner}}};

constexpr int MOST_BITS = {grid.MOST_BITS}, MOST_KINKS = {grid.MOST_KINKS}; // of a curve
constexpr long MOST_ROWS = {file.MOST_ROWS};
constexpr double LARGEST_ROW_OVERLAP = {file.LARGEST_OVERLAP}, LARGEST_ROW_FORCE = {file.LARGEST_FORCE};
constexpr double STEEPEST = {file.STEEPEST}, JUMP = {file.JUMP}, ROUNDING = {file.ROUNDING}; // of rows
constexpr double LEAST_MODULUS = {modulus}, LOWEST_HARDNESS = {hardness}; // of E* [Pa]; of hardness over E*
constexpr double SMALLEST_LENGTH = {file._LENGTH.low}; // [m]
// Over R: a warning beyond the first, an error beyond the second.
constexpr double LARGE_ROUGHNESS = {units.LARGE_ROUGHNESS}, LARGEST_ROUGHNESS = {units.LARGEST_ROUGHNESS};
constexpr double SMALL_OVERLAP = {units.SMALL_OVERLAP}, LARGEST_OVERLAP = {units.LARGEST_OVERLAP};

}} // namespace demlaws
#endif
"""


def words(values):
    """C++ strings of names."""
    return ", ".join(f'"{value}"' for value in values)


def key(record):
    """C++ record of a key."""
    values, low, high, included = record.values, 0.0, 0.0, False
    if isinstance(values, Numbers):
        low, high, included = values
        text = meaning = "number"
        meaning = f"a number {'from' if included else 'above'} {low:g} up to {high:g}"
    elif values == table_grammar.TRIPLES:
        text, meaning = "triples", "numbers three by three with a blank between"
    else:
        text, meaning = " ".join(values), f"one of {', '.join(values)}" if values else "a text"
    low, high = ("HUGE_VAL" if end == math.inf else "-HUGE_VAL" if end == -math.inf else repr(end) for end in (low, high))
    flags = ", ".join(str(flag).lower() for flag in (included, record.both))
    return f"{{{words([record.name, record.need, text, meaning])}, {low}, {high}, {flags}}}"


def header():
    """The text of the file."""
    rules = sorted((rule for rule in table_grammar.rules().values() if rule.number is not None), key=lambda rule: rule.number)
    assert [rule.number for rule in rules] == list(range(len(rules)))
    states = max((rule.state for rule in rules), key=len)
    assert all(rule.state == states[: len(rule.state)] for rule in rules) and len(states) == LARGEST_STATE
    names = {"table": "GIVEN"}  # in C++
    laws = table_grammar.law_keys()
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
        keys=", ".join(map(key, table_grammar.keys())),
        laws=words(laws),
        law_count=len(laws),
        law_keys=", ".join(f'{{"{law}", {key(one)}}}' for law, its_own in laws.items() for one in its_own),
        inner=words(table_grammar.INNER),
        hardness=LOWEST_HARDNESS,
        modulus=units.RANGES["modulus"].low,
        shear=shear,
        slip=slip,
        coarse=", ".join(repr(slip.coarse_error(count)) if count > 1 else "0." for count in range(MOST_SPRINGS + 1)),
        grid=grid,
        file=table_grammar,
        units=units,
        page="".join(('"', page('" NAME "'), '"')),
    )


if __name__ == "__main__":
    PATH.write_text(header())
    sys.exit(0)
