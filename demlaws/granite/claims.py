"""Statements of the papers compared with the laws that ran: four verdicts, and the numbers behind each.

A sentence about measured data could be decided by measured points alone, which are not public; a sentence that a rule or a
chosen parameter makes true is built in, and says nothing for or against the law.
"""

import functools
import math
from typing import NamedTuple

import numpy as np

from demlaws import granite, regime
from demlaws.errors import quiet
from demlaws.granite import (
    CONE_DIMENSION,
    MICRO,
    ROUGH_SPHERES,
    bind,
    displacement_gained,
    find_test,
    hertz_stiffness,
    run_test,
    stages_of,
    stiffness_at,
)
from demlaws.laws import GODDARD, GREENWOOD_TRIPP, HERTZ, POHRT_POPOV, RMS, ROUGH_PLASTIC, YIP_VENART
from demlaws.laws.greenwood_tripp import MU
from demlaws.make import law

REPRODUCED, NOT_REPRODUCED = "reproduced", "not reproduced"
UNDECIDED, BUILT_IN = "cannot be decided without measured points", "built in"


class Claim(NamedTuple):
    """One sentence of a paper, what the run gives, and the verdict."""

    test: str
    claim: str
    gives: str
    verdict: str
    criterion: str = ""  # of the verdict: when the claim counts as reproduced, or why it is built in or cannot be decided


def _verdict(holds):
    return REPRODUCED if holds else NOT_REPRODUCED


def granite_claims(tests=None):
    """Every claim of Altuhafi, Baudet & Coop 2023 that can be compared with a run; tests: those that concern one of these."""
    with quiet():
        get = functools.cache(lambda name, test: bind(name, find_test(test)))
        claims = [claim for group in _GROUPS for claim in group(get)]
    return claims if tests is None else [c for c in claims if any(name in _concerned(c) for name in tests)]


def _concerned(claim):
    """Names of the tests that a claim concerns."""
    groups = {"rough spheres": ROUGH_SPHERES, "all spheres": [t.name for t in granite.TESTS[:5]]}
    names = [t.name for t in granite.TESTS]
    return groups.get(claim.test) or [n for n in names if n in claim.test or n.partition("(")[0] in claim.test.split(", ")]


def _open(test, claim, gives, *tests, why="it is about measured points"):
    """A claim about measured points of these tests."""
    missing = f"no points of {', '.join(tests)}"
    return Claim(test, claim, "; ".join(filter(None, (gives, missing))), UNDECIDED, why)


def _smooth_claims(get):
    very_smooth = find_test("VS(18-18)")
    ratio = {
        load: stiffness_at(get(POHRT_POPOV, very_smooth.name), load) / hertz_stiffness(very_smooth, load)
        for load in (0.5, 2.0, 10.0)
    }
    rms = {load: stiffness_at(get(RMS, very_smooth.name), load) / hertz_stiffness(very_smooth, load) for load in (2.0, 10.0)}
    yield Claim(
        very_smooth.name,
        "Hertz stiffness after the initial loading, even before 10 N",
        f"Pohrt-Popov K/K_H = {ratio[0.5]:.3f} at 0.5 N, {ratio[2.0]:.3f} at 2 N, {ratio[10.0]:.3f} at 10 N; "
        f"RMS {rms[2.0]:.3f} at 2 N, {rms[10.0]:.3f} at 10 N",
        _verdict(min(ratio[2.0], ratio[10.0], *rms.values()) > 0.9),
        "K/K_H above 0.9 from 2 N by both laws",
    )
    others = {t: stiffness_at(get(POHRT_POPOV, t), 10.0) / hertz_stiffness(find_test(t), 10.0) for t in ROUGH_SPHERES}
    yield Claim(
        very_smooth.name,
        "of all spheres the closest to the Hertz stiffness",
        f"Pohrt-Popov K/K_H at 10 N: {ratio[10.0]:.3f}, the others {min(others.values()):.2f} to {max(others.values()):.2f}",
        BUILT_IN,
        "by every rough law K/K_H falls with σ, which is smallest here",
    )
    displacements = {
        name: [displacement_gained(get(name, t)) / MICRO for t in ("RS(18-18)", "SS(18-18)", "VS(18-18)")]
        for name in (POHRT_POPOV, RMS, YIP_VENART)
    }
    yield Claim(
        "RS(18-18), SS(18-18), VS(18-18)",
        "softness in the order RS(18-18) > SS(18-18) > VS(18-18)",
        "µm gained to 100 N: " + "; ".join(f"{n} {' > '.join(f'{v:.1f}' for v in row)}" for n, row in displacements.items()),
        BUILT_IN,
        "every rough law is softer for a larger σ",
    )


