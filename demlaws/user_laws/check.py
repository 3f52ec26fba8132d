"""The project's tests of a law, for any law: `check_law` evaluates the assertions of the test suite and reports failures."""

import math
from typing import Any, NamedTuple

import numpy as np

from demlaws.contact import GRANITE, Contact, contact_at
from demlaws.curves.soundness import Check, curve_checks, refuse_unless_collapses
from demlaws.errors import DemlawsError, NotPassive, quiet
from demlaws.laws.registry import find
from demlaws.make import example_law

GRANITE_PAIR = Contact(4.35e-3, 0.5 * GRANITE.plane_modulus, 2.40e-6, 2.22, GRANITE.hardness)
"""The granite pair SS(18-18), on which a law is checked by default."""
_RTOL = 1e-5
_RETURNED = 1e-10
"""Over the largest energy held: what rounding may return."""


class LawCheck(NamedTuple):
    """Result of `check_law`; `text` is the table."""

    law: str
    checks: tuple

    @property
    def passed(self) -> bool:
        """Whether every check passed."""
        return all(check.passed for check in self.checks)

    @property
    def failures(self) -> list:
        """The checks that failed."""
        return [check for check in self.checks if not check.passed]

    def __str__(self) -> str:
        lines = [f"{self.law:52}{'measured':>11}{'allowed':>10}  {'at overlap (m)':>14}"]
        for check in self.checks:
            where = "" if math.isnan(check.where) else f"{check.where:.3g}"
            mark = "" if check.passed else "FAILS"
            line = f"  {check.what:50}{check.value:11.2g}{check.allowed:10.2g}  {where:>14}  {mark} {check.note}"
            lines.append(line.rstrip())
        return "\n".join([*lines, f"{self.law}: {'all checks passed' if self.passed else f'{len(self.failures)} failed'}"])


def check_law(
    name: str,
    contact: Contact | None = None,
    rules: tuple | None = None,
    *,
    paths: int = 500,
    yade: bool = True,
    **options: Any,
) -> LawCheck:
    """Run the project's tests of laws on one law.

    Parameters
    ----------
    name : str
        Name of the law.
    contact : Contact, optional
        One contact; default: the granite pair SS(18-18).
    rules : tuple of str, optional
        Unloading rules; default: all that the law accepts.
    paths : int
        Random paths per rule.
    yade : bool
        Compare with the forces that YADE applies, if YADE is installed (some seconds).
    **options
        Options of the law, in addition to those of its example.

    Returns
    -------
    LawCheck
        Its text is a table, its `passed` the result.

    Raises
    ------
    DemlawsError
        For an inadmissible law (NaN, decreasing, wrong derivative), with the overlap and the value.

    Notes
    -----
    Round trip, stiffness against the derivative, energy = ∫P dδ, finite and increasing, no work returned on random paths, the
    certificate of its table; contacts of other sizes, as an array in any order and one by one; in YADE three contacts along a
    path of loading, unloading, reloading and separation.

    Examples
    --------
    >>> dl.check_law("hertz", rules=("elastic",), paths=100, yade=False).passed
    True
    """
    name = find(name).name
    contact = GRANITE_PAIR if contact is None else contact
    if not isinstance(contact, Contact) or contact.size is not None:
        raise DemlawsError("check_law takes one contact, not an array of contacts")
    with quiet(), np.errstate(all="ignore"):
        law = example_law(name, contact, "elastic", **options)
        checks = list(curve_checks(law.shape, law.params, float(contact.radius), law.definition.solved))
        if law.collapses and not law.definition.solved:  # a solved law's curve comes with a number of its own
            checks.append(_trial("one curve serves all contacts", refuse_unless_collapses, law, contact)[0])
        checks += [_rule_check(law, contact, rule, paths, options) for rule in rules or law.definition.offered()]
        made, table = _trial("table within 1e-5", law.tabulate, _RTOL)
        if table is not None:
            serves = "one table serves all contacts" if table.collapses else "a table serves its own contact only"
            what = f"table of {table.nodes.u.size} rows: largest error, relative"
            made = Check(what, max(table.force_error, table.stiffness_error), _RTOL, note=serves)
        checks += [made, _array_check(law, contact, options)]
        return LawCheck(name, (*checks, *([_yade_check(law, contact, options)] if yade else [])))


_SIZES = np.array([1.0, 0.05, 3.0])
"""Radii of three contacts over that of the one that is checked; the moduli go the other way."""
_PATH = 4e-3 * np.concatenate([np.linspace(a, b, 8)[1:] for a, b in ((0, 0.5), (0.5, 0.2), (0.2, 1), (1, -0.1), (-0.1, 0.3))])


def _three(contact):
    """Three contacts of different sizes and moduli, the first one as it is."""
    with_sigma = {} if contact.sigma is None else {"sigma": contact.sigma * _SIZES**0.5}
    return contact.with_values(radius=contact.radius * _SIZES, modulus=contact.modulus * _SIZES**-0.2, **with_sigma)


