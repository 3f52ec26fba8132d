"""Errors of a law against its 50-digit reference over random contacts, in units of ε = 2.2e-16."""

from typing import NamedTuple

import numpy as np
from examples import quiet
from references import REFERENCES, errors

import demlaws as dl


class Errors(NamedTuple):
    """One entry a contact, in ε."""

    force: np.ndarray
    stiffness: np.ndarray
    overlap: np.ndarray
    energy: np.ndarray


def contacts(rng, n, **shared):
    """n contacts: E* 1e5 to 1e12 Pa, R 1e-6 to 1 m, σ/R 1e-7 to 0.1."""
    radius = 10.0 ** rng.uniform(-6, 0, n)
    return dl.Contact(
        radius=radius,
        modulus=10.0 ** rng.uniform(5, 12, n),
        roughness=radius * 10.0 ** rng.uniform(-7, -1, n),
        **shared,
    )


def overlaps(rng, contact):
    """δ/σ from 1e-9 to 1e6, and up to R, beyond which there is no answer."""
    return np.minimum(contact.roughness * 10.0 ** rng.uniform(-9, 6, contact.size), 0.999 * contact.radius)


def measure(name, contact, overlap, energy=True, **options):
    """Errors at `overlap`, one a contact, and the references."""
    law = dl.law(name, contact, **options)
    force, stiffness = quiet(law.force, overlap), quiet(law.stiffness, overlap)
    back, work = quiet(law.overlap, force), law.energy(overlap)
    references = [
        REFERENCES[name](
            radius=contact.radius[i],
            modulus=contact.modulus[i],
            roughness=contact.roughness[i],
            fractal_dimension=contact.fractal_dimension,
            hardness=contact.hardness,
            **options,
        )
        for i in range(contact.size)
    ]
    pairs = list(zip(references, overlap, strict=True))
    return references, Errors(
        errors(force, [r.force(d) for r, d in pairs]),
        errors(stiffness, [r.stiffness(d) for r, d in pairs]),
        errors(back, [r.overlap(f) for r, f in zip(references, force, strict=True)]),
        errors(work, [r.energy(d) for r, d in pairs]) if energy else np.zeros(contact.size),
    )


def check(measured, largest, mean, fields=("force", "stiffness", "overlap", "energy")):
    for name in fields:
        values = getattr(measured, name)
        assert values.max() <= largest, f"{name}: {values.max():.2f} ε, mean {values.mean():.2f} ε"
        assert values.mean() <= mean, f"{name}: mean {values.mean():.2f} ε, largest {values.max():.2f} ε"
