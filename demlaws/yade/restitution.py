"""Restitution of a law together with YADE's damping, which differs from the `en` of YADE's Ip2 functor.

Ip2_FrictMat_FrictMat_MindlinPhys converts `en` to a damping ratio that gives this restitution to an elastic Hertz contact. The
rebound of a law that dissipates is lower, and the damping force is computed from 1.5 P/δ, which is K for Hertz only.
"""

import math
import warnings
from numbers import Real

import yade
from scipy.optimize import brentq
from yade import utils

from demlaws.contact import effective_modulus, effective_radius
from demlaws.errors import DemlawsError, ValidityWarning
from demlaws.units import SMALL_OVERLAP
from demlaws.yade.binding import Binding
from demlaws.yade.omega import O, contact_engines, scratch_scene, set_engines

STEPS = 600
"""Steps of a Hertz contact's duration: the rebound is within 1e-3 of its limit."""


def restitution(pairs, first, second, speed, en=None):
    """Rebound over impact speed of two bodies (of spheres, or one of them a flat) that collide head-on at `speed` [m/s].

    en: of Ip2_FrictMat_FrictMat_MindlinPhys, None for no damping. Computed in a scene of its own.
    """
    if not (isinstance(speed, Real) and speed > 0.0):
        raise DemlawsError(f"speed = {speed!r} m/s: an impact needs a positive speed")
    if en is not None and not (isinstance(en, Real) and 0.0 < en <= 1.0):
        raise DemlawsError(f"en = {en!r}: give a value above 0, at most 1")
    if O.running:
        raise DemlawsError("the impact needs a scene of its own, but a simulation is running: call O.pause() first")
    for body in (first, second):
        if not isinstance(body, yade.Body) or not isinstance(body.material, yade.FrictMat):
            raise DemlawsError(f"{body!r} is not a YADE body of a FrictMat: give O.bodies[n]")
    lower, upper = sorted((first, second), key=_radius)
    masses = [body.state.mass if body.dynamic else math.inf for body in (lower, upper)]
    if not _radius(upper):
        raise DemlawsError("two flats do not collide: give a sphere's body, O.bodies[n]")
    if not min(masses) > 0.0:
        raise DemlawsError(f"mass = {min(masses):g} kg: the mass of a body that moves must be positive")
    if all(map(math.isinf, masses)):
        raise DemlawsError("two fixed bodies do not collide: give one that moves (a sphere without fixed=True)")
    with scratch_scene():
        return _bounce(pairs, lower, upper, mass=1.0 / sum(1.0 / m for m in masses), speed=speed, en=en)


def en_for(pairs, first, second, speed, ratio):
    """The `en` of Ip2_FrictMat_FrictMat_MindlinPhys with which the rebound of these bodies is `ratio` times their speed."""
    most = restitution(pairs, first, second, speed)
    if not (isinstance(ratio, Real) and 0.0 < ratio <= most):
        raise DemlawsError(
            f"a restitution of {ratio!r} is not possible at {speed:g} m/s: the law itself dissipates energy, at most {most:.4f}"
        )

    def excess(en):
        return restitution(pairs, first, second, speed, en) - ratio

    least = 1e-3
    if excess(least) > 0.0:
        raise DemlawsError(f"a restitution of {ratio!r} is below that of en = {least:g}")
    return float(brentq(excess, least, 1.0, xtol=1e-4)) if excess(1.0) > 0.0 else 1.0


def _radius(body):
    """Radius [m] of a sphere, 0 of a flat."""
    return body.shape.radius if isinstance(body.shape, yade.Sphere) else 0.0


def _like(body):
    """A material with the numbers and the label of a body's."""
    names = ("young", "poisson", "density", "frictionAngle", "label")
    return yade.FrictMat(**{name: getattr(body.material, name) for name in names})


def _bounce(pairs, lower, upper, *, mass, speed, en):
    binding = Binding("impact", pairs)
    size, radius, stone = 4 * _radius(upper), _radius(upper), _like(lower)
    if _radius(lower):
        base = utils.sphere((0, 0, -_radius(lower)), _radius(lower), fixed=True, material=stone)
    elif isinstance(lower.shape, yade.Facet):  # YADE's own R of a sphere on a facet is not that on a wall
        base = utils.facet([(-size, -size, 0), (size, -size, 0), (0, size, 0)], material=stone)
    else:
        base = utils.wall(0, 2, sense=1, material=stone)
    ball = utils.sphere((0, 0, radius * (1 + 1e-9)), radius, material=_like(upper))
    O.bodies.append([base, ball])
    ball.state.vel, ball.state.mass, ball.state.blockedDOFs = yade.Vector3(0, 0, -speed), mass, "xyXYZ"
    functor = yade.Law2_ScGeom_MindlinPhys_Mindlin(label="impact")
    binding.context["may_be_unlisted"] = 1
    binding.attachment.patch(functor)
    binding.attachment.watch_itself()
    physics = yade.Ip2_FrictMat_FrictMat_MindlinPhys(**({} if en is None or en == 1.0 else {"en": en, "es": en}))
    set_engines([*contact_engines(functor, physics, 0.1 * radius), yade.NewtonIntegrator(damping=0)])
    if _radius(lower):
        radius = effective_radius(radius, _radius(lower))
    modulus = effective_modulus(lower.material, upper.material)
    O.dt = 2.87 * (mass**2 / (radius * modulus**2 * speed)) ** 0.2 / STEPS
    for _ in range(100 * STEPS):
        O.step()
        if ball.state.vel[2] > 0.0 and not O.interactions.countReal():
            break
    if binding.context.take_fault() is not None or not math.isfinite(ball.state.vel[2]):
        raise DemlawsError(f"the law has no force for an impact of these bodies at {speed:g} m/s (does a table end?)")
    if binding.context.take("deep"):
        text = f"the impact at {speed:g} m/s goes deeper than {SMALL_OVERLAP:g} R, the range of contact laws"
        warnings.warn(text, ValidityWarning, stacklevel=4)
    return ball.state.vel[2] / speed
