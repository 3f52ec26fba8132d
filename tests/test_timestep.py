"""Stable time steps: closed forms, estimates compared with exact limits, and packings integrated by velocity Verlet."""

import functools
import itertools
import math

import numpy as np
import pytest
from examples import GRANITE, each_law_and_rule, make, options_of, quiet, shared
from packings import CELLS, lattice, random_packing

import demlaws as dl
from demlaws.advice.scene import stable_step
from demlaws.make import example_law
from demlaws.timestep import (
    SOFTENING_SAFETY,
    STEP_SAFETY,
    UNDAMPED_SAFETY,
    from_contacts,
    packing_estimate,
    pair_limit,
    stiffest,
    stiffest_now,
)

RATIOS = (0.0, 0.3, 0.857, 1.0)
X = [1.0, 0.0, 0.0]


# --- closed forms


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("other", [1e-3, 5e-3, math.inf])
def test_pair_and_wall(ratio, other):
    """Two bodies, equal and unlike, and one on a wall: the closed form is the exact limit."""
    exact = from_contacts([[0, 1]], [X], 1e6, shear_stiffness=ratio * 1e6, masses=[1e-3, other])
    assert exact == pytest.approx(pair_limit(1e6, 1e-3, other, shear_ratio=ratio), rel=1e-9)
    assert pair_limit(1e6, 1e-3, other, shear_ratio=0.0) == pytest.approx(2.0 / math.sqrt(1e6 * (1e3 + 1.0 / other)), rel=1e-12)


# --- the estimate compared with the exact limit


@functools.cache
def packing(kind):
    if kind in CELLS:
        return lattice(kind)
    size_ratio, share, seed, *two_sizes = kind.split()
    return random_packing(float(size_ratio), float(share), int(seed), bool(two_sizes))


RANDOM = [f"{sizes} {share} {seed}" for sizes in (1, 1.5, 2, 3, 4) for share, seed in ((0.65, 1), (0.7, 2))]
RANDOM += ["1.4 0.65 3 two", "2 0.66 4 two", "3 0.66 5 two"]


@pytest.mark.parametrize("kind", shared([*CELLS, *RANDOM], {*CELLS, *RANDOM[::5]}.__contains__))
def test_estimate_is_half_to_all_of_the_exact_limit(kind):
    """Lattices and random packings of radii from 1 to 4; equal stiffness, and forces and stiffnesses as of rough contacts."""
    grains = packing(kind)
    reduced = 1.0 / np.sum(1.0 / grains.radius[grains.pairs], axis=1)
    stiffnesses = [np.ones(len(grains.pairs))]
    if kind not in CELLS:
        stiffnesses += [(grains.overlap * reduced) ** (1 / 3), grains.overlap**0.6 * reduced**0.4]
    sizes = grains.radius.mean() / grains.radius.min()
    for stiffness, ratio in itertools.product(stiffnesses, RATIOS):
        exact = from_contacts(grains.pairs, grains.normals, stiffness, shear_stiffness=ratio * stiffness, masses=grains.mass)
        largest = np.max(stiffness / grains.mass[grains.pairs].min(axis=1))
        estimate = packing_estimate(largest, 1.0, grains.coordination, shear_ratio=ratio, size_ratio=sizes)
        assert 0.5 <= estimate / exact <= 1.0, (ratio, estimate / exact)


@pytest.mark.parametrize("kind", ["sc", "bcc"])
def test_lattices_with_all_contacts_alike_have_a_closed_form(kind):
    """ω² = 2/3 Z max(1 + 2r, 5r) K/m."""
    grains = packing(kind)
    for ratio in RATIOS:
        exact = from_contacts(grains.pairs, grains.normals, 1.0, shear_stiffness=ratio, masses=grains.mass)
        square = 2 / 3 * grains.coordination * max(1 + 2 * ratio, 5 * ratio)
        assert exact == pytest.approx(2.0 / math.sqrt(square), rel=1e-5)


