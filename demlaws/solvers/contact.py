"""Deterministic contact of a measured rough surface with a smooth ball or flat (Jamari & Schipper 2006-2008).

The gap map is cut at a separation; every connected patch above the cut is replaced by the elliptic paraboloid of the same
area and volume, which carries load as an elastic-plastic ellipsoid; the separation is iterated to the load. Unloading
leaves a deformed map that is the input of the next cycle. The bulk stays elastic and its deflection is left out, as in
the papers.

    contact = RoughContact(heights, pair, poisson=0.34)
    step = contact.load(0.2)                    # LoadStep: area, micro-contacts and their states
    worn = contact.unload(step)                 # RoughContact of the deformed map
"""

import math
from dataclasses import dataclass, field

import numpy as np

from demlaws.contact import smooth_overlap
from demlaws.core.numba_compat import kernel, loop
from demlaws.errors import DemlawsError, warn
from demlaws.solvers.ellipsoid import (
    ALUMINIUM_FACTOR,
    ALUMINIUM_RATIO,
    ELASTIC,
    STATES,
    ellipsoid,
    plasticity,
    quick_factors,
    residual,
)
from demlaws.solvers.scan import AREA, EDGE, LIMIT, SPREAD, VOLUME, X0, Y0, X, Y, gather_patches, paraboloid, scan
from demlaws.surfaces.plausibility import field_doubts, warn_of_map
from demlaws.units import as_typed, number


@kernel
def _response(p, stats, i, shape, remembers):
    """What patch i remembers (blunting, pressure factor at its yield), its mean radius, and what `ellipsoid` gives for it."""
    cut_area, indentation, aspect, _ = shape
    blunt = stats[i, SPREAD] / stats[i, AREA] if remembers else 1.0
    limit = stats[i, LIMIT] / stats[i, AREA] if remembers else p.yield_factor
    geometric = blunt * cut_area / (2.0 * math.pi * indentation)
    mean = geometric / (aspect + 1.0 / aspect)
    ab, gamma = quick_factors(aspect * aspect)
    return (blunt, limit), mean, ellipsoid(p, ab, gamma, mean, geometric, indentation, limit)


_COLUMNS = (
    "x", "y", "cut_area", "volume", "length_long", "length_short", "angle", "indentation", "force", "area", "state",
    "shrink", "spread", "limit", "edge",
)  # fmt: skip


@loop
def _describe(p, stats, patches, pixel_x, pixel_y, remembers, out):
    """Everything about each patch, one row each, columns as in _COLUMNS; patches without volume get zeros."""
    for n in range(patches):
        i = n + 1
        for c in range(out.shape[1]):
            out[n, c] = 0.0
        out[n, 11] = out[n, 12] = 1.0
        out[n, 13] = p.yield_factor
        if not (stats[i, AREA] > 0.0 and stats[i, VOLUME] > 0.0):
            continue
        cut_area, indentation, aspect, angle = shape = paraboloid(stats, i, pixel_x, pixel_y)
        (blunt, limit), mean, values = _response(p, stats, i, shape, remembers)
        force, area, state = values[0], values[1], values[2]
        out[n, 0] = (stats[i, X] / stats[i, AREA] + stats[i, X0]) * pixel_x
        out[n, 1] = (stats[i, Y] / stats[i, AREA] + stats[i, Y0]) * pixel_y
        out[n, 2] = cut_area
        out[n, 3] = stats[i, VOLUME] * pixel_x * pixel_y
        side = math.sqrt(4.0 * cut_area / math.pi)
        out[n, 4], out[n, 5] = side * math.sqrt(aspect), side / math.sqrt(aspect)
        out[n, 6], out[n, 7] = angle, indentation
        out[n, 8], out[n, 9], out[n, 10] = force, area, state
        remainder = residual(p, mean, force, area, indentation, values[6], values[7], state)
        if state != ELASTIC:
            out[n, 11] = 1.0 - remainder / indentation
            out[n, 12] = blunt * area / values[5]
            out[n, 13] = 1.5 * force / (area * p.hardness) * (1.0 + 1e-9)  # rounding is no yield
        else:
            out[n, 12], out[n, 13] = blunt, limit
        out[n, 14] = stats[i, EDGE]


