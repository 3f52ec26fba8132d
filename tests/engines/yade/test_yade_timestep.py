"""Packings at the advised time step keep their energy in YADE, and explode beyond the exact limit."""

import itertools
import json
import math

import numpy as np
import pytest
from yade_scenes import advance, engine_list, interaction_loop, yade

import demlaws as dl
from demlaws.advice.scene import Scene, stable_step
from demlaws.cli import main
from demlaws.timestep import from_contacts

RADIUS, FORCE = 0.01, 500.0
GRANITE = dl.Material(young=60.6e9, poisson=0.25, density=2680.0)
HERTZ = dl.law("hertz", dl.Contact.between(GRANITE, GRANITE, radius1=RADIUS, radius2=RADIUS))
BASES = {"sc": [(0, 0, 0)], "fcc": [(0, 0, 0), (0.5, 0.5, 0), (0.5, 0, 0.5), (0, 0.5, 0.5)]}


def lattice(kind):
    """A periodic lattice of equal spheres with YADE's own Mindlin law and FORCE in each contact, moving a little."""
    yade.O.reset()
    edge = (2.0 * RADIUS - HERTZ.overlap(FORCE)) * (math.sqrt(2.0) if kind == "fcc" else 1.0)
    yade.O.materials.append(
        yade.FrictMat(young=GRANITE.young, poisson=GRANITE.poisson, density=GRANITE.density, frictionAngle=1.0)
    )
    yade.O.periodic = True
    yade.O.cell.setBox(4 * edge, 4 * edge, 4 * edge)
    random = np.random.default_rng(1)
    for corner, base in itertools.product(itertools.product(range(4), repeat=3), BASES[kind]):
        body = yade.utils.sphere(tuple(edge * (np.array(corner) + base)), RADIUS)
        body.state.vel = tuple(1e-4 * random.standard_normal(3))
        yade.O.bodies.append(body)
    yade.O.engines = engine_list(interaction_loop(yade.Law2_ScGeom_MindlinPhys_Mindlin()))
    yade.O.dt = 1e-9
    yade.O.run(2, True)
    return yade.O


def growth(omega, dt, steps):
    """Largest kinetic energy in a run of `steps` over that at its start."""
    start, largest = yade.utils.kineticEnergy(), 0.0
    omega.dt = dt
    for _ in range(steps // 20):
        advance(20)
        largest = max(largest, yade.utils.kineticEnergy())
        if not largest < 1e4 * start:  # grains that fly apart take long
            break
    return largest / start


@pytest.mark.parametrize("kind", BASES)
def test_energy_is_bounded_at_the_advised_step(omega, kind):
    scene = Scene(radii=(0.01, 0.03), materials=GRANITE, force=(1.0, FORCE), coordination=6.0)
    advised = stable_step(scene, lambda contact: dl.law("hertz", contact))
    exact = limits_of(lattice(kind))
    assert 0.4 * exact < advised < 0.9 * exact
    assert growth(lattice(kind), advised, 5_000) < 2.0
    assert growth(lattice(kind), 1.05 * exact, 2_000) > 1e3


def limits_of(omega):
    """Exact limit [s] of the contacts as they are; equal to the closed form of the lattice."""
    from demlaws.yade.snapshot import snapshot

    scene = snapshot()
    normal, shear = np.transpose(scene["springs"])
    found = from_contacts(scene["pairs"], scene["normals"], normal, shear_stiffness=shear, masses=scene["masses"])
    stiffness = 1.5 * FORCE / HERTZ.overlap(FORCE)
    mass = 4.0 / 3.0 * math.pi * RADIUS**3 * GRANITE.density
    number = 2.0 * len([i for i in omega.interactions if i.isReal]) / len(omega.bodies)
    assert found.exact == pytest.approx(2.0 / math.sqrt(10.0 / 3.0 * number * 1.5 / 1.75 * stiffness / mass), rel=1e-3)
    return found.exact


def test_command_reads_a_saved_scene(omega, tmp_path, capfd):
    exact = limits_of(lattice("sc"))
    omega.dt = 2.0 * exact
    omega.save(str(tmp_path / "sc.yade.gz"))
    assert main(["timestep", str(tmp_path / "sc.yade.gz")]) == 0
    lines = capfd.readouterr().out.splitlines()
    (limit,) = [float(line.split()[2]) for line in lines if line.startswith("exact limit")]
    assert limit == pytest.approx(exact, rel=1e-3) and lines[-1].endswith("2 of the exact limit: unstable")
    (tmp_path / "bad.yade.gz").write_bytes(b"no scene")
    assert main(["timestep", str(tmp_path / "bad.yade.gz")]) == 2


def test_scenes_without_friction_or_rotation(omega, tmp_path, capfd):
    """ω² of the simple cubic lattice is 2/3 Z K/m times max(1 + 2r, 5r), 1 without friction, 1 + 2r without rotation."""
    exact = limits_of(lattice("sc"))
    ratio = 1.5 / 1.75

    def found():
        omega.save(str(tmp_path / "sc.yade.gz"))
        assert main(["timestep", str(tmp_path / "sc.yade.gz"), "--json"]) == 0
        return json.loads(capfd.readouterr().out)["exact"]

    for body in omega.bodies:
        body.state.blockedDOFs = "XYZ"
    assert found() == pytest.approx(exact * math.sqrt(5 * ratio / (1 + 2 * ratio)), rel=1e-3)
    for contact in omega.interactions:
        contact.phys.tangensOfFrictionAngle = 0.0
    assert found() == pytest.approx(exact * math.sqrt(5 * ratio), rel=1e-3)
    next(iter(omega.interactions)).phys.kr = 1.0
    omega.save(str(tmp_path / "rolling.yade.gz"))
    assert main(["timestep", str(tmp_path / "rolling.yade.gz")]) == 2
    assert main(["timestep", str(tmp_path / "sc.yade.gz"), "--friction", "0"]) == 2
