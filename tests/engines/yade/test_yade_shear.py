"""Shear in YADE: K_t, the shear force along paths, regular arrays."""

import numpy as np
import pytest
from shear_paths import GRANITE_RATIO, PATHS, overlaps_at
from yade_scenes import GRANITE, POISSON, YOUNG, functor, material, set_engines

import demlaws as dl
from demlaws.driver import sheared
from demlaws.make import example

CHOICES = ("elastic", "loading")
pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")
RADIUS = 0.01
MODULUS = YOUNG / (1 - POISSON**2) / 2
PAIR = GRANITE.combined(GRANITE)
CONTACT = dl.Contact(RADIUS / 2, MODULUS, PAIR.roughness, PAIR.fractal_dimension, PAIR.hardness)


def taken_along(law, overlaps, displacements):
    """Two spheres led along a path: K_t, elastic shear force and normal force of their contact at each point."""
    import yade
    from yade.utils import sphere

    omega = yade.O
    omega.reset()
    stone = material(friction=1.5)
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


def test_the_choices_agree_with_mindlin_for_hertz(omega):
    import yade

    """Where the overlap does not fall: there YADE keeps the force, too."""
    forces, displacements = PATHS["wild"]
    path = overlaps_at(dl.law("hertz", CONTACT), np.sort(forces))
    native = taken_along(yade.Law2_ScGeom_MindlinPhys_Mindlin(), path, displacements)
    for choice in CHOICES:
        mine = taken_along(functor("hertz", "hertz", {}, bridge="native", shear=choice), path, displacements)
        for one, other in zip(mine, native, strict=True):
            assert one == pytest.approx(other, rel=1e-11, abs=1e-11 * np.abs(other).max())


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


@pytest.mark.slow
def test_small_strain_shear_modulus_of_an_array(omega):
    """C44 of FCC and its exponent of pressure against the lattice sum."""
    from studies.validation import in_yade
    from studies.validation.engines import shear_modulus
    from studies.validation.jobs import shear_jobs

    exponents = {}
    jobs = shear_jobs(peaks=(2e-5, 4e-5, 8e-5), steps=60)
    for choice in CHOICES:
        mine = [job for job in jobs if job["options"]["shear"] == choice]
        pressure, seen, low, high = np.array([shear_modulus(job, in_yade.lattice(job)) for job in mine]).T
        assert seen == pytest.approx(low, rel=5e-4) and high == pytest.approx(low, rel=1e-6)
        exponents[choice] = np.polyfit(np.log(pressure), np.log(seen), 1)[0]
        assert exponents[choice] == pytest.approx(np.polyfit(np.log(pressure), np.log(low), 1)[0], abs=1e-3)
    assert exponents["elastic"] < 0.4 < exponents["loading"]


def test_choice_is_saved_and_checked(omega, tmp_path):
    from demlaws.yade.pairs import Pairs

    law = functor(shear="loading")
    again = Pairs.from_text(law.binding.pairs.as_text())
    assert again.shear_name == "loading" and type(again.shear) is type(law.binding.pairs.shear)
    for wrong in ("secant", "tangent", ["elastic"]):
        with pytest.raises(dl.DemlawsError):
            functor(shear=wrong)
