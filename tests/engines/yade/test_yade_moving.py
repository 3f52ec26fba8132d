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
    "sphere": reference.Way(lever="radius"),
    "arms to the contact": reference.Way(),
    "wall": reference.Way(wall_share=1.0),
    "facet": reference.Way(),
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


@pytest.mark.native_step
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


@pytest.mark.native_step
@pytest.mark.native_step
@pytest.mark.parametrize("kind", ["facet", "box", "wall"])
def test_a_ball_that_rolls_on_a_turntable_comes_back(omega, kind):
    """It moves on a circle with 2/7 of the spin of the table, also on a Wall whose noRatch is left as it is."""
    stone, radius, turns = material(young=1e8, friction=np.arctan(1.0)), 0.01, 20.0
    table = {
        "facet": lambda: yade.utils.facet([(-5, -5, 0), (5, -5, 0), (0, 9, 0)], fixed=True, material=stone),
        "box": lambda: yade.utils.box((0, 0, -0.5), (5, 5, 0.5), fixed=True, material=stone),
        "wall": lambda: yade.utils.wall(0, 2, material=stone),
    }[kind]()
    ids = [yade.O.bodies.append(table)]
    ball = yade.O.bodies[yade.O.bodies.append(sphere((0.05, 0, radius - 1.5e-6), radius, material=stone))]
    velocity = yade.Vector3(0, 0.1, 0)
    ball.state.vel = velocity
    under = velocity - yade.Vector3(0, 0, turns).cross(yade.Vector3(0.05, 0, 0))
    ball.state.angVel = yade.Vector3(0, 0, 1).cross(under / radius)
    flats = [yade.Ig2_Wall_Sphere_ScGeom(), yade.Ig2_Facet_Sphere_ScGeom(), yade.Ig2_Box_Sphere_ScGeom()]
    physics = [yade.Ip2_FrictMat_FrictMat_MindlinPhys(en=0.5, es=0.5)]
    loop = interaction_loop(functor("hertz", "elastic", {}), geometries=flats, physics=physics)
    bounds = [yade.Bo1_Sphere_Aabb(), yade.Bo1_Wall_Aabb(), yade.Bo1_Facet_Aabb(), yade.Bo1_Box_Aabb()]
    axis = {"rotationAxis": (0, 0, 1), "rotateAroundZero": True, "zeroPoint": (0, 0, 0), "angularVelocity": turns}
    newton = yade.NewtonIntegrator(damping=0, gravity=(0, 0, -9.81))
    collider = yade.InsertionSortCollider(bounds)
    yade.O.engines = [yade.ForceResetter(), collider, loop, yade.RotationEngine(ids=ids, **axis), newton]
    steps = 20_000
    yade.O.dt, start = 7 * np.pi / turns / steps, np.array(ball.state.pos)
    yade.O.run(steps, True)
    assert np.linalg.norm((np.array(ball.state.pos) - start)[:2]) < 0.01 * 0.1 / (2 / 7 * turns)


@pytest.mark.parametrize("shear", ["elastic", "slip"])
@pytest.mark.parametrize("axis", [(0, 0, 1), (0.36, 0.48, 0.8)], ids=["normal", "oblique"])
@pytest.mark.parametrize("kind", ["sphere", "facet"])
def test_a_pair_that_turns_as_one_body_takes_its_shear_along(omega, kind, axis, shear):
    """By 90, 180 and 360°. About the normal to the third power of the angle of a step, oblique to its square: chords."""
    steps, angle = 500, 0.5 * np.pi * np.array(axis)
    path = [reference.Leg(), reference.Leg(shift=(0.15, 0.1)), *[reference.Leg(whole=angle)] * 4]
    motion = reference.motion(FIRST[kind], RADIUS, 10 * OVERLAP, steps, TIMESTEP, path=path)
    forces = prescribed(kind, functor(shear=shear), motion)[0][2 * steps - 1 :: steps, 1]
    for quarters in (1, 2, 4):
        wanted = reference.rotation(quarters * angle) @ forces[0]
        error = (3e-6 if axis[2] == 1 else 1e-3) * quarters
        assert np.linalg.norm(forces[quarters] - wanted) < error * np.linalg.norm(wanted)
        if shear == "elastic" and axis[2] == 1:
            assert abs(np.linalg.norm(forces[quarters]) / np.linalg.norm(wanted) - 1.0) < 1e-10


