"""Pages written to docs/made before Sphinx runs: laws, rules, commands, gallery, pages from other folders."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

DOCS = Path(__file__).resolve().parents[1]
ROOT = DOCS.parent
MADE = DOCS / "made"
TUTORIALS = sorted(path.stem for path in (DOCS / "tutorials").glob("*.md") if path.stem != "index")

ELSEWHERE = {
    "yade_scripts/README.md": "made/yade-scripts.md",
    "liggghts_inputs/README.md": "made/liggghts-cases.md",
    "lammps_inputs/README.md": "made/lammps-cases.md",
    "CHANGELOG.md": "made/changelog.md",
    "README.md": "index.md",
    "CITATION.cff": "made/citation.md",
}
"""Pages of the repository outside docs/ → where the site shows them."""

NOT_SEARCHED = "---\nnosearch: true\n---\n\n"
"""Before pages that a search of the site does not find."""

INTERNAL = ("docs/inside/", "CONTRIBUTING.md")
"""For maintainers: in the repository only."""

LAWS = {
    f"demlaws/laws/{path.stem}.py": f"made/theory/{path.stem.replace('_', '-')}.md"
    for path in (ROOT / "demlaws" / "laws").glob("*.py")
}
"""A link to the file of a law leads to the page that is made of it; in the repository, to the file."""

SECTIONS = {
    "tutorials": ["install", "made/gallery"],
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
        "from-source",
    ],
    "reference": ["symbols", "materials", "bibliography", "table-format", "made/citation", "made/changelog"],
    "validation": ["limits", "trade", "softening", "cost", "made/costs"],
}
"""Pages outside the folder of their section; any other page of docs/ itself is listed under how-to."""


def members(section):
    """Pages that the index of a section does not name: those outside its folder and generated ones."""
    known = {page for pages in SECTIONS.values() for page in pages}
    pages = [page for page in SECTIONS[section] if (DOCS / f"{page}.md").exists()]
    if section == "validation":
        pages = [*sorted(f"validation/{p.stem}" for p in (DOCS / section).glob("*.md") if p.stem != "index"), *pages]
    if section == "how-to":
        pages += sorted(p.stem for p in DOCS.glob("*.md") if p.stem not in known and p.stem not in ("index", "paper"))
    return pages


LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\((?!\w+:)([^)#\s]*)(#[^)\s]*)?\)")


def relinked(text, source, target):
    """Links of `source` (a file of the repository) rewritten for the page `target` of docs/.

    A link to a file that the site has elsewhere leads there; other files are named, without a link.
    """

    def link(match):
        picture, words, path, anchor = match.groups()
        if not path:
            return match.group()
        real = Path(os.path.normpath((ROOT / source).parent / path))
        inside = real.relative_to(ROOT).as_posix() if real.is_relative_to(ROOT) else ""
        if inside in ELSEWHERE or (real / "README.md").relative_to(ROOT).as_posix() in ELSEWHERE if inside else False:
            shown = ELSEWHERE.get(inside) or ELSEWHERE[f"{inside}/README.md"]
        elif inside.startswith("docs/pictures/") and (MADE / "gallery" / real.name).exists():
            shown = f"made/gallery/{real.name}"  # drawn just now
        elif inside in LAWS and (DOCS / LAWS[inside]).exists():
            shown = LAWS[inside]
        elif inside.startswith("docs/") and not inside.startswith(INTERNAL):
            shown = inside[len("docs/") :]
        elif real.exists():
            return f"{words} (`{inside}`)"
        else:
            raise ValueError(f"{source}: {path} does not exist")
        return f"{picture}[{words}]({os.path.relpath(DOCS / shown, (DOCS / target).parent)}{anchor or ''})"

    return LINK.sub(link, text)


def draw_gallery(folder):
    """Run the scripts of docs/gallery in `folder`, where they write their figures; returns the page of the gallery."""
    folder.mkdir(parents=True)
    environment = {**os.environ, "MPLBACKEND": "agg", "PYTHONPATH": str(ROOT)}
    lines = ["# Gallery\n", "Each figure with the script that draws it; the scripts are run when the site is built.\n"]
    for script in sorted((DOCS / "gallery").glob("*.py")):
        subprocess.run(
            [sys.executable, "-W", "ignore", script], cwd=folder, env=environment, check=True, stdout=subprocess.DEVNULL
        )
        text = script.read_text()
        caption, _, code = text.removeprefix('"""').partition('"""\n')
        lines.append(
            f"## {script.stem}\n\n![{caption}](gallery/{script.stem}.png)\n\n{caption}\n\n```python\n{code.strip()}\n```\n"
        )
    return "\n".join(lines)


LISTING = re.compile(r"(?:^<!-- ([^\n]*?) -->\n)?^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def notebook(text):
    """A page as a Jupyter notebook: files are written by %%writefile, commands run by !, Python run as it is."""
    cells, place = [], 0

    def add(kind, source):
        if source.strip():
            extra = {"execution_count": None, "outputs": []} if kind == "code" else {}
            cells.append({"cell_type": kind, "metadata": {}, "source": source.strip("\n"), **extra})

    for match in LISTING.finditer(text):
        mark, kind, listing = match[1] or "", match[2], match[3]
        add("markdown", text[place : match.start()])
        place = match.end()
        if mark.startswith("file: "):
            add("code", f"%%writefile {mark[6:]}\n{listing}")
        elif mark.startswith("run") and kind == "python":
            add("code", listing)
        elif mark.startswith("run"):
            joined = listing.replace("\\\n", " ")
            add("code", "\n".join(f"!{line[2:]}" for line in joined.splitlines() if line.startswith("$ ")))
        else:
            add("markdown", match.group())
    add("markdown", text[place:])
    kernel = {"kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"}}
    return json.dumps({"cells": cells, "metadata": kernel, "nbformat": 4, "nbformat_minor": 4}, ensure_ascii=False, indent=1)


def script(text):
    """The listings of a page that are run, as a shell script."""
    lines = ["set -e"]
    for match in LISTING.finditer(text):
        mark, kind, listing = match[1] or "", match[2], match[3]
        if mark.startswith("file: "):
            lines.append(f"cat > {mark[6:]} <<'END'\n{listing}END")
        elif mark.startswith("run") and kind == "python":
            lines.append(f"python - <<'END'\n{listing}END")
        elif mark.startswith("run"):
            joined = listing.replace("\\\n", " ")
            lines += [line[2:] for line in joined.splitlines() if line.startswith("$ ")]
    return "\n".join(lines) + "\n"


def citation():
    """The page of CITATION.cff: the entry for a bibliography, and where to get the software."""
    import demlaws

    fields = dict(re.findall(r'^([\w-]+): "?(.*?)"?$', (ROOT / "CITATION.cff").read_text(), re.MULTILINE))
    return f"""# Cite and download

