"""One surface measured twice, before and after a contact: the second map laid over the first, and what has changed.

    match = matched(before, after)
    match.difference.heights                  # after - before [m], NaN where the second map does not reach

The paper's method in outline (Jamari & Schipper 2006, "matching": mutual translation and rotation found from what both maps
show, then the difference); how theirs finds them is not printed, and this one is our own [our derivation]: the whole pixels by
phase correlation, then shift, rotation and a plane by least squares on heights interpolated by cubic splines, in which pixels
that differ far more than most, those that the contact has changed, do not count.
"""

import math
from typing import NamedTuple

import numpy as np

from demlaws import plots
from demlaws.errors import DemlawsError
from demlaws.plots import figure
from demlaws.plots.surface import MICRO, show
from demlaws.surface import HeightMap


class Match(NamedTuple):
    """How a second map lies over the first, and the difference of heights there."""

    shift_x: float  # [m] by which features have moved along x in the second map
    shift_y: float
    angle: float  # [rad] by which they have turned about the middle of the map, x towards y
    offset: float  # [m] of the second map's heights over the first's where nothing has changed
    noise: float  # spread [m] of the difference where nothing has changed (1.48 times its median deviation)
    difference: HeightMap  # after - before on the first map's grid

    def changed(self, times=4.0):
        """Which pixels differ by more than `times` the noise."""
        return np.nan_to_num(np.abs(self.difference.heights)) > times * self.noise


