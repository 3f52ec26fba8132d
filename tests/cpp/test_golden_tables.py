"""Table files of tests/data/tables, read by Python and by the C++ header: one verdict, one line, one force.

The files are those of tests/data/tables/good, and those of `table_faults` with one fault each.
"""

import re
import subprocess
from pathlib import Path

import facts
import numpy as np
import pytest
from examples import sealed, shared
from table_faults import FAULTS, lines_of

import demlaws as dl

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")

HERE = Path(__file__).parent
TABLES = HERE.parent / "data" / "tables"
GOOD = sorted(path.stem for path in (TABLES / "good").glob("*.tbl"))
FEW = ("pohrt-popov-hertz", "rough-plastic-thornton")
CHANGES = 300
STEPS = (1.0, 0.98, 0.6)  # of the largest overlap: first loading, then two points of unloading


@pytest.fixture(scope="module")
def reader(tmp_path_factory):
    """What the C++ program answers to lines of input, in the folder of tables: its words are separated by spaces."""
    program = tmp_path_factory.mktemp("reader") / "reader"
    headers = Path(dl.__file__).parent / "cpp"
    command = ["g++", "-std=c++11", "-O2", "-Wall", "-Wextra", "-Werror", "-I", str(headers), str(HERE / "reader.cpp")]
    subprocess.run([*command, "-o", str(program)], check=True)

    def ask(*lines):
        text = "\n".join(lines).replace(f"{TABLES}/", "")
        done = subprocess.run([program], cwd=TABLES, input=text, capture_output=True, text=True, errors="replace", check=True)
        return done.stdout.splitlines()

    return ask


def overlaps_of(table):
    """Dimensionless overlaps inside the table: deep below the first row, below it, at rows, between them, around kinks."""
    u = table.nodes.u
    below = u[0] * 0.5 ** np.array([70.0, 41.0, 40.0, 39.9, 30.0, 7.0, 1.3, 0.5])
    kinks = [table.nodes.kinks * (1.0 + shift) for shift in (-1e-3, -1e-9, -1e-13, 1e-13, 1e-9)]
    inside = np.concatenate([below, u, 0.5 * (u[1:] + u[:-1]), 0.1 * u[1:] + 0.9 * u[:-1], *kinks])
    return np.unique(inside[inside <= u[-1] * (1.0 - 1e-14)])


@pytest.mark.parametrize("name", shared(GOOD, lambda name: name in FEW or ("table" not in name and name != "most-kinks")))
def test_good_tables_are_read_alike(name, reader):
    path = TABLES / "good" / f"{name}.tbl"
    table = dl.Table.load(path)
    contact, length = table.contact, float(np.ravel(table.length)[0])
    overlap = overlaps_of(table) * length
    opening = f"table {path} {contact.modulus!r} {contact.radius!r} {contact.sigma!r}"
    asked = [f"overlap {float(x * step)!r}" for x in overlap for step in STEPS]
    asked = [line for n in range(overlap.size) for line in ("virgin", *asked[3 * n : 3 * n + 3])]
    first, *answers = reader(opening, *asked)
    assert first == f"good {table_fingerprint(path)}"
    rows = np.array([answer.split() for answer in answers], float).reshape(-1, 3, 8)
    assert not rows[:, :, 7].any()
    state = table.new_state(overlap.size) if table.state_size else None
    for n, step in enumerate(STEPS):
        force, stiffness = table.evaluate(overlap * step, state)
        np.testing.assert_allclose(rows[:, n, 0], force, rtol=3e-12, atol=0.0)
        np.testing.assert_allclose(rows[:, n, 1], stiffness, rtol=2e-11, atol=0.0)
        for k in range(table.state_size):
            scale = overlap if k < 2 else 1.0
            assert np.max(np.abs(rows[:, n, 2 + k] - state.arrays[k]) / scale) <= 1e-10
    for at, row in zip(overlap[::5], rows[::5], strict=True):
        path = table.follow(at * np.array(STEPS))
        np.testing.assert_allclose(row[:, 5:7].T, [path.stored, path.dissipated], rtol=1e-9, atol=1e-9 * path.work[0])


def table_fingerprint(path):
    """The checksum of the file."""
    return int(path.read_text().split()[-1], 16)


