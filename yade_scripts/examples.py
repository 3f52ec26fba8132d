"""YADE's own examples with its Hertz-Mindlin law and with a rough one: what had to be changed, and what came out.

Shows: examples that come with YADE (triaxial tests, periodic cells, clumps, a drum from STL, a hopper, an oedometer, buoyancy,
factories, the Conical Damage Model beside ours, yade-batch) run as they are, except that their contact law is first YADE's
Law2_ScGeom_MindlinPhys_Mindlin, then ours in its place, and that runs are shortened; energy, stress or height of both. No
script is kept here: they are read from the folder in which YADE's package has them, or from the one that is given.
Start: demlaws yade run -x yade_scripts/examples.py [--quick] [--hertz] [--examples FOLDER] [--only NAME ...] [--out FOLDER]
--hertz: our Hertz law with native shear in place of the rough one, and the largest distance between places of bodies by both.
Takes: about 10 min (quick, a quarter of the steps: 5), --only for less. Saves examples.png.
"""

import argparse
import builtins
import gzip
import json
import math
import os
import shutil
import subprocess
import sys
import tempfile
import types
from pathlib import Path

FOLDER = "/usr/share/doc/yade/examples"
MINDLIN = "law, Ip2"
VISCOUS = "law, Ip2, material"


class Example:
    """One of YADE's examples.

    path: in the folder of examples; changed: the changes that a run by Mindlin needs beside the example's text (nothing where
    it has Mindlin already); steps: of the shortened run; share: of the steps that the script itself asks for;
    roughness: Sq [m]; before: run in the example's folder before it; after: commented-out or interactive parts of the example,
    run behind it; swaps: parts of the text in place of others.
    """

    def __init__(self, name, path, changed, steps, roughness, share=1.0, before="", after="", swaps=(), batch=None):
        self.name, self.path, self.changed, self.steps, self.roughness = name, path, changed, steps, roughness
        self.share, self.before, self.after, self.swaps, self.batch = share, before, after, swaps, batch


TRIAX = """
O.run(2000, True)
O.engines = O.engines[0:5] + [PyRunner(iterPeriod=20, command='history()', label='recorder')] + O.engines[5:7]
rows = []
def history():
    rows.append((triax.meanStress, triax.porosity))
O.run(1000, True)
assert len(rows) > 10 and isinstance(O.engines[-1], NewtonIntegrator), O.engines
"""

# Data files of capillary bridges, which YADE's package does not have: by its own solver, as writesCapFile.m does it, with few
# radius ratios, suctions and distances, which suffice for this example
BRIDGES = """
import numpy
exec(open("solveLaplace_uc.py").read())
for ratio in (1, 1.1, 1.25, 1.5, 1.75, 2):
    suctions = (15, 20, 26, 33, 40)
    found = [solveLaplace_uc(0, ratio, suction, numpy.arange(2.0, 40.0, 2.0), 1e-3, 0) for suction in suctions]
    found = [rows[numpy.argsort(rows[:, 0])][:, [0, 1, 2, 3, 4, 5, 7, 8]] for rows in found]
    distances = numpy.linspace(0.0, found[0][-1, 0], 20)
    with open(f"M(r={ratio})", "w") as file:
        print(ratio, len(distances), sep="\\n", file=file)
        for distance in distances:
            rows = [[numpy.interp(distance, r[:, 0], column) for column in r.T] for r in found if r[-1, 0] >= distance]
            for row in [[len(rows)], *([distance, *row[1:]] for row in rows)]:
                print(*row, sep="\\t", file=file)
"""

# Mindlin's functor serves the contacts of grids, too; both laws take the same constant step
GRID = [("Law2_ScGridCoGeom_FrictPhys_CundallStrack(),", "")]
CONSTANT = "O.dt = 0.1 * PWaveTimeStep()"
STEPPER = "GlobalStiffnessTimeStepper(timestepSafetyCoefficient=0.1, label='ts'),"

