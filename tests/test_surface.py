import math
import sys
import types
from pathlib import Path

import numpy as np
import pytest
from examples import shared
from hypothesis import given, settings, strategies as st

import demlaws as dl
from demlaws import surface
from demlaws.surface import HeightMap, self_affine

DATA = Path(__file__).parent / "data" / "maps"


def test_roughness_of_a_known_surface():
    x = np.arange(200) * 2 * np.pi / 50
    wave = HeightMap(np.tile(3e-6 * np.sin(x), (64, 1)) + 7e-6, 1e-6, 2e-6)
    assert wave.sq == pytest.approx(3e-6 / math.sqrt(2), rel=1e-12)
    assert wave.sa == pytest.approx(3e-6 * 2 / math.pi, rel=2e-3)
    assert wave.field_of_view == pytest.approx((200e-6, 128e-6))
    assert wave.slope == pytest.approx(3e-6 * 2 * math.pi / 50e-6 / math.sqrt(2), rel=1e-2)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 5), st.integers(0, 10**6), st.booleans())
def test_form_of_its_order_is_removed_and_nothing_else(order, seed, holes):
    rng = np.random.default_rng(seed)
    y, x = np.meshgrid(np.linspace(-1, 1, 40), np.linspace(-1, 1, 55), indexing="ij")
    form = sum(rng.standard_normal() * x**i * y**j for i in range(order + 1) for j in range(order + 1 - i))
    z = form * 1e-3 + 5e-3
    if holes:
        z[rng.random(z.shape) < 0.1] = np.nan
    left = HeightMap(z, 1e-6).without_form(order)
    assert np.nanmax(np.abs(left.heights)) < 1e-12
    assert left.form_order == order
    assert HeightMap(z, 1e-6).without_form(np.float64(order)).form_order == order
    # taking form away twice changes nothing
    rough = HeightMap(z + 1e-6 * rng.standard_normal(z.shape), 1e-6).without_form(order)
    np.testing.assert_allclose(rough.without_form(order).heights, rough.heights, atol=1e-15)


@pytest.mark.parametrize(
    ("hurst", "size"),
    shared(
        [*((hurst, 512) for hurst in (0.1, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95)), (0.8, 1024)],
        [(0.1, 512), (0.8, 512), (0.95, 512)].__contains__,
    ),
)
@pytest.mark.parametrize("periodic", [False, True])
def test_fractal_dimension_of_self_affine_maps(hurst, size, periodic):
    """Both methods within 0.05 of 3 - H, on three maps each."""
    for seed in range(3):
        heights = self_affine(size, 1e-6, hurst, roughness=2e-6, seed=seed, periodic=periodic)
        assert abs(heights.fractal_dimension_by_boxes() - (3 - hurst)) < 0.05
        assert abs(heights.fractal_dimension_by_spectrum() - (3 - hurst)) < 0.05


def test_fractal_dimension_survives_form_missing_pixels_and_units():
    heights = self_affine(512, 1e-6, 0.8, roughness=2e-6, seed=4)
    rng = np.random.default_rng(0)
    y, x = np.indices(heights.shape) * 1e-6
    z = heights.heights + 0.02 * x + (x**2 + y**2) / 2e-3
    z[rng.random(z.shape) < 0.02] = np.nan
    z[100:130, 200:240] = np.nan
    curved = HeightMap(z, 1e-6).without_form(2)
    assert curved.missing == pytest.approx(0.02 + 1200 / 512**2, abs=0.003)
    assert abs(curved.fractal_dimension_by_boxes() - 2.2) < 0.05
    assert abs(curved.fractal_dimension_by_spectrum() - 2.2) < 0.05
    thousandth = HeightMap(heights.heights * 1e-3, 1e-9)
    assert thousandth.fractal_dimension_by_boxes() == pytest.approx(heights.fractal_dimension_by_boxes(), abs=2e-3)
    assert thousandth.fractal_dimension_by_spectrum() == pytest.approx(heights.fractal_dimension_by_spectrum(), abs=1e-9)


