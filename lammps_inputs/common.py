"""What the cases share: all of liggghts_inputs/common.py, with LAMMPS's log.

Every case folder has an input (in.*), a run.py that makes its tables, runs it and checks it, and a check.py that reads
the output: `python run.py [--quick] [-np N] [--out FOLDER]`, `python check.py FOLDER`.
"""

import importlib.util
from pathlib import Path

SHARED = Path(__file__).parents[1] / "liggghts_inputs" / "common.py"


def _shared():
    spec = importlib.util.spec_from_file_location("liggghts_inputs_common", SHARED)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


_module = _shared()
globals().update({name: value for name, value in vars(_module).items() if not name.startswith("_")})
