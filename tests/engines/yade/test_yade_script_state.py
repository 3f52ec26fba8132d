"""State that a script sets between steps: adopted as by YADE's own law, or the run stops."""

import numpy as np
import pytest
from yade_scenes import (
    GRANITE,
    MODULUS,
    advance,
    engine_list,
    functor,
    interaction_loop,
    material,
    set_engines,
    sphere,
    stops,
    under_yade,
    yade,
)

import demlaws as dl

OWN = ("kno", "kso", "prevU")
"""What the law itself writes: a change stops the run."""
SHEARS = {
    "elastic": lambda: functor("hertz", "elastic", None),
    "rough": lambda: functor("pohrt-popov", "hertz"),
    "loading": lambda: functor("pohrt-popov", "hertz", shear="loading"),
    "slip": lambda: functor("pohrt-popov", "hertz", shear="slip"),
    "native": lambda: functor("hertz", "elastic", None, shear="native"),
}


def sticking(law):
    """Two fixed spheres whose contact has a shear force below Coulomb's limit; the contact."""
    omega = yade.O
    omega.reset()
    stone = material()
    omega.bodies.append([sphere((0, 0, 0), 0.01, fixed=True), sphere((0, 0, 0.02 - 1e-5), 0.01, fixed=True)])
    for body in omega.bodies:
        body.material = stone
    omega.engines = engine_list(interaction_loop(law))
    omega.dt = 1e-6
    omega.step()
    omega.bodies[1].state.vel = (1e-3, 0, 0)
    advance(1000)
    omega.bodies[1].state.vel = (0, 0, 0)
    advance(2)
    return omega.interactions[0, 1]


def other(value):
    """Another value of the same kind."""
    if isinstance(value, bool):
        return not value
    if isinstance(value, float):
        return 1.5 * value if value == value and value != 0.0 else 0.125
    return type(value)(*(1.25 * part + 0.125 for part in value))


def after(law, part, name):
    """Forces of the contact two steps after a script has changed an attribute, or the message with which the run stops."""
    thing = getattr(sticking(law), part)
    setattr(thing, name, other(getattr(thing, name)))
    try:
        advance(2)
    except RuntimeError as error:
        return str(error)
    phys = yade.O.interactions[0, 1].phys
    return np.array([*phys.normalForce, *phys.shearForce, *phys.shearElastic])


def attributes():
    """(phys or geom, name) of every attribute that a script can set."""
    found = []
    for part, thing in (("geom", yade.ScGeom()), ("phys", yade.MindlinPhys())):
        for name, value in thing.dict().items():
            try:
                setattr(thing, name, value)
            except AttributeError:  # read-only
                continue
            found.append((part, name))
    return found


@pytest.mark.native_step
def test_every_attribute_acts_as_in_yades_law_or_stops(omega):
    """A walk over all that geometry and physics have; the law of Hertz beside YADE's own."""
    names = attributes()
    assert {"refR1", "shearElastic", "betan", "kno"} <= {name for _, name in names}
    for part, name in names:
        mine = after(SHEARS["elastic"](), part, name)
        if name in OWN:
            assert isinstance(mine, str), name
            continue
        stock = after(yade.Law2_ScGeom_MindlinPhys_Mindlin(), part, name)
        assert not isinstance(mine, str), (name, mine)
        if name in ("normal", "shearElastic"):  # YADE's turn of the force leaves, or keeps it out of, the plane of the contact
            assert np.abs(mine[5::3]).max() < 1e-3 * np.abs(mine[3:]).max()
            stock[5::3] = mine[5::3]
        assert mine == pytest.approx(stock, rel=1e-5, abs=1e-5 * np.abs(stock).max()), name


