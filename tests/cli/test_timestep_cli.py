"""`demlaws timestep` on dumps of LIGGGHTS and LAMMPS; saved scenes are read in tests/engines/yade."""

import math
import shutil
from pathlib import Path

import pytest

import demlaws as dl
from demlaws.cli import main

RADIUS, FORCE = 4e-3, 20.0
GRANITE = ["--law", "hertz", "--young", "60.6GPa", "--poisson", "0.25", "--density", "2680"]
DATA = Path(__file__).parents[1] / "data" / "dumps"


def dumps(folder, engine):
    """A periodic simple cubic lattice with FORCE in each contact, and an open contact, as exported cases dump it."""
    paths = folder / "grains.txt", folder / "contacts.txt"
    for path, name in zip(paths, ("grains.txt", f"contacts-{engine}.txt"), strict=True):
        shutil.copy(DATA / name, path)
    return [str(path) for path in paths]


@pytest.mark.parametrize("engine", ["liggghts", "lammps"])
def test_limit_of_a_lattice(tmp_path, capsys, engine):
    """2/ω with ω² = 2/3 Z 5 r K/m; a law that unloads more stiffly has a smaller one."""
    files = dumps(tmp_path, engine)
    assert main(["timestep", *files, *GRANITE]) == 0
    values = {line[:16].strip(): float(line[16:].split()[0]) for line in capsys.readouterr().out.splitlines()[1:]}
    law = dl.law("hertz", dl.Contact(RADIUS / 2, 0.5 * dl.Material(60.6e9, 0.25).plane_modulus))
    mass, stiffness = 4 / 3 * math.pi * RADIUS**3 * 2680, law.stiffness(law.overlap(FORCE))
    limit = 2.0 / math.sqrt(20 * 1.5 / 1.75 * stiffness / mass)
    assert values["exact limit"] == pytest.approx(limit, rel=1e-3)
    assert values["rigorous bound"] == pytest.approx(limit, rel=1e-3)
    assert values["recommended step"] == pytest.approx(0.8 * limit, rel=1e-3)
    rayleigh = math.pi * RADIUS * math.sqrt(2680 * 2.5 / 60.6e9) / (0.1631 * 0.25 + 0.8766)
    assert values["Rayleigh step"] == pytest.approx(rayleigh, rel=1e-3)
    surface = ["--law", "pohrt-popov", "--combined-roughness", "2.4um", "--fractal-dimension", "2.2", *GRANITE[2:]]
    exact = []
    for rule in ("elastic", "hertz"):
        assert main(["timestep", *files, *surface, "--unloading", rule]) == 0
        exact.append(float(capsys.readouterr().out.splitlines()[1].split()[2]))
    assert exact[1] < 0.95 * exact[0]


@pytest.mark.parametrize(
    ("change", "which"),
    [
        (lambda t: t.replace("\n7\n", "\n8\n"), 0),  # another step
        (lambda t: t[: len(t) // 2], 1),
        (lambda t: t.replace("ENTRIES", "THINGS"), 1),
        (lambda t: t.replace("radius", "size"), 0),
        (lambda t: "no dump at all", 0),
        (lambda t: t.replace("pp pp pp", "ff ff ff"), 0),  # contacts of grains far apart
        (lambda t: t.replace("1 1 17 ", "1 1 999 "), 1),
        (lambda t: t.replace("-20", "0"), 1),
        (lambda t: t.replace("1 1 17 -", "1 1 1 -"), 1),
    ],
)
def test_bad_dumps_are_refused_in_one_line(tmp_path, capsys, change, which):
    files = dumps(tmp_path, "lammps")
    path = Path(files[which])
    path.write_text(change(path.read_text()))
    assert main(["timestep", *files, *GRANITE]) == 2
    message = capsys.readouterr().err
    assert message.startswith("demlaws: error: ") and message.count("\n") == 1


def test_what_is_missing_is_refused(tmp_path):
    files = dumps(tmp_path, "lammps")
    columns = ["--columns", "2", "3", "4", "5", "60"]
    for arguments in ([files[0]], files, [*files, *GRANITE, *columns], ["none.txt"], [*files, "--law", "hertz"]):
        assert main(["timestep", *arguments]) == 2
