"""Files of height maps: reading and writing.

heights = read("scan.csv", pixel=0.8e-6, unit="um").without_form(2)
surface = heights.surface()                       # a demlaws.Surface: Sq and fractal dimension, ready for any law
"""

import math
import os
import re
import tokenize
import zipfile
import zlib
from pathlib import Path
from typing import Any

import numpy as np

from demlaws import units
from demlaws.errors import DemlawsError, MapWarning, did_you_mean, warn
from demlaws.files import as_path, read_text, write_atomically
from demlaws.surfaces import plausibility
from demlaws.surfaces.cells import decimal_mark, is_missing, is_number, separator, split, value_of
from demlaws.surfaces.headers import is_zygo, read_gwyddion, read_header_line, zygo_grid
from demlaws.surfaces.heightmap import LARGEST_PIXEL, UNITS, HeightMap, box_correction, self_affine

__all__ = ["UNITS", "HeightMap", "box_correction", "read", "self_affine", "write"]


def read(
    path: str | os.PathLike,
    pixel: Any = None,
    unit: str = "m",
    *,
    missing: float | None = None,
    channel: str | None = None,
) -> HeightMap:
    """Read a height map.

    Parameters
    ----------
    path : str or os.PathLike
        .npy, .npz, or text (.csv, .txt, .tsv, .asc) with columns split by commas, semicolons, tabs or blanks; an empty cell,
        NaN, #N/A, Bad or asterisks are a missing pixel; decimal commas are read where the file decides that they are, numbers
        with thousands separators are refused. Any other suffix is read by SurfaceTopography (pip install "demlaws[surfaces]").
    pixel : float, str or pair, optional
        Pixel size [m], or text with a unit, or a pair for x and y. Headers of ESRI, Gwyddion, Keyence,
        MountainsMap, SPIP, Wyko and Zygo (.xyz) contain it.
    unit : str
        Unit of the heights.
    missing : float, optional
        Number that stands for missing pixels, in the file's unit (-9999).
    channel : str, optional
        Name of the channel in an instrument's file that has several, or of the array in an .npz file; default: its first
        channel with heights, which a warning names, or the array "heights".

    Returns
    -------
    HeightMap
        A `MapWarning` names spikes, fillers, and slopes that no instrument measures.

    Raises
    ------
    DemlawsError
        If the file cannot be read; the message names it and, in text, the line.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> heights = dl.surface.self_affine(64, pixel=1e-6, hurst=0.8, roughness=2e-6, seed=1)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     same = dl.surface.read(dl.surface.write(pathlib.Path(folder, "map.asc"), heights))
    >>> same.shape, round(same.sq * 1e6, 6)
    ((64, 64), 2.0)
    """
    heights, scale = read_unchecked(path, pixel, unit, missing=missing, channel=channel)
    plausibility.warn_of_map(plausibility.doubts(heights, scale))
    return heights


_NO_PIXEL = "{} does not say its pixel size: give pixel (command line: --pixel 0.8um)"


def read_unchecked(path, pixel=None, unit="m", *, missing=None, channel=None):
    """As `read`, without the check of plausibility; the map, and metres per unit of height in the file."""
    path = as_path(path)
    if not os.path.isfile(path):
        raise DemlawsError(f"no such height map: {path!s:.300}")
    if path.stat().st_size == 0:
        raise DemlawsError(f"{path} is empty: was the measurement exported?")
    if not isinstance(unit, str) or unit not in UNITS:
        raise DemlawsError(f"unit = {unit!r}: the units of height are {', '.join(UNITS)}")
    filler = None if missing is None else float(units.as_float(missing, "missing"))
    suffix = path.suffix.lower()
    pixels = None if pixel is None else _pixel_pair(pixel)
    if suffix in (".npy", ".npz"):
        heights, header = _read_numpy(path, channel)
    elif suffix == ".xyz" and is_zygo(path):
        heights, header = zygo_grid(path, unit)
    elif suffix not in (".csv", ".txt", ".tsv", ".asc"):
        heights, header = _read_instrument(path, channel, pixels, unit)
    elif channel is None:
        heights, header = _read_text(path)
    else:
        raise DemlawsError(f"channel = {channel!r}: {path.name} has one channel only")
    plausibility.refuse_other_arrays(heights, path)
    if "dx" in header and "dy" in header:
        header["pixel"] = _cell((header["dx"], header["dy"]), unit, path)
    found = header.get("pixel")
    if pixels and found and not np.allclose(pixels, found, rtol=0.01):
        raise DemlawsError(
            f"{path} has pixels of {found[0] * 1e6:.5g} x {found[1] * 1e6:.5g} µm, pixel = {pixels[0] * 1e6:.5g} x "
            f"{pixels[1] * 1e6:.5g} µm is given: leave it out, or correct the file"
        )
    if unit != "m" and header.get("scale", UNITS[unit]) != UNITS[unit]:
        raise DemlawsError(f"{path} has heights in units of {header['scale']:g} m, unit = {unit!r} is given: leave it out")
    pixels = pixels or header.get("pixel")
    if pixels is None:
        raise DemlawsError(_NO_PIXEL.format(path))
    scale = header.get("scale", UNITS[unit])
    heights = np.asarray(heights, float)
    if filler is not None:
        heights = np.where(heights == filler, np.nan, heights)
    return HeightMap(heights * scale, *pixels), scale


