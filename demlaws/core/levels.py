"""Shear without slip before sliding: the tangential springs of a contact in a few levels, and Coulomb's limit.

A contact is a set of tangential springs, which touch one after the other while its tangential stiffness K_t grows. Level i has
the springs that touched between two values of K_t; they have one stretch:

    Q = Σ (bound[i] - bound[i-1]) stretch[i],    stored energy = ½ Σ (bound[i] - bound[i-1]) |stretch[i]|²

- K_t falls: the springs above the new K_t open. Their force and their energy are lost.
- K_t rises: a level without stretch is added. The two neighbours with the smallest (k1 + k2) |s1 - s2|² become one with the
  mean stretch (k1 s1 + k2 s2)/(k1 + k2), which keeps Q. (Their union loses ½ k1 k2/(k1 + k2) |s1 - s2|²; the pair that loses
  least would nearly always be that of the new level, which a short step makes small, and the result would depend on the step.)
- A displacement is added to every stretch; Coulomb's limit reduces all of them in proportion.

Energy is never created, on any path [our derivation]. With one level Q falls with K_t and is kept where K_t rises, so that a
contact whose overlap vibrates loses its shear force; with two or three it follows the model with all springs. All zeros are a
contact without history; a level between equal bounds is empty. Twin: demlaws/cpp/demlaws_shear.h.
"""

import numpy as np

from demlaws.core.dispatch import gather, scatter, step
from demlaws.core.fastmath import sqrt
from demlaws.core.numba_compat import kernel, loop
from demlaws.core.shear import EMPTY, shear_stiffness


@kernel
def set_stiffness(bound, stretch, stiffness):
    """Move the bounds [N/m] of the levels to a new K_t; stretch: (2, levels) [m]."""
    top = bound.size - 1
    if stiffness <= bound[top]:
        for i in range(bound.size):
            bound[i] = min(bound[i], stiffness)
        return
    joined, least, below, empty = top, np.inf, 0.0, EMPTY * stiffness
    for i in range(bound.size):  # level i and the one above it, at last the new one
        width, above = bound[i] - below, (bound[i + 1] if i < top else stiffness) - bound[i]
        u, v = stretch[0, i], stretch[1, i]
        if i < top:
            u, v = u - stretch[0, i + 1], v - stretch[1, i + 1]
        apart = (width + above) * (u * u + v * v) if width > empty and above > empty else 0.0
        if apart < least:
            joined, least = i, apart
        below = bound[i]
    below = bound[joined - 1] if joined > 0 else 0.0
    upper = bound[joined + 1] if joined < top else stiffness
    share = (bound[joined] - below) / (upper - below) if upper > below else 0.0
    for axis in range(2):
        other = stretch[axis, joined + 1] if joined < top else 0.0
        stretch[axis, joined] = share * stretch[axis, joined] + (1.0 - share) * other
        for i in range(joined + 1, top):
            stretch[axis, i] = stretch[axis, i + 1]
        if joined < top:
            stretch[axis, top] = 0.0
    for i in range(joined, top):
        bound[i] = bound[i + 1]
    bound[top] = stiffness


@kernel
def levels_force(bound, stretch):
    """Both shear forces [N] and the stored energy [J]."""
    first, second, stored, below = 0.0, 0.0, 0.0, 0.0
    for i in range(bound.size):
        width, u, v = bound[i] - below, stretch[0, i], stretch[1, i]
        first, second, stored = first + width * u, second + width * v, stored + 0.5 * width * (u * u + v * v)
        below = bound[i]
    return first, second, stored


@kernel
def shortened(u, v, limit):
    """A force (u, v) [N], at most `limit`, and its share that is left."""
    size = sqrt(u * u + v * v)
    share = limit / size if size > limit else 1.0
    return u * share, v * share, share


@kernel
def move(bound, stretch, stiffness, du, dv, limit):
    """One step, by K_t now, a displacement (du, dv) [m] and Coulomb's limit [N]: both shear forces [N], work and stored energy
    [J].

    The work is the mean of the forces before and after the step times the displacement. So that no step loses less than
    nothing, springs of the stiffness k that open carry ¼ k d² more, d² = du² + dv², at most the work of Coulomb's limit or of
    the force before over d/2, and where a step turns the force round the one before is at most the limit, which may have
    fallen. [our derivation]
    """
    first, second, _ = levels_force(bound, stretch)
    opened = max(bound[bound.size - 1] - stiffness, 0.0)
    work = 0.5 * (first * du + second * dv)
    moves, largest = du * du + dv * dv, max(limit * limit, first * first + second * second)
    set_stiffness(bound, stretch, stiffness)
    held_u, held_v, _ = levels_force(bound, stretch)
    for i in range(bound.size):
        stretch[0, i] += du
        stretch[1, i] += dv
    first, second, stored = levels_force(bound, stretch)
    turned = held_u * first + held_v * second < 0.0
    first, second, share = shortened(first, second, limit)
    if turned:
        work -= 0.5 * (1.0 - shortened(held_u, held_v, limit)[2]) * (held_u * du + held_v * dv)
    if share < 1.0:
        for i in range(bound.size):
            stretch[0, i] *= share
            stretch[1, i] *= share
    work += 0.5 * (first * du + second * dv)
    if opened > 0.0:
        work += 0.25 * opened * moves if opened * opened * moves <= 4.0 * largest else 0.5 * sqrt(largest * moves)
    return first, second, work, stored * share * share


@loop
def levels_loop(choice, rule, shape, p, overlap, along, across, ratio, friction, state, bound, stretch, results):
    """One contact along a path of overlaps and displacements [m] in two directions of its tangent plane.

    choice: the normal stiffness to which K_t is proportional (`demlaws.core.shear`). friction: at each point. bound, stretch:
    (levels,) and (2, levels), moved on as `state`. results: (6, points) for normal force, that stiffness, both shear forces,
    work and stored energy of shear.
    """
    work = 0.0
    for n in range(overlap.size):
        force, tangent, new = step(rule, shape, p, overlap[n], gather(state, 0))
        scatter(state, 0, new)
        top = shear_stiffness(choice, rule, shape, p, overlap[n], force, tangent, new) if overlap[n] > 0.0 else 0.0
        touches = n > 0 and overlap[n] > 0.0
        du = along[n] - along[n - 1] if touches else 0.0
        dv = across[n] - across[n - 1] if touches else 0.0
        limit = friction[n] * force if force > 0.0 else 0.0
        first, second, step_work, stored = move(bound, stretch, ratio * top, du, dv, limit)
        work += step_work
        results[0, n], results[1, n] = force, top
        results[2, n], results[3, n] = first, second
        results[4, n], results[5, n] = work, stored
