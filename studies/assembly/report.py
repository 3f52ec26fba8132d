"""Exponents over pressure from the rows of `study`: tables and picture."""

from typing import NamedTuple

import numpy as np

from demlaws.files import csv_text, save_csv
from demlaws.laws import HERTZ, POHRT_POPOV

ALL, LOW = (10.0, 1000.0), (10.0, 100.0)
"""Ranges of pressure [kPa]."""
MEASURED = {"G0": 0.5, "c_L": 0.3817, "c_T": 0.2809, "ratio": 1.6}
ALLOWED = {"G0": (0.45, 0.55), "ratio": (1.5, 1.7)}
"""Of the numbers given as "around" (see the criteria in docs/validation/small-strain.md)."""
KINDS = {
    "G": "tangent",
    "G_tenth": "K_t/10",
    "G_hertz": "after reversal",
    "G_first": "first step",
    "G_frozen": "frozen contacts",
}


class Case(NamedTuple):
    """What the packings of one line of the table share."""

    bead: str
    law: str
    sigma_um: float
    dimension: float
    slope: float
    packing: str
    count: float


def cases(rows):
    """`Case` → (path, seed) → rows in order of the pressure; cases by bead, law and roughness."""
    found, order = {}, list(dict.fromkeys(row["law"] for row in rows))
    for row in sorted(rows, key=lambda row: row["kPa"]):
        case = Case(*(row[name] for name in Case._fields))
        found.setdefault(case, {}).setdefault((row["path"], int(row["seed"])), []).append(row)
    return dict(sorted(found.items(), key=lambda item: (item[0].bead, item[0].packing, order.index(item[0].law), item[0][2:])))


def exponent(rows, column, span=ALL, speed=False):
    """Exponent of a modulus over pressure, or of the wave speed that belongs to it."""
    chosen = [row for row in rows if span[0] <= row["kPa"] <= span[1]]
    value = np.array([row[column] / (row["solid"] if speed else 1.0) for row in chosen])
    return float(np.polyfit(np.log([row["kPa"] for row in chosen]), np.log(value), 1)[0]) * (0.5 if speed else 1.0)


def spread(values):
    """Mean and standard deviation of the seeds (NaN for one)."""
    values = np.array(list(values))
    return (float(values.mean()) if len(values) else np.nan), (float(values.std(ddof=1)) if len(values) > 1 else np.nan)


def speeds(series, suffix=""):
    """Name → (mean, standard deviation) of the exponents of c_L and c_T and of c_L/c_T, oedometric, 10 to 100 kPa."""
    chosen = [rows for (path, _), rows in series.items() if path == "oedometric"]
    ratio = [
        np.mean([np.sqrt(row["M" + suffix] / row["G" + suffix]) for row in rows if row["kPa"] <= LOW[1]]) for rows in chosen
    ]
    return {
        "c_L": spread(exponent(rows, "M" + suffix, LOW, True) for rows in chosen),
        "c_T": spread(exponent(rows, "G" + suffix, LOW, True) for rows in chosen),
        "ratio": spread(ratio),
    }


def exponents(series, span=ALL):
    """Kind of stiffness → (mean, standard deviation) of the exponent of G0, isotropic."""
    chosen = [rows for (path, _), rows in series.items() if path == "isotropic"]
    found = {column: spread(exponent(rows, column, span) for rows in chosen) for column in KINDS if column != "G_first"}
    first = [rows for rows in chosen if not np.isnan(rows[0]["G_first"])]
    return found | {"G_first": spread(exponent(rows, "G_first", span) for rows in first)}


def cell(value):
    """Mean ± standard deviation."""
    mean, deviation = value
    if np.isnan(mean):
        return "–"
    return f"{mean:.3f}" + ("" if np.isnan(deviation) else f" ± {deviation:.3f}")


def name(case):
    """Law and roughness of a case."""
    rough = f", σ = {case.sigma_um:g} µm" if case.sigma_um else ""
    dimension = f", Df = {case.dimension:g}" if case.law == POHRT_POPOV and case.dimension != 2.2 else ""
    slope = f", slope {case.slope:g}" if case.slope else ""
    return f"{case.law}{rough}{dimension}{slope}"


