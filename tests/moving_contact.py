"""Two bodies that move as prescribed: forces and torques step by step, as an engine with half-step velocities must find them.

An implementation apart from that of demlaws, in numpy, for tests of the three engines. The first body is a sphere, a plane or a
triangle, the second one a sphere. Velocities v and spins ω belong to the half step before the positions at which forces are
wanted: x += v dt. Normal force and K_t come from a law of demlaws; the rest is here.

Of the contact with normal n (towards the second body), overlap δ and lever arms r1, r2 the displacement of a step is

    Δs = dt [v2 - v1 - (r1 ω1 + r2 ω2) × h + v_h (n - n_before)/2]    in the plane of n

with h, the unit vector along n - (n - n_before)/2, and the levers r of the half step, where v and ω are; v_h is the part of
v2 - v1 along h. The last term takes the velocity from the plane of h to that of n. [our derivation] A flat body has no r1;
its velocity at the contact has the lever c - x1, which the half step shifts by (c - x1)' dt/2 with c' = v2 - r2 n' - r2' n.
"""

from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp


class Motion(NamedTuple):
    """Positions [m] at the start, velocities [m/s] and spins [1/s] of two bodies: arrays (steps, 2, 3)."""

    start: np.ndarray
    velocity: np.ndarray
    spin: np.ndarray
    timestep: float


class Way(NamedTuple):
    """Conventions in which engines differ without being wrong."""

    lever: str = "contact"  # arms to the contact point (r - δ/2), or "radius": r, and v2 - v1 times (r1 + r2)/(r1 + r2 - δ)
    wall_share: float = 0.5  # place of the contact point with a flat: r2 - share δ from the sphere's centre
    first_share: float | None = None  # the same for the velocity of the flat itself; None: wall_share
    turn: str = "rotation"  # of springs: from normal to normal, then about n; "frame": components along a unit vector turned
    # by a - a × axis, twice, and across it
    first: bool = False  # the normal before the first contact is known
    by_speed: bool = False  # n - n_before of two spheres from the velocity of their centres over the distance of now
    half_step: bool = True  # False: all of the full step, as engines have it


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

    def __init__(self, way):
        self.way, self.before, self.first = way, None, None

    def to(self, now, angle):
        """Function that turns a vector from the plane of the last normal into that of `now`, and about it by an angle."""
        before = now if self.before is None else self.before
        self.before = now

        def crossed(a):
            a = a - np.cross(a, np.cross(before, now))
            return a - np.cross(a, angle * now)

        if self.way.turn == "rotation":
            return lambda a: rotation(angle * now) @ (a - (a @ now) * (before + now) / (1.0 + before @ now))
        if self.first is None:  # across the axis that is least along the normal
            self.first = np.cross(now, np.eye(3)[np.argmin(np.abs(now))])
            self.first /= np.linalg.norm(self.first)
        old = np.array([self.first, np.cross(before, self.first)])
        self.first = crossed(self.first)
        self.first -= (self.first @ now) * now
        self.first /= np.linalg.norm(self.first)
        new = np.array([self.first, np.cross(now, self.first)])
        return lambda a: new.T @ (old @ a)


def _change(way, first, motion, step, places, normal, before):
    """n - n_before in the plane of the normal."""
    if before is None or not way.half_step:
        return np.zeros(3)
    if way.by_speed and not first.flat:
        return motion.timestep * _across(motion.velocity[step, 1] - motion.velocity[step, 0], normal) / _distance(places)
    return _across(-before, normal)


def _across(vector, normal):
    return vector - (vector @ normal) * normal


def _distance(places):
    return np.linalg.norm(places[1] - places[0])


