"""The ways of computing the contacts of a scene that are measured against each other, and the granite they are measured on."""

from typing import NamedTuple

from demlaws.contact import GRANITE, GRANITE_YIELD_PRESSURE, Surface
from demlaws.errors import quiet
from demlaws.laws import HERTZ, POHRT_POPOV, RMS, ROUGH_PLASTIC
from demlaws.make import law as bind_law

NAMES = {"yade": "YADE", "liggghts": "LIGGGHTS", "lammps": "LAMMPS"}
ENGINES = tuple(NAMES)
SURFACE = Surface(1.7e-6, 2.22, GRANITE.hardness)
RADII = (3.5e-3, 4.5e-3)
CDM = (GRANITE_YIELD_PRESSURE, 1.4)
"""sigmaMax [Pa] and alpha of YADE's Conical Damage Model: the yield pressure, and the slope that is nearest to RICHEST."""


STONE = {
    "young": GRANITE.young,
    "poisson": GRANITE.poisson,
    "density": GRANITE.density,
    "surface": vars(SURFACE),
    "cdm": CDM,
}
"""The granite as engines' scripts take it."""


class Way(NamedTuple):
    """One way to compute the contacts of a scene."""

    label: str
    law: str = ""  # of ours; "": a model of the engine's own
    unloading: str = "elastic"
    rtol: float = 0.0  # of a table; 0: closed form
    model: str = ""  # the engine's own: "hertz", "cdm", "edinburgh"
    options: tuple = ()  # of the law: (name, value) pairs
    shaken: bool = False

    def bind(self, contact):
        """The law on a contact; the table, where it is one."""
        with quiet():
            law = bind_law(self.law, contact, self.unloading, **dict(self.options))
            return law.tabulate(self.rtol) if self.rtol else law


RICHEST = Way("rough-plastic, thornton", ROUGH_PLASTIC, "thornton", options=(("yield_pressure", GRANITE_YIELD_PRESSURE),))


def ways(engine):
    """The ways of an engine, the richest first. LIGGGHTS and LAMMPS compute tables, of rough-plastic one a pair of sizes."""
    table = 0.0 if engine == "yade" else 1e-5
    tables = [Way(f"pohrt-popov, hertz, table {r:g}", POHRT_POPOV, "hertz", r) for r in (1e-1, 1e-5, 1e-7)]
    own = {
        "yade": [Way("YADE's Hertz-Mindlin", model="hertz"), Way("YADE's Conical Damage Model", model="cdm")],
        "liggghts": [Way("LIGGGHTS's hertz", model="hertz"), Way("LIGGGHTS's edinburgh", model="edinburgh")],
        "lammps": [Way("LAMMPS's hertz/material", model="hertz")],
    }[engine]
    closed = [] if table else [Way("pohrt-popov, hertz", POHRT_POPOV, "hertz")]
    return [
        RICHEST._replace(rtol=table),
        RICHEST._replace(label="the same, shaken", rtol=table, shaken=True),
        RICHEST._replace(label="rough-plastic, hertz", unloading="hertz", rtol=table),
        *closed,
        *tables,
        Way("pohrt-popov, elastic", POHRT_POPOV, "elastic", table),
        Way("rms, hertz", RMS, "hertz", table),
        Way("rms, elastic", RMS, "elastic", table),
        Way("hertz", HERTZ, "elastic", table),
        *own,
    ]