@loop
def _deform(h, cut, labels, patch_of, table, heights, spread, limit):
    """Shrink plastic patches towards the cut, together with the ring of pixels round them, and note what they remember.

    Scaling h - cut on both sides of the contour keeps the contour, and so the area, where it is. The pixels of the ring
    rise: the pile-up. One that borders several patches follows the one that shrinks least, and remembers the highest pressure.
    """
    rows, columns = h.shape
    for i in range(rows):
        for j in range(columns):
            label = labels[i, j]
            patch, yield_limit = -1, 0.0
            if label:
                patch = patch_of[label] - 1
                if table[patch, 10] != ELASTIC:
                    yield_limit = table[patch, 13]
            elif h[i, j] == h[i, j]:
                largest = -1.0
                for di in range(-1, 2):
                    for dj in range(-1, 2):
                        if di == -dj and di != 0:
                            continue  # not an edge of the triangulation
                        a, b = i + di, j + dj
                        if 0 <= a < rows and 0 <= b < columns and labels[a, b]:
                            n = patch_of[labels[a, b]] - 1
                            if table[n, 11] > largest:
                                largest, patch = table[n, 11], n
                            if table[n, 10] != ELASTIC:
                                yield_limit = max(yield_limit, table[n, 13])
            if yield_limit > 0.0:
                limit[i, j] = yield_limit
            if patch >= 0 and table[patch, 10] != ELASTIC:
                heights[i, j] += (table[patch, 11] - 1.0) * (h[i, j] - cut)
                spread[i, j] = table[patch, 12]


@dataclass(frozen=True)
class LoadStep:
    """A rough contact under load. SI units.

    force; separation of ball apex or flat from the mean plane of the map; overlap since first touch; contact_area (real);
    cut_area of the map above the cut; counts: number of micro-contacts that are elastic, elastic-plastic, plastic;
    micro: an array of records, one per micro-contact: x, y [m] from the map's first pixel, cut_area and volume above the cut
    [m², m³], length_long, length_short, angle of the ellipse, indentation ω, force, contact area, state, edge (touches the
    map's edge).
    """

    force: float
    separation: float
    overlap: float
    contact_area: float
    cut_area: float
    counts: tuple
    micro: np.recarray
    cut: float
    touches_edge: bool

    def __str__(self):
        states = ", ".join(f"{n} {name}" for n, name in zip(self.counts, STATES, strict=True))
        return (
            f"force {self.force:.6g} N at separation {self.separation * 1e6:.4g} µm (overlap {self.overlap * 1e6:.4g} µm)\n"
            f"contact area {self.contact_area * 1e12:.5g} µm² in {len(self.micro)} micro-contacts: {states}"
            + (
                "; all are fully plastic: the area is the load over c_h H_m and independent of the map"
                if self.counts[2] == len(self.micro) > 0
                else ""
            )
        )


