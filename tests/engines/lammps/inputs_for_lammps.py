"""Inputs that the tests share."""

import functools

import inputs
from inputs import moves_of, scene, watched

from demlaws.lammps.run import HEAD

simulate = functools.partial(inputs.simulate, "lammps")
started = functools.partial(inputs.started, "lammps")
refused = functools.partial(inputs.refused, "lammps")

SHEAR = "tangential demlaws 1.0 0.5 damping demlaws/tangent"
TABLE = f"demlaws/table law.tbl 60.6e9 1.0 0.25 {SHEAR}"
STOCK = "hertz/material 60.6e9 1.0 0.25 tangential mindlin NULL 1.0 0.5 damping viscoelastic"


def two_spheres(coefficients, moves, newton="on", **options):
    """See `inputs.scene`; coefficients: pair_coeff lines, or the words of one for all types."""
    if not coefficients.startswith(("pair_", "suffix")):
        coefficients = f"pair_coeff * * {coefficients}"
    head = f"{HEAD}boundary        f f f\nnewton          {newton}"
    return scene(head, f"pair_style      granular\n{coefficients}", moves, 5e-8, **options)


def continued(moves, file="now.restart", again="", **watch):
    """The input that goes on from a restart file of `two_spheres`; again: lines after read_restart."""
    lines = f"read_restart    {file}\nneighbor        1e-4 bin\nneigh_modify    delay 0\n{again}\ntimestep        5e-8\n"
    return "comm_modify     vel yes\n" + lines + watched(**watch) + moves_of(moves)
