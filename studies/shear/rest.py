"""600 granite spheres that fell into a box, in LIGGGHTS: kinetic energy and wall forces with each model of shear."""

import tempfile
from pathlib import Path

import numpy as np

import demlaws as dl
from demlaws.errors import DemlawsError
from demlaws.liggghts.run import run
from demlaws.plugins.grains import Grain
from studies.shear.cyclic import WORDS
from studies.trade.candidates import GRANITE, SURFACE

INPUT = Path(__file__).parents[2] / "liggghts_inputs" / "packing" / "in.packing"
RADIUS = 2e-3
DROP = 1e-3
"""[m] Kinetic energies are over that of the packing's fall by this height."""


SEEDS = (49979687, 67867967, 86028121, 104395301, 122949823, 141650939)
"""Of the places in which the grains begin to fall; the first is that of the input."""


def settle(model, seed=0, steps=200_000):
    """Rows [time [s], kinetic energy over weight × DROP, |force on the walls over the weight − 1|] after the fall began.

    seed: which of SEEDS.
    """
    if seed not in range(len(SEEDS)):
        raise DemlawsError(f"packing at rest: seed {seed}: the seeds are 0 to {len(SEEDS) - 1}")
    grain = Grain(RADIUS, GRANITE, SURFACE)
    words = ("tangential history", "") if model == "own" else ("tangential demlaws", f" {WORDS[model]}")
    text = (
        INPUT.read_text()
        .replace("tangential demlaws", words[0])
        .replace(str(SEEDS[0]), str(SEEDS[seed]))
        .replace("table granite.tbl", f"table granite.tbl{words[1]}", 1)
    )
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "in.packing"
        (path.parent / "post").mkdir()
        path.write_text(text)
        dl.law("pohrt-popov", grain.contact(grain), unloading="hertz").tabulate().save(path.parent / "granite.tbl")
        log = run(path, 1, {"half": 0.015, "height": 0.14, "count": 600, "settle": steps})
    return np.stack([4e-6 * log["Step"], log["KinEng"] / (DROP * log["weight"]), np.abs(log["held"] / log["weight"] - 1.0)], 1)
