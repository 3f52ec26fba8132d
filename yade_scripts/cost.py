"""What a law costs inside YADE: time per contact of the interaction loop, as a ratio to native Hertz-Mindlin.

Shows: native Hertz-Mindlin, native linear, YADE's Conical Damage Model, the bridge with several laws in closed form and as a
table; with 1 and with 2 threads. The ratio of a law of ours is taken within one scene and one run: the
same functor alternates between our code and its own every two steps, of which the second is timed, over the same contacts in
the same memory; other models have scenes of their own, which take turns. The ratio is the figure; times depend on the machine.
Start: demlaws yade run -x yade_scripts/cost.py [--quick] [--sizes 4000 15000 60000] [--threads 1 2] [--bridge] [--laws LAW ...]
    [--every] [--damped] [--periodic] [--out FOLDER]
Takes: about 2 min per size (quick: 20 s, fewer contacts; --bridge: half of it; --every law and rule: 15 min per size, quick: 8,
with 6 GB at 60000, besides some eight minutes for compiling them once). Saves cost.png.
A user-defined law: call dl.load_laws("my_law.py") in a copy of this script; --bridge --laws "NAME, RULE" hertz
"""

import argparse
import ctypes
import json
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import yade

import demlaws as dl
from demlaws.laws.registry import find
from demlaws.make import example_law
from demlaws.yade import Law2_ScGeom_MindlinPhys_Demlaws
from demlaws.yade.native import address
from demlaws.yade.run import run

O = yade.O  # noqa: E741
YOUNG, POISSON, DENSITY = 60.6e9, 0.25, 2680.0
SURFACE = {"granite": dl.materials.granite}
ROUGHNESS = 2**0.5 * dl.materials.granite.surface.roughness  # σ of two grains
RADIUS = 0.01


def table():
    contact = dl.Contact(RADIUS / 2, YOUNG / (1 - POISSON**2) / 2, ROUGHNESS, 2.22)
    return dl.law("pohrt-popov", contact, "hertz").tabulate(1e-5)


BRIDGE = {
    "hertz": lambda: ("hertz", "elastic", {}),
    "pohrt-popov": lambda: ("pohrt-popov", "elastic", {}),
    "pohrt-popov, hertz unloading": lambda: ("pohrt-popov", "hertz", {}),
    "the same as a table": lambda: (table(), "hertz", {}),
    "rough-plastic, thornton unloading": lambda: ("rough-plastic", "thornton", {"yield_pressure": 1.66e9}),
    "rms, hertz unloading": lambda: ("rms", "hertz", {}),
    "hertz, shear native": lambda: ("hertz", "elastic", {"shear": "native"}),
    "pohrt-popov, slip": lambda: ("pohrt-popov", "elastic", {"shear": "slip"}),
    "pohrt-popov, hertz unloading, slip": lambda: ("pohrt-popov", "hertz", {"shear": "slip"}),
}


def of_rule(name, rule):
    """(law, rule, options) of one unloading rule of a law, for the spheres of `scene`."""
    contact = dl.Contact(RADIUS / 2, YOUNG / (1 - POISSON**2) / 2, ROUGHNESS, 2.22, 6.266e9)
    return example_law(name, contact, rule), None, {}


EVERY = {
    f"{name}, {rule}": lambda name=name, rule=rule: of_rule(name, rule) for name in dl.laws() for rule in find(name).offered()
}
EVERY["pohrt-popov, hertz, friction by pressure"] = lambda: (
    "pohrt-popov",
    "hertz",
    {"friction": dl.PressureFriction(0.3, 0.4, 1e-9)},
)
PEERS = ("native Hertz-Mindlin", "native linear", "native Conical Damage Model")


def spheres(side, material, overlap=2e-4 * RADIUS):
    """A close packing of side³ spheres with 4 to 5 contacts each, overlapping by `overlap` [m]."""
    i, j, k = np.indices((side,) * 3)
    x, y, z = 2 * i + (j + k) % 2, 3**0.5 * (j + (k % 2) / 3), 2 * 6**0.5 / 3 * k
    O.materials.append(material)
    for place in (np.stack([x, y, z], -1).reshape(-1, 3) * (RADIUS - 0.5 * overlap)).tolist():
        O.bodies.append(yade.utils.sphere(place, RADIUS * (1 + 1e-9 * np.sin(len(O.bodies))), material=material))
    O.dt = 1e-9


