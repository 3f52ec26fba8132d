"""Statements of the granite paper about spheres."""

import numpy as np

from demlaws import granite
from demlaws.granite import MICRO, MODULI, ROUGH_SPHERES, displacement_gained, hertz_stiffness, stiffness_at
from demlaws.granite.verdicts import AROUND, BUILT_IN, SIMILAR, Claim, around, open_claim, verdict_of
from demlaws.laws import GODDARD, GREENWOOD_TRIPP, HERTZ, POHRT_POPOV, RMS, YIP_VENART
from demlaws.laws.greenwood_tripp import MU
from demlaws.make import law
from demlaws.solvers import criterion

_ROUGH = (POHRT_POPOV, RMS, YIP_VENART)
"""The laws that the paper finds to fit rough spheres."""


def _printed_claims(get):
    """The three printed numbers that depend on E*."""
    threshold = granite.threshold_force(get.test("SS(18-18)"))
    yield Claim(
        "SS(18-18)",
        "Pohrt-Popov crosses over to Hertz at around 73 N",
        f"{threshold:.1f} N from the paper's own Eqs. 8 and 9 and its table",
        verdict_of(around(threshold, 73.0)),
        "within 10 % of 73 N",
    )
    field = hertz_radius(get, 4.4e-3, 100.0)
    yield Claim(
        "all spheres",
        "field of view of 0.2 mm, based on Hertz's contact between spheres of 4.4 mm equivalent radius at about 100 N",
        f"Hertz's contact radius {1e3 * field:.3f} mm",
        verdict_of(round(1e3 * field, 2) == 0.2),
        "contact radius 0.20 mm to two digits",
    )
    tips = [hertz_radius(get, radius, 100.0) for radius in (0.31e-3, 0.35e-3)]
    yield Claim(
        "FC5",
        "Hertz's contact radius of a cone's tip is less than 0.09 mm at 100 N",
        f"{1e3 * tips[0]:.4f} to {1e3 * tips[1]:.4f} mm for tips of 0.31 to 0.35 mm",
        verdict_of(max(tips) < 0.09e-3),
        "below 0.09 mm for tips of 0.31 to 0.35 mm",
    )


def hertz_radius(get, radius, load):
    """a_H = (3PR/(4E*))^(1/3) [m] of granite."""
    return (0.75 * load * radius / MODULI[get.modulus]) ** (1 / 3)


def _smooth_claims(get):
    very_smooth = get.test("VS(18-18)")
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
        verdict_of(min(ratio[2.0], ratio[10.0], *rms.values()) > 0.9),
        "K/K_H above 0.9 from 2 N by both laws",
    )
    others = {t: stiffness_at(get(POHRT_POPOV, t), 10.0) / hertz_stiffness(get.test(t), 10.0) for t in ROUGH_SPHERES}
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
    yield open_claim(
        "rough spheres",
        "Hertz is significantly too stiff in every rough test",
        "Pohrt-Popov gains " + ", ".join(f"{v:.2f}" for v in softer.values()) + " times Hertz's displacement to 100 N",
        *ROUGH_SPHERES,
    )
    low, high = (
        {t: stiffness_at(get(POHRT_POPOV, t), load) / hertz_stiffness(get.test(t), load) for t in ROUGH_SPHERES}
        for load in (1.0, 100.0)
    )
    yield Claim(
        "rough spheres",
        "the effect of roughness is very significant at lower load levels",
        "Pohrt-Popov K/K_H " + "; ".join(f"{t} {low[t]:.2f} at 1 N, {high[t]:.2f} at 100 N" for t in ROUGH_SPHERES),
        BUILT_IN,
        "K/K_H of every rough law rises with the load",
    )
    rough = get.test("RS(18-18)")
    ratio = criterion.pressure_ratio(rough.contact, 100.0)
    yield Claim(
        rough.name,
        "no change of the bulk form over the testing load range",
        f"p(0)/H_m = {ratio:.2f} at 100 N by the closed fit of Jamari & Schipper, below 0.6",
        verdict_of(ratio < criterion.YIELD_RATIO - criterion.BAND),
        f"p(0)/H_m below {criterion.YIELD_RATIO - criterion.BAND:g}",
    )
    hertz = displacement_gained(get(HERTZ, "VS(18-18)"))
    difference = {t: displacement_gained(get(POHRT_POPOV, t)) - hertz for t in ("SS(18-18)", "RS(18-18)")}
    sigma = {t: get.test(t).roughness for t in difference}
    yield Claim(
        "SS(18-18), RS(18-18)",
        "displacements differ from those of the smooth spheres by more than the roughness",
        "to 100 N, Pohrt-Popov: "
        + ", ".join(f"{t} {d / MICRO:.1f} µm more for σ = {sigma[t] / MICRO:.2f} µm" for t, d in difference.items()),
        verdict_of(all(d > sigma[t] for t, d in difference.items())),
        "the difference is above σ in both tests",
    )