def test_spectrum_holds_the_variance():
    """∫C d²q = Sq² within what the window leaves uncertain."""
    heights = self_affine((300, 400), 1e-6, 0.5, roughness=1e-6, seed=1, longest=40e-6)
    q, density, count = heights.spectrum()
    cell = (2 * np.pi) ** 2 / np.prod(heights.field_of_view)
    assert (density * count).sum() * cell == pytest.approx(heights.sq**2, rel=0.1)
    inside = (q > 2 * np.pi / 20e-6) & (q < 2 * np.pi / 3e-6)
    slope = np.polyfit(np.log(q[inside]), np.log(density[inside]), 1)[0]
    assert slope == pytest.approx(-2 - 2 * 0.5, abs=0.15)
    with pytest.raises(dl.DemlawsError):
        heights.fractal_dimension_by_spectrum(wavelengths=(10e-6, 10.1e-6))


@pytest.mark.parametrize("waves", [(20, 9), (7, 0), (0, 16)])
def test_spectrum_of_a_plane_wave_is_its_variance(waves):
    """Parseval: the Hann windows take 3/8 of each direction of any whole number of waves from 3 on."""
    rows, columns = 128, 150
    y, x = np.indices((rows, columns)) + 0.5
    wave = 2e-6 * np.cos(2 * np.pi * waves[0] * y / rows) * np.cos(2 * np.pi * waves[1] * x / columns)
    heights = HeightMap(wave, 1e-6, 2e-6)
    _, density, count = heights.spectrum()
    cell = (2 * np.pi) ** 2 / np.prod(heights.field_of_view)
    assert (density * count).sum() * cell / np.mean(wave**2) == pytest.approx(1.0, rel=1e-9)


def test_filling_touches_missing_pixels_only_and_is_smooth():
    y, x = np.indices((70, 90))
    z = 1e-6 * np.sin(x / 15.0) * np.cos(y / 11.0)
    holes = z.copy()
    holes[10:20, 30:42] = np.nan
    holes[0, 0] = holes[69, 89] = np.nan
    filled = HeightMap(holes, 1e-6).filled().heights
    known = np.isfinite(holes)
    np.testing.assert_array_equal(filled[known], z[known])
    assert np.abs(filled - z)[~known].max() < 0.5e-6
    assert HeightMap(z, 1e-6).filled().heights is not None


def test_synthetic_maps_are_seeded_and_as_asked():
    one, two = (
        self_affine((64, 96), 1e-6, 0.7, roughness=1e-6, seed=5),
        self_affine((64, 96), 1e-6, 0.7, roughness=1e-6, seed=5),
    )
    np.testing.assert_array_equal(one.heights, two.heights)
    assert not np.array_equal(one.heights, self_affine((64, 96), 1e-6, 0.7, roughness=1e-6, seed=6).heights)
    assert one.shape == (64, 96) and one.sq == pytest.approx(1e-6, rel=1e-12)
    long = self_affine(256, 1e-6, 0.8, roughness=1e-6, seed=1, anisotropy=6.0)
    assert np.diff(long.heights, axis=0).std() > 2.5 * np.diff(long.heights, axis=1).std()
    smooth = self_affine(256, 1e-6, 0.8, roughness=1e-6, seed=1, shortest=8e-6)
    assert smooth.slope < 0.9 * self_affine(256, 1e-6, 0.8, roughness=1e-6, seed=1).slope


def test_a_map_becomes_a_surface():
    found = self_affine(256, 2e-6, 0.78, roughness=2.4e-6, seed=2).surface(hardness=6e9)
    assert isinstance(found, dl.Surface)
    assert found.roughness == pytest.approx(2.4e-6) and found.hardness == 6e9
    assert found.fractal_dimension == pytest.approx(2.22, abs=0.05)
    assert HeightMap(np.zeros((8, 8)), 1e-6).surface().roughness == 0.0


# --- files


@pytest.mark.parametrize("suffix", [".npy", ".csv", ".asc"])
def test_files_come_back(tmp_path, suffix):
    heights = HeightMap(
        self_affine((20, 30), 0.5e-6, 0.8, roughness=0.1e-6, seed=1).heights, 0.5e-6, 1.5e-6 if suffix == ".asc" else None
    )
    holes = heights.heights.copy()
    holes[3, 4] = np.nan
    path = surface.write(tmp_path / f"map{suffix}", heights.with_heights(holes))
    back = surface.read(path, pixel=None if suffix == ".asc" else 0.5e-6)
    np.testing.assert_allclose(back.heights, holes, rtol=1e-8, atol=1e-20)
    assert (back.pixel_x, back.pixel_y) == pytest.approx((heights.pixel_x, heights.pixel_y), rel=1e-12)


