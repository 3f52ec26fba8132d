"""The tables of laws in README.md and docs/laws.md, from records and words: python docs/making/tables.py [--write].

Without `--write` it fails if a table differs from its records. tests/docs/test_tables.py does the same.
"""

import argparse
import re
import sys
from itertools import groupby
from pathlib import Path

DOCS = Path(__file__).resolve().parents[1]
ROOT = DOCS.parent
SYMBOLS = {"roughness": "σ", "sigma": "σ", "fractal_dimension": "Df", "hardness": "H_m", "poisson": "ν"}
"""Quantity of a contact → its symbol; others, and options, are shown by their names."""
TABLE = re.compile(r"(<!-- laws: (\w+) -->\n).*?(<!-- end of laws -->)", re.DOTALL)


def laws():
    """Name → (definition, words) of every law of the package, in the order of the groups; words that miss are an error."""
    from demlaws.laws import MODULES
    from demlaws.laws.registry import registry
    from making.words import GROUPS, WORDS

    grouped = [name for names in GROUPS.values() for name in names]
    known = [module.replace("_", "-") for module in MODULES]
    missing = [name for name in known if name not in WORDS or name not in grouped]
    if missing:
        raise SystemExit(f"docs/making/words.py: write words, and a group, for {', '.join(missing)}")
    return {name: (registry()[name], WORDS[name]) for name in grouped}


def needs(definition):
    """Quantities of the contact beside R and E*, and options without a default."""
    required = [line.partition(":")[0].partition(" ")[0] for line in definition.option_lines() if line.endswith("; needed")]
    return ", ".join([*(SYMBOLS.get(name, f"`{name}`") for name in definition.needed()), *(f"`{name}`" for name in required)])


def brief():
    """README's table: laws with the same use share a row."""
    rows = groupby(laws().items(), key=lambda item: item[1][1].brief)
    shown = [f"| {', '.join(f'`{name}`' for name, _ in group)} | {use} |" for use, group in rows]
    return "\n".join(["| law | use it for |", "|---|---|", *shown]) + "\n"


def full():
    """The table of docs/laws.md: every law with a link to its file, its needs and its range."""
    rows = [
        f"| [`{name}`](../demlaws/laws/{name.replace('-', '_')}.py) | {words.brief} | {needs(law)} | {words.valid} |"
        for name, (law, words) in laws().items()
    ]
    return "\n".join(["| law | use it for | required besides R, E\\* | valid for |", "|---|---|---|---|", *rows]) + "\n"


MADE = {"README.md": brief, "docs/laws.md": full}
"""File → function that makes its table."""


def made(file):
    """The text of a file with the table that its records give."""
    text, count = TABLE.subn(lambda match: f"{match[1]}{MADE[file]()}{match[3]}", (ROOT / file).read_text(encoding="utf-8"))
    if count != 1:
        raise SystemExit(f"{file}: {count} tables between <!-- laws: NAME --> and <!-- end of laws -->, not one")
    return text


def main():
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--write", action="store_true", help="write the tables")
    arguments = parser.parse_args()
    for file in MADE:
        text = made(file)
        if arguments.write:
            (ROOT / file).write_text(text, encoding="utf-8")
        elif text != (ROOT / file).read_text(encoding="utf-8"):
            raise SystemExit(f"{file}: the table of laws differs from its records: python docs/making/tables.py --write")


if __name__ == "__main__":
    sys.path[:0] = [str(DOCS), str(ROOT)]
    main()
