"""`demlaws regime`: which part of a rough contact deforms, and the papers that the criterion comes from."""

import warnings
from pathlib import Path

from demlaws.cli import example
from demlaws.cli.arguments import figures, force, length, output, plain, pressure
from demlaws.cli.bodies import bodies, draw, pair_of
from demlaws.cli.curve import SIGMA
from demlaws.cli.refused import Refused
from demlaws.errors import DemlawsError, ValidityWarning


def register(subparsers):
    """Add this file's commands to the command line."""
    regime = subparsers.add_parser(
        "regime",
        description="The criterion of Jamari & Schipper: p(0)/H_m at a load, the load at which the answer changes, which laws "
        "fit. Without a contact: the published tests, what the papers say of them (--claims), their figures (--figures).",
        **example(
            "  demlaws regime --figure regime.png\n"
            "  demlaws regime --claims\n"
            "  demlaws regime --figures all --out jamari-2006\n"
            "  demlaws regime --radius 3.175mm --young 75.2e9 --poisson 0.34 --hardness 0.24e9 --ball-young 430e9 \\\n"
            "      --ball-poisson 0.17 --sigma 1.3um --load 0.2"
        ),
    )
    bodies(regime)
    regime.add_argument("--sigma", dest="roughness", type=length, help="combined rms roughness σ in m, or with a unit: 1.3um")
    regime.add_argument("--roughness", action=Refused, remedy=SIGMA)
    regime.add_argument("--fractal-dimension", type=plain, help="Df from 2 to 3")
    regime.add_argument("--load", type=force, help="load in N")
    regime.add_argument("--mu", type=plain, help="Greenwood & Tripp's μ of the surface: p(0) from their solution, not the fit")
    regime.add_argument(
        "--yield-pressure", type=pressure, help="measured limit pressure p_y in Pa, in place of 0.6 of the hardness"
    )
    regime.add_argument(
        "--yield-load", type=force, help="measured load in N at which the bulk of this contact yields, in place of p_y"
    )
    regime.add_argument("--claims", action="store_true", help="what the papers of 2006 and 2008 say, and the verdicts")
    regime.add_argument(
        "--figures", type=figures(1, 12), metavar="LIST", help="Figs. 1 and 12 of the 2006 paper: all, or numbers (1,12)"
    )
    regime.add_argument("--out", type=Path, default=Path("jamari-2006"), help="folder for these (default: jamari-2006)")
    regime.add_argument("--figure", type=output, help="map of p(0)/H_m over load and roughness")
    regime.set_defaults(func=run_regime)


def run_regime(arguments):
    """Do what the command's arguments ask."""
    from demlaws import regime

    given = [n for n in ("radius", "young", "poisson", "hardness", "roughness", "load") if getattr(arguments, n) is not None]
    if arguments.claims or arguments.figures:
        if given:
            raise DemlawsError(f"--claims and --figures are about the papers: leave out --{given[0]}")
        return _papers(arguments)
    if not given:
        return _published(arguments)
    if arguments.yield_load is not None and arguments.yield_pressure is not None:
        raise DemlawsError("--yield-load and --yield-pressure say the same: give one of them")
    measured = arguments.yield_load is not None or arguments.yield_pressure is not None
    for name, flag in (("roughness", "sigma"), ("hardness", "hardness")):
        if getattr(arguments, name) is None and not (name == "hardness" and measured):
            raise DemlawsError(f"--{flag} missing: the criterion needs it")
    pair = pair_of(arguments, arguments.roughness, arguments.fractal_dimension)
    limit = arguments.yield_pressure
    if arguments.yield_load is not None:
        limit = float(regime.hertz_pressure(pair, arguments.yield_load))
    if arguments.load is None:
        if measured:
            raise DemlawsError("--load missing: a measured yield is held against a load")
        yields = regime.transition_load(pair, mu=arguments.mu)
        print(f"the bulk yields (p(0)/H_m = {regime.YIELD_RATIO}) from {yields:.4g} N; below, asperities")
    else:
        print(regime.assess(pair, arguments.load, arguments.mu, limit))
        print("laws at this load:")
        for advice in regime.advise(pair, arguments.load, limit, arguments.mu):
            print(f"  {advice.law:16} {'fits' if advice.fits else 'no'}: {advice.reason}")
    draw(arguments.figure, lambda plots: plots.regime_figure(pair, arguments.load))
    return 0


def _papers(arguments):
    if arguments.claims:
        from demlaws import claims
        from demlaws.cli.granite import print_claims

        with warnings.catch_warnings():  # α beyond the fit's range is in the table
            warnings.simplefilter("ignore", ValidityWarning)
            print_claims(list(claims.jamari_claims()))
    if arguments.figures:
        from demlaws.cli.granite import draw_figures
        from demlaws.plots import jamari

        draw_figures(jamari.FIGURES_2006, arguments.figures, arguments.out)
    return 0


def _published(arguments):
    from demlaws import regime

    rows = regime.published_ratios()
    print(f"{'':18} {'':6} {'':7} {'α':>7} {'':>8} {'μ':>8} {'p(0)/H_m':>23}")
    print(
        f"{'test':18} {'P (N)':>6} {'σ (µm)':>7} {'comp.':>7} {'printed':>8} {'printed':>8} "
        f"{'at μ':>7} {'Eq. 4':>7} {'printed':>8}  seen"
    )

    def cell(value, text):
        return f"{'-':>{len(format(1.0, text))}}" if value != value else format(value, text)

    for row in rows:
        test = row.test
        print(
            f"{test.label:18} {test.load:6g} {test.contact.roughness * 1e6:7.2f} {row.alpha:7.2f} {cell(test.alpha, '8.2f')} "
            f"{cell(test.mu, '8.0f')} {cell(row.solved, '7.3f')} {row.fitted:7.3f} {cell(test.ratio, '8.2f')}  {test.seen}"
        )
    print("\nat μ: Greenwood & Tripp's solution at the printed μ, the paper's own method; Eq. 4: its closed fit; both computed")
    for column, name in (("solved", "by the solution"), ("fitted", "by Eq. 4")):
        count = regime.swaps(rows, column)
        order = "the order is that of what was seen" if not count else f"{count} of the tests of 2006 stands out of order"
        print(f"  {name}: {order}")
    draw(arguments.figure, lambda plots: plots.regime_figure())
    return 0
