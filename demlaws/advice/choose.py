"""The cheapest law within a scene's tolerance; physics that its loads never reach is neglected, with the stated error.

`choose` binds the richest law that a `Scene`'s quantities determine (the reference), strips it step by step, predicts each
candidate's error over the scene's contacts and loads, and ranks those within the tolerance by the kept cost of an evaluation.
Errors are those against the reference; use `demlaws fit` to compare laws with measurements.
"""

import math
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from demlaws.advice.errors import error_of
from demlaws.advice.measured_costs import measured_costs
from demlaws.advice.scene import Scene, samples, stable_step, unloading_rule
from demlaws.contact import Contact
from demlaws.core.unloading import GIVEN
from demlaws.errors import DemlawsError, NeedsClasses, quiet, warn
from demlaws.law import Law, Table
from demlaws.laws import HERTZ
from demlaws.laws.definition import bulk_yield
from demlaws.laws.registry import find, registry
from demlaws.make import law as bind_law, unloading_for
from demlaws.responses.results import Tabular

_MARGIN = 1.02  # between the points of the prediction an error may be a little larger
_ROUNDING = 1e-13


def kept_cost(plan):
    """ns per contact of a `Plan`, measured by `make trade`; a law that it did not measure costs as much as a table."""
    cost = measured_costs()["cost"]
    tables = cost["table"]
    table = tables.get(plan.unloading, max(tables.values()))
    return table if plan.evaluation == "table" else cost["closed form"].get(plan.name, {}).get(plan.unloading, table)


class Plan(NamedTuple):
    """A law, an unloading rule and an evaluation for the contacts of a scene."""

    name: str
    options: tuple  # (name, value) pairs
    unloading: str
    evaluation: str  # "closed form" or "table"
    rtol: float = 0.0
    curve: Law | None = None  # along which contacts unload by the rule "table"

    @property
    def unload_by(self):
        """Rule or curve, as for the argument `unloading` of `dl.law`."""
        return self.unloading if self.curve is None else self.curve

    def bind(self, contact, max_force=None):
        """The law on a contact, or an array of contacts."""
        with quiet():
            law = bind_law(self.name, contact, unloading_for(self.unload_by, contact), **dict(self.options))
            return law.tabulate(self.rtol, max_force) if self.evaluation == "table" else law


@dataclass(frozen=True)
class Choice:
    """One candidate with its error and cost."""

    plan: Plan
    error: float  # bound of the scene's quantity over its contacts and loads, against the reference
    ns: float  # per contact and evaluation, kept from `make trade`; on another machine the ratios are similar
    step_factor: float  # time step over the reference's
    step: float  # safe time step of the scene [s], `stable_step`
    state_bytes: int  # per contact
    table_rows: int
    left_out: tuple  # (what, error that it costs)
    meets: bool
    scene: Scene
    reference: Plan  # that the error is relative to
    max_force: float  # 1.5 times the largest force [N] of the scene: the end of its tables

    name = property(lambda self: self.plan.name)
    unloading = property(lambda self: self.plan.unloading)
    evaluation = property(lambda self: self.plan.evaluation)

    @property
    def cost(self) -> float:
        """ns per contact and reference time step: a law that allows longer steps is evaluated less often."""
        return self.ns / self.step_factor

    def tables(self) -> dict[tuple[int, int], Table]:
        """Pair of kinds of grain → `Table`. `NeedsClasses` where one table cannot serve all sizes (`export` writes each)."""
        scene = self.scene
        if not find(self.name).collapses and len({*(scene.pair_radii() or scene.effective_radii())}) > 1:
            raise NeedsClasses(f"no table of {self.name}: {_ONE_SIZE if scene.pair_radii() else _NO_TABLE}")
        plan, contacts = _as_table(self.plan, scene), scene.contacts(scene.effective_radii()[1])
        return {kinds: plan.bind(contact, self.max_force) for kinds, contact in zip(scene.kinds(), contacts, strict=True)}

    def export(self, folder: str | os.PathLike) -> Path:
        """Write a case for LIGGGHTS, or LAMMPS where that is the scene's engine: this law for every kind and size of grain of
        the scene, with all the tables it needs."""
        from demlaws.lammps.export import export as to_lammps
        from demlaws.liggghts.export import export as to_liggghts

        engine, export = ("lammps", to_lammps) if self.scene.engine == "lammps" else ("liggghts", to_liggghts)
        native = self.evaluation != "table"  # a law that the engine has itself
        options = {"stock": find(self.name).advice.native[engine]} if native else {"rtol": self.plan.rtol}
        return export(
            folder,
            self.name,
            self.scene.grains(),
            unloading=self.plan.unload_by,
            options=dict(self.plan.options),
            max_force=self.max_force / 1.5,
            **options,
        )

    def law(self, contact: Contact) -> Law:
        """The law on your contact (or array of contacts)."""
        return self.plan.bind(contact, self.max_force)

    def describe(self) -> str:
        """One line: law with its options in SI, unloading, evaluation."""
        options = ", ".join(f"{n}={v:g}" if isinstance(v, float) else f"{n}={v}" for n, v in self.plan.options)
        rtol = f" (rtol {self.plan.rtol:g})" if self.plan.rtol else ""
        return f"{self.name}{f' ({options})' if options else ''}, {self.unloading}, {self.evaluation}{rtol}"

    def script(self, table: str = "law.tbl") -> str:
        """The Python line that makes this law: for `contact` or, in YADE, for materials with `surfaces`."""
        plain = {name: float(value) if isinstance(value, float) else value for name, value in self.plan.options}
        options = "".join(f", {name}={value!r}" for name, value in plain.items())
        unloading = "curve" if self.plan.curve is not None else f'"{self.unloading}"'  # curve: the scene's, a law or a table
        if self.scene.engine == "yade" and self.evaluation == "table":
            tables = f'"{table}"' if len(self.scene.materials) == 1 else "tables"  # pair of labels → file
            return f"law = Law2_ScGeom_MindlinPhys_Demlaws({tables})"
        if self.scene.engine == "yade":
            return f'law = Law2_ScGeom_MindlinPhys_Demlaws("{self.name}", {unloading}, surfaces{options})'
        tail = f".tabulate(rtol={self.plan.rtol:g}, max_force={self.max_force:g})" if self.evaluation == "table" else ""
        return f'law = dl.law("{self.name}", contact, unloading={unloading}{options}){tail}'


