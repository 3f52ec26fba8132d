"""Stable time steps.

Velocity Verlet and leapfrog are stable for dt < 2/ω_max, the limit. ω_max is the largest angular frequency of the packing
linearised about its present state: one normal spring K_n and two tangential springs K_t per contact, grains that move and
rotate as uniform spheres (inertia 2/5 m R²): `from_contacts` computes it, `packing_estimate` estimates it before a run.

**One contact** has ω² = K_n (1/m1 + 1/m2) in normal motion and 7/2 K_t (1/m1 + 1/m2) in tangential motion with rotation, since
1 + m R²/(2/5 m R²) = 7/2 [our derivation; the lever is R, in fact R less half the overlap: a higher ω, the safe side].
"""

import math

import numpy as np
from numpy.typing import ArrayLike

from demlaws.contact import Material
from demlaws.core.loops import force_loop, unloaded_loop
from demlaws.core.shear import LARGEST_SHEAR_RATIO
from demlaws.errors import DemlawsError
from demlaws.law import Law, as_law
from demlaws.units import number

STEP_SAFETY = 0.8
"""Safety factor on the limit: at √3/2 of it (three steps per period) velocity Verlet is in resonance with any curved force law,
Hertz's included, and oscillations of finite size grow (measured by `python -m studies.extremes`)."""
SOFTENING_SAFETY = 0.56
"""The same for a curve without loss whose tangent falls at some overlap (`conical-damage`, with "elastic" unloading or as the
unloading curve of another law): an oscillation about such a kink is in resonance in narrow windows of the step, which get rarer
and slower as the step falls but do not end. Where unloading is stiffer than loading, energy is lost, and no window was found
(docs/theory/notes/conical-damage.md)."""
UNDAMPED_SAFETY = 0.3
"""The same for lossless bodies that bounce: an impact then has 7 steps or more. Of 2,100 speeds of an elastic body on a wall
under a constant force, up to those of 100 times its preload's oscillation, 7 made the energy grow fourfold in 600,000 steps at
0.35 of the limit of the peak force, none at 0.3. At 0.8 it grows in about 500 steps. Any damping ends this."""
COORDINATION = 6.0
"""Default mean number of contacts per grain, and the least that the estimate of a packing is made for."""


def _mass(value, name):
    return math.inf if isinstance(value, float) and value == math.inf else number(value, name, "kg")


def pair_limit(stiffness: float, mass1: float, mass2: float = math.inf, *, shear_ratio: float = 1.0) -> float:
    """Limit of two bodies in one contact, exact: 2/ω with ω² = K (1/m1 + 1/m2) max(1, 7/2 K_t/K).

    Parameters
    ----------
    stiffness : float
        K [N/m].
    mass1, mass2 : float
        Masses [kg]; inf is a fixed wall.
    shear_ratio : float
        K_t/K: 2(1-ν)/(2-ν) for smooth spheres of one material (`shear_ratio`), less where it was measured, at most 4/3; 0
        for grains without friction.

    Returns
    -------
    float
        Time step [s].

    Examples
    --------
    >>> round(pair_limit(1e6, 1e-3, 1e-3, shear_ratio=0.0) * 1e6, 3)  # µs, 2 √(m/(2 K))
    44.721
    """
    mass1, mass2, ratio = _mass(mass1, "mass1"), _mass(mass2, "mass2"), _ratio(shear_ratio)
    stiffness = number(stiffness, "stiffness", "N/m")
    return 2.0 / math.sqrt(stiffness * (1.0 / mass1 + 1.0 / mass2) * max(1.0, 3.5 * ratio))


def packing_estimate(
    stiffness: float, mass: float, coordination: float = COORDINATION, *, shear_ratio: float = 1.0, size_ratio: float = 1.0
) -> float:
    """Estimate of the limit of a packing: 0.5 to 1 times the exact limit in lattices and random packings (tests).

    2/ω with ω² = 2/3 (1 + 1/s)/2 max((Z + 4)(1 + 2 K_t/K), (Z + 2.5) 5 K_t/K) K/m; a Z below 6 counts as 6.

    Parameters
    ----------
    stiffness, mass : float
        K [N/m] and the lighter grain's m [kg] of the contact with the largest K/m.
    coordination : float
        Z, the mean number of contacts of grains that have any.
    shear_ratio : float
        K_t/K.
    size_ratio : float
        s, the mean radius over the smallest one; 1 is the safe choice: small grains have fewer contacts than others.

    Returns
    -------
    float
        Time step [s].

    Notes
    -----
    Scope: grains that are the heavier the larger they are, with contacts spread over all of them. Outside it the estimate
    exceeds the limit: 1.1 times for a layer of grains with 12 contacts that touch grains with one, 1.2 where five large grains
    weigh as much as a small one, 2.3 where one such grain has 100 contacts (tests). `from_contacts` is valid there. The
    numbers added to Z and the dependence on s are fitted to random packings.
    """
    # With Z in place of Z + 4 and Z + 2.5 and s = 1 this is exact in simple and body-centred cubic lattices. The first term is
    # for motion, the second for rotation.
    stiffness, mass, ratio = number(stiffness, "stiffness", "N/m"), number(mass, "mass", "kg"), _ratio(shear_ratio)
    mean = max(number(coordination, "coordination", "", 0.0, 100.0, allow_low=True), COORDINATION)
    sizes = 0.5 * (1.0 + 1.0 / number(size_ratio, "size_ratio", "", 1.0, allow_low=True))
    moving, rolling = (mean + 4.0) * (1.0 + 2.0 * ratio), (mean + 2.5) * 5.0 * ratio
    return 2.0 / math.sqrt(2.0 / 3.0 * sizes * max(moving, rolling) * stiffness / mass)


