"""`python -m studies.costs`: cost of an engine's step with one law and with others, measured in turn."""

import sys

from demlaws.cli import Parser, example, execute
from demlaws.errors import DemlawsError
from demlaws.laws.registry import find
from demlaws.units import number
from studies.costs.steps import step_costs
from studies.trade.candidates import CDM, Way
from studies.trade.peers import GRANITE_CONTACT

OWN_MODELS = {"yade": ("hertz", "cdm"), "liggghts": ("hertz", "edinburgh"), "lammps": ("hertz",)}
"""Models of the engines' own, named NAME@own."""


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


def way_of(text, engine):
    """`Way` of "LAW", "LAW:RULE" (default: the law's own rule), or "MODEL@own" of the engine's own."""
    if text.endswith("@own"):
        model = text.removesuffix("@own")
        if model not in OWN_MODELS[engine]:
            known = ", ".join(f"{name}@own" for name in OWN_MODELS[engine])
            raise DemlawsError(f"{text!r}: {engine} has {known}")
        return Way(text, model=model)
    name, _, rule = text.partition(":")
    definition = find(name)
    options = dict(definition.example)
    if {"strength", "angle"} <= options.keys():  # as YADE's own
        options |= dict(zip(("strength", "angle"), CDM, strict=True))
    rule = definition.rule(rule or definition.default_unloading).name
    return Way(text, name, rule, 0.0 if engine == "yade" else 1e-5, options=tuple(options.items()))


def print_costs(names, engine, overlap, repeats):
    """Print one line per way: time per contact and step, over that with the engine's own Hertz, over that of the first."""
    radius, ways = 2.0 * GRANITE_CONTACT.radius, [way_of(name, engine) for name in names]
    deep = number(overlap, "overlap", "of the spheres' radius", 0.0, 0.04) * radius
    rounds = repeats if engine == "yade" else max(repeats // 5, 1)
    costs = step_costs(engine, ways, radius, deep, 10.0, 8, rounds)
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
