"""Arguments that describe a contact, a law and its unloading, shared by the commands."""

from pathlib import Path

from demlaws.cli import option
from demlaws.cli.arguments import length, plain, pressure, radius
from demlaws.errors import DemlawsError


def add_law_arguments(parser, law_required=True):
    """Arguments that name a law and its contact."""
    text = "name of the law (list: demlaws laws), or a table file, whose contact is the default"
    parser.add_argument("--law", required=law_required, help=text)
    add_unloading_arguments(parser)
    add_contact_arguments(parser)


def add_unloading_arguments(parser):
    """Arguments beside the name of a law: its unloading and its options."""
    parser.add_argument(
        "--unloading",
        help="unloading rule: elastic, hertz, thornton, a rule of this law only (list: demlaws laws NAME), or a table file "
        "with the unloading curve (default: that of the law, see demlaws laws NAME)",
    )
    parser.add_argument("--option", type=option, action="append", default=[], metavar="NAME=VALUE", help="option of the law")


def add_contact_arguments(parser, test=True, modulus=True):
    """Arguments that describe one contact of two bodies. test: also by the name of a granite test; modulus: also by E*."""
    contact = parser.add_argument_group(
        "contact (SI units, or with a unit: 4.35mm, 2.4um, 60GPa)",
        "--radius needs both bodies. One value of --material, --young, --poisson or --roughness applies to both, two apply "
        "to the first and the second body.",
    )
    if test:
        contact.add_argument(
            "--test", help="use a contact of the granite tests of Altuhafi et al. (2023), for instance SS(18-18)"
        )
    pair = {"nargs": "+"}
    contact.add_argument(
        "--radius", type=radius, **pair, help="radius of the first and of the second body in m; flat for a flat"
    )
    contact.add_argument(
        "--effective-radius", type=length, help="effective radius R in m, 1/R = 1/R1 + 1/R2, in place of --radius"
    )
    contact.add_argument(
        "--material",
        **pair,
        help="material with typical values of all quantities below, for instance granite (list: demlaws materials); those that "
        "are given replace its own",
    )
    contact.add_argument("--young", type=pressure, **pair, help="Young's modulus of each body in Pa")
    contact.add_argument("--poisson", type=plain, **pair, help="Poisson's ratio of each body, with --young")
    if modulus:
        contact.add_argument("--modulus", type=pressure, help="effective modulus E* in Pa, in place of --young and --poisson")
    else:
        parser.set_defaults(modulus=None)
    contact.add_argument(
        "--roughness",
        type=length,
        **pair,
        help="rms roughness Sq of each surface in m, required by laws of rough contacts; 0 is smooth",
    )
    contact.add_argument(
        "--sigma", "--combined-roughness", type=length, help="σ = √(Sq1² + Sq2²) of the pair in m, in place of --roughness"
    )
    contact.add_argument("--fractal-dimension", type=plain, help="fractal dimension Df, from 2 to 3")
    contact.add_argument("--hardness", type=pressure, help="hardness of the softer body in Pa")


def add_dump_arguments(parser):
    """Arguments that name the two dumps, their columns, and the law."""
    parser.add_argument("snapshot", type=Path, metavar="GRAINS", help="dump with id x y z radius")
    parser.add_argument("contacts", type=Path, metavar="CONTACTS", help="local dump with ids and force vectors")
    parser.add_argument(
        "--columns",
        type=int,
        nargs="+",
        metavar="N",
        help="column numbers (from 1) of id1 id2 fx fy fz [largest overlap [plastic overlap]] in CONTACTS; not needed for "
        "dumps of exported cases",
    )
    add_law_arguments(parser, law_required=False)


def _pair(arguments, name, replaced_by=None):
    """Values of an option for the first and the second body, or None."""
    values = getattr(arguments, name)
    if values is None:
        return None
    if replaced_by is not None and getattr(arguments, replaced_by, None) is not None:
        raise DemlawsError(f"give either --{name} or --{replaced_by.replace('_', '-')}")
    if len(values) > 2:
        raise DemlawsError(f"--{name} has {len(values)} values: give one for both bodies, or one for each")
    return values[0], values[-1]