ROUND_A_HUB = np.array([v for v in itertools.product((-1, 0, 1), repeat=3) if np.dot(v, v) == 2]) / math.sqrt(2.0)


def limits_of_hubs(count, ratio):
    """A row of touching grains that have 12 contacts each, with neighbours that touch nothing else."""
    row = [2.0 * k * ROUND_A_HUB[0] for k in range(count)]
    centres = np.unique(np.round(np.concatenate([row, *(hub + 2.0 * ROUND_A_HUB for hub in row)]), 9), axis=0)
    is_hub = np.array([min(np.linalg.norm(centre - hub) for hub in row) < 1e-6 for centre in centres])
    between = centres[:, None] - centres[None]
    touching = (np.abs(np.linalg.norm(between, axis=2) - 2.0) < 1e-6) & (is_hub[:, None] | is_hub[None])
    pairs = np.argwhere(np.triu(touching))
    exact = from_contacts(pairs, 0.5 * between[tuple(pairs.T)], 1.0, shear_stiffness=ratio, masses=np.ones(len(centres)))
    return exact, np.bincount(pairs.ravel())


@pytest.mark.parametrize("ratio", RATIOS)
def test_few_grains_with_many_contacts(ratio):
    """Grains with 12 contacts alone, in pairs (the estimate is valid) and in a row (it is not)."""
    for count in (1, 2, 8):
        exact, contacts = limits_of_hubs(count, ratio)
        assert 0.8 < packing_estimate(1.0, 1.0, contacts.mean(), shear_ratio=ratio) / exact < (1.0 if count < 8 else 1.15)


@pytest.mark.parametrize("ratio", RATIOS)
def test_a_grain_of_100_contacts_as_light_as_its_neighbours(ratio):
    height = 1.0 - 2.0 * (np.arange(100) + 0.5) / 100
    around = np.pi * (3.0 - math.sqrt(5.0)) * np.arange(100)
    level = np.sqrt(1.0 - height**2)
    normals = np.column_stack([level * np.cos(around), level * np.sin(around), height])
    pairs = np.column_stack([np.zeros(100, int), np.arange(1, 101)])
    exact = from_contacts(pairs, normals, 1.0, shear_stiffness=ratio, masses=np.ones(101))
    assert 2.0 < packing_estimate(1.0, 1.0, shear_ratio=ratio) / exact < 2.5  # as its docstring states


def test_light_large_grains_are_out_of_the_scope_of_the_estimate():
    """Five grains of three times the radius and the same mass."""
    random = np.random.default_rng(1)
    radius = np.where(np.arange(160) < 5, 1.5, 0.5)
    edge = (np.sum(4 / 3 * np.pi * radius**3) / 0.66) ** (1 / 3)
    centres = edge * random.random((160, 3))
    for _ in range(500):
        between = centres[:, None] - centres[None]
        between -= edge * np.round(between / edge)
        distance = np.linalg.norm(between, axis=2) + np.eye(160)
        overlap = radius[:, None] + radius[None] - distance
        np.fill_diagonal(overlap, 0.0)
        centres = centres + 0.3 * np.sum((np.maximum(overlap, 0.0) / distance)[:, :, None] * between, axis=1)
    pairs = np.argwhere(np.triu(overlap > 0.0))
    stiffness = np.sqrt(1.0 / np.sum(1.0 / radius[pairs], axis=1))
    normals = between[tuple(pairs.T)] / distance[tuple(pairs.T)][:, None]
    contacts = np.bincount(pairs.ravel())
    for ratio in (0.0, 0.857):
        exact = from_contacts(pairs, normals, stiffness, shear_stiffness=ratio * stiffness, masses=np.ones(160))
        estimate = packing_estimate(stiffness.max(), 1.0, contacts[contacts > 0].mean(), shear_ratio=ratio)
        assert exact < 1.3 * estimate
        assert STEP_SAFETY * estimate < exact


# --- the present stiffness of contacts with a history


@pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")
@each_law_and_rule
def test_stiffest_tangent_of_a_history(name, unloading):
    """Contacts that have carried ten times their force."""
    law = make(name, unloading)
    grains = GRANITE.with_values(radius=GRANITE.radius * np.ones(2))
    batch = example_law(name, grains, unloading, **options_of(name))
    peak = float(quiet(law.overlap, 20.0))
    state = law.new_state(1)
    quiet(law.follow, [peak], state)
    overlap = float(law.unloading_overlap(2.0, state)) if law.state_size else float(law.overlap(2.0))
    true = max(float(quiet(law.follow, [overlap], state).stiffness[0]), float(quiet(law.stiffness, law.overlap(2.0))))
    force = np.full(2, 2.0)
    known = quiet(stiffest_now, batch, force, np.full(2, peak))
    assert known == pytest.approx(true, rel=1e-6)


def test_blocked_degrees_of_freedom():
    """A face-centred lattice without rotation, whose layers move against each other; grains that move along one axis only."""
    grains = packing("fcc")
    blocked = np.zeros((len(grains.radius), 6), bool)
    blocked[:, 3:] = True
    exact = from_contacts(grains.pairs, grains.normals, 1.0, shear_stiffness=0.857, masses=grains.mass, blocked=blocked)
    assert exact == pytest.approx(2.0 / math.sqrt(8 * 1.857), rel=1e-5)
    alone = from_contacts([[0, 1]], [X], 1.0, shear_stiffness=0.5, masses=[1.0, 1.0], blocked=[[0, 1, 1, 1, 1, 1]] * 2)
    assert alone == pytest.approx(math.sqrt(2.0), rel=1e-6)


LAW = dl.law("hertz", dl.Contact(radius=2e-3, modulus=32.32e9))
MASS = 4 / 3 * math.pi * (4e-3) ** 3 * 2680


# --- dl.timestep


def test_default_is_safe_for_several_contacts():
    """The former step was 1.13 times the limit of two free equal grains, and 2 to 3 times that of lattices."""
    stiffness = stiffest(LAW, 100.0)
    step = dl.timestep(LAW, MASS, 100.0)
    assert step < STEP_SAFETY * pair_limit(stiffness, MASS, MASS)
    assert 1.6 * math.sqrt(MASS / stiffness) > 1.13 * pair_limit(stiffness, MASS, MASS, shear_ratio=0.0)
    for kind in CELLS:  # also where the coordination is higher than the default one
        grains = packing(kind)
        assert step < from_contacts(
            grains.pairs, grains.normals, stiffness, shear_stiffness=stiffness, masses=MASS * grains.mass
        )


def test_step_of_bodies_alone():
    """other_mass: two bodies or a wall; the safety factor depends on the law."""
    for name, rule, safety in (("pohrt-popov", "hertz", STEP_SAFETY), ("conical-damage", "elastic", SOFTENING_SAFETY)):
        law = make(name, rule)
        for other in (0.01, 0.03, math.inf):
            step = dl.timestep(law, 0.01, 500.0, other_mass=other, shear_ratio=0.5)
            assert step == pytest.approx(safety * pair_limit(stiffest(law, 500.0), 0.01, other, shear_ratio=0.5), rel=1e-12)


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
    exact = from_contacts(grains.pairs, grains.normals, stiffness, shear_stiffness=0.857 * stiffness, masses=masses)
    assert 0.4 * exact < step < STEP_SAFETY * exact
    assert stable_step(scene.__class__(**{**vars(scene), "walls": True}), lambda c: dl.law("hertz", c)) < step


