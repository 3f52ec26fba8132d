"""Laws of the literature that engines have themselves: theirs with the numbers of ours, on a path."""

import math
import re
import tempfile
from pathlib import Path

import numpy as np

from demlaws.liggghts.check import TWO_PARTICLES
from demlaws.liggghts.run import run
from studies.trade.liggghts_oedometer import edinburgh_lines

POISSON = 0.25
_SPEED = 0.2  # of the sphere in LIGGGHTS [m/s]
_STEP = float(re.search(r"^timestep +(\S+)$", TWO_PARTICLES, re.MULTILINE)[1])  # [s]


def edinburgh_input(lines):
    """The input of `demlaws liggghts check` with stock edinburgh, of these property lines, in place of a table."""
    style = "pair_style      gran model demlaws/table tangential history table ${table}\n"
    assert style in TWO_PARTICLES
    return TWO_PARTICLES.replace(style, lines + "pair_style gran model edinburgh/stiffness tangential off\n")


def in_liggghts(law, corners):
    """The same of LIGGGHTS's edinburgh/stiffness with n = 1.5, without adhesion; the overlaps are those that it moved."""
    coefficient = 4.0 / 3.0 * law.contact.modulus * math.sqrt(law.contact.radius)
    lines = edinburgh_lines(
        f"1 {law.options['softness'] * coefficient:.17g}", f"1 {law.options['stiffness_ratio']:.17g}", "1.5"
    )
    text = edinburgh_input(lines).split("velocity ", 1)[0]
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
