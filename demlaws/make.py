"""Making laws: by name, for a contact, joined with an unloading rule."""

import os
from typing import Any

import numpy as np

from demlaws.contact import Contact, as_contact
from demlaws.core.unloading import GIVEN, RULES
from demlaws.curves.closed import FormulaCurve
from demlaws.errors import DemlawsError, did_you_mean
from demlaws.law import Law, join, join_up_to, read_unloading
from demlaws.laws.registry import find, registry


def law(
    name: str,
    contact: Contact,
    unloading: str | os.PathLike | Law | None = None,
    *,
    max_force: float | str | None = None,
    **options: Any,
) -> Law:
    """Bind a law to a contact and join it with an unloading rule.

    Parameters
    ----------
    name : str
        Name of the law; `demlaws.laws()` lists them.
    contact : Contact
        One contact, or an array of contacts.
    unloading : str, Law or path, optional
        Unloading rule: "elastic", "hertz", "thornton", a rule of this law (`demlaws laws NAME`), or a curve: a law, a
        `Table` or the path of a saved table, along which the contact unloads through its largest overlap. The contact of
        that curve is this one, or one in a constant ratio to it. Default: that of the law, "hertz" for rough contacts, its
        own rule for a law that has one, else "elastic".
    max_force : float, optional
        Largest force [N] of the contacts. The law is then a `Table` within 1e-5 that ends with the row there, up to 12 % above
        (in the engines, too), and only up to its end must the pair return no work. Of a law with an option of this name, that
        option.
    **options : float or str
        Options of the law, for instance ``yield_pressure=1.66e9``; `demlaws laws NAME` lists them.

    Returns
    -------
    Law
        The bound law.

    Raises
    ------
    DemlawsError
        For an unknown name or option, a missing quantity, or a pair of law and rule that would create energy
        (`NotPassive`).

    Examples
    --------
    >>> pair = dl.Contact(radius=4e-3, modulus=32e9, sigma=2e-6, fractal_dimension=2.2)
    >>> law = dl.law("pohrt-popov", pair, unloading="hertz")
    >>> law.force(1e-6) < dl.law("hertz", pair).force(1e-6)
    True
    >>> dl.law("bahrami", pair.with_values(hardness=6e9), unloading="hertz")
    Traceback (most recent call last):
    demlaws.errors.NotPassive: law 'bahrami' cannot take 'hertz' unloading: ...
    """
    definition = find(name)
    as_contact(contact)
    if max_force is not None and "max_force" in definition.options:
        options, max_force = options | {"max_force": max_force}, None
    curve = FormulaCurve(definition, contact, options)
    unloading = definition.default_rule(**curve.options) if unloading is None else unloading
    if max_force is None:
        return join(contact, curve, unloading)
    return join_up_to(contact, curve, unloading, max_force)


def check_unloading(unloading: Any) -> "str | Law":
    """A rule that some law takes, or the law to follow, of an unloading that a user gives before the law is known."""
    unloading = read_unloading(unloading)
    if isinstance(unloading, Law) or (isinstance(unloading, str) and unloading in RULES):
        return unloading
    rules = dict.fromkeys(rule for definition in registry().values() for rule in definition.offered() if rule != GIVEN)
    if not isinstance(unloading, str) or unloading not in rules:
        why = f"{did_you_mean(unloading, rules)} The rules are {', '.join(rules)}"
        raise DemlawsError(f"unloading rule {unloading!r:.60} is unknown{why}")
    return unloading


def unloading_for(unloading, contact):
    """Unloading for another contact: a rule as it is, a law as the same law there, a table that collapses likewise."""
    if not isinstance(unloading, Law):
        return unloading
    if all(
        np.allclose(*(getattr(c, n) for c in (unloading.contact, contact)), rtol=1e-6, atol=0.0)
        for n in ("radius", "modulus", "sigma_or_zero")
    ):
        return unloading
    return unloading.bound_to(contact, surface_matters=False)


def example_curve(name, contact, **options):
    """The unloading curve with which tests and measurements join law `name` to rule "table".

    The law itself on surfaces a quarter as rough (what first loading has flattened), with its definition's own changes.
    """
    options = {**find(name).drawing.example, **options, **find(name).drawing.example_curve}
    return law(name, contact.with_values(sigma=0.25 * np.asarray(contact.sigma_or_zero)), "elastic", **options)


def example_law(name: str, contact: Contact, unloading: str | Law = "elastic", **options: Any) -> Law:
    """Law `name` as tests and measurements make it, joined with any rule that it is offered."""
    curve = example_curve(name, contact, **options) if unloading == GIVEN else unloading
    return law(name, contact, curve, **{**find(name).drawing.example, **options})
