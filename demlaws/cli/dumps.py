"""Contacts of the last frame of dumps of LIGGGHTS and LAMMPS, for `demlaws timestep` and `demlaws contacts`."""

import math
from typing import Any, NamedTuple

import numpy as np

from demlaws.core.loops import unloaded_loop
from demlaws.errors import DemlawsError
from demlaws.files import read_text
from demlaws.timestep import stiffest_now

LAMMPS_CASE = ["index", "c_ids[1]", "c_ids[2]", *(f"c_contacts[{i}]" for i in range(1, 8))]
"""Columns of the contacts of an exported LAMMPS case, of a stock one the first six: index, id1 id2, fx fy fz, p13 to p16."""
LIGGGHTS_CASE = [f"c_contacts[{i}]" for i in range(1, 13)]
"""First columns of the contacts of an exported LIGGGHTS case: two places, id1 id2 and a flag, fx fy fz; behind them largest and
plastic overlap of laws with history, and the overlap."""
QUANTITIES = ("id1", "id2", "fx", "fy", "fz", "maximum_overlap", "plastic_overlap", "stored", "dissipated")
"""Quantities of a dump in the order of a LAMMPS case; --columns names the first five to seven."""
MOST_APART = 2.0
"""Median ratio of the overlaps of a dump to those of the law at its forces from which on they are refused. Damping in a packing
that moves changes it by some tenths."""
MOST_OBLIQUE = 1.5
"""Median ratio of forces to their normal parts from which on they are refused: half of the contacts at a friction above 1.1."""
_PLACES = ("x", "y", "z", "radius")


class Dumped(NamedTuple):
    """Contacts of a frame that carry a force."""

    atoms: dict  # columns of the grains
    pairs: Any  # places of both grains in these columns
    between: Any  # vectors between their centres [m]
    force: Any  # normal force [N]
    overlap: Any  # [m]
    rounding: Any  # error [m] of overlaps that follow from printed positions
    known: dict  # name → other quantities, of `QUANTITIES`

    @property
    def radius(self):
        """Effective radius [m]."""
        from demlaws.contact import effective_radius

        return effective_radius(*self.atoms["radius"][self.pairs].T)


class _Frame(NamedTuple):
    """Last frame of a dump."""

    step: str
    lengths: Any  # of the box's periodic edges [m]; inf: not periodic
    columns: dict  # name → values
    resolution: Any  # last digits of x, y, z and radius [m]


def read_dumps(arguments):
    """`Dumped` of the two dumps that the arguments name."""
    path, grains = arguments.contacts, _frame(arguments.snapshot, "ATOMS")
    entries, atoms = _frame(path, "ENTRIES"), grains.columns
    if grains.step != entries.step:
        raise DemlawsError(f"{arguments.snapshot} is of step {grains.step}, {path} of step {entries.step}")
    missing = [name for name in ("id", *_PLACES) if name not in atoms]
    if missing or not len(atoms["id"]):
        raise DemlawsError(f"{arguments.snapshot} lacks {'the columns ' + ', '.join(missing) if missing else 'grains'}")
    known = _quantities_of(path, entries.columns, arguments.columns)
    _check_finite(arguments.snapshot, {name: atoms[name] for name in ("id", *_PLACES, "mass", "density") if name in atoms})
    _check_finite(path, known)
    pairs = _pairs_of(arguments, atoms, known)
    centres = np.stack([atoms[axis] for axis in "xyz"], axis=1)
    between = centres[pairs[:, 0]] - centres[pairs[:, 1]]
    between -= np.where(np.isinf(grains.lengths), 0.0, grains.lengths) * np.round(between / grains.lengths)
    force = _normal_force(path, atoms, pairs, between, np.stack([known[name] for name in QUANTITIES[2:5]], axis=1))
    touching = force > 0.0
    pairs, between, force = pairs[touching], between[touching], force[touching]
    known = {name: values[touching] for name, values in known.items() if name not in QUANTITIES[:5]}
    if np.any(known.get("maximum_overlap", np.ones(1)) <= 0.0):  # a run without unloading keeps no history
        known = {name: values for name, values in known.items() if name == "overlap"}
    distance = np.linalg.norm(between, axis=1)
    rounding = np.abs(between / distance[:, None]) @ grains.resolution[:3] + grains.resolution[3]  # half a digit of each grain
    if "overlap" in known:
        rounding = np.zeros(len(pairs))
    overlap = known.pop("overlap", atoms["radius"][pairs].sum(axis=1) - distance)
    if np.any(known.get("maximum_overlap", math.inf) < overlap - rounding - 1e-5 * np.abs(overlap)):
        raise DemlawsError(f"{path}: largest overlaps below the present ones; check --columns")
    return Dumped(atoms, pairs, between, force, overlap, rounding, known)


