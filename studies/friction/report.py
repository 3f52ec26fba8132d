"""Tables of beds and slopes: friction by pressure beside constant friction, effects of pairs by seed."""

from studies.paired import change, clear, interval

QUANTITIES = {
    "s1_um": "settlement, N = 1",
    "s20_um": "settlement, N = 1 to 20",
    "resilient_um": "elastic displacement, N = 20",
    "loss_1_J": "dissipated in cycle 1",
}
MINUS = str.maketrans("-", "−")


def pairs(rows, grains, value, former):
    """Values with `former` friction and with that by pressure, of the seeds that have both."""
    found = {(int(row["seed"]), row["friction"]): row[value] for row in rows if row["grains"] == grains}
    seeds = sorted(seed for seed, friction in found if friction == "pressure" and (seed, former) in found)
    return [found[seed, former] for seed in seeds], [found[seed, "pressure"] for seed in seeds]


def kinds(rows):
    """Grains in the order of the rows."""
    return list(dict.fromkeys(row["grains"] for row in rows))


def bed_effects(rows):
    """(grains, quantity) → `Estimate` of the change to friction by pressure from the constant one of the mean pressure."""
    return {(grains, name): change(*pairs(rows, grains, name, "mean")) for grains in kinds(rows) for name in QUANTITIES}


def slope_effects(rows):
    """(grains, former friction) → `Estimate` of the angle with friction by pressure less that with the former one [degrees]."""
    found = {}
    for grains in kinds(rows):
        for former in ("mean", "bed"):
            before, after = pairs(rows, grains, "degrees", former)
            found[grains, former] = interval([b - a for a, b in zip(before, after, strict=True)])
    return found


def shown(estimate, bold, factor=1.0, unit=""):
    """Text of an effect with its interval."""
    mean, low, high = (f"{factor * value:+.3g}" for value in estimate[:3])
    mark = "**" if bold else ""
    return f"{mark}{mean}{unit}{mark} ({low} to {high})".translate(MINUS)


def bed_table(rows):
    """The effects on beds in Markdown."""
    found = bed_effects(rows)
    bold = dict(zip(found, clear(found.values()), strict=True))
    lines = [f"| grains | pairs | μ | {' | '.join(QUANTITIES.values())} |", "|---|---|---|" + "---|" * len(QUANTITIES)]
    for grains in kinds(rows):
        cells = [shown(found[grains, name], bold[grains, name], 100.0, " %") for name in QUANTITIES]
        mu = interval(pairs(rows, grains, "mean_mu", "mean")[0])
        lines.append(f"| {grains} | {found[grains, 's1_um'].samples} | {mu.mean:.2f} | {' | '.join(cells)} |")
    return "\n".join(lines)


def slope_table(rows):
    """Angles and the effects on them in Markdown."""
    found = slope_effects(rows)
    bold = dict(zip(found, clear(found.values()), strict=True))
    heads = "grains | pairs | by pressure (degrees) | against constant μ of the slope | μ | against constant μ of the bed | μ"
    lines = [f"| {heads} |", "|---|---|---|---|---|---|---|"]
    for grains in kinds(rows):
        angle = interval(pairs(rows, grains, "degrees", "mean")[1])
        cells = [f"{angle.mean:.1f} ({angle.low:.1f} to {angle.high:.1f})"]
        for former in ("mean", "bed"):
            mu = interval([row["mu"] for row in rows if row["grains"] == grains and row["friction"] == former])
            cells += [shown(found[grains, former], bold[grains, former], unit="°"), f"{mu.mean:.2f}"]
        lines.append(f"| {grains} | {found[grains, 'mean'].samples} | {' | '.join(cells)} |")
    return "\n".join(lines)
