"""Settlement, resilient modulus and loss per cycle from the rows of `cycles`: tables and picture."""

from typing import NamedTuple

import numpy as np

from studies.assembly.report import spread
from studies.ballast.bed import PLATE, WIDTH
from studies.ballast.cycles import SENSITIVITY, STAGES, Case

KEY = ("grains", "law", "sigma", "shear")


class Kind(NamedTuple):
    """What the beds of one line of the table share."""

    grains: str
    law: str
    sigma: float
    shear: str

    def __str__(self):
        rough = f", σ = {self.sigma:g} µm" if self.sigma else ""
        return f"{self.grains}, {self.law}{rough}, {self.shear}"


def series(rows, **settings):
    """`Kind` → seed → rows in order of the cycle, of cases with these settings (default: those of `Case`)."""
    wanted = {name: getattr(Case(), name) for name in ("cycles", "period", "dt", "count")} | settings
    found = {}
    for row in sorted(rows, key=lambda row: row["cycle"]):
        if all(row[name] == value for name, value in wanted.items()):
            found.setdefault(Kind(*(row[name] for name in KEY)), {}).setdefault(int(row["seed"]), []).append(row)
    return found


def main_cycles(rows):
    """Number and settlement [µm] of the cycles between 20 and 200 kPa."""
    chosen = [row for row in rows if row["cycle"] <= row["cycles"]]
    return np.array([[row["cycle"], row["settlement_um"]] for row in chosen]).T


class Fit(NamedTuple):
    """s = a + b log10 N and s = c N^d over cycles 2 to the last; rms deviations over the last settlement."""

    slope: float  # b [µm per decade]
    logarithmic: float
    exponent: float  # d
    power: float


def fit(rows):
    """`Fit` of a bed."""
    number, settled = main_cycles(rows)
    number, settled = number[number > 1], settled[number > 1]
    slope, constant = np.polyfit(np.log10(number), settled, 1)

    def power(exponent):
        shape = number**exponent
        return settled - shape * (shape @ settled) / (shape @ shape)

    exponents = np.linspace(0.001, 1.0, 1000)
    best = min(exponents, key=lambda exponent: np.sum(power(exponent) ** 2))
    rms = [float(np.sqrt(np.mean(off**2)) / settled[-1]) for off in (settled - constant - slope * np.log10(number), power(best))]
    return Fit(float(slope), rms[0], float(best), rms[1])


def moduli(rows):
    """Largest pressure [kPa] and resilient modulus [MPa] of the last cycle of each stage."""
    last = {row["high_kPa"]: row for row in rows if row["cycle"] > row["cycles"]}
    found = [
        (row["peak_kPa"], (row["peak_kPa"] - row["least_kPa"]) * row["height_mm"] / row["resilient_um"]) for row in last.values()
    ]
    return np.array(found).T


def modulus_exponent(rows):
    """n of M ∝ p^n."""
    return float(np.polyfit(*np.log(moduli(rows)), 1)[0])


def loss(rows, cycle=None):
    """Loss per cycle over the work of loading, of a cycle (default: the mean of the kept ones of the second half)."""
    chosen = [row for row in rows if row["cycle"] <= row["cycles"]]
    chosen = [row for row in chosen if row["cycle"] == cycle] if cycle else [r for r in chosen if r["cycle"] > 0.5 * r["cycles"]]
    return float(np.mean([row["loss_J"] / row["work_J"] for row in chosen]))


def last_loss(rows):
    """Loss per cycle and volume of bed under the plate [J/m³], mean of the kept cycles of the second half."""
    chosen = [row for row in rows if 0.5 * row["cycles"] < row["cycle"] <= row["cycles"]]
    return float(np.mean([row["loss_J"] / (PLATE * WIDTH * 1e-3 * row["height_mm"]) for row in chosen]))


