"""The same two-sphere impact in the Python driver, in YADE and in LIGGGHTS."""

import importlib.util
import shutil
import sys
from pathlib import Path

import pytest

INPUTS = Path(__file__).parents[2] / "liggghts_inputs"
ABSENT = [name for name in ("liggghts", "yade") if not shutil.which(name)]

pytestmark = [
    pytest.mark.liggghts,
    pytest.mark.yade,
    pytest.mark.skipif(bool(ABSENT), reason=f"not installed: {', '.join(ABSENT)}"),
    pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning"),
]


@pytest.mark.slow
def test_peak_force_and_rebound_agree(monkeypatch):
    monkeypatch.syspath_prepend(str(INPUTS))
    monkeypatch.delitem(sys.modules, "common", raising=False)
    spec = importlib.util.spec_from_file_location("three_way", INPUTS / "impact" / "three_way.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    rows = module.compare()
    assert {row[2] for row in rows} == {"Python", "YADE", "LIGGGHTS"}
    for name, unloading, engine, _, _, force, speed in rows:
        assert max(force, speed) <= 1e-6, (name, unloading, engine, force, speed)
