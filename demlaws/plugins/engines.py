"""What LIGGGHTS and LAMMPS share: the plugin compiled into a cache, runs in processes of their own, thermo tables, self-tests.

Importing needs the standard library only: LAMMPS asks for the plugin at every start, and wheels are built without numpy.
"""

import contextlib
import fcntl
import functools
import hashlib
import itertools
import os
import platform
import re
import shutil
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import demlaws
from demlaws.errors import DemlawsError, EngineStopped, handling_signals
from demlaws.files import write_atomically

SHARED = Path(__file__).parents[1] / "cpp"
"""Headers that all plugins include."""

_INCLUDE = re.compile(r'#include "([^"]+)"')


def inlined(name, folders, kept=(), seen=None):
    """Lines of the source file `name`, found in `folders`, with the headers found there, each once, in place of their includes.

    kept: names of headers whose includes stay.
    """
    seen = {name} if seen is None else seen
    for line in next(folder / name for folder in folders if (folder / name).is_file()).read_text().splitlines():
        include = _INCLUDE.match(line)
        inner = include and include.group(1)
        if not inner or inner in kept or not any((folder / inner).is_file() for folder in folders):
            yield line
        elif inner not in seen:
            seen.add(inner)
            yield from inlined(inner, folders, kept, seen)


def write_sources(folder, texts, beside, then):
    """Write {name: text} into `folder`; returns lines that name the files, and what is to be done `then`.

    A file that has its text stays untouched: no build repeats it. beside: a file of the engine's sources by which their folder
    is known.
    """
    folder = Path(folder)
    if not (folder / beside).is_file():
        raise DemlawsError(f"{folder} has no {beside}: name the folder of the engine's sources that does")
    try:
        for name, text in texts.items():
            file = folder / name
            if not file.is_file() or file.read_text() != text:
                file.write_text(text)
    except OSError as error:
        raise DemlawsError(f"cannot write to {folder}: {error.strerror}") from error
    return "\n".join([*(f"wrote {folder / name}" for name in texts), then])


def cache_folder():
    """Where plugins are kept: $DEMLAWS_CACHE, else $XDG_CACHE_HOME/demlaws, else ~/.cache/demlaws; always an absolute path."""
    setting = os.environ.get("DEMLAWS_CACHE")
    if setting:
        return Path(setting).absolute()  # an engine is started in the input's folder
    try:
        return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache").absolute() / "demlaws"
    except RuntimeError:  # neither HOME nor an entry of the user's, as in containers
        raise DemlawsError("this user has no home folder for what is built once and kept: set DEMLAWS_CACHE or HOME") from None


def output_of(command):
    """Output of a command, "" where it fails."""
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout
    except (OSError, subprocess.CalledProcessError):
        return ""


def compiler():
    """Path of $CXX or g++, None where it is absent."""
    return shutil.which(os.environ.get("CXX", "g++"))


