"""Oedometer test of granite spheres for Hertz, Pohrt–Popov and rough-plastic contacts; 2 minutes.

python run.py [--figure stress.png]
"""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent))
import common

import demlaws as dl
from demlaws.liggghts import run

RADIUS = 4e-3
SPEED = 0.05
DT = 5e-7


def laws():
    """Name → law of a contact; the granite of RFC10: its yield pressure, its roughness."""
    rough = {"roughness": 1.7e-6, "fractal_dimension": 2.22}
    return {
        "hertz": lambda contact: dl.law("hertz", contact),
        "pohrt-popov": lambda contact: dl.law("pohrt-popov", contact, unloading="hertz"),
        "rough-plastic": lambda contact: dl.law(
            "rough-plastic", contact, unloading="thornton", yield_pressure=1.66e9, loading="pohrt-popov"
        ),
    }, rough


def simulate(folder, ranks=1, quick=False):
    variables = {"count": 120 if quick else 400, "close": 120000 if quick else 280000}
    log = run(folder / "in.prepare", 1, variables, log="log.prepare", plugin=False)
    rows = np.loadtxt(folder / "post" / "prepared.dump", skiprows=9)
    top = float(log["height"][-1])
    lines = ["prepared", "", f"{len(rows)} atoms", "2 atom types", ""]
    lines += ["-0.03 0.03 xlo xhi", "-0.03 0.03 ylo yhi", f"-0.01 {top + 0.01} zlo zhi", "", "Atoms", ""]
    lines += [f"{int(r[0])} 1 {2 * r[2]:.17g} 2650 {r[3]:.17g} {r[4]:.17g} {r[5]:.17g}" for r in rows]
    (folder / "prepared.data").write_text("\n".join(lines) + "\n")
    makers, rough = laws()
    down = 8000 if quick else 32000
    variables = {"top": top, "speed": SPEED, "down": down, "up": down * 6 // 5}
    for name, make in makers.items():
        pair, wall = make(common.contact(RADIUS, RADIUS, **rough)), make(common.contact(RADIUS, **rough))
        common.table(folder, f"{name}.pair.tbl", pair)
        common.table(folder, f"{name}.wall.tbl", wall)
        tables = f"table {name}.pair.tbl pairtable 1 2 {name}.wall.tbl pairtable 2 2 {name}.wall.tbl".split()
        run(
            folder / "in.compression",
            ranks,
            {"model": "demlaws/table", "tables": " ".join(tables), **variables},
            log=f"log.{name}",
        )
    stock = {"model": "hertz", "tables": "tangential_damping on", **variables}
    run(folder / "in.compression", ranks, stock, log="log.stock", plugin=False)


if __name__ == "__main__":
    common.run_main(__file__, simulate, __doc__)
