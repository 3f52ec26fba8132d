#!/usr/bin/env python3
"""What a maintainer with accounts uploads, in an empty folder: `make release`, after `make dist` and `make docs`.

    python tools/machines/release.py --out release    # from dist/ and build/site

Wheel, sdist, site, tutorials as notebooks and scripts, release notes, CITATION.cff with version and date, conda's recipe
(recipe.yaml) with the sdist as source, SHA256SUMS. The version is that of demlaws/__init__.py; the notes are its section of
CHANGELOG.md, or, with a warning, [Unreleased]. Nothing is uploaded. Standard library only.
"""

import argparse
import datetime
import hashlib
import re
import shutil
import sys
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
ERRORS, README = ROOT / "demlaws" / "errors.py", ROOT / "README.md"


class ReleaseError(Exception):
    """What is missing, and the command that makes it."""


def version():
    """The version, from its one place."""
    return re.search(r'^__version__ = "(.+)"$', (ROOT / "demlaws" / "__init__.py").read_text(), re.MULTILINE)[1]


def addresses():
    """{name: address of site or repository}, from their one place; empty before `--fill`."""
    return dict(re.findall(r'^(ADDRESS|REPOSITORY) = "(.*)"$', ERRORS.read_text(), re.MULTILINE))


def fill(site, repository):
    """Write the addresses into their one place, empty ones stay as they are; README then shows badges with them."""
    text = ERRORS.read_text()
    for name, value in {"ADDRESS": site.rstrip("/"), "REPOSITORY": repository.rstrip("/")}.items():
        if value and not re.fullmatch(r"https://[\w./~-]+", value):
            raise ReleaseError(f"{name} = {value!r}: an address that begins with https://")
        if value:
            text = re.sub(rf'^{name} = ".*"$', f'{name} = "{value}"', text, flags=re.MULTILINE)
    ERRORS.write_text(text)
    known = addresses()
    badges = "".join(
        f" [![{name}]({picture})]({page})"
        for name, picture, page in (
            ("tests", f"{known['REPOSITORY']}/actions/workflows/tests.yml/badge.svg", f"{known['REPOSITORY']}/actions"),
            ("documentation", "https://img.shields.io/badge/documentation-site-blue", known["ADDRESS"]),
        )
        if page.startswith("https://github.com/" if name == "tests" else "https://")
    )
    README.write_text(re.sub("(?<=<!-- badges -->).*", badges, README.read_text()))


def notes(number, changelog, today):
    """(release notes, whether CHANGELOG has a section for this version)."""
    sections = dict(re.findall(r"^## \[([^\]]+)\][^\n]*\n(.*?)(?=^## \[|\Z)", changelog, re.MULTILINE | re.DOTALL))
    text = sections.get(number) or sections.get("Unreleased", "")
    if not text.strip():
        raise ReleaseError(f"CHANGELOG.md has neither a section [{number}] nor lines under [Unreleased]")
    return f"# demlaws {number}, {today}\n\n{text.strip()}\n", number in sections


def citation(number, today):
    """CITATION.cff of a release: with version, date, and the addresses that there are."""
    text = (ROOT / "CITATION.cff").read_text()
    for key, value in {"version": number, "date-released": today}.items():
        text = re.sub(rf"^{key}:.*", f"{key}: {value}", text, flags=re.MULTILINE)
    keys = {"repository-code": addresses()["REPOSITORY"], "url": addresses()["ADDRESS"]}
    return text + "".join(f'{key}: "{value}"\n' for key, value in keys.items() if value)


def recipe(number, sdist):
    """Recipe for conda-forge of a release: its source is `sdist`, as attached to the page of the release in the repository."""
    repository, digest = addresses()["REPOSITORY"] or "REPOSITORY", hashlib.sha256(sdist.read_bytes()).hexdigest()
    source = f"url: {repository}/releases/download/v{number}/{sdist.name}\n  sha256: {digest}"
    text = (ROOT / "packaging" / "conda" / "recipe.yaml").read_text()
    return text.replace("path: ../..", source).replace("about:\n", f"about:\n  homepage: {repository}\n")