def _share_of_path(law):
    """1, or less for a law that ends: the paths of three contacts then stay below its largest force."""
    return min(1.0, 0.1 * law.largest_overlap / (_PATH.max() * float(law.contact.radius)))


def _array_check(law, contact, options):
    """Largest relative difference of an array of contacts, in two orders, from each contact by itself."""
    what = "array of contacts against each by itself, relative"
    three, order = _three(contact), np.array([2, 0, 1])
    overlap, errors = _share_of_path(law) * 1e-3 * np.asarray(three.radius), []
    try:
        for places in (np.arange(3), order):
            many = example_law(law.name, contact_at(three, places), "elastic", **options)
            for n, place in enumerate(places):
                one = example_law(law.name, contact_at(three, place), "elastic", **options)
                for of_many, of_one in ((many.force, one.force), (many.stiffness, one.stiffness)):
                    errors.append(abs(of_many(overlap[places])[n] / of_one(overlap[place]) - 1.0))
    except DemlawsError as error:
        return Check(what, int(not law.definition.needs_map), 0, note=f"refused: {error}")
    return Check(what, float(np.max(errors)), 2e-5 if law.definition.solved else 1e-13)


def _yade_check(law, contact, options):
    """Largest difference, over the largest force, of YADE's forces on three contacts from those of the law in Python."""
    from demlaws.laws import registry
    from demlaws.yade.forces import ask
    from demlaws.yade.run import executable

    what, three = "YADE against Python, of the largest force", _three(contact)
    home, definition = registry.home_of(law.name), law.definition
    loaded = home in registry._loaded
    try:
        executable()
    except DemlawsError as error:
        return Check(what, 0, 0, note=f"not compared: {error}")
    if definition.needs_map or (registry.is_user_defined(definition) and not loaded):
        why = "the law is that of one map" if definition.needs_map else "only laws of a file can be: dl.load_laws(FILE)"
        return Check(what, 0, 0, note=f"not compared: {why}")
    options = {**definition.drawing.example, **options}
    rule = definition.default_rule(**options)
    paths, asked, expected = [], [], []
    try:
        for n in range(3):
            one = contact_at(three, n)
            paths.append((_share_of_path(law) * _PATH * one.radius).tolist())
            surface = {"roughness": float(one.sigma_or_zero) / math.sqrt(2.0), "hardness": one.hardness}
            asked.append((one.radius, one.modulus, surface | {"fractal_dimension": one.fractal_dimension}))
            expected.append(example_law(law.name, one, rule, **options).follow(paths[n]).force)
        found = ask(law.name, rule, options, [home] if loaded else [], asked, paths)
    except DemlawsError as error:
        return Check(what, 1, 0, note=str(error))
    errors = [np.max(np.abs(np.subtract(f, e))) / np.max(e) for f, e in zip(found, expected, strict=True)]
    # YADE's overlap is 2r less a distance, both rounded
    return Check(what, float(np.max(errors)), 2e-11)


def _trial(what, function, *arguments):
    """A `Check` that fails where the function raises a DemlawsError, and what the function returns."""
    try:
        return Check(what, 0, 0), function(*arguments)
    except DemlawsError as error:
        return Check(what, 1, 0, note=str(error)), None


def _rule_check(law, contact, rule, paths, options):
    """Random paths of one contact on which the dissipated energy falls, so that work is returned."""
    try:
        trial = example_law(law.name, contact, rule, **options)
    except DemlawsError as error:
        # a rule that would return work is refused for every law: that is no fault of this one
        fault = not isinstance(error, NotPassive) and rule in law.definition.unloading
        return Check(f"{rule} unloading: refused", int(fault), 0, note=str(error))
    random = np.random.default_rng(2)
    highest = min((0.049 if law.definition.solved else 0.1) * contact.radius, 0.999 * law.largest_overlap)
    lowest = 1e-25 * contact.radius
    count, most = 0, 0.0
    for _ in range(paths):
        path = trial.follow(_random_path(random, lowest, highest))
        returned = -float(np.min(np.diff(path.dissipated, prepend=0.0)) / np.max(path.work))
        count += not returned <= _RETURNED
        most = max(most, returned)
    note = f"most {most:.1e} of the energy held" if count else ""
    return Check(f"{rule} unloading: paths of {paths} that return work", count, 0, note=note)


def _random_path(random, lowest, highest):
    """Overlaps [m] that end at 0 after 16 turns at any scale, half of them about the largest before."""
    overlap = np.exp(random.uniform(np.log(lowest), np.log(highest), 17))
    for n in np.flatnonzero(random.random(16) < 0.5) + 1:
        near = 1.0 + random.uniform(-1.0, 1.0) * 10.0 ** random.uniform(-15.0, 0.0)
        overlap[n] = min(overlap[:n].max() * near, highest)
    overlap[-1] = 0.0
    return overlap
