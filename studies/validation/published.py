"""Rows that need no engine."""

import itertools
import math
from typing import NamedTuple

import numpy as np

from demlaws import driver, errors
from demlaws.contact import Contact
from demlaws.granite import displacement_gained, find_test, options_for, stiffness_at
from demlaws.laws import (
    BAHRAMI,
    CONICAL_DAMAGE,
    EEPA,
    GODDARD,
    HERTZ,
    JACKSON_GREEN,
    KOGUT_ETSION,
    LUDING,
    POHRT_POPOV,
    RMS,
    ROUGH_PLASTIC,
    THORNTON_NING,
    WALTON_BRAUN,
    YIP_VENART,
)
from demlaws.make import law
from demlaws.solvers import master_curves
from demlaws.solvers.criterion import central_pressure
from demlaws.solvers.master_curves import ELASTIC_LAYER, PLASTIC_LAYER
from studies.extremes.exact import EXACT
from studies.half_space.axisymmetric import solve
from studies.jamari.published import PRINTED_RATIOS
from studies.validation import oblique
from studies.validation.maps import load_ratios, read_csv
from studies.validation.row import NUMBERS, PYTHON, between, near


def bound(name, contact, unloading="elastic", **options):
    """A law, without its warnings outside the validity range, which these rows leave on purpose."""
    with errors.quiet():
        return law(name, contact, unloading, **options)


def quiet(function, *arguments):
    """Call without warnings about a law's range."""
    with errors.quiet():
        return function(*arguments)


# --- impacts


class Impact(NamedTuple):
    """A sphere of `radius` [m] that meets its like, or a rigid plane, at `speed` [m/s]; the peak force [N] is printed."""

    name: str
    young: float
    poisson: float
    density: float
    radius: float
    speed: float
    plane: bool
    peak: float

    @property
    def mass(self):
        """Of the one body that moves against the other: m, or m/2."""
        whole = 4.0 / 3.0 * math.pi * self.radius**3 * self.density
        return whole if self.plane else 0.5 * whole

    @property
    def contact(self):
        """The contact of this impact."""
        plane_modulus = self.young / (1.0 - self.poisson**2)
        return Contact(self.radius, plane_modulus) if self.plane else Contact(0.5 * self.radius, 0.5 * plane_modulus)


IMPACTS = tuple(Impact(*row) for row in NUMBERS["impacts"])
IMPACT_TOLERANCE = 1e-5
"""Of the printed peaks: they have five or six digits."""


def impacts():
    """Rows: peak force of the published impacts."""
    for one in IMPACTS:
        peak = driver.impact(bound(HERTZ, one.contact), one.mass, one.speed, 4000).peak_force
        yield near(f"peak force: {one.name}", one.peak, peak, IMPACT_TOLERANCE, "chung-ooi", unit="N")


def _verlet(one, mass, place, *, speed, dt, steps):
    """Positions after each number of `steps` of velocity Verlet, of a body that meets the contact at place 0."""
    found, force = [], 0.0
    for count in steps:
        for _ in range(count):
            speed += 0.5 * dt * force / mass
            place += dt * speed
            force = float(one.force(max(-place, 0.0))) if place < 0.0 else 0.0
            speed += 0.5 * dt * force / mass
        found.append((place, speed))
    return found


class Kept(NamedTuple):
    """An impact of LAMMPS's own tests: a sphere meets its like, or a wall; what it keeps is a place [m] after so many steps."""

    name: str
    modulus: float  # E* [Pa]: 3/4 of the k_n of its input
    density: float
    radius: float
    place: float  # at the start: of the upper of two spheres, which mirror each other, or over the wall
    speed: float  # at which the surfaces meet
    plane: bool
    dt: float
    after: tuple  # steps
    places: tuple


KEPT = tuple(Kept(*row) for row in NUMBERS["kept"])
KEPT_TOLERANCE = 1e-12
"""Of the places: a choice of ours, far below what a wrong digit of E*, a step or a wrong half makes."""


def kept_rows(one, where, places):
    """Rows of one of LAMMPS's tests, from the places found."""
    for steps, kept, found in zip(one.after, one.places, places, strict=True):
        yield near(f"{one.name}, position after {steps} steps", kept, found, KEPT_TOLERANCE, "lammps", unit="m", where=where)