def _stiffness_and_unloading_claims(get):
    late = {t: [stiffness_at(get(n, t), 100.0) / hertz_stiffness(get.test(t), 100.0) for n in _ROUGH] for t in ROUGH_SPHERES}
    smooth = stiffness_at(get(POHRT_POPOV, "VS(18-18)"), 100.0) / hertz_stiffness(get.test("VS(18-18)"), 100.0)
    yield Claim(
        "all spheres",
        "up to 100 N the stiffness does not reach Hertz's but in VS(18-18)",
        f"K/K_H at 100 N by {', '.join(_ROUGH)}: "
        + ", ".join(f"{t} {' '.join(f'{v:.2f}' for v in values)}" for t, values in late.items())
        + f"; VS(18-18) by Pohrt-Popov {smooth:.2f}",
        verdict_of(smooth > 1.0 - AROUND and all(v < 1.0 - AROUND for values in late.values() for v in values)),
        "K/K_H at 100 N below 0.9 in all rough tests by all three laws, above 0.9 in VS(18-18)",
    )
    yield Claim(
        "SS(12-18)",
        "unloading is Hertz-like",
        "the laws were run with the Hertz rule, which unloads with K/K_H = 1",
        BUILT_IN,
        "true of the unloading rule by construction",
    )
    yield open_claim(
        "SS(12-18)",
        "of Hertz, RMS and Pohrt-Popov the last agrees best with the unloading",
        "each along its own curve",
        "SS(12-18)",
    )


_EARLY = ((0.0, 0.5), (0.1, 2.0))
"""Loads [N] between which displacements at low load are compared."""
_LATE = np.geomspace(10.0, 100.0, 20)


def _law_claims(get):
    exponents = [0.2567 * dimension for dimension in (2.17, 2.33)]
    pairs = sorted(0.2567 * get.test(t).fractal_dimension for t in ROUGH_SPHERES)
    yield Claim(
        "rough spheres",
        "exponent of stiffness against load around 0.56 for fractal dimensions of 2.17 to 2.33",
        f"0.2567 Df = {exponents[0]:.3f} to {exponents[1]:.3f}; of the four tests' pairs {pairs[0]:.3f} to {pairs[-1]:.3f}",
        verdict_of(all(around(m, 0.56) for m in pairs)),
        "within 10 % of 0.56 for the pairs of all four tests",
    )
    yield Claim(
        "SS(18-18), RS(18-18)",
        "roughness moves the Pohrt-Popov stiffness line and leaves its gradient",
        "K = c P^(0.2567 Df): σ enters c alone",
        BUILT_IN,
        "true of the law's formula",
    )
    for name in (RMS, POHRT_POPOV):
        yield open_claim("rough spheres", f"{name} agrees with the data to about 70 N", "", *ROUGH_SPHERES)
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
        verdict_of(all(min(values) > 1.0 for values in over.values())),
        "stiffer than Yip-Venart at 70 and 100 N in both tests",
    )
    yield open_claim("SF(12), RS(18-18)", "above about 70 N RMS and Pohrt-Popov are too stiff", "", "SF(12)", "RS(18-18)")


