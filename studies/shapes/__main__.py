"""python -m studies.shapes [--small] [--run] [--only WORD ...]"""

import csv
import functools
import sys
from pathlib import Path

import numpy as np

from demlaws.cli import Parser, execute
from demlaws.files import csv_text
from studies.engines import under_yade

HERE = Path(__file__).parent
# of the vertical stress in unloading [Pa]; not near the turn, where the inertia of the bed carries up to 20 kPa
WINDOWS = ((20e3, 30e3), (30e3, 45e3), (45e3, 65e3))
STRESSES = [0.5 * sum(window) for window in WINDOWS]
EDGE = 0.4e-3  # [m]: granite edges measure 0.3 to 0.6 mm
LARGEST = 0.02  # [m]: principal radii of flat faces count as this
SETUP = {
    "count": 60,
    "seed": 1,
    "cells": 6,  # of the grid of a level set, per largest half-axis
    "nodes": 200,
    "young": 60.6e9,
    "timestep": 1e-5,
    "windows": WINDOWS,
    "ends": (20e3, 100e3),  # vertical stress in a cycle [Pa]
    "cycles": 25,
    "pressures": (20e3, 40e3, 80e3),  # at which a small change of the height is tried
    "strain": 1e-5,
    "repeats": 3,
}
RATES = {"sphere": 2e-6, "clump": 2e-6, "levelset": 6e-6}  # strain per step in a cycle: about 200 steps per half cycle
ROUGH = {"roughness": 5e-6, "fractal_dimension": 2.2, "hardness": 6.266e9}
LAWS = {"hertz": ("hertz", "elastic", None), "rough": ("pohrt-popov", "hertz", ROUGH)}
RADII = {"body": "body", "curvature": {"largest": LARGEST}, "edge": EDGE}
RUNS = [(shape, law, "body") for shape in ("sphere", "clump") for law in LAWS]
RUNS += [("levelset", law, radius) for law in ("rough", "hertz") for radius in ("edge", "body", "curvature")]
FIELDS = ("shape", "law", "radius", "median_radius", "solid", "stiffness", "contacts", "heights", "steps", "seconds")


def run(case, folder, progress, task="measure"):
    """Result of a task for one run; the packing of its shape is made when it is missing."""
    shape, law, radius = case
    packing = Path(folder) / f"{shape}.yade.gz"
    packing.parent.mkdir(parents=True, exist_ok=True)
    given = {**SETUP, "shape": shape, "rate": RATES[shape], "packing": str(packing.resolve())}
    if not packing.exists():
        under_yade("shapes/yade_bed.py", {**given, "task": "prepare"}, progress)
    given.update(zip(("law", "unloading", "surface"), LAWS[law], strict=True), radius=RADII[radius], task=task)
    return under_yade("shapes/yade_bed.py", given, progress)


def add_run(case, folder, path, progress):
    """Run a case and add its row to a file."""
    found = run(case, folder, progress)
    row = {**dict(zip(("shape", "law", "radius"), case, strict=True)), "median_radius": found.pop("radius"), **found}
    for name, value in row.items():
        if isinstance(value, list):
            row[name] = " ".join(f"{v:.7g}" for v in value)
        elif not isinstance(value, str):
            row[name] = f"{value:.5g}"
    fresh = not path.exists()
    with open(path, "a", newline="") as file:
        writer = csv.DictWriter(file, FIELDS)
        if fresh:
            writer.writeheader()
        writer.writerow(row)


def add_small_strain(case, folder, path, progress):
    """Run a case and add its rows: stress [kPa], modulus, its deviation [MPa], contacts per grain, noise [Pa]."""
    found = np.array(run(case, folder, progress, "small")["rows"]) / (1e3, 1e6, 1e6, SETUP["count"], 1.0)
    with open(path, "a") as file:
        file.writelines(f"{','.join([*case, *(f'{value:.3g}' for value in row)])}\n" for row in found)


def read(path):
    """Rows of a file of results; lists are arrays."""
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        row.update((name, np.array(row[name].split(), float)) for name in ("stiffness", "heights"))
        row.update((name, float(row[name])) for name in ("median_radius", "solid", "contacts", "steps", "seconds"))
    return rows


def settlement(row):
    """Strain that stays after each cycle, from the end of the first one [-]."""
    low = row["heights"][2::2]
    return (low[0] - low) / row["heights"][0]


