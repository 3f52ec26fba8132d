"""Partial slip at a contact, a row of springs: the twin of SpringRow in demlaws/cpp/demlaws_slip.h, with stretches as two
components in a tangent frame. Compiled code, loaded for shear="slip" only."""

from numba.extending import overload

from demlaws.core.dispatch import bind, first_loading, unloading_curve
from demlaws.core.fastmath import sqrt
from demlaws.core.numba_compat import INLINED, kernel
from demlaws.core.slip import stretched
from demlaws.core.unloading import rule_of
from demlaws.yade import layout, objects
from demlaws.yade.mindlin import advance, turned
from demlaws.yade.records import assign, cross, dot, minus_scaled, note, pointee, scaled, unit_perpendicular, vector, view
from demlaws.yade.shear import Slip, account, is_changed

SLACK = 1e-11
"""Of Coulomb's limit: a contact within this is sliding."""


@kernel
def legendre_of_curve(shape, curve, reach, stiffness):
    """G = k u - f [J/m · ...] where a curve of first loading has the stiffness k [N/m]; reach: an overlap beyond it [m]."""
    low, high = 0.0, reach
    for _ in range(100):
        middle = 0.5 * (low + high)
        if first_loading(shape, curve, middle)[1] < stiffness:
            low = middle
        else:
            high = middle
        if high - low <= 1e-15 * high:
            break
    return high * stiffness - first_loading(shape, curve, high)[0]


@kernel
def legendre_of_hertz(coefficient, stiffness):
    """The same of P = coefficient u^1.5."""
    return stiffness * stiffness * stiffness / (6.75 * coefficient * coefficient)


def spring_end(rule, shape, p, ends, spring, reach, state, stiffness):
    """G of the unloading curve where its stiffness is `stiffness`: the integral of overlap over stiffness."""


@overload(spring_end, jit_options=INLINED)
def _spring_end(rule, shape, p, ends, spring, reach, state, stiffness):
    springs = rule_of(rule.instance_class).springs
    if springs == "hertz":
        return lambda rule, shape, p, ends, spring, reach, state, stiffness: legendre_of_hertz(p.hertz_coefficient, stiffness)
    if springs == "thornton":
        return lambda rule, shape, p, ends, spring, reach, state, stiffness: legendre_of_hertz(
            p.hertz_coefficient * sqrt(state[2]), stiffness
        )

    def cached(shape, p, ends, spring, reach, stiffness):
        value = ends[spring]
        if value < 0.0:
            value = max(legendre_of_curve(shape, p, reach, stiffness), 0.0)
            ends[spring] = value
        return value

    cached = kernel(cached)
    if springs == "given":
        return lambda rule, shape, p, ends, spring, reach, state, stiffness: cached(
            *unloading_curve(shape, p)[:2], ends, spring, reach, stiffness
        )
    return lambda rule, shape, p, ends, spring, reach, state, stiffness: cached(shape, p, ends, spring, reach, stiffness)


def recoverable(rule, overlap, state):
    """Overlap from the foot of the unloading curve [m]."""


@overload(recoverable, jit_options=INLINED)
def _recoverable(rule, overlap, state):
    if rule_of(rule.instance_class).springs == "own":
        return lambda rule, overlap, state: overlap
    return lambda rule, overlap, state: overlap - state[1]


@kernel
def part_in_contact(stiffness, share, spring):
    """Part of a spring that is in contact; stiffness: of the contact, share: of a spring [N/m]."""
    return min(max(stiffness / share - spring, 0.0), 1.0)


@kernel
def join(row, previous, share):
    """Join springs in pairs, with the mean of their stretches; previous: stiffness [N/m] of the contact in the last step."""
    count = len(row.end)
    for k in range(count):
        first = part_in_contact(previous, share, 2 * k) if 2 * k < count else 0.0
        second = part_in_contact(previous, share, 2 * k + 1) if 2 * k + 1 < count else 0.0
        for axis in range(2):
            mean = 0.0
            if first > 0.0:
                mean = first * row.spring[axis, 2 * k]
                if second > 0.0:
                    mean += second * row.spring[axis, 2 * k + 1]
                mean /= first + second
            row.spring[axis, k] = mean


