"""The extremes inside the engines: two spheres on prescribed paths and a thousand spheres let go.

Forces of an engine are compared step by step with the same law in Python, at the overlap that the engine's own
arithmetic makes of the positions. The smallest overlap two spheres can have is the spacing of doubles at R1 + R2, since
engines take it as (R1 + R2) - distance: some 2e-16 of the larger sphere; none below exists inside an engine.

Engines are driven through `yade_extremes.Yade` (in YADE's process) and `plugin_extremes.Plugin` (LIGGGHTS and LAMMPS); both
offer `two_spheres`, `let_go` and `stopped_by`.
"""

import itertools
import math
import pickle
from typing import NamedTuple

import numpy as np

from demlaws.contact import DENSITY, Contact
from demlaws.core.loops import loading_part
from demlaws.core.unloading import GIVEN
from demlaws.errors import quiet
from demlaws.laws.registry import registry
from demlaws.make import law as bind_law
from demlaws.timestep import timestep
from studies.engines import under_yade
from studies.extremes import stability
from studies.extremes.stability import DIMENSIONS, EPS, GRANITE, Case

MODULI = (2e3, 1e6, 32.32e9, 1e13)  # [Pa]
# roughness of each of two like spheres [m], and the effective radii [m] that it goes with: σ/R from 0 to a tenth
SURFACES = ((0.0, (1e-6, 1e-3, 1.0)), (1e-7, (1.5e-6, 1e-4, 1e-2)), (1e-4, (1.5e-3, 0.1, 1.0)))
LARGEST_SPHERE = 2.5  # [m]
RATIOS = (1.0, 30.0, 1e3, 1e6)  # of the radii
TOPS = (1e-9, 1e-6, 1e-3, 0.1, 1.0)  # of the largest overlap
KINDS = ("ladder", "kink", "again", "broken")
# of a packing's energy, at a thirtieth of dl.timestep: a step across the kink at a contact's maximum overlap costs up to
# (ω dt)²/4 of the energy in it
DRIFT = 5e-4
PACKINGS = {"soft": (1e5, 0.0, 1e6), "stiff": (1e13, 0.1, 100.0)}  # E* [Pa], σ over the smallest R, ratio of the radii


class Group(NamedTuple):
    """Pairs of like spheres that share a law; arrays with one entry per pair, SI units."""

    case: Case
    law: object  # a Law or Table over these contacts: the reference
    closed_form: object  # the Law
    radius1: np.ndarray
    radius2: np.ndarray
    modulus: np.ndarray  # effective
    roughness: np.ndarray  # of each sphere
    largest: np.ndarray  # overlap

    @property
    def floor(self):
        """Overlap [m] below which a Python table goes on straight, where the engines' reader keeps to its power law."""
        if self.case.evaluation != "table":
            return 0.0
        return loading_part(self.law.shape).grid.floor * loading_part(self.law.params).length

    @property
    def size(self):
        """Number of pairs."""
        return self.radius1.size

    @property
    def contact(self):
        """The pairs as an array of contacts."""
        return self.law.contact

    @property
    def quantum(self):
        """Smallest overlap that positions in double precision can make [m]."""
        return np.spacing(self.radius1 + self.radius2)


def make_group(case, contact, radius1, radius2, roughness):
    """A `Group` of these contacts; in a table's case the table reaches nearly to R."""
    law, closed_form = case.bind(contact, 0.9), case._replace(evaluation="closed form").bind(contact)
    solved, table = registry()[case.law].solved, case.evaluation == "table"
    # beyond R laws are undefined, and positions round
    share = 0.098 if solved else 0.85 if table else 1.0 - 1e-6
    largest = np.broadcast_to(np.asarray(contact.radius, float), radius1.shape) * share
    modulus = np.broadcast_to(np.asarray(contact.modulus, float), radius1.shape).copy()
    return Group(case, law, closed_form, radius1, radius2, modulus, roughness, largest)


