"""Height maps that are hardly the measured surface: named with the remedy; plausible maps pass silently."""

import json
import struct
import sys
import types
import warnings

import numpy as np
import pytest

import demlaws as dl
from demlaws import cli, surface
from demlaws.errors import MapWarning
from demlaws.solvers.contact import RoughContact
from demlaws.surface import HeightMap, self_affine
from demlaws.surfaces import plausibility

ROUGH = self_affine(128, 1e-6, 0.7, roughness=0.5e-6, seed=3, longest=40e-6)


def changed(count, height, seed=0):
    """ROUGH with `count` random pixels at about a height [m], each another."""
    z, random = ROUGH.heights.copy(), np.random.default_rng(seed)
    z.ravel()[random.choice(z.size, count, replace=False)] = height * random.uniform(0.9, 1.1, count)
    return HeightMap(z, 1e-6)


def test_plausible_maps_pass():
    """Self-affine maps of all Hurst exponents, with form, with missing pixels; a ground groove pattern; two levels."""
    x = np.arange(128) * 1e-6
    maps = [self_affine(128, 1e-6, hurst, roughness=0.1e-6, seed=1) for hurst in (0.2, 0.5, 0.8, 1.0)]
    cap = HeightMap(ROUGH.heights - (x**2 + x[:, None] ** 2) / 2e-3, 1e-6)
    maps += [cap, changed(500, np.nan), HeightMap(np.tile(1e-6 * np.sin(x / 5e-6), (128, 1)), 1e-6)]
    step = HeightMap(np.where(x < 64e-6, 0.0, 1e-6) * np.ones((128, 1)), 1e-6)
    for heights in [*maps, step]:
        assert plausibility.doubts(heights) == []
    assert ROUGH.robust_sq == pytest.approx(ROUGH.sq, rel=0.15)


def test_spikes():
    """A few spikes make Sq many times the robust one; despiked, the map is what it was."""
    spiky = changed(20, 60e-6)
    assert spiky.sq > 3.0 * ROUGH.sq and spiky.robust_sq == pytest.approx(ROUGH.robust_sq, rel=0.01)
    (text,) = [text for text in plausibility.doubts(spiky) if "despike" in text]
    assert "kurtosis" in text and "robust Sq" in text
    with warnings.catch_warnings(record=True) as issued:
        warnings.simplefilter("always")
        spiky.surface()
    assert {one.category for one in issued} == {MapWarning} and any("despike" in str(one.message) for one in issued)
    clean = spiky.despiked()
    assert np.array_equal(np.isnan(clean.heights), spiky.heights > 50e-6)
    assert clean.sq == pytest.approx(ROUGH.sq, rel=0.01) and plausibility.doubts(clean) == []
    single = changed(1, 6e-6)
    assert plausibility.doubts(single) and plausibility.doubts(single.despiked()) == []
    assert np.array_equal(ROUGH.despiked().heights, ROUGH.heights)


@pytest.mark.parametrize("value", [-9999.0, 32767.0])
def test_fillers(tmp_path, value):
    """A number for missing pixels is named in the unit of the file, and read as missing where it is given."""
    z = ROUGH.heights * 1e6
    z[10:40, 20:50] = value
    np.save(tmp_path / "map.npy", z)
    with pytest.warns(MapWarning, match=f"900 pixels have exactly the height {value:g}"):
        raw = surface.read(tmp_path / "map.npy", "1um", "um")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        read = surface.read(tmp_path / "map.npy", "1um", "um", missing=value)
    assert np.isnan(read.heights).sum() == 900 and read.sq < 0.6e-6
    assert np.array_equal(np.isnan(raw.despiked().heights), np.isnan(read.heights))


def test_units_of_heights(tmp_path):
    np.save(tmp_path / "map.npy", ROUGH.heights * 1e6)
    with pytest.warns(MapWarning, match="another unit"):
        surface.read(tmp_path / "map.npy", "1um")
    surface.read(tmp_path / "map.npy", "1um", "um")


