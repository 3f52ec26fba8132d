"""Track ballast of clumps: small-strain stiffness against pressure for smooth, rough and yielding contacts.

Shows: 500 angular clumps (five to seven spheres each, 20-60 mm by a ballast grading, granite) are deposited under gravity, then
compressed isotropically in a box; at 20, 50, 100 and 200 kPa a strain of 1e-5 probes the bulk stiffness, onwards and
backwards from the same state. Hertz, Pohrt-Popov (elastic, and with Hertz unloading) and
rough-plastic contacts start from the same packing. Printed: stiffness,
its exponent against pressure, processor time per step, the share of contacts in each branch of the law.
Start: demlaws yade run -x yade_scripts/ballast.py [--quick] [--out FOLDER] [--grains N] [--threads at `yade run`]
Takes: about 8 min (quick: 20 s, 40 grains, two pressures). Saves ballast.png.

The deposit uses soft grains, so that it takes thousands of steps and not millions; grains are then drawn apart by 1 %, until
none touch, and compressed with granite's own stiffness by the law under test.
"""

import argparse
import math
import time
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import matplotlib.ticker
import numpy as np
import yade
from yade import utils

import demlaws as dl
from demlaws.yade import Law2_ScGeom_MindlinPhys_Demlaws, engines

O = yade.O  # noqa: E741
YOUNG, POISSON, DENSITY, YIELD = 60.6e9, 0.25, 2680.0, 1.66e9
SURFACE = dl.Surface(roughness=5e-6, fractal_dimension=2.2, hardness=6.266e9)
LOOSE, ROUGH = math.radians(3), math.radians(30)  # friction until LUBRICATED [Pa], for a dense packing, and after
LUBRICATED = 5e3
LAWS = (
    ("hertz", "elastic", {}),
    ("pohrt-popov", "elastic", {}),
    ("pohrt-popov", "hertz", {}),
    ("rough-plastic", "hertz", {"yield_pressure": YIELD}),
)
# sieve [m]: share of mass that passes, after the middle of the bands that railways prescribe
GRADING = {0.020: 0.0, 0.0315: 0.15, 0.040: 0.50, 0.050: 0.85, 0.060: 1.0}
SPREAD = 1.01
PROBE = 1e-5  # linear strain; overlaps at 20 kPa are some 1e-4 of a grain


def grain(size, generator):
    """Spheres (centres, radii) of one angular grain: a core and corners that stick out, longer and flatter at random."""
    corners = generator.integers(4, 7)
    directions = [generator.normal(size=3)]
    while len(directions) < corners:  # corners in directions well apart
        trial = generator.normal(size=(40, 3))
        trial /= np.linalg.norm(trial, axis=1)[:, None]
        taken = np.array(directions) / np.linalg.norm(directions, axis=1)[:, None]
        directions.append(trial[np.argmin((trial @ taken.T).max(axis=1))])
    directions = np.array(directions)
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    form = np.array([generator.uniform(1.0, 1.3), 1.0, generator.uniform(0.7, 1.0)])
    radii = np.concatenate([[0.33], generator.uniform(0.13, 0.19, corners)]) * size
    reach = 0.5 * size - radii[1:]
    centres = np.vstack([np.zeros(3), directions * reach[:, None] * form])
    return centres, radii


def rotation(generator):
    q = generator.normal(size=4)
    w, x, y, z = q / np.linalg.norm(q)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def sizes(number, generator):
    """Grain sizes [m] whose masses follow the grading: the number density goes as the mass density over size³."""
    sieves, passing = np.array(list(GRADING)), np.array(list(GRADING.values()))
    fine = np.linspace(sieves[0], sieves[-1], 2000)
    weight = np.gradient(np.interp(fine, sieves, passing), fine) / fine**3
    cumulative = np.cumsum(weight) / weight.sum()
    return np.interp((generator.permutation(number) + 0.5) / number, cumulative, fine)


def add_grains(grains, material):
    for centres, radii in grains:
        spheres = [utils.sphere(tuple(map(float, c)), float(r), material=material) for c, r in zip(centres, radii, strict=True)]
        O.bodies.appendClumped(spheres, discretization=8)


def snapshot():
    """Centres and radii of the spheres of every clump."""
    grains = []
    for body in O.bodies:
        if body is not None and body.isClump:
            members = [O.bodies[n] for n in body.shape.members]
            grains.append((np.array([tuple(m.state.pos) for m in members]), np.array([m.shape.radius for m in members])))
    return grains


