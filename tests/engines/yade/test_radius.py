"""R of level sets, polyhedra and other shapes that are neither spheres nor flats: body, curvature, edge radius."""

import math
import warnings

import numpy as np
import pytest
from examples import shared as slow_but
from yade_scenes import GRANITE, MODULUS, advance, functor, material, needs, set_engines, stops, yade

import demlaws as dl
from demlaws import yade as dy
from demlaws.errors import DemlawsError
from demlaws.solvers.ellipsoid import shape_factors

pytestmark = pytest.mark.releases

R = 0.01


def law(radius=None, **options):
    return functor("hertz", "elastic", None, smooth=True, radius=radius, **options)


@pytest.fixture
def level_sets():
    needs("LS_DEM")


def has_polyhedra():
    """Debian 12's YADE has polyhedra, Debian 13's is built without them."""
    return hasattr(yade, "Ig2_Polyhedra_Polyhedra_ScGeom")


def engines(functor, timestep=1e-9):
    geometries = [
        yade.Ig2_LevelSet_LevelSet_ScGeom(),
        yade.Ig2_Wall_LevelSet_ScGeom(),
        yade.Ig2_Sphere_Sphere_ScGeom(),
    ]
    bounds = [yade.Bo1_LevelSet_Aabb(), yade.Bo1_Wall_Aabb(), yade.Bo1_Sphere_Aabb()]
    if has_polyhedra():
        geometries += [yade.Ig2_Polyhedra_Polyhedra_ScGeom(), yade.Ig2_Sphere_Polyhedra_ScGeom()]
        bounds.append(yade.Bo1_Polyhedra_Aabb())
    set_engines(functor, timestep, geometries=geometries, bounds=bounds, verlet=0)
    next(e for e in yade.O.engines if isinstance(e, yade.Collider)).verletDist = 0


def ellipsoid(axes, centre=(0, 0, 0), spacing=R / 10, dynamic=False, nodes=402):
    stone = yade.O.materials["granite"]
    options = {"spacing": spacing, "nSurfNodes": nodes, "nodesPath": 1, "dynamic": dynamic, "material": stone}
    if len(set(axes)) == 1:
        return yade.utils.levelSetBody("sphere", center=centre, radius=axes[0], **options)
    return yade.utils.levelSetBody("superellipsoid", center=centre, extents=axes, epsilons=(1, 1), **options)


def shaped(distance, reach, spacing, centre=(0, 0, 0), nodes=2502):
    """A body whose surface is distance(x, y, z) = 0, as a scan would give it."""
    half = math.ceil(reach / spacing) + 2
    grid = yade.RegularGrid(-half * spacing, half * spacing, 2 * half + 1)
    ticks = np.arange(-half, half + 1) * spacing
    field = distance(*np.meshgrid(ticks, ticks, ticks, indexing="ij")).tolist()
    return yade.utils.levelSetBody(
        grid=grid,
        distField=field,
        center=centre,
        nSurfNodes=nodes,
        nodesPath=1,
        dynamic=False,
        material=yade.O.materials["granite"],
    )


def rounded_cube(half, edge):
    """Signed distance of a cube with rounded edges and corners."""

    def distance(x, y, z):
        q = np.abs(np.stack([x, y, z])) - (half - edge)
        return np.sqrt((np.maximum(q, 0) ** 2).sum(axis=0)) + np.minimum(q.max(axis=0), 0) - edge

    return distance


def equivalent(radius_x, radius_y):
    """R of the sphere with the force of Hertz's elliptical contact, by exact elliptic integrals."""
    large, small = max(radius_x, radius_y), min(radius_x, radius_y)
    gamma = shape_factors(large / small)[2]
    return 2 / (1 / large + 1 / small) / gamma**3


