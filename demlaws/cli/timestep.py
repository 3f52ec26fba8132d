"""`demlaws timestep`: the largest stable step of the contacts of a snapshot."""

import math
import subprocess
from pathlib import Path
from typing import Any, NamedTuple

from demlaws.cli import example
from demlaws.cli.arguments import density, plain
from demlaws.cli.contact import add_law_arguments, law_from
from demlaws.errors import DemlawsError

LAMMPS_CASE = ["index", "c_ids[1]", "c_ids[2]", *(f"c_contacts[{i}]" for i in range(1, 8))]
"""Columns of the contacts of an exported LAMMPS case, of a stock one the first six: index, id1 id2, fx fy fz, p13 to p16."""
LIGGGHTS_CASE = [f"c_contacts[{i}]" for i in range(1, 13)]
"""First columns of the contacts of an exported LIGGGHTS case: two places, id1 id2 and a flag, fx fy fz; behind them largest and
plastic overlap of laws with history, and the overlap."""
LAMMPS_HISTORY = {"maximum_overlap": 7, "plastic_overlap": 8, "stored": 9, "dissipated": 10}
"""Columns (from 1) of an exported LAMMPS case of demlaws."""
MOST_APART, NOTED_APART = 2.0, 1.25
"""Median ratio of the overlaps of a dump to those of the law at its forces: refused beyond the first, noted beyond the second.
Damping in a packing that moves changes it by some tenths."""


def register(add):
    """Add this command."""
    parser = add(
        description="Computes the largest stable time step of a snapshot, 2/ω_max with shear and rotation, a rigorous bound, "
        "Rayleigh's step and the recommended step. SNAPSHOT is a scene saved by YADE (O.save), or a dump of the grains of "
        "LIGGGHTS or LAMMPS; CONTACTS is then the local dump of their contacts. The last frame of a dump is used. Dumps have "
        "no stiffness: give the law and the contact without radii. For a law with history the largest overlap of each contact "
        "is read (exported cases, or --largest-overlap); without it the stiffest tangent of all histories that allow "
        "the forces and overlaps is used, a safe limit instead of the exact one. No contact is assumed to slide. Contacts "
        "with walls are not in these dumps.",
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
        help="columns id1 id2 fx fy fz of CONTACTS, counted from 1; needed unless the columns are named as in exported cases",
    )
    parser.add_argument(
        "--largest-overlap",
        type=int,
        metavar="N",
        help="column of CONTACTS with the largest overlap so far in m (p13 of LAMMPS, δmax in the history of LIGGGHTS)",
    )
    parser.add_argument("--friction", type=plain, help="coefficient of friction of a dump; 0: no tangential stiffness")
    parser.add_argument("--no-rotation", action="store_true", help="the grains of a dump do not rotate")
    parser.add_argument(
        "--shear-ratio", type=plain, help="K_t/K of a dump, above 0, at most 4/3 (default: from --poisson, otherwise 1)"
    )
    parser.add_argument(
        "--density",
        type=density,
        default=2650.0,
        help="density in kg/m³ if the dump contains no mass or density (default 2650)",
    )
    add_law_arguments(parser, law_required=False)
    parser.set_defaults(func=run)


class Snapshot(NamedTuple):
    """Contacts of a snapshot."""

    pairs: Any
    normals: Any
    springs: Any  # K_n and K_t of each contact [N/m]
    masses: Any  # [kg]
    blocked: Any  # (bodies, 6) degrees of freedom
    rayleigh: float | None  # [s]
    step: float | None  # of the scene [s]; dumps do not contain it
    history: str  # of the contacts: "known", "none" or "stiffest"
    note: str = ""


