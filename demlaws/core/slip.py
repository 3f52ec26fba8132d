"""Partial slip of one contact: a row of springs, which creates no energy.

The method of dimensionality reduction (Popov & Heß 2015, Method of Dimensionality Reduction in Contact Mechanics
and Friction) replaces a contact by independent springs. A spring that touches at overlap z has the normal stiffness
dK = P''(z) dz. Here a spring is named by κ = K(z), the stiffness of the contact when the spring touched, so that springs
keep their place when the unloading curve moves [our derivation]:

- The springs with κ below the stiffness K with which the contact would unload now are in contact.
- Spring κ is compressed by c(κ) = δ - δ(κ), where δ(κ) is the overlap on that unloading curve at which its stiffness is κ, so
  that ∫ c dκ = P for curves with P(0) = P'(0) = 0; for other curves the compressions are scaled to it.
- Its tangential stiffness is ratio dκ, its stretch at most μ c/ratio (Coulomb).
- A spring that touches is not stretched. A spring that opens loses its energy.

Springs between two bounds of κ are one spring, with their mean stretch [our derivation]:

- K rises: the outermost spring grows until it has the share THIN of K; then a new one begins. If all are in use, two
  neighbours are joined whose union errs and loses least. It has the mean of their stretches: the force remains, and the energy
  falls by k1 k2/(k1 + k2) |s1 - s2|²/2.
- K falls: springs above K open. Their places are used to divide the outermost spring, and others that err much more than a
  union of neighbours would. Both parts have the stretch of the whole.
- The springs between two bounds slip one after the other, from the outer bound on. With the limit taken as a straight line from
  its value `onset` there through its mean m, a displacement s gives the mean stretch s - (s - onset)²/(4 (m - onset)).
  A stretch above `onset` is taken as one that came about so. Slip comes from outside: a spring slips only on the part of the
  way on which its outer neighbour slips at its own limit. Below `onset`, and on reloading, all of it sticks.

The mean overlap at which the springs of a pair of bounds touched, `rest`, needs no unloading curve: ∫ δ(κ) dκ up to K is
K δ - P in each step, and the outermost spring has the difference to the others. Where the curve is Hertz's, δ(κ) = δ (κ/K)².

A stretch is a vector in the tangent plane; a spring slips along its trial stretch. With the work of a step taken as the mean of
the forces before and after it times the displacement, no step dissipates less than nothing, for any path.
Twin: demlaws/cpp/demlaws_slip.h.
"""

import math

import numpy as np

from demlaws.core.dispatch import gather, generic, scatter, step, unloaded
from demlaws.core.fastmath import sqrt
from demlaws.core.numba_compat import kernel, loop
from demlaws.core.shear import EMPTY, unloading_stiffness
from demlaws.core.unloading import rule_of

SAMPLES = 512
"""Points at which `slip_loop` reads the unloading curve of a rule that has no springs of its own."""
THIN = 1.0 / 21.0
"""Share of K at which the outermost of n springs is complete, times n; cycles of 0.02 μP need it."""
WIDE = 1.5
"""The outermost spring is divided where it has this multiple of that share."""
LARGE_CYCLES = 3.0
"""Weight of large cycles against small ones in the error of a spring."""
LOST = 60.0
"""Weight of the share of the stored energy that a union of two springs loses, against the error of the union."""
SPARE = 4.0
"""A spring is divided where it errs this many times more than the best union of two would."""
COARSE = 2.0
"""It is also divided where it is this many times wider than a row of so many springs needs."""
FARTHEST = 1.6
"""Largest ratio of the outermost spring's compression to that of a straight line from its neighbour, and its inverse."""
TINY = 1e-300


# --- bounds


@kernel
def inner(i, bound):
    """Inner bound [N/m] of spring i."""
    return bound[i - 1] if i > 0 else 0.0


@kernel
def spring_error(low, high, top):
    """Error of the loss that one spring from `low` to `high` makes: in small cycles and in large ones."""
    width = high - low
    small, large = width / (top - low), width / top
    return small * small + LARGE_CYCLES * large * large


