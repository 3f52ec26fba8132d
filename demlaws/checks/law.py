"""The project's own tests of a law, for any law: `check_law` measures what the suite asserts and says what fails.

tests/test_law.py calls these measurements for every law of the package.
"""

import math
import warnings
from typing import Any, NamedTuple

import numpy as np

from demlaws.checks.paths import finite_loop, path_loop
from demlaws.contact import Contact
from demlaws.errors import DemlawsError, NotPassive, ValidityWarning
from demlaws.law import Law
from demlaws.laws.registry import find
from demlaws.make import example
from demlaws.materials import GRANITE
from demlaws.soundness import fault_of_slope, refuse_unless_collapses

EPS = float(np.finfo(float).eps)
GRANITE_PAIR = Contact(4.35e-3, 0.5 * GRANITE.plane_modulus, 2.40e-6, 2.22, GRANITE.hardness)
"""The granite pair SS(18-18), on which a law is checked by default."""


class Check(NamedTuple):
    """One line of the table."""

    what: str
    value: float  # measured value; the check passes at 0 or below `allowed`
    allowed: float
    where: float = math.nan  # overlap [m] of the worst
    note: str = ""

    @property
    def passed(self) -> bool:
        """Whether the value is within what is allowed."""
        return self.value <= self.allowed


class LawCheck(NamedTuple):
    """What `check_law` found; text is the table."""

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


# --- measurements, each (worst, overlap [m] of it); law: elastic, of one contact


def overlaps(law: Law, points: int = 60) -> np.ndarray:
    """Overlaps [m] from 1e-8 σ (1e-9 R of a smooth contact) to a tenth of the radius, less where the law's kinks lie."""
    contact = law.contact
    low = 1e-9 * contact.radius if contact.is_smooth else 1e-8 * contact.roughness
    values = np.geomspace(low, 0.1 * contact.radius, points)
    for kink in law.kinks():
        values = values[np.abs(values / kink - 1.0) > 1e-6]
    return values


def _worst(values, at):
    values = np.where(np.isfinite(values), values, np.inf)
    k = int(np.argmax(values))
    return float(values[k]), float(at[k]) if values[k] > 0.0 else math.nan


def round_trip(law: Law) -> tuple[float, float]:
    """Overlap of the force against the overlap, over what ε of overlap and force leaves to it: 1 is 16 ε + 64 ε P/(K δ)."""
    at = overlaps(law)
    force = law.force(at)
    noise = EPS * force / (law.stiffness(at) * at)
    return _worst(np.abs(law.overlap(force) / at - 1.0) / (16.0 * EPS + 64.0 * noise), at)


def force_trip(law: Law) -> tuple[float, float]:
    """Force at the overlap of a force against it, in units of ε (64 + 16 K δ/P)."""
    ends = overlaps(law)[[0, -1]]
    force = np.geomspace(law.force(ends[0]) * 1.001, law.force(ends[1]), 50)
    at = law.overlap(force)
    slope = law.stiffness(at) * at / force
    return _worst(np.abs(law.force(at) / force - 1.0) / (EPS * (64.0 + 16.0 * slope)), at)


def derivative(function, overlap, width, degree):
    """dP/dδ on either side of `overlap`, of the polynomial that fits the force over `width` of it; a kink within reach
    affects one side only. 300 Chebyshev points average out most of the rounding of single forces.
    """
    sides = []
    for sign in (-1.0, 1.0):
        half = 0.5 * width * overlap
        centre = overlap + sign * half
        nodes = centre + half * np.cos(np.pi * (np.arange(300) + 0.5) / 300)
        values = function(nodes)
        place = (nodes - centre) / half  # of the rounded nodes
        middle, span = values[150], np.ptp(values)  # taken out, so that the fit's own rounding counts for little
        fit = np.polynomial.chebyshev.chebfit(place, (values - middle) / span, degree)
        slope = np.polynomial.chebyshev.chebval((overlap - centre) / half, np.polynomial.chebyshev.chebder(fit))
        sides.append(slope * span / half)
    return sides


