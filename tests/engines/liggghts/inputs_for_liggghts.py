"""Inputs that the tests share."""

import functools

import inputs
from inputs import scene

from demlaws.liggghts.run import HEAD

simulate = functools.partial(inputs.simulate, "liggghts")
refused = functools.partial(inputs.refused, "liggghts")

PROPERTIES = """\
neigh_modify    page 400000
{material}
fix             m5 all property/global coefficientRollingFriction peratomtypepair 2 0.1 0.1 0.1 0.1
fix             m6 all property/global coefficientRollingViscousDamping peratomtypepair 2 0.1 0.1 0.1 0.1
fix             m7 all property/global surfaceRoughness peratomtype 1e-6 2e-6
{pair_style}
pair_coeff      * *"""


def properties(types=1, young=60.6e9, restitution=1.0, friction=0.5, poisson=0.25):
    """Lines of the material properties, the same for all types."""
    names = "youngsModulus", "poissonsRatio", "coefficientRestitution", "coefficientFriction"
    values = [f"peratomtype{f' {value!r}' * types}" for value in (young, poisson)]
    values += [f"peratomtypepair {types}{f' {value!r}' * types**2}" for value in (restitution, friction)]
    lines = zip(names, values, strict=True)
    return "\n".join(f"fix m{n} all property/global {name} {value}" for n, (name, value) in enumerate(lines, 1))


def two_spheres(pair_style, moves, restitution=1.0, step=1e-8, young=60.6e9, ranks=None, **options):
    """See `inputs.scene`."""
    style = PROPERTIES.format(material=properties(2, young, restitution), pair_style=pair_style)
    return scene(HEAD + (f"processors {ranks} 1 1" if ranks else ""), style, moves, step, **options)


def again(text, restart="now.restart", change=()):
    """The input that reads the restart file in place of making particles; changes: (old, new) of its text."""
    left_out = ("create_", "set ", "region ", "velocity ", "write_restart")
    lines = [line for line in text.splitlines() if not line.startswith(left_out)]
    lines.insert(next(i for i, line in enumerate(lines) if line.startswith("neighbor")), f"read_restart {restart}")
    out = "\n".join(lines) + "\n"
    for old, new in change:
        assert old in out
        out = out.replace(old, new)
    return out
