"""The command that starts YADE, and every script in yade_scripts, quickly, as a reader of the README would start it."""

import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import size
from yade_scenes import needs

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
    "split_stone": "4 stones split at 0.6",
}
MORE = {"examples": ["--only", "FEMxDEM", "beside", "batch"]}
"""Arguments beside --quick: all of YADE's examples take minutes."""
YADES = Path("/usr/share/doc/yade")
CDM = 'Law2_ScGeom_MindlinPhysCDM_HertzMindlinCDM(label="lawHMCDM")'
BESIDE = ',\n                 Law2_ScGeom_MindlinPhys_Mindlin(label="lawHM")'


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
    others = {"yade/curvature", "yade/slip", "yade/public", "core/slip", "curves/tabulate", "shear"}
    others |= {"yade/contacts", "yade/saving"}
    others |= {"solvers/ellipsoid", "solvers/criterion", "responses/batch", "responses/path", "responses/results"}
    assert not loaded & others


def of_conical_damage(path, tmp_path, native, end):
    """Printed lines of a script of YADE's Conical Damage Model after its last line `end`, with the native functor or ours."""
    text = (YADES / path).read_text().replace("\nplot.plot()", "")
    assert text.count(CDM) == 1
    if not native:
        ours = 'Law2_ScGeom_MindlinPhys_Demlaws("conical-damage", shear="native", label="lawHMCDM")'
        text = "from demlaws.yade import Law2_ScGeom_MindlinPhys_Demlaws\n" + text.replace(CDM, ours).replace(BESIDE, "")
    (tmp_path / "script.py").write_text("class YadeCheckError(Exception):\n    pass\n" + text + end)
    done = run.run(tmp_path / "script.py", capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return [line.removeprefix("ROW ") for line in done.stdout.splitlines() if line.startswith("ROW ")]


def test_yades_check_of_the_conical_damage_model_passes(tmp_path):
    """Overlap, force, phys.R and stress to 1e-5 of the script's own values, on a facet, a wall and a sphere."""
    needs("CGAL")  # without it YADE's script does nothing
    script = "scripts/checks-and-tests/checks/checkHertzExtended.py"
    assert of_conical_damage(script, tmp_path, False, '\nprint("ROW", lawHMCDM.ratioYieldingContacts())\n') == ["1.0"]


@pytest.mark.slow
def test_yades_example_of_the_conical_damage_model_is_that_of_the_native_law(tmp_path):
    """Periodic packing with c1 = 1.3: mean stress, phys.R, ratioYieldingContacts() and friction of its own addData()."""
    script = "examples/test/HertzMindlinExtended/HertzMindlinExtended_periodicSimpleShear.py"
    end = "\nO.run(2400, True)\naddData()\nprint('ROW', *(plot.data[name][-1] for name in NAMES))\n"
    end = end.replace("NAMES", "('szz', 'averageContactRadius', 'PercentYieldCont', 'averageMu')")
    native, ours = (of_conical_damage(script, tmp_path, native, end)[0].split() for native in (True, False))
    assert np.array(ours, float) == pytest.approx(np.array(native, float), rel=1e-3)
    assert float(native[2]) > 50.0 and float(native[1]) > 0.06


# --- the command


def program(path, text="#!/bin/sh\n"):
    path.write_text(text)
    path.chmod(0o755)
    return str(path)


def test_the_interpreter_of_a_start_script_is_asked(tmp_path):
    """Debian's script names python3.13, YADE's own cmake the python3 that it found; a script of the shell names none."""
    own = program(tmp_path / "python3", "#!/bin/sh\necho 3 99 1\n")
    assert run.python_of(program(tmp_path / "own", f"#! {own} -u\n".replace(" -u", ""))) == ((3, 99), 1)
    here = program(tmp_path / "python-here", f'#!/bin/sh\nexec "{sys.executable}" "$@"\n')  # #! takes no blank in a path
    python, numpy = run.python_of(program(tmp_path / "here", f"#!{here}\n"))
    assert python == sys.version_info[:2] and numpy in (1, 2)
    for first in ("#!/bin/sh", f"#!{tmp_path}/python3.7", ""):  # the shell, a Python that was removed, a program
        assert run.python_of(program(tmp_path / f"other{len(first)}", first + "\n")) is None


@pytest.mark.parametrize(("answer", "named"), [("3 9 1", "runs on Python 3.9"), ("{} {} 1", "'numpy<2'"), ("{} {} 2", None)])
def test_another_python_or_numpy_of_yade_is_refused(tmp_path, monkeypatch, answer, named):
    python = program(tmp_path / "python3", f"#!/bin/sh\necho {answer.format(*sys.version_info[:2])}\n")
    monkeypatch.setenv("YADE", program(tmp_path / "yade-own", f"#!{python}\n"))
    monkeypatch.setattr(np, "__version__", "2.4.0")
    if named is None:
        run.environment()
    else:
        with pytest.raises(dl.DemlawsError, match=named) as failure:
            run.environment()
        assert "yade-own" in str(failure.value)


def test_builds_of_other_names_are_found(tmp_path, monkeypatch):
    """Packages of every day and builds with a suffix; two are named, none is chosen; their batch program is their own."""
    unreadable = tmp_path / ("a" * 300)  # the system refuses it to root, too, as it refuses /root/bin after `su stranger`
    monkeypatch.setenv("PATH", f"{unreadable}:{tmp_path}")
    monkeypatch.delenv("YADE", raising=False)
    daily = program(tmp_path / "yadedaily")
    batch = program(tmp_path / "yadedaily-batch")
    (tmp_path / "yadedaily.py").symlink_to("yadedaily")  # as YADE's cmake installs
    assert (run.executable(), run.executable("yade-batch")) == (daily, batch)
    own = program(tmp_path / "yade-2026.1.0")
    with pytest.raises(dl.DemlawsError, match="set YADE to one of them") as failure:
        run.executable()
    assert daily in str(failure.value) and own in str(failure.value) and batch not in str(failure.value)
    monkeypatch.setenv("YADE", "yade-2026")
    with pytest.raises(dl.DemlawsError, match=r"'yade-2026' not found; there is .*yade-2026\.1\.0"):
        run.executable()
    monkeypatch.setenv("YADE", own)
    assert run.executable() == own
    with pytest.raises(dl.DemlawsError, match="batch' not found: it belongs to"):
        run.executable("yade-batch")
    monkeypatch.delenv("YADE")
    debian = program(tmp_path / "yade")
    assert run.executable() == debian
    monkeypatch.setenv("YADE", "yade-2026")
    with pytest.raises(dl.DemlawsError, match=rf"there is {re.escape(debian)}, "):
        run.executable()


@pytest.mark.parametrize("lists", ["yade\nyade-data", "yadedaily", None])
def test_a_package_is_advised_where_there_is_one(tmp_path, monkeypatch, lists):
    """Ubuntu 24.04 has none; other systems have no apt-cache."""
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("YADE", raising=False)
    if lists is not None:
        program(tmp_path / "apt-cache", f"#!/bin/sh\necho '{lists}'\n")
    with pytest.raises(dl.DemlawsError, match="'yade' not found: ") as failure:
        run.executable()
    advised = "apt install yade" in str(failure.value)
    assert advised == (lists is not None and lists.startswith("yade\n"))
    assert advised or "no package yade" in str(failure.value)


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
    monkeypatch.setattr(run, "exec_yade", seen.append)
    main(words)
    assert seen[0][1:] == ["-j1", "--cores=0,1", "-f5", str(tmp_path / "s.py"), "-x", "--threads"]
    script = tmp_path / "s.py"
    line = run.command(script, gui=True, stay=True, options=["--cores=0,1"])
    assert line[1:] == ["-j1", "--cores=0,1", str(script)]
    assert run.command(script)[1:] == ["-n", "-x", "-j1", str(script)]
    batch = run.command(script, threads=2, batch=str(script), options=["--cores=0,1"])
    assert batch[0] == f"{run.executable()}-batch" and batch[1:] == ["--job-threads=2", "--cores=0,1", str(script), str(script)]
    for name in ("", "nowhere.py", "scene", "scene.txt"):  # a folder; YADE ignores the others and ends with status 0
        if name.startswith("scene"):
            (tmp_path / name).write_text("raise ValueError")
        with pytest.raises(dl.DemlawsError):
            run.command(tmp_path / name)
    (tmp_path / "scene.yade.bz2").write_text("")
    assert run.command(tmp_path / "scene.yade.bz2")[-1].endswith("scene.yade.bz2")


def test_a_program_that_is_not_yade_passes_no_check(monkeypatch, capsys):
    """It ends with status 0, as a check that passed."""
    monkeypatch.setenv("YADE", "/bin/true")
    assert main(["yade", "check", "--quick"]) != 0
    assert "/bin/true" in capsys.readouterr().err


def test_quick_check():
    command = [sys.executable, "-m", "demlaws", "yade", "check", "--quick", "--json"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=3000)
    assert done.returncode == 0, done.stdout + done.stderr
    lines = json.loads(done.stdout)["text"]
    assert any("native bridge: available" in line for line in lines)
    assert sum(line.startswith(tuple(dl.laws())) for line in lines) == 2
