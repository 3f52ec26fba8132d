"""The same impact of two granite spheres in Python, YADE, LIGGGHTS and LAMMPS: peak force and rebound speed; about 20 s.

    python lammps_inputs/impact/four_way.py

Two spheres of 16 mm meet at 0.2 m/s; nothing but the law damps. An engine that is not installed is left out.
"""

import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))
import common

import demlaws as dl
from demlaws.lammps import run

THREE = common.load(common.SHARED.parent / "impact" / "three_way.py")


def in_lammps(law, dt, steps, folder):
    common.copy_inputs(__file__, folder)
    common.table(folder, "granite.tbl", law, rtol=1e-9)
    variables = {"speed": THREE.SPEED, "restitution": 1, "dt": repr(dt), "steps": steps, "gap": 1e-7}
    log = run(folder / "in.impact", 1, variables)
    return log["force"].max(), log["speed_now"][-1]


def compare(laws=THREE.LAWS, others=True):
    """Rows (law, unloading, engine, peak force [N], rebound [m/s], relative differences from Python)."""
    mass = 0.5 * 2650 * 3.141592653589793 / 6 * THREE.DIAMETER**3
    rows = THREE.compare(laws) if others else []
    for name, unloading, options in laws:
        law = dl.law(name, common.contact(THREE.DIAMETER / 2, THREE.DIAMETER / 2), unloading=unloading, **options)
        peak, rebound, dt = THREE.in_python(law, mass)
        with tempfile.TemporaryDirectory() as scratch:
            force, speed = in_lammps(law, dt, int(4 * THREE.STEPS_PER_CONTACT), Path(scratch))
        rows.append((name, unloading, "LAMMPS", force, speed, abs(force / peak - 1), abs(speed / rebound - 1)))
    return sorted(rows, key=lambda row: row[:2])


if __name__ == "__main__":
    print(f"{'law':14} {'unloading':10} {'where':9} {'peak force':>12} {'rebound':>12} {'difference from Python':>24}")
    for name, unloading, engine, force, speed, a, b in compare():
        print(f"{name:14} {unloading:10} {engine:9} {force:10.6f} N {speed:8.7f} m/s {a:12.1e} {b:11.1e}")
