"""Quasi-static motion of equal spheres, or of clumps of them, in a periodic box, compiled once per law.

Contacts take the law's own step, shear and friction. A clump moves with one moment of inertia, about every axis: states of
balance do not depend on it.
"""

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
def _cross(ax, ay, az, bx, by, bz):
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


@kernel
def _move(bodies, torque, mass, inertia, drag, rate, dt):
    """Move all bodies by one step; returns the largest square of the distances moved and the sum of the forces."""
    x, v, w, moved, force = bodies
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


@kernel
def _turn(arms, owner, w, turned, dt):
    """Turn the arms of all clumps by one step; returns the longest way of a sphere about its clump's centre."""
    farthest = 0.0
    for i in range(arms.shape[0]):
        tx, ty, tz = 0.5 * dt * w[owner[i], 0], 0.5 * dt * w[owner[i], 1], 0.5 * dt * w[owner[i], 2]
        ax, ay, az = _cross(tx, ty, tz, arms[i, 0], arms[i, 1], arms[i, 2])
        bx, by, bz = _cross(tx, ty, tz, ax, ay, az)
        share = 2.0 / (1.0 + tx * tx + ty * ty + tz * tz)  # a rotation: the arm keeps its length
        arms[i, 0] += share * (ax + bx)
        arms[i, 1] += share * (ay + by)
        arms[i, 2] += share * (az + bz)
        turned[i] += share * np.sqrt(ax * ax + ay * ay + az * az)
        farthest = max(farthest, turned[i])
    return farthest


@kernel
def _push(i, j, push, levers, force, torque):
    """Add the force of a contact on body `j`, the opposite one on body `i`, and their moments."""
    on_i = _cross(levers[0, 0], levers[0, 1], levers[0, 2], push[0], push[1], push[2])
    on_j = _cross(levers[1, 0], levers[1, 1], levers[1, 2], push[0], push[1], push[2])
    for a in range(3):
        force[j, a] += push[a]
        force[i, a] -= push[a]
        torque[i, a] -= on_i[a]
        torque[j, a] += on_j[a]


@loop
def march(choice, rule, shape, p, state, steps, given, goal, size, bodies, owner, arms, turned, pairs, contacts, results):
    """Move by `steps` at most; returns how many were done: fewer if a neighbour list may be incomplete.

    given: radius of the spheres, mass, inertia of a body, friction, K_t/K, drag [1/s], dt, feedback [1/s], largest strain rate
    [1/s], skin [m]. goal: normal stresses [Pa]; the box does not strain along an axis whose goal is 0. size: (3,). bodies:
    (5, n, 3) places, velocities beside the affine ones, spins, distances moved since the neighbours were found, and forces.
    owner, arms, turned: the body of each sphere, its place there, its way about the centre since the neighbours were found.
    pairs: (m, 5) both spheres and how many boxes the second body is shifted. contacts: (m, 6) shear force, normal force, K, the
    normal stiffness of shear. results: stresses (3), mean unbalanced force, mean contact force, largest K, strains (3).
    """
    radius, mass, inertia, friction, ratio, drag, dt, feedback, fastest, skin = given
    x, v, w, _, force = bodies
    count = x.shape[0]
    torque, rate = np.zeros_like(x), np.zeros(3)
    for done in range(steps):
        force[:] = 0.0
        torque[:] = 0.0
        stress, normal_sum, touching, stiffest = np.zeros(3), 0.0, 0, 0.0
        for k in range(pairs.shape[0]):
            i, j = owner[pairs[k, 0]], owner[pairs[k, 1]]
            first, second = arms[pairs[k, 0]], arms[pairs[k, 1]]
            lx = x[j, 0] - x[i, 0] + pairs[k, 2] * size[0]  # from body to body
            ly = x[j, 1] - x[i, 1] + pairs[k, 3] * size[1]
            lz = x[j, 2] - x[i, 2] + pairs[k, 4] * size[2]
            dx, dy, dz = lx + second[0] - first[0], ly + second[1] - first[1], lz + second[2] - first[2]
            square = dx * dx + dy * dy + dz * dz
            if square >= 4.0 * radius * radius:
                if contacts[k, 5] != 0.0:
                    contacts[k, :] = 0.0
                    scatter(state, k, step(rule, shape, p, -radius, gather(state, k))[2])
                continue
            distance = np.sqrt(square)
            overlap = 2.0 * radius - distance
            normal, tangent, new = step(rule, shape, p, overlap, gather(state, k))
            scatter(state, k, new)
            side = shear_stiffness(choice, rule, shape, p, overlap, normal, tangent, new)
            nx, ny, nz = dx / distance, dy / distance, dz / distance
            levers = np.empty((2, 3))
            for a in range(3):
                levers[0, a] = first[a] + radius * (nx, ny, nz)[a]
                levers[1, a] = second[a] - radius * (nx, ny, nz)[a]
            sx, sy, sz = _cross(w[j, 0], w[j, 1], w[j, 2], levers[1, 0], levers[1, 1], levers[1, 2])
            tx, ty, tz = _cross(w[i, 0], w[i, 1], w[i, 2], levers[0, 0], levers[0, 1], levers[0, 2])
            ux = v[j, 0] - v[i, 0] + rate[0] * lx + sx - tx
            uy = v[j, 1] - v[i, 1] + rate[1] * ly + sy - ty
            uz = v[j, 2] - v[i, 2] + rate[2] * lz + sz - tz
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
            push = normal * nx - qx, normal * ny - qy, normal * nz - qz
            _push(i, j, push, levers, force, torque)
            for a in range(3):
                stress[a] += push[a] * (lx, ly, lz)[a]
            normal_sum, touching, stiffest = normal_sum + normal, touching + 1, max(stiffest, tangent, side)
        _strain(size, rate, results, stress, goal, feedback, fastest, dt)
        farthest, unbalanced = _move(bodies, torque, mass, inertia, drag, rate, dt)
        about = _turn(arms, owner, w, turned, dt)
        results[3], results[4], results[5] = unbalanced / count, normal_sum / max(touching, 1), stiffest
        strained = 2.0 * radius * (abs(results[6]) + abs(results[7]) + abs(results[8]))
        if 2.0 * (np.sqrt(farthest) + about + strained) > skin:
            return done + 1
    return steps
