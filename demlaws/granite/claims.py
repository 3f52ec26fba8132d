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
from demlaws.laws.greenwood_tripp import MU
from demlaws.laws.names import GODDARD, GREENWOOD_TRIPP, HERTZ, POHRT_POPOV, RMS, ROUGH_PLASTIC, YIP_VENART
from demlaws.make import law

REPRODUCED, NOT_REPRODUCED = "reproduced", "not reproduced"
UNDECIDED, BUILT_IN = "cannot be decided without measured points", "built in"


class Claim(NamedTuple):
    """One sentence of a paper, what the run gives, and the verdict."""

    test: str
    claim: str
    gives: str
    verdict: str


def _verdict(holds):
    return REPRODUCED if holds else NOT_REPRODUCED


def granite_claims(tests=None):
    """Every claim of Altuhafi, Baudet & Coop 2023 that can be compared with a run; tests: those that concern one of these."""
    with quiet():
        get = functools.cache(lambda name, test: bind(name, find_test(test)))
        claims = [claim for group in (_sphere_claims, _law_claims, _cone_claims) for claim in group(get)]
    return claims if tests is None else [c for c in claims if any(name in _concerned(c) for name in tests)]


def _concerned(claim):
    """Names of the tests that a claim concerns."""
    groups = {"rough spheres": ROUGH_SPHERES, "all spheres": [t.name for t in granite.TESTS[:5]]}
    names = [t.name for t in granite.TESTS]
    return groups.get(claim.test) or [n for n in names if n in claim.test or n.partition("(")[0] in claim.test.split(", ")]


def _open(test, claim, gives, *tests):
    """A claim about measured points of these tests."""
    missing = f"no points of {', '.join(tests)}"
    return Claim(test, claim, "; ".join(filter(None, (gives, missing))), UNDECIDED)


def _sphere_claims(get):
    very_smooth = find_test("VS(18-18)")
    ratio = {
        load: stiffness_at(get(POHRT_POPOV, very_smooth.name), load) / hertz_stiffness(very_smooth, load)
        for load in (0.5, 2.0, 10.0)
    }
    rms = stiffness_at(get(RMS, very_smooth.name), 10.0) / hertz_stiffness(very_smooth, 10.0)
    yield Claim(
        very_smooth.name,
        "closest to the Hertz stiffness after the initial loading, even before 10 N",
        f"Pohrt-Popov K/K_H = {ratio[0.5]:.3f} at 0.5 N, {ratio[2.0]:.3f} at 2 N, {ratio[10.0]:.3f} at 10 N; "
        f"RMS {rms:.3f} at 10 N",
        _verdict(min(ratio[2.0], ratio[10.0], rms) > 0.9),
    )
    displacements = {
        name: [displacement_gained(get(name, t)) / MICRO for t in ("RS(18-18)", "SS(18-18)", "VS(18-18)")]
        for name in (POHRT_POPOV, RMS, YIP_VENART)
    }
    yield Claim(
        "RS(18-18), SS(18-18), VS(18-18)",
        "softness in the order RS(18-18) > SS(18-18) > VS(18-18)",
        "µm gained to 100 N: " + "; ".join(f"{n} {' > '.join(f'{v:.1f}' for v in row)}" for n, row in displacements.items()),
        BUILT_IN,  # every law is softer for a larger σ
    )
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
        BUILT_IN,  # K/K_H of every rough law rises with the load
    )
    rough = find_test("RS(18-18)")
    ratio = regime.pressure_ratio(rough.contact, 100.0)
    yield Claim(
        rough.name,
        "no change of the bulk form over the testing load range",
        f"p(0)/H_m = {ratio:.2f} at 100 N by the closed fit of Jamari & Schipper, below 0.6",
        _verdict(ratio < regime.YIELD_RATIO - regime.BAND),
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
    )
    yield Claim(
        "SS(12-18)",
        "unloading is Hertz-like",
        "the laws were run with the Hertz rule, which unloads with K/K_H = 1 by construction",
        BUILT_IN,
    )
    yield _open(
        "SS(12-18)",
        "of Hertz, RMS and Pohrt-Popov the last agrees best with the unloading",
        "each along its own curve",
        "SS(12-18)",
    )