@pytest.mark.parametrize(
    "call",
    [
        lambda: from_contacts([], [], 1.0, shear_stiffness=1.0, masses=[1.0]),
        lambda: from_contacts([[0, 0]], [X], 1.0, shear_stiffness=1.0, masses=[1.0]),
        lambda: from_contacts([[0, 2]], [X], 1.0, shear_stiffness=1.0, masses=[1.0, 1.0]),
        lambda: from_contacts([[0, 1]], [[2.0, 0.0, 0.0]], 1.0, shear_stiffness=1.0, masses=[1.0, 1.0]),
        lambda: from_contacts([[0, 1]], [X], math.nan, shear_stiffness=1.0, masses=[1.0, 1.0]),
        lambda: from_contacts([[0, 1]], [X], 0.0, shear_stiffness=0.0, masses=[1.0, 1.0]),
        lambda: from_contacts([[0, 1]], [X], 1.0, shear_stiffness=1.0, masses=[math.inf, math.inf]),
        lambda: from_contacts([[0, 1]], [X], 1.0, shear_stiffness=1.0, masses=[-1.0, 1.0]),
        lambda: from_contacts([[0, 1]], [X], 1.0, shear_stiffness=1.0, masses=[1.0, 1.0], blocked=np.ones((2, 6))),
        lambda: from_contacts([[0, 1]], [X], 1.0, shear_stiffness=1.0, masses=[1.0, 1.0], blocked=np.zeros((2, 3))),
        lambda: pair_limit(1.0, 1.0, shear_ratio=1.34),
        lambda: packing_estimate(1.0, 1.0, 6, shear_ratio=-0.1),
        lambda: dl.timestep(LAW, 1.0, 1.0, shear_ratio=1.34),
    ],
)
def test_bad_calls(call):
    with pytest.raises(dl.DemlawsError):
        call()


def test_the_limits_are_attributes_of_the_function():
    """As the documentation has them: `dl.timestep.from_contacts`, beside `dl.timestep(law, …)`."""
    from demlaws.timestep import from_contacts

    assert dl.timestep.from_contacts is from_contacts
    assert dl.timestep.pair_limit(1e6, 1e-3, 1e-3, shear_ratio=0.0) == pytest.approx(4.4721e-5, rel=1e-4)


# --- lossless bodies that bounce


def steps_until_growth(speed, damped, most, preload=20.0):
    """Steps in which a body's kinetic energy on a wall becomes 4 times the largest at first, 0 if it does not.

    Hertz without loss under a constant force, from its equilibrium at `speed` [m/s], with the step for the peak force.
    """
    radius, modulus, mass = 4e-3, 32e9, 7.2e-4
    k = 4.0 / 3.0 * modulus * math.sqrt(radius)
    start = (preload / k) ** (2 / 3)
    peaks = np.linspace(start, 100.0 * start, 200_001)
    work = 0.4 * k * (peaks**2.5 - start**2.5) - preload * (peaks - start) - 0.5 * mass * speed**2
    peak = float(peaks[np.argmax(work > 0.0)])
    law = dl.law("hertz", dl.Contact(radius, modulus))
    dt = quiet(dl.timestep, law, mass, k * peak**1.5, other_mass=math.inf, shear_ratio=0.0, damped=damped)
    overlap, force, first = start, preload, 0.0
    for step in range(most):
        speed += dt * (preload - force) / mass
        overlap += dt * speed
        force = k * overlap * math.sqrt(overlap) if overlap > 0.0 else 0.0
        if step < 300:
            first = max(first, speed * speed)
        elif speed * speed > 4.0 * first:
            return step
    return 0


def test_bouncing_without_loss_needs_a_shorter_step():
    """At 0.8 of the limit of the peak force energy grows without end at many speeds, at 0.3 at none of them."""
    unit = 20.0 / math.sqrt(7.2e-4 * 3.36e6)  # speed of an oscillation with the amplitude of the preload
    assert [steps_until_growth(share * unit, True, 20_000) for share in (0.3, 0.6)] == [0, 0]
    fast = unit * np.geomspace(3.0, 30.0, 12)
    assert sum(steps_until_growth(speed, True, 20_000) > 0 for speed in fast) >= 6
    assert [steps_until_growth(speed, False, 60_000) for speed in fast] == [0] * 12


def test_the_safety_factor_without_damping():
    law = make("hertz")
    damped, undamped = (quiet(dl.timestep, law, 1e-3, 10.0, damped=damped) for damped in (True, False))
    assert undamped / damped == pytest.approx(UNDAMPED_SAFETY / STEP_SAFETY, rel=1e-12)
