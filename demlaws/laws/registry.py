"""The laws by name."""

import importlib

from demlaws.errors import DemlawsError
from demlaws.laws import MODULES
from demlaws.laws.definition import Definition


def registry() -> dict[str, Definition]:
    """Name → Definition of every law, in the order in which figures and tables show them."""
    definitions = [importlib.import_module(f"demlaws.laws.{module}").LAW for module in MODULES]
    return {definition.name: definition for definition in definitions}


def laws() -> list[str]:
    """Names of all laws.

    >>> dl.laws()[:3]
    ['hertz', 'rms', 'pohrt-popov']
    """
    return list(registry())


def find(name: str) -> Definition:
    """The law of this name, or an error that lists the names."""
    known = registry()
    if not isinstance(name, str) or name not in known:
        raise DemlawsError(f"unknown law {name!r}: the laws are {', '.join(known)}")
    return known[name]