def _pixel_pair(pixel):
    pair = pixel if isinstance(pixel, (tuple, list)) else (pixel, pixel)
    if len(pair) != 2:
        raise DemlawsError(f"pixel = {pixel!r}: give one length, or two for x and y")
    return tuple(units.number(size, "pixel", "m", high=LARGEST_PIXEL) for size in pair)


def _cell(cell, unit, path):
    """Pixel size [m] of an ESRI grid, in m or, where that is no pixel and heights have another unit, in this unit."""
    sizes = [float(units.as_float(size, f"{path}: cellsize")) for size in cell]
    if max(sizes) <= LARGEST_PIXEL:
        return _pixel_pair(tuple(sizes))
    if unit == "m":
        raise DemlawsError(f"{path}: a cellsize of {max(sizes):g} m is no pixel: give the unit of the file (--unit um)")
    warn(f"{path}: the cellsize {max(sizes):g} was taken in {unit}, as the heights", MapWarning)
    return _pixel_pair(tuple(size * UNITS[unit] for size in sizes))


def _read_numpy(path, channel):
    """Heights and header of an .npy or .npz file."""
    try:
        content = np.load(path, allow_pickle=False)
        arrays = {"heights": content} if isinstance(content, np.ndarray) else dict(content)
    except (
        ValueError,
        OSError,
        EOFError,
        MemoryError,
        SyntaxError,
        tokenize.TokenError,
        zipfile.BadZipFile,
        zlib.error,
    ) as error:
        raise DemlawsError(f"{path} is not a numpy array file: {error}") from None
    name = channel or "heights"
    if name not in arrays:
        raise DemlawsError(f"{path} has the arrays {', '.join(arrays)}: give the one of heights as channel (--channel)")
    if arrays[name].dtype.kind not in "fiu":
        raise DemlawsError(f"{path} holds {arrays[name].dtype} values: heights must be real numbers")
    pixel = arrays.get("pixel")  # of `write`
    return arrays[name], {} if pixel is None else {"pixel": tuple(np.ravel(pixel).tolist()), "scale": 1.0}


def _read_text(path):
    lines = read_text(path).splitlines()
    header, rows, first, words = {}, [], 0, 0
    for number, line in enumerate(lines, 1):
        text = line.strip()
        if not rows and read_header_line(text, header):
            continue
        if text.startswith("#") and not is_missing(split(text, separator(text))[0]):  # "#N/A" of a spreadsheet
            read_gwyddion(text, header, f"{path}, line {number}")
            continue
        if not text:
            continue
        cells = split(text, separator(text))
        if not rows and lines[number:] and not all(is_missing(cell) or is_number(cell) for cell in cells):
            words = number
            continue
        if words:
            raise DemlawsError(
                f"{path}: delete lines 1 to {number - 1}, a header that is not read (to {lines[words - 1].strip()[:40]!r}), "
                "and give pixel and unit as it states them"
            )
        if rows and len(rows[0]) != len(cells):
            raise DemlawsError(f"{path}, line {number}: {len(cells)} columns, but line {first} has {len(rows[0])}")
        first = first or number
        rows.append(cells)
    if not rows:
        raise DemlawsError(f"{path} holds no heights")
    if len(rows[0]) > 1 and all(cells[-1].strip() == "" for cells in rows):
        rows = [cells[:-1] for cells in rows]  # every line ends in a separator
    mark = decimal_mark([cell for cells in rows for cell in cells], path)
    try:
        heights = np.array([[value_of(cell, mark) for cell in cells] for cells in rows])
    except ValueError as error:
        raise DemlawsError(f"{path}: a height is not a number: {error}") from None
    for name, count in zip(("columns", "rows"), heights.shape[::-1], strict=True):
        stated = header.get(name)
        if stated is not None and units.as_float(stated, f"{path}: {name}") != count:
            raise DemlawsError(
                f"{path}: its header states {stated} {name}, but there are {count}, one row per line: is it truncated?"
            )
    if "nodata_value" in header:
        heights[heights == float(units.as_float(header["nodata_value"], f"{path}: NODATA_value"))] = np.nan
    if "width" in header and "height" in header:
        header["pixel"] = header["width"] / heights.shape[1], header["height"] / heights.shape[0]
    return heights, header


