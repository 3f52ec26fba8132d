"""Statements of Altuhafi, Baudet & Coop 2023, each with the quantity that tests it: one table, judged by `granite_claims`.

The measured points are not public. Two statements of the paper replace them where its own words allow it: Yip-Venart "shows a
close fit" to SS(18-18) and SS(12-18), so that a law that differs from it there differs from the data.
"""

from collections.abc import Iterable
from functools import partial as of

from demlaws import granite, regime
from demlaws.errors import quiet
from demlaws.granite import CONE_DIMENSION, MODULI, ROUGH_SPHERES, quantities as q
from demlaws.granite.verdicts import NEAR, Claim, Criterion, Judged, built_in, judge, near, undecided
from demlaws.laws import BAHRAMI, HERTZ, POHRT_POPOV, RMS, ROUGH_PLASTIC, YIP_VENART

_SMOOTH = ("VS(18-18)",)
_ROUGH, _OPEN = "rough spheres", ("SF(12)", "RS(18-18)")
_SIGMA, _RULE, _FORMULA = "every rough law is softer for a larger σ", "true of the unloading rule", "true of the law's formula"
_ORIGIN = "the sign depends on the load from which displacements count, which is not printed"
_SOFT = 1.0 - NEAR

SPHERES = (
    Claim("§4", "all spheres", "field of view of 0.2 mm by Hertz, R = 4.4 mm at 100 N", "a_H (mm)",
          of(q.hertz_radius, (4.4e-3,), 100.0), Criterion(0.195, 0.205, "0.20 to two digits")),
    Claim("§4", "FC5", "Hertz's contact radius of the tip is below 0.09 mm at 100 N", "a_H (mm)",
          of(q.hertz_radius, (0.31e-3, 0.35e-3), 100.0), Criterion(high=0.09, reason="tips of 0.31 and 0.35 mm")),
    Claim("Table 2", "all spheres", "R and σ of a pair follow from its two stones", "computed less printed (last digits)",
          q.pairs_of_stones, Criterion(-0.5, 0.5, "rounded to the printed digits")),
    Claim("§5", "VS(18-18)", "good agreement with Hertz", "K/K_H",
          of(q.stiffness, (POHRT_POPOV, RMS), HERTZ, _SMOOTH, (2.0, 10.0, 100.0)),
          Criterion(_SOFT, 1.0 + NEAR, "by both laws, from 2 N")),
    Claim("§5", "RS, SS, VS(18-18)", "softness in the order RS > SS > VS", "µm to 100 N", q.softness,
          built_in(_SIGMA)),
    Claim("§5", "SS(18-18)", "displacement differs from that of VS by more than σ", "difference (σ)",
          of(q.beyond_smooth, "SS(18-18)"),
          built_in("above the crossover Pohrt-Popov's overlap exceeds Hertz's by 1.7 σ at any load")),
    Claim("§5", "RS(18-18)", "displacement differs from that of VS by more than σ", "difference (σ)",
          of(q.beyond_smooth, "RS(18-18)"), Criterion(low=1.0)),
    Claim("§5", "a*/a_H", "for α below 0.05 Hertz underestimates it by up to 7 %", "a*/a_H at α = 0.05",
          lambda laws: {name: float(values[0]) for name, values in granite.effective_radius([0.05]).items()},
          Criterion(1.0, 1.07)),
    Claim("§5, Fig. 4", _ROUGH, "Eq. 5 overestimates the contact radius at larger α", "a* of Pohrt-Popov over Eq. 5",
          q.back_calculated, undecided(_ORIGIN)),
    Claim("§6", "real area", "the real contact area is linear in the load", "d ln A/d ln P of elastic asperities", q.real_area,
          Criterion(_SOFT, 1.0 + NEAR, "at separations at which it is a small share of the nominal area")),
    Claim("§6", "SS(18-18)", "Pohrt-Popov crosses over to Hertz at around 73 N", "crossover (N)",
          lambda laws: {"": granite.threshold_force(laws.test("SS(18-18)"))}, near(73.0)),
    Claim("Eq. 12", _ROUGH, "κ = (E*/H) √(R/σ)", "p(0)/p0 over Yip-Venart's at 100 N", q.printed_kappa, near(1.0)),
    Claim("Eq. 13", "a_L", "branches 1.605 √p0' and 3.51 - 2.51 p0' at p0' = 0.47", "first branch over second at 0.47",
          q.printed_branches, near(1.0)),
    Claim("§8", _ROUGH, "Hertz is significantly too stiff", "displacement to 100 N, Pohrt-Popov over Hertz",
          of(q.displacement, (POHRT_POPOV,), HERTZ, ROUGH_SPHERES, ((0.1, 100.0),)), undecided()),
    Claim("§8", _ROUGH, "RMS and Pohrt-Popov agree with the data to about 70 N", "", None, undecided()),
    Claim("§8", "SS(18-18), SS(12-18)", "RMS is too stiff above 70 N, not below", "K over Yip-Venart's", of(q.onset, RMS),
          Criterion(1.0, reason="too stiff at 70 and 100 N, more than from 10 to 40 N")),
    Claim("§8", "SS(18-18), SS(12-18)", "Pohrt-Popov is too stiff above 70 N, not below", "K over Yip-Venart's",
          of(q.onset, POHRT_POPOV), Criterion(1.0, reason="too stiff at 70 and 100 N, more than from 10 to 40 N")),
    Claim("§8", "SF(12), RS(18-18)", "RMS and Pohrt-Popov are too stiff above 70 N", "", None, undecided()),
    Claim("§8", "SS(18-18), SS(12-18)", "Yip-Venart fits closely", "", None, undecided()),
    Claim("§8", "SF(12)", "Yip-Venart is too soft", "displacement to 100 N, over Pohrt-Popov's",
          of(q.displacement, (YIP_VENART,), POHRT_POPOV, ("SF(12)",), ((0.1, 100.0),)),
          undecided("softer than Pohrt-Popov by displacement, stiffer by stiffness; the paper does not state which")),
    Claim("§8", _ROUGH, "Bahrami suits none of the tests", "displacement to 100 N, over Pohrt-Popov's",
          of(q.displacement, (BAHRAMI,), POHRT_POPOV, ROUGH_SPHERES, ((0.1, 100.0),)), undecided()),
    Claim("§8, Fig. 7", "SS(12-18)", "unloading is stiffer, like Hertz's", "", None, built_in(_RULE)),
    Claim("§8, Fig. 7", "SS(12-18)", "of three elastic laws Pohrt-Popov agrees best with unloading", "", None,
          undecided()),
    Claim("§8", "SS(12-18)", "elastic or plastic asperities make little difference", "difference over Yip-Venart less RMS",
          q.elastic_and_plastic,
          Criterion(high=1.0, reason="less than between RMS and Yip-Venart, which both fit by the paper")),
    Claim("§8, Fig. 8", _ROUGH, "Pohrt-Popov's exponent of stiffness is around 0.56", "0.2567 Df",
          lambda laws: q.table(lambda test: 0.2567 * laws.test(test).fractal_dimension, ROUGH_SPHERES),
          built_in("0.2567 times the printed fractal dimensions")),
    Claim("§8, Fig. 9", "SS(18-18), RS(18-18)", "σ moves Pohrt-Popov's stiffness line, not its gradient",
          "K = c P^(0.2567 Df): σ is in c alone", None, built_in(_FORMULA)),
    Claim("§8, Fig. 9", "VS(18-18)", "of the three pairs the closest to the Hertz stiffness", "K/K_H at 10 N",
          of(q.stiffness, (POHRT_POPOV,), HERTZ, ("VS(18-18)", "SS(18-18)", "RS(18-18)"), (10.0,)), built_in(_SIGMA)),
    Claim("§8, Fig. 10", "RS(18-18)", "no change of the bulk form over the testing load range", "p(0)/H_m at 100 N",
          lambda laws: {"": regime.pressure_ratio(laws.test("RS(18-18)").contact, 100.0)},
          Criterion(high=0.56, reason="the bulk yields from 0.6 on, both deform from 0.56")),
    Claim("§9", _ROUGH, "Goddard's stiffness might be very similar to Pohrt-Popov's", "largest difference, 1 to 100 N",
          q.nearest_goddard, Criterion(high=NEAR, reason="with the nearest slope; RMS, without a free parameter, has 0.21")),
    Claim("§9", "ballast", "stiffness at small strain changes with Hertz unloading", "K/K_H at 1 N, first loading",
          of(q.stiffness, (POHRT_POPOV,), HERTZ, ROUGH_SPHERES, (1.0,)),
          undecided("whether the probes precede a reversal is not printed; packings: page Small strain")),
    Claim("concl. 1", _ROUGH, "Pohrt-Popov and Yip-Venart fit best", "", None, undecided()),
    Claim("concl. 2", _ROUGH, "the effect of roughness is very significant at lower load", "K/K_H of Pohrt-Popov",
          of(q.stiffness, (POHRT_POPOV,), HERTZ, ROUGH_SPHERES, (1.0, 100.0)),
          built_in("K/K_H of every rough law rises with the load")),
    Claim("concl. 2", _ROUGH, "up to 100 N the stiffness does not reach Hertz's", "K/K_H at 100 N",
          of(q.stiffness, q.FITTING, HERTZ, ROUGH_SPHERES, (100.0,)),
          Criterion(high=_SOFT, reason="by all three laws that fit by the paper")),
    Claim("concl. 3", "SS(18-18), SS(12-18)", "RMS overestimates deformation at low load", "K at 1 N over Yip-Venart's",
          of(q.stiffness, (RMS,), YIP_VENART, q.FITTED, (1.0,)), Criterion(high=_SOFT, reason="softer than the law that fits")),
    Claim("concl. 3", "SF(12), RS(18-18)", "RMS overestimates deformation at low load", "displacement over Pohrt-Popov's",
          of(q.displacement, (RMS,), POHRT_POPOV, _OPEN, ((0.0, 0.5), (0.1, 2.0))), undecided(_ORIGIN)),
)  # fmt: skip
"""Spheres, in the order of the paper."""

