"""Which part of a rough contact deforms plastically, the asperities or the bulk (Jamari & Schipper 2006, 2008).

The criterion itself stands in `criterion`; here are its answer for one contact (`assess`), a map of it, what each law
says to it (`advise`), and the papers' own tests.
"""

import math
from typing import NamedTuple

import numpy as np

from demlaws.checks import number
from demlaws.contact import Contact, Material
from demlaws.criterion import (
    BAND,
    YIELD_RATIO,
    checked_loads,
    deforming_part,
    hardness_of,
    hertz_pressure,
    lowest_transition_load,
    pressure_drop,
    pressure_ratio,
    transition_load,
    transition_roughness,
)
from demlaws.errors import DemlawsError
from demlaws.laws.definition import Conditions
from demlaws.laws.registry import registry

__all__ = [
    "BAND",
    "YIELD_RATIO",
    "Advice",
    "PublishedTest",
    "Regime",
    "advise",
    "assess",
    "deforming_part",
    "hertz_pressure",
    "lowest_transition_load",
    "pressure_drop",
    "pressure_map",
    "pressure_ratio",
    "published_tests",
    "transition_load",
    "transition_roughness",
]


class Regime(NamedTuple):
    """The criterion at one load. Pressures in Pa, loads in N, roughness in m."""

    load: float
    roughness_parameter: float  # α
    hertz_pressure: float  # p0
    central_pressure: float  # p(0)
    ratio: float  # p(0)/H_m
    deforms: str  # "asperities", "both" or "bulk"
    transition_load: float  # load at which p(0)/H_m = 0.6
    transition_roughness: float  # roughness at which it is, at this load; 0 where even a smooth bulk stays elastic

    def __str__(self):
        part = {
            "asperities": "asperities deform, the bulk stays elastic",
            "both": "asperities and bulk deform together",
            "bulk": "the bulk yields",
        }[self.deforms]
        change = f"{self.transition_load:.4g} N" if math.isfinite(self.transition_load) else "no load"
        roughness = (
            f"σ = {self.transition_roughness * 1e6:.3g} µm at this load"
            if self.transition_roughness > 0
            else "at this load the bulk of a smooth contact is elastic too"
        )
        return (
            f"P = {self.load:g} N: α = {self.roughness_parameter:.3g}, p0 = {self.hertz_pressure / 1e9:.4g} GPa, "
            f"p(0)/H_m = {self.ratio:.3f}: {part}\n"
            f"the answer changes (p(0)/H_m = {YIELD_RATIO}) at {change}; {roughness}"
        )


def assess(contact, load):
    """The `Regime` of one contact under `load` [N].

    Raises DemlawsError without a hardness, or for a load that is not positive.
    """
    if contact.size is not None:
        raise DemlawsError("assess takes one contact; this one is an array: use pressure_ratio and transition_load")
    load = number(load, "load", "N")
    p0 = float(hertz_pressure(contact, load))
    ratio = pressure_ratio(contact, load)
    return Regime(
        load=load,
        roughness_parameter=float(contact.roughness_parameter(load)),
        hertz_pressure=p0,
        central_pressure=ratio * contact.hardness,
        ratio=ratio,
        deforms=deforming_part(ratio),
        transition_load=transition_load(contact),
        transition_roughness=transition_roughness(contact, load),
    )


def pressure_map(contact, loads, roughnesses):
    """p(0)/H_m over `loads` [N] (columns) and `roughnesses` [m] (rows); `contact` gives the rest."""
    loads, roughnesses = checked_loads(loads), np.asarray(roughnesses, float)
    alpha = roughnesses[:, None] * contact.with_values(roughness=1e-9).roughness_parameter(loads)[None, :] / 1e-9
    return hertz_pressure(contact, loads)[None, :] * pressure_drop(alpha) / hardness_of(contact)


class Advice(NamedTuple):
    """Whether a law's physics fits a contact up to a load, and why."""

    law: str
    fits: bool
    reason: str


def advise(contact, load):
    """For each law, whether its physics fits this contact from first touch up to `load` [N], with the reason.

    The laws differ in what deforms: elastic asperities on an elastic bulk (rms, pohrt-popov, greenwood-tripp), plastic
    asperities on an elastic bulk (bahrami, yip-venart, asperity), a yielding bulk (rough-plastic), or no roughness
    (hertz); each says itself what it fits (`Definition.advise`). Without a hardness the bulk cannot be judged, which the
    reason then says.
    """
    load = number(load, "load", "N")
    alpha = float(np.max(contact.roughness_parameter(load)))
    if contact.hardness is None:
        yields, state = False, "no hardness given: bulk yield not judged"
    else:
        ratio = float(np.max(pressure_ratio(contact, load)))
        yields, state = ratio > YIELD_RATIO, f"p(0)/H_m = {ratio:.2f}"
    conditions = Conditions(contact, alpha, float(pressure_drop(alpha)), yields, state)
    advice = {name: definition.advise(conditions) for name, definition in registry().items()}
    return [Advice(name, bool(fits), reason) for name, (fits, reason) in advice.items()]


class PublishedTest(NamedTuple):
    """One indentation of Jamari & Schipper 2006 (their Figs. 5-7, 9-11) or 2008."""

    label: str
    material: str
    contact: Contact
    load: float  # N
    alpha: float  # as printed, NaN where not
    ratio: float  # p(0)/H_m: 2006 as drawn in Fig. 12, 2008 as printed (Cm)
    seen: str  # "asperities", "both", "bulk"


ALUMINIUM = Material(young=75.2e9, poisson=0.34, hardness=0.24e9)
BRASS = Material(young=105e9, poisson=0.34, hardness=1.2e9)
STEEL_BALL = Material(young=210e9, poisson=0.3, hardness=7.5e9)
SILICON_CARBIDE_BALL = Material(young=430e9, poisson=0.17, hardness=28e9)


def published_tests():
    """The published points: six of 2006 (steel ball, R = 5 mm) and two of 2008 (SiC ball, R = 3.175 mm)."""
    rows = [
        ("Al_B", ALUMINIUM, 0.67e-6, 4.0, 0.86, 1.061, "bulk"),
        ("Al_AB", ALUMINIUM, 2.1e-6, 4.0, 2.70, 0.630, "both"),
        ("Al_A", ALUMINIUM, 2.2e-6, 4.0, 2.84, 0.616, "asperities"),
        ("Br_B", BRASS, 0.13e-6, 12.0, 0.09, 0.647, "bulk"),
        ("Br_AB", BRASS, 0.28e-6, 12.0, 0.20, 0.570, "both"),
        ("Br_A", BRASS, 0.70e-6, 12.0, 0.50, 0.438, "asperities"),
        ("2008 isotropic", ALUMINIUM, 1.3e-6, 0.2, math.nan, 0.16, "asperities"),
        ("2008 anisotropic", ALUMINIUM, 1.4e-6, 0.2, math.nan, 0.15, "asperities"),
    ]
    tests = []
    for label, flat, roughness, load, alpha, ratio, seen in rows:
        ball, radius = (SILICON_CARBIDE_BALL, 3.175e-3) if label.startswith("2008") else (STEEL_BALL, 5e-3)
        contact = Contact.between(ball, flat, radius1=radius, roughness2=roughness)
        name = "aluminium" if flat is ALUMINIUM else "brass"
        tests.append(PublishedTest(label, name, contact, load, alpha, ratio, seen))
    return tests