def run(arguments, result):
    """Do what the command's arguments ask."""
    import numpy as np

    from demlaws.timestep import STEP_SAFETY, from_contacts
    from demlaws.yade.run import SCENES

    for path in filter(None, (arguments.snapshot, arguments.contacts)):
        if not path.is_file():
            raise DemlawsError(f"{path} {'is a folder' if path.is_dir() else 'does not exist'}")
    read = _from_yade if arguments.snapshot.name.endswith(SCENES) else _from_dumps
    shot = read(arguments)
    if not len(shot.pairs):
        raise DemlawsError(f"{arguments.contacts or arguments.snapshot}: no contact in it carries a force")
    normal, shear = np.transpose(shot.springs)
    limits = from_contacts(shot.pairs, shot.normals, normal, shear_stiffness=shear, masses=shot.masses, blocked=shot.blocked)
    free = np.isfinite(shot.masses)
    mean = np.sum(free[shot.pairs]) / np.sum(free)
    name = "safe limit" if shot.history == "stiffest" else "exact limit"
    motion = "with shear and rotation" if shear.any() else "without friction"
    if shear.any() and np.all(np.asarray(shot.blocked)[free, 3:]):
        motion = "with shear, without rotation"
    which = "between grains" if shot.step is None else "as they are"
    result.print(f"{len(shot.pairs)} contacts, {np.sum(free)} grains, {mean:.3g} contacts per grain")
    result.say(f"{name:<17} {limits.exact:.4g} s  2/ω_max {motion}, contacts {which}", " " * 18)
    if shot.history == "stiffest":
        result.say(
            "history           the stiffest tangent of all histories that allow the contacts' forces and overlaps", " " * 18
        )
    if shot.note:
        result.say(f"note              {shot.note}", " " * 18)
    share = f"of the {name}"
    result.print(f"rigorous bound    {limits.bound:.4g} s  {limits.bound / limits.exact:.2f} {share}")
    if shot.rayleigh is not None:
        result.print(f"Rayleigh step     {shot.rayleigh:.4g} s  {shot.rayleigh / limits.exact:.2f} {share}, for comparison")
    result.print(f"recommended step  {STEP_SAFETY * limits.exact:.4g} s  {STEP_SAFETY:g} {share}; less if loads still grow")
    result.values = {
        "contacts": len(shot.pairs),
        "grains": int(np.sum(free)),
        "exact": limits.exact,
        "bound": limits.bound,
        "rayleigh": shot.rayleigh,
        "step": shot.step,
        "recommended": STEP_SAFETY * limits.exact,
        "history": shot.history,
        "motion": motion,
    }
    if shot.step is not None:
        unstable = ": unstable" if shot.step > limits.exact else ""
        result.print(f"the scene's step  {shot.step:.4g} s  {shot.step / limits.exact:.3g} {share}{unstable}")


def _from_yade(arguments):
    """`Snapshot` of a saved scene."""
    import json
    import tempfile

    import numpy as np

    from demlaws.yade.run import run as run_in_yade

    if arguments.friction is not None or arguments.shear_ratio is not None or arguments.no_rotation:
        raise DemlawsError("a YADE scene contains friction, K_t and blocked rotations: leave out the options for dumps")
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
    arrays = [np.array(data[name]) for name in ("pairs", "normals", "springs", "masses", "blocked")]
    return Snapshot(*arrays, data["rayleigh"], data["dt"], "known")


class Frame(NamedTuple):
    """Last frame of a dump."""

    step: str
    lengths: Any  # of the box's periodic edges [m]; inf: not periodic
    columns: dict  # name → values
    resolution: Any  # last digits of x, y, z and radius [m]


def _frame(path, what):
    """`Frame` of a dump of ATOMS or ENTRIES."""
    import numpy as np

    from demlaws.files import read_text

    items = [item.splitlines() for item in read_text(path).split("ITEM: ")[1:]]
    frame = {lines[0].split()[0]: lines for lines in items if lines}
    try:
        names, box = frame[what][0].split()[1:], frame["BOX"]
        text = np.array([line.split() for line in frame[what][1:]]).reshape(int(frame["NUMBER"][1]), len(names))
        columns = dict(zip(names, text.astype(float).T, strict=True))
        places = [k for k, name in enumerate(names) if name in _PLACES]
        resolution = _resolution(text[:, places].ravel(), columns) if len(places) == len(_PLACES) else None
        edges = [float(high) - float(low) for low, high in (line.split() for line in box[1:4])]
        periodic = [word == "pp" for word in box[0].split()[-3:]]
        return Frame(frame["TIMESTEP"][1].strip(), np.where(periodic, edges, np.inf), columns, resolution)
    except (KeyError, IndexError, ValueError) as error:
        raise DemlawsError(
            f"{path}: no complete last frame of {what} in an orthogonal box: write a text dump, after the run has ended"
        ) from error


_PLACES = ("x", "y", "z", "radius")


def _resolution(words, columns):
    """Last digit of the largest number of each column of places, if all are printed with as many digits as the longest."""
    digits = max((len(word.lower().split("e")[0].lstrip("-+0.").replace(".", "")) for word in words), default=1)
    largest = [max(map(abs, columns[name]), default=0.0) for name in _PLACES]
    return [10.0 ** (math.floor(math.log10(size)) + 1 - digits) if size > 0.0 else 0.0 for size in largest]


