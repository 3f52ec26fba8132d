"""Partial slip of one contact: a row of springs, which creates no energy.

The method of dimensionality reduction (Popov & Heß 2015, Method of Dimensionality Reduction in Contact Mechanics
and Friction) replaces a contact by independent springs. A spring that touches at overlap z has the normal stiffness
dK = P''(z) dz. Here a spring is named by κ = K(z), the stiffness of the contact when the spring touched, so that springs have
equal stiffness and keep their place when the unloading curve moves [our derivation]:

- The springs with κ below the stiffness K with which the contact would unload now are in contact.
- Spring κ is compressed by c(κ) = δ - δ(κ), where δ(κ) is the overlap on that unloading curve at which its stiffness is κ. The
  compressions are scaled such that ∫ c dκ = P; for convex curves with P(0) = P'(0) = 0 the scale is 1.
- Its tangential stiffness is ratio dκ, its stretch at most μ c/ratio (Coulomb).
- A spring that touches is not stretched. A spring that opens loses its energy.

A stretch is a vector in the tangent plane; a spring slips along its trial stretch. With the work of a step taken as the mean of
the forces before and after it times the displacement, no step dissipates less than nothing, for any path.
"""

import numpy as np

from demlaws.core.dispatch import gather, scatter, step, unloaded
from demlaws.core.fastmath import sqrt
from demlaws.core.numba_compat import kernel, loop
from demlaws.core.shear import unloading_stiffness

SAMPLES = 512
"""Points at which `slip_loop` reads the unloading curve."""


@kernel
def stretched(u, v, du, dv, limit):
    """Stretch (u, v) of a spring after a displacement, at most `limit`; with the stretch before it, at most `limit`, too."""
    length = sqrt(u * u + v * v)
    if length > limit:  # the compression fell: slip without displacement
        u, v = u * (limit / length), v * (limit / length)
    new_u, new_v = u + du, v + dv
    length = sqrt(new_u * new_u + new_v * new_v)
    if length > limit:
        new_u, new_v = new_u * (limit / length), new_v * (limit / length)
    return u, v, new_u, new_v


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
def compress(curve, share, top, compression):
    """Fill `compression` [m] with the mean of each spring in contact. Returns the force [N] that they carry."""
    count, spring_force, j = 0, 0.0, 0
    while count < compression.size and count * share < top:
        low, high = count * share, min((count + 1) * share, top)
        width, total = high - low, 0.0
        while low < high:  # from piece to piece of the curve, on which compression is linear in stiffness
            end = min(curve[1, j], high)
            if end > low:
                depth = curve[0, max(j - 1, 0)]
                start = curve[1, j - 1] if j > 0 else 0.0
                slope = (curve[0, j] - depth) / (curve[1, j] - start)
                total += (end - low) * (depth + slope * (0.5 * (low + end) - start))
                low = end
            if low < high:
                j += 1
        compression[count] = max(total / width, 0.0)  # of a sliver, rounding could be negative
        spring_force += total
        count += 1
    return spring_force


@kernel
def slip_step(top, previous, share, force, ratio, friction, du, dv, compression, spring_force, stretch):
    """A step of a row of springs: both shear forces [N], and work and stored energy [J].

    top, previous: stiffness [N/m] with which the contact would unload, now and before the step; share: that of one spring;
    du, dv: displacement [m]; compression, spring_force: from `compress`; stretch: (2, springs), updated.
    """
    first, second, work, stored = 0.0, 0.0, 0.0, 0.0
    scale = force / spring_force if spring_force > 0.0 else 0.0
    for k in range(stretch.shape[1]):
        part, part_before = min(max(top / share - k, 0.0), 1.0), min(max(previous / share - k, 0.0), 1.0)
        if k * share >= top or part == 0.0:  # the first as in `compress`: rounding may let the second pass
            stretch[0, k] = stretch[1, k] = 0.0
            continue
        u, v = stretch[0, k], stretch[1, k]
        if part > part_before:
            u, v = u * (part_before / part), v * (part_before / part)
        stiffness = ratio * share * part
        before_u, before_v, u, v = stretched(u, v, du, dv, friction * compression[k] * scale / ratio)
        work += 0.5 * stiffness * ((before_u + u) * du + (before_v + v) * dv)
        stretch[0, k], stretch[1, k] = u, v
        first += stiffness * u
        second += stiffness * v
        stored += 0.5 * stiffness * (u * u + v * v)
    return first, second, work, stored


@loop
def slip_loop(rule, shape, p, overlap, along, across, ratio, friction, largest, state, stretch, curve, results):
    """`levels.levels_loop` with a row of springs, by the stiffness with which the contact would unload.

    largest: stiffness [N/m] that the springs share equally, not below that of the contact at any point of the path. stretch:
    (2, springs) zeros. curve: (2, SAMPLES) for the unloading curve.
    """
    share = largest / stretch.shape[1]
    previous, work = 0.0, 0.0
    compression = np.empty(stretch.shape[1])
    for n in range(overlap.size):
        force, tangent, new = step(rule, shape, p, overlap[n], gather(state, 0))
        scatter(state, 0, new)
        top = max(unloading_stiffness(rule, shape, p, overlap[n], force, tangent, new), 0.0) if overlap[n] > 0.0 else 0.0
        spring_force = 0.0
        if top > 0.0:
            read_unloading_curve(rule, shape, p, overlap[n], new, top, curve)
            spring_force = compress(curve, share, top, compression)
        du = along[n] - along[n - 1] if n > 0 else 0.0
        dv = across[n] - across[n - 1] if n > 0 else 0.0
        first, second, step_work, stored = slip_step(
            top, previous, share, force, ratio, friction[n], du, dv, compression, spring_force, stretch
        )
        previous = top
        work += step_work
        results[0, n], results[1, n] = force, top
        results[2, n], results[3, n] = first, second
        results[4, n], results[5, n] = work, stored