def phase_shift(first, second):
    """Whole pixels (rows, columns) by which `second` is moved against `first`, by phase correlation, and the reverse shift."""
    rows, columns = first.shape
    window = np.hanning(rows)[:, None] * np.hanning(columns)
    spectrum = np.fft.rfft2((second - second.mean()) * window) * np.conj(np.fft.rfft2((first - first.mean()) * window))
    size = np.abs(spectrum)
    # waves that the surface does not hold have a phase, too, without information
    correlation = np.fft.irfft2(spectrum / np.maximum(size, 1e-5 * size.max() + 1e-300), s=first.shape)
    row, column = np.unravel_index(int(np.argmax(correlation)), correlation.shape)
    return row - rows * (row > rows // 2), column - columns * (column > columns // 2)


def matched(before, after, steps=40):
    """The `Match` of two maps with equal pixels and of equal size.

    Rotation may be a few degrees, the shift half of the map. Raises DemlawsError where pixels or sizes differ, or where no
    position is found at which the maps agree better than two unlike maps would.
    """
    from scipy.ndimage import map_coordinates, spline_filter

    for one in (before, after):
        if not isinstance(one, HeightMap):
            raise DemlawsError(f"maps to be matched must be HeightMaps, got {one!r:.60}")
    if before.shape != after.shape or not all(
        math.isclose(getattr(before, n), getattr(after, n), rel_tol=1e-6) for n in ("pixel_x", "pixel_y")
    ):
        raise DemlawsError(f"the maps differ in size or pixels: {before!r} and {after!r}; crop or resample one of them")
    first, second = before.filled().without_form(1).heights, after.filled().heights
    spline = spline_filter(second, 3)
    rows, columns = first.shape
    y, x = np.mgrid[:rows, :columns].astype(float)
    middle = 0.5 * (rows - 1), 0.5 * (columns - 1)
    dy, dx = y - middle[0], x - middle[1]
    aspect = before.pixel_y / before.pixel_x
    row, column = phase_shift(first, after.filled().without_form(1).heights)
    place = np.array([row, column, 0.0], float)  # shift [pixels] along y and x, angle

    def positions():
        c, s = math.cos(place[2]), math.sin(place[2])
        return middle[0] + place[0] + c * dy + s * dx / aspect, middle[1] + place[1] + c * dx - s * dy * aspect

    def laid():
        at = positions()
        inside = (at[0] >= 1) & (at[0] <= rows - 2) & (at[1] >= 1) & (at[1] <= columns - 2)
        return at, map_coordinates(spline, at, order=3, prefilter=False, mode="nearest"), inside

    known = np.isfinite(before.heights) & np.isfinite(after.heights)
    plane = np.zeros(3)
    planes = np.stack([np.ones_like(x), dx / columns, dy / rows])
    noise = math.inf
    for _ in range(steps):
        _, z, inside = laid()
        if inside.mean() < 0.1:
            noise = math.inf
            break
        rest = z - first - np.tensordot(plane, planes, 1)
        use = inside & known
        centre = np.median(rest[use])
        noise = 1.4826 * float(np.median(np.abs(rest[use] - centre)))
        use &= np.abs(rest - centre) <= 3.0 * max(noise, 1e-300)
        slope_y, slope_x = np.gradient(z)
        c, s = math.cos(place[2]), math.sin(place[2])
        turn = slope_y * (c * dx / aspect - s * dy) - slope_x * (c * dy * aspect + s * dx)
        design = np.stack([slope_y[use], slope_x[use], turn[use], *(-p[use] for p in planes)], 1)
        scale = np.maximum(np.linalg.norm(design, axis=0), 1e-300)
        step = np.linalg.lstsq(design / scale, -rest[use], rcond=None)[0] / scale
        step[:3] = np.clip(step[:3], [-2.0, -2.0, -0.02], [2.0, 2.0, 0.02])
        place += step[:3]
        plane += step[3:]
        if np.max(np.abs(step[:2])) < 1e-5 and abs(step[2]) < 1e-7 and np.max(np.abs(step[3:])) < 1e-3 * noise:
            break
    _, z, inside = laid()
    difference = np.where(inside & known, z - first - np.tensordot(plane, planes, 1), np.nan)
    if inside.mean() >= 0.1:
        noise = 1.4826 * float(np.nanmedian(np.abs(difference - np.nanmedian(difference))))
    if not noise < 0.5 * float(np.std(first)):
        raise DemlawsError(
            "no position was found at which the two maps agree: do they show the same place? Level both alike (--form), crop "
            "them to what both show, or turn one by hand if it is turned by more than a few degrees"
        )
    return Match(
        place[1] * before.pixel_x,
        place[0] * before.pixel_y,
        float(math.atan2(math.sin(place[2]), math.cos(place[2]))),
        float(plane[0]),
        noise,
        before.with_heights(difference, form_order=None),
    )


def change(before, after, picture=None):
    """Print how the second map lies over the first and what has changed, and draw it to `picture`; returns the `Match`."""
    match = matched(before, after)
    changed, pixel = match.changed(), before.pixel_x * before.pixel_y
    heights = match.difference.heights
    lowered = float(np.nansum(np.where(changed & (heights < 0), -heights, 0.0))) * pixel
    raised = float(np.nansum(np.where(changed & (heights > 0), heights, 0.0))) * pixel
    print(
        f"the second map is moved by {match.shift_x * 1e6:.4g}, {match.shift_y * 1e6:.4g} µm and turned by "
        f"{math.degrees(match.angle):.4g}°; {100 * np.isfinite(heights).mean():.3g} % of the first is seen in both"
    )
    share = 100 * changed.mean()
    print(f"noise of the difference {match.noise * 1e9:.4g} nm; {share:.3g} % of the map differ by more than 4 times that")
    print(
        f"largest lowering {max(-np.nanmin(heights), 0.0) * 1e6:.4g} µm, "
        f"largest rise {max(np.nanmax(heights), 0.0) * 1e6:.4g} µm; "
        f"volume lowered {lowered * 1e18:.4g} µm³, raised {raised * 1e18:.4g} µm³"
    )
    if picture is not None:
        print(plots.save(change_figure(before, match), picture))
    return match


def change_figure(before, match):
    """A map, what has changed after it was laid over a second one, and profiles of that through its middle of change."""
    fig, (left, middle, right) = figure(columns=3, width=5.0, height=4.2)
    show(fig, left, before, before.heights * MICRO, "height (µm)")
    left.set_title("before", fontsize=10)
    change = match.difference.heights * MICRO
    limit = max(float(np.nanmax(np.abs(change))), 1e-9)
    show(fig, middle, before, change, "after - before (µm)", cmap="RdBu", vmin=-limit, vmax=limit)
    middle.set_title(f"difference, noise {match.noise * 1e9:.3g} nm", fontsize=10)
    weight = np.where(match.changed(), np.abs(np.nan_to_num(change)), 0.0) + 1e-300
    row = int(np.argmax(weight.sum(axis=1)))
    column = int(np.argmax(weight.sum(axis=0)))
    for values, pixel, place in (
        (change[row], before.pixel_x, f"along x at y = {row * before.pixel_y * MICRO:.0f} µm"),
        (change[:, column], before.pixel_y, f"along y at x = {column * before.pixel_x * MICRO:.0f} µm"),
    ):
        right.plot(np.arange(values.size) * pixel * MICRO, values, lw=1.0, label=place)
    right.set(xlabel="distance (µm)", ylabel="after - before (µm)")
    right.legend(fontsize=8)
    return fig
