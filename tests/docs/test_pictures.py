"""Pictures of docs/pictures are those that their scripts draw; on the site they are drawn again."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("matplotlib")
from pictures import difference

DOCS = Path(__file__).resolve().parents[2] / "docs"
DRAWN = sorted(path.stem for path in (DOCS / "gallery").glob("*.py") if (DOCS / "pictures" / f"{path.stem}.png").exists())


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
    changed = difference(tmp_path / f"{name}.png", DOCS / "pictures" / f"{name}.png")
    assert changed < 0.005, f"docs/pictures/{name}.png differs in {changed:.1%}: copy what docs/gallery/{name}.py draws"


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