def processor():
    """Instruction sets of the processor, as Linux lists them: a library made with -march=native needs the same."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor()
    return next((line for line in lines if line.startswith(("flags", "Features"))), platform.processor())


def _digest(parts):
    digest = hashlib.sha256()
    for part in parts:
        digest.update((part if isinstance(part, bytes) else part.encode()) + b"\0")
    return digest.hexdigest()[:12]


class Plugin:
    """Shared object of an engine's plugin, compiled at first use into a folder of the cache.

    The folder's name has a key of what the plugin is made from and runs on (our sources, the engine's library, the C library,
    the processor): no outdated plugin is loaded, and a node without a compiler takes what another one has compiled.
    """

    engine: str
    file: str  # of the shared object
    sources: Path
    source: str  # the file that is compiled
    # vectorised short loops read in one piece what was just written in two or three: the processor waits
    flags: tuple = ("-std=c++11", "-O3", "-fno-tree-vectorize", "-fno-tree-slp-vectorize", "-ffp-contract=fast")
    flags += ("-fno-math-errno", "-fno-trapping-math", "-fPIC", "-shared", "-w")
    packages: str  # how to install a compiler and headers

    def includes(self):
        """Further include options."""
        return []

    def runs_with(self):
        """Bytes of the engine's library that the plugin is made for."""
        return b""

    def compile_command(self, portable=False):
        """The compiler's command without its output; DemlawsError where something is missing."""
        program = compiler()
        if not program:
            raise DemlawsError(f"compiler {os.environ.get('CXX', 'g++')!r} not found: {self.packages}")
        architecture = [] if portable else ["-march=native"]
        includes = [f"-I{self.sources}", f"-I{SHARED}", *self.includes()]
        return [program, *self.flags, *architecture, *includes, str(self.sources / self.source), *self.links()]

    def source_digest(self):
        """Digest of our sources and flags."""
        files = sorted(file for file in (*self.sources.rglob("*"), *SHARED.glob("*.h")) if file.is_file())
        return _digest([*self.flags, *(part for file in files for part in (file.name, file.read_bytes()))])

    def library_path(self, portable=False):
        """Where the plugin of this version, these sources, this engine and this processor belongs, built or not."""
        machine = [platform.machine(), *platform.libc_ver(), "portable" if portable else processor()]
        key = _digest([self.source_digest(), *machine, self.runs_with()])
        return cache_folder() / f"{self.engine}-{demlaws.__version__}-{key}" / self.file

    def build(self, portable=False, rebuild=False):
        """Path of the plugin's shared object; compiled (seconds to a minute) unless the cache has it.

        portable: without -march=native, for a cluster whose nodes differ (the step costs about 10 % more).
        rebuild: compile in any case, with another compiler, say. Raises DemlawsError that names a missing package, or shows the
        compiler's message.
        """
        if any(mark in str(cache_folder()) for mark in " :"):
            raise DemlawsError(
                f"the cache {cache_folder()} has a space or a colon in its name, at which LD_PRELOAD and LAMMPS_PLUGIN_PATH "
                "split: set DEMLAWS_CACHE to another folder"
            )
        library = self.library_path(portable)
        if rebuild or not _is_whole(library):
            try:
                command = self.compile_command(portable)
            except DemlawsError as missing:
                raise DemlawsError(
                    f"{missing}; nor does the cache {cache_folder()} hold a whole plugin for this processor and engine: where "
                    f"there is a compiler, run `demlaws {self.engine} build --portable` with the same DEMLAWS_CACHE, and here "
                    "use --portable"
                ) from missing
            _compile(command, library, self.packages, rebuild)
        return library


def _is_whole(library):
    """Whether a plugin is as it was compiled: a process that loads half of one ends with a bus error."""
    try:
        return _digest_file(library).read_text() == _digest([library.read_bytes()])
    except OSError:
        return False


def _digest_file(library):
    return library.with_suffix(".digest")


def _compile(command, library, packages, rebuild):
    """Compile elsewhere, then write to the cache by renaming: no other process sees half of the plugin."""
    try:
        library.parent.mkdir(parents=True, exist_ok=True)
        with _locked(library.parent), handling_signals(_stop, signal.SIGTERM, signal.SIGHUP):
            if not rebuild and _is_whole(library):  # another process has compiled it meanwhile
                return
            with tempfile.TemporaryDirectory(prefix="demlaws-") as folder:
                print(f"demlaws: compiling {library.name} (once, about 20 s)", file=sys.stderr)
                made = Path(folder) / library.name
                environment = {**os.environ, "LC_ALL": "C"}
                result = subprocess.run([*command, "-o", str(made)], capture_output=True, text=True, env=environment)
                if result.returncode:
                    message = "\n".join((result.stderr or result.stdout).strip().splitlines()[:12])
                    raise DemlawsError(f"the plugin did not compile ({packages}):\n{message}")
                content = made.read_bytes()
            write_atomically(_digest_file(library), _digest([content]))
            write_atomically(library, content)
    except OSError as error:
        raise DemlawsError(
            f"cannot write to the cache {library.parent}: {error.strerror}; set DEMLAWS_CACHE to a folder you may write to"
        ) from error


@contextlib.contextmanager
def _locked(folder):
    """While one process compiles here, others wait; its death opens the lock."""
    number = os.open(folder, os.O_RDONLY)
    try:
        with contextlib.suppress(OSError):  # a file system without locks: they compile at the same time
            fcntl.flock(number, fcntl.LOCK_EX)
        yield
    finally:
        os.close(number)