@pytest.mark.parametrize("path", sorted((DATA / "good").iterdir()), ids=lambda path: path.stem)
def test_text_formats(path):
    """Their names end with the number of missing pixels."""
    heights = surface.read(path, pixel="20um", unit="um")
    assert heights.shape == (4, 4)
    assert int(np.isnan(heights.heights).sum()) == int(path.stem[-1])
    assert heights.heights[0, 0] == pytest.approx(1e-6)
    assert heights.heights[0, 3] == pytest.approx(4.5e-6 if "semicolons" in path.stem else 4e-6)
    assert heights.pixel_x == pytest.approx(20e-6)


@pytest.mark.parametrize("encoding", ["utf-8", "latin-1", "utf-16", "utf-8-sig"])
def test_gwyddion_header_in_the_encodings_of_instruments(tmp_path, encoding):
    path = tmp_path / "g.txt"
    path.write_text(
        "# Channel: Height\n# Width: 8.0 µm\n# Height: 4.0 µm\n# Value units: µm\n" + "1 2 3 4\n" * 4, encoding=encoding
    )
    heights = surface.read(path)
    assert (heights.pixel_x, heights.pixel_y) == pytest.approx((2e-6, 1e-6))
    assert heights.heights[0, 3] == pytest.approx(4e-6)


@pytest.mark.parametrize(
    "labels",
    [
        ("Kanal", "Breite", "Höhe", "Einheiten"),
        ("Canal", "Largeur", "Hauteur", "Unités"),
        ("チャネル", "幅", "高さ", "値の単位"),
    ],
)
def test_gwyddion_header_in_the_languages_of_its_windows(tmp_path, labels):
    """Pixels were missing, and heights in V were taken in metres."""
    path, rows = tmp_path / "g.txt", "1 2 3 4\n" * 4
    head = f"# {labels[0]}: a\n# {labels[1]}: 8,0 µm\n# {labels[2]}: 4.0 µm\n# {labels[3]}: "
    path.write_text(f"{head}nm\n{rows}", encoding="utf-8")
    heights = surface.read(path)
    assert (heights.pixel_x, heights.pixel_y) == pytest.approx((2e-6, 1e-6))
    assert heights.heights[0, 3] == pytest.approx(4e-9)
    path.write_text(f"{head}V\n{rows}", encoding="utf-8")
    with pytest.raises(dl.DemlawsError, match="heights in 'V'"):
        surface.read(path)


def test_masked_heights_are_missing():
    heights = self_affine(20, 1e-6, 0.8, roughness=1e-6, seed=1).heights
    masked = np.ma.array(heights, mask=heights > 1e-6)
    masked.data[masked.mask] = 1.0
    assert HeightMap(masked, 1e-6).sq == pytest.approx(float(np.std(heights[heights <= 1e-6])))
    for other in (heights + 1j, heights > 0):
        with pytest.raises(dl.DemlawsError):
            HeightMap(other, 1e-6)


@pytest.mark.parametrize("path", sorted((DATA / "bad").iterdir()), ids=lambda path: path.name)
def test_bad_files_are_refused(path):
    with pytest.raises(dl.DemlawsError):
        surface.read(path, pixel=1e-6)


@pytest.mark.parametrize(
    "call",
    [
        lambda path: surface.read(path.with_name("none.npy")),
        lambda path: surface.read(path),
        lambda path: surface.read(path, pixel="1 league"),
        lambda path: surface.read(path, pixel="-1um"),
        lambda path: surface.read(path, pixel=1e-6, unit="feet"),
        lambda path: self_affine(64, 1e-6, 0.5, roughness=1e-6, seed=1, shortest=1.0),
        lambda path: HeightMap(np.zeros((16, 16)), 1e-6).fractal_dimension_by_boxes(),
        lambda path: surface.write(path.with_name("m.tif"), self_affine(8, 1e-6, 0.8, roughness=1e-6, seed=1)),
    ],
)
def test_bad_arguments_are_refused(tmp_path, call):
    path = surface.write(tmp_path / "m.npy", self_affine(8, 1e-6, 0.8, roughness=1e-6, seed=1))
    with pytest.raises(dl.DemlawsError):
        call(path)