def _law_claims(get):
    threshold = granite.threshold_force(find_test("SS(18-18)"))
    yield Claim(
        "SS(18-18)",
        "Pohrt-Popov crosses over to Hertz at around 73 N",
        f"{threshold:.1f} N from the paper's own Eqs. 8 and 9 and its table",
        _verdict(abs(threshold - 73.0) < 3.0),
    )
    exponents = [0.2567 * dimension for dimension in (2.17, 2.33)]
    yield Claim(
        "rough spheres",
        "exponent of stiffness against load around 0.56 for fractal dimensions of 2.17 to 2.33",
        f"0.2567 Df = {exponents[0]:.3f} to {exponents[1]:.3f}, {np.mean(exponents):.3f} in the middle",
        _verdict(all(abs(m - 0.56) < 0.01 for m in exponents)),
    )
    yield Claim(
        "SS(18-18), RS(18-18)",
        "roughness moves the Pohrt-Popov stiffness line and leaves its gradient",
        "K = c P^(0.2567 Df): σ enters c alone",
        BUILT_IN,
    )
    for name in (RMS, POHRT_POPOV):
        yield _open("rough spheres", f"{name} agrees with the data to about 70 N", "", *ROUGH_SPHERES)
    yield _open("rough spheres", "above about 70 N RMS and Pohrt-Popov are too stiff", "", *ROUGH_SPHERES)
    early = {t: float(get(RMS, t).overlap(0.5) / get(POHRT_POPOV, t).overlap(0.5)) for t in ROUGH_SPHERES}
    yield Claim(
        "rough spheres",
        "RMS overestimates deformation at low load, where Pohrt-Popov is good",
        "by the paper's own inputs RMS gives "
        + ", ".join(f"{t} {early[t]:.2f}" for t in ROUGH_SPHERES)
        + " of Pohrt-Popov's overlap at 0.5 N: not more",
        _verdict(all(value > 1.0 for value in early.values())),
    )
    yield _open("SS(18-18), SS(12-18)", "Yip-Venart fits both", "", "SS(18-18)", "SS(12-18)")
    soft = displacement_gained(get(YIP_VENART, "SF(12)")) / displacement_gained(get(POHRT_POPOV, "SF(12)"))
    gives = f"Yip-Venart gains {soft:.2f} times Pohrt-Popov's displacement"
    yield _open("SF(12)", "Yip-Venart is too soft", gives, "SF(12)")
    yield _open("rough spheres", "Bahrami suits none of the tests", "", *ROUGH_SPHERES)
    slopes = {t: _nearest_goddard(get(POHRT_POPOV, t), find_test(t).contact) for t in ROUGH_SPHERES}
    yield Claim(
        "rough spheres",
        "Goddard's stiffness might be very similar to Pohrt-Popov's",
        "with the surface slope that comes nearest, K differs from 1 to 100 N by at most "
        + ", ".join(f"{t} {100 * e:.0f} % (β = {b:.3f})" for t, (b, e) in slopes.items()),
        _verdict(all(e < 0.15 for _, e in slopes.values())),
    )
    pair = [displacement_gained(get(n, "SS(12-18)")) / MICRO for n in (GREENWOOD_TRIPP, YIP_VENART, POHRT_POPOV)]
    yield Claim(
        "SS(12-18)",
        "elastic or plastic asperities make little difference",
        f"µm gained to 100 N: Greenwood-Tripp (μ = {MU:g} assumed) {pair[0]:.1f}, Yip-Venart {pair[1]:.1f}, "
        f"Pohrt-Popov {pair[2]:.1f}",
        _verdict(max(pair) / min(pair) < 1.15),
    )
    curves = granite.effective_radius(np.array([0.05]))
    values = [float(v[0]) for v in curves.values()]
    yield Claim(
        "a*/a_H",
        "for α below 0.05 Hertz underestimates the contact radius by up to 7 %",
        "at α = 0.05: " + ", ".join(f"{n} {100 * (v - 1):.1f} %" for n, v in zip(curves, values, strict=True)),
        _verdict(max(values) <= 1.07),
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
        )
        assumed = f"Df = {CONE_DIMENSION} assumed" + ("" if test is cone else ", σ too")
        yield _open(test.name, f"first loading to {load:g} N follows Pohrt-Popov", assumed, test.name)
    stages = stages_of(rfc)
    over = [s.over_hertz for s in stages if math.isfinite(s.over_hertz)]
    yield Claim(
        cone.name,
        "reloading is nearly Hertz up to gross yield",
        f"reload K/K_H = {min(over):.3f} to {max(over):.3f}: the rule that was run",
        BUILT_IN,
    )
    final = [s.final_stiffness / 1e3 for s in stages if s.maximum_force > rfc.law.params.yield_force]
    yield Claim(
        cone.name,
        "after gross yield a constant stiffness of about 5000 N/mm",
        f"{min(final):.0f} to {max(final):.0f} N/mm: p_y was chosen for it",
        BUILT_IN,
    )
    load = np.array([s.maximum_force for s in stages])
    plastic = np.array([s.plastic_overlap for s in stages])
    slopes = np.diff(plastic) / np.diff(load) / MICRO
    yield Claim(
        cone.name,
        "cumulative plastic deformation is nearly linear in the maximum load",
        "µm: "
        + ", ".join(f"{d / MICRO:.1f} at {f:.0f} N" for f, d in zip(load, plastic, strict=True))
        + f"; slope from {slopes.min():.2f} to {slopes.max():.2f} µm/N"
        + (f" ({rfc.beyond})" if rfc.beyond else ""),
        _verdict(slopes.min() > 0.7 * slopes.max()),
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
    )
    other = {round(s.maximum_force): s.plastic_overlap for s in stages_of(fc) if s.stage == 4}
    ratios = {f: other[round(f)] / d for f, d in zip(load, plastic, strict=True) if round(f) in other}
    yield Claim(
        "RFC10, FC5",
        "plastic deformations of the two cones compare well",
        "FC5 over RFC10: " + ", ".join(f"{v:.2f} at {f:.0f} N" for f, v in ratios.items()) + " (FC5's σ and both Df assumed)",
        _verdict(all(0.67 < v < 1.5 for v in ratios.values())),
    )


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