def table_name(path, scene, kinds):
    """File of the table of a pair of kinds of grain: the path itself where there is one kind."""
    path = Path(path)
    return path if len(scene.materials) == 1 else path.with_name(f"{path.stem}-{kinds[0]}-{kinds[1]}{path.suffix}")


class Choices(Tabular, list[Choice]):
    """Choices, ordered by cost; those within the tolerance come first."""

    def __init__(self, choices, scene, reference, ruled_out, notes):
        super().__init__(choices)
        self.scene = scene
        self.reference = reference  # Plan
        self.ruled_out = ruled_out  # text → reason
        self.notes = notes

    @property
    def best(self) -> Choice:
        """The cheapest choice within the tolerance, the first of the list."""
        return self[0]

    def columns(self) -> dict:
        """Choice, errors, cost, time step and state of each, each a list."""
        names = ("error", "ns", "step_factor", "state_bytes", "meets")
        return {"choice": [c.describe() for c in self], **{name: [getattr(c, name) for c in self] for name in names}}

    def title(self) -> str:
        """The scene's quantity and tolerance."""
        return f"{self.scene.quantity} within {self.scene.tolerance:g}"


def _determined(contact):
    """Laws that the contact's quantities determine and that choices are made of, the richest first."""
    pool = [
        d
        for d in registry().values()
        if (d.advice.rank or d.advice.candidate) and (d.advice.smooth or not np.all(contact.is_smooth))
    ]
    return sorted(
        (d for d in pool if all(getattr(contact, n) is not None for n in d.loading.needs)), key=lambda d: -d.advice.rank
    )


def _reaches(definition, scene):
    """Whether a law can be made of the scene's contacts."""
    try:
        for radius in scene.effective_radii():
            for contact in scene.contacts(radius):
                bind_law(definition.name, contact, "elastic")
    except DemlawsError:
        return False
    return True


def reference_plan(scene):
    """The richest law that the scene's quantities determine and that holds at its smallest loads."""
    options = dict(scene.reference_options)
    contact = scene.contacts(scene.effective_radii()[0])[0]
    if scene.reference is not None:
        definition = find(scene.reference)
    else:
        contacts = scene.contacts(scene.effective_radii()[0])
        if any(c.sigma is None for c in contacts):
            warn(
                "the scene's surfaces have no roughness: the reference is a law of smooth contacts; give the roughness of each "
                "surface, 0 for a smooth one"
            )
        rough = contact.with_values(sigma=max(c.sigma_or_zero for c in contacts))
        candidates = [d for d in _determined(rough) if d.advice.rank]
        definition = next((d for d in candidates if _reaches(d, scene)), candidates[-1])
        if scene.yield_pressure is not None:
            options = {"yield_pressure": scene.yield_pressure, "loading": definition.name, **options}
            definition = next(d for d in registry().values() if d.before_yield()[0] is not None)
    options = definition.read_options(options)
    back = unloading_rule(scene, definition.name, options)
    if isinstance(back, Law):
        return Plan(definition.name, tuple(options.items()), GIVEN, "closed form", curve=back)
    return Plan(definition.name, tuple(options.items()), definition.rule(back).name, "closed form")


