"""`demlaws regime`: which part of a rough contact deforms."""

from demlaws.cli import example
from demlaws.cli.arguments import force, plain, pressure
from demlaws.cli.contact import add_contact_arguments, contact_from, draw
from demlaws.cli.output import picture_file
from demlaws.errors import DemlawsError


def register(add):
    """Add this command."""
    regime = add(
        description="Evaluates the criterion of Jamari & Schipper: p(0)/H_m at a load, the transition load, and the laws "
        "that apply.",
        **example(
            "  demlaws regime --radius 3.175mm inf --young 430GPa 75.2GPa --poisson 0.17 0.34 --hardness 0.24GPa \\\n"
            "      --sigma 1.3um --load 0.2"
        ),
    )
    add_contact_arguments(regime)
    regime.add_argument("--load", type=force, help="normal force in N")
    regime.add_argument("--mu", type=plain, help="Greenwood & Tripp's μ of the surface; p(0) is then solved, not from the fit")
    regime.add_argument(
        "--yield-pressure", type=pressure, help="measured limit pressure p_y in Pa, in place of 0.6 of the hardness"
    )
    regime.add_argument(
        "--yield-load", type=force, help="measured load in N at which the bulk of this contact yields, in place of p_y"
    )
    regime.add_argument("--figure", type=picture_file, help="map of p(0)/H_m over load and roughness")


def run(arguments, result):
    """Do what the command's arguments ask."""
    from demlaws.regime import FIRST, advise, regime
    from demlaws.solvers.criterion import YIELD_RATIO, hertz_pressure, transition_force

    if arguments.yield_load is not None and arguments.yield_pressure is not None:
        raise DemlawsError("--yield-load and --yield-pressure are alternatives: give one of them")
    pair, limit = contact_from(arguments), arguments.yield_pressure
    if arguments.yield_load is not None:
        limit = float(hertz_pressure(pair, arguments.yield_load))
    if arguments.load is None:
        if limit is not None:
            raise DemlawsError("--load missing: a measured yield is compared with a load")
        yields = transition_force(pair, mu=arguments.mu)
        result.print(f"the bulk yields (p(0)/H_m = {YIELD_RATIO}) from {yields:.4g} N; below, asperities")
        result.values = {"contact": pair, "transition_force": yields}
    else:
        assessment = regime(pair, arguments.load, arguments.mu, yield_pressure=limit)
        laws = advise(pair, arguments.load, limit, mu=arguments.mu)
        result.values = {"contact": pair, "assessment": assessment, "laws": laws}
        result.print_wrapped(str(assessment))
        first = FIRST * arguments.load
        result.print(f"laws from {first:.3g} N (α = {float(pair.roughness_parameter(first)):.3g}) to {arguments.load:.4g} N:")
        for advice in laws:
            result.print_wrapped(f"  {advice.law:16} {'applies' if advice.fits else 'no':7} {advice.reason}", " " * 27)
    draw(result, arguments.figure, lambda plots: plots.surface.regime_figure(pair, arguments.load))
