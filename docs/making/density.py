"""Words, numbers, tables and pictures of each page: python docs/making/density.py [PAGE ...]; default: all of docs and README.

`--site build/site` counts the built pages instead, generated ones included: words of the text, and of listings.

Numbers are those of the text and of tables, not of listings. A page that is read has few. `--repeated` lists figures
with a unit that three pages or more have, other than inputs: a measured figure is stated once in README and once in docs.
"""

import re
import sys
from html.parser import HTMLParser
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
NUMBER = re.compile(r"(?<![\w.])[-−+]?\d[\d,]*(?:\.\d+)?(?:e[-+]?\d+)?")


def density(text):
    """(words, numbers, tables, rows of the longest table, pictures) of a page."""
    text = text_of(text)
    tables = [len(block.splitlines()) - 2 for block in re.findall(r"(?:^\|.*\n?)+", text, re.MULTILINE)]
    words = len(re.findall(r"[^\W\d_]{2,}", text))
    return words, len(NUMBER.findall(text)), len(tables), max(tables, default=0), len(re.findall(r"!\[", text))


FIGURE = re.compile(r"(?<![\w.,^])\d+(?:[.,]\d+)?(?:e[-+]?\d+)? ?(?:%|µm|nm|MB|s|ns|µs|N|J|MPa|kPa|times|bytes)(?!\w)")
INPUTS = {"100 N", "100 kPa", "375 kPa", "0.05 N"}
"""Loads and stresses that runs are made with."""


def text_of(page):
    """The text of a page without comments and listings."""
    text = re.sub(r"^```.*?^```", "", page, flags=re.MULTILINE | re.DOTALL)
    return re.sub(r"<!--.*?-->", "", text, flags=re.DOTALL)


def repeated(found):
    """{figure: names of its pages}, for figures on three pages or more."""
    places = {}
    for path in found:
        for figure in set(FIGURE.findall(text_of(path.read_text()))) - INPUTS:
            digits = re.sub(r"e.*|\D", "", figure.split()[0]).strip("0")
            if len(digits) < 2:
                continue  # a round figure may stand for several things
            places.setdefault(figure, []).append(path.relative_to(ROOT).as_posix())
    return {figure: names for figure, names in sorted(places.items()) if len(names) > 2}


def pages():
    """Pages of the repository that the site shows and people wrote."""
    found = [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]
    found += [ROOT / folder / "README.md" for folder in ("yade_scripts", "liggghts_inputs", "lammps_inputs")]
    return sorted(path for path in found if "made" not in path.parts)


class Article(HTMLParser):
    """The main content of a built page: pieces of its text and of its listings; each name in a listing counts as a word."""

    def __init__(self):
        super().__init__()
        self.open, self.text, self.listings = [], [], []

    def handle_starttag(self, tag, attrs):
        if tag in ("article", "pre", "script", "style", "math"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        if self.open and tag == self.open[-1]:
            self.open.pop()

    def handle_data(self, data):
        if self.open == ["article"]:
            self.text.append(data)
        elif self.open == ["article", "pre"]:
            self.listings.append(data)


def site(folder):
    """[(words of the text, words of listings, page)] of a built site, without its indexes."""
    rows = []
    for path in Path(folder).rglob("*.html"):
        if path.stem not in ("genindex", "py-modindex", "search"):
            page = Article()
            page.feed(path.read_text())
            words = [len(" ".join(pieces).split()) for pieces in (page.text, page.listings)]
            rows.append((*words, path.relative_to(folder).as_posix()))
    return sorted(rows, key=lambda row: -row[0] - row[1])


def main():
    """Print a line per page, most numbers first."""
    if "--site" in sys.argv:
        rows = site(sys.argv[sys.argv.index("--site") + 1])
        rows.append((sum(row[0] for row in rows), sum(row[1] for row in rows), f"{len(rows)} pages"))
        print("\n".join(f"{page:38} {text:6} + {listings:5} = {text + listings:6}" for text, listings, page in rows))
        return
    names = [name for name in sys.argv[1:] if name != "--repeated"]
    chosen = [Path(name).resolve() for name in names] or pages()
    if "--repeated" in sys.argv:
        print("\n".join(f"{figure:12} {', '.join(names)}" for figure, names in repeated(chosen).items()))
        return
    rows = [(density(path.read_text()), path.relative_to(ROOT)) for path in chosen]
    print(f"{'page':34} {'words':>6} {'numbers':>8} {'tables':>7} {'rows':>5} {'pictures':>9}")
    for counts, path in sorted(rows, key=lambda row: -row[0][1]):
        print(f"{path.as_posix():34} {counts[0]:6} {counts[1]:8} {counts[2]:7} {counts[3]:5} {counts[4]:9}")


if __name__ == "__main__":
    main()
