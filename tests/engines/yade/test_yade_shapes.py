"""Spheres on grids, facets between grid nodes and chained cylinders, and capillary physics: Hertz's law beside YADE's own.

The bodies are those of YADE's examples (grids, pfacet, chained-cylinders), the contacts those of Mindlin's physics.
"""

import functools
import itertools

import numpy as np
import pytest
from yade_scenes import engine_list, functor, interaction_loop, material, sphere, yade

from demlaws import yade as dy

RADIUS = 0.01
pytestmark = [pytest.mark.releases, pytest.mark.filterwarnings("ignore::UserWarning")]


def _grid(corners, closed=False):
    """A chain of connections between corners; closed: a triangle with a PFacet."""

    def build(yade):
        from yade.gridpfacet import gridConnection, gridNode, pfacet

        node = yade.CohFrictMat(young=1e9, poisson=0.3, density=1e3, frictionAngle=0.5, label="node")
        yade.O.materials.append(node)
        numbers = [yade.O.bodies.append(gridNode(list(place), 0.005, fixed=True, material=node)) for place in corners]
        for first, second in itertools.pairwise([*numbers, numbers[0]] if closed else numbers):
            yade.O.bodies.append(gridConnection(first, second, 0.005, material="granite"))
        if closed:
            yade.O.bodies.append(pfacet(*numbers, material="granite"))

    return build


def _cylinder(yade):
    from yade.gridpfacet import chainedCylinder

    yade.ChainedState.currentChain += 1  # chains outlive their scene
    for begin, end in itertools.pairwise([(-0.05, 0, 0), (0.05, 0, 0), (0.1, 0, 0), (0.1, 0, 0)]):  # the last one is a node
        chainedCylinder(yade.Vector3(begin), yade.Vector3(end), 0.005, fixed=True, material="granite")


def _sphere(yade):
    yade.O.bodies.append(sphere((0.003, 0, -0.005), RADIUS, fixed=True, material="granite"))


NODES = ("Ig2_GridNode_GridNode_GridNodeGeom6D",)
SHAPES = {
    "ScGridCoGeom": (
        _grid([(-0.05, 0, 0), (0.05, 0, 0), (0.1, 0, 0)]),
        ["Bo1_GridConnection_Aabb"],
        ["Ig2_Sphere_GridConnection_ScGridCoGeom", *NODES],
    ),
    "ScGridCoGeom of a PFacet": (
        _grid([(-0.05, -0.03, 0), (0.05, -0.03, 0), (0, 0.05, 0)], closed=True),
        ["Bo1_PFacet_Aabb", "Bo1_GridConnection_Aabb"],
        ["Ig2_Sphere_PFacet_ScGridCoGeom", *NODES],
    ),
    "CylScGeom": (_cylinder, ["Bo1_ChainedCylinder_Aabb"], ["Ig2_Sphere_ChainedCylinder_CylScGeom"]),
    "CylScGeom6D": (_cylinder, ["Bo1_ChainedCylinder_Aabb"], ["Ig2_Sphere_ChainedCylinder_CylScGeom6D"]),
    "MindlinCapillaryPhys": (_sphere, [], ["Ig2_Sphere_Sphere_ScGeom"]),
}


def _scene(name, law, body):
    """A scene with the shapes of that name and a body that is made when the materials are there; YADE's O, its number."""
    omega = yade.O
    omega.reset()
    material()
    build, bounds, geometries = SHAPES[name]
    physics = ["Ip2_FrictMat_FrictMat_MindlinPhys"]
    laws = [law]
    if name.endswith("CapillaryPhys"):
        physics = ["Ip2_FrictMat_FrictMat_MindlinCapillaryPhys"]
    if NODES[0] in geometries:
        physics = [*physics, "Ip2_CohFrictMat_CohFrictMat_CohFrictPhys"]
        laws = [law, yade.Law2_ScGeom6D_CohFrictPhys_CohesionMoment()]
    bounds, geometries, physics = ([getattr(yade, kind)() for kind in kinds] for kinds in (bounds, geometries, physics))
    omega.engines = engine_list(interaction_loop(*laws, geometries=geometries, physics=physics), bounds=bounds)
    build(yade)
    omega.dt = 1e-6
    return omega, omega.bodies.append(body())


