"""Self-test of a law on two spheres in a scene of their own: the force that YADE applied against the force of the law."""

from collections import defaultdict

import numpy as np
import yade

from demlaws.errors import DemlawsError
from demlaws.yade import layout as at
from demlaws.yade import native
from demlaws.yade.omega import get_engines, set_engines

POISSON = 0.2
TOLERANCE = 1e-14  # of the largest force
STEP_TOLERANCE = 1e-12
"""Of the largest value of each attribute: between a contact step without the native `go` and one with it."""


class SelfTestFailed(DemlawsError):
    """YADE did not apply the law's force to two test spheres."""


def _overlaps(deepest):
    """Load, unload, reload further, part, touch again [m]."""
    legs = [(0.0, 0.5), (0.5, 0.2), (0.2, 1.0), (1.0, -0.1), (-0.1, 0.3)]
    path = np.concatenate([np.linspace(a, b, 12, endpoint=False) for a, b in legs])
    return deepest * path[1:]


def _deepest(pairs, row, overlap):
    """The wanted overlap [m], halved until the law has a force there (a table ends)."""
    while overlap > 0.0:
        trial = row.copy()
        trial["overlap"] = overlap
        if pairs.respond(trial)[1] < 0:
            break
        overlap *= 0.5
    return overlap


def run(binding):
    """Take two spheres of surfaces that the law is for along a path; returns (steps, largest error over largest force).

    Works in a scene apart: the user's is left as it is. Raises SelfTestFailed.
    """
    omega = yade.O
    if omega.running:
        raise SelfTestFailed(
            "the law is made while a simulation runs (in a PyRunner?), and its self-test needs a scene of its own: make the "
            "law before O.run and let the PyRunner use it"
        )
    home = omega.thisScene
    scratch = omega.addScene()  # a new one each time: O.reset() drops them, and switching to a dropped one does nothing
    omega.switchToScene(scratch)
    if omega.thisScene != scratch or scratch == home or len(omega.bodies) or get_engines():
        omega.switchToScene(home)
        raise SelfTestFailed("YADE gave no scene of its own to the self-test")
    try:
        return _compare(binding, omega)
    finally:
        omega.resetThisScene()
        omega.switchToScene(home)


def try_step_alone(context, functor, omega, overlap):
    """Use the contact step without the native `go` from now on if it leaves what `go` leaves; else note why not."""
    layout = native.layout()
    try:
        words = {**layout.find_step(functor, omega._sceneObj), at.ALONE: 1}
        natively = _sheared(omega, overlap)
        context.words[[*words]] = list(words.values())
        alone = _sheared(omega, overlap)
        different = [
            name
            for name, values in natively.items()
            if not np.abs(alone[name] - values).max() <= STEP_TOLERANCE * np.abs(values).max()
        ]
        if different:
            raise native.BridgeUnavailable(f"it leaves other values of {', '.join(different)} than the native go")
    except (native.BridgeUnavailable, AttributeError) as error:
        context.words[at.ALONE] = 0
        layout.step_refused = str(error)
    else:
        layout.step, layout.step_refused = words, None


def _sheared(omega, overlap):
    """What a new contact has that sticks, slides and turns, with the forces and torques, at each step: name → array."""
    ball, seen = omega.bodies[1], defaultdict(list)
    ball.state.pos = yade.Vector3(0, 0, 2 * ball.shape.radius + overlap)
    omega.step()
    for n, slip in enumerate([0.0, 0.05, 0.1, -0.1, 1.0, 2.0, -0.1, -3.0, 0.2, 0.0]):
        turn, depth = 1e-3 * (n % 3), overlap * (1.0 - 0.05 * n) if slip else 0.5 * overlap
        ball.state.pos = yade.Vector3(turn * overlap, 0, 2 * ball.shape.radius - depth)
        ball.state.vel = yade.Vector3(slip, 0.3 * slip, 0) * (overlap / omega.dt)
        for body, sense in zip(omega.bodies, (1.0, 0.4), strict=True):
            body.state.angVel = yade.Vector3(turn, -turn, 1e-3) * (sense / omega.dt)
        omega.step()
        for name, value in omega.interactions[0, 1].phys.dict().items():
            if name != "prevU":  # which has the number of the row
                seen[name].append(value)
        for body in omega.bodies:
            seen["force"].append(omega.forces.f(body.id))
            seen["torque"].append(omega.forces.t(body.id))
    return {name: np.nan_to_num(np.array(values, float)) for name, values in seen.items()}


