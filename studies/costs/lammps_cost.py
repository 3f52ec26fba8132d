"""What laws cost in a LAMMPS step: the close packing of `liggghts_cost`, every way in turn, round after round."""

import numpy as np

from demlaws.lammps.run import HEAD, run, timings
from studies.costs import liggghts_cost
from studies.trade.lammps_oedometer import model_lines
from studies.trade.liggghts_oedometer import _data

CASE = """\
boundary        f f f
newton          {newton}
read_data       start.data
neighbor        {skin:.10g} bin
neigh_modify    delay 0
pair_style      granular
{pairs}
timestep        1e-9
fix             gravity all gravity 9.81 vector 0 0 -1
fix             move all nve/sphere
fix             still all setforce 0.0 0.0 0.0
thermo_style    custom step atoms ke
thermo_modify   norm no
thermo          100000
run             20
run             {steps}
"""


def write(folder, given, way, centres, width, steps, newton="on"):
    """Input and tables of one way; whether it needs the plugin."""
    radius = given["radius"]
    said = model_lines(folder, {"friction": 0.5, **given}, way)
    text = HEAD + CASE.format(newton=newton, pairs="\n".join(said.pairs), steps=steps, skin=0.1 * radius)
    (folder / "start.data").write_text(_data(centres, np.full(len(centres), radius), width, given["density"], types=2))
    (folder / "in.cost").write_text(text)
    return way["model"] != "hertz"


def measure(*arguments, **options):
    """As that of `liggghts_cost`."""
    return liggghts_cost.measure(*arguments, **options, write=write, run=run, timings=timings)