@dataclass
class RoughContact:
    """A rough map against a smooth ball of the pair's effective radius, or a flat.

    heights: `demlaws.surface.HeightMap`, form removed; pair: `demlaws.Contact` (its radius, modulus and hardness are used);
    poisson: ν of the rough body; flat=True: the counter-body is a flat; centre: (x, y) [m] of the ball's axis from the first
    pixel (default the middle). Missing pixels never touch; fill them first if they should. Without a hardness the asperities
    are elastic. plastic_factor, plastic_ratio: c_h and c_A of the material; default: those of aluminium,
    with a ValidityWarning.

    Unloading leaves in a pixel, besides its height, how much blunter its patch is than its outline tells (`spread`) and the
    pressure that it has carried (`limit`), up to which it stays elastic. The paper of 2008 names a cause, residual stresses
    that raise the yield stress, and leaves it out of its model: this form of it is our assumption. With it the same load
    changes nothing the second time, and loading beyond the largest overlap so far continues the curve of first loading
    [our derivation]: there every patch is wider than the area that it has carried, so that its memory ends, and the map is
    `before`, that of the contact before it was unloaded from the
    overlap `reached`. At another place of the map, or for another pair, what pixels remember stays alone.
    """

    heights: object
    pair: object
    poisson: float = 0.3
    plastic_factor: float | None = None
    plastic_ratio: float | None = None
    flat: bool = False
    centre: tuple | None = None
    spread: np.ndarray | None = field(default=None, repr=False)
    limit: np.ndarray | None = field(default=None, repr=False)
    origin: float | None = None
    before: "RoughContact | None" = field(default=None, repr=False)
    reached: float = -math.inf

    def __post_init__(self):
        if self.pair.size is not None:
            raise DemlawsError("a height map belongs to one contact; this pair is an array of contacts")
        hardness = math.inf if self.pair.hardness is None else self.pair.hardness
        if self.pair.hardness is not None and None in (self.plastic_factor, self.plastic_ratio):
            warn(
                f"c_h = {ALUMINIUM_FACTOR} and c_A = {ALUMINIUM_RATIO:g} are aluminium's: give plastic_factor and "
                "plastic_ratio (--plastic-factor, --plastic-ratio) of this material"
            )
        self.plastic_factor = ALUMINIUM_FACTOR if self.plastic_factor is None else self.plastic_factor
        self.plastic_ratio = ALUMINIUM_RATIO if self.plastic_ratio is None else self.plastic_ratio
        if not self.flat:
            warn_of_map(field_doubts(self.heights, self.pair.radius))
        self.material = plasticity(self.pair.modulus, hardness, self.poisson, self.plastic_factor, self.plastic_ratio)
        rows, columns = self.heights.shape
        px, py = self.heights.pixel_x, self.heights.pixel_y
        if self.centre is None:
            self.centre = (0.5 * (columns - 1) * px, 0.5 * (rows - 1) * py)
        x, y = np.arange(columns) * px - self.centre[0], np.arange(rows)[:, None] * py - self.centre[1]
        self.gap = self.heights.heights - (0.0 if self.flat else (x * x + y * y) / (2.0 * self.pair.radius))
        if self.before is not None and self._conditions() != self.before._conditions():
            self.before, self.reached = None, -math.inf
        self.highest = float(np.nanmax(self.gap))
        if self.origin is None:
            self.origin = self.highest  # where a new surface first touches; overlaps count from here
        self.mean = float(np.nanmean(self.heights.heights))
        most = self.gap.size // 2 + 2  # labels; memory that is not written is not taken
        self._labels = np.zeros(self.gap.shape, np.int32)
        self._parent, self._stats = np.zeros(most, np.int32), np.zeros((most, 12))

    def _patches(self, cut):
        """Every patch above a cut, one row each, columns as in _COLUMNS; their labels are in `_labels` and `_parent`."""
        none = np.empty((0, 0))
        spread, limit = (none, none) if self.spread is None else (self.spread, self.limit)
        count = scan(self.gap, cut, self._labels, self._parent, self._stats, spread, limit)
        table = np.empty((gather_patches(self._parent, self._stats, count), len(_COLUMNS)))
        px, py = self.heights.pixel_x, self.heights.pixel_y
        _describe(self.material, self._stats, len(table), px, py, self.spread is not None, table)
        return table

    def _conditions(self):
        """The pair, its place and its material: those for which `before` counts."""
        return self.pair, self.poisson, self.plastic_factor, self.plastic_ratio, self.flat, self.centre

    def _is_past(self, overlap):
        """Whether an overlap lies beyond all that the surface has carried."""
        return self.before is not None and overlap > self.reached

    def carried(self, overlap):
        """Force [N], contact area [m²] and whether the contact reaches the edge of the map, at an overlap [m] as in `at`."""
        if self._is_past(overlap):
            return self.before.carried(overlap)
        table = self._patches(self.origin - overlap)
        return table[:, 8].sum(), table[:, 9].sum(), table[:, 14].any()

    def at(self, overlap):
        """The `LoadStep` at a given overlap [m] since first touch of the new surface."""
        if self._is_past(overlap):
            return self.before.at(overlap)
        cut = self.origin - overlap
        table = self._patches(cut)
        micro = np.rec.fromarrays(table[table[:, 8] > 0].T, names=_COLUMNS)
        return LoadStep(
            force=float(micro.force.sum()),
            separation=cut - self.mean,
            overlap=overlap,
            contact_area=float(micro.area.sum()),
            cut_area=float(micro.cut_area.sum()),
            counts=tuple(int((micro.state == s).sum()) for s in range(3)),
            micro=micro,
            cut=cut,
            touches_edge=bool(micro.edge.any()),
        )

    def _solve(self, load, rtol, typed):
        """Overlap at which the patches carry `load` within `rtol`.

        The force falls in jumps where patches merge, and rises continuously between: a bracket whose upper end carries more
        than the load and whose lower end carries less closes on a continuous crossing.
        """
        from scipy.optimize import brentq

        base = self.origin - self.highest  # below this overlap nothing touches (a worn surface)
        scale = max(self.heights.sq, 1e-15 * abs(self.highest), 1e-300)

        def excess(logarithm):
            """Ln of the force over the load, at an overlap of e^logarithm past `base`; 0 within the tolerance."""
            force = self.carried(base + math.exp(logarithm))[0]
            return 0.0 if abs(force - load) <= rtol * load else math.log(max(force, 1e-300) / load)

        if self.reached > base and abs(self.carried(self.reached)[0] - load) <= rtol * load:
            return self.reached  # the load of the last cycle
        hertz = 0.0 if self.flat else smooth_overlap(self.pair, load)
        low = high = math.log(max(hertz, 0.5 * scale))
        deepest = math.log(self.highest - float(np.nanmin(self.gap)) + 10 * scale)
        while excess(high) < 0.0:
            if high > deepest:
                raise DemlawsError(f"force = {typed} brings the whole map into contact: use a smaller force or a larger map")
            high += 1.0
        while excess(low) > 0.0:
            low -= 1.0
        root = brentq(excess, low, high, xtol=1e-14, maxiter=300)
        if excess(root) != 0.0:
            raise DemlawsError(
                f"no separation carries {typed} within rtol = {rtol:g}: the force is discontinuous there; give a larger one "
                "or a map with more pixels in contact"
            )
        return base + math.exp(root)

    def load(self, force, rtol=0.01):
        """Press until the micro-contacts carry `force` [N] within a relative tolerance: a `LoadStep`.

        Warns (ValidityWarning) where the regime criterion says that the bulk yields too, and where the contact reaches
        the edge of the map.
        """
        step = self.at(self._solve(number(force, "force", "N"), number(rtol, "rtol", high=1.0), as_typed(force, "N")))
        self.warn_of_edge(step)
        return step

    def warn_of_edge(self, step):
        """Warn where the model leaves out what happens at this step."""
        from demlaws.solvers import criterion

        if self.flat:
            return
        if self.pair.hardness is not None:
            ratio = criterion.pressure_ratio(self.pair.with_values(sigma=self.heights.sq), step.force)
            if ratio >= criterion.YIELD_RATIO:
                warn(
                    f"asperity: at {step.force:.3g} N p(0)/H_m = {ratio:.2f} ≥ {criterion.YIELD_RATIO}: the bulk also yields, "
                    "which this model neglects"
                )
        if step.touches_edge:
            warn(
                f"asperity: at {step.force:.3g} N the contact reaches the edge of the map: its load is a lower bound; "
                "measure a larger area"
            )

    def unload(self, step):
        """The `RoughContact` that `step` leaves behind: plastic patches lowered, with the memory of their pixels.

        A plastic patch of indentation ω keeps ω' = 3P γ̄^1.5/(4√2 E* √g), g = A γ̄/(2π ᾱβ̄): the height of the ellipsoid that
        carries the same force elastically over the same area A [our derivation].
        """
        if self._is_past(step.overlap):
            return self.before.unload(step)
        table = self._patches(step.cut)
        heights = self.heights.heights.copy()
        spread = np.ones(self.gap.shape) if self.spread is None else self.spread.copy()
        limit = np.full(self.gap.shape, self.material.yield_factor) if self.limit is None else self.limit.copy()
        _deform(self.gap, step.cut, self._labels, self._parent, table, heights, spread, limit)
        return RoughContact(
            self.heights.with_heights(heights),
            self.pair,
            self.poisson,
            self.plastic_factor,
            self.plastic_ratio,
            self.flat,
            self.centre,
            spread,
            limit,
            self.origin,
            self if self.before is None else self.before,
            max(self.reached, step.overlap),
        )

    def change_from(self, earlier):
        """Volume ∫|Δz| [m³] by which the map differs from that of an earlier contact."""
        change = np.abs(self.heights.heights - earlier.heights.heights)
        return float(np.nansum(change)) * self.heights.pixel_x * self.heights.pixel_y
