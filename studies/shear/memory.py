"""Whether a contact that carries shear keeps its force, and stays, while its overlap vibrates: one contact, in Python."""

from typing import NamedTuple

import numpy as np

import demlaws as dl
from demlaws import shear
from demlaws.core.dispatch import gather, scatter, step
from demlaws.core.levels import follow_stiffness, force_of_levels
from demlaws.core.numba_compat import loop
from demlaws.core.shear import CHOICES, DEFAULT, shear_stiffness
from demlaws.errors import quiet
from demlaws.make import example_law
from studies.shear.gas import CONTACT

RATIO, FRICTION, LOAD = 2 * (1 - 0.25) / (2 - 0.25), 0.5, 10.0
LAWS = (("hertz", "elastic"), ("pohrt-popov", "elastic"), ("pohrt-popov", "hertz"), ("rough-plastic", "thornton"))
PARTS = 4
"""Steps between two turning points of the overlap."""
EVERY = 2000
"""Levels with which no two springs are joined that matter: those that vibration makes are far fewer."""
shear.MOST_LEVELS = EVERY  # more than `sheared` takes: the reference


class Vibration(NamedTuple):
    """Turning points of an overlap: regular, or normally distributed."""

    size: float  # of the overlap
    noise: bool
    cycles: int

    def path(self):
        """Overlaps over that at rest: loaded in 100 steps, then vibrated, at last as at rest."""
        noise = np.random.default_rng(1).standard_normal(2 * self.cycles)
        ends = 1.0 + self.size * (noise if self.noise else np.tile([-1.0, 1.0], self.cycles))
        turns = np.concatenate([[1.0], ends, [1.0]])
        return np.concatenate([np.linspace(0.01, 1.0, 100), np.linspace(turns[:-1], turns[1:], PARTS + 1)[1:].T.ravel()])


def specimen(name, rule):
    """Law, overlap at the load and K_t there."""
    with quiet():
        law = example_law(name, CONTACT, rule)
        overlap = law.overlap(LOAD)
        return law, overlap, law.shear_stiffness([overlap], RATIO)[0]


def retained(case, vibration, levels):
    """Share of the shear force, half of Coulomb's limit, that is left after a vibration at constant displacement."""
    law, overlap, stiffness = specimen(*case)
    path = vibration.path()
    sideways = np.where(np.arange(path.size) < 99, 0.0, 0.5 * FRICTION * LOAD / stiffness)
    with quiet():
        force = dl.driver.sheared(law, overlap * path, sideways, RATIO, friction=FRICTION, levels=levels).shear_force
    return float(force[-1] / force[100])


@loop
def creep_loop(choice, rule, shape, p, overlap, ratio, load, state, bound, stretch):
    """Displacements [m] of a contact under a constant shear force [N], from point 99 of a path of overlaps on."""
    places = np.zeros(overlap.size)
    for n in range(overlap.size):
        force, tangent, new = step(rule, shape, p, overlap[n], gather(state, 0))
        scatter(state, 0, new)
        follow_stiffness(bound, stretch, ratio * shear_stiffness(choice, rule, shape, p, overlap[n], force, tangent, new))
        if n >= 99:
            moved = (load - force_of_levels(bound, stretch)[0]) / bound[-1]
            places[n] = places[n - 1] + moved
            for i in range(bound.size):
                stretch[i, 0] += moved
    return places


def creep(case, vibration, levels):
    """Displacements under half of Coulomb's limit after each cycle of a vibration, over that without one."""
    law, overlap, stiffness = specimen(*case)
    load, tag, rows = 0.5 * FRICTION * LOAD, CHOICES[DEFAULT].tag, (np.zeros(levels), np.zeros((levels, 3)))
    path, state = overlap * vibration.path(), law.new_state(1)
    places = creep_loop(tag, law.rule_tag, law.shape, law.params, path, RATIO, load, state.arrays, *rows)
    return places[99 :: 2 * PARTS] * stiffness / load


VIBRATIONS = tuple(Vibration(size, noise, 2000 if noise else 1000) for size in (1e-3, 1e-2, 0.1) for noise in (False, True))
CREEP = Vibration(1e-2, True, 10_000)


def print_table():
    """A row per law and vibration: what one, two, three levels and all springs keep, and how far they creep."""
    print("| law, rule | vibration | kept: 1, 2, 3 levels, all springs | creep after 10,000 of 1 % noise: the same |")
    print("|---|---|---|---|")
    for name, rule in LAWS:
        moved = ", ".join(f"{creep((name, rule), CREEP, levels)[-1]:.3f}" for levels in (1, 2, 3, EVERY))
        for vibration in VIBRATIONS:
            kept = ", ".join(f"{retained((name, rule), vibration, levels):.3f}" for levels in (1, 2, 3, EVERY))
            kind = f"{vibration.cycles:,} of ±{vibration.size:.3g}{' (noise)' if vibration.noise else ''}"
            print(f"| {name}, {rule} | {kind} | {kept} | {moved} |", flush=True)
            moved = ""
