"""Partial slip at a contact: the row of springs of demlaws.core.slip, whose stretches are components in a tangent frame.
Compiled code, loaded for shear="slip" only."""

from demlaws.core.dispatch import bind
from demlaws.core.fastmath import sqrt
from demlaws.core.numba_compat import kernel
from demlaws.core.slip import compressions, depth_of, set_springs, slip, unloads_by_hertz
from demlaws.core.vectors import assign, cross, dot, minus_scaled, scaled, unit_perpendicular, vector
from demlaws.yade import layout
from demlaws.yade.mindlin import advance, limit_of_native_step, reduce_dashpot, supports_options, turned
from demlaws.yade.records import record_fault
from demlaws.yade.shear import Slip, account, before_turn, is_changed


@kernel
def place_springs(mode, rule, shape, p, row, overlap, force, stiffness, state):
    """`shear.compress` with springs: their bounds and compressions."""
    if stiffness > 0.0 and overlap > 0.0 and force > 0.0:
        hertzian, depth = unloads_by_hertz(rule), depth_of(rule, overlap, state)
        set_springs(hertzian, stiffness, force, depth, row.bound, row.rest, row.spring)
        compressions(hertzian, depth, row.bound, row.rest, row.onset, row.limit)


@kernel
def turned_tangent(geom, tangent, normal):
    """Unit vector of a tangent that turns with the contact; any one for zeros."""
    first = turned(geom, tangent)
    first = minus_scaled(first, dot(first, normal), normal)  # `turned` leaves the plane by the square of the turn
    length = sqrt(dot(first, first))
    if length > 0.0:
        return scaled(1.0 / length, first)
    return unit_perpendicular(normal)


@kernel
def step_of_springs(geom, row, stiffness, limit):
    """Shear force [N] of the springs under Coulomb's limit [N], the share that sticks, whether all slip."""
    displacement = scaled(-1.0, vector(geom.shearInc))  # positive along the force that it makes
    first, second = vector(row.tangent[0]), vector(row.tangent[1])
    du, dv = dot(displacement, first), dot(displacement, second)
    along, across, work, stored, stuck, slides = slip(limit, row.ratio, du, dv, row.bound, row.spring, row.onset, row.limit)
    account(row, stiffness, stored, work - (stored - row.held))
    return minus_scaled(scaled(along, first), -across, second), stuck, slides


@kernel
def _force_in_own_step(mode, contact, increment, limit):
    row = contact.row
    force, stuck, slides = step_of_springs(contact.geom, row, row.ratio * row.bound[len(row.bound) - 1], limit)
    return force, 1.0, stuck, slides


@kernel
def apply_to_springs(mode, contact, stiffness):
    """Set the shear force to that of the springs, apply Mindlin's law and account for the energy; stiffness: K_t [N/m]."""
    geom, phys, row = contact.geom, contact.phys, contact.row
    if not stiffness > 0.0 or row.bound[len(row.bound) - 1] == 0.0:
        assign(phys.shearElastic, (0.0, 0.0, 0.0))  # without stiffness; the energy of the springs is lost
        row.bound[:] = 0.0
        row.spring[:] = 0.0
        account(row, 0.0, 0.0, row.held)
        keep = advance(mode, contact)
        assign(row.tangent[0], (0.0, 0.0, 0.0))
        return keep
    if is_changed(contact):
        record_fault(contact.context, layout.SET_SHEAR, contact.interaction, 0.0)
    normal = vector(geom.normal)
    first = turned_tangent(geom, vector(row.tangent[0]), normal)
    assign(row.tangent[0], first)
    assign(row.tangent[1], cross(normal, first))
    if supports_options(contact):
        keep = advance(mode, contact)
        assign(phys.usElastic, scaled(1.0 / stiffness, vector(phys.shearElastic)))
        return keep
    limit = limit_of_native_step(contact)
    force, stuck, slides = step_of_springs(geom, row, stiffness, limit)
    # The native law turns the force and adds K_t times the displacement: it starts from the force that leads to ours.
    assign(phys.shearElastic, before_turn(geom, minus_scaled(force, -stiffness, vector(geom.shearInc))))
    betas = phys.betas
    reduce_dashpot(mode, contact, force, stuck, limit)
    keep = advance(mode, contact)
    phys.betas = betas
    phys.isSliding = slides
    assign(phys.usElastic, scaled(1.0 / stiffness, vector(phys.shearElastic)))
    return keep


bind(Slip, compress=place_springs, apply_mindlin=apply_to_springs, force_in_own_step=_force_in_own_step)