EXAMPLES = (
    Example("triax tutorial", "triax-tutorial/script-session1.py", MINDLIN, 3000, 1e-5, after=TRIAX),
    Example(
        "FEMxDEM RVE",
        "FEMxDEM/prepareRVE.py",
        f"{MINDLIN}; poisson .2 (.8 is k_s/k_n of the linear law there)",
        12000,
        1e-7,
        swaps=[("poisson=.8", "poisson=.2")],
    ),
    Example("periodic shear", "PeriodicBoundaries/periodic-simple-shear.py", MINDLIN, 16000, 1e-7),
    Example("periodic triax", "PeriodicBoundaries/periodic-triax.py", MINDLIN, 16000, 1e-7),
    Example("settings of hSize", "PeriodicBoundaries/periodic-triax-settingHsize.py", MINDLIN, 4000, 1e-7),
    Example(
        "triax of clumps",
        "triax-tutorial/script-session1.py",
        f"{MINDLIN}; clumps = True",
        3000,
        1e-5,
        swaps=[("clumps = False", "clumps = True")],
    ),
    Example(
        "STL drum",
        "baraban/baraban.py",
        f"{VISCOUS}; 216 grains",
        5000,
        1e-5,
        swaps=[("nbSpheres = (10, 10, 10)", "nbSpheres = (6, 6, 6)")],
    ),
    Example("hopper", "funnel.py", MINDLIN, 1500, 1e-5),
    Example("hopper of clumps", "clumps/clump-hopper-test.py", VISCOUS, 16000, 1e-6),
    Example(
        "oedometer",
        "DeformEngine/OedometricDeform.py",
        f"{VISCOUS}; no DeformControl",  # which Debian's YADE does not have
        12000,
        1e-6,
        swaps=[('        DeformControl(label="DefControl")\n', "")],
    ),
    Example(
        "sand pile",
        "PeriodicBoundaries/periodicSandPile.py",
        f"{MINDLIN}; 10 times stiffer",
        3000,
        1e-6,
        swaps=[("young=1e5", "young=1e6"), ("young=1e4", "young=1e5")],
    ),
    Example("buoyancy, clumps", "clumps/apply-buoyancy-clumps.py", "nothing", 5000, 1e-5, share=0.02),
    Example("factory", "spheresFactory.py", "nothing", 2000, 1e-7),
    Example(
        "Mindlin, beside CDM", "test/HertzMindlinExtended/HertzMindlinExtended_periodicSimpleShear.py", "nothing", 2500, 1e-5
    ),
    Example(
        "the same without CDM",
        "test/HertzMindlinExtended/HertzMindlinExtended_periodicSimpleShear.py",
        "makeCDM = 0",
        2500,
        1e-5,
        swaps=[("makeCDM = 1", "makeCDM = 0")],
    ),
    Example("damping", "test/Damping_HM.py", "poisson .3 (.6)", 2000, 1e-6, swaps=[("poisson = 0.6", "poisson = 0.3")]),
    Example("two Mindlin spheres", "test/mindlin.py", "poisson .3 (.6)", 100, 1e-5, swaps=[("poisson=0.6", "poisson=0.3")]),
    Example(
        "PFacets and grids",
        "pfacet/pFacets_grids_spheres_interacting.py",
        f"{MINDLIN}, constant step",
        24000,
        1e-7,
        swaps=[*GRID, (STEPPER, "")],
        after=CONSTANT,
    ),
    Example(
        "roots of grids",
        "cylinders/cylinderconnection-roots.py",
        f"{MINDLIN}, constant step; poisson .3 (3)",
        20000,
        1e-6,
        swaps=[*GRID, (STEPPER, ""), ("poisson = 3", "poisson = 0.3")],
        after=CONSTANT,
    ),
    Example(
        "roots of cylinders",
        "chained-cylinders/chained-cylinder-roots.py",
        f"{MINDLIN}; 100 times stiffer",  # and poisson .3, which is 3 there
        24000,
        1e-6,
        swaps=[
            ("Law2_CylScGeom_FrictPhys_CundallStrack()", ""),
            ("poisson = 3", "poisson = 0.3"),
            ("young = 4.0e6", "young = 4.0e8"),
            ("young=4000000.0", "young=4e8"),
            ("young=1.0e6", "young=1e8"),
            ("O.dt = 5e-4", "O.dt = 5e-5"),
        ],
    ),
    Example("capillary bridges", "capillaryLaplaceYoung/CapillaryPhys-example.py", "nothing", 20000, 1e-7, before=BRIDGES),
    Example("yade-batch", "triax-tutorial/script-session1.py", MINDLIN, 1000, 1e-5, batch="triax-tutorial/triax-table"),
)
WAYS = ("Mindlin", "ours")


