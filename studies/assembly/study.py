"""Moduli of packings over pressure for laws and roughnesses; a row per state in `moduli.csv`.

Packings of equal spheres in a periodic box are made at 2 kPa with smooth spheres: "dense" without friction, "loose" with it.
With a law they are then compressed from 10 kPa to 1 MPa, with friction, isotropically or along z alone
("oedometric"). Stiffnesses:

- tangent: K of the law's curve, K_t = K_t/K times it; for a wave in elastic asperities
- tenth: the same with a tenth of K_t
- hertz: K of Hertz's law at the same forces, which is rule "hertz" after the first reversal: asperities that stay flattened
- first: a first step of strain under rule "hertz": contacts that close take the law's K, those that open Hertz's
- frozen: tangent, with the contacts at 100 kPa and their forces in proportion to the pressure: no new contacts
"""

import csv
import itertools
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np

import demlaws as dl
from demlaws.errors import quiet
from demlaws.laws import HERTZ, POHRT_POPOV
from studies.assembly.packing import Bead, Packing
from studies.assembly.stiffness import first_loading, moduli, prestress

HERE = Path(__file__).parent
RESULTS = HERE / "moduli.csv"
STORE = Path("results") / "assembly"
GLASS = Bead(1e-3, 70e9, 0.2, 2500.0, 0.3)
GRANITE = Bead(17.4e-3, 60.6e9, 0.25, 2680.0, 0.5)
CLUMPS = "glass clumps"
BEADS = {"glass": GLASS, "granite": GRANITE, CLUMPS: GLASS._replace(clump=True)}
START = 2e3  # [Pa]
PRESSURES = (10e3, 30e3, 100e3, 300e3, 1e6)
FROZEN = 100e3
ROUGH = (0.05, 0.2, 0.5, 2.0)
PACKINGS, PATHS = ("dense", "loose"), ("isotropic", "oedometric")
FIELDS = (
    *("bead", "law", "sigma_um", "dimension", "slope", "packing", "path", "count", "seed", "kPa"),
    *("side_kPa", "solid", "coordination", "sliding", "force_N", "overlap_nm", "prestress", "steps", "seconds"),
    *("M", "G", "B", "M_tenth", "G_tenth", "M_hertz", "G_hertz", "M_first", "G_first", "M_frozen", "G_frozen"),
)


class Series(NamedTuple):
    """A packing with a law, over pressure."""

    bead: str = "glass"
    law: str = HERTZ
    sigma: float = 0.0  # combined roughness [µm]
    dimension: float = 2.2
    slope: float = 0.0  # of the cone tips of goddard [rad]
    packing: str = "dense"
    path: str = "isotropic"
    count: int = 3000
    seed: int = 1

    def bound(self, softness=1.0):
        """The law of a contact."""
        bead = BEADS[self.bead]
        modulus = bead.young / softness / (2.0 * (1.0 - bead.poisson**2))
        contact = dl.Contact(
            radius=bead.diameter / 4, modulus=modulus, sigma=1e-6 * self.sigma, fractal_dimension=self.dimension
        )
        law = dl.law(self.law, contact, "elastic", **({"slope": self.slope} if self.slope else {}))
        return law.tabulate(rtol=1e-5) if self.law == "greenwood-tripp" else law


CORE = (("glass", HERTZ), *(("glass", POHRT_POPOV, sigma) for sigma in ROUGH))
MORE = (
    *(("glass", "rms", sigma) for sigma in ROUGH),
    *(("glass", "greenwood-tripp", sigma) for sigma in (0.2, 0.7, 2.0)),
    *(("glass", "goddard", 0.0, 2.2, slope) for slope in (0.02, 0.1)),
    *(("glass", POHRT_POPOV, 0.5, dimension) for dimension in (2.0, 2.5)),
    ("granite", HERTZ),
    *(("granite", POHRT_POPOV, sigma) for sigma in ROUGH),
)
"""Bead, law, combined roughness [µm], fractal dimension, slope [rad]."""
OF_CLUMPS = ((CLUMPS, HERTZ), *((CLUMPS, POHRT_POPOV, sigma) for sigma in (0.5, 0.2, 2.0)))


def smooth(series):
    """Hertz's law of the same bead."""
    return Series(bead=series.bead).bound()


