"""Two bodies that move as prescribed: forces and torques step by step, as an engine with half-step velocities must find them.

An implementation apart from that of demlaws, in numpy, for tests of the three engines. The first body is a sphere, a plane or a
triangle, the second one a sphere. Velocities v and spins ω belong to the half step before the positions at which forces are
wanted: x += v dt. Normal force and K_t come from a law of demlaws; the rest is here.

Of the contact with normal n (towards the second body), overlap δ and lever arms r1, r2 the displacement of a step is

    Δs = dt v_t + (dt/2) (r1 ω1 + r2 ω2) × (n - n_before)

with v the velocity of the second surface against the first one with today's n, both parts in the plane of n. The second term
takes the lever to the half step, where ω is. [our derivation] A flat body has no r1; its velocity at the contact has the lever
c - x1, which the half step shifts by (c - x1)' dt/2 with c' = v2 - r2 n'.
"""

from typing import NamedTuple

import numpy as np


class Motion(NamedTuple):
    """Positions [m] at the start, velocities [m/s] and spins [1/s] of two bodies: arrays (steps, 2, 3)."""

    start: np.ndarray
    velocity: np.ndarray
    spin: np.ndarray
    timestep: float


class Way(NamedTuple):
    """Conventions in which engines differ without being wrong."""

    lever: str = "contact"  # arms to the contact point (r - δ/2), or "radius": r, and v2 - v1 times (r1 + r2)/(r1 + r2 - δ)
    stretched: bool = True  # False: v2 - v1 as it is with "radius", too
    term_lever: str = "contact"  # the same of the half-step term
    wall_share: float = 0.5  # place of the contact point with a flat: r2 - share δ from the sphere's centre
    first_share: float | None = None  # the same for the velocity of the flat itself; None: wall_share
    turn: str = "plane"  # of springs: projected with their length kept and turned about n; "cross": a - a × axis, twice;
    # "frame": components along a unit vector turned by "cross" and across it; "rotation": from normal to normal, then about n
    spin_about: str = "before"  # the normal about which bodies spin, or "now"
    first: bool = False  # the normal before the first contact is known
    by_speed: bool = False  # n - n_before of two spheres from the velocity of their centres over the distance of now
    half_turn: bool = False  # the displacement of a step turns about n by half of the angle of the springs
    half_step: bool = True  # False: as engines have it, without the term


class Forces(NamedTuple):
    """Forces [N] and torques [N m] on both bodies, (steps, 2, 3), and the overlap [m]."""

    force: np.ndarray
    torque: np.ndarray
    overlap: np.ndarray


# --- geometry


def rotation(vector):
    """Matrix of the rotation by |vector| about it."""
    angle = np.linalg.norm(vector)
    if angle == 0.0:
        return np.eye(3)
    x, y, z = vector / angle
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * skew + (1.0 - np.cos(angle)) * skew @ skew


def nearest(triangle, point):
    """The point of a triangle (3, 3) nearest to a point."""
    a, b, c = triangle
    normal = np.cross(b - a, c - a)
    foot = point - normal * ((point - a) @ normal / (normal @ normal))
    if all(np.cross(q - p, foot - p) @ normal >= 0.0 for p, q in ((a, b), (b, c), (c, a))):
        return foot
    ends = [(p, q - p) for p, q in ((a, b), (b, c), (c, a))]
    candidates = [p + e * min(max((point - p) @ e / (e @ e), 0.0), 1.0) for p, e in ends]
    return min(candidates, key=lambda candidate: np.linalg.norm(point - candidate))


class _Sphere:
    flat = False

    def __init__(self, radius):
        self.radius = radius

    def normal_and_overlap(self, position, turned, other, radius):
        apart = other - position
        distance = np.linalg.norm(apart)
        return apart / distance, self.radius + radius - distance


class _Plane:
    """A plane through its position, which does not turn."""

    flat, radius = True, 0.0

    def __init__(self, normal):
        self.normal = np.asarray(normal, float)

    def normal_and_overlap(self, position, turned, other, radius):
        return self.normal, radius - (other - position) @ self.normal


