"""YADE's engine list with guards: its own property `O.engines`, which `patches` replaces; tags and contacts of the current
scene; and scenes of our own beside the user's."""

import contextlib
import math

import yade
import yade.utils

from demlaws.errors import DemlawsError
from demlaws.units import RANGES

O = yade.O  # noqa: E741  YADE's name
_engines = yade.wrapper.Omega.engines
_NAMES = "MindlinPhys", "MindlinCapillaryPhys", "MindlinPhysCDM"
PHYSICS = tuple(getattr(yade, name) for name in _NAMES if hasattr(yade, name))
TOKEN = "demlaws-scene"
"""Tag of a scene that identifies it; a loaded scene gets another one."""
FULL_CHECK_STEPS = (2, 3, 12, 102, 1002)
"""Calls of the guard with a check of every contact and body, which takes time."""


def get_engines():
    """The engine list with guards."""
    return list(_engines.__get__(O))


def set_engines(engines):
    """Set the engine list, which includes guards; YADE then updates its variables named by labels."""
    _engines.__set__(O, engines)


def tag(key):
    """A tag of the current scene, or None."""
    return O.tags[key] if key in O.tags.keys() else None  # noqa: SIM118  not a dict


def token_here():
    """The current scene's token, or None."""
    return tag(TOKEN)


@contextlib.contextmanager
def scratch_scene():
    """An empty scene beside the user's, which is left as it is."""
    home = O.thisScene
    scratch = O.addScene()  # a new one each time: O.reset() drops them, and switching to a dropped one does nothing
    O.switchToScene(scratch)
    if O.thisScene != scratch or scratch == home or len(O.bodies) or get_engines():
        O.switchToScene(home)
        raise DemlawsError("YADE gave no scene of its own to a test")
    try:
        yield
    finally:
        O.resetThisScene()
        O.switchToScene(home)


def fixed_pair(labels, radius, young, poisson):
    """Add two fixed spheres, one above the other, of new materials with these labels, to the current scene, which is empty."""
    for height, label in zip((0.0, 2.0 * radius), labels, strict=True):
        stone = yade.FrictMat(young=young, poisson=poisson, frictionAngle=0.5, density=2600, label=label)
        O.materials.append(stone)
        # with a colour: YADE would draw one from the random numbers of the user's script
        O.bodies.append(yade.utils.sphere((0, 0, height), radius, fixed=True, material=stone, color=(1, 1, 1)))


def contact_engines(functor, physics, reach, before=(), geometries=None, bounds=None):
    """Engines of contacts: forces reset, the collider, contacts of `physics` under a law; reach: its `verletDist`.

    before: engines between collider and contacts; geometries, bounds: functors in place of those of spheres and flats.
    """
    bounds = bounds or [yade.Bo1_Sphere_Aabb(), yade.Bo1_Facet_Aabb(), yade.Bo1_Wall_Aabb(), yade.Bo1_Box_Aabb()]
    geometries = geometries or [
        yade.Ig2_Sphere_Sphere_ScGeom(),
        yade.Ig2_Facet_Sphere_ScGeom(),
        yade.Ig2_Wall_Sphere_ScGeom(),
        yade.Ig2_Box_Sphere_ScGeom(),
    ]
    collider = yade.InsertionSortCollider(bounds, verletDist=reach)
    return [yade.ForceResetter(), collider, *before, yade.InteractionLoop(geometries, [physics], [functor])]


def dispatchers(engine):
    """The law dispatchers within an engine of the list."""
    if isinstance(engine, yade.InteractionLoop):
        yield engine.lawDispatcher
    elif isinstance(engine, yade.LawDispatcher):
        yield engine
    elif isinstance(engine, yade.ParallelEngine):
        for slave in engine.slaves:
            for member in slave if isinstance(slave, list | tuple) else (slave,):
                yield from dispatchers(member)


def law_functors(engines):
    """(dispatcher, functor) of every law functor."""
    return [(one, functor) for engine in engines for one in dispatchers(engine) for functor in one.functors]


def real_contacts():
    """The current scene's contacts that a law of ours acts on."""
    return [i for i in O.interactions if is_our_contact(i)]


def is_our_contact(contact):
    """Whether a contact is real and of a class that a law of ours acts on."""
    return contact.isReal and type(contact.phys) in PHYSICS


def invalid_radius(body):
    """Message about a sphere whose radius is not a positive number, or None."""
    radius = body.shape.radius if isinstance(body.shape, yade.Sphere) else 1.0
    if 0.0 < radius < math.inf:
        return None
    return f"body {body.id} is a sphere with radius = {radius:g} m: {RANGES['radius'].remedy}"


def mobilities(contact):
    """1/m [1/kg] of both bodies of a contact: of the clump for its member, 0 of a body that contacts do not move."""
    found = []
    for number in (contact.id1, contact.id2):
        body = O.bodies[number]
        body = O.bodies[body.clumpId] if body.isClumpMember else body
        held = not body.dynamic or set("xyz") <= set(body.state.blockedDOFs)
        found.append(0.0 if held or not body.state.mass > 0.0 else 1.0 / body.state.mass)
    return found