@pytest.mark.parametrize("shear", [name for name in SHEARS if name != "slip"])
def test_a_shear_force_that_a_script_sets_is_adopted(omega, shear):
    """Reset to zero, and restored in a new scene from the script's own file; energies remain those of the contact."""
    law = SHEARS[shear]()
    contact = sticking(law)
    place, force = tuple(omega.bodies[1].state.pos), yade.Vector3(contact.phys.shearElastic)
    stored, lost = law.totals().shear_stored, law.totals().shear_dissipated
    assert force.norm() > 1.0
    contact.phys.shearElastic = yade.Vector3.Zero
    advance(2)
    assert omega.interactions[0, 1].phys.shearForce.norm() == 0.0
    assert law.totals().shear_stored == 0.0 and law.totals().shear_dissipated == lost
    law = SHEARS[shear]()
    sticking(law)
    omega.interactions.clear()
    omega.bodies[1].state.pos = place
    yade.utils.createInteraction(0, 1).phys.shearElastic = force
    advance(2)
    assert tuple(omega.interactions[0, 1].phys.shearForce) == pytest.approx(tuple(force), abs=1e-9 * force.norm())
    assert law.totals().shear_stored == pytest.approx(stored, rel=0.05)


def test_springs_of_partial_slip_do_not_adopt_a_force(omega):
    sticking(SHEARS["slip"]()).phys.shearElastic = yade.Vector3.Zero
    stops(r"contact 0\+1: its shearElastic was set by the script.*shear=.elastic")


def test_a_shear_force_set_after_loading_is_adopted(omega, tmp_path):
    law = SHEARS["rough"]()
    sticking(law)
    omega.save(str(tmp_path / "x.yade"))
    omega.load(str(tmp_path / "x.yade"))
    omega.interactions[0, 1].phys.shearElastic *= 0.5
    half = tuple(omega.interactions[0, 1].phys.shearElastic)
    advance(2)
    assert tuple(omega.interactions[0, 1].phys.shearForce) == pytest.approx(half, rel=1e-9)


@pytest.mark.parametrize("overlap", [2e-5, 1e-3])
def test_radii_that_grow_are_followed(omega, overlap):
    """As in packings that are made by growth: R is that of the bodies now (the run stopped with "2 times R, check units")."""
    law, radius = functor(), 1e-3
    stone = material()
    omega.bodies.append([sphere((0, 0, z), radius, fixed=True, material=stone) for z in (0, 1.9999 * radius)])
    set_engines(law, 1e-6)
    advance(3)
    yade.utils.growParticles(8, True, False)
    omega.bodies[1].state.pos = (0, 0, 16 * radius - overlap)
    advance(3)
    pair = GRANITE.combined(GRANITE)
    contact = dl.Contact(4e-3, MODULUS, pair.roughness, pair.fractal_dimension, pair.hardness)
    assert law.contacts().radius == pytest.approx([4e-3], rel=1e-12)
    depth = omega.interactions[0, 1].geom.penetrationDepth
    expected = dl.law("pohrt-popov", contact, "hertz").follow([1e-7, depth]).force[-1]
    assert omega.interactions[0, 1].phys.normalForce.norm() == pytest.approx(expected, rel=1e-9)


def test_a_run_leaves_the_globals_of_a_script_alone(tmp_path):
    """YADE copies the local variables of the function that calls it to the script's globals when a PyRunner acts."""
    under_yade(
        """
from yade_scenes import *
native, omega, keywords = "script", 2.0, [3]
one = functor("hertz", "elastic", None, smooth=True)
set_engines(one, 1e-7)
yade.O.engines = [*yade.O.engines, yade.PyRunner(iterPeriod=1, command="ran = True")]
yade.O.bodies.append([sphere((0, 0, n), 0.3, material=material()) for n in range(2)])
before = set(globals())
yade.O.run(3, True)
yade.O.step()
assert (native, omega, keywords) == ("script", 2.0, [3]) and set(globals()) - before <= {"before", "ran"}
print("ALONE")
""",
        tmp_path,
    ).stdout.index("ALONE")