def principal_radii(axes, point):
    """Of an ellipsoid at a point of its surface."""
    gradient, curved = 2 * point / np.square(axes), np.diag(2 / np.square(axes))
    normal = gradient / np.linalg.norm(gradient)
    across = np.eye(3) - np.outer(normal, normal)
    values = np.linalg.eigvalsh(across @ curved @ across / np.linalg.norm(gradient))
    return 1 / np.delete(values, np.argmin(np.abs(values))), normal


def twins(omega, axes, direction, overlap=4e-4):
    """Two equal ellipsoids that touch at a point of the first one, each the other's mirror image in it; (state, closed R)."""
    omega.reset()
    material()
    point = np.array(direction) / np.linalg.norm(np.array(direction) / axes)
    radii, normal = principal_radii(axes, point)
    omega.bodies.append(ellipsoid(axes, nodes=2502))
    omega.bodies.append(ellipsoid((R, R, R), tuple(map(float, 2 * point - overlap * normal)), R / 2, nodes=102))
    omega.bodies[1].shape = omega.bodies[0].shape
    functor = law("curvature")
    engines(functor)
    omega.step()
    omega.step()
    return functor.contacts(), equivalent(*(radii / 2))


AXES = {"oblate": (2 * R, 2 * R, R), "prolate": (R, R, 2 * R), "three axes": (2 * R, 1.5 * R, R)}
WAYS = ((0, 0, 1), (1, 0, 0), (0, 1, 0), (1, 0, 1), (1, 2, 2))


@pytest.mark.parametrize("name", slow_but(AXES, "three axes".__eq__))
def test_ellipsoids_against_the_closed_form(omega, level_sets, name):
    """Tips, poles and in between: the force of Hertz's elliptical contact within 5 %, where the body's is wrong by up to 2."""
    bodys = []
    for way in WAYS:
        state, closed = twins(omega, np.array(AXES[name]), way)
        assert state.force[0] == pytest.approx(dl.law("hertz", dl.Contact(closed, MODULUS)).force(state.overlap[0]), rel=0.05)
        geom = omega.interactions[0, 1].geom
        of_body = 1 / (1 / geom.refR1 + 1 / geom.refR2)
        bodys.append(math.sqrt(max(of_body / closed, closed / of_body)))
    assert max(bodys) > 1.7


def test_a_contact_that_rotates_keeps_its_radius(omega, level_sets):
    """Pressed on a wall at the pole, rolled to the tip and back at one overlap: R is that of the pole, no energy is lost."""
    a, c, overlap = 2 * R, R, 4e-4
    stone = material()
    omega.bodies.append(yade.utils.wall((0, 0, 0), 2, material=stone))
    omega.bodies.append(ellipsoid((a, a, c), (0, 0, c - overlap), nodes=6402))
    functor, found = law("curvature"), []
    engines(functor)
    for angle in np.append(np.linspace(0, math.pi / 2, 15), 0.0):
        height = math.hypot(a * math.sin(angle), c * math.cos(angle))
        omega.bodies[1].state.ori = yade.Quaternion(yade.Vector3(0, 1, 0), angle)
        omega.bodies[1].state.pos = (0, 0, height - overlap)
        omega.step()
        found.append(functor.contacts())
    assert found[0].radius[0] == pytest.approx(a * a / c, rel=0.1)
    assert {one.radius[0] for one in found} == {found[0].radius[0]}
    assert found[-1].stored[0] == pytest.approx(found[0].stored[0], rel=1e-12)


CHOICES = {"body": "body", "curvature": "curvature", "edge": 3e-3}


def on_corner(omega, radius, edge=3e-3, half=8e-3, overlap=4e-5):
    """A cube with rounded edges, on a corner on a wall: (state, distance from its centre to the contact)."""
    omega.reset()
    stone = material()
    omega.bodies.append(yade.utils.wall((0, 0, 0), 2, material=stone))
    reach = math.sqrt(3) * (half - edge) + edge
    omega.bodies.append(shaped(rounded_cube(half, edge), half, 5e-4, (0, 0, reach - overlap), 10002))
    turned = yade.Quaternion()
    turned.setFromTwoVectors(yade.Vector3(1, 1, 1), yade.Vector3(0, 0, -1))
    omega.bodies[1].state.ori = turned
    functor = law(radius)
    engines(functor)
    omega.step()
    omega.step()
    return functor.contacts(), reach


