"""The closed forms of the explicit laws at 50 digits, written from the papers and not from the package.

Every function takes what a user gives (floats are exact) and nothing that the package derives. A reference has `force`,
`stiffness` and `energy` of an overlap, `overlap` of a force, and `kinks`; all values are mpmath numbers.
"""

import itertools

import mpmath
import numpy as np
from mpmath import mp, mpf

EPS = float(np.finfo(float).eps)
mp.dps = 50


class Reference:
    """Base: the energy of a law without a closed form is a quadrature, graded towards the ends."""

    kinks = ()

    def energy(self, overlap):
        overlap = mpf(overlap)
        corners = [mpf(0), *sorted(k for k in self.kinks if k < overlap), overlap]
        total = mpf(0)
        for a, b in itertools.pairwise(corners):  # x = a + (b - a) t^4: force^1.5 of the end is smooth
            total += mpmath.quad(lambda t, a=a, b=b: self.force(a + (b - a) * t**4) * 4 * t**3 * (b - a), [0, 1])
        return total


class Hertz(Reference):
    def __init__(self, radius, modulus, **_):
        self.c = mpf(4) / 3 * mpf(modulus) * mpmath.sqrt(mpf(radius))

    def force(self, overlap):
        return self.c * mpf(overlap) ** mpf("1.5")

    def stiffness(self, overlap):
        return mpf("1.5") * self.c * mpmath.sqrt(mpf(overlap))

    def overlap(self, force):
        return mpmath.cbrt(mpf(force) / self.c) ** 2

    def energy(self, overlap):
        return mpf("0.4") * self.c * mpf(overlap) ** mpf("2.5")


class Rms(Reference):
    """a*/a_H = 2.4 - 2.8/(α + 2), δ = a*²/R."""

    def __init__(self, radius, modulus, roughness, **_):
        self.hertz = Hertz(radius, modulus)
        self.roughness = mpf(roughness)

    def alpha(self, overlap):
        """The root of u = (2.4α + 2)²/(α(α + 2)²) by Newton's method in logarithms."""
        target = mpmath.log(mpf(overlap) / self.roughness)
        x = -target
        for _ in range(60):
            a = mpmath.exp(x)
            value = 2 * mpmath.log(mpf("2.4") * a + 2) - x - 2 * mpmath.log(a + 2) - target
            slope = 2 * mpf("2.4") * a / (mpf("2.4") * a + 2) - 1 - 2 * a / (a + 2)
            x -= value / slope
            if abs(value) < mpf(10) ** -45:
                return mpmath.exp(x)
        raise AssertionError("Newton's method did not converge")

    def force(self, overlap):
        return self.hertz.force(self.roughness / self.alpha(overlap))

    def stiffness(self, overlap):
        a = self.alpha(overlap)
        part = mpf(2) / 3 - mpf(4) / 3 * mpf("2.8") * a / ((a + 2) * (mpf("2.4") * a + 2))
        return self.hertz.force(self.roughness / a) / mpf(overlap) / part

    def overlap(self, force):
        hertz = self.hertz.overlap(force)
        a = self.roughness / hertz
        return hertz * (mpf("2.4") - mpf("2.8") / (a + 2)) ** 2


class PohrtPopov(Reference):
    """K = c P^m up to F, then Hertz stiffness."""

    def __init__(self, radius, modulus, roughness, fractal_dimension, **_):
        radius, modulus, roughness, dimension = map(mpf, (radius, modulus, roughness, fractal_dimension))
        self.hertz = Hertz(radius, modulus)
        self.m = m = mpf("0.2567") * dimension
        a0 = mpf("0.75") * mp.pi ** mpf("1.5") * radius * roughness * (20 / (mp.pi ** mpf("1.5") * dimension)) ** (1 / m)
        root = mpmath.sqrt(a0)
        self.c = mp.pi * root * modulus * dimension / 10 * (roughness * modulus * root) ** -m
        self.threshold = 4 * modulus / (3 * radius) * (a0 / mp.pi) ** mpf("1.5")
        self.overlap_at_threshold = self.threshold ** (1 - m) / (self.c * (1 - m))
        self.kinks = (self.overlap_at_threshold,)

    def condition(self, overlap):
        """q (1 + |ln(δ/δ_F)|): what rounding q alone costs."""
        return (1 + abs(mpmath.log(mpf(overlap) / self.overlap_at_threshold))) / (1 - self.m)

    def force(self, overlap):
        overlap = mpf(overlap)
        if overlap < self.overlap_at_threshold:
            return (self.c * (1 - self.m) * overlap) ** (1 / (1 - self.m))
        return self.hertz.force(overlap - self.overlap_at_threshold + self.hertz.overlap(self.threshold))

    def stiffness(self, overlap):
        force = self.force(overlap)
        if mpf(overlap) < self.overlap_at_threshold:
            return self.c * force**self.m
        return self.hertz.stiffness(self.hertz.overlap(force))

    def overlap(self, force):
        force = mpf(force)
        if force < self.threshold:
            return force ** (1 - self.m) / (self.c * (1 - self.m))
        return self.overlap_at_threshold + self.hertz.overlap(force) - self.hertz.overlap(self.threshold)

    def energy(self, overlap):
        overlap = mpf(overlap)
        low = min(overlap, self.overlap_at_threshold)
        work = self.force(low) * low / (1 / (1 - self.m) + 1)
        if overlap > low:
            shift = self.hertz.overlap(self.threshold) - low
            work += self.hertz.energy(overlap + shift) - self.hertz.energy(low + shift)
        return work


