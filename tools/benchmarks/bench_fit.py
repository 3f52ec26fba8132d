"""How often a fit's 95 % intervals hold the truth, and how often a law finds itself: 200 made-up sets of points per case.

    python tools/benchmarks/bench_fit.py [--recovery] [--quick] [--sets N] [--only WORD]

Also the cases of tests/advice/test_fit.py, which asks for the same of fewer sets.
"""

import argparse
import math
import time
import warnings
import zlib
from typing import NamedTuple

import numpy as np

import demlaws as dl
from demlaws.advice.fit_model import COMPLIANCE, DRIFT, FORCE_ZERO, ZERO, parameters
from demlaws.core.history import history as history_loop
from demlaws.core.unloading import GIVEN
from demlaws.errors import quiet
from demlaws.laws.definition import OF_CONTACT
from demlaws.laws.registry import find, registry

PAIR = dl.Contact(4.35e-3, 32.32e9, 2.4e-6, 2.22, 6.266e9)
CONE = PAIR.with_values(radius=0.96e-3, sigma=5.04e-6)
CYCLE = np.concatenate([np.linspace(1, 60, 20), np.linspace(58, 2, 12), np.linspace(4, 100, 20), np.linspace(95, 3, 12)])
HELD = np.insert(CYCLE, 20, np.full(30, 60.0))
HELD = np.insert(HELD, 82, np.full(30, 100.0))
"""The cycle with two holds."""
LOADING = np.linspace(0.5, 100.0, 60)
FROM_AFAR = np.concatenate([np.zeros(60), np.linspace(0.0, 20.0, 121)[1:]])
"""A test that begins before the bodies meet."""
MEET = 3.1e-6
"""Displacement [m] at which they do."""


class Case(NamedTuple):
    """A law with true values, the forces of a test, and its noise."""

    name: str
    law: str
    unloading: str
    contact: dl.Contact
    truth: dict
    free: tuple
    force: np.ndarray
    noise: float  # [m]
    force_noise: float = 0.0  # [N]
    told: bool = False  # whether the fit is given the noise
    made_by: tuple = ()  # law and rule of the points, where they are not those that are fitted


