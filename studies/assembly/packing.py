"""A periodic packing of equal spheres with a contact law: compression, and the contacts that carry it."""

import math
from typing import NamedTuple

import numpy as np

from demlaws.core.shear import CHOICES
from demlaws.errors import DemlawsError
from studies.assembly.march import march

TRIANGLE = 23.0 / 30.0 * np.array([[1.0, 0.0, 0.0], [-0.5, 0.75**0.5, 0.0], [-0.5, -(0.75**0.5), 0.0]])
"""Places of the three spheres of a clump over their radius: the shape of `studies.ballast.bed`."""
DISTINCT = 0.863
"""Volume of these spheres, which overlap, over the sum of their volumes."""


class Bead(NamedTuple):
    """Size of a sphere, its material, and whether three of them are a clump; roughness belongs to the law."""

    diameter: float  # [m]
    young: float  # [Pa]
    poisson: float
    density: float  # [kg/m³]
    friction: float
    clump: bool = False  # three such spheres

    @property
    def arms(self):
        """Places of its spheres [m] about its centre."""
        return 0.5 * self.diameter * TRIANGLE if self.clump else np.zeros((1, 3))

    @property
    def volume(self):
        """Volume [m³]."""
        return (3.0 * DISTINCT if self.clump else 1.0) * math.pi * self.diameter**3 / 6.0

    @property
    def mass(self):
        """Mass [kg]."""
        return self.density * self.volume

    @property
    def inertia(self):
        """Moment of inertia [kg m²], of a clump the mean of all axes."""
        return self.mass * (0.1 * self.diameter**2 + 2.0 / 3.0 * float(np.sum(self.arms[0] ** 2)))

    @property
    def shear_ratio(self):
        """K_t/K (Mindlin)."""
        return 2.0 * (1.0 - self.poisson) / (2.0 - self.poisson)


class Contacts(NamedTuple):
    """Contacts that carry load."""

    pairs: np.ndarray  # (n, 2), spheres
    normals: np.ndarray  # (n, 3), from the first sphere to the second
    length: np.ndarray  # between the centres [m]
    force: np.ndarray  # normal [N]
    stiffness: np.ndarray  # K of the branch on which the contact is [N/m]
    unloading: np.ndarray  # K of unloading [N/m]
    shear: np.ndarray  # shear force over μ times the normal force
    owner: np.ndarray | None = None  # of clumps: the body of each sphere
    arms: np.ndarray | None = None  # of clumps: places of the spheres about the centres, over their radius
    radius: float = 0.0  # of the spheres of clumps [m]

    @property
    def branch(self):
        """(n, 3) from the centre of the first body to that of the second [m]."""
        between = self.length[:, None] * self.normals
        if self.arms is None:
            return between
        return between + self.radius * (self.arms[self.pairs[:, 0]] - self.arms[self.pairs[:, 1]])