def archive(path, files):
    """A zip file of files, {name: path}, in a folder of the archive's name."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as target:
        for name, file in sorted(files.items()):
            target.write(file, f"{path.stem}/{name}")


def assemble(out, number, today):
    """Write everything into `out`; returns the paths and warnings."""
    built = [*(ROOT / "dist").rglob(f"demlaws-{number}-*.whl"), ROOT / "dist" / f"demlaws-{number}.tar.gz"]
    if not all(path.is_file() for path in built) or f"demlaws-{number}-py3-none-any.whl" not in {path.name for path in built}:
        raise ReleaseError(f"dist/ lacks demlaws-{number}.tar.gz or the wheel for any system: make dist")
    if refused := [path.name for path in built if "-linux_" in path.name]:
        raise ReleaseError(f"dist/{refused[0]} has a tag that an index refuses: make dist")
    site, notebooks = ROOT / "build" / "site", ROOT / "docs" / "made" / "notebooks"
    index = site / "index.html"
    if not index.is_file() or f"demlaws {number}" not in index.read_text():
        raise ReleaseError(f"build/site is missing or of another version than {number}: make docs")
    text, own = notes(number, (ROOT / "CHANGELOG.md").read_text(), today)
    warnings = [] if own else [f"CHANGELOG.md has no section [{number}]: the notes are those of [Unreleased]"]
    if not all(addresses().values()):
        warnings.append("no address: messages name files; make release ADDRESS=https://… REPOSITORY=https://…")
    if out.exists() and any(out.iterdir()):
        raise ReleaseError(f"{out} is not empty")
    out.mkdir(parents=True, exist_ok=True)
    for path in built:
        shutil.copy(path, out)
    archive(out / f"demlaws-{number}-site.zip", {p.relative_to(site).as_posix(): p for p in site.rglob("*") if p.is_file()})
    tutorials = [*notebooks.glob("*.ipynb"), *notebooks.glob("*.sh"), *(ROOT / "docs" / "tutorials").glob("*.csv")]
    archive(out / f"demlaws-{number}-notebooks.zip", {path.name: path for path in tutorials})
    (out / "RELEASE_NOTES.md").write_text(text)
    (out / "CITATION.cff").write_text(citation(number, today))
    (out / "recipe.yaml").write_text(recipe(number, ROOT / "dist" / f"demlaws-{number}.tar.gz"))
    paths = sorted(path for path in out.iterdir() if path.is_file())
    sums = "".join(f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.name}\n" for path in paths)
    (out / "SHA256SUMS").write_text(sums)
    return [*paths, out / "SHA256SUMS"], warnings


def main(arguments=None):
    """Assemble the release; exit status 1 if something is missing."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=ROOT / "build" / "release", help="empty folder (default: build/release)")
    parser.add_argument(
        "--fill", nargs=2, metavar=("ADDRESS", "REPOSITORY"), help="only write these addresses of site and repository"
    )
    arguments, number = parser.parse_args(arguments), version()
    out = arguments.out
    try:
        if arguments.fill:
            fill(*arguments.fill)
            return 0
        paths, warnings = assemble(out, number, datetime.date.today().isoformat())
    except ReleaseError as error:
        print(f"release: {error}", file=sys.stderr)
        return 1
    for path in paths:
        print(f"{path.stat().st_size / 1024:9.1f} kB  {path}")
    for line in warnings:
        print(f"release: {line}")
    print(
        f"\ncheck:   cd {out} && sha256sum -c SHA256SUMS\n"
        f"upload:  twine upload {out}/demlaws-{number}*.whl {out}/demlaws-{number}.tar.gz\n"
        f"         git tag v{number} && git push {addresses()['REPOSITORY'] or 'REPOSITORY'} v{number}\n"
        "         attach the other files to the page of the release"
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
