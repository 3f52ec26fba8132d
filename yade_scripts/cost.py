"""What a law costs inside YADE: time per contact of the interaction loop, as a ratio to native Hertz-Mindlin.

Shows: native Hertz-Mindlin, native linear, YADE's Conical Damage Model, the bridge with several laws in closed form and as a
table, and the public way; with 1 and with 2 threads. The ratio of a law of ours is taken within one scene: the same functor
alternates between our code and its own every two steps, over the same contacts in the same memory; other models have scenes
of their own, which take turns. The ratio is the figure; times depend on the machine.
Start: demlaws yade run yade_scripts/cost.py [--quick] [--threads 1 2] [--out FOLDER]
Takes: about 2 min (quick: 20 s, fewer contacts). Saves cost.png.
"""

import argparse
import json
import sys
import time
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import yade
from yade import utils

import demlaws as dl
from demlaws.yade import Law2_ScGeom_MindlinPhys_Demlaws
from demlaws.yade.run import run

O = yade.O  # noqa: E741
YOUNG, POISSON, DENSITY = 60.6e9, 0.25, 2680.0
SURFACE = {"granite": dl.Surface(roughness=2.4e-6, fractal_dimension=2.22, hardness=6.266e9)}
RADIUS = 0.01
BLOCK = 2  # steps timed in a row: short, so that some blocks are not interrupted


def table():
    contact = dl.Contact(RADIUS / 2, YOUNG / (1 - POISSON**2) / 2, 2.4e-6 * 2**0.5, 2.22)
    return dl.law("pohrt-popov", contact, "hertz").tabulate(1e-5)


BRIDGE = {
    "hertz": lambda: ("hertz", "elastic", {}),
    "pohrt-popov": lambda: ("pohrt-popov", "elastic", {}),
    "pohrt-popov, hertz unloading": lambda: ("pohrt-popov", "hertz", {}),
    "the same as a table": lambda: (table(), "hertz", {}),
    "rough-plastic, thornton unloading": lambda: ("rough-plastic", "thornton", {"yield_pressure": 1.66e9}),
    "rms, hertz unloading": lambda: ("rms", "hertz", {}),
}
PEERS = ("native Hertz-Mindlin", "native linear", "native Conical Damage Model", "public way, pohrt-popov")


def spheres(side, material):
    """A close packing with some 5.4 contacts a sphere, overlaps of 1e-4 of the radius."""
    O.materials.append(material)
    for i in range(side):
        for j in range(side):
            for k in range(side):
                x, y, z = 2 * i + (j + k) % 2, 3**0.5 * (j + (k % 2) / 3), 2 * 6**0.5 / 3 * k
                place = [0.9999 * RADIUS * c for c in (x, y, z)]
                O.bodies.append(utils.sphere(place, RADIUS * (1 + 1e-6 * np.sin(len(O.bodies))), material=material))
    O.dt = 1e-9


def scene(side, law, physics, material):
    """A new scene with a packing under `law`; returns its number."""
    number = O.addScene()
    O.switchToScene(number)
    spheres(side, material)
    O.engines = [
        yade.ForceResetter(),
        yade.InsertionSortCollider([yade.Bo1_Sphere_Aabb()], verletDist=0.2 * RADIUS),
        yade.InteractionLoop([yade.Ig2_Sphere_Sphere_ScGeom()], [physics], [law]),
        yade.NewtonIntegrator(damping=0),
    ]
    O.run(3, True)
    O.timingEnabled = True
    return number


def granite():
    return yade.FrictMat(young=YOUNG, poisson=POISSON, density=DENSITY, frictionAngle=0.5, label="granite")


def peer(side, name):
    if name == "native linear":
        return scene(side, yade.Law2_ScGeom_FrictPhys_CundallStrack(), yade.Ip2_FrictMat_FrictMat_FrictPhys(), granite())
    if name == "native Conical Damage Model":
        stone = yade.FrictMatCDM(young=YOUNG, poisson=POISSON, density=DENSITY, frictionAngle=0.5, label="granite")
        stone.sigmaMax, stone.alpha = 6.27e9, 0.5
        law = yade.Law2_ScGeom_MindlinPhysCDM_HertzMindlinCDM()
        return scene(side, law, yade.Ip2_FrictMatCDM_FrictMatCDM_MindlinPhysCDM(), stone)
    if name.startswith("public"):
        law = Law2_ScGeom_MindlinPhys_Demlaws("pohrt-popov", "elastic", SURFACE, bridge="public", label="public")
    else:
        law = yade.Law2_ScGeom_MindlinPhys_Mindlin()
    return scene(side, law, yade.Ip2_FrictMat_FrictMat_MindlinPhys(), granite())


def undisturbed(samples):
    """Lower decile: other processes can only add time."""
    return float(np.quantile(samples, 0.1))


