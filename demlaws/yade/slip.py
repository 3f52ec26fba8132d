"""Partial slip at a contact, a row of springs: the twin of SpringRow in demlaws/cpp/demlaws_slip.h, with stretches as two
components in a tangent frame. Compiled code, loaded for shear="slip" only."""

from numba.extending import overload

from demlaws.core.dispatch import parts, virgin
from demlaws.core.fastmath import sqrt
from demlaws.core.numba_compat import INLINED, kernel
from demlaws.core.slip import stretched
from demlaws.core.unloading import Elastic, Given, Hertz, Thornton
from demlaws.laws.etsion import Etsion, Jackson
from demlaws.yade import layout as at
from demlaws.yade.memory import load_double, load_word, store_double
from demlaws.yade.shear import (
    FRAME_WORDS,
    SLACK,
    Slip,
    account,
    advance,
    compress,
    cross,
    dot,
    go,
    less,
    load_vector,
    scaled,
    store_vector,
    turned,
    word,
)


@kernel
def legendre_of_curve(curve, reach, stiffness):
    """G = k u - f [J/m · ...] where a curve of first loading has the stiffness k [N/m]; reach: an overlap beyond it [m]."""
    low, high = 0.0, reach
    for _ in range(100):
        middle = 0.5 * (low + high)
        if virgin(curve, middle)[1] < stiffness:
            low = middle
        else:
            high = middle
        if high - low <= 1e-15 * high:
            break
    return high * stiffness - virgin(curve, high)[0]


@kernel
def legendre_of_hertz(coefficient, stiffness):
    """The same of P = coefficient u^1.5."""
    return stiffness * stiffness * stiffness / (6.75 * coefficient * coefficient)


def spring_end(rule, p, place, reach, state, stiffness):
    """G of the unloading curve where its stiffness is `stiffness`: the integral of overlap over stiffness."""


@overload(spring_end, jit_options=INLINED)
def _spring_end(rule, p, place, reach, state, stiffness):
    kind = rule.instance_class
    if kind is Hertz:
        return lambda rule, p, place, reach, state, stiffness: legendre_of_hertz(p.hertz_coefficient, stiffness)
    if kind in (Thornton, Etsion, Jackson):
        return lambda rule, p, place, reach, state, stiffness: legendre_of_hertz(
            p.hertz_coefficient * sqrt(state[2]), stiffness
        )

    def cached(p, place, reach, stiffness):
        value = load_double(place)
        if value < 0.0:
            value = max(legendre_of_curve(p, reach, stiffness), 0.0)
            store_double(place, value)
        return value

    cached = kernel(cached)
    if kind is Given:
        return lambda rule, p, place, reach, state, stiffness: cached(parts(p)[1], place, reach, stiffness)
    return lambda rule, p, place, reach, state, stiffness: cached(p, place, reach, stiffness)


def recoverable(rule, overlap, state):
    """Overlap from the foot of the unloading curve [m]."""


@overload(recoverable, jit_options=INLINED)
def _recoverable(rule, overlap, state):
    if rule.instance_class is Elastic:
        return lambda rule, overlap, state: overlap
    return lambda rule, overlap, state: overlap - state[1]


@kernel
def join(springs, count, previous, share):
    """Join springs in pairs, with the mean of their stretches; previous: stiffness [N/m] of the contact in the last step."""
    stretch = springs + 8 * (FRAME_WORDS + 2 * count)
    for k in range(count):
        first = min(max(previous / share - 2 * k, 0.0), 1.0) if 2 * k < count else 0.0
        second = min(max(previous / share - 2 * k - 1, 0.0), 1.0) if 2 * k + 1 < count else 0.0
        for axis in range(2):
            row, mean = stretch + 8 * axis * count, 0.0
            if first > 0.0:
                mean = first * load_double(row + 16 * k)
                if second > 0.0:
                    mean += second * load_double(row + 16 * k + 8)
                mean /= first + second
            store_double(row + 8 * k, mean)


@overload(compress, jit_options=INLINED)
def _compress(mode, rule, p, context, row, overlap, force, stiffness, state):
    if mode.instance_class is not Slip:
        return None

    def write(mode, rule, p, context, row, overlap, force, stiffness, state):
        """`shear.compress` with springs: their mean compressions [m]."""
        if not (stiffness > 0.0 and overlap > 0.0):
            return
        springs, count = row + word(context, at.SPRINGS), word(context, at.SPRING_COUNT)
        ends = springs + 8 * FRAME_WORDS
        share, ratio = load_double(springs + 48), load_double(row + at.RATIO_OF_ROW)
        previous = load_double(row + at.SHEAR_STIFFNESS) / ratio if ratio > 0.0 else 0.0
        old = share
        if share == 0.0:
            share = stiffness / count
        while stiffness > count * share * (1.0 + 1e-12):
            join(springs, count, previous, share)
            share *= 2.0
        if share != old:
            store_double(springs + 48, share)
            for k in range(count):
                store_double(ends + 8 * k, -1.0)
        depth = recoverable(rule, overlap, state)
        before, total = 0.0, 0.0
        for k in range(count):
            low, high = k * share, (k + 1) * share
            if low >= stiffness:
                break
            if high < stiffness:
                end = spring_end(rule, p, ends + 8 * k, depth, state, high)
            else:
                high, end = stiffness, stiffness * depth - force
            mean = max(depth - (end - before) / (high - low), 0.0) if high > low else 0.0
            store_double(ends + 8 * (count + k), mean)
            total += (high - low) * mean
            before = end
        store_double(springs + 56, force / total if total > 0.0 else 0.0)

    return write


