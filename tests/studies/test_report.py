"""The validation report: its rows pass, its page lists them, and a wrong coefficient is noticed."""

import pytest
from examples import shared

import demlaws
from studies.validation import oblique, published
from studies.validation.__main__ import main
from studies.validation.published import GROUPS
from studies.validation.report import CONCLUSIONS, evidence, page
from studies.validation.row import SOURCES, between, near


@pytest.mark.parametrize("group", shared(list(GROUPS), lambda group: not group.startswith("Elastic rough spheres")))
def test_every_published_answer(group):
    rows = list(GROUPS[group]())
    assert rows
    assert not [(row.what, row.expected, row.found) for row in rows if row.verdict != "pass"]
    assert all(row.source in SOURCES for row in rows)


def test_the_places_that_lammps_keeps_tell_a_thousandth_of_a_per_cent_in_stiffness_apart(monkeypatch):
    monkeypatch.setattr(published, "KEPT", tuple(one._replace(modulus=1.00001 * one.modulus) for one in published.KEPT))
    verdicts = [row.verdict for row in published.lammps_impacts()]
    assert verdicts == ["pass", "FAIL", "FAIL"] * 2  # before contact nothing differs


def test_every_law_has_its_line_and_its_rows():
    assert set(CONCLUSIONS) == set(demlaws.laws())
    groups = {name: [] for name in GROUPS}
    for name in ("Plastic laws of the literature", "A cone", "Granite"):
        groups[name] = list(GROUPS[name]())
    for law in ("goddard", "rms", "bahrami", "thornton-ning", "luding", "eepa"):
        kinds = evidence(groups, CONCLUSIONS[law][0])
        assert kinds and all(law in row.what or law == "goddard" for _, rows in kinds for row in rows)
    failed = page({"one": [near("eepa: x", 1.0, 2.0, 0.1, "eepa")]})
    assert "printed equations 0/1 **FAIL**" in failed


def test_oblique_impacts_tell_shear_models_apart():
    """Neither Kharaz's spheres nor the finite elements pass with a model without partial slip."""
    assert 0.02 < oblique.misfit(oblique.table()["elastic"]) < 0.03
    assert oblique.spin_row("Python", oblique.spins("force kept")).verdict == "FAIL"


def test_the_command(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("studies.validation.report.GROUPS", {"A cone": GROUPS["A cone"]})
    assert main(["--no-engines", "--out", str(tmp_path / "page")]) == 0
    assert "1 rows pass, 0 fail" in capsys.readouterr().out
    for name in ("deviations.png", "asperity.png"):
        assert (tmp_path / "page" / name).stat().st_size > 1000 and name in (tmp_path / "page" / "validation.md").read_text()
    monkeypatch.setattr("studies.validation.report.GROUPS", {"wrong": lambda: [between("x", 0, 1, 2, "bem")]})
    assert main(["--no-engines", "--out", str(tmp_path / "page")]) == 1