def derivative_error(law: Law, points: int = 80) -> tuple[float, float]:
    """Stiffness against the derivative of the force, relative, on the better side of each overlap.

    Solved laws are read from cells of unknown place, counted from the seating load: the best of two reaches counts.
    """
    solved, errors, at = law.definition.solved, [], []
    for overlap in overlaps(law, points):
        force, stiffness = law.force(overlap), law.stiffness(overlap)
        reaches = [(0.25, 12)]
        if solved:
            reaches = [(w * max(1.0, force / (stiffness * overlap)), n) for w, n in ((3e-3, 5), (8e-3, 6))]
        slopes = [derivative(law.force, overlap, width, degree) for width, degree in reaches if width < 0.5]
        if slopes:
            errors.append(float(np.min(np.abs(np.array(slopes) / stiffness - 1.0))))
            at.append(overlap)
    return _worst(np.array(errors), at)


def energy_error(law: Law) -> tuple[float, float]:
    """Energy against ∫P dδ, relative, by Gauss's rule on panels of an octave (a 64th of one where a solver made the law)."""
    panels = 64 if law.definition.solved else 1
    x, weights = np.polynomial.legendre.leggauss(16)
    largest = 0.1 * law.contact.radius
    edges = largest * 2.0 ** np.arange(-60.0, 1 / panels, 1 / panels)
    edges = np.unique([0.0, *edges, *law.kinks()])
    edges = edges[edges <= largest]
    half = 0.5 * np.diff(edges)
    force = np.reshape(law.force((edges[:-1, None] + half[:, None] * (1 + x)).ravel()), (half.size, x.size))
    work = np.concatenate([[0.0], np.cumsum(half * (force @ weights))])
    chosen = (edges > 1e-7 * law.contact.roughness) & (edges > 1e-12 * law.contact.radius)
    return _worst(np.abs(law.energy(edges[chosen]) / work[chosen] - 1.0), edges[chosen])


def kink_jump(law: Law) -> tuple[float, float]:
    """Relative jump of the force at the law's kinks."""
    kinks = np.array([k for k in law.kinks() if 0.0 < k < 0.1 * law.contact.radius])
    if not kinks.size:
        return 0.0, math.nan
    return _worst(np.abs(law.force(kinks * (1 + 1e-12)) / law.force(kinks * (1 - 1e-12)) - 1.0), kinks)


def not_finite(law: Law, count: int = 20_000) -> tuple[int, int]:
    """Of random overlaps, denormal ones to a tenth of the radius: how many are not finite or negative, how many forces fall."""
    largest = np.array([0.0999 * law.contact.radius])
    return finite_loop(law.params, 1, largest, count, np.random.default_rng(1))


def alone(law: Law) -> tuple[float, float]:
    """Arrays against one number at a time, in ε."""
    at = overlaps(law, 40)
    one = np.array([[law.force(float(d)), law.stiffness(float(d))] for d in at]).T
    together = np.array([law.force(at), law.stiffness(at)])
    return _worst(np.max(np.abs(together / one - 1.0), axis=0) / EPS, at)


def returned_work(law: Law, paths: int = 2000) -> tuple[int, float]:
    """Random paths of one contact, any rule: how many return work, and the most over the energy held."""
    radius = np.array([law.contact.radius])
    state = law.new_state(1).arrays
    share = 0.049 if law.definition.solved else 0.1
    random = np.random.default_rng(2)
    count, worst, bad = path_loop(law.rule, law.params, state, 1, 1e-25 * radius, share * radius, paths, 12, random)
    return int(count + bad), float(-worst)


# --- all of them


