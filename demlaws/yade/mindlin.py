"""Mindlin's law with the coefficients kno and kso of a contact, as Law2_ScGeom_MindlinPhys_Mindlin has it: normal and shear
force, viscous damping, Coulomb's limit, forces and torques on the bodies. Every attribute is left as YADE leaves it.

`advance` does this for a contact where it can (`own_step`), and calls the native `go` for includeMoment, includeAdhesion,
calcEnergy and neverErase, and for contacts that share their physics.
"""

from typing import Any, NamedTuple

from numba import types

from demlaws.core.dispatch import generic
from demlaws.core.fastmath import sqrt
from demlaws.core.numba_compat import kernel
from demlaws.core.vectors import assign, cross, dot, minus_scaled, scaled, vector
from demlaws.yade import layout, objects
from demlaws.yade.records import c_function, on_stack, pointee, record_fault, view

_ADDRESS, _NUMBER = types.int64, types.int32
call_go = c_function(types.uint8, *[_ADDRESS] * 4)
"""bool Law2::go(shared_ptr<IGeom>&, shared_ptr<IPhys>&, Interaction*)."""
call_body_by_id = c_function(_ADDRESS, _NUMBER, _ADDRESS)
"""const shared_ptr<Body>& Body::byId(int, Scene*); scene 0: the current one."""
call_apply_force = c_function(types.void, _ADDRESS, _ADDRESS, _NUMBER, _ADDRESS, _NUMBER, _ADDRESS, _ADDRESS)
"""void Shop::applyForceAtContactPoint(force, point, id, position, id, position, scene)."""
NO_DEGREES_OF_FREEDOM = 63
"""State.blockedDOFs of a body that is not dynamic."""


class Contact(NamedTuple):
    """What the step of a contact reads and writes: records of the law's context and row, and of YADE's objects."""

    context: Any
    row: Any
    pointers: tuple  # the addresses that the native `go` is called with
    geom: Any
    phys: Any
    interaction: Any
    law: Any  # the functor
    scene: Any
    first: Any  # states of the bodies
    second: Any


@kernel
def body_of(context, number, scene):
    """A body; scene 0: the current one."""
    return view(pointee(call_body_by_id(context.body_by_id, (number, scene))), objects.Body)


@kernel
def turned(geom, a):
    """A tangential vector, turned with the contact in this step as ScGeom::rotate does."""
    return turned_by(turned_by(a, geom.orthonormal_axis), geom.twist_axis)


@kernel
def turned_by(a, axis):
    """a - a × axis."""
    return minus_scaled(a, 1.0, cross(a, vector(axis)))


@kernel
def native_go(context, pointers):
    """The native law's own step."""
    return call_go(context.go, pointers)


@kernel
def reduced_mass(first, second):
    """Mass [kg] of two bodies' relative motion, as the damping of the native law has it."""
    if first.blockedDOFs == NO_DEGREES_OF_FREEDOM and second.blockedDOFs != NO_DEGREES_OF_FREEDOM:
        return second.mass
    if second.blockedDOFs == NO_DEGREES_OF_FREEDOM and first.blockedDOFs != NO_DEGREES_OF_FREEDOM:
        return first.mass
    return first.mass * second.mass / (first.mass + second.mass)


@kernel
def velocity_at(state, point):
    """Velocity [m/s] of a body at a point."""
    spin = cross(vector(state.angVel), minus_scaled(point, 1.0, vector(state.pos)))
    return minus_scaled(vector(state.vel), -1.0, spin)


@kernel
def times_cells(matrix, cells):
    """A matrix of YADE's, column by column, times a number of cells in each direction."""
    x, y, z = float(cells[0]), float(cells[1]), float(cells[2])
    column = scaled(x, vector(matrix[0]))
    column = minus_scaled(column, -y, vector(matrix[1]))
    return minus_scaled(column, -z, vector(matrix[2]))


@kernel
def image_of(contact, point):
    """A point of the first body [m] as it is beside the second one in a periodic scene."""
    if contact.scene.isPeriodic == 0:
        return point
    size = view(contact.scene.cell, objects.Cell).hSize
    return minus_scaled(point, 1.0, times_cells(size, contact.interaction.cellDist))


@kernel
def velocity_apart(contact, first, second):
    """The second velocity less the first one [m/s], with that of the cell between two bodies of a periodic scene."""
    apart = minus_scaled(second, 1.0, first)
    if contact.scene.isPeriodic == 0:
        return apart
    shift = view(contact.scene.cell, objects.Cell).shiftVelocity
    return minus_scaled(apart, -1.0, times_cells(shift, contact.interaction.cellDist))