def _before_yield(plan):
    """The plan's law as it is before the bulk yields: (Definition, options), or None of a law that has no yield."""
    definition = find(plan.name)
    before, options = definition.before_yield(**dict(plan.options))
    return None if before is None else (before, tuple(options.items()))


def plans(scene, reference):
    """All candidates, tables aside."""
    candidates = [(find(reference.name), reference.options)]
    if (before := _before_yield(reference)) is not None:
        candidates.append(before)
    determined = _determined(scene.contacts(scene.effective_radii()[0])[0])
    candidates += [(definition, ()) for definition in determined if definition.advice.candidate]
    alternatives = [reference]
    for definition, options in candidates:
        rules = definition.unloading if scene.unloads else definition.unloading[:1]
        alternatives += [Plan(definition.name, options, rule, "closed form") for rule in rules]
        if reference.curve is not None and not definition.advice.smooth:
            alternatives.append(Plan(definition.name, options, GIVEN, "closed form", curve=reference.curve))
    return list(dict.fromkeys(alternatives))


_ONE_SIZE = "one table per pair of sizes"
_NO_TABLE = "its curve depends on the radius; list grain sizes as classes"


class _Evaluator:
    """Errors, step factors and state sizes of plans on one scene."""

    def __init__(self, scene, reference, tables=True):
        self.scene, self.reference, self.tables = scene, reference, tables
        self.samples = samples(scene)
        self.largest = max(float(s.peak.max()) for s in self.samples)
        self.smallest = min(float(s.peak.min()) for s in self.samples)
        self.exact = [reference.bind(s.contact) for s in self.samples]
        self.max_force = 1.5 * self.largest
        self.bound = {}
        with quiet():
            self.breaches = [b for law in self.exact for b in law.breaches(self.smallest, self.largest)]
        self.known = {breach.reason for breach in self.breaches}  # limits that the reference passes, too
        one = scene.contacts(scene.effective_radii()[1])[0]
        # the reference has roughness, and may yield: the error of a law without them is computed
        self.known |= {limit.reason for limit in find(HERTZ).limits(one) if limit.minimum_force > 0.0}
        if find(reference.name).before_yield()[0] is not None:
            self.known |= {limit.reason for limit in bulk_yield(one)}

    def consider(self, plan):
        """The plan and its table with their errors, and why they are ruled out."""
        errors, label = {}, _label(plan)
        try:
            breaches = [b for b in self.laws(plan)[0].breaches(self.smallest, self.largest) if b.reason not in self.known]
            if breaches and plan != self.reference:
                return {}, {label: f"loads of {breaches[0]}"}
            errors[plan] = self.error(plan)
            if self.tables and not find(plan.name).advice.closed_form_is_cheapest:
                table = _as_table(plan, self.scene)
                label = _label(table)
                errors[table] = self.error(table)
        except DemlawsError as error:
            return errors, {label: str(error)}
        return errors, {}

    def laws(self, plan):
        """The plan's laws on the samples, made once."""
        if plan not in self.bound:
            self.bound[plan] = [self._bind(plan, sample.contact) for sample in self.samples]
        return self.bound[plan]

    def _bind(self, plan, contact):
        if plan.evaluation != "table":
            return plan.bind(contact)
        if not find(plan.name).collapses:
            if np.ptp(contact.radius) > 0.0:
                raise NeedsClasses(f"no table: {_NO_TABLE}")
            if self.scene.engine == "yade" and len(self.scene.pair_radii()) > 1:
                raise NeedsClasses(f"no table: {_ONE_SIZE}, and YADE takes one per pair of materials")
            contact = contact.with_values(radius=float(contact.radius[0]))
        return plan.bind(contact, self.max_force)

    def error(self, plan, against=None):
        """Bound of the error of a plan against the reference (or another plan)."""
        worst = 0.0
        exact = self.exact if against is None else self.laws(against)
        for sample, other, law in zip(self.samples, exact, self.laws(plan), strict=True):
            error = error_of(law, other, sample, self.scene.quantity, self.scene.unloads)
            if not np.all(np.isfinite(error)):
                return math.inf
            worst = max(worst, float(error.max()))
        return _MARGIN * worst + _ROUNDING

    def step(self, plan):
        """Safe step [s] of the scene."""
        with quiet():
            return stable_step(self.scene, plan._replace(evaluation="closed form", rtol=0.0).bind)