@kernel
def lost_by_union(i, bound, stretch):
    """Energy [J], for a ratio K_t/K of 1, that spring i and its outer neighbour lose if they are joined."""
    first, second = bound[i] - inner(i, bound), bound[i + 1] - bound[i]
    du, dv = stretch[0, i + 1] - stretch[0, i], stretch[1, i + 1] - stretch[1, i]
    return 0.5 * first * second / max(first + second, TINY) * (du * du + dv * dv)


@kernel
def join(bound, rest, stretch):
    """Join the two neighbours whose union errs and loses least; the outermost spring is free then."""
    last, least, at = bound.size - 1, np.inf, 0
    _, _, stored = force_of_springs(bound, stretch)
    for i in range(last - 1):
        union = spring_error(inner(i, bound), bound[i + 1], bound[last])
        union += LOST * lost_by_union(i, bound, stretch) / max(stored, TINY)
        if union < least:
            least, at = union, i
    share = (bound[at] - inner(at, bound)) / (bound[at + 1] - inner(at, bound))
    rest[at] = share * rest[at] + (1.0 - share) * rest[at + 1]
    for k in range(2):
        stretch[k, at] = share * stretch[k, at] + (1.0 - share) * stretch[k, at + 1]
    bound[at] = bound[at + 1]
    for i in range(at + 1, last):
        bound[i], rest[i], stretch[0, i], stretch[1, i] = bound[i + 1], rest[i + 1], stretch[0, i + 1], stretch[1, i + 1]


@kernel
def coarse_error(springs):
    """Error from which a spring is divided, in a row of so many."""
    return (COARSE * math.log(springs / THIN) / springs) ** 2


@kernel
def widest(edge, bound):
    """The spring inside the outermost one, `edge`, that is worth a division; -1: none."""
    most, at, least = 0.0, -1, np.inf
    for i in range(edge):
        error = spring_error(inner(i, bound), bound[i], bound[edge])
        if error > most:
            most, at = error, i
        least = min(least, spring_error(inner(i, bound), bound[i + 1], bound[edge]))
    return at if most > min(SPARE * least, coarse_error(bound.size)) else -1


@kernel
def fall_within(at, depth, edge, bound, rest):
    """Fall of the compression [m] from the inner to the outer bound of spring `at`, if that is a square function of κ with the
    means of the springs there, `depth` at κ = 0 and 0 at the outermost bound (Colella & Woodward 1984, Eq. 1.7)."""
    if edge == 0:
        return depth
    before = bound[at - 1] - inner(at - 1, bound) if at > 0 else 0.0
    width = bound[at] - inner(at, bound)
    after = bound[at + 1] - bound[at] if at < edge else 0.0
    if at == 0:
        return (rest[1] * width * width + rest[0] * after * (2.0 * after + 3.0 * width)) / (width + after) ** 2
    mean = depth - rest[at]
    if at == edge:
        return ((depth - rest[at - 1]) * width * width + mean * before * (2.0 * before + 3.0 * width)) / (width + before) ** 2
    outside = (2.0 * before + width) / (after + width) * (rest[at + 1] - rest[at])
    inside = (2.0 * after + width) / (before + width) * (rest[at] - rest[at - 1])
    return width / (before + width + after) * (outside + inside)


@kernel
def divide(at, depth, edge, bound, rest, stretch):
    """Divide spring `at` in the middle."""
    mean = depth - rest[at]
    quarter = 0.25 * min(max(fall_within(at, depth, edge, bound, rest), 0.0), 3.0 * mean)
    for i in range(edge, at - 1, -1):
        bound[i + 1], rest[i + 1], stretch[0, i + 1], stretch[1, i + 1] = bound[i], rest[i], stretch[0, i], stretch[1, i]
    bound[at] = 0.5 * (inner(at, bound) + bound[at])
    rest[at], rest[at + 1] = depth - mean - quarter, depth - mean + quarter


@loop
def begin(top, force, depth, bound, rest):
    """Bounds of a new contact, whose unloading curve is taken as a power law; returns the outermost spring."""
    power = force / max(top * depth - force, 1e-12 * force)
    last, open_share, below, integral_below, edge = bound.size - 1, 1.0, 0.0, 0.0, 0
    while edge < last and open_share > WIDE * THIN / bound.size:
        open_share *= 0.5
        bound[edge] = (1.0 - open_share) * top
        integral = depth * top * (1.0 - open_share) ** (power + 1.0) / (power + 1.0)
        rest[edge] = (integral - integral_below) / (bound[edge] - below)
        below, integral_below = bound[edge], integral
        edge += 1
    return edge