def _read_instrument(path, channel, pixels, unit):
    """Heights and header (pixel sizes [m], metres per unit of height) of a file that SurfaceTopography reads.

    pixels and unit are those of files that contain none.
    """
    try:
        import SurfaceTopography
    except ImportError:
        raise DemlawsError(
            f"{path}: reading {path.suffix or 'such'} files needs SurfaceTopography: pip install 'demlaws[surfaces]', "
            "or export the map as .csv, .asc or .npy"
        ) from None
    try:
        reader = SurfaceTopography.open_topography(str(path))
        chosen = _channel(reader, path, channel)
        sizes = chosen.physical_sizes
        if chosen.dim != 2:
            raise DemlawsError(f"{path} is a line scan: a height map has two dimensions")
        if sizes is None and pixels is None:
            raise DemlawsError(_NO_PIXEL.format(path))
        topography = chosen.topography(**({"physical_sizes": chosen.nb_grid_pts} if sizes is None else {}))
        heights = np.ma.filled(np.ma.asarray(topography.heights(), float), np.nan)
    except DemlawsError:
        raise
    except Exception as error:  # every reader of theirs has its own errors
        raise DemlawsError(f"SurfaceTopography cannot read {path}: {_reason(error, path)}") from None
    if topography.unit is None:
        warn(f"{path} names no unit of length: heights and sizes are taken in {unit!r} (--unit)", MapWarning)
    unit = topography.unit or unit
    if unit not in UNITS:
        raise DemlawsError(f"{path}: unit {unit!r} is not a length demlaws knows ({', '.join(UNITS)})")
    # their first axis is x
    heights = heights.T
    header = {"scale": UNITS[unit]}
    if sizes is not None:
        header["pixel"] = tuple(size * UNITS[unit] / n for size, n in zip(sizes, heights.shape[::-1], strict=True))
    return heights, header


def _reason(error, path):
    """Why SurfaceTopography refuses a file, in one line: of all its readers that tried, the word of that of the suffix."""
    tried = {name.lower(): text for name, text in re.findall(r"tried (\w+)Reader:\s*\n\s*(.+)", str(error))}
    if tried:
        return tried.get(path.suffix[1:].lower(), f"none of its {len(tried)} readers takes the file")[:120]
    return (str(error).strip().splitlines() or [type(error).__name__])[0][:120]


def _channel(reader, path, name):
    """The channel of this name; without a name the reader's default, with a warning if there are others."""
    names = [channel.name for channel in reader.channels]
    if name is None:
        if len(names) > 1:
            others = ", ".join(repr(other) for other in names)
            warn(
                f"{path} has the channels {others}: {reader.default_channel.name!r} was read; name one (--channel)", MapWarning
            )
        return reader.default_channel
    if name not in names:
        raise DemlawsError(f"{path} has no channel {name!r}, but {', '.join(map(repr, names))}{did_you_mean(name, names)}")
    return reader.channels[names.index(name)]


def write(path: str | os.PathLike, heights: HeightMap) -> Path:
    """Write a map, heights in m.

    Parameters
    ----------
    path : str or os.PathLike
        File with the suffix .npy, .csv, .npz (arrays "heights" and "pixel") or .asc (an ESRI grid); the last two contain the
        pixel size.
    heights : HeightMap
        The map.

    Returns
    -------
    pathlib.Path
        The file.
    """
    import io

    path = as_path(path)
    if not isinstance(heights, HeightMap):
        raise DemlawsError(f"heights must be a HeightMap, got {heights!r:.60}")
    suffix = path.suffix.lower()
    if suffix in (".npy", ".npz"):
        buffer, z = io.BytesIO(), heights.heights
        np.save(buffer, z) if suffix == ".npy" else np.savez(buffer, heights=z, pixel=(heights.pixel_x, heights.pixel_y))
        return write_atomically(path, buffer.getvalue())
    if suffix not in (".csv", ".asc"):
        raise DemlawsError(f"cannot write {path}: the suffixes are .npy, .npz, .csv and .asc")
    text = io.StringIO()
    values = heights.heights
    if suffix == ".asc":
        rows, columns = heights.shape
        text.write(f"ncols {columns}\nnrows {rows}\nxllcorner 0\nyllcorner 0\n")
        square = math.isclose(heights.pixel_x, heights.pixel_y, rel_tol=1e-12)
        # GDAL's keywords where pixels are not square
        text.write(f"cellsize {heights.pixel_x!r}\n" if square else f"dx {heights.pixel_x!r}\ndy {heights.pixel_y!r}\n")
        text.write("NODATA_value -9999\n")
        values = np.where(np.isnan(values), -9999.0, values)
    np.savetxt(text, values, fmt="%.9g", delimiter="," if suffix == ".csv" else " ")
    return write_atomically(path, text.getvalue())
