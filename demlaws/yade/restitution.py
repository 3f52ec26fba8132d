"""The restitution that a law and a damping give together, which is not the `en` of YADE's Ip2 functor.

Ip2_FrictMat_FrictMat_MindlinPhys turns `en` into a damping ratio that gives this restitution to an elastic Hertz contact. A law
that dissipates by itself rebounds with less; and the damping force goes by 1.5 P/δ of a law that is no Hertz law.
"""

import math
import warnings
from numbers import Real

import yade
from scipy.optimize import brentq
from yade import utils

from demlaws.errors import DemlawsError, ValidityWarning
from demlaws.units import SMALL_OVERLAP
from demlaws.yade import layout as at
from demlaws.yade.binding import Binding
from demlaws.yade.omega import O, set_engines

STEPS = 600
"""Steps of a Hertz contact's duration: the rebound is within 1e-3 of its limit."""


def restitution(pairs, ratio, first, second, speed, en=None):
    """Rebound over impact speed of two bodies (of spheres, or one of them a flat) that meet head-on at `speed` [m/s].

    en: that of Ip2_FrictMat_FrictMat_MindlinPhys, None for no damping. In a scene of its own; the user's stays as it is.
    """
    if not (isinstance(speed, Real) and speed > 0.0):
        raise DemlawsError(f"speed = {speed!r} m/s: an impact needs a positive speed")
    if en is not None and not (isinstance(en, Real) and 0.0 < en <= 1.0):
        raise DemlawsError(f"en = {en!r}: above 0 and up to 1")
    if O.running:
        raise DemlawsError("the impact needs a scene of its own, but a simulation is running: call O.pause() first")
    bodies = [_Like(body) for body in (first, second)]
    if not any(body.radius for body in bodies):
        raise DemlawsError("two flats do not meet: give a sphere's body, O.bodies[n]")
    for body in bodies:
        if not body.mass > 0.0:
            raise DemlawsError(f"mass = {body.mass:g} kg: a body that moves must have one")
    if all(math.isinf(body.mass) for body in bodies):
        raise DemlawsError("two fixed bodies do not meet: give one that moves (a sphere without fixed=True)")
    home = O.thisScene
    own = O.addScene()
    O.switchToScene(own)
    try:
        return _bounce(Binding("impact", pairs, ratio, "native"), sorted(bodies, key=lambda body: body.radius), speed, en)
    finally:
        O.resetThisScene()
        O.switchToScene(home)


def en_for(pairs, ratio, first, second, speed, wanted):
    """The `en` to give to Ip2_FrictMat_FrictMat_MindlinPhys so that these bodies rebound with `wanted` times their speed."""
    most = restitution(pairs, ratio, first, second, speed)
    if not (isinstance(wanted, Real) and 0.0 < wanted <= most):
        raise DemlawsError(
            f"a restitution of {wanted!r} cannot be had at {speed:g} m/s: the law itself dissipates, {most:.4f} is the most"
        )

    def excess(en):
        return restitution(pairs, ratio, first, second, speed, en) - wanted

    least = 1e-3
    if excess(least) > 0.0:
        raise DemlawsError(f"a restitution of {wanted!r} is below what en = {least:g} gives")
    return float(brentq(excess, least, 1.0, xtol=1e-4)) if excess(1.0) > 0.0 else 1.0


class _Like:
    """What an impact takes from a body: its radius (0: a flat), mass (a fixed one's is infinite) and material."""

    def __init__(self, body):
        if not isinstance(body, yade.Body) or not isinstance(body.material, yade.FrictMat):
            raise DemlawsError(f"{body!r} is not a YADE body of a FrictMat: give O.bodies[n]")
        stone = body.material
        self.radius = body.shape.radius if isinstance(body.shape, yade.Sphere) else 0.0
        self.material = {name: getattr(stone, name) for name in ("young", "poisson", "density", "frictionAngle", "label")}
        self.mass = body.state.mass if body.dynamic else math.inf
        self.facet = isinstance(body.shape, yade.Facet)  # YADE's own R of a sphere on one is not that on a wall


def _bounce(binding, bodies, speed, en):
    lower, upper = bodies
    if lower.radius:
        base = utils.sphere((0, 0, -lower.radius), lower.radius, fixed=True, material=yade.FrictMat(**lower.material))
        radius = upper.radius * lower.radius / (upper.radius + lower.radius)
    else:
        size, stone = 4 * upper.radius, yade.FrictMat(**lower.material)
        corners = [(-size, -size, 0), (size, -size, 0), (0, size, 0)]
        base = utils.facet(corners, material=stone) if lower.facet else utils.wall(0, 2, sense=1, material=stone)
        radius = upper.radius
    mass = 1.0 / (1.0 / upper.mass + 1.0 / lower.mass)
    ball = utils.sphere((0, 0, upper.radius * (1 + 1e-9)), upper.radius, material=yade.FrictMat(**upper.material))
    O.bodies.append([base, ball])
    ball.state.vel, ball.state.mass, ball.state.blockedDOFs = yade.Vector3(0, 0, -speed), mass, "xyXYZ"
    functor = yade.Law2_ScGeom_MindlinPhys_Mindlin(label="impact")
    binding.context.words[at.UNLISTED] = 1
    binding.attachment.patch(functor)
    physics = yade.Ip2_FrictMat_FrictMat_MindlinPhys(**({} if en is None or en == 1.0 else {"en": en, "es": en}))
    set_engines(
        [
            yade.ForceResetter(),
            yade.InsertionSortCollider(
                [yade.Bo1_Sphere_Aabb(), yade.Bo1_Wall_Aabb(), yade.Bo1_Facet_Aabb()], verletDist=0.1 * upper.radius
            ),
            yade.InteractionLoop(
                [yade.Ig2_Sphere_Sphere_ScGeom(), yade.Ig2_Wall_Sphere_ScGeom(), yade.Ig2_Facet_Sphere_ScGeom()],
                [physics],
                [functor],
            ),
            yade.NewtonIntegrator(damping=0),
        ]
    )
    one, two = (body.material for body in bodies)
    modulus = 1.0 / ((1 - one["poisson"] ** 2) / one["young"] + (1 - two["poisson"] ** 2) / two["young"])
    O.dt = 2.87 * (mass**2 / (radius * modulus**2 * speed)) ** 0.2 / STEPS
    for _ in range(100 * STEPS):
        O.step()
        if ball.state.vel[2] > 0.0 and not O.interactions.countReal():
            break
    if binding.context.take_fault() is not None or not math.isfinite(ball.state.vel[2]):
        raise DemlawsError(f"the law does not serve an impact of these bodies at {speed:g} m/s (does a table end?)")
    if binding.context.take_deep():
        warnings.warn(
            f"the impact at {speed:g} m/s goes deeper than {SMALL_OVERLAP:g} R, the range of contact laws",
            ValidityWarning,
            stacklevel=4,
        )
    return ball.state.vel[2] / speed