@pytest.mark.parametrize("name", GOOD)
def test_beyond_the_last_row_there_is_no_value(name, reader):
    path = TABLES / "good" / f"{name}.tbl"
    table = dl.Table.load(path)
    contact = table.contact
    beyond = float(table.largest_overlap) * (1.0 + 1e-9)
    answer = reader(f"table {path} {contact.modulus!r} {contact.radius!r} {contact.sigma!r}", f"overlap {beyond!r}")[1]
    assert answer.split()[-1] == "1"
    with pytest.raises(dl.DemlawsError, match="beyond the table"):
        table.force(beyond)


def test_files_with_a_fault_are_refused_alike(reader, tmp_path):
    """The same line is named by both."""
    paths = [tmp_path / f"{name}.tbl" for name in FAULTS]
    for path, (data, _) in zip(paths, FAULTS.values(), strict=True):
        path.write_bytes(data)
    answers = reader(*(f"table {path} 1e9 1e-3 1e-6" for path in paths))
    wrong = {}
    for path, answer in zip(paths, answers, strict=True):
        try:
            dl.Table.load(path)
            message = "good"
        except dl.DemlawsError as error:
            message = str(error)
        for language, text in (("Python", message), ("C++", answer.removeprefix("refused "))):
            found = re.match(f".*{re.escape(path.name)}" + r", line (\d+): \S", text)
            line = FAULTS[path.stem][1]
            if found is None or int(found[1]) != line:
                wrong[f"{path.stem}, {language}: line {line}"] = text
    assert wrong == {}


def test_a_former_version_is_refused_with_the_command_that_makes_the_table_again(tmp_path):
    (tmp_path / "a.tbl").write_bytes(FAULTS["former-version"][0])
    with pytest.raises(dl.DemlawsError, match="demlaws table --law NAME"):
        dl.Table.load(tmp_path / "a.tbl")


WORDS = (b"", *b"0 -1 1e400 1e-400 nan +3 2. .5 0x1 1_0 007 none {} yes table".split())


def changed(lines, rng):
    """One change of a file's text: a line left out, doubled or exchanged, a word or a byte replaced."""
    lines, place = list(lines), int(rng.integers(0, len(lines)))
    kind = int(rng.integers(0, 6))
    if kind == 0:
        del lines[place]
    elif kind == 1:
        lines.insert(place, lines[place])
    elif kind == 2:
        other = int(rng.integers(0, len(lines)))
        lines[place], lines[other] = lines[other], lines[place]
    elif kind == 3:
        words = lines[place].split(b" ")
        words[int(rng.integers(0, len(words)))] = WORDS[int(rng.integers(0, len(WORDS)))]
        lines[place] = b" ".join(words)
    elif kind == 4 and lines[place]:
        at = int(rng.integers(0, len(lines[place])))
        lines[place] = lines[place][:at] + bytes([int(rng.choice(PRINTABLE))]) + lines[place][at + 1 :]
    else:
        at = int(rng.integers(0, len(lines[place]) + 1))
        lines[place] = lines[place][:at] + bytes([int(rng.choice(PRINTABLE))]) + lines[place][at:]
    return lines or [b""]


PRINTABLE = np.frombuffer(b' 0123456789.-+eE:,{}[]"abcxyz_\t\r\xc3\xff', np.uint8)


def test_any_change_with_a_checksum_that_fits_gives_one_verdict(reader, tmp_path, rng):
    """What a program that writes tables wrongly would write: both readers take it, or name the same line."""
    sources = [name for name in GOOD if (TABLES / "good" / f"{name}.tbl").stat().st_size < 6000]
    verdicts, questions, contents = [], [], []
    for n in range(CHANGES):
        path = tmp_path / f"{n}.tbl"
        path.write_bytes(sealed(changed(lines_of(sources[n % len(sources)]), rng)))
        contents.append(path.read_bytes())
        questions.append(f"table {path} 1e9 1e-3 1e-6")
        try:
            dl.Table.load(path)
            verdicts.append("good")
        except dl.DemlawsError as error:
            verdicts.append(re.search(r"line \d+:", str(error))[0])
    told = [re.search(r"line \d+:|^good", answer)[0] for answer in reader(*questions)]
    wrong = [(a, b, c) for a, b, c in zip(told, verdicts, contents, strict=True) if a != b]
    assert wrong == []
    assert verdicts.count("good") >= CHANGES // 20