HERTZ, ROUGH, YIELDING = ("hertz", "elastic", PAIR), ("pohrt-popov", "hertz", PAIR), ("rough-plastic", "hertz", CONE)
MODULUS, FRACTAL = {"modulus": 32.32e9}, {"sigma": 2.4e-6, "fractal_dimension": 2.22}
PLASTIC = ("sigma", "fractal_dimension", "yield_pressure")
YIELD = {"yield_pressure": 0.8e9, "yield_strength": 0.25e9}
CONICAL = {"sigma": 5.04e-6, "fractal_dimension": 2.22}
CASES = (
    Case("hertz", *HERTZ, MODULUS, ("modulus",), LOADING, 5e-8),
    Case("inside", *ROUGH, FRACTAL, tuple(FRACTAL), CYCLE, 1e-7),
    Case("at its bound", *ROUGH, {**FRACTAL, "fractal_dimension": 2.0}, tuple(FRACTAL), CYCLE, 1e-7),
    Case("near its bound", *ROUGH, {**FRACTAL, "fractal_dimension": 2.02}, tuple(FRACTAL), CYCLE, 1e-7),
    Case("upper bound", *ROUGH, {**FRACTAL, "fractal_dimension": 2.99}, tuple(FRACTAL), CYCLE, 1e-7),
    Case("compliance", *HERTZ, {**MODULUS, COMPLIANCE: 1e-8}, ("modulus", COMPLIANCE), LOADING, 2e-8),
    Case("no compliance", *HERTZ, {**MODULUS, COMPLIANCE: 0.0}, ("modulus", COMPLIANCE), LOADING, 2e-8),
    Case("from afar", *HERTZ, MODULUS, ("modulus",), FROM_AFAR, 2e-8, 5e-3),
    Case("from afar, noise told", *HERTZ, MODULUS, ("modulus",), FROM_AFAR, 2e-8, 5e-3, True),
    *(
        Case(f"force noise, {law}{known}", law, "hertz", PAIR, truth, tuple(truth), CYCLE, 5e-8, 0.3, bool(known))
        for law, truth in (("rms", {"sigma": 2.4e-6}), ("pohrt-popov", FRACTAL))
        for known in ("", ", told")
    ),
    Case("yield", *YIELDING, {**CONICAL, "yield_pressure": 1.66e9}, PLASTIC, CYCLE, 1e-7),
    Case("yield at the last load", *YIELDING, {**CONICAL, "yield_pressure": 2.8e9}, PLASTIC, CYCLE, 1e-7),
    *(
        Case(f"load cell off by {offset:g} N, {law}", law, rule, PAIR, {**truth, FORCE_ZERO: offset}, (), force, 3e-8)
        for law, rule, truth, force in (
            ("hertz", "elastic", MODULUS, LOADING),
            ("rms", "hertz", {"sigma": 2.4e-6}, CYCLE),
            ("pohrt-popov", "hertz", FRACTAL, CYCLE),
        )
        for offset in (0.0, 0.5, -0.5)
    ),
    *(
        Case(f"{kind}, {law}", law, rule, PAIR, {**surface, name: value}, (), CYCLE, 5e-8, made_by=maker)
        for law, rule, name, surface, made_by in (
            ("thornton-ning", "thornton", "yield_pressure", {}, ("hertz", "elastic")),
            ("kogut-etsion", "etsion", "yield_strength", {}, ("hertz", "elastic")),
            ("jackson-green", "etsion", "yield_strength", {}, ("hertz", "elastic")),
            ("rough-plastic", "hertz", "yield_pressure", FRACTAL, ("pohrt-popov", "hertz")),
        )
        for kind, value, maker in (("yields", YIELD[name], ()), ("never yields", math.inf, made_by))
    ),
    *(
        Case(f"drift by {1e6 * drift:g} µm, {law}", law, "hertz", PAIR, {**truth, DRIFT: drift}, (), CYCLE, 2e-8)
        for law, truth in (("rms", {"sigma": 2.4e-6}), ("pohrt-popov", FRACTAL))
        for drift in (0.0, 4e-7)
    ),
    *(
        Case(f"holds, {law}", law, rule, PAIR, {**truth, "creep_1": 1e-7, "creep_2": 3e-7}, (), HELD, 2e-8)
        for law, rule, truth in (
            ("hertz", "elastic", MODULUS),
            ("rms", "hertz", {"sigma": 2.4e-6}),
            ("pohrt-popov", "hertz", FRACTAL),
            ("thornton-ning", "thornton", {"yield_pressure": 0.8e9}),
            ("rough-plastic", "hertz", {**FRACTAL, "yield_pressure": 0.8e9}),
        )
    ),
    Case("ten points", "rms", "hertz", PAIR, {"sigma": 2.4e-6}, ("sigma",), CYCLE[::7], 3e-8),
)


def crept(case):
    """Displacement [m] by which a test creeps, as ln(time) over rows of one force; by `creep_1` over the first."""
    creep, held = np.zeros(case.force.size), np.append(False, np.diff(case.force) == 0.0)
    starts = np.flatnonzero(np.diff(held.astype(int)) == 1)
    for number, first in enumerate(starts, 1):
        rows = int(np.argmin(np.append(held[first + 1 :], False)))
        course = np.log1p(np.minimum(np.arange(case.force.size - first), rows)) / math.log1p(rows)
        creep[first:] += case.truth.get(f"creep_{number}", 0.0) * course
    return creep


def history(law, force):
    """Overlap [m] and tangent stiffness [N/m] at each force > 0 [N] of a history that starts with first loading."""
    return history_loop(law.unloading_parts.rule, law.shape, law.params, np.array(force, float))