def _frame(path, what):
    """`_Frame` of a dump of ATOMS or ENTRIES."""
    content = read_text(path)
    last = content[max(content.rfind("ITEM: TIMESTEP"), 0) :]  # of a frame that was cut, rows of the one before are not used
    items = [item.splitlines() for item in last.split("ITEM: ")[1:]]
    frame = {lines[0].split()[0]: lines for lines in items if lines}
    try:
        if not content.endswith("\n"):
            raise ValueError("the last row may have been cut")
        names, box = frame[what][0].split()[1:], frame["BOX"]
        text = np.array([line.split() for line in frame[what][1:]]).reshape(int(frame["NUMBER"][1]), len(names))
        columns = {name: _numbers(column) for name, column in zip(names, text.T, strict=True)}
        places = [k for k, name in enumerate(names) if name in _PLACES and columns[name].dtype.kind == "f"]
        resolution = _resolution(text[:, places].ravel(), columns) if len(places) == len(_PLACES) else None
        edges = [float(high) - float(low) for low, high in (line.split() for line in box[1:4])]
        periodic = [word == "pp" for word in box[0].split()[-3:]]
        return _Frame(frame["TIMESTEP"][1].strip(), np.where(periodic, edges, np.inf), columns, resolution)
    except (KeyError, IndexError, ValueError) as error:
        raise DemlawsError(
            f"{path}: not a text dump of {what} with a complete last frame in an orthogonal box: dump as text, let the run end"
        ) from error


def _numbers(column):
    """A column of words as numbers; as it is where it has others, such as element or mol."""
    try:
        return column.astype(float)
    except ValueError:
        return column


def _resolution(words, columns):
    """Last digit of the largest number of each column of places, if all are printed with as many digits as the longest."""
    digits = max((len(word.lower().split("e")[0].lstrip("-+0.").replace(".", "")) for word in words), default=1)
    largest = [max(map(abs, columns[name]), default=0.0) for name in _PLACES]
    return [10.0 ** (math.floor(math.log10(size)) + 1 - digits) if size > 0.0 else 0.0 for size in largest]


def _quantities_of(path, columns, places):
    """Name of a quantity → its column: at the given places (from 1), or by all names of an exported case."""
    names, values = list(columns), list(columns.values())
    if places is not None:
        if not (5 <= len(places) <= 7 and 1 <= min(places) and max(places) <= len(names)):
            raise DemlawsError(f"--columns {' '.join(map(str, places))}: give 5 to 7 of the {len(names)} columns of {path}")
        return {name: values[place - 1] for name, place in zip(QUANTITIES, places, strict=False)}
    if names in (LAMMPS_CASE, LAMMPS_CASE[:6]):
        return dict(zip(QUANTITIES, values[1:], strict=False))
    if names[:12] == LIGGGHTS_CASE and len(names) in (13, 15) and all(name.startswith("c_contacts[") for name in names[12:]):
        first = [values[place] for place in (6, 7, 9, 10, 11)]
        return dict(zip(QUANTITIES[: len(names) - 8], [*first, *values[12:-1]], strict=True)) | {"overlap": values[-1]}
    raise DemlawsError(
        f"{path} has the columns {' '.join(names)}, which are not those of an exported case: name id1 id2 fx fy fz, and the "
        "largest overlap, with --columns"
    )


def _check_finite(path, columns):
    """Raise where a value is not finite: its contacts would be left out."""
    for name, values in columns.items():
        if values.dtype.kind != "f":
            raise DemlawsError(f"{path}: {name} has text ({values[0]}), not numbers; check --columns")
        for row in np.flatnonzero(~np.isfinite(values))[:1]:
            raise DemlawsError(f"{path}: {name} of row {row + 1} is {values[row]}: has the run diverged?")