FOLDERS_OF_OPEN_MPI = tuple(
    f"OMPI_MCA_{name}" for name in ("orte_tmpdir_base", "btl_vader_backing_directory", "btl_sm_backing_directory")
)
"""Of sessions and shared memory, by the names of versions 4 and 5."""


@contextlib.contextmanager
def own_session(environment):
    """An environment with a folder of its own for files of Open MPI.

    Version 4 removes that of a user's processes when one of them ends, while another one begins in it; its ranks that are
    killed leave their shared memory.
    """
    memory = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None
    with tempfile.TemporaryDirectory(prefix="mpi-", dir=memory, ignore_cleanup_errors=True) as folder:
        yield {name: folder for name in FOLDERS_OF_OPEN_MPI} | dict(environment)


@functools.lru_cache
def mpirun_of(program, path):
    """The first mpirun in the folders of `path` that belongs to the MPI of `program`, and whether that is Open MPI.

    Programs of MPICH and Intel MPI load libmpi.so.12. MPICH's mpirun, which pip installs, may come before Open MPI's.
    """
    open_mpi = not re.search(r"\blibmpi(ch)?\.so\.12\b", output_of(["ldd", program]))
    names = ("mpirun.openmpi", "mpirun") if open_mpi else ("mpiexec.hydra", "mpirun.mpich", "mpirun")
    for folder in path.split(os.pathsep):
        for name in names:
            found = shutil.which(name, path=folder)
            if found and re.search("Open MPI|OpenRTE" if open_mpi else "HYDRA|Intel", output_of([found, "--version"])):
                return found, open_mpi
    remedy = "Open MPI on PATH: sudo apt install openmpi-bin" if open_mpi else f"MPICH on PATH, with which {program} is linked"
    raise DemlawsError(f"no mpirun of {remedy}")


