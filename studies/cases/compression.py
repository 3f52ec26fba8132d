"""Stress against strain of the case `compression` for Hertz, Pohrt–Popov and rough-plastic contacts, and stock hertz."""

import numpy as np

import demlaws as dl
from studies.cases import prepared, run_input

GRANITE = dl.Material(young=60.6e9, poisson=0.25, hardness=6.266e9)
RADIUS = 4e-3
LAWS = {
    "hertz": {},
    "pohrt-popov": {"unloading": "hertz"},
    "rough-plastic": {"unloading": "thornton", "yield_pressure": 1.66e9, "loading": "pohrt-popov"},
}
QUICK = {"count": 120, "close": 120000}
PARTS = np.array([0.25, 0.5, 0.75, 1.0])


def tables(folder, name):
    """Write the tables of a law; returns the words of the pair style that name them."""
    for kind, other in (("pair", RADIUS), ("wall", np.inf)):
        surface = {"roughness1": 1.7e-6, "roughness2": 1.7e-6, "fractal_dimension": 2.22}
        contact = dl.Contact.between(GRANITE, GRANITE, radius1=RADIUS, radius2=other, **surface)
        dl.law(name, contact, **LAWS[name]).tabulate().save(folder / f"{name}.{kind}.tbl")
    return f"table {name}.pair.tbl pairtable 1 2 {name}.wall.tbl pairtable 2 2 {name}.wall.tbl"


class Curve:
    """Loading and unloading of one law."""

    def __init__(self, log):
        self.log, self.strain, self.stress = log, log["strain"], np.abs(log["plate_st"])
        self.turn = int(np.argmax(self.strain))
        self.peak = self.stress[self.turn]
        self.stresses = np.interp(PARTS * self.strain.max(), self.strain[: self.turn + 1], self.stress[: self.turn + 1])
        self.exponent = np.log(self.stresses[3] / self.stresses[1]) / np.log(2)
        # unloading against loading at 5 % of the peak stress
        low = 0.05 * self.peak
        unloaded = np.interp(-low, -self.stress[self.turn :], self.strain[self.turn :])
        self.permanent = float(unloaded - self.strain[np.argmax(self.stress > low)])
        work = 0.5 * (self.stress[1:] + self.stress[:-1]) * np.diff(self.strain)
        self.loop = work.sum() / work[: self.turn].sum()


def curves(folder, quick=False):
    """{law: `Curve`}, also of stock hertz."""
    folder = prepared("liggghts", "compression", folder)
    run_input("liggghts", folder / "in.prepare", variables=QUICK if quick else {}, plugin=False)
    values = {"down": 8000, "up": 9600} if quick else {}
    given = {name: {"tables": tables(folder, name)} for name in LAWS}
    given["stock"] = {"model": "hertz", "tables": "tangential_damping on"}
    script = folder / "in.compression"
    return {
        name: Curve(run_input("liggghts", script, variables=values | more, log=f"log.{name}", plugin=name != "stock"))
        for name, more in given.items()
    }


def table(found):
    """The lines of the table."""
    columns = "".join(f"{100 * strain:8.3f}%" for strain in PARTS * found["hertz"].strain.max())
    yield f"{'plate stress [MPa] at':22}{columns}  exponent  permanent strain  loop, of the work"
    for name, curve in found.items():
        values = "".join(f"{stress / 1e6:9.3f}" for stress in curve.stresses)
        yield f"{name:22}{values}{curve.exponent:10.3f}{100 * curve.permanent:17.4f}%{curve.loop:18.3f}"


def rows(found):
    """Head and rows of the curves: law, strain, stress [Pa]."""
    yield "law", "strain", "stress (Pa)"
    for name in LAWS:
        for strain, stress in zip(found[name].strain, found[name].stress, strict=True):
            yield name, f"{strain:.6g}", f"{stress:.5g}"
