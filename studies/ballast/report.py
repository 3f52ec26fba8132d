"""Settlement, resilient modulus and loss per cycle from the rows of `cycles`: tables and picture."""

from typing import NamedTuple

import numpy as np

from demlaws.laws import HERTZ, POHRT_POPOV
from studies.assembly.report import spread
from studies.ballast.bed import DENSITY
from studies.ballast.cycles import SENSITIVITY, STAGES, Case

EXPONENTS = np.linspace(0.001, 0.999, 999)
MEAN = 40e-3  # diameter of a mean grain [m]
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


def order(kind):
    """Spheres first, smooth first, then by roughness and shear model."""
    return kind.grains != "spheres", kind.sigma, kind.shear


def series(rows, least=30, **settings):
    """`Kind` → seed → rows in order of the cycle, of cases with these settings (default: those of `Case`)

    and at least `least` cycles; of two cases of a seed the longer one.
    """
    wanted, found = {name: getattr(Case(), name) for name in ("period", "dt", "count")} | settings, {}
    for row in sorted(rows, key=lambda row: (row["cycles"], row["cycle"])):
        if row["cycles"] >= least and all(row[name] == value for name, value in wanted.items()):
            beds = found.setdefault(Kind(*(row[name] for name in KEY)), {})
            beds.setdefault(int(row["seed"]), {}).setdefault(row["cycles"], []).append(row)
    return {
        kind: {seed: list(cases.values())[-1] for seed, cases in sorted(found[kind].items())}
        for kind in sorted(found, key=order)
    }


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

    best = min(EXPONENTS, key=lambda exponent: np.sum(power(exponent) ** 2))
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


def tangent_exponent(rows):
    """m of a tangent modulus ∝ p^m with the strains of the last cycles of all stages, ∝ p^(1-m) - p0^(1-m).

    M has a smaller exponent, because it is a secant from p0 = 20 kPa.
    """
    last = {row["high_kPa"]: row for row in rows if row["cycle"] > row["cycles"]}.values()
    peak, least, strain = (np.array([row[name] for row in last]) for name in ("peak_kPa", "least_kPa", "resilient_um"))
    off = [np.std(np.log((peak ** (1 - m) - least ** (1 - m)) / strain)) for m in EXPONENTS]
    return float(EXPONENTS[np.argmin(off)])


def settlement(rows, cycle):
    """Settlement [µm] after a cycle (between kept ones by interpolation in log N); NaN beyond the last."""
    number, settled = main_cycles(rows)
    return float(np.interp(np.log(cycle), np.log(number), settled)) if cycle <= number[-1] else np.nan


def loss(rows, first=15, last=30):
    """Loss per cycle over the work of loading, mean of the kept cycles from `first` to `last`; NaN without them."""
    chosen = [row["loss_J"] / row["work_J"] for row in rows if first <= row["cycle"] <= min(last, row["cycles"])]
    return float(np.mean(chosen)) if chosen else np.nan


COLUMNS = {
    "settled (µm), N = 1": lambda rows: settlement(rows, 1),
    "30": lambda rows: settlement(rows, 30),
    "100": lambda rows: settlement(rows, 100),
    "200": lambda rows: settlement(rows, 200),
    "a + b log N: b (µm)": lambda rows: fit(rows).slope,
    "off (%)": lambda rows: 100.0 * fit(rows).logarithmic,
    "N^d: d": lambda rows: fit(rows).exponent,
    "off, %": lambda rows: 100.0 * fit(rows).power,
    "M (MPa)": lambda rows: moduli(rows)[1][-1],
    "n": modulus_exponent,
    "m": tangent_exponent,
    "loss/work": loss,
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
    "the same, clumps": (BASE._replace(grains="clumps"), ROUGH._replace(grains="clumps")),
    "roughness: σ = 10 µm for 2.4 µm": (ROUGH, ROUGH._replace(sigma=10.0)),
    "roughness: σ = 0.5 µm for 2.4 µm": (ROUGH, ROUGH._replace(sigma=0.5)),
    "shear: mindlin for default, hertz": (BASE, BASE._replace(shear="mindlin")),
    "shear: mindlin for default, pohrt-popov": (ROUGH, ROUGH._replace(shear="mindlin")),
    "shear: slip for default, hertz": (BASE, BASE._replace(shear="slip")),
    "shear: slip for default, pohrt-popov": (ROUGH, ROUGH._replace(shear="slip")),
    "shape: clumps for spheres, hertz": (BASE, BASE._replace(grains="clumps")),
    "shape: clumps for spheres, pohrt-popov": (ROUGH, ROUGH._replace(grains="clumps")),
}
MEASURES = {
    "settlement, N = 1": lambda rows: settlement(rows, 1),
    "N = 1 to 30": lambda rows: settlement(rows, 30) - settlement(rows, 1),
    "M": COLUMNS["M (MPa)"],
    "n": modulus_exponent,
    "m": tangent_exponent,
    "loss": loss,
}