def made(case, seed):
    """Points of one set: displacement and force, as measured."""
    random = np.random.default_rng(seed)
    options = {k: v for k, v in case.truth.items() if k in parameters() and parameters()[k].option and math.isfinite(v)}
    fields = {k: v for k, v in case.truth.items() if k in OF_CONTACT}
    name, rule = case.made_by or (case.law, case.unloading)
    law = dl.law(name, case.contact.with_values(**fields), rule, **options)
    overlap = np.zeros(case.force.size)
    touching = case.force > 0.0
    overlap[touching] = history(law, case.force[touching])[0]
    before = np.flatnonzero(~touching)
    overlap[before] = -np.linspace(8e-6, 0.0, before.size)
    displacement = overlap + MEET + case.truth.get(COMPLIANCE, 0.0) * case.force
    displacement += case.truth.get(DRIFT, 0.0) * np.linspace(0.0, 1.0, case.force.size)
    displacement += crept(case)
    displacement += case.noise * random.standard_normal(case.force.size)
    force = case.force + case.truth.get(FORCE_ZERO, 0.0)
    return np.column_stack([displacement, force + case.force_noise * random.standard_normal(case.force.size)])


def fitted(case, seed):
    guess = case.contact.with_values(
        sigma=1.7 * case.contact.sigma,
        modulus=case.contact.modulus * (1.2 if "modulus" in case.truth else 1.0),
        fractal_dimension=2.4,
    )
    noise = {"displacement_noise": case.noise, "force_noise": case.force_noise} if case.told else {}
    options = {"laws": case.law, "unloading": case.unloading, "free": case.free or None, **noise}
    return dl.fit(made(case, seed), guess, **options).best


def coverage(case, seeds):
    """Quantity → share of the sets whose interval holds the truth; median error over the truth; rms error over the stated."""
    inside, bias, spread = {}, {}, {}
    for seed in seeds:
        best = fitted(case, seed)
        for name, truth in {**case.truth, ZERO: MEET}.items():
            estimate = best.parameters[name]
            held = estimate.low <= truth * (1 + 1e-12) and truth * (1 - 1e-12) <= estimate.high
            inside.setdefault(name, []).append(held or (truth == math.inf and estimate.open_end in ("upper", "both")))
            bias.setdefault(name, []).append(estimate.value / truth - 1.0 if 0.0 < truth < math.inf else np.nan)
            spread.setdefault(name, []).append((estimate.value - truth) / estimate.error)
    held, median = ({n: float(mean(v)) for n, v in one.items()} for mean, one in ((np.mean, inside), (np.median, bias)))
    return held, median, {name: float(np.std(values)) for name, values in spread.items()}


# --- a law's own points, fitted by the same law and rule without a guess of its quantities

RANGES = {
    "modulus": (10e9, 100e9),
    "sigma": (0.5e-6, 6e-6),
    "fractal_dimension": (2.05, 2.6),
    "slope": (0.02, 0.15),
    "yield_pressure": (0.3e9, 3e9),
    "yield_strength": (0.2e9, 2e9),
    "strength": (1e9, 5e9),
    "angle": (0.4, 1.1),
    "loading_stiffness": (1e6, 1e7),
    "stiffness_ratio": (1.3, 4.0),
    "plasticity_depth": (1e-4, 3e-3),
    "softness": (0.3, 1.5),
}
"""From where true values are drawn, evenly in their logarithm; other quantities between half and twice their starts."""
RECOVERED = 1.5
"""Misfit over the noise up to which a law has found itself."""


class Truth(NamedTuple):
    """Points that a law made, and what it made them with."""

    points: np.ndarray
    guess: dl.Contact
    noise: float  # [m]
    values: dict


def fitted_rules():
    """Law → the rules that a fit supports; some laws take one only at some contacts, or at none."""
    laws = {name: definition for name, definition in registry().items() if not definition.needs_map}
    return {name: [rule for rule in definition.offered() if rule != GIVEN] for name, definition in laws.items()}


def truth_or_none(name, rule, number):
    """`truth`, or None for values with which the law does not take the rule."""
    try:
        with quiet():
            return truth(name, rule, number)
    except dl.DemlawsError:
        return None


