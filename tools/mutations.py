#!/usr/bin/env python3
"""Mutation test: change one number or one condition of the package at a time and check that its tests notice.

    python tools/mutations.py                           # all mutations: about twenty minutes on one core
    python tools/mutations.py --only rms --only E*      # those whose names contain one of these texts
    python tools/mutations.py --jobs 2
    python tools/mutations.py --tests "test_report.py -k published_answer"  # is it noticed by the validation report?
    python tools/mutations.py --list                    # the mutations, after a check that each matches its source
    python tools/mutations.py --table docs/tables/mutations.csv   # also write the page's table, with --tests its last column
    python tools/mutations.py --table docs/tables/mutations.csv --missing  # those that the table has as "not tried"

mutations.txt lists them. Most are 2 % of a coefficient, an exponent or a factor; the last group changes logic. Each names a
source file, the changed expression in its context and the tests that must fail. Files and tests are looked up by name, so that
a file may move to another folder. A mutation whose expression is not found exactly once is an error, reported before any test
runs.

Every test runs in a temporary copy of the working tree; the tree itself is never changed. Tests that failed under a mutation
are repeated without it: a test that fails there, too, has caught nothing. Exit status: 0 if every mutation was caught, else 1.
"""

import argparse
import csv
import functools
import os
import queue
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

PROJECT = Path(__file__).resolve().parents[1]
PART = 20
"""Mutations whose results are kept together."""
TIMED_OUT = "time limit"
TIME_LIMIT = 900  # [s] per mutation; a mutation whose tests do not end has been noticed
CHANGE = re.compile(r"<<(.*?) -> (.*?)>>", re.S)


class Mutation(NamedTuple):
    """One change of the package."""

    name: str
    file: str  # pattern of the end of the path
    tests: str  # test files by name, then options of pytest
    edits: list  # expressions with the change marked as <<old -> new>>
    part: str = ""  # heading in mutations.txt

    @property
    def change(self):
        """The changes alone, in one line."""
        return "; ".join(" → ".join(map(str.strip, pair)) for edit in self.edits for pair in CHANGE.findall(edit))


def read_mutations(path):
    """The mutations of a text file, whose first lines describe its format."""
    found, part = [], ""
    for line in path.read_text().splitlines():
        if line.startswith("    "):
            found[-1].edits.append(line.strip())
        elif line.startswith("#"):
            part = line.lstrip("# ")
        elif line:
            name, file, tests = map(str.strip, line.split(" | "))
            found.append(Mutation(name, file, tests, [], part[:1].upper() + part[1:]))
    return found


@functools.cache
def sources_below(tree):
    """Paths of the package's sources, without the thousands of folders of machine code beside them."""
    found = []
    for folder, folders, names in os.walk(tree / "demlaws"):
        folders[:] = [name for name in folders if name != "__pycache__"]
        found += [Path(folder) / name for name in names]
    return sorted(found)


def source_of(tree, mutation):
    """(path, new text) of the only source file that fits the pattern of a mutation and in which it can be made."""
    found, reasons = [], []
    for path in (path for path in sources_below(tree) if path.match(mutation.file)):
        try:
            found.append((path, mutated(path.read_text(), mutation.edits)))
        except LookupError as error:
            reasons.append(str(error))
    if len(found) != 1:
        raise LookupError(f"{mutation.file}: " + (reasons[0] if len(reasons) == 1 else f"{len(found)} files fit"))
    return found[0]


def mutated(text, edits):
    """The text with every edit made; LookupError where an edit does not match exactly once."""
    for edit in edits:
        parts = CHANGE.split(edit)  # context, old, new, context, …
        pattern, new = "", []
        for n, part in enumerate(parts):
            if n % 3 == 2:
                new.append(part.strip())
            else:
                pattern += "(" + r"\s*".join(re.escape(word) for word in re.split(r"\s+", part)) + ")"
        matches = list(re.finditer(pattern, text))
        if len(matches) != 1 or not new:
            raise LookupError(f"{len(matches)} matches of: {edit}")
        (match,) = matches
        pieces = list(match.groups())
        pieces[1::2] = new
        text = text[: match.start()] + "".join(pieces) + text[match.end() :]
    return text


def arguments_of(tree, tests):
    """The arguments of pytest, with the path of every test file."""
    arguments = []
    for word in shlex.split(tests):
        found = [path for path in (tree / "tests").rglob("*.py") if path.match(word)] if word.endswith(".py") else [word]
        if len(found) != 1:
            raise LookupError(f"{len(found)} test files are called {word}")
        arguments.append(str(found[0]))
    return arguments


