"""How soft grains may be, how fast they may be loaded, in how long a step: from the errors that `demlaws trade --softening`
measured.

Three causes, each with a measured curve [our derivation]: geometry, over x = overlap over diameter of the softened grains at
the mean force; rate, over y = I √κ_K in an oedometer (too few waves cross the sample while it is loaded; κ_K = K/(p d), K the
softened tangent at the mean force), over I in shear; and the time step, over its part of the stable one. Errors are those
against the study's own runs: full modulus, I of `STEADY`, half the stable step. Below its first point a curve goes as its first
two do; beyond the last one nothing is predicted. Roughness left alone costs what the law itself says. Density is no fourth
knob: of one inertial number I = rate × d √(ρ/p), denser grains loaded more slowly take the same steps, so that a density
factor serves where the rate is given.

Where a process has no measured curve of the scene's quantity, full modulus and the literature's `QUASISTATIC` are all that is
advised, and no error is predicted.
"""

import functools
import math
import warnings
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from demlaws.advice.scene import PROCESSES, Scene, stable_step, unloading_rule
from demlaws.advice.soften import Softening, soften
from demlaws.contact import Contact
from demlaws.errors import DemlawsError, ValidityWarning
from demlaws.laws.names import USUAL
from demlaws.make import law as bind_law
from demlaws.make import rebound
from demlaws.materials import DENSITY
from demlaws.units import number

STIFFNESS = ("low", "loading", "unloading")
MEASURED: dict[str, dict[str, tuple]] = {
    "oedometer": {"stiffness": STIFFNESS, "overlap": STIFFNESS, "energy": ("work",), "force": ("forces",)},
    "shear": {"force": ("peak",)},
    "pour": {"force": ("forces",), "overlap": ("height",)},
}
"""Process → quantity of a scene → those of the study that stand for it."""
NAMES = {
    **dict.fromkeys(STIFFNESS, "stiffness"),
    "work": "loss in a cycle",
    "forces": "distribution of forces",
    "peak": "peak strength",
    "height": "height",
}
FACTORS = (1.0, 2.0, 3.0, 5.0, 10.0, 20.0, 30.0, 50.0, 100.0)
INERTIAL = tuple(float(f"{v:.2g}") for v in np.geomspace(1e-5, 1e-2, 25))
PARTS = (0.5, 0.7)
"""Parts of the stable step that are advised: at 0.9 grains vibrate however slow the loading (docs/trade.md)."""
WAYS = tuple((factor, rate, part) for factor in FACTORS for rate in INERTIAL for part in PARTS)
"""(factor, I, part of the stable step) of which the fastest that keeps the tolerance is advised."""
SLOWEST = 1e3
"""By what a rate may be slower, at most, than that of its I at the grains' own density: a density factor of a million."""
MARGIN = 1.15
"""By what the curve's error is multiplied for scenes that are unlike the study's."""
STEADY = 3e-4
"""I of the study's own runs at full modulus."""
HALF = 0.5
"""Part of the stable step that the study's own runs take."""
QUASISTATIC = 1e-3
"""I below which flow is called quasi-static (from there to 0.1 dense): Wikipedia, "Inertial number", after GDR MiDi 2004 and
da Cruz et al. 2005 (as cited there and in J. Fluid Mech., "Constitutive relations for compressible granular flow in the
inertial regime"). Of the stiffness number no bound was at hand in text; Lommen, Schott & Lodewijks 2014 (Particuology 12,
107, abstract) found bulk behaviour unchanged by softening in two cases of three, which is what is measured here."""


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
    """Measured errors against what causes them, made monotone: a power law between neighbours."""

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
    largest: dict = {}
    for x, e in pairs:
        if x > 0.0 and e > 0.0:
            largest[x] = max(e, largest.get(x, 0.0))
    if not largest:
        raise DemlawsError("the study that is kept has no rows to predict from: demlaws trade --softening FILE makes them")
    place, error = np.array(sorted(largest.items())).T
    return Curve(place, np.maximum.accumulate(error))


