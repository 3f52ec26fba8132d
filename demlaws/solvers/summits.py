"""Nine-point summits of a height map: pixels higher than their eight neighbours, the classical definition of asperities."""

import math
from typing import NamedTuple

import numpy as np

from demlaws.errors import DemlawsError
from demlaws.units import number


class Summits(NamedTuple):
    """The nine-point summits of a map as Greenwood & Tripp's model takes them."""

    total: int
    density: float  # η [1/m²]
    radius: float  # β = 1/⟨curvature⟩ [m], by three-point curvatures 2/R = -(z_xx + z_yy)
    height: float  # mean height of the summits over the mean plane [m]
    spread: float  # their rms height about that [m]
    roughness: float  # Sq of the surface [m]: the σ_s of Jamari & Schipper

    def mu(self, radius):
        """μ = (8/3) η σ √(2Rβ) against a ball of `radius` [m], σ the surface's Sq as in the paper of 2006."""
        return 8.0 / 3.0 * self.density * self.roughness * math.sqrt(2.0 * number(radius, "radius", "m") * self.radius)


def summits(heights):
    """`Summits` of a levelled height map; raises DemlawsError where it has none. η and β depend on the pixel."""
    from scipy.ndimage import maximum_filter

    z, others = heights.heights, np.ones((3, 3), bool)
    others[1, 1] = False
    around = maximum_filter(np.where(np.isnan(z), np.inf, z), footprint=others, mode="constant", cval=np.inf)
    i, j = np.nonzero(z > around)
    if i.size == 0:
        raise DemlawsError("the map has no pixel that is higher than its eight neighbours")
    curvature = (2 * z[i, j] - z[i, j - 1] - z[i, j + 1]) / heights.pixel_x**2
    curvature = curvature + (2 * z[i, j] - z[i - 1, j] - z[i + 1, j]) / heights.pixel_y**2
    rows, columns = heights.shape
    return Summits(
        total=i.size,
        density=i.size / ((rows - 2) * heights.pixel_y * (columns - 2) * heights.pixel_x),
        radius=float(2.0 / np.mean(curvature)),
        height=float(np.mean(z[i, j]) - np.nanmean(z)),
        spread=float(np.std(z[i, j])),
        roughness=heights.sq,
    )
