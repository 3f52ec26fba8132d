"""Small-strain moduli of a packing from its linearised stiffness, with rotations and periodic images.

The springs of `demlaws.timestep` (one normal, two tangential per contact) elongate by B u + e: u are the displacements and
rotations beside the affine strain, e is the strain's own part. u minimises ½ |B u + e|², and C = |B u + e|²/V is the modulus.
The terms of the forces carried already, of the order of P/(l K_t), are left out; `prestress` is their size.
"""

import math
from typing import NamedTuple

import numpy as np

from demlaws.errors import DemlawsError
from demlaws.timestep import _springs

STRAINS = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "yz": (1, 2), "xz": (0, 2), "xy": (0, 1)}


class Moduli(NamedTuple):
    """Moduli [Pa]: of longitudinal and shear strain, along z and its mean over the axes, and the bulk modulus."""

    along: float  # M of a wave along z
    across: float  # G of a transverse wave along z
    longitudinal: float
    shear: float
    bulk: float


class Linear:
    """The springs of a packing's contacts; with forces [N] also the terms of those, which are small (see `prestress`)."""

    def __init__(self, contacts, size, stiffness, shear_stiffness, force=None):
        from scipy.sparse import vstack

        rows = _springs(contacts.pairs, contacts.normals, stiffness, shear_stiffness, np.ones(contacts.pairs.max() + 1))
        self.springs, self.volume, self.branch = rows.shape[1] * 3, float(np.prod(size)), contacts.branch
        self.matrix, self.directions = _matrix(rows, contacts.pairs), [-rows[:, :, 0, :3]]
        if contacts.arms is not None:
            self.matrix = (self.matrix @ _rigid(contacts)).tocsr()
        if force is not None:  # a force P along a line of length l that turns: a spring of -P/l across
            rows = _springs(contacts.pairs, contacts.normals, 0.0, force / contacts.length, np.ones(contacts.pairs.max() + 1))[
                1:
            ]
            rows[..., 3:] = 0.0
            self.matrix = vstack([self.matrix, _matrix(rows, contacts.pairs)]).tocsr()
            self.directions.append(-rows[:, :, 0, :3])
        self.sign = np.where(np.arange(self.matrix.shape[0]) < self.springs, 1.0, -1.0)
        self.turned = self.matrix.T.tocsr()
        diagonal = np.asarray(self.matrix.power(2).sum(axis=0)).ravel()
        self.inverse = np.where(diagonal > 0.0, 1.0 / np.maximum(diagonal, 1e-300), 0.0)

    def elongation(self, strain, tolerance=1e-5):
        """√k times the elongations of all springs under a gradient of displacement, with all bodies in balance."""
        strain = np.asarray(strain, float)
        affine = np.concatenate([np.einsum("kna,ab,nb->kn", d, strain, self.branch).ravel() for d in self.directions])
        right = -self.turned @ (self.sign * affine)
        u, residual = np.zeros(len(right)), right.copy()
        z = self.inverse * residual
        direction, rho, start = z.copy(), residual @ z, np.sqrt(right @ (self.inverse * right))
        for _ in range(20_000):
            if np.sqrt(rho) <= tolerance * start:
                return self.matrix @ u + affine
            stretched = self.matrix @ direction
            length = rho / (stretched @ (self.sign * stretched))
            u += length * direction
            residual -= length * (self.turned @ (self.sign * stretched))
            z = self.inverse * residual
            rho, before = residual @ z, rho
            direction = z + rho / before * direction
        raise DemlawsError(f"the packing's balance under a strain was not found: residual {np.sqrt(rho) / start:.1g}")

    def modulus(self, strain):
        """Stress [Pa] along a strain, per strain."""
        found = self.elongation(strain)
        return float(found @ (self.sign * found)) / self.volume

    def moduli(self, directions=STRAINS):
        """`Moduli`."""
        found = {}
        for name in directions:
            strain, (a, b) = np.zeros((3, 3)), STRAINS[name]
            strain[a, b] += 0.5
            strain[b, a] += 0.5
            found[name] = self.elongation(strain)
        square = {name: float(e @ e) / self.volume for name, e in found.items()}
        bulk = sum(found[name] for name in ("xx", "yy", "zz")) / 3.0
        return Moduli(
            square["zz"],
            0.5 * (square["yz"] + square["xz"]),
            (square["xx"] + square["yy"] + square["zz"]) / 3.0,
            (square["yz"] + square["xz"] + square["xy"]) / 3.0,
            float(bulk @ bulk) / self.volume,
        )


def _matrix(rows, pairs):
    """Springs (kinds, contacts, 2 bodies, 6) as a sparse matrix."""
    from scipy.sparse import csr_matrix

    columns = np.broadcast_to(6 * pairs[:, :, None] + np.arange(6), rows.shape)
    index = np.repeat(np.arange(rows.shape[0] * len(pairs)), 12)
    return csr_matrix((rows.ravel(), (index, columns.ravel())), shape=(rows.shape[0] * len(pairs), 6 * (pairs.max() + 1)))


def _rigid(contacts):
    """Motions of the spheres (6 each) by those of their clumps, as a sparse matrix: the rotations of both are R θ/√(5/2)."""
    from scipy.sparse import csr_matrix

    count = contacts.pairs.max() + 1
    owner, arms = contacts.owner[:count], math.sqrt(2.5) * contacts.arms[:count]
    blocks = np.broadcast_to(np.eye(6), (count, 6, 6)).copy()
    blocks[:, :3, 3:] = np.cross(np.eye(3)[None], arms[:, None]).transpose(0, 2, 1)
    rows = np.repeat(np.arange(6 * count), 6)
    columns = np.broadcast_to(6 * owner[:, None, None] + np.arange(6), blocks.shape)
    return csr_matrix((blocks.ravel(), (rows, columns.ravel())), shape=(6 * count, 6 * (owner.max() + 1)))


def moduli(contacts, size, ratio, stiffness=None):
    """`Moduli` with these normal stiffnesses (default: the tangents) and `ratio` times those of unloading across."""
    normal = contacts.stiffness if stiffness is None else stiffness
    across = contacts.unloading if stiffness is None else stiffness
    return Linear(contacts, size, normal, ratio * across).moduli()


def first_loading(contacts, size, ratio, strain, rounds=30):
    """Modulus [Pa] of a first step of strain: contacts that close take K of loading, those that open K of unloading."""
    tensor = np.array(strain, float)
    closing = np.ones(len(contacts.force), bool)
    for _ in range(rounds):
        stiffness = np.where(closing, contacts.stiffness, contacts.unloading)
        found = Linear(contacts, size, stiffness, ratio * contacts.unloading).elongation(tensor)
        now = found[: len(closing)] > 0.0
        if np.array_equal(now, closing):
            break
        closing = now
    return float(found @ found) / float(np.prod(size))


def prestress(contacts, ratio):
    """Mean of P/(l K_t): the terms left out over those kept."""
    return float(np.mean(contacts.force / (contacts.length * ratio * contacts.unloading)))