def _changes(reference, plan):
    """What leads from the reference to a plan: (what is left out, the plan without it), in the order yield, history, roughness,
    evaluation."""
    now = reference
    if (before := _before_yield(reference)) is not None and _before_yield(plan) is None:
        definition, options = before
        same_rule = reference.curve is not None or reference.unloading in definition.unloading
        rule = reference.unloading if same_rule else definition.unloading[-1]
        now = reference._replace(name=definition.name, options=options, unloading=rule)
        yield "bulk yield", now
    if now.unloading != plan.unloading:
        what = "unloading history" if plan.unloading == "elastic" else f"{now.unloading} unloading"
        now = now._replace(unloading=plan.unloading, curve=plan.curve)
        yield what, now
    if (now.name, now.options) != (plan.name, plan.options):
        what = "roughness" if find(plan.name).advice.smooth else f"{now.name} replaced by {plan.name}"
        now = now._replace(name=plan.name, options=plan.options)
        yield what, now
    if plan.evaluation != "closed form":
        yield "table in place of the closed form", plan


def _left_out(judge, plan):
    """What the plan leaves out, each with the error that it alone adds; not a number where that cannot be computed."""
    result, before = [], judge.reference
    for what, after in _changes(judge.reference, plan):
        try:
            error = max(judge.error(after, before) - _ROUNDING, 0.0) / _MARGIN
        except DemlawsError:
            error = math.nan
        result.append((what, error))
        before = after
    return tuple(result)


def by_reason(ruled_out: dict) -> dict:
    """Reason → labels of the plans that it rules out."""
    groups: dict = {}
    for label, reason in ruled_out.items():
        groups.setdefault(reason, []).append(label)
    return groups


def choose(scene: Scene, tables: bool = True, progress: Callable = iter) -> Choices:
    """Rank the candidate laws, rules and evaluations for a scene.

    Parameters
    ----------
    scene : Scene
        Grains, loads, quantity of interest and tolerance.
    tables : bool
        Whether tables are candidates, too.
    progress : callable
        Wraps the list of candidates, like tqdm.

    Returns
    -------
    Choices
        Candidates within the tolerance first, the cheapest first. Each `Choice` has the bound of the error, ns per contact, the
        factor of the time step, the bytes of history, and the neglected physics with its error.

    Raises
    ------
    DemlawsError
        If the scene lacks a required key.

    Examples
    --------
    >>> steel = dl.Material(young=210e9, poisson=0.3, density=7850)
    >>> choices = dl.choose(dl.Scene(radii=5e-3, materials=steel, force=(1, 10)), tables=False)  # smooth and elastic
    >>> choices.best.name
    'hertz'
    """
    if not isinstance(scene, Scene):
        raise DemlawsError(f"scene must be a demlaws.Scene (a file: dl.Scene.load), got {scene!r:.60}")
    reference = reference_plan(scene)
    judge = _Evaluator(scene, reference, tables)
    notes = [f"the reference itself ({reference.name}) leaves its range: {breach}" for breach in judge.breaches]
    ruled_out, errors = {}, {}
    for plan in progress(plans(scene, reference)):
        found, why = judge.consider(plan)
        errors.update(found)
        ruled_out.update(why)
    anywhere = scene.engine in ("python", "yade")  # the others compute tables, and what they have a model of their own for
    errors = {
        plan: error
        for plan, error in errors.items()
        if anywhere or plan.evaluation == "table" or scene.engine in find(plan.name).advice.native
    }
    none_meets = all(error > scene.tolerance for error in errors.values())
    if not errors or (none_meets and any(_NO_TABLE in why for why in ruled_out.values())):
        names = {why: dict.fromkeys(label.split(",")[0] for label in labels) for why, labels in by_reason(ruled_out).items()}
        reasons = "; ".join(f"{', '.join(laws)}: {why}" for why, laws in names.items())
        raise DemlawsError(f"no law can serve this scene: {reasons}")
    base = judge.step(reference)
    choices = []
    for plan, error in errors.items():
        step = judge.step(plan)
        law = judge.laws(plan)[0]
        choices.append(
            Choice(
                plan,
                error,
                kept_cost(plan),
                step / base,
                step,
                8 * len(law.state_names),
                law.nodes.u.size if isinstance(law, Table) else 0,
                _left_out(judge, plan),
                error <= scene.tolerance,
                scene,
                reference,
                judge.max_force,
            )
        )
    choices.sort(key=lambda c: (not c.meets, c.cost if c.meets else c.error, c.error))
    return Choices(choices, scene, reference, ruled_out, notes)


def _label(plan):
    return f"{plan.name}, {plan.unloading}, {plan.evaluation}"


def _as_table(plan, scene):
    """The table of a plan, which adds about a hundredth of the tolerance to its error."""
    return plan._replace(evaluation="table", rtol=plan.rtol or min(max(1e-5, 0.01 * scene.tolerance), 1e-3))
