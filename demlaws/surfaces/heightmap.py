"""Height maps: form removal, roughness, power spectrum, fractal dimension, and self-affine maps to test with.

Heights and lengths are in metres. Missing pixels are NaN: statistics leave them out, spectrum, box counting and contact
calculations work on `filled()` maps.
"""

import functools
import math
from dataclasses import dataclass, replace

import numpy as np

from demlaws import units
from demlaws.contact import Surface
from demlaws.errors import DemlawsError
from demlaws.surfaces import plausibility

UNITS = {**units.UNITS["m"], "µm": 1e-6, "μm": 1e-6}


LARGEST_PIXEL = 1e-2
"""A larger pixel [m] is one in another unit: 0.8 is mostly meant as 0.8 µm."""


@dataclass(frozen=True)
class HeightMap:
    """Heights [m] on a regular grid: rows along y, columns along x; NaN (or masked) where a value is missing.

    pixel_x, pixel_y: grid spacing [m]. form_order: order of the form removed so far, or "sphere" (None: none).
    """

    heights: np.ndarray
    pixel_x: float
    pixel_y: float = None  # type: ignore[assignment]  # stands for pixel_x until __post_init__: readers find a number
    form_order: int | str | None = None

    def __post_init__(self):
        try:
            heights = np.asarray(units.unmasked(self.heights))
            if heights.dtype.kind in "bcmM":  # truth values, complex numbers, dates
                raise TypeError
            heights = np.ascontiguousarray(heights, dtype=float)
        except (TypeError, ValueError):
            raise DemlawsError("heights must be a 2-D array of numbers in m") from None
        if heights.ndim != 2 or min(heights.shape) < 4:
            raise DemlawsError(f"a height map needs at least 4 by 4 pixels, got an array of shape {heights.shape}")
        if np.isinf(heights).any():
            heights = np.where(np.isinf(heights), np.nan, heights)
        if np.isnan(heights).all():
            raise DemlawsError("every pixel of the height map is missing")
        object.__setattr__(self, "heights", heights)
        object.__setattr__(self, "pixel_x", units.number(self.pixel_x, "pixel_x", "m", high=LARGEST_PIXEL))
        pixel_y = self.pixel_x if self.pixel_y is None else units.number(self.pixel_y, "pixel_y", "m", high=LARGEST_PIXEL)
        object.__setattr__(self, "pixel_y", pixel_y)

    def __repr__(self):
        rows, columns = self.shape
        width, height = self.field_of_view
        return f"HeightMap({columns} x {rows} pixels, {width * 1e6:.4g} x {height * 1e6:.4g} µm, Sq = {self.sq * 1e6:.4g} µm)"

    def record(self):
        """Record of the map in a table's file: enough to recognise the map, not to rebuild it."""
        import zlib

        return {"height map": repr(self), "crc32": f"{zlib.crc32(self.heights.tobytes()):08x}"}

    def portable(self):
        """Plain values from which `HeightMap.from_portable` makes the same map, for simulations that are saved."""
        import base64
        import zlib

        packed = base64.b64encode(zlib.compress(self.heights.tobytes(), 6)).decode()
        return {
            "heights": packed,
            "shape": list(self.shape),
            "pixel": [self.pixel_x, self.pixel_y],
            "form_order": self.form_order,
        }

    @classmethod
    def from_portable(cls, values):
        """A map from the output of `portable`; DemlawsError if that is corrupt."""
        import base64
        import zlib

        try:
            heights = np.frombuffer(zlib.decompress(base64.b64decode(values["heights"]))).reshape(values["shape"])
            return cls(heights, *values["pixel"], values["form_order"])
        except (KeyError, TypeError, ValueError, zlib.error) as error:
            raise DemlawsError(
                f"this is not a height map: {error!r}; a table names the file of its map but does not contain the heights"
            ) from None

    @property
    def shape(self):
        """Rows and columns of pixels."""
        return self.heights.shape

    @property
    def field_of_view(self):
        """Width and height [m] of the measured area, pixel edge to pixel edge."""
        return self.shape[1] * self.pixel_x, self.shape[0] * self.pixel_y

    @property
    def missing(self):
        """Fraction of missing pixels."""
        return float(np.isnan(self.heights).mean())

    @property
    def sq(self):
        """Sq = √⟨(z - ⟨z⟩)²⟩ [m] over the valid pixels."""
        return float(np.nanstd(self.heights))

    @property
    def robust_sq(self):
        """1.4826 times the median of |z - median(z)| [m]: Sq of Gaussian heights, which spikes do not change."""
        return plausibility.robust_sq(self.heights)

    @property
    def sa(self):
        """Sa = ⟨|z - ⟨z⟩|⟩ [m] over the valid pixels."""
        return float(np.nanmean(np.abs(self.heights - np.nanmean(self.heights))))

    @property
    def slope(self):
        """Rms slope √⟨|∇z|²⟩ from differences of neighbours; depends on the pixel size of a fractal surface."""
        return math.sqrt(sum(float(np.mean(slope**2)) if slope.size else math.nan for slope in self.slopes()))

    def slopes(self):
        """Slopes along y and along x between neighbours of which both were measured."""
        steps = np.diff(self.heights, axis=0) / self.pixel_y, np.diff(self.heights, axis=1) / self.pixel_x
        return [step[np.isfinite(step)] for step in steps]

    def with_heights(self, heights, **changes):
        """The same grid with other heights."""
        return replace(self, heights=heights, **changes)

    def without_form(self, order=2):
        """Form removed: the least-squares polynomial Σ c_ij x^i y^j, i + j ≤ order (0 mean, 1 plane, 2 sphere or cylinder).

        Order 2 removes a sphere instead of the paraboloid where the sphere leaves less: at the distance h from the apex of a
        ball of radius R the two differ by h⁴/(8R³).
        """
        order = units.whole(order, "form order", 0, 8)
        if order == 2:
            return self._second_order[0]
        y, coefficients, x = self._form(order)
        return self.with_heights(self.heights - y @ coefficients @ x.T, form_order=order)

    @functools.cached_property
    def _second_order(self):
        """The map without paraboloid or sphere, whichever leaves less, and the principal radii [m] of that."""
        y, coefficients, x = self._form(2)
        left = self.with_heights(self.heights - y @ coefficients @ x.T, form_order=2)
        radii = self._radii(coefficients)
        heights, radius = self._sphere(coefficients, *radii) if 0.5 < radii[0] / radii[1] < 2.0 else (None, None)
        if heights is None or np.nanstd(self.heights - heights) >= left.sq:
            return left, radii
        return self.with_heights(self.heights - heights, form_order="sphere"), (radius, radius)

    def _form(self, order):
        """Legendre polynomials of y at the rows, of x at the columns, and coefficients of their products, by least squares."""
        rows, columns = self.shape
        x = np.polynomial.legendre.legvander(np.linspace(-1, 1, columns), order)
        y = np.polynomial.legendre.legvander(np.linspace(-1, 1, rows), order)
        j, i = np.nonzero(np.add.outer(range(order + 1), range(order + 1)) <= order)
        there = np.isfinite(self.heights)
        if there.sum() < i.size:
            raise DemlawsError(f"form order {order} needs {i.size} pixels, the map has fewer that are not missing")
        offset = np.nanmean(self.heights)
        vector = (y.T @ np.where(there, self.heights - offset, 0.0) @ x)[j, i]
        # sums over the pixels of products of two products: those of y and of x are separate
        yy, xx = (np.einsum("pa,pb->pab", one, one).reshape(len(one), -1) for one in (y, x))
        sums = (yy.T @ there.astype(float) @ xx).reshape((order + 1,) * 4)
        matrix = sums[j[:, None], j, i[:, None], i]
        coefficients = np.zeros((order + 1, order + 1))
        coefficients[j, i] = np.linalg.lstsq(matrix, vector, rcond=None)[0]
        coefficients[0, 0] += offset
        return y, coefficients, x

    def _sphere(self, paraboloid, first, second):
        """Heights of the least-squares sphere z = c - κr²/(1 + √(1 - κ²r²)) and its radius [m], by Gauss's and Newton's steps.

        scipy's least_squares takes twice the time and 40 % more memory with 4 million pixels, and fails on steep caps.

        paraboloid, first, second: coefficients of `_form(2)`, where the steps start, and its radii. None: no convergence.
        """
        y, x = (np.arange(n) - 0.5 * (n - 1) for n in self.shape)
        y, x = y * self.pixel_y, x * self.pixel_x
        curvature = 0.5 * (1.0 / first + 1.0 / second)
        apex = paraboloid[0, 1] / (x[-1] * curvature), paraboloid[1, 0] / (y[-1] * curvature)
        best, there = np.array([paraboloid[0, 0], *apex, curvature]), np.isfinite(self.heights)
        for _ in range(20):
            top, x0, y0, curvature = best
            dx, dy = x - x0, (y - y0)[:, None]
            square = dx**2 + dy**2
            # the paraboloid is more curved than the sphere, whose equator is beyond the map
            steepest = 0.99 / math.sqrt(np.max(square))
            best[3] = curvature = min(max(curvature, -steepest), steepest)
            root = np.sqrt(1.0 - curvature**2 * square)
            heights = top - curvature * square / (1.0 + root)
            rates = np.ones_like(root), curvature * dx / root, curvature * dy / root, -square / (root * (1.0 + root))
            rates = np.array([rate[there] for rate in rates])
            size = np.sqrt(np.sum(rates**2, axis=1))
            rates /= size[:, None]
            step = np.linalg.lstsq(rates @ rates.T, rates @ (self.heights - heights)[there], rcond=None)[0]
            if np.max(np.abs(step)) <= 1e-12 * math.sqrt(there.sum()) * abs(curvature) * np.max(square):
                return heights, float(1.0 / curvature)
            best = best + step / size
        return None, None

    def cropped(self, width, height=None):
        """The middle of the map, a field of view of `width` by `height` [m] (default: square)."""
        width = units.number(width, "width", "m")
        height = width if height is None else units.number(height, "height", "m")
        rows, columns = round(height / self.pixel_y), round(width / self.pixel_x)
        if not (4 <= rows <= self.shape[0] and 4 <= columns <= self.shape[1]):
            whole = " x ".join(f"{side:g}" for side in self.field_of_view)
            raise DemlawsError(f"a field of view of {width:g} m x {height:g} m: below 4 pixels or beyond the map of {whole} m")
        top = round(0.5 * (self.shape[0] - height / self.pixel_y))
        left = round(0.5 * (self.shape[1] - width / self.pixel_x))
        return self.with_heights(self.heights[top : top + rows, left : left + columns])

    def radii_of_curvature(self):
        """Principal radii [m] of the paraboloid or sphere that fits best, the smaller radius first; negative: a hollow.

        Of a ball's cap both are R; of the tip of a cone they depend on the field of view: crop to the contact's.
        """
        return self._second_order[1]

    def _radii(self, c):
        """Principal radii [m] of a paraboloid with these coefficients of `_form(2)`."""
        a, b = 0.5 * (self.shape[1] - 1) * self.pixel_x, 0.5 * (self.shape[0] - 1) * self.pixel_y
        # the second derivative of the polynomial of order 2 is 3
        hessian = np.array([[3.0 * c[0, 2] / a**2, c[1, 1] / (a * b)], [c[1, 1] / (a * b), 3.0 * c[2, 0] / b**2]])
        curvatures = -np.linalg.eigvalsh(hessian)
        straight = np.abs(curvatures) <= 1e-9 * np.max(np.abs(curvatures))
        first, second = np.where(straight, math.inf, 1.0 / np.where(straight, 1.0, curvatures))
        return float(first), float(second)

    def despiked(self):
        """The map with spikes and fillers as missing pixels.

        Spikes differ from the median of their 5 × 5 surroundings by more than 8 times the robust spread of such differences.
        """
        from scipy.ndimage import median_filter

        filler, heights = plausibility.filler(self.heights), self
        if filler is not None:
            heights = self.with_heights(np.where(self.heights == filler, np.nan, self.heights))
        z = heights.filled().heights
        difference = np.abs(z - median_filter(z, size=5, mode="nearest"))
        spread = 1.4826 * float(np.median(difference))
        if spread == 0.0:
            return heights
        return heights.with_heights(np.where(difference > plausibility.HIGHEST * spread, np.nan, heights.heights))

    def filled(self):
        """Missing pixels as their nearest measured neighbour; others untouched."""
        from scipy.ndimage import distance_transform_edt

        nearest = distance_transform_edt(np.isnan(self.heights), return_distances=False, return_indices=True)
        return self.with_heights(self.heights[tuple(nearest)])

    def spectrum(self, bins=60):
        """Radially averaged power spectral density: q [rad/m], C(q) [m⁴], number of wavevectors averaged; ∫C d²q = Sq².

        Plane removed and Hann window applied. Bins are even in log q and only those that hold a wavevector are returned.
        """
        bins = units.whole(bins, "bins", 1, 100_000)
        z = self.filled().without_form(1).heights
        rows, columns = z.shape
        # periodic Hann windows have mean square 3/8 exactly
        window_y = 0.5 - 0.5 * np.cos(2 * np.pi * (np.arange(rows) + 0.5) / rows)
        window_x = 0.5 - 0.5 * np.cos(2 * np.pi * (np.arange(columns) + 0.5) / columns)
        transform = np.fft.rfft2(z * window_y[:, None] * window_x)
        power = transform.real**2 + transform.imag**2
        del transform, z
        power *= self.pixel_x * self.pixel_y / ((2 * np.pi) ** 2 * rows * columns * (3 / 8) ** 2)
        qx = 2 * np.pi * np.fft.rfftfreq(columns, self.pixel_x)
        qy = 2 * np.pi * np.fft.fftfreq(rows, self.pixel_y)
        q = np.hypot(qy[:, None], qx)
        weight = np.where((qx == 0) | ((columns % 2 == 0) & (np.arange(qx.size) == qx.size - 1)), 1.0, 2.0)
        low = 2 * np.pi / max(self.field_of_view)
        high = np.pi / max(self.pixel_x, self.pixel_y)
        edges = np.geomspace(low * 0.999, high * 1.001, bins + 1)
        index = np.searchsorted(edges, q.ravel())
        weights = np.broadcast_to(weight, q.shape).ravel()
        parts = weights, weights * q.ravel(), weights * power.ravel()
        count, total_q, total = (np.bincount(index, part, minlength=bins + 2)[1:-1] for part in parts)
        nonempty = count > 0
        return total_q[nonempty] / count[nonempty], total[nonempty] / count[nonempty], count[nonempty]

    def fractal_dimension_by_spectrum(self, wavelengths=None):
        """Df = 3 - H from C(q) ∝ q^(-2-2H), fitted between two wavelengths [m].

        wavelengths: (shortest, longest), default 3 pixels to a sixth of the field of view. An instrument's short-wave
        cut-off or a surface's roll-off inside that range must be kept out by giving the range.
        """
        shortest, longest = _wavelengths(wavelengths, 3 * max(self.pixel_x, self.pixel_y), min(self.field_of_view) / 6)
        q, density, count = self.spectrum()
        inside = (q >= 2 * np.pi / longest) & (q <= 2 * np.pi / shortest) & (density > 0)
        if inside.sum() < 4:
            raise DemlawsError(
                f"{inside.sum()} bins of the spectrum lie between {shortest:g} and {longest:g} m: give a wider range of "
                "wavelengths or a larger map with some roughness"
            )
        # the scatter of a bin falls as 1/√count; the cap keeps the many shortest waves from ruling alone
        weight = np.sqrt(np.minimum(count[inside], 3000.0))
        slope = np.polyfit(np.log(q[inside]), np.log(density[inside]), 1, w=weight)[0]
        return float(4.0 + slope / 2.0)

    def box_counts(self, tilted=True):
        """Box sides n [pixels] and the mean height range ⟨max z - min z⟩ [m] in all n by n boxes of a grid over the map.

        Each box is tilted with the plane that fits best in it, so that waves longer than the box do not count. Covering
        the surface with such boxes of side and height n takes N(n) ∝ range(n)/n³ of them; the range is not rounded to
        whole boxes. tilted=False leaves the boxes as they stand.
        """
        z = self.filled().heights
        shortest = min(self.shape)
        largest = max(shortest // 8, min(shortest // 4, 32))
        sizes = [n for n in _BOX_SIDES if n <= largest]
        return np.array(sizes), np.array([_mean_range(z, n, tilted) for n in sizes])

    def fractal_dimension_by_boxes(self, wavelengths=None, plain=False):
        """Df = 3 - H from box counting, ⟨range(n)⟩ ∝ n^H.

        plain: as programs for surfaces count, without correction, which is 0.1 to 0.4 off. Otherwise the slope is corrected
        as calibrated on synthetic self-affine Gaussian maps [our derivation]; a surface that has roughness below its pixel
        size comes out rougher by up to 0.05 (H ≥ 0.5) or 0.15 (H = 0.1).
        wavelengths: (smallest, largest) box [m], default 8 pixels to an eighth of the field of view.
        """
        # a box of n pixels sees fewer extremes than the continuous surface has in it, so the local exponent exceeds H by
        # (b1 + b2/ln n + b3/ln² n)/ln n, b a quadratic of H: maps whose spectrum ends at the pixels' Nyquist wavevector
        sizes, ranges = self.box_counts(not plain)
        pixel = math.sqrt(self.pixel_x * self.pixel_y)
        smallest, largest = _wavelengths(wavelengths, 0.0, math.inf)
        inside = (sizes * pixel >= smallest * 0.999) & (sizes * pixel <= largest * 1.001) & (ranges > 0)
        if inside.sum() < 3:
            raise DemlawsError(
                f"not determined: box counting needs 3 sizes of boxes with a height difference, and this map of "
                f"{self.shape[1]} by {self.shape[0]} pixels has {inside.sum()}; give a rough map of at least 64 by 64 pixels"
            )
        sizes, measured = sizes[inside].astype(float), np.log(ranges[inside])
        if plain:
            return 3.0 - float(np.polyfit(np.log(sizes), measured, 1)[0])
        weight = 1.0 / (1.0 + (8.0 * sizes / min(self.shape)) ** 2)  # large boxes are few
        log = np.log(sizes)

        def misfit(hurst):
            difference = measured - hurst * log - box_correction(hurst, sizes)
            return float(weight @ (difference - weight @ difference / weight.sum()) ** 2)

        hursts = np.linspace(-0.2, 1.3, 1501)
        return 3.0 - float(hursts[np.argmin([misfit(h) for h in hursts])])

    def surface(self, hardness=None, wavelengths=None):
        """The `demlaws.Surface` of this map: Sq, and Df by box counting (as the granite tests did) kept within [2, 3].

        A `MapWarning` is issued for spikes, fillers, slopes above 1, and a Df out of this range.
        """
        dimension = None
        plausibility.warn_of_map(plausibility.doubts(self))
        if self.sq > 0 and min(self.shape) >= 64:
            measured = self.fractal_dimension_by_boxes(wavelengths)
            plausibility.warn_of_map(plausibility.dimension_doubts(measured, None))
            dimension = min(max(measured, 2.0), 3.0)
        return Surface(roughness=self.sq, fractal_dimension=dimension, hardness=hardness)


def _wavelengths(value, shortest, longest):
    """(shortest, longest) wavelength [m] that a user gave, or the default."""
    if value is None:
        return shortest, longest
    try:
        low, high = value
    except (TypeError, ValueError):
        raise DemlawsError(f"wavelengths = {value!r:.60}: give the shortest and the longest in m") from None
    low, high = float(units.as_float(low, "wavelengths", "m")), float(units.as_float(high, "wavelengths", "m"))
    if not 0.0 <= low < high:
        raise DemlawsError(f"wavelengths from {low:g} to {high:g} m: give the shortest and the longest, from 0 on")
    return low, high


_BOX_SIDES = [8, 11, 16, 23, 32, 45, 64, 91, 128, 181, 256, 362, 512]

# (b1, b2, b3) of the local box-counting exponent H + b1/ln n + b2/ln² n + b3/ln³ n, as quadratics in H: least squares on
# mean curves of six 768² maps for each of eleven H in [0.05, 1]
_BOX_CORRECTION = np.array(
    [
        [1.06587141, -3.53756051, 2.3638359],
        [-0.06927216, 7.18631673, -6.48861625],
        [0.88834118, -4.62787429, 5.58264101],
    ]
)


def box_correction(hurst, sizes):
    """ln of what pixels do to the mean range in boxes of `sizes` pixels, up to a constant: ∫(local exponent - H) d ln n."""
    log = np.log(sizes)
    return (_BOX_CORRECTION @ hurst ** np.arange(3)) @ np.array([np.log(log), -1.0 / log, -0.5 / log**2])


def _mean_range(z, n, tilted=True):
    """Mean of max - min over the n by n boxes of the map, each less its least-squares plane if `tilted`."""
    rows, boxes = z.shape[0] // n, z.shape[1] // n
    part = z[: rows * n, : boxes * n].reshape(rows, n, boxes, n)
    if tilted:
        t = np.arange(n) - 0.5 * (n - 1)
        scale = n * (t @ t)
        slope_x = part.sum(axis=1) @ t / scale
        slope_y = np.einsum("aibj,i->ab", part, t) / scale
        part = part - slope_x[:, None, :, None] * t - slope_y[:, None, :, None] * t[:, None, None]
    return float((part.max(axis=(1, 3)) - part.min(axis=(1, 3))).mean())


def self_affine(shape, pixel, hurst, *, roughness, seed, shortest=0.0, longest=math.inf, anisotropy=1.0, periodic=False):
    """A Gaussian self-affine map with the spectrum C(q) ∝ q^(-2-2H).

    Parameters
    ----------
    shape : int or pair of int
        Rows and columns.
    pixel : float or str
        Pixel size [m].
    hurst : float
        Hurst exponent H in (0, 1], Df = 3 - H.
    roughness : float or str
        Sq [m] of the map, exactly.
    seed : int
        Seed of numpy's generator: the same seed gives the same map.
    shortest, longest : float
        Wavelengths [m]: the spectrum is zero below the shortest and flat beyond the longest.
    anisotropy : float
        Ratio of the lengths of features along x and along y.
    periodic : bool
        Default: a window cut out of a periodic map of twice the size, which contains waves longer than the window.

    Returns
    -------
    HeightMap
    """
    sides = shape if np.ndim(shape) else (shape, shape)
    if len(sides) != 2:
        raise DemlawsError(f"shape = {shape!r:.60}: give a number of pixels, or rows and columns")
    rows, columns = (units.whole(n, "shape", 4, 16384) for n in sides)
    hurst = units.number(hurst, "hurst", "", 0.0, 1.0)
    roughness, anisotropy = units.number(roughness, "roughness", "m"), units.number(anisotropy, "anisotropy")
    shortest = units.number(shortest, "shortest", "m", allow_low=True)
    longest = math.inf if isinstance(longest, float) and longest == math.inf else units.number(longest, "longest", "m")
    pixel = units.number(pixel, "pixel", "m")
    try:
        generator = np.random.default_rng(seed)
    except (TypeError, ValueError):
        raise DemlawsError(f"seed = {seed!r:.60}: give a whole number from 0 on") from None
    if not isinstance(periodic, bool | np.bool_):
        raise DemlawsError(f"periodic = {periodic!r:.60}: give True or False")
    factor = 1 if periodic else 2
    noise = generator.standard_normal((factor * rows, factor * columns))
    transform = np.fft.rfft2(noise)
    del noise
    stretch = math.sqrt(anisotropy)
    qx = 2 * np.pi * np.fft.rfftfreq(factor * columns, pixel) * stretch
    qy = 2 * np.pi * np.fft.fftfreq(factor * rows, pixel) / stretch
    q = np.hypot(qy[:, None], qx)
    cut = q > (2 * np.pi / shortest if shortest > 0 else math.inf)
    np.maximum(q, max(2 * np.pi / longest, q[0, 1] * 1e-3), out=q)
    np.power(q, -1.0 - hurst, out=q)
    q[0, 0] = 0.0
    q[cut] = 0.0
    transform *= q
    del q, cut
    heights = np.fft.irfft2(transform, s=(factor * rows, factor * columns))[:rows, :columns]
    heights = heights - heights.mean()
    spread = heights.std()
    if spread == 0:
        raise DemlawsError(f"no wave between {shortest:g} and {longest:g} m fits a map of {columns * pixel:g} m")
    return HeightMap(heights * (roughness / spread), pixel)