def _compare(binding, omega):
    pairs = binding.pairs
    functor = yade.Law2_ScGeom_MindlinPhys_Mindlin(label="")
    binding.attachment.patch(functor)
    binding.attachment.watch_itself()
    labels, number = pairs.of_a_law()
    effective_radius, modulus = pairs.specimen(number)
    radius, young = 2.0 * effective_radius, 2.0 * modulus * (1.0 - POISSON**2)
    for height, label in zip((0.0, 2 * radius), labels, strict=True):
        material = yade.FrictMat(young=young, poisson=POISSON, frictionAngle=0.5, density=2600, label=label)
        omega.materials.append(material)
        body = yade.Body()
        body.shape, body.material = yade.Sphere(radius=radius), material
        body.state.pos = body.state.refPos = yade.Vector3(0, 0, height)
        body.state.mass, body.state.inertia = 1.0, yade.Vector3(1, 1, 1)
        body.state.blockedDOFs = "xyzXYZ"
        body.bound = yade.Aabb()
        omega.bodies.append(body)
    engines = [
        yade.ForceResetter(),
        yade.InsertionSortCollider([yade.Bo1_Sphere_Aabb()], verletDist=0.1 * radius),
        yade.InteractionLoop([yade.Ig2_Sphere_Sphere_ScGeom()], [yade.Ip2_FrictMat_FrictMat_MindlinPhys()], [functor]),
        yade.NewtonIntegrator(damping=0),
    ]
    set_engines(engines)
    omega.dt = 1e-9
    row = np.zeros(1, at.CONTACT)
    row["ratio"], row["tag"], row["radius"], row["modulus"] = 1.0, number + 1.0, effective_radius, modulus
    wrong, largest, forces, steps = 0.0, 0.0, [], 0
    deepest = _deepest(pairs, row, 4e-3 * effective_radius)
    for overlap in _overlaps(deepest):
        omega.bodies[1].state.pos = yade.Vector3(0, 0, 2 * radius - overlap)
        omega.step()
        contact = omega.interactions[0, 1] if omega.interactions.has(0, 1) else None
        touching = contact is not None and contact.isReal
        depth = contact.geom.penetrationDepth if touching else min(overlap, 0.0)
        row["overlap"] = depth
        answer, _ = pairs.respond(row)
        expected = answer["kno"][0] * depth * np.sqrt(depth) if depth > 0 else 0.0
        force = omega.forces.f(1)[2]
        forces.append(force)
        largest, wrong, steps = max(largest, expected), max(wrong, abs(force - expected)), steps + 1
        if touching and expected > 0:
            tangent = answer["tangent"][0]
            if not np.isclose(contact.phys.kn, tangent, rtol=1e-9):
                raise SelfTestFailed(f"YADE has the tangent stiffness {contact.phys.kn:g} N/m, the law {tangent:g} N/m")
    if not largest > 0 or not wrong <= TOLERANCE * largest * 100:
        raise SelfTestFailed(f"YADE applied up to {max(forces):g} N, the law gives {largest:g} N; they differ by {wrong:g} N")
    if binding.context.take_fault() is not None:
        raise SelfTestFailed("the native code received unknown contacts")
    if native.layout().step_refused == native.NOT_TRIED:
        try_step_alone(binding.context, functor, omega, deepest)
    binding.account = 0.0, 0, 0.0
    binding.attachment.forget_rows()
    binding.attachment.watched_by(None)
    return steps, wrong / largest
