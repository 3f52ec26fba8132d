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
    """A law on contacts of a sample after first loading: to the peak forces [N], or to overlaps `top` [m]."""

    def __init__(self, law, peak, top=None):
        self.law, self.pair = law, (law.shape, law.params)
        self.top = np.atleast_1d(law.overlap(peak)) if top is None else top
        self.state = law.new_state(self.top.size)
        self.force, self.stiffness = law.evaluate(self.top, self.state)

    def unloaded(self, force):
        """Overlap at `force` after the peak."""
        if not self.state.arrays:
            return inverse_loop(*self.pair, force)
        return unloaded_loop(self.law.rule_tag, *self.pair, force, self.state.arrays)

    def at(self, overlap):
        """Force and stiffness at `overlap` after the peak."""
        return self.law.evaluate(overlap, self.state.copy())

    def energies(self):
        """Work of loading, and the part that unloading does not return."""
        return self.law.energy(self.top), energies_loop(self.law.rule_tag, *self.pair, self.top, self.state.arrays)[1]

    def overlap_of_work(self, work):
        """Overlap at which loading has taken `work`; not a number where the law ends before.

        Newton's method for ln W over ln δ, nearly a straight line in every law.
        """
        overlap = np.maximum(self.top, 1e-9 * np.asarray(self.law.contact.radius))
        for _ in range(60):
            energy, (force, _) = energy_loop(*self.pair, overlap), force_loop(*self.pair, overlap)
            step = np.log(work / energy) * energy / (force * overlap)
            step = np.where(np.isfinite(step), np.clip(step, -2.0, 2.0), -0.7)  # beyond a table's end: half of it
            overlap *= np.exp(step)
            if np.all(np.abs(step) < 1e-13):
                break
        return np.where(np.abs(step) < 1e-9, overlap, np.nan)


def error_of(law, reference, sample, quantity, unloads):
    """Error of `law` against `reference` for each contact of `sample`, as `QUANTITIES` define it."""
    with quiet(), np.errstate(all="ignore"):
        errors = _MEASURES[quantity](Loaded(reference, sample.peak), law, sample.peak, FRACTIONS if unloads else ())
        return np.max(np.abs(errors), axis=0)


def _force_errors(exact, law, peak, fractions):
    candidate = Loaded(law, peak, exact.top)
    unloaded = [exact.unloaded(fraction * peak) for fraction in fractions]
    # below a seating load no overlap carries that force: the exact one is evaluated, too
    return [(candidate.force - peak) / peak, *((candidate.at(one)[0] - exact.at(one)[0]) / peak for one in unloaded)]


def _stiffness_errors(exact, law, peak, fractions):
    candidate = Loaded(law, peak)
    errors = [candidate.stiffness / exact.stiffness - 1.0]
    for fraction in fractions:
        true, stiffness = (one.at(one.unloaded(fraction * peak))[1] for one in (exact, candidate))
        errors.append(np.where(true > 0.0, stiffness / true - 1.0, 0.0))
    return errors


def _overlap_errors(exact, law, peak, fractions):
    candidate = Loaded(law, peak)
    unloaded = [candidate.unloaded(f * peak) - exact.unloaded(f * peak) for f in ((0.0, *fractions) if fractions else ())]
    return [(difference / exact.top) for difference in (candidate.top - exact.top, *unloaded)]


def _energy_errors(exact, law, peak, fractions):
    (work, loss), (other_work, other_loss) = exact.energies(), Loaded(law, peak).energies()
    return [other_work / work - 1.0, (other_loss - loss) / work if fractions else np.zeros(peak.size)]


def _restitution_errors(exact, law, peak, fractions):
    work, loss = exact.energies()
    other_work, other_loss = Loaded(law, peak, Loaded(law, peak).overlap_of_work(work)).energies()
    return [np.sqrt(np.maximum(1.0 - other_loss / other_work, 0.0)) - np.sqrt(np.maximum(1.0 - loss / work, 0.0))]


_MEASURES = {
    "force": _force_errors,
    "stiffness": _stiffness_errors,
    "overlap": _overlap_errors,
    "energy": _energy_errors,
    "restitution": _restitution_errors,
}
