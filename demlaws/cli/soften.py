"""`demlaws soften`: softer grains that stay on their branch."""

from demlaws.cli import example
from demlaws.cli.arguments import force, plain
from demlaws.cli.curve import add_law_arguments, law_from


def register(subparsers):
    """Add this file's commands to the command line."""
    parser = subparsers.add_parser(
        "soften",
        description="What to give an engine so that contacts are softer by a factor and the time step longer, without a change "
        "of the law's branch: moduli, roughness, hardness, the law's options; and what that keeps, multiplies and loses.",
        **example(
            '  demlaws soften --factor 10 --law pohrt-popov --unloading hertz --test "SS(18-18)" --force 10\n'
            "  demlaws soften --factor 100 --law rough-plastic --option yield_pressure=1.66GPa --radius 4mm \\\n"
            "      --modulus 32GPa --sigma 2.4um --fractal-dimension 2.2 --force 10"
        ),
    )
    parser.add_argument("--factor", type=plain, required=True, help="by what the modulus is divided, for instance 10")
    parser.add_argument("--force", type=force, default=10.0, help="force in N at which the contact is shown (default 10)")
    add_law_arguments(parser)
    parser.set_defaults(func=run)


def run(arguments):
    """Do what the command's arguments ask."""
    from demlaws.advice.soften import EXPONENTS, Softening
    from demlaws.contact import Contact

    softening = Softening(arguments.factor)
    law = law_from(arguments)
    report = softening.report(law, arguments.force)
    print(f"{law.name}, {law.unloading} unloading, s = {softening.factor:g}\n")
    units = {"radius": "m", "modulus": "Pa", "roughness": "m", "hardness": "Pa"}
    print(f"{'give':34}{'as it is':>14}{'softened':>18}")
    for name in EXPONENTS[Contact]:
        if (value := getattr(law.contact, name)) is not None:
            unit = f" [{units[name]}]" if name in units else ""
            print(f"{name.replace('_', ' ') + unit:34}{value:14.6g}{getattr(report.law.contact, name):18.6g}")
    for name, value in law.options.items():
        if isinstance(value, int | float):
            unit = law.definition.options[name].unit if name in law.definition.options else ""
            print(f"{name + (f' [{unit}]' if unit else ''):34}{value:14.6g}{report.law.options[name]:18.6g}")
    print(f"\n{'what becomes of it':72}{'×':>10}")
    for quantity, times, power in softening.effects():
        print(f"{quantity:72}{times:>10}  {power}")
    print("\n" + "\n".join(report.lines()))