SHOWN = (
    *(("glass", HERTZ, 0.0, packing) for packing in ("dense", "loose")),
    *(("glass", POHRT_POPOV, sigma, "dense") for sigma in (0.05, 0.5)),
    ("glass", POHRT_POPOV, 0.5, "loose"),
    *(("glass", "greenwood-tripp", sigma, "dense") for sigma in (0.2, 0.7)),
    ("glass clumps", HERTZ, 0.0, "dense"),
    ("glass clumps", HERTZ, 0.0, "loose"),
    ("glass clumps", POHRT_POPOV, 0.5, "dense"),
)
"""Bead, law, σ [µm] and packing of the lines of the table of the page; the CSV file has all."""
SPEEDS = {"c_L": "c_L", "c_T": "c_T", "ratio": "c_L/c_T"}


def numbers(series):
    """Heading → (mean, standard deviation) of all exponents and of c_L/c_T of a case, as far as it has the packings."""
    paths, found = {path for path, _ in series}, {}
    if "isotropic" in paths:
        values = exponents(series)
        found |= {f"G0, {kind}": values[column] for column, kind in KINDS.items()}
    if "oedometric" in paths:
        for suffix, kind in (("", "tangent"), ("_tenth", "K_t/10"), ("_hertz", "after reversal")):
            found |= {f"{SPEEDS[key]}, {kind}": value for key, value in speeds(series, suffix).items()}
    return found


def seeds(series):
    """Number of packings."""
    return len({seed for _, seed in series})


def table(rows):
    """Text: exponents of G0 and of wave speeds, of the cases of SHOWN."""
    names = ["G0, tangent", "G0, after reversal", "G0, frozen contacts", *(f"{name}, tangent" for name in SPEEDS.values())]
    names += [f"{name}, after reversal" for name in ("c_L", "c_T")]
    lines = ["| bead, law | packing | seeds | " + " | ".join(names) + " |", "|---" * (3 + len(names)) + "|"]
    for case, series in cases(rows).items():
        if (case.bead, case.law, case.sigma_um, case.packing) in SHOWN and case.dimension == 2.2:
            found = numbers(series)
            cells = " | ".join(cell(found.get(name, (np.nan, np.nan))) for name in names)
            lines.append(f"| {case.bead}, {name(case)} | {case.packing} | {seeds(series)} | {cells} |")
    return "\n".join(lines)


def save(rows, path):
    """Write the exponents of all cases, mean and standard deviation, to a CSV file; its path."""
    found = {case: numbers(series) for case, series in cases(rows).items()}
    names = list(dict.fromkeys(name for values in found.values() for name in values))
    lines = []
    for case, series in cases(rows).items():
        values = (value for name in names for value in found[case].get(name, (np.nan, np.nan)))
        written = (f"{value:.4f}".replace("nan", "") for value in values)
        steps = max(some[-1]["steps"] for some in series.values())
        lines.append([*map(str, case[:-1]), int(case.count), seeds(series), *written, f"{steps:.0f}"])
    return save_csv(
        path, [*Case._fields, "seeds", *(f"{name}{end}" for name in names for end in ("", " ±")), "most steps"], lines
    )


def sensitivity(rows):
    """CSV text: exponents of one packing with other settings of the compression."""
    titles, lines = ("settings", "packing, path", "exponent of M", "of G", "G at 100 kPa (MPa)", "steps"), []
    for key in dict.fromkeys((row["settings"], row["packing"], row["path"]) for row in rows):
        chosen = [row for row in rows if (row["settings"], row["packing"], row["path"]) == key]
        shear = next(1e-6 * row["G"] for row in chosen if row["kPa"] == LOW[1])
        exponents = (f"{exponent(chosen, column):.4f}" for column in "MG")
        lines.append([key[0], f"{key[1]}, {key[2]}", *exponents, f"{shear:.2f}", f"{chosen[-1]['steps']:.0f}"])
    return csv_text(titles, lines)