def _displacement(way, first, radius, motion, step, places, normal, change, overlap):
    """Δs of a step, in the plane of the normal."""
    (v1, v2), (w1, w2), dt = motion.velocity[step], motion.spin[step], motion.timestep
    lag, apart = 0.5 * dt * way.half_step, v2 - v1
    middle = (1.0 - 0.125 * change @ change) * (normal - 0.5 * change)
    if first.flat:
        foot_share = way.wall_share if way.first_share is None else way.first_share
        foot = radius - foot_share * overlap
        place = places[1] - places[0] - foot * normal  # of the contact, from the flat's position
        along = (apart - np.cross(w1, place)) @ (normal - 0.5 * change)
        arm = radius - way.wall_share * (overlap + lag * along)
        place = place - lag * apart + 0.5 * foot * change + lag * foot_share * along * normal
        apart = apart - np.cross(w1, place)
        relative = apart - np.cross(arm * w2, middle)
    else:
        total, then = first.radius + radius, overlap + lag * apart @ (normal - 0.5 * change)
        if way.lever == "radius":
            apart, then = total / (total - then) * apart, 0.0
        relative = apart - np.cross((first.radius - 0.5 * then) * w1 + (radius - 0.5 * then) * w2, middle)
    return dt * (_across(relative, normal) + 0.5 * apart @ (normal - 0.5 * change) * change)


def follow(first, radius, motion, law, *, ratio, friction, way=None, levels=3, springs=None, damping=None, shear="elastic"):
    """Forces on `first` and on a sphere of this radius along a motion.

    law: of one contact, with its rule. ratio: K_t/K, shear: of which K. damping: None, or mass m [kg], β_n and β_s of viscous
    forces 2 β √(m K) v with K_t and 1.5 P/δ, with the springs' at most Coulomb's limit. springs: another model of shear, in
    place of `Levels(levels)`, with its methods.
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
    model, turn = springs or Levels(levels), _Turn(way)
    for step in range(steps):
        normal, point = geometry[step]
        if overlap[step] <= 0.0:
            model.touch(0.0)
            turn = _Turn(way)
            turn.before = normal if way.first else None
            continue
        model.touch(stiffness[step])
        change = _change(way, first, motion, step, at[step], normal, turn.before)
        moved = _displacement(way, first, radius, motion, step, at[step], normal, change, overlap[step])
        angle = 0.5 * dt * (normal - 0.5 * change) @ motion.spin[step].sum(axis=0)
        if way.half_step:
            moved = rotation(0.5 * angle * normal) @ moved
        sideways = -model.displace(turn.to(normal, angle), moved)
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
            if np.linalg.norm(sideways + viscous) > limit:
                share = np.roots([viscous @ viscous, 2.0 * sideways @ viscous, size**2 - limit**2]).max()
                viscous = share * viscous
        total = along * normal + sideways + viscous  # on the second body
        force[step] = -total, total
        torque[step] = np.cross(point - at[step, 0], -total), np.cross(point - at[step, 1], total)
    return Forces(force, torque, overlap)


def _approach(motion, step, places, point, normal):
    """Velocity [m/s] at which the surfaces part."""
    (v1, v2), (w1, w2) = motion.velocity[step], motion.spin[step]
    return (v2 + np.cross(w2, point - places[1]) - v1 - np.cross(w1, point - places[0])) @ normal


def carried(place, spins, radii, time, lever="contact"):
    """The displacement [m] that a contact of two spheres keeps after a time, by integration: turned with it, without slip.

    place: time → second centre minus first one; spins: time → those of both; lever: as in `Way`.
    ds/dt = v - (r1 ω1 + r2 ω2) × n in the plane of n, and s turns with n and by the mean spin about it.
    """

    def rate(now, stretch):
        h = 1e-4
        far = [place(now + k * h) for k in (-2, -1, 1, 2)]
        velocity = (far[0] - 8 * far[1] + 8 * far[2] - far[3]) / (12 * h)
        apart, (first, second) = place(now), spins(now)
        distance = np.linalg.norm(apart)
        normal = apart / distance
        stretched = sum(radii) / distance if lever == "radius" else 1.0
        arms = (radii if lever == "radius" else radii - 0.5 * (sum(radii) - distance)) @ [first, second]
        surface = stretched * velocity - np.cross(arms, normal)
        turn = np.cross(normal, velocity) / distance + 0.5 * (first + second) @ normal * normal
        return surface - surface @ normal * normal + np.cross(turn, stretch)

    return solve_ivp(rate, (0.0, time), np.zeros(3), method="DOP853", rtol=1e-11, atol=1e-11).y[:, -1]


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