class Curves(NamedTuple):
    """What the study measured of a quantity in a process."""

    geometry: Curve  # over x
    rate: Curve | None  # over y, in shear over I, at full modulus; None: the process has no rate
    soft_rate: Curve | None  # the same of softer grains, against the same grains at `STEADY`
    step: Curve | None  # over the part of the stable step, against half of it; None: no other was run
    unbalanced: Curve | None  # unbalanced force over the mean force, over the same as `rate`
    chance: float  # scatter of one copy at full modulus


@functools.cache
def curves(process: str, quantity: str, unloads: bool) -> Curves:
    """`Curves` of a quantity in a process, from the kept rows in YADE."""
    from demlaws.measure import softening

    names = [n for n in MEASURED[process][quantity] if unloads or n != "unloading"]
    pressed = process == "oedometer"
    rows = softening.load()

    def change(point, other=None):
        """Largest error of a point against another one (None: against the process as it is)."""
        of = [n for n in names if n in point.errors]
        if len(of) < len(names):  # so fast that a stress is passed between two looks: nothing is right
            return 1.0
        if other is None:
            return max(abs(point.errors[n]) for n in of)
        absolute = softening.ABSOLUTE
        return max(
            abs(point.errors[n] - other.errors[n])
            if n in absolute
            else abs((1.0 + point.errors[n]) / (1.0 + other.errors[n]) - 1.0)
            for n in of
        )

    def place(run):
        return _of_run(run).waves if pressed else run.inertial

    points = {
        (p.run.factor, p.run.inertial, p.run.part): p
        for p in softening.points(rows)
        if (p.run.engine, p.run.process) == ("yade", "cycles" if pressed else process)
        and (p.run.law, p.run.unloading, p.run.density) == (*softening.STUDIED, 1.0)
        and (p.run.scaled or p.run.factor == 1.0)
    }
    plain = points.get((1.0, STEADY, HALF))
    if plain is None:
        return Curves(error_curve([]), None, None, None, None, 0.0)
    geometry, rate, soft, step, unbalanced = [], [], [], [], []
    for (factor, inertial, part), p in points.items():
        steady = points.get((factor, STEADY, HALF))
        if part == HALF and inertial == STEADY and factor > 1.0:
            geometry.append((_of_run(p.run).depth, change(p, plain)))
        elif part == HALF and inertial > STEADY and steady is not None:
            (rate if factor == 1.0 else soft).append((place(p.run), change(p, steady)))
        elif part > HALF and (factor, inertial) == (1.0, STEADY):
            step.append((part, change(p, plain)))
        if part == HALF and p.unbalanced is not None:
            unbalanced.append((place(p.run), p.unbalanced))
    if pressed:
        told = {*softening.scenes("yade", softening.OTHERS), *softening.scenes("yade", softening.FASTER)}
        for p in softening.points(rows, others=True):  # those that are held back are no part of this
            if p.run in told and p.run.scaled and p.run.part == HALF:
                if p.run.factor > 1.0 and p.run.inertial == STEADY:
                    geometry.append((_of_run(p.run).depth, change(p)))
                elif p.run.factor == 1.0 and p.run.inertial > STEADY:
                    rate.append((place(p.run), change(p)))
    chance = max((plain.chance[n] for n in names if plain.chance.get(n) == plain.chance.get(n)), default=0.0)
    moved = error_curve(unbalanced) if unbalanced else None
    long, slow = error_curve(step) if step else None, process == "pour"
    return Curves(
        error_curve(geometry), None if slow else error_curve(rate), None if slow else error_curve(soft), long, moved, chance
    )


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
    """A modulus factor, a loading rate, a density factor and a time step for a scene, with what they cost."""

    factor: float
    inertial: float  # I
    rate: float  # strain rate [1/s] of that I, with the density factor
    numbers: Numbers
    geometry: float  # predicted error of each cause; not a number: not measured
    waves: float
    coarse: float  # of the time step
    error: float  # predicted, all of it, with twice the scatter of chance
    left_alone: float  # what the error would be with σ, hardness and yield pressure left alone
    steps: float  # steps of the process over those at full modulus, I = STEADY and half the stable step
    scene: Scene  # softened, of the denser grains
    part: float = HALF  # of the stable step
    dt: float = math.nan  # time step [s]
    density: float = 1.0  # factor of the density; gravity is to be divided by it
    unbalanced: float = math.nan  # predicted largest unbalanced force over the mean force while it moves
    what: str = ""  # what is wrong by `error`

    @property
    def measured(self) -> bool:
        """Whether the error is predicted from measured curves; else only the literature's bound of I is kept."""
        return self.error == self.error

    def lines(self) -> list[str]:
        """As text."""
        n, scaled = self.numbers, Softening(self.factor)
        first = "full modulus: softer grains would cost more than they save within this tolerance"
        if not self.measured:
            first = "full modulus: what softer grains cost of this quantity in this process has not been measured"
        if self.factor != 1.0:
            first = (
                f"modulus / {self.factor:g} (σ, hardness, yield pressure scaled along: demlaws soften), stable step × "
                f"{scaled.step:.3g}"
            )
        dense = "density as it is"
        if self.density != 1.0:
            dense = (
                f"density × {self.density:.3g}, gravity / {self.density:.3g} (the weight stays: at this rate I, and the steps, "
                "are those of a faster one)"
            )
        lines = [f"{first}; {dense}", f"  time step {self.dt:.3g} s, {self.part:g} of the stable one"]
        if self.scene.process == "pour":
            lines.append(f"  κ_K = {n.kappa:.3g}, overlap/diameter {n.depth:.2g}")
        else:
            force = "" if self.unbalanced != self.unbalanced else f", unbalanced force up to {self.unbalanced:.2g} of the mean"
            lines.append(
                f"  strain rate up to {self.rate:.3g} 1/s (I = {self.inertial:.2g}{force}); κ_K = {n.kappa:.3g}, "
                f"overlap/diameter {n.depth:.2g}"
            )
        to = {"oedometer": "to the stress", "pour": "of the fall"}.get(self.scene.process, "to a given strain")
        lines.append(f"  steps {to} × {self.steps:.2g} of full modulus at I = {STEADY:g} and half the stable step")
        if not self.measured:
            return [*lines, f"  no error is predicted: I ≤ {QUASISTATIC:g} is the literature's bound of quasi-static loading"]
        causes = [(self.geometry, "geometry"), (self.waves, "rate"), (self.coarse, "time step")]
        of = ", ".join(f"{name} {100 * error:.2g} %" for error, name in causes)
        alone = "" if self.factor == 1.0 else f"; with E alone softened {100 * self.left_alone:.2g} %"
        return [*lines, f"  predicted error of the packing's {self.what}: {100 * self.error:.2g} % ({of}){alone}"]


