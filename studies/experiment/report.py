"""Table and figure of the oedometer runs."""

import numpy as np

from demlaws.errors import DemlawsError
from demlaws.files import csv_text
from studies.experiment.oedometer import CASES, STIFFER, curve_of, measured

LOW, HIGH = 6.78e6, 51.8e6
"""Axial stresses [Pa] between which strains are compared."""
TITLES = ("strain (%)", "unloading (%)", "exponent", "K0", "E needed (GPa)")


def numbers(curve, young=None):
    """Strain on first loading and on unloading [%], exponent of the modulus, radial over axial stress, modulus needed [GPa].

    Modulus needed: at a given stress the strain of smooth elastic grains falls as E^(-2/3) (our derivation: overlap over
    radius is a function of p/E* alone, without resistance to rolling), so that E times (strain over the measured
    strain)^1.5 gives the measured strain.
    """
    test = measured()
    strain = curve.gained(0, LOW, HIGH)
    back = curve.gained(1, float(test.stress[test.turns[2]]), HIGH)
    needed = np.nan if young is None else 1e-9 * young * (strain / test.gained(0, LOW, HIGH)) ** 1.5
    return np.array([100.0 * strain, 100.0 * back, curve.exponent(), curve.stress_ratio(), needed])


def outcomes(rows, count):
    """Label → numbers of each seed, for runs of this many grains."""
    found = {}
    for case in (*CASES, *STIFFER):
        chosen = [row for row in rows if row["count"] == count and row["label"] == case.label]
        if chosen:
            smooth = None if case.roughness or case.rolling else case.young
            found[case.label] = np.array([numbers(curve_of(row), smooth) for row in chosen])
    if not found:
        raise DemlawsError(f"no runs of {count} grains are kept: run python -m studies.experiment --grains {count}")
    return found


def table(rows, count):
    """Mean of the seeds and their standard deviation, as CSV."""
    lines = [["measured", "", *("" if np.isnan(v) else f"{v:.3f}" for v in numbers(measured()))]]
    for label, values in outcomes(rows, count).items():
        mean = values.mean(axis=0)
        spread = values.std(axis=0, ddof=1) if len(values) > 1 else np.full(len(mean), np.nan)
        cells = ["" if np.isnan(m) else f"{m:.3f} ± {s:.3f}" for m, s in zip(mean, spread, strict=True)]
        lines.append([label, len(values), *cells])
    return csv_text(("packing", "seeds", *TITLES), lines)


def porosities(rows, count):
    """Porosity of every run at the start of the test."""
    return np.array([row["rows"][0][3] for row in rows if row["count"] == count])


def figure(rows, count, path):
    """Axial stress over axial strain: the measurement, and each case's seeds."""
    from demlaws.plots import figure as new_figure, save

    fig, ax = new_figure(width=7.5, height=5.5)
    shown = {"tab:blue": 0, "tab:green": 2, "tab:red": 4, "tab:orange": 5, "tab:purple": 6, "tab:cyan": 8}
    for colour, label in ((colour, CASES[number].label) for colour, number in shown.items()):
        chosen = [row for row in rows if row["count"] == count and row["label"] == label]
        for number, row in enumerate(chosen):
            curve = curve_of(row)
            ax.plot(100.0 * curve.strain, 1e-6 * curve.stress, color=colour, lw=0.8, label=None if number else label)
    test = measured()
    ax.plot(100.0 * test.strain, 1e-6 * test.stress, "ko", ms=2.5, label="measured (Cheng et al. 2019)")
    ax.set(xlabel="axial strain (%)", ylabel="axial stress (MPa)", title=f"{count} spheres, E = 70 GPa unless calibrated")
    ax.legend(fontsize=8)
    save(fig, path)