def test_other_files_need_surface_topography(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "SurfaceTopography", None)
    (tmp_path / "map.opd").write_bytes(b"anything")
    with pytest.raises(dl.DemlawsError, match=r"demlaws\[surfaces\]"):
        surface.read(tmp_path / "map.opd")


def test_instrument_files_go_through_surface_topography(tmp_path):
    """A map written by SurfaceTopography (NetCDF), with a unit, missing pixels and a shape."""
    topography = pytest.importorskip("SurfaceTopography")
    z = np.arange(24, dtype=float).reshape(4, 6) * 0.1  # rows along y, in µm
    z[1, 2] = np.nan
    theirs = topography.Topography(np.ma.masked_invalid(z).T, physical_sizes=(12.0, 4.0), unit="µm")
    theirs.to_netcdf(str(tmp_path / "map.nc"))
    heights = surface.read(tmp_path / "map.nc")
    assert heights.shape == (4, 6)
    assert (heights.pixel_x, heights.pixel_y) == pytest.approx((2e-6, 1e-6))
    np.testing.assert_allclose(heights.heights, z * 1e-6, rtol=1e-12)
    bad = tmp_path / "bad.opd"
    bad.write_bytes(b"not a surface")
    with pytest.raises(dl.DemlawsError, match="SurfaceTopography cannot read") as error:
        surface.read(bad)
    assert len(str(error.value)) < 300


@pytest.mark.parametrize(("suffix", "reason"), [("x3p", "main.xml is missing"), ("di", "none of its 2 readers takes")])
def test_the_reason_of_many_readers_is_that_of_the_suffix(suffix, reason, tmp_path, monkeypatch):
    """An archive with its files in a folder: "cannot read sample.x3p: tried XYZReader:"."""

    def refuse(path):
        raise OSError("tried XYZReader: \n Could not parse.\n\ntried X3PReader: \n Archive member main.xml is missing.\n\n")

    monkeypatch.setitem(sys.modules, "SurfaceTopography", types.SimpleNamespace(open_topography=refuse))
    (tmp_path / f"sample.{suffix}").write_bytes(b"PK")
    with pytest.raises(dl.DemlawsError, match=reason):
        surface.read(tmp_path / f"sample.{suffix}")


# --- fields of view, curvature, plain counting


def cap(radius_x, radius_y, angle=0.0, shape=(120, 150), roughness=0.0):
    y, x = (np.indices(shape) - 60.0) * 1e-6
    u, v = x * math.cos(angle) + y * math.sin(angle), y * math.cos(angle) - x * math.sin(angle)
    z = -(u**2) / (2.0 * radius_x) - v**2 / (2.0 * radius_y)
    if roughness:
        z = z + self_affine(shape, 1e-6, 0.8, roughness=roughness, seed=1, longest=20e-6).heights
    return HeightMap(z, 1e-6)


def test_radius_of_a_tip():
    """The cone RFC10 has a tip of 0.96 mm; a toric cap keeps both radii however it is turned; a cylinder has one."""
    assert cap(0.96e-3, 0.96e-3).radii_of_curvature() == pytest.approx((0.96e-3, 0.96e-3), rel=1e-9)
    assert cap(1e-3, 4e-3, 0.7).radii_of_curvature() == pytest.approx((1e-3, 4e-3), rel=1e-9)
    assert cap(1e-3, -4e-3, 0.7).radii_of_curvature() == pytest.approx((1e-3, -4e-3), rel=1e-9)
    assert cap(1e-3, math.inf).radii_of_curvature() == (pytest.approx(1e-3), math.inf)
    assert cap(0.96e-3, 0.96e-3, roughness=0.2e-6).radii_of_curvature() == pytest.approx((0.96e-3, 0.96e-3), rel=0.1)
    missing = cap(0.96e-3, 0.96e-3).heights.copy()
    missing[30:50, 70:90] = np.nan
    assert HeightMap(missing, 1e-6).radii_of_curvature() == pytest.approx((0.96e-3, 0.96e-3), rel=1e-9)