def _sphere_claims(get):
    softer = {t: displacement_gained(get(POHRT_POPOV, t)) / displacement_gained(get(HERTZ, t)) for t in ROUGH_SPHERES}
    yield _open(
        "rough spheres",
        "Hertz is significantly too stiff in every rough test",
        "Pohrt-Popov gains " + ", ".join(f"{v:.2f}" for v in softer.values()) + " times Hertz's displacement to 100 N",
        *ROUGH_SPHERES,
    )
    low, high = (
        {t: stiffness_at(get(POHRT_POPOV, t), load) / hertz_stiffness(find_test(t), load) for t in ROUGH_SPHERES}
        for load in (1.0, 100.0)
    )
    yield Claim(
        "rough spheres",
        "the effect of roughness is very significant at lower load levels",
        "Pohrt-Popov K/K_H " + "; ".join(f"{t} {low[t]:.2f} at 1 N, {high[t]:.2f} at 100 N" for t in ROUGH_SPHERES),
        BUILT_IN,
        "K/K_H of every rough law rises with the load",
    )
    rough = find_test("RS(18-18)")
    ratio = regime.pressure_ratio(rough.contact, 100.0)
    yield Claim(
        rough.name,
        "no change of the bulk form over the testing load range",
        f"p(0)/H_m = {ratio:.2f} at 100 N by the closed fit of Jamari & Schipper, below 0.6",
        _verdict(ratio < regime.YIELD_RATIO - regime.BAND),
        f"p(0)/H_m below {regime.YIELD_RATIO - regime.BAND:g}",
    )
    hertz = displacement_gained(get(HERTZ, "VS(18-18)"))
    difference = {t: displacement_gained(get(POHRT_POPOV, t)) - hertz for t in ("SS(18-18)", "RS(18-18)")}
    sigma = {t: find_test(t).roughness for t in difference}
    yield Claim(
        "SS(18-18), RS(18-18)",
        "displacements differ from those of the smooth spheres by more than the roughness",
        "to 100 N, Pohrt-Popov: "
        + ", ".join(f"{t} {d / MICRO:.1f} µm more for σ = {sigma[t] / MICRO:.2f} µm" for t, d in difference.items()),
        _verdict(all(d > sigma[t] for t, d in difference.items())),
        "the difference is above σ in both tests",
    )
    yield Claim(
        "SS(12-18)",
        "unloading is Hertz-like",
        "the laws were run with the Hertz rule, which unloads with K/K_H = 1",
        BUILT_IN,
        "true of the unloading rule by construction",
    )
    yield _open(
        "SS(12-18)",
        "of Hertz, RMS and Pohrt-Popov the last agrees best with the unloading",
        "each along its own curve",
        "SS(12-18)",
    )


_EARLY = ((0.0, 0.5), (0.1, 2.0))
"""Loads [N] between which displacements at low load are compared."""
_LATE = np.geomspace(10.0, 100.0, 20)


def _gained(get, name, test, low, high):
    """Displacement [m] that a law gains in a test between two loads [N], 0 included."""
    bound = get(name, test)
    return float(bound.overlap(high) - (bound.overlap(low) if low else 0.0))


