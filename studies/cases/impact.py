"""The same impact of two granite spheres in Python, YADE, LIGGGHTS and LAMMPS: peak force and rebound speed."""

import math
from pathlib import Path

import demlaws as dl
from studies import engines
from studies.cases import ENGINES, prepared, run_input

DIAMETER, SPEED, STEPS_PER_CONTACT, GAP = 16e-3, 0.2, 40000, 1e-7
MASS = 2650 * math.pi / 6 * DIAMETER**3
LAWS = (
    ("pohrt-popov", "elastic", {}),
    ("pohrt-popov", "hertz", {}),
    ("rough-plastic", "thornton", {"yield_pressure": 0.5e9}),  # soft enough to yield at this speed
)
GRANITE = dl.Material(young=60.6e9, poisson=0.25, hardness=6.266e9)
SURFACE = dl.Surface(roughness=1.7e-6, fractal_dimension=2.22, hardness=6.266e9)


def contact():
    """Contact of the two spheres."""
    sq = {"roughness1": SURFACE.roughness, "roughness2": SURFACE.roughness}
    radii = {"radius1": DIAMETER / 2, "radius2": DIAMETER / 2}
    return dl.Contact.between(GRANITE, GRANITE, **radii, **sq, fractal_dimension=SURFACE.fractal_dimension)


def in_plugin(engine, law, dt, folder):
    """(peak force [N], rebound speed [m/s]) of the case `impact` of an engine."""
    folder = prepared(engine, "impact", Path(folder) / engine)
    (folder / "granite.tbl").unlink()
    law.tabulate(rtol=1e-9).save(folder / "granite.tbl")
    values = {"speed": SPEED, "gap": GAP, "dt": repr(dt), "steps": 4 * STEPS_PER_CONTACT}
    log = run_input(engine, folder / "in.impact", variables=values)
    return log["force"].max(), log[next(name for name in log if name.startswith("speed_no"))][-1]


def compare(folder, laws=LAWS):
    """Rows (law, unloading, engine, peak force [N], rebound [m/s], relative differences from Python)."""
    rows = []
    for name, unloading, options in laws:
        law = dl.law(name, contact(), unloading=unloading, **options)
        impact = dl.driver.impact(law, MASS / 2, SPEED, STEPS_PER_CONTACT)
        dt = impact.duration / impact.time.size
        found = {"Python": (impact.peak_force, impact.rebound_speed)}
        if not engines.available("yade"):
            found["YADE"] = engines.under_yade("cases/yade_impact.py", {"law": [name, unloading, options, dt]})
        for engine in ENGINES:
            if not engines.available(engine):
                found[engine.upper()] = in_plugin(engine, law, dt, folder)
        for engine, (force, speed) in found.items():
            differences = abs(force / impact.peak_force - 1), abs(speed / impact.rebound_speed - 1)
            rows.append((name, unloading, engine, force, speed, *differences))
    return rows


def table(rows):
    """The lines of the table."""
    yield f"{'law':14} {'unloading':10} {'where':9} {'peak force':>12} {'rebound':>12} {'difference from Python':>24}"
    for name, unloading, engine, force, speed, a, b in rows:
        yield f"{name:14} {unloading:10} {engine:9} {force:10.6f} N {speed:8.7f} m/s {a:12.1e} {b:11.1e}"
