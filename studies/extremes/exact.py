"""First loading of the laws in closed form, in extended precision: written from the equations, not the kernels."""

import numpy as np

from demlaws.laws.registry import find

L = np.longdouble
PI = L("3.14159265358979323846264338327950288")


def extended(value):
    """A number, an array or a decimal text in extended precision."""
    return L(value) if isinstance(value, str) else np.asarray(value, L)


def from_hertz(contact, equivalent, slope):
    """Force P = (4/3) E* √R s^1.5 [N] and stiffness [N/m] of a Hertz-equivalent overlap s [m] with ds/dδ = `slope`."""
    root = 4 * extended(contact.modulus) * np.sqrt(extended(contact.radius)) / 3 * np.sqrt(equivalent)
    return root * equivalent, 3 * root * slope / 2


def _hertz(contact, overlap):
    return from_hertz(contact, extended(overlap), 1)


def _rms(contact, overlap):
    sigma = extended(contact.sigma)
    u = extended(overlap) / sigma
    s = np.where(u < 2, u / 4, np.maximum(u - extended("1.4"), u / 2))
    for _ in range(80):  # Newton in log s: u(s) rises from 5.76 s to s + 1.4
        ratio = (extended("2.4") + 2 * s) / (1 + 2 * s)
        value = np.log(s) + 2 * np.log(ratio) - np.log(u)
        slope = 1 + 2 * s * (2 / (extended("2.4") + 2 * s) - 2 / (1 + 2 * s))
        s = s * np.exp(-value / slope)
    ratio = (extended("2.4") + 2 * s) / (1 + 2 * s)
    return from_hertz(contact, s * sigma, 1 / (ratio * (ratio + 4 * s * (1 - ratio) / (1 + 2 * s))))


def _pohrt_popov(contact, overlap):
    dimension, sigma, delta = extended(contact.fractal_dimension), extended(contact.sigma), extended(overlap)
    m = extended("0.2567") * dimension
    r = 2 / (3 * (1 - m))
    h = extended(3) / 4 * np.sqrt(PI) * (20 / (np.sqrt(PI) ** 3 * dimension)) ** (1 / m) * sigma
    t = delta / (r * h)
    return from_hertz(contact, np.where(t < 1, h * t**r, delta - (r - 1) * h), np.where(t < 1, t ** (r - 1), 1))


def _goddard(contact, overlap, slope):
    delta = extended(overlap)
    d = 3 * PI**2 / 16 * np.tan(extended(slope)) ** 2 * extended(contact.radius)
    t = delta / d
    return from_hertz(contact, np.where(t < 1, extended(3) / 4 * delta * np.cbrt(t), delta - d / 4), np.minimum(np.cbrt(t), 1))


def _rough_plastic(contact, overlap, **options):
    law = find("rough-plastic")
    definition, rest = law.before_yield(**options)
    rough, shape = EXACT[definition.name], law.shape(contact, **options)
    delta = extended(overlap)
    stiffness = PI * extended(contact.radius) * extended(shape.yield_pressure)
    pressure = extended(shape.load_pressure)
    load = PI**3 / 6 * pressure * (extended(contact.radius) * pressure / extended(contact.modulus)) ** 2
    middle = np.log(extended(contact.radius))
    low, high = middle - 70, middle + 7
    for _ in range(45):  # to 2e-12 of δ_y: where K = K_y the force changes with the square of that
        middle = (low + high) / 2
        force, tangent = rough(contact, np.exp(middle), **rest)
        before = force < load if shape.load_pressure > 0.0 else tangent < stiffness
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    yields = np.exp(low)
    force, tangent = rough(contact, np.minimum(delta, yields), **rest)
    return force + stiffness * np.maximum(delta - yields, 0), np.where(delta > yields, stiffness, tangent)


def _conical_damage(contact, overlap, strength, angle):
    delta, radius, modulus = (extended(v) for v in (overlap, contact.radius, contact.modulus))
    sine = np.sin(extended(angle))
    blunting, h = (1 - sine) / sine, (PI * extended(strength) / (2 * modulus)) ** 2
    now = np.maximum((delta + radius * blunting) / (h + blunting), radius)
    elastic = delta - (now - radius) * blunting
    force = 4 * modulus / 3 * np.sqrt(now) * elastic * np.sqrt(elastic)
    slope = 1 / (h + blunting)
    crushed = 8 * modulus / 3 * h * np.sqrt(h) * now * slope
    return force, np.where(now > radius, crushed, 2 * modulus * np.sqrt(now * elastic))


