"""A law of a user's file, and a table of a user's function, inside LIGGGHTS."""

import re
from pathlib import Path

import numpy as np
import pytest

import demlaws as dl
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
