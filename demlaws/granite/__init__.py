"""The granite contact tests of Altuhafi, Baudet & Coop 2023, run with every law.

No measured point of these tests is public; `demlaws fit` compares a user's points with laws. `claims` compares the
statements of the paper with the runs.
"""

import math
import re
from typing import NamedTuple

import numpy as np

from demlaws import driver
from demlaws.contact import GRANITE, GRANITE_YIELD_PRESSURE, Contact
from demlaws.errors import DemlawsError, quiet
from demlaws.laws import POHRT_POPOV
from demlaws.laws.registry import registry
from demlaws.make import law
from demlaws.solvers import master_curves

MODULI = {"text": 0.5 * GRANITE.plane_modulus, "figures": 0.5 * GRANITE.young / (1.0 - GRANITE.poisson)}
"""E* [Pa] by the definition in the paper's text, E/(2(1 - ν²)), and E/(2(1 - ν)), which fits the three printed numbers that
depend on E* [our reading: the figures were drawn with ν in place of ν²]. Laws use the first."""
SWITCH_FORCE = 10.0
"""Load [N] at which the tests went over from displacement control to force control."""
MICRO = 1e-6

# What our text of the paper lacks; stated wherever it is used.
CONE_DIMENSION = 2.22
ASSUMED = f"fractal dimension {CONE_DIMENSION} is assumed, because our text lacks the body of the paper's Table 3"


class Test(NamedTuple):
    """One contact test."""

    name: str
    radius: float  # effective R [m]
    sigma: float  # combined roughness σ [m]
    fractal_dimension: float  # mean of the two surfaces (our choice)
    stages: tuple = ((100.0,),)  # each a list of forces [N] to turn at, begun on a new contact
    yield_pressure: float = GRANITE_YIELD_PRESSURE  # p_y [Pa] of the rough-plastic law
    assumed: str = ""
    yield_at: str | None = None  # of the rough-plastic law
    bulk_radius: float | None = None  # R_b [m] of it
    modulus: float = MODULI["text"]  # E* [Pa]

    @property
    def contact(self):
        """The test's contact: R, E*, σ, Df and hardness of the granite."""
        return Contact(self.radius, self.modulus, self.sigma, self.fractal_dimension, GRANITE.hardness)

    @property
    def cyclic(self):
        """Whether the test loads, unloads and loads again."""
        return max(map(len, self.stages)) > 2

    @property
    def key(self):
        """File name part."""
        return re.sub(r"[^a-z0-9]+", "-", self.name.lower()).strip("-")


STONES = {
    "SS(18-18)": ((8.76, 1.56, 2.21), (8.63, 1.84, 2.23)),
    "SS(12-18)": ((6.05, 2.83, 2.33), (8.75, 3.09, 2.25)),
    "SF(12)": ((6.05, 3.61, 2.23), (math.inf, 5.48, 2.32)),
    "VS(18-18)": ((8.27, 0.10, 2.06), (7.90, 0.11, 2.09)),
    "RS(18-18)": ((8.2, 3.30, 2.17), (8.58, 4.20, 2.23)),
}
"""Table 2 as printed: radius [mm], Sq [µm] and Df of both stones of a test."""


def _cycles(*forces):
    """Turning points [N] of loading to each force and back to 0."""
    return tuple(turn for force in forces for turn in (force, 0.0))


TESTS = (
    Test("SS(18-18)", 4.35e-3, 2.40e-6, 2.22),
    Test("SS(12-18)", 3.58e-3, 4.19e-6, 2.29, ((100.0, 0.0),)),
    Test("SF(12)", 6.05e-3, 6.56e-6, 2.275),
    Test("VS(18-18)", 4.04e-3, 0.15e-6, 2.075),
    Test("RS(18-18)", 4.19e-3, 5.34e-6, 2.20),
    # tips of cones on a flat: one p_y for both, p0 of a smooth RFC10 where K_H is the printed 5000 N/mm
    Test(
        "RFC10",
        0.96e-3,
        5.04e-6,
        CONE_DIMENSION,
        (_cycles(20.0, 40.0, 80.0, 150.0, 300.0, 450.0),),
        assumed=ASSUMED,
        yield_at="load",
    ),
    Test(
        "FC5",
        0.33e-3,
        5.04e-6,
        CONE_DIMENSION,
        (*(_cycles(*(20.0, 40.0, 80.0, 150.0)[:last]) for last in (1, 2, 3, 4)), _cycles(225.0, 300.0)),
        assumed="σ and fractal dimension of RFC10 are assumed; the tip that failed at 225 N is not modelled",
        yield_at="load",
        bulk_radius=0.62e-3,
    ),
)
ROUGH_SPHERES = ("SS(18-18)", "SS(12-18)", "SF(12)", "RS(18-18)")


def tests_of(modulus="text"):
    """All tests with the E* of this name (`MODULI`)."""
    return tuple(test._replace(modulus=MODULI[modulus]) for test in TESTS)


def find_test(name, modulus="text"):
    """A test by name, in any spelling of its letters and digits; modulus: name of its E* (`MODULI`)."""
    key = re.sub(r"[^a-z0-9]", "", str(name).lower())
    for test in tests_of(modulus):
        if re.sub(r"[^a-z0-9]", "", test.name.lower()) == key:
            return test
    raise DemlawsError(f"unknown test {name!r}: the tests are {', '.join(t.name for t in TESTS)}")


def options_for(name, test):
    """Options with which a law is run on a test: those of its example, with the test's own quantities in place of them."""
    definition = registry()[name]
    example = {} if definition.needs_map else definition.drawing.example
    own = {option: getattr(test, option, None) for option in definition.options}
    return {**example, **{option: value for option, value in own.items() if value is not None}}


