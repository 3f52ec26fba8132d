"""`demlaws materials`: typical values of materials, with ranges and sources."""

import textwrap

from demlaws.cli import example


def register(add):
    """Add this command."""
    parser = add(
        description="Lists typical values of materials (E, ν, hardness, density, Sq, Df, friction), or the ranges and sources "
        "of one. In Python: dl.materials.glass.",
        **example("  demlaws materials\n  demlaws materials glass"),
    )
    parser.add_argument("name", nargs="?", help="name of a material (default: all)")


def run(arguments, result):
    """Do what the command's arguments ask."""
    from demlaws.materials import SYMBOLS, Typical, names, typical

    chosen = [arguments.name] if arguments.name else names()
    result.values = {
        name: {quantity: {**value._asdict(), "display": value.display()} for quantity, value in typical(name).items()}
        for name in chosen
    }
    if not arguments.name:
        result.print(Typical(chosen), "?: no value in public text. Sources and ranges: demlaws materials NAME")
        return
    for quantity, value in typical(arguments.name).items():
        result.print(f"{SYMBOLS[quantity]:3} {quantity.replace('_', ' '):18} {value.display()}")
        result.print(textwrap.fill(value.source, 96, initial_indent="    ", subsequent_indent="    "))