def start(packing, count, seed, store=STORE, clump=False):
    """Places, size, shear forces, arms of a packing of smooth glass at START, made once and kept in `store`."""
    file = Path(store) / f"{'clumps-' * clump}{packing}-{count}-{seed}.npz"
    if not file.is_file():
        friction = 0.0 if packing == "dense" else GLASS.friction
        found = Packing.loose(GLASS._replace(clump=clump), count, seed, Series().bound(1e3), friction)
        for softness in (1e3, 1e2, 10.0, 1.0):  # hard spheres take too many steps to meet; each step is ten times harder
            found.law = Series().bound(softness)
            slow = {"drag": 0.03, "viscous": 1e-2} if softness == 1e3 else {"drag": 0.05, "viscous": 5e-3}
            found.compress([START] * 3, tolerance=2e-2, balance=1e-2, **slow)
        file.parent.mkdir(parents=True, exist_ok=True)
        parts = {"size": found.size, "pairs": found.pairs, "shear": found.contacts[:, :3], "arms": found.arms}
        np.savez(file, places=found.bodies[0], **parts)
    return np.load(file)


def begin(series, store=STORE):
    """The `Packing` of a series before its first pressure: bodies of its size, closer by the change of the mean overlap."""
    bead = BEADS[series.bead]
    kept = start(series.packing, series.count, series.seed, store, bead.clump)
    scale, law, force = bead.diameter / GLASS.diameter, series.bound(), START * bead.diameter**2
    closer = float(law.overlap(force) - smooth(series).overlap(force)) / bead.diameter
    arms = scale * kept["arms"] if bead.clump else None
    scale *= 1.0 - closer
    packing = Packing(bead, scale * kept["places"], scale * kept["size"], law, bead.friction, arms)
    packing.inherit(kept["pairs"], kept["shear"])
    return packing


def states(series, pressures=PRESSURES, store=STORE, **settings):
    """The packing at each pressure, in balance; settings: of `Packing.compress`."""
    packing = begin(series, store)
    for pressure in pressures:
        yield pressure, packing.compress([pressure] * 3 if series.path == "isotropic" else [0.0, 0.0, pressure], **settings)


def stiffnesses(series, contacts, size, first):
    """Columns of the moduli of one state [Pa]."""
    bead, along = BEADS[series.bead], series.path == "oedometric"
    ratio = bead.shear_ratio

    def both(*args):
        found = moduli(contacts, size, *args)
        return (found.along, found.across, found.bulk) if along else (found.longitudinal, found.shear, found.bulk)

    hertz = smooth(series)
    after = hertz.stiffness(hertz.overlap(contacts.force))
    row = dict(zip(("M", "G", "B"), both(ratio), strict=True))
    row |= dict(zip(("M_tenth", "G_tenth"), both(0.1 * ratio)[:2], strict=True))
    row |= dict(zip(("M_hertz", "G_hertz"), both(ratio, after)[:2], strict=True))
    if first and series.law != HERTZ and not along:
        contacts = contacts._replace(unloading=after)
        pushed, sheared = np.zeros((3, 3)), np.zeros((3, 3))
        pushed[2, 2], sheared[0, 2], sheared[2, 0] = -1.0, 0.5, 0.5
        row["M_first"] = first_loading(contacts, size, ratio, pushed)
        row["G_first"] = first_loading(contacts, size, ratio, sheared)
    return row


def at_ratios(ratios, count, store=STORE):
    """(K_t/K, M, G [Pa]) of rough granite spheres (σ = 2 µm) at 100 kPa, isotropic, for each ratio."""
    series = Series(bead="granite", law="pohrt-popov", sigma=2.0, count=count)
    ((_, packing),) = states(series, (1e5,), store)
    for ratio in ratios:
        found = moduli(packing.carrying(), packing.size, ratio)
        yield ratio, found.longitudinal, found.shear


def frozen(series, law, contacts, size, pressure):
    """M and G with these contacts, their forces in proportion to the pressure."""
    bead, along = BEADS[series.bead], series.path == "oedometric"
    stiffness = law.stiffness(law.overlap(contacts.force * pressure / FROZEN))
    found = moduli(contacts, size, bead.shear_ratio, stiffness)
    return (
        {"M_frozen": found.along, "G_frozen": found.across}
        if along
        else {"M_frozen": found.longitudinal, "G_frozen": found.shear}
    )