def _process(scene):
    """The process whose errors are predicted: without one the scene's strain is given, its errors those of an oedometer."""
    return scene.process or PROCESSES[0]


def _steps(scene, factor, inertial, part):
    """Steps over those at full modulus, STEADY and half the stable step."""
    share = HALF / part / Softening(factor).step
    if scene.process == "pour":  # the time is given
        return share
    strain = Softening(factor).overlap if scene.process == "oedometer" else 1.0  # the stress is given, or the strain
    return share * strain * STEADY / inertial


def _of_step(curve, part):
    """Error of a step against half the stable one, than which none is taken to be better."""
    if part <= HALF:
        return 0.0
    return math.inf if curve is None else MARGIN * curve.at(part)


def _check(scene):
    if not isinstance(scene, Scene):
        raise DemlawsError(f"scene must be a demlaws.Scene, got {scene!r:.60}")
    if scene.quantity == "restitution":
        known = ", ".join(MEASURED["oedometer"])
        raise DemlawsError(f"quantity = 'restitution': softening is advised for {known} of a packing")


def _predicted(scene, law, options, factor, inertial, part, here):
    """`Advice` but for its scene and time step."""
    process = _process(scene)
    if scene.quantity not in MEASURED[process]:
        geometry = waves = step = error = alone = unbalanced = math.nan
        what = scene.quantity
    else:
        found = curves(process, scene.quantity, scene.unloads)
        place = here.waves if process == "oedometer" else inertial
        geometry = 0.0 if factor == 1.0 else MARGIN * found.geometry.at(here.depth)
        rates = found.rate if factor == 1.0 else found.soft_rate
        waves = 0.0 if rates is None else MARGIN * rates.at(place)
        if factor != 1.0 and inertial <= STEADY:  # what it costs there is part of geometry's curve
            waves = 0.0
        step = _of_step(found.step, part)
        error = (1.0 + geometry) * (1.0 + waves) * (1.0 + step) - 1.0 + 2.0 * found.chance
        alone = (1.0 + error) * (1.0 + here.branch) - 1.0
        unbalanced = math.nan if found.unbalanced is None or process == "pour" else found.unbalanced.at(place)
        what = NAMES[MEASURED[process][scene.quantity][0]]
    rate, density = _rate(scene, inertial), 1.0
    if scene.rate is not None and rate > scene.rate and process != "pour":
        slower = rate / scene.rate
        density, rate = slower * slower if slower < SLOWEST else math.inf, scene.rate
        error = error if density < math.inf else math.inf
    steps = _steps(scene, factor, inertial, part)
    return Advice(
        factor,
        inertial,
        rate,
        here,
        geometry,
        waves,
        step,
        error,
        alone,
        steps,
        scene,
        part,
        math.nan,
        density,
        unbalanced,
        what,
    )


