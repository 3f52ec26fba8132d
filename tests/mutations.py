#!/usr/bin/env python3
"""Mutation test: change one number or one condition of the package at a time and check that its tests notice.

    python tests/mutations.py                           # all mutations: some twenty minutes on one core
    python tests/mutations.py --only rms --only E*      # those whose names contain one of these texts
    python tests/mutations.py --jobs 2 --out mutations.txt
    python tests/mutations.py --tests "test_report.py -k published_answer"  # is it noticed by the validation report?
    python tests/mutations.py --list                    # the mutations, after a check that each matches its source

mutations.txt lists them. Most are 2 % of a coefficient, an exponent or a factor; the last group changes logic. Each names a
source file, the changed expression in its context and the tests that must fail. Files and tests are looked up by name, so that
a file may move to another folder. A mutation whose expression is not found exactly once is an error, reported before any test
runs.

Every test runs in a temporary copy of the working tree; the tree itself is never changed. Tests that failed under a mutation
are repeated without it: a test that fails there, too, has caught nothing. Exit status: 0 if every mutation was caught, else 1.
"""

import argparse
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

PROJECT = Path(__file__).resolve().parents[1]
TIME_LIMIT = 900  # [s] per mutation; a mutation whose tests do not end has been noticed
CHANGE = re.compile(r"<<(.*?) -> (.*?)>>", re.S)


class Mutation(NamedTuple):
    """One change of the package."""

    name: str
    file: str  # pattern of the end of the path
    tests: str  # test files by name, then options of pytest
    edits: list  # expressions with the change marked as <<old -> new>>


def read_mutations(path):
    """The mutations of a text file, whose first lines describe its format."""
    found = []
    for line in path.read_text().splitlines():
        if line.startswith("    "):
            found[-1].edits.append(line.strip())
        elif line and not line.startswith("#"):
            name, file, tests = map(str.strip, line.split(" | "))
            found.append(Mutation(name, file, tests, []))
    return found


def source_of(tree, mutation):
    """(path, new text) of the only source file that fits the pattern of a mutation and in which it can be made."""
    found, reasons = [], []
    for path in sorted(path for path in (tree / "demlaws").rglob("*.*") if path.match(mutation.file)):
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


def problem_of(mutation):
    """Why a mutation cannot be made in the working tree, or None."""
    try:
        arguments_of(PROJECT, mutation.tests)
        source_of(PROJECT, mutation)
    except LookupError as error:
        return f"{mutation.name}: {error}"
    return None


class Tree:
    """A temporary copy of the working tree in which one process at a time runs tests."""

    def __init__(self, folder):
        listed = ["git", "ls-files", "--cached", "--others", "--exclude-standard", "-z"]
        names = subprocess.run(listed, cwd=PROJECT, capture_output=True, text=True, check=True).stdout.split("\0")
        for name in names:
            if name and (PROJECT / name).is_file():
                (folder / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(PROJECT / name, folder / name)
        self.path = folder
        self.edits = 0

    def pytest(self, *arguments):
        """Exit status and output of pytest in this tree."""
        environment = {**os.environ, "PYTHONPATH": str(self.path), "NUMBA_CACHE_DIR": str(self.path.parent / "numba")}
        environment.pop("CI", None)
        command = [sys.executable, "-m", "pytest", "-x", "-q", "--no-header", "--tb=no", "-rfE", "-m", "not slow"]
        command += ["-p", "no:cacheprovider", "--hypothesis-seed=0", *arguments]
        try:
            ran = subprocess.run(
                command, cwd=self.path, env=environment, capture_output=True, text=True, timeout=TIME_LIMIT, check=False
            )
        except subprocess.TimeoutExpired:
            return 1, "FAILED time limit"
        return ran.returncode, ran.stdout + ran.stderr

    def try_mutation(self, mutation):
        """(what failed or None, seconds) of the tests of a mutation."""
        (source, changed), began = source_of(self.path, mutation), time.monotonic()
        original = source.read_text()
        try:
            self._write(source, changed)
            status, output = self.pytest(*arguments_of(self.path, mutation.tests))
        finally:
            self._write(source, original)
        failed = re.search(r"^(?:FAILED|ERROR) (.+?)(?: - .*)?$", output, re.M)
        if status not in (0, 1, 2) or (status and not failed):
            raise RuntimeError(f"{mutation.name}: pytest ended with {status}:\n{output[-2000:]}")
        return (failed.group(1) if status else None), time.monotonic() - began

    def _write(self, source, text):
        """Write a source file with a time stamp of its own, so that no compiled file of Python is taken for current."""
        source.write_text(text)
        self.edits += 2
        os.utime(source, (time.time() + self.edits, time.time() + self.edits))


def run(mutations, jobs, write):
    """Try the mutations; returns what failed by mutation (None: it survived)."""
    failures = {}
    with tempfile.TemporaryDirectory(prefix="mutations-") as folder:
        trees = [Tree(Path(folder, f"tree{n}")) for n in range(jobs)]
        free, lock = list(trees), threading.Lock()

        def work(mutation):
            with lock:
                tree = free.pop()
            try:
                failed, seconds = tree.try_mutation(mutation)
            finally:
                with lock:
                    free.append(tree)
            with lock:
                failures[mutation.name] = failed
                write(f"{'survived' if failed is None else 'caught':9}{mutation.name:45}{seconds:6.0f} s  {failed or ''}")

        with ThreadPoolExecutor(jobs) as pool:
            list(pool.map(work, mutations))
        tests = sorted({failed for failed in failures.values() if failed and "::" in failed})
        if tests:  # without -x: every test that fails without a mutation is to be named
            _, output = trees[0].pytest("--maxfail=1000", *tests)
            for test in re.findall(r"^(?:FAILED|ERROR) (.+?)(?: - .*)?$", output, re.M):
                write(f"fails without a mutation: {test}")
                failures.update((name, None) for name, failed in failures.items() if failed == test)
    return failures


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", action="append", metavar="TEXT", help="mutations whose name contains TEXT; may be repeated")
    parser.add_argument("--tests", metavar="ARGUMENTS", help="test files and options of pytest in place of each mutation's own")
    parser.add_argument("--jobs", type=int, default=1, help="mutations tried at the same time (default: 1)")
    parser.add_argument("--out", metavar="FILE", help="also write the table to FILE")
    parser.add_argument("--list", action="store_true", help="list the mutations and check that each can be made")
    options = parser.parse_args(arguments)
    chosen = [
        m
        for m in read_mutations(Path(__file__).with_suffix(".txt"))
        if not options.only or any(text in m.name for text in options.only)
    ]
    if options.tests:
        chosen = [mutation._replace(tests=options.tests) for mutation in chosen]
    problems = [problem for problem in map(problem_of, chosen) if problem]
    if problems or not chosen:
        print("\n".join(problems) or "no mutation has such a name", file=sys.stderr)
        return 1
    if options.list:
        print("\n".join(f"{mutation.name:45}{mutation.file}" for mutation in chosen))
        return 0
    lines = []

    def write(line):
        lines.append(line)
        print(line, flush=True)
        if options.out:
            Path(options.out).write_text("\n".join(lines) + "\n")

    failures = run(chosen, max(options.jobs, 1), write)
    survivors = [name for name, failed in failures.items() if failed is None]
    write(f"{len(failures) - len(survivors)} of {len(failures)} mutations caught")
    if survivors:
        write(f"survived: {', '.join(survivors)}")
    return 1 if survivors else 0


if __name__ == "__main__":
    sys.exit(main())
