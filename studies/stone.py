"""`python -m studies.stone`: the stone contact of DEMsim and Pohrt-Popov, each fitted to the other; loss of its reloading.

The equations are those of DEMsim's StoneMaterialContact (github.com/erolsson/DEMsim, after tests of Celma Cervera, Jelagin,
Partl & Larsson 2017, Materials & Design 133, 255): a layer of constant stiffness, then Hertz's curve shifted, then a straight
line; unloading with another exponent, reloading with Hertz's.
"""

import math
from typing import NamedTuple

import numpy as np

from demlaws import granite
from demlaws.errors import quiet
from demlaws.laws import POHRT_POPOV
from demlaws.make import law

RADIUS = 6.25e-3  # R [m] at which DEMsim's parameters are stated
ELASTIC = 0.95  # Hertz's coefficient over that of unloading


class Stone(NamedTuple):
    """One contact."""

    coefficient: float  # k = (4/3) E* √R [N/m^1.5]
    depth: float  # h_s [m] of the layer
    force: float  # F_s [N] there
    straight: float = math.inf  # h [m] from which loading is a straight line
    exponent: float = 1.7  # m of unloading

    @classmethod
    def on(cls, contact, depth, force, straight=math.inf):
        """On a contact, from parameters at R = 6.25 mm; the straight line begins at `straight` R/6.25 mm past the layer."""
        coefficient = 4.0 / 3.0 * contact.modulus * math.sqrt(contact.radius)
        return cls(coefficient, depth, force * math.sqrt(contact.radius / RADIUS), depth + straight * contact.radius / RADIUS)

    def load(self, h):
        """Force and stiffness of first loading."""
        h = np.asarray(h, float)
        shift = self.depth - (self.force / self.coefficient) ** (2 / 3)
        past = np.maximum(np.minimum(h, self.straight) - shift, 0.0)
        stiffness = 1.5 * self.coefficient * np.sqrt(past)
        force = self.coefficient * past**1.5 + stiffness * np.maximum(h - self.straight, 0.0)
        layer = h < self.depth
        slope = self.force / self.depth
        return np.where(layer, slope * h, force), np.where(layer, slope, stiffness)

    def recovered(self, top):
        """Overlap [m] that unloading from `top` [m] gives back."""
        return float((ELASTIC * self.load(top)[0] / self.coefficient) ** (2 / 3))

    def loss(self, top, share):
        """Work [J] lost by unloading from `top` to this share of the force and reloading."""
        force, back, m = float(self.load(top)[0]), self.recovered(top), self.exponent
        turn = share ** (1.0 / m)  # recovered overlap left at the turn, over all of it
        released = force * back * (1.0 - turn ** (m + 1.0)) / (m + 1.0)
        # reloading: F = F_max ((h - h_l)/(h_max - h_l))^1.5 from the turn on
        root = share ** (2.0 / 3.0)
        span = back * (1.0 - turn) / (1.0 - root)
        return force * span * (1.0 - root**2.5) / 2.5 - released


def fitted(make, starts, bounds, overlap, force):
    """The parameters whose `make` is nearest in ln of the force, and what it gives; starts, bounds: of the parameters."""
    from scipy.optimize import least_squares

    def misfit(logarithms):
        return np.log(np.maximum(make(*np.exp(logarithms))(overlap)[0], 1e-300) / force)

    limits = np.log(np.transpose(bounds))
    found = min((least_squares(misfit, start, bounds=limits) for start in np.log(starts)), key=lambda one: one.cost)
    return np.exp(found.x), make(*np.exp(found.x))


def errors(found, reference, overlap):
    """Largest relative difference of force and of stiffness."""
    return [float(np.abs(a / b - 1.0).max()) for a, b in zip(found(overlap), reference(overlap), strict=True)]


STONES = ((1e-7, 1e-3), (1e-2, 1e4), (1e-9, 1.0))
"""Bounds of the depth of the layer [m], the force there [N], and the depth at which the straight line begins [m]."""
ROUGH = ((1e-8, 1e-4), (2.0, 3.0))
"""Of σ [m] and Df."""


def there_and_back(test="SS(12-18)", low=1.0, high=100.0):
    """Stone fitted to Pohrt-Popov on a granite test, and Pohrt-Popov to this stone: parameters, errors of force and K."""
    contact = granite.find_test(test).contact

    def curve(roughness, dimension):
        bound = law(POHRT_POPOV, contact.with_values(sigma=roughness, fractal_dimension=dimension), "elastic")
        return lambda h: (bound.force(h), bound.stiffness(h))

    def stone(*values):
        return Stone.on(contact, *values).load

    with quiet():
        target = curve(contact.sigma, contact.fractal_dimension)
        overlap = law(POHRT_POPOV, contact, "elastic").overlap(np.geomspace(low, high, 200))
        starts = [(depth, force, straight) for depth in (5e-6, 2e-5) for force in (3.0, 30.0) for straight in (1e-6, 1e-3)]
        values, nearest = fitted(stone, starts, STONES, overlap, target(overlap)[0])
        rough, near = fitted(curve, [(1e-6, 2.1), (4e-6, 2.3), (1e-5, 2.7)], ROUGH, overlap, nearest(overlap)[0])
        found = errors(nearest, target, overlap), rough, errors(near, nearest, overlap)
    return Stone.on(contact, *values), *found


def main():
    """Print both fits, and the loss of reloading."""
    one, first, (roughness, dimension), second = there_and_back()
    print("SS(12-18), 1 to 100 N; largest error of force and of stiffness")
    print(
        f"stone fitted to pohrt-popov, E* of the granite: layer {one.depth * 1e6:.3g} µm to {one.force:.3g} N, straight from "
        f"{one.straight * 1e6:.3g} µm: {100 * first[0]:.0f} %, {100 * first[1]:.0f} %"
    )
    print(
        f"pohrt-popov fitted to this stone: σ = {roughness * 1e6:.3g} µm, Df = {dimension:.3f}: {100 * second[0]:.0f} %, "
        f"{100 * second[1]:.0f} %"
    )
    top = float(one.straight)
    stored = float(one.load(top)[0]) * one.recovered(top) / (one.exponent + 1.0)
    print(
        f"reloading of the stone (unloading exponent {one.exponent:g}), work lost over the work that full unloading gives back:"
    )
    for share in (0.0, 0.1, 0.2, 0.5, 0.8, 0.9):
        print(f"  down to {share:g} of the largest force: {100 * one.loss(top, share) / stored:.2g} %")


if __name__ == "__main__":
    main()