def copy_tree(folder):
    """The files of the working tree that git knows or would add, in a new folder."""
    listed = ["git", "ls-files", "--cached", "--others", "--exclude-standard", "-z"]
    for name in subprocess.run(listed, cwd=PROJECT, capture_output=True, text=True, check=True).stdout.split("\0"):
        if name and (PROJECT / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(PROJECT / name, folder / name)
    return folder


def run_pytest(tree, *arguments):
    """What pytest in a copy prints, and its exit status; None beyond the time limit."""
    changes = {"PYTHONPATH": str(tree), "NUMBA_CACHE_DIR": str(tree.parent / "numba"), "PYTHONDONTWRITEBYTECODE": "1", "CI": ""}
    command = [
        sys.executable,
        "-m",
        "pytest",
        "-q",
        "-m",
        "not slow",
        "-p",
        "no:cacheprovider",
        "--hypothesis-seed=0",
        *arguments,
    ]
    try:
        return subprocess.run(command, cwd=tree, env=os.environ | changes, capture_output=True, text=True, timeout=TIME_LIMIT)
    except subprocess.TimeoutExpired:
        return None


def pytest(tree, *arguments):
    """Tests that fail in a copy, by name."""
    ran = run_pytest(tree, "-x", "--no-header", "--tb=no", "-rfE", *arguments)
    if ran is None:
        return [TIMED_OUT]
    failed = re.findall(r"^(?:FAILED|ERROR) (.+?)(?: - .*)?$", ran.stdout, re.M)
    if bool(ran.returncode) != bool(failed):
        raise RuntimeError(f"pytest ended with {ran.returncode}:\n{(ran.stdout + ran.stderr)[-2000:]}")
    return failed


def collected(tree, tests):
    """Those of the tests that are there without a mutation: it may have made the parameters of its test."""
    ran = run_pytest(tree, "--collect-only", *sorted({test.partition("[")[0] for test in tests})) if tests else None
    return [test for test in tests if ran is None or test in ran.stdout.splitlines()]


def failing(tree, mutation):
    """The test that fails in a copy with the mutation; None: it survived."""
    source, changed = source_of(tree, mutation)
    original = source.read_text()
    try:
        source.write_text(changed)
        return next(iter(pytest(tree, *arguments_of(tree, mutation.tests))), None)
    finally:
        source.write_text(original)


def run(mutations, jobs, found=lambda failures: None):
    """Try the mutations; returns what failed by mutation (None: it survived).

    found: called with the results so far after every PART of them.
    """
    failures, trees = {}, queue.Queue()
    with tempfile.TemporaryDirectory(prefix="mutations-") as folder:
        for n in range(jobs):
            trees.put(copy_tree(Path(folder, f"tree{n}")))
        for first in range(0, len(mutations), PART):
            failures |= run_part(mutations[first : first + PART], jobs, trees)
            found(failures)
    return failures


def run_part(mutations, jobs, trees):
    """The results of some mutations, tried in copies of the tree."""
    failures = {}

    def work(mutation):
        tree = trees.get()
        try:
            failures[mutation.name] = failed = failing(tree, mutation)
        finally:
            trees.put(tree)
        print(f"{'survived' if failed is None else 'caught':9}{mutation.name:45}{failed or ''}", flush=True)

    with ThreadPoolExecutor(jobs) as pool:
        list(pool.map(work, mutations))
    tests = sorted({failed for failed in failures.values() if failed and failed != TIMED_OUT})
    tree = trees.get()
    there = collected(tree, tests)
    for test in pytest(tree, "--maxfail=1000", *there) if there else ():  # every one that fails is to be named
        print(f"fails without a mutation: {test}")
        failures.update((name, None) for name, failed in failures.items() if failed == test)
    trees.put(tree)
    return failures


HEADS = ("part", "changed", "from → to", "detected by the test", "by the report")
UNTRIED = "not tried"


def rows_of(path):
    """{name: row} of the page's table."""
    with open(path, newline="") as file:
        return {row["changed"]: row for row in csv.DictReader(file)}


def keep(path, known, failures, report):
    """Write the page's table: a row per known mutation, with the results of this run; the others stay, or are UNTRIED."""
    old = rows_of(path)
    column = HEADS[4 if report else 3]
    with open(path, "w", newline="") as file:
        writer = csv.DictWriter(file, HEADS, lineterminator="\n")
        writer.writeheader()
        for mutation in known:
            row = dict.fromkeys(HEADS[3:], UNTRIED) | old.get(mutation.name, {})
            row |= dict(zip(HEADS, (mutation.part, mutation.name, mutation.change), strict=False))
            if mutation.name in failures:
                failed = failures[mutation.name]
                test = failed and failed.rpartition("::")[2]
                row[column] = "no" if test is None else "yes: " + test.partition("[")[2].rstrip("]") if report else test
            writer.writerow(row)


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", action="append", metavar="TEXT", help="mutations whose name contains TEXT; may be repeated")
    parser.add_argument("--tests", metavar="ARGUMENTS", help="test files and options of pytest in place of each mutation's own")
    parser.add_argument("--jobs", type=int, default=1, help="mutations tried at the same time (default: 1)")
    parser.add_argument("--list", action="store_true", help="list the mutations and check that each can be made")
    parser.add_argument("--table", type=Path, metavar="FILE", help="CSV file in which the results of this run are written, too")
    parser.add_argument("--missing", action="store_true", help="only those without a result in the table")
    options = parser.parse_args(arguments)
    if options.missing and not options.table:
        parser.error("--missing needs --table FILE")
    known = read_mutations(Path(__file__).with_suffix(".txt"))
    chosen = [m for m in known if not options.only or any(text in m.name for text in options.only)]
    if options.missing:
        there = rows_of(options.table)
        chosen = [m for m in chosen if there.get(m.name, {}).get(HEADS[4 if options.tests else 3], UNTRIED) == UNTRIED]
    if options.tests:
        chosen = [mutation._replace(tests=options.tests) for mutation in chosen]
    problems = []
    for mutation in chosen:
        try:
            arguments_of(PROJECT, mutation.tests), source_of(PROJECT, mutation)
        except LookupError as error:
            problems.append(f"{mutation.name}: {error}")
    if problems or not chosen:
        print("\n".join(problems) or "no mutation has such a name, or each has its result", file=sys.stderr)
        return 1
    if options.list:
        print("\n".join(f"{mutation.name:45}{mutation.file}" for mutation in chosen))
        return 0

    def found(failures):
        if options.table:
            keep(options.table, known, failures, bool(options.tests))

    failures = run(chosen, max(options.jobs, 1), found)
    survivors = [name for name, failed in failures.items() if failed is None]
    print(f"{len(failures) - len(survivors)} of {len(failures)} mutations caught")
    if survivors:
        print(f"survived: {', '.join(survivors)}")
    return 1 if survivors else 0


if __name__ == "__main__":
    sys.exit(main())
