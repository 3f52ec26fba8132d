"""The closed forms of the explicit laws at 50 digits, written from the papers and not from the package.

Every function takes what a user gives (floats are exact) and nothing that the package derives. A reference has `force` and
`stiffness` of an overlap, `overlap` of a force, and `kinks`; all values are mpmath numbers.
"""

import itertools

import mpmath
import numpy as np
from mpmath import mp, mpf

EPS = float(np.finfo(float).eps)
mp.dps = 50


class Reference:
    """Base: stiffness is a difference quotient, energy a quadrature, graded towards the ends."""

    kinks = ()

    def condition(self, overlap):
        """What rounding the overlap costs besides."""
        return 1

    def overlap(self, force, near):
        """One step of Newton's method from an overlap that has an error of rounding, which is squared."""
        return mpf(near) - (self.force(near) - mpf(force)) / self.stiffness(near)

    def stiffness(self, overlap):
        with mp.workdps(80):
            return mpmath.diff(self.force, mpf(overlap), h=mpf(overlap) * mpf(10) ** -25)

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

    def overlap(self, force, near=None):
        return mpmath.cbrt(mpf(force) / self.c) ** 2

    def energy(self, overlap):
        return mpf("0.4") * self.c * mpf(overlap) ** mpf("2.5")


class OfForce(Reference):
    """A law whose equation gives the overlap of a force, from Hertz's overlap at that force."""

    def overlap(self, force, near=None):
        return self.of_hertz(self.hertz.overlap(force))

    def force(self, overlap):
        """By the secant method in logarithms, from below every root."""
        overlap = mpf(overlap)
        start = mpmath.log(overlap) - 5
        root = mpmath.findroot(lambda x: mpmath.log(self.of_hertz(mpmath.exp(x)) / overlap), (start, start + 1))
        return self.hertz.force(mpmath.exp(root))

    def stiffness(self, overlap):
        force = self.force(overlap)
        with mp.workdps(80):
            return 1 / mpmath.diff(self.overlap, force, h=force * mpf(10) ** -25)


class Rms(OfForce):
    """a*/a_H = 2.4 - 2.8/(α + 2), δ = a*²/R."""

    def __init__(self, radius, modulus, roughness, **_):
        self.hertz = Hertz(radius, modulus)
        self.roughness = mpf(roughness)

    def of_hertz(self, hertz):
        return hertz * (mpf("2.4") - mpf("2.8") / (self.roughness / hertz + 2)) ** 2


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

    def condition(self, overlap):
        return self.rough.condition(min(overlap, self.overlap_at_yield))

    def _solve(self):
        # all the rough laws end parallel to Hertz, whose load of that stiffness brackets the one sought from below
        low = mpmath.log((self.stiffness_at_yield / (mpf("1.5") * Hertz(self.radius, self.modulus).c)) ** 2) - 2

        def above(log_overlap):
            return mpmath.log(self.rough.stiffness(mpmath.exp(log_overlap)) / self.stiffness_at_yield)

        return mpmath.exp(mpmath.findroot(above, (low, low + 60), solver="anderson"))

    def force(self, overlap):
        more = mpf(overlap) - self.overlap_at_yield
        return self.rough.force(overlap) if more < 0 else self.force_at_yield + self.stiffness_at_yield * more


class Bahrami(OfForce):
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
        self.overlap_at_joint = self.of_hertz(joint, mpf("0.47"))
        self.kinks = (self.overlap_at_joint,)

    def of_hertz(self, hertz, p=None):
        p = 1 / (1 + self.b * self.roughness / hertz) if p is None else p
        a = self.constant / mpmath.sqrt(p) if p <= mpf("0.47") else mpf("3.51") - mpf("2.51") * p
        return hertz * (a * a / 2 + 8 * p * a / (mp.pi**2 * (mpf("4.79") - mpf("3.17") * p ** mpf("3.13")))) - self.initial


class WaltonBraun(Reference):
    """k1 δ; back along k2 (δ - δ0), δ0 = δmax (1 - k1/k2), k2 = ratio k1 or k1 + S Pmax."""

    def __init__(self, loading_stiffness, stiffness_ratio=None, growth=None, **_):
        self.k1 = mpf(loading_stiffness)
        self.ratio, self.growth = mpf(stiffness_ratio or 1), mpf(growth or 0)

    def force(self, overlap):
        return self.k1 * mpf(overlap)

    def unloading(self, maximum, overlap):
        k2 = self.ratio * self.k1 + self.growth * self.force(maximum)
        return max(mpf(0), k2 * (mpf(overlap) - mpf(maximum) * (1 - self.k1 / k2)))


