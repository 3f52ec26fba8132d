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
    *("ratio", "step over Rayleigh time", "model", "runs"),
    *("hang in the bed (%)", "change to after", "hang in the heap (%)", "slope (degrees)", "change to after"),
    *("large grains left", "cost of a step: after over this"),
)
OEDOMETER_TITLES = (
    *("model", "seeds", "height (mm)", "settlement in cycle 1 (um)", "change to after"),
    *("settlement in cycles 2 to 20 (um)", "change to after", "cost of a step: after over this"),
)


def groups(rows, *names):
    """{values of these columns: {model: {(ratio, seed): row}}}."""
    found = {}
    for row in rows:
        found.setdefault(tuple(row[n] for n in names), {}).setdefault(row["model"], {})[row["ratio"], row["seed"]] = row
    return dict(sorted(found.items()))


def difference(models, model, value, of="after"):
    """Mean of value(row) of `of` less that of `model` over the pairs of both, text with its 95 % interval."""
    seeds = sorted(models.get(of, {}).keys() & models.get(model, {}).keys())
    if model == of or not seeds:
        return ""
    found = interval([value(models[of][s]) - value(models[model][s]) for s in seeds])
    return f"{found.mean:.3g}" if np.isnan(found.low) else f"{found.mean:.3g} ({found.low:.3g} to {found.high:.3g})"


def cost(models, model, of="after"):
    """CPU time of a step of `of` over that of `model`: geometric mean over the pairs of both."""
    seeds = sorted(models.get(of, {}).keys() & models.get(model, {}).keys())
    if model == of or not seeds:
        return ""
    return f"{np.exp(np.mean([np.log(models[of][s]['us_step'] / models[model][s]['us_step']) for s in seeds])):.2f}"


def hang(row, stage="bed"):
    """Per cent of the fines that hang."""
    return 100 * row[f"hang_{stage}"] / row["fines"]


def heap_table(rows):
    """Rows of HEAP_TITLES; last those of all ratios together, in which each bed and ratio is a pair."""
    cases = {**groups(rows, "ratio", "share"), **{("all", share): models for (share,), models in groups(rows, "share").items()}}
    return [
        [
            *(ratio if ratio == "all" else f"{ratio:g}", f"{share:g}", model, len(found)),
            *(f"{np.mean([hang(row) for row in found]):.2f}", difference(models, model, hang)),
            f"{np.mean([hang(row, 'heap') for row in found]):.2f}",
            *(f"{np.mean([row['angle'] for row in found]):.1f}", difference(models, model, itemgetter("angle"))),
            *(f"{np.mean([row['large_heap'] for row in found]):.1f}", cost(models, model)),
        ]
        for (ratio, share), models in cases.items()
        for model in MODELS
        if (found := list(models.get(model, {}).values()))
    ]


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


def draw(rows):
    """Fines that hang in the bed and slope of the heap over the ratio of sizes: each seed, and the mean of several."""
    from demlaws.plots import figure

    fig, axes = figure(columns=2, width=5.0, height=3.8)
    main = [row for row in rows if row["share"] == MAIN]
    ratios = sorted({row["ratio"] for row in main})
    drawn = [model for model in LOOKS if sum(row["model"] == model for row in main) > 1]
    for ax, value in zip(axes, (hang, itemgetter("angle")), strict=True):
        for place, model in enumerate(drawn):
            colour, label = LOOKS[model]
            for column, ratio in enumerate(ratios):
                values = [value(row) for row in main if row["model"] == model and row["ratio"] == ratio]
                if len(values) > 1:
                    x = column + 0.22 * (place - 0.5 * (len(drawn) - 1))
                    ax.bar(x, np.mean(values), width=0.2, color=colour, alpha=0.45, label=label if ratio == 20 else None)
                    ax.plot(np.full(len(values), x), values, "o", ms=3, color=colour)
        ax.set_xticks(range(len(ratios)), [f"1:{ratio:g}" for ratio in ratios])
        ax.set(xlabel="ratio of diameters")
    axes[0].set(ylabel="fines that hang (%)", title="fines poured on a bed of large grains")
    axes[0].legend(fontsize=8, loc="upper left")
    axes[1].set(ylabel="slope (degrees)", title="after one wall is removed")
    return fig