@kernel
def approach_velocity(contact):
    """Relative velocity along the normal [m/s], positive where the bodies part."""
    point = vector(contact.geom.contactPoint)
    at_point = velocity_at(contact.first, point), velocity_at(contact.second, image_of(contact, point))
    return dot(vector(contact.geom.normal), velocity_apart(contact, *at_point))


@kernel
def damping_of_normal(contact, size):
    """Viscous normal force [N], at most as large as the force without damping, `size` [N], and displacement [m]."""
    phys = contact.phys
    coefficient = 2.0 * sqrt(reduced_mass(contact.first, contact.second) * phys.kn) * phys.betan
    velocity = approach_velocity(contact)
    return min(coefficient * velocity, size), velocity * contact.scene.dt


@kernel
def shear_damping(contact, increment):
    """Viscous shear force [N] for a displacement [m] of the step."""
    phys = contact.phys
    coefficient = 2.0 * sqrt(reduced_mass(contact.first, contact.second) * phys.ks) * phys.betas
    return scaled(coefficient / contact.scene.dt, increment)


@kernel
def apply_forces(contact, force):
    """Add the force on the first body and its reaction, with their torques, to the bodies."""
    context, geom, interaction = contact.context, contact.geom, contact.interaction
    point, place1, place2 = geom.contactPoint.ctypes.data, contact.first.pos.ctypes.data, contact.second.pos.ctypes.data
    if contact.scene.isPeriodic != 0:  # positions are not wrapped: by distances along the normal from the contact, as YADE does
        normal, half = vector(geom.normal), 0.5 * geom.penetrationDepth
        point = on_stack((0.0, 0.0, 0.0))
        place1 = on_stack(scaled(half - geom.refR1, normal))
        place2 = on_stack(scaled(geom.refR2 - half, normal))
    at = on_stack(force), point, interaction.id1, place1, interaction.id2, place2, contact.law.scene
    call_apply_force(context.apply_force, at)


@kernel
def own_step(mode, contact):
    """The native law for a contact that is Mindlin's own."""
    geom, phys, row = contact.geom, contact.phys, contact.row
    root = sqrt(geom.penetrationDepth)
    phys.kn = 1.5 * phys.kno * root
    phys.ks = phys.kso * root
    if not row.overlap > 0.0:
        keep_first_overlap(phys, geom.penetrationDepth)
    normal_force = phys.kno * geom.penetrationDepth * root
    assign(phys.normalForce, scaled(normal_force, vector(geom.normal)))
    damped = phys.betan != 0.0 or phys.betas != 0.0
    if damped:
        drag, moved = damping_of_normal(contact, normal_force)
        row.viscous += drag * moved
        assign(phys.normalViscous, scaled(drag, vector(geom.normal)))
        normal_force -= drag
        assign(phys.normalForce, scaled(normal_force, vector(geom.normal)))
    increment = vector(geom.shearInc)
    stretch = minus_scaled(turned(geom, vector(phys.usElastic)), 1.0, increment)
    assign(phys.usTotal, minus_scaled(turned(geom, vector(phys.usTotal)), 1.0, increment))
    limit = phys.tangensOfFrictionAngle * abs(normal_force)
    shear_force, share, stuck, slides = force_in_own_step(mode, contact, increment, limit)
    viscous = (0.0, 0.0, 0.0)
    if damped and stuck > 0.0:
        viscous = within_limit(mode, shear_force, scaled(stuck, shear_damping(contact, increment)), limit)
        row.viscous += dot(viscous, increment)
    phys.isSliding = slides
    assign(phys.shearElastic, shear_force)
    assign(phys.usElastic, scaled(share, stretch))
    assign(phys.shearViscous, viscous)
    shear_force = minus_scaled(shear_force, 1.0, viscous)
    assign(phys.shearForce, shear_force)
    apply_forces(contact, minus_scaled(scaled(-1.0, vector(phys.normalForce)), 1.0, shear_force))
    return 1


@generic(lambda phys: (lambda phys: phys.damping_exponent) if "damping_exponent" in phys.fields else lambda phys: 0.0)
def exponent_of_damping(phys):
    """Exponent of another kind of viscous damping, which some versions of YADE have; 0: not used."""


def _keep_first_overlap(phys, overlap):
    phys.initD = overlap


@generic(lambda phys, _: _keep_first_overlap if "initD" in phys.fields else lambda phys, overlap: None)
def keep_first_overlap(phys, overlap):
    """Note the overlap of a contact's first step, where YADE is built with partial saturation."""


