"""Settlement, resilient modulus and loss per cycle from the rows of `cycles`: tables and picture."""

from typing import NamedTuple

import numpy as np

from demlaws.laws.names import HERTZ, POHRT_POPOV
from studies.assembly.report import spread
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


def series(rows, least=50, **settings):
    """`Kind` → seed → rows in order of the cycle, of cases with these settings (default: those of `Case`)

    and at least `least` cycles; of two cases of a seed the longer one.
    """
    wanted, found = {name: getattr(Case(), name) for name in ("period", "dt", "count")} | settings, {}
    for row in sorted(rows, key=lambda row: (row["cycles"], row["cycle"])):
        if row["cycles"] >= least and all(row[name] == value for name, value in wanted.items()):
            beds = found.setdefault(Kind(*(row[name] for name in KEY)), {})
            beds.setdefault(int(row["seed"]), {}).setdefault(row["cycles"], []).append(row)
    return {kind: {seed: list(cases.values())[-1] for seed, cases in beds.items()} for kind, beds in found.items()}


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
    rms = [
        float(np.sqrt(np.mean(off**2)) / settled[-1]) for off in (settled - constant - slope * np.log10(number), power(best))
    ]
    return Fit(float(slope), rms[0], float(best), rms[1])


def moduli(rows):
    """Largest pressure [kPa] and resilient modulus [MPa] of the last cycle of each stage."""
    last = {row["high_kPa"]: row for row in rows if row["cycle"] > row["cycles"]}
    found = [
        (row["peak_kPa"], (row["peak_kPa"] - row["least_kPa"]) * row["height_mm"] / row["resilient_um"])
        for row in last.values()
    ]
    return np.array(found).T


def modulus_exponent(rows):
    """n of M ∝ p^n."""
    return float(np.polyfit(*np.log(moduli(rows)), 1)[0])


def settlement(rows, cycle):
    """Settlement [µm] after a cycle (between kept ones by interpolation in log N); NaN beyond the last."""
    number, settled = main_cycles(rows)
    return float(np.interp(np.log(cycle), np.log(number), settled)) if cycle <= number[-1] else np.nan


def loss(rows, first=25, last=50):
    """Loss per cycle over the work of loading, mean of the kept cycles from `first` to `last`."""
    return float(np.mean([row["loss_J"] / row["work_J"] for row in rows if first <= row["cycle"] <= min(last, row["cycles"])]))


COLUMNS = {
    "settled (µm), N = 1": lambda rows: settlement(rows, 1),
    "50": lambda rows: settlement(rows, 50),
    "100": lambda rows: settlement(rows, 100),
    "200": lambda rows: settlement(rows, 200),
    "b (µm)": lambda rows: fit(rows).slope,
    "off (%)": lambda rows: 100.0 * fit(rows).logarithmic,
    "d": lambda rows: fit(rows).exponent,
    "off, % ": lambda rows: 100.0 * fit(rows).power,
    "M (MPa)": lambda rows: moduli(rows)[1][-1],
    "n": modulus_exponent,
    "loss/work, N = 2": lambda rows: loss(rows, 2, 2),
    "25 to 50": loss,
}


def cell(values):
    """Mean ± standard deviation, three digits."""
    mean, deviation = spread(value for value in values if not np.isnan(value))
    if np.isnan(mean):
        return "–"
    digits = max(0, 2 - int(np.floor(np.log10(abs(mean)))))
    return f"{mean:.{digits}f}" + ("" if np.isnan(deviation) else f" ± {deviation:.{digits}f}")


def table(rows, **settings):
    """Text: a line per kind of bed."""
    lines = ["| bed | seeds | " + " | ".join(COLUMNS) + " |", "|---" * (2 + len(COLUMNS)) + "|"]
    for kind, beds in series(rows, **settings).items():
        cells = [cell([function(one) for one in beds.values()]) for function in COLUMNS.values()]
        lines.append(f"| {kind} | {len(beds)} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


BASE = Kind("spheres", HERTZ, 0.0, "default")
ROUGH = BASE._replace(law=POHRT_POPOV, sigma=2.4)
EFFECTS = {
    "law: pohrt-popov, σ = 2.4 µm, for hertz": (BASE, ROUGH),
    "roughness: σ = 10 µm for 2.4 µm": (ROUGH, ROUGH._replace(sigma=10.0)),
    "roughness: σ = 0.5 µm for 2.4 µm": (ROUGH, ROUGH._replace(sigma=0.5)),
    "shear: mindlin for default, hertz": (BASE, BASE._replace(shear="mindlin")),
    "shear: mindlin for default, pohrt-popov": (ROUGH, ROUGH._replace(shear="mindlin")),
    "shear: slip for default, hertz": (BASE, BASE._replace(shear="slip")),
    "shear: slip for default, pohrt-popov": (ROUGH, ROUGH._replace(shear="slip")),
    "shape: clumps for spheres, hertz": (BASE, BASE._replace(grains="clumps")),
    "shape: clumps for spheres, pohrt-popov": (ROUGH, ROUGH._replace(grains="clumps")),
}
MEASURES = {"settlement, 50 cycles": COLUMNS["50"], "M": COLUMNS["M (MPa)"], "n": modulus_exponent, "loss": loss}


def scatter(found, function):
    """Standard deviation between packings over their mean, all kinds with several; NaN without."""
    kinds = [np.array([function(one) for one in beds.values()]) for beds in found.values() if len(beds) > 1]
    freedom = sum(len(values) - 1 for values in kinds)
    return float(np.sqrt(sum(np.sum((values / values.mean() - 1.0) ** 2) for values in kinds) / freedom)) if freedom else np.nan


def effects(rows):
    """Text: changes in percent by law, roughness, shear and shape, marked where they are clear of the scatter."""
    found = series(rows)
    off = {name: scatter(found, function) for name, function in MEASURES.items()}
    lines = ["| change (%) | " + " | ".join(MEASURES) + " |", "|---" * (1 + len(MEASURES)) + "|"]
    for what, (before, after) in EFFECTS.items():
        if before in found and after in found:
            cells = []
            for name, function in MEASURES.items():
                old, new = (np.mean([function(one) for one in found[kind].values()]) for kind in (before, after))
                text = f"{100.0 * (new / old - 1.0):+.0f}"
                cells.append(f"**{text}**" if abs(new / old - 1.0) > 2.0 * off[name] else text)
            lines.append(f"| {what} | " + " | ".join(cells) + " |")
    lines.append("| twice the scatter of packings | " + " | ".join(f"{200.0 * value:.0f}" for value in off.values()) + " |")
    return "\n".join(lines)


def sensitivity(rows):
    """Text: the first cycles of one bed with other settings."""
    lines = ["| settings | settled (µm) | resilient modulus (MPa) | loss over work |", "|---|---|---|---|"]
    for name, case in SENSITIVITY.items():
        chosen = [row for row in rows if all(row[key] == value for key, value in case._asdict().items())]
        if chosen:
            found = main_cycles(chosen)[1][-1], moduli(chosen)[1][-1], loss(chosen, 10, 20)
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
