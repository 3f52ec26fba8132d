"""A law of a user's file, and a table of a user's function, inside LIGGGHTS."""

import re
from pathlib import Path

import numpy as np
import pytest
from inputs_for_liggghts import two_spheres
from own_spring import registered

import demlaws as dl
from demlaws.liggghts import run
from demlaws.liggghts.check import follow

GRAN = "pair_style gran model demlaws/table tangential history "
PAGE = (Path(__file__).parents[3] / "docs" / "own-laws.md").read_text()
CONTACT = dl.Contact(radius=4e-3, modulus=32e9)


@pytest.mark.slow
def test_a_law_of_ones_own_within_its_certificate(tmp_path, registered_here):
    (text,) = re.findall(r"<!-- file: my_law.py -->\n```python\n(.*?)```", PAGE, re.DOTALL)
    (tmp_path / "my_law.py").write_text(text)
    dl.load_laws(tmp_path / "my_law.py")
    law = dl.law("power", CONTACT, "hertz")
    log, path = follow(law)
    assert path.overlap.max() > 1e-5
    assert np.abs(log["force"] - path.force).max() <= 1e-5 * path.force.max()


@pytest.mark.slow
def test_a_table_of_a_function_within_its_certificate():
    def force(overlap):
        return 3e9 * overlap**1.7

    table = dl.Table.from_function(force, CONTACT, unloading=lambda overlap: 9e9 * overlap**1.65)
    log, path = follow(table)  # which tabulates a table, too, to 1e-5
    overlap, found, expected = log["overlap"], log["force"], path.force
    assert np.abs(found - expected).max() <= 1e-5 * expected.max()
    first = slice(0, int(np.argmax(overlap > 1e-6)) + 5)
    touching = overlap[first] > 0
    np.testing.assert_allclose(found[first][touching], force(overlap[first][touching]), rtol=1e-5 + table.force_error)


@pytest.mark.slow
def test_a_rule_of_ones_own_goes_on_after_a_restart(tmp_path):
    """Half way through unloading a restart file is written; a new process goes on as the first would have."""
    with registered(tmp_path):
        law = dl.law("spring", CONTACT, lost=0.3)
        law.tabulate(1e-6).save(tmp_path / "law.tbl")
    moves = [(-0.2, 0, 5000), (0.2, 0, 500), (-0.2, 0, 2000), (0.2, 0, 6000)]
    text = two_spheres(f"{GRAN}table law.tbl", moves[:2], 16e-3, 16e-3).replace(
        "region          box", "processors 1 1 1\nregion box"
    )
    young = 2 * CONTACT.modulus * (1 - 0.25**2)
    text = text.replace("60.6e9 60.6e9", f"{young!r} {young!r}")
    more = "".join(f"velocity right set {along} {across} 0\nrun {steps}\n" for along, across, steps in moves[2:])
    (tmp_path / "in.whole").write_text(f"{text}write_restart half.restart\n{more}")
    whole = run(tmp_path / "in.whole")
    head, tail = text.split("region box", 1)
    after = "\n".join(line for line in tail.splitlines()[1:] if not line.startswith(("create_", "set ", "velocity", "run")))
    (tmp_path / "in.later").write_text(f"{head}read_restart half.restart\n{after}\n{more}")
    later = run(tmp_path / "in.later")
    same = np.isin(whole["Step"], later["Step"])
    assert same.sum() == later["Step"].size > 300
    np.testing.assert_allclose(later["force"], whole["force"][same], rtol=1e-12, atol=1e-12 * whole["force"].max())
