"""Error of a packing's stiffness against the cost of a step, one panel per engine, from the tables of docs/trade.md."""

import re
from pathlib import Path

import matplotlib.pyplot as plt

TEXT = (Path(__file__).parents[1] / "trade.md").read_text().replace("−", "-")
COSTS = {"YADE": "interaction loop", "LIGGGHTS": "step"}
ENGINES = tuple(COSTS)


def rows(heading):
    """First cell and other cells of the first table below a heading."""
    for line in re.search(r"^\|---.*\n((?:\|.*\n)+)", TEXT.split(f"## {heading}\n")[1], re.MULTILINE).group(1).splitlines():
        name, *cells = (cell.strip() for cell in line.strip("| ").split("|"))
        yield name, cells


def errors(cells, engine):
    """Largest error (%) of the stiffnesses in cells like "+49 / +60 %"; the same if there is one engine only."""
    return max(abs(float(re.findall(r"[-+]?[\d.]+", cell)[engine * ("/" in cell)])) for cell in cells)


def only(name):
    """Engines of a row: one if its name ends with "(YADE)" or "(LIGGGHTS)", else both."""
    return [engine for engine in ENGINES if name.endswith(f"({engine})")] or ENGINES


steps = {name: cells[1:] for name, cells in rows("One contact")}
packing = dict(rows("A packing"))
scatter = next(cells for name, cells in packing.items() if name.startswith("random scatter"))
fig, axes = plt.subplots(1, 2, figsize=(9.6, 4.2), sharey=True, layout="constrained")
small = {"fontsize": 8, "textcoords": "offset points", "va": "center"}
for column, (ax, engine) in enumerate(zip(axes, ENGINES, strict=True)):
    ax.axhspan(0.1, errors(scatter, column), color="0.9")
    ax.text(0.98, 0.02, "random scatter: positions perturbed", transform=ax.transAxes, ha="right", color="0.4", fontsize=8)
    for name, cells in packing.items():
        law = name.removesuffix(f" ({engine})")
        if law not in steps or engine not in only(name):
            continue
        best = law == "pohrt-popov, Hertz unloading"
        step, error = float(steps[law][column]), errors(cells, column)
        ax.plot(step, error, "*" if best else "o", ms=16 if best else 7, color="tab:red" if best else "tab:blue")
        place = (-9, 13) if law == "hertz" else (9, 0)
        if step > 1.5:
            place = (-9, 0)
        align = "right" if step > 1.5 else "left"
        ax.annotate(law + (" (recommended)" if best else ""), (step, error), xytext=place, ha=align, **small)
    ax.axvline(1.0, color="0.6", lw=0.8, ls=":")
    ax.set(yscale="log", xlabel=f"time of the {COSTS[engine]} / with the engine's own Hertz", title=engine, ylim=(0.1, 200))
    ax.grid(alpha=0.3)
axes[0].set(ylabel="largest error of the packing's stiffness (%)", xlim=(0.7, 1.1))
axes[1].set(xlim=(0.7, 2.5))
fig.savefig("trade.png", dpi=130)