def local(series, column, path):
    """σ/δ and exponent between neighbouring pressures, means of the seeds; δ is the overlap at the mean force."""
    chosen = [rows for (p, _), rows in series.items() if p == path]
    if not chosen:
        return np.zeros(0), np.zeros(0)
    x, y = [], []
    for rows in chosen:
        overlap, value = (np.log([row[name] for row in rows]) for name in ("overlap_nm", column))
        pressure = np.log([row["kPa"] for row in rows])
        x.append(np.log(1e3 * rows[0]["sigma_um"] or 1.0) - 0.5 * (overlap[1:] + overlap[:-1]))
        y.append(np.diff(value) / np.diff(pressure))
    return np.exp(np.mean(x, axis=0)), np.mean(y, axis=0)


MARKS = {
    ("glass", "dense"): "o",
    ("glass", "loose"): "s",
    ("granite", "dense"): "^",
    ("granite", "loose"): "v",
    ("glass clumps", "dense"): "D",
    ("glass clumps", "loose"): "P",
}
PANELS = (
    ("G", "isotropic", "G0, isotropic, between neighbouring pressures"),
    ("G", "oedometric", "G = ρ c_T², oedometric"),
    ("M", "oedometric", "M = ρ c_L², oedometric"),
)


def one_contact(law, sigma=1.0):
    """σ/δ and the exponent d ln K/d ln P of one contact of glass."""
    from demlaws.errors import quiet
    from studies.assembly.study import Series

    with quiet():
        bound = Series(law=law, sigma=sigma).bound()
        force = np.geomspace(1e-3, 50.0, 200)
        overlap = bound.overlap(force)
        return 1e-6 * sigma / overlap, np.gradient(np.log(bound.stiffness(overlap)), np.log(force))


def draw(rows):
    """Local exponents of G0 (isotropic), and of M and G along the load (oedometric), over σ/δ."""
    from demlaws.plots import colour, figure

    fig, axes = figure(rows=3, width=6.4, height=3.9)
    found = cases(rows)
    laws = dict.fromkeys(case.law for case in found if case.sigma_um)
    for ax, (column, path, title) in zip(axes, PANELS, strict=True):
        for law in laws:
            x, y = one_contact(law)
            there = [local(series, column, path)[0].max(initial=0.0) for case, series in found.items() if case.law == law]
            ax.plot(x[x < max(there)], y[x < max(there)], color=colour(law), lw=1, label=f"{law}, one contact")
        for case, series in found.items():
            x, y = local(series, column, path)
            if case.law == HERTZ:
                style = "-" if case.packing == "dense" else "--"
                if case.bead == "glass" and len(y):
                    ax.axhline(y.mean(), color="0.5", lw=1, ls=style, label=f"hertz, {case.packing} packing")
            elif case.dimension == 2.2 and case.sigma_um:
                mark = MARKS[case.bead, case.packing]
                ax.plot(x, y, mark, ms=4.5, mfc="none", color=colour(case.law))
        ax.set(xscale="log", ylabel="exponent", title=title, xlim=(0.03, 10.0), ylim=(0.28, 1.0))
    for (bead, packing), mark in MARKS.items():
        if any((case.bead, case.packing) == (bead, packing) for case in found):
            axes[1].plot([], [], mark, ms=4.5, mfc="none", color="k", label=f"{bead}, {packing} packing")
    axes[0].axhspan(*ALLOWED["G0"], color="k", alpha=0.08, lw=0)
    place = {"xycoords": ("axes fraction", "data"), "fontsize": 9}
    axes[0].annotate("measured: around 0.5", (0.01, 0.5), va="center", **place)
    for ax, speed in ((axes[1], "c_T"), (axes[2], "c_L")):
        ax.axhline(2.0 * MEASURED[speed], color="k", lw=0.8, ls=":")
        text = f"measured: 2 × {MEASURED[speed]}"
        ax.annotate(text, (0.01, 2.0 * MEASURED[speed]), va="bottom", **place)
    axes[-1].set(xlabel="σ/δ, δ: overlap at the mean force")
    for ax in axes[:2]:
        handles, labels = ax.get_legend_handles_labels()
        kept = [n for n, label in enumerate(labels) if (" packing" in label and "hertz" not in label) == (ax is axes[1])]
        ax.legend([handles[n] for n in kept], [labels[n] for n in kept], fontsize=8.5, loc="upper left")
    return fig
