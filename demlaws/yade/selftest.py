"""Self-test of a law on two spheres in a scene of their own: the force that YADE applied against the force of the law."""

import itertools
from collections import defaultdict

import numpy as np
import yade

from demlaws.errors import DemlawsError
from demlaws.yade import layout, native
from demlaws.yade.omega import O, contact_engines, fixed_pair, scratch_scene, set_engines

POISSON = 0.2
TOLERANCE = 1e-14  # of the largest force
STEP_TOLERANCE = 1e-12
"""Of the largest value of each attribute: between a contact step without the native `go` and one with it."""


_LEGS = (0.0, 0.5), (0.5, 0.2), (0.2, 1.0), (1.0, -0.1), (-0.1, 0.3)
PATH = np.concatenate([np.linspace(a, b, 12, endpoint=False) for a, b in _LEGS])[1:]
"""Overlaps over the deepest one: load, unload, reload further, part, touch again."""


class SelfTestFailed(native.BridgeUnavailable):
    """YADE did not apply the law's force to two test spheres."""


def _deepest(pairs, row, overlap):
    """The wanted overlap [m], halved until the law has a force there (a table ends)."""
    while overlap > 0.0:
        trial = row.copy()
        trial["overlap"] = overlap
        if pairs.evaluate(trial)[1] < 0:
            break
        overlap *= 0.5
    return overlap


DAMPING = ({"en": 0.7, "es": 0.5}, {"betan": 0.2, "betas": 0.1})
"""Arguments of Ip2_FrictMat_FrictMat_MindlinPhys of the contacts by which damping is judged."""


def try_own_step(context, functor, overlap):
    """Raise unless the contact step without the native `go` leaves what `go` leaves: without damping, with it, in a periodic
    scene. A native law with a slip of its own is compared by the slip that both can have."""
    context["slip_of_yade"], context["native_step"] = native.find_layout().own_slip, 1
    for damping, periodic in itertools.product(({}, *DAMPING), (False, True)):
        context["own_step"] = 0
        natively = _sheared(functor, overlap, damping, periodic)
        context["own_step"] = 1
        alone = _sheared(functor, overlap, damping, periodic)
        different = [
            attribute
            for attribute, values in natively.items()
            if not np.abs(alone[attribute] - values).max() <= STEP_TOLERANCE * np.abs(values).max()
        ]
        if different:
            where = f"with {damping} " * bool(damping) + "in a periodic scene " * periodic
            raise SelfTestFailed(f"{where}a contact step leaves other values of {', '.join(different)} than YADE's own")
    context["slip_of_yade"], context["native_step"] = 0, not native.find_layout().own_slip
    native.find_layout().own_step_is_proved = True


def _sheared(functor, overlap, damping, periodic):
    """What a new contact has that sticks, slides and turns, with the forces and torques, at each step: name → array."""
    base, ball, seen = O.bodies[0], O.bodies[1], defaultdict(list)
    O.interactions.clear()
    size, O.periodic = 2 * ball.shape.radius, periodic
    image = 4 * size if periodic else 0.0
    base.state.pos, base.state.vel, ball.state.pos = yade.Vector3.Zero, yade.Vector3.Zero, yade.Vector3(0, 0, 2 * size)
    if periodic:
        O.cell.hSize = yade.Matrix3.Identity * image  # YADE's cell of 1 m may be too small for the spheres
        O.cell.velGrad = yade.Matrix3(0, 0, 0, 0.01, 0.02, 0, 0, 0.03, 0.04) * (1e-6 / O.dt)
        O.step()  # it is used from the next step on
        O.cell.hSize = yade.Matrix3.Identity * image
    set_engines(_engines(functor, ball.shape.radius, damping))
    for n, slip in enumerate([0.0, 0.0, 0.05, 0.1, -0.1, 1.0, 2.0, -0.1, -3.0, 0.2, 0.0]):
        turn, depth = 1e-3 * (n % 3), overlap * (1.0 - 0.05 * n) if slip or not n else 0.5 * overlap
        ball.state.pos = yade.Vector3(turn * overlap, 0, size - depth - image)
        ball.state.vel = yade.Vector3(slip, 0.3 * slip, 0.02 * (n % 4) - 0.03) * (overlap / O.dt)
        for body, sense in zip((base, ball), (1.0, 0.4), strict=True):
            body.state.angVel = yade.Vector3(turn, -turn, 1e-3) * (sense / O.dt)
        O.step()
        for name, value in O.interactions[0, 1].phys.dict().items():
            if name != "prevU":  # which has the code of the row
                seen[name].append(value)
        for body in O.bodies:
            seen["force"].append(O.forces.f(body.id))
            seen["torque"].append(O.forces.t(body.id))
    return {name: np.nan_to_num(np.array(values, float)) for name, values in seen.items()}