@kernel
def unit_perpendicular(normal):
    """Some unit vector across `normal`."""
    x, y, z = normal
    if abs(x) <= abs(y) and abs(x) <= abs(z):
        side = (0.0, -z, y)
    elif abs(y) <= abs(z):
        side = (z, 0.0, -x)
    else:
        side = (-y, x, 0.0)
    length = sqrt(dot(side, side))
    return side[0] / length, side[1] / length, side[2] / length


@kernel
def go_with_springs(context, this, geom_pointer, phys_pointer, interaction, row, stiffness):
    """Set the shear force to that of the springs, apply Mindlin's law and account for the energy; stiffness: K_t [N/m]."""
    geom, phys = load_word(geom_pointer), load_word(phys_pointer)
    springs, count = row + word(context, at.SPRINGS), word(context, at.SPRING_COUNT)
    means = springs + 8 * (FRAME_WORDS + count)
    stretch = means + 8 * count
    place, energy = phys + word(context, at.SHEAR_FORCE), load_double(row + at.SHEAR_HELD)
    old_first, old_second = load_vector(springs), load_vector(springs + 24)
    if not stiffness > 0.0:
        store_vector(place, (0.0, 0.0, 0.0))
        for k in range(2 * count):
            store_double(stretch + 8 * k, 0.0)
        account(row, 0.0, 0.0, energy)
        keep = advance(context, this, geom_pointer, phys_pointer, interaction, row)
        store_vector(springs, (0.0, 0.0, 0.0))
        return keep
    step = scaled(-1.0, load_vector(geom + word(context, at.INCREMENT)))  # positive along the force that it makes
    normal, first = load_vector(geom + word(context, at.NORMAL)), turned(context, geom, old_first)
    length = sqrt(dot(first, first))
    if length > 0.0:
        first = (first[0] / length, first[1] / length, first[2] / length)
    else:  # a new contact
        first, length = unit_perpendicular(normal), 1.0
        old_first, old_second = first, cross(normal, first)
    second = cross(normal, first)
    share, ratio = load_double(springs + 48), load_double(row + at.RATIO_OF_ROW)
    top, previous = stiffness / ratio, load_double(row + at.SHEAR_STIFFNESS) / ratio
    limit = load_double(phys + word(context, at.FRICTION)) * load_double(springs + 56) / ratio
    along, across, most, work, stored = 0.0, 0.0, 0.0, 0.0, 0.0
    du, dv = dot(step, first), dot(step, second)
    for k in range(count):  # as `slip_step`
        here = stretch + 8 * k
        part, was = min(max(top / share - k, 0.0), 1.0), min(max(previous / share - k, 0.0), 1.0)
        if part == 0.0 or k * share >= top:
            store_double(here, 0.0)
            store_double(here + 8 * count, 0.0)
            continue
        u, v = load_double(here), load_double(here + 8 * count)
        if part > was:
            u, v = u * (was / part), v * (was / part)
        one = ratio * share * part
        longest = limit * load_double(means + 8 * k)
        most += one * longest
        before_u, before_v, u, v = stretched(u, v, du, dv, longest)
        work += 0.5 * one * ((before_u + u) * du + (before_v + v) * dv)
        store_double(here, u)
        store_double(here + 8 * count, v)
        along += one * u
        across += one * v
        stored += 0.5 * one * (u * u + v * v)
    # the native law turns this and adds K_t times the displacement
    first_part, second_part = (along - stiffness * du) / length, (across - stiffness * dv) / length
    store_vector(place, less(scaled(first_part, old_first), -second_part, old_second))
    store_vector(springs, first)
    store_vector(springs + 24, second)
    account(row, stiffness, stored, work - (stored - energy))
    damping = phys + word(context, at.BETAS)
    betas = load_double(damping)
    if along * along + across * across >= (1.0 - SLACK) * most * most:  # sliding, which the native law does not see
        store_double(damping, 0.0)
    keep = advance(context, this, geom_pointer, phys_pointer, interaction, row)
    store_double(damping, betas)
    return keep


@overload(go, jit_options=INLINED)
def _go(mode, context, this, geom_pointer, phys_pointer, interaction, row, stiffness):
    if mode.instance_class is Slip:
        return lambda mode, context, this, geom_pointer, phys_pointer, interaction, row, stiffness: go_with_springs(
            context, this, geom_pointer, phys_pointer, interaction, row, stiffness
        )
