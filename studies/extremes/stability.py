"""The extremes, measured: every law × unloading rule × evaluation, on paths and contacts that scenes seldom reach.

Each figure is a number that should be 0, or a few ε = 2.2e-16, or inside a stated range; `table` prints them in the manner
of Boost.Math's accuracy tables. References for rounding errors are the laws' closed forms in extended precision
(`exact`), written from the equations and not from the kernels.
"""

import math
from typing import NamedTuple

import numpy as np

from demlaws.contact import Contact
from demlaws.core import dispatch
from demlaws.core.dispatch import gather, scatter
from demlaws.core.loops import loading_part, params_at
from demlaws.core.numba_compat import loop
from demlaws.core.unloading import GIVEN
from demlaws.driver import elastic_contact, impact_loop
from demlaws.errors import DemlawsError, quiet
from demlaws.granite import find_test
from demlaws.laws.registry import registry
from demlaws.make import example_law
from demlaws.timestep import timestep
from studies.extremes.exact import EXACT
from studies.extremes.paths import finite_loop, path_loop

EPS = float(np.finfo(float).eps)
DIMENSIONS = (2.0, 2.22, 3.0)
SPEEDS = tuple(np.geomspace(1e-6, 100.0, 9))
STEPS = (5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10_000, 100_000)
ALLOWED_GAIN = 1e-4
TABLE = 1e-5
POISSON = 0.25  # of every sphere: LIGGGHTS's tangential model needs a shear modulus
GRANITE = find_test("SS(18-18)").contact
_MASS = 1.2e-2  # kg, of a granite sphere of twice that radius


class Balance(NamedTuple):
    """Energy [J], momentum [kg m/s] and number of contacts of a packing at one time."""

    kinetic: float
    stored: float
    dissipated: float
    momentum: np.ndarray
    contacts: int


class Case(NamedTuple):
    """What is put to the test."""

    law: str
    unloading: str
    evaluation: str  # "closed form" or "table"

    @property
    def options(self):
        """Options that the law is made with."""
        return registry()[self.law].drawing.example

    @property
    def one_contact(self):
        """Whether there is one curve for one contact only: the case is measured on the granite pair."""
        definition = registry()[self.law]
        return definition.solved or (self.evaluation == "table" and not definition.collapses)

    def bind(self, contact, table_end=None):
        """The law on a contact or an array of contacts; as a table one that reaches `table_end` times each of their radii."""
        with quiet():
            if self.evaluation == "closed form":
                return example_law(self.law, contact, self.unloading)
            law = example_law(self.law, _longest(contact), self.unloading)
            share = 0.099 if registry()[self.law].solved else table_end  # solved curves end at a tenth of the radius
            end = None if table_end is None else float(np.max(law.force(share * np.asarray(law.contact.radius))))
            table = law.tabulate(TABLE, end)
            return table if contact.size is None else table.bound_to(contact)


def _longest(contact):
    """Of an array of contacts the one whose radius is the most multiples of its roughness."""
    if contact.size is None:
        return contact
    columns = {name: np.broadcast_to(getattr(contact, name), contact.size) for name in ("radius", "modulus", "sigma")}
    index = int(np.argmax(columns["radius"] / np.maximum(columns["sigma"], 1e-300)))
    return contact.with_values(**{name: float(column[index]) for name, column in columns.items()})


def cases(laws=None, unloadings=None, evaluations=("closed form", "table")):
    """Every law that needs no height map, with each rule that it takes, in closed form and as a table."""
    found = []
    for name, definition in registry().items():
        if definition.needs_map or (laws and name not in laws):
            continue
        for rule in unloadings or definition.offered():
            try:
                example_law(name, GRANITE, rule)
            except DemlawsError:
                continue
            found += [Case(name, rule, evaluation) for evaluation in evaluations]
    return found


def extreme_contacts(count, random, dimension=GRANITE.fractal_dimension):
    """Contacts with R from 1e-6 to 1 m and radius ratios to 1e6, E* from 2e3 to 1e13 Pa, σ from 0 to R/10."""
    one = 10.0 ** random.uniform(-6.0, 0.0, count)
    radius = 1.0 / (1.0 / one + 1.0 / (one * 10.0 ** random.uniform(0.0, 6.0, count)))
    roughness = radius * 10.0 ** random.uniform(-15.0, -1.0, count)
    roughness[::10] = 0.0
    roughness[1::10] = 0.1 * radius[1::10]
    modulus = 10.0 ** random.uniform(3.3, 13.0, count)
    return Contact(radius, modulus, roughness, dimension, GRANITE.hardness)