def _engines(functor, radius, damping):
    """Engines of the two spheres; damping: arguments of the functor of physics."""
    physics, geometries = yade.Ip2_FrictMat_FrictMat_MindlinPhys(**damping), None
    if native.find_layout().own_slip:  # the slip at the contact point, in YADE's geometry and in its law
        setattr(functor, native.SLIP_OF_ITS_OWN, False)
        geometries = [yade.Ig2_Sphere_Sphere_ScGeom(avoidGranularRatcheting=False)]
    engines = contact_engines(functor, physics, 0.1 * radius, geometries=geometries)
    return [*engines, yade.NewtonIntegrator(damping=0)]


def run(binding):
    """Take two spheres of surfaces that the law is for along a path; returns (steps, largest error over largest force).

    Works in a scene apart: the user's is left as it is. Raises `native.BridgeUnavailable`.
    """
    if O.running:
        raise DemlawsError(
            "the law is made while a simulation runs (in a PyRunner?), and its self-test needs a scene of its own: make the "
            "law before O.run and let the PyRunner use it"
        )
    with scratch_scene():
        return _compare(binding)


def _compare(binding):
    pairs = binding.pairs
    functor = yade.Law2_ScGeom_MindlinPhys_Mindlin(label="")
    binding.attachment.patch(functor)
    binding.attachment.watched_by(yade.PyRunner())
    labels, number = pairs.pair_of_law()
    effective_radius, modulus = pairs.typical_contact(number)
    radius, young = 2.0 * effective_radius, 2.0 * modulus * (1.0 - POISSON**2)
    fixed_pair(labels, radius, young, POISSON)
    set_engines(_engines(functor, radius, {}))
    O.dt = 1e-9
    row = pairs.contacts_of([number], effective_radius, modulus)
    wrong, largest, forces, steps = 0.0, 0.0, [], 0
    deepest = _deepest(pairs, row, 4e-3 * effective_radius)
    for overlap in deepest * PATH:
        O.bodies[1].state.pos = yade.Vector3(0, 0, 2 * radius - overlap)
        O.step()
        contact = O.interactions[0, 1] if O.interactions.has(0, 1) else None
        touching = contact is not None and contact.isReal
        depth = contact.geom.penetrationDepth if touching else min(overlap, 0.0)
        row["overlap"] = depth
        answer, _ = pairs.evaluate(row)
        expected = answer["kno"][0] * depth * np.sqrt(depth) if depth > 0 else 0.0
        force = O.forces.f(1)[2]
        forces.append(force)
        largest, wrong, steps = max(largest, expected), max(wrong, abs(force - expected)), steps + 1
        if touching and expected > 0:
            tangent = answer["tangent"][0]
            if not np.isclose(contact.phys.kn, tangent, rtol=1e-9):
                raise SelfTestFailed(f"YADE has the tangent stiffness {contact.phys.kn:g} N/m, the law {tangent:g} N/m")
    if not largest > 0 or not wrong <= TOLERANCE * largest * 100:
        raise SelfTestFailed(f"YADE applied up to {max(forces):g} N, the law gives {largest:g} N; they differ by {wrong:g} N")
    if binding.context["seen"][: layout.FAULTS].any():
        raise SelfTestFailed("the native code received unknown contacts")
    if not native.find_layout().own_step_is_proved:
        try_own_step(binding.context, functor, deepest)
    binding.clear()
    binding.attachment.watched_by(None)
    return steps, wrong / largest
