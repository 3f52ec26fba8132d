"""One surface measured twice: shift, rotation and tilt that were put in are found, and what has changed is what remains."""

import functools
import math

import numpy as np
import pytest
from scipy.ndimage import map_coordinates

from demlaws.errors import DemlawsError
from demlaws.surface import HeightMap, self_affine
from studies.jamari.matching import matched

PIXEL, SIDE = 1e-6, 160
DEPTH = 0.5e-6


@functools.cache
def surface():
    return self_affine(260, PIXEL, 0.8, 1e-6, 3, shortest=5e-6, longest=60e-6).heights


@functools.cache
def worn():
    y, x = np.mgrid[:260, :260]
    return surface() - DEPTH * np.exp(-((y - 130.0) ** 2 + (x - 140.0) ** 2) / (2.0 * 7.0**2))


def view(heights, shift=(0.0, 0.0), angle=0.0):
    """What an instrument sees whose stage has moved features by `shift` [pixels: y, x] and turned them by `angle`."""
    y, x = np.mgrid[:SIDE, :SIDE] - 0.5 * (SIDE - 1)
    y, x = y - shift[0], x - shift[1]
    c, s = math.cos(angle), math.sin(angle)
    return map_coordinates(heights, [130.0 + c * y - s * x, 130.0 + c * x + s * y], order=5)


MOVES = [((0.0, 0.0), 0.0), ((3.4, -7.3), 0.0), ((-9.75, 15.5), 0.02), ((0.3, 0.2), -0.03), ((30.4, -41.2), 0.01)]


@pytest.mark.parametrize(("shift", "angle"), MOVES)
def test_what_was_moved_is_found(shift, angle):
    x = np.arange(SIDE) / SIDE
    noise = 5e-9 * np.random.default_rng(1).standard_normal((SIDE, SIDE))
    after = view(worn(), shift, angle) + 2e-6 + 3e-7 * x + noise  # raised and tilted, too
    match = matched(HeightMap(view(surface()), PIXEL), HeightMap(after, PIXEL))
    assert (match.shift_y / PIXEL, match.shift_x / PIXEL) == pytest.approx(shift, abs=0.02)
    assert match.angle == pytest.approx(angle, abs=2e-4)
    assert match.noise < 1.2e-8
    change = match.difference.heights
    assert np.nanmin(change) == pytest.approx(-DEPTH, rel=0.06)
    row, column = np.unravel_index(np.nanargmin(change), change.shape)
    assert abs(row - 79.5) < 2.0 and abs(column - 89.5) < 2.0  # where the first map has it
    far = np.ones_like(change, bool)
    far[40:120, 50:130] = False
    assert np.nanmax(np.abs(change[far])) < 6e-8


def test_maps_that_cannot_be_matched():
    first = HeightMap(view(surface()), PIXEL)
    with pytest.raises(DemlawsError, match="no position was found"):
        matched(first, self_affine(SIDE, PIXEL, 0.8, 1e-6, 9, shortest=5e-6))
    with pytest.raises(DemlawsError, match="differ in size or pixels"):
        matched(first, HeightMap(view(surface()), 2 * PIXEL))
    with pytest.raises(DemlawsError, match="must be HeightMaps"):
        matched(first, view(surface()))