@pytest.mark.parametrize("radius", [2.5e-3, -2.5e-3, 4.35e-3])
def test_a_ball_leaves_nothing(radius, monkeypatch):
    """Its paraboloid leaves h⁴/(8R³): 18 µm at the rim of the smaller ball, 40 nm on the other."""
    half, (rows, columns) = (1.7e-3 if abs(radius) < 3e-3 else 0.35e-3), (90, 110)
    x, y = np.linspace(-half, half, columns), np.linspace(-0.8 * half, 0.8 * half, rows)[:, None]
    square = (x - 0.05 * radius) ** 2 + (y + 0.02 * radius) ** 2
    z = math.copysign(1.0, radius) * np.sqrt(radius**2 - square) + 1e-3
    z[3:8, 40:60] = np.nan
    ball = HeightMap(z, x[1] - x[0], float(y[1, 0] - y[0, 0]))
    assert ball.radii_of_curvature() == pytest.approx((radius, radius), rel=1e-9)
    left = ball.without_form(2)
    assert left.form_order == "sphere" and left.sq < 1e-12
    rough = self_affine((rows, columns), ball.pixel_x, 0.8, roughness=50e-9, seed=1, longest=20 * ball.pixel_x)
    assert ball.with_heights(z + rough.heights).without_form(2).sq == pytest.approx(50e-9, rel=0.02)
    monkeypatch.setattr(HeightMap, "_form", None)
    assert ball.without_form(2) is left  # one fit for radii and form
    monkeypatch.undo()
    # a paraboloid stays one
    cap = HeightMap(np.zeros((rows, columns)) - (x**2 + y**2) / (2 * radius), x[1] - x[0], float(y[1, 0] - y[0, 0]))
    assert cap.without_form(2).form_order == 2


def test_field_of_view():
    heights = HeightMap(np.arange(20.0 * 30.0).reshape(20, 30) * 1e-9, 1e-6, 2e-6)
    part = heights.cropped("10um", "20um")
    assert part.shape == (10, 10) and part.heights[0, 0] == heights.heights[5, 10]
    assert (part.pixel_x, part.pixel_y) == (1e-6, 2e-6)
    for field in ({"width": 31e-6}, {"width": 2e-6}):
        with pytest.raises(dl.DemlawsError):
            heights.cropped(**field)


HEADERS = {
    "keyence.csv": '"Measured date","2026/05/12"\n"Model","VK-X150"\n"Comment",""\n"XY Calibration","0.500","um"\n'
    '"Horizontal","8"\n"Vertical","6"\n"Unit","um"\n""\n"Height"\n',
    "keyence_nm.csv": '"Measured date","2026/05/12"\n"XY Calibration","500","nm/pixel"\n"Unit","µm"\n"Vertical","6"\n',
    "mountains.txt": "# File Format = ASCII\n# Created\n# Start Header\n# x-pixels = 8\n# y-pixels = 6\n# x-length = 4\n"
    "# y-length = 3\n# x-unit = um\n# y-unit = um\n# z-unit = um\n# scanspeed = \n# Start Data:\n",
    "esri.asc": "ncols 8\nnrows 6\ncellsize 0.5\n",
    "wyko.asc": "Wyko ASCII Data File Format 0\t1\t1\nX Size\t6\nY Size\t8\nBlock Name\tType\tLength\tValue\n"
    "Wavelength\t7\t4\t500\nAspect\t7\t4\t1\nPixel_size\t7\t4\t0.0005\nRAW_DATA\t3\t192\n",
    "waves.asc": "Wyko ASCII Data File Format 0\t0\t1\nX Size\t6\nY Size\t8\nBlock Name\tType\tLength\tValue\n"
    "Wavelength\t7\t4\t500\nAspect\t7\t4\t1\nPixel_size\t7\t4\t0.0005\nRAW_DATA\t3\t192\n",
    "zygo.xyz": 'Zygo XYZ Data File - Format 1\n0 3 0 0 ""\n0 0 8 6 1 255\n2 3 8 6\n""\n""\n""\n'
    "0 0 6.328e-07 0.5 1 0 5e-07 1787677163\n3 2 0 0 0 6666\n0 0 0\n0\n0\n0\n#\n",
}
IN_UM = {"wyko.asc": 1e3, "waves.asc": 2.0}
"""Units of height of a file in 1 µm: nm, waves of 500 nm."""


