"""Compile the plugin into a cache. Its name holds everything that it depends on, so a stale one is never loaded.

The name has two keys: what it runs on (our sources, LIGGGHTS's library, the processor), and what made it (compiler, headers,
flags). Where there is no compiler, as on a compute node, the newest with the first key serves.
"""

import functools
import hashlib
import os
import platform
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

import demlaws
from demlaws.errors import DemlawsError
from demlaws.processes import cache_folder

SOURCES = Path(__file__).parent / "src"
SHARED = Path(__file__).parent.parent / "cpp"
HEADERS = Path("/usr/include/liggghts")
PACKAGES = "sudo apt install liggghts libliggghts-dev libopenmpi-dev g++"

# Vectorisation of the short loops over x, y, z reads in one piece what was just written in three: the processor waits.
FLAGS = ["-std=c++11", "-O3", "-fno-tree-vectorize", "-fno-tree-slp-vectorize"]
FLAGS += ["-fno-math-errno", "-fno-trapping-math", "-ffp-contract=fast"]
FLAGS += ["-fPIC", "-shared", "-w", "-DOMPI_SKIP_MPICXX"]


def header_folder():
    """Folder of demlaws_table.h, the standalone C++11 header that any DEM code can include."""
    return SHARED


@functools.lru_cache(maxsize=256)
def _answer(command, stamps, environment):
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout
    except (OSError, subprocess.CalledProcessError):
        return ""


def _output(command):
    """What a command prints, "" where it fails. Asked once, as long as the files that it names and the environment stay."""
    files = [Path(shutil.which(word) or word) for word in map(str, command)]
    stamps = tuple(file.stat().st_mtime_ns if file.is_file() else None for file in files)
    return _answer(tuple(command), stamps, frozenset(os.environ.items()))


def _compiler():
    compiler = os.environ.get("CXX", "g++")
    if not shutil.which(compiler):
        raise DemlawsError(f"compiler {compiler!r} not found: {PACKAGES} (no compiler? `demlaws liggghts export --stock`)")
    return compiler


def engine_library():
    """Path of the libliggghts that the binary loads; None where nobody says: no binary, no ldd, a script that starts it."""
    binary = shutil.which(os.environ.get("DEMLAWS_LIGGGHTS", "liggghts"))
    said = _output(["ldd", binary]) if binary else ""
    found = re.search(r"(/\S*/libliggghts[^/\s]*) \(0x", said)
    if found:
        return Path(found.group(1))
    if "libliggghts" in said:
        raise DemlawsError(f"{binary} does not find its libliggghts: set LD_LIBRARY_PATH to the folder of that library")
    if said:
        raise DemlawsError(
            f"{binary} holds LIGGGHTS in itself and loads no libliggghts, through which alone a plugin reaches it: "
            "link main.cpp with the shared library instead (docs/machines.md has the line)"
        )
    return None


def packaged(library):
    """Whether a libliggghts is the system's, or unknown and taken to be so."""
    return library is None or str(library).startswith(("/lib/", "/usr/lib/"))


def headers():
    """Folder of the headers of the LIGGGHTS in use: those of another one might not fit its memory."""
    named, library = os.environ.get("DEMLAWS_LIGGGHTS_INCLUDE"), engine_library()
    if named or packaged(library):
        places = [Path(named or HEADERS)]
    else:
        places = [library.parent.parent / "include", library.parent.parent / "include" / "liggghts"]
    for folder in places:
        if (folder / "contact_models.h").is_file():
            return folder
    raise DemlawsError(
        f"the headers of LIGGGHTS are not in {places[0]}: {PACKAGES}, or set DEMLAWS_LIGGGHTS_INCLUDE to their folder"
    )


def _mpi_flags():
    for command in (["mpicxx", "--showme:compile"], ["pkg-config", "--cflags", "ompi-cxx"]):
        flags = _output(command).split()
        if flags:
            return [word for flag in flags if flag.startswith("-I") for word in ("-isystem", flag[2:])]
    raise DemlawsError(f"the MPI headers were not found (neither mpicxx nor pkg-config ompi-cxx answers): {PACKAGES}")


def linked_library():
    """Path of the libliggghts that the plugin is linked with: the binary's own, else the one that the compiler finds."""
    compiler = os.environ.get("CXX", "g++")
    library = engine_library() or _output([compiler, "-print-file-name=libliggghts.so"]).strip()
    if "/" not in str(library):
        raise DemlawsError(f"{compiler} finds no libliggghts.so: {PACKAGES}")
    return str(library)


def mpi_libraries(library):
    """Paths of the MPI libraries that a libliggghts loads, directly or through others: no other may be in the process."""
    found = re.findall(r"^\s*(\S*mpi\S*) => (/\S+)", _output(["ldd", library]), re.M | re.I)
    if not found:
        raise DemlawsError(f"{library} loads no MPI library that ldd finds: {PACKAGES}")
    return [path for _, path in found]


