"""Single-contact tests: displacement- and force-controlled paths, and the impact of a mass on a contact."""

import itertools
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from demlaws.core import dispatch
from demlaws.core.dispatch import gather, stored_and_dissipated
from demlaws.core.loops import energy_loop
from demlaws.core.numba_compat import loop
from demlaws.errors import DemlawsError
from demlaws.law import Law, as_law
from demlaws.responses.path import Path
from demlaws.shear import Sheared as Sheared, sheared as sheared
from demlaws.units import as_float, as_typed, number, typed, whole


def _branches(law, turning_points, unit, steps):
    """`steps` equal steps from 0 to the first turning point, and from each to the next; one array per branch."""
    points = np.atleast_1d(as_float(turning_points, "turning points", unit, array=True))
    if points.size == 0 or not np.all(np.isfinite(points)):
        raise DemlawsError(f"turning points must be finite numbers in {unit}, at least one, got {turning_points!r:.60}")
    as_law(law)
    steps = whole(steps, "steps")
    return [np.linspace(a, b, steps + 1)[1:] for a, b in itertools.pairwise([0.0, *points])]


def _moving(mass, speed):
    """A mass [kg], its speed [m/s] and its kinetic energy [J]."""
    m, v = number(mass, "mass", "kg"), number(speed, "speed", "m/s")
    kinetic = 0.5 * m * v * v
    if not 1e-200 < kinetic < math.inf:
        raise DemlawsError(
            f"speed = {as_typed(speed, 'm/s')}: the kinetic energy of mass = {as_typed(mass, 'kg')} is {kinetic:g} J, beyond "
            "what can be computed"
        )
    return m, v, kinetic


def displacement_controlled(law: Law, turning_points: ArrayLike, steps: int = 200) -> Path:
    """Drive the overlap of one contact from 0 through turning points.

    Parameters
    ----------
    law : Law
        Law of one contact.
    turning_points : array_like
        Overlaps [m], or text with units. Below 0 the bodies are separated, and the history is lost.
    steps : int
        Equal steps per branch.

    Returns
    -------
    Path
        Response at every step.

    Raises
    ------
    DemlawsError
        For turning points that are not finite or out of the range of the law.

    Examples
    --------
    >>> law = dl.law("hertz", dl.Contact(radius=4e-3, modulus=32e9))
    >>> path = dl.driver.displacement_controlled(law, [2e-6, 0.0], steps=2)
    >>> (path.overlap * 1e6).round(3), path.force.round(3)
    (array([0., 1., 2., 1., 0.]), array([0.   , 2.698, 7.632, 2.698, 0.   ]))
    """
    branches = _branches(law, turning_points, "m", steps)
    return law._follow(np.concatenate([[0.0], *branches]), None, turning_points)


def force_controlled(law: Law, turning_points: ArrayLike, steps: int = 200) -> Path:
    """Drive the force of one contact from 0 through turning points.

    Below the largest force so far the overlap follows the unloading curve, above it the loading curve.

    Parameters
    ----------
    law : Law
        Law of one contact.
    turning_points : array_like
        Forces [N], at least 0, or text with units.
    steps : int
        Equal steps per branch.

    Returns
    -------
    Path
        Response at every step.

    Raises
    ------
    DemlawsError
        For negative forces, or forces out of the range of the law.

    Examples
    --------
    >>> pair = dl.Contact(radius=4e-3, modulus=32e9, sigma=2e-6, fractal_dimension=2.2)
    >>> path = dl.driver.force_controlled(dl.law("pohrt-popov", pair, unloading="hertz"), [50.0, 0.0])
    >>> bool(path.plastic_overlap[-1] > 0.0), bool(abs(path.work[-1] - path.dissipated[-1]) < 1e-15)
    (True, True)
    """
    branches = _branches(law, turning_points, "N", steps)
    lowest = min(forces[-1] for forces in branches)
    if lowest < 0.0:
        text = as_typed(typed(lowest, turning_points, "N"), "N")
        raise DemlawsError(f"force {text}: a contact without adhesion carries no tension; turn at 0 N or above")
    state, largest, overlaps = law.new_state(1), 0.0, [np.zeros(1)]
    for forces in branches:
        branch = np.empty(forces.size)
        new = forces >= largest
        if np.any(new):
            branch[new] = law._overlap(forces[new], turning_points)
        if not np.all(new):
            branch[~new] = law.unloading_overlap(forces[~new], state)
        law.follow(branch, state)
        is_new = law.state_size and not any(array[0] for array in state.arrays)  # back at zero overlap: a new contact
        largest = 0.0 if is_new else max(largest, float(forces.max()))
        overlaps.append(branch)
    return law.follow(np.concatenate(overlaps))


@loop
def impact_loop(rule, shape, p, state, mass, speed, dt, phase, limit, record):
    """Velocity Verlet from a fraction `phase` of a step before touch to separation. Columns of record: overlap, speed, force.

    Returns the steps taken, the last overlap and velocity, what the contact has dissipated, and the peak overlap.
    """
    overlap = -phase * dt * speed
    velocity = speed
    force = 0.0
    count = 0
    dissipated = 0.0
    peak = 0.0
    s = gather(state, 0)
    for i in range(limit):
        velocity -= 0.5 * dt * force / mass
        overlap += dt * velocity
        if overlap <= 0.0:
            dissipated = stored_and_dissipated(rule, shape, p, overlap, s)[1]
        force, _, s = dispatch.step(rule, shape, p, overlap, s)
        velocity -= 0.5 * dt * force / mass
        peak = max(peak, overlap)
        if i < record.shape[0]:
            record[i, 0] = overlap
            record[i, 1] = velocity
            record[i, 2] = force
        count = i + 1
        if overlap <= 0.0 and velocity <= 0.0:
            break
    return count, overlap, velocity, dissipated, peak


