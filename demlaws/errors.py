"""Errors and warnings that a user of demlaws meets."""

import functools
import inspect
import sys
import warnings
from collections.abc import Iterable


class DemlawsError(ValueError):
    """Bad input: the message names the value, its unit and the remedy.

    >>> dl.Contact(radius=-1e-3, modulus=32e9)
    Traceback (most recent call last):
    demlaws.errors.DemlawsError: radius = -0.001 m: the radius must be positive (two flats have no Hertz contact)
    """


class NotPassive(DemlawsError):
    """A law and an unloading rule that together would return more work than loading took."""


class EngineStopped(DemlawsError):
    """An engine has read an input and ended with an error of its own."""


class NeedsClasses(DemlawsError):
    """A curve that depends on the radius, asked for a range of radii: it needs grains of a few sizes."""


class ValidityWarning(UserWarning):
    """A law is used outside the range in which its source supports it.

    >>> import warnings
    >>> law = dl.law("hertz", dl.Contact(radius=4e-3, modulus=32e9, hardness=6e9))
    >>> with warnings.catch_warnings(record=True) as said:
    ...     warnings.simplefilter("always")
    ...     force = law.force(1e-3)  # m: the bulk would have yielded
    >>> any(one.category is dl.ValidityWarning for one in said)
    True
    """


class LargeOverlap(ValidityWarning):
    """An overlap beyond a tenth of the effective radius."""


def did_you_mean(word: object, known: Iterable[str]) -> str:
    """Text after an unknown word: ", did you mean 'X'?" of the most similar of the known words, or a full stop."""
    import difflib

    similar = difflib.get_close_matches(str(word), list(known), 1)
    return f", did you mean {similar[0]!r}?" if similar else "."


def refuse_unknown_keywords(cls: type) -> None:
    """Let a dataclass raise a DemlawsError, with the most similar name, where a keyword is not one of its fields."""
    init = cls.__init__  # type: ignore[misc]

    @functools.wraps(init)
    def checked(self, *values, **named):
        known = list(inspect.signature(init).parameters)[1:]
        for name in named:
            if name not in known:
                raise DemlawsError(
                    f"{cls.__name__} has no {name!r}{did_you_mean(name, known)} Its quantities are {', '.join(known)}"
                )
        init(self, *values, **named)

    cls.__init__ = checked  # type: ignore[misc]


def warn(text: str, category: type[Warning] = ValidityWarning) -> None:
    """Issue a warning that shows the line of the caller's file, the first one outside of this package."""
    frame, depth = sys._getframe(1), 2
    while frame.f_back is not None and frame.f_globals.get("__name__", "").partition(".")[0] == "demlaws":
        frame, depth = frame.f_back, depth + 1
    warnings.warn(text, category, stacklevel=depth)