def truth(name, rule, number):
    """40 points of loading and 20 of unloading: in 7 of 10 cases the curve's joint lies between 0.16 and 0.8 of the load."""
    random = np.random.default_rng([zlib.crc32(f"{name},{rule}".encode()), number])
    quantities, radius = parameters(), 10.0 ** random.uniform(-3.3, -2.0)
    guess = dl.Contact(radius, 32.32e9, hardness=6e9)

    def drawn(quantity):
        starts = np.ravel(quantities[quantity].starts(guess))
        return float(np.exp(random.uniform(*np.log(RANGES.get(quantity, (0.5 * starts.min(), 2.0 * starts.max()))))))

    surface = {q: drawn(q) for q in ("sigma", "fractal_dimension")}
    values = {q: surface.get(q) or drawn(q) for q in find(name).fitting.free}
    fields = {q: value for q, value in values.items() if not quantities[q].option}
    law = dl.law(name, guess.with_values(**(surface | fields)), rule, **{q: v for q, v in values.items() if q not in fields})
    kinks = law.kinks()
    joint = float(law.force(max(kinks))) if kinks else 0.0
    if 0.01 < joint < 1e4 and random.random() < 0.7:
        most = min(joint * 10.0 ** random.uniform(0.1, 0.8), float(law.force(0.08 * radius)))
    else:
        most = min(10.0 ** random.uniform(1.0, 2.3), float(law.force(0.05 * radius)))
    force = np.linspace(0.02 * most, most, 40)
    if rule != "elastic":
        force = np.append(force, np.linspace(0.95 * most, 0.1 * most, 20))
    overlap = history(law, force)[0]
    noise = 2e-3 * float(np.ptp(overlap))
    rows = np.column_stack([overlap + MEET + noise * random.standard_normal(force.size), force])
    return Truth(rows, guess, noise, values)


def recovery(name, rule, numbers):
    """Misfit over the noise of each truth, fitted by its own law and rule; inf where the fit is refused."""
    for number in numbers:
        one = truth_or_none(name, rule, number)
        if one is None:
            continue
        try:
            yield number, dl.fit(one.points, one.guess, laws=name, unloading=rule).best.misfit / one.noise
        except dl.DemlawsError:
            yield number, float("inf")


def print_recovery(sets, only):
    print(f"| law | rule | truths | found again, misfit ≤ {RECOVERED} noise | largest misfit/noise | s per fit |")
    print("| --- | --- | ---: | ---: | ---: | ---: |")
    for name, rule in ((name, rule) for name, rules in fitted_rules().items() for rule in rules):
        if only in f"{name}, {rule}":
            start = time.process_time()
            misfits = dict(recovery(name, rule, range(sets)))
            if not misfits:
                continue
            seconds = (time.process_time() - start) / len(misfits)
            missed = [number for number, misfit in misfits.items() if misfit > RECOVERED]
            share = 100.0 * (1.0 - len(missed) / len(misfits))
            row = f"{name} | {rule} | {len(misfits)} | {share:.1f} % | {max(misfits.values()):.3g} | {seconds:.3f}"
            print(f"| {row} |{f'  missed: {missed}' if missed else ''}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--recovery", action="store_true", help="each law's own points fitted by that law, with each rule")
    parser.add_argument("--quick", action="store_true", help="20 sets a case")
    parser.add_argument("--sets", type=int, default=200)
    parser.add_argument("--only", default="")
    arguments = parser.parse_args()
    sets = 20 if arguments.quick else arguments.sets
    warnings.simplefilter("ignore")
    if arguments.recovery:
        print_recovery(sets, arguments.only)
        return
    print(f"{'case':24} coverage of 95 % intervals in {sets} sets (median error)")
    for case in CASES:
        if arguments.only in case.name:
            start = time.process_time()
            held, bias, _ = coverage(case, range(sets))
            text = ", ".join(f"{name} {100 * share:.1f} % ({100 * bias[name]:+.1f} %)" for name, share in held.items())
            print(f"{case.name:24} {text}   [{(time.process_time() - start) / sets:.2f} s a fit]", flush=True)


if __name__ == "__main__":
    main()
