"""How far the engines' own contact models are from a law, at the same overlaps."""

import math

import numpy as np

from demlaws.liggghts.export import stock_fit
from demlaws.make import law as bind_law
from demlaws.materials import DENSITY
from demlaws.measure.costs import under_yade
from demlaws.measure.errors import FRACTIONS, Loaded, Sample, error_of

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


def edinburgh_force(fit, overlaps):
    """Force [N] of stock edinburgh/stiffness along rows of overlaps [m] that begin at the largest.

    P = k1 δ^n, but no more than k2 (δ^n - δp^n) with δp^n = (1 - k1/k2) δmax^n, and no less than 0
    (normal_model_edinburgh_stiffness.h of LIGGGHTS 3.8.0, without adhesion).
    """
    n, first = fit.parameters["overlapExponent"], fit.parameters["LoadingStiffness"]
    ratio = fit.parameters["UnloadingStiffness"]
    power = overlaps**n
    kept = (1.0 - 1.0 / ratio) * power[:, :1]
    return first * np.maximum(np.minimum(power, ratio * (power - kept)), 0.0)


def edinburgh_error(reference, peaks):
    """(largest and mean force error of the best fit of stock edinburgh over the peaks, its load [N])."""
    overlaps, forces = reference_paths(reference, peaks)
    tried = []
    for load in np.geomspace(peaks.min(), peaks.max(), 25):
        fit = stock_fit(reference, float(load), "edinburgh")
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
    found = np.array(under_yade("yade_cost.py", given))
    return min((*_largest(one, forces), option) for one, option in zip(found, options, strict=True))


def force_error(way, reference, peaks, yield_pressure):
    """Largest force error of a `Way` against `reference` (one contact) over `peaks` [N], loading and unloading."""
    if way.model == "cdm":
        return cdm_error(reference, peaks[:: max(1, peaks.size // 16)], yield_pressure)[0]
    if way.model == "edinburgh":
        return edinburgh_error(reference, peaks)[0]
    sample = Sample(reference.contact, peaks, np.full(peaks.size, 1.0 / peaks.size))
    law = bind_law("hertz", reference.contact) if way.model == "hertz" else way.bind(reference.contact)
    worst = float(error_of(law, reference, sample, "force", True).max())
    return worst if math.isfinite(worst) else math.nan
