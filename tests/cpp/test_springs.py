"""Partial slip of the plugins (demlaws_slip.h) against a row of springs written from its definition."""

import subprocess
from pathlib import Path

import numpy as np
import pytest
from examples import GRANITE
from scipy.optimize import brentq

import demlaws as dl

RATIO, FRICTION = 0.857, 0.4
PLACES, WEIGHTS = np.polynomial.legendre.leggauss(24)


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    program = tmp_path_factory.mktemp("springs") / "springs"
    headers, source = Path(dl.__file__).parent / "cpp", Path(__file__).parent / "springs.cpp"
    subprocess.run(["g++", "-std=c++11", "-O2", "-I", str(headers), str(source), "-o", str(program), "-lz"], check=True)
    return program


def row_of_springs(path, unloading, count):
    """Force in two directions, energy and loss of each step.

    path: rows of overlap, normal force and displacement in two directions; unloading(overlap, force): the stiffness K with
    which the contact would unload, and the function K → overlap along that curve.
    """

    def shares(stiffness):  # of each spring
        return np.diff(np.clip(share * np.arange(count + 1), 0.0, stiffness))

    held, share, stretch = 0.0, 0.0, np.zeros((count, 2))
    for overlap, force, *displacement in path:
        stiffness, overlap_at = unloading(overlap, force)
        share = share or stiffness / count
        was = shares(held)
        before, shear = 0.5 * RATIO * was @ (stretch**2).sum(1), RATIO * (was @ stretch)
        while stiffness > count * share:  # springs are joined in pairs, with their mean stretch
            pairs = was.reshape(-1, 2).sum(1)[:, None]
            sums = (was[:, None] * stretch).reshape(-1, 2, 2).sum(1)
            joined = np.divide(sums, pairs, out=np.zeros_like(sums), where=pairs > 0.0)
            stretch = np.concatenate([joined, np.zeros((count // 2, 2))])
            share *= 2.0
            was = shares(held)
        now = shares(stiffness)
        touching = now > 0.0
        stretch *= np.divide(np.minimum(was, now), now, out=np.zeros(count), where=touching)[:, None]
        compression = np.zeros(count)
        for k in np.flatnonzero(touching):
            places = k * share + 0.5 * now[k] * (1.0 + PLACES)
            compression[k] = overlap - 0.5 * WEIGHTS @ [overlap_at(place) for place in places]
        carried = RATIO * (now @ compression)
        limits = FRICTION * force / carried * compression if carried > 0.0 else compression
        for moved in (0.0, np.array(displacement)):
            stretch += moved * touching[:, None]
            lengths = np.hypot(*stretch.T)
            stretch *= np.divide(limits, lengths, out=np.ones(count), where=lengths > limits)[:, None]
        work = 0.5 * (shear + RATIO * (now @ stretch)) @ displacement if stiffness > 0.0 else 0.0
        held, shear, after = stiffness, RATIO * (now @ stretch), 0.5 * RATIO * now @ (stretch**2).sum(1)
        yield *shear, after, work - (after - before)


def hertz_curve(contact):
    """Unloading by Hertz's law of the contact."""
    root = 2.0 * contact.modulus * np.sqrt(contact.radius)

    def unloading(overlap, force):
        recoverable = (3.0 * force / (2.0 * root)) ** (2 / 3)
        return root * np.sqrt(recoverable), lambda stiffness: overlap - recoverable + (stiffness / root) ** 2

    return unloading


def loading_curve(law):
    def unloading(overlap, force):
        def overlap_at(stiffness):
            return brentq(lambda u: float(law.stiffness(u)) / stiffness - 1.0, 1e-18, 2.0 * overlap, xtol=1e-20, rtol=1e-13)

        return float(law.stiffness(overlap)), overlap_at

    return unloading


CASES = [
    pytest.param("hertz", "elastic", 12, 3e-6, 2e-6, id="hertz"),
    pytest.param("pohrt-popov", "elastic", 4, 6e-7, 2e-6, id="pohrt-popov"),
    pytest.param("pohrt-popov", "hertz", 12, 6e-7, 2e-9, id="pohrt-popov, Hertz unloading"),
    pytest.param("pohrt-popov", "hertz", 30, 6e-7, 2e-9, id="30 springs"),
]


@pytest.mark.parametrize(("name", "rule", "springs", "reach", "tolerance"), CASES)
def test_row_of_springs(program, tmp_path, name, rule, springs, reach, tolerance):
    """Growth, which joins springs, unloading and reversed slip. Tolerances of loading curves: a table's, and its spline's."""
    law = dl.law(name, GRANITE, rule)
    law.tabulate(rtol=1e-7, max_force=100.0).save(tmp_path / "law.tbl")
    turn = np.linspace(0.0, 3.0, 61)
    overlap = 4e-6 * np.interp(turn, [0.0, 1.0, 1.4, 2.0, 3.0], [0.03, 0.5, 0.45, 1.0, 0.2])
    displacement = reach * np.stack([np.sin(7.0 * turn), 0.5 * np.cos(4.0 * turn)], -1) * (overlap / 4e-6)[:, None]
    steps = np.column_stack([overlap, displacement])
    lines = "\n".join(" ".join(map(repr, row)) for row in steps.tolist())
    words = [str(program), str(tmp_path / "law.tbl"), str(springs), str(RATIO), str(FRICTION)]
    out = subprocess.run(words, input=lines, capture_output=True, text=True, check=True).stdout
    found = np.array([line.split() for line in out.splitlines()], float).T
    force = law.follow(overlap).force
    unloading = loading_curve(law) if rule == "elastic" else hertz_curve(GRANITE)
    path = np.column_stack([overlap, force, displacement])
    expected = np.array(list(row_of_springs(path, unloading, springs))).T
    share = np.hypot(*expected[:2])[force > 0.0] / (FRICTION * force[force > 0.0])
    assert share.max() > 0.999 and share.min() < 0.95 and expected[3].max() > 0.0
    for one, other in zip(found, expected, strict=True):
        np.testing.assert_allclose(one, other, rtol=0.0, atol=tolerance * np.abs(other).max())
