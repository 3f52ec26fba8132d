"""The extremes inside LIGGGHTS and LAMMPS: inputs that both take, but for the head and the lines of the contacts."""

import math
import tempfile
from pathlib import Path

import numpy as np

from demlaws import lammps, liggghts
from demlaws.errors import EngineStopped
from demlaws.lammps.run import HEAD as LAMMPS_HEAD
from demlaws.laws import HERTZ
from demlaws.laws.registry import registry
from demlaws.liggghts.run import HEAD as LIGGGHTS_HEAD
from studies.extremes.stability import GRANITE, POISSON, Balance, Case

START = """\
{head}boundary {boundary}
newton off
processors 1 1 1
region box block {ends} units box
create_box {types} box
neighbor {skin:.17g} bin
neigh_modify delay 0 one 20000 page 200000
{contacts}
timestep {dt:.17g}
{spheres}
"""
TWO_SPHERES = """\
group second id {numbers}
variable x atomfile places.txt
dump force second custom 1 force.dump id fx
dump_modify force sort id format {line}"%d %.17g"
run 0
label again
set group second x v_x
run 1 pre no post no
next x
jump in.extremes again
"""
LET_GO = """\
fix move all nve/sphere
compute ke all ke
compute energy all demlaws/energy
compute pairs all contact/atom
compute contacts all reduce sum c_pairs
variable stored equal c_energy[1]
variable lost equal c_energy[2]
variable px equal mass(all)*vcm(all,x)
variable py equal mass(all)*vcm(all,y)
variable pz equal mass(all)*vcm(all,z)
thermo_style custom step c_ke v_stored v_lost v_px v_py v_pz c_contacts
thermo_modify norm no lost error format float %.17e
thermo 1
"""
STOP = """\
fix move all nve/sphere
thermo_modify lost error norm no
thermo 10
run 2 post no
variable wrong atom {value}
set atom 3 {where} v_wrong
run 250 pre no post no
"""
WRONG = {"inf": "exp(1000)", "nan": "-(exp(1000)-exp(1000))"}  # inf - inf is -nan


def liggghts_contacts(moduli, roughness):
    """Materials and pair style of types with these effective moduli; roughness: of each, None for a table that has it."""
    n = len(moduli)
    each = {"youngsModulus": [2.0 * e * (1.0 - POISSON**2) for e in moduli], "poissonsRatio": [POISSON] * n}
    each |= {} if roughness is None else {"surfaceRoughness": roughness}
    lines = [
        f"fix p{k} all property/global {name} peratomtype {' '.join(map(repr, values))}"
        for k, (name, values) in enumerate(each.items())
    ]
    for k, (name, value) in enumerate((("coefficientRestitution", "1"), ("coefficientFriction", "0"))):
        lines.append(f"fix q{k} all property/global {name} peratomtypepair {n} {' '.join([value] * n * n)}")
    words = "table law.tbl" + ("" if roughness is None else " surfaceRoughness on")
    return [*lines, f"pair_style gran model demlaws/table tangential history {words}", "pair_coeff * *"]


def lammps_contacts(moduli, roughness):
    """The same in LAMMPS."""
    lines = ["pair_style granular"]
    for k, modulus in enumerate(moduli):
        words = f"demlaws/table law.tbl {2.0 * modulus * (1.0 - POISSON**2):.17g} 1 {POISSON:.17g}"
        words += "" if roughness is None else f" roughness {math.sqrt(2.0) * roughness[k]:.17g}"
        lines.append(f"pair_coeff {k + 1} {k + 1} {words} tangential mindlin NULL 0 0 damping demlaws/tangent")
    return lines


