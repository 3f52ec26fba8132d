"""Cost against error: law × unloading rule × evaluation, measured in one run on one scene.

The scene is a granite pair of the tests, SS(18-18), from 0.1 N to 2 kN (bulk yield included), loading and unloading.
Costs are ns per contact of batches whose rounds are interleaved, with a copy kernel beside them; errors are those of
`errors.QUANTITIES`.
"""

import math
import time
from typing import NamedTuple

import numpy as np

from demlaws.advice.errors import Sample, error_of
from demlaws.core.numba_compat import loop
from demlaws.core.unloading import GIVEN
from demlaws.errors import DemlawsError, quiet
from demlaws.laws.registry import registry
from demlaws.make import example_law
from studies.extremes.stability import GRANITE
from studies.trade.candidates import RICHEST

LOADS = (0.1, 2000.0)
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


def _sample(shares):
    """Contacts of equal weight; shares: 0 for the smallest of the loads, 1 for the largest."""
    return Sample(GRANITE, LOADS[0] * (LOADS[1] / LOADS[0]) ** shares)


def _errors(law, reference, points=1500):
    sample = _sample(np.linspace(0.0, 1.0, points))
    return {q: float(error_of(law, reference, sample, q, True).max()) for q in COMPARED}


# --- costs


@loop
def copy(source, first, second):
    """Read one array and write two, as a law without history must."""
    for i in range(source.size):
        first[i] = source[i]
        second[i] = source[i]


def _batch(law, count):
    """(a law, overlaps [m], state) of contacts at random loads, of which seven in ten are unloading."""
    random = np.random.default_rng(1)
    top = np.asarray(law.overlap(_sample(random.random(count)).peak))
    now = top * np.where(random.random(count) < 0.3, 1.0, random.uniform(0.3, 1.0, count))
    state = law.new_state(count)
    if law.state_size:
        law.evaluate(top, state)
    return law, now, state


def _seconds(function, *arguments):
    start = time.perf_counter()
    function(*arguments)
    return time.perf_counter() - start


def nanoseconds(batches, count, rounds):
    """(name → ns per contact, ns of `copy`) of `_batch`es: each is timed in every round, and its fastest round counts."""
    best, floor, out = dict.fromkeys(batches, math.inf), math.inf, (np.zeros(count), np.zeros(count))
    for _ in range(rounds + 1):  # one more, in which loops are compiled
        floor = min(floor, _seconds(copy, np.ones(count), *out))
        for name, (law, overlap, state) in batches.items():
            best[name] = min(best[name], _seconds(law.evaluate, overlap, state.copy(), out))
    return {name: 1e9 * seconds / count for name, seconds in best.items()}, 1e9 * floor / count


# --- all ways


def _ways(laws, progress):
    """(law, rule, "closed form" or "table", bits per octave) → law, of every law with each of its rules."""
    ways = {}
    for name in progress([n for n, d in registry().items() if not d.needs_map and (not laws or n in laws)]):
        definition = registry()[name]
        # along another curve: of laws that choices are made of
        given = (GIVEN,) if definition.advice.candidate and not definition.advice.smooth else ()
        for rule in (*definition.unloading, *given):
            try:
                law = example_law(name, GRANITE, rule)
            except DemlawsError:
                continue
            ways[name, rule, "closed form", ""] = law
            for rtol in RTOLS:
                try:
                    table = law.tabulate(rtol, 2.0 * LOADS[1])
                except DemlawsError:
                    continue
                ways.setdefault((name, rule, "table", f"{table.curve.bits} bits"), table)
    return ways


def measure(laws=None, count=200_000, rounds=9, progress=lambda things: things):
    """All entries, the Pareto front of cost and force error against RICHEST marked; and the copy kernel's ns."""
    with quiet(), np.errstate(all="ignore"):
        richest, ways = RICHEST.bind(GRANITE), _ways(laws, progress)
        cost, floor = nanoseconds({key: _batch(law, count) for key, law in ways.items()}, count, rounds)
        entries = [
            Entry(
                *key,
                cost[key],
                cost[key] / floor,
                8 * law.state_size,
                law.nodes.u.size if key[2] == "table" else 0,
                _errors(law, ways[(*key[:2], "closed form", "")]),
                _errors(law, richest),
            )
            for key, law in progress(list(ways.items()))
        ]
    front = pareto([(e.ns, e.richest["force"]) for e in entries])
    return [e._replace(front=n in front) for n, e in enumerate(entries)], floor


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


def _number(value):
    return "-" if value != value else f"{value:.1e}"


def table(entries, floor):
    """The entries as text."""
    own, richest = "error against its own closed form", f"error against {RICHEST.law}"
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
    lines.append(f"* on the Pareto front of cost and force error against {RICHEST.law}; copy kernel {floor:.2f} ns")
    return "\n".join(lines)
