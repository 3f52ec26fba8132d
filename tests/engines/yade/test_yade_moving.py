"""Shear of bodies that move and turn: YADE against `moving_contact`, and a small grain between large ones."""

import moving_contact as reference
import numpy as np
import pytest
from yade_scenes import GRANITE, functor, interaction_loop, material, sphere, yade

import demlaws as dl

RADIUS, OTHER, OVERLAP, FRICTION = 5e-4, 5e-3, 1e-6, 0.5
YOUNG, POISSON, TIMESTEP = 5e8, 0.25, 1e-6
CORNERS = [(-0.05, -0.05, 0), (0.05, -0.05, 0), (0, 0.05, 0)]
FIRST = {"sphere": reference.sphere(OTHER), "wall": reference.plane((0, 0, 1)), "facet": reference.triangle(CORNERS)}
WAYS = {
    "sphere": reference.Way("radius", "radius", turn="cross"),
    "arms to the contact": reference.Way("contact", "radius", turn="cross"),
    "wall": reference.Way("contact", "radius", 1.0, "cross"),
    "facet": reference.Way("contact", "radius", 0.5, "cross"),
}


def prescribed(kind, law, motion, friction=FRICTION, between=lambda step: None, **physics):
    """Forces [N] and torques [N m] on both bodies along a motion: arrays (steps, 2, 3)."""
    stone = material(young=YOUNG, poisson=POISSON, friction=np.arctan(friction))
    if kind == "facet":
        first = yade.utils.facet(CORNERS, fixed=True, material=stone)
    else:
        first = yade.utils.wall(0, 2, sense=1, material=stone) if kind == "wall" else sphere((0, 0, 0), OTHER, material=stone)
    second = sphere(motion.start[1], RADIUS, material=stone)
    yade.O.bodies.append([first, second])
    for body in yade.O.bodies:
        body.state.blockedDOFs = "xyzXYZ"
    geometries = [
        yade.Ig2_Sphere_Sphere_ScGeom(avoidGranularRatcheting=kind != "arms to the contact"),
        yade.Ig2_Facet_Sphere_ScGeom(),
        yade.Ig2_Wall_Sphere_ScGeom(noRatch=False),
    ]
    bounds = [yade.Bo1_Sphere_Aabb(), yade.Bo1_Facet_Aabb(), yade.Bo1_Wall_Aabb()]
    loop = interaction_loop(law, geometries=geometries, physics=[yade.Ip2_FrictMat_FrictMat_MindlinPhys(**physics)])
    yade.O.engines = [yade.ForceResetter(), yade.InsertionSortCollider(bounds), loop, yade.NewtonIntegrator()]
    yade.O.dt = motion.timestep
    places, turned, forces, torques = np.array(motion.start), yade.Quaternion.Identity, [], []
    for step, (velocities, spins) in enumerate(zip(motion.velocity, motion.spin, strict=True)):
        between(step)
        places += motion.timestep * velocities
        for body, place, velocity, spin in zip(yade.O.bodies, places, velocities, spins, strict=True):
            body.state.pos, body.state.vel, body.state.angVel = place, velocity, spin
        turn = motion.timestep * yade.Vector3(spins[0])
        turned = yade.Quaternion(turn.normalized(), turn.norm()) * turned
        yade.O.bodies[0].state.ori = turned
        yade.O.step()  # its NewtonIntegrator moves the bodies in vain
        forces.append([yade.O.forces.f(body.id) for body in yade.O.bodies])
        torques.append([yade.O.forces.t(body.id) for body in yade.O.bodies])
    return np.array(forces, float), np.array(torques, float)