def frames(arguments):
    """Columns of the grains, periodic lengths of the box [m] and columns of the contacts, of the two dumps' last frames;
    last digits of the places."""
    step, lengths, atoms, resolution = _frame(arguments.snapshot, "ATOMS")
    of_contacts, _, entries, _ = _frame(arguments.contacts, "ENTRIES")
    if step != of_contacts:
        raise DemlawsError(f"{arguments.snapshot} is of step {step}, {arguments.contacts} of step {of_contacts}")
    missing = [name for name in ("id", *_PLACES) if name not in atoms]
    if missing:
        raise DemlawsError(f"{arguments.snapshot} lacks the columns {', '.join(missing)}")
    if not len(atoms["id"]):
        raise DemlawsError(f"{arguments.snapshot}: its last frame has no grains")
    needed = ("id", *_PLACES, "mass", "density")
    _check_finite(arguments.snapshot, {name: atoms[name] for name in needed if name in atoms})
    return atoms, lengths, entries, resolution


def _check_finite(path, columns):
    """Raise where a value is NaN or infinite: its contacts would be left out."""
    import numpy as np

    for name, values in columns.items():
        for row in np.flatnonzero(~np.isfinite(values))[:1]:
            raise DemlawsError(f"{path}: {name} of row {row + 1} is {values[row]}: has the run diverged?")


def _from_dumps(arguments):
    """`Snapshot` of dumps."""
    import numpy as np

    if arguments.contacts is None or arguments.law is None:
        raise DemlawsError(
            "a dump of grains needs CONTACTS, the dump of their contacts, and --law with the contact's quantities"
        )
    atoms, lengths, entries, resolution = frames(arguments)
    radius = atoms["radius"]
    volume = 4.0 / 3.0 * np.pi * radius**3
    mass = atoms["mass"] if "mass" in atoms else volume * atoms.get("density", arguments.density)
    _refuse_clumps(arguments.snapshot, atoms)
    pairs, normals, force, known = contacts_of_dump(arguments, atoms, lengths, entries)
    touching = force > 0.0
    pairs, normals, force = pairs[touching], normals[touching], force[touching]
    largest, overlap = (
        None if (array := known.get(name)) is None else array[touching] for name in ("maximum_overlap", "overlap")
    )
    rounding = np.zeros(len(pairs))
    if overlap is None:
        overlap = radius[pairs].sum(axis=1) - np.linalg.norm(normals, axis=1)
    normals = normals / np.linalg.norm(normals, axis=1)[:, None]
    if "overlap" not in known:
        rounding = np.abs(normals) @ resolution[:3] + resolution[3]  # half a digit of each of two grains
    ratio, rayleigh = _ratio_and_rayleigh(arguments, set(zip(radius, mass / volume, strict=True)))
    if not len(pairs):
        return Snapshot(pairs, normals, np.zeros((0, 2)), mass, None, rayleigh, None, "none")
    arguments.effective_radius = 1.0 / np.sum(1.0 / radius[pairs], axis=1)
    law = law_from(arguments)
    stiffness, history, note = stiffness_of_dump(arguments.contacts, law, force, largest, overlap, rounding)
    blocked = np.zeros((len(mass), 6), bool)
    blocked[:, 3:] = arguments.no_rotation
    springs = np.stack([stiffness, ratio * stiffness], axis=1)
    return Snapshot(pairs, normals, springs, mass, blocked, rayleigh, None, history, note)


def _refuse_clumps(path, atoms):
    """Raise where grains are members of rigid clumps: their mass and inertia are those of the clump, which no dump contains."""
    import numpy as np
    from scipy.spatial import cKDTree

    remedy = "a clump moves as one body, whose mass and inertia the dump does not contain: the limit cannot be computed"
    if "mol" in atoms:
        for number in atoms["mol"][atoms["mol"] > 0.0]:
            if np.sum(atoms["mol"] == number) > 1:
                raise DemlawsError(
                    f"{path}: {np.sum(atoms['mol'] == number)} grains have mol {number:.0f}: {remedy}; "
                    "dump no mol if each moves by itself"
                )
    if len(atoms["id"]) < 2:
        return
    centres = np.stack([atoms[axis] for axis in "xyz"], axis=1)
    distance, nearest = cKDTree(centres).query(centres, k=2)
    deep = distance[:, 1] < 0.7 * (atoms["radius"] + atoms["radius"][nearest[:, 1]])
    for one in np.flatnonzero(deep)[:1]:
        raise DemlawsError(
            f"{path}: grains {atoms['id'][one]:.0f} and {atoms['id'][nearest[one, 1]]:.0f} overlap by more than 0.3 of their "
            f"radii, like members of a clump: {remedy}"
        )


