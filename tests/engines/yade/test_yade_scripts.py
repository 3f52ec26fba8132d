"""The command that starts YADE, and every script in yade_scripts, quickly, as a reader of the README would start it."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import size

import demlaws as dl
from demlaws.cli import main
from demlaws.yade import run

PACKAGE = Path(dl.__file__).parent
SCRIPTS = Path(__file__).parents[3] / "yade_scripts"
SAID = {
    "two_spheres": "largest error",
    "impact": "rebound/impact",
    "chain": "pohrt-popov: speed ∝ F^0.28",
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
    run.run(tmp_path / "script.py", [tmp_path / "found.json"], capture_output=True)
    files = json.loads((tmp_path / "found.json").read_text())["loaded"]
    loaded = {Path(file).relative_to(PACKAGE).with_suffix("").as_posix() for file in files}
    assert {"yade/kernel", "yade/shear", "laws/pohrt_popov"} <= loaded
    others = {"yade/curvature", "yade/slip", "yade/public", "core/slip", "curves/tabulate", "shear", "core/levels"}
    others |= {"yade/contacts", "yade/saving"}
    others |= {"solvers/ellipsoid", "solvers/criterion", "responses/batch", "responses/path", "responses/results"}
    assert not loaded & others


# --- the command


@pytest.mark.parametrize(
    ("first", "python"),
    [
        ("#!/usr/bin/python3.13", (3, 13)),
        ("#! {folder}/python3", (3, 99)),
        ("#!/usr/bin/env python3.12", (3, 12)),
        ("#!/bin/sh", None),
    ],
)
def test_python_of_a_start_script(tmp_path, first, python):
    """Debian's names python3.13; YADE's own cmake names the python3 that it found, which links to one."""
    script = tmp_path / "yade"
    (tmp_path / "python3").symlink_to("python3.99")
    script.write_text(f"{first.format(folder=tmp_path)}\nimport sys\n")
    assert run.python_of(script) == python


@pytest.mark.parametrize(("version", "major"), [("1.24.2", 1), ("2.2.4", 2)])
def test_numpy_of_the_systems_packages(tmp_path, monkeypatch, version, major):
    metadata = tmp_path / f"numpy-{version}.dist-info" / "METADATA"
    metadata.parent.mkdir()
    metadata.write_text(f"Metadata-Version: 2.1\nName: numpy\nVersion: {version}\n")
    assert run.numpy_built_for(tmp_path) == major and run.numpy_built_for(tmp_path / "empty") is None
    monkeypatch.setattr(np, "__version__", "2.4.0")
    monkeypatch.setattr(run, "numpy_built_for", lambda: major)
    if major == 2:
        run.environment()
    else:
        with pytest.raises(dl.DemlawsError, match="'numpy<2'"):
            run.environment()


@pytest.mark.slow
def test_run_keeps_the_interpreter(tmp_path):
    """As yade does: input after the script sees its variables; -x leaves; options and arguments go through."""
    script = tmp_path / "script.py"
    script.write_text("import sys, yade\nanswer = 6 * 7\nprint('arguments', sys.argv[1:], 'threads', yade.O.numThreads)\n")
    command = [sys.executable, "-m", "demlaws", "yade", "run"]
    options = {"capture_output": True, "text": True, "timeout": 1200, "cwd": tmp_path, "input": "print('typed', answer)\n"}
    stays = subprocess.run([*command, "--nice=1", "-j2", str(script), "-a", "b"], **options)
    assert "arguments ['-a', 'b'] threads 2" in stays.stdout and "typed 42" in stays.stdout
    leaves = subprocess.run([*command, "-x", str(script)], **options)
    assert "threads 1" in leaves.stdout and "typed" not in leaves.stdout and leaves.returncode == 0


@pytest.mark.slow
def test_a_batch_with_a_job_that_fails(tmp_path, capsys):
    """yade-batch itself ends with status 0."""
    script, table = tmp_path / "s.py", tmp_path / "t.table"
    script.write_text("from yade import utils\nutils.readParamsFromTable(x=1)\nfrom yade.params.table import x\nassert x < 2\n")
    for values, status in (("1\n2\n", 1), ("0\n1\n", 0)):
        table.write_text("x\n" + values)
        assert main(["yade", "run", "--batch", str(table), str(script)]) == status
        assert ("1 of the jobs failed" in capsys.readouterr().err) == bool(status)


def test_command_lines(tmp_path, monkeypatch):
    seen, words = [], ["yade", "run", "--gui", "--cores=0,1", "-f5", str(tmp_path / "s.py"), "-x", "--threads"]
    (tmp_path / "s.py").write_text("")
    monkeypatch.setattr(run, "become", seen.append)
    main(words)
    assert seen[0][1:] == ["-j1", "--cores=0,1", "-f5", str(tmp_path / "s.py"), "-x", "--threads"]
    script = tmp_path / "s.py"
    line = run.command(script, gui=True, stay=True, options=["--cores=0,1"])
    assert line[1:] == ["-j1", "--cores=0,1", str(script)]
    assert run.command(script)[1:] == ["-n", "-x", "-j1", str(script)]
    batch = run.command(script, threads=2, batch=str(script), options=["--cores=0,1"])
    assert batch[0].endswith("yade-batch") and batch[1:] == ["--job-threads=2", "--cores=0,1", str(script), str(script)]
    for name in ("", "nowhere.py", "scene", "scene.txt"):  # a folder; YADE ignores the others and ends with status 0
        if name.startswith("scene"):
            (tmp_path / name).write_text("raise ValueError")
        with pytest.raises(dl.DemlawsError):
            run.command(tmp_path / name)
    (tmp_path / "scene.yade.bz2").write_text("")
    assert run.command(tmp_path / "scene.yade.bz2")[-1].endswith("scene.yade.bz2")


def test_quick_check():
    command = [sys.executable, "-m", "demlaws", "yade", "check", "--quick", "--json"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=3000)
    assert done.returncode == 0, done.stdout + done.stderr
    lines = json.loads(done.stdout)["text"]
    assert any("native bridge: available" in line for line in lines)
    assert sum(line.startswith(tuple(dl.laws())) for line in lines) == 2
