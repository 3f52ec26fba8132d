"""Measured points: which of them are first loading, and the files that they come in."""

import io
import sys
from pathlib import Path

import numpy as np
import pytest

import demlaws as dl
from demlaws import granite
from demlaws.curves.point_files import Points, columns_of, in_contact, read_points
from demlaws.errors import DemlawsError

TEST = granite.find_test("SS(18-18)")


@pytest.fixture(scope="module")
def bound():
    return granite.bind("pohrt-popov", TEST, "hertz")


def measured(bound, turning_points, steps=40, noise=0.0):
    path = dl.driver.force_controlled(bound, turning_points, steps)
    scatter = noise * np.random.default_rng(1).standard_normal((2, path.force.size))
    return Points(path.overlap - 7e-6 + 1e-9 * scatter[0], path.force + scatter[1], "made")


@pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")
def test_a_loop_of_unloading_is_no_first_loading(bound):
    loop = measured(bound, [40.0, 0.0, 100.0])
    first = loop.loading_mask()
    path_of_forces = loop.force[first]
    assert np.all(np.diff(path_of_forces) >= 0)
    assert path_of_forces.size == 66  # 0 to 40 N, and of the second branch what lies above 40 N
    several = measured(bound, [30.0, 10.0, 50.0, 20.0, 100.0, 60.0])
    assert np.all(np.diff(several.force[several.loading_mask()]) >= 0)
    assert several.force[several.loading_mask()][-1] == pytest.approx(100.0)


@pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")
def test_noise_is_no_unloading(bound):
    noisy = measured(bound, [100.0], 400, noise=0.02)
    assert np.sum(np.diff(noisy.force) < 0) == 0 or noisy.loading_mask().all()
    dips = noisy._replace(force=noisy.force * (1 + 0.01 * (-1.0) ** np.arange(noisy.force.size)))
    assert np.sum(np.diff(dips.force) < 0) > 100
    assert dips.loading_mask()[: int(np.argmax(dips.force)) + 1].mean() > 0.95


DATA = Path(__file__).parents[1] / "data" / "points"


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1"])
@pytest.mark.parametrize("path", sorted((DATA / "good").iterdir()), ids=lambda path: path.stem)
def test_files(tmp_path, path, encoding):
    file = tmp_path / "points.txt"
    file.write_bytes(path.read_bytes().decode().encode(encoding))
    points = read_points(file)
    np.testing.assert_allclose(points.displacement, [1.5e-6, 2e-6, 3e-6], rtol=1e-12)
    np.testing.assert_allclose(points.force, [0.5, 1.5, 3.0], rtol=1e-12)


@pytest.mark.parametrize("path", sorted((DATA / "bad").iterdir()), ids=lambda path: path.stem)
def test_bad_files(path):
    with pytest.raises(DemlawsError):
        read_points(path)
    with pytest.raises(DemlawsError, match="cannot read points"):
        read_points(path.parent)


TITLES = {
    "displacement (um)": 1e-6,
    "Disp. [µm]": 1e-6,
    "Depth (nm) - 1": 1e-9,
    "penetration [\u212b]": 1e-10,
    "overlap (micron) 2": 1e-6,
    "Displacement (in)": 0.0254,
}


@pytest.mark.parametrize("title", TITLES)
def test_titles_of_exports(title, tmp_path):
    for force, unit in (("Load (gf)", 9.80665e-3), ("Force [kgf]", 9.80665), ("load (lbf)", 4.4482216152605)):
        (tmp_path / "a.txt").write_text(f"{title};{force}\n1;1\n2;2.5\n3;4\n", encoding="utf-8")
        points = read_points(tmp_path / "a.txt")
        np.testing.assert_allclose(points.displacement, TITLES[title] * np.array([1.0, 2.0, 3.0]), rtol=1e-12)
        np.testing.assert_allclose(points.force, unit * np.array([1.0, 2.5, 4.0]), rtol=1e-12)


def test_increments_and_errors_are_no_displacement(tmp_path):
    """They have its unit."""
    rows = "1;9;0.1;1\n2;8;0.1;2.5\n3;7;0.1;4\n"
    (tmp_path / "a.txt").write_text(f"Displacement (mm);Displacement increment (mm);Disp. error (mm);Force (N)\n{rows}")
    np.testing.assert_allclose(read_points(tmp_path / "a.txt").displacement, [1e-3, 2e-3, 3e-3], rtol=1e-12)
    (tmp_path / "b.txt").write_text("Displacement increment (mm);Force (N)\n1;1\n2;2\n3;3\n")
    with pytest.raises(DemlawsError, match="displacement"):
        read_points(tmp_path / "b.txt")


def test_an_error_names_the_line_of_the_first_number(tmp_path):
    (tmp_path / "a.csv").write_text("Report, page 1\nby nobody\n\nWeg (mm);Kraft (N)\n1;2\n2;3\n3;4\n")
    with pytest.raises(DemlawsError, match=r"line 5.*Weg"):
        read_points(tmp_path / "a.csv")


def test_a_pull_is_no_noise_of_the_load_cell():
    loading, unloading = np.linspace(0.1, 20.0, 40), np.linspace(19.0, 0.2, 30)
    pull = -2.0 * np.sin(np.linspace(0.1, 3.0, 12))
    keep, skipped = in_contact(np.concatenate([loading, unloading, pull]), 0.0)
    assert keep[:70].all() and not keep[70:].any()
    assert any("adhere" in reason for reason in skipped.values())
    noise = 0.05 * np.random.default_rng(1).standard_normal((2, 20))
    keep, skipped = in_contact(np.concatenate([noise[0], loading + 0.5, unloading, noise[1]]), 0.0)
    assert not keep[:20].any() and keep[20:88].all() and not any("adhere" in reason for reason in skipped.values())
    keep, skipped = in_contact(np.concatenate([noise[0], loading + 0.5, unloading, pull]), 0.0)
    assert keep[20:88].all() and len(skipped) == 2


