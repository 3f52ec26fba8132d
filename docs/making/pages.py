"""Pages written to docs/made before Sphinx runs: laws, commands, pictures, pages from other folders."""

import json
import os
import re
import shutil
import subprocess
import sys

from making.links import DOCS, ELSEWHERE, MADE, ROOT, relinked

TUTORIALS = sorted(path.stem for path in (DOCS / "tutorials").glob("*.md"))


def draw_gallery(folder):
    """Run the scripts of docs/gallery in `folder`, where they write their figures."""
    folder.mkdir(parents=True)
    environment = {**os.environ, "MPLBACKEND": "agg", "PYTHONPATH": str(ROOT)}
    for script in sorted((DOCS / "gallery").glob("*.py")):
        subprocess.run(
            [sys.executable, "-W", "ignore", script], cwd=folder, env=environment, check=True, stdout=subprocess.DEVNULL
        )


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
    """The entry of CITATION.cff for a bibliography."""
    import demlaws
    from demlaws.errors import ADDRESS, REPOSITORY

    fields = dict(re.findall(r'^([\w-]+): "?(.*?)"?$', (ROOT / "CITATION.cff").read_text(), re.MULTILINE))
    where = f",\n  url     = {{{REPOSITORY or ADDRESS}}}" if REPOSITORY or ADDRESS else ""
    return f"""```bibtex
@software{{demlaws,
  title   = {{{{{fields["title"]}}}}},
  author  = {{{{demlaws authors}}}},
  year    = {{{fields["date-released"][:4]}}},
  version = {{{demlaws.__version__}}},
  license = {{{fields["license"]}}}{where}
}}
```"""


def beneath(text):
    """A page as a part of another: its headings one level lower."""
    parts = re.split(r"(^```.*?^```$)", text, flags=re.MULTILINE | re.DOTALL)
    return "".join(re.sub(r"^#", "##", part, flags=re.MULTILINE) if n % 2 == 0 else part for n, part in enumerate(parts))


def moved(source):
    """A page of the repository with the links that it has on the site."""
    return relinked((ROOT / source).read_text(), source, ELSEWHERE[source])


def measured(name):
    """A measured page as a section of the page of validations."""
    return beneath((DOCS / "validation" / f"{name}.md").read_text())


def write():
    """Write the folder docs/made; returns {KEY: text that replaces {{KEY}} in pages}."""
    from demlaws import errors
    from making import reference, theory

    shutil.rmtree(MADE, ignore_errors=True)
    MADE.mkdir()
    draw_gallery(MADE / "gallery")
    (MADE / "notebooks").mkdir()
    for tutorial in TUTORIALS:
        text = (DOCS / "tutorials" / f"{tutorial}.md").read_text()
        (MADE / "notebooks" / f"{tutorial}.ipynb").write_text(notebook(text))
        (MADE / "notebooks" / f"{tutorial}.sh").write_text(script(text))
    (MADE / "yade.md").write_text(moved("yade_scripts/README.md"))
    (MADE / "commands.md").write_text(reference.command_page())
    return {
        "LAWS": "\n".join(f"made/theory/{name}" for names in theory.write(MADE / "theory").values() for name in names),
        "REPORT": measured("report"),
        "CLAIMS": measured("claims"),
        "RULES": theory.rule_sections(),
        "CITATION": citation(),
        "REPOSITORY": errors.REPOSITORY or "REPOSITORY",
    }
