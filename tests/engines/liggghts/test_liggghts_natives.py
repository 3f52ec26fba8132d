"""Stock edinburgh of LIGGGHTS on one contact."""

import math
import re
import tempfile
from pathlib import Path

import numpy as np

import demlaws as dl
from demlaws.liggghts.check import TWO_PARTICLES
from demlaws.liggghts.run import run
from studies.trade.liggghts_oedometer import edinburgh_lines

POISSON = 0.25
_SPEED = 0.2  # of the sphere in LIGGGHTS [m/s]
_STEP = float(re.search(r"^timestep +(\S+)$", TWO_PARTICLES, re.MULTILINE)[1])  # [s]


def in_liggghts(law, corners):
    """Overlaps [m] as they were reached and forces [N] of edinburgh/stiffness with n = 1.5, without adhesion."""
    coefficient = 4.0 / 3.0 * law.contact.modulus * math.sqrt(law.contact.radius)
    lines = edinburgh_lines(
        f"1 {law.options['softness'] * coefficient:.17g}", f"1 {law.options['stiffness_ratio']:.17g}", "1.5"
    )
    style = "pair_style      gran model demlaws/table tangential history table ${table}\n"
    assert style in TWO_PARTICLES
    text = TWO_PARTICLES.replace(style, lines + "pair_style gran model edinburgh/stiffness tangential off\n")
    text = text.split("velocity ", 1)[0]
    at = -1e-7
    for corner in corners:
        steps = max(1, round(abs(corner - at) / (_SPEED * _STEP)))
        speed = -_SPEED if corner > at else _SPEED
        text += f"thermo {max(1, steps // 40)}\nvelocity right set {speed!r} 0 0\nrun {steps}\n"
        at -= speed * steps * _STEP
    with tempfile.TemporaryDirectory() as scratch:
        path = Path(scratch, "in.path")
        path.write_text(text)
        young = 2.0 * law.contact.modulus * (1.0 - POISSON**2)
        log = run(path, 1, {"young": repr(young), "radius": repr(2.0 * law.contact.radius)}, plugin=False)
    touching = log["overlap"] > 0.0
    return log["overlap"][touching], log["force"][touching]


def until_free(force):
    """Number of points of a path until the force is first 0 again after loading; all, where it never is."""
    free = np.flatnonzero((force == 0.0) & (np.arange(force.size) > np.argmax(force > 0.0)))
    return int(free[0]) if free.size else force.size


def test_liggghts_own_and_ours_on_the_same_path():
    """Equal until the force is 0; below the plastic overlap stock moves it back with the bodies, and reloads from there."""
    law = dl.law("eepa", dl.Contact(4e-3, 32e9), softness=0.8, stiffness_ratio=2.5)
    overlap, theirs = in_liggghts(law, [6e-6, 4.5e-6, 1e-5, 7.5e-6, 5.5e-6, 9e-6])
    ours = law.follow(overlap).force
    assert np.count_nonzero(ours == 0.0) > 10 and until_free(ours) > 100
    first = slice(0, until_free(ours))
    assert np.max(np.abs(theirs - ours)[first]) <= 1e-13 * theirs.max()
    later = (np.arange(ours.size) > until_free(ours)) & (theirs > 0.0)
    assert np.max((theirs - ours)[later]) > 0.05 * theirs.max()
