"""The same impact of two spheres in Python's driver, in YADE, in LIGGGHTS and in LAMMPS."""

import importlib.util
import shutil
import sys
from pathlib import Path

import pytest

INPUTS = Path(__file__).parents[3] / "lammps_inputs"
ABSENT = [name for name in ("liggghts", "yade") if not shutil.which(name)]

pytestmark = [
    pytest.mark.liggghts,
    pytest.mark.yade,
    pytest.mark.skipif(bool(ABSENT), reason=f"not installed: {', '.join(ABSENT)}"),
    pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning"),
]


@pytest.mark.slow
def test_peak_force_and_rebound_agree_in_all_four(monkeypatch):
    monkeypatch.syspath_prepend(str(INPUTS))
    monkeypatch.delitem(sys.modules, "common", raising=False)
    spec = importlib.util.spec_from_file_location("four_way", INPUTS / "impact" / "four_way.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    rows = module.compare()
    sys.modules.pop("common", None)
    assert len(rows) == 12 and {row[2] for row in rows} == {"Python", "YADE", "LIGGGHTS", "LAMMPS"}
    for name, unloading, engine, _, _, force, speed in rows:
        assert max(force, speed) <= 1e-9, (name, unloading, engine, force, speed)
    for name, unloading in {row[:2] for row in rows}:
        peaks = [row[3] for row in rows if row[:2] == (name, unloading)]
        assert max(peaks) / min(peaks) - 1 <= 1e-9, (name, unloading)
