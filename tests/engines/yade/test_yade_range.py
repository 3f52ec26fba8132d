"""Overlaps that no law of small strains is for: warned of beyond R/10, refused beyond R."""

import warnings

import pytest
from yade_scenes import advance, functor, material, set_engines, sphere, stops, yade

import demlaws as dl

pytestmark = pytest.mark.filterwarnings("ignore:.* above the range of:demlaws.ValidityWarning")  # another test's
RADIUS = 0.01  # of two spheres: R = 5 mm


def pressed(law, overlap, young=60.6e9, speed=0.0):
    omega = yade.O
    omega.reset()
    below, above = material(), material(young=young)
    for place in (0.0, 0.2):
        omega.bodies.append(sphere((0, 0, place), RADIUS, fixed=True, material=below))
        omega.bodies.append(sphere((0, 0, place + 2 * RADIUS - overlap), RADIUS, fixed=True, material=above))
    omega.bodies[1].state.vel = (0, 0, -speed)
    set_engines(law, 1e-6)


@pytest.mark.parametrize("way", ["native", "public"])
@pytest.mark.parametrize("rule", ["elastic", "hertz"])
def test_a_large_overlap_is_warned_of_once(omega, way, rule):
    law = functor("pohrt-popov", rule, bridge=way)
    pressed(law, 0.499e-3)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        warnings.filterwarnings("error", "law 'demlaws': overlap", dl.ValidityWarning)
        advance(5)
    pressed(law, 0.6e-3)
    with pytest.warns(dl.ValidityWarning, match=r"law 'demlaws': overlap 0.0006 m is 0.12 of .* R = 0.005 m \(2 of 2 con"):
        advance(2)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        warnings.filterwarnings("error", "law 'demlaws': overlap", dl.ValidityWarning)
        advance(20)
    assert omega.interactions[0, 1].phys.normalForce.norm() > 0
    pressed(law, 0.6e-3)  # another scene: again
    with pytest.warns(dl.ValidityWarning, match="2 of 2"):
        advance(2)


@pytest.mark.parametrize("way", ["native", "public"])
def test_an_overlap_beyond_the_radius_stops(omega, way):
    """Sphere 1 is driven in at 200 m/s; no force is applied at that overlap."""
    law = functor(bridge=way, neverErase=True)
    pressed(law, 4.9e-3, speed=200.0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        stops(r"contact 0\+1: overlap 0.005\d* m is 1.\d* times .* R = 0.005 m.*check units", 20)
    assert omega.iter < 5


@pytest.mark.parametrize("way", ["native", "public"])
def test_a_marker_has_no_force_anywhere(omega, way):
    """young=0, as YADE's examples mark water levels: no force, as native Mindlin."""
    law = functor(bridge=way)
    pressed(law, 8e-3, young=0.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        advance(5)
    assert omega.interactions.countReal() == 2 and omega.forces.f(1).norm() == 0 and law.totals() == (0.0, 0.0)
    functor("yip-venart", "elastic", bridge=way, moduli=None, label="later")  # made after the marker
