"""How soft grains may be, how fast they may be loaded, in how long a step: from the errors that `make trade` measured.

Three causes, each with a measured curve [our derivation]: geometry, over x = overlap over diameter of the softened grains at
the mean force; rate, over y = I √κ_K in an oedometer (too few waves cross the sample while it is loaded; κ_K = K/(p d), K the
softened tangent at the mean force), over I in shear; and the time step, over its part of the stability limit 2/ω_max. Errors
are those against the study's own runs: full modulus, I of `STEADY`, a step of `STANDARD`. Below its first point a curve goes
as its first two do; beyond the last one nothing is predicted.
"""

import functools
import math
from typing import NamedTuple

import numpy as np

from demlaws.advice.measured_costs import measured_costs
from demlaws.advice.scene import PROCESSES, Scene, stable_step, unloading_rule
from demlaws.advice.soften import Softening, soften
from demlaws.contact import DENSITY
from demlaws.errors import DemlawsError, quiet
from demlaws.laws import USUAL
from demlaws.make import law as bind_law, unloading_for
from demlaws.timestep import STEP_SAFETY
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
STUDY_STEP = 1.36
"""The study's unit of time step over the stability limit: `from_contacts` on its packing in YADE, in the oedometer at the
largest stress (1.3 before shear, 1.5 at its peak; 1.05 where the oedometer is unloaded)."""
HALF = 0.5
"""Time step of the study's own runs in its unit."""
STANDARD = HALF * STUDY_STEP
"""The same as a part of the stability limit."""
PARTS = (STANDARD, STEP_SAFETY)
"""Parts of the stability limit that are advised. In the study, with damping, 0.95 was accurate; at 1.2 grains vibrate however
slow the loading (docs/how-to/time-step.md)."""
WAYS = tuple((factor, rate, part) for factor in FACTORS for rate in INERTIAL for part in PARTS)
"""(factor, I, part of the stability limit) of which the fastest within the tolerance is advised."""
MARGIN = 1.15
"""By what the curve's error is multiplied for scenes that are unlike the study's."""
STEADY = 3e-4
"""I of the study's own runs at full modulus."""


class PackingNumbers(NamedTuple):
    """What a softened packing is at its mean force."""

    depth: float  # x: overlap over diameter
    kappa: float  # κ_K = K/(p d)


class ErrorCurve(NamedTuple):
    """Measured errors against what causes them, made monotone: a power law between neighbours."""

    place: np.ndarray
    error: np.ndarray

    def error_at(self, place: float) -> float:
        """Error there: below the first point it is extrapolated from the first two (at least as the square root, at most in
        proportion); infinite beyond the last."""
        if place > self.place[-1] * (1.0 + 1e-9):
            return math.inf
        x, e = np.log(self.place), np.log(self.error)
        if place >= self.place[0]:
            return float(np.exp(np.interp(math.log(place), x, e)))
        power = (e[1] - e[0]) / (x[1] - x[0]) if x.size > 1 else 1.0
        return float(self.error[0] * (place / self.place[0]) ** min(max(power, 0.5), 1.0))


class ErrorCurves(NamedTuple):
    """What the study measured of a quantity in a process."""

    geometry: ErrorCurve  # over x
    chance: float  # scatter of one copy at full modulus
    rate: ErrorCurve | None = None  # over y, in shear over I, at full modulus; None: the process has no rate
    soft_rate: ErrorCurve | None = None  # the same of softer grains, against the same grains at `STEADY`
    step: ErrorCurve | None = None  # over the step in the study's unit, against HALF; None: no other was run


@functools.cache
def curves(process: str, quantity: str, unloads: bool) -> ErrorCurves:
    """`ErrorCurves` of a quantity in a process, as `make trade` fitted them to runs in YADE."""
    data = measured_costs()["curves"][process]
    entries = data["+".join(n for n in MEASURED[process][quantity] if unloads or n != "unloading")]
    fits = {name: ErrorCurve(*np.array(entries[name])) for name in ErrorCurves._fields if name != "chance" and name in entries}
    return ErrorCurves(**fits, chance=entries["chance"])


