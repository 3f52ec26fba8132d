"""Beds deposited with each shear model, and loaded with the same and with another one; rows in `beds.csv`.

Beds that come to rest with different shear models differ. Is the state at rest the reason, or the model under load? The beds of
LOADED are loaded from their places, without shear forces, with both models, the others with their own.
"""

import itertools
from pathlib import Path

import numpy as np

from demlaws.files import csv_text
from demlaws.lammps import run
from studies.assembly.study import append, read
from studies.ballast import bed

RESULTS = Path(__file__).parent / "beds.csv"
LAW, SIGMA, FRICTION = "pohrt-popov", 10.0, 0.6
PRESSURE = 30e3  # [Pa]
DT = 1e-5  # [s]
FIELDS = (
    *("deposited", "loaded", "seed", "count", "solid", "contacts", "steps"),
    *("rest_um", "sunk_mm", "solid_loaded", "contacts_loaded"),
)
LOADED = ("default", "mindlin")


def solid(grains, low=0.03, high=0.14):
    """Share of the volume between two heights [m] in spheres."""
    radius, z = 0.5 * grains[:, 1], grains[:, 5]

    def below(height):  # volume of each sphere below a height
        cap = np.clip(height - z + radius, 0.0, 2.0 * radius)
        return np.pi * cap**2 * (radius - cap / 3.0)

    return float(np.sum(below(high) - below(low)) / (bed.WIDTH**2 * (high - low)))


def simulate(folder, shear, grains, more):
    """Run an input with a shear model; its log and the grains at its end."""
    law = bed.Law(LAW, SIGMA, shear)
    (folder / "post").mkdir(parents=True, exist_ok=True)
    law.save(folder / "pair.tbl")
    bed.write_data(folder / "start.data", grains)
    text = bed.ground(law, bed.from_data(False), DT, FRICTION, settled=False) + more
    (folder / "in.bed").write_text(text + bed.WRITE.format(mol="", name="bed.txt"))
    log = run(folder / "in.bed")
    return log, bed.read_dump(folder / "post" / "bed.txt")


def rows(shear, seed, count, store):
    """A row (dict) for each model with which the bed of a model is loaded."""
    folder = Path(store) / f"beds-{shear.replace(' ', '-')}-{seed}-{count}"
    log, grains = simulate(folder, shear, bed.loose(count, seed), bed.rest(400_000, slow=1e-7))
    about = {"deposited": shear, "seed": seed, "count": count, "solid": solid(grains)}
    about |= {"contacts": log["contacts"][-1] / count, "steps": log["Step"][-1]}
    for other in dict.fromkeys((shear, *(LOADED if shear in LOADED else ()))):
        _, lower = simulate(folder, other, grains, bed.rest(10_000, drag=20.0, slow=1e-9))
        top = float((lower[:, 5] + 0.5 * lower[:, 1]).max())
        log, pressed = simulate(
            folder, other, lower, bed.load(0.0, PRESSURE, 1.0, 50_000, DT, top, width=bed.WIDTH, settled=False)
        )
        begun = np.argmax(log["carried"] > 0.02 * log["load"][-1])
        yield about | {
            "loaded": other,
            "rest_um": 1e6 * float(np.mean(grains[:, 5] - lower[:, 5])),
            "sunk_mm": 1e3 * float(log["plate"][begun] - log["plate"][-1]),
            "solid_loaded": solid(pressed),
            "contacts_loaded": log["contacts"][-1] / count,
        }


def run_beds(path=RESULTS, store="results/ballast", shears=tuple(bed.SHEAR), seeds=(1, 2), count=300, progress=print):
    """Run the beds that `path` lacks."""
    done = {(row["deposited"], row["seed"], row["count"]) for row in read(path)}
    for seed, shear in itertools.product(seeds, shears):
        if (shear, seed, count) not in done:
            append(path, FIELDS, list(rows(shear, seed, count, store)))
            progress(f"bed {shear} {seed}")


def table(path=RESULTS):
    """CSV text: state at rest, and what the plate does."""
    titles = [
        "deposited with",
        "loaded with",
        "solid share",
        "contacts",
        "sunk at rest (µm)",
        "plate (mm)",
        "solid share",
        "contacts",
    ]
    lines = []
    found = {}
    for row in read(path):
        found.setdefault((row["deposited"], row["loaded"]), []).append(row)
    for (deposited, loaded), some in found.items():
        mean = [np.mean([row[name] for row in some]) for name in (FIELDS[4], FIELDS[5], *FIELDS[7:])]
        lines.append([deposited, loaded, *"{:.4f},{:.2f},{:.1f},{:.2f},{:.4f},{:.2f}".format(*mean).split(",")])
    return csv_text(titles, lines)
