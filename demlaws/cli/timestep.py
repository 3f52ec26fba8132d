"""`demlaws timestep`: the largest stable step of the contacts of a snapshot."""

import subprocess
from pathlib import Path

from demlaws.cli import example
from demlaws.cli.arguments import density
from demlaws.cli.contact import add_law_arguments, law_from
from demlaws.cli.output import record
from demlaws.errors import DemlawsError

LAYOUTS = {"index": (2, 3, 4, 5, 6), "c_": (7, 8, 10, 11, 12)}
"""First column of a dump of contacts → columns (from 1) of id1 id2 fx fy fz: as the exported cases of LAMMPS and of LIGGGHTS
write them (there: pair/gran/local pos id force_normal …)."""


def register(add):
    """Add this command."""
    parser = add(
        description="Computes the largest stable time step of a snapshot, 2/ω_max with shear and rotation, a rigorous bound, "
        "Rayleigh's step and the recommended step. SNAPSHOT is a scene saved by YADE (O.save), or a dump of the grains of "
        "LIGGGHTS or LAMMPS; CONTACTS is then the local dump of their contacts. The last frame of a dump is used. Dumps have "
        "no stiffness: give the law and the contact without radii. Contacts with walls are not in these dumps.",
        **example(
            "  demlaws timestep packing.yade.gz\n"
            "  demlaws timestep post/grains.5000.txt post/contacts.5000.txt --law pohrt-popov --unloading hertz \\\n"
            "      --young 60.6GPa --poisson 0.25 --roughness 1.7um --fractal-dimension 2.22"
        ),
    )
    parser.add_argument("snapshot", type=Path, metavar="SNAPSHOT", help="saved YADE scene, or dump with id x y z radius")
    parser.add_argument("contacts", type=Path, nargs="?", metavar="CONTACTS", help="local dump with ids and normal force")
    parser.add_argument(
        "--columns",
        type=int,
        nargs=5,
        metavar="N",
        help="columns id1 id2 fx fy fz of CONTACTS, counted from 1 (default: as in exported cases, 7 8 10 11 12 for LIGGGHTS, "
        "2 3 4 5 6 for LAMMPS)",
    )
    parser.add_argument(
        "--density",
        type=density,
        default=2650.0,
        help="density in kg/m³ if the dump contains no mass or density (default 2650)",
    )
    add_law_arguments(parser, law_required=False)
    parser.set_defaults(func=run)


def run(arguments):
    """Do what the command's arguments ask."""
    import numpy as np

    from demlaws.timestep import STEP_SAFETY, from_contacts
    from demlaws.yade.run import SCENES

    for path in filter(None, (arguments.snapshot, arguments.contacts)):
        if not path.is_file():
            raise DemlawsError(f"{path} does not exist")
    read = _from_yade if arguments.snapshot.name.endswith(SCENES) else _from_dumps
    pairs, normals, springs, masses, rayleigh, dt = read(arguments)
    if not len(pairs):
        raise DemlawsError(f"{arguments.snapshot}: no contact in it carries a force")
    limits = from_contacts(pairs, normals, *np.transpose(springs), masses)
    free = np.isfinite(masses)
    mean = np.sum(free[pairs]) / np.sum(free)
    print(f"{len(pairs)} contacts, {np.sum(free)} grains, {mean:.3g} contacts per grain")
    which = "between grains; walls are not in the dump" if dt is None else "as they are"
    print(f"exact limit       {limits.exact:.4g} s  2/ω_max with shear and rotation, contacts {which}")
    print(f"rigorous bound    {limits.bound:.4g} s  {limits.bound / limits.exact:.2f} of the exact limit")
    if rayleigh is not None:
        print(f"Rayleigh step     {rayleigh:.4g} s  {rayleigh / limits.exact:.2f} of the exact limit, for comparison")
    print(f"recommended step  {STEP_SAFETY * limits.exact:.4g} s  {STEP_SAFETY:g} of the exact limit; less if loads still grow")
    record(contacts=len(pairs), grains=int(np.sum(free)), exact=limits.exact, bound=limits.bound, rayleigh=rayleigh, step=dt)
    record(recommended=STEP_SAFETY * limits.exact)
    if dt is not None:
        unstable = ": unstable" if dt > limits.exact else ""
        print(f"the scene's step  {dt:.4g} s  {dt / limits.exact:.3g} of the exact limit{unstable}")


def _from_yade(arguments):
    """Arguments of `from_contacts`, Rayleigh's step and the scene's step [s]."""
    import json
    import tempfile

    import numpy as np

    from demlaws.yade.run import run as run_in_yade

    script = Path(__file__).parent.parent / "yade" / "snapshot.py"
    with tempfile.TemporaryDirectory() as scratch:
        result = Path(scratch) / "contacts.json"
        process = run_in_yade(
            script, [arguments.snapshot.absolute(), result], capture_output=True, text=True, stdin=subprocess.DEVNULL
        )
        if not result.is_file():
            raise DemlawsError(f"YADE cannot load {arguments.snapshot}: {(process.stdout + process.stderr).strip()[-300:]}")
        data = json.loads(result.read_text())
    if "error" in data:
        raise DemlawsError(f"{arguments.snapshot}: {data['error']}")
    arrays = [np.array(data[name]) for name in ("pairs", "normals", "springs", "masses")]
    return *arrays, data["rayleigh"], data["dt"]


