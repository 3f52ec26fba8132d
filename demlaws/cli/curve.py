"""`demlaws curve`: one law, one contact, any path; and the arguments that name a law and a contact."""

from demlaws.cli import example, option
from demlaws.cli.arguments import force, law_name, length, output, plain, pressure, whole
from demlaws.errors import DemlawsError


def add_law_arguments(parser, law_required=True):
    """Arguments that name a law and its contact."""
    parser.add_argument(
        "--law", type=law_name, required=law_required, help="name of the law (--law ? or demlaws laws lists them)"
    )
    parser.add_argument(
        "--unloading",
        help="elastic, hertz, thornton, a rule of the law's own (demlaws laws NAME), or a table file whose curve the contact "
        "unloads along (default: the law's own, else elastic)",
    )
    parser.add_argument("--option", type=option, action="append", default=[], metavar="NAME=VALUE", help="option of the law")
    curve = parser.add_argument_group("unloading along another law's curve, through the largest overlap")
    curve.add_argument("--unloading-law", type=law_name, help="name of that law")
    curve.add_argument(
        "--unloading-option", type=option, action="append", default=[], metavar="NAME=VALUE", help="option of that law"
    )
    curve.add_argument("--unloading-sigma", dest="unloading_roughness", type=length, help="its σ in m (default: the contact's)")
    curve.add_argument("--unloading-radius", type=length, help="its R in m (default: the contact's)")
    add_contact_arguments(parser)


def add_contact_arguments(parser):
    """Arguments that describe one contact."""
    contact = parser.add_argument_group(
        "contact (SI units, or with a unit: 4.35mm, 2.4um, 60GPa), or --test for one of the granite tests"
    )
    contact.add_argument("--test", help="contact of a granite test, for instance SS(18-18)")
    contact.add_argument("--radius", type=length, help="effective radius R in m")
    contact.add_argument("--modulus", type=pressure, help="effective modulus E* in Pa")
    contact.add_argument("--young", type=pressure, help="Young's modulus of both bodies in Pa, in place of --modulus")
    contact.add_argument("--poisson", type=plain, help="Poisson's ratio of both bodies, with --young")
    contact.add_argument(
        "--sigma", dest="roughness", type=length, help="combined rms roughness σ = √(Sq1² + Sq2²) in m (default 0)"
    )
    contact.add_argument("--fractal-dimension", type=plain, help="Df from 2 to 3")
    contact.add_argument("--hardness", type=pressure, help="hardness in Pa")


def law_from(arguments):
    """The law that the arguments name."""
    from demlaws import granite
    from demlaws.laws.registry import find
    from demlaws.make import law

    definition = find(arguments.law)
    options = dict(arguments.option)
    if arguments.test is not None:
        options = {**granite.options_for(definition.name, granite.find_test(arguments.test)), **options}
    contact = contact_from(arguments)
    return law(definition.name, contact, _unloading_from(arguments, contact), **options)


def _unloading_from(arguments, contact):
    """A rule, or the law whose curve the contact unloads along."""
    from demlaws import granite
    from demlaws.laws.registry import find
    from demlaws.make import law

    changes = {n: getattr(arguments, f"unloading_{n}") for n in ("roughness", "radius")}
    changes = {name: value for name, value in changes.items() if value is not None}
    if arguments.unloading_law is None:
        if changes or arguments.unloading_option:
            raise DemlawsError("--unloading-option, -sigma and -radius describe the curve of --unloading-law: name that law")
        return arguments.unloading
    if arguments.unloading not in (None, "elastic", "table"):
        raise DemlawsError(f"give either --unloading {arguments.unloading} or --unloading-law")
    options = dict(arguments.unloading_option)
    if arguments.test is not None:
        options = {**granite.options_for(find(arguments.unloading_law).name, granite.find_test(arguments.test)), **options}
    return law(arguments.unloading_law, contact.with_values(**changes), **options)


def contact_from(arguments):
    """The contact that the arguments describe."""
    from demlaws import granite
    from demlaws.contact import Contact, Material

    changes = {n: getattr(arguments, n) for n in ("radius", "modulus", "roughness", "fractal_dimension", "hardness")}
    changes = {name: value for name, value in changes.items() if value is not None}
    if (arguments.young is None) != (arguments.poisson is None):
        raise DemlawsError("--young and --poisson belong together: give both, or --modulus")
    if arguments.young is not None:
        if arguments.modulus is not None:
            raise DemlawsError("give either --modulus or --young with --poisson")
        changes["modulus"] = 0.5 * Material(arguments.young, arguments.poisson).plane_modulus
    if arguments.test is not None:
        return granite.find_test(arguments.test).contact.with_values(**changes)
    missing = [f"--{n}" for n in ("radius", "modulus") if n not in changes]
    if missing:
        raise DemlawsError(f"{' and '.join(missing)} missing: give the contact, or --test for a granite test's")
    return Contact(**changes)


def register(subparsers):
    """Add this file's commands to the command line."""
    curve = subparsers.add_parser(
        "curve",
        description="Takes one contact along a path of forces or overlaps and writes the curve.",
        **example(
            '  demlaws curve --law pohrt-popov --unloading hertz --test "SS(18-18)" --forces 50 0 100 0 --figure c.png\n'
            "  demlaws curve --law rough-plastic --option yield_pressure=1.66e9 --radius 1e-3 --modulus 3.2e10 \\\n"
            "      --sigma 5e-6 --fractal-dimension 2.2 --unloading thornton --overlaps 2e-5 0 3e-5"
        ),
    )
    add_law_arguments(curve)
    way = curve.add_mutually_exclusive_group(required=True)
    way.add_argument("--forces", type=force, nargs="+", metavar="N", help="turning points in N, from 0")
    way.add_argument("--overlaps", type=length, nargs="+", metavar="M", help="turning points in m, from 0")
    curve.add_argument("--steps", type=whole(), default=200, help="steps a branch (default 200)")
    curve.add_argument("--csv", type=output, help="file to write the curve to (default: print 20 rows)")
    curve.add_argument("--figure", type=output, help="picture to draw (png, pdf, svg)")
    curve.set_defaults(func=run_curve)


def run_curve(arguments):
    """Do what the command's arguments ask."""
    from demlaws import driver, granite, plots

    law = law_from(arguments)
    if arguments.forces is not None:
        path = driver.force_controlled(law, arguments.forces, arguments.steps)
    else:
        path = driver.displacement_controlled(law, arguments.overlaps, arguments.steps)
    if arguments.csv is not None:
        print(f"{granite.save_path(arguments.csv, path)}: {path.overlap.size} points")
    else:
        print(f"{'overlap (µm)':>14} {'force (N)':>12} {'K (N/mm)':>12} {'plastic (µm)':>13} {'work (J)':>12}")
        every = max(1, path.overlap.size // 20)
        for row in list(zip(path.overlap, path.force, path.stiffness, path.plastic_overlap, path.work, strict=True))[::every]:
            print(f"{row[0] * 1e6:14.4f} {row[1]:12.5g} {row[2] / 1e3:12.5g} {row[3] * 1e6:13.4f} {row[4]:12.4g}")
    if arguments.figure is not None:
        curve = law.unloading_law
        title = f"{law.name}, {f'{law.unloading} unloading' if curve is None else f'unloading along {curve.name}'}"
        print(plots.save(plots.path_figure(path, title), arguments.figure))
