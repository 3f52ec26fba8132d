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

from demlaws.core.dispatch import gather, scatter, step
from demlaws.core.fastmath import sqrt
from demlaws.core.numba_compat import kernel, loop
from demlaws.core.shear import EMPTY, shear_stiffness
from demlaws.core.vectors import assign, dot, minus_scaled, scaled, vector


@kernel
def _width(bound, level):
    return bound[level] - bound[level - 1] if level > 0 else bound[0]


@kernel
def force_of_levels(bound, stretch):
    """Elastic shear force [N]; bound: (levels,) [N/m]; stretch: (levels, 3) [m]."""
    force = (0.0, 0.0, 0.0)
    for level in range(len(bound)):
        force = minus_scaled(force, -_width(bound, level), vector(stretch[level]))
    return force


@kernel
def energy_of_levels(bound, stretch):
    """Stored energy [J]."""
    energy = 0.0
    for level in range(len(bound)):
        here = vector(stretch[level])
        energy += 0.5 * _width(bound, level) * dot(here, here)
    return energy


@kernel
def _push_level(bound, stretch, stiffness):
    """K_t rises to `stiffness` [N/m]: a level without stretch on top; the two nearest neighbours become one. Their loss [J]."""
    count, rest = len(bound), (0.0, 0.0, 0.0)
    joined, least, lower, upper, below, empty, gap = 0, 0.0, 0.0, 0.0, 0.0, EMPTY * stiffness, 0.0
    for level in range(count):
        here, above = bound[level], bound[level + 1] if level + 1 < count else stiffness
        apart = minus_scaled(vector(stretch[level]), 1.0, vector(stretch[level + 1]) if level + 1 < count else rest)
        square = dot(apart, apart)
        distance = (above - below) * square if here - below > empty and above - here > empty else 0.0
        if level == 0 or distance < least:
            joined, least, lower, upper, gap = level, distance, here - below, above - here, square
        below = here
    both = lower + upper
    part = upper / both if both > 0.0 else 0.0
    for level in range(count):  # without a branch, which a processor would often guess wrong
        share = 0.0 if level < joined else part if level == joined else 1.0
        above_it = vector(stretch[level + 1]) if level + 1 < count else rest
        assign(stretch[level], minus_scaled(scaled(1.0 - share, vector(stretch[level])), -share, above_it))
        above = bound[level + 1] if level + 1 < count else stiffness
        bound[level] = bound[level] if level < joined else above
    return 0.5 * lower * part * gap


@kernel
def _cut_levels(bound, stretch, stiffness):
    """K_t falls to `stiffness` [N/m]: the springs that touched above it open. Their energy [J]."""
    loss, below, below_now = 0.0, 0.0, 0.0
    for level in range(len(bound)):
        here, old = vector(stretch[level]), bound[level]
        now = min(old, stiffness)
        loss += 0.5 * ((old - below) - (now - below_now)) * dot(here, here)
        bound[level], below, below_now = now, old, now
    return loss


@kernel
def follow_stiffness(bound, stretch, stiffness):
    """Move the bounds of the levels to a new K_t [N/m]; the energy [J] that is lost."""
    if stiffness > bound[len(bound) - 1]:
        return _push_level(bound, stretch, stiffness)
    return _cut_levels(bound, stretch, stiffness)


@kernel
def scale_levels(stretch, share):
    """Reduce all stretches to a share."""
    for level in range(len(stretch)):
        assign(stretch[level], scaled(share, vector(stretch[level])))


@kernel
def _share_within(force, limit):
    """What is left of a force [N] that is at most `limit` long."""
    size = sqrt(dot(force, force))
    return limit / size if size > limit else 1.0


@kernel
def move(bound, stretch, stiffness, displacement, limit):
    """One step, by K_t now, a displacement [m] and Coulomb's limit [N]: shear force [N], work and stored energy [J].

    The work is the mean of the forces before and after the step times the displacement. So that no step loses less than
    nothing, springs of the stiffness k that open carry ¼ k d² more, d the displacement, at most the work of Coulomb's limit or
    of the force before over d/2, and where a step turns the force round the one before is at most the limit, which may have
    fallen. [our derivation]
    """
    before = force_of_levels(bound, stretch)
    opened = max(bound[bound.size - 1] - stiffness, 0.0)
    work = 0.5 * dot(before, displacement)
    moves, largest = dot(displacement, displacement), max(limit * limit, dot(before, before))
    follow_stiffness(bound, stretch, stiffness)
    held = force_of_levels(bound, stretch)
    for level in range(len(bound)):
        assign(stretch[level], minus_scaled(vector(stretch[level]), -1.0, displacement))
    force = force_of_levels(bound, stretch)
    if dot(held, force) < 0.0:
        work -= 0.5 * (1.0 - _share_within(held, limit)) * dot(held, displacement)
    share = _share_within(force, limit)
    if share < 1.0:
        scale_levels(stretch, share)
        force = scaled(share, force)
    work += 0.5 * dot(force, displacement)
    if opened > 0.0:
        work += 0.25 * opened * moves if opened * opened * moves <= 4.0 * largest else 0.5 * sqrt(largest * moves)
    return force, work, energy_of_levels(bound, stretch)


@loop
def levels_loop(choice, rule, shape, p, overlap, along, across, ratio, friction, state, bound, stretch, results):
    """One contact along a path of overlaps and displacements [m] in two directions of its tangent plane.

    choice: the normal stiffness to which K_t is proportional (`demlaws.core.shear`). friction: at each point. bound, stretch:
    (levels,) and (levels, 3), moved on as `state`. results: (6, points) for normal force, that stiffness, both shear forces,
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
        sheared, step_work, stored = move(bound, stretch, ratio * top, (du, dv, 0.0), limit)
        work += step_work
        results[0, n], results[1, n] = force, top
        results[2, n], results[3, n] = sheared[0], sheared[1]
        results[4, n], results[5, n] = work, stored