class Goddard(Reference):
    """K = 2 √(2 E* P/(π tan β)) up to P* = (9π³/128) E* R² tan³β, then Hertz stiffness."""

    def __init__(self, radius, modulus, slope, **_):
        radius, modulus, tangent = mpf(radius), mpf(modulus), mpmath.tan(mpf(slope))
        self.hertz = Hertz(radius, modulus)
        self.cone = 2 * modulus / (mp.pi * tangent)  # P = cone δ²: K = 2 cone δ = 2 √(cone P)
        self.threshold = 9 * mp.pi**3 / 128 * modulus * radius**2 * tangent**3
        self.overlap_at_threshold = mpmath.sqrt(self.threshold / self.cone)
        self.shift = self.overlap_at_threshold - self.hertz.overlap(self.threshold)
        self.kinks = (self.overlap_at_threshold,)

    def force(self, overlap):
        overlap = mpf(overlap)
        return self.cone * overlap**2 if overlap < self.overlap_at_threshold else self.hertz.force(overlap - self.shift)

    def stiffness(self, overlap):
        overlap = mpf(overlap)
        return 2 * self.cone * overlap if overlap < self.overlap_at_threshold else self.hertz.stiffness(overlap - self.shift)

    def overlap(self, force):
        force = mpf(force)
        return mpmath.sqrt(force / self.cone) if force < self.threshold else self.hertz.overlap(force) + self.shift

    def energy(self, overlap):
        overlap = mpf(overlap)
        low = min(overlap, self.overlap_at_threshold)
        work = self.cone * low**3 / 3
        if overlap > low:
            work += self.hertz.energy(overlap - self.shift) - self.hertz.energy(low - self.shift)
        return work


class RoughPlastic(Reference):
    """K = min(K_rough(P), π R p_y)."""

    def __init__(self, radius, yield_pressure, loading="pohrt-popov", **values):
        self.rough = REFERENCES[loading](radius=radius, **values)
        self.stiffness_at_yield = mp.pi * mpf(radius) * mpf(yield_pressure)
        self.radius, self.yield_pressure = mpf(radius), mpf(yield_pressure)
        self.modulus = mpf(values["modulus"])
        self.overlap_at_yield = self._solve()
        self.force_at_yield = self.rough.force(self.overlap_at_yield)
        self.kinks = (*(k for k in self.rough.kinks if k < self.overlap_at_yield), self.overlap_at_yield)

    def _solve(self):
        # all the rough laws end parallel to Hertz, whose load of that stiffness brackets the one sought from below
        hertz = Hertz(self.radius, self.modulus)
        low = mpmath.log((self.stiffness_at_yield / (mpf("1.5") * hertz.c)) ** 2) - 2
        high = low + 60
        for _ in range(170):
            middle = (low + high) / 2
            if self.rough.stiffness(mpmath.exp(middle)) < self.stiffness_at_yield:
                low = middle
            else:
                high = middle
        return mpmath.exp(low)

    def force(self, overlap):
        more = mpf(overlap) - self.overlap_at_yield
        return self.rough.force(overlap) if more < 0 else self.force_at_yield + self.stiffness_at_yield * more

    def stiffness(self, overlap):
        return self.rough.stiffness(overlap) if mpf(overlap) < self.overlap_at_yield else self.stiffness_at_yield

    def overlap(self, force):
        more = mpf(force) - self.force_at_yield
        return self.rough.overlap(force) if more < 0 else self.overlap_at_yield + more / self.stiffness_at_yield

    def energy(self, overlap):
        low = min(mpf(overlap), self.overlap_at_yield)
        more = mpf(overlap) - low
        return self.rough.energy(low) + more * (self.force_at_yield + self.stiffness_at_yield * more / 2)


