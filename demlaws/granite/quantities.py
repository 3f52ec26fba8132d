"""Numbers that test statements about the granite tests: functions of `GraniteLaws` that return label → number."""

import functools
import itertools
import math
from typing import NamedTuple

import numpy as np

from demlaws import granite
from demlaws.contact import combined_roughness, effective_radius
from demlaws.granite import MICRO, MODULI, STONES, bind, displacement_gained, find_test, run_test, stiffness_at
from demlaws.laws import GODDARD, GREENWOOD_TRIPP, HERTZ, POHRT_POPOV, RMS, ROUGH_PLASTIC, YIP_VENART
from demlaws.make import law
from demlaws.solvers import master_curves

CONES = ("RFC10", "FC5")
FITTED = ("SS(18-18)", "SS(12-18)")
"""The tests that Yip-Venart fits by the paper."""
FITTING = (POHRT_POPOV, RMS, YIP_VENART)
"""The laws that fit rough spheres by the paper."""


class GraniteLaws(NamedTuple):
    """Laws and runs on the tests with one E*."""

    modulus: str  # name of E*

    def test(self, name):
        """A test."""
        return find_test(name, self.modulus)

    def law(self, name, test):
        """A law on a test of this name; "hertz" is Hertz on the test's R."""
        return bind(name, self.test(test))

    def run(self, test):
        """The rough-plastic law through the last stage of a cone before its tip failed."""
        return run_test(ROUGH_PLASTIC, (cone := self.test(test))._replace(stages=cone.stages[:4][-1:]))


def table(value, *axes, number="{:g} N"):
    """Label → value(*entries) of every combination of the axes' entries; axes of one entry are not in the label."""

    def word(entry):
        if isinstance(entry, tuple):
            return f"{entry[0]:g} to {entry[1]:g} N"
        return number.format(entry) if isinstance(entry, float) else entry

    shown = [len(axis) > 1 for axis in axes]
    return {
        " ".join(word(entry) for entry, show in zip(entries, shown, strict=True) if show): value(*entries)
        for entries in itertools.product(*axes)
    }


def stiffness(names, over, tests, loads, laws):
    """Tangent stiffness of laws over that of another law."""
    return table(
        lambda test, name, load: stiffness_at(laws.law(name, test), load) / stiffness_at(laws.law(over, test), load),
        *(tests, names, loads),
    )


def displacement(names, over, tests, spans, laws):
    """Displacement gained between two loads, over that by another law."""
    return table(
        lambda test, name, span: (
            displacement_gained(laws.law(name, test), *span) / displacement_gained(laws.law(over, test), *span)
        ),
        *(tests, names, spans),
    )


def hertz_radius(radii, load, laws):
    """a_H = (3PR/(4E*))^(1/3) [mm] of granite."""
    return {f"R {1e3 * r:g} mm": 1e3 * (0.75 * load * r / MODULI[laws.modulus]) ** (1 / 3) for r in radii}


def pairs_of_stones(laws):
    """R [mm] and σ [µm] computed from both stones less the printed ones, in units of the last printed digit."""
    found = {}
    for name, ((r1, s1, _), (r2, s2, _)) in STONES.items():
        test = laws.test(name)
        found[f"{name} R"] = (effective_radius(r1, r2) - 1e3 * test.radius) / 0.01
        found[f"{name} σ"] = (float(combined_roughness(s1, s2)) - test.sigma / MICRO) / 0.01
    return found


def beyond_smooth(test, laws):
    """Displacement [σ] gained to 100 N more than in the very smooth contact, by three laws."""
    pairs = {name: [displacement_gained(laws.law(name, one)) for one in (test, "VS(18-18)")] for name in FITTING}
    return {name: (rough - smooth) / laws.test(test).sigma for name, (rough, smooth) in pairs.items()}


def softness(laws):
    """Displacement [µm] gained to 100 N."""
    tests = ("RS(18-18)", "SS(18-18)", "VS(18-18)")
    return table(lambda name, test: displacement_gained(laws.law(name, test)) / MICRO, FITTING, tests)


def onset(name, laws):
    """Smallest K over that of Yip-Venart at 70 and 100 N, and that over the largest one from 10 to 40 N."""
    found = {}
    for test in FITTED:
        late = min(stiffness((name,), YIP_VENART, (test,), (70.0, 100.0), laws).values())
        early = max(stiffness((name,), YIP_VENART, (test,), (10.0, 20.0, 40.0), laws).values())
        found |= {f"{test} late": late, f"{test} late over early": late / early}
    return found


def nearest_goddard(laws):
    """Largest relative difference of K from Pohrt-Popov's, 1 to 100 N, of Goddard with the nearest slope."""
    load = np.geomspace(1.0, 100.0, 30)

    def difference(test):
        bound = laws.law(POHRT_POPOV, test)
        target = bound.stiffness(bound.overlap(load))
        slopes = (law(GODDARD, bound.contact, slope=float(slope)) for slope in np.geomspace(0.005, 0.2, 60))
        return min(float(np.abs(one.stiffness(one.overlap(load)) / target - 1.0).max()) for one in slopes)

    return table(difference, granite.ROUGH_SPHERES)


