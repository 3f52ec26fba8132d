"""Tangential stiffness of one contact: every law, every rule, every choice of normal stiffness."""

import numpy as np
import pytest
from examples import GRANITE, make, pairs, telling

import demlaws as dl
from demlaws.core.unloading import RULES
from demlaws.shear import sheared

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")
# what is followed is the rule's force: every rule with one law, and those that laws have of their own
every_pair = pytest.mark.parametrize(
    ("name", "unloading"), [p for p in pairs() if telling(p) and (p[0] == "pohrt-popov" or p[1] not in RULES)]
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


@pytest.mark.parametrize(
    "call",
    [
        lambda law: law.shear_stiffness(1e-6, 0.8, "secant"),
        lambda law: law.shear_stiffness(1e-6, 0.8, "tangent"),
        lambda law: law.shear_stiffness(1.0, 0.8),
        lambda law: sheared(law, [DEEP] * 3, [0.0, 1e-7, 2e-7], 5.0),
    ],
)
def test_bad_input(call):
    with pytest.raises(dl.DemlawsError):
        call(make("pohrt-popov", "hertz"))