def _pairs_of(arguments, atoms, known):
    """Places of both grains of each contact among the grains."""
    number = {int(name): place for place, name in enumerate(atoms["id"])}
    try:
        pairs = [(number[int(a)], number[int(b)]) for a, b in zip(known["id1"], known["id2"], strict=True)]
    except KeyError as error:
        raise DemlawsError(f"{arguments.contacts}: grain {error} is not in {arguments.snapshot}; check --columns") from error
    return np.array(pairs, int).reshape(-1, 2)


def _normal_force(path, atoms, pairs, between, vector):
    """Normal forces [N]; DemlawsError where pairs and forces are not those of contacts, each listed once."""
    distance = np.linalg.norm(between, axis=1)
    if np.any(np.abs(distance / atoms["radius"][pairs].sum(axis=1) - 1.0) > 0.5):
        raise DemlawsError(f"{path}: grains in contact are far apart or one and the same; check --columns")
    force = np.abs(np.sum(between * vector, axis=1)) / distance
    size = np.linalg.norm(vector, axis=1)
    carries = force > 0.0
    oblique = np.median(size[carries] / force[carries]) if carries.any() else 1.0
    if oblique > MOST_OBLIQUE or np.linalg.norm(size) > 3.0 * np.linalg.norm(force):  # a coefficient of friction above 2.8
        raise DemlawsError(
            f"{path}: the forces point across the lines between the centres: give the columns of the vector fx fy fz, not of "
            "its size, with --columns"
        )
    each, times = np.unique(np.sort(pairs[force > 0.0], axis=1), axis=0, return_counts=True)
    for a, b in each[times > 1][:1]:
        raise DemlawsError(
            f"{path}: the contact of grains {atoms['id'][a]:.0f} and {atoms['id'][b]:.0f} is listed twice: dump "
            "each contact once, and use a box of at least three grains across"
        )
    return force


def stiffness_of(path, dumped, law):
    """Tangents [N/m] of the contacts of a dump, the stiffer of loading and unloading at their history.

    DemlawsError where overlaps are not those of the law, or the law's stiffness depends on an unknown history.
    """
    _compare(path, dumped, law)
    force, largest = dumped.force, dumped.known.get("maximum_overlap")
    stiffness = stiffest_now(law, force, largest)
    if law.state_size and largest is None:
        deeper = stiffest_now(law, force, 1.01 * law.overlap(force))
        if not np.allclose(stiffness, deeper, rtol=1e-9, atol=0.0):  # of Hertz's curve, or a given one, the force alone decides
            raise DemlawsError(
                f"{path} lacks the largest overlap of each contact, on which the stiffness of {law.name!r} with "
                f"{law.unloading} unloading depends: dump it, and name its column after those of the force with --columns"
            )
    return stiffness


def _compare(path, dumped, law):
    """DemlawsError where overlaps are others than those of the law at the dump's forces.

    It finds a wrong column, a dump that is not in SI units, and another law or modulus than the run's. Without a history only
    overlaps below those of first loading contradict the law.
    """
    force, largest = dumped.force, dumped.known.get("maximum_overlap")
    expected = law.overlap(force)
    if law.state_size and largest is not None:
        state, highest = law.new_state(force.size), np.maximum(largest, expected)
        law.evaluate(highest, state)
        expected = np.minimum(unloaded_loop(law.rule_tag, law.shape, law.params, force, state.arrays), highest)
    clear = dumped.rounding < 0.1 * expected
    if not clear.any():
        return
    ratio = float(np.median(dumped.overlap[clear] / expected[clear]))
    unloaded = law.state_size and largest is None  # any overlap above that of first loading may be right
    if ratio < 1.0 / MOST_APART or (ratio > MOST_APART and not unloaded):
        middle = np.argsort(force)[force.size // 2]
        example = f"{dumped.overlap[middle]:.3g} m at {force[middle]:.3g} N, the law has {expected[middle]:.3g} m"
        raise DemlawsError(
            f"{path}: overlaps of the dump are {ratio:.2g} times those of this law at its forces (median of {clear.sum()}; "
            f"{example}): give the units of the run in SI, its columns (--columns), its --young and law"
        )
