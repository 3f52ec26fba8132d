"""Table files with one fault each: (bytes, line of the fault), made from the good ones of tests/data/tables.

All but the first few have a checksum that fits, as of a program that writes tables wrongly.
"""

from pathlib import Path

from examples import sealed

GOOD = Path(__file__).parents[1] / "data" / "tables" / "good"
KINKS, GIVEN, BULK = "three-kinks", "three-kinks-table", "rough-plastic-thornton"


def lines_of(name):
    """Lines of a good file without the checksum."""
    return (GOOD / f"{name}.tbl").read_bytes().splitlines()[:-1]


def place(lines, key, second=False):
    """Index of the line of a key, or of the first row of the first or second curve."""
    rows = [n for n, line in enumerate(lines) if n and b": " not in line]
    first = rows[0]
    other = next((n for n in rows if n > first and b": " in lines[n - 1]), None)
    if key == "row":
        return other if second else first
    found = [n for n, line in enumerate(lines) if line.startswith(key.encode() + b": ")]
    return next((n for n in found if second == (n > first)), 1)


def put(name, *texts, second=False):
    """`KEY: TEXT` for the line of this key, or new below the first line."""
    lines = lines_of(name)
    for text in texts:
        n = place(lines, text.partition(": ")[0], second)
        new = n == 1 and not lines[1].startswith(text.partition(": ")[0].encode() + b": ")
        lines[n : n + (not new)] = [text.encode()]
    return sealed(lines), n + 1


def without(name, key, second=False, line=None):
    """No line of this key: the first row names what the lines above lack."""
    lines = lines_of(name)
    del lines[place(lines, key, second)]
    return sealed(lines), line or place(lines, "row", second) + 1


def row(name, number, text, more=0, second=False):
    """This text for a row; None: no such row. more: lines from there to that of the fault."""
    lines = lines_of(name)
    n = place(lines, "row", second) + number
    lines[n : n + 1] = [] if text is None else text.encode().split(b"\n")
    return sealed(lines), n + 1 + more


def _twice(name):
    """Number of a row of a file with as many kinks as there may be, and the text with which it is a kink, too."""
    rows = lines_of(name)[place(lines_of(name), "row") :]
    overlaps = [line.split(b" ")[0] for line in rows]
    last = max(n for n in range(len(rows) - 1) if overlaps.count(overlaps[n]) == 1)
    return last, "\n".join([rows[last].decode()] * 2), 1


def of_hertz(rows, curve_rows=None, **keys):
    """A file of these rows (u, f, k) for Hertz's law of one contact."""
    header = {"law": "x", "radius": "0.004", "modulus": "3e10", "unloading": "elastic", "collapses": "yes", "length": "radius"}
    curve = {"below": "power", "bits": "1", "force_error": "0", "stiffness_error": "0"}
    header |= curve | {"rtol": "0"} | keys
    lines = ["# demlaws-table 4", *(f"{key}: {value}" for key, value in header.items())]
    lines += [" ".join(map(repr, values)) for values in rows]
    if curve_rows is not None:
        second = {key: header[key] for key in ("law", "radius", "modulus", *curve)}
        lines += [
            *(f"{key}: {value}" for key, value in second.items()),
            *(" ".join(map(repr, values)) for values in curve_rows),
        ]
    return [line.encode() for line in lines]


def first_row(lines, more=0):
    """(bytes, line of the first row and so many further)."""
    return sealed(lines), place(lines, "row") + 1 + more


U = 2.0**-10
HERTZ = [(u, 4 / 3 * u**1.5, 2 * u**0.5) for u in (U, 1.5 * U)]
LONG = [(u, 4 / 3 * u**1.5, 2 * u**0.5) for u in (U, 1.5 * U, 2 * U, 3 * U, 4 * U)]
FINE = [(u, 4 / 3 * u**1.5, 2 * u**0.5) for u in (U, U * (1 + 2.0**-12))]
_text = (GOOD / f"{KINKS}.tbl").read_bytes()
_whole = lines_of(KINKS)
_end = len(_whole) + 1
_linear = place(lines_of("luding-linear"), "row")
_kinks, _given = place(_whole, "row") + 1, lines_of(GIVEN)
_yip = of_hertz(HERTZ, length="sigma", sigma="1e-310")