def expected(kind, motion, way, rule="hertz", friction=FRICTION, **options):
    """`reference.follow` of a granite contact."""
    first = FIRST.get(kind, FIRST["sphere"])
    radius = RADIUS * OTHER / (RADIUS + OTHER) if first.radius else RADIUS
    surfaces = GRANITE.combined(GRANITE)
    contact = dl.Contact(radius, YOUNG / (1 - POISSON**2) / 2, surfaces.roughness, surfaces.fractal_dimension)
    ratio = 2 * (1 - POISSON) / (2 - POISSON)
    law = dl.law("pohrt-popov", contact, rule)
    return reference.follow(first, RADIUS, motion, law, ratio=ratio, friction=friction, way=way, **options)


def motion_of(kind, steps=60):
    first = FIRST.get(kind, FIRST["sphere"])
    return reference.motion(first, RADIUS, OVERLAP, steps, TIMESTEP)


def assert_agree(found, wanted, tolerance=1e-9):
    for mine, other in zip(found, (wanted.force, wanted.torque), strict=True):
        for body in (0, 1):
            assert np.abs(mine[:, body] - other[:, body]).max() <= tolerance * np.abs(other[:, body]).max()


@pytest.mark.parametrize("kind", WAYS)
def test_forces_and_torques_of_a_moving_contact(omega, kind):
    """Approach, slide, roll, twist, turn as a whole about two axes, and back, with three levels of springs."""
    motion = motion_of(kind)
    wanted = expected(kind, motion, WAYS[kind])
    assert_agree(prescribed(kind, functor(), motion), wanted)
    if kind != "wall":  # whose normal never turns
        former = expected(kind, motion, WAYS[kind]._replace(half_step=False))
        assert np.abs(former.force - wanted.force).max() > 0.05 * np.abs(wanted.force).max()


@pytest.mark.parametrize("case", ["native go", "one level", "damped", "loading"])
def test_the_same_by_other_ways(omega, case):
    """YADE's own step with the corrected displacement, one level, viscous forces, K_t by first loading."""
    motion, way = motion_of("sphere"), WAYS["sphere"]
    law = functor(levels=1 if case == "one level" else None, shear="loading" if case == "loading" else "elastic")
    law.binding.attachment.context["own_step"] &= case != "native go"
    options = {"levels": 1} if case == "one level" else {"shear": "loading"} if case == "loading" else {}
    physics = {}
    if case == "damped":
        masses = 2650 * 4 / 3 * np.pi * np.array([OTHER, RADIUS]) ** 3
        physics = {"betan": 0.01, "betas": 0.02}
        options = {"damping": (masses.prod() / masses.sum(), 0.01, 0.02)}
    assert_agree(prescribed("sphere", law, motion, **physics), expected("sphere", motion, way, **options))


def test_partial_slip(omega):
    """With a high μ and at constant overlap its springs are one level, but for the square of the turn of a step (3° here)."""
    path = [reference.Leg(), *(leg._replace(overlap=1.0) for leg in reference.legs(FIRST["sphere"], RADIUS, OVERLAP)[1:9])]
    motion = reference.motion(FIRST["sphere"], RADIUS, OVERLAP, 60, TIMESTEP, path=path)
    found = prescribed("sphere", functor(shear="slip"), motion, friction=1e6)
    assert_agree(found, expected("sphere", motion, WAYS["sphere"]._replace(turn="frame"), friction=1e6), 2e-3)


@pytest.mark.parametrize("kind", ["sphere", "facet"])
def test_a_saved_contact_goes_on(omega, kind, tmp_path):
    """Saved and loaded between the turns of the path: the history is there, and how the surfaces turn."""
    motion = motion_of(kind)
    whole = prescribed(kind, functor(), motion)
    omega.reset()
    again = prescribed(kind, functor(), motion, between=lambda step: step == 330 and save_and_load(omega, tmp_path))
    for one, other in zip(whole, again, strict=True):
        assert np.abs(one - other).max() <= 1e-12 * np.abs(one).max()


def save_and_load(omega, folder):
    omega.save(str(folder / "scene.yade"))
    omega.load(str(folder / "scene.yade"))