def columns_of(arguments, entries):
    """Columns (from 1) of id1 id2 fx fy fz, and name of a quantity → its column: as the arguments name them, or all names of an
    exported case."""
    names = list(entries)
    given = {"maximum_overlap": arguments.largest_overlap, "plastic_overlap": getattr(arguments, "plastic_overlap", None)}
    given = {name: number for name, number in given.items() if number is not None}
    for name, number in given.items():
        if not 1 <= number <= len(names):
            option = "--largest-overlap" if name == "maximum_overlap" else "--plastic-overlap"
            raise DemlawsError(f"{option} {number}: {arguments.contacts} has {len(names)} columns")
    if arguments.columns is not None:
        if not 1 <= min(arguments.columns) <= max(arguments.columns) <= len(names):
            raise DemlawsError(
                f"--columns {' '.join(map(str, arguments.columns))}: {arguments.contacts} has {len(names)} columns"
            )
        return tuple(arguments.columns), given
    if names in (LAMMPS_CASE, LAMMPS_CASE[:6]):
        return (2, 3, 4, 5, 6), given or (LAMMPS_HISTORY if names == LAMMPS_CASE else {})
    if names[:12] == LIGGGHTS_CASE and len(names) in (13, 15) and all(name.startswith("c_contacts[") for name in names[12:]):
        history = dict(zip(("maximum_overlap", "plastic_overlap", "overlap")[15 - len(names) :], range(13, 16), strict=False))
        return (7, 8, 10, 11, 12), {**history, **given}
    raise DemlawsError(
        f"{arguments.contacts} has the columns {' '.join(names)}, which are not those of an exported case: name id1 id2 fx fy "
        "fz with --columns, and the largest overlap with --largest-overlap"
    )


def contacts_of_dump(arguments, atoms, lengths, entries):
    """Bodies, vectors between the centres [m], normal forces [N] of the contacts, and name → what else the dump has of them."""
    import numpy as np

    columns, history = columns_of(arguments, entries)
    needed = [*columns, *history.values()]
    _check_finite(arguments.contacts, {name: entries[name] for k, name in enumerate(entries, 1) if k in needed})
    first, second, *force = (list(entries.values())[column - 1] for column in columns)
    number = {int(name): place for place, name in enumerate(atoms["id"])}
    try:
        pairs = [(number[int(a)], number[int(b)]) for a, b in zip(first, second, strict=True)]
    except KeyError as error:
        raise DemlawsError(f"{arguments.contacts}: grain {error} is not in {arguments.snapshot}; check --columns") from error
    pairs = np.array(pairs, int).reshape(-1, 2)
    centres = np.stack([atoms[axis] for axis in "xyz"], axis=1)
    between = centres[pairs[:, 0]] - centres[pairs[:, 1]]
    between -= np.where(np.isinf(lengths), 0.0, lengths) * np.round(between / lengths)
    distance = np.linalg.norm(between, axis=1)
    if np.any(np.abs(distance / atoms["radius"][pairs].sum(axis=1) - 1.0) > 0.5):
        raise DemlawsError(f"{arguments.contacts}: grains in contact are far apart or one and the same; check --columns")
    vector = np.stack(force, axis=1)
    force = np.abs(np.sum(between * vector, axis=1)) / distance
    if np.linalg.norm(vector) > 3.0 * np.linalg.norm(force):  # a coefficient of friction above 2.8
        raise DemlawsError(f"{arguments.contacts}: the forces point across the lines between the centres; check --columns")
    each, times = np.unique(np.sort(pairs[force > 0.0], axis=1), axis=0, return_counts=True)
    for a, b in each[times > 1][:1]:
        raise DemlawsError(
            f"{arguments.contacts}: the contact of grains {atoms['id'][a]:.0f} and {atoms['id'][b]:.0f} is listed twice: dump "
            "each contact once, and use a box of at least three grains across"
        )
    known = {name: list(entries.values())[column - 1] for name, column in history.items()}
    if "maximum_overlap" in known and np.any(known["maximum_overlap"][force > 0.0] <= 0.0):
        if arguments.largest_overlap is not None:
            raise DemlawsError(
                f"{arguments.contacts}, column {arguments.largest_overlap}: the largest overlap of a loaded contact must "
                "be above 0"
            )
        known = {name: known[name] for name in known if name == "overlap"}  # a run without unloading keeps none
    return pairs, between, force, known


