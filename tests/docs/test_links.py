"""Relative links of all Markdown files lead to files of the repository and to their headings; citations to the bibliography."""

import re
import subprocess
from pathlib import Path

import pytest

PROJECT = Path(__file__).resolve().parents[2]
LINK = re.compile(r"\[(?:[^\[\]]|\[[^\]]*\])*\]\((?!\w+:)([^)#\s]*)(?:#([^)\s]*))?\)")
CODE = re.compile(r"^(`{3,}).*?^\1", re.MULTILINE | re.DOTALL)


def kept():
    """Files that git knows, or all of the folder where it is no checkout."""
    listed = subprocess.run(["git", "ls-files"], cwd=PROJECT, capture_output=True, text=True)
    return listed.stdout.split("\n") if listed.returncode == 0 else []


PAGES = [name for name in kept() if name.endswith(".md")]


def headings(text):
    """Anchors as GitHub and MyST make them."""
    found = []
    for line in CODE.sub("", text).splitlines():
        if re.match(r"#{1,6} ", line):
            words = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", line.lstrip("# ")).strip().lower()
            found.append(re.sub(r"[^\w\- ]", "", words).replace(" ", "-"))
    return found


def broken(page, text, known):
    """(link, why) of the links of a page that lead nowhere."""
    out = []
    plain = re.sub(r"`[^`\n]*`", "", CODE.sub("", text))
    for path, anchor in LINK.findall(plain):
        target = (PROJECT / page).parent / path if path else PROJECT / page
        target = Path(target).resolve()
        name = target.relative_to(PROJECT).as_posix() if target.is_relative_to(PROJECT) else None
        if name and name.startswith("docs/made/"):
            continue  # made by the site, which checks them
        if name is None or not (name in known or any(k.startswith(f"{name}/") for k in known)):
            out.append((path, "no such file is kept"))
        elif anchor and target.suffix == ".md" and anchor not in headings(target.read_text()):
            out.append((f"{path}#{anchor}", "no such heading"))
    return out


@pytest.mark.parametrize("page", PAGES)
def test_links_lead_somewhere(page):
    known = set(kept())
    assert broken(page, (PROJECT / page).read_text(), known) == []