def scatter(found, function):
    """Standard deviation between packings over their mean, all kinds with several; NaN without."""
    kinds = [np.array([function(one) for one in beds.values()]) for beds in found.values() if len(beds) > 1]
    freedom = sum(len(values) - 1 for values in kinds)
    return float(np.sqrt(sum(np.sum((values / values.mean() - 1.0) ** 2) for values in kinds) / freedom)) if freedom else np.nan


def effects(rows):
    """Text: changes in percent, of the same seeds; bold: more than twice the scatter of packings."""
    found = series(rows)
    off = {name: scatter(found, function) for name, function in MEASURES.items()}
    lines = ["| change (%) | " + " | ".join(MEASURES) + " |", "|---" * (1 + len(MEASURES)) + "|"]
    for what, (before, after) in EFFECTS.items():
        common, cells = found.get(before, {}).keys() & found.get(after, {}).keys(), []
        if common:
            for name, function in MEASURES.items():
                old, new = (np.mean([function(found[kind][seed]) for seed in common]) for kind in (before, after))
                text = f"{100.0 * (new / old - 1.0):+.0f}"
                cells.append(f"**{text}**" if abs(new / old - 1.0) > 2.0 * off[name] else text)
            lines.append(f"| {what} | " + " | ".join(cells) + " |")
    lines.append("| twice the scatter of packings | " + " | ".join(f"{200.0 * value:.0f}" for value in off.values()) + " |")
    return "\n".join(lines)


def secant(rows, cycle):
    """Resilient modulus [MPa] of a cycle between 20 and 200 kPa."""
    (row,) = (row for row in rows if row["cycle"] == cycle)
    return (row["peak_kPa"] - row["least_kPa"]) * row["height_mm"] / row["resilient_um"]


def sensitivity(rows):
    """Text: the first 18 cycles of one bed with other settings."""
    lines = ["| settings | settled (µm), N = 1 | N = 18 | M, N = 18 (MPa) | loss/work, N = 9 to 18 |", "|---|---|---|---|---|"]
    for name, case in SENSITIVITY.items():
        chosen = [row for row in rows if all(row[key] == value for key, value in case._asdict().items())]
        if chosen:
            found = settlement(chosen, 1), settlement(chosen, 18), secant(chosen, 18), loss(chosen, 9, 18)
            lines.append(f"| {name} | " + " | ".join(f"{value:.3g}" for value in found) + " |")
    return "\n".join(lines)


def inertial(rows):
    """Largest inertial number of cycles 2 and later: rate of strain × d √(ρ/p), both amid a swing of the load."""
    return max(
        np.pi
        * row["resilient_um"]
        * 1e-3
        / row["height_mm"]
        / row["period"]
        * MEAN
        * np.sqrt(DENSITY / (500.0 * row["high_kPa"]))
        for row in rows
        if row["cycle"] > 1
    )


def course(rows):
    """Text: inertial number, load carried, time per cycle."""
    carried = [np.median([row[name] for row in rows if row["high_kPa"] == 200.0]) for name in ("least_kPa", "peak_kPa")]
    seconds = [row["seconds"] for row in rows if row["cycle"] > 1]
    text = f"inertial number at most {inertial(rows):.1g}; {np.median(seconds):.2g} s per cycle (median, {min(seconds):.2g} to"
    return f"{text} {max(seconds):.2g}); the plate carries {carried[0]:.0f} to {carried[1]:.0f} kPa (median)"


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
            axes[0].plot(*main_cycles(one), **more, **label)
            axes[1].plot(*moduli(one), marker="o" if n == 0 else ".", ms=3, **more)
            losses = [(r["cycle"], r["loss_J"] / r["work_J"]) for r in one if 1 < r["cycle"] <= r["cycles"]]
            axes[2].plot(*np.array(losses).T, **more)
    pressure = 1e-3 * np.array(STAGES)[[0, -1]]
    for m, style in ((1 / 3, "-"), (0.5, "--")):  # secants of tangent moduli ∝ p^m
        way = np.geomspace(*pressure)
        secant_of = (way - 20.0) / (way ** (1 - m) - 20.0 ** (1 - m))
        axes[1].plot(way, 120.0 * secant_of / secant_of[0], color="0.6", lw=1, ls=style, label=f"secant, tangent ∝ p^{m:.2g}")
    axes[1].legend(fontsize=7)
    axes[0].set(xscale="log", xlabel="cycle", ylabel="settlement (µm)")
    axes[1].set(xscale="log", yscale="log", xlabel="largest pressure (kPa)", ylabel="resilient modulus (MPa)")
    axes[2].set(xscale="log", xlabel="cycle", ylabel="loss over work of a cycle", ylim=(0, None))
    axes[1].set_xticks(1e-3 * np.array(STAGES), [f"{1e-3 * p:g}" for p in STAGES])
    axes[1].set_xticks([], minor=True)
    for form in (axes[1].yaxis.set_major_formatter, axes[1].yaxis.set_minor_formatter):
        form("{x:g}")
    axes[0].set_ylim(0, 1.4 * axes[0].get_ylim()[1])
    axes[0].legend(fontsize=7)
    return fig