def bodies_from(arguments):
    """The materials of both bodies, or None where neither --material nor --young and --poisson are given."""
    from demlaws.contact import Material
    from demlaws.materials import material

    names = _pair(arguments, "material", "test")
    young, poisson = (_pair(arguments, name, "modulus") for name in ("young", "poisson"))
    if names is None and young is None and poisson is None:
        return None
    if names is None and (young is None or poisson is None):
        raise DemlawsError("--young and --poisson belong together: give both, or --modulus")
    own = [{}, {}] if names is None else [vars(material(name)) for name in names]
    given = {name: pair for name, pair in (("young", young), ("poisson", poisson)) if pair is not None}
    return tuple(Material(**{**own[place], **{name: pair[place] for name, pair in given.items()}}) for place in (0, 1))


def contact_from(arguments, base=None, **measured):
    """The contact that the arguments describe, with the measured fields in place of arguments.

    base: the contact whose fields are taken where no argument gives them.
    """
    from demlaws import granite
    from demlaws.contact import Contact, joined_radius, joined_roughness

    if getattr(arguments, "test", None) is not None:
        base = granite.find_test(arguments.test).contact
    bodies = bodies_from(arguments)
    pair = bodies and Contact.between(*bodies, radius1=1.0, radius2=1.0)
    given = {name: getattr(arguments, name) for name in ("modulus", "sigma", "fractal_dimension", "hardness")}
    given["radius"] = arguments.effective_radius
    if (radii := _pair(arguments, "radius", "effective_radius")) is not None:
        if len(arguments.radius) < 2:
            one = getattr(arguments.radius[0], "text", "flat")
            raise DemlawsError(
                f"--radius {one}: give both bodies, --radius {one} flat for a sphere on a flat, --radius {one} {one} for two "
                "equal spheres (or --effective-radius)"
            )
        given["radius"] = joined_radius(*radii, ("--radius", "--radius"))
    sources = vars(base) if base else {}, {**vars(pair), "radius": None} if pair else {}, given, measured
    fields = {name: value for source in sources for name, value in source.items() if value is not None}
    options = {
        "radius": "--radius (or --effective-radius)",
        "modulus": "--material, or --young and --poisson (or --modulus)",
    }
    missing = [text for name, text in options.items() if name not in fields]
    if missing:
        tests = ", or --test for that of a granite test" if hasattr(arguments, "test") else ""
        raise DemlawsError(f"{' and '.join(missing)} missing: give the contact{tests}")
    if (sq := _pair(arguments, "roughness", "sigma")) is not None:
        fields["sigma"] = joined_roughness(*sq, fields["radius"], ("--roughness", "--roughness"))
    return Contact(**{**fields, **measured})


def law_from(arguments):
    """The law that the arguments name: with its name or as a table file."""
    from demlaws import granite
    from demlaws.files import names_a_file
    from demlaws.law import Table
    from demlaws.laws.registry import find
    from demlaws.make import law

    if names_a_file(arguments.law):
        if arguments.option:
            raise DemlawsError(
                f"--option {arguments.option[0][0]}: the table {arguments.law} has the options of its law already"
            )
        table = Table.load(arguments.law)
        bound = table.bound_to(contact_from(arguments, table.contact))
        return bound if arguments.unloading is None else bound.joined(arguments.unloading)
    definition = find(arguments.law)
    options = dict(arguments.option)
    if arguments.test is not None:
        options = {**granite.options_for(definition.name, granite.find_test(arguments.test)), **options}
    return law(definition.name, contact_from(arguments), arguments.unloading, **options)


def unloads(law):
    """Name of a law and of its unloading rule, or of the curve that it unloads along."""
    curve = law.unloading_law
    return f"{law.name}, {f'{law.unloading} unloading' if curve is None else f'unloading along {curve.name}'}"


def describe(contact):
    """One line with the effective quantities of a contact."""
    text = f"contact: R = {contact.radius * 1e3:.5g} mm, E* = {contact.modulus / 1e9:.5g} GPa"
    return text if contact.sigma is None else text + f", σ = {contact.sigma * 1e6:.4g} µm"


def draw(result, path, make):
    """Save the figure that `make(plots)` returns, if a path is given; print the path."""
    if path is not None:
        from demlaws import plots
        from demlaws.plots import surface  # noqa: F401  `plots.surface`

        result.print(plots.save(make(plots), path))