COLUMNS = {
    "settled, cycle 1 (µm)": lambda rows: main_cycles(rows)[1][0],
    "cycle 200 (µm)": lambda rows: main_cycles(rows)[1][-1],
    "per decade (µm)": lambda rows: fit(rows).slope,
    "a + b log N, off (%)": lambda rows: 100.0 * fit(rows).logarithmic,
    "N^d: d": lambda rows: fit(rows).exponent,
    "off (%)": lambda rows: 100.0 * fit(rows).power,
    "M at 200 kPa (MPa)": lambda rows: moduli(rows)[1][-1],
    "M ∝ p^n: n": modulus_exponent,
    "loss over work, cycle 2": lambda rows: loss(rows, 2),
    "later": loss,
}


def cell(values):
    """Mean ± standard deviation, three digits."""
    mean, deviation = spread(values)
    digits = max(0, 2 - int(np.floor(np.log10(abs(mean)))))
    return f"{mean:.{digits}f}" + ("" if np.isnan(deviation) else f" ± {deviation:.{digits}f}")


def table(rows, **settings):
    """Text: a line per kind of bed."""
    lines = ["| bed | seeds | " + " | ".join(COLUMNS) + " |", "|---" * (2 + len(COLUMNS)) + "|"]
    for kind, beds in series(rows, **settings).items():
        cells = [cell([function(one) for one in beds.values()]) for function in COLUMNS.values()]
        lines.append(f"| {kind} | {len(beds)} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def sensitivity(rows):
    """Text: the first cycles of one bed with other settings."""
    lines = ["| settings | settled (µm) | resilient modulus (MPa) | loss over work |", "|---|---|---|---|"]
    for name, case in SENSITIVITY.items():
        chosen = [row for row in rows if all(row[key] == value for key, value in case._asdict().items())]
        if chosen:
            found = main_cycles(chosen)[1][-1], moduli(chosen)[1][-1], loss(chosen)
            lines.append(f"| {name} | " + " | ".join(f"{value:.3g}" for value in found) + " |")
    return "\n".join(lines)


def draw(rows):
    """Settlement over cycles, resilient modulus over pressure, loss over cycles."""
    from demlaws.plots import figure

    fig, axes = figure(columns=3, width=4.6, height=4.2)
    found = series(rows)
    styles = {"default": "-", "mindlin": "--", "slip": ":"}
    looks = dict.fromkeys((kind.grains, kind.law, kind.sigma) for kind in found)
    colours = {look: f"C{n}" for n, look in enumerate(looks)}
    for kind, beds in found.items():
        for n, one in enumerate(beds.values()):
            more = {"ls": styles[kind.shear], "color": colours[kind[:3]], "lw": 1.6 if n == 0 else 0.6}
            label = {"label": str(kind)} if n == 0 else {}
            axes[0].plot(*main_cycles(one), **more)
            axes[1].plot(*moduli(one), marker="o" if n == 0 else ".", ms=3, **more)
            losses = [(r["cycle"], r["loss_J"] / r["work_J"]) for r in one if 1 < r["cycle"] <= r["cycles"]]
            axes[2].plot(*np.array(losses).T, **more, **label)
    pressure = 1e-3 * np.array(STAGES)[[0, -1]]
    for exponent, style in ((1 / 3, "-"), (0.5, "--")):
        axes[1].plot(pressure, 60 * (pressure / pressure[0]) ** exponent, color="0.6", lw=1, ls=style)
        axes[1].annotate(f"p^{exponent:.2g}", (pressure[1], 60 * (pressure[1] / pressure[0]) ** exponent), fontsize=8)
    axes[0].set(xscale="log", xlabel="cycle", ylabel="settlement (µm)")
    axes[1].set(xscale="log", yscale="log", xlabel="largest pressure (kPa)", ylabel="resilient modulus (MPa)")
    axes[2].set(xscale="log", xlabel="cycle", ylabel="loss over work of a cycle", ylim=(0, None))
    fig.legend(loc="outside lower center", ncols=3, fontsize=8)
    return fig
