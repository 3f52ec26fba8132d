"""`tools/machines/release.py`: files of a release, from made-up results of `make dist` and `make docs`."""

import hashlib
import re
import runpy
import subprocess
import sys
import types
import zipfile

import pytest
import release

NUMBER = release.version()
RECIPE = "packaging/conda/recipe.yaml"


@pytest.fixture
def project(tmp_path, monkeypatch):
    """A project after `make dist` and `make docs`."""
    root = tmp_path / "project"
    for name, text in {
        f"dist/any/demlaws-{NUMBER}-py3-none-any.whl": "wheel",
        f"dist/demlaws-{NUMBER}-py3-none-manylinux_2_34_x86_64.whl": "wheel",
        f"dist/demlaws-{NUMBER}.tar.gz": "sdist",
        "build/site/index.html": f"<title>demlaws {NUMBER}</title>",
        "build/site/made/commands.html": "commands",
        "docs/made/notebooks/first.ipynb": "{}",
        "docs/made/notebooks/first.sh": "set -e",
        "docs/tutorials/contact.csv": "1,2",
        "CHANGELOG.md": "# Changes\n\n## [Unreleased]\n\n- later\n\n"
        f"## [{NUMBER}] - 2026-11-24\n\n- now\n\n## [0.1.0]\n\n- before\n",
        "CITATION.cff": (release.ROOT / "CITATION.cff").read_text(),
        RECIPE: (release.ROOT / RECIPE).read_text(),
    }.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text)
    monkeypatch.setattr(release, "ROOT", root)
    monkeypatch.setattr(release, "version", lambda: NUMBER)
    return root


def test_all_that_is_uploaded(project, tmp_path, capsys):
    out = tmp_path / "out"
    assert release.main(["--out", str(out)]) == 0
    assert "[Unreleased]" not in capsys.readouterr().out
    notes = (out / "RELEASE_NOTES.md").read_text()
    assert "- now" in notes and "- later" not in notes and "- before" not in notes
    assert re.search(
        rf"^version: {re.escape(NUMBER)}\ndate-released: \d{{4}}-", (out / "CITATION.cff").read_text(), re.MULTILINE
    )
    assert {name.rpartition("/")[2] for name in zipfile.ZipFile(out / f"demlaws-{NUMBER}-notebooks.zip").namelist()} == {
        "first.ipynb",
        "first.sh",
        "contact.csv",
    }
    assert f"demlaws-{NUMBER}-site/made/commands.html" in zipfile.ZipFile(out / f"demlaws-{NUMBER}-site.zip").namelist()
    sums = subprocess.run(["sha256sum", "-c", "SHA256SUMS"], cwd=out, capture_output=True, text=True)
    assert sums.returncode == 0 and sums.stdout.count("OK") == 8


@pytest.mark.parametrize(
    ("spoil", "remedy"),
    [
        (lambda root: (root / f"dist/demlaws-{NUMBER}.tar.gz").unlink(), "make dist"),
        (lambda root: (root / f"dist/any/demlaws-{NUMBER}-py3-none-any.whl").unlink(), "any system: make dist"),
        (lambda root: (root / f"dist/demlaws-{NUMBER}-py3-none-linux_x86_64.whl").write_text(""), "index refuses"),
        (lambda root: (root / "build/site/index.html").write_text("demlaws 0.1.0"), "make docs"),
        (lambda root: (root / "CHANGELOG.md").write_text("# Changes\n"), "CHANGELOG"),
    ],
)
def test_what_is_missing_is_named(project, tmp_path, capsys, spoil, remedy):
    spoil(project)
    assert release.main(["--out", str(tmp_path / "out")]) == 1
    assert remedy in capsys.readouterr().err and not (tmp_path / "out").exists()


def test_a_folder_with_files_is_left_alone(project, tmp_path, capsys):
    (tmp_path / "old.whl").write_text("")
    assert release.main(["--out", str(tmp_path)]) == 1
    assert "not empty" in capsys.readouterr().err


def test_citation_and_recipe_have_the_version_of_the_package():
    assert f"\nversion: {NUMBER}\n" in (release.ROOT / "CITATION.cff").read_text()
    assert f'\n  version: "{NUMBER}"\n' in (release.ROOT / "packaging" / "conda" / "recipe.yaml").read_text()


def test_the_recipe_for_conda_has_the_requirements_of_the_package():
    project = (release.ROOT / "pyproject.toml").read_text()
    needed = re.findall(r'"([^"]+)"', re.search(r"^dependencies = \[(.*)\]$", project, re.MULTILINE)[1])
    recipe = (release.ROOT / "packaging" / "conda" / "recipe.yaml").read_text().partition("  run:")[2].partition("tests:")[0]
    for name, versions in (re.fullmatch(r"(\w+)([^;]*).*", one).groups() for one in needed):
        assert f"    - {name} {versions}\n" in recipe