def _impact(name, law):
    """Forces and torques on a sphere and its places at every step, and the classes of its contacts."""
    omega, ball = _scene(name, law, lambda: sphere((0.003, 0.0005, 0.015 + 1e-6), RADIUS, material="granite"))
    omega.bodies[ball].state.vel, omega.bodies[ball].state.angVel = (0.05, 0.02, -0.3), (3, -5, 2)
    omega.dt = 1e-7
    rows, classes = [], set()
    for _ in range(1200):
        omega.step()
        for contact in omega.interactions:
            if contact.isReal and ball in (contact.id1, contact.id2):
                classes.add((type(contact.geom).__name__, type(contact.phys).__name__))
        rows.append((*omega.forces.f(ball), *omega.forces.t(ball), *omega.bodies[ball].state.pos))
    return np.array(rows), classes


@pytest.mark.parametrize("name", SHAPES)
def test_hertz_is_native_mindlin(omega, name):
    if not hasattr(yade, "MindlinCapillaryPhys") and name.endswith("CapillaryPhys"):
        pytest.skip("this YADE is built without capillarity")
    native, classes = _impact(name, yade.Law2_ScGeom_MindlinPhys_Mindlin())
    assert name.split()[0] in {part for pair in classes for part in pair}
    mine, same = _impact(name, functor("hertz", "elastic", {}, shear="native"))
    assert same == classes and np.abs(native[:, 2]).max() > 20.0
    assert np.abs(native[:, 3:6]).max() > 1e-3  # it is sheared
    for columns in (slice(0, 3), slice(3, 6), slice(6, 9)):
        scale = np.abs(native[:, columns]).max()
        assert mine[:, columns] == pytest.approx(native[:, columns], rel=0, abs=1e-11 * scale)


def _over_a_joint(name, law):
    """Forces and torques on a sphere that is led over a joint, away from the chain and onto it again, and back."""
    omega, ball = _scene(name, law, lambda: sphere((0.045, 0, 0.015 - 1e-6), RADIUS, fixed=True, material="granite"))
    rows = []
    for steps, velocity in ((500, (20, 0, 0)), (50, (0, 0, 0.04)), (50, (0, 0, -0.04)), (500, (-20, 0, 0)), (50, (0, 0, 0.04))):
        omega.bodies[ball].state.vel = velocity
        for _ in range(steps):
            omega.step()
            rows.append((*omega.forces.f(ball), *omega.forces.t(ball)))
    return np.array(rows)


@pytest.mark.native_step
@pytest.mark.parametrize("name", ["ScGridCoGeom", "CylScGeom", "CylScGeom6D"])
def test_a_joint_doubles_the_force_as_natively(omega, name):
    native = _over_a_joint(name, yade.Law2_ScGeom_MindlinPhys_Mindlin())
    with pytest.warns(dy.ShapeWarning):
        mine = _over_a_joint(name, functor("hertz", "elastic", {}, shear="native"))
    assert native[450, 2] == pytest.approx(2.0 * native[50, 2])
    for columns in (slice(0, 3), slice(3, 6)):
        assert mine[:, columns] == pytest.approx(native[:, columns], rel=0, abs=1e-12 * np.abs(native[:, columns]).max())


@pytest.mark.parametrize("name", ["ScGridCoGeom", "CylScGeom6D"])
def test_a_rough_law_is_softer_there(omega, name):
    law = functor()
    rough, _ = _impact(name, law)
    totals = law.totals()
    smooth, _ = _impact(name, functor("hertz", "elastic", {}))
    assert 0.2 * smooth[:, 2].max() < rough[:, 2].max() < 0.95 * smooth[:, 2].max() and totals.dissipated > 0


@pytest.mark.parametrize("name", ["ScGridCoGeom", "ScGridCoGeom of a PFacet", "CylScGeom"])
def test_an_inadmissible_material_is_refused(omega, monkeypatch, name):
    monkeypatch.setitem(globals(), "material", functools.partial(material, poisson=0.7))
    with pytest.raises(RuntimeError, match=r"'granite': poisson = 0\.7"):
        _impact(name, functor("hertz", "elastic", {}))
