"""Everything that is written into docs/made before Sphinx reads: laws, rules, commands, errors, pages from other folders."""

import os
import re
import shutil
from pathlib import Path

DOCS = Path(__file__).resolve().parents[1]
ROOT = DOCS.parent
MADE = DOCS / "made"

ELSEWHERE = {
    "yade_scripts/README.md": "made/yade-scripts.md",
    "liggghts_inputs/README.md": "made/liggghts-cases.md",
    "lammps_inputs/README.md": "made/lammps-cases.md",
    "CONTRIBUTING.md": "made/contributing.md",
    "CHANGELOG.md": "made/changelog.md",
    "README.md": "index.md",
}
"""Pages of the repository outside docs/ → where the site shows them."""

SECTIONS = {
    "tutorials": [],
    "theory": ["laws", "plastic-laws", "shear"],
    "how-to": [
        "own-laws",
        "surfaces",
        "scene",
        "made/yade-scripts",
        "liggghts",
        "made/liggghts-cases",
        "lammps",
        "made/lammps-cases",
        "machines",
    ],
    "reference": ["table-format", "made/changelog"],
    "validation": ["trade"],
    "inside": ["made/contributing"],
}
"""Pages that stand outside the folder of their section; any other page of docs/ itself is listed under how-to."""


def members(section):
    """Pages that the index of a section does not name itself: those that stand outside its folder, or are made."""
    known = {page for pages in SECTIONS.values() for page in pages}
    pages = [page for page in SECTIONS[section] if (DOCS / f"{page}.md").exists()]
    if section == "validation":  # what has been measured and kept
        pages = [*sorted(f"validation/{p.stem}" for p in (DOCS / section).glob("*.md") if p.stem != "index"), *pages]
    if section == "how-to":
        pages += sorted(p.stem for p in DOCS.glob("*.md") if p.stem not in known and p.stem not in ("index", "paper"))
    return pages


LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\((?!\w+:)([^)#\s]*)(#[^)\s]*)?\)")


def relinked(text, source, target):
    """Links of `source` (a file of the repository) as they must be on the page `target` of docs/.

    A file that the site shows elsewhere is linked there; one that it does not show is named, without a link.
    """

    def link(match):
        picture, words, path, anchor = match.groups()
        if not path:
            return match.group()
        real = Path(os.path.normpath((ROOT / source).parent / path))
        inside = real.relative_to(ROOT).as_posix() if real.is_relative_to(ROOT) else ""
        if inside in ELSEWHERE or (real / "README.md").relative_to(ROOT).as_posix() in ELSEWHERE if inside else False:
            shown = ELSEWHERE.get(inside) or ELSEWHERE[f"{inside}/README.md"]
        elif inside.startswith("docs/"):
            shown = inside[len("docs/") :]
        elif real.exists():
            return f"{words} (`{inside}`)"
        else:
            raise ValueError(f"{source}: there is no {path}")
        return f"{picture}[{words}]({os.path.relpath(DOCS / shown, (DOCS / target).parent)}{anchor or ''})"

    return LINK.sub(link, text)


def write():
    """Write docs/made anew."""
    from making import reference, theory

    shutil.rmtree(MADE, ignore_errors=True)
    MADE.mkdir()
    for source, target in ELSEWHERE.items():
        if target.startswith("made/"):
            (DOCS / target).write_text(relinked((ROOT / source).read_text(), source, target))
    laws, rules = theory.write(MADE / "theory")
    commands = reference.command_pages(MADE / "commands")
    (MADE / "errors.md").write_text(reference.error_page())
    return {
        "LAWS": [f"made/theory/{n}" for n in laws],
        "RULES": [f"made/theory/{n}" for n in rules],
        "COMMANDS": [f"made/commands/{n}" for n in commands],
    }
