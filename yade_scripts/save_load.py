"""A packing saved in the middle of its compression and gone on with: in this process, and in a new one.

Shows: O.saveTmp/O.loadTmp, O.save/O.load, O.reload and loading in a new process (which knows nothing of this script)
continue the same run: positions, stored energy and plastic dissipation agree to rounding.
Start: demlaws yade run -x yade_scripts/save_load.py [--quick] [--out FOLDER]
Takes: about 15 s (quick: 6 s). Saves save_load.png.
"""

import argparse
import subprocess
import tempfile
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import yade
from yade import pack

import demlaws as dl
from demlaws.yade import Law2_ScGeom_MindlinPhys_Demlaws, engines

O = yade.O  # noqa: E741
SURFACE = dl.materials.granite.surface


def packing(number):
    O.materials.append(yade.FrictMat(young=60.6e9, poisson=0.25, frictionAngle=0.5, density=2680, label="granite"))
    O.periodic = True
    O.cell.hSize = yade.Matrix3(0.1, 0, 0, 0, 0.1, 0, 0, 0, 0.1)
    spheres = pack.SpherePack()
    spheres.makeCloud((0, 0, 0), (0.1, 0.1, 0.1), rMean=0.0075, rRelFuzz=0.3, periodic=True, seed=3, num=number)
    spheres.toSimulation(material="granite")
    O.cell.velGrad = yade.Matrix3(-60, 0, 0, 0, -60, 0, 0, 0, -60)
    functor = Law2_ScGeom_MindlinPhys_Demlaws("rough-plastic", "thornton", {"granite": SURFACE}, yield_pressure=1.66e9)
    O.engines = engines(functor, newton=yade.NewtonIntegrator(damping=0.1))
    O.dt = 1e-6
    return functor


def outcome(functor):
    positions = np.array([tuple(b.state.pos) for b in O.bodies])
    return positions, np.array(functor.totals()), O.interactions.countReal()


CONTINUE = """
import yade
yade.O.load({file!r})
yade.O.run({steps}, True)
import demlaws.yade
law = demlaws.yade.attached()
print("result", *[x.hex() for b in yade.O.bodies for x in b.state.pos], *[x.hex() for x in law.totals()])
"""


def in_new_process(file, steps, folder):
    script = Path(folder) / "continue.py"
    script.write_text(CONTINUE.format(file=file, steps=steps))
    done = subprocess.run(["yade", "-n", "-x", str(script)], capture_output=True, text=True, check=True)
    line = next(line for line in done.stdout.splitlines() if line.startswith("result"))
    values = np.array([float.fromhex(x) for x in line.split()[1:]])
    return values[:-2].reshape(-1, 3), values[-2:]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="fewer spheres")
    parser.add_argument("--out", default=".", help="folder of the picture")
    arguments = parser.parse_args()
    steps = 500
    functor = packing(100 if arguments.quick else 250)
    history = []
    for _ in range(30):
        O.run(100, True)
        history.append((O.time, *functor.totals()))
    with tempfile.TemporaryDirectory() as folder:
        file = str(Path(folder) / "packing.yade.bz2")
        O.saveTmp()
        O.save(file)
        for _ in range(5):
            O.run(steps // 5, True)
            history.append((O.time, *functor.totals()))
        goal, energies, contacts = outcome(functor)
        print(f"{len(goal)} spheres, {contacts} contacts; saved at step {O.iter - steps}, gone on for {steps} steps")
        print(f"stored {1e3 * energies[0]:.6f} mJ, dissipated {1e3 * energies[1]:.6f} mJ")
        print(f"{'way':28}{'largest difference of positions':>33}{'of energies (relative)':>25}")
        results = {}
        for name, load in (("O.loadTmp", O.loadTmp), ("O.load", lambda: O.load(file)), ("O.reload", O.reload)):
            load()
            O.run(steps, True)
            results[name] = outcome(functor)[:2]
        results["O.load in a new process"] = in_new_process(file, steps, folder)
        for name, (positions, totals) in results.items():
            difference = np.abs(positions - goal).max()
            print(f"{name:28}{difference:31.1e} m{np.abs(totals / energies - 1).max():25.1e}")
            if difference > 1e-12:
                raise SystemExit(f"{name} did not continue the same run")
    figure, axis = plt.subplots(figsize=(6, 4), constrained_layout=True)
    time, stored, dissipated = np.array(history).T
    axis.plot(1e3 * time, 1e3 * stored, label="stored")
    axis.plot(1e3 * time, 1e3 * dissipated, label="dissipated by plasticity")
    axis.axvline(1e3 * time[29], color="0.5", ls=":", label="saved")
    axis.set(xlabel="time (ms)", ylabel="energy (mJ)")
    axis.legend()
    picture = Path(arguments.out) / "save_load.png"
    picture.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(picture, dpi=120)
    print(f"picture: {picture}")


main()