class Packing:
    """Spheres or clumps in a periodic box; `law`, `friction` may be changed between compressions."""

    def __init__(self, bead, places, size, law, friction, arms=None):
        self.bead, self.law, self.friction = bead, law, friction
        self.size = np.array(size, float)
        self.bodies = np.zeros((5, len(places), 3))
        self.bodies[0] = places
        self.owner = np.repeat(np.arange(len(places)), len(bead.arms))
        self.arms = np.tile(bead.arms, (len(places), 1)) if arms is None else np.array(arms, float)
        self.pairs, self.contacts, self.turned = np.zeros((0, 5), np.int64), np.zeros((0, 6)), np.zeros(len(self.arms))
        self.state, self.skin, self.steps = law.new_state(0).arrays, 0.1 * bead.diameter, 0
        self.results = np.zeros(9)
        self._neighbours()

    @classmethod
    def loose(cls, bead, count, seed, law, friction):
        """Bodies added one after another at random places; spheres about them do not touch and fill a quarter."""
        from scipy.spatial import cKDTree
        from scipy.spatial.transform import Rotation

        random = np.random.default_rng(seed)
        diameter = bead.diameter + 2.0 * float(np.linalg.norm(bead.arms[0]))
        side = (count * math.pi / 6.0 / 0.25) ** (1.0 / 3.0) * diameter
        places = np.zeros((0, 3))
        while len(places) < count:
            places = np.vstack([places, random.uniform(0.0, side, (count, 3))])
            near = cKDTree(places, boxsize=side).query_pairs(diameter, output_type="ndarray")
            while len(near):  # of each pair the later one goes, unless it is in conflict with one that goes itself
                kept = np.ones(len(places), bool)
                kept[np.setdiff1d(near[:, 1], near[:, 0])] = False
                kept[near[near[:, 0] == near[:, 0].min(), 1]] = False
                places = places[kept]
                near = cKDTree(places, boxsize=side).query_pairs(diameter, output_type="ndarray")
        turns = Rotation.random(count, random_state=seed).as_matrix()
        arms = np.einsum("nab,mb->nma", turns, bead.arms).reshape(-1, 3)
        return cls(bead, places[:count], np.full(3, side), law, friction, arms)

    def inherit(self, pairs, shear):
        """Take over the shear forces [N] of these pairs of spheres."""
        where = {tuple(pair): n for n, pair in enumerate(self.pairs[:, :2])}
        for pair, force in zip(pairs[:, :2], shear, strict=True):
            if (n := where.get(tuple(pair))) is not None:
                self.contacts[n, :3] = force

    @property
    def solid(self):
        """Share of the volume in bodies."""
        return self.bodies.shape[1] * self.bead.volume / float(np.prod(self.size))

    @property
    def places(self):
        """Places of the spheres [m]."""
        return self.bodies[0][self.owner] + self.arms

    @property
    def stress(self):
        """Normal stresses [Pa]."""
        return self.results[:3].copy()

    def _neighbours(self):
        from scipy.spatial import cKDTree

        x, diameter = self.bodies[0], self.bead.diameter
        x -= self.size * np.floor(x / self.size)
        x[x >= self.size] = 0.0
        x = self.places
        inside = x - self.size * np.floor(x / self.size)
        inside[inside >= self.size] = 0.0
        found = cKDTree(inside, boxsize=self.size).query_pairs(diameter + self.skin, output_type="ndarray")
        found = found[self.owner[found[:, 0]] != self.owner[found[:, 1]]]
        found = found[np.lexsort((found[:, 1], found[:, 0]))]
        shift = -np.rint((x[found[:, 1]] - x[found[:, 0]]) / self.size).astype(np.int64)
        key, count = (lambda pairs: pairs[:, 0] * len(x) + pairs[:, 1]), len(found)
        _, new, old = np.intersect1d(key(found), key(self.pairs), assume_unique=True, return_indices=True)
        contacts = np.zeros((count, 6))
        contacts[new] = self.contacts[old]
        state = self.law.new_state(count).arrays
        for now, before in zip(state, self.state, strict=True):
            now[new] = before[old]
        self.pairs, self.contacts, self.state = np.hstack([found, shift]), contacts, state
        self.bodies[3], self.turned[:] = 0.0, 0.0
        self.results[6:] = 0.0

    def run(self, steps, goal, feedback, fastest, drag, dt):
        """March by this many steps."""
        bead, law, goal = self.bead, self.law, np.array(goal, float)
        rule, choice = law.unloading_parts.rule.tag, CHOICES["elastic"].tag
        given = (0.5 * bead.diameter, bead.mass, bead.inertia, self.friction, bead.shear_ratio, drag, dt, feedback, fastest)
        given = tuple(map(float, (*given, self.skin)))
        while steps > 0:
            done = march(
                choice,
                rule,
                law.shape,
                law.params,
                self.state,
                steps,
                given,
                goal,
                self.size,
                self.bodies,
                self.owner,
                self.arms,
                self.turned,
                self.pairs,
                self.contacts,
                self.results,
            )
            self.steps, steps = self.steps + done, steps - done
            if steps:
                self._neighbours()
        if not np.all(np.isfinite(self.bodies[0])):
            raise DemlawsError("the packing flew apart: the step is too long")

    def compress(self, goal, tolerance=5e-3, balance=1e-3, share=0.3, drag=0.1, viscous=5e-3, limit=200_000):
        """Bring the normal stresses to `goal` [Pa] (0: the box keeps its size there) and the forces to balance.

        share, drag: of √(m/K) of the stiffest contact the step, of √(K/m) of a mean one the drag; viscous: largest strain rate
        times the drag of a sphere over the pressure.
        """
        goal, mass, diameter = np.array(goal, float), self.bead.mass, self.bead.diameter
        pressure = goal[goal > 0.0].mean()
        guess = float(self.law.stiffness(float(self.law.overlap(pressure * diameter**2))))
        mean = math.sqrt(guess / mass)
        # stress follows strain with a modulus of about K/d: the feedback relaxes in a few crossings of the box by a wave
        feedback = mean * diameter / self.size.max() * pressure * diameter / guess
        fastest = viscous * pressure * diameter / (drag * mean * mass)
        for _ in range(limit // 100):
            step = share / math.sqrt(max(self.results[5], guess) / mass)
            self.run(100, goal, feedback, fastest, drag * mean, step)
            off = np.abs(self.stress / np.where(goal > 0.0, goal, 1.0) - 1.0)[goal > 0.0]
            if off.max() < tolerance and self.results[3] < balance * self.results[4]:
                return self
        raise DemlawsError(f"stresses {self.stress} Pa, not {goal}, unbalanced {self.results[3] / self.results[4]:.2g}")

    def carrying(self):
        """The `Contacts`."""
        x, diameter = self.places, self.bead.diameter
        apart = x[self.pairs[:, 1]] - x[self.pairs[:, 0]] + self.pairs[:, 2:] * self.size
        distance = np.linalg.norm(apart, axis=1)
        on = (self.contacts[:, 3] > 0.0) & (distance < diameter)
        normal = self.contacts[on, 3]
        shear = np.linalg.norm(self.contacts[on, :3], axis=1) / (max(self.friction, 1e-9) * normal)
        return Contacts(
            self.pairs[on, :2],
            apart[on] / distance[on, None],
            distance[on],
            normal,
            self.contacts[on, 4],
            self.contacts[on, 5],
            shear,
            *((self.owner, self.arms / (0.5 * diameter), 0.5 * diameter) if self.bead.clump else ()),
        )