@loop
def grade(edge, depth, bound, rest, stretch):
    """Divide springs, the outermost one `edge` first, and join others for it where none is free; returns the outermost."""
    last, top = bound.size - 1, bound[bound.size - 1]
    while True:
        wide = top - inner(edge, bound) > WIDE * THIN / bound.size * top
        if wide and (edge < last or last > 1):  # of two springs none is left to be joined
            if edge == last:
                join(bound, rest, stretch)
                edge -= 1
            at = edge
        else:
            at = widest(edge, bound) if edge < last else -1
        if at < 0:
            return edge
        divide(at, depth, edge, bound, rest, stretch)
        edge += 1


@kernel
def outermost(force, top, depth, edge, bound, rest):
    """Mean compression [m] of the outermost spring, which carries the rest of the force."""
    carried, below = 0.0, 0.0
    for i in range(edge):
        carried += (bound[i] - below) * max(depth - rest[i], 0.0)
        below = bound[i]
    width = top - below
    mean = max(force - carried, 0.0) / width if width > 0.0 else 0.0
    if edge > 0:
        straight = max(depth - rest[edge - 1], 0.0) * 0.5 * width / (top - 0.5 * (below + inner(edge - 1, bound)))
        mean = min(max(mean, straight / FARTHEST), straight * FARTHEST)
    return mean


@kernel
def set_springs(hertzian, top, force, depth, bound, rest, stretch):
    """The contact unloads with the stiffness `top` [N/m] now, along a curve that began `depth` [m] before.

    hertzian: along Hertz's curve. bound [N/m], rest [m], stretch (2, springs) [m]: of the springs, updated. Bounds that are not
    in use are `top`, the stretches there 0.
    """
    last = bound.size - 1
    held = bound[last]
    lowest, edge = min(top, held) * (1.0 - EMPTY), last  # not of springs that rounding makes
    while edge > 0 and bound[edge - 1] >= lowest:
        edge -= 1
    opened = held == 0.0 or (edge < last and top < held)
    if held > 0.0 and top > held:
        low = inner(edge, bound)
        if top - low <= THIN / bound.size * top:
            stretch[0, edge] *= (held - low) / (top - low)
            stretch[1, edge] *= (held - low) / (top - low)
        else:
            if edge == last:
                join(bound, rest, stretch)
            else:
                edge += 1
            stretch[0, edge] = stretch[1, edge] = 0.0
    if held == 0.0:
        edge = begin(top, force, depth, bound, rest)
    for i in range(edge, last + 1):
        bound[i] = top
    if not hertzian:
        rest[edge] = depth - outermost(force, top, depth, edge, bound, rest)
    if opened or top - inner(edge, bound) > WIDE * THIN / bound.size * top:
        if hertzian:
            set_rest(top, depth, bound, rest)
        edge = grade(edge, depth, bound, rest, stretch)
    for i in range(edge + 1, last + 1):
        rest[i], stretch[0, i], stretch[1, i] = depth, 0.0, 0.0


@kernel
def set_rest(top, depth, bound, rest):
    """Fill `rest` where the curve is Hertz's."""
    unit, below = depth / (3.0 * top * top), 0.0
    for i in range(bound.size):
        rest[i] = unit * (bound[i] * bound[i] + bound[i] * below + below * below)
        below = bound[i]


# --- a step


@kernel
def shorten(stretch, limit):
    """Shorten the stretches to at most their limits."""
    longer = 0
    for i in range(limit.size):
        longer += stretch[0, i] * stretch[0, i] + stretch[1, i] * stretch[1, i] > limit[i] * limit[i]
    if longer == 0:
        return
    for i in range(limit.size):  # without a branch: one vector of the processor has several springs
        u, v, most = stretch[0, i], stretch[1, i], limit[i]
        share = most / sqrt(max(max(u * u + v * v, most * most), TINY))
        stretch[0, i], stretch[1, i] = u * share, v * share