class Engine:
    """A program that runs inputs with the plugin."""

    name: str
    begins: str  # how the line above a thermo table begins
    log: str  # name of the log file

    def start(self, ranks, plugin, portable):
        """(words of the program, environment, variables that load the plugin, mpiexec of the program's own or None)."""
        raise NotImplementedError

    def column(self, word):
        """Name of a thermo column."""
        return word

    def command(self, script, ranks=1, variables=None, *, log=None, plugin=True, portable=False, arguments=()):
        """The command line and the environment of a run; portable: with the plugin that `build(portable=True)` returns.

        arguments: further arguments of the engine's own, such as ("-echo", "screen"). For Open MPI's mpirun, root needs
        --allow-run-as-root and --oversubscribe, more ranks than cores the latter.
        """
        if ranks < 1:
            raise DemlawsError(f"ranks = {ranks}: at least 1")
        program, environment, loading, mpiexec = self.start(ranks, plugin, portable)
        line = [*map(str, program), "-in", str(script), "-log", str(log or self.log)]
        for name, value in (variables or {}).items():
            line += ["-var", name, *(map(str, value) if isinstance(value, (list, tuple)) else [str(value)])]
        line += map(str, arguments)
        open_mpi = False
        if ranks > 1 and not mpiexec:
            mpiexec, open_mpi = mpirun_of(line[0], os.environ.get("PATH", ""))
        if ranks > 1 and not open_mpi:  # MPICH hands the environment on
            line = [str(mpiexec), "-n", str(ranks), *line]
        elif ranks > 1:
            root = os.geteuid() == 0
            mpirun = [mpiexec, "-np", str(ranks), *(["--allow-run-as-root"] if root else [])]
            mpirun += ["--oversubscribe"] if root or ranks > len(os.sched_getaffinity(0)) else []
            for name, value in loading.items():  # for the ranks only, not for mpirun
                mpirun += ["-x", f"{name}={value}"]
            line, loading = mpirun + line, {}
        return line, {**environment, **loading}

    def run(
        self,
        script,
        ranks=1,
        variables=None,
        *,
        folder=None,
        log=None,
        plugin=True,
        echo=False,
        timeout=None,
        portable=False,
        arguments=(),
    ):
        """Run `script` in `folder` (default: the script's own) and return the thermo tables of its output.

        variables: {name: value} for the script's ${name}; echo: show the engine's output as it comes; portable: the plugin
        without -march=native, for a cluster of unlike nodes; arguments: further arguments of the engine's command line.
        Returns a dict column → array over all rows (see `read_log`); empty where the input has no run, or no thermo output.
        Raises EngineStopped with the engine's own error.
        """
        script, log = Path(script), log or self.log
        if folder is None:
            folder, script = script.resolve().parent, Path(script.name)
        if not (Path(folder) / script).is_file():
            raise DemlawsError(f"input {Path(folder) / script} does not exist; `demlaws {self.name.lower()} export` writes one")
        options = {"log": log, "plugin": plugin, "portable": portable, "arguments": arguments}
        line, environment = self.command(script, ranks, variables, **options)
        log_path = Path(folder) / log
        if log_path.is_file():  # of an earlier run
            log_path.unlink()
        with own_session(environment) as environment:
            status, lines = _run(line, folder, environment, echo, timeout)
        log_text = log_lines(log_path) if log_path.is_file() else []
        if status:
            raise EngineStopped(f"{self.name} stopped (exit {status}): {_reason(status, log_text + lines, script)}")
        # the output of another rank may have run into a row; the log is complete unless the input names another one
        printed, logged = (thermo(text, self.begins, self.column) for text in (lines, log_text))
        rows = [len(next(iter(table.values()), ())) for table in (printed, logged)]
        return logged if rows[1] > rows[0] and list(printed) in ([], list(logged)) else printed

    def read_log(self, path):
        """Thermo output of a log: dict column → array, the rows of all runs one after another.

        Rows that a run repeats (its first step is the last one of the run before) are kept once; where the columns change,
        only the rows after the last change are returned. In LAMMPS a column of a variable, compute or fix has its name
        without v_, c_ or f_.
        """
        tables = thermo(log_lines(path), self.begins, self.column)
        if not tables:
            raise DemlawsError(f"{path} holds no thermo output")
        return tables

    def run_path(self, law, text, radius=None, *, rtol=1e-5, folder=None, ranks=1, **variables):
        """One contact on the path of an input: the log, with columns overlap, force, stored, lost, and the law's path.

        law: one contact with ν = 0.25 of two spheres of `radius` (default: equal ones), or of one and a wall.
        """
        with tempfile.TemporaryDirectory() as scratch:
            folder = Path(folder or scratch)
            law.tabulate(rtol=rtol).save(folder / "law.tbl")
            (folder / "in.contact").write_text(text)
            radius = 2 * law.contact.radius if radius is None else radius
            young = 2 * law.contact.modulus * (1 - 0.25**2)
            values = {"young": repr(young), "radius": repr(radius), "table": "law.tbl", **variables}
            log = self.run(folder / "in.contact", ranks, values)
        return log, law.follow(log["overlap"])


def _run(command, folder, environment, echo=False, timeout=None):
    """(exit status, lines of output) of a command in `folder`; echo: shown as they come. What stops us stops it, too."""
    lines = []
    with (
        handling_signals(_stop, signal.SIGTERM, signal.SIGHUP),
        subprocess.Popen(
            command, cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace"
        ) as process,
    ):
        try:
            if echo:
                for text in process.stdout:
                    print(text, end="", flush=True)
                    lines.append(text)
                process.wait()
            else:
                lines = process.communicate(timeout=timeout)[0].splitlines(keepends=True)
        except BaseException:
            process.terminate()  # mpiexec ends its ranks then; killed, it would leave them
            try:
                process.wait(timeout=10)
            except subprocess.TimeoutExpired:
                process.kill()
            raise
    return process.returncode, lines


def _stop(number, frame):
    """Of a signal that would end Python at once and leave the engine at work."""
    raise SystemExit(128 + number)