def lammps_impacts():
    """The positions that LAMMPS's own tests keep, after the same steps of the same size."""
    for one in KEPT:
        # each sphere of two moves half the approach
        share = 1.0 if one.plane else 0.5
        hertz = bound(HERTZ, Contact(share * one.radius, one.modulus))
        mass = share * 4.0 / 3.0 * math.pi * one.radius**3 * one.density
        counts = [b - a for a, b in itertools.pairwise((0, *one.after))]
        states = _verlet(hertz, mass, (one.place - one.radius) / share, speed=-one.speed, dt=one.dt, steps=counts)
        yield from kept_rows(one, PYTHON, [one.radius + share * place for place, _ in states])


# --- yield


YIELD_RATIO = 1e-3
"""p_y/E* of the restitution rows: small, so that overlaps stay small against R at a thousand times the yield speed."""
SPEEDS = (1.0, 2.0, 5.0, 20.0, 100.0, 1000.0)


def restitution_of(ratio):
    """e of Thornton & Ning's Eq. 44 at `ratio` = V/V_y ≥ 1."""
    inverse = 1.0 / ratio
    return (
        math.sqrt(1.2 * math.sqrt(3.0))
        * math.sqrt(1.0 - inverse**2 / 6.0)
        * (inverse / (inverse + 2.0 * math.sqrt(1.2 - 0.2 * inverse**2))) ** 0.25
    )


def yield_speed(contact, yield_pressure, mass):
    """V_y = (π^5 p_y^5 R³/(30 E*^4 m))^½ (their Eq. 10 with its constant, 3.194, written out)."""
    return math.sqrt(math.pi**5 / 30.0 * yield_pressure**5 * contact.radius**3 / (contact.modulus**4 * mass))


def restitution():
    """Rows: restitution of a yielding sphere against Thornton's equation."""
    contact, mass = Contact(0.005, 30e9, sigma=0.0), 0.01
    pressure = YIELD_RATIO * contact.modulus
    elastoplastic = bound(ROUGH_PLASTIC, contact, "thornton", yield_pressure=pressure, loading=HERTZ)
    for ratio in SPEEDS:
        found = quiet(driver.impact, elastoplastic, mass, ratio * yield_speed(contact, pressure, mass), 40000).restitution
        yield near(f"restitution at V/V_y = {ratio:g}", restitution_of(ratio), found, 1e-5, "thornton")


def _jackson_green(ratio, yield_strength, contact):
    """P/P_c at ω/ω_c of Jackson & Green (ν = 0.3), and ω_c, P_c."""
    c, modulus = 1.295 * math.exp(0.736 * 0.3), contact.modulus
    overlap = (math.pi * c * yield_strength / (2.0 * modulus)) ** 2 * contact.radius
    load = 4.0 / 3.0 * modulus * math.sqrt(contact.radius) * overlap**1.5
    return EXACT[JACKSON_GREEN](contact, ratio * overlap, yield_strength)[0].astype(float) / load, overlap, load


def indentation():
    """What one limit pressure makes of a yielding sphere: how far from the finite elements, over 1.9 to 110 ω_c."""
    contact, strength = Contact(0.01, 100e9, sigma=0.0), 1e8
    ratios = np.geomspace(1.9, 110.0, 40)
    wanted, overlap, load = _jackson_green(ratios, strength, contact)
    off = {}
    for factor in (1.64, 2.8, 4.1, 4.2, 4.3, 4.4):
        plastic = bound(ROUGH_PLASTIC, contact, "thornton", yield_pressure=factor * strength, loading=HERTZ)
        off[factor] = quiet(plastic.force, ratios * overlap) / load / wanted - 1.0
    note = "a limit of the law, not an agreement: known from an independent program"
    for factor, low, high in ((1.64, -0.68, -0.65), (2.8, -0.46, -0.41)):
        what = f"rough-plastic, p_y = {factor} S_y: force error at 110 ω_c"
        yield between(what, low, high, off[factor][-1], "jackson-green", note=note)
    best = min(float(np.max(np.abs(e))) for f, e in off.items() if f > 4.0)
    yield between("rough-plastic, best p_y (4.1–4.4 S_y): largest force error", 0.17, 0.19, best, "jackson-green", note=note)
    # Kogut & Etsion's fits use their own ω_c: K = 0.454 + 0.41 ν, H = 2.8 Y
    k = 0.454 + 0.41 * 0.3
    critical = (math.pi * k * 2.8 * strength / (2.0 * contact.modulus)) ** 2 * contact.radius
    carried = float(quiet(bound(HERTZ, contact).force, critical))
    smooth = bound(HERTZ, contact)
    found = float(quiet(smooth.force, critical)) / carried
    yield near("Hertz at Kogut & Etsion's ω_c: P/P_c of their fit", 1.03, found, 0.031, "kogut-etsion", note="a fit")
    plastic = bound(ROUGH_PLASTIC, contact, "thornton", yield_pressure=4.2 * strength, loading=HERTZ)
    ratios = np.geomspace(6.0, 110.0, 30)
    error = quiet(plastic.force, ratios * critical) / carried / (1.40 * ratios**1.263) - 1.0
    yield between(
        "rough-plastic, p_y = 4.2 S_y: largest force error over 6–110 ω_c",
        0.0,
        0.25,
        np.max(np.abs(error)),
        "kogut-etsion",
        note="a limit of the law",
    )


