"""`demlaws laws`: the laws, and the options of each."""

from demlaws.cli import example
from demlaws.errors import DemlawsError


def register(subparsers):
    """Add this file's commands to the command line."""
    parser = subparsers.add_parser(
        "laws",
        description="Lists the laws of first loading, or one law's equation, source, what of the contact it needs, its options "
        "(for --option NAME=VALUE and dl.law(..., name=value)) and the unloading rules.",
        **example("  demlaws laws\n  demlaws laws rough-plastic\n  demlaws laws my-law --laws my_laws.py --check"),
    )
    parser.add_argument("name", nargs="?", help="name of a law (default: list all)")
    parser.add_argument("--check", action="store_true", help="run the project's own law tests on it and print the table")
    parser.set_defaults(func=run)


def print_laws():
    """Print a line a law: name and description."""
    from demlaws.laws.registry import registry

    for name, definition in registry().items():
        print(f"{name:16} {definition.description}")


def run(arguments):
    """Do what the command's arguments ask."""
    from demlaws.core.unloading import RULES
    from demlaws.laws.registry import find

    if arguments.check and arguments.name is None:
        raise DemlawsError("--check is of one law: demlaws laws NAME --check")
    if arguments.check:
        from demlaws.checks.law import check_law

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
