"""Bahrami, Yovanovich & Culham: published numbers, the joint of the branches, and 50-digit references."""

import functools
import itertools

import numpy as np
import pytest
from accuracy import check, contacts, measure, overlaps
from examples import GRANITE, granite_numbers, quiet
from references import Bahrami

import demlaws as dl
from demlaws.laws.bahrami import CONTINUOUS, PRINTED


def test_granite_numbers():
    """The published table was made with the printed constant; the continuous one is up to 1 % stiffer."""
    got, expected = granite_numbers("bahrami", constant=PRINTED)
    np.testing.assert_allclose(got[:, 0], expected[:, 0], atol=0.06)
    np.testing.assert_allclose(got[:, 1], expected[:, 1], atol=0.6)
    got, expected = granite_numbers("bahrami")
    np.testing.assert_allclose(got, expected, rtol=0.01)


def test_branches_meet_with_the_continuous_constant():
    """a_L' of the two branches at p0' = 0.47: 2.3411 against 2.3303 as printed."""
    assert PRINTED / np.sqrt(0.47) == pytest.approx(2.3411, abs=5e-5)
    assert CONTINUOUS / np.sqrt(0.47) == pytest.approx(3.51 - 2.51 * 0.47, abs=5e-5)
    jumps = {}
    for constant in (CONTINUOUS, PRINTED):
        law = dl.law("bahrami", GRANITE, constant=constant)
        (kink,) = law.kinks()
        force = law.force(kink * np.array([1 - 1e-9, 1 + 1e-9]))
        jumps[constant] = force[1] / force[0] - 1
    assert abs(jumps[CONTINUOUS]) < 1e-4
    assert jumps[PRINTED] > 5e-3


def test_starts_without_a_jump():
    law = dl.law("bahrami", GRANITE)
    overlap = np.geomspace(1e-15, 1e-9, 7)
    force = quiet(law.force, overlap)
    assert np.all(np.diff(force) > 0)
    np.testing.assert_allclose(np.diff(np.log(force)) / np.diff(np.log(overlap)), 1.5, rtol=1e-2)


def test_errors_against_fifty_digits(rng):
    contact = quiet(functools.partial(contacts, hardness=6e9), rng, 100)
    overlap = overlaps(rng, contact)
    references, measured = measure("bahrami", contact, overlap, energy=False)
    # the root's condition differs from branch to branch: which one a point at the joint takes is a rounding
    joint = np.array([float(r.overlap_at_joint) for r in references])
    away = np.abs(overlap / joint - 1) > 1e-3
    assert away.sum() > 90
    kept = type(measured)(*(values[away] for values in measured))
    check(kept, 8.0, 1.0, ["overlap"])  # δ(P), the explicit direction; measured: 2.4, mean 0.8
    check(kept, 16.0, 1.5, ["force", "stiffness"])  # the root; measured: 3.9, mean 1.2


def test_energy_against_a_quadrature():
    import mpmath

    for overlap in GRANITE.roughness * np.array([1e-3, 1.0, 50.0]):
        law = dl.law("bahrami", GRANITE)
        with mpmath.workdps(25):
            reference = Bahrami(GRANITE.radius, GRANITE.modulus, GRANITE.roughness, GRANITE.hardness)
            reference.kinks = [k for k in reference.kinks if k < overlap]
            work = float(sum(_gauss(reference, a, b) for a, b in _corners(reference, overlap)))
        assert law.energy(overlap) == pytest.approx(work, rel=1e-10)


def _corners(reference, overlap):
    edges = [0.0, *(overlap * 2.0 ** np.arange(-24.0, 0.0)), *map(float, reference.kinks), overlap]
    edges = np.unique(edges)
    return list(itertools.pairwise(edges))


def _gauss(reference, a, b):
    x, weights = np.polynomial.legendre.leggauss(10)
    return sum(w * 0.5 * (b - a) * reference.force(a + (b - a) * 0.5 * (1 + t)) for t, w in zip(x, weights, strict=True))


def test_bad_options():
    with pytest.raises(dl.DemlawsError, match="hardness"):
        dl.law("bahrami", GRANITE.with_values(hardness=None))
    with pytest.raises(dl.DemlawsError, match="constant"):
        dl.law("bahrami", GRANITE, constant=2.0)