def energy_gained(law, speed, steps=20_000, pull=50.0, spin=3000.0, small=1e-3, circles=False):
    """Energy that a grain gains in steps of 1 µs, over that of its motion: pulled to a fixed sphere, on which it spins.

    It rolls, or its shear force `circles`: vibrations in two directions, a quarter apart. It does not slide: μ is 100.
    """
    mass, radius, modulus = 2650 * 4 / 3 * np.pi * small**3, OTHER * small / (OTHER + small), YOUNG / (1 - POISSON**2) / 2
    overlap = (mass * pull / (4 / 3 * modulus * radius**0.5)) ** (2 / 3)
    stone = material(young=YOUNG, poisson=POISSON, friction=np.arctan(100.0))
    grain = sphere((0, 0, OTHER + small - overlap), small, material=stone)
    yade.O.bodies.append([sphere((0, 0, 0), OTHER, fixed=True, material=stone), grain])
    grain.state.vel, grain.state.angVel = (speed, 0, 0), (0, 0 if circles else speed / small, spin)
    yade.O.engines = [
        yade.ForceResetter(),
        yade.InsertionSortCollider([yade.Bo1_Sphere_Aabb()]),
        interaction_loop(law, geometries=[yade.Ig2_Sphere_Sphere_ScGeom(avoidGranularRatcheting=False)]),
        yade.CentralConstantAccelerationEngine(accel=pull, centralBody=0, reciprocal=False),
        yade.NewtonIntegrator(damping=0),
    ]
    yade.O.dt = TIMESTEP

    def energy():
        place, velocity, turning = grain.state.pos.norm(), grain.state.vel, grain.state.angVel
        yade.O.step()
        velocity, turning = 0.5 * (velocity + grain.state.vel), 0.5 * (turning + grain.state.angVel)  # of the full step
        totals = law.totals()
        springs = totals.stored + totals.dissipated + totals.shear_stored + totals.shear_dissipated
        moving = 0.5 * mass * (velocity.squaredNorm() + 0.4 * small**2 * turning.squaredNorm())
        return moving + springs + mass * pull * place

    if circles:
        stiffness = 4 * (1 - POISSON) / (2 - POISSON) * modulus * (radius * overlap) ** 0.5
        yade.O.run(round(0.5 * np.pi * (mass * 2 / 7 / stiffness) ** 0.5 / TIMESTEP), True)
        grain.state.vel += (0, speed, 0)
    yade.O.run(50, True)
    start = energy()
    yade.O.run(steps, True)
    return abs(energy() - start) / (0.5 * mass * speed**2)


@pytest.mark.parametrize("shear", ["elastic", "slip"])
@pytest.mark.parametrize(
    ("circles", "speed", "most"),
    [(False, 0.1, 2e-5), (True, 0.003, 2e-4)],
    ids=["lever at the half step", "displacement turned by half"],
)
def test_a_grain_that_spins_keeps_its_energy(omega, shear, circles, speed, most):
    """The lever at the half step in the displacement alone, not in the torque, and half a turn are symmetric in time."""
    gained = energy_gained(functor("hertz", "elastic", {}, shear=shear), speed, circles=circles)
    most *= 1.5 if shear == "slip" else 1.0  # the outermost of its springs slips in every cycle
    omega.reset()
    assert gained < most < 20 * most < energy_gained(functor("hertz", "elastic", {}, shear="native"), speed, circles=circles)


def height(law, ratio, timestep, wall, time):
    """Height [mm] after a time [s] of a grain that falls between two fixed spheres of 10 mm, or such a sphere and a wall."""
    big, stone = 5e-3, material(young=5e8, poisson=0.3, friction=np.arctan(0.5))
    small = big / ratio
    x, y = big - small * wall, 0.11 * small
    second = (
        yade.utils.wall(big, 0, sense=-1, material=stone) if wall else sphere((2 * big, 0, 0), big, fixed=True, material=stone)
    )
    place = (x, y, np.sqrt((big + small) ** 2 - x * x - y * y))
    yade.O.bodies.append([sphere((0, 0, 0), big, fixed=True, material=stone), second, sphere(place, small, material=stone)])
    loop = interaction_loop(
        law,
        geometries=[yade.Ig2_Sphere_Sphere_ScGeom(), yade.Ig2_Wall_Sphere_ScGeom()],
        physics=[yade.Ip2_FrictMat_FrictMat_MindlinPhys(en=0.5, es=1.0)],
    )
    collider = yade.InsertionSortCollider([yade.Bo1_Sphere_Aabb(), yade.Bo1_Wall_Aabb()])
    yade.O.engines = [yade.ForceResetter(), collider, loop, yade.NewtonIntegrator(gravity=(0, 0, -9.81), damping=0)]
    yade.O.dt = timestep
    yade.O.run(round(time / timestep), True)
    return 1e3 * yade.O.bodies[2].state.pos[2]


@pytest.mark.slow
@pytest.mark.parametrize("shear", ["elastic", "slip"])
@pytest.mark.parametrize(
    ("ratio", "wall", "late"),
    [
        *[(2, False, 0.03), (5, False, 0.4), (10, False, 4.0), (20, False, 40.0), (40, False, 20.0)],
        *[(2, True, 0.1), (5, True, 0.8), (10, True, 2.0), (20, True, 2.0), (40, True, 0.0)],
    ],
)
def test_a_small_grain_falls_between_large_ones(omega, ratio, wall, late, shear):
    """The height is that of half and a quarter of the step; stock Mindlin holds the grain for ever, or is late by `late` mm."""
    found, step, time = [], 2e-5 / ratio, 0.4 if wall and ratio >= 20 else 0.24
    for stock, timestep in ((True, step), (False, step), (False, 0.5 * step), (False, 0.25 * step)):
        omega.reset()
        law = yade.Law2_ScGeom_MindlinPhys_Mindlin() if stock else functor("hertz", "elastic", {}, shear=shear)
        found.append(height(law, ratio, timestep, wall, time))
    stock, *ours = found
    assert ours[-1] < -4.0 and ours == pytest.approx([ours[-1]] * 3, abs=0.05)
    assert stock - ours[0] > late