def _reason(status, lines, script):
    """Why an engine stopped: its own error, else its last lines without the stack that MPI prints after a crash."""
    errors = [at for at, text in enumerate(lines) if text.startswith("ERROR")]
    if errors:  # it may go on over several lines; then comes the line of the input, or MPI's
        after = ("Last ", "For more", "Abort", "application called", "---")
        text = itertools.takewhile(lambda line: line.strip() and not line.startswith(after), lines[errors[-1] :][:8])
        return " ".join(line.strip() for line in text)
    text = [line.strip() for line in lines if line.strip() and not re.match(r"\[[^]]*:\d+\]|-{20}|mpirun |Primary job", line)]
    reason = " | ".join(text[-3:]) or "it printed no message"
    number = -status if status < 0 else status - 128
    if 0 < number < signal.NSIG:
        reason = f"{signal.strsignal(number).lower()}; last output: {reason}"
    return f"{reason}; run {script} with -echo both, which shows the last line that it read"


MOVES = ((-0.2, 6000), (0.2, 3000), (-0.2, 4500), (0.2, 9000), (-0.2, 4000))
"""Speed [m/s] of the second body along x and steps of 10 ns: load, unload, reload, separate, load again."""


def moves(step):
    """Input lines of these moves with a time step [s]."""
    return "".join(f"velocity        right set {speed} 0 0\nrun             {round(n * 1e-8 / step)}\n" for speed, n in MOVES)


def self_test(report, log, path, name, limit):
    """Report how far force and energies of `log` are from the law's `path`; DemlawsError where that is more than `limit`."""
    import numpy as np

    worst = float(np.max(np.abs(log["force"] - path.force)) / np.max(path.force))
    errors = np.abs(log["stored"] - path.stored) + np.abs(log["lost"] - path.dissipated)
    energy = float(np.max(errors) / np.max(path.work))
    line = f"self-test {name}: |force - law| ≤ {worst:.1e} of {path.force.max():.1f} N, energies ≤ {energy:.1e} of the work"
    if not max(worst, energy) <= limit:
        raise DemlawsError(f"{line}; allowed {limit:g}")
    report(line)


def laws_to_check():
    """(law, tolerance of its table, allowed error, name) of the self-tests: one contact of two granite spheres of 17.4 mm."""
    from demlaws.contact import Contact
    from demlaws.laws import USUAL
    from demlaws.make import law

    contact = Contact(radius=4.35e-3, modulus=32.32e9, sigma=2.40e-6, fractal_dimension=2.22)
    for unloading in ("elastic", "hertz"):
        for rtol, limit in ((1e-5, 1e-5), (1e-9, 1e-8)):
            yield law(USUAL, contact, unloading=unloading), rtol, limit, f"{unloading} unloading, table {rtol:g}"


def log_lines(path):
    """Lines of an engine's log."""
    try:
        return Path(path).read_text(errors="replace").splitlines()
    except OSError as error:
        raise DemlawsError(f"cannot read {path}: {error.strerror}") from error


def thermo(lines, begins, column=str):
    """Columns of all thermo tables of LIGGGHTS or LAMMPS: dict name → array; empty without tables.

    A table stands between a line that begins with `begins` and the line "Loop time" of a run; its first line names the
    columns, which may be numbers themselves (LIGGGHTS heads c_1 by 1); column: from such a word to the name of the column.
    Rows that a run repeats (its first step is the last one of the run before) are kept once; where the columns change, only the
    rows after the last change are returned. Of `thermo_style multi` and `yaml` nothing is read.
    """
    import numpy as np

    tables, inside = [], False
    for line in lines:
        if line.startswith(begins):
            inside = True
            tables.append([])
        elif line.startswith("Loop time"):
            inside = False
        elif inside and not line.startswith("WARNING:"):
            tables[-1].append(line.split())
    names, rows = [], []
    for head, *body in filter(None, tables):
        titles = [column(word) for word in head]
        if titles != names:
            names, rows = titles, []
        for words in body:
            with contextlib.suppress(ValueError):
                rows += [list(map(float, words))] if len(words) == len(names) else []
    if not rows:
        return {}
    rows = np.array(rows)
    if "Step" in names:
        step = rows[:, names.index("Step")]
        rows = rows[np.append(True, step[1:] > np.maximum.accumulate(step)[:-1])]
    return dict(zip(names, rows.T, strict=True))
