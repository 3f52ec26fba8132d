"""Forces of the restarted run against those of the run that went on, and against the Python law."""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent))
import common

from demlaws.liggghts import read_log


def check(folder, unloading="hertz", limit=1e-5):
    first, second = (read_log(Path(folder) / f"log.{name}") for name in ("first", "second"))
    expected = common.load(Path(__file__).parent / "run.py").law(unloading).follow(first["overlap"]).force
    scale = expected.max()
    same = np.isin(first["Step"], second["Step"])
    return [
        ("rows missing in the restarted run", float(second["Step"].size - same.sum()), 0),
        ("restarted against continued, of the maximum", np.abs(first["force"][same] - second["force"]).max() / scale, 1e-12),
        ("force against the law, of the maximum", np.abs(first["force"] - expected).max() / scale, limit),
    ]


if __name__ == "__main__":
    common.check_main(__file__, check)