_RATIO = 2.5
_REST = 1.0 - 1.0 / _RATIO
BRANCHES = (
    (WALTON_BRAUN, "linear", {"loading_stiffness": 2e6, "stiffness_ratio": _RATIO}, math.sqrt(1.0 / _RATIO)),
    # e² = 1 - 1.5 (k2/k1) c^1.5 (1 - c) with c = (1 - k1/k2)^(2/3), from the branches' areas
    (EEPA, "eepa", {"stiffness_ratio": _RATIO}, math.sqrt(1.0 - 1.5 * _RATIO * _REST * (1.0 - _REST ** (2.0 / 3.0)))),
)
"""Law, its rule, options and restitution, which does not depend on speed, for the engines."""


def cycle(name, options, contact, maximum, share):
    """Force at `maximum` [m], and after unloading to a share of it, of the law with its own rule."""
    one = law(name, contact, **options)
    return quiet(one.follow, np.array([maximum, share * maximum])).force


def plastic_laws():
    """The plastic laws of the literature: what their papers' equations give, written out once more."""
    contact, mass = Contact(0.005, 30e9, sigma=0.0), 0.01
    radius, modulus = contact.radius, contact.modulus
    hertz = 4.0 / 3.0 * modulus * math.sqrt(radius)
    pressure, ratio = YIELD_RATIO * modulus, 20.0
    one = law(THORNTON_NING, contact, yield_pressure=pressure)
    found = quiet(driver.impact, one, mass, ratio * yield_speed(contact, pressure, mass), 40000).restitution
    yield near("thornton-ning: restitution at V/V_y = 20", restitution_of(ratio), found, 1e-5, "thornton")

    contact, strength = Contact(0.01, 100e9, sigma=0.0), 1e8
    for ratio in (10.0, 110.0):
        wanted, overlap, load = _jackson_green(ratio, strength, contact)
        found = float(quiet(law(JACKSON_GREEN, contact, yield_strength=strength).force, ratio * overlap)) / load
        yield near(f"jackson-green: P/P_c at {ratio:g} ω_c", wanted, found, 1e-12, "jackson-green")
    critical = (math.pi * (0.454 + 0.41 * 0.3) * 2.8 * strength / (2.0 * modulus)) ** 2 * radius
    load = hertz * critical**1.5
    for ratio, wanted in ((3.0, 1.03 * 3.0**1.425), (50.0, 1.40 * 50.0**1.263)):
        found = (
            float(quiet(law(KOGUT_ETSION, Contact(radius, modulus), yield_strength=strength).force, ratio * critical)) / load
        )
        yield near(f"kogut-etsion: P/P_c at {ratio:g} ω_c", wanted, found, 1e-12, "kogut-etsion")

    contact = Contact(radius, modulus, sigma=0.0)
    sine, peak = math.sin(1.2), 1e9
    blunting, h = (1.0 - sine) / sine, (math.pi * peak / (2.0 * modulus)) ** 2
    top = 3.0 * h * radius
    now = (top + radius * blunting) / (h + blunting)
    wanted = [4.0 / 3.0 * modulus * math.sqrt(now) * (d + (radius - now) * blunting) ** 1.5 for d in (top, 0.9 * top)]
    found = cycle(CONICAL_DAMAGE, {"strength": peak, "angle": 1.2}, contact, top, 0.9)
    for what, one, other in zip(("loading", "unloading"), wanted, found, strict=True):
        yield near(f"conical-damage: force at 3 δ_y, {what}", one, float(other), 1e-12, "conical-damage", unit="N")

    k1, k2 = 2e6, 5e6
    found = quiet(driver.impact, law(WALTON_BRAUN, contact, loading_stiffness=k1, stiffness_ratio=k2 / k1), mass, 0.1, 20000)
    yield near("walton-braun: restitution", math.sqrt(k1 / k2), found.restitution, 1e-6, "walton-braun")

    depth = 0.002
    limit = k2 / (k2 - k1) * depth * 2.0 * radius
    stiffness = k1 + (k2 - k1) * 0.5
    found = cycle(
        LUDING, {"loading_stiffness": k1, "stiffness_ratio": k2 / k1, "plasticity_depth": depth}, contact, 0.5 * limit, 0.9
    )
    yield near("luding: force at δ*/2", 0.5 * k1 * limit, float(found[0]), 1e-12, "luding", unit="N")
    wanted = 0.5 * limit * (k1 - 0.1 * stiffness)
    yield near("luding: after unloading by a tenth", wanted, float(found[1]), 1e-12, "luding", unit="N")

    top = 1e-5
    plastic = (1.0 - 1.0 / 3.0) ** (2.0 / 3.0) * top
    found = cycle(EEPA, {"stiffness_ratio": 3.0}, contact, top, 0.95)
    wanted = 3.0 * hertz * ((0.95 * top) ** 1.5 - plastic**1.5)
    yield near("eepa: after unloading by a twentieth", wanted, float(found[1]), 1e-12, "eepa", unit="N")