def bind(name, test, unloading=None):
    """A law on a test's contact; unloading: by default the law's own."""
    return law(name, test.contact, unloading, **options_for(name, test))


def laws_for_tests():
    """Names of the laws that the tests' published quantities suffice for (a height map is not published)."""
    return [name for name, definition in registry().items() if definition.fitting.identifiable and not definition.needs_map]


class Run(NamedTuple):
    """One law through the stages of one test."""

    test: Test
    law: object
    paths: tuple  # one Path per stage

    @property
    def radius(self):
        """R [m] of the shape that yields and unloads."""
        return float(self.law.definition.bulk_radius(self.test.contact, **self.law.options))

    @property
    def breaches(self):
        """Limits of the law that the run's forces exceed."""
        force = np.concatenate([path.force for path in self.paths])
        return self.law.breaches(float(np.min(force[force > 0.0])), float(np.max(force)))

    @property
    def beyond(self):
        """Where the run leaves the overlaps for which contact laws are valid (a tenth of R), in words; "" where it does not."""
        path = max(self.paths, key=lambda path: path.overlap.max())
        deepest = int(np.argmax(path.overlap))
        share = float(path.overlap[deepest]) / self.radius
        if share <= 0.1:
            return ""
        first = float(path.force[np.argmax(path.overlap > 0.1 * self.radius)])
        where = f"{share:.3f} R at {path.force[deepest]:.0f} N"
        return f"above {first:.0f} N the overlap passes 0.1 R, the limit of contact laws: {where}"


def protocol(bound, turning_points, steps=400):
    """The tests' protocol: displacement control to 10 N, then force control through the turning points."""
    first = driver.displacement_controlled(bound, [float(bound.overlap(SWITCH_FORCE))], steps)
    later = driver.force_controlled(bound, [SWITCH_FORCE, *turning_points], steps)
    return bound.follow(np.concatenate([first.overlap, later.overlap[steps + 1 :]]))


def run_test(name, test):
    """Run law `name` through `test`; `Run.breaches` and `Run.beyond` say where it leaves its range."""
    with quiet():
        bound = bind(name, test)
        return Run(test, bound, tuple(protocol(bound, stage) for stage in test.stages))


def displacement_gained(bound, low=0.1, high=100.0):
    """Overlap gained [m] by first loading between two forces [N]."""
    return float(bound.overlap(high) - bound.overlap(low))


def stiffness_at(bound, force):
    """Tangent stiffness [N/m] of first loading at `force` [N]."""
    return float(bound.stiffness(bound.overlap(force)))


def hertz_stiffness(test, force, radius=None):
    """K_H = (6 P R E*²)^(1/3) [N/m]; R of the test unless another radius [m] is given."""
    return (6.0 * force * (radius or test.radius) * test.modulus**2) ** (1 / 3)


# --- tables


def forces_of(test):
    """Forces [N] between which displacement is gained, and those at which stiffness is listed."""
    return (0.1, 20.0, (1.0, 7.0, 10.0, 20.0)) if test.cyclic else (0.1, 100.0, (1.0, 10.0, 50.0, 100.0))


def gains(run):
    """Displacement gained [µm] and stiffnesses [N/mm] of a run, between and at the forces of its test."""
    low, high, loads = forces_of(run.test)
    with quiet():
        return displacement_gained(run.law, low, high) / MICRO, [stiffness_at(run.law, load) / 1e3 for load in loads]


class StageRow(NamedTuple):
    """One loading branch of a cyclic test."""

    stage: int
    maximum_force: float  # [N]
    reload_stiffness: float  # [N/m] at half the earlier maximum, or nan on first loading
    over_hertz: float  # that stiffness over Hertz's at the same load
    final_stiffness: float  # [N/m] at the branch's maximum
    plastic_overlap: float  # cumulative, after unloading [m]


def stages_of(run):
    """Loading branches of every stage of a cyclic run."""
    rows = []
    for number, path in enumerate(run.paths, start=1):
        peaks = [i for i in range(1, path.force.size - 1) if path.force[i - 1] < path.force[i] > path.force[i + 1]]
        largest, start = 0.0, 0
        for peak in peaks:
            reload, over = math.nan, math.nan
            if largest > 0.0:
                branch = slice(start, peak + 1)
                at = start + int(np.argmin(np.abs(path.force[branch] - 0.5 * largest)))
                reload = float(path.stiffness[at])
                over = reload / hertz_stiffness(run.test, float(path.force[at]), run.radius)
            force = float(path.force[peak])
            rows.append(StageRow(number, force, reload, over, float(path.stiffness[peak]), float(path.plastic_overlap[peak])))
            largest = max(largest, force)
            after = path.force[peak:]
            start = peak + int(np.argmin(after[: first_rise(after)]))
    return rows


def first_rise(force):
    """Index of the first force above the one before, the number of forces if there is none."""
    rises = np.flatnonzero(np.diff(force) > 0)
    return int(rises[0]) + 1 if rises.size else force.size


# --- derived curves


def threshold_force(test):
    """F of Pohrt & Popov [N]."""
    bound = bind(POHRT_POPOV, test, "elastic")
    return float(bound.force(1.0 / bound.params.inverse_threshold))


def effective_radius(alpha):
    """a*/a_H against α: the RMS fit, and Greenwood & Tripp for μ = 4 and 17."""
    alpha = np.asarray(alpha, float)
    force = 4.0 / 3.0 * alpha**-1.5
    curves = {"RMS fit": 2.4 - 2.8 / (alpha + 2.0)}
    for mu in (4.0, 17.0):
        curves[f"Greenwood-Tripp μ = {mu:g}"] = master_curves.effective_radius(mu, force)
    return curves
