"""Overlapping members of a clump: two contacts where the grain has one, and a remedy."""

import math

import pytest
from yade_scenes import MODULUS, functor, material, set_engines

import demlaws as dl

R, OVERLAP = 0.01, 1e-5
RADIUS_OF_CONTACT = math.sqrt(R * OVERLAP)


def standing(omega, apart, radius=None):
    """Force on a clump of two equal spheres, `apart` from each other, that stands on a wall with both, over one sphere's."""
    import yade

    omega.reset()
    stone = material()
    omega.bodies.append(yade.utils.wall((0, 0, 0), 2, material=stone))
    members = [yade.utils.sphere((x, 0, R - OVERLAP), R, material=stone) for x in (-apart / 2, apart / 2)]
    clump, _ = omega.bodies.appendClumped(members)
    omega.bodies[clump].state.blockedDOFs = "xyzXYZ"
    law = functor("hertz", "elastic", None, smooth=True, bridge="native", radius=radius)
    set_engines(law, 1e-9)
    omega.run(3, True)
    one = float(dl.law("hertz", dl.Contact(R, MODULUS)).force(OVERLAP))
    return law.contacts().force.sum() / one


@pytest.mark.parametrize("apart", [1e-9, 0.1 * RADIUS_OF_CONTACT, 2 * RADIUS_OF_CONTACT, R])
def test_two_members_at_one_place_double_the_force(omega, apart):
    """Independent of their distance: right where the contacts are apart, wrong by 2 where their areas cover each other."""
    assert standing(omega, apart) == pytest.approx(2.0, rel=1e-9)


def shared(contact):
    """R/n² for n contacts of the same two grains whose areas cover each other: n of them then carry one contact's force."""
    import yade

    def grains(one):
        bodies = [yade.O.bodies[number] for number in (one.id1, one.id2)]
        return {body.clumpId if body.isClumpMember else body.id for body in bodies}

    first, second = contact.geom.refR1, contact.geom.refR2
    flat = any(isinstance(yade.O.bodies[n].shape, yade.Wall | yade.Box | yade.Facet) for n in (contact.id1, contact.id2))
    radius = second if flat else first * second / (first + second)
    reach = 2 * math.sqrt(radius * contact.geom.penetrationDepth)
    near = [
        one
        for one in yade.O.interactions
        if one.isReal and grains(one) == grains(contact) and (one.geom.contactPoint - contact.geom.contactPoint).norm() < reach
    ]
    return radius / len(near) ** 2


def test_a_function_of_the_contact_is_the_remedy(omega):
    assert standing(omega, 0.1 * RADIUS_OF_CONTACT, shared) == pytest.approx(1.0, rel=1e-9)
    assert standing(omega, 4 * RADIUS_OF_CONTACT, shared) == pytest.approx(2.0, rel=1e-9)