def shear_ratio(material1: Material, material2: Material) -> float:
    """K_t/K of smooth elastic spheres (Mindlin 1949), 4 G*/E*: 2(1-ν)/(2-ν) for one material.

    Parameters
    ----------
    material1, material2 : Material
        Materials of the two bodies.

    Returns
    -------
    float

    Examples
    --------
    >>> round(shear_ratio(*2 * [Material(young=60e9, poisson=0.25)]), 6)
    0.857143
    """
    both = material1, material2
    shear = 1.0 / sum(2.0 * (2.0 - m.poisson) * (1.0 + m.poisson) / m.young for m in both)
    return 4.0 * shear * sum(1.0 / m.plane_modulus for m in both)


def rayleigh_step(radius: float, density: float, young: float, *, poisson: float) -> float:
    """Rayleigh's step, π R √(ρ/G)/(0.1631 ν + 0.8766), the travel time of a surface wave across the smallest grain.

    For comparison only: it does not depend on the law, the load or the number of contacts. Usual advice is 0.1 to 0.3 of it.

    Parameters
    ----------
    radius : float
        Radius of the smallest grain [m].
    density : float
        Density [kg/m³].
    young : float
        Young's modulus [Pa].
    poisson : float
        Poisson's ratio.

    Returns
    -------
    float
        Time step [s].
    """
    radius, density = number(radius, "radius", "m"), number(density, "density", "kg/m³")
    young, poisson = number(young, "young", "Pa"), number(poisson, "poisson", "", -1.0, 0.5)
    return math.pi * radius * math.sqrt(density * 2.0 * (1.0 + poisson) / young) / (0.1631 * poisson + 0.8766)


def timestep(
    law: Law,
    mass: float,
    max_force: float,
    *,
    other_mass: float | None = None,
    coordination: float = COORDINATION,
    shear_ratio: float = 1.0,
    size_ratio: float = 1.0,
    damped: bool = True,
) -> float:
    """Stable time step of velocity Verlet with contacts of a law.

    Parameters
    ----------
    law : Law
        Law of the contact with the largest stiffness over mass, usually of the smallest grain with a large one.
    mass : float
        Mass of the lighter body [kg].
    max_force : float
        Largest contact force [N].
    other_mass : float, optional
        Mass of the other body of an isolated pair [kg]; inf for a fixed wall. Default: a packing, whose grains have several
        contacts.
    coordination : float
        Mean number of contacts per grain, of a packing.
    shear_ratio : float
        K_t/K, at most 4/3; 0 without friction.
    size_ratio : float
        Mean radius over the smallest one, of a packing; 1 is the safe choice.
    damped : bool
        Whether damping, friction or plastic contacts dissipate energy; False for lossless bodies that bounce.

    Returns
    -------
    float
        Step [s]: 0.8 (`STEP_SAFETY`) of the limit with the stiffest tangent of loading and unloading, 0.3
        (`UNDAMPED_SAFETY`) without damping, or 0.56 (`SOFTENING_SAFETY`) if a lossless curve becomes softer on the way to
        `max_force`.

    Raises
    ------
    DemlawsError
        For values that are not positive, or a force out of the range of the law.

    Examples
    --------
    >>> law = dl.law("hertz", dl.Contact(radius=4e-3, modulus=32e9))
    >>> print(f"{dl.timestep(law, mass=0.01, max_force=100.0):.3g} s in a packing")
    8.18e-06 s in a packing
    >>> print(f"{dl.timestep(law, mass=0.01, max_force=100.0, other_mass=0.01, shear_ratio=0.0):.3g} s for two of them")
    3.08e-05 s for two of them
    """
    mass = number(mass, "mass", "kg")
    largest = stiffest(law, max_force)
    lossless = law.unloading_law if law.state_size else law
    falls = lossless is not None and _jumps_down(lossless, float(lossless.overlap(max_force)))
    if other_mass is not None:
        limit = pair_limit(largest, mass, _mass(other_mass, "other_mass"), shear_ratio=shear_ratio)
    else:
        limit = packing_estimate(largest, mass, coordination, shear_ratio=shear_ratio, size_ratio=size_ratio)
    return (SOFTENING_SAFETY if falls else STEP_SAFETY if damped else UNDAMPED_SAFETY) * limit