def _ratio_and_rayleigh(arguments, kinds):
    """K_t/K, and the smallest Rayleigh step [s] of `kinds`, (radius, density), or None."""
    from demlaws.contact import Material
    from demlaws.core.shear import LARGEST_SHEAR_RATIO
    from demlaws.timestep import rayleigh_step, shear_ratio
    from demlaws.units import number

    ratio, rayleigh = 1.0, None
    if arguments.poisson is not None and arguments.young is not None:
        young, poisson = arguments.young[0], arguments.poisson[0]
        grain = Material(young, poisson)
        ratio = shear_ratio(grain, grain)
        rayleigh = min(rayleigh_step(r, density, young, poisson=poisson) for r, density in kinds)
    if arguments.shear_ratio is not None:
        ratio = number(arguments.shear_ratio, "--shear-ratio", "", 0.0, LARGEST_SHEAR_RATIO)
    if arguments.friction is not None and number(arguments.friction, "--friction", "", 0.0, allow_low=True) == 0.0:
        ratio = 0.0
    return ratio, rayleigh


def stiffness_of_dump(path, law, force, largest, overlap, rounding):
    """Tangents [N/m] of the contacts of a dump, what is known of their history, and notes on contradictions."""
    compared = _compare(path, law, force, largest, overlap, rounding)
    stiffness, history, note = _stiffness(law, force, largest, overlap, rounding)
    return stiffness, history, "; ".join(filter(None, (compared, note)))


def _compare(path, law, force, largest, overlap, rounding):
    """A note on overlaps of the dump that differ from those of the law at its forces; DemlawsError where they are others.

    It finds a wrong column, a dump that is not in SI units, and another law or modulus than the run's. Without a history only
    overlaps below those of first loading contradict the law.
    """
    import numpy as np

    from demlaws.core.loops import unloaded_loop

    expected = law.overlap(force)
    if law.state_size and largest is not None:
        state, highest = law.new_state(force.size), np.maximum(largest, expected)
        law.evaluate(highest, state)
        expected = np.minimum(unloaded_loop(law.rule_tag, law.params, force, state.arrays), highest)
    clear = rounding < 0.1 * expected
    if not clear.any():
        return "positions have too few digits to compare overlaps with the law's"
    ratio = float(np.median(overlap[clear] / expected[clear]))
    middle = np.argsort(force)[force.size // 2]
    example = f"{overlap[middle]:.3g} m at {force[middle]:.3g} N, the law has {expected[middle]:.3g} m"
    text = f"overlaps of the dump are {ratio:.2g} times those of this law at its forces (median of {clear.sum()}; {example})"
    unloaded = law.state_size and largest is None  # any overlap above that of first loading may be right
    if ratio < 1.0 / MOST_APART or (ratio > MOST_APART and not unloaded):
        raise DemlawsError(f"{path}: {text}: give the units of the run in SI, its columns (--columns), its --young and law")
    if ratio < 1.0 / NOTED_APART or ratio > (MOST_APART if unloaded else NOTED_APART):
        return text + ": damping, unloading, or another --young or law in the run"
    return ""


def _stiffness(law, force, largest, overlap, rounding):
    """Tangents [N/m], what is known of the contacts' history, and a note on overlaps that contradict the law."""
    import numpy as np

    from demlaws.timestep import stiffest_now

    if not law.state_size or largest is not None:
        return stiffest_now(law, force, largest), "known" if law.state_size else "none", ""
    stiffness, fresh = stiffest_now(law, force, overlap=overlap + rounding), stiffest_now(law, force, law.overlap(force))
    if np.allclose(stiffness, fresh, rtol=1e-9, atol=0.0):  # Hertz's curve, a given one: the force alone decides
        return stiffness, "none", ""
    small = overlap + rounding < law.overlap(force)
    note = ""
    if small.any():
        note = f"{np.sum(small)} contacts overlap less than this law at their force: damping, or another law in the run"
    return stiffness, "stiffest", note