def _comparison_claims(get):
    early = {
        t: [displacement_gained(get(RMS, t), *span) / displacement_gained(get(POHRT_POPOV, t), *span) for span in _EARLY]
        for t in ROUGH_SPHERES
    }
    yield open_claim(
        "rough spheres",
        "RMS overestimates deformation at low load, where Pohrt-Popov is good",
        "RMS over Pohrt-Popov, displacement "
        + " and ".join(f"from {low:g} to {high:g} N" for low, high in _EARLY)
        + ": "
        + ", ".join(f"{t} {first:.2f} and {second:.2f}" for t, (first, second) in early.items()),
        *ROUGH_SPHERES,
        why="the sign depends on the load from which displacements count, which is not printed",
    )
    yield open_claim("SS(18-18), SS(12-18)", "Yip-Venart fits both", "", "SS(18-18)", "SS(12-18)")
    soft = displacement_gained(get(YIP_VENART, "SF(12)")) / displacement_gained(get(POHRT_POPOV, "SF(12)"))
    stiff = [stiffness_at(get(YIP_VENART, "SF(12)"), p) / stiffness_at(get(POHRT_POPOV, "SF(12)"), p) for p in _LATE]
    yield open_claim(
        "SF(12)",
        "Yip-Venart is too soft",
        f"Yip-Venart gains {soft:.2f} times Pohrt-Popov's displacement from 0.1 to 100 N; its stiffness is "
        f"{min(stiff):.2f} to {max(stiff):.2f} times Pohrt-Popov's from 10 to 100 N",
        "SF(12)",
        why="softer by displacement, stiffer by stiffness; the paper does not state which",
    )
    yield open_claim("rough spheres", "Bahrami suits none of the tests", "", *ROUGH_SPHERES)


def _likeness_claims(get):
    slopes = {t: _nearest_goddard(get(POHRT_POPOV, t), get.test(t).contact) for t in ROUGH_SPHERES}
    yield Claim(
        "rough spheres",
        "Goddard's stiffness might be very similar to Pohrt-Popov's",
        "with the surface slope that comes nearest, K differs from 1 to 100 N by at most "
        + ", ".join(f"{t} {100 * e:.0f} % (β = {b:.3f})" for t, (b, e) in slopes.items()),
        verdict_of(all(e < SIMILAR - 1.0 for _, e in slopes.values())),
        "with one slope per test K within a tenth of a decade (26 %) from 1 to 100 N, as lines of a double logarithmic figure",
    )
    pair = [displacement_gained(get(n, "SS(12-18)")) / MICRO for n in (GREENWOOD_TRIPP, YIP_VENART, POHRT_POPOV)]
    yield Claim(
        "SS(12-18)",
        "elastic or plastic asperities make little difference",
        f"µm gained to 100 N: Greenwood-Tripp (μ = {MU:g} assumed) {pair[0]:.1f}, Yip-Venart {pair[1]:.1f}, "
        f"Pohrt-Popov {pair[2]:.1f}",
        verdict_of(max(pair) / min(pair) < 1.15),
        "largest displacement over smallest below 1.15",
    )
    alphas = np.array([1.0, 5.0])
    back = [_back_calculated(get, t, alphas) / (2.4 - 2.8 / (alphas + 2.0)) for t in ROUGH_SPHERES]
    yield open_claim(
        "rough spheres",
        "Eq. 5 overestimates the contact radius a* at larger α (Fig. 4)",
        "a* = √(R δ) of Pohrt-Popov, which by the paper fits the data, over Eq. 5: "
        + ", ".join(f"{min(v):.2f} to {max(v):.2f} at α = {a:g}" for a, v in zip(alphas, np.transpose(back), strict=True)),
        *ROUGH_SPHERES,
        why="a* from a displacement depends on the load from which displacements count, which is not printed",
    )
    curves = granite.effective_radius(np.array([0.05]))
    values = [float(v[0]) for v in curves.values()]
    yield Claim(
        "a*/a_H",
        "for α below 0.05 Hertz underestimates the contact radius by up to 7 %",
        "at α = 0.05: " + ", ".join(f"{n} {100 * (v - 1):.1f} %" for n, v in zip(curves, values, strict=True)),
        verdict_of(max(values) <= 1.07),
        "at most 7 % at α = 0.05",
    )


def _back_calculated(get, test, alphas):
    """a*/a_H = √(δ/δ_H) of Pohrt-Popov in a test where α = σ/δ_H has these values, as the paper computes it from data."""
    hertz = get.test(test).roughness / alphas
    force = get(HERTZ, test).force(hertz)
    return np.sqrt(get(POHRT_POPOV, test).overlap(force) / hertz)


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


GROUPS = (
    _printed_claims,
    _smooth_claims,
    _sphere_claims,
    _stiffness_and_unloading_claims,
    _law_claims,
    _comparison_claims,
    _likeness_claims,
)
"""Functions that yield claims, in the order of the table."""
