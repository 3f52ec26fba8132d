#!/usr/bin/env python3
"""LAMMPS built statically from Debian's source package with the models in it, and the engine tests with that program.

    python3 tools/machines/lammps_source.py                   # make lammps-source
    python3 tools/machines/lammps_source.py --shared          # the plugin is tested beside it in the same release
    python3 tools/machines/lammps_source.py --only-build      # prints the path of the program
    python3 tools/machines/lammps_source.py -- -k restart     # further arguments of pytest

The first build takes 5 to 10 minutes on one core, one after a change here half a minute. Needs g++, cmake, make and an MPI for
C++. docs/inside/from-source.md says more.

Exit status: 0 all tests passed, 1 the build or a test failed, 2 wrong arguments, 75 no source could be had.
"""

import sys

import source

UNUSED = ("examples", "doc", "potentials", "bench", "lib/gpu")  # of the archive's 12,000 files
OPTIONS = {"CMAKE_BUILD_TYPE": "Release", "BUILD_MPI": "on", "BUILD_OMP": "off"}
OPTIONS |= {f"PKG_{name}": "on" for name in ("GRANULAR", "GRANSURF", "RIGID")}
OPTIONS |= {f"WITH_{name}": "off" for name in ("JPEG", "PNG", "GZIP", "CURL", "FFMPEG")}
TOOLS = {"cmake": "cmake", "make": "make", "g++": "g++", "mpicxx": "libopenmpi-dev"}
TESTS = ("tests/engines/lammps/test_source.py", "tests/engines/lammps/test_plugin.py", "tests/engines/test_energies.py")
TESTS += ("tests/engines/test_passive_shear.py", "tests/engines/test_plugins.py", "tests/engines/test_refusals.py")
KEPT = "lammps and not radius_at_cylinders and not without_its_list_of_pairs"
"""Walls changed with LAMMPS (no zcylinder, other curvature); a list of pairs that was deleted is made again."""


def build(work, jobs, shared=False):
    """A program: static and with the models of this checkout, or with shared libraries and as LAMMPS has it."""
    work.needs(TOOLS)
    tree = work.tree("cmake/CMakeLists.txt", UNUSED)
    folder = work.folder / ("build-shared" if shared else "build")
    sources = tree / "src" / "GRANULAR"
    models = [source.PYTHON, "-m", "demlaws", "lammps", "source", sources]
    if shared:
        models = ["rm", "-f", *sources.glob("*demlaws*")]
    configure = source.cmake(tree / "cmake", folder, {"BUILD_SHARED_LIBS": "on" if shared else "off", **OPTIONS})
    work.commands(f"{folder}.log", models, configure, ["nice", "cmake", "--build", folder, "-j", jobs])
    return folder / "lmp"


def test(work, program, beside, arguments):
    """The engine tests: those of the sources, which compare with the plugin in LAMMPS `beside` (None: the one that tests
    take), and those of the plugin, with the program.
    """
    compared = {"DEMLAWS_LAMMPS_SOURCE": str(program), **({"DEMLAWS_LAMMPS": str(beside)} if beside else {})}
    for tests, variables in ((TESTS[:1], compared), (TESTS[1:], {"DEMLAWS_LAMMPS": str(program)})):
        work.pytest(tests, ["-m", "not slow", "-k", KEPT, *arguments], variables)


def main(argv=None):
    parser = source.parser(__doc__)
    parser.add_argument("--shared", action="store_true", help="build LAMMPS with shared libraries, too, for the plugin")
    given, more = source.arguments(parser, "lammps", 40.0, sys.argv[1:] if argv is None else argv)
    beside = []

    def built(work):
        beside.append(build(work, given.jobs, shared=True) if given.shared else None)
        return build(work, given.jobs)

    return source.outcome("lammps", given, built, lambda work, program: test(work, program, beside[0], more))


if __name__ == "__main__":
    sys.exit(main())
