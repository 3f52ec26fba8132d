"""`demlaws contacts`: the contacts of dumps of LIGGGHTS and LAMMPS, and lines between the grains for ParaView."""

from demlaws.cli import example
from demlaws.cli.contact import add_dump_arguments, law_from
from demlaws.cli.output import csv_file, lines_file

TITLES = ("body1", "body2", "overlap (m)", "force (N)")
"""First titles of the CSV file."""


def register(add):
    """Add this command."""
    parser = add(
        description="Lists the contacts of a dump: bodies, overlap, normal force, largest and plastic overlap, which have "
        "deformed plastically (keep a plastic overlap) and, of LAMMPS, stored and dissipated energy; with --law and the "
        "contact without radii also stiffness, contact radius and conductance over conductivity. GRAINS is a dump of the "
        "grains of LIGGGHTS or LAMMPS, CONTACTS the local dump of their contacts; the last frame is used. --vtk writes lines "
        'between the centres with these columns. In YADE: law.contacts().save("contacts.vtu").',
        **example(
            "  demlaws contacts post/grains.5000.txt post/contacts.5000.txt --vtk contacts.vtu\n"
            "  demlaws contacts post/grains.5000.txt post/contacts.5000.txt --law pohrt-popov --unloading hertz \\\n"
            "      --young 60.6GPa --poisson 0.25 --roughness 1.7um --fractal-dimension 2.22 --csv contacts.csv"
        ),
    )
    parser.add_argument("--vtk", type=lines_file, help="write lines for ParaView: .vtu or .vtk")
    parser.add_argument("--csv", type=csv_file(TITLES, last=False), help="write all columns as CSV")
    add_dump_arguments(parser)


def run(arguments, result):
    """Do what the command's arguments ask."""
    table = read(arguments, result)
    columns = table.columns()
    result.write_csv(arguments.csv, list(columns), zip(*columns.values(), strict=True))
    if arguments.vtk:
        result.print(table.save(arguments.vtk))
    result.print(table)
    flattened = table.flattened
    result.values = {"contacts": len(table), "flattened": None if flattened is None else int(flattened.sum())}
    if flattened is None:
        result.print_wrapped(
            "history: not in this dump (no law with history, or name its columns behind those of the force: --columns)"
        )
    elif len(table):
        result.print(f"{int(flattened.sum())} of {len(table)} contacts have deformed plastically")


def read(arguments, result):
    """`Contacts` of the two dumps that the arguments name."""
    import numpy as np

    from demlaws.cli.dumps import read_dumps, stiffness_of
    from demlaws.responses.contacts import Contacts

    dumped = read_dumps(arguments)
    overlap, rounding, known = dumped.overlap, dumped.rounding, dict(dumped.known)
    if np.any(rounding > 0.01 * np.abs(overlap)):
        error = float(np.max(rounding))
        result.print_wrapped(
            f"overlaps are computed from the rounded positions of {arguments.snapshot} (error {error:.1g} m): dump more digits"
        )
    if arguments.law is not None and len(dumped.pairs):
        arguments.effective_radius = dumped.radius
        law = law_from(arguments)
        known["stiffness"] = stiffness_of(arguments.contacts, dumped, law)
        known["modulus"] = np.broadcast_to(law.contact.modulus, overlap.shape).copy()
    if "plastic_overlap" in known:
        known["flattened"] = known["plastic_overlap"] > 0.0
    if "maximum_overlap" in known:
        known["branch"] = (overlap + rounding < known["maximum_overlap"]).astype(int)
    bodies = dumped.atoms["id"].astype(int)[dumped.pairs]
    first = np.stack([dumped.atoms[axis] for axis in "xyz"], axis=1)[dumped.pairs[:, 0]]
    places = {"centre1": first, "centre2": first - dumped.between}
    return Contacts(bodies[:, 0], bodies[:, 1], overlap, dumped.force, radius=dumped.radius, **known, **places)