@kernel
def displace(du, dv, onset, limit, stretch):
    """Displace the springs by (du, dv) [m]: one that is stretched beyond `onset` [m] follows less and less, up to `limit` [m],
    on the part of the way on which its outer neighbour slips at its own limit.

    Returns whether all of them slip.
    """
    yields = 0
    for i in range(limit.size):
        u, v = stretch[0, i] + du, stretch[1, i] + dv
        held = max(stretch[0, i] * stretch[0, i] + stretch[1, i] * stretch[1, i], onset[i] * onset[i])
        yields += u * u + v * v > held
    if yields == 0:
        for i in range(limit.size):
            stretch[0, i] += du
            stretch[1, i] += dv
        return False
    slips, beyond = 0, np.inf  # beyond: length by which the outer neighbour exceeds its limit
    for i in range(limit.size - 1, -1, -1):
        u, v, wide = stretch[0, i] + du, stretch[1, i] + dv, max(limit[i] - onset[i], TINY)
        length = sqrt(u * u + v * v)
        held = sqrt(max(stretch[0, i] * stretch[0, i] + stretch[1, i] * stretch[1, i], onset[i] * onset[i]))
        start = min(max(held, length - beyond), limit[i])
        beyond = max(length - limit[i], 0.0)
        stuck = sqrt(max(1.0 - (start - onset[i]) / wide, 0.0))
        stuck = max(stuck - 0.5 * max(length - start, 0.0) / wide, 0.0)
        share = (onset[i] + wide * (1.0 - stuck * stuck)) / max(length, TINY) if length > start else 1.0
        stretch[0, i], stretch[1, i] = u * share, v * share
        slips += length > start and stuck < 1e-7
    return slips == limit.size


@kernel
def force_of_springs(bound, stretch):
    """Both shear forces [N] and the energy [J] for a ratio K_t/K of 1."""
    first, second, energy, below = 0.0, 0.0, 0.0, 0.0
    for i in range(bound.size):
        stiffness, u, v = bound[i] - below, stretch[0, i], stretch[1, i]
        first += stiffness * u
        second += stiffness * v
        energy += stiffness * (u * u + v * v)
        below = bound[i]
    return first, second, 0.5 * energy


@kernel
def compressions(hertzian, depth, bound, rest, onset, limit):
    """Fill `limit` with the springs' mean compressions over the force [N] that they carry [m/N], their share of Coulomb's
    limit, and `onset` with those at their outer bounds."""
    if hertzian:
        set_rest(bound[bound.size - 1], depth, bound, rest)
    carried, below = 0.0, 0.0
    for i in range(bound.size):
        limit[i] = max(depth - rest[i], 0.0)
        carried += (bound[i] - below) * limit[i]
        below = bound[i]
    scale, last, below = 1.0 / carried if carried > 0.0 else 0.0, bound.size - 1, 0.0
    for i in range(bound.size):
        limit[i] *= scale
    for i in range(last):
        width, outer = bound[i] - below, bound[i + 1] - bound[i]
        onset[i] = (limit[i] * outer + limit[i + 1] * width) / max(width + outer, TINY)
        below = bound[i]
    onset[last] = 0.0


@kernel
def slip(most, ratio, du, dv, bound, stretch, onset, limit):
    """Displace the springs by (du, dv) [m] under Coulomb's limit `most` [N] of the contact.

    onset, limit: of `compressions`, overwritten. Returns both shear forces [N], work and stored energy [J], the share of the
    contact's stiffness that sticks, from 0 to 1, and whether all springs slip.
    """
    top = bound[bound.size - 1]
    for i in range(bound.size):
        limit[i] *= most / ratio
        onset[i] = min(onset[i] * (most / ratio), limit[i])
    shorten(stretch, limit)  # the compression fell: slip without displacement
    before_u, before_v, _ = force_of_springs(bound, stretch)
    slides = displace(du, dv, onset, limit, stretch)
    first, second, energy = force_of_springs(bound, stretch)
    work = 0.5 * ratio * ((before_u + first) * du + (before_v + second) * dv)
    moved = top * (du * du + dv * dv)
    stuck = ((first - before_u) * du + (second - before_v) * dv) / moved if moved > 0.0 else 1.0
    return ratio * first, ratio * second, work, ratio * energy, min(max(stuck, 0.0), 1.0), slides


