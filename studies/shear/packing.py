"""What the shear model changes in the packing of `studies.softening` in YADE: 25 oedometer cycles, shear to the peak."""

import json
from typing import NamedTuple

import numpy as np

from studies.costs.costs import under_yade
from studies.softening import study

PROCESSES = study.Run("yade", "cycles", cycles=25), study.Run("yade", "shear", stress=1e5, inertial=1e-3)


class Changed(NamedTuple):
    """One copy of a packing with one shear model."""

    settlement: float  # of the plate from the first peak of the stress to the 25th [m]
    losses: np.ndarray  # area of each cycle's loop of stress over the plate's way [J/m²]
    peak: float  # largest axial over lateral stress
    dilation: float  # of the volume, at 15 % strain


def measure(shear, copies=3):
    """`Changed` for each copy, shaken by chance, with "native", "elastic" or "slip"."""
    runs = [run._replace(copy=copy) for run in PROCESSES for copy in range(copies)]
    found = {}

    def ended(text):
        message = json.loads(text)
        found[runs[message["number"]]] = message["found"]

    given = [{**run.given(), "shear": shear} for run in runs]
    under_yade("softening/yade_softening.py", {**study.scene(1.0), "runs": given}, ended)
    for pressed, sheared in zip(runs[:copies], runs[copies:], strict=True):
        branches = [study.work(branch) for branch in found[pressed]["branches"]]
        row = study.summary(sheared, found[sheared])
        settlement = study.summary(pressed, found[pressed])["settlement"]
        yield Changed(settlement, np.add(branches[::2], branches[1::2]), row["peak"], row["dilation"])