def contacts_for(case, count, random):
    """Laws on extreme contacts; where the law refuses extremes, on the granite pair."""
    definition = registry()[case.law]
    if case.one_contact:
        return [case.bind(GRANITE, 0.9)]
    result = []
    for dimension in DIMENSIONS if "fractal_dimension" in definition.loading.needs else (GRANITE.fractal_dimension,):
        contact = extreme_contacts(count, random, dimension)
        if case.evaluation == "table":  # one curve for all; a table that scales with roughness has no smooth contacts
            contact = contact.with_values(sigma=np.maximum(contact.sigma, 1e-12 * contact.radius))
            if definition.length == "roughness":
                contact = contact.with_values(sigma=np.maximum(contact.sigma, 1e-5 * contact.radius))
        result.append(case.bind(contact, 0.9 if case.evaluation == "table" else None))
    return result


# --- compiled measurements


@loop
def cycle_loop(rule, shape, p, state, top, bottom, cycles):
    """Tiny cycles from `top` to `bottom` and back: largest relative change of force, at both ends, and the last state."""
    s = gather(state, 0)
    first, _, s = dispatch.step(rule, shape, p, top, s)
    low, _, s = dispatch.step(rule, shape, p, bottom, s)
    worst = 0.0
    for _ in range(cycles):
        force, _, s = dispatch.step(rule, shape, p, top, s)
        worst = max(worst, abs(force - first))
        force, _, s = dispatch.step(rule, shape, p, bottom, s)
        worst = max(worst, abs(force - low))
    scatter(state, 0, s)
    return worst / first


@loop
def broken_loop(rule, shape, p, state, overlap, count):
    """Contact made and broken every step: how often force or stiffness differ from those of a new contact."""
    first, stiff, _ = dispatch.step(rule, shape, p, overlap, gather(state, 0))
    s = gather(state, 0)
    differ = 0
    for _ in range(count):
        force, stiffness, s = dispatch.step(rule, shape, p, overlap, s)
        differ += force != first or stiffness != stiff
        force, stiffness, s = dispatch.step(rule, shape, p, -overlap, s)
        differ += force != 0.0 or stiffness != 0.0
    return differ


@loop
def hold_loop(rule, shape, p, state, mass, load, overlap, kick, dt, steps, limit):
    """Oscillation about equilibrium under a constant load: largest departure over the first one; ends beyond `limit`."""
    s = gather(state, 0)
    x = overlap + kick
    force, _, s = dispatch.step(rule, shape, p, x, s)
    velocity = 0.0
    largest = 0.0
    for _ in range(steps):
        velocity += 0.5 * dt * (load - force) / mass
        x += dt * velocity
        force, _, s = dispatch.step(rule, shape, p, x, s)
        velocity += 0.5 * dt * (load - force) / mass
        largest = max(largest, abs(x - overlap))
        if largest > limit * abs(kick):
            break
    return largest / abs(kick)


def rounding_by_decade(case, count=20_000, seed=3):
    """Worst relative error of the force in ε by decade of δ/σ (δ/R for laws without roughness): {decade: error}.

    None where there is no reference (`EXACT`), and of a table.
    """
    definition = registry()[case.law]
    if np.finfo(np.longdouble).eps > 1e-18 or case.law not in EXACT or case.evaluation == "table":
        return None
    random = np.random.default_rng(seed)
    radius = 10.0 ** random.uniform(-6.0, 0.0, count)
    modulus = 10.0 ** random.uniform(5.0, 12.0, count)
    sigma = radius * 10.0 ** random.uniform(-9.0, -2.0, count)
    decade = random.integers(-9, 7, count)
    length = sigma if definition.length == "roughness" else radius
    overlap = length * 10.0 ** (decade + random.random(count))
    keep = overlap < radius
    overlap, decade = overlap[keep], decade[keep]
    with quiet():
        contact = Contact(radius[keep], modulus[keep], sigma[keep], GRANITE.fractal_dimension, GRANITE.hardness)
        exact, _ = EXACT[case.law](contact, overlap, **case.options)
        force = case.bind(contact).force(overlap)
    error = np.abs((force.astype(np.longdouble) - exact) / exact).astype(float) / EPS
    return {int(d): float(error[decade == d].max()) for d in np.unique(decade)}