class ThorntonNing(Reference):
    """Hertz to p_y = 2 E* a_y/(π R), then P = P_y + π p_y R (δ - δ_y); R_p = (4E*/(3P)) ((2P + P_y)/(2π p_y))^1.5."""

    def __init__(self, radius, modulus, yield_pressure, **_):
        self.radius, self.modulus, self.pressure = map(mpf, (radius, modulus, yield_pressure))
        self.hertz = Hertz(radius, modulus)
        self.overlap_at_yield = (mp.pi * self.radius * self.pressure / (2 * self.modulus)) ** 2 / self.radius
        self.force_at_yield = self.hertz.force(self.overlap_at_yield)
        self.slope = mp.pi * self.pressure * self.radius
        self.kinks = (self.overlap_at_yield,)

    def force(self, overlap):
        overlap = mpf(overlap)
        if overlap <= self.overlap_at_yield:
            return self.hertz.force(overlap)
        return self.force_at_yield + self.slope * (overlap - self.overlap_at_yield)

    def unloading(self, maximum, overlap):
        force = self.force(maximum)
        radius = (
            4 * self.modulus / (3 * force) * ((2 * force + self.force_at_yield) / (2 * mp.pi * self.pressure)) ** mpf("1.5")
        )
        if mpf(maximum) <= self.overlap_at_yield:
            return self.force(overlap)
        curve = Hertz(radius, self.modulus)
        return curve.force(max(mpf(0), mpf(overlap) - mpf(maximum) + curve.overlap(force)))


class ConicalDamage(Reference):
    """As Suhr & Six write it: u_N = u + (R0 - R) A; where (2E*/π) √(u_N/R) > σmax, R = (u + R0 A)/(h + A)."""

    def __init__(self, radius, modulus, strength, angle, **_):
        self.r0, self.modulus, self.strength = map(mpf, (radius, modulus, strength))
        self.a = (1 - mpmath.sin(mpf(angle))) / mpmath.sin(mpf(angle))
        self.h = (mp.pi * self.strength / (2 * self.modulus)) ** 2
        self.kinks = (self.h * self.r0,)

    def radius(self, overlap):
        overlap = mpf(overlap)
        crushed = 2 * self.modulus / mp.pi * mpmath.sqrt(overlap / self.r0) > self.strength
        return (overlap + self.r0 * self.a) / (self.h + self.a) if crushed else self.r0

    def on(self, radius, overlap):
        elastic = mpf(overlap) + (self.r0 - radius) * self.a
        return 4 * self.modulus / 3 * mpmath.sqrt(radius) * elastic ** mpf("1.5") if elastic > 0 else mpf(0)

    def force(self, overlap):
        return self.on(self.radius(overlap), overlap)

    def unloading(self, maximum, overlap):
        return self.on(self.radius(maximum), overlap)


class Luding(WaltonBraun):
    """k1 δ to δ* = k̂2/(k̂2 - k1) φ_f 2R, then k̂2; back along k2 (δ - δ0), k2 = k1 + (k̂2 - k1) δmax/δ*."""

    def __init__(self, radius, loading_stiffness, stiffness_ratio, plasticity_depth, **_):
        self.k1 = mpf(loading_stiffness)
        self.largest = self.k1 * mpf(stiffness_ratio)
        self.limit = self.largest / (self.largest - self.k1) * mpf(plasticity_depth) * 2 * mpf(radius)
        self.kinks = (self.limit,)

    def force(self, overlap):
        overlap = mpf(overlap)
        return self.k1 * overlap if overlap <= self.limit else self.k1 * self.limit + self.largest * (overlap - self.limit)

    def unloading(self, maximum, overlap):
        k2 = self.k1 + (self.largest - self.k1) * min(1, mpf(maximum) / self.limit)
        return max(mpf(0), self.force(maximum) - k2 * (mpf(maximum) - mpf(overlap)))


class Eepa(Reference):
    """k1 δ^1.5; back along k2 (δ^1.5 - δp^1.5), δp = (1 - k1/k2)^(1/1.5) δmax."""

    def __init__(self, radius, modulus, stiffness_ratio, softness=1.0, **_):
        self.hertz, self.softness, self.ratio = Hertz(radius, modulus), mpf(softness), mpf(stiffness_ratio)

    def force(self, overlap):
        return self.softness * self.hertz.force(overlap)

    def unloading(self, maximum, overlap):
        plastic = mpmath.cbrt(1 - 1 / self.ratio) ** 2 * mpf(maximum)
        return max(mpf(0), self.ratio * (self.force(overlap) - self.force(plastic)))


