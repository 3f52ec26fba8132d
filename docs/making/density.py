"""Words, numbers, tables and pictures of each page: python docs/making/density.py [PAGE ...]; default: all of docs and README.

Numbers are those of the text and of tables, not of listings. A page that is read has few.
"""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
NUMBER = re.compile(r"(?<![\w.])[-−+]?\d[\d,]*(?:\.\d+)?(?:e[-+]?\d+)?")


def density(text):
    """(words, numbers, tables, rows of the longest table, pictures) of a page."""
    text = re.sub(r"<!--.*?-->", "", re.sub(r"^```.*?^```", "", text, flags=re.MULTILINE | re.DOTALL), flags=re.DOTALL)
    tables = [len(block.splitlines()) - 2 for block in re.findall(r"(?:^\|.*\n?)+", text, re.MULTILINE)]
    words = len(re.findall(r"[^\W\d_]{2,}", text))
    return words, len(NUMBER.findall(text)), len(tables), max(tables, default=0), len(re.findall(r"!\[", text))


def pages():
    """Pages of the repository that the site shows and people wrote."""
    found = [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]
    found += [ROOT / folder / "README.md" for folder in ("yade_scripts", "liggghts_inputs", "lammps_inputs")]
    return sorted(path for path in found if "made" not in path.parts)


def main():
    """Print a line per page, most numbers first."""
    chosen = [Path(name).resolve() for name in sys.argv[1:]] or pages()
    rows = [(density(path.read_text()), path.relative_to(ROOT)) for path in chosen]
    print(f"{'page':34} {'words':>6} {'numbers':>8} {'tables':>7} {'rows':>5} {'pictures':>9}")
    for counts, path in sorted(rows, key=lambda row: -row[0][1]):
        print(f"{path.as_posix():34} {counts[0]:6} {counts[1]:8} {counts[2]:7} {counts[3]:5} {counts[4]:9}")


if __name__ == "__main__":
    main()
