"""Plausibility of height maps: spikes, fillers, units, lists of points, resolution, fractal dimensions. [our limits]

`doubts` and the other functions return texts that name the value and the remedy; nothing is changed.
"""

import math

import numpy as np

from demlaws.errors import DemlawsError, MapWarning, warn

HIGHEST = 8.0
"""Largest height over robust Sq; of 10⁸ Gaussian pixels it is 6."""
KURTOSIS = 10.0
"""Largest kurtosis; 3 for Gaussian heights."""
STEEP = 1.0
"""Largest robust rms slope: beyond 45 degrees an instrument sees nothing."""
FLAT = 1e-5
"""Smallest robust rms slope; polished optics have some 1e-4."""
ROUNDING = 1e-12
"""Slope that is left of a plane."""
WIDEST = 0.05
"""Largest field of view [m] of an instrument that resolves roughness, stitched fields included."""
EVEN = 0.02
"""Part of the mean step by which the steps of an axis may differ; those of heights differ by more than the mean."""
PIXELS = 10.0
"""Fewest pixels across the Hertz radius."""
DISAGREEMENT = 0.2
"""Largest difference of Df by two methods; they differ by 0.1 on maps of known dimension."""
REPEATED = 5.0
"""Pixels of the most frequent height over those of the second, above which it may stand for missing pixels."""
FAR = 20.0
"""Gap between a filler and the other heights over their interquartile range."""


def robust_sq(z: np.ndarray) -> float:
    """1.4826 times the median of |z - median(z)|: Sq of Gaussian heights, whatever a few pixels are."""
    z = z[np.isfinite(z)]
    return float(1.4826 * np.median(np.abs(z - np.median(z))))


def filler(z: np.ndarray) -> float | None:
    """The lowest or highest height if several pixels have exactly it, far from all others: missing pixels; or None."""
    z = z[np.isfinite(z)]
    for end in (float(z.min()), float(z.max())):
        others = z[z != end]
        if 1 < z.size - others.size < 0.9 * z.size and np.ptp(others) > 0.0:
            spread = float(np.subtract(*np.percentile(others, [75, 25])))
            if np.min(np.abs(others - end)) > FAR * max(spread, 1e-12 * abs(end)):
                return end
    return None


def repeated(z: np.ndarray) -> tuple[float, int] | None:
    """A height that far more pixels have than any other, though none is at an end: missing pixels as 0; or None."""
    values, counts = np.unique(z[np.isfinite(z)], return_counts=True)
    if values.size < 20:
        return None
    last = int(np.argmax(counts))
    usual = float(np.max(np.delete(counts, last)))
    return (float(values[last]), int(counts[last])) if counts[last] > REPEATED * max(usual, 2.0) else None


def doubts(heights, scale: float = 1.0) -> list[str]:
    """Reasons to doubt a `HeightMap`; scale: metres per unit of its file. Heights are judged without form of order 2."""
    found, z = [], heights.heights
    missing = filler(z)
    if missing is not None:
        count = int(np.sum(z == missing))
        found.append(
            f"{count} pixels have exactly the height {missing / scale:g}, far from all others: if these are missing pixels, "
            f"give missing={missing / scale:g} (--missing)"
        )
        heights = heights.with_heights(np.where(z == missing, np.nan, z))
    elif (same := repeated(z)) is not None:
        found.append(
            f"{same[1]} pixels have exactly the height {same[0] / scale:g}, far more than any other: if these are missing "
            f"pixels, give missing={same[0] / scale:g} (--missing)"
        )
    level = heights if heights.form_order is not None else heights.without_form(2)
    z = level.heights - np.nanmedian(level.heights)
    robust, sq = robust_sq(z), level.sq
    if robust > 0.0:
        highest, kurtosis = float(np.nanmax(np.abs(z))) / robust, float(np.nanmean((z / sq) ** 4))
        if highest > HIGHEST or kurtosis > KURTOSIS:
            found.append(
                f"spikes or pits: the largest height is {highest:.3g} times the robust Sq {robust:.4g} m, kurtosis "
                f"{kurtosis:.3g} (Gaussian: 3); Sq = {sq:.4g} m contains them; use despiked() (--despike), or robust_sq"
            )
    remedy = "check unit (--unit) and pixel (--pixel)"
    slopes = heights.with_heights(z).slopes()
    if all(slope.size for slope in slopes):
        slope = math.hypot(*map(robust_sq, slopes))  # robust, too: spikes are no wrong unit
        if slope > STEEP or ROUNDING < slope < FLAT:
            found.append(
                f"slope {slope:.4g} (robust rms), {'above 45 degrees' if slope > STEEP else 'flatter than polished optics'}: "
                f"are heights or pixels in another unit than read? {remedy}"
            )
    else:
        found.append("no two neighbours were measured, as of interlaced lines: there is no slope")
    width = max(heights.field_of_view)
    if width > WIDEST:
        found.append(f"a field of view of {width:.4g} m, above {WIDEST:g} m: is the pixel size in another unit? {remedy}")
    return found


