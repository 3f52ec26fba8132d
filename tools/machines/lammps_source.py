#!/usr/bin/env python3
"""LAMMPS built statically from Debian's source package with the models in it, and the engine tests with that program.

    python3 tools/machines/lammps_source.py                   # make lammps-source
    python3 tools/machines/lammps_source.py --shared          # the plugin is tested beside it in the same release
    python3 tools/machines/lammps_source.py --only-build      # prints the path of the program
    python3 tools/machines/lammps_source.py -- -k restart     # further arguments of pytest

The source is that of Debian sid, found with apt's own signatures and without a change to this system's lists. It is kept
with the build in a folder of the cache: the first build takes 5 to 10 minutes on one core, one after a change here half a
minute. Needs g++, cmake, make and an MPI for C++; standard library only. docs/inside/from-source.md says more.

Exit status: 0 all tests passed, 1 the build or a test failed, 2 wrong arguments, 75 no source could be had.
"""

import argparse
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[2]
PYTHON = str(PROJECT / ".venv" / "bin" / "python")
ARCHIVE, SUITE, KEYS = "http://deb.debian.org/debian", "sid", "/usr/share/keyrings/debian-archive-keyring.gpg"
NO_SOURCE = 75  # EX_TEMPFAIL of sysexits.h
UNUSED = ("examples", "doc", "potentials", "bench", "lib/gpu")  # of the archive's 12,000 files
OPTIONS = {"CMAKE_BUILD_TYPE": "Release", "BUILD_MPI": "on", "BUILD_OMP": "off"}
OPTIONS |= {f"PKG_{name}": "on" for name in ("GRANULAR", "GRANSURF", "RIGID")}
OPTIONS |= {f"WITH_{name}": "off" for name in ("JPEG", "PNG", "GZIP", "CURL", "FFMPEG")}
TESTS = ("tests/engines/lammps/test_source.py", "tests/engines/lammps/test_plugin.py", "tests/engines/test_energies.py")
TESTS += ("tests/engines/test_passive_shear.py", "tests/engines/test_plugins.py", "tests/engines/test_refusals.py")
KEPT = "lammps and not radius_at_cylinders and not without_its_list_of_pairs"
"""Walls changed with LAMMPS (no zcylinder, other curvature); a list of pairs that was deleted is made again."""


class NoSource(Exception):
    """The source or a tool to build it is not there, for a reason that lies outside the project."""


class Failed(Exception):
    """The build or a test failed."""


def say(text):
    print(f"lammps-source: {text}", flush=True)