# --- one case, all figures


class Figures(NamedTuple):
    """What `measure` found for one case."""

    law: str
    unloading: str
    evaluation: str
    paths: int
    not_finite: int  # values on paths and first loadings: NaN, infinite or negative
    falling: int  # forces that fall as the overlap grows
    returned: int  # paths that return work
    worst_return: float  # work returned over the largest energy held (rounding: some ε)
    rounding: dict | None  # worst relative error of force in ε by decade of overlap
    ratcheting: float  # relative change of force over the tiny cycles
    kink: float  # jump of force across a kink, in ε
    reload: float  # force at exactly the maximum against the first time, in ε; one ulp below it in ε × 1.5 δ/δ_H
    broken: int  # steps at which a contact closed again differs from a new one
    gains: dict  # steps per contact → largest energy gain per impact
    safe_steps: float  # steps per contact from which on the gain stays below 1e-4
    step_ratio: tuple  # dl.timestep over the measured stable step: smallest and largest over contacts


def measure(case, paths=100_000, cycles=1_000_000, seed=1, quick=False):
    """All figures of one case. paths: random load paths; cycles: tiny cycles; quick: fewer impacts and contacts."""
    random = np.random.default_rng(seed)
    bad = falling = returned = done = 0
    worst = 0.0
    with quiet():
        laws = contacts_for(case, 1000, random)
        for law in laws:
            count = law.contact.size or 1
            radius = np.broadcast_to(np.asarray(law.contact.radius, float), count).copy()
            largest = radius * (0.098 if registry()[case.law].solved else 0.5 if case.evaluation == "table" else 1.0)
            share = paths // len(laws)
            b, f = finite_loop(law.shape, law.params, count, largest, max(share, 20_000), random)
            state = law.new_state(1).arrays
            deepest = np.minimum(0.5 * largest, _first_kinks(law, case, radius))
            r, w, b2 = path_loop(law.rule_tag, law.shape, law.params, state, count, 1e-25 * radius, deepest, share, 12, random)
            bad, falling, returned, done = bad + b + b2, falling + f, returned + r, done + share
            worst = min(worst, w)
        singles = _single_contacts(case)[: 1 if quick else 3]
        ratchet = max(_ratcheting(law, cycles // len(singles)) for law in singles)
        kink = max(_kink(law) for law in singles)
        again = max(_reload(law) for law in singles)
        broken = sum(
            broken_loop(law.rule_tag, law.shape, law.params, law.new_state(1).arrays, float(share * law.contact.radius), 1000)
            for law in singles
            for share in (1e-12, 1e-7, 1e-3)
        )
        gains = impact_gains(singles[0], SPEEDS[::4], (20, 50, 1000), 3) if quick else impact_gains(singles[0])
        ratios = [r for law in singles for r in step_ratios(law)]
        return Figures(
            *case,
            done,
            bad,
            falling,
            returned,
            -worst,
            rounding_by_decade(case),
            ratchet,
            kink,
            again,
            int(broken),
            gains,
            safe_steps(gains),
            (min(ratios), max(ratios)),
        )


def _first_kinks(law, case, radius):
    """Overlaps [m] at which contacts first yield beyond R/10, where no law holds and pairs are not promised to be passive."""
    if case.evaluation == "table" or law.contact.size is None:
        return np.full(radius.size, np.inf)
    kinks = law.definition.loading.kinks
    found = (kinks(loading_part(params_at(law.params, i)), **law.options) for i in range(radius.size))
    return np.array([min((k for k in own if k > 0.1 * r), default=np.inf) for own, r in zip(found, radius, strict=True)])


def _single_contacts(case):
    """The granite pair, and with it a tiny soft and a large hard contact where the law takes them."""
    found = [case.bind(GRANITE, 0.9)]
    if not registry()[case.law].solved:
        for contact in (Contact(1e-6, 1e5, 1e-9, 2.0, 1e5), Contact(1.0, 1e13, 1e-4, 3.0, 1e12)):
            found.append(case.bind(contact, 0.9))
    return found


def _ratcheting(law, cycles):
    worst = 0.0
    for top in (1e-6, 1e-3, 1e-2):
        for size in (1e-15, 1e-12, 1e-6, 1e-2):
            overlap = top * float(law.contact.radius)
            state = law.new_state(1).arrays
            worst = max(
                worst, cycle_loop(law.rule_tag, law.shape, law.params, state, overlap, overlap * (1.0 - size), cycles // 12)
            )
    return float(worst)


def _kink(law):
    """Jump of force between the two doubles that enclose each kink, in ε of the force, less what the slope explains."""
    worst = 0.0
    for kink in law.kinks():
        if not 0.0 < kink < 0.4 * law.contact.radius:
            continue
        low, high = np.nextafter(kink, 0.0), np.nextafter(kink, 1e9)
        below, above = law.force(low), law.force(high)
        slope = max(law.stiffness(low), law.stiffness(high)) * (high - low)
        worst = max(worst, (abs(above - below) - slope) / above / EPS)
    return float(max(worst, 0.0))


def _reload(law):
    worst = 0.0
    for share in (1e-9, 1e-5, 1e-3, 1e-2):
        top = share * float(law.contact.radius)
        below = float(np.nextafter(top, 0.0))
        path = law.follow(np.array([top, 0.7 * top, top, below, top]))
        if path.force[0] <= 0.0:
            continue
        worst = max(worst, abs(path.force[2] / path.force[0] - 1.0), abs(path.force[4] / path.force[0] - 1.0))
        # below the maximum the state holds δp: force there has the condition number K δ/P, with Hertz's curve 1.5 δ/δ_H
        drop = path.stiffness[3] * (top - below) / path.force[0]
        condition = max(1.0, 1.5 * top / float((path.force[0] / law.params.hertz_coefficient) ** (2 / 3)))
        condition = max(condition, float(path.stiffness[3]) * top / path.force[0])
        worst = max(worst, (abs(path.force[3] / path.force[0] - 1.0) - drop) / condition)
    return float(worst / EPS)


_UNRECORDED = np.empty((0, 3))


def impact(law, mass, speed, *, dt, phase, limit):
    """Impact that begins a fraction `phase` of a step before touch: relative energy gained, peak overlap, velocity after it."""
    state = law.new_state(1).arrays
    _, _, velocity, dissipated, peak = impact_loop(
        law.rule_tag, law.shape, law.params, state, mass, speed, dt, phase, limit, _UNRECORDED
    )
    kinetic = 0.5 * mass * speed * speed
    return (0.5 * mass * velocity * velocity + dissipated - kinetic) / kinetic, peak, velocity


def impact_gains(law, speeds=SPEEDS, steps=STEPS, phases=8, mass=_MASS):
    """Largest energy gain per impact over speeds and phases of the first step: {steps per contact: gain}."""
    gains = {}
    for count in steps:
        worst = 0.0
        for speed in speeds:
            try:
                _, duration = elastic_contact(law, mass, speed)
            except DemlawsError:  # the impact would crush the contact, or leave the table
                continue
            for phase in range(phases if count < 5000 else 1):
                gain, _, _ = impact(law, mass, speed, dt=duration / count, phase=(phase + 0.5) / phases, limit=50 * count + 100)
                worst = max(worst, gain) if gain == gain else math.inf
        gains[count] = float(worst)
    return gains


def safe_steps(gains, allowed=ALLOWED_GAIN):
    """Fewest steps per contact from which on no impact gains more than `allowed` of its energy."""
    safe = math.inf
    for count in sorted(gains, reverse=True):
        if gains[count] > allowed:
            break
        safe = count
    return safe


def step_ratios(law, mass=_MASS):
    """dl.timestep over the measured stable step, at two largest forces."""
    ratios = []
    for share in (1e-4, 1e-2):
        largest = float(law.force(share * law.contact.radius))
        if largest > 0.0:
            promised = timestep(law, mass, largest, other_mass=math.inf, shear_ratio=0.0)
            ratios.append(
                promised
                / min(_stable_step(law, mass, largest, share=load, promised=promised) for load in (0.999, 0.9, 0.5, 0.1))
            )
    return ratios


def _stable_step(law, mass, largest, *, share, promised, steps=20_000):
    """Smallest step with which an oscillation about `share` of the largest force grows twentyfold, scanned from below.

    Oscillations of several sizes, from the loading curve and after the largest force: Verlet's limit 2/ω is that of
    small ones only, and resonances make windows of growth below it. Growth is over what the motion itself does, followed in a
    step of a fiftieth: a contact that unloads 500 times as stiffly as it loads departs 22 times as far as it was pulled back.
    """
    load, smallest = share * largest, 3.0 * promised
    for preloaded in (False, True) if law.state_size else (False,):
        state = law.new_state(1)
        if preloaded:
            law.follow(np.array([float(law.overlap(largest))]), state)
            overlap = float(law.unloading_overlap(load, state))
            foot = max(float(law.unloading_overlap(0.0, state)), 0.0)
        else:
            overlap, foot = float(law.overlap(load)), 0.0
        if overlap - foot <= 1e-12 * law.contact.radius:  # at or below a law's seating load
            continue
        size = (load / law.params.hertz_coefficient) ** (2 / 3)
        for kick in (1e-6, 1e-3, 3e-2):
            kick = min(kick, 0.1 * (overlap - foot) / size)  # a seated contact: less than would part it
            held = mass, load, overlap, -kick * size
            allowed = 20.0 * max(_growth(law, state, held, dt=0.02 * promised, steps=steps), 1.0)
            for ratio in np.arange(0.7, 3.0, 0.02):
                dt = ratio * promised
                if dt >= smallest:
                    break
                if _growth(law, state, held, dt=dt, steps=steps, limit=allowed) > allowed:
                    smallest = dt
                    break
    return smallest


def _growth(law, state, held, *, dt, steps, limit=math.inf):
    """`hold_loop` of a law whose contact is in `state`, which stays as it is; held: mass, load, overlap and kick."""
    arrays = tuple(a.copy() for a in state.arrays)
    return hold_loop(law.rule_tag, law.shape, law.params, arrays, *held, dt, steps, limit)


# --- output


def decades(errors, low, high):
    """Largest of the errors by decade below `low`, from there, and from `high` on, as text."""
    parts = [[e for d, e in errors.items() if np.digitize(d, (low, high)) == n] for n in range(3)]
    return " ".join(f"{max(part):.3g}" if part else "-" for part in parts)


def table(rows):
    """The figures as text, one line a case."""
    head = (
        f"{'law':16}{'unloading':10}{'evaluation':12}{'paths':>9}{'not':>5}{'returns':>8}{'most':>9}"
        f"{'force error (ε)':>18}{'ratchet':>8}{'kink':>6}{'reload':>7}{'broken':>7}{'gain at':>9}{'safe':>7}"
        f"{'step / limit':>14}"
    )
    under = (
        f"{'':38}{'':>9}{'fin.':>5}{'work':>8}{'returned':>9}{'<1e-3 to 1 above':>18}{'':>8}{'(ε)':>6}{'(ε)':>7}"
        f"{'differ':>7}{'50 steps':>9}{'steps':>7}{'':>14}"
    )
    lines = [head, under]
    for r in rows:
        safe = f"{r.safe_steps:.0f}" if math.isfinite(r.safe_steps) else "none"
        rounding = decades(r.rounding, -3, 1) if r.rounding else "-"
        lines.append(
            f"{r.law:16}{r.unloading:10}{r.evaluation:12}{r.paths:9d}{r.not_finite + r.falling:5d}{r.returned:8d}"
            f"{r.worst_return:9.1e}{rounding:>18}{r.ratcheting:8.0e}{r.kink:6.2g}"
            f"{r.reload:7.2g}{r.broken:7d}{r.gains.get(50, math.nan):9.1e}{safe:>7}"
            f"{f'{r.step_ratio[0]:.3f}-{r.step_ratio[1]:.3f}':>14}"
        )
    return "\n".join(lines)


def failures(rows):
    """Failed checks, as sentences."""
    found = []
    for r in rows:
        label = f"{r.law}, {r.unloading}, {r.evaluation}"
        if r.not_finite or r.falling:
            found.append(f"{label}: {r.not_finite} values not finite or negative, {r.falling} falling")
        # two tables of one curve, a law's own as that it unloads along, differ by what they are certified to
        if r.returned and not (r.unloading == GIVEN and r.evaluation == "table" and r.worst_return <= 2.0 * TABLE):
            found.append(
                f"{label}: {r.returned} of {r.paths} paths return work, at most {r.worst_return:.1e} of the energy held"
            )
        if r.ratcheting > 4.0 * EPS:
            found.append(f"{label}: tiny cycles change the force by {r.ratcheting:.1e}")
        if r.broken:
            found.append(f"{label}: {r.broken} contacts closed again differ from new ones")
        if not 0.5 <= r.step_ratio[0] or r.step_ratio[1] > 1.001:
            found.append(f"{label}: dl.timestep is {r.step_ratio[0]:.3f} to {r.step_ratio[1]:.3f} of the measured stable step")
    return found
