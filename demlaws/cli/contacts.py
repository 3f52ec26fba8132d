"""`demlaws contacts`: the contacts of dumps of LIGGGHTS and LAMMPS, and lines between the grains for ParaView."""

from pathlib import Path

from demlaws.cli import example
from demlaws.cli.contact import add_law_arguments, law_from
from demlaws.cli.output import Output
from demlaws.cli.timestep import contacts_of_dump, frames, stiffness_of_dump
from demlaws.errors import DemlawsError


def register(add):
    """Add this command."""
    parser = add(
        description="Lists the contacts of a dump: bodies, overlap, normal force, largest and plastic overlap, which have "
        "deformed plastically (keep a plastic overlap) and, of LAMMPS, stored and dissipated energy; with --law and the "
        "contact without radii also stiffness, contact radius and conductance over conductivity. GRAINS is a dump of the "
        "grains of LIGGGHTS or LAMMPS, CONTACTS the local dump of their contacts; the last frame is used. --vtk writes lines "
        'between the centres with these columns. In YADE: law.contacts().save("contacts.vtp").',
        **example(
            "  demlaws contacts post/grains.5000.txt post/contacts.5000.txt --vtk contacts.vtp\n"
            "  demlaws contacts post/grains.5000.txt post/contacts.5000.txt --law pohrt-popov --unloading hertz \\\n"
            "      --young 60.6GPa --poisson 0.25 --roughness 1.7um --fractal-dimension 2.22 --csv contacts.csv"
        ),
    )
    parser.add_argument("snapshot", type=Path, metavar="GRAINS", help="dump with id x y z radius")
    parser.add_argument("contacts", type=Path, metavar="CONTACTS", help="local dump with ids and normal force")
    parser.add_argument(
        "--columns",
        type=int,
        nargs=5,
        metavar="N",
        help="columns id1 id2 fx fy fz of CONTACTS, from 1; needed unless they are named as in exported cases",
    )
    parser.add_argument("--largest-overlap", type=int, metavar="N", help="column of the largest overlap (p13, δmax)")
    parser.add_argument("--plastic-overlap", type=int, metavar="N", help="column of the plastic overlap (p14)")
    parser.add_argument("--vtk", type=Output(), metavar="FILE", help="write lines for ParaView: .vtp, .vtu or .vtk")
    parser.add_argument("--csv", type=Output(), metavar="FILE", help="write all columns as CSV")
    add_law_arguments(parser, law_required=False)
    parser.set_defaults(func=run)


def run(arguments, result):
    """Do what the command's arguments ask."""
    table = read(arguments, result)
    if arguments.csv:
        columns = table.columns()
        result.write_csv(arguments.csv, list(columns), zip(*columns.values(), strict=True))
    if arguments.vtk:
        result.print(table.save(arguments.vtk))
    result.print(table)
    flattened = table.flattened
    result.values = {"contacts": len(table), "flattened": None if flattened is None else int(flattened.sum())}
    if flattened is None:
        result.say("history: not in this dump (no law with history, or name its columns: --largest-overlap, --plastic-overlap)")
    elif len(table):
        result.print(f"{int(flattened.sum())} of {len(table)} contacts have deformed plastically")
    return 0


def read(arguments, result):
    """`Contacts` of the two dumps that the arguments name."""
    import numpy as np

    from demlaws.responses.contacts import Contacts

    for path in (arguments.snapshot, arguments.contacts):
        if not path.is_file():
            raise DemlawsError(f"{path} {'is a folder' if path.is_dir() else 'does not exist'}")
    atoms, lengths, entries, resolution = frames(arguments)
    pairs, between, force, known = contacts_of_dump(arguments, atoms, lengths, entries)
    touching = force > 0.0
    pairs, between, force = pairs[touching], between[touching], force[touching]
    known = {name: values[touching] for name, values in known.items()}
    radius, distance = atoms["radius"][pairs], np.linalg.norm(between, axis=1)
    rounding = np.abs(between / distance[:, None]) @ resolution[:3] + resolution[3]
    if "overlap" in known:
        rounding = 0.0 * rounding
    overlap = known.pop("overlap", radius.sum(axis=1) - distance)
    if "maximum_overlap" in known and np.any(known["maximum_overlap"] < overlap - rounding - 1e-5 * np.abs(overlap)):
        raise DemlawsError(
            f"{arguments.contacts}: largest overlaps below the present ones; name the columns with --largest-overlap and "
            "--plastic-overlap"
        )
    if np.any(rounding > 0.01 * np.abs(overlap)):
        error = float(np.max(rounding))
        result.say(
            f"overlaps are computed from the rounded positions of {arguments.snapshot} (error {error:.1g} m): dump more digits"
        )
    centres = np.stack([atoms[axis] for axis in "xyz"], axis=1)
    first = centres[pairs[:, 0]]
    bodies = atoms["id"].astype(int)[pairs]
    effective = 1.0 / np.sum(1.0 / radius, axis=1)
    if arguments.law is not None and len(pairs):
        known |= _stiffnesses(arguments, result, effective, force, known.get("maximum_overlap"), overlap, rounding)
    if "plastic_overlap" in known:
        known["flattened"] = known["plastic_overlap"] > 0.0
    if "maximum_overlap" in known:
        known["branch"] = (overlap + rounding < known["maximum_overlap"]).astype(int)
    return Contacts(
        bodies[:, 0], bodies[:, 1], overlap, force, radius=effective, **known, centre1=first, centre2=first - between
    )


def _stiffnesses(arguments, result, radius, force, largest, overlap, rounding):
    """Stiffness and modulus of the contacts by the law that the arguments name; without them if the history is not known."""
    import numpy as np

    arguments.effective_radius = radius
    law = law_from(arguments)
    stiffness, history, note = stiffness_of_dump(arguments.contacts, law, force, largest, overlap, rounding)
    if note:
        result.say(note)
    if history == "stiffest":
        result.say("stiffness: not known without the largest overlap of each contact (--largest-overlap)")
        return {}
    return {"stiffness": stiffness, "modulus": np.broadcast_to(law.contact.modulus, stiffness.shape).copy()}
