"""LAMMPS's own tests of granular contacts (unittest/granular/tests), with a table of a law in place of the stock normal model.

`lammps_tests.json` has the numbers of each test: the words of its contact, its grains (diameter, density, position, velocity,
angular velocity), and the state of the first grain at the end, as LAMMPS of 4 Jul 2026 keeps it. A test runs in the same parts
as there: a damped contact depends on them, because each `run` starts with forces computed from the velocities of the full step,
while all later steps use those of the half step. One run in place of several changes the results by up to 1.5e-7.

Differences are of round-off, up to 3e-12 of the speed of the test. Component by component they look larger: the vertical
velocity of dem07-incline-rolling is 1.1e-7 m/s at the end; 2.5e-7 of it is 7e-14 of the speed that gravity gives meanwhile.

Not among them: dem08 (adhesion, which no law here has), dem09 (drag of a gas, without contacts), the pair styles
`gran/hooke` and `gran/hertz`, whose normal models cannot be replaced, and further angles or frictions of the same inputs.
"""

import json
import math
import tempfile
from pathlib import Path

import numpy as np

from demlaws.contact import Contact
from demlaws.lammps.run import HEAD, run
from demlaws.laws import HERTZ, WALTON_BRAUN
from studies.validation.published import bound
from studies.validation.row import between

TOLERANCE = 1e-11
"""Largest difference of position over R, and of velocity and ω R over the speed of the test."""
TESTS = json.loads(Path(__file__).with_suffix(".json").read_text())
INPUT = """\
boundary        {sides}
region          box block {region} units box
create_box      1 box
neighbor        0.001 bin
neigh_modify    delay 0
timestep        {dt}
pair_style      granular
pair_coeff      * * {contact}
{grains}
{more}
fix             move all nve/sphere
group           first id 1
compute         spin all property/atom omegax omegay omegaz
compute         sum first reduce sum x y z vx vy vz c_spin[1] c_spin[2] c_spin[3]
{columns}
thermo_style    custom step {names}
thermo_modify   format float %.17e norm no
"""


def restitution_of(damping):
    """The restitution e' of `damping coeff_restitution` for a damping force of `damping` √(m F/δ) v."""
    share = damping / math.sqrt(5.0)
    return math.exp(-math.pi * share / math.sqrt(1.0 - share**2))


def table_words(test, folder):
    """The words in place of the normal model's and its damping; writes the table.

    LAMMPS computes `coeff_restitution` for a linear contact if the model's name is hooke, and its factor of `tsuji` has changed
    since 22 Jul 2025: both become the restitution with which `coeff_restitution` of another model gives the same damping.
    """
    name, first, damping, *rest = test["normal"].split()
    radii = [0.5 * grain[0] for grain in test["grains"]]
    radius = radii[0] if test["wall"] else 1.0 / sum(1.0 / r for r in radii)
    poisson, word = rest[0] if rest else "0", test["damping"]
    if name == "hooke":
        modulus, options = 1e10, {"loading_stiffness": float(first), "stiffness_ratio": 1.0}
    else:
        modulus = 0.5 * float(first) / (1.0 - float(poisson) ** 2) if rest else 0.75 * float(first)
        options = {}
    if name == "hooke" and word == "coeff_restitution":
        loss = -math.log(float(damping))
        damping = restitution_of(2.0 * loss / math.hypot(math.pi, loss))
    elif word == "tsuji":
        factors = (4.8218, -18.022, 27.467, -22.348, 11.087, -4.2783, 1.2728)
        word, damping = "coeff_restitution", restitution_of(math.sqrt(2.0) * np.polyval(factors, float(damping)))
    law = bound(WALTON_BRAUN if options else HERTZ, Contact(radius, modulus), **options)
    law.tabulate(1e-9).save(folder / "law.tbl")
    young = 2.0 * modulus * (1.0 - float(poisson) ** 2)
    return f"demlaws/table law.tbl {young:.17g} {damping} {poisson} damping {word}"


def final_state(test):
    """Position, velocity and angular velocity of the first grain at the end, with our table."""
    lines, more = [], []
    for number, (diameter, density, *vectors) in enumerate(test["grains"], start=1):
        place, velocity, spin = (" ".join(f"{v:.17g}" for v in vector) for vector in vectors)
        lines += [f"create_atoms 1 single {place} units box", f"set atom {number} diameter {diameter} density {density}"]
        lines += [f"group g{number} id {number}", f"velocity g{number} set {velocity}", f"set atom {number} omega {spin}"]
    if test["gravity"]:
        more.append(f"fix weight all gravity 1 vector {test['gravity']}")
    columns = {f"q{n}": f"variable q{n} equal c_sum[{n}]" for n in range(1, 10)}
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        contact = f"{table_words(test, folder)} {test['rest']}"
        if test["wall"]:
            more.append(f"fix wall all wall/gran granular {contact} {test['wall']}")
        text = HEAD + INPUT.format(
            sides=test["box"][0],
            region=test["box"][1],
            dt=test["dt"],
            contact=contact,
            grains="\n".join(lines),
            more="\n".join(more),
            columns="\n".join(columns.values()),
            names=" ".join(f"v_{name}" for name in columns),
        )
        text += "".join(f"thermo {steps}\nrun {steps}\n" for steps in test["runs"])
        (folder / "in.test").write_text(text)
        log = run(folder / "in.test")
        return np.array([float(log[name][-1]) for name in columns]).reshape(3, 3)


def difference(test, state, other):
    """Largest difference of two states: of position over R, of velocity and ω R over the speed of the test."""
    diameter, _, _, velocity, spin = test["grains"][0]
    fall = test["dt"] * sum(test["runs"]) if test["gravity"] else 0.0
    speed = max(np.linalg.norm(velocity), 0.5 * diameter * np.linalg.norm(spin), fall)
    return float(max(np.linalg.norm(state - other, axis=1) / (0.5 * diameter, speed, 2.0 * speed / diameter)))


def rows():
    """One row per test."""
    for test in TESTS:
        what = f"{test['name']}: largest difference of position, velocity and spin"
        yield between(
            what, 0.0, TOLERANCE, difference(test, final_state(test), np.array(test["kept"])), "lammps-tests", where="LAMMPS"
        )