def deposit(number, generator):
    """Grains of soft stone fall into a box; returns them at rest, and the corners of the box that holds them."""
    O.reset()
    soft = yade.FrictMat(young=YOUNG / 1000, poisson=POISSON, density=DENSITY, frictionAngle=LOOSE, label="soft")
    smooth = yade.FrictMat(young=YOUNG / 1000, poisson=POISSON, density=DENSITY, frictionAngle=0.0, label="walls")
    O.materials.append(soft)
    O.materials.append(smooth)
    diameters = sizes(number, generator)
    pitch = 0.066  # no grain reaches further
    across = max(2, round((float(np.sum(0.3 * diameters**3)) / 0.6) ** (1 / 3) / pitch))
    width = across * pitch
    for axis, sense, place in ((2, 1, 0.0), (0, 1, 0.0), (0, -1, width), (1, 1, 0.0), (1, -1, width)):
        position = [width / 2] * 3
        position[axis] = place
        O.bodies.append(utils.wall(tuple(position), axis, sense=sense, material="walls"))
    grains = []
    for n, size in enumerate(diameters):
        centres, radii = grain(size, generator)
        layer, rest = divmod(n, across * across)
        place = np.array([rest % across + 0.5, rest // across + 0.5, layer + 0.6]) * pitch
        grains.append((centres @ rotation(generator).T + place, radii))
    add_grains(grains, "soft")
    law = Law2_ScGeom_MindlinPhys_Demlaws("hertz", label="deposit")
    height = grains[-1][0][0, 2]
    gravity = 30.0
    O.engines = engines(
        law,
        physics=yade.Ip2_FrictMat_FrictMat_MindlinPhys(betan=0.3, betas=0.3),
        newton=yade.NewtonIntegrator(damping=0.2, gravity=(0, 0, -gravity)),
    )
    O.dt = 3e-5
    fall = math.sqrt(2 * height / gravity)
    started, steps = time.perf_counter(), 0
    while O.time < 1.2 * fall or (utils.unbalancedForce() > 0.02 and O.time < 4 * fall):
        O.run(500, True)
        steps += 500
    grains = snapshot()
    top = max(float((c[:, 2] + r).max()) for c, r in grains)
    print(
        f"deposit: {len(grains)} grains of {sum(len(r) for _, r in grains)} spheres, {steps} steps, "
        f"{time.perf_counter() - started:.0f} s, {utils.kineticEnergy():.0e} J left, "
        f"box {width:.3f} x {width:.3f} x {top:.3f} m",
        flush=True,
    )
    return grains


class Box:
    """A packing between six walls under stress control."""

    def __init__(self, grains, name, unloading, options, quick):
        O.reset()
        self.increment, self.patience = (0.25, 4000) if quick else (0.08, 30000)
        for label, friction in (("ballast", LOOSE), ("walls", 0.0)):
            O.materials.append(
                yade.FrictMat(young=YOUNG, poisson=POISSON, density=DENSITY, frictionAngle=friction, label=label)
            )
        drawn = []
        for centres, radii in grains:
            middle = centres.mean(axis=0)
            drawn.append((centres + (SPREAD - 1) * middle, radii))
        low = np.min([(c - r[:, None]).min(axis=0) for c, r in drawn], axis=0)
        high = np.max([(c + r[:, None]).max(axis=0) for c, r in drawn], axis=0)
        O.bodies.append(utils.aabbWalls([tuple(low - 1e-4), tuple(high + 1e-4)], thickness=0, material="walls"))
        add_grains(drawn, "ballast")
        self.law = Law2_ScGeom_MindlinPhys_Demlaws(
            name, unloading, {"ballast": SURFACE, "walls": dl.Surface(0)}, flats="yade", **options
        )
        self.name, self.unloading, self.contacts_seen = name, unloading, 0
        self.make_servo()
        O.engines = engines(self.law, timestep=0.5, after=[self.servo], newton=yade.NewtonIntegrator(damping=0.6), verlet=0.15)
        for engine in O.engines:
            if isinstance(engine, yade.GlobalStiffnessTimeStepper):
                engine.maxDt = 5e-6  # a young contact is soft: its tangent must not decide
        O.dt = 1e-6
        self.steps, self.seconds = 0, 0.0
        self.run(3000 if quick else 6000)
        self.compress(LUBRICATED)
        O.materials["ballast"].frictionAngle = ROUGH
        for contact in O.interactions:
            if contact.isReal and min(contact.id1, contact.id2) > 5:  # the walls are bodies 0 to 5
                contact.phys.tangensOfFrictionAngle = math.tan(ROUGH)

    def make_servo(self):
        self.servo = yade.TriaxialStressController(
            thickness=0, internalCompaction=False, stressMask=7, max_vel=0.05, stressDamping=0.25, label="servo"
        )
        self.servo.goal1 = self.servo.goal2 = self.servo.goal3 = -2e3

    def run(self, steps):
        started = time.process_time()  # of the processor: others may be using it too
        O.run(steps, True)
        self.steps += steps
        self.seconds += time.process_time() - started

    @property
    def control(self):
        return next(e for e in O.engines if isinstance(e, yade.TriaxialStressController))

    def pressure(self):
        return -self.control.meanStress

    def stresses(self):
        return [-self.control.stress(wall)[axis] * sign for wall, axis, sign in ((1, 0, 1), (3, 1, 1), (5, 2, 1))]

    def compress(self, pressure):
        """Raise the pressure slowly from what it is, then wait for rest; whether rest was reached."""
        control = self.control
        control.stressMask = 7
        start = max(self.pressure(), 2e3)
        track = []
        for goal in np.geomspace(start, pressure, 2 + round(math.log(pressure / start) / self.increment)):
            control.goal1 = control.goal2 = control.goal3 = -goal
            self.run(400)
            track.append((self.pressure(), math.log(self.volume())))
        # stiffness of first loading, sliding of grains included: the slope over the last third of the ramp
        (low, volume), (high, smaller) = track[-1 - len(track) // 3], track[-1]
        self.loading = (high - low) / (volume - smaller)
        for _ in range(self.patience // 500):
            self.run(500)
            if self.at_rest(pressure):
                break
        control.stressMask = 0
        control.goal1 = control.goal2 = control.goal3 = 0.0
        self.run(1500)  # walls at rest
        return self.at_rest(pressure, 0.02)

    def at_rest(self, pressure, tolerance=0.005):
        worst = max(abs(abs(s) / pressure - 1) for s in self.stresses())
        return worst < tolerance and utils.unbalancedForce() < 5e-4

    def volume(self):
        control = self.control
        return control.width * control.height * control.depth

    def strained(self, sense, steps):
        """Pressure and volume after an isotropic strain of `sense` PROBE from the saved state."""
        O.loadTmp("state")
        control = self.control
        control.max_vel = 1.0
        control.goal1 = control.goal2 = control.goal3 = -sense * PROBE / (steps * O.dt)
        self.run(steps)
        control.goal1 = control.goal2 = control.goal3 = 0.0
        self.run(steps)
        return self.pressure(), self.volume()

    def probe(self, steps):
        """Bulk stiffness [Pa] onwards and backwards, against the same number of steps without strain."""
        O.saveTmp("state")
        (up, small), (rest, volume), (down, large) = (self.strained(sense, steps) for sense in (1, 0, -1))
        O.loadTmp("state")
        return (up - rest) / math.log(volume / small), (rest - down) / math.log(large / volume)

    def shares(self):
        """Share of the contacts that carry force in each branch, and the largest force [N]."""
        state = self.law.contacts()
        touching = state.overlap > 0
        force, stiffness = state.force[touching], state.stiffness[touching]
        hertz = (6 * force * state.radius[touching] * state.modulus[touching] ** 2) ** (1 / 3)
        maximum = state.maximum_overlap[touching]
        first = (state.overlap[touching] >= maximum) | np.isnan(maximum)
        bulk = math.pi * state.radius[touching] * YIELD
        yielded = first & np.isclose(stiffness, bulk, rtol=1e-9) & (self.name == "rough-plastic")
        like_hertz = first & ~yielded & (stiffness > hertz * (1 - 1e-6))
        rough = first & ~yielded & ~like_hertz
        open_ = force == 0
        branches = {
            "rough loading": rough,
            "Hertz loading": like_hertz,
            "yielded": yielded,
            "unloading": ~first & ~open_,
            "overlap, no force": open_ & ~first,
        }
        return {name: float(np.mean(chosen)) for name, chosen in branches.items()}, force.size, float(force.max())


def one_law(grains, pressures, name, unloading, options, quick):
    box = Box(grains, name, unloading, options, quick)
    rows = []
    for pressure in pressures:
        settled = box.compress(pressure)
        shares, contacts, largest = box.shares()
        onwards, backwards = box.probe(500 if quick else 1200)
        rows.append((pressure, onwards, backwards, shares, box.loading, contacts))
        note = "" if settled else "  (not settled)"
        stiffnesses = f"onwards {onwards / 1e6:.1f}, backwards {backwards / 1e6:.1f}, while loading {box.loading / 1e6:.1f}"
        print(
            f"  {pressure / 1e3:5.0f} kPa: bulk stiffness {stiffnesses} MPa; {contacts} contacts, "
            f"mean {box.pressure() / 1e3:.2f} kPa, largest force {largest:.0f} N{note}\n        "
            + ", ".join(f"{key} {100 * share:.1f} %" for key, share in shares.items() if share > 0),
            flush=True,
        )
    totals = box.law.totals()
    print(
        f"  {box.steps} steps, {1e3 * box.seconds / box.steps:.3f} ms of CPU time per step; stored {totals.stored:.3g} J, "
        f"dissipated by plasticity {totals.dissipated:.3g} J"
    )
    return rows, box.seconds / box.steps


def exponent(pressures, stiffness):
    return float(np.polyfit(np.log(pressures), np.log(stiffness), 1)[0])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="40 grains, two pressures")
    parser.add_argument("--grains", type=int, help="number of grains (default 500)")
    parser.add_argument("--out", default=".", help="folder of the picture")
    arguments = parser.parse_args()
    pressures = [20e3, 100e3] if arguments.quick else [20e3, 50e3, 100e3, 200e3]
    number = arguments.grains or (40 if arguments.quick else 500)
    grains = deposit(number, np.random.default_rng(2023))
    figure, (left, right) = plt.subplots(1, 2, figsize=(12, 4.8), constrained_layout=True)
    table = []
    for place, (name, unloading, options) in enumerate(LAWS):
        print(f"{name}, {unloading} unloading", flush=True)
        rows, seconds = one_law(grains, pressures, name, unloading, options, arguments.quick)
        onwards, backwards, loading = (np.array([row[n] for row in rows]) for n in (1, 2, 4))
        number = np.array([row[5] for row in rows])
        exponents = [exponent(pressures, k) for k in (onwards, backwards, loading)]
        # a contact bears ~ p/N and contributes ~ B/N: the exponent without the effect of the growing number N of contacts
        exponents.append(exponent(np.array(pressures) / number, onwards / number))
        table.append((f"{name}, {unloading}", *exponents, seconds))
        title = f"{name}, {unloading}: {table[-1][1]:.2f}, {table[-1][2]:.2f}, {table[-1][3]:.2f}"
        (line,) = left.loglog([p / 1e3 for p in pressures], onwards / 1e6, "o-", label=title)
        left.loglog([p / 1e3 for p in pressures], backwards / 1e6, "s--", ms=4, color=line.get_color())
        left.loglog([p / 1e3 for p in pressures], loading / 1e6, "^:", ms=4, color=line.get_color())
        bottom = np.zeros(len(pressures))
        for shade, key in enumerate(rows[0][3]):
            share = np.array([row[3][key] for row in rows])
            x = np.arange(len(pressures)) * (len(LAWS) + 1) + place
            label = key if place == 0 else None
            right.bar(x, 100 * share, bottom=100 * bottom, color=f"C{shade}", label=label, width=0.9)
            bottom += share
    print("exponent n of bulk stiffness ∝ pressure^n, and cost")
    columns = (
        ("onwards", 9),
        ("backwards", 11),
        ("while loading", 15),
        ("per contact", 13),
        ("ms a step", 11),
        ("over Hertz", 12),
    )
    print(f"{'law, unloading':24}" + "".join(f"{name:>{width}}" for name, width in columns))
    for name, onwards, backwards, loading, single, seconds in table:
        cost = f"{1e3 * seconds:11.3f}{seconds / table[0][5]:12.2f}"
        print(f"{name:24}{onwards:9.3f}{backwards:11.3f}{loading:15.3f}{single:13.3f}{cost}")
    print("per contact: onwards, B/N against p/N with N contacts; one contact alone has 0.333 (Hertz), 0.565 (Pohrt-Popov)")
    left.set(
        xlabel="pressure (kPa)", ylabel="bulk stiffness (MPa)", title="probe onwards (—), backwards (- -), while loading (···)"
    )
    left.set_xticks([p / 1e3 for p in pressures], [f"{p / 1e3:.0f}" for p in pressures])
    left.xaxis.set_minor_formatter(matplotlib.ticker.NullFormatter())
    left.yaxis.set_minor_formatter(matplotlib.ticker.ScalarFormatter())
    left.yaxis.set_major_formatter(matplotlib.ticker.ScalarFormatter())
    left.legend(title="law, unloading: exponents", fontsize=7)
    right.set(ylabel="share of contacts (%)", title="branches; laws in the order of the left legend")
    right.set_xticks(np.arange(len(pressures)) * (len(LAWS) + 1) + 1.5, [f"{p / 1e3:.0f} kPa" for p in pressures])
    right.legend(fontsize=7, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    picture = Path(arguments.out) / "ballast.png"
    picture.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(picture, dpi=120)
    print(f"picture: {picture}")


main()