def rows(series, pressures=PRESSURES, store=STORE, **settings):
    """A row (dict of FIELDS) per pressure; settings: of `Packing.compress`."""
    found, kept, law = [], None, series.bound()
    for pressure, packing in states(series, pressures, store, **settings):
        began, bead = time.process_time(), BEADS[series.bead]
        contacts = packing.carrying()
        row = dict(zip(FIELDS[:9], series, strict=True)) | {
            "kPa": 1e-3 * pressure,
            "side_kPa": 1e-3 * packing.stress[:2].mean(),
            "solid": packing.solid,
            "coordination": 2.0 * len(contacts.force) / series.count,
            "sliding": float(np.mean(contacts.shear > 0.999)),
            "force_N": float(contacts.force.mean()),
            "overlap_nm": 1e9 * float(law.overlap(contacts.force.mean())),
            "prestress": prestress(contacts, bead.shear_ratio),
            "steps": packing.steps,
        }
        row |= stiffnesses(series, contacts, packing.size, series.seed == 1 and series.packing == "dense")
        if pressure == FROZEN:
            kept = contacts, packing.size.copy()
        found.append(row | {"seconds": time.process_time() - began})
    for row in found:
        if kept:
            row.update(frozen(series, law, *kept, 1e3 * row["kPa"]))
    return found


def wanted(count, seeds):
    """All series, those first that the page needs most."""
    few, two = min(seeds, 3), min(seeds, 2)
    for chosen, last, packing, paths in (
        (CORE, seeds, "dense", PATHS),
        (MORE, 1, "dense", PATHS),
        (CORE, two, "loose", PATHS[::-1]),
        (MORE, two, "dense", PATHS),
        (MORE, 1, "loose", PATHS[::-1]),
        (CORE, seeds, "loose", PATHS),
        (MORE, few, "loose", PATHS),
        (OF_CLUMPS, two, "dense", PATHS),
        (OF_CLUMPS, two, "loose", PATHS),
    ):
        for seed, case, path in itertools.product(range(1, last + 1), chosen, paths):
            yield Series(*case, packing=packing, path=path, count=count, seed=seed)


def read(path=RESULTS):
    """Rows of a file of results, numbers as numbers; [] without the file."""
    if not Path(path).is_file():
        return []

    def value(text):
        try:
            return float(text) if text else np.nan
        except ValueError:
            return text

    with open(path, newline="") as text:
        return [{name: value(cell) for name, cell in row.items()} for row in csv.DictReader(text)]


def append(path, fields, found):
    """Add rows (dicts) to a CSV file, with a head if it is new."""
    new = not Path(path).is_file()
    with open(path, "a", newline="") as file:
        writer = csv.DictWriter(file, fields)
        if new:
            writer.writeheader()
        writer.writerows({k: f"{v:.5g}" if isinstance(v, float) else v for k, v in row.items()} for row in found)


def run(series, path=RESULTS, store=STORE, progress=print):
    """Run the series that `path` lacks; a series is written when it is complete."""
    done = {tuple(row[name] for name in FIELDS[:9]) for row in read(path)}
    for one in dict.fromkeys(series):
        if tuple(one) in done:
            continue
        with quiet():  # rms and greenwood-tripp below the loads for which they were made: the page reports it
            found = rows(one, store=store)
        append(path, FIELDS, found)
        progress(" ".join(map(str, one)))


SENSITIVITY = HERE / "sensitivity.csv"
SETTINGS = {
    "as in the study": {},
    "half the step": {"share": 0.15},
    "half the speed": {"viscous": 2.5e-3},
    "tenfold balance": {"balance": 1e-4, "tolerance": 5e-4},
}


def run_sensitivity(count, path=SENSITIVITY, store=STORE, progress=print):
    """Rows of three series with each of SETTINGS; those that `path` has are not run again."""
    done = {(row["settings"], row["packing"], row["path"]) for row in read(path)}
    for name, settings in SETTINGS.items():
        for packing, way in (("dense", "isotropic"), ("dense", "oedometric"), ("loose", "oedometric")):
            if (name, packing, way) not in done:
                series = Series(law=POHRT_POPOV, sigma=0.5, packing=packing, path=way, count=count, seed=2)
                append(
                    path, ("settings", *FIELDS), [{"settings": name, **row} for row in rows(series, store=store, **settings)]
                )
                progress(f"{name}: {packing} {way}")