@kernel
def write_compressions(mode, rule, shape, p, row, overlap, force, stiffness, state):
    """`shear.compress` with springs: their mean compressions [m]."""
    if not (stiffness > 0.0 and overlap > 0.0):
        return
    count, share = len(row.end), row.share
    previous = row.shear / row.ratio if row.ratio > 0.0 else 0.0
    old = share
    if share == 0.0:
        share = stiffness / count
    while stiffness > count * share * (1.0 + 1e-12):
        join(row, previous, share)
        share *= 2.0
    if share != old:
        row.share = share
        for k in range(count):
            row.end[k] = -1.0
    depth = recoverable(rule, overlap, state)
    before, total = 0.0, 0.0
    for k in range(count):
        low, high = k * share, (k + 1) * share
        if low >= stiffness:
            break
        if high < stiffness:
            end = spring_end(rule, shape, p, row.end, k, depth, state, high)
        else:
            high, end = stiffness, stiffness * depth - force
        mean = max(depth - (end - before) / (high - low), 0.0) if high > low else 0.0
        row.compression[k] = mean
        total += (high - low) * mean
        before = end
    row.scale = force / total if total > 0.0 else 0.0


@kernel
def turned_tangent(geom, tangent, normal):
    """Unit vector of a tangent that turns with the contact, and the length which the turn gave it; any one and 0 for zeros."""
    first = turned(geom, tangent)
    first = minus_scaled(first, dot(first, normal), normal)  # `turned` leaves the plane by the square of the turn
    length = sqrt(dot(first, first))
    if length > 0.0:
        return (first[0] / length, first[1] / length, first[2] / length), length
    return unit_perpendicular(normal), 0.0


@kernel
def open_springs(phys, row):
    """A contact without stiffness has no shear force; the energy of its springs is lost."""
    assign(phys.shearElastic, (0.0, 0.0, 0.0))
    for k in range(len(row.end)):
        row.spring[0, k] = row.spring[1, k] = 0.0
    account(row, 0.0, 0.0, row.held)


@kernel
def apply_to_springs(mode, context, contact, row, stiffness):
    """Set the shear force to that of the springs, apply Mindlin's law and account for the energy; stiffness: K_t [N/m]."""
    geom, phys = view(contact.geom, objects.ScGeom), view(pointee(contact.phys_pointer), objects.MindlinPhys)
    count = len(row.end)
    old_first, old_second = vector(row.tangent[0]), vector(row.tangent[1])
    if not stiffness > 0.0:
        open_springs(phys, row)
        keep = advance(mode, context, contact, row)
        assign(row.tangent[0], (0.0, 0.0, 0.0))
        return keep
    displacement = scaled(-1.0, vector(geom.shearInc))  # positive along the force that it makes
    normal = vector(geom.normal)
    first, length = turned_tangent(geom, old_first, normal)
    if length == 0.0:  # a new contact
        length, old_first, old_second = 1.0, first, cross(normal, first)
    second = cross(normal, first)
    share, ratio = row.share, row.ratio
    top, previous = stiffness / ratio, row.shear / ratio
    limit = phys.tangensOfFrictionAngle * row.scale / ratio
    along, across, most, work, stored = 0.0, 0.0, 0.0, 0.0, 0.0
    if is_changed(phys, row):
        note(context, layout.SET_SHEAR, view(contact.interaction, objects.Interaction), 0.0)
    du, dv = dot(displacement, first), dot(displacement, second)
    for k in range(count):  # as `slip_step`
        part, part_before = part_in_contact(top, share, k), part_in_contact(previous, share, k)
        if part == 0.0 or k * share >= top:
            row.spring[0, k] = row.spring[1, k] = 0.0
            continue
        u, v = row.spring[0, k], row.spring[1, k]
        if part > part_before:
            u, v = u * (part_before / part), v * (part_before / part)
        spring = ratio * share * part
        longest = limit * row.compression[k]
        most += spring * longest
        before_u, before_v, u, v = stretched(u, v, du, dv, longest)
        work += 0.5 * spring * ((before_u + u) * du + (before_v + v) * dv)
        row.spring[0, k], row.spring[1, k] = u, v
        along += spring * u
        across += spring * v
        stored += 0.5 * spring * (u * u + v * v)
    # Mindlin's law turns this and adds K_t times the displacement
    first_part, second_part = (along - stiffness * du) / length, (across - stiffness * dv) / length
    assign(phys.shearElastic, minus_scaled(scaled(first_part, old_first), -second_part, old_second))
    assign(row.tangent[0], first)
    assign(row.tangent[1], second)
    account(row, stiffness, stored, work - (stored - row.held))
    betas = phys.betas
    if along * along + across * across >= (1.0 - SLACK) * most * most:  # sliding, which Mindlin's law does not see
        phys.betas = 0.0
    keep = advance(mode, context, contact, row)
    phys.betas = betas
    return keep


bind(Slip, compress=write_compressions, apply_mindlin=apply_to_springs)
