"""One contact under normal and tangential displacement: shear without slip before sliding, and partial slip."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from demlaws.core.levels import levels_loop
from demlaws.core.shear import (
    CHOICES,
    DEFAULT,
    DEFAULT_LEVELS,
    LARGEST_SHEAR_RATIO,
    MOST_LEVELS,
    SLIP,
    friction_at,
    pressure_loop,
)
from demlaws.core.slip import SAMPLES, slip_loop
from demlaws.curves.unloading import UNKNOWN_AREA
from demlaws.errors import DemlawsError, warn
from demlaws.law import Law, as_law
from demlaws.units import as_float, number, unmasked, whole


@dataclass(frozen=True)
class PressureFriction:
    """Friction that falls with the mean pressure of the contact: μ = μ0 + c1/(1 + c2 p), p = P/(π a²).

    Parameters
    ----------
    mu0 : float
        Coefficient of friction at high pressure.
    c1 : float
        What it is larger by at rest: μ0 + c1 at zero pressure.
    c2 : float or str
        Inverse of the pressure at which half of c1 is left [1/Pa].

    Raises
    ------
    DemlawsError
        If a value is negative or not finite.

    Notes
    -----
    Suhr & Six 2016 (Powder Technol. 294, 211), as in YADE's Law2_ScGeom_MindlinPhysCDM_HertzMindlinCDM: μ0, c1 and c2 describe
    friction over the pressures of the tests to which they were fitted; outside it is an extrapolation, and a warning is issued
    above the hardness. a is the contact radius of the law on first loading; on unloading a = K/(2 E*), with the stiffness K of
    unloading: that of the rule's curve. [our derivation] No step creates energy: a limit that falls below the shear force lets
    the contact slide, a limit that rises does nothing.

    Tables of `jackson-green` and `kogut-etsion` with rule `elastic`, and of `rough-plastic` with `bulk_radius`, do not contain
    the law's area: friction by pressure is refused with them.

    Examples
    --------
    >>> friction = dl.PressureFriction(mu0=0.3, c1=0.4, c2=1e-9)
    >>> friction.coefficient([0.0, 1e9, 1e12]).round(4)
    array([0.7   , 0.5   , 0.3004])
    """

    mu0: float
    c1: float
    c2: float

    def __post_init__(self):
        for name in ("mu0", "c1", "c2"):
            value = number(getattr(self, name), name, "1/Pa" if name == "c2" else "", allow_low=True)
            object.__setattr__(self, name, value)

    def coefficient(self, pressure: ArrayLike) -> np.ndarray:
        """μ at a mean pressure [Pa]."""
        return friction_at(self.mu0, self.c1, self.c2, np.asarray(pressure, float))

    def combined(self, other: "PressureFriction") -> "PressureFriction":
        """Friction of two materials: the smaller of each parameter, as YADE's Ip2_FrictMatCDM_FrictMatCDM_MindlinPhysCDM."""
        return PressureFriction(*(min(getattr(self, name), getattr(other, name)) for name in ("mu0", "c1", "c2")))


class Sheared(NamedTuple):
    """One contact under normal and tangential displacement: arrays with one entry per point of the path, SI units.

    displacement and shear_force have two columns for two directions. work: done by tangential displacement since
    the path began [J]; stored: elastic shear energy [J]; the rest was dissipated.
    """

    overlap: np.ndarray
    displacement: np.ndarray
    force: np.ndarray
    shear_stiffness: np.ndarray  # K_t [N/m] at the onset of slip
    shear_force: np.ndarray
    work: np.ndarray
    stored: np.ndarray

    @property
    def dissipated(self) -> np.ndarray:
        """Energy [J] dissipated by friction and by the opening of sheared parts of the contact; it never decreases."""
        return self.work - self.stored


