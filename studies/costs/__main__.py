"""`python -m studies.costs`: cost of an engine's step with one law and with others, measured in turn."""

import sys

from demlaws.cli import Parser, example, execute
from studies.trade.peers import law_costs


def parser():
    """The command line."""
    parser = Parser(
        prog="python -m studies.costs",
        description="Time per contact and step of an engine with each law, in a close packing of granite spheres at rest.",
        **example(
            "  python -m studies.costs conical-damage cdm@own\n  python -m studies.costs --engine liggghts eepa edinburgh@own"
        ),
    )
    parser.add_argument(
        "laws", nargs="+", metavar="LAW", help="LAW, LAW:RULE, or MODEL@own of the engine's; costs are also over the first's"
    )
    parser.add_argument("--engine", choices=("yade", "liggghts", "lammps"), default="yade", help="default: yade")
    parser.add_argument(
        "--overlap", type=float, default=1e-4, metavar="X", help="of each contact, over the spheres' radius (default: 1e-4)"
    )
    parser.add_argument("--repeats", type=int, default=40, metavar="N", help="rounds (default: 40)")
    parser.set_defaults(func=lambda found: print_costs(found.laws, found.engine, found.overlap, found.repeats))
    return parser


def print_costs(names, engine, overlap, repeats):
    """Print one line per way: time per contact and step, over that with the engine's own Hertz, over that of the first."""
    costs = law_costs(names, engine, overlap, repeats=repeats)
    print(f"{engine}: {'law':27} {'unloading':10} {'ns per contact':>14} {'own Hertz':>10} {names[0]:>16}")
    for cost in costs:
        over = cost.over_hertz / costs[0].over_hertz
        rule = cost.way.unloading if cost.way.law else ""
        print(f"{'':{len(engine) + 1}} {cost.way.label:27} {rule:10} {cost.step:14.1f} {cost.over_hertz:10.3f} {over:16.3f}")


def main(arguments=None):
    """Run the command; returns the exit status."""
    return execute(parser, arguments)


if __name__ == "__main__":
    sys.exit(main())