@pytest.mark.filterwarnings("ignore::demlaws.errors.MapWarning")
@pytest.mark.parametrize("name", HEADERS)
def test_headers_of_instruments(name, tmp_path):
    """Pixel size and unit of the file were not read; an ESRI grid in µm was refused as one of metres."""
    z = np.random.default_rng(0).standard_normal((6, 8)).round(4)
    z[2, 3] = np.nan
    rows = [[f'"{v}"' if name.startswith("key") else str(v) for v in IN_UM.get(name, 1.0) * row] for row in z]
    if name == "zygo.xyz":
        lines = [f"{x + 2} {y + 3} {'No Data' if v == 'nan' else v}" for y, row in enumerate(rows) for x, v in enumerate(row)]
        rows = [*([line] for line in lines), ["#"]]
    mark = "," if name.startswith("key") else "\t"
    (tmp_path / name).write_text(HEADERS[name] + "\n".join(mark.join(row) for row in rows) + "\n")
    heights = surface.read(tmp_path / name, unit="um" if name == "esri.asc" else "m")
    np.testing.assert_allclose(heights.heights, 1e-6 * z, rtol=1e-12)
    assert (heights.pixel_x, heights.pixel_y) == pytest.approx((5e-7, 5e-7))
    # the header states the numbers of rows and columns: a file that was cut is not a smaller map
    (tmp_path / f"cut_{name}").write_text(HEADERS[name] + "\n".join(mark.join(row) for row in rows[:-2]) + "\n")
    with pytest.raises(dl.DemlawsError, match=r"truncated|not a whole"):
        surface.read(tmp_path / f"cut_{name}", unit="um" if name == "esri.asc" else "m")


def test_maps_that_cannot_be_read_name_the_remedy(tmp_path):
    """ValueError, IndexError, TokenError and MemoryError, or "a height is not a number"."""
    (tmp_path / "other.asc").write_text("Some Data File\t1\nX Size\t4\nRAW_DATA\t3\t16\n" + "1\t2\t1\t2\n" * 4)
    (tmp_path / "zygo.xyz").write_text(HEADERS["zygo.xyz"] + "11 3 0.5\n#\n")
    (tmp_path / "mountains.txt").write_text(
        HEADERS["mountains.txt"].replace("x-pixels = 8", "x-pixels = 0") + "1\t2\t1\t2\n" * 4
    )
    (tmp_path / "width.asc").write_text("# Width: 1e5e µm\n# Height: 1 mm\n" + "1 2 1 2\n" * 4)
    np.save(tmp_path / "empty.npy", np.ones((0, 5)))
    np.save(tmp_path / "large.npy", np.ones((4, 4)))
    data = (tmp_path / "large.npy").read_bytes()
    (tmp_path / "large.npy").write_bytes(data.replace(b"(4, 4), }" + b" " * 15, b"(400000000000, 4000), }" + b" "))
    for name, reason in (
        ("other.asc", "delete lines 1 to 3"),
        ("zygo.xyz", "line 15 is outside of the grid"),
        ("mountains.txt", "x-pixels"),
        ("width.asc", "Width"),
        ("empty.npy", "shape"),
        ("large.npy", "numpy"),
    ):
        with pytest.raises(dl.DemlawsError, match=reason):
            surface.read(tmp_path / name, pixel=1e-6)


def test_zeros_that_may_be_missing_pixels():
    """Without a gap to the other heights they were not named: 269 of 12,288 pixels."""
    from demlaws.surfaces import plausibility

    z = surface.self_affine(64, 1e-6, 0.8, roughness=1e-6, seed=1)
    assert not any("exactly" in text for text in plausibility.doubts(z))
    heights = z.heights.copy()
    heights[::7, ::5] = 0.0
    assert any("missing=0" in text for text in plausibility.doubts(z.with_heights(heights)))
