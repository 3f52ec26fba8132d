"""Errors and warnings of demlaws, and signals that end a process."""

import contextlib
import re
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Iterable, Iterator
from typing import Any

ADDRESS = ""
REPOSITORY = ""
"""Addresses of the site and of the repository, https://…; `make release ADDRESS=… REPOSITORY=…` fills them, here only."""


def page(name: str) -> str:
    """Where a page of the documentation is, as "shear": its address, or, without one, its file in the repository."""
    return f"{ADDRESS}/{name}.html" if ADDRESS else f"docs/{name}.md"


LONGEST_WORD, LONGEST_TEXT = 300, 10_000
"""Characters of a word, and of a text, that a message repeats in full."""


def shortened(text: object) -> str:
    """A text whose very long words are cut."""
    return re.sub(rf"\S{{{LONGEST_WORD},}}", lambda word: f"{word[0][:60]}…", str(text)[:LONGEST_TEXT])


class DemlawsError(ValueError):
    """Bad input: the message names the value, its unit and the remedy.

    >>> dl.Contact(radius=-1e-3, modulus=32e9)
    Traceback (most recent call last):
    demlaws.errors.DemlawsError: radius = -0.001 m: the radius must be positive (two flats have no Hertz contact)
    """

    def __init__(self, text: object = "") -> None:
        super().__init__(shortened(text))


class NotPassive(DemlawsError):
    """A law and an unloading rule that would return more work than was done on loading."""


class MissingQuantity(DemlawsError):
    """A law, or a criterion, uses a quantity of the contact that is not given; for sigma 0 is a value, too: smooth.

    >>> dl.law("rms", dl.Contact(radius=4e-3, modulus=32e9))
    Traceback (most recent call last):
    demlaws.errors.MissingQuantity: law 'rms' needs the contact's sigma, which is not given: give ...
    """

    @classmethod
    def of(cls, user: str, quantity: str) -> "MissingQuantity":
        """The error of a law or criterion (`user`, text) for a field of the contact."""
        remedy = f"{quantity} (--{quantity.replace('_', '-')})"
        if quantity == "sigma":
            remedy = "sigma of the pair (--sigma), or the roughness of each surface (--roughness), 0 for smooth surfaces"
        return cls(f"{user} needs the contact's {quantity}, which is not given: give {remedy}")


class EngineStopped(DemlawsError, RuntimeError):
    """An engine stopped with an error while it ran an input; a RuntimeError, too, as YADE's own."""


class NeedsClasses(DemlawsError):
    """A curve that depends on the radius cannot serve a range of radii; define grains of a few sizes."""


class ValidityWarning(UserWarning):
    """A law is used outside the validity range of its source.

    >>> import warnings
    >>> with warnings.catch_warnings():
    ...     warnings.simplefilter("error", dl.ValidityWarning)
    ...     dl.law("hertz", dl.Contact(radius=4e-3, modulus=32e9, hardness=6e9)).force(2e-4)  # the bulk yields
    Traceback (most recent call last):
    demlaws.errors.ValidityWarning: ...
    """


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """Within this context no `ValidityWarning` is issued."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ValidityWarning)
        yield


class LargeOverlap(ValidityWarning):
    """An overlap beyond a tenth of the effective radius."""


class MapWarning(ValidityWarning):
    """A height map that is hardly the measured surface: spikes, fillers, a wrong unit."""


# of YADE, here since a process without YADE may report them


class BridgeWarning(UserWarning):
    """demlaws has not been tested with this version of YADE."""


class TimeStepWarning(UserWarning):
    """A time stepper of the engine list had no bound that is stable for the law."""


class ShapeWarning(UserWarning):
    """R of a level set or polyhedron is the distance from the body's centre: no `radius` was chosen."""


def most_similar(word: object, known: Iterable[str], likeness: float = 0.6) -> str | None:
    """The known word that is most similar to `word`, or None; likeness: least share of letters in common."""
    import difflib

    return next(iter(difflib.get_close_matches(str(word)[:100], list(known), 1, likeness)), None)


def did_you_mean(word: object, known: Iterable[str], likeness: float = 0.6) -> str:
    """Text after an unknown word: ", did you mean 'X'?" of the most similar of the known words, or a full stop."""
    similar = most_similar(word, known, likeness)
    return f", did you mean {similar!r}?" if similar else "."


def counted(count: int, noun: str) -> str:
    """1 contact, 2 contacts."""
    return f"{count} {noun}" + "s" * (count != 1)


def warn(text: str, category: type[Warning] = ValidityWarning) -> None:
    """Issue a warning that shows the line of the caller's file, the first one outside of this package."""
    frame, depth = sys._getframe(1), 2
    while frame.f_back is not None and frame.f_globals.get("__name__", "").partition(".")[0] == "demlaws":
        frame, depth = frame.f_back, depth + 1
    warnings.warn(category(shortened(text)), stacklevel=depth)


@contextlib.contextmanager
def handling_signals(handler: Callable[[int, Any], None], *numbers: int) -> Iterator[None]:
    """Signals that would end or interrupt this process call the handler.

    One that is ignored, or has a handler of somebody else, stays as it is, and outside the main thread all do.
    """
    usual = signal.SIG_DFL, signal.default_int_handler
    mine = numbers if threading.current_thread() is threading.main_thread() else ()
    before = {number: signal.signal(number, handler) for number in mine if signal.getsignal(number) in usual}
    try:
        yield
    finally:
        for number, one in before.items():
            signal.signal(number, one)
