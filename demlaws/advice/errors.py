"""How far a law is from a reference on the same contacts and loads: force, stiffness, overlap, energy, restitution."""

from typing import NamedTuple

import numpy as np

from demlaws.contact import Contact
from demlaws.core.loops import energies_loop, energy_loop, force_loop, inverse_loop, unloaded_loop
from demlaws.errors import quiet

QUANTITIES = {
    "force": "force at equal overlap, over the contact's largest force so far",
    "stiffness": "tangent stiffness at equal force, relative",
    "overlap": "overlap at equal force, over the overlap at the largest force so far",
    "energy": "work of loading to equal force and what a cycle dissipates, over the work of loading",
    "restitution": "restitution coefficient at equal energy of impact, absolute",
}
FRACTIONS = (0.01, 0.1, 0.3, 0.6, 0.9, 0.99)
"""Forces of unloading, over the largest force so far, at which cyclic scenes are compared."""


class Sample(NamedTuple):
    """Contacts of a scene, each with the largest force that it has carried."""

    contact: Contact
    peak: np.ndarray  # [N]


class Loaded:
    """A law on a sample, loaded to the peak forces."""

    def __init__(self, law, sample):
        self.law, self.sample = law, sample
        self.top = np.atleast_1d(law.overlap(sample.peak))  # overlap [m] of first loading

    def state_at(self, top):
        """State, force [N] and stiffness [N/m] after first loading to each overlap `top` [m]."""
        state = self.law.new_state(top.size)
        force, stiffness = self.law.evaluate(top, state)
        return state, np.asarray(force, float), np.asarray(stiffness, float)

    def unloaded(self, state, force):
        """Overlap at `force` after the peak."""
        if not state.arrays:
            return inverse_loop(self.law.shape, self.law.params, force)
        return unloaded_loop(self.law.rule_tag, self.law.shape, self.law.params, force, state.arrays)

    def again(self, overlap, state):
        """Force and stiffness at `overlap` after the peak."""
        force, stiffness = self.law.evaluate(np.asarray(overlap), state.copy())
        return np.asarray(force, float), np.asarray(stiffness, float)

    def energies(self, top):
        """Work of loading to `top`, and the part that unloading does not return."""
        work = np.asarray(self.law.energy(np.asarray(top, float)), float)
        state, _, _ = self.state_at(top)
        rule, pair = self.law.rule_tag, (self.law.shape, self.law.params)
        return work, energies_loop(rule, *pair, np.asarray(top, float), state.arrays)[1]

    def overlap_of_work(self, work):
        """Overlap at which loading has taken `work`; not a number where the law ends before.

        Newton's method for ln W over ln δ, nearly a straight line in every law.
        """
        pair = self.law.shape, self.law.params
        overlap = np.maximum(self.top.astype(float), 1e-9 * np.asarray(self.law.contact.radius))
        for _ in range(60):
            energy, (force, _) = energy_loop(*pair, overlap), force_loop(*pair, overlap)
            step = np.log(work / energy) * energy / (force * overlap)
            step = np.where(np.isfinite(step), np.clip(step, -2.0, 2.0), -0.7)  # beyond a table's end: half of it
            overlap *= np.exp(step)
            if np.all(np.abs(step) < 1e-13):
                break
        return np.where(np.abs(step) < 1e-9, overlap, np.nan)


def error_of(law, reference, sample, quantity, unloads):
    """Error of `law` against `reference` for each contact of `sample`, as `QUANTITIES` define it."""
    with quiet(), np.errstate(all="ignore"):
        exact, candidate = Loaded(reference, sample), Loaded(law, sample)
        return _MEASURES[quantity](exact, candidate, sample, unloads)


def _force_error(exact, candidate, sample, unloads):
    state, _, _ = exact.state_at(exact.top)
    other, force, _ = candidate.state_at(exact.top)
    worst = np.abs(force - sample.peak) / sample.peak
    for fraction in FRACTIONS if unloads else ():
        overlap = exact.unloaded(state, fraction * sample.peak)
        true, _ = exact.again(overlap, state)  # below a seating load no overlap carries that force
        force, _ = candidate.again(overlap, other)
        worst = np.maximum(worst, np.abs(force - true) / sample.peak)
    return worst


def _stiffness_error(exact, candidate, sample, unloads):
    state, _, stiffness = exact.state_at(exact.top)
    other, _, other_stiffness = candidate.state_at(candidate.top)
    worst = np.abs(other_stiffness / stiffness - 1.0)
    for fraction in FRACTIONS if unloads else ():
        force = fraction * sample.peak
        stiffness = exact.again(exact.unloaded(state, force), state)[1]
        other_stiffness = candidate.again(candidate.unloaded(other, force), other)[1]
        worst = np.maximum(worst, np.where(stiffness > 0.0, np.abs(other_stiffness / stiffness - 1.0), 0.0))
    return worst


def _overlap_error(exact, candidate, sample, unloads):
    state, _, _ = exact.state_at(exact.top)
    other, _, _ = candidate.state_at(candidate.top)
    worst = np.abs(candidate.top / exact.top - 1.0)
    for fraction in (0.0, *FRACTIONS) if unloads else ():
        force = fraction * sample.peak
        worst = np.maximum(worst, np.abs(candidate.unloaded(other, force) - exact.unloaded(state, force)) / exact.top)
    return worst


def _energy_error(exact, candidate, sample, unloads):
    work, loss = exact.energies(exact.top)
    other_work, other_loss = candidate.energies(candidate.top)
    worst = np.abs(other_work / work - 1.0)
    return np.maximum(worst, np.abs(other_loss - loss) / work) if unloads else worst


def _restitution_error(exact, candidate, sample, unloads):
    work, loss = exact.energies(exact.top)
    other_work, other_loss = candidate.energies(candidate.overlap_of_work(work))
    return np.abs(np.sqrt(np.maximum(1.0 - other_loss / other_work, 0.0)) - np.sqrt(np.maximum(1.0 - loss / work, 0.0)))


_MEASURES = {
    "force": _force_error,
    "stiffness": _stiffness_error,
    "overlap": _overlap_error,
    "energy": _energy_error,
    "restitution": _restitution_error,
}