def test_the_recipe_of_a_release_takes_its_sdist(project, monkeypatch):
    monkeypatch.setattr(release, "addresses", lambda: {"REPOSITORY": "https://example.org/demlaws"})
    sdist = project / f"dist/demlaws-{NUMBER}.tar.gz"
    recipe = release.recipe(NUMBER, sdist)
    url = f"https://example.org/demlaws/releases/download/v{NUMBER}/{sdist.name}"
    assert f"\nsource:\n  url: {url}\n  sha256: {hashlib.sha256(b'sdist').hexdigest()}\n\nbuild:\n" in recipe
    assert "\nabout:\n  homepage: https://example.org/demlaws\n  summary: " in recipe and "path: " not in recipe


@pytest.mark.parametrize("filled", [False, True])
def test_a_citation_has_the_addresses_that_there_are(monkeypatch, filled):
    """An empty `repository-code` makes the file invalid: the format wants an address."""
    address = "https://example.org/demlaws" if filled else ""
    monkeypatch.setattr(release, "addresses", lambda: {"ADDRESS": address, "REPOSITORY": address})
    text = release.citation("9.9.0", "2030-01-02")
    keys = dict(line.split(": ", 1) for line in text.splitlines() if line[0].isalpha() and ": " in line)
    assert (keys["version"], keys["date-released"]) == ("9.9.0", "2030-01-02")
    assert keys.get("repository-code") == keys.get("url") == (f'"{address}"' if filled else None)


def test_addresses_are_filled_in_one_place(tmp_path, monkeypatch, capsys):
    """Python's messages, the C++ header, the metadata and the citation take them from demlaws/errors.py."""
    errors = tmp_path / "errors.py"
    errors.write_text(release.ERRORS.read_text())
    readme = tmp_path / "README.md"
    readme.write_text(release.README.read_text())
    monkeypatch.setattr(release, "ERRORS", errors)
    monkeypatch.setattr(release, "README", readme)
    assert "\n<!-- badges -->\n" in readme.read_text()  # no address yet
    assert release.main(["--fill", "https://example.org/demlaws/", "https://example.org/code"]) == 0
    assert release.addresses() == {"ADDRESS": "https://example.org/demlaws", "REPOSITORY": "https://example.org/code"}
    filled = {}
    exec(compile(errors.read_text(), "errors.py", "exec"), filled)
    assert filled["page"]("how-to/cluster") == "https://example.org/demlaws/how-to/cluster.html"
    assert "(https://example.org/demlaws)" in readme.read_text() and "example.org/code" not in readme.read_text()
    for repository in ("https://github.com/some/fork", "https://github.com/some/code"):  # GitHub has a badge of its tests
        assert release.main(["--fill", "", repository]) == 0
    text = readme.read_text()
    assert text.count("https://github.com/some/code/actions/workflows/tests.yml/badge.svg") == 1 and "some/fork" not in text
    assert text.count("(https://example.org/demlaws)") == 1
    assert release.main(["--fill", "example.org", ""]) == 1 and "https://" in capsys.readouterr().err


@pytest.mark.parametrize("site", ["", "https://example.org/demlaws"])
def test_readme_of_the_metadata_has_no_relative_link(site, monkeypatch):
    """PyPI shows README alone; hatchling, which reads the hook, is not part of the environment of tests."""
    for name in ("hatchling.builders.hooks.plugin.interface", "hatchling.metadata.plugin.interface"):
        module = types.SimpleNamespace(BuildHookInterface=object, MetadataHookInterface=object)
        monkeypatch.setitem(sys.modules, name, module)
    hook = runpy.run_path(str(release.ROOT / "hatch_build.py"))["Addresses"]()
    hook.root = release.ROOT
    links = re.findall(r"\]\((?!https://img.shields.io/)([^)]*)\)", hook.readme(site))  # but badges
    assert links and not [link for link in links if not link.startswith(("#", f"{site}/" if site else "#"))]
    pages = {link.removeprefix(f"{site}/").partition("#")[0] for link in links if link.endswith(".html")}
    assert not [page for page in pages if not (release.ROOT / "docs" / page).with_suffix(".md").exists()]


def test_no_other_file_names_a_page_by_its_file():
    """Messages of Python and C++ use `page`, so that they name the address once there is one."""
    found = []
    for path in sorted((release.ROOT / "demlaws").rglob("*")):
        if path.suffix in (".py", ".h", ".cpp") and path.name not in ("errors.py", "demlaws_facts.h"):
            lines = [re.sub(r"(//|#).*", "", line) for line in path.read_text().splitlines()]
            code = re.sub(r'"""(.*?)"""', "", "\n".join(lines), flags=re.DOTALL)
            found += [path.name] if re.search(r"docs/[\w/-]+\.md", code) else []
    assert found == []


def test_the_changelog_has_a_section_of_this_version():
    _, own = release.notes(NUMBER, (release.ROOT / "CHANGELOG.md").read_text(), "2026-11-24")
    assert own
