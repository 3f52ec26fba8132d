"""Shear in YADE: K_t, the shear force along paths, regular arrays."""

import math

import numpy as np
import pytest
from examples import shared
from shear_paths import GRANITE_RATIO, PATHS, overlaps_at
from yade_scenes import GRANITE, POISSON, YOUNG, functor, material, set_engines, sphere, yade

import demlaws as dl
from demlaws.core.slip import SAMPLES, slip_loop
from demlaws.driver import sheared
from demlaws.make import example
from demlaws.yade.shear import SPRINGS
from studies.validation import engines
from studies.validation.jobs import collision_jobs

CHOICES = ("elastic", "loading")
RADIUS = 0.01
MODULUS = YOUNG / (1 - POISSON**2) / 2
PAIR = GRANITE.combined(GRANITE)
CONTACT = dl.Contact(RADIUS / 2, MODULUS, PAIR.roughness, PAIR.fractal_dimension, PAIR.hardness)


def taken_along(law, overlaps, displacements, friction=14.0):
    """Two spheres led along a path: K_t, elastic shear force and normal force of their contact at each point."""
    omega = yade.O
    omega.reset()
    stone = material(friction=math.atan(friction))
    for height in (0.0, 2 * RADIUS):
        omega.bodies.append(sphere((0, 0, height), RADIUS, fixed=True, material=stone))
    set_engines(law, 1.0)
    rows, x = [], 0.0
    for overlap, displacement in zip(overlaps, displacements, strict=True):
        omega.bodies[1].state.pos = yade.Vector3(0, 0, 2 * RADIUS - overlap)
        # YADE takes the shear of bodies that are as far apart as the sum of their radii, against ratcheting
        omega.bodies[1].state.vel = yade.Vector3((displacement - x) * (1 - overlap / (2 * RADIUS)), 0, 0)
        x = displacement
        omega.step()
        contact = omega.interactions[0, 1]
        phys = contact.phys
        rows.append((contact.geom.penetrationDepth, phys.ks, phys.shearElastic[0], phys.normalForce.norm()))
    return np.array(rows).T


def test_tangential_stiffness_through_a_reversal(omega):
    """K_t is continuous where the tangent jumps, from 1.24 N/µm on first loading to 3.03 just below."""
    one = example("pohrt-popov", dl.Contact(RADIUS / 2, MODULUS, 2.4e-6, 2.22, 6.266e9), "hertz")
    surfaces = {"granite": dl.Surface(2.4e-6 / 2**0.5, 2.22, 6.266e9)}
    deep = 2.2657e-6
    path = np.array([0.5, 1.0, 1.0 - 1e-10, 0.8, 1.0 - 1e-10, 1.0 + 1e-10, 1.2]) * deep
    for choice in CHOICES:
        reached, stiffness, _, _ = taken_along(functor(surfaces=surfaces, bridge="native", shear=choice), path, 0.0 * path)
        expected = one.shear_stiffness(reached, GRANITE_RATIO, choice)
        assert stiffness == pytest.approx(expected, rel=1e-11)
        jumps = np.abs(stiffness[[2, 4]] / stiffness[[1, 5]] - 1.0)
        assert np.all(jumps < 1e-9)


@pytest.mark.parametrize("way", ["native", "public"])
@pytest.mark.parametrize(("name", "rule"), [("pohrt-popov", "elastic"), ("pohrt-popov", "hertz")])
def test_shear_force_is_that_of_the_passive_contact(omega, name, rule, way):
    """Along closed paths of normal force and displacement, which then return no work."""
    one = example(name, CONTACT, rule)
    for forces, displacements in PATHS.values() if way == "native" else [PATHS["wild"]]:
        for choice in CHOICES:
            law = functor(name, rule, bridge=way, shear=choice)
            reached, _, shear, normal = taken_along(law, overlaps_at(one, forces), displacements)
            assert normal == pytest.approx(forces, rel=1e-9)
            mine = sheared(one, reached, displacements, GRANITE_RATIO, choice)
            assert -shear == pytest.approx(mine.shear_force, abs=1e-9 * np.abs(shear).max())
            assert np.diff(mine.dissipated).min() >= -1e-12 * mine.work.max()


