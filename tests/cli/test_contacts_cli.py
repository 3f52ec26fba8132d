"""`demlaws contacts` on dumps as exported cases write them."""

import csv
import json

import pytest

from demlaws.cli import main
from demlaws.cli.output import Output
from demlaws.cli.timestep import LAMMPS_CASE, LIGGGHTS_CASE
from demlaws.errors import DemlawsError

RADIUS, FIRST, BOX = 4e-3, 0.123456789012, "-1 1\n-1 1\n-1 1"


def dumps(folder, columns, rows, digits=12):
    """Three grains along x that overlap by 2 and 1 µm, and dumps of these contacts."""
    places = [FIRST, FIRST + 2 * RADIUS - 2e-6, FIRST + 4 * RADIUS - 3e-6]
    grains = "".join(f"{n + 1} {x:.{digits}g} 0 0 {RADIUS:g}\n" for n, x in enumerate(places))
    entries = "".join(" ".join(f"{value:.12g}" for value in row) + "\n" for row in rows)
    for name, what, count, titles, text in (
        ("grains.txt", "ATOMS", 3, "id x y z radius", grains),
        ("contacts.txt", "ENTRIES", len(rows), " ".join(columns), entries),
    ):
        (folder / name).write_text(
            f"ITEM: TIMESTEP\n7\nITEM: NUMBER OF {what}\n{count}\nITEM: BOX BOUNDS ff ff ff\n{BOX}\n"
            f"ITEM: {what} {titles}\n{text}"
        )
    return [str(folder / "grains.txt"), str(folder / "contacts.txt")]


def lammps(folder, largest=3e-6, **more):
    # index, ids, force, largest and plastic overlap, energies
    rows = [(1, 1, 2, -5.0, 0, 0, largest, 1e-6, 4e-6, 2e-6), (2, 2, 3, -1.0, 0, 0, 1e-6, 0.0, 1e-6, 0.0)]
    return dumps(folder, LAMMPS_CASE, rows, **more)


def liggghts(folder, history=True):
    start = [(0,) * 6 + (1, 2, 0, -5.0, 0, 0), (0,) * 6 + (2, 3, 0, -1.0, 0, 0)]
    ends = [(3e-6, 1e-6, 2e-6), (1e-6, 0.0, 1e-6)]
    rows = [(*first, *(last if history else last[2:])) for first, last in zip(start, ends, strict=True)]
    return dumps(folder, LIGGGHTS_CASE + [f"c_contacts[{n}]" for n in ((25, 26, 28) if history else (26,))], rows, digits=4)


def table(path):
    with open(path) as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    return {name: [float(row[name]) for row in rows if name != "yielded"] for name in rows[0]}


@pytest.mark.parametrize("write", [lammps, liggghts])
def test_columns_of_exported_cases(tmp_path, capsys, write):
    assert main(["contacts", *write(tmp_path), "--csv", str(tmp_path / "x.csv")]) == 0
    text = capsys.readouterr().out
    assert "1 of 2 contacts have yielded" in text and "to 1e" not in text
    columns = table(tmp_path / "x.csv")
    assert columns["overlap (m)"] == pytest.approx([2e-6, 1e-6], rel=1e-5) and columns["force (N)"] == [5.0, 1.0]
    assert columns["maximum_overlap (m)"] == [3e-6, 1e-6] and columns["plastic_overlap (m)"] == [1e-6, 0.0]
    assert columns["radius (m)"] == pytest.approx([RADIUS / 2] * 2)


def test_dump_without_history(tmp_path, capsys):
    assert main(["contacts", *liggghts(tmp_path, history=False), "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {"contacts": 2, "yielded": None}


def test_rounded_places_are_reported(tmp_path, capsys):
    assert main(["contacts", *lammps(tmp_path, digits=6)]) == 0
    assert "dump more digits" in " ".join(capsys.readouterr().out.split())


def test_wrong_columns_are_refused(tmp_path, capsys):
    files = lammps(tmp_path, largest=1.5e-6)
    assert main(["contacts", *files]) == 2
    assert "below the present ones" in capsys.readouterr().err
    assert main(["contacts", *files, "--columns", *"23456", "--plastic-overlap", "12"]) == 2
    assert "has 10 columns" in capsys.readouterr().err
    assert main(["contacts", files[0], str(tmp_path / "none.txt")]) == 2
    assert "does not exist" in capsys.readouterr().err


def test_lines(tmp_path, capsys):
    meshio = pytest.importorskip("meshio")
    assert main(["contacts", *lammps(tmp_path), "--vtk", str(tmp_path / "x.vtu")]) == 0
    assert str(tmp_path / "x.vtu") in capsys.readouterr().out
    mesh = meshio.read(tmp_path / "x.vtu")
    first, last = mesh.points[mesh.cells_dict["line"][1]]
    assert first == pytest.approx([FIRST + 2 * RADIUS - 2e-6, 0, 0]) and last == pytest.approx(
        [FIRST + 4 * RADIUS - 3e-6, 0, 0]
    )


def test_lines_of_this_command_are_overwritten_and_no_others(tmp_path):
    """Before: a second run of the command refused its own .vtp file."""
    file = tmp_path / "contacts.vtp"
    file.write_text('<VTKFile type="PolyData">' + 5000 * " " + '<DataArray Name="body1">')
    Output().check(file)
    file.write_text('<VTKFile type="PolyData"><DataArray Name="pressure">')
    with pytest.raises(DemlawsError):
        Output().check(file)
