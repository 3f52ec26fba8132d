"""Speed of a small wave in a chain of granite beads under a force F, in YADE, LIGGGHTS and LAMMPS.

Long waves travel at c = D √(K/m), with the distance D of the centres and the tangent stiffness K at F (Coste, Falcon & Fauve
1997, Phys. Rev. E 56, 6104), so that K ∝ F^q gives c ∝ F^(q/2): 1/6 for Hertz, 0.2567 Df/2 for Pohrt & Popov.

Arrival: the velocity of bead n of a struck linear chain is 2ν J_ν(x)/x with ν = 2n + 1, x = 2 √(K/m) t. At x = ν, where a wave
of speed c arrives, it is 0.66 of its first maximum, for any large ν [our derivation from the asymptotic forms of J_ν].
"""

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np

import demlaws as dl
from demlaws.laws import HERTZ, POHRT_POPOV
from studies import engines
from studies.cases import ENGINES, prepared, run_input

DIAMETER, DENSITY, BEADS = 17.4e-3, 2650.0, 80
NEAR, FAR = 20, 60  # beads behind the struck one
MASS = DENSITY * math.pi / 6 * DIAMETER**3
ARRIVED = 0.663
"""Share of the first maximum at which a bead is reached: 0.4473/0.6749, J_ν(ν) over the first maximum for large ν."""
FORCES = (0.805, 2.5, 8.05)
"""Forces [N], below the threshold of Pohrt & Popov."""
SURFACE = dl.Surface(roughness=1.7e-6, fractal_dimension=2.22, hardness=6.266e9)
GRANITE = dl.Material(young=60.6e9, poisson=0.25, hardness=6.266e9)


class Chain(NamedTuple):
    """A chain of one law at one force, and the settings of its run."""

    law: str
    force: float  # [N]
    overlap: float  # of neighbours at that force [m]
    expected: float  # c [m/s]
    speed: float  # of the struck bead [m/s]
    dt: float  # [s]
    steps: int


def chain(name, force):
    """`Chain` of a law at a force [N]."""
    radii = {"radius1": DIAMETER / 2, "radius2": DIAMETER / 2}
    sq = {"roughness1": SURFACE.roughness, "roughness2": SURFACE.roughness} if name != HERTZ else {}
    contact = dl.Contact.between(GRANITE, GRANITE, **radii, **sq, fractal_dimension=SURFACE.fractal_dimension)
    law = dl.law(name, contact)  # asperities stay elastic: with rule hertz a small wave is Hertz's
    overlap = float(law.overlap(force))
    stiffness = float(law.stiffness(overlap))
    frequency = math.sqrt(stiffness / MASS)
    speed = 1e-3 * force / math.sqrt(stiffness * MASS)
    steps = int(1.15 * (FAR + 5) / frequency / (0.04 / frequency))
    return Chain(name, force, overlap, (DIAMETER - overlap) * frequency, speed, 0.04 / frequency, steps)


def wave_speed(one, time, near, far):
    """Speed [m/s] from the velocities of both beads over time [s]."""
    return (FAR - NEAR) * (DIAMETER - one.overlap) / (arrival(time, far) - arrival(time, near))


def arrival(time, velocity):
    """Time at which a velocity first has ARRIVED of its first maximum."""
    rising = np.flatnonzero(velocity > 0.5 * velocity.max())
    top = rising[0] + int(np.argmax(np.diff(velocity[rising[0] :]) < 0.0))
    after = int(np.argmax(velocity[: top + 1] >= ARRIVED * velocity[top]))
    return float(np.interp(ARRIVED * velocity[top], velocity[after - 1 : after + 1], time[after - 1 : after + 1]))


def in_plugin(engine, one, folder):
    """Speed [m/s] in the case `chain` of an engine."""
    folder = Path(folder) / f"{engine}-{one.law}-{one.force:g}"
    script = prepared(engine, "chain", folder) / "in.chain"
    values = {name: repr(getattr(one, name)) for name in ("force", "overlap", "speed", "dt", "steps")}
    values |= {"table": "hertz" if one.law == HERTZ else "granite", "bead_near": NEAR + 1, "bead_far": FAR + 1}
    log = run_input(engine, script, variables=values)
    return wave_speed(one, one.dt * (log["Step"] - log["Step"][0]), log["near"], log["far"])


def in_yade(chains):
    """Speeds [m/s] in YADE."""
    found = engines.under_yade("cases/yade_chain.py", {"chains": [list(one) for one in chains]})
    return [wave_speed(one, *np.array(columns)) for one, columns in zip(chains, found, strict=True)]


def measured(engine, folder, forces=FORCES):
    """(`Chain`, speed [m/s] in an engine) of both laws at each force."""
    chains = [chain(name, force) for name in (HERTZ, POHRT_POPOV) for force in forces]
    speeds = in_yade(chains) if engine == "yade" else [in_plugin(engine, one, folder) for one in chains]
    return list(zip(chains, speeds, strict=True))


def compare(folder, forces=FORCES):
    """Rows (law, force [N], D √(K/m) [m/s], engine → speed [m/s])."""
    rows = {}
    for engine in ("yade", *ENGINES):
        for one, speed in [] if engines.available(engine) else measured(engine, folder, forces):
            rows.setdefault((one.law, one.force, one.expected), {})[engine.upper()] = speed
    return [(*key, speeds) for key, speeds in rows.items()]


def exponents(rows):
    """{(law, engine): exponent of the speed over the force}."""
    found = {}
    for law in dict.fromkeys(row[0] for row in rows):
        mine = [row for row in rows if row[0] == law]
        force = np.log([row[1] for row in mine])
        for engine in mine[0][3]:
            found[law, engine] = float(np.polyfit(force, np.log([row[3][engine] for row in mine]), 1)[0])
    return found


def table(rows):
    """The lines of the table."""
    names = list(rows[0][3])
    yield (
        f"{'law':14}{'force (N)':>10}{'D √(K/m) (m/s)':>16}" + "".join(f"{name:>12}" for name in names) + "  (over the formula)"
    )
    for law, force, expected, found in rows:
        yield f"{law:14}{force:10g}{expected:16.2f}" + "".join(f"{found[name] / expected:12.4f}" for name in names)
    yield "exponent of the speed over the force: " + ", ".join(f"{k[0]} {k[1]} {v:.4f}" for k, v in exponents(rows).items())
