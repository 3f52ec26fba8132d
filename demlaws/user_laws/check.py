"""The project's tests of a law, for any law: `check_law` evaluates the assertions of the test suite and reports failures."""

import math
from typing import Any, NamedTuple

import numpy as np

from demlaws.contact import GRANITE, Contact
from demlaws.curves.soundness import EPS, Check, curve_checks, largest_of, refuse_unless_collapses
from demlaws.errors import DemlawsError, NotPassive, quiet
from demlaws.law import Law
from demlaws.laws.registry import find
from demlaws.make import example

GRANITE_PAIR = Contact(4.35e-3, 0.5 * GRANITE.plane_modulus, 2.40e-6, 2.22, GRANITE.hardness)
"""The granite pair SS(18-18), on which a law is checked by default."""


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


# --- measurements; law: elastic, of one contact


def overlaps(law: Law, points: int = 60) -> np.ndarray:
    """Overlaps [m] from 1e-8 σ (1e-9 R of a smooth contact) to a tenth of the radius, less where the law's kinks lie."""
    contact = law.contact
    low = 1e-9 * contact.radius if contact.is_smooth else 1e-8 * contact.sigma
    values = np.geomspace(low, 0.1 * contact.radius, points)
    for kink in law.kinks():
        values = values[np.abs(values / kink - 1.0) > 1e-6]
    return values


def alone(law: Law) -> Check:
    """Arrays against one number at a time, in ε."""
    at = overlaps(law, 40)
    one = np.array([[law.force(float(d)), law.stiffness(float(d))] for d in at]).T
    together = np.array([law.force(at), law.stiffness(at)])
    return largest_of("arrays against single numbers (ε)", np.max(np.abs(together / one - 1.0), axis=0) / EPS, at, 8.0)


def returned_work(law: Law, paths: int = 2000) -> tuple[int, float]:
    """Random paths of one contact, any rule: how many return work, and the most over the largest energy of a path."""
    random = np.random.default_rng(2)
    highest = (0.049 if law.definition.solved else 0.1) * law.contact.radius
    count, worst = 0, 0.0
    for _ in range(paths):
        at, excursions = _random_path(random, 1e-25 * law.contact.radius, highest)
        work = law.follow(at).work
        net_work = [work[-1], *(work[end] - work[begin] for begin, end in excursions)]
        least = float(np.min(net_work)) / float(np.max(work))
        count += not least >= -1e-11
        worst = min(worst, least)
    return count, -worst


def _random_path(random, lowest, highest):
    """Overlaps [m] that end at 0 after 12 turns at any scale; (begin, end) of excursions that come back to where they began."""
    at, excursions, maximum = [], [], 0.0
    while len(at) < 12:
        if maximum == 0.0 or random.random() < 0.5:
            overlap = math.exp(random.uniform(math.log(lowest), math.log(highest)))
        else:  # a reversal about the maximum
            overlap = min(maximum * (1.0 + random.uniform(-1.0, 1.0) * 10.0 ** random.uniform(-15.0, 0.0)), highest)
        maximum = max(maximum, overlap)
        if at and random.random() < 0.4:
            excursions.append((len(at) - 1, len(at) + 1))
            at += [overlap, at[-1]]
        else:
            at.append(overlap)
    return np.array([*at, 0.0]), excursions


# --- all of them


def check_law(
    name: str, contact: Contact | None = None, rules: tuple | None = None, *, paths: int = 2000, **options: Any
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
    Round trip, stiffness against the derivative, energy = ∫P dδ, finite and increasing, arrays equal to numbers, no work
    returned on random paths, and the certificate of its table.

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
        return LawCheck(name, (*_curve_checks(law), *_rule_checks(law, contact, rules, paths, options), *_table_checks(law)))


def _curve_checks(law):
    checks = [
        *curve_checks(law.params, law.contact.radius, law.definition.solved),
        alone(law),
    ]
    if law.collapses and not law.definition.solved:  # a solved law's curve comes with a number of its own
        try:
            refuse_unless_collapses(law, law.contact)
            checks.append(Check("one curve serves all contacts", 0, 0))
        except DemlawsError as error:
            checks.append(Check("one curve serves all contacts", 1, 0, note=str(error)))
    return checks


def _rule_checks(law, contact, rules, paths, options):
    checks = []
    for rule in rules or law.definition.offered():
        try:
            trial = example(law.name, contact, rule, **options)
        except DemlawsError as error:
            # a rule that would return work is refused for every law: that is no fault of this one
            if isinstance(error, NotPassive) or rule not in law.definition.unloading:  # it does not say that it takes this rule
                checks.append(Check(f"{rule} unloading: refused", 0, 0, note=str(error).split(": ")[-1][:70]))
            else:
                checks.append(Check(f"{rule} unloading: refused, though its definition names it", 1, 0, note=str(error)))
            continue
        count, most = returned_work(trial, paths)
        note = f"most {most:.1e} of the energy held" if count else ""
        checks.append(Check(f"{rule} unloading: paths of {paths} that return work", count, 0, note=note))
        checks.append(batch_against_path(trial, rule))
    return checks


def batch_against_path(law: Law, rule: str) -> Check:
    """Force and stiffness of a batch against the same contact followed alone."""
    random = np.random.default_rng(3)
    scale = 1e-3 * law.contact.radius
    steps = random.uniform(-0.1, 1.0, 60) * scale
    path = law.follow(steps)
    state = law.new_state(3) if law.state_size else None
    errors = []
    for n, overlap in enumerate(steps):
        response = law.evaluate(np.full(3, overlap), state)
        pairs = zip(response, (path.force[n], path.stiffness[n]), strict=True)
        errors.append(max(float(np.max(np.abs(a - b)) / b) if b > 0.0 else float(np.max(np.abs(a))) for a, b in pairs))
    return largest_of(f"{rule} unloading: batch against path, relative", np.array(errors), steps, 1e-13)


def _table_checks(law):
    rtol = 1e-5
    try:
        table = law.tabulate(rtol)
    except DemlawsError as error:
        return [Check("table within 1e-5", 1, 0, note=str(error))]
    serves = "one table serves all contacts" if table.collapses else "a table serves its own contact only"
    return [
        Check(f"table of {table.nodes.u.size} rows: force, relative", table.force_error, rtol),
        Check(f"table of {table.nodes.u.size} rows: stiffness, relative", table.stiffness_error, rtol, note=serves),
    ]
