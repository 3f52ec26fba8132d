"""The extremes inside LIGGGHTS: how its library is driven, with the plugin loaded, in a process of its own.

`python -m studies.extremes --liggghts` runs this file. What stops LIGGGHTS ends its process, so `stops` starts one for
each fault.
"""

import ctypes
import math
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from demlaws.errors import DemlawsError
from demlaws.laws.names import HERTZ
from demlaws.laws.registry import registry
from demlaws.liggghts.build import build, linked_library, mpi_libraries
from demlaws.liggghts.run import versions
from studies.extremes.extremes import POISSON, Balance, answer
from studies.extremes.stability import GRANITE, Case
from studies.under_yade import serve

_HEAD = """\
atom_style granular
atom_modify map array
boundary {boundary}
newton off
communicate single vel yes
units si
hard_particles yes
soft_particles yes
processors 1 1 1
region box block {ends} units box
create_box {types} box
neighbor {skin:.17g} bin
neigh_modify delay 0 one 20000 page 200000
{contacts}
timestep {dt:.17g}
"""


class _Library:
    """LIGGGHTS through the C interface of its library."""

    def __init__(self, screen=False):
        versions()
        self._words = [b"liggghts", b"-log", b"none", *([] if screen else [b"-screen", b"none"])]
        path = linked_library()
        for name in (*mpi_libraries(path), path):
            self._library = library = ctypes.CDLL(name, mode=ctypes.RTLD_GLOBAL)
        ctypes.CDLL(str(build()), mode=ctypes.RTLD_GLOBAL)
        for name in ("lammps_extract_atom", "lammps_extract_compute"):
            getattr(library, name).restype = ctypes.c_void_p
        self._instance = ctypes.c_void_p()

    def start(self, text):
        """A new instance that has taken these commands."""
        if self._instance:
            self._library.lammps_close(self._instance)
            self._instance = ctypes.c_void_p()
        arguments = (ctypes.c_char_p * len(self._words))(*self._words)
        self._library.lammps_open_no_mpi(len(self._words), arguments, ctypes.byref(self._instance))
        for line in text.splitlines():
            self.command(line)

    def command(self, line):
        self._library.lammps_command(self._instance, line.encode())

    def _pointer(self, name):
        found = self._library.lammps_extract_atom(self._instance, name.encode())
        if not found:
            raise DemlawsError(f"the engine's library does not give {name!r}")
        return found

    def vectors(self, name, count):
        """The [count, 3] array of LIGGGHTS's own memory; rows as `rows` orders them."""
        first = ctypes.cast(self._pointer(name), ctypes.POINTER(ctypes.POINTER(ctypes.c_double)))[0]
        return np.ctypeslib.as_array(first, (count, 3))

    def rows(self, count):
        """Row of each particle, in the order in which they were made."""
        numbers = np.ctypeslib.as_array(ctypes.cast(self._pointer("id"), ctypes.POINTER(ctypes.c_int)), (count,))
        rows = np.argsort(numbers, kind="stable")
        if not np.array_equal(numbers[rows], np.arange(1, count + 1)):
            raise DemlawsError("the engine has lost a particle")
        return rows

    def compute(self, name, size, per_atom=False):
        found = self._library.lammps_extract_compute(self._instance, name.encode(), int(per_atom), 1)
        return np.ctypeslib.as_array(ctypes.cast(found, ctypes.POINTER(ctypes.c_double)), (size,)).copy()


