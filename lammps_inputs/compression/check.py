"""The packing's stiffness in every engine and on 1 and 2 ranks, against the scatter of chance."""

import json
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent))
import common

QUANTITIES = ("low", "loading", "unloading")
LEAST = 0.02
"""Three shaken runs do not show all of chance: a grain that slips in one of some twenty runs changes a slope by so much."""


def check(folder):
    found = json.loads((Path(folder) / "outcomes.json").read_text())
    print(f"{'':18}{'height mm':>12}" + "".join(f"{q + ' MPa':>15}" for q in QUANTITIES) + f"{'mean force N':>14}")
    for label, o in found.items():
        stiffness = "".join(f"{o[q] / 1e6:15.2f}" for q in QUANTITIES)
        print(f"{label:18}{o['height'] * 1e3:12.6f}{stiffness}{o['mean force']:14.3f}")
    first = found.pop("LAMMPS, 1 rank")
    shaken = [found.pop(label) for label in list(found) if "shaken" in label]
    findings = []
    for quantity in QUANTITIES:
        values = np.array([first[quantity], *(o[quantity] for o in shaken)])
        chance = np.ptp(values) / values.mean()
        for label, o in found.items():
            difference = abs(o[quantity] / values.mean() - 1)
            what = f"{label}: stiffness, {quantity}, from LAMMPS's mean ({100 * chance:.2f} % of it is chance)"
            findings.append((what, difference, max(LEAST, 2 * chance)))
    for label, o in found.items():
        findings.append(
            (f"{label}: centre of gravity at rest, from LAMMPS's [µm]", abs(o["height"] - first["height"]) * 1e6, 0.1)
        )
    return findings


if __name__ == "__main__":
    common.check_main(__file__, check)
