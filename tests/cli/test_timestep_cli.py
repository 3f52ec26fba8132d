"""`demlaws timestep` on dumps of LIGGGHTS and LAMMPS."""

import json
import math
import re
import shutil
from pathlib import Path

import pytest

import demlaws as dl
from demlaws.cli import main

RADIUS, FORCE = 4e-3, 20.0
GRANITE = ["--law", "hertz", "--young", "60.6GPa", "--poisson", "0.25", "--density", "2680"]
DATA = Path(__file__).parents[1] / "data" / "dumps"


def dumps(folder, engine):
    """A periodic simple cubic lattice with FORCE in each contact, and an open contact, as exported cases dump it."""
    paths = folder / "grains.txt", folder / "contacts.txt"
    for path, name in zip(paths, ("grains.txt", f"contacts-{engine}.txt"), strict=True):
        shutil.copy(DATA / name, path)
    return [str(path) for path in paths]


@pytest.mark.parametrize("engine", ["liggghts", "lammps"])
def test_limit_of_a_lattice(tmp_path, capsys, engine):
    """2/ω with ω² = 2/3 Z 5 r K/m; a law that unloads more stiffly has a smaller one."""
    files = dumps(tmp_path, engine)
    assert main(["timestep", *files, *GRANITE]) == 0
    values = {line[:16].strip(): float(line[16:].split()[0]) for line in capsys.readouterr().out.splitlines()[1:]}
    law = dl.law("hertz", dl.Contact(RADIUS / 2, 0.5 * dl.Material(60.6e9, 0.25).plane_modulus))
    mass, stiffness = 4 / 3 * math.pi * RADIUS**3 * 2680, law.stiffness(law.overlap(FORCE))
    limit = 2.0 / math.sqrt(20 * 1.5 / 1.75 * stiffness / mass)
    assert values["exact limit"] == pytest.approx(limit, rel=1e-3)
    assert values["recommended step"] == pytest.approx(0.8 * limit, rel=1e-3)
    rayleigh = math.pi * RADIUS * math.sqrt(2680 * 2.5 / 60.6e9) / (0.1631 * 0.25 + 0.8766)
    assert values["Rayleigh step"] == pytest.approx(rayleigh, rel=1e-3)
    surface = ["--law", "pohrt-popov", "--sigma", "2.4um", "--fractal-dimension", "2.2", *GRANITE[2:]]
    exact = []
    for rule in ("elastic", "hertz"):
        assert main(["timestep", *files, *surface, "--unloading", rule]) == 0
        exact.append(float(capsys.readouterr().out.splitlines()[1].split()[2]))  # a Hertz curve needs no history
    assert exact[1] < 0.95 * exact[0]


BOX = "-1 1\n-1 1\n-1 1"


def two_grains(folder, overlap, force, digits, largest=(), columns=None):
    """Dumps of two grains in contact."""
    columns = columns or " ".join(f"c_1[{k}]" for k in range(1, 6 + len(largest)))
    texts = {
        "grains.txt": f"ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS ff ff ff\n{BOX}\n"
        f"ITEM: ATOMS id x y z radius\n1 0 0 0 {RADIUS:g}\n2 {2 * RADIUS - overlap:.{digits}g} 0 0 {RADIUS:g}\n",
        "contacts.txt": f"ITEM: TIMESTEP\n0\nITEM: NUMBER OF ENTRIES\n1\nITEM: BOX BOUNDS ff ff ff\n{BOX}\n"
        f"ITEM: ENTRIES index {columns}\n1 1 2 {force:.12g} 0 0 {' '.join(map(repr, largest))}\n",
    }
    for name, text in texts.items():
        (folder / name).write_text(text)
    return [str(folder / name) for name in texts]


HISTORIES = {
    "luding": ("loading_stiffness=3e6", "stiffness_ratio=5", "plasticity_depth=0.002"),
    "eepa": ("stiffness_ratio=4",),
    "thornton-ning": ("yield_pressure=5e8",),
}