def test_choice_is_saved_and_checked(omega, tmp_path):
    from demlaws.yade.pairs import Pairs

    law = functor(shear="loading")
    again = Pairs.from_text(law.binding.pairs.as_text())
    assert again.shear_name == "loading" and type(again.shear) is type(law.binding.pairs.shear)
    for wrong in ("secant", "tangent", ["elastic"]):
        with pytest.raises(dl.DemlawsError):
            functor(shear=wrong)


def test_friction_limits_a_damped_contact_that_slides():
    """The dashpot of the shear force is off while the contact slides, though the normal dashpot raises Coulomb's limit."""
    (job,) = [job for job in collision_jobs("YADE") if job["restitution"] == 0.9]
    for found in engines.in_yade([job | {"motions": job["motions"][-1:], "shear": choice} for choice in ("elastic", "slip")]):
        _, away, spin = found[0]
        assert 0.95 < spin / (2.5 * job["friction"] * (5.0 + away)) < 1.005


# --- partial slip


def slip_along(law, overlaps, displacements, friction, springs):
    """Shear force of `dl.driver.sheared(..., "slip")`, with 128 times as many points of the unloading curve."""
    results, rows = np.empty((6, len(overlaps))), (np.zeros((2, springs)), np.empty((2, 128 * SAMPLES)))
    largest = float(np.max(law.shear_stiffness(overlaps, 1.0, "elastic")))
    still = np.zeros(len(overlaps))
    state = law.new_state(1).arrays
    slip_loop(law.rule, law.params, overlaps, displacements, still, GRANITE_RATIO, friction, largest, state, *rows, results)
    return results[2]


@pytest.mark.parametrize(
    ("name", "rule"),
    shared(
        [("hertz", "elastic"), ("pohrt-popov", "elastic"), ("pohrt-popov", "hertz"), ("jackson-green", "jackson")],
        lambda pair: pair[1] != "jackson" and pair != ("pohrt-popov", "elastic"),
    ),
)
def test_partial_slip_is_that_of_python(omega, name, rule):
    """From a first step to the largest overlap on, so that both have the same springs."""
    one = example(name, CONTACT, rule)
    generator = np.random.default_rng(2)
    depth = float(one.overlap(60.0))
    overlaps = depth * np.concatenate([[1.0, 1.0, 1.0], generator.uniform(0.7, 1.0, 60)])
    sideways = 0.6 * depth * np.concatenate([[0.0, 0.2, 1.0], generator.uniform(-1.0, 1.0, 60)])
    surfaces = {} if name == "hertz" else {"granite": GRANITE}
    law = functor(name, rule, surfaces, bridge="native", shear="slip", **one.options)
    reached, _, shear, normal = taken_along(law, overlaps, sideways, friction=0.5)
    expected = slip_along(one, reached, sideways, 0.5, SPRINGS)
    assert -shear == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())
    close = sheared(one, reached, sideways, GRANITE_RATIO, "slip", friction=0.5, springs=SPRINGS)
    assert expected == pytest.approx(close.shear_force, abs=1e-4 * np.abs(expected).max())
    assert np.any(np.abs(shear) < 0.2 * normal) and np.any(np.abs(shear) > 0.49 * normal)
    totals = law.totals()
    assert totals.shear_stored == pytest.approx(close.stored[-1], rel=1e-3)
    assert totals.shear_dissipated == pytest.approx(close.dissipated[-1], rel=1e-3)


def test_partial_slip_of_a_contact_that_grows(omega):
    """Springs are joined as the contact becomes stiffer: within the error of 12 springs."""
    one = example("pohrt-popov", CONTACT, "hertz")
    forces, displacements = PATHS["wild"]
    overlaps = overlaps_at(one, forces)
    reached, _, shear, _ = taken_along(functor(bridge="native", shear="slip"), overlaps, displacements, friction=0.5)
    limit = sheared(one, reached, displacements, GRANITE_RATIO, "slip", friction=0.5, springs=1000)
    assert -shear == pytest.approx(limit.shear_force, abs=0.02 * 0.5 * max(forces))
