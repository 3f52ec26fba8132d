"""The cheapest law that a scene allows: what its loads never reach is left out, and each omission's error is stated.

A `Scene` says what happens; `choose` binds the richest law that the scene's quantities determine (the reference), strips
it step by step, predicts each candidate's error over the scene's contacts and loads, measures what an evaluation costs
on this machine, and ranks. Errors are those against the reference; how well that describes the grains is `demlaws fit`'s
question.
"""

import itertools
import math
import warnings
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from demlaws.checks import number
from demlaws.contact import Contact, Material, Surface
from demlaws.driver import timestep
from demlaws.errors import DemlawsError, ValidityWarning
from demlaws.laws.registry import find
from demlaws.make import law as bind_law
from demlaws.measure.timing import Batch, nanoseconds
from demlaws.table import Table, tabulate

QUANTITIES = {
    "force": "force at equal overlap, over the contact's largest force so far",
    "stiffness": "tangent stiffness at equal force, relative",
    "overlap": "overlap at equal force, over the overlap at the largest force so far",
    "energy": "work of loading to equal force and what a cycle dissipates, over the work of loading",
    "restitution": "restitution coefficient at equal energy of impact, absolute",
}
ENGINES = ("python", "yade", "liggghts")
FRACTIONS = (0.01, 0.1, 0.3, 0.6, 0.9, 0.99)
"""Forces of unloading, over the largest force so far, at which cyclic scenes are compared."""
_TABLE_STEPS = (3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 1e-5)
_MARGIN = 1.02  # between the points of the prediction an error may be a little larger
_ROUNDING = 1e-13
_POINTS = 2800
_TIMED = 100_000


