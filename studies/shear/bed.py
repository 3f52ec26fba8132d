"""What partial slip changes in 25 cycles of load on a bed of granite spheres: the small bed of lammps_inputs/ballast."""

import importlib.util
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

import numpy as np

from demlaws.lammps import run

CASE = Path(__file__).parents[2] / "lammps_inputs" / "ballast"


class Bed(NamedTuple):
    """Since the first cycle began."""

    settlement: np.ndarray  # of the plate at the end of each cycle [m]
    loss: np.ndarray  # area of each cycle's loop of load over the plate's way [J]
    taken: np.ndarray  # by plastic flow and shear at the end of each cycle [J]


def _case():
    sys.path.insert(0, str(CASE.parent))  # where its module `common` is
    try:
        spec = importlib.util.spec_from_file_location("ballast_of_lammps", CASE / "run.py")
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return module
    finally:
        sys.path.remove(str(CASE.parent))


def load_in_cycles(shear, count=25):
    """`Bed` with "elastic" or "slip"."""
    case = _case()
    shared = case.SHARED
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        case.common.table(folder, "granite.tbl", shared.law())
        variables, grains = shared.variables(True)
        case.PACKING.write_loose(folder / "loose.data", grains, variables["half"], (0.015, 0.020, 0.025), (0.4, 0.4, 0.2))
        text = (CASE / "in.ballast").read_text().replace(" tangential", f" shear {shear} tangential")
        (folder / "in.ballast").write_text(text)
        variables = {**variables, "wide": 0.85 * variables["half"], "cycles": count * shared.PERIOD}
        log = run(folder / "in.ballast", 1, variables)
    step = log["Step"] - shared.SETTLE - shared.PRESS
    ends = np.flatnonzero((step >= 0) & (step % shared.PERIOD == 0))
    down, carried = -log["plate"], log["carried"]
    work = np.append(0.0, np.cumsum(0.5 * (carried[1:] + carried[:-1]) * np.diff(down)))
    return Bed(down[ends[1:]] - down[ends[0]], np.diff(work[ends]), log["lost"][ends[1:]] - log["lost"][ends[0]])
