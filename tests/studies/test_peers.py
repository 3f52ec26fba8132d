"""Laws that other codes have, fitted to made points of the granite reference."""

import numpy as np
import pytest

from demlaws.granite import find_test
from studies.trade.peers import PEERS, held_table, held_together, made_points

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")  # cones at 450 N: overlaps beyond R/10


def test_points_are_the_references():
    """Loaded twice and unloaded twice; more is left after the second."""
    displacement, force = made_points(find_test("RFC10"), 450.0)
    assert force.max() == pytest.approx(450.0, rel=1e-9)
    falls = np.flatnonzero(np.diff(force) < 0)
    assert 0 < displacement[falls[0]] < displacement[-1] < displacement.max()
    assert force[-1] == pytest.approx(9.0, rel=1e-9)


def test_what_a_fit_leaves():
    """Thornton and Ning's plastic sphere is nearly the reference where roughness hardly matters, and finds its yield pressure:
    that is by construction. Hertz's contact returns what it took, whatever E* is."""
    rows = {r.law: r for r in held_together(("hertz", "thornton-ning"), (("RFC10", 450.0),))}
    plastic, elastic = rows["thornton-ning"], rows["hertz"]
    assert plastic.parameters["yield_pressure"] == pytest.approx(1.66e9, rel=0.01)
    assert plastic.rms < 0.005 and plastic.left < 0.01
    assert elastic.rms > 0.1 and elastic.left == elastic.worst > 0.3
    assert "thornton-ning" in held_table(rows.values()) and set(rows) < set(PEERS)