def test_standard_input(monkeypatch):
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO((DATA / "good" / "indenter.txt").read_bytes())))
    points = read_points("-")
    assert points.source == "standard input"
    np.testing.assert_allclose(points.displacement, [1.5e-6, 2e-6, 3e-6], rtol=1e-12)


DEPTH, LOAD = np.array([1500.0, 2000.0, 3000.0]), np.array([0.5, 1.5, 3.0])
TITLED = {
    "indenter": {"Time (s)": LOAD, "Depth (nm)": DEPTH, "Load (µN)": 1e6 * LOAD},
    "SI": {"force": LOAD, "displacement": 1e-9 * DEPTH},
    "a path": {"overlap (m)": 1e-9 * DEPTH, "force (N)": LOAD, "plastic overlap (m)": LOAD},
}


@pytest.mark.parametrize("kind", ["dict", "frame"])
@pytest.mark.parametrize("titles", TITLED)
def test_titles_of_a_table_give_its_units(titles, kind):
    table = TITLED[titles]
    if kind == "frame":
        table = pytest.importorskip("pandas").DataFrame(table)
    displacement, force = columns_of(table)
    np.testing.assert_allclose(displacement, 1e-9 * DEPTH, rtol=1e-12)
    np.testing.assert_allclose(force, LOAD, rtol=1e-12)


def test_titles_without_a_meaning_are_refused():
    for table in (
        {"x (nm)": DEPTH, "y": LOAD},
        {"depth (s)": DEPTH, "load (N)": LOAD},
        {"depth (nm)": ["a"], "load (N)": [1.0]},
    ):
        with pytest.raises(DemlawsError):
            columns_of(table)
    np.testing.assert_array_equal(columns_of(pytest.importorskip("pandas").DataFrame(np.ones((3, 2)))), np.ones((2, 3)))


def test_a_file_is_read_by_its_name(tmp_path):
    (tmp_path / "test.csv").write_text("displacement (um),force (N)\n1,0.5\n2,1.5\n3,3\n")
    np.testing.assert_allclose(columns_of(tmp_path / "test.csv"), [[1e-6, 2e-6, 3e-6], [0.5, 1.5, 3.0]])


@pytest.mark.parametrize("titles", ["Displacement / nm;Load / mN", "depth_nm;load_mN", "depth_nm;load_milli_N (mN)"])
def test_units_behind_a_slash_or_an_underscore(titles, tmp_path):
    """They were refused as titles without a unit."""
    (tmp_path / "a.txt").write_text(titles + "\n1500;500\n2000;1500\n3000;3000\n")
    points = read_points(tmp_path / "a.txt")
    np.testing.assert_allclose(points.displacement, 1e-9 * DEPTH, rtol=1e-12)
    np.testing.assert_allclose(points.force, LOAD, rtol=1e-12)


def test_a_header_with_numbers_behind_a_word(tmp_path):
    """LabVIEW's "Samples 40 40" was taken for the first row."""
    head = "LabVIEW Measurement\t\nChannels\t2\t\nSamples\t40\t40\nX0\t0.0\t0.0\n"
    rows = "0\t1.5\t0.5\n1\t2\t1.5\n2\t3\t3\n"
    (tmp_path / "a.lvm").write_text(head + "X_Value\tDisplacement (um)\tForce (N)\tComment\n" + rows)
    np.testing.assert_allclose(read_points(tmp_path / "a.lvm").force, LOAD, rtol=1e-12)


def test_results_of_the_package_are_points():
    """A Path was a TypeError, a DataFrame with "displacement" and "load" an AttributeError."""
    contact = dl.Contact(4e-3, 32e9)
    path = dl.driver.force_controlled(dl.law("hertz", contact), [50.0], steps=30)
    np.testing.assert_array_equal(columns_of(path), [path.overlap, path.force])
    assert dl.fit(path, contact, laws="hertz").best.parameters["modulus"].value == pytest.approx(32e9, rel=1e-6)
    assert dl.Table.from_points(path, contact).force(path.overlap[-2]) == pytest.approx(path.force[-2], rel=1e-2)
    pandas = pytest.importorskip("pandas")
    for force in ("load", "force (N)"):
        frame = pandas.DataFrame({"displacement": path.overlap, force: path.force})
        np.testing.assert_array_equal(columns_of(frame), [path.overlap, path.force])


def test_impossible_forces_and_titles(tmp_path):
    """1e308 N was TypeError or OverflowError, a title of 120 kB of blanks took 38 s, a jump by 1e9 gave a falling table."""
    contact, force = dl.Contact(4e-3, 32e9), np.linspace(1.0, 30.0, 16)
    overlap = dl.law("hertz", contact).overlap(force)
    for last, use in ((1e308, dl.fit), (1e308, dl.Table.from_points), (24e9, dl.Table.from_points)):
        with pytest.raises(DemlawsError, match=r"of point 16 is no measurement|from a rising curve"):
            use(np.column_stack([overlap, np.append(force[:-1], last)]), contact)
    (tmp_path / "a.csv").write_text("displacement (um),force" + " " * 2000 + "(" + " " * 400_000 + "\n1,2\n2,3\n3,4\n")
    with pytest.raises(DemlawsError, match="no unit of force"):
        read_points(tmp_path / "a.csv")