def test_a_table_is_written_again_as_the_same_table(tmp_path):
    for name in GOOD:
        one = dl.Table.load(TABLES / "good" / f"{name}.tbl")
        other = dl.Table.load(one.save(tmp_path / f"{name}.tbl"))
        assert other.contact == one.contact
        pairs = [(one, other)] if one.unloading_law is None else [(one, other), (one.unloading_law, other.unloading_law)]
        for a, b in pairs:
            assert all(np.array_equal(x, y) for x, y in zip(a.nodes, b.nodes, strict=True))
            assert a.curve.shape.grid.seat == b.curve.shape.grid.seat


def test_a_curve_of_one_contact_is_not_lent(reader):
    """`Pair::checked` and `serves` of a table that does not collapse, and of one that does."""
    one = dl.Table.load(TABLES / "good" / "greenwood-tripp-elastic.tbl").contact
    modulus, radius = one.modulus, one.radius
    contacts = ((modulus, radius, 0.0), (modulus, 1.02 * radius, 0.0), (1.01 * modulus, radius, 0.0), (modulus, radius, 1e-6))
    asked = [f"contact {' '.join(map(repr, contact))}" for contact in contacts]
    opening = f"{modulus!r} {radius!r} {one.sigma!r}"
    told = reader(f"table {TABLES / 'good' / 'greenwood-tripp-elastic.tbl'} {opening}", *asked)[1:]
    assert told[:2] == ["served 1", "served 0"]
    assert "does not collapse" in told[2] and "effective modulus" in told[2] and "make a table of this pair" in told[2]
    assert "does not collapse" in told[3] and "no roughness" in told[3]
    assert reader(f"table {TABLES / 'good' / 'three-kinks.tbl'} {opening}", *asked)[1:] == ["served 1"] * 4


def test_the_facts_of_the_header_are_those_of_python():
    assert facts.PATH.read_text() == facts.header(), "run `make facts`"


@pytest.mark.parametrize("name", shared([name for name in GOOD if "bulk" not in name], FEW.__contains__))
def test_shear_stiffnesses_are_those_of_python(name, reader):
    """Of each choice, on loading, unloading, reloading and beyond, in a step and without one."""
    from demlaws.core.shear import CHOICES

    path = TABLES / "good" / f"{name}.tbl"
    table = dl.Table.load(path)
    contact = table.contact
    largest = table.nodes.u[-1] * table.length
    overlaps = np.array([0.1, 0.3, 0.3 * (1 - 1e-9), 0.29, 0.2, 0.299, 0.5, 0.4]) * min(largest, 0.1 * contact.radius)
    lines = [f"table {path} {float(contact.modulus)!r} {float(contact.radius)!r} {float(contact.sigma)!r}"]
    _, *answers = reader(*lines, *(f"shear {float(overlap)!r}" for overlap in overlaps))
    found = np.array([[float(value) for value in line.split()] for line in answers])
    for n, choice in enumerate(CHOICES):
        expected = table.shear_stiffness(overlaps, 1.0, choice)
        np.testing.assert_allclose(found[:, 2 + n], expected, rtol=1e-8)
        np.testing.assert_allclose(found[:, n], expected, rtol=1e-8)


def test_shear_stiffness_where_rounding_leaves_no_recoverable_overlap(reader):
    """From the force alone, K = 2 E* √R' (3P/(4 E* √R'))^(1/3): R' = R for rule hertz, R times the ratio for thornton."""
    modulus, radius, force, overlap, ratio = 3e10, 4e-3, 2e-6, 1e-3, 1.7
    lines = [f"table {TABLES}/good/pohrt-popov-hertz.tbl {modulus!r} {radius!r} 2e-06"]
    lines += [
        f"recoverable {force!r} {overlap!r} {plastic!r} {ratio!r}" for plastic in (overlap * (1.0 - 1e-13), 0.5 * overlap)
    ]
    _, lost, kept = reader(*lines)
    expected = [2 * modulus * r**0.5 * (0.75 * force / (modulus * r**0.5)) ** (1 / 3) for r in (radius, ratio * radius)]
    assert list(map(float, lost.split())) == pytest.approx(expected, rel=1e-12)
    assert list(map(float, kept.split())) == pytest.approx(2 * [1.5 * force / (0.5 * overlap)], rel=1e-12)
