"""The plugin's shared object: the one that the wheel brings, or one compiled into the cache. Only the standard library."""

import hashlib
import os
import platform
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import demlaws
from demlaws.errors import DemlawsError
from demlaws.processes import cache_folder

SOURCES = Path(__file__).parent / "src"
SHARED = Path(__file__).parent.parent / "cpp"
NAME = "demlawsplugin.so"
"""LAMMPS loads what ends in plugin.so from the folders of LAMMPS_PLUGIN_PATH."""

PACKAGED = Path(__file__).parent / "lib"
"""Where the wheel has the plugin, compiled for any processor, and the digest of the sources that it was made of."""

PACKAGES = "sudo apt install g++"
FLAGS = ["-std=c++11", "-O3", "-fno-math-errno", "-fno-trapping-math", "-ffp-contract=fast", "-w"]
FLAGS += ["-fPIC", "-shared", "-fvisibility=hidden"]
FLAGS += ["-fno-tree-slp-vectorize"]  # a pair read at once where two numbers were just written makes the processor wait


def compile_command(output, compiler="g++", portable=False):
    """The command that makes the plugin: nothing of LAMMPS or MPI is in it."""
    architecture = [] if portable else ["-march=native"]
    link = [f"-Wl,--version-script={SOURCES / 'export.map'}", "-Wl,-z,nodelete", "-Wl,--no-undefined"]
    source = str(SOURCES / "demlaws_lammps.cpp")
    return [compiler, *FLAGS, *architecture, f"-I{SOURCES}", f"-I{SHARED}", *link, source, "-o", str(output), "-ldl"]


def sources_digest():
    """Digest of the sources and the flags."""
    digest = hashlib.sha256(" ".join(FLAGS).encode())
    for file in sorted([*SOURCES.glob("*"), *SHARED.glob("*.h")]):
        if file.is_file():
            digest.update(file.name.encode() + b"\0" + file.read_bytes())
    return digest.hexdigest()[:16]


def packaged():
    """The wheel's plugin, or None where there is none or it is not of these sources."""
    library, made_of = PACKAGED / NAME, PACKAGED / "sources"
    try:
        if library.is_file() and made_of.read_text().strip() == sources_digest():
            return library
    except OSError:
        pass
    return None


def _output(command):
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout
    except (OSError, subprocess.CalledProcessError):
        return ""


def compiler():
    """$CXX or g++, None where it is absent."""
    return shutil.which(os.environ.get("CXX", "g++"))


def library_path(portable=False):
    """Where the plugin of these sources and this compiler belongs in the cache, built or not."""
    digest = hashlib.sha256(sources_digest().encode())
    command = compile_command("", compiler() or "g++", portable)
    parts = [demlaws.__version__, *command, _output([command[0], "--version"]), platform.machine()]
    if not portable:  # -march=native means another thing on another processor
        parts.append(_output([command[0], "-march=native", "-Q", "--help=target"]))
    for text in parts:
        digest.update(text.encode() + b"\0")
    return cache_folder() / f"lammps-{demlaws.__version__}-{digest.hexdigest()[:16]}" / NAME


def build(portable=False, force=False):
    """Path of the plugin's shared object for LAMMPS; compiled (5 s) unless the cache has it.

    portable: for any processor of this kind; where the wheel brings that one, it is taken. Without a compiler the wheel's
    is taken, too. force: compile even so. Raises DemlawsError that names the missing package, or shows the compiler's
    message.
    """
    ready = packaged()
    if ready and not force and (portable or not compiler()):
        return ready
    found = compiler()
    if not found:
        raise DemlawsError(
            f"compiler {os.environ.get('CXX', 'g++')!r} not found, and no wheel of demlaws with the plugin: {PACKAGES}"
        )
    library = library_path(portable)
    if any(mark in str(library) for mark in " :"):
        raise DemlawsError(
            f"the cache {cache_folder()} has a space or a colon in its name, at which LD_PRELOAD and LAMMPS_PLUGIN_PATH split: "
            "set DEMLAWS_CACHE to another folder"
        )
    if library.is_file() and not force:
        return library
    try:
        library.parent.mkdir(parents=True, exist_ok=True)
        descriptor, temporary = tempfile.mkstemp(prefix=".new.", suffix=".so", dir=library.parent)
    except OSError as error:
        raise DemlawsError(
            f"cannot write to the cache {library.parent}: {error.strerror}; set DEMLAWS_CACHE to a folder you may write to"
        ) from error
    os.close(descriptor)
    try:
        result = subprocess.run(compile_command(temporary, found, portable), capture_output=True, text=True)
        if result.returncode:
            message = "\n".join((result.stderr or result.stdout).strip().splitlines()[:12])
            raise DemlawsError(f"the plugin did not compile with {found}:\n{message}")
        os.chmod(temporary, 0o755)
        os.replace(temporary, library)
    finally:
        if os.path.exists(temporary):
            os.unlink(temporary)
    return library


def plugin_folder():
    """Folder of the plugin, for LAMMPS's entry point `lammps.plugins`: what it names is loaded whenever `lmp` starts.

    Never raises, for that would keep LAMMPS from starting: without a plugin a folder that holds none, and a line that says why.
    """
    try:
        return str((packaged() or build()).parent)
    except Exception as error:
        print(f"demlaws: no plugin for LAMMPS: {error}", file=sys.stderr)
        return str(PACKAGED)
