"""Statements of the granite paper about the tips of cones, with yield and unloading on one radius and on two.

Both cones have one p_y, that of RFC10's 5000 N/mm after yield; they yield at the load at which a smooth bulk's p0 is p_y.
"""

import math

import numpy as np

from demlaws.granite import (
    CONE_DIMENSION,
    MICRO,
    ROUGH_SPHERES,
    displacement_gained,
    hertz_stiffness,
    run_test,
    stages_of,
    stiffness_at,
)
from demlaws.granite.verdicts import BUILT_IN, Claim, around, open_claim, verdict_of
from demlaws.laws import HERTZ, POHRT_POPOV, RMS, ROUGH_PLASTIC

LINEAR = 0.98
"""R² of a straight line through the points of a figure that a reader calls nearly linear."""


def _yield_claims(get):
    for name, load in (("RFC10", 20.0), ("FC5", 7.0)):
        run = get.run(ROUGH_PLASTIC, name)
        test, p = run.test, run.law.params
        text = (
            f"with p_y = {test.yield_pressure / 1e9:.2f} GPa of RFC10's stiffness after yield, counted at the load at which a "
            f"smooth bulk's p0 is p_y (yield_at='load'): {p.yield_force:.1f} N with R_b = {1e3 * run.radius:.2f} mm"
        )
        if test.bulk_radius is not None:
            tip = _on_the_tip(get, name)
            text += f"; with R = {1e3 * test.radius:.2f} mm in its place {tip.params.yield_force:.1f} N"
        yield Claim(
            name,
            f"the elastic models hold to {load:g} N",
            text,
            verdict_of(around(p.yield_force, load)),
            f"yield within 10 % of {load:g} N",
        )
        yield open_claim(
            name,
            f"first loading to {load:g} N follows Pohrt-Popov",
            f"Df = {CONE_DIMENSION} assumed" + ("" if name == "RFC10" else ", σ too"),
            name,
        )


def _on_the_tip(get, name):
    """The rough-plastic law of a cone with R of the tip in place of the bulk's; elastic unloading."""
    from demlaws.make import law

    test = get.test(name)
    return law(ROUGH_PLASTIC, test.contact, "elastic", yield_pressure=test.yield_pressure, yield_at=test.yield_at)


def _reload_claims(get):
    run = get.run(ROUGH_PLASTIC, "RFC10")
    stages = stages_of(run)
    over = [s.over_hertz for s in stages if math.isfinite(s.over_hertz)]
    yield Claim(
        "RFC10",
        "reloading is nearly Hertz up to gross yield",
        f"reload K/K_H = {min(over):.3f} to {max(over):.3f}",
        BUILT_IN,
        "true of the unloading rule by construction",
    )
    final = [s.final_stiffness / 1e3 for s in stages if s.maximum_force > run.law.params.yield_force]
    yield Claim(
        "RFC10",
        "after gross yield a constant stiffness of about 5000 N/mm",
        f"{min(final):.0f} to {max(final):.0f} N/mm",
        BUILT_IN,
        "p_y was chosen for it",
    )
    top = float(run.law.overlap(40.0))
    path = run.law.follow(np.array([top, 0.9 * top, (1.0 - 1e-9) * top, (1.0 + 1e-9) * top]))
    below, above = path.stiffness[2:]
    yield Claim(
        "RFC10",
        "on reloading the stiffness is higher, and returns to that of first loading at the largest load so far",
        f"after 40 N {below / 1e3:.0f} N/mm just below that load, {above / 1e3:.0f} N/mm just above it",
        BUILT_IN,
        "true of the unloading rules by construction",
    )


