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

Springs between two bounds of κ are one spring: its stretch and its limit are means. The bounds are a ladder, graded towards the
springs that touched last, which slip first [our derivation]: bound i is at ladder[i] K in a contact that grows.

- K rises: a bound below its step of the ladder moves there. The springs that it passes change to the spring inside of it, with
  the mean of their stretches: the force remains, the energy cannot rise. Bounds above their steps remain in place.
- K falls: springs above K open. The bounds that they leave divide the springs that contain the most steps of the ladder.

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
from demlaws.core.shear import SPRINGS, unloading_stiffness
from demlaws.core.unloading import rule_of

SAMPLES = 512
"""Points at which `slip_loop` reads the unloading curve of a rule that has no springs of its own."""
STEPS = (0.4093, 0.6484, 0.7924, 0.8732, 0.9262, 0.9605, 0.9786, 0.9892, 0.9958, 1.0)
"""Ladder of `SPRINGS`: the largest error of the loss of a cycle of Hertz's law from 0.05 μP on, or a third of that at 0.02, is
least."""
SLACK = 1.3
"""The ladder is laid again where the outermost spring has this share of its step."""
FARTHEST = 3.0
"""Largest ratio of the outermost spring's compression to that of a straight line from its neighbour, and its inverse."""
TINY = 1e-300


def ladder_of(springs):
    """Bounds of so many springs over the stiffness of the contact."""
    if springs == SPRINGS:
        return np.array(STEPS)
    growth = 1.0 + 6.4 / springs
    return (growth**springs - growth ** np.arange(springs - 1, -1, -1.0)) / (growth**springs - 1.0)


# --- bounds


@loop
def begin(ladder, top, force, depth, bound, rest, stretch):
    """Lay the ladder of a new contact whose unloading curve is taken as a power law."""
    power = force / max(top * depth - force, 1e-12 * force)
    below = integral_below = 0.0
    for i in range(bound.size):
        integral = depth * top * ladder[i] ** (power + 1.0) / (power + 1.0)
        bound[i] = ladder[i] * top
        rest[i] = (integral - integral_below) / (bound[i] - below)
        below, integral_below = bound[i], integral
        stretch[0, i] = stretch[1, i] = 0.0


@loop
def lift(ladder, top, depth, bound, rest, stretch, old):
    """Move the bounds that are below their steps of the ladder; old: (4, springs), overwritten."""
    last = bound.size - 1
    for i in range(bound.size):
        old[0, i], old[1, i], old[2, i], old[3, i] = bound[i], rest[i], stretch[0, i], stretch[1, i]
    j, start, low = 0, 0.0, 0.0  # start: lower bound of the old spring j
    for i in range(bound.size):
        high = max(ladder[i] * top, old[0, i])
        below, sums, first, second = low, 0.0, 0.0, 0.0
        while low < high:
            end = min(old[0, j], high)
            if end > low:
                width = old[0, j] - start
                if j == last:
                    slope = 2.0 * (depth - old[1, j]) / width
                else:
                    before = start - (old[0, j - 2] if j > 1 else 0.0) if j > 0 else -width
                    slope = (old[1, j + 1] - old[1, max(j - 1, 0)]) / (0.5 * (before + old[0, j + 1] - old[0, j]) + width)
                sums += (end - low) * (old[1, j] + 0.5 * slope * (low + end - start - old[0, j]))
                first += (end - low) * old[2, j]
                second += (end - low) * old[3, j]
                low = end
            if low < high:
                start = old[0, j]
                j += 1
        width = high - below
        bound[i] = high
        rest[i] = sums / width if width > 0.0 else old[1, j]
        stretch[0, i] = first / width if width > 0.0 else old[2, j]
        stretch[1, i] = second / width if width > 0.0 else old[3, j]