class Bahrami(Reference):
    """δ/δ_H = a_L'²/2 + 8 p0' a_L'/(π² (4.79 - 3.17 p0'^3.13)), less its value at P → 0."""

    def __init__(self, radius, modulus, roughness, hardness, constant=None, **_):
        self.hertz = Hertz(radius, modulus)
        self.roughness = mpf(roughness)
        joined = (mpf("3.51") - mpf("2.51") * mpf("0.47")) * mpmath.sqrt(mpf("0.47"))  # 1.5976
        self.constant = joined if constant is None else mpf(constant)
        kappa = mpf(hardness) / mpf(modulus) * mpmath.sqrt(mpf(radius) / mpf(roughness))
        self.b = mpf("1.22") * kappa ** mpf("-0.16")
        self.initial = self.roughness * self.constant**2 * self.b / 2
        joint = self.roughness * self.b * mpf("0.47") / mpf("0.53")
        self.overlap_at_joint = self._of_hertz(joint, mpf("0.47"))
        self.kinks = (self.overlap_at_joint,)

    def _of_hertz(self, hertz, p=None):
        p = 1 / (1 + self.b * self.roughness / hertz) if p is None else p
        a = self.constant / mpmath.sqrt(p) if p <= mpf("0.47") else mpf("3.51") - mpf("2.51") * p
        return hertz * (a * a / 2 + 8 * p * a / (mp.pi**2 * (mpf("4.79") - mpf("3.17") * p ** mpf("3.13")))) - self.initial

    def overlap(self, force):
        return self._of_hertz(self.hertz.overlap(force))

    def _hertz_overlap(self, overlap):
        """Bisection in ln δ_H, then the secant method."""
        overlap = mpf(overlap)
        low, high = mpmath.log(overlap) - 5, mpmath.log(overlap + 4 * self.initial) + 2
        for _ in range(30):
            middle = (low + high) / 2
            low, high = (middle, high) if self._of_hertz(mpmath.exp(middle)) < overlap else (low, middle)
        x, y = low, high
        fx, fy = (mpmath.log(self._of_hertz(mpmath.exp(t)) / overlap) for t in (x, y))
        for _ in range(30):
            if fx == fy or abs(fy) < mpf(10) ** -43:
                break
            x, y, fx = y, y - fy * (y - x) / (fy - fx), fy
            fy = mpmath.log(self._of_hertz(mpmath.exp(y)) / overlap)
        return mpmath.exp(y)

    def force(self, overlap):
        return self.hertz.force(self._hertz_overlap(overlap))

    def stiffness(self, overlap):
        hertz = self._hertz_overlap(overlap)
        with mp.workdps(80):
            slope = mpmath.diff(self._of_hertz, hertz, h=hertz * mpf(10) ** -25)
        return self.hertz.stiffness(hertz) / slope


class WaltonBraun(Reference):
    """k1 δ; back along k2 (δ - δ0), δ0 = δmax (1 - k1/k2), k2 = ratio k1 or k1 + S Pmax."""

    def __init__(self, loading_stiffness, stiffness_ratio=None, growth=None, **_):
        self.k1 = mpf(loading_stiffness)
        self.ratio, self.growth = mpf(stiffness_ratio or 1), mpf(growth or 0)

    def force(self, overlap):
        return self.k1 * mpf(overlap)

    def stiffness(self, overlap):
        return self.k1

    def overlap(self, force):
        return mpf(force) / self.k1

    def energy(self, overlap):
        return self.k1 * mpf(overlap) ** 2 / 2

    def unloading(self, maximum, overlap):
        k2 = self.ratio * self.k1 + self.growth * self.force(maximum)
        return max(mpf(0), k2 * (mpf(overlap) - mpf(maximum) * (1 - self.k1 / k2)))


REFERENCES = {
    "hertz": Hertz,
    "rms": Rms,
    "pohrt-popov": PohrtPopov,
    "goddard": Goddard,
    "rough-plastic": RoughPlastic,
    "bahrami": Bahrami,
    "walton-braun": WaltonBraun,
}


def errors(values, exact):
    """Relative errors in units of ε, against mpmath numbers."""
    return np.array([float(abs(mpf(float(v)) / e - 1)) / EPS for v, e in zip(np.ravel(values), exact, strict=True)])
