"""Examples of granite have one granite: the numbers of `dl.materials.granite`, on every page, in scripts, cases and helps."""

import math
import re
from pathlib import Path

import pytest

import demlaws as dl
from demlaws.cli import COMMANDS, build_parser

PROJECT = Path(__file__).resolve().parents[2]
GRANITE = dl.materials.granite
SURFACE = GRANITE.surface
PAIR = dl.Contact.between(GRANITE, GRANITE, radius1=8.7e-3, radius2=8.7e-3)
UNITS = {"um": 1e-6, "µm": 1e-6, "GPa": 1e9, "Pa": 1.0, "m": 1.0, "": 1.0}
VALUE = r"([\d.]+(?:e[-+]?\d+)?)(um|µm|GPa|Pa|m)?(?![\w.])"
QUANTITIES = {
    "fractal.dimension": (SURFACE.fractal_dimension,),
    "poisson": (GRANITE.poisson,),
    "hardness": (GRANITE.hardness,),
    "density": (GRANITE.density,),
}
IS_GRANITE = re.compile(r"60\.6e9|60\.6 ?GPa|32\.32e9|32\.32GPa|young=granite")
LISTING = re.compile(r"^(`{3,})\w*\n(.*?)^\1", re.MULTILINE | re.DOTALL)
PAGES = [
    PROJECT / "README.md",
    *(path for path in sorted((PROJECT / "docs").rglob("*.md")) if not {"made", "inside"} & set(path.parts)),
    *(
        path
        for folder in ("yade_scripts", "liggghts_inputs", "lammps_inputs")
        for path in sorted((PROJECT / folder).rglob("README.md"))
    ),
]


SURFACES = re.compile(r"Surface\((?:roughness=)?([\d.]+e-\d+)(?! /)")
"""A surface of a grain, also in the running text."""


def roughness_in(line):
    """σ where a line has a pair (`Contact(`, an effective radius), else Sq of one surface."""
    return (
        PAIR.roughness
        if re.search(r"Contact\(|contact\(|effective-radius|combined|roughness SIGMA", line)
        else SURFACE.roughness
    )


def others(text):
    """(quantity, value) of a listing of granite that are not granite's; a fit starts from a guess, other bodies are named."""
    found = []
    for listing in re.sub(r"\\\n\s*", " ", text).split("\n\n"):
        if not IS_GRANITE.search(listing):
            continue
        for line in listing.splitlines():
            if "demlaws fit " in line or "steel" in line or "against" in line:
                continue
            for quantity, expected in {"roughness": (roughness_in(line),), **QUANTITIES}.items():
                for values in re.findall(rf"{quantity}[12]?[ =]+\"?({VALUE}(?: {VALUE})*)", line):
                    for number, unit in re.findall(VALUE, values[0]):
                        value = float(number) * UNITS[unit or ""]
                        if value and not any(math.isclose(value, one, rel_tol=2e-3) for one in expected):
                            found.append((quantity, f"{number}{unit}"))
    return found


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(PROJECT).as_posix())
def test_listings_of_granite(page):
    given = [float(value) for value in SURFACES.findall(page.read_text())]
    assert given == pytest.approx([SURFACE.roughness] * len(given))
    assert [wrong for _, listing in LISTING.findall(page.read_text()) for wrong in others(listing)] == []


OWN = ("ballast.py", "examples.py", "measured_surface.py", "two_spheres.py")
"""Scripts of other stones, of YADE's examples, of a map, of the published tests."""


@pytest.mark.parametrize(
    "script", sorted({*PROJECT.glob("yade_scripts/*.py"), *PROJECT.glob("docs/gallery/*.py")}), ids=lambda path: path.name
)
def test_scripts_of_granite(script):
    text = re.sub(r".*steel.*", "", script.read_text())
    assert script.name in OWN or others(text) == [] == SURFACES.findall(text)


@pytest.mark.parametrize("command", COMMANDS)
def test_examples_of_help(command):
    assert others(build_parser((command,)).format_help()) == []


def test_another_roughness_is_seen():
    line = "demlaws table --law rms --radius 8mm 8mm --young 60.6GPa --poisson 0.25 --roughness {} --out x.tbl"
    assert others(line.format("1.7um 1.7um")) == [] and others(line.format("2.4um")) == [("roughness", "2.4um")]
    assert others(line.format("1.7um 3.39um")) == [("roughness", "3.39um")]
    assert others("dl.Contact(radius=5e-3, modulus=32.32e9, roughness=2.4e-6, fractal_dimension=2.2)") == [
        ("fractal.dimension", "2.2")
    ]


def test_quickstart_has_the_script_of_readme():
    """Pages show one bounce.py."""
    scripts = [
        listing
        for page in (PROJECT / "README.md", PROJECT / "docs/tutorials/first.md")
        for _, listing in LISTING.findall(page.read_text())
        if "O.run(" in listing
    ]
    assert len(scripts) == 2 and scripts[0] == scripts[1]
