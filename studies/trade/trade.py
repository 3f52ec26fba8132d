"""Cost against error: law × unloading rule × evaluation, and the time step, measured in one run on one scene.

The scene is a granite pair of the tests, SS(18-18), from 0.1 N to 2 kN (bulk yield included), loading and unloading.
Costs are ns per contact of batches whose rounds are interleaved, with a copy kernel beside them; errors are those of
`errors.QUANTITIES`.
"""

import math
from typing import NamedTuple

import numpy as np

from demlaws.advice.errors import Sample, error_of
from demlaws.core.unloading import GIVEN
from demlaws.driver import elastic_contact
from demlaws.errors import DemlawsError, quiet
from demlaws.laws.names import POHRT_POPOV
from demlaws.laws.registry import registry
from demlaws.make import example
from demlaws.make import law as bind_law
from studies.costs.costs import available
from studies.costs.steps import StepCost, step_costs
from studies.extremes.stability import GRANITE, STEPS, impact
from studies.trade import candidates, peers
from studies.trade.timing import Batch, nanoseconds

LOADS = (0.1, 2000.0)
RICHEST = (candidates.RICHEST.law, candidates.RICHEST.unloading, dict(candidates.RICHEST.options))
COMPARED = ("force", "stiffness", "energy", "restitution")
RTOLS = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7)


class Entry(NamedTuple):
    """One way to compute the scene."""

    law: str
    unloading: str
    evaluation: str  # "closed form" or "table"
    detail: str  # bits per octave
    ns: float
    over_copy: float
    state_bytes: int
    rows: int
    own: dict  # quantity → largest error against the closed form of the same law and rule
    richest: dict  # quantity → largest error against RICHEST
    front: bool = False


class StepEntry(NamedTuple):
    """One time step."""

    steps: int  # per contact
    gain: float  # largest relative energy made or lost by an impact, over speeds and phases of the first step
    rebound_error: float  # largest error of the restitution coefficient
    ns: float  # a contact and impact: steps × ns of the law


def _sample(count, random=None):
    share = np.linspace(0.0, 1.0, count) if random is None else random.random(count)
    peak = LOADS[0] * (LOADS[1] / LOADS[0]) ** share
    return Sample(GRANITE, peak, np.full(count, 1.0 / count))


def _bind(name, unloading, options=None):
    return bind_law(name, GRANITE, unloading, **(registry()[name].example if options is None else options))


def _batch(law, count):
    random = np.random.default_rng(1)
    sample = _sample(count, random)
    top = np.asarray(law.overlap(sample.peak))
    now = top * np.where(random.random(count) < 0.3, 1.0, random.uniform(0.3, 1.0, count))
    return Batch.of(law, top, now)


def _errors(law, reference, points=1500):
    sample = _sample(points)
    return {q: float(error_of(law, reference, sample, q, True).max()) for q in COMPARED}


def measure(laws=None, count=200_000, rounds=9, progress=lambda things: things):
    """All entries, the copy kernel's ns, and the Pareto front of the richest law's force error against cost."""
    with quiet(), np.errstate(all="ignore"):
        richest = _bind(RICHEST[0], RICHEST[1], RICHEST[2])
        bound = {}
        for name, definition in registry().items():
            if definition.needs_map or (laws and name not in laws):
                continue
            # along another curve: of laws that choices are made of
            given = (GIVEN,) if definition.advice.candidate and not definition.advice.smooth else ()
            for rule in (*definition.unloading, *given):
                try:
                    bound[name, rule] = example(name, GRANITE, rule)
                except DemlawsError:
                    continue
        made, batches = {}, {}
        for (name, rule), law in progress(list(bound.items())):
            made[name, rule, "closed form", ""] = law
            seen = set()
            for rtol in RTOLS:
                try:
                    table = law.tabulate(rtol, 2.0 * LOADS[1])
                except DemlawsError:
                    continue
                bits = table.curve.rows.bits
                if bits not in seen:
                    seen.add(bits)
                    made[name, rule, "table", f"{bits} bits"] = table
        for key, law in made.items():
            batches[key] = _batch(law, count)
        cost, floor = nanoseconds(batches, rounds)
        entries = []
        for key, law in progress(list(made.items())):
            exact = bound[key[:2]]
            entries.append(
                Entry(
                    *key,
                    cost[key],
                    cost[key] / floor,
                    8 * law.state_size,
                    law.nodes.u.size if key[2] == "table" else 0,
                    _errors(law, exact),
                    _errors(law, richest),
                )
            )
    return _mark_front(entries), floor


GAIN = 0.99
"""By what factor an error must fall, at least, for a dearer way to be on the Pareto front: less is rounding."""


def pareto(points):
    """Places of the (cost, error) pairs that no cheaper one matches within `GAIN`."""
    front, best = set(), math.inf
    for n in sorted(range(len(points)), key=points.__getitem__):
        if points[n][1] < GAIN * best:
            best = points[n][1]
            front.add(n)
    return front


def _mark_front(entries):
    front = pareto([(e.ns, e.richest["force"]) for e in entries])
    return [e._replace(front=n in front) for n, e in enumerate(entries)]