FAULTS = {
    # the file as a whole
    "empty": (b"", 1),
    "other-text": (b"overlap force\n1 2\n", 1),
    "former-version": (_text.replace(b"table 4", b"table 3"), 1),
    "later-version": (_text.replace(b"table 4", b"table 41"), 1),
    "cr-alone": (_text.replace(b"\n", b"\r"), 1),
    "first-line-alone": (b"# demlaws-table 4\n", 1),
    "cut-between-lines": (b"\n".join(_whole[:20]) + b"\n", 20),
    "cut-in-a-line": (_text[:400], _text[:400].count(b"\n") + 1),
    "cut-in-the-checksum": (_text[:-4], _end),
    "changed-row": (_text.replace(b"0.5", b"0.6", 1), _end),
    "checksum-of-another-file": (_text[:-9] + b"00000000\n", _end),
    "checksum-in-capitals": (_text[:-9] + b"ABCDEF00\n", _end),
    "text-after-the-checksum": (_text + b"more\n", _end + 1),
    "blank-line-at-the-end": (_text + b"\n", _end + 1),
    "no-rows": (sealed(_whole[: _kinks - 1]), _kinks),
    "one-row": (sealed(_whole[:_kinks]), _kinks + 1),
    # keys
    "key-unknown": put(KINKS, "colour: red"),
    "key-without-name": put(KINKS, ": 5"),
    "key-twice": (sealed([*_whole[:8], _whole[3], *_whole[8:]]), 9),
    "key-of-another-rule": put(KINKS, "linear_first: 1"),
    "key-without-text": put(KINKS, "law: "),
    "key-without-blank": (sealed([_whole[0], b"description:none", *_whole[1:]]), 2),
    "keys-of-a-third-curve": (sealed([*_given, b"law: x"]), len(_given) + 1),
    "rule-unknown": put(KINKS, "unloading: springs"),
    "rule-empty": put(KINKS, "unloading: "),
    "collapses-maybe": put(KINKS, "collapses: maybe"),
    "length-of-a-number": put(KINKS, "length: 2.4e-06"),
    "below-unknown": put(KINKS, "below: 0"),
    "below-two-words": put(KINKS, "below: power straight"),
    "bits-0": put(KINKS, "bits: 0"),
    "bits-13": put(KINKS, "bits: 13"),
    "bits-fraction": put(KINKS, "bits: 1.0"),
    "error-negative": put(KINKS, "force_error: -1e-9"),
    "error-above-a-tenth": put(KINKS, "stiffness_error: 0.11"),
    "rtol-infinite": put(KINKS, "rtol: inf"),
    "rtol-too-large": put(KINKS, "rtol: 1e400"),
    "radius-hexadecimal": put(KINKS, "radius: 0x1p-8"),
    "radius-negative": put(KINKS, "radius: -0.004"),
    "radius-1e300": put(KINKS, "radius: 1e300"),
    "modulus-in-GPa": put(KINKS, "modulus: 32.3"),
    "sigma-as-large-as-R": put(KINKS, "sigma: 0.003"),
    "sigma-0-of-overlaps-over-sigma": put(KINKS, "sigma: 0"),
    "sigma-1e-310": (sealed(_yip), 2 + [line.split(b":")[0] for line in _yip[1:]].index(b"sigma")),
    "sigma-missing": without("yip-venart-table", "sigma"),
    "fractal-dimension-9": put(KINKS, "fractal_dimension: 9"),
    "hardness-1": put(KINKS, "hardness: 1"),
    "hardness-1e200": put(KINKS, "hardness: 1e200"),
    "yield-slope-alone": without(BULK, "yield_area", line=place(lines_of(BULK), "yield_slope")),
    "yield-area-alone": without(BULK, "yield_slope"),
    "area-unknown": put(KINKS, "area: unknown"),
    "points-x": put(KINKS, "points: x"),
    "points-without-knots": (*put(KINKS, "smoothing: spline", "departure: 0.1", "points: 5")[:1], _kinks + 3),
    "knots-of-two-numbers": put(KINKS, "points: 5", "departure: 0.1", "smoothing: spline", "knots: 1 2"),
    "knots-with-a-word": put(KINKS, "points: 5", "departure: 0.1", "smoothing: spline", "knots: 1 2 x"),
    "limit-without-reason": put("rms-limits", "limit_1: above 5"),
    "limit-of-nothing": put("rms-limits", "limit_1: near 5 because"),
    "limit-negative": put("rms-limits", "limit_1: above -5 because"),
    "limit-2-first": put(KINKS, "limit_2: above 5 because"),
    **{
        f"without-{key}": without(KINKS, key)
        for key in [
            "law",
            "radius",
            "modulus",
            "unloading",
            "collapses",
            "length",
            "below",
            "bits",
            "force_error",
            "stiffness_error",
            "rtol",
        ]
    },
    # laws of demlaws
    "option-unknown": put("rms-limits", "option_a: 1"),
    "option-out-of-range": put("luding-linear", "option_plasticity_depth: 2"),
    "option-word-for-number": put("luding-linear", "option_plasticity_depth: much"),
    "option-missing": without("luding-linear", "option_plasticity_depth"),
    "option-of-no-law-before-yield": put(BULK, "option_slope: 0.1"),
    "quantity-that-the-law-needs": without("pohrt-popov-hertz", "fractal_dimension"),
    "quantity-that-the-law-before-yield-needs": without(BULK, "fractal_dimension"),
    # rules
    "linear-without-growth": without("luding-linear", "linear_growth"),
    "linear-growth-negative": put("luding-linear", "linear_growth: -1"),
    "eepa-stiffness-0": put("eepa-eepa", "eepa_stiffness: 0"),
    "jackson-without-its-overlap": without("jackson-green-jackson", "jackson_overlap"),
    "table-without-curve": (sealed([line.replace(b"unloading: elastic", b"unloading: table") for line in _whole]), _end),
    "curve-of-another-rule": (
        sealed([line.replace(b"unloading: table", b"unloading: hertz") for line in _given]),
        len(_given) + 1,
    ),
    "curve-of-one-row": (sealed([*_given[: place(_given, "row", True) + 1]]), place(_given, "row", True) + 2),
    "curve-with-a-rule": (*put(GIVEN, "law: x\nunloading: hertz", second=True)[:1], place(_given, "law", True) + 2),
    **{
        f"curve-without-{key}": without(GIVEN, key, second=True)
        for key in ["law", "radius", "modulus", "sigma", "bits", "below", "force_error", "stiffness_error"]
        if key != "sigma"
    },
    "curve-without-sigma": without(GIVEN, "sigma", second=True),
    "curve-row-missing": row(GIVEN, 3, None, second=True),
    # rows
    "row-two-numbers": row(KINKS, 4, "0.25 0.16"),
    "row-four-numbers": row(KINKS, 4, "0.25 0.16 1 1"),
    "row-two-blanks": row(KINKS, 4, "0.25  0.16 1"),
    "row-word": row(KINKS, 4, "a quarter 1"),
    "row-nan": row(KINKS, 4, "0.25 nan 1"),
    "row-underscore": row(KINKS, 4, "0.25 0.1_6 1"),
    "row-hexadecimal": row(KINKS, 4, "0x1p-2 0.16 1"),
    "row-comma": row(KINKS, 4, "0,25 0,16 1"),
    "row-empty": row(KINKS, 4, ""),
    "row-too-large": row(KINKS, 4, "0.25 1e61 1"),
    "row-too-small": row(KINKS, 0, "1e-21 1e-30 1"),
    "row-negative-force": row(KINKS, 4, "0.25 -0.16 1"),
    "row-zero-stiffness": row(KINKS, 4, "0.25 0.1666666666666666 0"),
    "row-force-as-before": row(KINKS, 4, "0.25 0.10825317547305482 0.9"),
    "row-missing": row(KINKS, 2, None),
    "row-beside-the-grid": row(KINKS, 1, "0.0626 0.02089 0.5", 0),
    "first-row-twice": (sealed([*_whole[:_kinks], _whole[_kinks - 1], *_whole[_kinks:]]), _kinks + 1),
    "row-that-ends-with-a-kink": (sealed([*_whole, _whole[-1]]), _end),
    "kinks-33": row("most-kinks", *_twice("most-kinks")),
    "bits-finer": (*put(KINKS, "bits: 2")[:1], _kinks + 1),
    "straight-from-below-0": put("pohrt-popov-hertz", "below: straight"),
    # stiffnesses that do not fit
    "steep-first-row": first_row(of_hertz([(U, 1e-5, 1e5), (1.5 * U, 2e-5, 1e-5)])),
    "steep-unloading": (sealed(of_hertz(HERTZ, [(U, 1e-5, 1e5), (1.5 * U, 2e-5, 1e-5)], unloading="table")), 22),
    "steep-unloading-bits-12": (
        sealed(of_hertz(FINE, [(U, 1e-5, 1e5), (FINE[1][0], 2e-5, 1e-5)], unloading="table", bits="12")),
        22,
    ),
    "force-that-leaps-in-a-cell": first_row(of_hertz([(U, 1e-50, 1e-50), (FINE[1][0], 1e50, 1e50)], bits="12"), 1),
    "force-that-falls-in-a-cell": first_row(of_hertz([(U, 1e-5, 0.05), (1.5 * U, 1.1e-5, 0.05)]), 1),
    "flat-row-after-a-steep-one": first_row(of_hertz([HERTZ[0], (1.5 * U, 4.1e-5, 0.25)]), 1),
    # energy
    "work-from-hertz": (*put("kinks-in-one-cell", "unloading: hertz")[:1], 24),
    "work-from-thornton": first_row(of_hertz(LONG, unloading="thornton", yield_area="0.0012", yield_slope="0.001"), 1),
    "work-from-linear": (
        *put("luding-linear", "linear_first: 0.005", "linear_largest: 0.005")[:1],
        place(lines_of("luding-linear"), "row") + 1,
    ),
    "work-from-eepa": (*put("eepa-eepa", "eepa_plastic: 0")[:1], place(lines_of("eepa-eepa"), "row") + 1),
    "work-from-a-softer-curve": (sealed(of_hertz(HERTZ, [(u, 0.5 * f, 0.5 * k) for u, f, k in LONG], unloading="table")), 13),
    "unloading-curve-too-short": (sealed(of_hertz(LONG, HERTZ, unloading="table")), 25),
}