def _walton_braun(contact, overlap, loading_stiffness, stiffness_ratio=None, growth=None):
    k1, delta = extended(loading_stiffness), extended(overlap)
    return k1 * delta, k1 + 0 * delta


def _thornton_ning(contact, overlap, yield_pressure):
    delta, radius, modulus = (extended(v) for v in (overlap, contact.radius, contact.modulus))
    pressure = extended(yield_pressure)
    yields = (PI * pressure / (2 * modulus)) ** 2 * radius
    stiffness = PI * radius * pressure
    force, tangent = from_hertz(contact, np.minimum(delta, yields), 1)
    return force + stiffness * np.maximum(delta - yields, 0), np.where(delta > yields, stiffness, tangent)


def _luding(contact, overlap, loading_stiffness, stiffness_ratio, plasticity_depth):
    k1, ratio, delta = extended(loading_stiffness), extended(stiffness_ratio), extended(overlap)
    limit = ratio / (ratio - 1) * extended(plasticity_depth) * 2 * extended(contact.radius)
    more = np.maximum(delta - limit, 0)
    return k1 * (delta - more) + ratio * k1 * more, np.where(more > 0, ratio * k1, k1)


def _eepa(contact, overlap, stiffness_ratio, softness=1.0):
    force, stiffness = from_hertz(contact, extended(overlap), 1)
    return extended(softness) * force, extended(softness) * stiffness


def _kogut_etsion(contact, overlap, yield_strength, poisson=0.3):
    delta = extended(overlap)
    pressure = (extended("0.454") + extended("0.41") * extended(poisson)) * extended("2.8") * extended(yield_strength)
    critical = (PI * pressure / (2 * extended(contact.modulus))) ** 2 * extended(contact.radius)
    w = delta / critical
    carried = from_hertz(contact, critical, 1)[0]
    powers = [(extended(factor), extended(power)) for factor, power in (("1", "1.5"), ("1.03", "1.425"), ("1.40", "1.263"))]
    branches = np.array([factor * w**power for factor, power in powers])
    least = np.argmin(branches, axis=0)
    force = carried * np.take_along_axis(branches, least[None], 0)[0]
    return force, force * np.array([power for _, power in powers])[least] / delta


def _jackson_green(contact, overlap, yield_strength, poisson=0.3):
    delta, radius, modulus, strength = (extended(v) for v in (overlap, contact.radius, contact.modulus, yield_strength))
    c = extended("1.295") * np.exp(extended("0.736") * extended(poisson))
    critical = (PI * c * strength / (2 * modulus)) ** 2 * radius
    w = delta / critical
    b = extended("0.14") * np.exp(23 * np.minimum(strength / modulus, extended("0.1")))
    spread = np.sqrt(critical * w / radius * (w / extended("1.9")) ** b) ** extended("-0.7")
    hardness = extended("2.84") * (1 - np.exp(extended("-0.82") * spread))
    bulk, deep = w ** (extended(5) / 12), w ** (extended(5) / 9)
    left = np.exp(-deep / 25)
    plastic = np.exp(-bulk / 4) * w**1.5 + 4 * hardness / c * (1 - left) * w
    slope = np.exp(-bulk / 4) * np.sqrt(w) * (extended("1.5") - 5 * bulk / 48)
    slope += 4 * hardness / c * (1 - left + left * deep / 45)
    slope -= (
        4 * extended("2.84") / c * (1 - left) * np.exp(extended("-0.82") * spread) * spread * extended("0.574") * (1 + b) / 2
    )
    carried = from_hertz(contact, critical, 1)[0]
    force, tangent = from_hertz(contact, delta, 1)
    yields = (plastic < w**1.5) & (w > extended("0.01"))
    return np.where(yields, carried * plastic, force), np.where(yields, carried / critical * slope, tangent)


EXACT = {
    "hertz": _hertz,
    "rms": _rms,
    "pohrt-popov": _pohrt_popov,
    "goddard": _goddard,
    "rough-plastic": _rough_plastic,
    "conical-damage": _conical_damage,
    "walton-braun": _walton_braun,
    "thornton-ning": _thornton_ning,
    "luding": _luding,
    "eepa": _eepa,
    "kogut-etsion": _kogut_etsion,
    "jackson-green": _jackson_green,
}
"""Law → function of contact, overlap [m] and options: force [N] and stiffness [N/m]."""
