"""The project's tests of a law, for any law: `check_law` evaluates the assertions of the test suite and reports failures."""

import math
from typing import Any, NamedTuple

import numpy as np

from demlaws.contact import GRANITE, Contact
from demlaws.curves.soundness import Check, curve_checks, refuse_unless_collapses
from demlaws.errors import DemlawsError, NotPassive, quiet
from demlaws.laws.registry import find
from demlaws.make import example

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
    name: str, contact: Contact | None = None, rules: tuple | None = None, *, paths: int = 500, **options: Any
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
    Round trip, stiffness against the derivative, energy = ∫P dδ, finite and increasing, no work returned on random paths, and
    the certificate of its table.

    Examples
    --------
    >>> dl.check_law("hertz", rules=("elastic",), paths=100).passed
    True
    """
    name = find(name).name
    contact = GRANITE_PAIR if contact is None else contact
    if not isinstance(contact, Contact) or contact.size is not None:
        raise DemlawsError("check_law takes one contact, not an array of contacts")
    with quiet(), np.errstate(all="ignore"):
        law = example(name, contact, "elastic", **options)
        checks = list(curve_checks(law.params, float(contact.radius), law.definition.solved))
        if law.collapses and not law.definition.solved:  # a solved law's curve comes with a number of its own
            checks.append(_trial("one curve serves all contacts", refuse_unless_collapses, law, contact)[0])
        for rule in rules or law.definition.offered():
            checks.append(_rule_check(law, contact, rule, paths, options))
        made, table = _trial("table within 1e-5", law.tabulate, _RTOL)
        if table is not None:
            serves = "one table serves all contacts" if table.collapses else "a table serves its own contact only"
            what = f"table of {table.nodes.u.size} rows: largest error, relative"
            made = Check(what, max(table.force_error, table.stiffness_error), _RTOL, note=serves)
        return LawCheck(name, (*checks, made))


def _trial(what, function, *arguments):
    """A `Check` that fails where the function raises a DemlawsError, and what the function returns."""
    try:
        return Check(what, 0, 0), function(*arguments)
    except DemlawsError as error:
        return Check(what, 1, 0, note=str(error)), None


def _rule_check(law, contact, rule, paths, options):
    """Random paths of one contact on which the dissipated energy falls, so that work is returned."""
    try:
        trial = example(law.name, contact, rule, **options)
    except DemlawsError as error:
        # a rule that would return work is refused for every law: that is no fault of this one
        fault = not isinstance(error, NotPassive) and rule in law.definition.unloading
        return Check(f"{rule} unloading: refused", int(fault), 0, note=str(error))
    random = np.random.default_rng(2)
    highest = (0.049 if law.definition.solved else 0.1) * contact.radius
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