@pytest.mark.parametrize("columns", [3, 4, 5])
def test_list_of_points_is_no_grid(tmp_path, columns):
    """x, y, z and more in columns or in rows were a map of 4 by 4096 pixels."""
    y, x = np.indices((64, 64)) * 1e-6
    points = np.stack([x.ravel(), y.ravel(), ROUGH.heights[:64, :64].ravel(), np.arange(4096.0), np.ones(4096)][:columns], 1)
    for number, array in enumerate((points, points.T)):
        np.save(tmp_path / f"{number}.npy", array)
        np.savetxt(tmp_path / f"{number}.csv", array, delimiter=",")
        for suffix in ("npy", "csv"):
            with pytest.raises(dl.DemlawsError, match="list of points"):
                surface.read(tmp_path / f"{number}.{suffix}", "1um")


def test_plausible_from_both_sides(tmp_path):
    """A pixel of 0.8 m and one of 1 m by 5 µm, a map of 38 mm under a ball of 8 mm: nothing was said."""
    np.save(tmp_path / "map.npy", ROUGH.heights * 1e6)
    for pixel in ("1,5um", "0.8,0.8", (0.8, 1e-6, 1.0), 0.8, "0.8"):
        with pytest.raises(dl.DemlawsError, match="pixel"):
            surface.read(tmp_path / "map.npy", pixel, "um")
    assert surface.read(tmp_path / "map.npy", ("1um", 2e-6), "um").pixel_y == 2e-6
    with pytest.raises(dl.DemlawsError, match=r"pixel_x = 0\.8 m"):
        HeightMap(ROUGH.heights, 0.8)
    with pytest.warns(MapWarning, match="field of view"):
        surface.read(tmp_path / "map.npy", "0.8mm", "mm")
    with pytest.warns(MapWarning, match="flatter"):
        surface.read(tmp_path / "map.npy", "0.1mm", "nm")
    wide = HeightMap(ROUGH.heights, 0.1e-3)
    assert plausibility.field_doubts(wide, 0.02) == []
    with pytest.warns(MapWarning, match="wider than the effective radius"):
        RoughContact(wide, dl.Contact(8e-3, 30e9, 0.5e-6))


@pytest.mark.parametrize("corner", ["0,", ""])
def test_axes_are_no_heights(tmp_path, corner):
    axis = np.arange(128) * 0.1
    rows = [",".join(f"{v:.6g}" for v in row) for row in ROUGH.heights * 1e6]
    first = ",".join(f"{v:.1f}" for v in axis)
    both = [corner + first, *(f"{y:.1f},{row}" if corner else row for y, row in zip(axis, rows, strict=True))]
    (tmp_path / "map.csv").write_text("\n".join(both))
    with pytest.raises(dl.DemlawsError, match="axis"):
        surface.read(tmp_path / "map.csv", "1um", "um")
    np.save(tmp_path / "column.npy", np.column_stack([axis, ROUGH.heights]))
    with pytest.raises(dl.DemlawsError, match="axis"):
        surface.read(tmp_path / "column.npy", "1um")
    plane = HeightMap(np.add.outer(axis, 2.0 * axis) * 1e-9, 1e-6)
    np.save(tmp_path / "plane.npy", plane.heights)
    surface.read(tmp_path / "plane.npy", "1um")


@pytest.mark.parametrize("shape", [(3, 64, 64), (64,), ()])
def test_a_stack_is_no_map(tmp_path, shape):
    np.save(tmp_path / "map.npy", np.zeros(shape))
    with pytest.raises(dl.DemlawsError, match="not one map"):
        surface.read(tmp_path / "map.npy", "1um")
    assert cli.main(["surface", str(tmp_path / "map.npy"), "--pixel", "1um"]) == 2


def test_interlaced_lines():
    """Every other line is missing."""
    lines = ROUGH.heights.copy()
    lines[1::2] = np.nan
    assert np.isnan(HeightMap(lines, 1e-6).slope)
    assert any("interlaced" in text for text in plausibility.doubts(HeightMap(lines, 1e-6)))


