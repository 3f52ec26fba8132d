"""Measured points whose smoothed curve is stiffer, within their noise, than the curve along which the contact unloads."""

from collections.abc import Callable

import numpy as np

from demlaws.curves.points import MeasuredCurve
from demlaws.errors import NotPassive, warn

WIDEST = 3.0
"""Standard uncertainties by which the force may change: the band that holds the whole true curve. [our choice]"""
_PLACES, _BELOW = 120, 40
"""Places at which the change is known, between the points and below them."""
_LOWEST = 1e-3
"""Lowest of these places, over the first overlap of the points."""


class LimitedCurve:
    """`curve` with a stiffness of at most K_U/(1 + margin) at each load P, where K_U(P) is that of `along`. [our derivation]

    A contact returns no more work than it took where dδ/dP ≥ 1/K_U, that is, where g(P) = δ(P) - (1 + margin) δ_U(P) does not
    fall. Between the points g becomes the mean of its largest value so far and its lowest from there on: of all curves that do
    not fall the one that is nearest at the worst place. Below the points, where nothing was measured, g is the lowest from
    there on; below the lowest place the curve is a multiple of `along`. Beyond the last point the stiffness is constant.

    along: loads [N] → overlap [m], stiffness [N/m]; margin: relative error of the table that is made of this curve.
    """

    def __init__(self, curve: MeasuredCurve, along: Callable, margin: float):
        from scipy.interpolate import PchipInterpolator

        self._along, self._more, self.largest = along, 1.0 + margin, curve.largest
        inside = np.exp(np.linspace(curve.x[0], curve.x[-1], _PLACES))
        below = inside[0] * np.geomspace(_LOWEST, 1.0, _BELOW + 1)[:-1]
        loads = curve.evaluate(np.append(below, inside))[0]
        rest = np.append(below, inside) - self._more * along(loads)[0]
        highest, lowest = np.maximum.accumulate(rest[_BELOW:]), np.minimum.accumulate(rest[::-1])[::-1]
        rest = np.append(lowest[:_BELOW], 0.5 * (highest + lowest[_BELOW:]))
        rest = np.maximum(np.minimum.accumulate(rest[::-1])[::-1], 0.0)
        self._rest, self._x = PchipInterpolator(np.log(loads), rest), np.log(loads[[0, -1]])
        self._low = float(rest[0] / along(loads[:1])[0][0])
        self._end = float(loads[-1]), *(float(one[0]) for one in self._at(loads[-1:]))
        self._overlaps, self._loads = self._at(loads)[0], loads
        self.kinks = [float(self._overlaps[0])]

    def _at(self, load):
        """Overlap [m] and its derivative dδ/dP [m/N] at loads [N] up to the last."""
        overlap, stiffness = self._along(load)
        x = np.log(load)
        below = x < self._x[0]
        rest = np.where(below, self._low * overlap, self._rest(np.maximum(x, self._x[0])))
        slope = np.where(below, self._low / stiffness, self._rest(np.maximum(x, self._x[0]), 1) / load)
        return self._more * overlap + rest, self._more / stiffness + slope

    def evaluate(self, overlap: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Force [N] and stiffness [N/m] at overlaps [m] > 0."""
        overlap = np.asarray(overlap, float)
        last, at, flexibility = self._end
        beyond = overlap > at
        inside = np.minimum(overlap, at)
        x = np.log(inside)
        load = np.exp(np.interp(x, np.log(self._overlaps), np.log(self._loads)))
        for _ in range(30):  # Newton's rule for ln P over ln δ
            there, slope = self._at(np.minimum(load, last))
            step = (x - np.log(there)) * there / (slope * load)
            load = np.minimum(load * np.exp(np.clip(step, -3.0, 3.0)), last)
            if np.all(np.abs(step) < 1e-15):
                break
        slope = np.where(beyond, flexibility, self._at(load)[1])
        return np.where(beyond, last + (overlap - at) / flexibility, load), 1.0 / slope


def limited(curve: MeasuredCurve, along: Callable, rtol: float, whose: str) -> tuple:
    """(`LimitedCurve`, its `Knots`) of measured points; NotPassive where it leaves their band of uncertainty.

    rtol: tolerance of the table of the curve; whose: the unloading, in words.
    """
    if not along(curve.evaluate(np.exp(curve.x[:1]) * _LOWEST)[0])[0][0] > 0.0:
        raise NotPassive(f"points cannot take {whose}: its force at overlap 0 is not 0; use unloading 'elastic'")
    result = LimitedCurve(curve, along, 1.01 * rtol)
    places = np.exp(np.linspace(curve.x[0], curve.x[-1], _PLACES))
    force, stiffness = curve.evaluate(places)
    ratio = stiffness / along(force)[1]
    sigma = np.interp(np.log(places), np.log(curve.knots.overlap), curve.error)
    change = np.abs(result.evaluate(places)[0] - force)
    excess = change / np.maximum(WIDEST * sigma, 2.0 * rtol * force)
    worst, stiffest = int(np.argmax(excess)), int(np.argmax(ratio))
    at = f"at {force[stiffest]:.3g} N the stiffness is {stiffness[stiffest]:.4g} N/m, that of {whose} "
    at += f"{stiffness[stiffest] / ratio[stiffest]:.4g} N/m"
    by = f"{change[worst]:.2g} N at {force[worst]:.3g} N"
    if excess[worst] > 1.0:
        raise NotPassive(
            f"points: {at}, so that unloading would return more work than loading took; a curve that is nowhere stiffer is off "
            f"by {by}, where the standard uncertainty of the force is {sigma[worst]:.2g} N (at most {WIDEST:g} times that is "
            "allowed): use unloading 'elastic', or check the modulus, the radius and the zero of the overlap"
        )
    text = f"stiffness limited to that of {whose}"
    if ratio[stiffest] > 1.0:
        text = f"{text}, the force changes by up to {by}"
        warn(f"points: {at} (by noise): the curve's {text}, within {WIDEST:g} standard uncertainties")
    else:
        text = f"{text} outside the points"
    overlap, load = curve.points
    departure = float(np.max(np.abs(result.evaluate(overlap)[0] - load)))
    knots = curve.knots._replace(force=result.evaluate(curve.knots.overlap)[0], departure=departure)
    return result, knots._replace(smoothing=f"{knots.smoothing}; {text}")
