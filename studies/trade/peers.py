"""How far the engines' own contact models are from a law, at the same overlaps."""

import math
from typing import NamedTuple

import numpy as np

from demlaws.advice.errors import FRACTIONS, Loaded, Sample, error_of
from demlaws.advice.fit import fit
from demlaws.driver import force_controlled
from demlaws.errors import quiet
from demlaws.granite import find_test, options_for
from demlaws.laws.names import CONICAL_DAMAGE, EEPA, HERTZ, LUDING, THORNTON_NING, WALTON_BRAUN
from demlaws.make import law as bind_law
from demlaws.materials import DENSITY
from studies.costs.costs import under_yade
from studies.trade.candidates import RICHEST

GRANITE_CONTACT = find_test("SS(18-18)").contact
CDM_STRENGTHS = (0.3, 0.5, 1.0, 2.0, 4.0)  # sigmaMax over the yield pressure
CDM_SLOPES = (1e-6, 0.25, 0.5, 1.0, 1.4)  # alpha


def reference_paths(reference, peaks):
    """Overlaps [m] and forces [N] of contacts of `reference` that are loaded to `peaks` [N] and unloaded, one row each."""
    sample = Sample(reference.contact, peaks, np.full(peaks.size, 1.0 / peaks.size))
    exact = Loaded(reference, sample)
    state, _, _ = exact.state_at(exact.top)
    overlaps, forces = [exact.top], [peaks]
    for fraction in sorted(FRACTIONS, reverse=True):
        overlaps.append(exact.unloaded(state, fraction * peaks))
        forces.append(exact.again(overlaps[-1], state)[0])
    return np.stack(overlaps, 1), np.stack(forces, 1)


def _largest(found, forces):
    """Largest and mean error of force over the row's first force."""
    error = np.abs(found - forces) / forces[:, :1]
    return float(error.max()), float(error.mean())


class EdinburghFit(NamedTuple):
    """Stock edinburgh/stiffness, P = k1 δ^n; ratio: k2/k1."""

    exponent: float
    stiffness: float
    ratio: float


def edinburgh_fit(law, load):
    """The model with the overlap and tangent of `law` (one contact) at `load` [N] of first loading, and its plastic overlap."""
    with quiet():
        overlap = float(law.overlap(load))
        exponent = float(law.stiffness(overlap)) * overlap / load
        plastic = float(law.follow(np.array([overlap])).plastic_overlap[0]) if law.state_size else 0.0
    kept = (max(plastic, 0.0) / overlap) ** exponent
    return EdinburghFit(exponent, load / overlap**exponent, 1.0 / (1.0 - kept))


def edinburgh_force(fit, overlaps):
    """Force [N] of stock edinburgh/stiffness along rows of overlaps [m] that begin at the largest.

    P = k1 δ^n, but no more than k2 (δ^n - δp^n) with δp^n = (1 - k1/k2) δmax^n, and no less than 0
    (normal_model_edinburgh_stiffness.h of LIGGGHTS 3.8.0, without adhesion).
    """
    power = overlaps**fit.exponent
    kept = (1.0 - 1.0 / fit.ratio) * power[:, :1]
    return fit.stiffness * np.maximum(np.minimum(power, fit.ratio * (power - kept)), 0.0)


def edinburgh_error(reference, peaks):
    """(largest and mean force error of the best fit of stock edinburgh over the peaks, its load [N])."""
    overlaps, forces = reference_paths(reference, peaks)
    tried = []
    for load in np.geomspace(peaks.min(), peaks.max(), 25):
        fit = edinburgh_fit(reference, float(load))
        tried.append((*_largest(edinburgh_force(fit, overlaps), forces), float(load)))
    return min(tried)