def test_arrays_of_an_npz_file(tmp_path):
    np.savez(tmp_path / "two.npz", z=ROUGH.heights[:40], quality=ROUGH.heights[:40])
    assert np.array_equal(surface.read(tmp_path / "two.npz", "1um", channel="z").heights, ROUGH.heights[:40])
    for channel in (None, "y"):
        with pytest.raises(dl.DemlawsError, match="z, quality"):
            surface.read(tmp_path / "two.npz", "1um", channel=channel)
    back = surface.read(surface.write(tmp_path / "map.npz", HeightMap(ROUGH.heights, 1e-6, 3e-6)))
    assert np.array_equal(back.heights, ROUGH.heights) and (back.pixel_x, back.pixel_y) == (1e-6, 3e-6)
    (tmp_path / "bad.npz").write_bytes(b"PK\3\4 nothing")
    with pytest.raises(dl.DemlawsError):
        surface.read(tmp_path / "bad.npz", "1um")


def test_strip_of_a_map_is_no_list(tmp_path):
    np.save(tmp_path / "strip.npy", ROUGH.heights[:5])
    assert surface.read(tmp_path / "strip.npy", "1um").shape == (5, 128)


def test_fractal_dimensions():
    assert plausibility.dimension_doubts(2.3, 2.35) == [] == plausibility.dimension_doubts(None, None)
    assert len(plausibility.dimension_doubts(2.1, 2.6)) == 1
    assert len(plausibility.dimension_doubts(1.70, 3.67)) == 3
    noise = HeightMap(np.random.default_rng(1).normal(0.0, 1e-7, (128, 128)), 1e-6)
    with pytest.warns(MapWarning, match="not between 2 and 3"):
        assert noise.surface().fractal_dimension == 3.0


def test_pixels_of_a_hertz_radius():
    """a = (3 P R/(4 E*))^(1/3)."""
    pair = dl.Contact(radius=4e-3, modulus=32e9)
    load = 4.0 * 32e9 * (4.5e-6) ** 3 / (3.0 * 4e-3)
    (text,) = plausibility.resolution_doubts(ROUGH, pair, load)
    assert "4.5 pixels" in text and "4.5e-06 m" in text
    assert plausibility.resolution_doubts(ROUGH, pair, load * (10.1 / 4.5) ** 3) == []


def test_command(tmp_path, capsys):
    """Warnings, the robust Sq and --despike; JSON has the doubts."""
    path = str(surface.write(tmp_path / "map.asc", changed(20, 60e-6)))

    def run(*words):
        assert cli.main(["surface", *words, "--json"]) == 0
        out = capsys.readouterr()
        return json.loads(out.out), out.err

    result, messages = run(path)
    assert "--despike" in messages and len(result["doubts"]) >= 1 and result["sq"] > 3.0 * result["robust_sq"]
    result, messages = run(path, "--despike")
    assert messages == "" and result["doubts"] == [] and result["despiked"] == 20
    assert result["sq"] == pytest.approx(ROUGH.without_form(2).sq, rel=0.01)
    z = np.where(np.indices(ROUGH.shape)[0] < 2, -9999.0, ROUGH.heights)
    np.savetxt(tmp_path / "map.csv", z, delimiter=",")
    result, messages = run(str(tmp_path / "map.csv"), "--pixel", "1um", "--missing", "-9999")
    assert result["missing"] == pytest.approx(2 / 128) and messages == ""
    ball = ["--radius", "1mm", "inf", "--young", "430GPa", "75.2GPa", "--poisson", "0.17", "0.34", "--load", "0.001"]
    result, messages = run("contact", str(surface.write(tmp_path / "rough.asc", ROUGH)), *ball)
    assert "pixels wide" in messages and "pixels wide" in result["doubts"][0]


class Channel(types.SimpleNamespace):
    """A channel as SurfaceTopography has it; its heights are constant slopes."""

    dim, nb_grid_pts, unit, physical_sizes = 2, (6, 4), "nm", (6.0, 4.0)

    def topography(self, physical_sizes=None):
        assert (physical_sizes is None) == (self.physical_sizes is not None)
        heights = np.arange(24.0).reshape(6, 4) * self.slope
        return types.SimpleNamespace(heights=lambda: heights, unit=self.unit)


def instrument(tmp_path, monkeypatch, *channels):
    """A file with these channels."""
    reader = types.SimpleNamespace(channels=channels, default_channel=channels[0])
    monkeypatch.setitem(sys.modules, "SurfaceTopography", types.SimpleNamespace(open_topography=lambda path: reader))
    (tmp_path / "map.ibw").write_bytes(b"x")
    return tmp_path / "map.ibw"