def numbers_of(scene: Scene, name: str, options: dict, factor: float) -> PackingNumbers:
    """`PackingNumbers` of a scene's grains of law `name` under its largest pressure, softened by `factor`."""
    if scene.pressure is None:
        raise DemlawsError("softening advice needs the key `pressure` (Pa) in the scene")
    radius, pressure, softening = 0.25 * (scene.radii[0] + scene.radii[1]), scene.pressure[1], Softening(factor)
    force, diameter = float(scene.mean_force(pressure, radius)), 4.0 * radius
    softening.options(name, options)  # refuses a law that cannot be softened
    with quiet():
        law = bind_law(name, max(scene.contacts(radius), key=lambda c: c.modulus), **options)
        overlap = float(law.overlap(force))
        kappa = float(law.stiffness(overlap)) * softening.stiffness / (pressure * diameter)
    return PackingNumbers(overlap * softening.overlap / diameter, kappa)


def _inertial_of_rate(scene):
    """I of a strain rate of 1/s."""
    density = min(DENSITY if m.density is None else m.density for m in scene.materials)
    return sum(scene.radii) * math.sqrt(density / scene.pressure[1])


class SofteningAdvice(NamedTuple):
    """A modulus factor, a loading rate and a time step for a scene, with what they cost."""

    factor: float
    inertial: float  # I
    rate: float  # strain rate [1/s] of that I
    numbers: PackingNumbers
    geometry: float  # predicted error of each cause; not a number: not measured
    waves: float
    coarse: float  # of the time step
    error: float  # predicted, all of it, with twice the scatter of chance; σ, hardness and yield pressure are scaled with E
    what: str  # the packing's quantity that `error` is of
    steps: float  # steps of the process over those at full modulus, I = STEADY and a step of STANDARD
    part: float  # of the stability limit
    scene: Scene  # softened
    dt: float  # time step [s]

    def lines(self) -> list[str]:
        """As text."""
        n, scaled = self.numbers, Softening(self.factor)
        first = "full modulus: within this tolerance softer grains save no steps"
        if self.factor != 1.0:
            others = "demlaws soften: roughness, hardness and yield pressure too"
            first = f"divide the modulus by {self.factor:g} ({others}); the time step grows by {scaled.step:.3g}"
        lines = [first, f"  time step {self.dt:.3g} s, {self.part:.2g} of the estimated stability limit"]
        numbers = f"κ_K = {n.kappa:.3g}, overlap/diameter {n.depth:.2g}"
        if self.scene.process != "pour":
            numbers = f"strain rate up to {self.rate:.3g} 1/s (I = {self.inertial:.2g}); {numbers}"
        lines.append(f"  {numbers}")
        slow = "" if self.scene.process == "pour" else f" at I = {STEADY:g}"
        lines.append(f"  needs {self.steps:.2g} times the steps of an unsoftened run{slow} with {STANDARD:.2g} of the limit")
        causes = [(self.geometry, "geometry"), (self.waves, "rate"), (self.coarse, "time step")]
        of = ", ".join(f"{name} {100 * error:.2g} %" for error, name in causes)
        return [*lines, f"  predicted error of the packing's {self.what}: {100 * self.error:.2g} % ({of})"]


def _process(scene):
    """The process whose errors are predicted: without one the scene's strain is given, its errors those of an oedometer."""
    return scene.process or PROCESSES[0]


def _steps(scene, factor, inertial, part):
    """Steps over those at full modulus, STEADY and STANDARD."""
    share = STANDARD / part / Softening(factor).step
    if scene.process == "pour":  # the time is given
        return share
    strain = Softening(factor).overlap if scene.process == "oedometer" else 1.0  # the stress is given, or the strain
    return share * strain * STEADY / inertial


def _check(scene):
    if not isinstance(scene, Scene):
        raise DemlawsError(f"scene must be a demlaws.Scene (a file: dl.Scene.load), got {scene!r:.60}")
    process = _process(scene)
    if scene.quantity not in MEASURED[process]:
        measured = ", ".join(MEASURED[process])
        raise DemlawsError(
            f"quantity = {scene.quantity!r}: in process {process!r} softer grains were measured for {measured} only"
        )


