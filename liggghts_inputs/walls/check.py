"""Force and energies of either wall against the Python law, and the force of one wall against the other."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))
import common

from demlaws.liggghts import read_log


def check(folder, unloading="hertz", limit=1e-5):
    law = common.load(Path(__file__).parent / "run.py").law(unloading)
    logs = {wall: read_log(Path(folder) / f"log.{wall}") for wall in ("primitive", "mesh")}
    findings = [found for wall, log in logs.items() for found in common.against_law(log, law, limit, f"{wall} wall: ")]
    force, other = (log["force"] for log in logs.values())
    return [*findings, ("mesh against primitive, of the maximum", abs(force - other).max() / force.max(), 1e-9)]


if __name__ == "__main__":
    common.check_main(__file__, check)
