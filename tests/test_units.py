"""Numbers as text, and messages about them."""

import array
import time

import numpy as np
import pytest

import demlaws as dl
from demlaws.errors import LONGEST_TEXT
from demlaws.units import as_float, check_overlaps, number, quantity

PAIR = dl.Contact(4e-3, 32e9)


def test_long_text_is_no_number():
    """The work of its reading grows with its length, not with a power of it: no more than `_LONGEST` characters are matched."""
    start = time.process_time()
    for text in ("1" + 100 * "0", "1" * 1600 + " x y", "1" * 100_000 + "e", " " * 100_000 + "x", "1." * 50_000):
        with pytest.raises(dl.DemlawsError, match="must be a number"):
            quantity(text, "radius", "m")
    assert time.process_time() - start < 5.0  # minutes with a pattern that goes back
    assert quantity("1" + 99 * "0", "radius") == 1e99
    assert quantity("  3.mm ", "radius", "m") == 3e-3 and quantity(".5e3", "radius") == 500.0


def test_a_message_does_not_repeat_a_long_word():
    word = "a" * 100_000
    for wrong in (
        lambda: dl.law("hertz", PAIR, **{word: 1}),
        lambda: dl.law("hertz", PAIR, unloading=word),
        lambda: PAIR.with_values(**{word: 1}),
        lambda: dl.Contact(word, 1e9),
    ):
        with pytest.raises(dl.DemlawsError) as caught:
            wrong()
        assert len(str(caught.value)) < 1000
    assert len(str(dl.DemlawsError("a b " * 100_000))) == LONGEST_TEXT


@pytest.mark.parametrize("raw", [b"abc", bytearray(b"12"), memoryview(b"abc"), memoryview(array.array("u", "ab"))])
def test_bytes_are_no_numbers(raw):
    """The letter a is no radius of 97 m."""
    with pytest.raises(dl.DemlawsError, match="radius must be a number"):
        dl.Contact(raw, 32e9)


@pytest.mark.parametrize("use", ["force", "energy", "follow"])
def test_an_overlap_beyond_all_numbers_is_one_error(use):
    law = dl.law("hertz", PAIR)
    with pytest.raises(dl.DemlawsError, match="beyond R"):
        getattr(law, use)(np.array([1e308]))
    with pytest.raises(dl.DemlawsError, match="not enough memory"):
        law.joined("hertz").new_state(10**15)


def test_a_number_that_is_refused_is_shown_as_typed():
    """In the unit of the text, and the bounds with theirs."""
    with pytest.raises(dl.DemlawsError, match=r"^width = 5cm: must be above 0 and at most 0\.01 m$"):
        number("5cm", "width", "m", 0.0, 0.01)
    with pytest.raises(dl.DemlawsError, match=r"^width = 0\.05 m: must be above 0 and at most 0\.01$"):
        number(0.05, "width", "m", 0.0, 0.01)
    with pytest.raises(dl.DemlawsError, match=r"^count = 0: must be above 0$"):
        number("0", "count")


LAW = dl.law("hertz", PAIR)
TABLE = dl.law("hertz", PAIR, max_force=10.0)
TYPED = {
    "radius = -4mm:": lambda: dl.Contact("-4mm", 32e9),
    r"radius = -4mm \(entry 1\):": lambda: dl.Contact(["8mm", "-4mm"], 32e9),
    "sigma = 50mm is": lambda: dl.Contact("4mm", 32e9, sigma="50mm"),
    "hardness = 6Pa is": lambda: dl.Contact("4mm", 32e9, hardness="6Pa"),
    "young = 60 Pa:": lambda: dl.Material("60", 0.2),
    "young = -60GPa:": lambda: dl.Material("-60GPa", 0.2),
    "radius1 = -5mm:": lambda: dl.Contact.between(dl.materials.glass, dl.materials.glass, radius1="-5mm", radius2="flat"),
    "overlap 5cm is": lambda: LAW.force(["1um", "5cm"]),
    "^overlap 5cm is": lambda: LAW.energy("5cm"),
    "^overlap 5cm is .* times": lambda: dl.driver.displacement_controlled(LAW, ["1um", "5cm", 0]),
    "force = 1e9kN is too large": lambda: LAW.overlap("1e9kN"),
    "^force = 1e9kN is too large": lambda: dl.driver.force_controlled(LAW, ["1kN", "1e9kN"]),
    "max_force = 1e9kN is too large": lambda: LAW.tabulate(max_force="1e9kN"),
    "force -3mN:": lambda: dl.driver.force_controlled(LAW, [1.0, "-3mN"]),
    "overlap 100um is beyond the table": lambda: dl.driver.displacement_controlled(TABLE, ["100um", 0]),
    "force 1kN is beyond the table": lambda: dl.driver.force_controlled(TABLE, ["1kN", 0]),
    "speed = 1e9mm/s: the contact": lambda: dl.driver.impact(LAW, "1g", "1e9mm/s"),
    "speed = 1e-99mm/s: the kinetic energy of mass = 1g": lambda: dl.driver.impact(LAW, "1g", "1e-99mm/s"),
    r"speed = 1e\+06 m/s: the contact": lambda: dl.driver.impact(LAW, 1e-3, 1e6),
    "load 1e9kN: overlap": lambda: dl.regime(PAIR, "1e9kN"),
}


@pytest.mark.parametrize("text", TYPED)
def test_an_error_shows_a_quantity_as_typed(text):
    with pytest.raises(dl.DemlawsError, match=text):
        TYPED[text]()


@pytest.mark.parametrize("n", ["", -1, [2]])
def test_a_state_has_a_whole_number_of_contacts(n):
    """An elastic law has no arrays, and took any."""
    with pytest.raises(dl.DemlawsError, match="whole number"):
        dl.law("hertz", PAIR).new_state(n)


class Quantity(np.ndarray):
    """An array with a unit, as of pint, unyt and astropy: numpy takes its numbers and drops the unit."""

    unit = "kN"


@pytest.mark.parametrize(
    "value", [np.array(0.05).view(Quantity), np.array([0.05]).view(Quantity), [np.array(0.05).view(Quantity)]]
)
def test_units_of_other_packages_are_refused(value):
    with pytest.raises(dl.DemlawsError, match=r"^force .* in N"):
        as_float(value, "force", "N", array=True)
    assert as_float(value, "force", "kN", array=True) == 0.05


def test_the_smallest_overlap_where_underflow_raises():
    with np.errstate(all="raise"):
        assert check_overlaps(np.array([0.0, 5e-324]), 4e-3) is None


@pytest.mark.parametrize(
    ("text", "word"), [("1e400", "large"), ("-2e999 mm", "large"), ("1e-400", "small"), ("3e-330mm", "small")]
)
def test_a_number_beyond_the_range_of_floats_is_refused(text, word):
    """A radius of "1e400" was infinite: a flat."""
    with pytest.raises(dl.DemlawsError, match=f"radius = {text}: the number is too {word}"):
        quantity(text, "radius", "m")


@pytest.mark.parametrize("text", ["0", "0e5", "0.0e-400", "inf", "1e300"])
def test_a_number_in_the_range_of_floats_is_read(text):
    assert quantity(text, "radius", "m") == float(text)