def _errors(scene, factor, inertial, part, here):
    """Fields geometry to what of an `SofteningAdvice`."""
    process = _process(scene)
    fits = curves(process, scene.quantity, scene.unloads)
    place = inertial * math.sqrt(here.kappa) if process == "oedometer" else inertial
    geometry = 0.0 if factor == 1.0 else MARGIN * fits.geometry.error_at(here.depth)
    rates = fits.rate if factor == 1.0 else fits.soft_rate
    if rates is None or (factor != 1.0 and inertial <= STEADY):  # what it costs there is part of geometry's curve
        waves = 0.0
    else:
        waves = MARGIN * rates.error_at(place)
    if part <= STANDARD * (1.0 + 1e-9):  # the study's own step, than which none is taken to be better
        coarse = 0.0
    else:
        coarse = math.inf if fits.step is None else MARGIN * fits.step.error_at(part / STUDY_STEP)
    error = (1.0 + geometry) * (1.0 + waves) * (1.0 + coarse) - 1.0 + 2.0 * fits.chance
    return {
        "geometry": geometry,
        "waves": waves,
        "coarse": coarse,
        "error": error,
        "what": NAMES[MEASURED[process][scene.quantity][0]],
    }


def predict(
    scene: Scene,
    factor: float,
    inertial: float = STEADY,
    *,
    law: str = USUAL,
    options: dict | None = None,
    part: float = STANDARD,
) -> SofteningAdvice:
    """Predicted error of the scene's quantity with grains softer by `factor`, at inertial number `inertial`, in steps of `part`
    of the stability limit, which is estimated (`packing_estimate`).

    The quantity is that of a packing under the scene's largest pressure. Raises DemlawsError without a pressure, for
    restitution, which is no packing's, or for a law that cannot be softened.
    """
    _check(scene)
    factor, inertial = number(factor, "factor"), number(inertial, "inertial number", "", 0.0, 1.0)
    part, options = number(part, "part of the stability limit", "", 0.0, 2.0), options or {}
    here = numbers_of(scene, law, options, factor)

    def bind(contact):
        with quiet():
            return bind_law(law, contact, unloading_for(rule, contact), **options)

    rule = unloading_rule(scene, law, options)  # of many a law unloading is stiffer than loading
    stable = stable_step(scene, bind) * Softening(factor).step
    return SofteningAdvice(
        factor,
        inertial,
        inertial / _inertial_of_rate(scene),
        here,
        **_errors(scene, factor, inertial, part, here),
        steps=_steps(scene, factor, inertial, part),
        part=part,
        scene=soften(scene, factor),
        dt=part / STEP_SAFETY * stable,
    )


def recommend_modulus(
    scene: Scene, law: str = USUAL, options: dict | None = None, ways: tuple = WAYS
) -> SofteningAdvice | None:
    """The factor, rate and time step of fewest steps whose predicted error is within the scene's tolerance, or None.

    A `rate` of the scene [1/s] is the fastest that is advised. ways: (factor, I, part of the limit) to choose from.
    """
    _check(scene)
    options = options or {}
    numbers: dict[float, PackingNumbers] = {}
    for factor in sorted({way[0] for way in ways}):
        try:
            numbers[factor] = numbers_of(scene, law, options, factor)
        except DemlawsError:  # a law that cannot be softened
            if factor == 1.0:
                raise
    highest = math.inf
    if scene.rate is not None and scene.process != "pour":
        highest = scene.rate * _inertial_of_rate(scene)
    possible = [(factor, min(fastest, highest), part) for factor, fastest, part in ways if factor in numbers]
    for factor, inertial, part in sorted(possible, key=lambda way: _steps(scene, *way)):
        if _errors(scene, factor, inertial, part, numbers[factor])["error"] <= scene.tolerance:
            return predict(scene, factor, inertial, law=law, options=options, part=part)
    return None