class _Triangle:
    """Corners relative to the position; it turns with its spin."""

    flat, radius = True, 0.0

    def __init__(self, corners):
        self.corners = np.asarray(corners, float)

    def normal_and_overlap(self, position, turned, other, radius):
        apart = other - nearest(position + self.corners @ turned.T, other)
        distance = np.linalg.norm(apart)
        return apart / distance, radius - distance


sphere, plane, triangle = _Sphere, _Plane, _Triangle


# --- shear


class Levels:
    """Springs ordered by the K_t at which they touched, in a few levels: a list of [stiffness, stretch], the oldest first."""

    def __init__(self, count):
        self.count, self.levels = count, []

    def touch(self, stiffness):
        """K_t is now `stiffness` [N/m]."""
        rest, kept = stiffness, []
        for width, stretch in self.levels:
            if rest > 0.0 and width > 0.0:
                kept.append([min(width, rest), stretch])
                rest -= width
        if rest > 0.0:
            kept.append([rest, np.zeros(3)])
        while len(kept) > self.count:
            pairs = [(kept[i], kept[i + 1]) for i in range(len(kept) - 1)]
            costs = [
                0.0 if min(a[0], b[0]) <= 1e-9 * stiffness else (a[0] + b[0]) * np.sum((a[1] - b[1]) ** 2) for a, b in pairs
            ]
            i = int(np.argmin(costs))
            a, b = pairs[i]
            kept[i : i + 2] = [[a[0] + b[0], (a[0] * a[1] + b[0] * b[1]) / (a[0] + b[0])]]
        self.levels = kept

    def displace(self, turn, displacement):
        """Turn the stretches, add a displacement [m]; the force [N]."""
        for level in self.levels:
            level[1] = turn(level[1]) + displacement
        return sum((width * stretch for width, stretch in self.levels), np.zeros(3))

    def shorten(self, share):
        for level in self.levels:
            level[1] = share * level[1]


class _Turn:
    """Turns tangential vectors with the contact from one step to the next."""

    def __init__(self, way, timestep):
        self.way, self.timestep, self.before, self.first = way, timestep, None, None

    def to(self, now, spins):
        """Function that turns a vector from the plane of the last normal into that of `now`."""
        before = now if self.before is None else self.before
        spun = now if self.way.spin_about == "now" else before
        axis, angle = np.cross(before, now), 0.5 * self.timestep * spun @ (spins[0] + spins[1])
        self.before = now

        def crossed(a):
            a = a - np.cross(a, axis)
            return a - np.cross(a, angle * before)

        def projected(a):
            flat = a - (a @ now) * now
            old, new = np.linalg.norm(a), np.linalg.norm(flat)
            return rotation(angle * now) @ (flat * (old / new) if new > 0.0 else flat)

        def rotated(a):
            return rotation(angle * now) @ (a - (a @ now) * (before + now) / (1.0 + before @ now))

        if self.way.turn == "rotation":
            return rotated
        if self.way.turn != "frame":
            return crossed if self.way.turn == "cross" else projected
        if self.first is None:  # across the axis that is least along the normal
            self.first = np.cross(now, np.eye(3)[np.argmin(np.abs(now))])
            self.first /= np.linalg.norm(self.first)
        old = np.array([self.first, np.cross(before, self.first)])
        self.first = crossed(self.first)
        self.first -= (self.first @ now) * now
        self.first /= np.linalg.norm(self.first)
        new = np.array([self.first, np.cross(now, self.first)])
        return lambda a: new.T @ (old @ a)


