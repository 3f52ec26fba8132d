"""`demlaws regime`: which part of a rough contact deforms."""

from demlaws.cli import example
from demlaws.cli.arguments import force, length, output, plain, pressure
from demlaws.cli.bodies import bodies, draw, pair_of
from demlaws.errors import DemlawsError


def register(subparsers):
    """Add this file's commands to the command line."""
    regime = subparsers.add_parser(
        "regime",
        description="The criterion of Jamari & Schipper: p(0)/H_m at a load, the load at which the answer changes, which laws "
        "fit.",
        **example(
            "  demlaws regime --radius 3.175mm --young 75.2e9 --poisson 0.34 --hardness 0.24e9 --ball-young 430e9 \\\n"
            "      --ball-poisson 0.17 --sigma 1.3um --load 0.2"
        ),
    )
    bodies(regime)
    regime.add_argument("--sigma", dest="roughness", type=length, help="combined rms roughness σ in m, or with a unit: 1.3um")
    regime.add_argument("--fractal-dimension", type=plain, help="Df from 2 to 3")
    regime.add_argument("--load", type=force, help="load in N")
    regime.add_argument("--mu", type=plain, help="Greenwood & Tripp's μ of the surface: p(0) from their solution, not the fit")
    regime.add_argument(
        "--yield-pressure", type=pressure, help="measured limit pressure p_y in Pa, in place of 0.6 of the hardness"
    )
    regime.add_argument(
        "--yield-load", type=force, help="measured load in N at which the bulk of this contact yields, in place of p_y"
    )
    regime.add_argument("--figure", type=output, help="map of p(0)/H_m over load and roughness")
    regime.set_defaults(func=run_regime)


def run_regime(arguments):
    """Do what the command's arguments ask."""
    from demlaws import regime

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
