"""Compiled measurements of a law: random first loading, and random load paths that must return no work."""

import math

from numba.extending import overload

from demlaws.core import dispatch
from demlaws.core.dispatch import energy, first_loading, gather, unloading_curve
from demlaws.core.numba_compat import kernel, loop
from demlaws.core.unloading import Given, rule_of


def _plastic(rule, state):
    """Plastic overlap of a state tuple; 0 where the rule has no state, or is a law's own, whose state may be anything."""


@overload(_plastic)
def _plastic_of(rule, state):
    foot = len(state) > 0 and rule_of(rule.instance_class).curve != "law"
    return (lambda rule, state: state[1]) if foot else (lambda rule, state: 0.0)


def _held(rule, shape, p, force, elastic, overlap, state):
    """Energy of the unloading curve at the overlap `elastic` past its foot, where it carries `force`."""


@overload(_held)
def _held_by(rule, shape, p, force, elastic, overlap, state):
    if rule.instance_class is Given:
        return lambda rule, shape, p, force, elastic, overlap, state: (
            energy(*unloading_curve(shape, p)[:2], elastic) if elastic > 0.0 else 0.0
        )
    if rule_of(rule.instance_class).curve == "law":
        return lambda rule, shape, p, force, elastic, overlap, state: (
            dispatch.stored_and_dissipated(rule, shape, p, overlap, state)[0] if elastic > 0.0 else 0.0
        )
    return lambda rule, shape, p, force, elastic, overlap, state: 0.4 * force * elastic


def _blur(rule, force, stiffness):
    """Work [J] that rounding of the force alone makes of a curve that is sought by its force: P ε of P is P ε/K of overlap."""


@overload(_blur)
def _blur_by(rule, force, stiffness):
    if rule.instance_class is Given:
        return lambda rule, force, stiffness: 4.0 * 2.0**-52 * force * force / stiffness if stiffness > 0.0 else 0.0
    return lambda rule, force, stiffness: 0.0


@loop
def finite_loop(shape, params, contacts, largest, count, random):
    """Random first loading from denormal overlaps to `largest`: not finite, negative, decreasing."""
    bad = 0
    falling = 0
    for n in range(count):
        i = n % contacts
        p = gather(params, i)
        top = math.log10(largest[i])
        overlap = 10.0 ** (top + (-323.3 - top) * random.random()) if n % 2 else 10.0 ** (top - 16.0 * random.random())
        force, stiffness, equivalent, _ = first_loading(shape, p, overlap)
        finite = force - force == 0.0 and stiffness - stiffness == 0.0 and equivalent - equivalent == 0.0
        if not (finite and force >= 0.0 and stiffness >= 0.0):
            bad += 1
        else:
            further = first_loading(shape, p, overlap * (1.0 + 1e-12))[0]
            if further < force * (1.0 - 4.5e-16):
                falling += 1
    return bad, falling


@kernel
def _drawn(random, smallest, largest, maximum):
    """A random overlap at any scale, or after first loading as likely a reversal at any scale about the maximum."""
    if random.random() < 0.5 or maximum == 0.0:
        low, high = math.log(smallest), math.log(largest)
        return math.exp(low + (high - low) * random.random())
    overlap = maximum * (1.0 + (2.0 * random.random() - 1.0) * 10.0 ** (-15.0 * random.random()))
    return min(overlap, largest)


@kernel
def _held_at(rule, shape, p, overlap, force, plastic, state):
    """`_held` where `step` returned `force`: with a seating load force ends in a step at zero overlap."""
    closing = max(overlap, 1e-300)
    last = force if overlap > 0.0 else dispatch.step(rule, shape, p, closing, state)[0]
    return _held(rule, shape, p, last, max(closing - plastic, 0.0), closing, state)


@loop
def path_loop(rule, shape, params, state, contacts, smallest, largest, paths, turns, random):
    """Random load paths with excursions that come back: how many return work, by how much, and values not finite.

    Work of first loading is the law's energy, on a Hertz-like unloading curve 0.4 (P x) from the forces that `step` returned,
    on a given one that curve's energy, on one of the law's own the stored energy of the rule. Where a given curve is flat, what
    rounding of its force makes of the overlap is allowed.
    """
    returned, worst, bad = 0, 0.0, 0
    for n in range(paths):
        i = n % contacts
        p = gather(params, i)
        s = gather(state, 0)
        before = force_before = maximum = peak_force = 0.0
        held = 0.0  # energy of first loading to the maximum
        curve = 0.0  # largest energy of the curves so far
        work = work_at_mark = low_work = blur = 0.0
        mark = -1.0
        for k in range(turns + 1):
            if k == turns:
                overlap = 0.0
            elif mark >= 0.0:
                overlap = mark  # back from the excursion
            else:
                overlap = _drawn(random, smallest[i], largest[i], maximum)
            force, stiffness, new = dispatch.step(rule, shape, p, overlap, s)
            if not (force - force == 0.0 and stiffness - stiffness == 0.0) or force < 0.0 or stiffness < 0.0:
                bad += 1
            gained = 0.0
            if len(s) == 0:
                now = energy(shape, p, overlap) if overlap > 0.0 else 0.0
                gained = now - (energy(shape, p, before) if before > 0.0 else 0.0)
                held = max(held, now)
            else:
                plastic = _plastic(rule, s) if before > 0.0 else 0.0
                rest = max(before - plastic, 0.0)
                if overlap >= maximum:
                    if maximum > 0.0:
                        gained = _held(rule, shape, p, peak_force, max(maximum - plastic, 0.0), maximum, s)
                        gained -= _held(rule, shape, p, force_before, rest, before, s)
                    now = energy(shape, p, overlap) if overlap > 0.0 else 0.0
                    gained += now - held
                    held, maximum, peak_force = now, overlap, force
                    blur = max(blur, _blur(rule, force, stiffness))
                else:
                    gained = _held_at(rule, shape, p, overlap, force, plastic, s) - _held(
                        rule, shape, p, force_before, rest, before, s
                    )
            work += gained
            # a seated contact's unloading curve begins below zero overlap: rounding is that of its whole energy
            scale = max(held, 0.4 * peak_force * (maximum - _plastic(rule, new)) if maximum > 0.0 else 0.0)
            curve = max(curve, scale)
            if curve > 0.0:
                if mark >= 0.0:
                    low_work = min(low_work, (work - work_at_mark + blur) / curve)
                if k == turns:
                    low_work = min(low_work, (work + blur) / curve)
            if mark >= 0.0:
                mark = -1.0
            elif k < turns - 1 and random.random() < 0.4:
                mark = overlap
                work_at_mark = work
            before, force_before, s = overlap, force, new
        worst = min(worst, low_work)
        if low_work < -1e-11:
            returned += 1
    return returned, worst, bad