class KogutEtsion(Reference):
    """ω_c = (π K H/(2E*))² R, K = 0.454 + 0.41 ν, H = 2.8 Y; the smallest of ω^1.5, 1.03 ω^1.425, 1.40 ω^1.263."""

    BRANCHES = ((mpf(1), mpf("1.5")), (mpf("1.03"), mpf("1.425")), (mpf("1.40"), mpf("1.263")))

    def __init__(self, radius, modulus, yield_strength, poisson=0.3, **_):
        self.radius, self.modulus = mpf(radius), mpf(modulus)
        k = mpf("0.454") + mpf("0.41") * mpf(poisson)
        self.critical = (mp.pi * k * mpf("2.8") * mpf(yield_strength) / (2 * mpf(modulus))) ** 2 * mpf(radius)
        self.hertz = Hertz(radius, modulus)
        self.carried = self.hertz.force(self.critical)
        pairs = itertools.pairwise(self.BRANCHES)
        self.kinks = tuple(self.critical * (c / b) ** (1 / (p - q)) for (b, p), (c, q) in pairs)

    def branch(self, overlap):
        return min(self.BRANCHES, key=lambda one: one[0] * (mpf(overlap) / self.critical) ** one[1])

    def force(self, overlap):
        factor, power = self.branch(overlap)
        return self.carried * factor * (mpf(overlap) / self.critical) ** power

    def contact_radius(self, overlap):
        ratio = mpf(overlap) / self.critical
        return mpmath.sqrt(self.radius * self.critical * max(ratio, mpf("0.94") * ratio ** mpf("1.146")))

    def unloading(self, maximum, overlap):
        """R_p = 4 E* a³/(3 F), δ_res = δmax - 3F/(4 E* a): Etsion, Kligerman & Kadin as Jackson et al. 2010 give them."""
        force, a = self.force(maximum), self.contact_radius(maximum)
        residual = mpf(maximum) - 3 * force / (4 * self.modulus * a)
        return Hertz(4 * self.modulus * a**3 / (3 * force), self.modulus).force(max(mpf(0), mpf(overlap) - residual))

    def unloading_of_finite_elements(self, maximum, overlap):
        """δ_res/δmax = 1.02 (1 - ((ω + 5.9)/6.9)^-0.54) for 1 ≤ ω ≤ 145, R_p = (3F/(4 E*))²/(δmax - δ_res)³."""
        w = min(max(mpf(maximum) / self.critical, mpf(1)), mpf(145))
        residual = mpf(maximum) * mpf("1.02") * (1 - ((w + mpf("5.9")) / mpf("6.9")) ** mpf("-0.54"))
        radius = (3 * self.force(maximum) / (4 * self.modulus)) ** 2 / (mpf(maximum) - residual) ** 3
        return Hertz(radius, self.modulus).force(max(mpf(0), mpf(overlap) - residual))


class JacksonGreen(KogutEtsion):
    """P/P_c = exp(-ω^(5/12)/4) ω^1.5 + (4 H_G/(C S_y)) (1 - exp(-ω^(5/9)/25)) ω, where that is less than Hertz's ω^1.5."""

    def __init__(self, radius, modulus, yield_strength, poisson=0.3, **_):
        self.radius, self.modulus = mpf(radius), mpf(modulus)
        self.c = mpf("1.295") * mpmath.exp(mpf("0.736") * mpf(poisson))
        self.critical = (mp.pi * self.c * mpf(yield_strength) / (2 * self.modulus)) ** 2 * mpf(radius)
        self.hertz = Hertz(radius, modulus)
        self.carried = self.hertz.force(self.critical)
        self.b = mpf("0.14") * mpmath.exp(23 * min(mpf(yield_strength) / self.modulus, mpf("0.1")))
        self.joint = mpmath.findroot(
            lambda w: self.plastic(w) / w ** mpf("1.5") - 1, (mpf("1.9"), mpf("2.0")), tol=mpf(10) ** -40
        )
        self.kinks = (self.joint * self.critical,)

    def plastic(self, w):
        a = mpmath.sqrt(self.critical / self.radius * w * (w / mpf("1.9")) ** self.b)
        hardness = mpf("2.84") * (1 - mpmath.exp(mpf("-0.82") * a ** mpf("-0.7")))
        deep = 1 - mpmath.exp(-(w ** (mpf(5) / 9)) / 25)
        return mpmath.exp(-(w ** (mpf(5) / 12)) / 4) * w ** mpf("1.5") + 4 * hardness / self.c * deep * w

    def force(self, overlap):
        w = mpf(overlap) / self.critical
        return self.carried * (self.plastic(w) if w > self.joint else w ** mpf("1.5"))

    def contact_radius(self, overlap):
        ratio = mpf(overlap) / self.critical
        return mpmath.sqrt(self.radius * mpf(overlap) * max(mpf(1), ratio / mpf("1.9")) ** self.b)


REFERENCES = {
    "hertz": Hertz,
    "rms": Rms,
    "pohrt-popov": PohrtPopov,
    "goddard": Goddard,
    "rough-plastic": RoughPlastic,
    "bahrami": Bahrami,
    "walton-braun": WaltonBraun,
    "thornton-ning": ThorntonNing,
    "conical-damage": ConicalDamage,
    "luding": Luding,
    "eepa": Eepa,
    "kogut-etsion": KogutEtsion,
    "jackson-green": JacksonGreen,
}


def errors(values, exact):
    """Relative errors in units of ε, against mpmath numbers."""
    return np.array([float(abs(mpf(float(v)) / e - 1)) / EPS for v, e in zip(np.ravel(values), exact, strict=True)])