def sheared(
    law: Law,
    overlap: ArrayLike,
    displacement: ArrayLike,
    ratio: float,
    shear: str = DEFAULT,
    *,
    friction: float | PressureFriction | None = None,
    springs: int = 32,
    levels: int | None = None,
) -> Sheared:
    """Shear force and energies of one contact along a path of overlaps and tangential displacements [m].

    Parameters
    ----------
    law : Law
        Normal law of one contact, with its unloading rule.
    overlap : array_like, shape (n,)
        Overlaps [m]; the contact has no history at the start.
    displacement : array_like, shape (n,) or (n, 2)
        Tangential displacement [m] in one direction, or in two directions of the tangent plane.
    ratio : float
        K_t/K of an elastic contact, 2(1-ν)/(2-ν) for two bodies of one material (Mindlin 1949): above 0, at most 4/3 (ν = -1).
    shear : str
        "elastic" (default): no slip before sliding, K_t = ratio times the tangent stiffness of unloading.
        "loading": the same with the tangent of first loading at the present force. "slip": partial slip.
    friction : float or PressureFriction, optional
        Coefficient of friction μ, or one that depends on the pressure. Default: the contact never slides; required by "slip".
    springs : int
        Number of springs of "slip", 2 or more, graded towards those that touched last. With 32 the loss of a cycle of Hertz
        contact from 0.05 μP on is within 6 %, and the force within 1 % of μP; of rough elastic contacts within 2.5 %.
    levels : int, optional
        Number of levels of "elastic" and "loading" (default 3). With 1 the contact loses its shear force if its overlap
        vibrates; 2 or more keep it.

    Returns
    -------
    Sheared

    Raises
    ------
    DemlawsError
        Lengths that differ, values that are not finite, an unknown choice, "slip" without friction.

    Notes
    -----
    Every choice is passive: `dissipated` never falls on any path, so that no closed path returns work. Without slip,
    dQ = K_t ds. At constant overlap δ "slip" gives Q = μ [P(δ) - P(δ - ratio s/μ)], with P the unloading curve (Jäger 1998;
    Ciavarella 1998). The page "Shear" has the theory.

    Examples
    --------
    >>> law = dl.law("hertz", dl.Contact(radius=4.35e-3, modulus=32.32e9))
    >>> depth = law.overlap(10.0)
    >>> sideways = np.linspace(0.0, 1e-6, 11)
    >>> slip = dl.driver.sheared(law, [depth] * 11, sideways, 0.857, "slip", friction=0.5)
    >>> slip.shear_force[[1, 5, 10]].round(3)
    array([0.546, 2.503, 4.341])
    """
    depth = np.atleast_1d(as_float(overlap, "overlap", "m", array=True))
    as_law(law)
    try:
        along = np.asarray(unmasked(displacement), float)
    except (TypeError, ValueError):
        raise DemlawsError(f"displacement must be numbers in m, got {displacement!r:.60}") from None
    plane = np.stack([along, np.zeros(along.shape)], -1) if along.ndim == 1 else along
    if plane.ndim != 2 or plane.shape != (depth.size, 2):
        raise DemlawsError(
            f"displacement has shape {along.shape} for {depth.size} overlaps: give one displacement in m, or two components, "
            "for each overlap"
        )
    if not (np.all(np.isfinite(depth)) and np.all(np.isfinite(plane))):
        raise DemlawsError("overlap and displacement must be finite numbers in m")
    ratio = number(ratio, "ratio", high=LARGEST_SHEAR_RATIO)
    if not isinstance(shear, str) or shear not in (*CHOICES, SLIP):
        raise DemlawsError(f"shear must be {', '.join(map(repr, (*CHOICES, SLIP)))}, got {shear!r}")
    if shear == SLIP and levels is not None:
        raise DemlawsError("partial slip has springs, not levels: give springs=, or another shear= than 'slip'")
    if shear == SLIP and friction is None:
        raise DemlawsError("partial slip needs the coefficient of friction: give friction=")
    state = law.new_state(1)
    first, second = np.ascontiguousarray(plane.T)
    results = np.empty((6, depth.size))
    law.shear_stiffness(depth, 1.0, DEFAULT if shear == SLIP else shear)  # checks law and range
    limit = _friction_along(law, depth, friction)
    if shear == SLIP:
        rows = np.zeros((6, whole(springs, "springs", low=2, high=100_000))), np.empty((2, SAMPLES))
        slip_loop(law.rule_tag, law.shape, law.params, depth, first, second, ratio, limit, state.arrays, *rows, results)
    else:
        tag = CHOICES[shear].tag
        count = DEFAULT_LEVELS if levels is None else whole(levels, "levels", high=MOST_LEVELS)
        rows = np.zeros(count), np.zeros((count, 3))
        levels_loop(tag, law.rule_tag, law.shape, law.params, depth, first, second, ratio, limit, state.arrays, *rows, results)
    force, stiffness, *forces, work, stored = results
    shear_force = forces[0] if along.ndim == 1 else np.stack(forces, -1)
    return Sheared(depth, along, force, ratio * stiffness, shear_force, work, stored)


def _pressure_along(law: Law, overlap: np.ndarray) -> np.ndarray:
    """Mean pressure P/(π a²) [Pa] of one contact at each point of a path of overlaps [m]; `PressureFriction` has the area."""
    pressure = np.empty(overlap.size)
    if not law.knows_area:
        raise DemlawsError(UNKNOWN_AREA.format(f"the table of law {law.name!r} with unloading {law.unloading!r}"))
    known = law.rule_tag, law.shape, law.params, law.contact.modulus
    pressure_loop(*known, overlap, law.new_state(1).arrays, pressure)
    return pressure


def _friction_along(law, overlap, friction):
    """Coefficient of friction at each point of a path of overlaps [m]."""
    if not isinstance(friction, PressureFriction):
        return np.full(overlap.size, math.inf if friction is None else number(friction, "friction", allow_low=True))
    pressure = _pressure_along(law, overlap)
    doubt = _beyond_hardness(float(pressure.max()), law.contact.hardness)
    if doubt is not None:
        warn(doubt)
    return friction.coefficient(pressure)


def _beyond_hardness(highest: float, hardness: float | None) -> str | None:
    """Text about a mean pressure above the hardness [Pa], or None."""
    if hardness is None or not highest > hardness:
        return None
    return f"mean pressure {highest:.4g} Pa is above the hardness {hardness:.4g} Pa: the friction law is not known there"