def groups(case, random, quick=False):
    """Pairs at the extremes that the law takes: radius ratios to 1e6, E* 2e3 to 1e13 Pa, σ 0 to R/10, Df 2 to 3."""
    definition = registry()[case.law]
    table = case.evaluation == "table"
    if case.one_contact:
        radius = np.full(12, 2.0 * GRANITE.radius)  # two equal spheres of half the granite pair's roughness squared each
        return [make_group(case, GRANITE, radius, radius, np.full(12, GRANITE.sigma / math.sqrt(2.0)))]
    found = []
    dimensions = DIMENSIONS if "fractal_dimension" in definition.loading.needs else (GRANITE.fractal_dimension,)
    for dimension in dimensions[:: 2 if quick and len(dimensions) > 1 else 1]:
        rows = []
        for sigma, radii in SURFACES:
            if table and definition.length == "roughness" and sigma == 0.0:
                continue  # a curve over δ/σ has no smooth contact: such a pair takes the table of `hertz`
            for radius in radii:
                for modulus in MODULI[:: 3 if quick else 1]:
                    rows.append((sigma, radius, modulus, min(RATIOS[len(rows) % 4], 0.4 * LARGEST_SPHERE / radius)))
        sigma, radius, modulus, ratio = np.array(rows).T
        order = random.permutation(sigma.size)
        sigma, radius, modulus, ratio = sigma[order], radius[order], modulus[order], np.maximum(ratio[order], 1.0)
        first, second = radius * (1.0 + 1.0 / ratio), radius * (1.0 + ratio)
        contact = Contact(first * second / (first + second), modulus, np.hypot(sigma, sigma), dimension, GRANITE.hardness)
        found.append(make_group(case, contact, first, second, sigma))
    return found


def _kinks(group, pair):
    contact, definition = group.contact, registry()[group.case.law]
    if contact.size is not None:
        contact = contact.with_values(**{n: float(getattr(contact, n)[pair]) for n in ("radius", "modulus", "sigma")})
    options = group.case.options
    places = definition.loading.kinks(bind_law(group.case.law, contact, **options).params, **options)
    return [float(k) for k in places if 10.0 * group.quantum[pair] < k < 0.9 * group.largest[pair]]


def path(kind, top, quantum, *, far, steps, random, kink=0.0):
    """Prescribed overlaps [m]: below 0 apart. `far` is a distance at which engines forget the pair."""
    if kind == "ladder":  # up and down a ladder of all decades, with rungs close to the top
        rungs = np.append(np.geomspace(4.0 * quantum, top, 24), top * (1.0 - 10.0 ** -np.arange(1.0, 15.0)))
        rungs = np.concatenate([[-0.3 * top], np.unique(rungs[rungs > 0.0])])
        sense = np.cumprod(np.where(random.random(steps) < 0.15, -1, 1))
        walk = np.cumsum(sense) % (2 * rungs.size - 2)  # up to the last rung and down again
        return rungs[np.minimum(walk, 2 * rungs.size - 2 - walk)]
    if kind == "kink":
        return kink + quantum * random.integers(-3, 4, steps)
    if kind == "again":
        return np.resize([top, 0.7 * top, top, top - quantum, top, 0.01 * top, top, top - 4.0 * quantum, top], steps)
    if kind == "broken":
        gaps = [quantum, 0.5 * top, far / 30.0, far]
        return np.resize([x for gap in gaps for x in (top, -gap, 0.3 * top, -gap)], steps)
    raise ValueError(kind)