def field_doubts(heights, radius: float) -> list[str]:
    """A field of view wider than the radius [m] of the ball that is pressed on it."""
    width = max(heights.field_of_view)
    if width <= radius:
        return []
    return [
        f"a field of view of {width:.4g} m is wider than the effective radius {radius:.4g} m: is the pixel size as meant "
        "(--pixel)? If so, crop the map to the contact (--crop)"
    ]


def warn_of_map(found: list[str]) -> None:
    """Issue a `MapWarning` for each doubt that one of these functions found."""
    for text in found:
        warn(f"height map: {text}", MapWarning)


def dimension_doubts(by_boxes: float | None, by_spectrum: float | None) -> list[str]:
    """Fractal dimensions out of range, or two methods that contradict each other."""
    found, remedy = [], "give the wavelengths between which the spectrum is straight (--wavelengths)"
    for name, value in (("box counting", by_boxes), ("the spectrum", by_spectrum)):
        if value is not None and not 2.0 <= value <= 3.0:
            found.append(f"Df = {value:.3f} by {name} is not between 2 and 3: the map is not self-affine there; {remedy}")
    if by_boxes is not None and by_spectrum is not None and abs(by_boxes - by_spectrum) > DISAGREEMENT:
        found.append(f"Df = {by_boxes:.3f} by box counting and {by_spectrum:.3f} by the spectrum disagree; {remedy}")
    return found


def resolution_doubts(heights, pair, force: float) -> list[str]:
    """A Hertz radius a = (3 P R/(4 E*))^(1/3) of a `Contact` under a force [N] that is few pixels wide."""
    radius, pixel = math.cbrt(0.75 * force * pair.radius / pair.modulus), max(heights.pixel_x, heights.pixel_y)
    if radius >= PIXELS * pixel:
        return []
    return [
        f"the Hertz radius {radius:.4g} m is {radius / pixel:.2g} pixels wide: forces depend on the pixel size below "
        f"{PIXELS:g}; measure with smaller pixels, or give a larger force or radius"
    ]


def refuse_other_arrays(array: np.ndarray, path) -> None:
    """DemlawsError for an array that is not a grid of heights: a stack of maps, axes beside a grid, a list of points."""
    if array.ndim != 2 or 0 in array.shape:
        raise DemlawsError(f"{path}: an array of shape {array.shape} is not one map: save one, with rows and columns")
    for name, grid in (("row", array), ("column", array.T)):
        if _is_even(grid[0]) and len(grid) > 4 and not _is_even(grid[1]):
            raise DemlawsError(
                f"{path}: the first {name} rises evenly from {grid[0, 1]:g} to {grid[0, -1]:g}, as an axis does, not heights: "
                "leave the axes out, and give their step as pixel (--pixel)"
            )
    for columns in (array, array.T):
        rows, count = columns.shape
        if count > 6 or rows < 10 * count or count < 3:
            continue
        steps = [np.unique(np.round(np.diff(column) / (np.ptp(column) or 1.0), 6)).size for column in columns.T]
        if sum(number < 0.1 * rows for number in steps) >= 2:
            raise DemlawsError(
                f"{path}: {rows} entries of {count} values are a list of points x, y, z, not a grid of heights: write the z as "
                "a grid, one row per line (numpy: z.reshape(rows, columns); scattered points: scipy.interpolate.griddata)"
            )


def _is_even(values):
    """Whether values rise or fall by equal steps; the first is left out, as it may be the corner of two axes."""
    steps = np.diff(values[1:])
    mean = float(np.mean(steps)) if steps.size > 4 else 0.0
    return mean != 0.0 and bool(np.all(np.abs(steps - mean) <= EVEN * abs(mean)))
