#!/usr/bin/env python3
"""YADE built from Debian's source package with the options of its own CMakeLists, and the engine tests with that program.

    python3 tools/machines/yade_source.py                         # make yade-source
    python3 tools/machines/yade_source.py --compiler clang++-14   # in folders of its own beside the first
    python3 tools/machines/yade_source.py --only-build            # prints the path of the start script
    python3 tools/machines/yade_source.py -- -k restart           # further arguments of pytest

The libraries common and dem with OpenMP; all other features are off. The flags are YADE's default, -O3 -DNDEBUG. CMake compiles
16 sources at once, so that the headers of Boost and Eigen are read 25 times, not 200 times. A compiler needs 2.5 GB of memory.
docs/inside/from-source.md says more.

Exit status: 0 all tests passed, 1 the build or a test failed, 2 wrong arguments, 75 no source could be had.
"""

import os
import sys

import source

UNUSED = ("examples",)
OPTIONS = {"CMAKE_BUILD_TYPE": "Release", "DISABLE_ALL": "ON", "ENABLE_OPENMP": "ON", "DISABLE_PKGS": "polyhedra,openfoam"}
OPTIONS |= {"CMAKE_UNITY_BUILD": "ON", "CMAKE_UNITY_BUILD_BATCH_SIZE": "16", "DISABLE_SAVE_TEMPS": "ON"}
OPTIONS |= {"PYTHON_EXECUTABLE": "/usr/bin/python3"}
BOOST = "libboost-{python,thread,date-time,filesystem,iostreams,regex,serialization,system,log,chrono}-dev"
NEEDED = {"cmake": "cmake", "make": "make", "/usr/include/boost/python.hpp": BOOST, "/usr/include/bzlib.h": "libbz2-dev"}
NEEDED |= {"/usr/include/eigen3/Eigen/Core": "libeigen3-dev", "/usr/include/sqlite3.h": "libsqlite3-dev"}
EDITS = {
    "py/high-precision/_math.cpp": [
        ("//#ifndef __clang__ //", "#ifndef __clang__ //"),
        ("\n};\n//#endif\n\ntemplate", "\n};\n#endif\n\ntemplate"),
    ],
    "py/high-precision/_minieigenHP.cpp": [
        (
            "\t\tArbitraryReal_from_python<RealHP<N>>();\n",
            "#ifndef __clang__\n\t\tArbitraryReal_from_python<RealHP<N>>();\n#endif\n",
        )
    ],
}
"""For clang, which compiles templates for more precision than double, too."""
NEEDED |= {"/usr/lib/python3/dist-packages/pygraphviz": "python3-pygraphviz python3-sphinx python3-tk python3-xlib"}


def edit(path, edits):
    """Replace texts in a file that has not been edited before."""
    text = path.read_text()
    new = text
    for old, replacement in edits:
        new = new if replacement in new else new.replace(old, replacement)
    if new != text:  # an unchanged file is not compiled again
        path.write_text(new)


def build(work, compiler, jobs):
    """Path of the start script of YADE compiled by `compiler`."""
    work.needs(NEEDED | {compiler: compiler})
    tree = work.tree("CMakeLists.txt", UNUSED)
    for name, edits in EDITS.items():
        edit(tree / name, edits)
    folder, target = work.folder / f"build-{compiler}", work.folder / compiler
    options = OPTIONS | {"CMAKE_CXX_COMPILER": compiler, "CMAKE_INSTALL_PREFIX": target}
    install = ["nice", "cmake", "--build", folder, "--target", "install", "-j", jobs]
    work.commands(f"{folder}.log", source.cmake(tree, folder, options), install)
    return next(path for path in (target / "bin").glob("yade-*") if not path.name.endswith(("-batch", ".py")))


def test(work, program, arguments):
    """`demlaws yade check` and the engine tests of YADE."""
    variables = {"YADE": str(program)}
    line = [source.PYTHON, "-m", "demlaws", "yade", "check"]
    if status := work.run(*line, cwd=source.PROJECT, env={**os.environ, **variables}).returncode:
        raise source.Failed(f"demlaws yade check: exit {status}")
    work.pytest(["tests/engines"], ["-m", "yade and not slow", "-rs", *arguments], variables)


def main(argv=None):
    parser = source.parser(__doc__)
    parser.add_argument("--compiler", default="g++", help="of C++ (default %(default)s)")
    given, more = source.arguments(parser, "yade", 240.0, sys.argv[1:] if argv is None else argv)
    return source.outcome(
        "yade", given, lambda work: build(work, given.compiler, given.jobs), lambda work, path: test(work, path, more)
    )


if __name__ == "__main__":
    sys.exit(main())