{fields["message"]} The references are in the [bibliography](../bibliography.md).

```bibtex
@software{{demlaws,
  title   = {{{{{fields["title"]}}}}},
  author  = {{{{demlaws authors}}}},
  version = {{{demlaws.__version__}}},
  license = {{{fields["license"]}}}
}}
```

A release has the wheel, the sources, this site, the tutorials as notebooks, and SHA256SUMS. [Installation](../install.md) names
the address of the repository.
"""


def write():
    """Write the folder docs/made."""
    from making import reference, theory

    shutil.rmtree(MADE, ignore_errors=True)
    MADE.mkdir()
    (MADE / "gallery.md").write_text(NOT_SEARCHED + draw_gallery(MADE / "gallery"))
    (MADE / "notebooks").mkdir()
    for tutorial in TUTORIALS:
        text = (DOCS / "tutorials" / f"{tutorial}.md").read_text()
        (MADE / "notebooks" / f"{tutorial}.ipynb").write_text(notebook(text))
        (MADE / "notebooks" / f"{tutorial}.sh").write_text(script(text))
    for source, target in ELSEWHERE.items():
        if target.startswith("made/") and source.endswith(".md"):
            unsearched = NOT_SEARCHED if source == "CHANGELOG.md" else ""
            (DOCS / target).write_text(unsearched + relinked((ROOT / source).read_text(), source, target))
    laws, rules = theory.write(MADE / "theory")
    commands = reference.command_pages(MADE / "commands")
    (MADE / "citation.md").write_text(citation())
    (MADE / "costs.md").write_text(theory.cost_page())
    return {
        "SYMBOLS": theory.symbol_table().splitlines(),
        "LAWS": [f"made/theory/{n}" for n in laws],
        "RULES": [f"made/theory/{n}" for n in rules],
        "COMMANDS": [f"made/commands/{n}" for n in commands],
    }