def text_of(folder, path):
    """An example's text: Debian compresses long ones."""
    for file in (Path(folder) / path, Path(folder) / f"{path}.gz"):
        if file.exists():
            return gzip.decompress(file.read_bytes()).decode() if file.suffix == ".gz" else file.read_text()
    raise FileNotFoundError(f"no {path} in {folder}")


# --- one example, in a YADE of its own


def one(given):
    """Run an example in this YADE and write what came out."""
    import yade

    import __main__
    import demlaws as dl
    from demlaws.yade import Law2_ScGeom_MindlinPhys_Demlaws

    omega, main = yade.O, vars(__main__)
    example = Example(**given["example"])
    laws = []

    def law(*functors, **keywords):
        keep = {name: value for name, value in keywords.items() if name in ("label", "neverErase", "calcEnergy")}
        if given["way"] == "Mindlin":
            laws.append(yade.Law2_ScGeom_MindlinPhys_Mindlin(**keep))
        elif given["hertz"]:
            laws.append(Law2_ScGeom_MindlinPhys_Demlaws("hertz", smooth=True, shear="native", flats="yade", **keep))
        else:
            surface = dl.Surface(roughness=example.roughness, fractal_dimension=2.2)
            laws.append(Law2_ScGeom_MindlinPhys_Demlaws("pohrt-popov", "hertz", surface, **keep))
        return laws[-1]

    def viscous(**values):
        return yade.FrictMat(
            young=1e7, poisson=0.3, frictionAngle=values.get("frictionAngle", 0.5), density=values.get("density", 1000)
        )

    from yade import gridpfacet  # examples import all of its names

    names = {"Law2_ScGeom_MindlinPhys_Mindlin": law}
    if example.changed.startswith(MINDLIN):
        names["Law2_ScGeom_FrictPhys_CundallStrack"] = names["Law2_ScGeom_ViscElPhys_Basic"] = law
        names["Ip2_FrictMat_FrictMat_FrictPhys"] = yade.Ip2_FrictMat_FrictMat_MindlinPhys
    main.update(names)
    vars(gridpfacet).update(names)
    if example.changed.startswith(VISCOUS):
        main["Ip2_ViscElMat_ViscElMat_ViscElPhys"] = lambda: yade.Ip2_FrictMat_FrictMat_MindlinPhys(en=0.3, es=0.3)
        main["ViscElMat"] = viscous
        yade.utils.defaultMaterial = lambda: viscous(density=1000)
    nothing_to_see(yade)
    shorten(omega, example)
    random_numbers(main)
    os.chdir(given["scratch"])
    text = text_of(given["folder"], example.path)
    for old, new in example.swaps:
        assert old in text, f"{example.path} no longer holds {old!r}"
        text = text.replace(old, new)
    exec(compile(example.before, "before", "exec"), main)
    exec(compile(text, example.path, "exec"), main)
    exec(compile(example.after, "after", "exec"), main)
    example.share = 1.0  # of the steps that are left
    while omega.iter < example.steps and not omega.demlaws_paused:
        before = omega.iter
        omega.run(builtins.min(500, example.steps - omega.iter), True)  # examples put numpy's min in its place
        if omega.iter == before:
            break
    rest(omega, given, laws)


def nothing_to_see(yade):
    """No windows, no plots."""

    class Nothing:
        def __init__(self, *arguments, **keywords):
            pass

        def __getattr__(self, name):
            return Nothing()

        def __call__(self, *arguments, **keywords):
            return Nothing()

    qt = types.ModuleType("yade.qt")
    qt.__getattr__ = lambda name: Nothing()
    yade.qt = sys.modules["yade.qt"] = qt
    import matplotlib

    matplotlib.use = lambda *arguments, **keywords: None
    import yade.plot

    yade.plot.plot = lambda *arguments, **keywords: None