def check_law(
    name: str, contact: Contact | None = None, rules: tuple | None = None, paths: int = 2000, **options: Any
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
    returned on random paths, the certificate of its table, and its `exact` reference if it has one.

    Examples
    --------
    >>> dl.check_law("hertz", rules=("elastic",), paths=100).passed
    True
    """
    name = find(name).name
    contact = GRANITE_PAIR if contact is None else contact
    if not isinstance(contact, Contact) or contact.size is not None:
        raise DemlawsError("check_law takes one contact, not an array of contacts")
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore", ValidityWarning)
        law = example(name, contact, "elastic", **options)
        return LawCheck(name, (*_curve_checks(law), *_rule_checks(law, contact, rules, paths, options), *_table_checks(law)))


def _curve_checks(law):
    solved = law.definition.solved
    bad, falling = not_finite(law)
    slope = fault_of_slope(lambda at: (law.force(at), law.stiffness(at)), overlaps(law, 240)) or ""
    checks = [
        Check("force, stiffness: not finite or negative", bad, 0),
        Check("force falls as the overlap grows", falling, 0),
        Check("force jumps, or stiffness is not its derivative", float(bool(slope)), 0, note=slope),
        Check("overlap of the force of an overlap (1: rounding)", *_put(round_trip(law), 10.0 if solved else 1.0)),
        Check("force of the overlap of a force (1: rounding)", *_put(force_trip(law), 3.0)),
        Check("stiffness against derivative, relative", *_put(derivative_error(law), 1e-11)),
        Check("energy against ∫P dδ, relative", *_put(energy_error(law), 1e-10)),
        Check("force across kinks, relative", *_put(kink_jump(law), 2e-4)),
        Check("arrays against single numbers (ε)", *_put(alone(law), 8.0)),
    ]
    if law.definition.exact is not None:
        at = law.contact.roughness * np.geomspace(1e-4, 30.0, 200) if law.contact.roughness else overlaps(law, 200)
        for kink in (*law.kinks(), law.contact.roughness or 1.0):
            at = at[np.abs(at / kink - 1.0) > 1e-6]
        force, stiffness = law.definition.exact(law.contact, at, **law.options)
        for what, found, exact, allowed in (
            ("force", law.force(at), force, 1e-14),
            ("stiffness", law.stiffness(at), stiffness, 1e-13),
        ):
            checks.append(
                Check(
                    f"{what} against its exact equation", *_put(_worst(np.abs(found / exact.astype(float) - 1.0), at), allowed)
                )
            )
    if law.collapses and not law.definition.solved:  # a solved law's curve comes with a number of its own
        try:
            refuse_unless_collapses(law, law.contact)
            checks.append(Check("one curve serves all contacts", 0, 0))
        except DemlawsError as error:
            checks.append(Check("one curve serves all contacts", 1, 0, note=str(error)))
    return checks


def _put(found, allowed):
    """(value, allowed, where) as `Check` takes them."""
    return found[0], allowed, found[1]


def _rule_checks(law, contact, rules, paths, options):
    checks = []
    for rule in rules or law.definition.offered():
        try:
            joined = example(law.name, contact, rule, **options)
        except DemlawsError as error:
            # a rule that would return work is refused for every law: that is no fault of this one
            if isinstance(error, NotPassive) or rule not in law.definition.unloading:  # it does not say that it takes this rule
                checks.append(Check(f"{rule} unloading: refused", 0, 0, note=str(error).split(": ")[-1][:70]))
            else:
                checks.append(Check(f"{rule} unloading: refused, though its definition names it", 1, 0, note=str(error)))
            continue
        count, most = returned_work(joined, paths)
        note = f"most {most:.1e} of the energy held" if count else ""
        checks.append(Check(f"{rule} unloading: paths of {paths} that return work", count, 0, note=note))
        checks.append(Check(f"{rule} unloading: batch against path, relative", *_put(batch_against_path(joined), 1e-13)))
    return checks


def batch_against_path(law: Law) -> tuple[float, float]:
    """Force and stiffness of a batch against the same contact followed alone."""
    random = np.random.default_rng(3)
    scale = 1e-3 * law.contact.radius
    steps = random.uniform(-0.1, 1.0, 60) * scale
    path = law.follow(steps)
    state = law.new_state(3) if law.state_size else None
    errors = []
    for n, overlap in enumerate(steps):
        found = law.evaluate(np.full(3, overlap), state)
        pairs = zip(found, (path.force[n], path.stiffness[n]), strict=True)
        errors.append(max(float(np.max(np.abs(a - b)) / b) if b > 0.0 else float(np.max(np.abs(a))) for a, b in pairs))
    return _worst(np.array(errors), steps)


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