class Impact(NamedTuple):
    """Result of `impact`, SI units; arrays with one entry per step."""

    rebound_speed: float
    restitution: float
    peak_force: float
    peak_overlap: float
    plastic_overlap: float
    duration: float
    kinetic_before: float
    kinetic_after: float
    dissipated: float
    energy_error: float  # (kinetic_after + dissipated - kinetic_before)/kinetic_before: error of the integration
    time: np.ndarray
    overlap: np.ndarray
    speed: np.ndarray
    force: np.ndarray


def impact(law: Law, mass: float | str, speed: float | str, steps_per_contact: int = 1000) -> Impact:
    """Impact of a body on the contact, damped only by the law.

    Parameters
    ----------
    law : Law
        Law of one contact.
    mass : float or str
        Mass of the body [kg]; of two bodies m1 m2/(m1 + m2).
    speed : float or str
        Speed of approach [m/s].
    steps_per_contact : int
        Steps per elastic loading and unloading.

    Returns
    -------
    Impact
        Rebound speed, restitution, peak values, energies and the history.

    Raises
    ------
    DemlawsError
        For values that are not positive, or an overlap out of the range of the law.

    Notes
    -----
    Integrated by velocity Verlet.

    Examples
    --------
    >>> law = dl.law("hertz", dl.Contact(radius=4e-3, modulus=32e9))
    >>> round(dl.driver.impact(law, mass=0.01, speed=0.1).restitution, 6)
    1.0
    """
    count = number(steps_per_contact, "steps_per_contact", "", 3, 10_000_000, allow_low=True)
    p = as_law(law).single_params()
    m, v, kinetic = _moving(mass, speed)
    peak, duration = elastic_contact(law, mass, speed)
    dt = duration / count
    state = law.new_state(1).arrays
    # a plastic contact leaves its dent at the rebound speed: restitution e takes some 1/e times the elastic duration
    limit = int(max(100 * count, min(5000 * count, 1e7)))
    room = np.empty((min(limit, int(4 * count) + 16), 3))
    start = law.rule_tag, law.shape, p
    steps, overlap, velocity, dissipated, _ = impact_loop(*start, state, m, v, dt, 0.0, limit, room)
    if steps > len(room):  # of slow separation: again with room for every step
        room, state = np.empty((steps, 3)), law.new_state(1).arrays
        steps, overlap, velocity, dissipated, _ = impact_loop(*start, state, m, v, dt, 0.0, limit, room)
    if not math.isfinite(velocity):
        raise DemlawsError(law._out_of_range(peak))
    if overlap > 0.0:
        raise DemlawsError(
            f"speed = {as_typed(speed, 'm/s')}: no separation within {limit} steps; is the law's plastic overlap that large?"
        )
    record = room[:steps]
    path = law.follow(record[:, 0])
    after = 0.5 * m * velocity**2
    return Impact(
        rebound_speed=-velocity,
        restitution=-velocity / v,
        peak_force=float(record[:, 2].max()),
        peak_overlap=float(record[:, 0].max()),
        plastic_overlap=float(path.plastic_overlap.max(initial=0.0)),
        duration=steps * dt,
        kinetic_before=kinetic,
        kinetic_after=after,
        dissipated=dissipated,
        energy_error=(after + dissipated - kinetic) / kinetic,
        time=dt * np.arange(1, record.shape[0] + 1),
        overlap=record[:, 0],
        speed=record[:, 1],
        force=record[:, 2],
    )


def elastic_contact(law: Law, mass: float | str, speed: float | str) -> tuple[float, float]:
    """Largest overlap and duration of an elastic impact, from the energy of first loading.

    Parameters
    ----------
    law : Law
        Law of one contact.
    mass : float or str
        Effective mass [kg].
    speed : float or str
        Relative normal speed at first touch [m/s].

    Returns
    -------
    tuple of float
        Overlap [m] at which first loading has taken the kinetic energy, and twice the time until then [s].
    """
    from scipy.optimize import brentq

    params = as_law(law).single_params()
    m, v, kinetic = _moving(mass, speed)

    def work(overlaps):  # without the advice that `law.energy` gives on overlaps which no impact reaches
        return energy_loop(law.shape, params, np.atleast_1d(np.asarray(overlaps, float)))

    high = float(law.contact.radius)
    if not work(high)[0] > kinetic:  # also where a table ends before: its energy is not a number there
        high = min(high, float(law.largest_overlap)) * (1.0 - 1e-12)
        if not work(high)[0] > kinetic:
            text = f"speed = {as_typed(speed, 'm/s')}"
            raise DemlawsError(f"{text}: the contact cannot take {kinetic:g} J within its radius or its table")
    peak = brentq(lambda overlap: work(overlap)[0] - kinetic, 0.0, high, xtol=1e-300, rtol=1e-13, maxiter=1000)
    # t = ∫dδ/v, with δ = peak (1 - x²) to take the square root out of the end
    places, weights = np.polynomial.legendre.leggauss(64)
    x = 0.5 * (places + 1.0)
    squares = v * v - 2.0 / m * work(peak * (1.0 - x**2))
    times = weights * x * peak / np.sqrt(np.maximum(squares, 1e-300))
    return peak, 2.0 * float(np.sum(times))
