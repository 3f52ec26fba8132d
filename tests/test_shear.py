"""Tangential stiffness of one contact: every law, every rule, every choice of normal stiffness."""

import numpy as np
import pytest
from examples import GRANITE, make, pairs, shared, telling
from shear_paths import GRANITE_RATIO

import demlaws as dl
from demlaws.core.shear import CHOICES
from demlaws.core.unloading import RULES
from demlaws.driver import sheared

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")
# what is followed is the rule's force: every rule with one law, and those that laws have of their own
every_pair = pytest.mark.parametrize(
    ("name", "unloading"), shared(pairs(), lambda pair: telling(pair) and (pair[0] == "pohrt-popov" or pair[1] not in RULES))
)
DEEP = 5.0 * GRANITE.roughness
BACK = np.array([0.4, 1.0, 1.0 - 1e-11, 0.999, 1.0, 1.0 + 1e-11, 1.1]) * DEEP


@every_pair
def test_what_each_choice_is(name, unloading):
    """Against the law's own stiffnesses: just below the overlap, and of first loading at that force."""
    law = make(name, unloading)
    path = law.follow(BACK)
    elastic, loading = (law.shear_stiffness(BACK, 0.5, choice) for choice in ("elastic", "loading"))
    below = [law.follow([*BACK[: n + 1], BACK[n] * (1 - 1e-9)]).stiffness[-1] for n in range(BACK.size)]
    np.testing.assert_allclose(elastic, 0.5 * np.array(below), rtol=1e-7)
    np.testing.assert_allclose(loading, 0.5 * law.stiffness(law.overlap(path.force)), rtol=1e-7)


@every_pair
def test_elastic_and_loading_go_through_a_reversal(name, unloading):
    law = make(name, unloading)
    for choice in ("elastic", "loading"):
        one = law.shear_stiffness(BACK, 1.0, choice)
        assert one[2] == pytest.approx(one[1], rel=1e-9)
        assert one[5] == pytest.approx(one[4], rel=1e-9)


@pytest.mark.parametrize("unloading", ["elastic", "hertz"])
def test_all_choices_are_one_for_hertz(unloading):
    law = make("hertz", unloading)
    path = law.follow(BACK)
    for choice in CHOICES:
        np.testing.assert_allclose(law.shear_stiffness(BACK, 1.0, choice), path.stiffness, rtol=1e-11)


def test_elastic_is_the_smooth_contacts_with_hertz_unloading():
    """Yimsiri & Soga's view: at one force the smooth contact's tangential stiffness."""
    law, smooth = make("pohrt-popov", "hertz"), make("hertz")
    force = law.follow(BACK).force
    np.testing.assert_allclose(law.shear_stiffness(BACK, 1.0), smooth.stiffness(smooth.overlap(force)), rtol=1e-10)


def test_sheared_work_is_stored_where_nothing_changes():
    law = make("pohrt-popov", "hertz")
    there = np.linspace(0.0, 1e-9, 30)
    path = sheared(law, np.full(30, DEEP), np.concatenate([there[:15], there[14::-1]]), GRANITE_RATIO)
    np.testing.assert_allclose(path.work, path.stored, atol=1e-12 * path.stored.max())
    assert path.shear_force[-1] == pytest.approx(0.0, abs=1e-12 * path.shear_force.max())


@pytest.mark.parametrize(
    "call",
    [
        lambda law: law.shear_stiffness(1e-6, 0.8, "secant"),
        lambda law: law.shear_stiffness(1e-6, 0.8, "tangent"),
        lambda law: law.shear_stiffness(1e-6, 0.0),
        lambda law: law.shear_stiffness(np.nan, 0.8),
        lambda law: law.shear_stiffness(1.0, 0.8),
        lambda law: law.shear_stiffness([[1e-6]], 0.8),
    ],
)
def test_bad_input(call):
    with pytest.raises(dl.DemlawsError):
        call(make("pohrt-popov", "hertz"))


@pytest.mark.parametrize("name", ["pohrt-popov", "rms"])
def test_elastic_where_rounding_leaves_nothing_to_recover(name):
    """At 1e-11 σ the recoverable overlap is lost in the total one: K = 1.5 (C²P)^(1/3), C = (4/3) E* √R, of the force."""
    law = make(name, "hertz")
    depth = np.geomspace(1e-13, 1e-6, 200) * GRANITE.roughness
    found = np.array([law.shear_stiffness(d, 1.0, "elastic") for d in depth])
    coefficient = 4.0 / 3.0 * GRANITE.modulus * GRANITE.radius**0.5
    np.testing.assert_allclose(found, 1.5 * np.cbrt(coefficient**2 * law.force(depth)), rtol=1e-6)
