"""Granular styles and contact models of LIGGGHTS and LAMMPS: which of them demlaws/table can replace, and why not the others.

The tests compare these lists with those that the engines print and document; a style that is in none of them is not converted.
"""

import re
from typing import NamedTuple

from demlaws.laws import EEPA, LUDING, THORNTON_NING, WALTON_BRAUN


class Normal(NamedTuple):
    """A normal model: the law whose table may replace it, and what that law lacks; any: every law's, "": none."""

    law: str
    lacks: str = ""
    options: str = ""  # of `demlaws table` for that law


_ADHESION = "is adhesive, and no law of demlaws is"
_LINEAR = Normal(WALTON_BRAUN, "", "--option loading_stiffness=K_N --option stiffness_ratio=1")
NORMALS = {
    "liggghts": {
        "hertz": Normal("any"),
        "hertz/stiffness": Normal(
            "",
            "has kn in place of moduli: give youngsModulus, poissonsRatio, coefficientRestitution and coefficientFriction "
            "(kn is 4/3 E*) and write `model hertz` here first",
        ),
        "hooke": _LINEAR,
        "hooke/stiffness": _LINEAR,
        "hooke/hysteresis": Normal(
            LUDING,
            "the adhesive branch (coefficientAdhesionStiffness)",
            "--option loading_stiffness=K_N --option stiffness_ratio=coefficientMaxElasticStiffness "
            "--option plasticity_depth=coefficientPlasticityDepth",
        ),
        "luding": Normal(
            LUDING,
            "the adhesive branch and the pull-off force",
            "--option loading_stiffness=LoadingStiffness --option stiffness_ratio=UnloadingStiffness "
            "--option plasticity_depth=coefficientPlasticityDepth",
        ),
        "edinburgh": Normal(
            EEPA, "adhesion, and overlapExponent other than 1.5", "--option stiffness_ratio=UnloadingStiffness"
        ),
        "edinburgh/stiffness": Normal(
            EEPA,
            "adhesion, and overlapExponent other than 1.5",
            "--option stiffness_ratio=UnloadingStiffness --option softness=LoadingStiffness/(4/3 E* sqrt(R))",
        ),
        "thornton_ning": Normal(
            THORNTON_NING, "adhesion (surfaceEnergy)", "--option yield_pressure=2 E* coefficientYieldRatio r/(pi R)"
        ),
        "jkr": Normal("", f"{_ADHESION}: write `model hertz` here first if the grains may lose their adhesion"),
        "hysteretic/nonlinear1": Normal(EEPA, "exponents other than 1.5", "--option stiffness_ratio=K2/K1"),
    },
    "lammps": {
        "hertz/material": Normal("any"),
        "hertz": Normal(
            "", "has k_n in place of a modulus: write `hertz/material E eta nu` with E = 1.5 (1 - nu²) k_n here first"
        ),
        "hooke": Normal(
            "",
            "is a linear spring: write `hertz/material E eta nu` here first; nearest law walton-braun (`demlaws table --law "
            "walton-braun --option loading_stiffness=K_N --option stiffness_ratio=1`)",
        ),
        "jkr": Normal("", f"{_ADHESION}: write `hertz/material E eta nu` here first if the grains may lose their adhesion"),
        "dmt": Normal("", f"{_ADHESION}: write `hertz/material E eta nu` here first if the grains may lose their adhesion"),
        "mdr": Normal(
            "",
            "is elastic-plastic and adhesive: write `hertz/material E eta nu` here first; nearest law thornton-ning, without "
            "adhesion (`demlaws table --law thornton-ning --option yield_pressure=2.8Y`)",
        ),
        "none": Normal("", "is no force: write `hertz/material E eta nu` here first"),
    },
}
SUB_MODELS = {
    "tangential": ("off", "no_history", "history", "demlaws"),
    "rolling_friction": ("off", "cdt", "epsd", "epsd2"),
    "cohesion": ("off",),
    "surface": ("default",),
}
"""Of LIGGGHTS, those that demlaws/table runs with; every other one is refused."""
STOCK_SETTINGS = (
    "absolute_damping",
    "viscous",
    "ktToKnUser",
    "fixKc",
    "computeElasticPotential",
    "computeDissipatedEnergy",
    "disableNormalWhenBonded",
    "heating_normal_hertz",
    "heating_normal_hooke",
    "heating_tracking",
    "heating_tangential_history",
)
"""Settings (with a value) of LIGGGHTS's models that demlaws/table has no use for."""
SETTINGS = ("tangential_damping", "limitForce", "torsionTorque", "heating_rolling_friction")
"""Those that stay."""

