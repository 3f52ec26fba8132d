"""Oedometer test of granite spheres in LAMMPS on 1 and 2 ranks and in LIGGGHTS, from one packing; 1 minute.

python run.py

1,000 grains (150 with --quick) of 7 and 9 mm, at rest in a box, are pressed by a plate to 0.5 MPa and eased by a fifth:
the scene of `python -m studies.trade --scene`, rough-plastic contacts, Thornton unloading. Runs from positions shaken by
1e-9 of the radius, three of them, say how much of the result is chance. An engine that is not installed is left out.
"""

import json
import shutil
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent))
import common

from studies.trade import lammps_oedometer, liggghts_oedometer, packings
from studies.trade.candidates import RICHEST

WAY = RICHEST._replace(rtol=1e-5)


def simulate(folder, ranks=2, quick=False):
    setup = packings.QUICK if quick else packings.Setup()
    radii, centres = packings.packing(setup)
    given = setup.given(radii, centres)
    way = {**WAY._asdict(), "options": dict(WAY.options)}
    runs = [("LAMMPS, 1 rank", lammps_oedometer, {"ranks": 1}, 0), ("LAMMPS, 2 ranks", lammps_oedometer, {"ranks": 2}, 0)]
    runs += [(f"LAMMPS, shaken {n}", lammps_oedometer, {}, n) for n in (1, 2, 3)]
    if shutil.which("liggghts"):
        runs += [("LIGGGHTS", liggghts_oedometer, {}, 0)]
    found = {}
    for number, (label, engine, options, shaken) in enumerate(runs):
        shift = packings.SHAKEN * np.random.default_rng(shaken).uniform(-1.0, 1.0, centres.shape) * radii.min() * (shaken > 0)
        places = {**given, "centres": (centres + shift).tolist()}
        outcome = packings.outcome(WAY, setup, engine.oedometer(folder / str(number), places, way, **options))
        found[label] = {name: getattr(outcome, name) for name in ("height", "low", "loading", "unloading", "stress", "steps")}
        found[label]["mean force"] = float(outcome.forces.mean())
    (folder / "outcomes.json").write_text(json.dumps(found, indent=1))


if __name__ == "__main__":
    common.run_main(__file__, simulate, __doc__)