def steps_trade(ns, speeds=(1e-3, 1e-1, 1.0), phases=8, mass=1.2e-2, name=POHRT_POPOV, rule="hertz"):
    """Error and energy drift of impacts against steps per contact; ns: cost of one evaluation of the law."""
    entries = []
    with quiet():
        law = _bind(name, rule)
        for steps in STEPS:
            gain = rebound = 0.0
            for speed in speeds:
                overlap, duration = elastic_contact(law, mass, speed)
                state = law.new_state(1)
                law.follow(np.array([overlap]), state)
                work = float(law.energy(overlap))
                stored = float(law.follow(np.array([overlap * (1.0 - 1e-12)]), state).stored[0])
                exact = math.sqrt(stored / work)
                for phase in range(phases):
                    drift, peak, _ = impact(law, mass, speed, duration / steps, (phase + 0.5) / phases, 50 * steps + 100)
                    gain = max(gain, abs(drift))
                    state = law.new_state(1)
                    law.follow(np.array([peak]), state)
                    lost = float(law.energy(peak)) - float(law.follow(np.array([peak * (1.0 - 1e-12)]), state).stored[0])
                    found = math.sqrt(max(1.0 + drift - lost / work, 0.0))
                    rebound = max(rebound, abs(found - exact))
            entries.append(StepEntry(steps, gain, rebound, steps * ns))
    return entries


# --- engines


class EngineEntry(NamedTuple):
    """One way in one engine."""

    cost: StepCost
    error: float  # largest force error against RICHEST
    front: bool = False


def engine_trade(engine, quick=False, progress=lambda things: things):
    """`EngineEntry` of every way of an engine, its own models included, on this module's granite pair."""
    ways = [way for way in candidates.ways(engine) if not way.shaken]
    peaks = _sample(60).peak
    with quiet(), np.errstate(all="ignore"):
        reference = _bind(*RICHEST)
        force = math.sqrt(LOADS[0] * LOADS[1])
        if engine == "yade":
            size = (6, 10) if quick else (10, 40)
        else:
            size = (8, 2, 100) if quick else (12, 9, 300)
        costs = step_costs(engine, ways, 2.0 * GRANITE.radius, float(reference.overlap(force)), force, *size, progress=progress)
        yielding = RICHEST[2]["yield_pressure"]
        entries = [EngineEntry(c, peers.force_error(c.way, reference, peaks, yielding)) for c in costs]
    front = pareto([(e.cost.over_hertz, e.error) for e in entries])
    return [e._replace(front=n in front) for n, e in enumerate(entries)]


def installed(names):
    """The engines of these names; with none given, those that are here. Raises where one that was asked for is missing."""
    missing = {name: available(name) for name in names or candidates.ENGINES}
    found = [name for name, problem in missing.items() if problem is None]
    if (names and len(found) < len(missing)) or not found:
        raise DemlawsError("; ".join(problem for problem in missing.values() if problem))
    return found


# --- output


def _number(value):
    return "-" if value != value else f"{value:.1e}"


def table(entries, floor):
    """The entries as text."""
    own, richest = "error against its own closed form", f"error against {RICHEST[0]}"
    names = " ".join(f"{q:>9}" for q in (*COMPARED[:3], "rebound"))
    lines = [
        f"{'':51} {'':>9} {'×':>8} {'state':>6} {'':>6}   {own:^39}   {richest:^39}",
        f"{'law':16} {'unloading':10} {'evaluation':12} {'':>9} {'ns':>9} {'copy':>8} {'bytes':>6} {'rows':>6}"
        f"   {names}   {names}",
    ]
    for e in entries:
        errors = "   ".join(" ".join(f"{_number(values[q]):>9}" for q in COMPARED) for values in (e.own, e.richest))
        lines.append(
            f"{e.law:16} {e.unloading:10} {e.evaluation:12} {e.detail:>9} {e.ns:9.2f} {e.over_copy:8.2f} {e.state_bytes:6d} "
            f"{e.rows or '-':>6}   {errors}{'  *' if e.front else ''}"
        )
    lines.append(f"* on the Pareto front of cost and force error against {RICHEST[0]}; copy kernel {floor:.2f} ns")
    return "\n".join(lines)


def engine_table(entries):
    """Ways in an engine as text."""
    model = "Law2" if any(e.cost.way.model == "cdm" for e in entries) else "pair loop"
    lines = [
        f"{'':36}{'force error':>12}{'ns per contact':>15}{'step over':>11}{'share of the step (%)':>24}",
        f"{'':36}{'':>12}{'and step':>15}{'its Hertz':>11}{'normal law':>13}{model:>11}",
    ]
    for e in entries:
        c = e.cost
        law = "-" if math.isnan(c.law) else f"{100 * c.law:.1f}"
        lines.append(
            f"{c.way.label:36}{e.error:12.1e}{c.step:15.1f}{c.over_hertz:11.3f}{law:>13}{100 * c.model:11.1f}"
            f"{'  *' if e.front else ''}"
        )
    return "\n".join(lines)


def steps_table(entries):
    """The time steps as text."""
    lines = [f"{'steps per contact':>18}{'energy drift':>14}{'rebound error':>15}{'ns an impact':>14}"]
    lines += [f"{e.steps:18d}{e.gain:14.1e}{e.rebound_error:15.1e}{e.ns:14.0f}" for e in entries]
    return "\n".join(lines)