def _law_claims(get):
    threshold = granite.threshold_force(find_test("SS(18-18)"))
    yield Claim(
        "SS(18-18)",
        "Pohrt-Popov crosses over to Hertz at around 73 N",
        f"{threshold:.1f} N from the paper's own Eqs. 8 and 9 and its table",
        _verdict(abs(threshold - 73.0) < 3.0),
        "within 3 N of 73 N",
    )
    exponents = [0.2567 * dimension for dimension in (2.17, 2.33)]
    pairs = sorted(0.2567 * find_test(t).fractal_dimension for t in ROUGH_SPHERES)
    yield Claim(
        "rough spheres",
        "exponent of stiffness against load around 0.56 for fractal dimensions of 2.17 to 2.33",
        f"0.2567 Df = {exponents[0]:.3f} to {exponents[1]:.3f}; of the four tests' pairs {pairs[0]:.3f} to {pairs[-1]:.3f}",
        _verdict(all(abs(m - 0.56) < 0.01 for m in pairs)),
        "within 0.01 of 0.56 for the pairs of all four tests",
    )
    yield Claim(
        "SS(18-18), RS(18-18)",
        "roughness moves the Pohrt-Popov stiffness line and leaves its gradient",
        "K = c P^(0.2567 Df): σ enters c alone",
        BUILT_IN,
        "true of the law's formula",
    )
    for name in (RMS, POHRT_POPOV):
        yield _open("rough spheres", f"{name} agrees with the data to about 70 N", "", *ROUGH_SPHERES)
    spheres = ("SS(18-18)", "SS(12-18)")
    over = {
        name: [stiffness_at(get(name, t), p) / stiffness_at(get(YIP_VENART, t), p) for t in spheres for p in (70.0, 100.0)]
        for name in (RMS, POHRT_POPOV)
    }
    yield Claim(
        "SS(18-18), SS(12-18)",
        "above about 70 N RMS and Pohrt-Popov are too stiff",
        "K over that of Yip-Venart, which by the paper fits both, at 70 and 100 N: "
        + "; ".join(f"{name} {min(values):.2f} to {max(values):.2f}" for name, values in over.items()),
        _verdict(all(min(values) > 1.0 for values in over.values())),
        "stiffer than Yip-Venart at 70 and 100 N in both tests",
    )
    yield _open("SF(12), RS(18-18)", "above about 70 N RMS and Pohrt-Popov are too stiff", "", "SF(12)", "RS(18-18)")


def _comparison_claims(get):
    early = {t: [_gained(get, RMS, t, *span) / _gained(get, POHRT_POPOV, t, *span) for span in _EARLY] for t in ROUGH_SPHERES}
    yield _open(
        "rough spheres",
        "RMS overestimates deformation at low load, where Pohrt-Popov is good",
        "RMS over Pohrt-Popov, displacement "
        + " and ".join(f"from {low:g} to {high:g} N" for low, high in _EARLY)
        + ": "
        + ", ".join(f"{t} {first:.2f} and {second:.2f}" for t, (first, second) in early.items()),
        *ROUGH_SPHERES,
        why="the sign depends on the load from which displacements count, which is not printed",
    )
    yield _open("SS(18-18), SS(12-18)", "Yip-Venart fits both", "", "SS(18-18)", "SS(12-18)")
    soft = displacement_gained(get(YIP_VENART, "SF(12)")) / displacement_gained(get(POHRT_POPOV, "SF(12)"))
    stiff = [stiffness_at(get(YIP_VENART, "SF(12)"), p) / stiffness_at(get(POHRT_POPOV, "SF(12)"), p) for p in _LATE]
    yield _open(
        "SF(12)",
        "Yip-Venart is too soft",
        f"Yip-Venart gains {soft:.2f} times Pohrt-Popov's displacement from 0.1 to 100 N; its stiffness is "
        f"{min(stiff):.2f} to {max(stiff):.2f} times Pohrt-Popov's from 10 to 100 N",
        "SF(12)",
        why="softer by displacement, stiffer by stiffness; the paper does not state which",
    )
    yield _open("rough spheres", "Bahrami suits none of the tests", "", *ROUGH_SPHERES)
    slopes = {t: _nearest_goddard(get(POHRT_POPOV, t), find_test(t).contact) for t in ROUGH_SPHERES}
    yield Claim(
        "rough spheres",
        "Goddard's stiffness might be very similar to Pohrt-Popov's",
        "with the surface slope that comes nearest, K differs from 1 to 100 N by at most "
        + ", ".join(f"{t} {100 * e:.0f} % (β = {b:.3f})" for t, (b, e) in slopes.items()),
        _verdict(all(e < 0.15 for _, e in slopes.values())),
        "K within 15 % from 1 to 100 N in all tests",
    )
    pair = [displacement_gained(get(n, "SS(12-18)")) / MICRO for n in (GREENWOOD_TRIPP, YIP_VENART, POHRT_POPOV)]
    yield Claim(
        "SS(12-18)",
        "elastic or plastic asperities make little difference",
        f"µm gained to 100 N: Greenwood-Tripp (μ = {MU:g} assumed) {pair[0]:.1f}, Yip-Venart {pair[1]:.1f}, "
        f"Pohrt-Popov {pair[2]:.1f}",
        _verdict(max(pair) / min(pair) < 1.15),
        "largest displacement over smallest below 1.15",
    )
    curves = granite.effective_radius(np.array([0.05]))
    values = [float(v[0]) for v in curves.values()]
    yield Claim(
        "a*/a_H",
        "for α below 0.05 Hertz underestimates the contact radius by up to 7 %",
        "at α = 0.05: " + ", ".join(f"{n} {100 * (v - 1):.1f} %" for n, v in zip(curves, values, strict=True)),
        _verdict(max(values) <= 1.07),
        "at most 7 % at α = 0.05",
    )


