"""Lattices and random packings as contact networks, for tests of time steps."""

from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

ROOT3 = np.sqrt(3.0)
CELLS = {
    "sc": ([(0, 0, 0)], (1, 1, 1), 1.0),
    "bcc": ([(0, 0, 0), (0.5, 0.5, 0.5)], (1, 1, 1), ROOT3 / 2),
    "fcc": ([(0, 0, 0), (0.5, 0.5, 0), (0.5, 0, 0.5), (0, 0.5, 0.5)], (1, 1, 1), np.sqrt(0.5)),
    "hcp": (
        [(0, 0, 0), (0.5, ROOT3 / 2, 0), (0.5, ROOT3 / 6, np.sqrt(2 / 3)), (0, 2 / ROOT3, np.sqrt(2 / 3))],
        (1, ROOT3, 2 * np.sqrt(2 / 3)),
        1.0,
    ),
}
"""Lattice → grains of a unit cell, edges of the cell, distance of neighbours."""


class Packing(NamedTuple):
    """A periodic contact network: bodies of each contact, unit vectors from the second to the first, overlaps, radii."""

    pairs: np.ndarray
    normals: np.ndarray
    overlap: np.ndarray
    radius: np.ndarray

    @property
    def coordination(self):
        """Mean number of contacts of the grains that have some."""
        return 2.0 * len(self.pairs) / len(np.unique(self.pairs))

    @property
    def mass(self):
        """Masses at a density at which a grain of radius 1 has mass 1."""
        return self.radius**3


def _contacts(centres, radius, box):
    pairs = cKDTree(centres % box, boxsize=box).query_pairs(2.0 * radius.max() * 1.001, output_type="ndarray")
    between = centres[pairs[:, 0]] - centres[pairs[:, 1]]
    between -= box * np.round(between / box)
    distance = np.linalg.norm(between, axis=1)
    return pairs, between / distance[:, None], radius[pairs].sum(axis=1) - distance


def lattice(kind, cells=4):
    """Equal spheres of radius 1 in contact in a periodic block of `cells`³ unit cells."""
    base, edges, neighbour = CELLS[kind]
    corners = np.array(list(np.ndindex(cells, cells, cells)))
    scale = 2.0 / neighbour
    centres = scale * np.concatenate([corners * np.array(edges) + np.array(grain) for grain in base])
    radius = np.ones(len(centres))
    pairs, normals, overlap = _contacts(centres, radius, scale * cells * np.array(edges, float))
    touching = overlap > -1e-6
    return Packing(pairs[touching], normals[touching], overlap[touching], radius)


def random_packing(size_ratio, share, seed, two_sizes=False, count=150, steps=1200):
    """Elastic spheres, relaxed at the volume fraction `share`: radii from 1 to `size_ratio`, or half of each of these."""
    random = np.random.default_rng(seed)
    radius = np.repeat([1.0, size_ratio], count // 2) if two_sizes else random.uniform(1.0, size_ratio, count)
    edge = (np.sum(4 / 3 * np.pi * radius**3) / share) ** (1 / 3)
    centres, velocity = random.uniform(0.0, edge, (count, 3)), np.zeros((count, 3))
    for _ in range(steps):
        pairs, normals, overlap = _contacts(centres, radius, np.full(3, edge))
        pull = np.maximum(overlap, 0.0)[:, None] * normals
        force = np.zeros_like(centres)
        np.add.at(force, pairs[:, 0], pull)
        np.add.at(force, pairs[:, 1], -pull)
        if np.sum(force * velocity) < 0.0:
            velocity[:] = 0.0
        velocity = 0.99 * velocity + 0.05 * force
        centres = centres + 0.05 * velocity
    touching = overlap > 1e-6
    return Packing(pairs[touching], normals[touching], overlap[touching], radius)