def test_a_scanned_grain_with_rounded_edges(omega, level_sets):
    """A corner of 3 mm on a flat: curvature and edge radius agree, the body's R is four times as large, its force twice."""
    forces, states = {}, {}
    for name, choice in CHOICES.items():
        states[name], reach = on_corner(omega, choice)
        exact = dl.law("hertz", dl.Contact({"body": reach}.get(name, 3e-3), MODULUS)).force(states[name].overlap[0])
        forces[name] = states[name].force[0] / exact
    assert forces["body"] == pytest.approx(1, rel=1e-2) and forces["edge"] == pytest.approx(1, rel=1e-9)
    assert forces["curvature"] == pytest.approx(1, rel=0.05)
    assert reach / 3e-3 > 3.8


# --- choices, refusals


def cubes(functor, kind="level set", overlap=1e-5, half=8e-3):
    """A new scene of two cubes, face on face, level sets or polyhedra; the functor."""
    yade.O.reset()
    stone = material()
    for z in (0.0, 2 * half - overlap):
        if kind == "level set":
            yade.O.bodies.append(shaped(rounded_cube(half, 2e-3), half, 1e-3, (0, 0, z), 402))
        else:
            from yade import polyhedra_utils

            corners = [(x, y, w) for x in (-half, half) for y in (-half, half) for w in (-half, half)]
            body = polyhedra_utils.polyhedra(stone, v=corners, fixed=True)
            body.state.pos = (0, 0, z)
            yade.O.bodies.append(body)
    engines(functor)
    return functor


def test_flat_on_flat_has_no_curvature(omega, level_sets, tmp_path):
    cubes(law("curvature"))
    stops(r"(?s)contact 0\+1 \(LevelSet on LevelSet\): flat on flat.*Curvature\(largest")
    bounded = cubes(law(dy.Curvature(largest=0.02)))
    advance(2)
    assert bounded.contacts().radius == pytest.approx([0.02], rel=1e-6)
    omega.save(str(tmp_path / "scene.yade"))
    omega.reset()
    omega.load(str(tmp_path / "scene.yade"))
    omega.interactions.clear()  # so that R is computed again, of shapes that were loaded
    advance(2)
    from demlaws.yade.saving import pairs_from, pairs_text

    pairs = dy.attached(bounded.label).pairs
    assert bounded.contacts().radius == pytest.approx([0.02], rel=1e-6)
    assert pairs_from(pairs_text(pairs)).radii.choice == dy.Curvature(largest=0.02)


def test_a_stepper_without_spheres_has_no_bound(omega, level_sets):
    """YADE computes its P-wave step from spheres only; without one it is 1 s."""
    cubes(law("body"))
    omega.engines = [*omega.engines, yade.GlobalStiffnessTimeStepper()]
    with pytest.warns(dl.errors.TimeStepWarning, match="no bound .* give it a maxDt"):
        advance(3)
    assert omega.engines[-1].maxDt > 1e300


def test_polyhedra_take_an_edge_radius_and_no_curvature(omega):
    if not has_polyhedra():
        return  # nothing to serve; a skipped engine test would stop continuous integration
    cubes(law("curvature"), "polyhedra")
    stops(r"(?s)Polyhedra on Polyhedra\).*edge radius in m")
    surfaces = {"granite": dl.Surface(edge_radius=4e-4)}
    for make in (lambda: law(4e-4), lambda: functor("hertz", "elastic", surfaces)):
        chosen = cubes(make(), "polyhedra")
        advance(2)
        assert chosen.contacts().radius == pytest.approx([4e-4], rel=1e-12)