def scene(side, law, physics, material):
    """A new scene with a packing under `law`; returns its number."""
    number = O.addScene()
    O.switchToScene(number)
    if "--periodic" in sys.argv:
        O.periodic = True
        O.cell.setBox(*[2.0 * (side + 2) * RADIUS] * 3)
    spheres(side, material)
    O.engines = [
        yade.PyRunner(command="clock.tick()", iterPeriod=1, initRun=True, dead=True, label="ticker"),
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
    return scene(side, yade.Law2_ScGeom_MindlinPhys_Mindlin(), yade.Ip2_FrictMat_FrictMat_MindlinPhys(), granite())


def undisturbed(samples):
    """Lower decile: other processes can only add time."""
    return float(np.quantile(samples, 0.1))


class Clock:
    """Nanoseconds a contact of each step of what computes contacts, read between the steps of one run."""

    def start(self, each_step=lambda number: None):
        kinds = (yade.InteractionLoop, yade.LawDispatcher, yade.PyRunner)
        self.engines = [e for e in O._currEngines if isinstance(e, kinds) and e.label != "ticker" and not e.dead]
        for engine in O.engines:
            if isinstance(engine, yade.InsertionSortCollider | yade.NewtonIntegrator):
                engine.dead = True  # the spheres stand still
        self.each_step, self.steps, self.times, self.before = each_step, 0, [], 0
        O.engines[0].dead = False

    def tick(self):
        now = sum(engine.execTime for engine in self.engines)
        if self.steps:
            self.times.append(now - self.before)
        self.each_step(self.steps)
        self.steps += 1
        self.before = sum(engine.execTime for engine in self.engines)

    def run(self, steps, each_step=lambda number: None):
        self.start(each_step)
        O.run(steps + 1, True)
        O.engines[0].dead = True
        return np.array(self.times) / O.interactions.countReal()


clock = Clock()


def spread(ratios):
    """Median, smallest and largest."""
    return float(np.median(ratios)), float(np.min(ratios)), float(np.max(ratios))


NATIVE = yade.Law2_ScGeom_MindlinPhys_Mindlin()


def release(law):
    """Give the functor the table of a native one, so that YADE's own code acts; `patch` undoes it."""
    layout = law.binding.attachment.layout
    table = ctypes.c_uint64.from_address(address(NATIVE) + layout.find_slot(NATIVE)[0]).value
    ctypes.c_uint64.from_address(address(law) + layout.slot[0]).value = table


def measure_bridge(side, rounds, steps, wanted):
    """Name → (ns per contact; ratio to the functor's native code: median, least, most of the rounds; µs of the guard)."""
    made, contacts = {}, 0
    for n, name in enumerate(wanted):
        try:
            given, unloading, options = (BRIDGE | EVERY)[name]()
            law = Law2_ScGeom_MindlinPhys_Demlaws(given, unloading, SURFACE, label=f"law{n}", **options)
            damping = {"en": 0.5, "es": 0.5} if "--damped" in sys.argv else {}
            number = scene(side, law, yade.Ip2_FrictMat_FrictMat_MindlinPhys(**damping), granite())
        except (dl.DemlawsError, RuntimeError) as error:  # the guard's: an overlap that the law has no force at
            print(f"REFUSED {name}: {str(error).splitlines()[0]}")
            continue
        guard = next(e for e in O._currEngines if isinstance(e, yade.PyRunner) and e.label != "ticker")
        O.run(5, True)  # the guard checks every contact at the second step
        watched = 300 if O.interactions.countReal() < 30000 else 60
        law.binding.guards = 20 if watched == 300 else 110  # and then now and then; not within 60 steps
        guard.execTime = 0
        O.run(watched, True)
        made[name] = (number, law, guard.execTime / (1e3 * watched))
        guard.dead = True  # or it would put our code back
        contacts = O.interactions.countReal()
    times = {name: ([], []) for name in made}
    for _ in range(rounds):
        for name, (number, law, _) in made.items():
            O.switchToScene(number)
            attachment = law.binding.attachment

            def switch(step, law=law, patch=attachment.point):
                if step % 2 == 0:
                    (patch if step % 4 == 0 else release)(law)

            found = clock.run(steps, switch)
            attachment.point(law)
            for side_, first in ((0, 1), (1, 3)):  # the second step under either
                times[name][side_].append(undisturbed(found[first::4]))
    return {
        f"bridge: {name}": (min(ours), *spread(np.divide(ours, native)), made[name][2])
        for name, (ours, native) in times.items()
    }, contacts


def measure_peers(side, rounds, steps):
    numbers = {name: peer(side, name) for name in PEERS}
    times = {name: [] for name in PEERS}
    for _ in range(rounds):
        for name, number in numbers.items():
            O.switchToScene(number)
            times[name].append(undisturbed(clock.run(steps)))
    native = times[PEERS[0]]
    return {name: (min(values), *spread(np.divide(values, native)), 0.0) for name, values in times.items()}


def child(size, quick, bridge, wanted):
    """size: number of contacts, about; a sphere of the packing has 5.4 in the middle."""
    side = round((size / 5.4) ** (1 / 3))
    steps = 4 * round(np.clip((0.3e6 if quick else 0.9e6) / size, 12, 120))
    rounds = 3 if quick else 9
    peers = {} if bridge else measure_peers(side, rounds, steps // 2)
    results, contacts = measure_bridge(side, rounds, steps, wanted)
    print("RESULT " + json.dumps({"contacts": contacts, "times": {**peers, **results}}))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="fewer repetitions, 4,000 contacts unless sizes are given")
    parser.add_argument("--sizes", type=int, nargs="+", help="numbers of contacts, about (default 15000)")
    parser.add_argument("--bridge", action="store_true", help="our laws alone, without YADE's other models")
    known = list(BRIDGE | EVERY)
    parser.add_argument("--laws", nargs="+", choices=known, default=list(BRIDGE), metavar="LAW", help="some of our laws")
    parser.add_argument("--every", action="store_true", help="every law with each of its rules, without YADE's other models")
    parser.add_argument("--damped", action="store_true", help="viscous damping, in our laws and in the native one beside them")
    parser.add_argument("--periodic", action="store_true", help="a periodic cell")
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 2], help="numbers of threads (default 1 2)")
    parser.add_argument("--out", default=".", help="folder of the picture")
    parser.add_argument("--child", type=int, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.every:
        arguments.laws, arguments.bridge = list(EVERY), True
    if arguments.child:
        child(arguments.child, arguments.quick, arguments.bridge, arguments.laws)
        return
    for size in arguments.sizes or [4000 if arguments.quick else 15000]:
        results = measure(arguments, size)
        tell(arguments, results)
    draw(arguments, results)


def measure(arguments, size):
    """Number of threads → what `child` found."""
    results = {}
    for threads in arguments.threads:
        flags = [f"--{name}" for name in ("quick", "bridge", "damped", "periodic") if getattr(arguments, name)]
        options = ["--child", str(size), *flags, "--laws", *arguments.laws]
        done = run(sys.argv[0], options, threads, capture_output=True, text=True)
        line = next((x for x in done.stdout.splitlines() if x.startswith("RESULT ")), None)
        if line is None:
            raise SystemExit(done.stdout + done.stderr)
        if threads == arguments.threads[0]:
            print("".join(f"{x}\n" for x in done.stdout.splitlines() if x.startswith("REFUSED ")), end="")
        results[threads] = json.loads(line.removeprefix("RESULT "))
    return results


def tell(arguments, results):
    """A table of every model at one size."""
    contacts = results[arguments.threads[0]]["contacts"]
    print(f"interaction loop, {contacts} contacts; ratio to native Hertz-Mindlin (median, range of rounds), ns per contact")
    head = "".join(f"{f'{n} thread(s)':>30}" for n in arguments.threads)
    print(f"{'':44}{head}{'guard':>14}")
    names = list(results[arguments.threads[0]]["times"])
    for name in names:
        rows = [results[n]["times"][name] for n in arguments.threads]
        cells = "".join(f"{ratio:9.3f} ({low:.3f}-{high:.3f}){ns:8.1f}" for ns, ratio, low, high, _ in rows)
        guard = rows[0][4]
        print(f"{name:44}{cells}" + (f"{guard:8.1f} µs/step" if guard else ""), flush=True)


def draw(arguments, results):
    """The ratios of the last size."""
    names = list(results[arguments.threads[0]]["times"])
    figure, axis = plt.subplots(figsize=(8, max(4, 0.25 * len(names))), constrained_layout=True)
    for n, threads in enumerate(arguments.threads):
        ratios = [results[threads]["times"][name][1] for name in names]
        place = np.arange(len(names)) + 0.4 * (n - 0.5 * (len(arguments.threads) - 1))
        axis.barh(place, ratios, height=0.38, label=f"{threads} thread(s)")
    axis.axvline(1.0, color="k", lw=0.8)
    axis.axvline(1.1, color="k", lw=0.8, ls=":")
    axis.set_yticks(range(len(names)), names, fontsize=8)
    axis.invert_yaxis()
    axis.set(xlabel="time of the interaction loop over native Hertz-Mindlin")
    axis.legend()
    picture = Path(arguments.out) / "cost.png"
    picture.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(picture, dpi=120)
    print(f"picture: {picture}")


main()
