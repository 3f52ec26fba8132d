"""Laws and pairs of laws that end at a largest force: checked up to there, refused beyond, in Python, tables and YADE."""

import re

import numpy as np
import pytest

import demlaws as dl
from demlaws.errors import NotPassive, quiet

CONTACT = dl.Contact(4e-3, 32e9)
END = 5e-5
"""Overlap [m] at which the humped law carries 40 N."""


def force(p, overlap):
    return 1e6 * overlap - 4e9 * overlap**2  # falls from 125 µm on


def stiffness(p, overlap):
    return 1e6 - 8e9 * overlap


@pytest.fixture(autouse=True)
def humped(registered_here):
    dl.register(dl.define("humped", force, stiffness, max_force="40 N"))


def test_a_law_is_checked_to_its_largest_force():
    law = dl.law("humped", CONTACT)
    assert (law.largest_force, law.largest_overlap) == pytest.approx((40.0, END), rel=1e-14)
    assert law.force(law.largest_overlap) == pytest.approx(40.0, rel=1e-14)
    assert law.overlap(40.0) == pytest.approx(END, rel=1e-14)
    assert law.energy(law.largest_overlap) == pytest.approx(0.5e6 * END**2 - 4e9 / 3.0 * END**3, rel=1e-12)
    assert dl.check_law("humped", CONTACT, rules=("elastic", "table"), paths=50, yade=False).passed
    for last in (70.0, "1e3 N"):  # its largest is 62.5 N
        dl.register(dl.define("humped-too-far", force, stiffness, max_force=last))
        with pytest.raises(dl.DemlawsError, match=r"at overlap 0\.00012\d+ m the stiffness is -"):
            dl.law("humped-too-far", CONTACT)
    dl.register(dl.define("humped-too-far", force, stiffness, max_force=62.4))  # exceeded from 120 to 130 µm only
    assert dl.law("humped-too-far", CONTACT).largest_overlap == pytest.approx(1.2e-4, rel=1e-9)
    with pytest.raises(dl.DemlawsError, match="max_force = 0 N"):
        dl.define("humped-too-far", force, stiffness, max_force=0.0)
    with pytest.raises(dl.DemlawsError, match="cannot be a name"):
        dl.define("humped-too-far", force, stiffness, options={"max_force": 3.0})


def test_a_force_that_nowhere_reaches_its_end():
    def bounded(p, overlap):
        return 30.0 * overlap / (overlap + 1e-5)

    def slope(p, overlap):
        return 30.0 * 1e-5 / (overlap + 1e-5) ** 2

    dl.register(dl.define("bounded", bounded, slope, max_force=40.0))
    law = dl.law("bounded", CONTACT)  # rises everywhere: its range is that of every law
    assert law.largest_overlap == CONTACT.radius
    dl.register(dl.define("bounded", bounded, slope, max_force=25.0))
    assert dl.law("bounded", CONTACT).largest_overlap == pytest.approx(5e-5, rel=1e-12)


@pytest.mark.parametrize(
    "ask",
    [
        lambda law: law.force(1.001 * END),
        lambda law: law.stiffness(2e-4),
        lambda law: law.overlap(40.1),
        lambda law: law.follow([1e-5, 1e-4]),
        lambda law: law.evaluate(np.array([1e-5, 1e-4])),
        lambda law: law.tabulate(max_force=50.0),
        lambda law: dl.driver.force_controlled(law, [50.0]),
    ],
)
def test_beyond_it_is_an_error(ask):
    with pytest.raises(dl.DemlawsError, match=r"max_force = 40 N"):
        ask(dl.law("humped", CONTACT))


@pytest.mark.parametrize("last", [None, 20.0])
def test_its_table_ends_below(last, tmp_path):
    """The last cell of a table ends at a place of its grid: of a law that ends, at the last one before."""
    table = dl.law("humped", CONTACT).tabulate(max_force=last)
    assert 0.93 * 40.0 < table.largest_force <= 40.0 if last is None else 20.0 <= table.largest_force < 22.0
    read = dl.Table.load(table.save(tmp_path / "humped.tbl"))
    with pytest.raises(dl.DemlawsError, match="beyond the table"):
        read.force(END)


def test_contacts_of_other_sizes_end_at_the_same_force():
    def power(p, overlap):
        return p.hertz_coefficient * overlap**1.5

    def slope(p, overlap):
        return 1.5 * p.hertz_coefficient * overlap**0.5

    dl.register(dl.define("short-hertz", power, slope, max_force=3.0))
    law = dl.law("short-hertz", dl.Contact(np.array([1e-3, 4e-3]), 32e9), "hertz")
    ends = np.array([dl.law("hertz", dl.Contact(r, 32e9)).overlap(3.0) for r in (1e-3, 4e-3)])
    np.testing.assert_allclose(law.force(0.999999 * ends), 3.0, rtol=1e-5)
    with pytest.raises(dl.DemlawsError, match=r"contact 1: .*max_force = 3 N"):
        law.evaluate(np.array([0.9, 1.1]) * ends, law.new_state(2))


# --- pairs


def loading_and_unloading():
    """rms with an unloading branch that is less stiff than it from 140 N on: fitted, the test went to 100 N."""
    pair = dl.Contact(4.35e-3, 32.32e9, 2.4e-6)
    return pair, dl.law("hertz", pair.with_values(modulus=0.98 * pair.modulus))


def test_a_pair_is_judged_to_its_largest_force():
    pair, branch = loading_and_unloading()
    with pytest.raises(NotPassive) as refused:
        dl.law("rms", pair, branch)
    most = float(re.search(r"no contact carries more than (\S+) N, max_force", str(refused.value))[1])
    with quiet():
        law = dl.law("rms", pair, branch, max_force=f"{0.8 * most} N")
        assert 0.8 * most <= law.largest_force < 0.9 * most and law.unloading == "table"
        rise = np.linspace(0.0, 0.999 * law.largest_overlap, 4000)
        path = law.follow(np.concatenate([rise, rise[::-1]]))
        assert np.min(np.diff(path.dissipated)) >= -1e-10 * np.max(path.work)
        assert np.sum(0.5 * np.diff(path.overlap) * (path.force[1:] + path.force[:-1])) > 0.0
        with pytest.raises(dl.DemlawsError, match="beyond the table, which ends at"):
            law.force(1.2 * law.largest_overlap)
        with pytest.raises(NotPassive, match="would return more work"):
            dl.law("rms", pair, branch, max_force=1.3 * most)


def test_it_is_a_table_in_closed_form_accuracy():
    pair, _ = loading_and_unloading()
    with quiet():
        table, law = dl.law("rms", pair, max_force=50.0), dl.law("rms", pair)
        loads = np.linspace(0.1, 50.0, 50)
        np.testing.assert_allclose(table.overlap(loads), law.overlap(loads), rtol=1e-5)
    assert table.unloading == law.unloading == "hertz"
    with pytest.raises(dl.DemlawsError, match="max_force"):
        dl.law("rms", pair, max_force="much")


def test_a_largest_force_below_all_forces_is_named():
    """The text asked whether the unloading curve was for another contact."""
    match = r"max_force = \S+ N is below all forces of law 'rms', which begin with"
    with quiet(), pytest.raises(dl.DemlawsError, match=match):
        dl.law("rms", dl.Contact(4e-3, 32e9, 2e-6), max_force=1e-30)