def _finished(advice, law, options):
    """With the softened scene of denser grains, and the time step."""
    scene, density = advice.scene, advice.density

    def bind(contact):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ValidityWarning)
            return bind_law(law, contact, rebound(back, contact), **options)

    back = unloading_rule(scene, law, options)  # of many a law unloading is stiffer than loading
    stable = stable_step(scene, bind) * Softening(advice.factor).step * math.sqrt(density)
    softer = soften(scene, advice.factor)
    if density != 1.0:
        heavier = tuple(replace(m, density=density * (DENSITY if m.density is None else m.density)) for m in softer.materials)
        softer = replace(softer, materials=heavier)
    return advice._replace(dt=advice.part * stable, scene=softer)


def predict(
    scene: Scene,
    factor: float,
    inertial: float = STEADY,
    law: str = USUAL,
    options: dict | None = None,
    part: float = HALF,
) -> Advice:
    """Predicted error of the scene's quantity with grains softer by `factor`, at inertial number `inertial`, in steps of `part`
    of the stable one.

    The quantity is that of a packing under the scene's largest pressure. Raises DemlawsError without a pressure, for
    restitution, which is no packing's, or for a law that cannot be softened.
    """
    _check(scene)
    factor, inertial = number(factor, "factor"), number(inertial, "inertial number", "", 0.0, 1.0)
    part, options = number(part, "part of the stable step", "", 0.0, 1.0), options or {}
    here = _of_scene(scene, law, options, factor, inertial)
    return _finished(_predicted(scene, law, options, factor, inertial, part, here), law, options)


def advise(scene: Scene, law: str = USUAL, options: dict | None = None, ways: tuple = WAYS) -> Advice | None:
    """The factor, rate and time step of fewest steps whose predicted error is within the scene's tolerance, or None.

    A `rate` of the scene [1/s] is the fastest that it allows; where that of the advised I is faster, density is multiplied
    instead. ways: (factor, I, part of the stable step) to choose from. Where the study has not measured the scene's quantity in
    its process, full modulus at the literature's bound of I.
    """
    _check(scene)
    options = options or {}
    if scene.quantity not in MEASURED[_process(scene)]:
        return predict(scene, 1.0, QUASISTATIC, law, options)
    best, at = None, {}
    for factor, inertial, part in ways:
        if best is not None and _steps(scene, factor, inertial, part) >= best.steps:
            continue
        if factor not in at:
            try:
                at[factor] = _of_scene(scene, law, options, factor, 1.0)
            except DemlawsError:
                if factor == 1.0:
                    raise
                at[factor] = None
        if at[factor] is None:
            continue
        here = at[factor]._replace(waves=inertial * at[factor].waves)
        found = _predicted(scene, law, options, factor, inertial, part, here)
        if found.error <= scene.tolerance:
            best = found
    return best if best is None else _finished(best, law, options)