def stiffest(law: Law, max_force: float) -> float:
    """Largest tangent stiffness up to a force, on loading and at the start of unloading.

    Parameters
    ----------
    law : Law
        Law of one contact.
    max_force : float
        Force [N].

    Returns
    -------
    float
        Stiffness [N/m].
    """
    as_law(law)
    law.single_params()
    end = float(law.overlap_of(max_force))
    overlap = np.concatenate([end * np.geomspace(1e-9, 1.0, 400), [end], *_beside_kinks(law, end)])
    largest = float(_tangent(law, overlap).max())
    if law.state_size:
        state = law.new_state(1)
        path = law.follow(end * np.append([1.0, 1.0 - 1e-12], np.linspace(1.0, 0.0, 400)[1:-1]), state)
        largest = max(largest, float(path.stiffness.max()))
    return largest


def stiffest_now(law: Law, force: np.ndarray, largest_overlap: np.ndarray | None = None) -> np.ndarray:
    """Stiffest tangent of each contact at its present force: of loading, and of unloading after its history.

    Parameters
    ----------
    law : Law
        Law of the contacts, an array of n of them.
    force : ndarray, shape (n,)
        Present forces [N].
    largest_overlap : ndarray, optional
        Largest overlaps so far [m]. Default: those at the present forces.

    Returns
    -------
    ndarray
        Stiffness [N/m].
    """
    loaded = np.asarray(law.overlap(force))
    largest = np.asarray(law.stiffness(loaded))
    if not law.state_size:
        return largest
    state, highest = law.new_state(force.size), loaded if largest_overlap is None else np.maximum(largest_overlap, loaded)
    law.evaluate(highest, state)
    unloaded = np.minimum(unloaded_loop(law.rule_tag, law.shape, law.params, force, state.arrays), highest * (1.0 - 2.0**-36))
    return np.maximum(largest, law.evaluate(unloaded, state)[1])


def _beside_kinks(law, end):
    """Overlaps [m] just below and just above the kinks of first loading up to `end`."""
    kinks = np.array([kink for kink in law.kinks() if 0.0 < kink < end])
    return kinks * (1.0 - 1e-9), kinks * (1.0 + 1e-9)


def _jumps_down(law, end):
    """Whether the tangent of first loading falls by more than a hundredth at some overlap up to `end` [m]."""
    below, above = (_tangent(law, overlaps) for overlaps in _beside_kinks(law, end))
    return bool(np.any(above < 0.99 * below))


def _tangent(law, overlap):
    """Stiffness [N/m] of first loading, without the warnings of `law.stiffness`."""
    return force_loop(law.shape, law.params, overlap)[1]


def _ratio(value):
    return number(value, "shear_ratio", "", 0.0, LARGEST_SHEAR_RATIO, allow_low=True)


def from_contacts(
    pairs: ArrayLike,
    normals: ArrayLike,
    stiffness: ArrayLike,
    *,
    shear_stiffness: ArrayLike,
    masses: ArrayLike,
    blocked: ArrayLike | None = None,
) -> float:
    """Largest stable step of spheres in contact, in their present configuration: 2/ω_max, exact.

    Radii are not needed: a sphere's lever arm and inertia grow alike.

    Parameters
    ----------
    pairs : array_like of int, shape (n, 2)
        Numbers (from 0) of the two bodies of each contact.
    normals : array_like, shape (n, 3)
        Unit vectors along the lines of centres, of either sign.
    stiffness, shear_stiffness : float or array_like, shape (n,)
        Tangents K_n and K_t [N/m]; K_t = 0 without friction.
    masses : array_like
        Mass of each body [kg], inf for walls and fixed bodies.
    blocked : array_like of bool, shape (bodies, 6), optional
        Degrees of freedom that do not move: translations, then rotations about x, y, z.

    Returns
    -------
    float
        Time step [s].

    Raises
    ------
    DemlawsError
        If shapes do not match, or no body is free.

    Examples
    --------
    >>> pair = from_contacts([[0, 1]], [[1.0, 0.0, 0.0]], 1e6, shear_stiffness=0.0, masses=[1e-3, 1e-3])
    >>> round(pair * 1e6, 3)  # µs, 2 √(m/(2 K))
    44.721
    """
    bodies, unit, normal, sideways, mass = _checked(pairs, normals, stiffness, shear_stiffness, masses)
    rows = _springs(bodies, unit, normal, sideways, 1.0 / np.sqrt(mass))
    if blocked is not None:
        fixed = np.asarray(blocked, bool)
        if fixed.shape != (mass.size, 6):
            raise DemlawsError(f"blocked must be of shape ({mass.size}, 6), got {fixed.shape}")
        rows = np.where(fixed[bodies], 0.0, rows)
        if not rows.any():
            raise DemlawsError("no contact moves a degree of freedom that is not blocked")
    return 2.0 / math.sqrt(_largest_eigenvalue(rows, bodies, mass.size))