def _frame(path, what):
    """Last frame of a dump of ATOMS or ENTRIES: its step, the periodic lengths of its box (inf: not periodic), its columns."""
    import numpy as np

    from demlaws.files import read_text

    items = [item.splitlines() for item in read_text(path).split("ITEM: ")[1:]]
    frame = {lines[0].split()[0]: lines for lines in items if lines}
    try:
        names, box = frame[what][0].split()[1:], frame["BOX"]
        rows = np.array([line.split() for line in frame[what][1:]], float).reshape(int(frame["NUMBER"][1]), len(names))
        edges = [float(high) - float(low) for low, high in (line.split() for line in box[1:4])]
        periodic = [word == "pp" for word in box[0].split()[-3:]]
        return frame["TIMESTEP"][1].strip(), np.where(periodic, edges, np.inf), dict(zip(names, rows.T, strict=True))
    except (KeyError, IndexError, ValueError) as error:
        raise DemlawsError(
            f"{path}: its end is no complete frame of {what} in an orthogonal box; is it a text dump, and has its run ended?"
        ) from error


def _from_dumps(arguments):
    """Arguments of `from_contacts`, Rayleigh's step [s] or None, and None: dumps do not hold the run's step."""
    import numpy as np

    from demlaws.timestep import rayleigh_step

    if arguments.contacts is None or arguments.law is None:
        raise DemlawsError(
            "a dump of grains needs CONTACTS, the dump of their contacts, and --law with the contact's quantities"
        )
    step, lengths, atoms = _frame(arguments.snapshot, "ATOMS")
    of_contacts, _, entries = _frame(arguments.contacts, "ENTRIES")
    if step != of_contacts:
        raise DemlawsError(f"{arguments.snapshot} is of step {step}, {arguments.contacts} of step {of_contacts}")
    missing = [name for name in ("id", "x", "y", "z", "radius") if name not in atoms]
    if missing:
        raise DemlawsError(f"{arguments.snapshot} lacks the columns {', '.join(missing)}")
    radius, centres = atoms["radius"], np.stack([atoms[axis] for axis in "xyz"], axis=1)
    volume = 4.0 / 3.0 * np.pi * radius**3
    mass = atoms["mass"] if "mass" in atoms else volume * atoms.get("density", arguments.density)
    columns = arguments.columns or LAYOUTS["index" if "index" in entries else "c_"]
    if not 1 <= min(columns) <= max(columns) <= len(entries):
        raise DemlawsError(f"{arguments.contacts} has the columns {' '.join(entries)}: name those needed with --columns")
    first, second, *force = (list(entries.values())[column - 1] for column in columns)
    number = {int(name): place for place, name in enumerate(atoms["id"])}
    try:
        pairs = np.array([(number[int(a)], number[int(b)]) for a, b in zip(first, second, strict=True)]).reshape(-1, 2)
    except KeyError as error:
        raise DemlawsError(f"{arguments.contacts}: grain {error} is not in {arguments.snapshot}; check --columns") from error
    between = centres[pairs[:, 0]] - centres[pairs[:, 1]]
    between -= np.where(np.isinf(lengths), 0.0, lengths) * np.round(between / lengths)
    distance = np.linalg.norm(between, axis=1)
    if np.any(np.abs(distance / radius[pairs].sum(axis=1) - 1.0) > 0.5):
        raise DemlawsError(f"{arguments.contacts}: grains in contact are far apart or one and the same; check --columns")
    normals = between / distance[:, None]
    force = np.abs(np.sum(normals * np.stack(force, axis=1), axis=1))
    pairs, normals, force = (array[force > 0.0] for array in (pairs, normals, force))
    ratio, rayleigh = 1.0, None
    if arguments.poisson is not None and arguments.young is not None:
        young, poisson = arguments.young[0], arguments.poisson[0]
        ratio = 2.0 * (1.0 - poisson) / (2.0 - poisson)
        kinds = set(zip(radius, mass / volume, strict=True))
        rayleigh = min(rayleigh_step(r, density, young, poisson) for r, density in kinds)
    stiffness = _stiffness(arguments, 1.0 / np.sum(1.0 / radius[pairs], axis=1), force) if len(pairs) else force
    return pairs, normals, np.stack([stiffness, ratio * stiffness], axis=1), mass, rayleigh, None


def _stiffness(arguments, radius, force):
    """The larger of the tangents [N/m] of loading and of unloading of each contact."""
    import numpy as np

    arguments.effective_radius = radius
    law = law_from(arguments)
    overlap, state = law.overlap(force), law.new_state(force.size) if law.state_size else None
    loading = law.evaluate(overlap, state)[1].copy()
    return np.maximum(loading, law.evaluate(overlap * (1.0 - 2.0**-36), state)[1])