def _displacement(way, first, radius, motion, step, places, point, normal, before, overlap):
    """Δs of a step, in the plane of the normal."""
    (v1, v2), (w1, w2), dt = motion.velocity[step], motion.spin[step], motion.timestep
    arm1, arm2 = point - places[0], point - places[1]
    foot = radius - overlap * (way.wall_share if way.first_share is None else way.first_share)
    if first.flat:
        arm1 = places[1] - foot * normal - places[0]
    if way.lever == "radius":
        share = (first.radius + radius) / (first.radius + radius - overlap) if way.stretched else 1.0
        relative = share * (v2 - v1) - np.cross(first.radius * w1 + radius * w2, normal)
    else:
        relative = v2 + np.cross(w2, arm2) - v1 - np.cross(w1, arm1)
    result = dt * relative
    if way.half_step and before is not None:
        change = np.cross(np.cross(before, normal), normal)  # of n, in its plane
        if way.by_speed and not first.flat:
            change = dt * (v2 - v1 - ((v2 - v1) @ normal) * normal) / np.linalg.norm(places[1] - places[0])
        r2 = radius if way.term_lever == "radius" else np.linalg.norm(arm2)
        r1 = first.radius if way.term_lever == "radius" else np.linalg.norm(arm1)
        if first.flat:
            behind = r2 if way.first_share is None else foot
            shift = 0.5 * dt * (np.cross(w1, dt * (v2 - v1) - behind * change) + r2 * np.cross(w2, change))
        else:
            shift = 0.5 * dt * np.cross(r1 * w1 + r2 * w2, change)
        result = result + shift
    return result - (result @ normal) * normal


def follow(first, radius, motion, law, *, ratio, friction, way=None, levels=3, springs=None, damping=None, shear="elastic"):
    """Forces on `first` and on a sphere of this radius along a motion.

    law: of one contact, with its rule. ratio: K_t/K, shear: of which K. damping: None, or mass m [kg], β_n and β_s of viscous
    forces 2 β √(m K) v with K_t and 1.5 P/δ. springs: another model of shear in place of `Levels(levels)`, with its methods.
    """
    way, dt, steps = way or Way(), motion.timestep, len(motion.velocity)
    places, turned = np.array(motion.start, float), np.eye(3)
    geometry, overlap, at = [], np.empty(steps), np.empty((steps, 2, 3))
    for step in range(steps):
        places = places + dt * motion.velocity[step]
        turned = rotation(dt * motion.spin[step, 0]) @ turned
        normal, overlap[step] = first.normal_and_overlap(places[0], turned, places[1], radius)
        share = way.wall_share if first.flat else 0.5
        point = places[1] - (radius - share * overlap[step]) * normal
        geometry.append((normal, point))
        at[step] = places
    normal_force, stiffness = law.follow(overlap).force, law.shear_stiffness(overlap, ratio, shear)
    force, torque = np.zeros((steps, 2, 3)), np.zeros((steps, 2, 3))
    model, turn = springs or Levels(levels), _Turn(way, dt)
    for step in range(steps):
        normal, point = geometry[step]
        if overlap[step] <= 0.0:
            model.touch(0.0)
            turn = _Turn(way, dt)
            turn.before = normal if way.first else None
            continue
        model.touch(stiffness[step])
        moved = _displacement(way, first, radius, motion, step, at[step], point, normal, turn.before, overlap[step])
        if way.half_turn:
            moved = rotation(0.25 * dt * normal @ motion.spin[step].sum(axis=0) * normal) @ moved
        sideways = -model.displace(turn.to(normal, motion.spin[step]), moved)
        along, viscous = normal_force[step], np.zeros(3)
        if damping is not None:
            mass, along_beta, sideways_beta = damping
            approach = _approach(motion, step, at[step], point, normal)
            along -= min(2.0 * along_beta * np.sqrt(mass * 1.5 * along / overlap[step]) * approach, along)
        size, limit = np.linalg.norm(sideways), friction * abs(along)
        if size > limit:
            model.shorten(limit / size)
            sideways = sideways * (limit / size)
        elif damping is not None:
            viscous = -2.0 * sideways_beta * np.sqrt(mass * stiffness[step]) / dt * moved
        total = along * normal + sideways + viscous  # on the second body
        force[step] = -total, total
        torque[step] = np.cross(point - at[step, 0], -total), np.cross(point - at[step, 1], total)
    return Forces(force, torque, overlap)


