"""Warnings: once per text and line, as Python promises, whatever code between them does to its filters."""

import warnings

import pytest

import demlaws as dl
from demlaws.errors import quiet, warn


def shown(action, times=3):
    """How many warnings of one line are shown, with filters that change between them."""
    with warnings.catch_warnings(record=True) as seen:
        warnings.resetwarnings()
        warnings.simplefilter(action, dl.ValidityWarning)
        for _ in range(times):
            with quiet():
                warn("never shown")
            warn(f"by {action}")
    return [str(one.message) for one in seen]


def test_a_warning_is_shown_once_per_line():
    """`dl.law("hertz", …).plot()` of the quickstart printed one text twice: matplotlib had changed the filters between."""
    assert shown("default") == ["by default"] and shown("default") == []
    assert shown("always") == ["by always"] * 3 and shown("ignore") == []
    with pytest.raises(dl.ValidityWarning, match="by error"):
        shown("error")


def test_filters_of_texts_and_modules_are_pythons():
    with warnings.catch_warnings(record=True) as seen:
        warnings.resetwarnings()
        warnings.filterwarnings("always", "each time", dl.ValidityWarning)
        warnings.filterwarnings("always", "of this module", module=__name__)
        for text in ("each time", "of this module", "of another text"):
            for _ in range(2):
                warn(text)
    assert [str(one.message) for one in seen] == ["each time"] * 2 + ["of this module"] * 2 + ["of another text"]