CONES = (
    Claim("§9, Fig. 11", "RFC10", "the elastic models hold to 20 N", "yield (N)", of(q.yield_load, "RFC10"), near(20.0)),
    Claim("§9, Fig. 14", "FC5", "the elastic models hold to 7 N", "yield (N)", of(q.yield_load, "FC5"), near(7.0)),
    Claim("§9", "RFC10, FC5", "first loading follows Pohrt-Popov to 20 and 7 N", f"Df = {CONE_DIMENSION} and FC5's σ assumed",
          None, undecided()),
    Claim("§9, Fig. 14", "FC5", "Hertz is much stiffer than observed", "displacement, Hertz over Pohrt-Popov",
          of(q.displacement, (HERTZ,), POHRT_POPOV, ("FC5",), ((0.1, 7.0),)), undecided()),
    Claim("§9, Fig. 14", "FC5", "RMS overestimates deformation at low load", "displacement over Pohrt-Popov's",
          of(q.displacement, (RMS,), POHRT_POPOV, ("FC5",), ((0.0, 0.5), (0.1, 7.0))), undecided(_ORIGIN)),
    Claim("§9, Fig. 14", "FC5", "above 7 N much stiffer than Pohrt-Popov", "mean K from 7 to 20 N over Pohrt-Popov's",
          of(q.displacement, (POHRT_POPOV,), ROUGH_PLASTIC, ("FC5",), ((7.0, 20.0),)),
          Criterion(1.2, reason="the range of the figure")),
    Claim("§9, Fig. 14", "FC5", "first and second stage are alike to 20 N", "", None,
          built_in("each stage begins on a new contact")),
    Claim("§9, Fig. 12", "RFC10", "reloading is nearly Hertz up to gross yield", "K/K_H", q.reload, built_in(_RULE)),
    Claim("§9, Fig. 12", "RFC10", "after gross yield a stiffness of about 5000 N/mm", "K at the largest load (N/mm)",
          q.after_yield, near(5000.0)),
    Claim("§9, Fig. 14", "FC5, RFC10", "all unloading is stiff", "", None, built_in(_RULE)),
    Claim("§9, Fig. 13", "RFC10", "plastic deformation is nearly linear in the largest load", "R² of a straight line",
          q.straightness, Criterion(0.98, reason="what a reader calls nearly linear")),
    Claim("§9, Fig. 13", "RFC10, FC5", "plastic deformations of the two cones compare well", "FC5 over RFC10", q.two_cones,
          Criterion(1 / 1.5, 1.5)),
    Claim("§9", "RFC10, FC5", "most deformation is in the flat", "", None,
          undecided("no law divides the overlap between two bodies of one material")),
    Claim("§9", "RFC10", "Goddard is not compatible with the drop at yield", "smallest d ln K/d ln P of Goddard",
          q.goddard_rises, built_in(_FORMULA)),
    Claim("concl. 4", "RFC10", "reloading is stiffer, up to the largest load so far", "K at 40 N (N/mm)",
          q.return_to_first_loading, built_in(_RULE)),
    Claim("concl. 5", "RFC10", "plastic deformation is proportional to the largest load", "deformation/load over its mean",
          q.proportion, near(1.0)),
)  # fmt: skip
"""Tips of cones. Both cones have one p_y, Hertz's p0 where K_H is the printed 5000 N/mm; FC5's bulk has the camera's radius."""


def granite_claims(tests: Iterable[str] | None = None) -> list[Judged]:
    """Every claim, judged; tests: those that concern one of these.

    The verdict is that with E* of the paper's text; `other_gives` and `other_verdict` are those with E/(2(1 - ν)).
    """
    claims = [c for c in (*SPHERES, *CONES) if tests is None or set(tests) & set(concerned(c.test))]
    with quiet():
        return judge(claims, *map(q.GraniteLaws, MODULI))


def concerned(text: str) -> list[str]:
    """Names of the tests that a claim's entry concerns."""
    groups = {_ROUGH: ROUGH_SPHERES, "all spheres": [t.name for t in granite.TESTS[:5]]}
    names = [t.name for t in granite.TESTS]
    return list(groups.get(text, [n for n in names if n in text or n.partition("(")[0] in text.partition("(")[0].split(", ")]))
