"""Nine-point summits of a height map: pixels higher than their eight neighbours, the classical definition of asperities."""

import math
from typing import NamedTuple

import numpy as np

from demlaws.errors import DemlawsError
from demlaws.units import number


def nine_point_summits(heights):
    """Summits higher than all eight neighbours: x, y, z [m] and mean radius of curvature [m].

    The classical definition, beside which the volume-conserving patches stand. The radius comes from three-point
    curvatures, 2/R = -(z_xx + z_yy).
    """
    z = heights.heights
    middle = z[1:-1, 1:-1]
    summit = np.isfinite(middle)
    for di in range(3):
        for dj in range(3):
            if (di, dj) != (1, 1):
                summit &= middle > z[di : di + middle.shape[0], dj : dj + middle.shape[1]]
    i, j = np.nonzero(summit)
    i, j = i + 1, j + 1
    curvature = (2 * z[i, j] - z[i, j - 1] - z[i, j + 1]) / heights.pixel_x**2
    curvature = curvature + (2 * z[i, j] - z[i - 1, j] - z[i + 1, j]) / heights.pixel_y**2
    return j * heights.pixel_x, i * heights.pixel_y, z[i, j], 2.0 / curvature


class Summits(NamedTuple):
    """The nine-point summits of a map as Greenwood & Tripp's model takes them."""

    total: int
    density: float  # η [1/m²]
    radius: float  # β = 1/⟨curvature⟩ [m]
    mean_radius: float  # ⟨radius⟩ [m] of those that are convex: few flat ones make it larger
    height: float  # mean height of the summits over the mean plane [m]
    spread: float  # their rms height about that [m]
    roughness: float  # Sq of the surface [m]: the σ_s of Jamari & Schipper

    def mu(self, radius):
        """μ = (8/3) η σ √(2Rβ) against a ball of `radius` [m], σ the surface's Sq as in the paper of 2006."""
        return 8.0 / 3.0 * self.density * self.roughness * math.sqrt(2.0 * number(radius, "radius", "m") * self.radius)


def summits(heights):
    """`Summits` of a levelled height map; raises DemlawsError where it has none. η and β depend on the pixel."""
    _, _, z, radius = nine_point_summits(heights)
    if z.size == 0:
        raise DemlawsError("the map has no pixel that is higher than its eight neighbours")
    rows, columns = heights.shape
    area = (rows - 2) * heights.pixel_y * (columns - 2) * heights.pixel_x
    convex = radius[radius > 0]
    return Summits(
        total=z.size,
        density=z.size / area,
        radius=float(1.0 / np.mean(1.0 / radius)),
        mean_radius=float(np.mean(convex[np.isfinite(convex)])),
        height=float(np.mean(z) - np.nanmean(heights.heights)),
        spread=float(np.std(z)),
        roughness=heights.sq,
    )
