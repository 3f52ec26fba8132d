"""What is made of the runs of angular grains, without the engine."""

import csv

import numpy as np
import pytest

from studies.shapes import __main__ as shapes


def test_a_row_written_and_read(tmp_path, capsys):
    """Modulus ∝ stress^0.4, a bed of 0.2 m that loses 1 mm in the first cycle and 0.1 mm in each of three more."""
    low = 0.2 - 1e-3 - 1e-4 * np.arange(4)
    heights = [0.2, *np.column_stack([low - 1e-4, low]).ravel()]
    moduli = 1e6 * np.array(shapes.STRESSES) ** 0.4
    text = {name: " ".join(f"{v:.9g}" for v in values) for name, values in (("stiffness", moduli), ("heights", heights))}
    row = {
        **dict.fromkeys(shapes.FIELDS, "1"),
        "shape": "levelset",
        "law": "rough",
        "radius": "edge",
        "contacts": "150",
        **text,
    }
    with open(tmp_path / "rows.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, shapes.FIELDS)
        writer.writeheader()
        writer.writerow(row)
    (found,) = shapes.read(tmp_path / "rows.csv")
    assert shapes.exponent(found) == pytest.approx(0.4, rel=1e-6)
    assert shapes.settlement(found) == pytest.approx(np.arange(4) * 1e-4 / 0.2, abs=1e-9)
    options = ["--results", str(tmp_path / "rows.csv"), "--figure", str(tmp_path / "rows.png")]
    assert shapes.main(options) == 0 and (tmp_path / "rows.png").stat().st_size > 5000
    assert "levelset,rough,edge," in capsys.readouterr().out


def test_the_kept_runs_are_those_of_the_study():
    kept = shapes.read(shapes.HERE / "angular.csv")
    assert {(row["shape"], row["law"], row["radius"]) for row in kept} <= set(shapes.RUNS)
    assert all(row["heights"].size == 2 * shapes.SETUP["cycles"] + 1 for row in kept)


def test_small_strain_moduli_are_kept(tmp_path, monkeypatch, capsys):
    """A missing run is added in kPa and MPa; a kept one is not repeated. Of the kept moduli the edge radius has the lowest."""
    calls = []

    def run(case, folder, progress, task):
        calls.append((*case, task))
        return {"rows": [[2e4, 8e7, 1e6, 150, 5.0]]}

    monkeypatch.setattr(shapes, "run", run)
    options = ["--small", "--results", str(tmp_path / "small.csv"), "--run", "--only", "sphere", "hertz"]
    for _ in range(2):
        assert shapes.main(options) == 0
        assert "sphere,hertz,body,20,80,1,2.5,5\n" in capsys.readouterr().out
    assert calls == [("sphere", "hertz", "body", "small")]
    assert shapes.main(["--small"]) == 0 and len(calls) == 1  # the kept runs are printed, none is started
    assert "levelset,rough,curvature," in capsys.readouterr().out
    kept = list(csv.reader((shapes.HERE / "small_strain.csv").read_text().splitlines()))
    modulus = {(row[0], row[2]): [float(r[4]) for r in kept if (r[0], r[2]) == (row[0], row[2])] for row in kept}
    assert all(np.array(modulus["levelset", "edge"]) < 0.6 * np.array(modulus["levelset", "body"]))
    assert all(np.diff(modulus["clump", "body"][:3]) > 0)
