"""How soft grains may be, and how fast they may be loaded: predicted from the errors that `demlaws trade --softening` measured.

Two causes [our derivation]: geometry, which is lost at the order of x = overlap over diameter of the softened grains at the
mean force; and waves, too few of which cross the sample while it is loaded elastically when y = I √κ_K is large, with
κ_K = K/(p d), K the softened tangent at the mean force. The error of each is read from the study's curve of x or y; below the
first measured point it goes as the first two do, beyond the last one nothing is predicted. Roughness left alone costs what the
law itself says. No bounds from the literature are used.
"""

import functools
import math
import warnings
from typing import Any, NamedTuple

import numpy as np

from demlaws.advice.scene import Scene
from demlaws.advice.soften import Softening, soften
from demlaws.checks import number
from demlaws.contact import Contact
from demlaws.errors import DemlawsError, ValidityWarning
from demlaws.make import law as bind_law
from demlaws.materials import DENSITY

MEASURED = {
    "stiffness": ("low", "loading", "unloading"),
    "overlap": ("low", "loading", "unloading"),
    "energy": ("work",),
    "force": ("forces",),
}
"""Quantity of a scene → those of the study that stand for it."""
FACTORS = (1.0, 2.0, 3.0, 5.0, 10.0, 20.0, 30.0, 50.0, 100.0)
INERTIAL = tuple(float(f"{v:.2g}") for v in np.geomspace(1e-5, 1e-2, 25))
MARGIN = 1.15
"""By what the curve's error is multiplied for scenes that are unlike the study's."""
STEADY = 3e-4
"""I of the study's own runs at full modulus."""


class Numbers(NamedTuple):
    """What a softened packing is at its mean force."""

    depth: float  # x: overlap over diameter
    kappa: float  # κ_K = K/(p d)
    waves: float  # y = I √κ_K
    branch: float  # relative error of stiffness if σ, hardness and yield pressure are left alone, at weak contacts


def numbers(
    contact: Contact, name: str, options: dict, force: float, pressure: float, factor: float, inertial: float
) -> Numbers:
    """`Numbers` of grains of contact `contact` (its radius a quarter of the diameter) of law `name` at mean `force` [N]."""
    softening, diameter = Softening(factor), 4.0 * float(contact.radius)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ValidityWarning)
        law = bind_law(name, contact, **options)
        overlap = float(law.overlap(force))
        kappa = float(law.stiffness(overlap)) * softening.stiffness / (pressure * diameter)
        branch = 0.0
        if factor != 1.0:
            branch = max(abs(softening.report(law, share * force).left_alone_error) for share in (0.1, 0.3, 1.0))
    return Numbers(overlap * softening.overlap / diameter, kappa, inertial * math.sqrt(kappa), branch)


class Curve(NamedTuple):
    """Measured errors against x or y, made monotone: a power law between neighbours."""

    place: np.ndarray
    error: np.ndarray

    def at(self, place: float) -> float:
        """Error there: below the first point it goes as the first two do (at least as the square root, at most in
        proportion); infinite beyond the last."""
        if place > self.place[-1] * (1.0 + 1e-9):
            return math.inf
        x, e = np.log(self.place), np.log(self.error)
        if place >= self.place[0]:
            return float(np.exp(np.interp(math.log(place), x, e)))
        power = (e[1] - e[0]) / (x[1] - x[0]) if x.size > 1 else 1.0
        return float(self.error[0] * (place / self.place[0]) ** min(max(power, 0.5), 1.0))


def error_curve(pairs: list) -> Curve:
    """(knob, error) of kept runs as a curve that rises with the knob and lies above all of them."""
    ordered = sorted((x, e) for x, e in pairs if x > 0.0 and e > 0.0)
    if not ordered:
        raise DemlawsError("the study that is kept has no rows to predict from: demlaws trade --softening FILE makes them")
    place, error = np.array(ordered).T
    return Curve(place, np.maximum.accumulate(error))


@functools.cache
def curves(quantity: str, unloads: bool) -> tuple[Curve, Curve, float]:
    """(error against x, error against y, chance) of a quantity, from the kept rows in YADE."""
    from demlaws.measure import softening

    names = [n for n in MEASURED[quantity] if unloads or n != "unloading"]
    rows = softening.load()
    points = [
        p
        for p in softening.points(rows)
        if (p.run.engine, p.run.process, p.run.part, p.run.scaled) == ("yade", "cycles", 0.5, True)
        and (p.run.law, p.run.unloading) == softening.STUDIED
    ]
    steady = {p.run.factor: p for p in points if p.run.inertial == STEADY}
    geometry, rate = [], []
    told = set(softening.scenes("yade", softening.OTHERS))  # those that are held back are no part of this
    for p in softening.points(rows, others=True):
        if p.run in told and p.run.scaled and p.run.inertial == STEADY and p.run.factor > 1.0:
            geometry.append((_of_run(p.run).depth, max(abs(p.errors[n]) for n in names)))
    for p in points:
        here = _of_run(p.run)
        if p.run.inertial == STEADY and p.run.factor > 1.0:
            geometry.append((here.depth, max(abs(p.errors[n]) for n in names)))
        elif p.run.inertial > STEADY and p.run.factor in steady:
            base = steady[p.run.factor].errors
            changed = [
                abs(p.errors[n] - base[n]) if n == "forces" else abs((1.0 + p.errors[n]) / (1.0 + base[n]) - 1.0)
                for n in names
                if n in p.errors
            ]
            # so fast that a stress is passed between two looks: nothing is right
            rate.append((here.waves, max(changed) if len(changed) == len(names) else 1.0))
    chance = max((steady[1.0].chance[n] for n in names), default=0.0) if 1.0 in steady else 0.0
    return error_curve(geometry), error_curve(rate), chance