@dataclass(frozen=True)
class Scene:
    """What a simulation's contacts go through. SI units.

    radii: radius of the grains, or the smallest and largest; materials, surfaces: one for all grains, or lists of equal
    length, one entry a kind of grain; force: (smallest, largest) normal force that matters [N]; pressure: (smallest,
    largest) mean stress [Pa] of a packing, from which forces follow; loads: forces [N] of an actual run; speed: fastest
    approach [m/s]: an impact's peak force widens the range; one of force, pressure, loads, speed must be given. cyclic:
    contacts unload and reload; quantity: what must be right, a key of `QUANTITIES`; tolerance: largest error of it;
    engine: one of `ENGINES`; walls: grains touch flats of their own kind; yield_pressure p_y [Pa], where the bulk may
    yield; reference, reference_options: law to hold the others against (default: the richest that the quantities given
    determine); porosity, coordination: of the packing, for pressure and time step; classes: radii [m] of grains that come
    in a few sizes, such as LIGGGHTS's particle types, in place of `radii`.
    """

    radii: float | tuple = ()
    materials: Material | tuple = ()
    surfaces: Surface | tuple = field(default_factory=Surface)
    force: tuple | None = None
    pressure: tuple | None = None
    loads: np.ndarray | None = None
    speed: float = 0.0
    cyclic: bool = False
    quantity: str = "force"
    tolerance: float = 0.05
    engine: str = "python"
    walls: bool = False
    yield_pressure: float | None = None
    reference: str | None = None
    reference_options: dict = field(default_factory=dict)
    porosity: float = 0.4
    coordination: float = 6.0
    classes: tuple = ()
    name: str = ""

    def __post_init__(self):
        classes = tuple(sorted({number(r, "classes", "m") for r in np.ravel(self.classes)}))
        object.__setattr__(self, "classes", classes)
        radii = classes or tuple(number(r, "radii", "m") for r in np.ravel(self.radii))
        if not radii:
            raise DemlawsError("radii is empty: give one radius in m, or the smallest and the largest")
        object.__setattr__(self, "radii", (min(radii), max(radii)))
        materials = (self.materials,) if isinstance(self.materials, Material) else tuple(self.materials)
        surfaces = (self.surfaces,) if isinstance(self.surfaces, Surface) else tuple(self.surfaces)
        kinds = max(len(materials), len(surfaces))
        if {len(materials), len(surfaces)} - {1, kinds} or not kinds:
            raise DemlawsError(f"{len(materials)} materials and {len(surfaces)} surfaces: give one, or one a kind of grain")
        object.__setattr__(self, "materials", materials * (kinds // len(materials)))
        object.__setattr__(self, "surfaces", surfaces * (kinds // len(surfaces)))
        for label, unit in (("force", "N"), ("pressure", "Pa")):
            if getattr(self, label) is not None:
                object.__setattr__(self, label, _range(getattr(self, label), label, unit))
        if self.loads is not None:
            loads = np.asarray(self.loads, float).ravel()
            loads = loads[loads > 0.0]
            if not loads.size or not np.all(np.isfinite(loads)):
                raise DemlawsError("loads must be finite forces in N, some above 0")
            object.__setattr__(self, "loads", loads)
        number(self.speed, "speed", "m/s", allow_low=True)
        if self.force is None and self.pressure is None and self.loads is None and not self.speed:
            raise DemlawsError("the scene has no load: give force=(low, high) in N, pressure in Pa, loads, or speed in m/s")
        number(self.tolerance, "tolerance", "", 0.0, 1.0)
        number(self.porosity, "porosity", "", 0.0, 0.95)
        number(self.coordination, "coordination", "", 0.0, 20.0)
        if self.yield_pressure is not None:
            number(self.yield_pressure, "yield_pressure", "Pa")
        for label, known in (("quantity", QUANTITIES), ("engine", ENGINES)):
            if getattr(self, label) not in known:
                raise DemlawsError(f"{label} = {getattr(self, label)!r}: choose one of {', '.join(known)}")

    @classmethod
    def load(cls, path):
        """A scene from a TOML file; its keys are the fields, see the examples of `demlaws choose --help`."""
        return _from_toml(Path(path))

    def with_fit(self, fit):
        """This scene with the surface, the modulus and the law that `demlaws.fit` found for its contacts."""
        contact = fit.contact
        poisson = self.materials[0].poisson
        material = replace(self.materials[0], young=2.0 * contact.modulus * (1.0 - poisson**2), hardness=contact.hardness)
        surface = Surface(contact.roughness / math.sqrt(2.0), contact.fractal_dimension, contact.hardness)
        changes = {"materials": material, "surfaces": surface, "reference": fit.name, "reference_options": fit.law.options}
        return replace(self, **changes, yield_pressure=fit.law.options.get("yield_pressure"))

    @property
    def unloads(self):
        """Whether unloading matters."""
        return self.cyclic or self.quantity == "restitution"

    def contacts(self, radius):
        """One Contact a pair of kinds of grain, all of effective radius `radius` [m] (a number or an array)."""
        kinds = list(zip(self.materials, self.surfaces, strict=True))
        pairs = []
        for (m1, s1), (m2, s2) in itertools.combinations_with_replacement(kinds, 2):
            joined = s1.combined(s2)
            hardness = [h for h in (m1.hardness, m2.hardness, joined.hardness) if h is not None]
            pairs.append(
                Contact(
                    radius,
                    1.0 / (1.0 / m1.plane_modulus + 1.0 / m2.plane_modulus),
                    joined.roughness,
                    joined.fractal_dimension,
                    min(hardness) if hardness else None,
                )
            )
        return pairs

    def effective_radii(self):
        """Smallest and largest effective radius [m]."""
        return 0.5 * self.radii[0], self.radii[1] if self.walls else 0.5 * self.radii[1]

    def pair_radii(self):
        """Every effective radius [m] that grains of `classes` can have."""
        pairs = [a * b / (a + b) for a, b in itertools.combinations_with_replacement(self.classes, 2)]
        return sorted({*pairs, *(self.classes if self.walls else ())})

    def kinds(self):
        """Pairs of numbers of kinds of grain, in the order of `contacts`."""
        return list(itertools.combinations_with_replacement(range(len(self.materials)), 2))

    def grains(self):
        """A LIGGGHTS `Grain` for each kind and size: `classes`, or the smallest and the largest."""
        from demlaws.liggghts.export import Grain

        sizes = self.classes or tuple(dict.fromkeys(self.radii))
        return [Grain(r, m, s) for m, s in zip(self.materials, self.surfaces, strict=True) for r in sizes]

    def mass(self, radius):
        """Mass [kg] of the lightest kind of grain whose contact with its like has effective radius `radius` [m]."""
        density = min(2650.0 if m.density is None else m.density for m in self.materials)
        return density * 4.0 / 3.0 * math.pi * (2.0 * np.asarray(radius)) ** 3

    def mean_force(self, pressure, radius):
        """Mean normal force [N] of a packing of grains of one size: p π d²/((1 - porosity) Z) (Rothenburg & Bathurst 1989)."""
        return math.pi * (4.0 * np.asarray(radius)) ** 2 * pressure / ((1.0 - self.porosity) * self.coordination)

    def force_range(self, contact):
        """Smallest and largest normal force [N] that matter, one a contact."""
        ranges = []
        one = np.ones(np.shape(contact.radius))
        if self.force is not None:
            ranges.append((self.force[0] * one, self.force[1] * one))
        if self.loads is not None:
            ranges.append((self.loads.min() * one, self.loads.max() * one))
        if self.pressure is not None:  # forces of a packing: an exponential tail to some 6 means, few below 0.05
            low, high = (self.mean_force(p, contact.radius) for p in self.pressure)
            ranges.append((0.05 * low, 6.0 * high))
        if self.speed:
            # Hertz impact of two grains: (5/4 m v²)^(3/5) k^(2/5) with m the reduced mass
            mass = 0.5 * self.mass(contact.radius)
            peak = (1.25 * mass * self.speed**2) ** 0.6 * (4 / 3 * contact.modulus * np.sqrt(contact.radius)) ** 0.4
            ranges.append((1e-3 * peak if not ranges else peak, peak))
        return np.min([r[0] for r in ranges], axis=0), np.max([r[1] for r in ranges], axis=0)


def _range(value, label, unit):
    pair = [number(v, label, unit) for v in np.ravel(value)]
    if len(pair) == 1:
        pair = [0.01 * pair[0], pair[0]]
    if len(pair) != 2 or pair[0] > pair[1]:
        raise DemlawsError(f"{label} = {value!r}: give the smallest and the largest in {unit}")
    return tuple(pair)


def _from_toml(path):
    try:
        import tomllib
    except ImportError:
        try:
            import tomli as tomllib
        except ImportError as error:
            raise DemlawsError("scene files need Python 3.11 or 'pip install tomli'") from error
    try:
        text = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise DemlawsError(f"cannot read scene {path}: {error.strerror or error}") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise DemlawsError(f"{path}: {error}") from error
    measured = text.pop("measured", None)
    values = {}
    try:
        for key, kind in (("material", Material), ("surface", Surface)):
            given = text.pop(f"{key}s", text.pop(key, None))
            if given is not None:
                values[f"{key}s"] = [kind(**entry) for entry in ([given] if isinstance(given, dict) else given)]
        reference = text.pop("reference", None)
        if isinstance(reference, dict):
            values["reference"] = reference.pop("law", None)
            values["reference_options"] = reference
        elif reference is not None:
            values["reference"] = reference
        scene = Scene(**values, **text)
    except TypeError as error:
        names = ", ".join(f for f in Scene.__dataclass_fields__)
        raise DemlawsError(f"{path}: {str(error).split(') ')[-1]}; a scene's keys are {names}") from None
    if measured is not None:
        scene = scene.with_fit(_fit_measured(scene, measured, path))
    return scene


def _fit_measured(scene, measured, path):
    from demlaws.advice.fit import fit
    from demlaws.granite import read_points

    unknown = set(measured) - {"points", "radius", "laws", "free", "unloading"}
    if unknown or "points" not in measured or "radius" not in measured:
        raise DemlawsError(
            f"{path}: [measured] needs points (a CSV file) and radius (effective, m); may have laws, free, unloading"
        )
    points = read_points(path.parent / measured["points"])
    contact = scene.contacts(number(measured["radius"], "radius", "m"))[0]
    return fit(points, contact, measured.get("laws"), measured.get("unloading"), measured.get("free")).best


# --- what a law does, and how far it is from the reference


class Sample(NamedTuple):
    """Contacts of a scene, each with the largest force that it has carried."""

    contact: Contact
    peak: np.ndarray  # [N]
    weight: np.ndarray  # share of the load distribution


class _Loaded:
    """A law on a sample, loaded to the peak forces."""

    def __init__(self, law, sample, storage=np.float64):
        self.law, self.sample, self.storage = law, sample, storage
        self.top = self.overlap_of(sample.peak)

    def overlap_of(self, force):
        return np.atleast_1d(self.law.overlap(force)).astype(self.storage)

    def state_at(self, top):
        state = self.law.new_state(top.size, self.storage)
        force, stiffness = self.law.evaluate(top.astype(self.storage), state)
        return state, np.asarray(force, float), np.asarray(stiffness, float)

    def unloaded(self, state, force):
        """Overlap at `force` after the peak."""
        if not self.law.state_size:
            return self.overlap_of(force)
        ratio = state.radius_ratio if "radius_ratio" in self.law.state_names else 1.0
        return state.plastic_overlap + np.cbrt(force / (self.law.params.hertz_coefficient * np.sqrt(ratio))) ** 2

    def again(self, overlap, state):
        """Force and stiffness at `overlap` after the peak."""
        force, stiffness = self.law.evaluate(np.asarray(overlap).astype(self.storage), state.copy())
        return np.asarray(force, float), np.asarray(stiffness, float)

    def energies(self, top):
        """Work of loading to `top`, and the part that unloading does not return."""
        work = np.asarray(self.law.energy(np.asarray(top, float)), float)
        if not self.law.state_size:
            return work, np.zeros_like(work)
        state, _, _ = self.state_at(top)
        ratio = state.radius_ratio if "radius_ratio" in self.law.state_names else 1.0
        coefficient = 0.4 * self.law.params.hertz_coefficient * np.sqrt(ratio)
        plastic = np.asarray(state.plastic_overlap, float)
        stored = coefficient * (np.maximum(top - plastic, 0.0) ** 2.5 - np.maximum(-plastic, 0.0) ** 2.5)
        return work, work - stored

    def overlap_of_work(self, work):
        """Overlap at which loading has taken `work`, by bisection."""
        low, high = np.zeros(work.size), np.broadcast_to(np.asarray(self.law.contact.radius, float), work.size).copy()
        if isinstance(self.law, Table):
            high = np.minimum(high, self.law.loading_shape.grid.highest * np.broadcast_to(self.law.length, work.size))
        for _ in range(70):
            middle = 0.5 * (low + high)
            less = np.asarray(self.law.energy(middle)) < work
            low, high = np.where(less, middle, low), np.where(less, high, middle)
        return 0.5 * (low + high)


def error_of(law, reference, sample, quantity, unloads, storage=np.float64):
    """Error of `law` against `reference` for each contact of `sample`, as `QUANTITIES` define it."""
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore", ValidityWarning)
        exact, given = _Loaded(reference, sample), _Loaded(law, sample, storage)
        return _MEASURES[quantity](exact, given, sample, unloads)


def _force_error(exact, given, sample, unloads):
    state, _, _ = exact.state_at(exact.top)
    other, force, _ = given.state_at(exact.top)
    worst = np.abs(force - sample.peak) / sample.peak
    for fraction in FRACTIONS if unloads else ():
        overlap = exact.unloaded(state, fraction * sample.peak)
        true, _ = exact.again(overlap, state)  # below a seating load no overlap carries that force
        force, _ = given.again(overlap, other)
        worst = np.maximum(worst, np.abs(force - true) / sample.peak)
    return worst


def _stiffness_error(exact, given, sample, unloads):
    state, _, stiffness = exact.state_at(exact.top)
    other, _, found = given.state_at(given.top)
    worst = np.abs(found / stiffness - 1.0)
    for fraction in FRACTIONS if unloads else ():
        force = fraction * sample.peak
        stiffness = exact.again(exact.unloaded(state, force), state)[1]
        found = given.again(given.unloaded(other, force), other)[1]
        worst = np.maximum(worst, np.where(stiffness > 0.0, np.abs(found / stiffness - 1.0), 0.0))
    return worst


def _overlap_error(exact, given, sample, unloads):
    state, _, _ = exact.state_at(exact.top)
    other, _, _ = given.state_at(given.top)
    worst = np.abs(given.top / exact.top - 1.0)
    for fraction in (0.0, *FRACTIONS) if unloads else ():
        force = fraction * sample.peak
        worst = np.maximum(worst, np.abs(given.unloaded(other, force) - exact.unloaded(state, force)) / exact.top)
    return worst


def _energy_error(exact, given, sample, unloads):
    work, lost = exact.energies(exact.top)
    found, found_lost = given.energies(given.top)
    worst = np.abs(found / work - 1.0)
    return np.maximum(worst, np.abs(found_lost - lost) / work) if unloads else worst


def _restitution_error(exact, given, sample, unloads):
    work, lost = exact.energies(exact.top)
    found, found_lost = given.energies(given.overlap_of_work(work))
    return np.abs(np.sqrt(np.maximum(1.0 - found_lost / found, 0.0)) - np.sqrt(np.maximum(1.0 - lost / work, 0.0)))


_MEASURES = {
    "force": _force_error,
    "stiffness": _stiffness_error,
    "overlap": _overlap_error,
    "energy": _energy_error,
    "restitution": _restitution_error,
}


def samples(scene, points=_POINTS, random=None):
    """One Sample a pair of kinds of grain: a grid over radii and loads, or random ones (`random`: a numpy Generator)."""
    result = []
    # of sizes that come in classes each pair has a sample, so that each may have a table
    spans = [(r, r) for r in scene.pair_radii()] or [scene.effective_radii()]
    for pair, (low, high) in itertools.product(scene.contacts(spans[0][0]), spans):
        sizes = 1 if low == high else 7
        if random is None:
            radius = np.repeat(np.geomspace(low, high, sizes), points // sizes)
            place = np.tile(np.linspace(0.0, 1.0, points // sizes), sizes)
        else:
            radius = np.exp(random.uniform(math.log(low), math.log(high), points))
            place = random.uniform(0.0, 1.0, points)
        contact = pair.with_values(radius=radius)
        smallest, largest = scene.force_range(contact)
        peak = smallest * (largest / smallest) ** place
        if scene.pressure is not None:  # exponential distribution of forces about the mean, over logarithmic steps
            mean = scene.mean_force(math.sqrt(scene.pressure[0] * scene.pressure[1]), radius)
            weight = peak / mean * np.exp(-peak / mean)
        elif scene.loads is not None:
            edges = np.geomspace(scene.loads.min() * 0.999, scene.loads.max() * 1.001, 30)
            counts = np.histogram(scene.loads, edges)[0].astype(float)
            weight = counts[np.clip(np.searchsorted(edges, peak) - 1, 0, counts.size - 1)]
        else:
            weight = np.ones(peak.size)
        result.append(Sample(contact, peak, weight / weight.sum()))
    return result


# --- candidates


class Plan(NamedTuple):
    """A way to compute the scene's contacts."""

    name: str
    options: tuple  # (name, value) pairs
    unloading: str
    evaluation: str  # "closed form", "table", "closed form, float32"
    rtol: float = 0.0

    @property
    def storage(self):
        return np.float32 if self.evaluation.endswith("float32") else np.float64

    def bind(self, contact, max_force=None):
        """The law on a contact, or an array of contacts."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ValidityWarning)
            law = bind_law(self.name, contact, self.unloading, **dict(self.options))
            return tabulate(law, self.rtol, max_force) if self.evaluation == "table" else law


@dataclass(frozen=True)
class Choice:
    """One candidate, judged."""

    plan: Plan
    error: float  # bound of the scene's quantity over its contacts and loads, against the reference
    mean_error: float  # over the load distribution
    ns: float  # a contact and evaluation, measured alone
    engine_ns: float | None  # a contact and whole step in the scene's engine, measured there; None: not measured
    step_factor: float  # stable time step over the reference's
    step: float  # stable time step of the scene [s]
    state_bytes: int  # a contact
    table_rows: int
    left_out: tuple  # (what, error that it costs)
    meets: bool
    judge: object = field(repr=False)

    name = property(lambda self: self.plan.name)
    unloading = property(lambda self: self.plan.unloading)
    evaluation = property(lambda self: self.plan.evaluation)

    @property
    def cost(self):
        """ns a contact and reference time step: a law that allows longer steps is evaluated less often."""
        return (self.ns if self.engine_ns is None else self.engine_ns) / self.step_factor

    @property
    def branch(self):
        """The branch of the law that is computed, in brackets, if not all."""
        return "".join(f" ({v})" for k, v in self.plan.options if k == "branch")

    def tables(self):
        """Pair of kinds of grain → `Table` of the largest grains (for LIGGGHTS, `export` writes those of all sizes)."""
        scene = self.scene
        rtol = self.plan.rtol or max(1e-5, 0.1 * scene.tolerance)
        plan = self.plan._replace(evaluation="table", rtol=rtol)
        contacts = scene.contacts(scene.effective_radii()[1])
        return {kinds: plan.bind(contact, self.max_force) for kinds, contact in zip(scene.kinds(), contacts, strict=True)}

    def export(self, folder):
        """Write a LIGGGHTS case: this law for every kind and size of grain of the scene, with all the tables it needs."""
        from demlaws.liggghts import export

        own = self.evaluation != "table"  # LIGGGHTS's own Hertz
        options = {"stock": "hertz"} if own else {"rtol": self.plan.rtol}
        return export(
            folder,
            self.name,
            self.scene.grains(),
            self.unloading,
            dict(self.plan.options),
            load=self.max_force / 1.5,
            **options,
        )

    def law(self, contact):
        """The law on your contact (or array of contacts)."""
        return self.plan.bind(contact, self.max_force)

    @property
    def scene(self):
        return self.judge.scene

    @property
    def reference(self):
        """The plan that errors are held against."""
        return self.judge.reference

    @property
    def max_force(self):
        """Largest force [N] of the scene, and half as much again: where a table ends."""
        return self.judge.max_force

    def batch(self, seed=1):
        """Random contacts of the scene in the states that occur, to time."""
        return self.judge.batch(self.plan, seed)

    def describe(self):
        """One line: law, unloading, evaluation."""
        options = ", ".join(f"{k}={v:g}" if isinstance(v, float) else f"{k}={v}" for k, v in self.plan.options)
        rtol = f" (rtol {self.plan.rtol:g})" if self.plan.rtol else ""
        return f"{self.name}{f' ({options})' if options else ''}, {self.unloading}, {self.evaluation}{rtol}"

    def script(self, table="law.tbl"):
        """The lines that put this choice into the scene's engine."""
        options = "".join(f", {k}={v!r}" for k, v in self.plan.options)
        unloading = "" if self.unloading == "elastic" else f', unloading="{self.unloading}"'
        if self.scene.engine == "yade":
            source = f'"{self.name}"'
            if self.evaluation == "table":
                names = [f'("kind{i}", "kind{j}"): "{table_name(table, self.scene, (i, j))}"' for i, j in self.scene.kinds()]
                source = f'"{table}"' if len(names) == 1 else f"{{{', '.join(names)}}}"
            surfaces = ", ".join(
                f'"kind{i}": dl.Surface({s.roughness:g}, {s.fractal_dimension!r}, {s.hardness or m.hardness!r})'
                for i, (m, s) in enumerate(zip(self.scene.materials, self.scene.surfaces, strict=True))
            )
            extra = "" if self.evaluation == "table" else options + unloading
            return (
                "import demlaws as dl\n"
                "from demlaws.yade import Law2_ScGeom_MindlinPhys_Demlaws\n"
                f"# kind0, kind1, …: labels of the scene's materials\n"
                f"law = Law2_ScGeom_MindlinPhys_Demlaws({source}, surfaces={{{surfaces}}}{extra})\n"
                f"# O.dt = {self.step:.3g}"
            )
        if self.scene.engine == "liggghts":
            grains = self.scene.grains()
            types = ", ".join(f"{n + 1}: radius {g.radius:g} m" for n, g in enumerate(grains))
            return f"choice.export(folder), or --out FOLDER, writes the case; types {types}; timestep {self.step:.3g}"
        tail = f".tabulate(rtol={self.plan.rtol:g}, max_force={self.max_force:g})" if self.evaluation == "table" else ""
        kept = "  # state = law.new_state(n, np.float32), overlaps float32" if self.evaluation.endswith("float32") else ""
        return f'law = dl.law("{self.name}", contact{unloading}{options}){tail}{kept}'


def table_name(path, scene, kinds):
    """File of the table of a pair of kinds of grain: the path itself where there is one kind."""
    path = Path(path)
    return path if len(scene.materials) == 1 else path.with_name(f"{path.stem}-{kinds[0]}-{kinds[1]}{path.suffix}")


class Choices(list):
    """Choices, those that meet the tolerance first, the cheapest of them first."""

    def __init__(self, choices, scene, reference, ruled_out, notes, floor, measured_in):
        super().__init__(choices)
        self.scene = scene
        self.reference = reference  # Plan
        self.ruled_out = ruled_out  # text → reason
        self.notes = notes
        self.floor = floor  # ns a contact of a copy kernel
        self.measured_in = measured_in  # what `cost` is of

    @property
    def best(self):
        return self[0]


def reference_plan(scene):
    """The richest law that the scene's quantities determine."""
    rough = any(s.roughness > 0.0 for s in scene.surfaces)
    options = dict(scene.reference_options)
    contact = scene.contacts(scene.effective_radii()[0])[0]
    if scene.reference is not None:
        name = find(scene.reference).name
    else:
        loading = "hertz"
        if rough and contact.fractal_dimension is not None:
            loading = "pohrt-popov"
        elif rough:
            loading = "yip-venart" if contact.hardness is not None else "rms"
        name = loading if scene.yield_pressure is None else "rough-plastic"
        if name == "rough-plastic":
            options = {"yield_pressure": scene.yield_pressure, "loading": loading, **options}
    for rule in (("thornton",) if name == "rough-plastic" else ()) + ("hertz",) if scene.unloads else ():
        try:
            bind_law(name, contact, rule, **options)
            return Plan(name, tuple(options.items()), rule, "closed form")
        except DemlawsError as error:
            if "cannot take" not in str(error):
                raise
    return Plan(name, tuple(options.items()), "elastic", "closed form")


def plans(scene, reference):
    """All candidates, tables aside."""
    options = dict(reference.options)
    named = [(reference.name, reference.options)]
    if reference.name == "rough-plastic":
        own = {k: v for k, v in options.items() if k not in ("yield_pressure", "loading")}
        named.append((options.get("loading", "pohrt-popov"), tuple(own.items())))
    contact = scene.contacts(scene.effective_radii()[0])[0]
    rough = contact.roughness > 0.0
    if rough and contact.fractal_dimension is not None:
        named += [("pohrt-popov", ()), ("pohrt-popov", (("branch", "power"),)), ("pohrt-popov", (("branch", "hertz"),))]
    if rough:
        named.append(("rms", ()))
    named.append(("hertz", ()))
    found = []
    for name, given in dict.fromkeys(named):
        rules = ["elastic"]
        if scene.unloads and name != "hertz":
            rules += ["hertz"] + (["thornton"] if name == "rough-plastic" else [])
        found += [Plan(name, given, rule, "closed form") for rule in rules]
    return list(dict.fromkeys([reference, *found]))


def _range_problem(plan, law, smallest, largest, known):
    """Why the scene leaves the law's range, or None. known: reasons that hold for the reference as well."""
    for limit in law.limits():
        if limit.reason in known:
            continue
        if largest > limit.maximum_force:
            return f"loads reach {largest:.3g} N: above {limit.maximum_force:.3g} N {limit.reason}"
        if smallest < limit.minimum_force:
            return f"loads begin at {smallest:.3g} N: below {limit.minimum_force:.3g} N {limit.reason}"
    return None


_NO_TABLE = (
    "its curve depends on the radius, so that it needs one table for each pair of sizes, and radii is a range: if the grains "
    "come in a few sizes, give them as classes"
)


class _Judge:
    """Errors, step factors and state sizes of plans on one scene."""

    def __init__(self, scene, reference):
        self.scene, self.reference = scene, reference
        self.samples = samples(scene)
        self.largest = max(float(s.peak.max()) for s in self.samples)
        self.smallest = min(float(s.peak.min()) for s in self.samples)
        self.exact = [reference.bind(s.contact) for s in self.samples]
        self.max_force = 1.5 * self.largest
        self.extremes = [c for r in dict.fromkeys(scene.effective_radii()) for c in scene.contacts(r)]
        self.bound = {}

    def laws(self, plan):
        """The plan's laws on the samples, made once."""
        if plan not in self.bound:
            laws = []
            for sample in self.samples:
                one = sample.contact
                if plan.evaluation == "table" and not find(plan.name).collapses:
                    if np.ptp(one.radius) > 0.0:
                        raise DemlawsError(_NO_TABLE)
                    single = one.with_values(radius=float(one.radius[0]))
                    laws.append(plan.bind(single, self._table_end(plan, single)))
                else:
                    laws.append(plan.bind(one, self._table_end(plan, one)))
            self.bound[plan] = laws
        return self.bound[plan]

    def _table_end(self, plan, contact):
        return self.max_force if plan.evaluation == "table" else None

    def error(self, plan, against=None):
        """Largest and mean error of a plan against the reference (or another plan)."""
        worst, mean = 0.0, 0.0
        exact = self.exact if against is None else self.laws(against)
        for sample, other, law in zip(self.samples, exact, self.laws(plan), strict=True):
            error = error_of(law, other, sample, self.scene.quantity, self.scene.unloads, plan.storage)
            if not np.all(np.isfinite(error)):
                return math.inf, math.inf
            worst, mean = max(worst, float(error.max())), max(mean, float(error @ sample.weight))
        return _MARGIN * worst + _ROUNDING, mean

    def step(self, plan):
        """Stable step [s] of the scene: grains of both extreme sizes, half of their contacts on one side."""
        steps = []
        closed = plan._replace(evaluation="closed form", rtol=0.0)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ValidityWarning)
            for contact in self.extremes:
                _, largest = self.scene.force_range(contact)
                stable = timestep(closed.bind(contact), float(self.scene.mass(contact.radius)), float(largest))
                steps.append(stable / math.sqrt(max(self.scene.coordination / 2.0, 1.0)))
        return min(steps)

    def batch(self, plan, seed=1):
        """Random contacts of the scene in the states that occur, for timing."""
        random = np.random.default_rng(seed)
        sample = samples(self.scene, _TIMED, random)[0]
        contact = sample.contact
        if np.ptp(contact.radius) == 0.0:
            contact = contact.with_values(radius=float(contact.radius[0]))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ValidityWarning)
            law = plan.bind(contact, self._table_end(plan, contact))
            top = np.asarray(law.overlap(sample.peak))
            now = (
                top * np.where(random.random(top.size) < 0.3, 1.0, random.uniform(0.3, 1.0, top.size))
                if law.state_size
                else top
            )
            return Batch.of(law, top, now, plan.storage)


def _left_out(judge, plan):
    """What the plan leaves out, in the order yield, history, roughness, evaluation; each with the error that it alone adds."""
    reference = judge.reference
    stages = []

    def stage(what, **changes):
        before = stages[-1][1] if stages else reference
        after = before._replace(**changes)
        if after != before:
            stages.append((what, after, before))

    if reference.name == "rough-plastic" and plan.name != "rough-plastic":
        options = dict(reference.options)
        own = tuple((k, v) for k, v in options.items() if k not in ("yield_pressure", "loading"))
        rule = "hertz" if reference.unloading == "thornton" else reference.unloading
        stage("bulk yield", name=options.get("loading", "pohrt-popov"), options=own, unloading=rule)
    now = stages[-1][1] if stages else reference
    if now.unloading == "thornton" and plan.unloading == "hertz":
        stage("larger radius after yield", unloading="hertz")
        now = stages[-1][1]
    if now.unloading != "elastic" and plan.unloading == "elastic":
        stage("unloading history", unloading="elastic")
        now = stages[-1][1]
    if (now.name, now.options) != (plan.name, plan.options):
        branch = dict(plan.options).get("branch")
        if plan.name == "hertz":
            what = "roughness"
        elif branch and now.name == "pohrt-popov":
            what = {"power": "Hertz stiffness above the threshold", "hertz": "power law below the threshold"}[branch]
        else:
            what = f"{now.name} replaced by {plan.name}"
        stage(what, name=plan.name, options=plan.options, unloading=plan.unloading)
    if plan.evaluation != "closed form":
        what = f"{plan.evaluation} in place of the closed form" if plan.rtol else "double precision in memory"
        stage(what, evaluation=plan.evaluation, rtol=plan.rtol)
    result = []
    for what, after, before in stages:
        try:
            result.append((what, max(judge.error(after, before)[0] - _ROUNDING, 0.0) / _MARGIN))
        except DemlawsError:
            result.append((what, math.nan))
    return tuple(result)


def choose(scene, tables=True):
    """Candidates for a `Scene`, ranked: those that meet its tolerance first, the cheapest of them first (`Choices`).

    Each `Choice` has the predicted bound and mean of the error, measured ns a contact, time-step factor, state bytes, what
    it leaves out at which error, and the law itself. Raises DemlawsError where the scene's quantities do not suffice.
    """
    reference = reference_plan(scene)
    judge = _Judge(scene, reference)
    ruled_out, notes, judged = {}, [], {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ValidityWarning)
        known = set()
        for law in judge.exact:
            for limit in law.limits():
                if judge.largest > limit.maximum_force or judge.smallest < limit.minimum_force:
                    known.add(limit.reason)
                    notes.append(f"the reference itself ({reference.name}) leaves its range: {limit.reason}")
    for plan in plans(scene, reference):
        label = _label(plan)
        try:
            law = judge.laws(plan)[0]
            problem = _range_problem(plan, law, judge.smallest, judge.largest, known)
            if problem and "branch=" not in problem and plan != reference:
                ruled_out[label] = problem
                continue
            judged[plan] = judge.error(plan)
            if scene.engine == "python":
                small = plan._replace(evaluation="closed form, float32")
                added, mean = judge.error(small, plan)  # rounding is random: its extremes show in few of the points
                judged[small] = judged[plan][0] + 2.0 * added, judged[plan][1] + mean
        except DemlawsError as error:
            ruled_out[label] = str(error)
            continue
        try:
            table = _table_for(judge, plan, judged[plan][0]) if tables else None
        except DemlawsError as error:
            ruled_out[_label(plan._replace(evaluation="table"))] = str(error)
            continue
        if table is not None:
            judged[table[0]] = table[1]
    judged = {plan: error for plan, error in judged.items() if _runs_in(plan, scene.engine)}
    if not judged:
        named = {}
        for label, why in ruled_out.items():
            named.setdefault(why, []).append(label.split(",")[0])
        reasons = "; ".join(f"{', '.join(dict.fromkeys(labels))}: {why}" for why, labels in named.items())
        raise DemlawsError(f"no law can serve this scene: {reasons}")
    batches = {}
    for plan in list(judged):
        try:
            batches[plan] = judge.batch(plan)
        except DemlawsError as error:
            ruled_out[_label(plan)] = str(error)
            del judged[plan]
    cost, floor = nanoseconds(batches, rounds=21)
    in_engine, measured_in = _engine_costs(judge, list(judged), notes)
    base = judge.step(reference)
    choices = []
    for plan, (error, mean) in judged.items():
        step = judge.step(plan)
        law = judge.laws(plan)[0]
        choices.append(
            Choice(
                plan,
                error,
                mean,
                cost[plan],
                in_engine.get(plan),
                step / base,
                step,
                len(law.state_names) * np.dtype(plan.storage).itemsize,
                law.nodes.u.size if isinstance(law, Table) else 0,
                (),
                error <= scene.tolerance,
                judge,
            )
        )
    least = min((c.cost for c in choices if c.meets), default=0.0)
    choices.sort(key=lambda c: (not c.meets, *_rank(c, least)))
    choices = [replace(c, left_out=_left_out(judge, c.plan)) for c in choices]
    return Choices(choices, scene, reference, ruled_out, notes, floor, measured_in)


_EQUAL = 1.03
"""Costs of steps in an engine that differ by less are measured as equal: then the law's own cost decides."""


def _rank(choice, least):
    if not choice.meets:
        return (choice.error,)
    if choice.engine_ns is None:
        return (choice.cost,)
    return int(math.log(choice.cost / least, _EQUAL)), choice.ns / choice.step_factor


def _engine_costs(judge, plans, notes):
    """Plan → ns a contact and step, measured in the scene's engine (nothing where it cannot be), and what that is of."""
    from demlaws.liggghts.export import Grain
    from demlaws.measure.costs import available, liggghts_costs, yade_costs
    from demlaws.measure.packings import Way

    scene, alone = judge.scene, "the law alone"
    if scene.engine == "python":
        return {}, alone
    name = {"yade": "YADE", "liggghts": "LIGGGHTS"}[scene.engine]
    problem = available(scene.engine)
    if problem is None:
        contact = scene.contacts(scene.effective_radii()[1])[0]
        radius = scene.radii[1]
        if not scene.walls:
            contact = scene.contacts(0.5 * radius)[0]
        low, high = (float(v) for v in scene.force_range(contact))
        material, surface = scene.materials[0], scene.surfaces[0]
        given = {
            "young": material.young,
            "poisson": material.poisson,
            "density": 2650.0 if material.density is None else material.density,
            "surface": {**vars(surface), "hardness": contact.hardness},
            "radius": radius,
            "overlap": float(judge.reference.bind(contact).overlap(math.sqrt(low * high))),
        }
        ways = []
        for plan in plans:
            own = scene.engine == "liggghts" and plan.evaluation != "table"
            law = "" if own else plan.name
            ways.append(Way(_label(plan), law, plan.unloading, plan.rtol, "hertz" if own else "", plan.options))
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", ValidityWarning)
                if scene.engine == "yade":
                    costs = yade_costs(ways, given, scene.contacts(0.5 * radius)[0])
                else:
                    grains = [Grain(r, material, surface) for r in (radius, 1.01 * radius)]
                    given |= {"contact": scene.contacts(0.5 * radius)[0], "grains": grains}
                    costs = liggghts_costs(ways, given)
            return {plan: cost.step for plan, cost in zip(plans, costs, strict=True)}, f"a step of {name}"
        except DemlawsError as error:
            problem = str(error)
    notes.append(f"the cost in {name} could not be measured ({problem}): ranked by the cost of the law alone")
    return {}, alone


def _label(plan):
    options = ", ".join(f"{k}={v}" for k, v in plan.options if k == "branch")
    return f"{plan.name}{f' ({options})' if options else ''}, {plan.unloading}, {plan.evaluation}"


def _runs_in(plan, engine):
    """LIGGGHTS computes tables, and Hertz by its own model; YADE computes any law, in double precision."""
    if engine == "liggghts":
        return plan.evaluation == "table" or (plan.name == "hertz" and plan.evaluation == "closed form")
    return engine == "python" or not plan.evaluation.endswith("float32")


def _table_for(judge, plan, closed_error):
    """The smallest table of a plan that still meets the tolerance (of one that does not: the one that adds a tenth)."""
    if plan.name == "hertz" or dict(plan.options).get("branch"):  # their closed forms cost less than any table
        return None
    target = judge.scene.tolerance if closed_error < judge.scene.tolerance else 1.1 * closed_error
    for rtol in _TABLE_STEPS:
        if rtol < 1e-5 or (find(plan.name).solved and rtol < 1e-5):
            continue
        table = plan._replace(evaluation="table", rtol=rtol)
        try:
            found = judge.error(table)
        except DemlawsError as error:
            if "radii" in str(error) or "cannot take" in str(error):
                raise
            continue
        if found[0] <= target:
            return table, found
    return None
