"""Making laws: by name, for a contact, joined with an unloading rule."""

import os
import sys
from typing import Any

import numpy as np

from demlaws.contact import Contact
from demlaws.core.unloading import GIVEN
from demlaws.errors import DemlawsError
from demlaws.law import Law
from demlaws.laws.registry import find, registry
from demlaws.table import Table, tabulate, take  # noqa: F401  laws call it as Law._maker.tabulate


def law(name: str, contact: Contact, unloading: str | Law | None = None, **options: Any) -> Law:
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
    if not isinstance(contact, Contact):
        raise DemlawsError(f"contact must be a demlaws.Contact, got {contact!r:.60}")
    rule, curve = rule_and_curve(definition.default_unloading if unloading is None else unloading, definition)
    for field in definition.needs:
        if getattr(contact, field) is None:
            raise DemlawsError(f"law {name!r} needs the contact's {field}: give Contact(..., {field}=...)")
    result = Law(definition, contact, "elastic", options, definition.shape(contact, **options))
    return take(result, rule, curve)


def joined(law, unloading):
    """See `Law.joined`."""
    return take(law, *rule_and_curve(unloading, law.definition))


def rule_and_curve(unloading, definition=None):
    """(rule, unloading curve or None) of what a user gave as `unloading`; definition: the law that is to take it, if known."""
    if isinstance(unloading, os.PathLike) or (isinstance(unloading, str) and ("/" in unloading or "." in unloading)):
        unloading = Table.load(unloading)
    if isinstance(unloading, Law):
        if unloading.unloading != "elastic":
            raise DemlawsError(
                f"the unloading curve is elastic, this {unloading.name!r} has {unloading.unloading!r} unloading itself: "
                "give it with unloading='elastic' (law.joined('elastic'))"
            )
        return GIVEN if definition is None else definition.rule(GIVEN).name, unloading
    if isinstance(unloading, str) and unloading == GIVEN:
        raise DemlawsError(
            f"unloading {GIVEN!r} needs its curve: give a law or a table, unloading=dl.law(...) or dl.Table.load(...)"
        )
    if definition is not None:
        return definition.rule(unloading).name, None
    known = dict.fromkeys(rule for law_definition in registry().values() for rule in law_definition.offered())
    if not isinstance(unloading, str) or unloading not in known:
        raise DemlawsError(f"unknown unloading rule {unloading!r}: the rules are {', '.join(known)}")
    return unloading, None


def rebound(unloading, contact):
    """What `law` takes as `unloading`, for another contact: a law as the same law there, a table that collapses likewise."""
    rule, curve = rule_and_curve(unloading)
    if curve is None:
        return rule
    names = ("radius", "modulus", "roughness")
    if all(np.allclose(getattr(curve.contact, n), getattr(contact, n), rtol=1e-6, atol=0.0) for n in names):
        return curve
    return curve.lent_to(contact) if isinstance(curve, Table) else curve.bound_to(contact)


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


Law._maker = sys.modules[__name__]
