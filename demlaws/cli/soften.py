"""`demlaws soften`: softer grains that stay on the same branch of the law."""

from demlaws.cli import example
from demlaws.cli.arguments import plain
from demlaws.cli.contact import add_law_arguments, law_from, unloads
from demlaws.errors import DemlawsError

_UNITS = {
    "radius": ("mm", 1e3),
    "modulus": ("GPa", 1e-9),
    "sigma": ("µm", 1e6),
    "fractal_dimension": ("", 1),
    "hardness": ("GPa", 1e-9),
}


def register(add):
    """Add this command."""
    parser = add(
        description="Prints the engine input for softer contacts that remain on the same branch of the law, and allow a longer "
        "time step: moduli, roughness, hardness and options; and the effects on forces, energies and times.",
        **example(
            "  demlaws soften --factor 10 --law pohrt-popov --unloading hertz --radius 8.7mm 8.7mm --material granite\n"
            "  demlaws soften --factor 100 --law rough-plastic --option yield_pressure=1.66GPa --radius 8mm 8mm \\\n"
            "      --modulus 32GPa --roughness 1.7um --fractal-dimension 2.2"
        ),
    )
    parser.add_argument("--factor", type=plain, required=True, help="divisor of the modulus, for instance 10")
    add_law_arguments(parser)


def run(arguments, result):
    """Do what the command's arguments ask."""
    from demlaws.advice.soften import Softening
    from demlaws.units import HANDY

    softening = Softening(arguments.factor)
    if softening.factor < 1.0:
        raise DemlawsError(f"--factor = {softening.factor:g} makes grains stiffer: it divides the modulus, give 1 or more")
    law = law_from(arguments)
    softer = softening.of(law)
    result.print(f"{unloads(law)}, s = {softening.factor:g}\n")
    result.values = {
        "law": law.name,
        "unloading": law.unloading,
        "factor": softening.factor,
        "contact": law.contact,
        "options": law.options,
        "softened": {"contact": softer.contact, "options": softer.options},
        "effects": [dict(zip(("quantity", "factor", "power"), row, strict=True)) for row in softening.effects()],
    }
    rows = [(n.replace("_", " "), *unit, getattr(law.contact, n), getattr(softer.contact, n)) for n, unit in _UNITS.items()]
    for name, value in law.options.items():
        unit = law.definition.options[name].unit if name in law.definition.options else ""
        rows.append((name, *HANDY.get(unit, (unit, 1.0)), value, softer.options[name]))
    result.print(f"{'input':34}{'original':>14}{'softened':>18}")
    for name, unit, times, before, after in rows:
        if isinstance(before, int | float):
            title = f"{name} [{unit}]" if unit else name
            result.print(f"{title:34}{before * times:14.6g}{after * times:18.6g}")
    result.print(f"\n{'effect':66}{'×':>10}")
    for quantity, times, power in softening.effects():
        if len(power) > 20:
            result.print_wrapped(f"{quantity}: {power}")
        else:
            result.print(f"{quantity:66}{times:>10}  {power}")
    result.print_wrapped("at equal force; impacts at equal speed are not similar")
