"""Compile the plugin into a cache. The key is everything that the result depends on, so a stale one is never loaded."""

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


def cache_folder():
    """$DEMLAWS_CACHE, else $XDG_CACHE_HOME/demlaws, else ~/.cache/demlaws."""
    named = os.environ.get("DEMLAWS_CACHE")
    if named:
        return Path(named)
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "demlaws"


def _output(command):
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout
    except (OSError, subprocess.CalledProcessError):
        return ""


def _compiler():
    compiler = os.environ.get("CXX", "g++")
    if not shutil.which(compiler):
        raise DemlawsError(f"compiler {compiler!r} not found: {PACKAGES} (no compiler? `demlaws liggghts export --stock`)")
    return compiler


def _headers():
    folder = Path(os.environ.get("DEMLAWS_LIGGGHTS_INCLUDE", HEADERS))
    if not (folder / "contact_models.h").is_file():
        raise DemlawsError(
            f"the headers of LIGGGHTS are not in {folder}: {PACKAGES}, or set DEMLAWS_LIGGGHTS_INCLUDE to their folder"
        )
    return folder


def _mpi_flags():
    for command in (["mpicxx", "--showme:compile"], ["pkg-config", "--cflags", "ompi-cxx"]):
        flags = _output(command).split()
        if flags:
            return [flag for flag in flags if flag.startswith("-I")]
    raise DemlawsError(f"the MPI headers were not found (neither mpicxx nor pkg-config ompi-cxx answers): {PACKAGES}")


def _mpi_libraries(compiler):
    """Paths of the MPI libraries that libliggghts itself loads, directly or through others: no other may be in the process."""
    library = _output([compiler, "-print-file-name=libliggghts.so"]).strip()
    if "/" not in library:
        raise DemlawsError(f"{compiler} finds no libliggghts.so: {PACKAGES}")
    found = re.findall(r"^\s*(\S*mpi\S*) => (/\S+)", _output(["ldd", library]), re.M | re.I)
    if not found:
        raise DemlawsError(f"{library} loads no MPI library that ldd finds: {PACKAGES}")
    return [path for _, path in found]


def _command(portable):
    architecture = [] if portable else ["-march=native"]
    headers = _headers()
    includes = [f"-I{SOURCES / 'styles'}", f"-I{SOURCES}", f"-I{SHARED}", f"-I{headers}", *_mpi_flags()]
    compiler = _compiler()
    link = [f"-Wl,--version-script={SOURCES / 'export.map'}", "-Wl,--no-undefined", "-lliggghts"]
    link += ["-Wl,--as-needed", *_mpi_libraries(compiler)]  # several of that name; only what is used is linked
    return [compiler, *FLAGS, *architecture, *includes, str(SOURCES / "demlaws_liggghts.cpp")], link


def _key(command, link, portable):
    digest = hashlib.sha256()
    parts = [demlaws.__version__, *command, *link, _output([command[0], "--version"]), platform.machine()]
    if not portable:  # -march=native means another thing on another processor
        parts.append(_output([command[0], "-march=native", "-Q", "--help=target"]))
    for text in parts:
        digest.update(text.encode() + b"\0")
    for file in sorted([*SOURCES.rglob("*"), *SHARED.glob("*.h")]):
        if file.is_file():
            digest.update(file.name.encode() + b"\0" + file.read_bytes())
    for file in sorted(_headers().glob("*.h")):  # an update of LIGGGHTS changes them
        digest.update(f"{file.name} {file.stat().st_size} {file.stat().st_mtime_ns}".encode())
    return digest.hexdigest()[:16]


def library_path(portable=False):
    """Where the plugin of this version, these sources, this compiler and these headers belongs, built or not."""
    command, link = _command(portable)
    return cache_folder() / f"libdemlaws_liggghts-{demlaws.__version__}-{_key(command, link, portable)}.so"


def build(portable=False, force=False):
    """Path of the plugin's shared object; compiled (about 10 s) unless the cache has it.

    portable: without -march=native, for a cluster whose nodes differ (the step costs some 10 % more).
    force: compile even so. Raises DemlawsError that names the missing package, or shows the compiler's message.
    """
    command, link = _command(portable)
    library = cache_folder() / f"libdemlaws_liggghts-{demlaws.__version__}-{_key(command, link, portable)}.so"
    if any(mark in str(library) for mark in " :"):
        raise DemlawsError(
            f"the cache {library.parent} has a space or a colon in its name, at which LD_PRELOAD splits: "
            "set DEMLAWS_CACHE to another folder"
        )
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