def cdm_error(reference, peaks, yield_pressure, poisson=0.25):
    """(largest, mean force error, (sigmaMax [Pa], alpha)) of the best Conical Damage Model, run in YADE on one contact."""
    overlaps, forces = reference_paths(reference, peaks)
    overlaps = np.maximum(overlaps, 0.0)
    contact = reference.contact
    options = [(s * yield_pressure, a) for s in CDM_STRENGTHS for a in CDM_SLOPES]
    given = {
        "young": 2.0 * contact.modulus * (1.0 - poisson**2),
        "poisson": poisson,
        "density": DENSITY,
        "radius": 2.0 * contact.radius,
        "paths": overlaps.tolist(),
        "ways": [{"model": "cdm", "cdm": option} for option in options],
    }
    found = np.array(under_yade("costs/yade_cost.py", given))
    return min((*_largest(one, forces), option) for one, option in zip(found, options, strict=True))


def force_error(way, reference, peaks, yield_pressure):
    """Largest force error of a `Way` against `reference` (one contact) over `peaks` [N], loading and unloading."""
    if way.model == "cdm":
        return cdm_error(reference, peaks[:: max(1, peaks.size // 16)], yield_pressure)[0]
    if way.model == "edinburgh":
        return edinburgh_error(reference, peaks)[0]
    sample = Sample(reference.contact, peaks, np.full(peaks.size, 1.0 / peaks.size))
    law = bind_law(HERTZ, reference.contact) if way.model == "hertz" else way.bind(reference.contact)
    worst = float(error_of(law, reference, sample, "force", True).max())
    return worst if math.isfinite(worst) else math.nan


# --- the laws that users of other codes have, each fitted as well as it can be


PEERS = (HERTZ, THORNTON_NING, CONICAL_DAMAGE, WALTON_BRAUN, LUDING, EEPA)
TESTS_HELD = (("SS(12-18)", 100.0), ("RFC10", 450.0))
"""Granite tests, and the largest force [N] of each."""


class Held(NamedTuple):
    """A peer fitted to a granite contact, loaded to half the force, unloaded, loaded to all of it, unloaded."""

    test: str
    law: str
    unloading: str
    parameters: dict  # name → value, SI
    rms: float  # difference in displacement over the largest displacement: root mean square
    worst: float  # largest
    loading: float  # largest on first loading to the largest force
    left: float  # of the displacement left at the end of unloading


def made_points(test, force, steps=30):
    """(displacement [m], force [N]) of `candidates.RICHEST` on a granite test's contact, unloaded twice, to 2 % of the load."""
    reference = bind_law(RICHEST.law, test.contact, RICHEST.unloading, **options_for(RICHEST.law, test))
    path = force_controlled(reference, [0.5 * force, 0.01 * force, force, 0.02 * force], steps)
    keep = path.force >= 0.005 * force
    return path.overlap[keep], path.force[keep]


def held_together(laws=PEERS, tests=TESTS_HELD, progress=iter):
    """`Held` of each law on each test: its best fit (`fit`, every rule that it is fitted with) to the reference's points."""
    found = []
    with quiet(), np.errstate(all="ignore"):
        for (name, force), law in progress([(test, law) for test in tests for law in laws]):
            test = find_test(name)
            displacement, loads = made_points(test, force)
            best = fit(np.stack([displacement, loads], 1), test.contact, laws=[law]).best
            off = np.abs(best.displacement - displacement) / displacement.max()
            first = loads >= np.maximum.accumulate(loads)
            values = {n: e.value for n, e in best.parameters.items()}
            rms, left = float(np.sqrt(np.mean(off**2))), float(off[-1])
            found.append(Held(name, law, best.unloading, values, rms, float(off.max()), float(off[first].max()), left))
    return found


def held_table(rows):
    """The rows as text."""
    lines = [
        f"{'':12}{'law':16}{'unloading':11}{'rms':>8}{'worst':>8}{'loading':>9}{'left':>8}   fitted",
        f"{'':39}{'difference in displacement over the largest (%)':>33}",
    ]
    for r in rows:
        values = ", ".join(f"{name} {value:.3g}" for name, value in r.parameters.items())
        errors = f"{100 * r.rms:8.2f}{100 * r.worst:8.2f}{100 * r.loading:9.2f}{100 * r.left:8.2f}"
        lines.append(f"{r.test:12}{r.law:16}{r.unloading:11}{errors}   {values}")
    return "\n".join(lines)