# --- the curve of a rule


def _springs_of(kinds):
    return rule_of(kinds[0].instance_class).springs


def _depth(*kinds):
    if _springs_of(kinds) in ("own", None):
        return lambda rule, overlap, state: overlap
    return lambda rule, overlap, state: overlap - state[1]


def _unloads_by_hertz(*kinds):
    hertzian = _springs_of(kinds) in ("hertz", "thornton")
    return lambda rule: hertzian


def _has_springs(*kinds):
    springs = _springs_of(kinds) is not None
    return lambda rule: springs


@generic(_depth)
def depth_of(rule, overlap, state):
    """Overlap from the foot of the unloading curve [m]."""


@generic(_unloads_by_hertz)
def unloads_by_hertz(rule):
    """Whether the unloading curve of a rule is Hertz's."""


@generic(_has_springs)
def has_springs(rule):
    """Whether the unloading curve of a rule moves without a change of its springs; else it is read in each step."""


@kernel
def read_unloading_curve(rule, shape, p, overlap, state, top, curve):
    """Fill `curve` (2, points) with compressions [m] and stiffnesses [N/m] of the unloading curve, from where it ends to here.

    A stiffness above that of a larger overlap is replaced by it: springs of that stiffness have opened on the way.
    """
    last = curve.shape[1] - 1
    foot = min(max(unloaded(rule, shape, p, 0.0, state), 0.0), overlap)
    curve[0, last], curve[1, last] = 0.0, top
    for j in range(last - 1, -1, -1):
        place = foot + (overlap - foot) * (j / last) ** 2
        stiffness = step(rule, shape, p, place, state)[1]
        curve[0, j], curve[1, j] = overlap - place, min(stiffness, curve[1, j + 1])


@kernel
def compress(curve, depth, bound, rest):
    """Fill `rest` with means along a curve of `read_unloading_curve`."""
    j, low = 0, 0.0
    for i in range(bound.size):
        high, below, total = bound[i], low, 0.0
        while low < high:  # from piece to piece of the curve, on which compression is linear in stiffness
            end = min(curve[1, j], high)
            if end > low:
                deepest = curve[0, max(j - 1, 0)]
                start = curve[1, j - 1] if j > 0 else 0.0
                slope = (curve[0, j] - deepest) / (curve[1, j] - start)
                total += (end - low) * (deepest + slope * (0.5 * (low + end) - start))
                low = end
            if low < high:
                j += 1
        rest[i] = depth - total / (high - below) if high > below else depth


@loop
def slip_loop(rule, shape, p, overlap, along, across, ratio, friction, state, row, curve, results):
    """`levels.levels_loop` with a row of springs, by the stiffness with which the contact would unload.

    row: (6, springs) zeros: bounds, `rest`, stretches in two rows, and memory for steps. curve: (2, SAMPLES) for the unloading
    curve.
    """
    work = 0.0
    bound, rest, stretch, onset, limit = row[0], row[1], row[2:4], row[4], row[5]
    for n in range(overlap.size):
        force, tangent, new = step(rule, shape, p, overlap[n], gather(state, 0))
        scatter(state, 0, new)
        top = max(unloading_stiffness(rule, shape, p, overlap[n], force, tangent, new), 0.0) if overlap[n] > 0.0 else 0.0
        first, second, stored = 0.0, 0.0, 0.0
        if top > 0.0 and force > 0.0:
            hertzian, depth = unloads_by_hertz(rule), depth_of(rule, overlap[n], new)
            set_springs(hertzian, top, force, depth, bound, rest, stretch)
            if not has_springs(rule):
                read_unloading_curve(rule, shape, p, overlap[n], new, top, curve)
                compress(curve, depth, bound, rest)
            du = along[n] - along[n - 1] if n > 0 else 0.0
            dv = across[n] - across[n - 1] if n > 0 else 0.0
            compressions(hertzian, depth, bound, rest, onset, limit)
            first, second, step_work, stored, _, _ = slip(friction[n] * force, ratio, du, dv, bound, stretch, onset, limit)
            work += step_work
        else:
            row[:] = 0.0
        results[0, n], results[1, n] = force, top
        results[2, n], results[3, n] = first, second
        results[4, n], results[5, n] = work, stored
