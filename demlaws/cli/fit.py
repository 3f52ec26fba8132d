"""`demlaws fit`: laws fitted to measured points."""

import math
from pathlib import Path

from demlaws.cli import example
from demlaws.cli.arguments import compliance, force, length
from demlaws.cli.contact import add_contact_arguments, contact_from, describe, draw
from demlaws.cli.output import csv_file, picture_file, progress
from demlaws.files import wrapped

TITLES = [
    *("law", "unloading", "misfit_m", "aicc", "delta", "weight"),
    *("parameter", "value", "standard_error", "low", "high", "note"),
]


def register(add):
    """Add this command."""
    parser = add(
        description="Fits each law to measured points of displacement and force, loading and unloading in the order of the "
        "test, and prints parameters with 95 % intervals and the ranking by Akaike's criterion (AICc).",
        **example(
            "  demlaws fit points.csv --radius 8.7mm 8.7mm --material granite --figure fit.png\n"
            "  demlaws fit points.csv --radius 8.7mm 8.7mm --modulus 32.3GPa --roughness 1.4um --fractal-dimension 2.2 \\\n"
            "      --law rms --law pohrt-popov --free sigma modulus\n\n"
            "points.csv: two columns with units in the header, for instance\n"
            "  displacement (um),force (N)"
        ),
    )
    parser.add_argument(
        "points", type=Path, help="text file of measured points: two columns with units in the header (-: standard input)"
    )
    add_contact_arguments(parser)
    parser.add_argument(
        "--law",
        action="append",
        help="fit only this law (may be repeated; default: all laws that need no height map)",
    )
    parser.add_argument(
        "--unloading",
        help="fit only this rule: elastic, hertz, thornton or a rule of the law (default: all, if points unload)",
    )
    parser.add_argument(
        "--free", nargs="+", metavar="NAME", help="quantities to fit (default: those of each law, and force_zero)"
    )
    parser.add_argument("--displacement-noise", type=length, help="standard deviation of the displacement in m")
    parser.add_argument("--force-noise", type=force, default=0.0, help="standard deviation of the force in N")
    parser.add_argument(
        "--compliance",
        type=compliance,
        default=0.0,
        help="compliance of the apparatus, in m/N or with a unit: 0.01um/N (to fit it: --free ... compliance)",
    )
    parser.add_argument("--csv", type=csv_file(TITLES), help="CSV file of the ranking")
    parser.add_argument("--figure", type=picture_file, help="picture to draw (png, pdf, svg)")


def shown(name, estimate, unit):
    """A parameter with its interval, in handy units."""
    from demlaws.units import HANDY

    if estimate.open_end == "both":
        return f"{name} {estimate.note}"
    unit, factor = HANDY.get(unit, (unit, 1.0))
    if estimate.open_end == "lower":
        text = f"{name} below {estimate.high * factor:.4g}"
    elif estimate.open_end == "upper":
        text = f"{name} above {estimate.low * factor:.4g}"
    else:
        text = f"{name} {estimate.value * factor:.5g}"
        if estimate.low == estimate.low:
            text += f" [{estimate.low * factor:.4g}, {estimate.high * factor:.4g}]"
    return f"{text} {unit}".rstrip() + (f" ({estimate.cause})" if estimate.cause else "")


def surfaces(fit, given):
    """Sq [m] of both surfaces, of which the σ of the pair in a fit consists; None if it is not fitted or not determined.

    given: values of --roughness. Of two unlike ones the second is kept, unless σ is below it; else both surfaces are alike.
    """
    if "sigma" not in fit.parameters or fit.parameters["sigma"].open_end:
        return None
    sigma = fit.parameters["sigma"].value
    first, second = (given[0], given[-1]) if given else (0.0, 0.0)
    if first != second and sigma > second:
        return math.sqrt((sigma - second) * (sigma + second)), second
    return sigma / math.sqrt(2.0), sigma / math.sqrt(2.0)


def table_lines(ranking, given=None):
    """The ranking: a line for each law, its parameters and notes below; a note that several laws share comes last."""
    from demlaws.advice.fit import parameters
    from demlaws.advice.fit_report import SYSTEMATIC

    units = {name: quantity.unit for name, quantity in parameters().items()}
    if ranking.title():
        yield wrapped(ranking.title())
    yield f"{'law':16} {'unloading':9} {'misfit (µm)':>11} {'ΔAICc':>9} {'weight':>7}  misfit is"
    for f in ranking:
        kind = "systematic" if f.systematic else "scatter"
        yield f"{f.name:16} {f.unloading:9} {f.misfit * 1e6:11.4g} {f.delta:9.1f} {f.weight:7.3f}  {kind}"
        yield wrapped("; ".join(shown(n, e, units.get(n, "m")) for n, e in f.parameters.items()), "    ")
        if (sq := surfaces(f, given)) is not None:
            words = "{} of each of two equal surfaces" if sq[0] == sq[1] else "{} of the first surface, {} of the second"
            yield wrapped("roughness Sq " + words.format(*(f"{1e6 * one:.5g} µm" for one in sq)), "    ")
        yield from (wrapped(note, "    * ", "      ") for note in f.notes if note != SYSTEMATIC)
    if any(f.systematic for f in ranking):
        yield wrapped("systematic: the law does not describe the points (drift, or a wrong law); ignore its intervals")


def run(arguments, result):
    """Do what the command's arguments ask."""
    from demlaws.advice.fit import fit
    from demlaws.curves.point_files import read_points

    points, contact = read_points(arguments.points), contact_from(arguments)
    result.print(describe(contact))
    ranking = fit(
        points,
        contact,
        laws=arguments.law,
        unloading=arguments.unloading,
        free=arguments.free,
        displacement_noise=arguments.displacement_noise,
        force_noise=arguments.force_noise,
        compliance=arguments.compliance,
        progress=progress("fit"),
    )
    result.print(f"{points.source}: {ranking.points[1].size} points to {ranking.points[1].max():.4g} N; intervals hold 95 %\n")
    result.print(*table_lines(ranking, arguments.roughness))
    fields = ("name", "unloading", "misfit", "systematic", "aicc", "delta", "weight", "notes")
    laws = [{name: getattr(f, name) for name in fields} for f in ranking]
    for one, f in zip(laws, ranking, strict=True):
        one["parameters"] = {name: {**e._asdict(), "note": e.note} for name, e in f.parameters.items()}
        if (sq := surfaces(f, arguments.roughness)) is not None:
            one["roughness"] = sq
    result.values = {"laws": laws, "skipped": dict(ranking.skipped)}
    for name, reason in ranking.skipped.items():
        result.print_wrapped(f"not fitted: {name}: {reason}")
    rows = (
        (f.name, f.unloading, f.misfit, f.aicc, f.delta, f.weight, name, e.value, e.error, e.low, e.high, e.note)
        for f in ranking
        for name, e in f.parameters.items()
    )
    result.write_csv(arguments.csv, TITLES, rows)
    draw(result, arguments.figure, lambda plots: plots.fit_figure(ranking, points.source))
