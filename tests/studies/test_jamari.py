"""The tests of Jamari & Schipper: printed and drawn by the command, and the repeated contact of 2008."""

import numpy as np
import pytest

from demlaws import regime
from studies.jamari import cycles, published
from studies.jamari.__main__ import main

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")


def test_the_command(tmp_path, capsys):
    picture = tmp_path / "regime.png"
    assert main(["--figure", str(picture)]) == 0
    printed = capsys.readouterr().out
    assert all(f"\n{test.label} " in printed for test in published.published_tests())
    assert "by the solution: the order is that of what was seen" in printed
    assert "by Eq. 4: 1 of the tests of 2006 stands out of order" in printed
    assert picture.stat().st_size > 20_000


@pytest.mark.parametrize(("kind", "criterion"), [("isotropic", 0.16), ("anisotropic", 0.15)])
def test_repeated_contact_of_the_paper(kind, criterion):
    """0.2 N on aluminium: asperities only; plastic change in the first cycle, practically none after."""
    contact = published.published_contact(kind)
    assert regime.pressure_ratio(contact.pair, 0.2) == pytest.approx(criterion, abs=0.005)
    history = cycles.repeat(contact, 0.2)
    assert history[0].step.counts[1] + history[0].step.counts[2] > 0
    assert history[0].change > 0
    assert all(c.relative_change <= 0.01 for c in history[1:])
    assert cycles.run_in_cycle(history) == 1
    first = history[0].contact.heights.heights
    for cycle in history:
        if cycle.contact is not None:
            assert np.abs(cycle.contact.heights.heights - first).max() <= 0.01 * np.ptp(first - contact.heights.heights)
    assert history[-1].step.counts[1] <= 3 and history[-1].step.counts[2] == 0  # those that share a pixel of their rings
    area = history[0].step.contact_area
    assert history[-1].step.contact_area == pytest.approx(area, rel=0.01)