def paths(group, steps, random):
    """Prescribed overlaps [steps, pairs] and the kind of each pair's path."""
    columns, kinds = [], []
    for pair in range(group.size):
        kind = KINDS[pair % len(KINDS)]
        kinks = _kinks(group, pair) if kind == "kink" else []
        if kind == "kink" and not kinks:
            kind = "ladder"
        top = float(group.largest[pair] * TOPS[pair // len(KINDS) % len(TOPS)])
        top = max(top, min(100.0 * float(group.quantum[pair]), float(group.largest[pair])))
        if kind == "ladder":
            top = float(group.largest[pair]) * (1.0, 1e-3)[pair // 8 % 2]
        far = 3.0 * float(group.radius1[pair] + group.radius2[pair])
        kink = kinks[pair // len(KINDS) % len(kinks)] if kinks else 0.0
        columns.append(path(kind, top, float(group.quantum[pair]), far=far, steps=steps, random=random, kink=kink))
        kinds.append(kind)
    return np.array(columns).T, np.array(kinds)


class Compared(NamedTuple):
    """Engine against law along prescribed paths."""

    not_finite: int
    to_law: float  # worst relative error of the force of first loading against the law's closed form
    decades: dict  # decade of δ/R → the same against the law or table that the engine was given, in ε
    later: float  # worst error on unloading and reloading over the largest force so far, in ε
    reload: float  # force at exactly the overlap of before, in ε
    broken: int  # contacts closed again whose force is not that of a new contact

    @classmethod
    def joined(cls, parts):
        """Of several groups of pairs: counts add up, of errors the worst counts."""
        columns = dict(zip(cls._fields, zip(*parts, strict=True), strict=True))
        errors = columns.pop("decades")
        decades = {d: max(one.get(d, 0.0) for one in errors) for d in set().union(*errors)}
        counts = ("not_finite", "broken")
        return cls(decades=decades, **{n: (sum if n in counts else max)(values) for n, values in columns.items()})


def compare(group, kinds, overlap, force):
    """`Compared` of what an engine did. Forces below 1e-290 N count as equal: an engine's coefficients underflow there."""
    steps, pairs = overlap.shape
    state, closed_form = group.law.new_state(pairs), group.closed_form
    expected, exact = np.empty_like(overlap), np.empty_like(overlap)
    for n in range(steps):
        expected[n], _ = group.law.evaluate(overlap[n], state)
        exact[n], _ = closed_form.evaluate(overlap[n], closed_form.new_state(pairs))
    finite = np.isfinite(force)
    wrong, wrong_by_law = (np.where(finite, np.abs(force - x), 0.0) for x in (expected, exact))
    apart = overlap <= 0.0
    peak, life = np.zeros_like(overlap), np.zeros_like(overlap)
    peak_now, most = np.zeros(pairs), np.zeros(pairs)
    for n in range(steps):
        peak_now = np.where(apart[n], 0.0, np.maximum(peak_now, expected[n]))
        peak[n] = peak_now
        life[n] = most  # largest overlap before this step
        most = np.where(apart[n], 0.0, np.maximum(most, overlap[n]))
    first = ~apart & (overlap >= life) & (exact > 1e-290)
    held = overlap >= group.floor
    first &= held
    to_law = float(np.max(wrong_by_law[first] / exact[first], initial=0.0))
    radius = np.broadcast_to(np.asarray(group.contact.radius, float), (pairs,))
    decade = np.floor(np.log10(np.where(apart, 1.0, overlap) / radius)).astype(int)
    relative = np.where(first, wrong / np.where(first, expected, 1.0), 0.0) / EPS
    decades = {int(d): float(relative[first & (decade == d)].max()) for d in np.unique(decade[first])}
    rest = ~apart & ~first & held & (peak > 1e-290)
    later = float(np.max(wrong[rest] / peak[rest], initial=0.0)) / EPS
    stray = int(np.count_nonzero(apart & (force != 0.0)))  # a force between bodies that do not touch
    reload = 0.0
    for k in np.flatnonzero((kinds == "again") & (force[0] > 0.0)):
        same = overlap[:, k] == overlap[0, k]
        reload = max(reload, float(np.max(np.abs(force[same, k] / force[0, k] - 1.0))) / EPS)
    made = (kinds == "broken") & held & ~apart  # at two overlaps in turn, the larger first
    usual = np.where(overlap == overlap[0], force[0], force[2])
    anew = int(np.count_nonzero(made & ((force != usual) | (wrong_by_law > 1e-4 * exact))))
    return Compared(int(np.count_nonzero(~finite)), to_law, decades, later, reload, anew + stray)


# --- a thousand spheres


class Packing(NamedTuple):
    """Spheres in a periodic cube that overlap at the start."""

    case: Case
    law: object  # of the smallest sphere with the largest
    table: object  # the law or table of all pairs
    radius: np.ndarray
    mass: np.ndarray
    position: np.ndarray
    speed: np.ndarray  # up to which each sphere is thrown
    side: float
    modulus: float
    roughness: float  # of each sphere
    dt: float

    def velocities(self, random):
        """Random velocities [m/s]: of equal energy, so that small spheres count in the balance."""
        direction = random.normal(size=(self.radius.size, 3))
        return direction * (self.speed * random.random(self.radius.size) / np.linalg.norm(direction, axis=1))[:, None]


def packing(case, name, count=1000, *, speed=100.0, share=30.0, seed=7):
    """Spheres with radii from 2 mm down, even in their logarithm, each overlapping one placed before it.

    All have the same energy to spend. The smallest has `speed`, or as much as its contact with the largest takes within
    R/5; it overlaps by up to R/20. Time step: `dl.timestep` of that contact over `share`. Laws without one curve get equal
    granite spheres.
    """
    random = np.random.default_rng(seed)
    definition = registry()[case.law]
    modulus, rough, ratio = PACKINGS[name]
    largest = 2e-3
    single = case.one_contact
    if single:
        modulus, ratio, largest = GRANITE.modulus, 1.0, 2.0 * GRANITE.radius
    radius = largest * ratio ** -np.sort(random.random(count))
    radius[-1] = largest / ratio
    smallest = float(radius[-1])
    sigma = GRANITE.sigma if single else rough * smallest / 2.0
    if case.evaluation == "table" and definition.length == "roughness":
        sigma = max(sigma, 1e-4 * smallest)  # a curve over δ/σ has no smooth contact
    position = _cluster(radius, random)
    side = float(np.ptp(position, axis=0).max() + 4.0 * largest)
    position = position - position.min(axis=0) + 2.0 * largest
    mass = DENSITY * 4.0 / 3.0 * math.pi * radius**3
    effective = radius[-1] * radius[0] / (radius[-1] + radius[0])
    contact = Contact(effective, modulus, sigma, GRANITE.fractal_dimension, GRANITE.hardness)
    if single:
        contact = GRANITE
    closed = case._replace(evaluation="closed form").bind(contact)
    depth = 0.06 if definition.solved else 0.2
    with quiet():
        bearable = math.sqrt(2.0 * float(closed.energy(depth * effective)) / mass[-1])
        speed = min(speed, 0.6 * bearable)  # two such spheres meet
        force = float(closed.force(depth * effective))
        dt = timestep(closed, float(mass[-1]), force, other_mass=math.inf, shear_ratio=0.0) / share
    speeds = speed * np.sqrt(mass[-1] / mass)
    table = case.bind(contact, 0.9)
    return Packing(case, closed, table, radius, mass, position, speeds, side, modulus, sigma / math.sqrt(2.0), dt)


def _cluster(radius, random, deepest=0.05):
    """Positions of spheres that each overlap an earlier one: by `deepest` R where two of the smallest meet, larger ones so
    that their Hertz contacts hold the same energy. No two overlap further."""
    position, smallest = np.zeros((radius.size, 3)), 0.5 * radius[-1]
    for n in range(1, radius.size):
        effective = radius[:n] * radius[n] / (radius[:n] + radius[n])
        allowed = deepest * smallest * (smallest / effective) ** 0.2
        while True:
            partner = random.integers(n)
            direction = random.normal(size=3)
            gap = radius[n] + radius[partner] - random.random() * allowed[partner]
            centre = position[partner] + gap * direction / np.linalg.norm(direction)
            overlap = radius[:n] + radius[n] - np.linalg.norm(position[:n] - centre, axis=1)
            if np.all(overlap <= allowed):
                break
        position[n] = centre
    return position


class Released(NamedTuple):
    """A packing let go and shaken."""

    contacts: int  # most at one time
    not_finite: int
    drift: float  # largest departure of kinetic + stored + dissipated energy from that at the start of its stretch, over it
    momentum: float  # change of momentum over the sum of its parts


def release(engine, case, name, *, count=1000, steps=4000, every=100, shakes=3):
    """Let a `packing` go; `shakes` times on the way every velocity is drawn again, which starts a new balance."""
    made = packing(case, name, count)
    random = np.random.default_rng(11)
    stretches = [made.velocities(random) for _ in range(shakes + 1)]
    found = engine.let_go(made, stretches, steps // (shakes + 1), every)
    bad, drift, momentum, most = 0, 0.0, 0.0, 0
    for velocity, rows in zip(stretches, found, strict=True):
        parts = float(np.sum(made.mass * np.linalg.norm(velocity, axis=1)))
        start = rows[0]
        first = start.kinetic + start.stored + start.dissipated
        for row in rows:
            total = row.kinetic + row.stored + row.dissipated
            if not (math.isfinite(total) and np.all(np.isfinite(row.momentum))):
                bad += 1
                continue
            drift = max(drift, abs(total / first - 1.0))
            momentum = max(momentum, float(np.linalg.norm(row.momentum - start.momentum)) / parts)
            most = max(most, row.contacts)
    return Released(most, bad, drift, momentum)


# --- one case


class Figures(NamedTuple):
    """What `measure` found of one law and rule inside an engine."""

    engine: str
    law: str
    unloading: str
    evaluation: str
    pairs: int
    steps: int
    compared: Compared
    packings: dict  # name → Released


def cases(laws=None, unloadings=None, evaluation="closed form"):
    """The cases of `stability.cases` in the evaluation that the engine has."""
    # a case is two names, and rule "table" has a law besides: its paths in the engines are in their tests
    return [c for c in stability.cases(laws, unloadings, (evaluation,)) if c.unloading != GIVEN]


def measure(engine, case, quick=False, seed=5):
    """All figures of one law and unloading rule inside `engine`."""
    random = np.random.default_rng(seed)
    steps = 120 if quick else 600
    with quiet():
        parts, pairs = [], 0
        for group in groups(case, random, quick):
            prescribed, kinds = paths(group, steps, random)
            overlap, force = engine.two_spheres(group, prescribed)
            parts.append(compare(group, kinds, overlap, force))
            pairs += group.size
        size = {"count": 200, "steps": 400} if quick else {}
        chosen = list(PACKINGS)[-1:] if case.one_contact else PACKINGS
        packings = {name: release(engine, case, name, **size) for name in chosen}
        return Figures(engine.name, *case, pairs, steps, Compared.joined(parts), packings)


# --- all cases


def results(engine, request):
    """`Figures` of each case of `request`, then what stops the engine if that is asked."""
    for case in request["cases"]:
        yield measure(engine, Case(*case, engine.evaluation), request["quick"])
    if request["stops"]:
        yield stops(engine)


def stops(engine):
    """The engine's reaction to NaN and infinity: (what was done, message or None) of touching and lone spheres."""
    names = {"nan": "NaN", "inf": "infinite"}
    return [
        (f"{names[value]} {where}, {'touching' if touching else 'alone'}", engine.stopped_by(touching, where, value))
        for touching, value, where in itertools.product((True, False), names, ("position", "velocity"))
    ]


ENGINES = ("YADE", "LIGGGHTS", "LAMMPS")


def run(engine, laws=None, unloadings=None, *, quick=False, stops=True, progress=lambda found: None):
    """Measure inside an engine, one of `ENGINES`: a list of `Figures`, then what stopped it; progress: called with each.

    The last item, if `stops`, is a list of (what was done to a body, the message or None).
    """
    from studies.extremes.plugin_extremes import Plugin

    request = {"cases": [case[:2] for case in cases(laws, unloadings)], "quick": quick, "stops": stops}
    found = []

    def ended(result):
        found.append(result)
        progress(result)

    if engine == "YADE":
        under_yade("extremes/yade_extremes.py", request, lambda text: ended(pickle.loads(bytes.fromhex(text))))
    else:
        for result in results(Plugin(engine), request):
            ended(result)
    return found