class Plugin:
    """LIGGGHTS or LAMMPS with the plugin."""

    evaluation = "table"

    def __init__(self, name):
        self.name = name
        if name == "LIGGGHTS":
            self._run, self._contacts = liggghts.run, liggghts_contacts
            self._head, self._line = LIGGGHTS_HEAD + "soft_particles yes\n", ""
        else:
            self._run, self._contacts, self._head, self._line = lammps.run, lammps_contacts, LAMMPS_HEAD, "line "
        self._scratch = tempfile.TemporaryDirectory(prefix="demlaws-extremes-")
        self._folder = Path(self._scratch.name)

    def _start(self, case, table, spheres, *, box, skin, dt, boundary="f f f"):
        """The beginning of an input: one type for each modulus and roughness; box: the lowest and the highest corner.

        spheres: modulus, roughness, position, radius and mass of each.
        """
        (modulus, roughness, position, radius, mass), (low, high) = spheres, box
        path = self._folder / "law.tbl"
        path.unlink(missing_ok=True)  # of another law
        table.save(path)
        kinds, types = np.unique(np.stack([modulus, roughness], axis=1), axis=0, return_inverse=True)
        definition, (moduli, roughnesses) = registry()[case.law], kinds.T.tolist()
        rough = definition.collapses and definition.length == "roughness"
        density = mass / (4.0 / 3.0 * math.pi * radius**3)
        atoms = [
            f"create_atoms {kind + 1} single {' '.join(map(repr, place))} units box"
            for kind, place in zip(np.ravel(types), position.tolist(), strict=True)
        ]
        atoms += [
            f"set atom {number} diameter {2.0 * r:.17g} density {d:.17g}"
            for number, (r, d) in enumerate(zip(radius.tolist(), density.tolist(), strict=True), 1)
        ]
        return START.format(
            head=self._head,
            boundary=boundary,
            ends=" ".join(f"{a:.17g} {b:.17g}" for a, b in zip(low, high, strict=True)),
            types=len(kinds),
            skin=skin,
            contacts="\n".join(self._contacts(moduli, roughnesses if rough else None)),
            dt=dt,
            spheres="\n".join(atoms),
        )

    def _input(self, text):
        """Run an input; its thermo output."""
        (self._folder / "in.extremes").write_text(text)
        return self._run(self._folder / "in.extremes")

    def two_spheres(self, group, wanted):
        """Overlaps [m] as the engine's arithmetic has them and forces [N] on the second spheres, [steps, pairs].

        The second sphere of each pair is at x = 0, the first to its left: numbers 2n + 1 and 2n + 2 for pair n.
        """
        count = group.size
        large, left = np.maximum(group.radius1, group.radius2), -(group.radius1 + group.radius2)
        height = np.cumsum(2.4 * large) - 1.2 * large
        position, radius = np.zeros((2 * count, 3)), np.empty(2 * count)
        position[0::2, 0], position[:, 1] = left, np.repeat(height, 2)
        radius[0::2], radius[1::2] = group.radius1, group.radius2
        widest = float(large.max())
        low = (float(left.min()) - widest, -widest, -widest)
        high = (widest + 1.01 * float(-wanted.min()), float(height[-1]) + 2.0 * widest, widest)
        modulus, roughness = np.repeat(group.modulus, 2), np.repeat(group.roughness, 2)
        skin, mass = 0.02 * float(radius.min()), np.ones(2 * count)
        spheres = modulus, roughness, position, radius, mass
        text = self._start(group.case, group.law, spheres, box=(low, high), skin=skin, dt=1e-12)
        numbers = range(2, 2 * count + 1, 2)
        with open(self._folder / "places.txt", "w") as file:
            for row in wanted.tolist():
                file.writelines([f"{count}\n", *(f"{n} {-x:.17g}\n" for n, x in zip(numbers, row, strict=True)), "\n"])
        self._input(text + TWO_SPHERES.format(numbers=" ".join(map(str, numbers)), line=self._line))
        lines = (self._folder / "force.dump").read_text().splitlines()
        found = [line.split()[1] for n, line in enumerate(lines) if n % (count + 9) >= 9]
        force = np.array(found, float).reshape(-1, count)[1:]  # the first is of the start
        distance = -wanted - left
        return -left - np.sqrt(distance * distance), force

    def let_go(self, packing, stretches, steps, every):
        """`Balance`s of a periodic packing; each stretch starts with velocities of its own."""
        ones = np.ones(packing.radius.size)
        spheres = packing.modulus * ones, packing.roughness * ones, packing.position, packing.radius, packing.mass
        given = {"skin": 0.5 * packing.radius[-1], "dt": packing.dt, "boundary": "p p p"}
        box = (0.0,) * 3, (packing.side,) * 3
        lines = [self._start(packing.case, packing.table, spheres, box=box, **given) + LET_GO]
        length = every * len(range(0, steps - 1, every))
        for stretch in stretches:
            lines += [
                f"set atom {n} vx {x:.17g} vy {y:.17g} vz {z:.17g}\n" for n, (x, y, z) in enumerate(stretch.tolist(), start=1)
            ]
            lines.append(f"run {length + 1} post no\n")
        log = self._input("".join(lines))
        momentum = np.stack([log["px"], log["py"], log["pz"]], axis=1)
        found = []
        for n in range(len(stretches)):
            first = n * (1 + length) + 1  # histories begin with a step
            found.append(
                [
                    Balance(log["ke"][k], log["stored"][k], log["lost"][k], momentum[k], int(log["contacts"][k]) // 2)
                    for k in range(first, first + length + 1, every)
                ]
            )
        return found

    def stopped_by(self, touching, where, value):
        """The engine's error after a fault (see `extremes.stops`), or None."""
        radius = np.full(4, 2.0 * GRANITE.radius)
        spacing = (1.9999 if touching else 3.0) * radius[0]
        position = np.zeros((4, 3))
        position[:, 0] = spacing * np.arange(4)
        case, far = Case(HERTZ, "elastic", "table"), 5.0 * spacing
        spheres = np.full(4, GRANITE.modulus), np.full(4, 1e-6), position, radius, np.full(4, 0.01)
        text = self._start(case, case.bind(GRANITE, 0.9), spheres, box=((-far,) * 3, (far,) * 3), skin=1e-3, dt=1e-7)
        component = {"position": "x", "velocity": "vx"}[where]
        try:
            self._input(text + STOP.format(value=WRONG[value], where=component))
        except EngineStopped as error:
            return str(error)
        return None
