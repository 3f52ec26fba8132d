"""`demlaws laws`: the laws, and the options of each."""

from demlaws.cli import example
from demlaws.errors import DemlawsError


def register(subparsers):
    """Add this file's commands to the command line."""
    parser = subparsers.add_parser(
        "laws",
        description="Lists the laws of first loading, or one law's equation, source, what of the contact it needs, its options "
        "(for --option NAME=VALUE and dl.law(..., name=value)) and the unloading rules.",
        **example(
            "  demlaws laws\n  demlaws laws rough-plastic\n  demlaws laws my-law --laws my_laws.py --check\n"
            "  demlaws laws conical-damage --cost cdm@own"
        ),
    )
    parser.add_argument("name", nargs="?", help="name of a law (default: list all)")
    parser.add_argument("--check", action="store_true", help="run the project's own law tests on it and print the table")
    parser.add_argument(
        "--cost",
        nargs="+",
        metavar="LAW",
        help="what an engine's step costs with it and with these laws (LAW, LAW:RULE, or MODEL@own of the engine's), in turn",
    )
    parser.add_argument("--engine", choices=("yade", "liggghts", "lammps"), default="yade", help="of --cost (default: yade)")
    parser.add_argument("--overlap", type=float, default=1e-4, metavar="X", help="of --cost: of the spheres' radius")
    parser.add_argument("--repeats", type=int, default=40, metavar="N", help="of --cost: rounds (default: 40)")
    parser.set_defaults(func=run)


def print_laws():
    """Print a line a law: name and description."""
    from demlaws.laws.registry import registry

    for name, definition in registry().items():
        print(f"{name:16} {definition.description}")


def print_costs(names, engine, overlap, repeats):
    """Print a line a way: time a contact and step, over that with the engine's own Hertz, over that of the first."""
    from demlaws.measure.peers import law_costs

    costs = law_costs(names, engine, overlap, repeats=repeats)
    print(f"{engine}: {'law':27} {'unloading':10} {'ns a contact':>12} {'own Hertz':>10} {names[0]:>16}")
    for cost in costs:
        over = cost.over_hertz / costs[0].over_hertz
        rule = cost.way.unloading if cost.way.law else ""
        print(f"{'':{len(engine) + 1}} {cost.way.label:27} {rule:10} {cost.step:12.1f} {cost.over_hertz:10.3f} {over:16.3f}")


def run(arguments):
    """Do what the command's arguments ask."""
    from demlaws.core.unloading import RULES
    from demlaws.laws.registry import find

    if (arguments.check or arguments.cost) and arguments.name is None:
        raise DemlawsError("--check and --cost are of one law: demlaws laws NAME --check")
    if arguments.cost:
        print_costs([arguments.name, *arguments.cost], arguments.engine, arguments.overlap, arguments.repeats)
        return 0
    if arguments.check:
        from demlaws.measure.lawcheck import check_law

        found = check_law(arguments.name)
        print(found)
        return 0 if found.passed else 1
    if arguments.name is None:
        print_laws()
        print(f"unloading: {', '.join(RULES)}; options of a law, and unloading rules of its own: demlaws laws NAME")
        return 0
    definition = find(arguments.name)
    print(f"{definition.name}: {definition.description}\n  {definition.equation}\n  {definition.source}")
    print(f"  needs of the contact: {', '.join(('radius', 'modulus', *definition.needs))}")
    lines = list(definition.option_lines())
    print("  no options" if not lines else "  options:")
    for line in lines:
        print(f"    {line}")
    if definition.unloading:
        print(f"  unloading: {', '.join(definition.offered())} (those that are passive with it)")
        print(f"  where none is named: {definition.default_unloading}")
    for rule in definition.rules:
        print(f"  {rule.name}, a rule of its own: {rule.description}")
    return 0