def shorten(omega, example):
    """O.run takes a share of the steps of the run, up to the example's number; one without end waits for O.wait or
    the end of the script, which may define what the engines call only then."""
    cls = type(omega)
    run, pause = cls.run, cls.pause
    cls.demlaws_paused = False

    def shorter(self, nSteps=-1, wait=False):
        left = builtins.max(example.steps - self.iter, 0)
        steps = left if nSteps <= 0 else builtins.min(builtins.max(int(nSteps * example.share), 1), left)
        if steps and not cls.demlaws_paused and (nSteps > 0 or wait):
            run(self, steps, True)

    def waited(self):
        shorter(self, wait=True)

    def paused(self):
        cls.demlaws_paused = True
        pause(self)

    cls.run, cls.pause, cls.wait = shorter, paused, waited


def random_numbers(main):
    """The same ones for both laws."""
    import random

    import numpy
    from yade import pack

    random.seed(1)
    numpy.random.seed(1)  # noqa: NPY002  what the examples draw from
    for name in ("makeCloud", "makeClumpCloud"):
        native = getattr(pack.SpherePack, name)

        def seeded(self, *arguments, native=native, **keywords):
            if len(arguments) < 8:
                keywords.setdefault("seed", 1)
            return native(self, *arguments, **keywords)

        setattr(pack.SpherePack, name, seeded)


def rest(omega, given, laws):
    """Write what the scene has come to, and end YADE."""
    import yade
    from yade import utils

    if omega.running:
        omega.pause()
        omega.wait()
    spheres = [body for body in omega.bodies if body is not None and isinstance(body.shape, yade.Sphere)]
    heights = [tuple(body.state.pos) for body in spheres]
    up = given["up"]
    found = {
        "steps": omega.iter,
        "spheres": len(spheres),
        "contacts": omega.interactions.countReal(),
        "energy": utils.kineticEnergy(),
        "height": builtins.sum(place[up] for place in heights) / builtins.max(len(heights), 1),
        "stress": builtins.sum(utils.getStress()[n, n] for n in range(3)) / 3 if omega.periodic else None,
        "seen": None,
        "places": [tuple(body.state.pos) for body in omega.bodies if body is not None],
    }
    if given["way"] == "ours":
        law = laws[-1]
        law.binding.verify()
        found["seen"] = len(law.contacts().force)
        found["repr"] = repr(law)
    # a batch runs the script once for each line of its table
    number = len(list(Path(given["result"]).parent.glob(Path(given["result"]).name + "*")))
    Path(f"{given['result']}{number}").write_text(json.dumps(found))
    sys.stdout.flush()
    os._exit(0)


# --- all of them