@pytest.mark.parametrize("name", HISTORIES)
def test_contact_that_carried_more(tmp_path, capsys, name):
    """The limit was 1.1 to 1.8 times the true one after unloading to a tenth of the largest force."""
    options = dict(zip(*zip(*(text.split("=") for text in HISTORIES[name]), strict=True), strict=True))
    contact = dl.Contact(RADIUS / 2, 0.5 * dl.Material(60.6e9, 0.25).plane_modulus)
    law = dl.law(name, contact, **{key: float(value) for key, value in options.items()})
    state = law.new_state(1)
    force = 0.1 * float(law.follow([9e-6], state).force[0])
    overlap = float(law.unloading_overlap(force, state))
    stiffness = float(law.follow([overlap], state).stiffness[0])
    mass = 4 / 3 * math.pi * RADIUS**3 * 2680
    true = 2.0 / math.sqrt(stiffness * 2.0 / mass * 3.5 * 1.5 / 1.75)
    words = ["--law", name, *GRANITE[2:], *(word for text in HISTORIES[name] for word in ("--option", text))]

    files = two_grains(tmp_path, overlap, force, 6, [9e-6])
    assert main(["timestep", *files, *words, "--columns", *"234567", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["exact"] == pytest.approx(true, rel=1e-6)
    assert main(["timestep", *files, *words, "--columns", *"23456"]) == 2
    assert "lacks the largest overlap" in capsys.readouterr().err


def test_largest_overlap_of_an_exported_case(tmp_path, capsys):
    """Columns as exported LAMMPS cases dump them: p13 is the largest overlap."""
    words, found = ["--law", "eepa", "--option", "stiffness_ratio=4", *GRANITE[2:], "--json"], []
    names = "c_ids[1] c_ids[2] " + " ".join(f"c_contacts[{k}]" for k in range(1, 8))
    for largest in (4e-6, 8e-6, 0.0):
        files = two_grains(tmp_path, 1e-6, 5.0, 14, [largest, 1e-6, 0.0, 0.0], names)
        status = main(["timestep", *files, *words])
        found.append(json.loads(capsys.readouterr().out)["exact"] if status == 0 else None)
    assert found[1] < 0.9 * found[0] and found[2] is None  # a run without unloading keeps no history


def test_friction_rotation_and_shear_ratio(tmp_path, capsys):
    """Simple cubic: ω² is 2/3 Z K/m times 1 without friction, 1 + 2r without rotation, max(1 + 2r, 5r) with both."""
    files = dumps(tmp_path, "lammps")

    def exact(*more):
        assert main(["timestep", *files, *GRANITE, *more, "--json"]) == 0
        return json.loads(capsys.readouterr().out)

    default, ratio = exact()["exact"], 1.5 / 1.75
    for more, square in (
        (["--shear-ratio", "0"], 1.0),
        (["--no-rotation"], 1 + 2 * ratio),
        (["--shear-ratio", "0.3"], 1.6),
        (["--shear-ratio", "1.3"], 6.5),
    ):
        assert exact(*more)["exact"] == pytest.approx(default * math.sqrt(5 * ratio / square), rel=1e-3)
    assert exact("--shear-ratio", "0")["motion"] == "without friction"
    damped, undamped = exact(), exact("--undamped")
    assert undamped["exact"] == damped["exact"] and damped["recommended"] == pytest.approx(0.8 * damped["exact"])
    assert undamped["recommended"] == pytest.approx(0.3 * damped["exact"])
    for more in (["--shear-ratio", "-0.1"], ["--shear-ratio", "1.34"]):
        assert main(["timestep", *files, *GRANITE, *more]) == 2


@pytest.mark.parametrize(
    ("change", "which"),
    [
        (lambda t: t.replace("\n7\n", "\n8\n"), 0),  # another step
        (lambda t: t[: len(t) // 2], 1),
        (lambda t: t.replace("ENTRIES", "THINGS"), 1),
        (lambda t: t.replace("radius", "size"), 0),
        (lambda t: "no dump at all", 0),
        (lambda t: t.replace("pp pp pp", "ff ff ff"), 0),  # contacts of grains far apart
        (lambda t: t.replace("1 1 17 ", "1 1 999 "), 1),
        (lambda t: t.replace("-20", "0"), 1),
        (lambda t: t[: t.index("1 1 17")].replace("193", "0"), 1),  # no contacts
        (lambda t: t.replace("1 1 17 -", "1 1 1 -"), 1),
        (lambda t: t.replace("1 1 17 -20", "1 1 17 nan"), 1),  # such contacts were left out silently
        (lambda t: re.sub(r"\n64 1 \S+", "\n64 1 nan", t), 0),
        (lambda t: t.replace("64 1 0.02", "nan 1 0.02"), 0),
        (lambda t: t.replace("2 1 5 -0 -20", "2 17 1 20 -0"), 1),  # listed twice: counted twice
        (lambda t: t[: t.index("64 1 0.02")].replace("\n64\n", "\n0\n"), 0),  # no grains
        (
            lambda t: t + t[t.rindex("ITEM: TIME") : t.rindex("ITEM: ATOMS")],
            0,
        ),  # cut behind a header: rows of the frame before were used
        (lambda t: t + t[t.rindex("ITEM: TIME") : t.rindex("ITEM: BOX")], 0),
        (lambda t: t + t[t.rindex("ITEM: TIME") : t.rindex("64 1 0.02")], 0),
        (lambda t: t.rstrip()[:-3], 0),  # within the last number
        (lambda t: t.replace("64 1 0.02", "64 1 wide"), 0),
    ],
)
def test_bad_dumps_are_refused_in_one_line(tmp_path, capsys, change, which):
    files = dumps(tmp_path, "lammps")
    path = Path(files[which])
    path.write_text(change(path.read_text()))
    assert main(["timestep", *files, *GRANITE]) == 2
    message = capsys.readouterr().err
    assert message.startswith("demlaws: error: ") and message.count("\n") == 1


def test_text_in_other_columns(tmp_path, capsys):
    """`dump custom ... element`: a column of words is no fault, unless it is to be used."""
    files = dumps(tmp_path, "lammps")
    assert main(["timestep", *files, *GRANITE, "--json"]) == 0
    expected = json.loads(capsys.readouterr().out)
    for path, titles, row in zip(
        files, ("ATOMS id type", "ENTRIES index"), (r"^(\d+ 1)(?= 0\.)", r"^(\d+)(?= \d+ \d+ -?\d)"), strict=True
    ):
        text = Path(path).read_text().replace(titles, f"{titles} element")
        Path(path).write_text(re.sub(row, r"\1 C", text, flags=re.M))
    columns = ["--columns", *"34567"]
    assert main(["timestep", *files, *GRANITE, *columns, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["exact"] == expected["exact"]
    assert main(["timestep", *files, *GRANITE, "--columns", *"23567"]) == 2
    assert "id1 has text (C)" in capsys.readouterr().err


def test_forces_across_the_centres_are_refused(tmp_path, capsys):
    """Columns of the shear force, say: the limit would be many times too large. Here those of x, y, z are exchanged."""
    assert main(["timestep", *dumps(tmp_path, "lammps"), *GRANITE, "--columns", *"23564"]) == 2
    assert "across the lines between the centres" in capsys.readouterr().err


@pytest.mark.parametrize("command", ["timestep", "contacts"])
def test_the_size_of_forces_is_refused(tmp_path, capsys, command):
    """Columns "force p13 p14" of LAMMPS's pair/local in place of fx fy fz: the size was taken for the x component."""
    files = dumps(tmp_path, "lammps")
    head, rows = Path(files[1]).read_text().rsplit("ITEM: ENTRIES", 1)
    rows = [row.split() for row in rows.splitlines()[1:]]
    text = "\n".join(f"{' '.join(row[:3])} {math.hypot(*map(float, row[3:6]))!r} 2e-6 1e-6" for row in rows)
    Path(files[1]).write_text(f"{head}ITEM: ENTRIES index i j F d p\n{text}\n")
    assert main([command, *files, *(GRANITE if command == "timestep" else ()), "--columns", *"23456"]) == 2
    assert "the vector fx fy fz, not of its size" in capsys.readouterr().err


@pytest.mark.parametrize("command", [["timestep", *GRANITE], ["contacts"]])
@pytest.mark.parametrize("engine", ["liggghts", "lammps"])
def test_columns_that_no_exported_case_has_are_to_be_named(tmp_path, capsys, engine, command):
    """Columns of other names were read by their place: forces one column away, and a step of 1.01 times the limit."""
    files = dumps(tmp_path, engine)
    columns = ["7", "8", "10", "11", "12"] if engine == "liggghts" else [*"23456"]
    path = Path(files[1])
    path.write_text(path.read_text().replace("c_contacts", "c_c"))
    assert main([command[0], *files, *command[1:]]) == 2
    assert "--columns" in capsys.readouterr().err
    assert main([command[0], *files, *command[1:], "--columns", *columns]) == 0
    assert main([command[0], *files, *command[1:], "--columns", *columns[:4], "60"]) == 2


def scaled(file, name, factor, places):
    """Multiplies the columns at these places of a dump's rows, and the box."""
    lines, rows = Path(file).read_text().splitlines(), False
    for k, line in enumerate(lines):
        words = line.split()
        if rows and len(words) > max(places):
            lines[k] = " ".join(repr(float(w) * factor) if n in places else w for n, w in enumerate(words))
        rows = (rows or line.startswith(f"ITEM: {name}")) and not line.startswith("ITEM: TIMESTEP")
        if name == "ATOMS" and k and lines[k - 1].startswith("ITEM: BOX"):
            lines[k : k + 3] = [f"0 {float(edge.split()[1]) * factor!r}" for edge in lines[k : k + 3]]
    Path(file).write_text("\n".join(lines) + "\n")


@pytest.mark.parametrize("wrong", ["forces of another column", "cgs", "young"])
def test_overlaps_that_are_not_the_laws_are_refused(tmp_path, capsys, wrong):
    """One comparison finds a wrong column, other units and another modulus than the run's."""
    files, words = dumps(tmp_path, "lammps"), list(GRANITE)
    if wrong == "young":
        words[3] = "6060GPa"
    elif wrong == "cgs":
        scaled(files[0], "ATOMS", 1e2, (2, 3, 4, 5))
        scaled(files[1], "ENTRIES", 1e5, (3, 4, 5))
    else:
        scaled(files[1], "ENTRIES", 1 / 180, (3, 4, 5))
    assert main(["timestep", *files, *words]) == 2
    assert "times those of this law at its forces" in capsys.readouterr().err


@pytest.mark.parametrize("sign", ["mol", "place"])
def test_members_of_clumps_are_refused(tmp_path, capsys, sign):
    """The limit was 1.55 times that of the rigid body whose members they are."""
    files = dumps(tmp_path, "lammps")
    path = Path(files[0])
    text = path.read_text()
    if sign == "mol":
        text = re.sub(r"(?m)^(ITEM: ATOMS .*)$", r"\1 mol", text)
        text = re.sub(
            r"(?m)^(\d+)( 1 .*)$", lambda row: f"{row[1]}{row[2]} {max(int(row[1]) - 1, 0) // 2 * (int(row[1]) < 5)}", text
        )
    else:  # grain 64, which touches nothing, in the middle of another
        text = re.sub(r"\n64 1 \S+ \S+ \S+", "\n64 1 0.0045 0.004 0.004", text)
        contacts = Path(files[1])
        contacts.write_text(re.sub(r"(?m)^(\d+ 64 \d+|\d+ \d+ 64) .*$", r"\1 0 0 0 ", contacts.read_text()))
    path.write_text(text)
    assert main(["timestep", *files, *GRANITE]) == 2
    assert "clump" in capsys.readouterr().err


def test_what_is_missing_is_refused(tmp_path):
    files = dumps(tmp_path, "lammps")
    columns = ["--columns", "2", "3", "4", "5", "60"]
    for arguments in (files, [*files, *GRANITE, *columns], ["none.txt", *files[1:], *GRANITE], [*files, "--law", "hertz"]):
        assert main(["timestep", *arguments]) == 2
