"""`demlaws laws`: the laws, and the options of each."""

from demlaws.cli import example
from demlaws.errors import DemlawsError


def register(add):
    """Add this command."""
    parser = add(
        description="Lists the laws of first loading, or one law's equation, source, required contact quantities, options "
        "(for --option NAME=VALUE and dl.law(..., name=value)) and the unloading rules.",
        **example("  demlaws laws\n  demlaws laws rough-plastic\n  demlaws laws my-law --law-file my_laws.py --check"),
    )
    parser.add_argument("name", nargs="?", help="name of a law (default: list all)")
    parser.add_argument("--check", action="store_true", help="run the project's tests on this law and print the results")


def run(arguments, result):
    """Do what the command's arguments ask."""
    from demlaws.core.unloading import GIVEN, RULES
    from demlaws.laws.registry import find, registry

    if arguments.check and arguments.name is None:
        raise DemlawsError("--check is for one law: demlaws laws NAME --check")
    if arguments.check:
        from demlaws.user_laws.check import check_law

        report = check_law(arguments.name)
        result.print(report)
        return 0 if report.passed else 1
    if arguments.name is None:
        rules = [rule for rule in RULES if rule != GIVEN]
        result.values = {"laws": {name: d.description for name, d in registry().items()}, "unloading": rules}
        result.print(*(f"{name:16} {definition.description}" for name, definition in registry().items()))
        result.print_wrapped(
            f"unloading: {', '.join(rules)}, or a table to unload along; options and rules of a law: demlaws laws NAME"
        )
        return 0
    definition = find(arguments.name)
    rules = [rule for rule in definition.offered() if rule != GIVEN]
    result.values = {name: getattr(definition, name) for name in ("name", "description", "equation", "source")} | {
        "needs": definition.needed(),
        "unloading": rules,
        "default_unloading": definition.default_rule(),
        "options": {name: option._replace(values=str(option.values)) for name, option in definition.options.items()},
    }
    result.print_wrapped(f"{definition.name}: {definition.description}\n  {definition.equation}\n  {definition.source}")
    result.print(f"  needs of the contact: {', '.join(('radius', 'modulus', *definition.needed()))}")
    options = list(definition.option_lines())
    result.print("  options:" if options else "  no options")
    for line in options:
        result.print_wrapped(f"    {line}", "        ")
    if definition.unloading:
        result.print_wrapped(
            f"  unloading: {', '.join(rules)}, or a table to unload along (except those that would create energy)"
        )
        result.print(f"  default: {definition.default_rule()}")
    for rule in definition.rules.own:
        result.print_wrapped(f"  {rule.name}, a rule of this law only: {rule.description}")
    return 0
