"""`demlaws contacts` on dumps as exported cases write them."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest

import demlaws as dl
from demlaws.cli import main
from demlaws.cli.dumps import LAMMPS_CASE, LIGGGHTS_CASE
from demlaws.errors import DemlawsError
from demlaws.responses.contacts import Contacts

DATA = Path(__file__).parents[1] / "data" / "dumps"
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
    return {name: [float(row[name]) for row in rows if name != "flattened"] for name in rows[0]}


@pytest.mark.parametrize("write", [lammps, liggghts])
def test_columns_of_exported_cases(tmp_path, capsys, write):
    assert main(["contacts", *write(tmp_path), "--csv", str(tmp_path / "x.csv")]) == 0
    text = capsys.readouterr().out
    assert "1 of 2 contacts have deformed plastically" in text and "to 1e" not in text
    columns = table(tmp_path / "x.csv")
    assert columns["overlap (m)"] == pytest.approx([2e-6, 1e-6], rel=1e-5) and columns["force (N)"] == [5.0, 1.0]
    assert columns["maximum_overlap (m)"] == [3e-6, 1e-6] and columns["plastic_overlap (m)"] == [1e-6, 0.0]
    assert columns["radius (m)"] == pytest.approx([RADIUS / 2] * 2)


def test_dump_without_history(tmp_path, capsys):
    assert main(["contacts", *liggghts(tmp_path, history=False), "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {"contacts": 2, "flattened": None}


def test_rounded_places_are_reported(tmp_path, capsys):
    assert main(["contacts", *lammps(tmp_path, digits=6)]) == 0
    assert "dump more digits" in " ".join(capsys.readouterr().out.split())


def test_wrong_columns_are_refused(tmp_path, capsys):
    files = lammps(tmp_path, largest=1.5e-6)
    assert main(["contacts", *files]) == 2
    assert "below the present ones" in capsys.readouterr().err
    assert main(["contacts", *files, "--columns", *"23456", "7", "12"]) == 2
    assert "the 10 columns" in capsys.readouterr().err
    assert main(["contacts", files[0], str(tmp_path / "none.txt")]) == 2
    assert "cannot read" in capsys.readouterr().err


def test_lines(tmp_path, capsys):
    meshio = pytest.importorskip("meshio")
    assert main(["contacts", *lammps(tmp_path), "--vtk", str(tmp_path / "x.vtu")]) == 0
    assert str(tmp_path / "x.vtu") in capsys.readouterr().out
    mesh = meshio.read(tmp_path / "x.vtu")
    first, last = mesh.points[mesh.cells_dict["line"][1]]
    assert first == pytest.approx([FIRST + 2 * RADIUS - 2e-6, 0, 0]) and last == pytest.approx(
        [FIRST + 4 * RADIUS - 3e-6, 0, 0]
    )


@pytest.mark.parametrize("name", ["contacts.vtu", "contacts.vtk"])
def test_lines_of_this_command_are_replaced_and_no_others(name, tmp_path):
    pytest.importorskip("meshio")
    grains, contacts = (str(DATA / name) for name in ("grains.txt", "contacts-lammps.txt"))
    vtk, csv = tmp_path / name, tmp_path / "contacts.csv"
    words = ["contacts", grains, contacts, "--vtk", str(vtk), "--csv", str(csv)]
    assert main(words) == 0 and main(words) == 0
    assert list(tmp_path.glob(".*")) == []
    for file in (vtk, csv):
        content = file.read_bytes()
        other = content.replace(b"demlaws contacts", b"other program").replace(b"body1,", b"number,")
        file.write_bytes(other)
        assert main(words) == 2 and file.read_bytes() == other
        file.write_bytes(content)


def test_lines_that_cannot_be_written_leave_the_old_file(tmp_path, monkeypatch):
    """The library would write into the file itself."""
    pytest.importorskip("meshio")
    centres = np.array([[0.0, 0.0, 0.0]]), np.array([[1e-3, 0.0, 0.0]])
    one, ones = np.array([1]), np.array([1.0])
    contacts = Contacts(one, one + 1, ones, ones, centre1=centres[0], centre2=centres[1])
    file = tmp_path / "contacts.vtu"
    before = contacts.save(file).read_bytes()
    monkeypatch.setattr("os.replace", lambda *_: (_ for _ in ()).throw(OSError(28, "No space left on device")))
    with pytest.raises(DemlawsError, match="No space"):
        contacts[:0].save(file)
    assert file.read_bytes() == before and list(tmp_path.iterdir()) == [file]


def test_stiffness_and_conductance_by_the_law(tmp_path, capsys):
    """K of the law at the dump's forces; a = K/(2E*), conductance over conductivity K/E*."""
    grains, contacts = (str(DATA / name) for name in ("grains.txt", "contacts-lammps.txt"))
    contact = ["--young", "60.6GPa", "--poisson", "0.25"]
    assert main(["contacts", grains, contacts, "--law", "hertz", *contact, "--csv", str(tmp_path / "x.csv")]) == 0
    found, modulus = table(tmp_path / "x.csv"), 0.5 * 60.6e9 / (1 - 0.25**2)
    force, radius = np.array(found["force (N)"]), np.array(found["radius (m)"])
    expected = (6.0 * force * radius * modulus**2) ** (1 / 3)
    assert len(force) > 100 and found["modulus (Pa)"] == pytest.approx([modulus] * len(force), rel=1e-6)
    assert found["stiffness (N/m)"] == pytest.approx(expected, rel=1e-6)
    assert found["contact_radius (m)"] == pytest.approx((0.75 * force * radius / modulus) ** (1 / 3), rel=1e-6)
    assert found["conductance (m)"] == pytest.approx(expected / modulus, rel=1e-6)
    capsys.readouterr()
    rough = ["--law", "pohrt-popov", *contact, "--roughness", "1.7um", "--csv", str(tmp_path / "y.csv")]
    assert main(["contacts", grains, contacts, *rough]) == 2  # without a fractal dimension
    assert "fractal" in capsys.readouterr().err and not (tmp_path / "y.csv").exists()


def test_conductance_is_that_of_the_heat_model_of_lammps():
    """Two rough beads of 17.4 mm at 8 N, k = 3 W/(m K): 3.503e-4 W/K; of contacts of which no stiffness is known none."""
    law = dl.law("pohrt-popov", dl.Contact(4.35e-3, 32.32e9, 1.7e-6 * 2**0.5, 2.22))
    overlap = law.overlap(8.0)
    one = Contacts(
        np.array([1]),
        np.array([2]),
        np.array([overlap]),
        np.array([8.0]),
        stiffness=np.array([law.stiffness(overlap)]),
        modulus=np.array([32.32e9]),
    )
    assert 3.0 * one.conductance == pytest.approx([3.503e-4], rel=1e-3)
    assert one[0].contact_radius == pytest.approx(0.5 * one.conductance)
    assert {"conductance (m)", "contact_radius (m)"} <= set(one.columns())
    bare = Contacts(one.body1, one.body2, one.overlap, one.force)
    assert bare.conductance is None and "contact_radius (m)" not in bare.columns()
