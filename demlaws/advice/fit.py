"""Laws fitted to measured points: parameters with intervals, and a ranking of the laws.

The points are a history of (displacement, force), loading and unloading in any order. A law predicts the overlap at each
force from the largest force before it. The displacement at first touch ("zero") is a free parameter. The noise is that of
the displacement; noise of the force is converted with the stiffness (effective variance). Laws are ranked by Akaike's
information criterion, corrected for few points (AICc). The apparatus may be compliant: `compliance` [m/N] times the force
adds to the displacement, known or fitted. The reading of the load cell without a load, "force_zero", is fitted, too.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from demlaws.advice.fit_model import APPARATUS, COMPLIANCE, DRIFT, FORCE_ZERO, ZERO, Model, largest_compliance, parameters
from demlaws.advice.fit_report import WEAK, Fit, fitted
from demlaws.contact import Contact, warn_of_roughness
from demlaws.core.unloading import GIVEN
from demlaws.curves.point_files import columns_of, creeping_holds, in_contact, refuse_other_units
from demlaws.errors import DemlawsError, counted
from demlaws.laws.registry import find, registry
from demlaws.responses.results import Tabular
from demlaws.units import number

_DECISIVE = 10.0  # decrease of AICc from which a note mentions a fixed quantity


class Ranking(Tabular, list[Fit]):
    """Fits from the best to the worst, and the laws that were not fitted; `print(ranking)` shows them as a table."""

    def __init__(self, fits, skipped, points):
        super().__init__(fits)
        self.skipped = skipped  # law or points left out → reason
        self.points = points  # displacement and force of the points used, in their order

    @property
    def best(self) -> Fit:
        """The fit of lowest AICc, the first of the list."""
        return self[0]

    def title(self) -> str:
        """A line where no law describes the points."""
        none = all(fit.systematic for fit in self)
        return "no law fits within the noise: weights only compare these laws with each other" if none else ""

    def columns(self) -> dict:
        """Law, unloading, misfit, ΔAICc, weight, kind of misfit and parameters, each a list."""
        titles = {"law": "name", "unloading": "unloading", "misfit (m)": "misfit", "ΔAICc": "delta", "weight": "weight"}
        columns = {title: [getattr(fit, name) for fit in self] for title, name in titles.items()}
        texts = ["; ".join(f"{n} {e.value:.4g}" for n, e in fit.parameters.items()) for fit in self]
        kinds = ["systematic" if fit.systematic else "scatter" for fit in self]
        return {**columns, "misfit is": kinds, "parameters": texts}


def fit(
    points: ArrayLike,
    contact: Contact,
    laws: str | Sequence[str] | None = None,
    *,
    unloading: str | Sequence[str] | None = None,
    free: Sequence[str] | None = None,
    options: dict | None = None,
    displacement_noise: float | None = None,
    force_noise: float = 0.0,
    compliance: float = 0.0,
    progress: Callable = iter,
) -> Ranking:
    """Fit laws to measured points and rank them by Akaike's criterion.

    Parameters
    ----------
    points : array_like, shape (n, 2), Points, or path of a file
        Displacement [m] and force [N] in the order of the test.
    contact : Contact
        Known quantities, and starting values of the fitted ones.
    laws : str or sequence of str, optional
        Names of laws. Default: all laws without a height map whose parameters such a test determines.
    unloading : str or sequence of str, optional
        Unloading rules. Default: each rule of the law if the points unload, else "elastic".
    free : sequence of str, optional
        Quantities to fit: of the contact, of the laws (`Fitting.parameters`), of the apparatus ("compliance",
        "drift": displacement [m] in proportion to the rows, "force_zero"). An empty list fits none.
        Each hold over which the displacement creeps adds one, "creep_1" and so on.
        Default: `Fitting.free`, "force_zero", which may be left out if the load cell was tared in air, and, if the points
        load and unload, "drift", which may be left out of a test at constant temperature.
    options : dict, optional
        Name of the law → fixed options.
    displacement_noise : float, optional
        Standard deviation of the displacement [m]. Default: from the scatter of the points about the law.
    force_noise : float
        Standard deviation of the force [N].
    compliance : float
        Compliance of the apparatus [m/N], subtracted from the displacement; to fit it, name "compliance" in `free`.
    progress : callable
        Wraps the list of fits, like tqdm.

    Returns
    -------
    Ranking
        Fits from the best to the worst; `.skipped` lists points and laws that are not used.

    Raises
    ------
    DemlawsError
        For points that determine nothing.

    Notes
    -----
    A weight compares the laws with each other only; `Fit.systematic` marks a law that does not describe the points.

    Examples
    --------
    >>> pair = dl.Contact(radius=4e-3, modulus=32e9)
    >>> path = dl.driver.force_controlled(dl.law("hertz", pair), [50.0], steps=30)
    >>> points = [(x, p) for x, p in zip(path.overlap, path.force)][1:]
    >>> best = dl.fit(points, pair.with_values(modulus=20e9), laws="hertz", free=["modulus"]).best
    >>> round(best.contact.modulus / 1e9, 3)
    32.0
    """
    if not isinstance(contact, Contact) or contact.size is not None:
        raise DemlawsError("contact must be one demlaws.Contact: that of the test")
    displacement, force = columns_of(points)
    usual = [n for n, definition in registry().items() if definition.fitting.identifiable and not definition.needs_map]
    names = [find(n).name for n in _texts(laws, "laws") or usual]
    free, rules, options = _named(_texts(free, "free")), _texts(unloading, "unloading"), _checked_options(options or {})
    if displacement_noise is not None:
        displacement_noise = number(displacement_noise, "displacement_noise", "m", 1e-13, 1e-2, allow_low=True)
    force_noise = number(force_noise, "force_noise", "N", allow_low=True)
    if force_noise and displacement_noise is None:
        raise DemlawsError("force_noise needs displacement_noise [m] beside it: only their ratio weights the points")
    displacement = displacement - number(compliance, "compliance", "m/N", 0.0, 1e-3, allow_low=True) * force
    course = np.linspace(0.0, 1.0, force.size)
    repeated = np.append(False, np.all(np.diff([displacement, force]) == 0.0, axis=0)) if force.size else np.zeros(0, bool)
    displacement, force, course = (one[~repeated] for one in (displacement, force, course))
    keep, skipped = in_contact(force, force_noise)
    displacement, force, course = displacement[keep], force[keep], course[keep]
    if np.any(repeated):
        skipped[counted(int(np.sum(repeated)), "repeated row")] = "equal to the row before: no new reading"
    quantities = parameters()
    if unknown := [n for n in free or () if n not in quantities]:
        raise DemlawsError(f"cannot fit {', '.join(unknown)}: the quantities that a fit can vary are {', '.join(quantities)}")
    if force.size:
        refuse_other_units(displacement, force, contact, largest_compliance(contact) if COMPLIANCE in (free or ()) else 0.0)
    left, creep = _without_holds(displacement, force, skipped)
    displacement, force, course = displacement[left], force[left], course[left]
    distinct = len(np.unique(np.column_stack([displacement, force]), axis=0)) - len(creep)
    test = _TestData(contact, options, displacement, force, course, displacement_noise, force_noise, free, creep)
    fits, failed = [], {}
    for name, rule, variables in progress(list(_models_to_fit(names, rules, free, force, distinct))):
        try:
            fits.append(test.fit(name, rule, variables))
        except DemlawsError as error:
            failed[name if rule == "elastic" else f"{name}, {rule} unloading"] = error
    if not fits:
        raise DemlawsError(f"no law could be fitted: {'; '.join(f'{name}: {reason}' for name, reason in failed.items())}")
    fits.sort(key=lambda f: f.aicc)
    fits[0] = fits[0]._replace(notes=(*fits[0].notes, *_suspicions(fits[0], test)))
    relative = [math.exp(-0.5 * (f.aicc - fits[0].aicc)) for f in fits]
    ranking = [f._replace(delta=f.aicc - fits[0].aicc, weight=w / sum(relative)) for f, w in zip(fits, relative, strict=True)]
    return Ranking(ranking, failed | skipped, (displacement, force))


class _TestData(NamedTuple):
    """Points in contact, and what is known of them."""

    contact: Contact
    options: dict  # name of the law → fixed options
    displacement: np.ndarray
    force: np.ndarray
    course: np.ndarray  # place of each point in the test, from 0 to 1
    displacement_noise: float | None
    force_noise: float
    free: Sequence[str] | None  # as the user gave it
    creep: dict  # name → mask of the rows after a hold, over which the displacement crept

    def fit(self, name, rule, free):
        """The `Fit` of a law, its rule, and the names of its free quantities."""
        points = {
            "displacement": self.displacement,
            "force": self.force,
            "noise": self.displacement_noise,
            "course": self.course,
            "creep": self.creep,
        }
        model = Model(name, rule, free, contact=self.contact, options=self.options.get(name, {}), **points)
        one = fitted(model, self.displacement_noise, self.force_noise)
        # a straight line has one zero; the displacement of a cycle of few points may drift in many ways
        for quantity in (DRIFT, FORCE_ZERO) if self.free is None else ():
            if quantity in free and one.parameters[quantity].cause == WEAK:
                return self.fit(name, rule, [n for n in free if n != quantity])
        return one


def _without_holds(displacement, force, skipped):
    """Mask of the rows that are fitted, and name → mask of the rows after each hold; the holds are named in `skipped`.

    The first row of a hold and the last one stay, if others are before and behind it.
    """
    left, creep, names = np.ones(force.size, bool), {}, []
    if force.size and np.ptp(force) < 1e-3 * np.max(force):
        raise DemlawsError(
            f"all {force.size} forces are {np.max(force):.4g} N within 0.1 %: a hold shows creep or drift, no law; give "
            "points of different forces"
        )
    for first, last in creeping_holds(displacement, force):
        inner = first + 1 if first else 0, last if last < force.size - 1 else force.size
        left[slice(*inner)] = False
        names.append(f"{1e6 * (displacement[last] - displacement[first]):.3g} µm at {np.mean(force[first : last + 1]):.4g} N")
        if first and last < force.size - 1:
            creep[f"creep_{len(creep) + 1}"] = np.arange(force.size) >= last
    if names:
        skipped[f"{counted(int(np.sum(~left)), 'row')} at constant force"] = (
            f"the displacement creeps ({', '.join(names)}); the creep of each hold between other rows is fitted"
        )
    return left, {name: rows[left] for name, rows in creep.items()}


def _models_to_fit(names, rules, free, force, distinct):
    """(law, rule, free quantities) of each fit; distinct: number of different points."""
    # the curve of rule "table" has no parameters of the law
    available = [rule for rule in dict.fromkeys(r for name in names for r in find(name).offered()) if rule != GIVEN]
    if unknown := [rule for rule in rules or () if rule not in available]:
        raise DemlawsError(f"unknown unloading rule {unknown[0]!r}: the rules that a fit takes are {', '.join(available)}")
    unloads = np.any(force < 0.98 * np.maximum.accumulate(force)) if force.size else False
    loads = np.any(force - np.minimum.accumulate(force) > 0.02 * np.max(force)) if force.size else False
    for name in names:
        definition = find(name)
        fields = definition.fitting.parameters
        known = {"modulus", *APPARATUS, *fields}
        variables = [n for n in (definition.fitting.free if free is None else free) if n in known]
        if distinct < len(variables) + 4:
            if not force.size:
                raise DemlawsError("no point has a force above 0: compression is positive; change the sign of the forces")
            few = f"{distinct} different points with a force above 0 (compression)"
            raise DemlawsError(f"{few}: at least {len(variables) + 4} are needed for {name}")
        if free is None and distinct >= len(variables) + 5:
            variables.append(FORCE_ZERO)
        if free is None and loads and unloads and distinct >= len(variables) + 6:
            variables.append(DRIFT)  # loading alone, or unloading alone, does not tell it from the law
        for rule in rules or (definition.unloading if unloads else ("elastic",)):
            # first loading alone does not show a quantity of the unloading curve
            yield name, rule, [n for n in variables if rule != "elastic" or n not in fields or not fields[n].unloading]


def _texts(value, name):
    """None, or a list of one or several words."""
    words = [value] if isinstance(value, str) else value
    if words is not None and not (isinstance(words, list | tuple | set) and all(isinstance(one, str) for one in words)):
        raise DemlawsError(f"{name} must be a name or a list of names, got {value!r:.60}")
    return None if words is None else list(words)


def _named(free):
    """Names of free quantities, σ of the pair by its own name."""
    if "roughness" not in (free or ()):
        return free
    warn_of_roughness()
    return ["sigma" if name == "roughness" else name for name in free]


def _checked_options(options):
    """Law name → options."""
    if not isinstance(options, Mapping) or not all(isinstance(one, Mapping) for one in options.values()):
        raise DemlawsError(f"options must be {{law: {{option: value}}}}, got {options!r:.60}")
    return {find(name).name: one for name, one in options.items()}


def _suspicions(best, test):
    """Notes on fixed quantities that explain a pattern of the misfit: E*, and the compliance of the apparatus."""
    misfit = test.displacement - best.displacement
    spread = float(np.sum(misfit**2))
    if best.law.definition.solved or not float(np.sum(misfit[1:] * misfit[:-1])) > 1.7 / math.sqrt(misfit.size) * spread > 0.0:
        return
    variables = [name for name in best.coordinates if name != ZERO and name not in test.creep]
    wrong = f"the given E* = {test.contact.modulus * 1e-9:.4g} GPa may be wrong"
    hints = {
        "modulus": (1e-9, "GPa", wrong, "fit the modulus"),
        COMPLIANCE: (1e6, "µm/N", "the apparatus may be compliant", "measure the compliance and give it, or fit it"),
        DRIFT: (1e6, "µm", "the displacement may drift", "remove the drift, or fit it (free)"),
        FORCE_ZERO: (1.0, "N", "the load cell may be off", "fit its zero (force_zero)"),
    }
    for name, (unit, symbol, meaning, remedy) in hints.items():
        if name in variables:
            continue
        try:
            other = test.fit(best.name, best.unloading, [*variables, name])
        except DemlawsError:
            continue
        if name not in other.parameters or other.parameters[name].cause:
            continue  # not separately identifiable, or at the end of its range
        value, low, high = (other.parameters[name][n] * unit for n in (0, 2, 3))
        if (value > 0.0 or name in (DRIFT, FORCE_ZERO)) and other.aicc < best.aicc - _DECISIVE:
            fall = f"from {best.misfit * 1e6:.3g} to {other.misfit * 1e6:.3g} µm"
            interval = f"{value:.4g} {symbol} [{low:.4g}, {high:.4g}]"
            yield f"{meaning}: with {interval} the misfit falls {fall}; {remedy}"
