"""Headers of text files: pixel size and unit of ESRI grids, Keyence, MountainsMap, Wyko, Gwyddion and Zygo files."""

import re

import numpy as np

from demlaws import units
from demlaws.errors import DemlawsError, MapWarning, warn
from demlaws.files import read_text
from demlaws.surfaces.cells import is_missing, is_number, split
from demlaws.surfaces.heightmap import UNITS

_KEYENCE = ("measured date", "model", "xy calibration", "unit", "output image data")
_WYKO = {"pixel_size": 1e-3, "aspect": 1.0, "wavelength": 1e-9, "mult": 1.0}
"""Entries of a Wyko header in SI: mm and nm."""


def _value(text, name):
    """Number above zero of an entry."""
    return units.number(float(units.as_float(text, name)), name)


def read_header_line(text, header):
    """Whether a line is of an instrument's header; pixel size [m] and metres per unit of height go to `header`."""
    match = re.match(r"Wyko ASCII Data File Format\s+\d+\s+(\d)", text)
    if match:
        header["real units"] = match[1] != "0"
    if "real units" in header:
        return _wyko(text, header)
    return _keyence(text, header) or _mountains(text, header) or _esri(text, header)


_ESRI = {"ncols": ("columns",), "nrows": ("rows",), "cellsize": ("dx", "dy")}


def _esri(text, header):
    """ESRI's grid, GDAL's with pixels that are not square: `dx` and `dy` in the unit of the file."""
    match = re.fullmatch(
        r"(ncols|nrows|xllcorner|yllcorner|xllcenter|yllcenter|cellsize|dx|dy|nodata_value)\s+(\S+)", text.lower()
    )
    if match:
        header.update(dict.fromkeys(_ESRI.get(match[1], match.groups()[:1]), match[2]))
    return match is not None


def _wyko(text, header):
    """Wyko: pixel size in mm; heights in nm, or in wavelengths, which the header says."""
    cells = re.split(r"\t+|\s{2,}", text)
    if not cells[0] or is_missing(cells[0]) or is_number(cells[0]):
        return False
    key = cells[0].lower()
    if key in ("x size", "y size"):  # a line of the file is one place along x
        header["rows" if key[0] == "x" else "columns"] = cells[-1]
    if key in _WYKO:
        header[key] = _WYKO[key] * _value(cells[-1], cells[0])
    if "pixel_size" in header:
        header["pixel"] = header["pixel_size"] * header.get("aspect", 1.0), header["pixel_size"]
    if header["real units"]:
        header["scale"] = 1e-9
    elif "wavelength" in header:
        header["scale"] = header["wavelength"] / header.get("mult", 1.0)
    return True


def _keyence(text, header):
    """Keyence: quoted names with values, up to the heights."""
    cells = [cell.strip().strip('"') for cell in split(text, ",")]
    key = cells[0].lower()
    if key in _KEYENCE:
        header["keyence"] = True
    if not header.get("keyence"):
        return False
    if text and not is_number(cells[0]) and not is_missing(cells[0]):
        unit = cells[-1].split("/")[0]  # nm/pixel
        if key == "xy calibration" and unit in UNITS:
            header["pixel"] = (_value(cells[1], "XY Calibration") * UNITS[unit],) * 2
        elif key == "unit" and cells[-1] in UNITS:
            header["scale"] = UNITS[cells[-1]]
        elif key in ("horizontal", "vertical"):
            header["columns" if key == "horizontal" else "rows"] = cells[-1]
        return True
    return not any(cells)


def _mountains(text, header):
    """MountainsMap and SPIP: `# x-length = 64000`."""
    match = re.fullmatch(r"#\s?([xyz])-(pixels|length|unit) = (\S+)", text)
    if not match:
        return text.startswith("# ") and text.rstrip(":").endswith((" = ASCII", "Created", "Header", "Data", "scanspeed ="))
    header[match[1] + match[2]] = match[3]
    if match[2] == "pixels":
        header["columns" if match[1] == "x" else "rows"] = match[3]
    stated = {axis: header.get(f"{axis}unit") in UNITS for axis in "xyz"}
    if stated["z"]:
        header["scale"] = UNITS[header["zunit"]]
    if stated["x"] and stated["y"] and all(f"{axis}{name}" in header for axis in "xy" for name in ("pixels", "length")):
        header["pixel"] = tuple(
            _value(header[f"{axis}length"], f"{axis}-length")
            * UNITS[header[f"{axis}unit"]]
            / _value(header[f"{axis}pixels"], f"{axis}-pixels")
            for axis in "xy"
        )
    return True


_GWYDDION = {
    "width": "width|šířka|breite|anchura|largeur|larghezza|幅|폭|largura|ширина",
    "height": "height|výška|höhe|altura|hauteur|altezza|高さ|높이|высота",
    "scale": "value units?|jednotky hodnot|einheiten|unités|unità valore|値の単位|값 단위|unidades de valor|единицы измерения",
}
"""Labels in the languages of Gwyddion's windows, in which it writes them."""


def read_gwyddion(text, header, where):
    """Width, height and unit of a Gwyddion comment."""
    for name in ("width", "height"):
        match = re.match(rf"#\s*({_GWYDDION[name]})\s*[:：]\s*([-+0-9.,eE]+)\s*([a-zµμ]+)", text, re.IGNORECASE)
        if match and match[3] in UNITS:
            header[name] = _value(match[2].replace(",", "."), f"{where}: {match[1]}") * UNITS[match[3]]
    match = re.match(rf"#\s*(?:{_GWYDDION['scale']})\s*[:：]\s*(\S+)", text, re.IGNORECASE)
    if match and match[1] not in UNITS:
        raise DemlawsError(f"{where}: heights in {match[1]!r}; export them in one of {', '.join(UNITS)}")
    if match:
        header["scale"] = UNITS[match[1]]


def is_zygo(path):
    """Whether a .xyz file is one of Zygo's."""
    with open(path, "rb") as file:
        return file.readline(100).startswith(b"Zygo XYZ")


def zygo_grid(path, unit):
    """Heights and header of a Zygo XYZ file: line 4 has the grid, line 8 the pixel size [m]; heights are in µm or in `unit`."""
    lines = read_text(path).splitlines()
    try:
        if lines[-1].strip() != "#":
            raise ValueError("the last line is not #")
        left, top, columns, rows = (int(cell) for cell in lines[3].split()[:4])
        pixel = float(lines[7].split()[6])
        grid = np.full((rows, columns), np.nan)
        for number, line in enumerate(lines[lines.index("#") + 1 :], lines.index("#") + 2):
            if line.strip() in ("", "#"):
                continue
            x, y, z = line.split(None, 2)
            grid[_inside(int(y) - top, rows, number), _inside(int(x) - left, columns, number)] = (
                np.nan if z.strip() == "No Data" else float(z)
            )
    except (ValueError, IndexError) as error:
        raise DemlawsError(f"{path} is not a whole Zygo XYZ file: {error}; export the map as .csv") from None
    if unit == "m":
        unit = "um"
        warn(
            f"{path} names no unit of height: heights are taken in µm, as Zygo's format states; else give unit (--unit)",
            MapWarning,
        )
    return grid, {"pixel": (pixel, pixel), "scale": UNITS[unit]}


def _inside(place, count, number):
    """A place in the grid; ValueError with the line if it is beyond."""
    if not 0 <= place < count:
        raise ValueError(f"line {number} is outside of the grid")
    return place
