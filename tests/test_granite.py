"""The granite tests: published numbers, protocol, files."""

import numpy as np
import pytest
from examples import GRANITE_TESTS

from demlaws import granite

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")
STONES = {
    "SS(18-18)": ((8.76, 1.56, 2.21), (8.63, 1.84, 2.23)),
    "SS(12-18)": ((6.05, 2.83, 2.33), (8.75, 3.09, 2.25)),
    "SF(12)": ((6.05, 3.61, 2.23), (np.inf, 5.48, 2.32)),
    "VS(18-18)": ((8.27, 0.10, 2.06), (7.90, 0.11, 2.09)),
    "RS(18-18)": ((8.2, 3.30, 2.17), (8.58, 4.20, 2.23)),
}
"""Table 2 as printed: radius [mm], Sq [µm] and Df of both stones of a test."""


@pytest.mark.parametrize("name", STONES)
def test_what_is_printed_of_the_stones_gives_what_is_printed_of_the_pairs(name):
    """R and σ of the pair follow from both stones, to the digits printed."""
    test, ((r1, s1, d1), (r2, s2, d2)) = granite.find_test(name), STONES[name]
    assert 1.0 / (1.0 / r1 + 1.0 / r2) == pytest.approx(1e3 * test.radius, abs=6e-3)
    assert np.hypot(s1, s2) == pytest.approx(1e6 * test.roughness, abs=0.015)
    assert 0.5 * (d1 + d2) == pytest.approx(test.fractal_dimension, abs=1e-9)


@pytest.mark.parametrize("name", GRANITE_TESTS)
def test_displacement_and_stiffness(name):
    """Of each law from its printed inputs; Bahrami's default constant is 0.9 % stiffer than the printed one."""
    test = granite.find_test(name)
    for law, (gained, stiffness) in GRANITE_TESTS[name].expected.items():
        bound = granite.bind(law, test, "elastic")
        share, scatter = {"bahrami": (0.01, 0.0102), "yip-venart": (0.0005, 0.021)}.get(law, (0.0005, 0.0007))
        assert granite.displacement_gained(bound) * 1e6 == pytest.approx(gained, abs=0.06 + share * gained)
        assert granite.stiffness_at(bound, 10.0) / 1e3 == pytest.approx(stiffness, rel=scatter)


def test_cycles_of_the_cone():
    run, _ = granite.run_test("rough-plastic", granite.find_test("RFC10"))
    stages = granite.stages_of(run)
    assert [round(s.maximum_force) for s in stages] == [20, 40, 80, 150, 300, 450]
    assert all(s.over_hertz == pytest.approx(1.0, abs=1e-3) for s in stages[1:])
    # K_y = π R p_y
    assert all(s.final_stiffness == pytest.approx(np.pi * 0.96e-3 * 1.66e9, rel=1e-9) for s in stages[1:])
    assert np.all(np.diff([s.plastic_overlap for s in stages]) > 0)