def _nearest_goddard(reference, contact):
    """(slope, largest relative difference of stiffness from 1 to 100 N) of the Goddard law nearest to `reference`."""
    load = np.geomspace(1.0, 100.0, 30)
    target = reference.stiffness(reference.overlap(load))
    differences = []
    for slope in np.geomspace(0.005, 0.2, 60):
        one = law(GODDARD, contact, slope=float(slope))
        differences.append((float(np.max(np.abs(one.stiffness(one.overlap(load)) / target - 1.0))), float(slope)))
    error, slope = min(differences)
    return slope, error


def _cone_claims(get):
    cone, small = find_test("RFC10"), find_test("FC5")
    rfc, _ = run_test(ROUGH_PLASTIC, cone)
    fc, _ = run_test(ROUGH_PLASTIC, small)
    loads = {cone.name: 20.0, small.name: 7.0}
    for test, run in ((cone, rfc), (small, fc)):
        p, load = run.law.params, loads[test.name]
        stiff = p.yield_stiffness / 1e3
        yield Claim(
            test.name,
            f"the elastic models hold to {load:g} N",
            f"the rough law with p_y = {test.yield_pressure / 1e9:.2f} GPa (K_y = {stiff:.0f} N/mm) yields at "
            f"{p.yield_force:.1f} N: one p_y ties both, unless post_yield_pressure separates them",
            _verdict(abs(p.yield_force / load - 1.0) < 0.1),
            f"yield within 10 % of {load:g} N",
        )
        assumed = f"Df = {CONE_DIMENSION} assumed" + ("" if test is cone else ", σ too")
        yield _open(test.name, f"first loading to {load:g} N follows Pohrt-Popov", assumed, test.name)
    stages = stages_of(rfc)
    over = [s.over_hertz for s in stages if math.isfinite(s.over_hertz)]
    yield Claim(
        cone.name,
        "reloading is nearly Hertz up to gross yield",
        f"reload K/K_H = {min(over):.3f} to {max(over):.3f}",
        BUILT_IN,
        "true of the unloading rule by construction",
    )
    final = [s.final_stiffness / 1e3 for s in stages if s.maximum_force > rfc.law.params.yield_force]
    yield Claim(
        cone.name,
        "after gross yield a constant stiffness of about 5000 N/mm",
        f"{min(final):.0f} to {max(final):.0f} N/mm",
        BUILT_IN,
        "p_y was chosen for it",
    )


