"""Listings of a Markdown page, taken out and run as a reader would: files written, commands run, what they print compared.

A comment in a page gives the kind of a listing on the line above it:

    <!-- file: NAME -->             the listing is written into this file
    <!-- run -->                    a console listing: lines after `$ ` are run in order, those below each are what it prints
    <!-- run: within 10 % -->       the same, numbers within that (default: 1 %)
    <!-- run -->                    of a Python listing: run here, the listings of a page one after another in one namespace
    <!-- not run: REASON -->        neither

Every listing of a page that is tested says one of them; `...` in what is printed stands for anything.
"""

import contextlib
import os
import re
import subprocess
from pathlib import Path
from typing import NamedTuple

LISTING = re.compile(r"(?:^<!-- (?P<mark>[^\n]*?) -->\n)?^```(?P<kind>[^\n]*)\n(?P<text>.*?)^```$", re.MULTILINE | re.DOTALL)
NUMBER = re.compile(r"[-+−]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


class Listing(NamedTuple):
    """One listing of a page."""

    mark: str  # what its comment says; "" without
    kind: str  # language
    text: str


def listings(path):
    """All listings of a page, in order."""
    return [
        Listing(m["mark"] or "", m["kind"], m["text"]) for m in LISTING.finditer(Path(path).read_text()) if m["kind"][:1] != "{"
    ]


def commands(text):
    """(command, lines that it prints) of a console listing."""
    found = []
    for line in text.splitlines():
        if line.startswith("$ "):
            found.append([line[2:], []])
        elif found and not found[-1][1] and found[-1][0].endswith("\\"):
            found[-1][0] += "\n" + line
        elif found:
            found[-1][1].append(line)
    return found


def same(shown, printed, tolerance):
    """Whether a printed text is the one shown: words equal, numbers within `tolerance`, `...` anything, spaces as they come."""
    place = 0
    for piece in re.split(r"\s*\.\.\.\s*", "\n".join(shown)):
        pattern, numbers = _pattern(piece.strip())
        while match := pattern.search(printed, place):
            found = [_number(text) for text in match.groups()]
            if all(abs(a - b) <= tolerance * max(abs(a), abs(b)) for a, b in zip(numbers, found, strict=True)):
                place = match.end()
                break
            place = match.start() + 1
        else:
            return False
    return True


def _number(text):
    return float(text.replace("−", "-"))


def _pattern(piece):
    """(pattern whose groups are the numbers, the numbers) of a piece of what is shown."""
    text = f"({NUMBER.pattern})".join(map(re.escape, NUMBER.split(piece)))
    return re.compile(re.sub(r"(?:\\\s|\s)+", r"\\s+", text)), [_number(number) for number in NUMBER.findall(piece)]


@contextlib.contextmanager
def _inside(folder):
    before = os.getcwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)


def run(path, folder, environment=None):
    """Run the listings of the page in `folder`; returns what did not come out as shown: (command, printed)."""
    wrong, names = [], {"__name__": "page"}
    for listing in listings(path):
        word, _, rest = listing.mark.partition(":")
        if word == "file":
            (folder / rest.strip()).write_text(listing.text)
        elif word == "run" and listing.kind == "python":
            with _inside(folder):
                exec(compile(listing.text, f"{path}", "exec"), names)
        elif word == "run":
            share = re.search(r"within ([\d.]+) %", rest)
            tolerance = float(share.group(1)) / 100 if share else 0.01
            for command, shown in commands(listing.text):
                line, around = ["bash", "-c", command], {**os.environ, **(environment or {})}
                done = subprocess.run(line, cwd=folder, env=around, capture_output=True, text=True, timeout=540)
                # a message on the first use only
                errors = [text for text in done.stderr.splitlines() if not text.startswith("demlaws: compiling")]
                printed = "\n".join([done.stdout, *errors])
                if done.returncode or not same(shown, printed, tolerance):
                    wrong.append((command, printed))
        elif word != "not run":
            raise AssertionError(f"{path}: a listing says neither file, run nor not run:\n{listing.text[:200]}")
    return wrong
