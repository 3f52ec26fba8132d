"""How often a fit's 95 % intervals hold the truth: 200 made-up sets of points a case.

    python tests/benchmarks/bench_fit.py [--quick] [--sets N] [--only WORD]

Also the cases of tests/advice/test_fit.py, which asks for the same of fewer sets.
"""

import argparse
import time
import warnings
from typing import NamedTuple

import numpy as np

import demlaws as dl
from demlaws.advice.fit import COMPLIANCE, PARAMETERS, ZERO, history

PAIR = dl.Contact(4.35e-3, 32.32e9, 2.4e-6, 2.22, 6.266e9)
CONE = PAIR.with_values(radius=0.96e-3, roughness=5.04e-6)
CYCLE = np.concatenate([np.linspace(1, 60, 20), np.linspace(58, 2, 12), np.linspace(4, 100, 20), np.linspace(95, 3, 12)])
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


HERTZ, ROUGH, YIELDING = ("hertz", "elastic", PAIR), ("pohrt-popov", "hertz", PAIR), ("rough-plastic", "hertz", CONE)
MODULUS, FRACTAL = {"modulus": 32.32e9}, {"roughness": 2.4e-6, "fractal_dimension": 2.22}
CONICAL = {"roughness": 5.04e-6, "fractal_dimension": 2.22}
CASES = (
    Case("hertz", *HERTZ, MODULUS, ("modulus",), LOADING, 5e-8),
    Case("inside", *ROUGH, FRACTAL, (), CYCLE, 1e-7),
    Case("at its bound", *ROUGH, {**FRACTAL, "fractal_dimension": 2.0}, (), CYCLE, 1e-7),
    Case("near its bound", *ROUGH, {**FRACTAL, "fractal_dimension": 2.02}, (), CYCLE, 1e-7),
    Case("upper bound", *ROUGH, {**FRACTAL, "fractal_dimension": 2.99}, (), CYCLE, 1e-7),
    Case("compliance", *HERTZ, {**MODULUS, COMPLIANCE: 1e-8}, ("modulus", COMPLIANCE), LOADING, 2e-8),
    Case("no compliance", *HERTZ, {**MODULUS, COMPLIANCE: 0.0}, ("modulus", COMPLIANCE), LOADING, 2e-8),
    Case("from afar", *HERTZ, MODULUS, ("modulus",), FROM_AFAR, 2e-8, 5e-3),
    Case("from afar, noise told", *HERTZ, MODULUS, ("modulus",), FROM_AFAR, 2e-8, 5e-3, True),
    *(
        Case(f"force noise, {law}{known}", law, "hertz", PAIR, truth, (), CYCLE, 5e-8, 0.3, bool(known))
        for law, truth in (("rms", {"roughness": 2.4e-6}), ("pohrt-popov", FRACTAL))
        for known in ("", ", told")
    ),
    Case("yield", *YIELDING, {**CONICAL, "yield_pressure": 1.66e9}, (), CYCLE, 1e-7),
    Case("yield at the last load", *YIELDING, {**CONICAL, "yield_pressure": 2.8e9}, (), CYCLE, 1e-7),
)


def made(case, seed):
    """Points of one set: displacement and force, as measured."""
    random = np.random.default_rng(seed)
    options = {k: v for k, v in case.truth.items() if PARAMETERS[k].option}
    fields = {k: v for k, v in case.truth.items() if not PARAMETERS[k].option and k != COMPLIANCE}
    law = dl.law(case.law, case.contact.with_values(**fields), case.unloading, **options)
    overlap = np.zeros(case.force.size)
    touching = case.force > 0.0
    overlap[touching] = history(law, case.force[touching])[0]
    before = np.flatnonzero(~touching)
    overlap[before] = -np.linspace(8e-6, 0.0, before.size)
    displacement = overlap + MEET + case.truth.get(COMPLIANCE, 0.0) * case.force
    displacement += case.noise * random.standard_normal(case.force.size)
    return np.column_stack([displacement, case.force + case.force_noise * random.standard_normal(case.force.size)])


def fitted(case, seed):
    guess = case.contact.with_values(
        roughness=1.7 * case.contact.roughness,
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
            inside.setdefault(name, []).append(estimate.low <= truth * (1 + 1e-12) and truth * (1 - 1e-12) <= estimate.high)
            bias.setdefault(name, []).append(estimate.value / truth - 1.0 if truth else np.nan)
            spread.setdefault(name, []).append((estimate.value - truth) / estimate.error)
    held, median = ({n: float(mean(v)) for n, v in one.items()} for mean, one in ((np.mean, inside), (np.median, bias)))
    return held, median, {name: float(np.std(values)) for name, values in spread.items()}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="20 sets a case")
    parser.add_argument("--sets", type=int, default=200)
    parser.add_argument("--only", default="")
    arguments = parser.parse_args()
    sets = 20 if arguments.quick else arguments.sets
    warnings.simplefilter("ignore")
    print(f"{'case':24} coverage of 95 % intervals in {sets} sets (median error)")
    for case in CASES:
        if arguments.only in case.name:
            start = time.process_time()
            held, bias, _ = coverage(case, range(sets))
            text = ", ".join(f"{name} {100 * share:.1f} % ({100 * bias[name]:+.1f} %)" for name, share in held.items())
            print(f"{case.name:24} {text}   [{(time.process_time() - start) / sets:.2f} s a fit]", flush=True)


if __name__ == "__main__":
    main()