@kernel
def split_integral(at, place, low, high, inside, whole, depth, top, bound, rest):
    """∫ δ(κ) dκ from `low` to `place`, of which `whole` lies from `low` to `high`, and `inside` below `low`.

    ∫ δ(κ) dκ from 0 on is taken as a power of κ.
    """
    if inside > 0.0:
        part = inside * (place / low) ** (math.log1p(whole / inside) / math.log(high / low)) - inside
    elif not whole > 0.0:
        return 0.0
    elif high < top:
        next_whole = (bound[at + 1] - high) * rest[at + 1]
        part = whole * (place / high) ** (math.log1p(next_whole / whole) / math.log(bound[at + 1] / high))
    else:
        part = whole * (place / high) ** (depth * top / whole)
    return min(max(part, 0.0), whole)


@loop
def divide(ladder, top, depth, edge, bound, rest, stretch):
    """Divide springs that contain the most steps of the ladder, while there are empty ones behind `edge`, the outermost."""
    last = bound.size - 1
    while edge < last:
        most, at, place, step_number = 0, -1, 0.0, last - 1
        for j in range(edge, -1, -1):
            low, highest = bound[j - 1] if j > 0 else 0.0, step_number
            while step_number >= 0 and ladder[step_number] * top > low:
                step_number -= 1
            if highest - step_number > most:
                most, at, place = highest - step_number, j, ladder[(highest + step_number + 1) // 2] * top
        if at < 0:
            break
        low, high, inside = bound[at - 1] if at > 0 else 0.0, bound[at], 0.0
        for j in range(at):
            inside += (bound[j] - (bound[j - 1] if j > 0 else 0.0)) * rest[j]
        whole = (high - low) * rest[at]
        part = split_integral(at, place, low, high, inside, whole, depth, top, bound, rest)
        for j in range(edge + 1, at, -1):
            bound[j], rest[j], stretch[0, j], stretch[1, j] = bound[j - 1], rest[j - 1], stretch[0, j - 1], stretch[1, j - 1]
        bound[at], rest[at], rest[at + 1] = place, part / (place - low), (whole - part) / (high - place)
        edge += 1
    for j in range(edge + 1, bound.size):
        bound[j], rest[j], stretch[0, j], stretch[1, j] = top, depth, stretch[0, edge], stretch[1, edge]


@kernel
def outermost(force, top, depth, edge, bound, rest):
    """Mean compression [m] of the outermost spring: what the others leave of the force."""
    carried, below = 0.0, 0.0
    for i in range(edge):
        carried += (bound[i] - below) * max(depth - rest[i], 0.0)
        below = bound[i]
    width = top - below
    mean = max(force - carried, 0.0) / width if width > 0.0 else 0.0
    if edge > 0:
        inner = bound[edge - 2] if edge > 1 else 0.0
        straight = max(depth - rest[edge - 1], 0.0) * 0.5 * width / (top - 0.5 * (below + inner))
        mean = min(max(mean, straight / FARTHEST), straight * FARTHEST)
    return mean


@kernel
def set_springs(hertzian, ladder, top, force, depth, bound, rest, stretch, scratch):
    """The contact unloads with the stiffness `top` [N/m] now, along a curve that began `depth` [m] before.

    hertzian: along Hertz's curve. bound [N/m], rest [m], stretch (2, springs) [m]: of the springs, updated. scratch: (4,
    springs).
    """
    last = bound.size - 1
    held = bound[last]
    if held == 0.0:
        begin(ladder, top, force, depth, bound, rest, stretch)
        return
    edge = last
    if top < held:
        if top <= bound[last - 1]:
            edge = 0
            for i in range(last):
                edge += bound[i] < top
            for i in range(edge, last):
                bound[i] = top
        bound[last] = top
    elif top > held:
        below = bound[last - 1]
        share = (held - below) / (top - below)
        bound[last] = top
        stretch[0, last] *= share
        stretch[1, last] *= share
    if not hertzian:
        rest[edge] = depth - outermost(force, top, depth, edge, bound, rest)
    if edge < last:
        if hertzian:
            set_rest(top, depth, bound, rest)
        divide(ladder, top, depth, edge, bound, rest, stretch)
    elif top > held and bound[last - 1] < top - SLACK * (1.0 - ladder[last - 1]) * top:
        lift(ladder, top, depth, bound, rest, stretch, scratch)


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
    """Shorten the stretches to at most their limits, without a branch: one vector of the processor has several springs.

    Returns how many were longer.
    """
    longer = 0
    for i in range(limit.size):
        u, v, most = stretch[0, i], stretch[1, i], limit[i]
        share = most / sqrt(max(max(u * u + v * v, most * most), TINY))
        stretch[0, i], stretch[1, i] = u * share, v * share
        longer += share < 1.0
    return longer


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
def compressions(hertzian, depth, bound, rest, limit):
    """Fill `limit` with the springs' compressions over the force [N] that they carry [m/N]; their share of Coulomb's limit."""
    if hertzian:
        set_rest(bound[bound.size - 1], depth, bound, rest)
    carried, below = 0.0, 0.0
    for i in range(bound.size):
        limit[i] = max(depth - rest[i], 0.0)
        carried += (bound[i] - below) * limit[i]
        below = bound[i]
    scale = 1.0 / carried if carried > 0.0 else 0.0
    for i in range(bound.size):
        limit[i] *= scale


@kernel
def slip(most, ratio, du, dv, bound, stretch, limit):
    """Displace the springs by (du, dv) [m] under Coulomb's limit `most` [N] of the contact.

    limit: of `compressions`, overwritten. Returns both shear forces [N], work and stored energy [J], the share of the contact's
    stiffness that sticks, from 0 to 1, and whether all springs slip.
    """
    top = bound[bound.size - 1]
    for i in range(bound.size):
        limit[i] *= most / ratio
    shorten(stretch, limit)  # the compression fell: slip without displacement
    before_u, before_v, _ = force_of_springs(bound, stretch)
    for i in range(bound.size):
        stretch[0, i] += du
        stretch[1, i] += dv
    slides = shorten(stretch, limit) == bound.size
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
def slip_loop(rule, shape, p, overlap, along, across, ratio, friction, ladder, state, row, curve, results):
    """`levels.levels_loop` with a row of springs, by the stiffness with which the contact would unload.

    ladder: of `ladder_of`. row: (9, springs) zeros: bounds, `rest`, stretches in two rows, and memory for steps. curve: (2,
    SAMPLES) for the unloading curve.
    """
    work = 0.0
    bound, rest, stretch, scratch, limit = row[0], row[1], row[2:4], row[4:8], row[8]
    for n in range(overlap.size):
        force, tangent, new = step(rule, shape, p, overlap[n], gather(state, 0))
        scatter(state, 0, new)
        top = max(unloading_stiffness(rule, shape, p, overlap[n], force, tangent, new), 0.0) if overlap[n] > 0.0 else 0.0
        first, second, stored = 0.0, 0.0, 0.0
        if top > 0.0 and force > 0.0:
            hertzian, depth = unloads_by_hertz(rule), depth_of(rule, overlap[n], new)
            set_springs(hertzian, ladder, top, force, depth, bound, rest, stretch, scratch)
            if not has_springs(rule):
                read_unloading_curve(rule, shape, p, overlap[n], new, top, curve)
                compress(curve, depth, bound, rest)
            du = along[n] - along[n - 1] if n > 0 else 0.0
            dv = across[n] - across[n - 1] if n > 0 else 0.0
            compressions(hertzian, depth, bound, rest, limit)
            first, second, step_work, stored, _, _ = slip(friction[n] * force, ratio, du, dv, bound, stretch, limit)
            work += step_work
        else:
            row[:] = 0.0
        results[0, n], results[1, n] = force, top
        results[2, n], results[3, n] = first, second
        results[4, n], results[5, n] = work, stored