def exponent(row):
    """Exponent of the modulus in stress."""
    return np.polyfit(np.log(STRESSES), np.log(row["stiffness"]), 1)[0]


def table(rows):
    """CSV."""
    titles = ["grains", "law", "R", "median R, mm", f"modulus at {', '.join(f'{p / 1e3:.0f}' for p in STRESSES)} kPa, MPa"]
    titles += ["exponent", "first cycle, %", "cycles 2 to 25, %", "contacts per grain", "ms per step"]
    lines = []
    for row in rows:
        first = (row["heights"][0] - row["heights"][2]) / row["heights"][0]
        values = (
            row["shape"],
            row["law"],
            row["radius"],
            f"{1e3 * row['median_radius']:.3g}",
            ", ".join(f"{k / 1e6:.1f}" for k in row["stiffness"]),
            f"{exponent(row):.2f}",
            f"{100 * first:.3f}",
            f"{100 * settlement(row)[-1]:.3f}",
            f"{row['contacts'] / SETUP['count']:.2f}",
            f"{1e3 * row['seconds'] / row['steps']:.2f}",
        )
        lines.append(values)
    return csv_text(titles, lines)


def picture(rows):
    """Stiffness over pressure and settlement over cycles."""
    from demlaws.plots import figure

    fig, (left, right) = figure(columns=2, width=5.0, height=4.0)
    colours = {"sphere": "#999999", "clump": "#c49a6c", "body": "#1f77b4", "curvature": "#2ca02c", "edge": "#d62728"}
    for row in rows:
        key = row["radius"] if row["shape"] == "levelset" else row["shape"]
        style = {"color": colours[key], "ls": "-" if row["law"] == "rough" else "--"}
        name = f"R = {key}" if row["shape"] == "levelset" else f"{key}s"
        left.loglog(np.array(STRESSES) / 1e3, row["stiffness"] / 1e6, marker="o", label=f"{name}, {row['law']}", **style)
        strain = 100 * settlement(row)
        right.plot(np.arange(1, strain.size + 1), strain, **style)
    left.set(xlabel="vertical stress (kPa)", ylabel="modulus in unloading (MPa)")
    left.set_xticks(np.array(STRESSES) / 1e3, [f"{p / 1e3:.0f}" for p in STRESSES])
    left.set_yticks([25, 50, 100], ["25", "50", "100"])
    left.minorticks_off()
    left.legend(fontsize=7)
    right.set(xlabel="cycle", ylabel="settlement since cycle 1 (%)")
    return fig


def parser():
    """The command line."""
    parser = Parser(
        prog="python -m studies.shapes",
        description="Angular grains, clumps and spheres: stiffness against pressure and settlement in 25 cycles with R = body, "
        "curvature and edge.",
    )
    parser.add_argument("--small", action="store_true", help="instead: moduli at small strain")
    parser.add_argument("--run", action="store_true", help="first run the cases that the file of results does not have (hours)")
    parser.add_argument("--only", nargs="+", default=[], metavar="WORD", help="run only cases whose name has these words")
    parser.add_argument("--results", type=Path, help="file of results (default: angular.csv or small_strain.csv, kept here)")
    parser.add_argument("--packings", default="results/shapes", help="folder of the packings")
    parser.add_argument("--figure", default="results/angular.png", help="file of the picture")
    parser.set_defaults(func=show)
    return parser


def show(options, _):
    """Run the missing cases if asked to, then print the table and draw the picture."""
    path = options.results or HERE / ("small_strain.csv" if options.small else "angular.csv")
    lines = list(csv.reader(path.read_text().splitlines())) if path.exists() else []
    progress = functools.partial(print, flush=True)
    known = {tuple(line[:3]) for line in lines}
    for case in RUNS if options.run else ():
        if case not in known and set(options.only) <= set(case):
            (add_small_strain if options.small else add_run)(case, options.packings, path, progress)
            progress(f"{' '.join(case)} done")
    if options.small:
        titles = "pressure, kPa", "modulus, MPa", "deviation, MPa", "contacts per grain", "noise, Pa"
        print(csv_text(("grains", "law", "R", *titles), csv.reader(path.read_text().splitlines())), end="")
        return
    rows = read(path)
    print(table(rows), end="")
    Path(options.figure).parent.mkdir(parents=True, exist_ok=True)
    picture(rows).savefig(options.figure)


def main(arguments=None):
    """Run the command; returns the exit status."""
    return execute(parser, arguments)


if __name__ == "__main__":
    sys.exit(main())