def _checked(pairs, normals, stiffness, shear_stiffness, masses):
    """Arguments of `from_contacts` as arrays, or a DemlawsError."""
    pairs, normals, masses = np.asarray(pairs), np.asarray(normals, float), np.asarray(masses, float)
    if pairs.ndim != 2 or pairs.shape[1] != 2 or not len(pairs) or pairs.dtype.kind not in "iu" or masses.ndim != 1:
        raise DemlawsError(
            f"pairs must be whole numbers of shape (n, 2), n > 0, and masses 1-D, got {pairs.shape}, {masses.shape}"
        )
    if pairs.min() < 0 or pairs.max() >= len(masses) or np.any(pairs[:, 0] == pairs[:, 1]):
        raise DemlawsError(f"pairs must name two different bodies from 0 to {len(masses) - 1}")
    if normals.shape != (len(pairs), 3) or not np.allclose(np.sum(normals**2, axis=1), 1.0, atol=1e-3):
        raise DemlawsError(f"normals must be {len(pairs)} unit vectors, got an array of shape {normals.shape}")
    normal, sideways = (np.broadcast_to(np.asarray(k, float), len(pairs)) for k in (stiffness, shear_stiffness))
    if not all(np.all(np.isfinite(k) & (k >= 0.0)) for k in (normal, sideways)) or not normal.any():
        raise DemlawsError("stiffnesses must be finite, not negative, and not all zero")
    if not np.all(masses > 0.0) or np.all(np.isinf(masses[pairs])):
        raise DemlawsError("masses must be positive, and some body must be free (mass below inf)")
    return pairs, normals, normal, sideways, masses


def _springs(pairs, normals, stiffness, shear_stiffness, weight):
    """√k g of three springs per contact, g the direction in all degrees of freedom, each divided by √mass or √inertia.

    Shape (3, contacts, 2 bodies, 6 degrees of freedom).
    """
    across = np.cross(normals, np.eye(3)[np.argmin(np.abs(normals), axis=1)])
    across /= np.linalg.norm(across, axis=1)[:, None]
    rows = np.zeros((3, len(pairs), 2, 6))
    for row, direction in zip(rows, (normals, across, np.cross(normals, across)), strict=True):
        scale = np.sqrt(stiffness if direction is normals else shear_stiffness)
        for side, sign in ((0, 1.0), (1, -1.0)):
            here = (scale * weight[pairs[:, side]])[:, None]
            row[:, side, :3] = sign * here * direction
            row[:, side, 3:] = math.sqrt(2.5) * here * np.cross(normals, direction)  # R/√(2/5 m R²) = √(5/2)/√m
    return rows


def _largest_eigenvalue(rows, pairs, bodies):
    from scipy.sparse import csr_matrix
    from scipy.sparse.linalg import eigsh

    columns = np.broadcast_to(6 * pairs[:, :, None] + np.arange(6), rows.shape)
    index = np.repeat(np.arange(3 * len(pairs)), 12)
    matrix = csr_matrix((rows.ravel(), (index, columns.ravel())), shape=(3 * len(pairs), 6 * bodies))
    start = np.random.default_rng(0).random(6 * bodies)  # a regular start may be orthogonal to a lattice's mode
    # close eigenvalues converge slowly; the residual is below 1e-6 of the eigenvalue, and so is its error
    return float(eigsh(matrix.T @ matrix, k=1, which="LA", v0=start, tol=1e-6, return_eigenvectors=False)[0])


class TimestepFunctions:
    """Type of `dl.timestep`: the function, whose attributes are the other functions of this module."""

    __call__ = staticmethod(timestep)
    from_contacts = staticmethod(from_contacts)
    packing_estimate = staticmethod(packing_estimate)
    pair_limit = staticmethod(pair_limit)
    rayleigh_step = staticmethod(rayleigh_step)
    shear_ratio = staticmethod(shear_ratio)


timestep.__dict__.update({name: getattr(TimestepFunctions, name) for name in vars(TimestepFunctions) if name[0] != "_"})
