"""Bytes kept for one contact: by a particle, from restart files of two spheres that touch or do not; by the law in YADE."""

import tempfile
from pathlib import Path

from demlaws.make import example
from demlaws.yade.run import run as run_in_yade
from studies.shear.gas import CONTACT, DIAMETER, ENGINES, HEADS, LIGGGHTS

START = """\
region box block -0.03 0.03 -0.03 0.03 -0.03 0.03 units box
create_box 1 box
create_atoms 1 single 0 0 0 units box
create_atoms 1 single {distance} 0 0 units box
set group all diameter {diameter} density 2650
neighbor 0.002 bin
{model}
timestep 1e-7
fix integr all nve/sphere
run 2
write_restart now.restart
"""
MODELS = {
    "liggghts": {
        "stock hertz, history": "hertz tangential history",
        "elastic law, history": "demlaws/table tangential history table elastic.tbl",
        "Hertz unloading, history": "demlaws/table tangential history table hertz.tbl",
        "elastic law, demlaws": "demlaws/table tangential demlaws table elastic.tbl",
        "Hertz unloading, demlaws": "demlaws/table tangential demlaws table hertz.tbl",
        "elastic law, slip": "demlaws/table tangential demlaws table elastic.tbl shear slip",
        "Hertz unloading, slip": "demlaws/table tangential demlaws table hertz.tbl shear slip",
    },
    "lammps": {
        "stock hertz, mindlin": "hertz/material 60.6e9 0.5 0.25 tangential mindlin NULL 1 0.5",
        "any law, mindlin_rescale/force": "demlaws/table hertz.tbl 60.6e9 0.5 0.25 tangential mindlin_rescale/force NULL 1 0.5",
        "any law, demlaws": "demlaws/table hertz.tbl 60.6e9 0.5 0.25 tangential demlaws 1 0.5",
        "any law, slip": "demlaws/table hertz.tbl 60.6e9 0.5 0.25 shear slip tangential demlaws 1 0.5",
    },
}

YADE = """\
import demlaws as dl
from demlaws.yade import Law2_ScGeom_MindlinPhys_Demlaws
from demlaws.yade.layout import ROW_WORDS
surface = {"granite": dl.Surface(2.4e-6, 2.22)}
laws = ("Hertz", "hertz", "elastic"), ("elastic law", "pohrt-popov", "elastic"), ("Hertz unloading", "pohrt-popov", "hertz")
for name, law, rule in laws:
    for shear in "elastic", "slip":
        functor = Law2_ScGeom_MindlinPhys_Demlaws(law, rule, surface, shear=shear, bridge="native")
        print(f"ROW {name}, shear {shear}: {8 * functor.binding.attachment.context.words[ROW_WORDS]}", flush=True)
"""


def bytes_in_yade():
    """Rows (engine, model, bytes): the row of a contact in the law's memory, beside YADE's own objects."""
    with tempfile.TemporaryDirectory() as name:
        script = Path(name) / "rows.py"
        script.write_text(YADE)
        for line in run_in_yade(script, capture_output=True, text=True).stdout.splitlines():
            if line.startswith("ROW "):
                model, _, size = line.removeprefix("ROW ").rpartition(": ")
                yield "yade", model, int(size)


def bytes_per_contact():
    """Rows (engine, model, bytes)."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for rule in ("elastic", "hertz"):
            example("pohrt-popov", CONTACT, rule).tabulate().save(folder / f"{rule}.tbl")
        for engine, models in MODELS.items():
            for label, words in models.items():
                model = f"pair_style granular\npair_coeff * * {words} damping viscoelastic"
                if engine == "liggghts":
                    model = LIGGGHTS.format(poisson=0.25, friction=0.5, pair=words)
                sizes = []
                for distance in (DIAMETER - 1e-6, DIAMETER + 1e-6):
                    text = HEADS[engine] + START.format(model=model, distance=distance, diameter=DIAMETER)
                    (folder / "in.pair").write_text(text)
                    ENGINES[engine].run(folder / "in.pair")
                    sizes.append((folder / "now.restart").stat().st_size)
                yield engine, label, (sizes[0] - sizes[1]) // 2
