"""The same impact of two granite spheres in Python, in YADE and in LIGGGHTS: peak force and rebound speed; about 15 s.

    python liggghts_inputs/impact/three_way.py

Two spheres of 16 mm meet at 0.2 m/s; nothing but the law damps. An engine that is not installed is left out.
"""

import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))
import common

import demlaws as dl
from demlaws.liggghts import run

DIAMETER, SPEED, STEPS_PER_CONTACT = 16e-3, 0.2, 40000
LAWS = (
    ("pohrt-popov", "elastic", {}),
    ("pohrt-popov", "hertz", {}),
    ("rough-plastic", "thornton", {"yield_pressure": 0.5e9}),  # soft enough to yield at this speed
)

YADE = """\
import json, sys
import yade
from yade.utils import sphere
import demlaws as dl
from demlaws.yade import Law2_ScGeom_MindlinPhys_Demlaws, engines

case = json.loads(sys.argv[-1])
O = yade.O
O.materials.append(yade.FrictMat(young=60.6e9, poisson=0.25, frictionAngle=0.5, density=2650, label="granite"))
for side in (-1, 1):
    O.bodies.append(sphere((side * (case["diameter"] / 2 + 5e-8), 0, 0), case["diameter"] / 2, material="granite"))
    O.bodies[-1].state.vel = (-side * case["speed"] / 2, 0, 0)
surface = dl.Surface(roughness=1.7e-6, fractal_dimension=2.22, hardness=6.266e9)
O.engines = engines(Law2_ScGeom_MindlinPhys_Demlaws(case["law"], case["unloading"], {"granite": surface}, **case["options"]))
O.dt = case["dt"]
left, right = O.bodies[0], O.bodies[1]
peak, parted = 0.0, False

def watch():
    global peak, parted
    force = O.forces.f(1)[0]
    peak, parted = max(peak, force), peak > 0 and force == 0

O.engines = O.engines + [yade.PyRunner(command="watch()", iterPeriod=1, initRun=True)]
while not parted and O.iter < 200000:
    O.run(4000, True)  # a single step at a time would wait for the poll of O.run
print("RESULT", json.dumps([peak, right.state.vel[0] - left.state.vel[0]]))
"""


def in_python(law, mass):
    impact = dl.driver.impact(law, mass, SPEED, STEPS_PER_CONTACT)
    return impact.peak_force, impact.rebound_speed, impact.duration / impact.time.size


def in_liggghts(law, dt, steps, folder):
    common.copy_inputs(__file__, folder)
    common.table(folder, "granite.tbl", law, rtol=1e-9)
    case = (
        (folder / "in.impact")
        .read_text()
        .replace("single -0.008 ", "single -0.00800005 ")
        .replace("single 0.008 ", "single 0.00800005 ")
    )
    (folder / "in.impact").write_text(case)
    log = run(folder / "in.impact", 1, {"speed": SPEED, "restitution": 1, "dt": repr(dt), "steps": steps})
    return log["force"].max(), log["speed_no"][-1]


def in_yade(name, unloading, options, dt, folder):
    from demlaws.yade.run import run as run_yade

    (folder / "impact.py").write_text(YADE)
    case = {"law": name, "unloading": unloading, "options": options, "diameter": DIAMETER, "speed": SPEED, "dt": dt}
    result = run_yade(
        folder / "impact.py",
        [json.dumps(case)],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=300,
    )
    lines = [line for line in result.stdout.splitlines() if line.startswith("RESULT")]
    if not lines:
        raise dl.DemlawsError(f"YADE gave no result:\n{result.stdout[-2000:]}")
    return json.loads(lines[-1].removeprefix("RESULT"))


def compare(laws=LAWS):
    """Rows (law, unloading, engine, peak force [N], rebound [m/s], relative differences from Python)."""
    mass = 0.5 * 2650 * 3.141592653589793 / 6 * DIAMETER**3
    rows = []
    for name, unloading, options in laws:
        law = dl.law(name, common.contact(DIAMETER / 2, DIAMETER / 2), unloading=unloading, **options)
        peak, rebound, dt = in_python(law, mass)
        rows.append((name, unloading, "Python", peak, rebound, 0.0, 0.0))
        with tempfile.TemporaryDirectory() as scratch:
            results = {"LIGGGHTS": in_liggghts(law, dt, int(4 * STEPS_PER_CONTACT), Path(scratch))}
            if shutil.which("yade"):
                results["YADE"] = in_yade(name, unloading, options, dt, Path(scratch))
        for engine, (force, speed) in results.items():
            rows.append((name, unloading, engine, force, speed, abs(force / peak - 1), abs(speed / rebound - 1)))
    return rows


if __name__ == "__main__":
    print(f"{'law':14} {'unloading':10} {'where':9} {'peak force':>12} {'rebound':>12} {'difference from Python':>24}")
    for name, unloading, engine, force, speed, a, b in compare():
        print(f"{name:14} {unloading:10} {engine:9} {force:10.6f} N {speed:8.7f} m/s {a:12.1e} {b:11.1e}")
