"""Making laws: by name, for a contact, joined with an unloading rule."""

import os
from typing import Any

import numpy as np

from demlaws.contact import Contact, as_contact
from demlaws.core.unloading import GIVEN, RULES
from demlaws.curves.closed import ClosedForm
from demlaws.errors import DemlawsError
from demlaws.law import Law, join, read_if_path
from demlaws.laws.registry import find, registry


def law(name: str, contact: Contact, unloading: str | os.PathLike | Law | None = None, **options: Any) -> Law:
    """Bind law `name` to `contact` and join it with a rule `unloading`: "elastic", "hertz", "thornton", or a curve.

    A law of the literature that unloads in a way of its own brings that as a rule of its own (`demlaws laws NAME`) and has it
    where no `unloading` is named; the others are elastic then.

    A curve is a law, a `Table` or the path of a saved table: the contact then unloads along that law's curve of first
    loading through its largest overlap (rule "table"). Its contact is this one, or one in a constant ratio to it.
    Raises DemlawsError for an unknown name, option or missing quantity, and where the pair is not passive.

    >>> pair = dl.Contact(radius=4e-3, modulus=32e9, roughness=2e-6, fractal_dimension=2.2)
    >>> law = dl.law("pohrt-popov", pair, unloading="hertz")
    >>> law.force(1e-6) < dl.law("hertz", pair).force(1e-6)
    True
    >>> dl.law("bahrami", pair.with_values(hardness=6e9), unloading="hertz")
    Traceback (most recent call last):
    demlaws.errors.NotPassive: law 'bahrami' cannot take 'hertz' unloading: ...
    """
    definition = find(name)
    as_contact(contact)
    for field in definition.needs:
        if getattr(contact, field) is None:
            raise DemlawsError(f"law {name!r} needs the contact's {field}: give Contact(..., {field}=...)")
    chosen = definition.default_unloading if unloading is None else unloading
    return join(contact, ClosedForm(definition, contact, options), chosen)


def rule_and_curve(unloading: Any) -> tuple[str, Law | None]:
    """(name of the rule, law to follow or None) of an unloading that a user named, before the law is known."""
    unloading = read_if_path(unloading)
    if isinstance(unloading, Law):
        return GIVEN, unloading
    if isinstance(unloading, str) and unloading in RULES and unloading != GIVEN:
        return unloading, None
    known = dict.fromkeys(rule for definition in registry().values() for rule in definition.offered())
    if not isinstance(unloading, str) or unloading not in known or unloading == GIVEN:
        why = (
            "needs its curve: give a law or a table" if unloading == GIVEN else f"is unknown: the rules are {', '.join(known)}"
        )
        raise DemlawsError(f"unloading rule {unloading!r:.60} {why}")
    return unloading, None


def rebound(unloading, contact):
    """What `law` takes as `unloading`, for another contact: a law as the same law there, a table that collapses likewise."""
    rule, curve = rule_and_curve(unloading)
    if curve is None:
        return rule
    names = ("radius", "modulus", "roughness")
    if all(np.allclose(getattr(curve.contact, n), getattr(contact, n), rtol=1e-6, atol=0.0) for n in names):
        return curve
    return curve.for_unloading(contact)


def unloading_of_case(name):
    """The rule of an engine's case where none is named: the law's own where it has one, else Hertz's."""
    own = find(name).default_unloading
    return "hertz" if own == "elastic" else own


def example_curve(name, contact, **options):
    """The unloading curve with which tests and measurements join law `name` to rule "table".

    The law itself on surfaces a quarter as rough (what first loading has flattened), with its definition's own changes.
    """
    options = {**find(name).example, **options, **find(name).example_curve}
    return law(name, contact.with_values(roughness=0.25 * np.asarray(contact.roughness)), "elastic", **options)


def example(name: str, contact: Contact, unloading: str | Law = "elastic", **options: Any) -> Law:
    """Law `name` as tests and measurements make it, joined with any rule that it is offered."""
    curve = example_curve(name, contact, **options) if unloading == GIVEN else unloading
    return law(name, contact, curve, **{**find(name).example, **options})
