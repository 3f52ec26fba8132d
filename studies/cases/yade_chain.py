"""The chains of `studies.cases.chain` in YADE; started by it under YADE."""

import importlib.util

from studies.cases import ROOT
from studies.under_yade import serve


def waves(given):
    """Time [s] and velocities [m/s] of two beads of each chain, by the script of yade_scripts."""
    spec = importlib.util.spec_from_file_location("chain", ROOT / "yade_scripts" / "chain.py")
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    return [
        script.strike(law, force, overlap, speed, dt, steps).tolist()
        for law, force, overlap, _, speed, dt, steps in given["chains"]
    ]


if __name__ == "__main__":
    serve(waves)