def _plastic_claims(get):
    run = get.run(ROUGH_PLASTIC, "RFC10")
    stages = stages_of(run)
    load = np.array([s.maximum_force for s in stages])
    plastic = np.array([s.plastic_overlap for s in stages]) / MICRO
    slopes = np.diff(plastic) / np.diff(load)
    line = np.polynomial.Polynomial.fit(load, plastic, 1)
    residual = plastic - line(load)
    square = 1.0 - np.sum(residual**2) / np.sum((plastic - plastic.mean()) ** 2)
    yield Claim(
        "RFC10",
        "cumulative plastic deformation is nearly linear in the maximum load",
        "µm: "
        + ", ".join(f"{d:.1f} at {f:.0f} N" for f, d in zip(load, plastic, strict=True))
        + f"; straight line: R² = {square:.3f}, residuals up to {100 * np.abs(residual).max() / np.ptp(plastic):.1f} % of the "
        f"range; slope from {slopes.min():.2f} to {slopes.max():.2f} µm/N" + (f" ({run.beyond})" if run.beyond else ""),
        verdict_of(square > LINEAR),
        f"R² of a straight line above {LINEAR:g}",
    )
    small = get.run(ROUGH_PLASTIC, "FC5")
    other = {round(s.maximum_force): s.plastic_overlap / MICRO for s in stages_of(small) if s.stage == 4}
    ratios = {f: other[round(f)] / d for f, d in zip(load, plastic, strict=True) if round(f) in other}
    # the same loads with R of the tip in place of the bulk's
    turns = tuple(turn for f in load if round(f) in other for turn in (f, 0.0))
    sharp, _ = run_test(ROUGH_PLASTIC, get.test("FC5")._replace(bulk_radius=None, stages=(turns,)))
    tip = [s.plastic_overlap / MICRO for s in stages_of(sharp)]
    yield Claim(
        "RFC10, FC5",
        "plastic deformations of the two cones compare well",
        "FC5 over RFC10: "
        + ", ".join(f"{v:.2f} at {f:.0f} N" for f, v in ratios.items())
        + f" with R_b = {1e3 * small.radius:.2f} mm; "
        + ", ".join(f"{v / d:.2f}" for v, d in zip(tip, plastic, strict=False))
        + " with R in its place (FC5's σ and both Df assumed)"
        + (f"; {small.beyond}" if small.beyond else ""),
        verdict_of(all(0.67 < v < 1.5 for v in ratios.values())),
        "ratio between 0.67 and 1.5 at every load",
    )


def _stiffer_claims(get):
    small = get.run(ROUGH_PLASTIC, "FC5")
    elastic, tip = get(POHRT_POPOV, "FC5"), _on_the_tip(get, "FC5")
    above = (10.0, 20.0)

    def over(law):
        mean = displacement_gained(elastic, 7.0, 20.0) / displacement_gained(law, 7.0, 20.0)
        each = ", ".join(f"{stiffness_at(law, f) / stiffness_at(elastic, f):.2f} at {f:g} N" for f in above)
        return mean, f"{mean:.2f} from 7 to 20 N ({each})"

    (mean, text), (_, other) = over(small.law), over(tip)
    yield Claim(
        "FC5",
        "above 7 N much stiffer than Pohrt-Popov",
        f"stiffness over Pohrt-Popov's at R: {text} with R_b = {1e3 * small.radius:.2f} mm; {other} with R in its place",
        verdict_of(mean > 1.2),
        "mean stiffness from 7 to 20 N, the range of the figure, above 1.2 times Pohrt-Popov's",
    )


def _elastic_claims(get):
    early, late = (0.0, 0.5), (0.1, 7.0)
    gained = {
        n: [displacement_gained(get(n, "FC5"), *span) / MICRO for span in (early, late)] for n in (HERTZ, RMS, POHRT_POPOV)
    }
    rows = {n: [v / w for v, w in zip(gained[n], gained[POHRT_POPOV], strict=True)] for n in (HERTZ, RMS)}
    yield open_claim(
        "FC5",
        "Hertz predicts a much stiffer response than observed",
        f"Hertz gains {rows[HERTZ][1]:.2f} times Pohrt-Popov's displacement from 0.1 to 7 N",
        "FC5",
    )
    yield open_claim(
        "FC5",
        "RMS overestimates deformation at low load",
        f"RMS over Pohrt-Popov, displacement: {rows[RMS][0]:.2f} from 0 to 0.5 N, {rows[RMS][1]:.2f} from 0.1 to 7 N",
        "FC5",
        why="the sign depends on the load from which displacements count, which is not printed",
    )
    ratio = {t: stiffness_at(get(POHRT_POPOV, t), 1.0) / hertz_stiffness(get.test(t), 1.0) for t in ROUGH_SPHERES}
    yield open_claim(
        "rough spheres",
        "stiffness of ballast at small strain: a significant change if Pohrt-Popov loads and Hertz unloads",
        f"K/K_H of a contact is {min(ratio.values()):.2f} to {max(ratio.values()):.2f} at 1 N on first loading, 1 after a "
        'reversal; our packings: page "Small strain"',
        *ROUGH_SPHERES,
        why="whether the probes come before or after a reversal is not printed",
    )


GROUPS = (_yield_claims, _elastic_claims, _reload_claims, _plastic_claims, _stiffer_claims)
"""Functions that yield claims, in the order of the table."""