def _plastic_claims(get):
    small = find_test("FC5")
    rfc, _ = run_test(ROUGH_PLASTIC, find_test("RFC10"))
    fc, _ = run_test(ROUGH_PLASTIC, small)
    stages = stages_of(rfc)
    load = np.array([s.maximum_force for s in stages])
    plastic = np.array([s.plastic_overlap for s in stages])
    slopes = np.diff(plastic) / np.diff(load) / MICRO
    yield Claim(
        rfc.test.name,
        "cumulative plastic deformation is nearly linear in the maximum load",
        "µm: "
        + ", ".join(f"{d / MICRO:.1f} at {f:.0f} N" for f, d in zip(load, plastic, strict=True))
        + f"; slope from {slopes.min():.2f} to {slopes.max():.2f} µm/N"
        + (f" ({rfc.beyond})" if rfc.beyond else ""),
        _verdict(slopes.min() > 0.7 * slopes.max()),
        "smallest slope above 0.7 of the largest",
    )
    above = (10.0, 20.0)
    elastic = {f: stiffness_at(get(POHRT_POPOV, small.name), f) / 1e3 for f in above}
    ran = {f: stiffness_at(fc.law, f) / 1e3 for f in above}
    jump = law(ROUGH_PLASTIC, small.contact, yield_pressure=small.yield_pressure, yield_at="load")
    yield Claim(
        small.name,
        "above 7 N much stiffer than Pohrt-Popov",
        ", ".join(f"at {f:g} N rough-plastic {ran[f]:.0f} N/mm, Pohrt-Popov {elastic[f]:.0f}" for f in above)
        + f"; yielding at a smooth tip's load ({jump.params.yield_force:.1f} N, yield_at='load') K jumps up: "
        + ", ".join(f"{stiffness_at(jump, f) / 1e3:.0f} N/mm at {f:g} N" for f in above),
        _verdict(all(ran[f] > 1.2 * elastic[f] for f in above)),
        "stiffness above 1.2 times Pohrt-Popov's at 10 and 20 N",
    )
    other = {round(s.maximum_force): s.plastic_overlap for s in stages_of(fc) if s.stage == 4}
    ratios = {f: other[round(f)] / d for f, d in zip(load, plastic, strict=True) if round(f) in other}
    yield Claim(
        "RFC10, FC5",
        "plastic deformations of the two cones compare well",
        "FC5 over RFC10: " + ", ".join(f"{v:.2f} at {f:.0f} N" for f, v in ratios.items()) + " (FC5's σ and both Df assumed)",
        _verdict(all(0.67 < v < 1.5 for v in ratios.values())),
        "ratio between 0.67 and 1.5 at every load",
    )


_GROUPS = (_smooth_claims, _sphere_claims, _law_claims, _comparison_claims, _cone_claims, _plastic_claims)
"""Functions that yield claims, in the order of the table."""


# --- sensitivity of the cones


class Sensitivity(NamedTuple):
    """What an uncertain input of FC5 does to Pohrt-Popov."""

    radius: float  # [m]
    fractal_dimension: float
    displacement: float  # gained from 0.1 N to 7 N [m]
    stiffness: float  # at 7 N [N/m]
    threshold: float  # F [N]


def cone_sensitivity():
    """FC5 with each radius that the paper measured (0.31, 0.35 mm by microscope, 0.62 by camera) and Df from 2.1 to 2.35."""
    base, rows = find_test("FC5"), []
    with quiet():
        for radius in (0.31e-3, 0.35e-3, 0.62e-3):
            for dimension in (2.10, 2.22, 2.35):
                one = law(POHRT_POPOV, base.contact.with_values(radius=radius, fractal_dimension=dimension))
                displacement, stiffness = displacement_gained(one, 0.1, 7.0), stiffness_at(one, 7.0)
                threshold = float(one.force(1.0 / one.params.inverse_threshold))
                rows.append(Sensitivity(radius, dimension, displacement, stiffness, threshold))
    return rows