class Liggghts:
    """LIGGGHTS, its library in this process."""

    name = "LIGGGHTS"
    evaluation = "table"
    start = _HEAD

    def __init__(self, screen=False, library=None):
        self._lib = library or _Library(screen)
        self._folder = tempfile.TemporaryDirectory(prefix="demlaws-extremes-")

    def _start(self, case, table, modulus, roughness, low, high, skin, dt, boundary="f f f"):
        """An instance with one particle type for each modulus and roughness; returns the types of the entries."""
        path = Path(self._folder.name) / "law.tbl"
        table.save(path)
        kinds, types = np.unique(np.stack([modulus, roughness], axis=1), axis=0, return_inverse=True)
        definition = registry()[case.law]
        ends = " ".join(f"{a:.17g} {b:.17g}" for a, b in zip(low, high, strict=True))
        values = {"boundary": boundary, "ends": ends, "types": len(kinds), "skin": float(skin), "dt": float(dt)}
        values["contacts"] = self._contacts(path, kinds, definition.collapses and definition.length == "roughness")
        self._lib.start(self.start.format(**values))
        return np.ravel(types) + 1

    def _contacts(self, path, kinds, rough):
        """Lines of the materials and the pair style, of types with these moduli and roughnesses; path: of the table."""
        n = len(kinds)
        each = {
            "youngsModulus": [2.0 * e * (1.0 - POISSON**2) for e, _ in kinds.tolist()],
            "poissonsRatio": [POISSON] * n,
            **({"surfaceRoughness": kinds[:, 1].tolist()} if rough else {}),
        }
        lines = [
            f"fix p{k} all property/global {name} peratomtype {' '.join(map(repr, values))}"
            for k, (name, values) in enumerate(each.items())
        ]
        for k, (name, value) in enumerate((("coefficientRestitution", "1"), ("coefficientFriction", "0"))):
            lines.append(f"fix q{k} all property/global {name} peratomtypepair {n} {' '.join([value] * n * n)}")
        words = f"table {path}" + (" surfaceRoughness on" if rough else "")
        return "\n".join([*lines, f"pair_style gran model demlaws/table tangential history {words}", "pair_coeff * *"])

    def _fill(self, types, position, radius, mass):
        """Make the particles; afterwards their order is that of `rows`."""
        lib = self._lib
        for kind, place in zip(types, position.tolist(), strict=True):
            lib.command(f"create_atoms {kind} single {' '.join(map(repr, place))} units box")
        volume = 4.0 / 3.0 * math.pi * radius**3
        for number, (r, density) in enumerate(zip(radius.tolist(), (mass / volume).tolist(), strict=True), 1):
            lib.command(f"set atom {number} diameter {2.0 * r:.17g} density {density:.17g}")

    def _pairs(self, group, far):
        """Pairs, the second sphere of each at x = 0, the first to its left. Numbers: 2n + 1 and 2n + 2 for pair n."""
        count = group.size
        large = np.maximum(group.radius1, group.radius2)
        height = np.cumsum(2.4 * large) - 1.2 * large
        left = -(group.radius1 + group.radius2)
        position, radius = np.zeros((2 * count, 3)), np.empty(2 * count)
        position[0::2, 0], position[:, 1] = left, np.repeat(height, 2)
        radius[0::2], radius[1::2] = group.radius1, group.radius2
        widest = float(large.max())
        low = (float(left.min()) - widest, -widest, -widest)
        high = (widest + far, float(height[-1]) + 2.0 * widest, widest)
        types = self._start(group.case, group.law, group.modulus, group.roughness, low, high, 0.02 * float(radius.min()), 1e-12)
        self._fill(np.repeat(types, 2), position, radius, np.ones(2 * count))
        return left

    def two_spheres(self, group, wanted):
        """Overlaps [m] as LIGGGHTS's arithmetic has them and forces [N] on the second spheres, [steps, pairs]."""
        lib, count = self._lib, 2 * group.size
        left = self._pairs(group, 1.01 * float(-wanted.min()))
        lib.command("run 0")
        force = np.empty_like(wanted)
        for n, row in enumerate(wanted):
            lib.vectors("x", count)[lib.rows(count)[1::2], 0] = -row
            lib.command("run 1 pre no post no")
            force[n] = lib.vectors("f", count)[lib.rows(count)[1::2], 0]
        distance = -wanted - left
        return -left - np.sqrt(distance * distance), force

    def let_go(self, packing, stretches, steps, every):
        """`Balance`s of a periodic packing; each stretch starts with velocities of its own."""
        lib, count = self._lib, packing.radius.size
        ones = np.ones(count)
        types = self._start(
            packing.case,
            packing.table,
            packing.modulus * ones,
            packing.roughness * ones,
            (0.0,) * 3,
            (packing.side,) * 3,
            0.5 * packing.radius[-1],
            packing.dt,
            "p p p",
        )
        self._fill(types, packing.position, packing.radius, packing.mass)
        for line in ("fix move all nve/sphere", "compute energy all demlaws/energy", "compute pairs all contact/atom"):
            lib.command(line)
        lib.vectors("x", count)[lib.rows(count)] = packing.position
        lib.command("run 0 post no")
        found, mass = [], packing.mass[:, None]

        def balance():
            velocity = lib.vectors("v", count)[lib.rows(count)]
            stored, dissipated = lib.compute("energy", 2).tolist()
            kinetic = 0.5 * float(np.sum(mass * velocity**2))
            contacts = int(lib.compute("pairs", count, per_atom=True).sum()) // 2
            return Balance(kinetic, stored, dissipated, np.sum(mass * velocity, axis=0), contacts)

        for stretch in stretches:
            lib.vectors("v", count)[lib.rows(count)] = stretch
            lib.command("run 1 pre no post no")  # histories begin with a step
            rows = [balance()]
            for _ in range(0, steps - 1, every):
                lib.command(f"run {every} pre no post no")
                rows.append(balance())
            found.append(rows)
        return found

    def stopped_by(self, *fault):
        """The engine's error after a fault (see `extremes.stops`), or None."""
        return stopped_by(*fault, self.name)

    def stop(self, touching, where, value):
        """Four spheres, one of which gets a number that is none; ends the process where the engine stops."""
        lib, case = self._lib, Case(HERTZ, "elastic", "table")
        radius = np.full(4, 2.0 * GRANITE.radius)
        spacing = (1.9999 if touching == "touching" else 3.0) * radius[0]
        position = np.zeros((4, 3))
        position[:, 0] = spacing * np.arange(4)
        far = 5.0 * spacing
        types = self._start(
            case, case.bind(GRANITE, 0.9), np.full(4, GRANITE.modulus), np.full(4, 1e-6), (-far,) * 3, (far,) * 3, 1e-3, 1e-7
        )
        self._fill(types, position, radius, np.full(4, 0.01))
        for line in ("fix move all nve/sphere", "thermo_modify lost error norm no", "thermo 10", "run 2 post no"):
            lib.command(line)
        lib.vectors({"position": "x", "velocity": "v"}[where], 4)[lib.rows(4)[2], 0] = float(value)
        lib.command("run 250 pre no post no")


def stopped_by(touching, where, value, engine="LIGGGHTS"):
    """The engine's error after a position or velocity was set to `value`, "nan" or "inf", in a process of its own; or None."""
    line = [
        sys.executable,
        "-m",
        f"studies.extremes.{engine.lower()}_extremes",
        "--stop",
        "touching" if touching else "alone",
        where,
        value,
    ]
    done = subprocess.run(line, capture_output=True, text=True, errors="replace")
    told = [x for x in (done.stdout + done.stderr).splitlines() if x.startswith("ERROR")]
    return told[0] if told else None if done.returncode == 0 else f"exit {done.returncode}"


def main(arguments, engine=Liggghts):
    """`--stop TOUCHING WHERE VALUE`, or the files of `under_yade.serve`."""
    if arguments[0] == "--stop":
        engine(screen=True).stop(*arguments[1:])
        return
    serve(lambda request: answer(engine(), request))


if __name__ == "__main__":
    main(sys.argv[1:])
