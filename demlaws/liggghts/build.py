"""The plugin of LIGGGHTS: what it is compiled with, and which library, headers and MPI belong to the binary."""

import os
import re
import shutil
from pathlib import Path

from demlaws.errors import DemlawsError
from demlaws.plugins.engines import SHARED, Plugin, output_of

HEADERS = Path("/usr/include/liggghts")
PACKAGES = "sudo apt install liggghts libliggghts-dev libopenmpi-dev g++"


def header_folder():
    """Folder of demlaws_table.h and the C++11 headers that it includes, for any DEM code."""
    return SHARED


def engine_library():
    """Path of the libliggghts that the binary loads; of a script, say, that which the compiler finds."""
    name = os.environ.get("DEMLAWS_LIGGGHTS", "liggghts")
    binary = shutil.which(name)
    libraries = output_of(["ldd", binary]) if binary else ""
    match = re.search(r"(/\S*/libliggghts[^/\s]*) \(0x", libraries)
    if match:
        return Path(match.group(1))
    if "libliggghts" in libraries:
        raise DemlawsError(f"{binary} does not find its libliggghts: set LD_LIBRARY_PATH to the folder of that library")
    if libraries:
        raise DemlawsError(
            f"{binary} contains LIGGGHTS statically and loads no libliggghts, which the plugin needs: build it with the models "
            "in it (`demlaws liggghts source`), or link main.cpp with the shared library"
        )
    library = Path(output_of([os.environ.get("CXX", "g++"), "-print-file-name=libliggghts.so"]).strip())
    if not library.is_absolute():
        raise DemlawsError(f"neither {name} nor the compiler leads to a libliggghts.so: {PACKAGES}")
    return library


def _is_packaged(library):
    return str(library).startswith(("/lib/", "/usr/lib/"))


def headers():
    """Folder of the headers of the LIGGGHTS in use: those of another one might not fit its memory."""
    setting, library = os.environ.get("DEMLAWS_LIGGGHTS_INCLUDE"), engine_library()
    if setting or _is_packaged(library):
        places = [Path(setting or HEADERS)]
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
        flags = output_of(command).split()
        if flags:
            return [word for flag in flags if flag.startswith("-I") for word in ("-isystem", flag[2:])]
    raise DemlawsError(f"the MPI headers were not found (neither mpicxx nor pkg-config ompi-cxx answers): {PACKAGES}")


def mpi_libraries(library):
    """Paths of the MPI libraries that a libliggghts loads, directly or through others: no other may be in the process."""
    matches = re.findall(r"^\s*(\S*mpi\S*) => (/\S+)", output_of(["ldd", library]), re.M | re.I)
    if not matches:
        raise DemlawsError(f"{library} loads no MPI library that ldd finds: {PACKAGES}")
    return [path for _, path in matches]


class _Plugin(Plugin):
    engine, file, source = "liggghts", "libdemlaws_liggghts.so", "demlaws_liggghts.cpp"
    sources = Path(__file__).parent / "src"
    packages = f"{PACKAGES} (no compiler? `demlaws liggghts export --stock`)"
    flags = (*Plugin.flags, "-DOMPI_SKIP_MPICXX")

    def includes(self):
        return [f"-I{self.sources / 'styles'}", "-isystem", str(headers()), *_mpi_flags()]

    def links(self):
        library = engine_library()
        link = [f"-Wl,--version-script={self.sources / 'export.map'}", "-Wl,--no-undefined", str(library)]
        if not _is_packaged(library):
            link.append(f"-Wl,-rpath,{library.parent}")  # else the loader would find the system's by the same name
        return [*link, "-Wl,--as-needed", *mpi_libraries(library)]  # several of that name; only what is used is linked

    def runs_with(self):
        return engine_library().read_bytes()


PLUGIN = _Plugin()
build, library_path = PLUGIN.build, PLUGIN.library_path
