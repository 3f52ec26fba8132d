"""Tests that run the real LIGGGHTS; skipped only where it, its headers or a compiler is absent."""

import os
import shutil
import sys
from pathlib import Path

import pytest

import demlaws as dl
from demlaws.errors import DemlawsError
from demlaws.liggghts.build import headers

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))  # inputs_for_liggghts.py, inputs that the tests share


def _headers():
    try:
        return headers()
    except DemlawsError:
        return None


ABSENT = [
    name
    for name, there in (
        ("liggghts", shutil.which(os.environ.get("DEMLAWS_LIGGGHTS", "liggghts"))),
        ("mpirun", shutil.which("mpirun")),
        ("g++", shutil.which("g++")),
        ("libliggghts-dev", _headers()),
    )
    if not there
]


def pytest_collection_modifyitems(items):
    for item in items:
        if HERE in Path(item.fspath).parents:
            item.add_marker(pytest.mark.liggghts)
            if ABSENT:
                item.add_marker(pytest.mark.skip(reason=f"not installed: {', '.join(ABSENT)}"))


@pytest.fixture(scope="session")
def granite_pair():
    """Two granite spheres of 17.4 mm."""
    return dl.Contact(radius=4.35e-3, modulus=32.32e9, roughness=2.40e-6, fractal_dimension=2.22, hardness=6.266e9)
