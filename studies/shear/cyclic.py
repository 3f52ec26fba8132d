"""Cyclic oedometer of rough granite spheres in LIGGGHTS: settlement under each model of shear.

The scene is that of `studies.trade.packings` with 150 grains, cycled between 50 and 500 kPa.
"""

import tempfile
from pathlib import Path

import numpy as np

from demlaws.liggghts.export import table_words
from demlaws.liggghts.run import HEAD, run
from demlaws.plugins.grains import Case
from studies.trade.liggghts_oedometer import CASE, data_of, grains, numbers, pairwise, plate
from studies.trade.packings import QUICK, packing

WORDS = {"1 level": "levels 1", "2 levels": "levels 2", "3 levels": "levels 3", "slip": "shear slip", "own": ""}
WORDS |= {f"ratio {ratio:g}": f"shear_ratio {ratio:g}" for ratio in (0.3, 0.086)}
"""Model of shear → words of the table's line; "own": the engine's, "ratio": three levels with another K_t/K than that of ν."""
LOW = 0.1
"""Of the full stress, to which each cycle unloads."""
CYCLES = """\
fix             drive all move/mesh mesh plate linear 0. 0. -{speed:.10g}
variable        speed equal -{speed:.10g}
variable        cycle loop {cycles}
label           cycling
label           pressing
run             {every}
if              "${{stress}} >= {full:.10g}" then "jump SELF pressed"
jump            SELF pressing
label           pressed
unfix           drive
fix             drive all move/mesh mesh plate linear 0. 0. {speed:.10g}
variable        speed equal {speed:.10g}
label           easing
run             {every}
if              "${{stress}} <= {least:.10g}" then "jump SELF eased"
jump            SELF easing
label           eased
unfix           drive
fix             drive all move/mesh mesh plate linear 0. 0. -{speed:.10g}
variable        speed equal -{speed:.10g}
next            cycle
jump            SELF cycling
"""


def settlement(model, cycles, shaken=0, scale=0.25):
    """(height of the plate [m] at the full stress in each cycle, thickness of the packing [m]).

    model: one of WORDS; "own" has the same normal law; scale: of the plate's speed; shaken: seed of random
    displacements of the grains by 1e-4 of their radii (0: none): scatter by chance.
    """
    radii, centres = packing(QUICK)
    if shaken:
        centres = centres + 1e-4 * radii[:, None] * np.random.default_rng(shaken).uniform(-1.0, 1.0, centres.shape)
    given = QUICK.given(radii, centres)
    case = Case("pohrt-popov", tuple(grains(given)), "hertz")
    words = WORDS[model]
    tangential = "history" if model == "own" else "demlaws"
    friction = given["friction"]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "post").mkdir()
        (folder / "start.data").write_text(data_of(centres, radii, given["width"], given["density"]))
        (folder / "plate.stl").write_text(plate(given["width"]))
        tables, _ = table_words(case, folder)
        values = {
            **numbers(given),
            "model": "demlaws/table",
            "words": f"{tables} {words}",
            "more": "",
            "young": " ".join([f"{given['young']:.10g}"] * 3),
            "poisson": " ".join([f"{given['poisson']:.10g}"] * 3),
            "restitution": pairwise([1.0] * 5),
            "friction": pairwise([friction, friction, friction, 0.0, 0.0]),
            "width": given["width"],
            "hold": 0,
            "speed": scale * given["speed"],
            "least": LOW * given["stress"],
            "cycles": cycles,
        }
        begin = CASE[: CASE.index("fix             drive")].replace("tangential history", f"tangential {tangential}")
        path = folder / "in.cyclic"
        path.write_text((HEAD + begin + CYCLES).format(**values))
        log = run(path)
    place = log["touching"] + np.append(0.0, np.cumsum(log["speed"][1:] * np.diff(log["Step"]))) * given["dt"]
    last = np.flatnonzero((log["speed"][:-1] < 0.0) & (log["speed"][1:] > 0.0))
    before = np.flatnonzero(np.diff(log["Step"]) > 0)
    before = before[np.searchsorted(before, last, "left") - 1]  # the reading below the full stress
    share = (given["stress"] - log["stress"][before]) / (log["stress"][last] - log["stress"][before])
    return place[before] + share * (place[last] - place[before]), float(log["touching"][0])