def run_example(example, way, arguments, scratch):
    """What an example came to by one of the two laws: a list with one dict a run."""
    from demlaws.yade.run import command, environment

    folder = Path(scratch) / f"{example.name} {way}".replace(" ", "-").replace(",", "")
    source = Path(arguments.examples) / example.path
    shutil.copytree(source.parent, folder)
    for file in folder.rglob("*.gz"):
        file.with_suffix("").write_bytes(gzip.decompress(file.read_bytes()))
    result = str(folder / "result-")
    given = {
        "example": vars(example),
        "way": way,
        "folder": arguments.examples,
        "scratch": str(folder),
        "result": result,
        "hertz": arguments.hertz,
        "up": 1 if "SandPile" in example.path or "baraban" in example.path else 2,
    }
    if arguments.quick:
        given["example"] = {**vars(example), "steps": max(example.steps // 4, 100), "share": 0.25 * example.share}
    surroundings = {**environment(), "DEMLAWS_EXAMPLE": json.dumps(given)}
    batch = None
    if example.batch:
        batch = str(folder / "table")
        # the table's first column is the number of threads, which yade-batch gets otherwise here
        rows = [line.split()[1:] for line in text_of(arguments.examples, example.batch).splitlines()]
        Path(batch).write_text("\n".join(" ".join(row) for row in rows[:3]) + "\n")
    line = command(Path(sys.argv[0]).resolve(), [] if batch else ["--one"], batch=batch)
    done = subprocess.run(
        line,
        env=surroundings,
        cwd=folder,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    found = [json.loads(file.read_text()) for file in sorted(folder.glob("result-*"))]
    if not found:
        logs = "".join(file.read_text()[-800:] for file in folder.glob("*.log"))
        errors = [line for line in (logs + done.stdout).splitlines() if "Error" in line or "ERROR" in line]
        return [], "; ".join(errors) or (logs + done.stdout)[-800:]
    return found, ""


def row(example, mindlin, ours):
    """A line of the table, and (name, value by Mindlin, by ours) for the picture."""
    quantity, unit = ("stress", "Pa") if mindlin["stress"] is not None else ("height", "m")
    a, b = mindlin[quantity], ours[quantity]
    seen = f"{ours['seen']}/{ours['contacts']}"
    line = (
        f"{example.name:21}{example.changed:36}{'nothing':9}{mindlin['steps']:7d}{ours['steps']:7d}{mindlin['contacts']:7d}{seen:>12}"
        f"{mindlin['energy']:12.3e}{ours['energy']:12.3e}  {quantity:7}{a:12.4g}{b:12.4g} {unit}"
    )
    return line, (example.name, a, b)


def picture(rows, folder):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axis = plt.subplots(figsize=(8, 5), constrained_layout=True)
    places = range(len(rows))
    axis.barh(places, [b / a if a else 1.0 for _, a, b in rows])
    axis.set_yticks(list(places), [name for name, _, _ in rows])
    axis.axvline(1.0, color="0.4", lw=1)
    axis.invert_yaxis()
    axis.set(xlabel="mean stress (periodic cells) or mean height: Pohrt-Popov over Hertz-Mindlin")
    path = Path(folder) / "examples.png"
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=120)
    return path


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a quarter of the steps")
    parser.add_argument("--hertz", action="store_true", help="our Hertz law with native shear in place of the rough one")
    parser.add_argument("--examples", default=FOLDER, help="folder of YADE's examples (default: that of the package yade)")
    parser.add_argument("--only", nargs="+", metavar="NAME", help="examples whose name holds one of these")
    parser.add_argument("--out", default=".", help="folder of the picture")
    arguments = parser.parse_args()
    chosen = [e for e in EXAMPLES if not arguments.only or any(word in e.name for word in arguments.only)]
    ours = "hertz, native shear" if arguments.hertz else "pohrt-popov, Hertz unloading"
    print(f"YADE's examples, shortened, by YADE's Hertz-Mindlin and by ours ({ours}) in its place.")
    print(
        "To Mindlin: what differs from the example; to ours: what had to be changed beside the law; seen: contacts by our law."
    )
    print(
        f"{'example':21}{'to Mindlin':36}{'to ours':9}{'steps':>7}{'ours':>7}{'':>7}{'contacts seen':>12}"
        f"{'E_kin [J]':>11}{'ours':>12}  {'':7}{'Mindlin':>12}{'ours':>12}"
    )
    rows, failed = [], 0
    with tempfile.TemporaryDirectory() as scratch:
        for example in chosen:
            found = {}
            for way in WAYS:
                found[way], why = run_example(example, way, arguments, scratch)
                if not found[way]:
                    failed += 1
                    print(f"{example.name:21}FAILED by {way}: {why}", flush=True)
            for mindlin, ours in zip(*(found[way] for way in WAYS), strict=False):
                line, values = row(example, mindlin, ours)
                apart = max(math.dist(a, b) for a, b in zip(mindlin["places"], ours["places"], strict=False))
                print(f"{line}{f', places within {apart:.1e} m' if arguments.hertz else ''}", flush=True)
                rows.append(values)
    print(f"{len(rows)} runs by both laws, {failed} failed")
    if rows:
        print(f"picture: {picture(rows, arguments.out)}")
    if failed:
        raise SystemExit(1)


if "DEMLAWS_EXAMPLE" in os.environ:
    one(json.loads(os.environ["DEMLAWS_EXAMPLE"]))
else:
    main()