_OLD = "an old style: write `granular` and hertz/material E eta nu first"
_ALIAS = "demlaws/table runs in style gran only: write `gran` first"
_LOCAL = (
    "the plugin cannot be used with it: take fix surface/global, or a LAMMPS with the models built in (`demlaws lammps source`)"
)
GRANULAR = {"liggghts": re.compile(r"gran|bubble", re.I), "lammps": re.compile(r"gran|\bsurf(ace)?/")}
"""How granular styles are called."""
STYLES = {
    "liggghts": {
        "pair_style": {"gran": "", "bubble": _ALIAS, "gran_bubble": _ALIAS},
        "fix": {
            "wall/gran": "",
            "check/timestep/gran": "",
            "heat/gran": "",
            "heat/gran/conduction": "",
            "move/mesh/gran": "",
        },
        "compute": {"contact/atom/gran": "", "coord/gran": "", "pair/gran/local": "", "wall/gran/local": ""},
        "dump": {"local/gran/vtk": "", "mesh/gran/VTK": ""},
    },
    "lammps": {
        "pair_style": {
            "granular": "",
            "gran/hooke": _OLD,
            "gran/hooke/history": _OLD,
            "gran/hertz/history": _OLD,
            "surf/granular": _LOCAL,
            "granular/superellipsoid": "has force laws of its own without sub-models: demlaws cannot be used with it",
        },
        "fix": {"wall/gran": "", "wall/gran/region": "", "surface/global": "", "surface/local": _LOCAL},
        "compute": {},
        "dump": {},
    },
}
"""Command, granular style → why it stays as it is; "": it is converted, or has no contact model."""
OTHER_PAIRS = ("none", "soft", "line/lj", "sph/artVisc/tensCorr", "hybrid", "hybrid/overlay")
"""Pair styles of LIGGGHTS that are not granular."""

_RESPA = "run_style respa", "displacements of shear would be multiplied by its steps: write `run_style verlet`"
_UNITS = r"units (?!si$)", "tables are in metres: write the input in `units si`"
_RENUMBERS = (
    r"reset_(atoms id|atom_ids|ids)\b",
    "contacts would lose their histories: put it before the first run, or leave it out",
)
STOPS = {
    "liggghts": (
        _UNITS,
        _RESPA,
        (r"atom_style (hybrid .*)?(superquadric|convexhull)", "demlaws/table has spheres only"),
        (r"coarsegraining\b", "demlaws/table does not run with coarse grains"),
        (r"fix \S+ \S+ insert/stream/predefined", "it brings histories along: use another fix insert"),
        (r"fix \S+ \S+ multicontact/halfspace", "demlaws/table does not run with multicontact models"),
        (
            r"fix \S+ \S+ heat/gran.* area_correction (?!no\b)",
            "it needs a force that is one power of the overlap: leave it out",
        ),
    ),
    "lammps": (_UNITS, _RESPA, _RENUMBERS),
}
"""Commands that demlaws/table does not run with, and what to write."""
PROPERTIES = ("youngsModulus", "poissonsRatio", "coefficientRestitution")
"""Properties of LIGGGHTS that demlaws/table needs."""
ELSEWHERE = {
    "liggghts": re.compile(r"\bpair_style\b|\bfix\b.*\bwall/gran|\bmodel\s+(hertz|hooke)\b|\bdelete_atoms\b(?!.*compress no)"),
    "lammps": re.compile(
        r"\bpair_(style|coeff)\b|\bfix\b.*\b(wall/gran|surface/)|\bhertz/material\b|\bdelete_atoms\b(?!.*compress no)"
    ),
}
"""Lines in other commands, such as `if`, that would have to be converted."""