def test_potential_particles_are_refused_by_name(omega):
    """YADE's geometry gives them no radius: MindlinPhys has no stiffness, and native Mindlin's force is NaN."""
    needs("POTENTIAL_PARTICLES")
    material()
    half, edge = 8e-3, 2e-3
    reach = yade.Vector3(half, half, half)
    planes = {"a": [1, -1, 0, 0, 0, 0], "b": [0, 0, 1, -1, 0, 0], "c": [0, 0, 0, 0, 1, -1], "d": [half - edge] * 6}
    corners = dict.fromkeys(("minAabb", "maxAabb", "minAabbRotated", "maxAabbRotated"), reach)
    for number, z in enumerate((0.0, 2 * half - 1e-4)):
        body = yade.Body()
        body.shape = yade.PotentialParticle(k=0.2, r=edge, R=2 * half, AabbMinMax=True, id=number, **planes, **corners)
        yade.utils._commonBodySetup(body, 1.0, reach, material="granite", pos=(0, 0, z), fixed=True)
        yade.O.bodies.append(body)
    geometry = yade.Ig2_PP_PP_ScGeom(twoDimension=False, unitWidth2D=1.0, calContactArea=True, areaStep=5)
    set_engines(law(edge), geometries=[geometry], bounds=[yade.PotentialParticle2AABB()])
    stops(r"contact 0\+1 of PotentialParticle")


def test_without_a_choice_one_warning_names_shape_and_radius(omega, level_sets):
    cubes(law())
    with pytest.warns(dy.ShapeWarning, match=r"LevelSet on LevelSet\) has R = 0.004 m") as caught:
        advance(4)
    assert len([w for w in caught if w.category is dy.ShapeWarning]) == 1
    with warnings.catch_warnings():
        warnings.simplefilter("error", dy.ShapeWarning)
        for chosen in ("body", 1e-3):
            cubes(law(chosen))
            advance(4)


def test_spheres_keep_their_radius_under_every_choice(omega):
    """Also a rough law: the same numbers to the last digit, natively."""
    from yade_scenes import force, two_spheres

    found = []
    for choice in (None, "body", "curvature", 1e-4):
        omega.reset()
        two_spheres(functor(radius=choice), steps=60)
        found.append(force())
    assert found[0] > 0 and len(set(found)) == 1


def test_a_rough_contact_has_the_radius_of_curvature(omega, level_sets):
    """All that the law derives from R is of this R, not only Hertz's coefficient."""
    material()
    rough = functor("pohrt-popov", "hertz", radius="curvature")
    for height in (0.0, 2 * R - 2e-5):
        omega.bodies.append(ellipsoid((2 * R, 2 * R, R), (0, 0, height)))
    engines(rough)
    advance(2)
    state, pair = rough.contacts(), GRANITE.combined(GRANITE)
    exact = dl.law("pohrt-popov", dl.Contact(state.radius[0], MODULUS, pair.roughness, pair.fractal_dimension, pair.hardness))
    assert omega.interactions[0, 1].phys.normalForce.norm() == pytest.approx(float(exact.force(state.overlap[0])), rel=1e-12)
    assert state.radius[0] == pytest.approx(0.02, rel=0.05)


@pytest.mark.parametrize("value", [0, -1e-3, math.inf, True, "edges"])
def test_what_is_no_choice_is_refused(omega, value):
    with pytest.raises(DemlawsError, match="radius="):
        law(value)
    if value != "edges" and value is not True:
        with pytest.raises(DemlawsError, match=r"Curvature\(largest="):
            law(dy.Curvature(largest=value))


def test_periodic_boundaries_are_refused(omega, level_sets):
    cubes(law("curvature"))
    omega.periodic = True
    omega.cell.hSize = yade.Matrix3(0.1, 0, 0, 0, 0.1, 0, 0, 0, 0.1)
    stops("not available with periodic boundaries")