@kernel
def supports_options(contact):
    """Whether `own_step` does what the native law would do: the functor has no option, no other contact has its physics."""
    row = contact.row
    if not (contact.context.own_step != 0 and contact.geom.penetrationDepth > 0.0):
        return False
    return row.interaction == contact.pointers[3] and contact.law.options == 0 and exponent_of_damping(contact.phys) == 0.0


def _turned_and_displaced(mode, contact, increment):
    phys = contact.phys
    return minus_scaled(turned(contact.geom, vector(phys.shearElastic)), phys.ks, increment)


@generic(lambda *_: _turned_and_displaced)
def trial_force(mode, contact, increment):
    """Elastic shear force after the step's displacement `increment` [m], before Coulomb's limit: turned with the contact."""


@generic(lambda *_: _force_with_limit)
def force_in_own_step(mode, contact, increment, limit):
    """Elastic shear force [N] after the step's displacement [m], under Coulomb's limit [N]; the share of it that the limit has
    left, the share of the contact's stiffness that sticks, and whether the contact slides."""


def _force_with_limit(mode, contact, increment, limit):
    force = trial_force(mode, contact, increment)
    square = dot(force, force)
    if square > limit * limit:
        share = limit / sqrt(square)
        slide(mode, contact.row, share)
        return scaled(share, force), share, 0.0, True
    return force, 1.0, 1.0, False


@generic(lambda *_: lambda mode, force, viscous, limit: viscous)
def within_limit(mode, force, viscous, limit):
    """Viscous shear force [N], which acts against the elastic one in YADE's signs: not so much that both exceed the limit."""


@kernel
def together_within_limit(mode, force, viscous, limit):
    """As `ShearStep::damp` in demlaws/cpp/demlaws_shear.h."""
    along, square, beyond = -dot(force, viscous), dot(viscous, viscous), dot(force, force) - limit * limit
    if square + 2.0 * along + beyond <= 0.0 or not square > 0.0:
        return viscous
    return scaled((sqrt(along * along - square * min(beyond, 0.0)) - along) / square, viscous)


@generic(lambda *_: lambda mode, row, share: None)
def slide(mode, row, share):
    """What else is reduced to a share where Coulomb's limit reduces the shear force."""


@kernel
def limit_of_native_step(contact):
    """Coulomb's limit [N] in the native law's own step, whose stiffnesses are written."""
    phys, overlap = contact.phys, contact.geom.penetrationDepth
    phys.kn = 1.5 * phys.kno * sqrt(overlap)
    phys.ks = phys.kso * sqrt(overlap)
    size = phys.kno * overlap * sqrt(overlap)
    if phys.betan != 0.0 or phys.betas != 0.0:
        size -= damping_of_normal(contact, size)[0]
    return phys.tangensOfFrictionAngle * abs(size)


@kernel
def reduce_dashpot(mode, contact, force, stuck, limit):
    """Set the damping ratio of shear for a native step whose elastic force is `force` [N], of which a share sticks."""
    phys, viscous = contact.phys, scaled(stuck, shear_damping(contact, vector(contact.geom.shearInc)))
    allowed, square = within_limit(mode, force, viscous, limit), dot(viscous, viscous)
    phys.betas = phys.betas * stuck * sqrt(dot(allowed, allowed) / square) if square > 0.0 else 0.0


@generic(lambda *_: lambda mode, contact: None)
def before_native_step(mode, contact):
    """What the native law's own step needs: its turn of vectors is another one."""


@generic(lambda *_: lambda mode, contact: None)
def after_native_step(mode, contact):
    """What else the native law's own step changes."""


@kernel
def advance(mode, contact):
    """Mindlin's law; returns whether the contact lasts."""
    if supports_options(contact):
        return own_step(mode, contact)
    geom, phys = contact.geom, contact.phys
    if contact.context.native_step == 0 and geom.penetrationDepth > 0.0:
        record_fault(contact.context, layout.NATIVE_STEP, contact.interaction, 0.0)
    betas = phys.betas
    before_native_step(mode, contact)
    keep = native_go(contact.context, contact.pointers)
    after_native_step(mode, contact)
    if geom.penetrationDepth > 0.0 and (phys.betan != 0.0 or phys.betas != 0.0 or exponent_of_damping(phys) != 0.0):
        moved = approach_velocity(contact) * contact.scene.dt
        contact.row.viscous += dot(vector(phys.normalViscous), vector(geom.normal)) * moved
        contact.row.viscous += dot(vector(phys.shearViscous), vector(geom.shearInc))
    phys.betas = betas
    return keep