def goddard_rises(laws):
    """Smallest d ln K/d ln P of Goddard from 1 to 450 N."""
    load = np.geomspace(1.0, 450.0, 200)
    bound = laws.law(GODDARD, "RFC10")
    slopes = np.diff(np.log(bound.stiffness(bound.overlap(load)))) / np.diff(np.log(load))
    return {"": float(slopes.min())}


def elastic_and_plastic(laws):
    """Difference of elastic (Greenwood-Tripp) and plastic asperities (Yip-Venart) over that of Yip-Venart and RMS, to 100 N."""
    elastic, plastic, rms = (displacement_gained(laws.law(n, "SS(12-18)")) for n in (GREENWOOD_TRIPP, YIP_VENART, RMS))
    return {"": abs(elastic - plastic) / abs(plastic - rms)}


def back_calculated(laws):
    """a* = √(R δ) of Pohrt-Popov over Eq. 5, at α = σ/δ_H."""

    def ratio(test, alpha):
        hertz = laws.test(test).sigma / alpha
        size = math.sqrt(laws.law(POHRT_POPOV, test).overlap(laws.law(HERTZ, test).force(hertz)) / hertz)
        return size / (2.4 - 2.8 / (alpha + 2.0))

    return table(ratio, granite.ROUGH_SPHERES, (1.0, 5.0), number="α = {:g}")


def real_area(laws):
    """d ln A/d ln P of Greenwood-Tripp's elastic asperities: A ∝ F_1, P ∝ F_1.5, with F_n = ∫ (z - d)^n φ(z) dz."""
    z = 3e-3 * (np.arange(4000) + 0.5)

    def moment(separation, power):
        return np.sum(z**power * np.exp(-0.5 * (z + separation) ** 2))

    def slope(d):
        return float(moment(d, 0.0) * moment(d, 1.5) / (1.5 * moment(d, 1.0) * moment(d, 0.5)))

    return table(slope, (1.0, 2.0, 3.0), number="d = {:g} σ")


def printed_kappa(laws):
    """p(0)/p0 of Eq. 12 with κ as printed over Yip-Venart's, which has the same plastic asperities."""

    def ratio(test):
        t = laws.test(test)
        printed = t.modulus / t.contact.hardness * math.sqrt(t.radius / t.sigma)
        number = t.contact.hardness / t.modulus * math.sqrt(8.0 * t.radius / t.sigma)
        alpha = float(t.contact.roughness_parameter(100.0))
        solved = float(master_curves.central_pressure(YIP_VENART, number, 4.0 / 3.0 * alpha**-1.5))
        return 1.0 / (1.0 + 1.22 * alpha * printed**-0.16) / solved

    return table(ratio, granite.ROUGH_SPHERES)


def printed_branches(laws):
    """a_L' of the first branch of Eq. 13 over that of the second where they meet, p0' = 0.47."""
    return {"": 1.605 * math.sqrt(0.47) / (3.51 - 2.51 * 0.47)}


# --- tips of cones


def yield_load(test, laws):
    """Load [N] at which the bulk yields."""
    return {"": float(laws.law(ROUGH_PLASTIC, test).params.yield_force)}


def reload(laws):
    """K/K_H of the bulk on reloading, at half the earlier maximum."""
    stages = granite.stages_of(laws.run("RFC10"))
    return {f"to {s.maximum_force:.0f} N": s.over_hertz for s in stages if math.isfinite(s.over_hertz)}


def after_yield(laws):
    """K [N/mm] at the largest load of each stage that passes yield."""
    run = laws.run("RFC10")
    passed = (s for s in granite.stages_of(run) if s.maximum_force > run.law.params.yield_force)
    return {f"{s.maximum_force:.0f} N": s.final_stiffness / 1e3 for s in passed}


def return_to_first_loading(laws):
    """K [N/mm] just below and just above the largest load so far, 40 N."""
    bound = laws.law(ROUGH_PLASTIC, "RFC10")
    top = float(bound.overlap(40.0))
    below, above = bound.follow(top * np.array([1.0, 0.9, 1.0 - 1e-9, 1.0 + 1e-9])).stiffness[2:]
    return {"below": below / 1e3, "above": above / 1e3}


@functools.cache
def _plastic(laws, test):
    """Largest load [N] → cumulative plastic overlap [µm] of the last stages of a cone."""
    rows = granite.stages_of(laws.run(test))
    return {f"{s.maximum_force:.0f} N": (s.maximum_force, s.plastic_overlap / MICRO) for s in rows}


def straightness(laws):
    """R² of a straight line through plastic overlap against the largest load."""
    load, plastic = np.transpose(list(_plastic(laws, "RFC10").values()))
    return {"": float(np.corrcoef(load, plastic)[0, 1]) ** 2}


def proportion(laws):
    """Plastic overlap over the largest load, over its mean."""
    rows = {label: plastic / load for label, (load, plastic) in _plastic(laws, "RFC10").items()}
    return {label: row / np.mean(list(rows.values())) for label, row in rows.items()}


def two_cones(laws):
    """Plastic overlap of FC5 over that of RFC10 at the same loads."""
    cone, small = (_plastic(laws, test) for test in CONES)
    return {label: small[label][1] / cone[label][1] for label in small}