def loop_time(steps):
    """Nanoseconds a contact and step of the interaction loop (in the public way: of all that replaces it).

    With one thread this is processor time, which other processes on the machine disturb less.
    """
    kinds = (yade.InteractionLoop, yade.LawDispatcher, yade.PyRunner, yade.ForceResetter)
    for engine in O.engines:
        if not isinstance(engine, kinds):
            engine.dead = True  # the spheres stand still
    clock = time.process_time if O.numThreads == 1 else time.perf_counter
    timed = [e for e in O.engines if isinstance(e, kinds[:3])]
    for engine in timed:
        engine.execTime = 0
    started = clock()
    O.run(steps, True)
    spent = clock() - started if O.numThreads == 1 else 1e-9 * sum(e.execTime for e in timed)
    return 1e9 * spent / steps / O.interactions.countReal()


def measure_bridge(side, repeats):
    """Name → (ns a contact, ratio to the native code of the same functor, µs a step of the guard)."""
    results, contacts = {}, 0
    made = {}
    for n, (name, specification) in enumerate(BRIDGE.items()):
        given, unloading, options = specification()
        law = Law2_ScGeom_MindlinPhys_Demlaws(given, unloading, SURFACE, bridge="native", label=f"law{n}", **options)
        number = scene(side, law, yade.Ip2_FrictMat_FrictMat_MindlinPhys(), granite())
        guard = next(e for e in O.engines if isinstance(e, yade.PyRunner))
        O.run(100, True)  # the guard looks at every contact at its steps 2, 10 and 100
        guard.execTime = 0
        O.run(50, True)
        made[name] = (number, law, guard.execTime / 50e3)
        guard.dead = True  # or it would put our code back
        contacts = O.interactions.countReal()
    times = {name: ([], []) for name in BRIDGE}
    for _ in range(repeats):
        for name, (number, law, _) in made.items():
            O.switchToScene(number)
            attachment = law.binding.attachment
            for ours in (True, False):
                if ours:
                    attachment.patch(law)
                else:
                    attachment.release(law)
                O.run(1, True)
                times[name][0 if ours else 1].append(loop_time(BLOCK))
    for name, (ours, native) in times.items():
        results[f"bridge: {name}"] = undisturbed(ours), undisturbed(ours) / undisturbed(native), made[name][2]
    return results, contacts


def measure_peers(side, repeats):
    numbers = {name: peer(side, name) for name in PEERS}
    times = {name: [] for name in PEERS}
    for round_ in range(repeats):
        for name, number in numbers.items():
            if name.startswith("public") and round_ % 10:
                continue
            O.switchToScene(number)
            O.run(1, True)
            times[name].append(loop_time(BLOCK))
    native = undisturbed(times[PEERS[0]])
    return {name: (undisturbed(values), undisturbed(values) / native, 0.0) for name, values in times.items()}


def child(quick):
    side, repeats = (9, 10) if quick else (14, 100)
    peers = measure_peers(side, repeats)
    results, contacts = measure_bridge(side, repeats)
    print("RESULT " + json.dumps({"contacts": contacts, "times": {**peers, **results}}))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="fewer repetitions")
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 2], help="numbers of threads (default 1 2)")
    parser.add_argument("--out", default=".", help="folder of the picture")
    parser.add_argument("--child", action="store_true", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.child:
        child(arguments.quick)
        return
    results = {}
    for threads in arguments.threads:
        options = ["--child", *(["--quick"] if arguments.quick else [])]
        done = run(sys.argv[0], options, threads, capture_output=True, text=True)
        line = next((x for x in done.stdout.splitlines() if x.startswith("RESULT ")), None)
        if line is None:
            raise SystemExit(done.stdout + done.stderr)
        results[threads] = json.loads(line.removeprefix("RESULT "))
    contacts = results[arguments.threads[0]]["contacts"]
    print(f"interaction loop, {contacts} contacts; ratio to native Hertz-Mindlin, and ns a contact (lower deciles)")
    head = "".join(f"{f'{n} thread(s)':>22}" for n in arguments.threads)
    print(f"{'':44}{head}{'guard':>14}")
    names = list(results[arguments.threads[0]]["times"])
    for name in names:
        cells = "".join(f"{results[n]['times'][name][1]:13.3f}{results[n]['times'][name][0]:9.1f}" for n in arguments.threads)
        guard = results[arguments.threads[0]]["times"][name][2]
        print(f"{name:44}{cells}" + (f"{guard:8.1f} µs/step" if guard else ""))
    figure, axis = plt.subplots(figsize=(8, 4), constrained_layout=True)
    shown = [name for name in names if not name.startswith("public")]
    for n, threads in enumerate(arguments.threads):
        ratios = [results[threads]["times"][name][1] for name in shown]
        place = np.arange(len(shown)) + 0.4 * (n - 0.5 * (len(arguments.threads) - 1))
        axis.barh(place, ratios, height=0.38, label=f"{threads} thread(s)")
    axis.axvline(1.0, color="k", lw=0.8)
    axis.axvline(1.1, color="k", lw=0.8, ls=":")
    axis.set_yticks(range(len(shown)), shown, fontsize=8)
    axis.invert_yaxis()
    axis.set(xlabel="time of the interaction loop over native Hertz-Mindlin")
    axis.legend()
    picture = Path(arguments.out) / "cost.png"
    picture.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(picture, dpi=120)
    print(f"picture: {picture}")


main()
