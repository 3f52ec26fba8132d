"""`demlaws contacts`: the contacts of dumps of LIGGGHTS and LAMMPS, and lines between the grains for ParaView."""

from pathlib import Path

from demlaws.cli import example
from demlaws.cli.output import Output, record, say, write_csv
from demlaws.cli.timestep import LAMMPS_CASE, contacts_of_dump, frames
from demlaws.errors import DemlawsError

LAMMPS_OUTPUTS = {"maximum_overlap": 7, "plastic_overlap": 8, "stored": 9, "dissipated": 10}
"""Columns (from 1) of the contacts of an exported LAMMPS case: p13 to p16."""
LIGGGHTS_CASE = [f"c_contacts[{i}]" for i in range(1, 13)]
"""First columns of the contacts of an exported LIGGGHTS case; behind them largest and plastic overlap of laws with history, and
the overlap."""


def register(add):
    """Add this command."""
    parser = add(
        description="Lists the contacts of a dump: bodies, overlap, normal force, largest and plastic overlap, which have "
        "yielded (keep a plastic overlap) and, of LAMMPS, stored and dissipated energy. GRAINS is a dump of the grains of "
        "LIGGGHTS or LAMMPS, CONTACTS the local dump of their contacts; the last frame is used. --vtk writes lines between the "
        'centres with these columns. In YADE: law.contacts().save("contacts.vtp").',
        **example("  demlaws contacts post/grains.5000.txt post/contacts.5000.txt --vtk contacts.vtp"),
    )
    parser.add_argument("snapshot", type=Path, metavar="GRAINS", help="dump with id x y z radius")
    parser.add_argument("contacts", type=Path, metavar="CONTACTS", help="local dump with ids and normal force")
    parser.add_argument(
        "--columns",
        type=int,
        nargs=5,
        metavar="N",
        help="columns id1 id2 fx fy fz of CONTACTS, from 1 (default: exported cases')",
    )
    parser.add_argument("--largest-overlap", type=int, metavar="N", help="column of the largest overlap (p13, δmax)")
    parser.add_argument("--plastic-overlap", type=int, metavar="N", help="column of the plastic overlap (p14)")
    parser.add_argument("--vtk", type=Output(), metavar="FILE", help="write lines for ParaView: .vtp, .vtu or .vtk")
    parser.add_argument("--csv", type=Output(), metavar="FILE", help="write all columns as CSV")
    parser.set_defaults(func=run)


def run(arguments):
    """Do what the command's arguments ask."""
    table = read(arguments)
    if arguments.csv:
        columns = table.columns()
        write_csv(arguments.csv, list(columns), zip(*columns.values(), strict=True))
    if arguments.vtk:
        print(table.save(arguments.vtk))
    print(table)
    yielded = table.yielded
    record(contacts=len(table), yielded=None if yielded is None else int(yielded.sum()))
    if yielded is None:
        say("history: not in this dump (no law with history, or name its columns: --largest-overlap, --plastic-overlap)")
    elif len(table):
        print(f"{int(yielded.sum())} of {len(table)} contacts have yielded")
    return 0


def read(arguments):
    """`Contacts` of the two dumps that the arguments name."""
    import numpy as np

    from demlaws.responses.contacts import Contacts

    for path in (arguments.snapshot, arguments.contacts):
        if not path.is_file():
            raise DemlawsError(f"{path} does not exist")
    atoms, lengths, entries, resolution = frames(arguments)
    history = _history(arguments, entries)
    pairs, between, force, _ = contacts_of_dump(arguments, atoms, lengths, entries)
    touching = force > 0.0
    pairs, between, force = pairs[touching], between[touching], force[touching]
    columns = list(entries.values())
    known = {name: columns[number - 1][touching] for name, number in history.items()}
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
        say(f"overlaps are computed from the rounded positions of {arguments.snapshot} (error {error:.1g} m): dump more digits")
    centres = np.stack([atoms[axis] for axis in "xyz"], axis=1)
    first = centres[pairs[:, 0]]
    bodies = atoms["id"].astype(int)[pairs]
    effective = 1.0 / np.sum(1.0 / radius, axis=1)
    if "plastic_overlap" in known:
        known["yielded"] = known["plastic_overlap"] > 0.0
    if "maximum_overlap" in known:
        known["branch"] = (overlap + rounding < known["maximum_overlap"]).astype(int)
    return Contacts(
        bodies[:, 0], bodies[:, 1], overlap, force, radius=effective, **known, centre1=first, centre2=first - between
    )


def _history(arguments, entries):
    """Name of a quantity → its column from 1: as the arguments name it, or as exported cases have it."""
    given = {"maximum_overlap": arguments.largest_overlap, "plastic_overlap": arguments.plastic_overlap}
    given = {name: number for name, number in given.items() if number is not None}
    for name, number in given.items():
        if not 1 <= number <= len(entries):
            raise DemlawsError(f"--{name.replace('_', '-')} {number}: {arguments.contacts} has {len(entries)} columns")
    if given or arguments.columns is not None:
        return given
    names = list(entries)
    if names == LAMMPS_CASE:
        return LAMMPS_OUTPUTS
    if names[:12] == LIGGGHTS_CASE and len(names) in (13, 15):
        return dict(zip(("maximum_overlap", "plastic_overlap", "overlap")[15 - len(names) :], range(13, 16), strict=False))
    return {}
