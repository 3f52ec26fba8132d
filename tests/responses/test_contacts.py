"""Contacts as a table, and as lines between centres."""

import dataclasses
import sys

import numpy as np
import pytest

import demlaws as dl
from demlaws.responses.contacts import COLUMNS, MAIN, Contacts

ONE, TWO = np.array([[0.0, 0, 0], [0, 0, 1], [0, 1, 0]]), np.array([[0.0, 0, 1], [0, 0, 2], [0, 1, 1]])


def three(**more):
    values = {"stored": np.array([1.0, 1.0, 1.0]), "dissipated": np.array([0.0, 1e-14, 0.5])}
    values |= {"maximum_overlap": np.array([2e-6, 2e-6, 3e-6]), "plastic_overlap": np.array([0.0, 0.0, 1e-6])}
    values |= {"flattened": np.array([False, False, True])}
    return Contacts(
        np.array([0, 1, 2]), np.array([1, 2, 3]), np.array([2e-6, 1e-6, 3e-6]), np.array([5.0, 4.0, 9.0]), **(values | more)
    )


def test_length_indexing_and_columns():
    contacts = three(sliding=np.array([True, False, False]), radius_ratio=np.full(3, np.nan))
    assert len(contacts) == 3 and len(contacts[contacts.force > 4.5]) == 2
    assert contacts[-1].body2.tolist() == [3] and contacts[[2, 0]].force.tolist() == [9.0, 5.0]
    assert contacts[:1].stiffness is None
    assert contacts[1:].flattened.tolist() == [False, True]
    columns = contacts.columns()
    assert "radius_ratio" not in columns and "stiffness (N/m)" not in columns  # nothing is known of them
    assert columns["plastic_overlap (m)"][2] == 1e-6 and list(columns["sliding"]) == [True, False, False]
    assert max(map(len, str(contacts).splitlines())) <= 100
    with pytest.raises(IndexError):
        contacts[3]


def test_every_column_is_described():
    fields = [field.name for field in dataclasses.fields(Contacts)]
    assert [*(name for name in COLUMNS if name in fields), "centre1", "centre2"] == fields
    assert all(isinstance(getattr(Contacts, name), property) for name in COLUMNS if name not in fields)
    assert set(MAIN) <= set(COLUMNS)


def test_dataframe():
    pytest.importorskip("pandas")
    frame = three().to_dataframe()
    assert len(frame) == 3 and frame["force (N)"].sum() == 18.0 and frame["flattened"].sum() == 1


@pytest.mark.parametrize("suffix", [".vtu", ".vtk"])
def test_lines_for_paraview(tmp_path, suffix):
    meshio = pytest.importorskip("meshio")
    mesh = meshio.read(three(centre1=ONE, centre2=TWO).save(tmp_path / f"contacts{suffix}"))
    points, lines = np.asarray(mesh.points), mesh.cells_dict["line"]
    data = {name: np.ravel(values[0]).tolist() for name, values in mesh.cell_data.items()}
    assert points[lines[:, 0]] == pytest.approx(ONE) and points[lines[:, 1]] == pytest.approx(TWO)
    assert data["plastic_overlap"] == [0.0, 0.0, 1e-6] and data["flattened"] == [0, 0, 1]


@pytest.mark.parametrize(("suffix", "remedy"), [(".vtu", "demlaws\\[vtk\\]"), (".csv", "csv")])
def test_remedy_without_a_library(tmp_path, suffix, remedy, monkeypatch):
    monkeypatch.setitem(sys.modules, "meshio", None)
    with pytest.raises(dl.DemlawsError, match=remedy):
        three(centre1=ONE, centre2=TWO).save(tmp_path / f"x{suffix}")
    assert not list(tmp_path.iterdir())


def test_without_places():
    with pytest.raises(dl.DemlawsError, match="places"):
        three().save("x.vtu")