# --- roughness


def _force(alpha):
    return 4.0 / 3.0 * alpha**-1.5


def _radius(mu, force):
    return float(master_curves.effective_radius(mu, force))


def greenwood_tripp():
    """Rows: Greenwood & Tripp's contact against another author's code; forces by the solver behind the package's data."""
    for mu, separation, force, radius in NUMBERS["gt-code"]:
        here = solve(ELASTIC_LAYER, mu, np.array([force]))
        # the force at that separation, from the one at ours: dP = K dδ
        found = force - float((here.approach[0] + separation) * here.stiffness[0])
        what = f"μ = {mu:g}, separation {separation:g} σ"
        yield near(f"force: {what}", force, found, 1e-3, "gt-code", unit="E* √R σ^1.5")
        yield near(f"a*/a_H: {what}", radius, _radius(mu, force), 1e-3, "gt-code")
    for alpha, mu, pressure, radius in NUMBERS["gt-paper"]:
        what = f"α = {alpha:g}, μ = {mu:g}"
        yield near(f"p(0)/p0: {what}", pressure, central_pressure(alpha, mu), 4e-3, "gt-paper", note="three digits are given")
        yield near(f"a*/a_H: {what}", radius, _radius(mu, _force(alpha)), 2e-3, "gt-paper", note="three digits are given")


def central_pressures():
    """Rows: p(0)/p0 as Jamari & Schipper read it."""
    for mu, printed in PRINTED_RATIOS.items():
        what = f"p(0)/p0 at α = 0.09, μ = {mu:g}"
        yield near(what, printed, central_pressure(0.09, mu), 0.01, "jamari", note="read from a figure by its authors")


def yip_venart():
    """Rows: p(0)/p0 against a second program of ours: the paper has figures only."""
    for number, alpha, pressure in NUMBERS["yv-paper"]:
        found = float(master_curves.central_pressure(PLASTIC_LAYER, number, _force(alpha)))
        yield near(f"p(0)/p0: N_H = {number:g}, α = {alpha:g}", pressure, found, 7e-3, "yv-paper")


GRANITE_LAWS = (HERTZ, RMS, POHRT_POPOV, YIP_VENART, BAHRAMI)


def granite():
    """Rows: displacement and stiffness of the granite tests."""
    for name, *values in NUMBERS["granite"]:
        test = find_test(name)
        for law_name, (displacement, stiffness) in zip(GRANITE_LAWS, values, strict=True):
            options = {**options_for(law_name, test), **({"constant": 1.605} if law_name == BAHRAMI else {})}
            one = bound(law_name, test.contact, **options)
            gained = 1e6 * quiet(displacement_gained, one)
            yield near(f"{name}, {law_name}: displacement from 0.1 to 100 N", displacement, gained, 7e-3, "granite", unit="µm")
            if law_name == YIP_VENART:
                continue  # the only stiffness at hand is our own
            found = 1e-3 * quiet(stiffness_at, one, 10.0)
            yield near(f"{name}, {law_name}: stiffness at 10 N", stiffness, found, 1e-3, "granite", unit="N/mm")


