"""What the inputs of LIGGGHTS and LAMMPS have in common: they are run, refused and compared alike."""

import importlib
import math
import os
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest
from processes import parted

import demlaws as dl
from demlaws.errors import DemlawsError

GRANITE = dl.Material(young=60.6e9, poisson=0.25, hardness=6.266e9, density=2650.0)
ROUGH = dl.Surface(roughness=1.7e-6, fractal_dimension=2.22)
HOME = os.pathsep.join(p for p in (str(Path(dl.__file__).parents[1]), os.environ.get("PYTHONPATH")) if p)
"""PYTHONPATH of a process in another folder."""
LOAD_UNLOAD = [(-0.2, 0, 1000), (0.2, 0, 600), (-0.2, 0, 800), (0.2, 0, 1800), (-0.2, 0, 800)]
ENERGY = {"more": "compute e all demlaws/energy", "columns": "c_e[1] c_e[2]"}
SCENE = """\
{head}
region          box block -0.03 0.03 -0.02 0.02 -0.02 0.02 units box
create_box      2 box
neighbor        1e-4 bin
neigh_modify    delay 0
{style}
timestep        {step}
create_atoms    1 single {left!r} 0 0 units box
create_atoms    2 single {right!r} 0 0 units box
set             atom 1 diameter {d1!r} density 2650
set             atom 2 diameter {d2!r} density 2650
"""
WATCH = """\
group           left id 1
group           right id 2
fix             move all nve/noforce
variable        overlap equal "0.5*({d1!r}+{d2!r})-(xcm(right,x)-xcm(left,x))"
compute         pull right reduce sum fx fy
variable        force equal c_pull[1]
variable        side equal c_pull[2]
{more}
thermo_style    custom step v_overlap v_force v_side {columns}
thermo_modify   format float %.17e lost ignore norm no
thermo          {every}
"""


def part(engine, name):
    """A module of an engine: in its package, functions have the names of modules."""
    return importlib.import_module(f"demlaws.{engine}.{name}")


def moves_of(moves):
    """Lines that move the group `right`; moves: (speed along x, along y, steps)."""
    return "".join(f"velocity right set {along} {across} 0\nrun {steps}\n" for along, across, steps in moves)


def watched(d1=17.4e-3, d2=17.4e-3, every=20, more="", columns=""):
    """Lines that make two spheres known, and the columns of the log."""
    return WATCH.format(d1=d1, d2=d2, every=every, more=more, columns=columns)


def scene(head, style, moves, step, d1=17.4e-3, d2=17.4e-3, left=0.0, **watch):
    """An input of two spheres of types 1 and 2, 0.1 µm apart; moves: (speed along x, along y, steps) of the second."""
    values = {"d1": d1, "d2": d2, "left": left, "right": left + 0.5 * (d1 + d2) + 1e-7}
    return SCENE.format(head=head, style=style, step=step, **values) + watched(d1, d2, **watch) + moves_of(moves)


def simulate(engine, folder, text, ranks=1, **options):
    (folder / "in.case").write_text(text)
    return part(engine, "run").run(folder / "in.case", ranks, **options)


def started(engine, folder, text, ranks=1, variables=None, away=None, elsewhere=None, environment=(), **options):
    """The engine, run to its end, whatever it is; away: a rank in a folder of its own, which has the files `elsewhere`."""
    (folder / "in.case").write_text(text)
    run = part(engine, "run")
    line, more = run.command("in.case", ranks, variables, **options)
    if away is not None:
        program = run.executable()
        line = parted(line, getattr(program, "path", program), folder, away)
        for name, content in (elsewhere or {}).items():
            (folder / "elsewhere" / name).write_bytes(content)
    settings = {"cwd": folder, "env": {**more, **dict(environment)}, "timeout": 300}
    return subprocess.run(line, **settings, capture_output=True, text=True, errors="replace")


def refused(engine, folder, text, ranks=1, **options):
    """Message of the engine's own error."""
    with pytest.raises(DemlawsError) as caught:
        simulate(engine, folder, text, ranks, **options)
    assert "ERROR" in str(caught.value)
    return str(caught.value)


def said_in(engine, folder):
    """Text of the log of a run."""
    return (folder / f"log.{engine}").read_text().replace("\n", " ")


def counts(text, where):
    """Contact steps that each run counted."""
    return [int(found) for found in re.findall(rf"in this run (\d+) contact steps were {where}", text)]


def save(law, path, **options):
    law.tabulate(**options).save(path)
    return path.name


def error_of(log, law):
    expected = law.follow(log["overlap"]).force
    return np.abs(log["force"] - expected).max() / expected.max()


def energy_error_of(log, law):
    """Largest relative error of the force and of both columns of ENERGY."""
    path = law.follow(log["overlap"])
    pairs = (("force", path.force, path.force), ("e[1]", path.stored, path.work), ("e[2]", path.dissipated, path.work))
    return max(np.abs(log[name] - expected).max() / scale.max() for name, expected, scale in pairs)


def modulus(young=60.6e9, poisson=0.25):
    return young / (2 * (1 - poisson**2))


def sphere_mass(diameter):
    return 2650 * math.pi / 6 * diameter**3