def test_an_instrument_without_sizes_or_unit(tmp_path, monkeypatch):
    """Without sizes the map could not be read, in spite of `pixel`; without a unit it was in metres without a word."""
    file = instrument(tmp_path, monkeypatch, Channel(name="z", slope=1e-3, physical_sizes=None))
    with pytest.raises(dl.DemlawsError, match="--pixel"):
        surface.read(file)
    assert surface.read(file, "2nm").pixel_x == pytest.approx(2e-9)
    file = instrument(tmp_path, monkeypatch, Channel(name="z", slope=1e-3, unit=None))
    for unit, metres in (("mm", 1e-3), ("um", 1e-6)):
        with pytest.warns(MapWarning, match="names no unit"):
            assert surface.read(file, unit=unit).pixel_x == pytest.approx(metres)


def test_options_that_contradict_the_file(tmp_path, monkeypatch):
    """A pixel size replaced that of the file, and a unit was ignored, without a word."""
    (tmp_path / "map.txt").write_text("# Width: 8.0 µm\n# Height: 8.0 µm\n# Value units: nm\n" + "1 2 3 4\n" * 4)
    for file, pixel in (
        (tmp_path / "map.txt", "2um"),
        (instrument(tmp_path, monkeypatch, Channel(name="z", slope=1e-3)), "1nm"),
    ):
        assert surface.read(file, pixel, unit="nm").heights == pytest.approx(surface.read(file).heights)
        for contradiction in ({"pixel": "3um"}, {"unit": "um"}):
            with pytest.raises(dl.DemlawsError, match="leave it out"):
                surface.read(file, **contradiction)


def test_channels_by_name(tmp_path, monkeypatch):
    instrument(tmp_path, monkeypatch, Channel(name="Trace", slope=1e-3), Channel(name="Retrace", slope=2e-3))
    with pytest.warns(MapWarning, match="'Trace', 'Retrace'"):
        first = surface.read(tmp_path / "map.ibw")
    second = surface.read(tmp_path / "map.ibw", channel="Retrace")
    assert second.heights == pytest.approx(2.0 * first.heights)
    with pytest.raises(dl.DemlawsError, match="'Retrace'"):
        surface.read(tmp_path / "map.ibw", channel="Phase")
    np.save(tmp_path / "map.npy", ROUGH.heights)
    with pytest.raises(dl.DemlawsError, match="the arrays heights"):
        surface.read(tmp_path / "map.npy", 1e-6, channel="Trace")


def gwyddion(path, channels):
    """A Gwyddion file with channels {name: heights [m]} of pixels of 1 µm."""

    def item(name, kind, data):
        return name.encode() + b"\0" + kind + data

    def thing(name, *items):
        body = b"".join(items)
        return name.encode() + b"\0" + struct.pack("<L", len(body)) + body

    unit = thing("GwySIUnit", item("unitstr", b"s", b"m\0"))
    items = []
    for number, (name, z) in enumerate(channels.items()):
        sides = [item(key, b"i", struct.pack("<i", n)) for key, n in zip(("yres", "xres"), z.shape, strict=True)]
        sides += [item(k, b"d", struct.pack("<d", n * 1e-6)) for k, n in zip(("yreal", "xreal"), z.shape, strict=True)]
        units = [item(key, b"o", unit) for key in ("si_unit_xy", "si_unit_z")]
        values = item("data", b"D", struct.pack("<L", z.size) + z.tobytes())
        items.append(item(f"/{number}/data", b"o", thing("GwyDataField", *sides, *units, values)))
        items.append(item(f"/{number}/data/title", b"s", name.encode() + b"\0"))
    path.write_bytes(b"GWYP" + thing("GwyContainer", *items))
    return path


def test_channels_of_a_gwyddion_file(tmp_path):
    pytest.importorskip("SurfaceTopography")
    path = gwyddion(tmp_path / "map.gwy", {"Height": ROUGH.heights, "Error": 0.1 * ROUGH.heights})
    read = surface.read(path, channel="Error")
    assert read.sq == pytest.approx(0.1 * ROUGH.sq) and read.pixel_x == pytest.approx(1e-6)
    with pytest.warns(MapWarning, match="Height"):
        assert surface.read(path).sq == pytest.approx(ROUGH.sq)
