"""The grains of a case: arguments that `demlaws liggghts export` and `demlaws lammps export` share."""

from demlaws.cli import option
from demlaws.cli.arguments import density, law_name, length, plain, pressure, whole
from demlaws.errors import DemlawsError
from demlaws.laws.names import USUAL


def grain_arguments(export):
    """Add the folder, the law and the grains of a case to a parser."""
    export.add_argument("folder", help="folder to write")
    export.add_argument("--law", type=law_name, default=USUAL, help="name of the law (default %(default)s)")
    export.add_argument(
        "--unloading",
        help="elastic, hertz, thornton, a rule of the law's own, or a table file whose curve all contacts unload along "
        "(default: the law's own, else hertz)",
    )
    export.add_argument("--unloading-law", help="name of a law whose curve each contact unloads along, in place of --unloading")
    options = {"type": option, "action": "append", "default": [], "metavar": "NAME=VALUE"}
    export.add_argument("--unloading-option", **options, help="an option of that law")
    export.add_argument("--option", **options, help="an option of the law")
    export.add_argument(
        "--radius", type=length, nargs="+", required=True, help="grain radius in m, or with a unit (4mm): one a particle type"
    )
    for name, kind, default, text in (
        ("sq", length, [0.0], "rms roughness Sq of a grain's own surface [m]; two grains have σ² = Sq1² + Sq2²"),
        ("fractal-dimension", plain, [None], "fractal dimension of the surface, 2 to 3"),
        ("young", pressure, [60.6e9], "Young's modulus [Pa]"),
        ("poisson", plain, [0.25], "Poisson's ratio"),
        ("hardness", pressure, [None], "indentation hardness [Pa]"),
        ("density", density, [2650.0], "density [kg/m³]"),
    ):
        shown = "" if default == [None] else f" (default {default[0]:g})"
        export.add_argument(f"--{name}", type=kind, nargs="+", default=default, help=f"{text}: one, or one a type{shown}")
    export.add_argument("--rtol", type=plain, default=1e-5, help="relative tolerance of the tables (default %(default)g)")
    export.add_argument("--count", type=whole(), default=1000, help="number of grains (default %(default)s)")


def _each(arguments, name, count):
    values = getattr(arguments, name)
    if len(values) not in (1, count):
        raise DemlawsError(f"--{name.replace('_', '-')} has {len(values)} values for {count} radii: give one, or one a radius")
    return values if len(values) == count else values * count


def grains_of(arguments):
    """The case's `Grain`s, what they unload along, and the options of the law."""
    from demlaws.contact import Material, Surface
    from demlaws.liggghts.export import Grain
    from demlaws.make import law

    count = len(arguments.radius)
    columns = [_each(arguments, name, count) for name in ("sq", "fractal_dimension", "young", "poisson", "hardness", "density")]
    grains = [
        Grain(radius, Material(young, poisson, hardness, density), Surface(sq, dimension, hardness))
        for radius, sq, dimension, young, poisson, hardness, density in zip(arguments.radius, *columns, strict=True)
    ]
    options, unloading = dict(arguments.option), arguments.unloading
    if arguments.unloading_law is not None:
        contact = grains[0].contact(grains[0])
        unloading = law(arguments.unloading_law, contact, **dict(arguments.unloading_option))
    return grains, unloading, options
