"""Quasi-static motion of equal spheres in a periodic box, compiled once per law: the law's own step, shear and friction."""

import numpy as np

from demlaws.core.dispatch import gather, scatter, step
from demlaws.core.numba_compat import kernel, loop
from demlaws.core.shear import shear_stiffness


@kernel
def _strain(size, rate, results, stress, goal, feedback, fastest, dt):
    """Strain the box by one step toward the stresses of `goal`; results: stresses first, strains from 6 on."""
    volume = size[0] * size[1] * size[2]
    for a in range(3):
        results[a] = stress[a] / volume
        share = results[a] / goal[a] - 1.0 if goal[a] > 0.0 else 0.0
        wanted = feedback * share if share > -0.95 else -fastest
        rate[a] = min(max(wanted, -fastest), fastest)
        size[a] *= 1.0 + rate[a] * dt
        results[6 + a] += rate[a] * dt


@kernel
def _move(x, v, w, moved, force, torque, mass, inertia, drag, rate, dt):
    """Move all bodies by one step; returns the largest square of the distances moved and the sum of the forces."""
    farthest, unbalanced = 0.0, 0.0
    for i in range(x.shape[0]):
        far = 0.0
        unbalanced += np.sqrt(force[i, 0] ** 2 + force[i, 1] ** 2 + force[i, 2] ** 2)
        for a in range(3):
            v[i, a] += dt * (force[i, a] / mass - drag * v[i, a])
            w[i, a] += dt * (torque[i, a] / inertia - drag * w[i, a])
            x[i, a] += dt * (v[i, a] + rate[a] * x[i, a])
            moved[i, a] += dt * v[i, a]
            far += moved[i, a] ** 2
        farthest = max(farthest, far)
    return farthest, unbalanced


@loop
def march(choice, rule, p, state, steps, given, goal, size, bodies, pairs, contacts, results):
    """Move by `steps` at most; returns how many were done: fewer if a neighbour list may be incomplete.

    given: radius, mass, friction, K_t/K, drag [1/s], dt, feedback [1/s], largest strain rate [1/s], skin [m]. goal: normal
    stresses [Pa]; the box does not strain along an axis whose goal is 0. size: (3,). bodies: (5, n, 3) places, velocities
    beside the affine ones, spins, distances moved since the neighbours were found, and forces. pairs: (m, 5) both bodies and
    how many boxes the second one is shifted. contacts: (m, 6) shear force, normal force, K, the normal stiffness of shear.
    results: stresses (3), mean unbalanced force, mean contact force, largest K, strains (3).
    """
    radius, mass, friction, ratio, drag, dt, feedback, fastest, skin = given
    x, v, w, moved, force = bodies
    count, inertia = x.shape[0], 0.4 * mass * radius * radius
    torque, rate = np.zeros_like(x), np.zeros(3)
    for done in range(steps):
        force[:] = 0.0
        torque[:] = 0.0
        stress, normal_sum, touching, stiffest = np.zeros(3), 0.0, 0, 0.0
        for k in range(pairs.shape[0]):
            i, j = pairs[k, 0], pairs[k, 1]
            dx = x[j, 0] - x[i, 0] + pairs[k, 2] * size[0]
            dy = x[j, 1] - x[i, 1] + pairs[k, 3] * size[1]
            dz = x[j, 2] - x[i, 2] + pairs[k, 4] * size[2]
            square = dx * dx + dy * dy + dz * dz
            if square >= 4.0 * radius * radius:
                if contacts[k, 5] != 0.0:
                    contacts[k, :] = 0.0
                    new = step(rule, p, -radius, gather(state, k))[2]
                    scatter(state, k, new)
                continue
            distance = np.sqrt(square)
            overlap = 2.0 * radius - distance
            normal, tangent, new = step(rule, p, overlap, gather(state, k))
            scatter(state, k, new)
            side = shear_stiffness(choice, rule, p, overlap, normal, tangent, new)
            nx, ny, nz = dx / distance, dy / distance, dz / distance
            sx, sy, sz = w[i, 0] + w[j, 0], w[i, 1] + w[j, 1], w[i, 2] + w[j, 2]
            ux = v[j, 0] - v[i, 0] + rate[0] * dx - radius * (sy * nz - sz * ny)
            uy = v[j, 1] - v[i, 1] + rate[1] * dy - radius * (sz * nx - sx * nz)
            uz = v[j, 2] - v[i, 2] + rate[2] * dz - radius * (sx * ny - sy * nx)
            along, held = ux * nx + uy * ny + uz * nz, contacts[k, 0] * nx + contacts[k, 1] * ny + contacts[k, 2] * nz
            kt = ratio * side * dt
            qx = contacts[k, 0] - held * nx + kt * (ux - along * nx)
            qy = contacts[k, 1] - held * ny + kt * (uy - along * ny)
            qz = contacts[k, 2] - held * nz + kt * (uz - along * nz)
            shear, limit = np.sqrt(qx * qx + qy * qy + qz * qz), friction * normal
            share = limit / shear if shear > limit else 1.0
            qx, qy, qz = share * qx, share * qy, share * qz
            contacts[k, 0], contacts[k, 1], contacts[k, 2] = qx, qy, qz
            contacts[k, 3], contacts[k, 4], contacts[k, 5] = normal, tangent, side
            fx, fy, fz = normal * nx - qx, normal * ny - qy, normal * nz - qz
            torques = radius * (ny * qz - nz * qy), radius * (nz * qx - nx * qz), radius * (nx * qy - ny * qx)
            for a in range(3):
                force[j, a] += (fx, fy, fz)[a]
                force[i, a] -= (fx, fy, fz)[a]
                torque[i, a] += torques[a]
                torque[j, a] += torques[a]
                stress[a] += (fx, fy, fz)[a] * (dx, dy, dz)[a]
            normal_sum, touching, stiffest = normal_sum + normal, touching + 1, max(stiffest, tangent, side)
        _strain(size, rate, results, stress, goal, feedback, fastest, dt)
        farthest, unbalanced = _move(x, v, w, moved, force, torque, mass, inertia, drag, rate, dt)
        results[3], results[4], results[5] = unbalanced / count, normal_sum / max(touching, 1), stiffest
        strained = 2.0 * radius * (abs(results[6]) + abs(results[7]) + abs(results[8]))
        if 2.0 * np.sqrt(farthest) + 2.0 * strained > skin:
            return done + 1
    return steps
