"""An engine's source package of Debian sid, unpacked and compiled below a folder: for lammps_source.py and yade_source.py.

The source is found with apt's own signatures and without a change to this system's lists. It is kept with the builds, by
default in a folder of the cache. Standard library only.
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

from run import mirror

PROJECT = Path(__file__).resolve().parents[2]
PYTHON = str(PROJECT / ".venv" / "bin" / "python")
SUITE, KEYS = "sid", "/usr/share/keyrings/debian-archive-keyring.gpg"
NO_SOURCE = 75  # EX_TEMPFAIL of sysexits.h


class NoSource(Exception):
    """The source or a tool to build it is not there, for a reason that lies outside the project."""


class Failed(Exception):
    """The build or a test failed."""


class Work:
    """Downloads, tree and builds of the source package `name` below `folder`, with a limit of time."""

    def __init__(self, name, folder, minutes):
        self.name, self.folder, self.ends = name, folder, time.monotonic() + 60 * minutes
        self.apt = ["-o", "Dir::Etc::sourceparts=/dev/null", "-o", f"Dir::Etc::sourcelist={folder}/sources.list"]
        self.apt += ["-o", f"Dir::State::lists={folder}/lists", "-o", f"Dir::Cache={folder}/cache"]
        self.apt += ["-o", "Acquire::Check-Valid-Until=false", "-o", "Acquire::Retries=3", "-o", "APT::Sandbox::User=root"]

    def say(self, text):
        print(f"{self.name}-source: {text}", flush=True)

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
        """(address, file, digest) of the newest orig archive of the package."""
        debian = mirror()
        if debian is None:
            raise NoSource("this system's apt reads no archive of Debian")
        (self.folder / "lists" / "partial").mkdir(parents=True, exist_ok=True)
        (self.folder / "sources.list").write_text(f"deb-src [signed-by={KEYS}] {debian} {SUITE} main\n")
        if self.run("apt-get", *self.apt, "update", "-qq", "-o", "APT::Update::Error-Mode=any").returncode:
            raise NoSource(f"the lists of {debian} {SUITE} cannot be read")
        found = self.run("apt-cache", *self.apt, "showsrc", "--only-source", self.name, stdout=subprocess.PIPE).stdout
        versions = re.findall(r"^Version: (\S+)", found, re.M)
        if not versions:
            raise NoSource(f"{SUITE} has no source package {self.name}")
        command = ["apt-get", *self.apt, "source", "--print-uris", "-qq", f"{self.name}={versions[-1]}"]
        uris = self.run(*command, stdout=subprocess.PIPE).stdout
        match = re.search(r"'(\S+)' (\S+\.orig\.tar\.\w+) \d+ (SHA256:\S+)", uris)
        if not match:
            raise NoSource(f"no archive of {self.name} {versions[-1]} is named")
        return match.groups()

    def tree(self, script, unused=()):
        """Folder of the source that has cmake's `script`: kept, else downloaded and unpacked without the folders `unused`."""
        mark, target = self.folder / "unpacked", self.folder / "tree"
        if not mark.exists():
            address, file, digest = self.archive()
            self.unpack(target, address, file, digest, unused)
            mark.write_text(address)
        self.say(f"source {mark.read_text()}")
        return next(path for path in (target, *target.iterdir()) if (path / script).is_file())

    def unpack(self, target, address, file, digest, unused):
        if self.run("/usr/lib/apt/apt-helper", *self.apt, "download-file", address, str(self.folder / file), digest).returncode:
            raise NoSource(f"{address} cannot be downloaded")
        shutil.rmtree(target, ignore_errors=True)
        target.mkdir()
        excluded = [f"--exclude={name}" for name in unused]
        if self.run("tar", "-xf", str(self.folder / file), "-C", str(target), *excluded).returncode:
            raise Failed(f"{file} cannot be unpacked")
        (self.folder / file).unlink()

    def needs(self, packages):
        """Check that programs and files are there: {program on the path or path of a file: package of Debian}."""
        missing = [tool for tool in packages if not (os.path.exists(tool) if "/" in tool else shutil.which(tool))]
        if missing:
            names = " ".join(dict.fromkeys(packages[tool] for tool in missing))
            raise NoSource(f"no {', '.join(missing)} here: apt-get install {names}")

    def commands(self, log, *lines):
        """Run lines of words one after the other, with their output in the file `log`."""
        with open(log, "w") as file:
            for line in lines:
                if self.run(*map(str, line), cwd=PROJECT, stdout=file, stderr=subprocess.STDOUT).returncode:
                    print("\n".join(Path(log).read_text().splitlines()[-30:]), file=sys.stderr)
                    raise Failed(f"{' '.join(map(str, line[:4]))}: see {log}")

    def pytest(self, tests, arguments, variables):
        """Tests of this checkout, which must pass."""
        line = [PYTHON, "-m", "pytest", "-q", "-n0", *tests, *arguments]
        if status := self.run(*line, cwd=PROJECT, env={**os.environ, **variables}).returncode:
            raise Failed(f"pytest {' '.join(tests)}: exit {status}")


def cmake(source, build, options):
    """A command line that configures `source` in the folder `build`."""
    return ["cmake", "-S", source, "-B", build, *(f"-D{name}={value}" for name, value in options.items())]


def arguments(parser, name, minutes, argv):
    """(what is given to a script, arguments of pytest after `--`); `parser` has the script's own options."""
    end = argv.index("--") if "--" in argv else len(argv)
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "demlaws-machines" / name
    parser.add_argument("--folder", type=Path, default=cache, help="where source and build are kept (default %(default)s)")
    cores = len(os.sched_getaffinity(0))
    parser.add_argument("--jobs", type=int, default=cores, help="compilers at once (default %(default)s)")
    parser.add_argument("--minutes", type=float, default=minutes, help="time for everything (default %(default)g)")
    parser.add_argument("--only-build", action="store_true", help="print the path of the program, run no tests")
    return parser.parse_args(argv[:end]), argv[end + 1 :]


def parser(description):
    return argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)


def outcome(name, given, build, test):
    """Exit status: `build(work)` returns the path of the program, with which `test(work, program)` runs the tests."""
    work, began = Work(name, given.folder.resolve(), given.minutes), time.monotonic()
    verdict, status = "all passed", 0
    try:
        work.folder.mkdir(parents=True, exist_ok=True)
        program = build(work)
        work.say(f"{program}, {time.monotonic() - began:.0f} s")
        if given.only_build:
            print(program)
            return 0
        test(work, program)
    except NoSource as error:
        verdict, status = f"NOT RUN: {error}", NO_SOURCE
    except Failed as error:
        verdict, status = f"FAILED: {error}", 1
    work.say(f"{verdict}, {time.monotonic() - began:.0f} s in all")
    return status
