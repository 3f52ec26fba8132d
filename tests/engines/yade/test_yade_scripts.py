"""Every script in yade_scripts, quickly, as a reader of the README would start it."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
import size

import demlaws
from demlaws.yade.run import run

PACKAGE = Path(demlaws.__file__).parent
SCRIPTS = Path(__file__).parents[3] / "yade_scripts"
SAID = {
    "two_spheres": "largest error",
    "impact": "rebound/impact",
    "facet_and_wall": "combined roughness",
    "save_load": "O.load in a new process",
    "ballast": "exponent n of bulk stiffness",
    "cost": "ratio to native Hertz-Mindlin",
    "measured_surface": "law of mean",
    "examples": "runs by both laws, 0 failed",
}
MORE = {"examples": ["--only", "FEMxDEM", "beside", "batch"]}
"""Arguments beside --quick: all of YADE's examples take minutes."""


def test_every_script_is_tested():
    assert {path.stem for path in SCRIPTS.glob("*.py")} == set(SAID)


@pytest.mark.slow
@pytest.mark.parametrize("name", SAID)
def test_script(name, tmp_path):
    script = SCRIPTS / f"{name}.py"
    command = [sys.executable, "-m", "demlaws", "yade", "run", "-x", str(script), "--quick", "--out", str(tmp_path)]
    command += MORE.get(name, [])
    done = subprocess.run(command, capture_output=True, text=True, timeout=6000, cwd=SCRIPTS.parent)
    assert done.returncode == 0, done.stdout + done.stderr
    assert SAID[name] in done.stdout
    assert (tmp_path / f"{name}.png").stat().st_size > 5000


def test_a_script_with_one_law_loads_no_code_of_other_features(tmp_path):
    (tmp_path / "script.py").write_text(size.SCRIPT)
    run(tmp_path / "script.py", [tmp_path / "found.json"], capture_output=True)
    files = json.loads((tmp_path / "found.json").read_text())["loaded"]
    loaded = {Path(file).relative_to(PACKAGE).with_suffix("").as_posix() for file in files}
    assert {"yade/kernel", "yade/shear", "laws/pohrt_popov"} <= loaded
    others = {"yade/curvature", "yade/slip", "yade/public", "core/slip", "solvers/ellipsoid", "criterion", "curves/tabulate"}
    assert not loaded & (others | {"batch", "files", "path", "results", "shear"})