def _approach(motion, step, places, point, normal):
    """Velocity [m/s] at which the surfaces part."""
    (v1, v2), (w1, w2) = motion.velocity[step], motion.spin[step]
    return (v2 + np.cross(w2, point - places[1]) - v1 - np.cross(w1, point - places[0])) @ normal


# --- a path


class Leg(NamedTuple):
    """A part of a path, as totals: the overlap at its end over that of the path; displacement of the second centre in the plane
    of the contact [overlaps]; angles by which the bodies turn, in the frame of the contact (its normal is the third axis);
    angle vector by which everything turns as one body."""

    overlap: float = 1.0
    shift: tuple = (0.0, 0.0)
    first: tuple = (0.0, 0.0, 0.0)
    second: tuple = (0.0, 0.0, 0.0)
    whole: tuple = (0.0, 0.0, 0.0)


def legs(first, radius, overlap):
    """Approach, slide, roll, twist, turn as a whole by 180° about two axes, and back, with the overlap changed on the way."""
    other = first.radius
    roll = 0.2 * (other + radius) / overlap  # way of the second centre, in overlaps
    spin = 0.2 * (other + radius - overlap * bool(other)) / (radius - 0.5 * overlap)  # with which it rolls
    twist = 0.3 if other else 0.0
    turns = 0.0 if isinstance(first, plane) else np.pi
    return [
        Leg(overlap=1.0),
        Leg(shift=(0.15, 0.1), overlap=1.1),
        Leg(shift=(roll, 0.0), second=(0.0, spin, 0.0)),
        Leg(second=(0.0, 0.0, 0.7), first=(0.0, 0.0, twist), overlap=0.9),
        Leg(shift=(0.5 * roll, -0.3 * roll), second=(0.3 * spin, 0.5 * spin, 0.9), first=(0.0, 0.0, twist)),
        Leg(shift=(0.1, -0.1), whole=(0.12 * turns, 0.96 * turns, -np.sqrt(1.0 - 0.936) * turns)),
        Leg(whole=(turns, 0.0, 0.0), second=(0.0, 0.0, 0.6)),
        Leg(shift=(-1.0, 0.5), overlap=0.4),
        Leg(shift=(-roll, 0.2 * roll), second=(-0.2 * spin, -1.001 * spin, -0.4), overlap=1.3),
        Leg(shift=(0.0, -3.0), overlap=0.6),
        Leg(overlap=-0.1),
        Leg(shift=(0.2, 0.0), overlap=0.8),
    ]


def motion(first, radius, overlap, steps=60, timestep=1e-6, path=None, start=None):
    """`Motion` along `legs` (or other ones), so many steps each, from just before contact.

    The frame of the contact starts as that of the space, with the first body at `start` (the origin)."""
    frame, gap = np.eye(3), -0.05 * overlap
    origin = np.zeros(3) if start is None else np.asarray(start, float)
    depth = gap
    places = np.array([origin, origin + (first.radius + radius - depth) * frame[:, 2]])
    begin, velocities, spins = places.copy(), [], []
    for leg in path or legs(first, radius, overlap):
        last, total = depth, leg.overlap * overlap
        for step in range(1, steps + 1):
            whole = np.array(leg.whole) / steps
            turn, half = rotation(whole), rotation(0.5 * whole)
            old, middle = places, half @ frame
            shift = np.array(leg.shift) * overlap / steps
            apart = places[1] - places[0]
            new_depth = last + (total - last) * step / steps
            if first.flat:
                apart = turn @ (apart + frame[:, :2] @ shift - (new_depth - depth) * frame[:, 2])
                frame = turn @ frame
            else:
                angle = frame[:, :2] @ (np.array([-shift[1], shift[0]]) / (first.radius + radius))
                frame = turn @ rotation(angle) @ frame
                apart = (first.radius + radius - new_depth) * frame[:, 2]
            depth = new_depth
            base = origin + turn @ (places[0] - origin)
            places = np.array([base, base + apart])
            velocities.append((places - old) / timestep)
            own = np.array([leg.first, leg.second]) @ middle.T / steps
            spins.append((own + whole) / timestep)
    return Motion(begin, np.array(velocities), np.array(spins), timestep)