def cone():
    """Rows: Goddard's law against Sneddon's cone."""
    slope, contact = 0.05, Contact(0.004, 30e9, sigma=0.0)
    one = bound(GODDARD, contact, slope=slope)
    limit = 9.0 * math.pi**3 / 128.0 * contact.modulus * contact.radius**2 * math.tan(slope) ** 3
    overlap = 0.5 * float(one.overlap(limit))
    wanted = 2.0 * contact.modulus / (math.pi * math.tan(slope)) * overlap**2
    yield near("goddard: force of a cone", wanted, float(quiet(one.force, overlap)), 1e-12, "sneddon", unit="N")


ELEMENTS = {1.6e-4: (0.85, 1.15), 3.2e-4: (0.7, 1.3)}
"""Longest roughness wavelength [m] → range of stiffness of Pohrt & Popov over that of the boundary elements."""
ELEMENT_LOADS = np.array([3.0, 6.0, 12.0, 25.0, 50.0])  # [N]: every map was pressed beyond both ends


def boundary_elements():
    """Rough elastic sphere of the granite tests (R = 4.35 mm, σ = 2.40 µm, H = 0.8): tangent stiffness at equal force.

    One map scatters by a third, so the geometric mean of eight is compared.
    """
    rows = read_csv("bem.csv")
    one = bound(POHRT_POPOV, Contact(4.35e-3, 32.32e9, 2.40e-6, 2.2, 6.266e9))
    ours = np.log(quiet(one.stiffness, quiet(one.overlap, ELEMENT_LOADS)))
    for longest, (low, high) in ELEMENTS.items():
        maps = []
        chosen = [row for row in rows if float(row["longest"]) == longest]
        for seed in sorted({row["seed"] for row in chosen}):
            pairs = [(float(row["force"]), float(row["stiffness"])) for row in chosen if row["seed"] == seed]
            force, stiffness = np.log(np.array(pairs)).T
            maps.append(np.interp(np.log(ELEMENT_LOADS), force, stiffness))
        mean = np.mean(maps, axis=0)
        ratio = np.exp(ours - mean)
        what = f"pohrt-popov, longest wavelength {1e6 * longest:g} µm"
        note = f"3 to 50 N, mean of {len(maps)} maps"
        yield between(f"{what}: stiffness over boundary elements, least", low, high, ratio.min(), "bem", note=note)
        yield between(f"{what}: stiffness over boundary elements, largest", low, high, ratio.max(), "bem", note=note)
        exponent = np.polyfit(np.log(ELEMENT_LOADS), mean, 1)[0]
        what = f"{what}: exponent of stiffness over force, theirs (Pohrt & Popov: {0.2567 * 2.2:.3f})"
        if longest < 2e-4:
            yield near(what, 0.2567 * 2.2, exponent, 0.1, "bem", note=note)
        else:
            note += "; waves longer than the contact: a limit of the law"
            yield between(what, 0.45, 0.60, exponent, "bem", note=note)


def asperities():
    """Rows: the asperity model against boundary elements."""
    found = list(load_ratios())
    smooth = np.array([ratio for case, ratio in found if case == "smooth ball"])
    rough = np.array([ratio for case, ratio in found if case != "smooth ball"])
    what = "asperity model over boundary elements at equal separation, load"
    yield between(f"{what}: smooth ball, least", 0.99, 1.01, smooth.min(), "bem")
    yield between(f"{what}: smooth ball, largest", 0.99, 1.01, smooth.max(), "bem")
    yield between(f"{what}: rough maps, least", 0.5, 1.0, rough.min(), "bem")
    yield between(f"{what}: rough maps, median", 0.8, 1.0, np.median(rough), "bem")
    yield between(f"{what}: rough maps, largest", 1.0, 1.35, rough.max(), "bem")


GROUPS = {
    "Hertz impacts": impacts,
    "LAMMPS's own tests": lammps_impacts,
    "Oblique impacts": oblique.rows,
    "Pairwise motions": oblique.pairwise_motions,
    "Restitution of a yielding sphere": restitution,
    "A yielding sphere against finite elements": indentation,
    "Plastic laws of the literature": plastic_laws,
    "Elastic rough spheres (Greenwood & Tripp)": greenwood_tripp,
    "Central pressure as printed": central_pressures,
    "Plastic asperities on an elastic sphere (Yip & Venart)": yip_venart,
    "Granite": granite,
    "A cone": cone,
    "Boundary elements": boundary_elements,
    "Height maps against boundary elements": asperities,
}