def _of_run(run: Any) -> Numbers:
    from demlaws.measure.candidates import GRANITE

    scene = Scene(
        radii=run.size * 4e-3,
        materials=GRANITE,
        surfaces=run.surface,
        pressure=(0.1 * run.stress, run.stress),
        quantity="stiffness",
    )
    return _of_scene(scene, run.law, {}, run.factor, run.inertial)


def _of_scene(scene, name, options, factor, inertial):
    if scene.pressure is None:
        raise DemlawsError("softening is advised for a packing under pressure: give the scene its pressure in Pa")
    radius = 0.25 * (scene.radii[0] + scene.radii[1])
    contact = max(scene.contacts(radius), key=lambda c: c.modulus)
    force = float(scene.mean_force(scene.pressure[1], radius))
    return numbers(contact, name, options, force, scene.pressure[1], factor, inertial)


def _rate(scene, inertial):
    density = min(DENSITY if m.density is None else m.density for m in scene.materials)
    return inertial / (sum(scene.radii) * math.sqrt(density / scene.pressure[1]))


class Advice(NamedTuple):
    """A modulus factor and a loading rate for a scene, with what they cost."""

    factor: float
    inertial: float  # I
    rate: float  # strain rate [1/s] of that I
    numbers: Numbers
    geometry: float  # predicted error of each cause
    waves: float
    error: float  # predicted, all of it, with twice the scatter of chance
    left_alone: float  # what the error would be with σ, hardness and yield pressure left alone
    steps: float  # steps to a given strain over those at full modulus and I = STEADY
    scene: Scene  # softened

    def lines(self) -> list[str]:
        """As text."""
        n, scaled = self.numbers, Softening(self.factor)
        first = "full modulus: softer grains would cost more than they save within this tolerance"
        if self.factor != 1.0:
            first = (
                f"modulus / {self.factor:g} (σ, hardness, yield pressure scaled along: demlaws soften), stable step × "
                f"{scaled.step:.3g}, density as it is"
            )
        alone = "" if self.factor == 1.0 else f"; with E alone softened {100 * self.left_alone:.2g} %"
        return [
            first,
            f"  strain rate up to {self.rate:.3g} 1/s (I = {self.inertial:.2g}); κ_K = {n.kappa:.3g}, overlap/diameter "
            f"{n.depth:.2g}; steps to a given strain × {self.steps:.2g} of full modulus at I = {STEADY:g}",
            f"  predicted error of the packing's {self.scene.quantity}: {100 * self.error:.2g} % (geometry "
            f"{100 * self.geometry:.2g} %, rate {100 * self.waves:.2g} %){alone}",
        ]


def predict(
    scene: Scene, factor: float, inertial: float = STEADY, law: str = "pohrt-popov", options: dict | None = None
) -> Advice:
    """Predicted error of the scene's quantity with grains softer by `factor` and loaded at inertial number `inertial`.

    The quantity is that of a packing under the scene's largest pressure. Raises DemlawsError without a pressure, for a
    quantity that the study has not measured (restitution), or for a law that cannot be softened.
    """
    if not isinstance(scene, Scene):
        raise DemlawsError(f"scene must be a demlaws.Scene, got {scene!r:.60}")
    factor, inertial = number(factor, "factor"), number(inertial, "inertial number", "", 0.0, 1.0)
    if scene.quantity not in MEASURED:
        raise DemlawsError(f"quantity = {scene.quantity!r}: softening is advised for {', '.join(MEASURED)}")
    here = _of_scene(scene, law, options or {}, factor, inertial)
    full = _of_scene(scene, law, options or {}, 1.0, STEADY)
    by_depth, by_waves, chance = curves(scene.quantity, scene.unloads)
    geometry = 0.0 if factor == 1.0 else MARGIN * by_depth.at(here.depth)
    waves = MARGIN * by_waves.at(here.waves)
    error = (1.0 + geometry) * (1.0 + waves) - 1.0 + 2.0 * chance
    alone = (1.0 + error) * (1.0 + here.branch) - 1.0
    rate = _rate(scene, inertial)
    steps = math.sqrt(here.kappa / full.kappa) * STEADY / inertial
    return Advice(factor, inertial, rate, here, geometry, waves, error, alone, steps, soften(scene, factor))


def advise(scene: Scene, law: str = "pohrt-popov", options: dict | None = None) -> Advice | None:
    """The factor and rate of fewest steps to a given strain whose predicted error is within the scene's tolerance, or None.

    A `rate` of the scene [1/s] is the fastest that it allows.
    """
    best = None
    for factor in FACTORS:
        for inertial in INERTIAL:
            try:
                found = predict(scene, factor, inertial, law, options)
            except DemlawsError:
                if factor == 1.0:
                    raise
                break
            if found.error > scene.tolerance or (scene.rate is not None and found.rate > scene.rate * (1.0 + 1e-9)):
                break
            if best is None or found.steps < best.steps:
                best = found
    return best