class Work:
    """Downloads, tree and build of LAMMPS below `folder`, with a limit of time."""

    def __init__(self, folder, minutes):
        self.folder, self.ends = folder, time.monotonic() + 60 * minutes
        self.apt = ["-o", "Dir::Etc::sourceparts=/dev/null", "-o", f"Dir::Etc::sourcelist={folder}/sources.list"]
        self.apt += ["-o", f"Dir::State::lists={folder}/lists", "-o", f"Dir::Cache={folder}/cache"]
        self.apt += ["-o", "Acquire::Check-Valid-Until=false", "-o", "Acquire::Retries=3", "-o", "APT::Sandbox::User=root"]

    def run(self, *command, **options):
        """Finished process of a command in a session of its own, all of which ends when no time is left."""
        left = self.ends - time.monotonic()
        if left < 1:
            raise Failed("no time left")
        with subprocess.Popen(command, text=True, start_new_session=True, **options) as process:
            try:
                out, _ = process.communicate(timeout=left)
            except BaseException as error:
                os.killpg(process.pid, signal.SIGTERM)
                if isinstance(error, subprocess.TimeoutExpired):
                    raise Failed(f"no time left: {command[0]} was stopped") from None
                raise
        return subprocess.CompletedProcess(command, process.returncode, out)

    def archive(self):
        """(address, file, digest) of the newest orig archive of package lammps."""
        (self.folder / "lists" / "partial").mkdir(parents=True, exist_ok=True)
        (self.folder / "sources.list").write_text(f"deb-src [signed-by={KEYS}] {ARCHIVE} {SUITE} main\n")
        if self.run("apt-get", *self.apt, "update", "-qq", "-o", "APT::Update::Error-Mode=any").returncode:
            raise NoSource(f"the lists of {ARCHIVE} {SUITE} cannot be read")
        found = self.run("apt-cache", *self.apt, "showsrc", "--only-source", "lammps", stdout=subprocess.PIPE).stdout
        versions = re.findall(r"^Version: (\S+)", found, re.M)
        if not versions:
            raise NoSource(f"{SUITE} has no source package lammps")
        command = ["apt-get", *self.apt, "source", "--print-uris", "-qq", f"lammps={versions[-1]}"]
        uris = self.run(*command, stdout=subprocess.PIPE).stdout
        match = re.search(r"'(\S+)' (\S+\.orig\.tar\.\w+) \d+ (SHA256:\S+)", uris)
        if not match:
            raise NoSource(f"no archive of lammps {versions[-1]} is named")
        return match.groups()

    def tree(self):
        """LAMMPS's source: the one that is kept, else downloaded."""
        mark = self.folder / "unpacked"
        if not mark.exists():
            self.unpack(*self.archive(), mark)
        say(f"LAMMPS of {mark.read_text()}")
        return next(self.folder.glob("tree/**/cmake/CMakeLists.txt")).parents[1]

    def unpack(self, address, file, digest, mark):
        target = self.folder / "tree"
        if self.run("/usr/lib/apt/apt-helper", *self.apt, "download-file", address, str(self.folder / file), digest).returncode:
            raise NoSource(f"{address} cannot be downloaded")
        shutil.rmtree(target, ignore_errors=True)
        target.mkdir()
        excluded = [f"--exclude={name}" for name in UNUSED]
        if self.run("tar", "-xf", str(self.folder / file), "-C", str(target), *excluded).returncode:
            raise Failed(f"{file} cannot be unpacked")
        (self.folder / file).unlink()
        mark.write_text(address)

    def build(self, jobs, shared=False):
        """A program: static and with the models of this checkout, or with shared libraries and as LAMMPS has it."""
        missing = [tool for tool in ("cmake", "make", "g++", "mpicxx") if not shutil.which(tool)]
        if missing:
            raise NoSource(f"no {', '.join(missing)} here: apt-get install cmake make g++ libopenmpi-dev")
        tree = self.tree()
        folder = self.folder / ("build-shared" if shared else "build")
        sources = tree / "src" / "GRANULAR"
        models = [PYTHON, "-m", "demlaws", "lammps", "source", str(sources)]
        if shared:
            models = ["rm", "-f", *map(str, sources.glob("*demlaws*"))]
        options = {"BUILD_SHARED_LIBS": "on" if shared else "off", **OPTIONS}
        with open(f"{folder}.log", "w") as log:
            streams = {"stdout": log, "stderr": subprocess.STDOUT}
            for command in (
                models,
                [
                    "cmake",
                    "-S",
                    str(tree / "cmake"),
                    "-B",
                    str(folder),
                    *(f"-D{name}={value}" for name, value in options.items()),
                ],
                ["nice", "cmake", "--build", str(folder), "-j", str(jobs)],
            ):
                if self.run(*command, cwd=PROJECT, **streams).returncode:
                    print("\n".join(Path(log.name).read_text().splitlines()[-30:]), file=sys.stderr)
                    raise Failed(f"{' '.join(command[:4])}: see {log.name}")
        return folder / "lmp"

    def test(self, program, beside, arguments):
        """The engine tests: those of the sources, which compare with the plugin in LAMMPS `beside` (None: the one that tests
        take), and those of the plugin, with the program.
        """
        compared = {"DEMLAWS_LAMMPS_SOURCE": str(program), **({"DEMLAWS_LAMMPS": str(beside)} if beside else {})}
        for tests, variables in ((TESTS[:1], compared), (TESTS[1:], {"DEMLAWS_LAMMPS": str(program)})):
            line = [PYTHON, "-m", "pytest", "-q", "-n0", "-m", "not slow", "-k", KEPT, *tests, *arguments]
            done = self.run(*line, cwd=PROJECT, env={**os.environ, **variables})
            if done.returncode:
                raise Failed(f"pytest {' '.join(tests)}: exit {done.returncode}")


def main(argv=None):
    argv = sys.argv[1:] if argv is None else argv
    end = argv.index("--") if "--" in argv else len(argv)
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "demlaws-machines" / "lammps"
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--folder", type=Path, default=cache, help="where source and build are kept (default %(default)s)")
    parser.add_argument(
        "--jobs", type=int, default=len(os.sched_getaffinity(0)), help="compilers at once (default %(default)s)"
    )
    parser.add_argument("--minutes", type=float, default=40.0, help="time for everything (default %(default)g)")
    parser.add_argument("--only-build", action="store_true", help="print the path of the program, run no tests")
    parser.add_argument("--shared", action="store_true", help="build LAMMPS with shared libraries, too, for the plugin")
    given = parser.parse_args(argv[:end])
    work, began = Work(given.folder.resolve(), given.minutes), time.monotonic()
    verdict, status = "all passed", 0
    try:
        work.folder.mkdir(parents=True, exist_ok=True)
        beside = work.build(given.jobs, shared=True) if given.shared else None
        program = work.build(given.jobs)
        say(f"{program}, {time.monotonic() - began:.0f} s")
        if given.only_build:
            print(program)
            return 0
        work.test(program, beside, argv[end + 1 :])
    except NoSource as error:
        verdict, status = f"NOT RUN: {error}", NO_SOURCE
    except Failed as error:
        verdict, status = f"FAILED: {error}", 1
    say(f"{verdict}, {time.monotonic() - began:.0f} s in all")
    return status


if __name__ == "__main__":
    sys.exit(main())
