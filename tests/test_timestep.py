"""Stable time steps: closed forms, estimates compared with exact limits, and packings integrated by velocity Verlet."""

import functools
import itertools
import math

import numpy as np
import pytest
from examples import make, shared
from packings import CELLS, lattice, random_packing

import demlaws as dl
from demlaws.advice.scene import stable_step
from demlaws.timestep import (
    SOFTENING_SAFETY,
    STEP_SAFETY,
    from_contacts,
    packing_limit,
    pair_limit,
    stiffest,
)

RATIOS = (0.0, 0.3, 0.857, 1.0)
X = [1.0, 0.0, 0.0]


# --- closed forms


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("other", [1e-3, 5e-3, math.inf])
def test_pair_and_wall(ratio, other):
    """Two bodies, equal and unlike, and one on a wall: estimate, exact limit and bound are one."""
    limits = from_contacts([[0, 1]], [X], 1e6, ratio * 1e6, [1e-3, other])
    assert limits.exact == pytest.approx(pair_limit(1e6, 1e-3, other, ratio), rel=1e-9)
    assert limits.bound == pytest.approx(limits.exact, rel=1e-9)
    assert pair_limit(1e6, 1e-3, other, 0.0) == pytest.approx(2.0 / math.sqrt(1e6 * (1e3 + 1.0 / other)), rel=1e-12)


# --- the estimate and the bound compared with the exact limit


@functools.cache
def packing(kind):
    if kind in CELLS:
        return lattice(kind)
    size_ratio, share, seed, *two_sizes = kind.split()
    return random_packing(float(size_ratio), float(share), int(seed), bool(two_sizes))


RANDOM = [f"{sizes} {share} {seed}" for sizes in (1, 1.5, 2, 3, 4) for share, seed in ((0.65, 1), (0.7, 2))]
RANDOM += ["1.4 0.65 3 two", "2 0.66 4 two", "3 0.66 5 two"]


@pytest.mark.parametrize("kind", shared([*CELLS, *RANDOM], {*CELLS, *RANDOM[::5]}.__contains__))
def test_estimate_and_bound_are_half_to_all_of_the_exact_limit(kind):
    """Lattices and random packings of radii from 1 to 4; equal stiffness, and forces and stiffnesses as of rough contacts."""
    grains = packing(kind)
    reduced = 1.0 / np.sum(1.0 / grains.radius[grains.pairs], axis=1)
    stiffnesses = [np.ones(len(grains.pairs))]
    if kind not in CELLS:
        stiffnesses += [(grains.overlap * reduced) ** (1 / 3), grains.overlap**0.6 * reduced**0.4]
    sizes = grains.radius.mean() / grains.radius.min()
    for stiffness, ratio in itertools.product(stiffnesses, RATIOS):
        limits = from_contacts(grains.pairs, grains.normals, stiffness, ratio * stiffness, grains.mass)
        largest = np.max(stiffness / grains.mass[grains.pairs].min(axis=1))
        estimate = packing_limit(largest, 1.0, grains.coordination, ratio, sizes)
        assert 0.5 <= estimate / limits.exact <= 1.0, (ratio, estimate / limits.exact)
        assert 0.85 <= limits.bound / limits.exact <= 1.0 + 1e-6, (ratio, limits.bound / limits.exact)


@pytest.mark.parametrize("kind", ["sc", "bcc"])
def test_lattices_with_all_contacts_alike_have_a_closed_form(kind):
    """ω² = 2/3 Z max(1 + 2r, 5r) K/m."""
    grains = packing(kind)
    for ratio in RATIOS:
        exact = from_contacts(grains.pairs, grains.normals, 1.0, ratio, grains.mass).exact
        square = 2 / 3 * grains.coordination * max(1 + 2 * ratio, 5 * ratio)
        assert exact == pytest.approx(2.0 / math.sqrt(square), rel=1e-5)


LAW = dl.law("hertz", dl.Contact(radius=2e-3, modulus=32.32e9))
MASS = 4 / 3 * math.pi * (4e-3) ** 3 * 2680


# --- dl.timestep


def test_default_is_safe_for_several_contacts():
    """The former step was 1.13 times the limit of two free equal grains, and 2 to 3 times that of lattices."""
    stiffness = stiffest(LAW, 100.0)
    step = dl.timestep(LAW, MASS, 100.0)
    assert step < STEP_SAFETY * pair_limit(stiffness, MASS, MASS)
    assert 1.6 * math.sqrt(MASS / stiffness) > 1.13 * pair_limit(stiffness, MASS, MASS, 0.0)
    for kind in CELLS:  # also where the coordination is higher than the default one
        grains = packing(kind)
        assert step < from_contacts(grains.pairs, grains.normals, stiffness, stiffness, MASS * grains.mass).exact


def test_step_of_bodies_alone():
    """other_mass: two bodies or a wall; the safety factor depends on the law."""
    for name, rule, safety in (("pohrt-popov", "hertz", STEP_SAFETY), ("conical-damage", "elastic", SOFTENING_SAFETY)):
        law = make(name, rule)
        for other in (0.01, 0.03, math.inf):
            step = dl.timestep(law, 0.01, 500.0, other_mass=other, shear_ratio=0.5)
            assert step == pytest.approx(safety * pair_limit(stiffest(law, 500.0), 0.01, other, 0.5), rel=1e-12)


def test_scene_of_unlike_grains():
    """Small grains between large ones: the stiffness is that of unlike radii, the mass that of the small one."""
    scene = dl.Scene(
        radii=(4e-3, 12e-3), materials=dl.Material(60.6e9, 0.25, density=2680.0), force=(1.0, 100.0), coordination=8
    )
    step = stable_step(scene, lambda contact: dl.law("hertz", contact))
    contact = scene.contacts(3e-3)[0]  # of 4 and 12 mm
    stiffness = dl.law("hertz", contact).stiffness(dl.law("hertz", contact).overlap(100.0))
    grains = packing("bcc")  # with large grains on one of its two lattices
    masses = MASS * np.where(np.arange(len(grains.radius)) < len(grains.radius) // 2, 1.0, 27.0)
    exact = from_contacts(grains.pairs, grains.normals, stiffness, 0.857 * stiffness, masses).exact
    assert 0.4 * exact < step < STEP_SAFETY * exact
    assert stable_step(scene.__class__(**{**vars(scene), "walls": True}), lambda c: dl.law("hertz", c)) < step


@pytest.mark.parametrize(
    "call",
    [
        lambda: from_contacts([], [], 1.0, 1.0, [1.0]),
        lambda: from_contacts([[0, 0]], [X], 1.0, 1.0, [1.0]),
        lambda: from_contacts([[0, 2]], [X], 1.0, 1.0, [1.0, 1.0]),
        lambda: from_contacts([[0, 1]], [[2.0, 0.0, 0.0]], 1.0, 1.0, [1.0, 1.0]),
        lambda: from_contacts([[0, 1]], [X], math.nan, 1.0, [1.0, 1.0]),
        lambda: from_contacts([[0, 1]], [X], 0.0, 0.0, [1.0, 1.0]),
        lambda: from_contacts([[0, 1]], [X], 1.0, 1.0, [math.inf, math.inf]),
        lambda: from_contacts([[0, 1]], [X], 1.0, 1.0, [-1.0, 1.0]),
    ],
)
def test_bad_calls(call):
    with pytest.raises(dl.DemlawsError):
        call()
