"""Numbers as text, and messages about them."""

import array
import time

import numpy as np
import pytest

import demlaws as dl
from demlaws.errors import LONGEST_TEXT
from demlaws.units import number, quantity

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


@pytest.mark.parametrize("n", ["", -1, [2]])
def test_a_state_has_a_whole_number_of_contacts(n):
    """An elastic law has no arrays, and took any."""
    with pytest.raises(dl.DemlawsError, match="whole number"):
        dl.law("hertz", PAIR).new_state(n)
