"""Force, history and energies of in.two_spheres against the Python law."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))
import common

from demlaws.liggghts import read_log


def check(folder, unloading="hertz", limit=1e-5):
    law = common.load(Path(__file__).parent / "run.py").law(unloading)
    history = () if unloading == "elastic" else ("maximum", "plastic")
    return common.against_law(read_log(Path(folder) / "log.liggghts"), law, limit, history=history)


if __name__ == "__main__":
    common.check_main(__file__, check)
