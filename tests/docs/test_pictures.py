"""Pictures of docs/pictures are those that their scripts draw; on the site they are drawn again."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

matplotlib = pytest.importorskip("matplotlib")
from pictures import difference  # noqa: E402

DOCS = Path(__file__).resolve().parents[2] / "docs"
sys.path.insert(0, str(DOCS))
from making import sources  # noqa: E402

DRAWN_WITH = "3.6."
"""The matplotlib that drew the pictures kept in git, Debian 12's; others leave other margins."""
DRAWN = [name for name in sources.DRAWN if (DOCS / "pictures" / f"{name}.png").exists()]


@pytest.mark.slow
@pytest.mark.parametrize("name", DRAWN)
def test_picture_is_what_its_script_draws(name, tmp_path):
    environment = {**os.environ, "MPLBACKEND": "agg", "PYTHONPATH": str(DOCS.parent)}
    subprocess.run(
        [sys.executable, "-W", "ignore", DOCS / "gallery" / f"{name}.py"],
        cwd=tmp_path,
        env=environment,
        check=True,
        stdout=subprocess.DEVNULL,
    )
    if not matplotlib.__version__.startswith(DRAWN_WITH):
        assert not os.environ.get("CI"), f"CI compares pictures: draw them again with its matplotlib {matplotlib.__version__}"
        pytest.skip(f"drawn by matplotlib {matplotlib.__version__}; the picture in git by {DRAWN_WITH}x")
    changed = difference(tmp_path / f"{name}.png", DOCS / "pictures" / f"{name}.png")
    assert changed < 0.005, f"docs/pictures/{name}.png differs in {changed:.1%}: copy what docs/gallery/{name}.py draws"


@pytest.mark.slow
@pytest.mark.parametrize("name", sources.STORED)
def test_picture_or_table_is_that_of_the_stored_rows(name, tmp_path):
    again = tmp_path / Path(name).name
    sources.make(name, again)
    remedy = f"python docs/making/sources.py --write {name}"
    if again.suffix == ".csv":
        assert again.read_text() == (DOCS / name).read_text(), remedy
    else:
        assert difference(again, DOCS / name) < 0.005, remedy


def test_every_picture_and_table_names_its_source():
    """Pictures of docs and tables of docs/tables are in one list of making/sources.py, and all that is listed exists."""
    pages = {f"pictures/{name}.png" for name in (*DRAWN, *sources.FOLLOWED)}
    listed = [*pages, *sources.STORED, *sources.MEASURED, *sources.VIEWS]
    found = {path.relative_to(DOCS).as_posix() for path in (*DOCS.rglob("*.png"), *(DOCS / "tables").glob("*"))}
    assert sorted(listed) == sorted(name for name in found if not name.startswith("made/"))


def test_every_picture_and_table_is_on_a_page():
    pages = [*DOCS.rglob("*.md"), *(DOCS.parent / folder / "README.md" for folder in ("yade_scripts", "liggghts_inputs"))]
    text = "".join(page.read_text() for page in pages if "made" not in page.parts)
    gallery = "".join(path.read_text() for path in (DOCS / "gallery").glob("*.py"))
    for name in (*sources.STORED, *sources.MEASURED, *sources.VIEWS):
        assert Path(name).name in text + gallery, f"docs/{name} is on no page"


def test_a_moved_curve_is_seen(tmp_path):
    import matplotlib.pyplot as plt

    for name, values in (("a", [0, 1, 4, 9]), ("b", [0, 1, 4, 6])):
        fig, ax = plt.subplots()
        ax.plot(values)
        ax.set_ylim(0, 10)
        fig.savefig(tmp_path / f"{name}.png")
        plt.close(fig)
    assert difference(tmp_path / "a.png", tmp_path / "b.png") > 0.005
    shutil.copy(tmp_path / "a.png", tmp_path / "c.png")
    assert difference(tmp_path / "a.png", tmp_path / "c.png") == 0.0
