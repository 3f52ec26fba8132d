"""Tables and picture of the rows of `runs`: means over the seeds, and changes paired by seed with 95 % intervals."""

from operator import itemgetter

import numpy as np

from studies.grading.scenes import MODELS
from studies.paired import interval

LOOKS = {
    "stock": ("#de2d26", "mindlin of LAMMPS"),
    "before": ("#fb9a66", "demlaws, lever of the full step"),
    "stock synchronized": ("#9ecae1", "mindlin, synchronized_verlet"),
    "after": ("k", "demlaws, lever of the half step"),
}
"""Colour and label of a model."""
MAIN = 0.25
"""Step over the Rayleigh time of the main runs."""
HEAP_TITLES = (
    *("ratio", "step over Rayleigh time", "model", "seeds", "fines"),
    *("hang in the bed (%)", "change to after", "hang in the heap (%)", "slope (degrees)", "change to after"),
    *("large grains left", "cost of a step, after over this"),
)
OEDOMETER_TITLES = (
    *("model", "seeds", "height (mm)", "settlement in cycle 1 (um)", "change to after"),
    *("settlement in cycles 2 to 20 (um)", "change to after", "cost of a step, after over this"),
)


def groups(rows, *names):
    """{values of these columns: {model: {seed: row}}}."""
    found = {}
    for row in rows:
        found.setdefault(tuple(row[n] for n in names), {}).setdefault(row["model"], {})[int(row["seed"])] = row
    return dict(sorted(found.items()))


def difference(models, model, value, of="after"):
    """Mean of value(row) of `of` less that of `model` over the seeds of both, text with its 95 % interval."""
    seeds = sorted(models.get(of, {}).keys() & models.get(model, {}).keys())
    if model == of or not seeds:
        return ""
    found = interval([value(models[of][s]) - value(models[model][s]) for s in seeds])
    return f"{found.mean:.3g}" if np.isnan(found.low) else f"{found.mean:.3g} ({found.low:.3g} to {found.high:.3g})"


def cost(models, model, of="after"):
    """CPU time of a step of `of` over that of `model`: geometric mean over the seeds of both."""
    seeds = sorted(models.get(of, {}).keys() & models.get(model, {}).keys())
    if model == of or not seeds:
        return ""
    return f"{np.exp(np.mean([np.log(models[of][s]['us_step'] / models[model][s]['us_step']) for s in seeds])):.2f}"


def hang(row, stage="bed"):
    """Per cent of the fines that hang."""
    return 100 * row[f"hang_{stage}"] / row["fines"]


def heap_table(rows):
    """Rows of HEAP_TITLES."""
    lines = []
    for (ratio, share), models in groups(rows, "ratio", "share").items():
        for model in MODELS:
            found = list(models.get(model, {}).values())
            if not found:
                continue
            lines.append(
                [
                    *(f"{ratio:g}", f"{share:g}", model, len(found), f"{found[0]['fines']:g}"),
                    *(f"{np.mean([hang(row) for row in found]):.2f}", difference(models, model, hang)),
                    f"{np.mean([hang(row, 'heap') for row in found]):.2f}",
                    *(f"{np.mean([row['angle'] for row in found]):.1f}", difference(models, model, itemgetter("angle"))),
                    *(f"{np.mean([row['large_heap'] for row in found]):.1f}", cost(models, model)),
                ]
            )
    return lines


def oedometer_table(rows):
    """Rows of OEDOMETER_TITLES; changes from each model to "after"."""
    lines = []
    for models in groups(rows, "ratio").values():
        for model in MODELS:
            found = list(models.get(model, {}).values())
            if not found:
                continue
            numbers = [f"{np.mean([row['height_mm'] for row in found]):.1f}"]
            for name in ("first_um", "later_um"):
                numbers += [f"{np.mean([row[name] for row in found]):.0f}", difference(models, model, itemgetter(name))]
            lines.append([model, len(found), *numbers, cost(models, model)])
    return lines


def draw(heaps, oedometers):
    """Fines that hang in the bed over the ratio of sizes, and settlement of the oedometer, of each seed and their mean."""
    from demlaws.plots import figure

    fig, (left, right) = figure(columns=2, width=5.0, height=3.8)
    main = [row for row in heaps if row["share"] == MAIN]
    ratios = sorted({row["ratio"] for row in main})
    for place, (model, (colour, label)) in enumerate(LOOKS.items()):
        aside = 0.17 * (place - 1.5)
        means = []
        for column, ratio in enumerate(ratios):
            shares = [hang(r) for r in main if r["model"] == model and r["ratio"] == ratio]
            left.plot(np.full(len(shares), column + aside), shares, "o", ms=3, color=colour)
            means.append((column + aside, np.mean(shares)) if shares else (np.nan, np.nan))
        places, heights = np.array(means).T
        left.bar(places, heights, width=0.16, color=colour, alpha=0.45, label=label)
        settled = np.array([[r["first_um"], r["later_um"]] for r in oedometers if r["model"] == model])
        for column, values in enumerate(settled.T):
            right.plot(np.full(len(values), column + aside), values, "o", ms=3, color=colour)
        right.bar(np.arange(2) + aside, settled.mean(axis=0), width=0.16, color=colour, alpha=0.45)
    left.set_xticks(range(len(ratios)), [f"1:{ratio:g}" for ratio in ratios])
    left.set(xlabel="ratio of diameters", ylabel="fines that hang (%)", title="fines poured on a bed of large grains")
    left.legend(fontsize=8, loc="upper left")
    right.set_xticks(range(2), ["first cycle", "cycles 2 to 20"])
    right.set(ylabel="settlement (µm)", title="oedometer, 10 % of fines, 5 to 50 kPa")
    return fig