def compile_command(portable):
    """The compiler's command without its output, and what it links."""
    architecture = [] if portable else ["-march=native"]
    includes = [f"-I{SOURCES / 'styles'}", f"-I{SOURCES}", f"-I{SHARED}"]
    includes += ["-isystem", str(headers()), *_mpi_flags()]  # so that warnings are of our own files only
    compiler = _compiler()
    library = linked_library()
    link = [f"-Wl,--version-script={SOURCES / 'export.map'}", "-Wl,--no-undefined", library]
    if not packaged(library):
        link.append(f"-Wl,-rpath,{Path(library).parent}")  # else the loader would find the system's by the same name
    link += ["-Wl,--as-needed", *mpi_libraries(library)]  # several of that name; only what is used is linked
    return [compiler, *FLAGS, *architecture, *includes, str(SOURCES / "demlaws_liggghts.cpp")], link


def _key(parts):
    digest = hashlib.sha256()
    for part in parts:
        digest.update((part if isinstance(part, bytes) else part.encode()) + b"\0")
    return digest.hexdigest()[:12]


def _processor():
    """What the processor can do, as Linux says it; a library made with -march=native needs the same."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor()
    return next((line for line in lines if line.startswith(("flags", "Features"))), platform.processor())


def _engine():
    """The bytes of LIGGGHTS's library, as the binary loads it."""
    library = engine_library()
    return library.read_bytes() if library else b""


def _runs_on(portable):
    """First part of the plugin's name: what it runs on. Needs no compiler."""
    parts = [demlaws.__version__, platform.machine(), "portable" if portable else _processor(), _engine()]
    for file in sorted([*SOURCES.rglob("*"), *SHARED.glob("*.h")]):
        if file.is_file():
            parts += [file.name, file.read_bytes()]
    return f"libdemlaws_liggghts-{demlaws.__version__}-{_key(parts)}"


def _made_by(command, link, portable):
    parts = [*command, *link, _output([command[0], "--version"])]
    if not portable:  # -march=native means another thing on another processor
        parts.append(_output([command[0], "-march=native", "-Q", "--help=target"]))
    for file in sorted(headers().glob("*.h")):  # an update of LIGGGHTS changes them
        parts.append(f"{file.name} {file.stat().st_size} {file.stat().st_mtime_ns}")
    return _key(parts)


def library_path(portable=False):
    """Where the plugin of this version, these sources, this compiler and these headers belongs, built or not."""
    return cache_folder() / f"{_runs_on(portable)}-{_made_by(*compile_command(portable), portable)}.so"


def _made_elsewhere(portable):
    """The newest plugin in the cache that runs here, whichever compiler made it; None if there is none."""
    made = [file for file in cache_folder().glob(f"{_runs_on(portable)}-*.so") if os.access(file, os.R_OK)]
    return max(made, key=lambda file: file.stat().st_mtime_ns, default=None)


def build(portable=False, force=False):
    """Path of the plugin's shared object; compiled (half a minute to a minute) unless the cache has it.

    portable: without -march=native, for a cluster whose nodes differ (the step costs some 10 % more).
    force: compile even so. Where a compiler or the headers are missing, a plugin that was compiled elsewhere for the same
    sources, LIGGGHTS and processor is taken from the cache. Raises DemlawsError that names the missing package, or shows the
    compiler's message.
    """
    if any(mark in str(cache_folder()) for mark in " :"):
        raise DemlawsError(
            f"the cache {cache_folder()} has a space or a colon in its name, at which LD_PRELOAD splits: "
            "set DEMLAWS_CACHE to another folder"
        )
    engine_library()  # a LIGGGHTS that no plugin reaches is refused before anything else is missed
    try:
        command, link = compile_command(portable)
    except DemlawsError as missing:
        made = None if force else _made_elsewhere(portable)
        if made:
            return made
        raise DemlawsError(
            f"{missing}; nor does the cache {cache_folder()} hold a plugin for this processor and LIGGGHTS: where there is a "
            "compiler, run `demlaws liggghts build --portable` with the same DEMLAWS_CACHE, and here use --portable"
        ) from missing
    library = cache_folder() / f"{_runs_on(portable)}-{_made_by(command, link, portable)}.so"
    if library.is_file() and not force:
        return library
    try:
        library.parent.mkdir(parents=True, exist_ok=True)
        descriptor, temporary = tempfile.mkstemp(prefix=f".{library.stem}.", suffix=".so", dir=library.parent)
    except OSError as error:
        raise DemlawsError(
            f"cannot write to the cache {library.parent}: {error.strerror}; set DEMLAWS_CACHE to a folder you may write to"
        ) from error
    os.close(descriptor)
    try:
        result = subprocess.run([*command, "-o", temporary, *link], capture_output=True, text=True)
        if result.returncode:
            message = "\n".join((result.stderr or result.stdout).strip().splitlines()[:12])
            raise DemlawsError(f"the plugin did not compile; is libliggghts-dev 3.8.0 installed ({PACKAGES})?\n{message}")
        os.chmod(temporary, 0o755)
        os.replace(temporary, library)
    finally:
        if os.path.exists(temporary):
            os.unlink(temporary)
    return library
