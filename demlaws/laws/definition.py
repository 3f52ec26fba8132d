"""What a law declares besides its compiled kernels."""

from collections.abc import Callable
from typing import NamedTuple


class Limit(NamedTuple):
    """A range of force [N] outside which a law is not supported by its source, and why."""

    minimum_force: float
    maximum_force: float
    reason: str


def bulk_yield(contact, **options):
    """Where the contact's hardness is known: the load at which p(0), lowered by roughness, reaches 0.6 H_m (`regime`)."""
    if contact.hardness is None:
        return []
    from demlaws.regime import lowest_transition_load  # it checks its input with this module

    reason = "the central pressure passes 0.6 H_m, so that the bulk yields; this law keeps it elastic (see rough-plastic)"
    return [Limit(0.0, lowest_transition_load(contact), reason)]


def no_kinks(params, **options):
    return []


def never(**options):
    return False


def always(**options):
    return True


class Definition(NamedTuple):
    """A law: `prepare(contact, **options)` checks input and returns the Shape that its kernels are bound to."""

    name: str
    prepare: Callable
    equation: str
    source: str
    description: str
    limits: Callable = bulk_yield  # contact, **options → [Limit]
    kinks: Callable = no_kinks  # params, **options → overlaps [m] where dK/dδ or K jumps: a table puts nodes there
    seated: Callable = never  # **options → whether the force at overlap 0+ is a seating load, not 0
    bulk: Callable | None = None  # of a law whose bulk yields: params → δ_y [m], a²/R there [m], d(a²/R)/dP after it [m/N]
    length: str = "roughness"  # the contact's length that makes the law's curve dimensionless: "roughness" or "radius"
    collapses: bool = True  # one dimensionless curve serves all radii, moduli and roughnesses
    implicit: bool = False  # force is the root of an equation, not a closed form
    solved: bool = False  # the curve comes from a solver and is a table from the start
    needs_map: bool = False  # made from a height map, not from a roughness
    needs: tuple = ()  # names of Contact fields that must be given
    example: dict = {}  # noqa: RUF012  options with which tests and figures make the law, where it has no default
    example_curve: dict = {}  # noqa: RUF012  what of these changes where the law is an example of an unloading curve
