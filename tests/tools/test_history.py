"""The page's table of the history's sizes is what the engines say."""

import csv
from pathlib import Path

import bench_engines
import history
import pytest

TABLE = Path(__file__).parents[2] / "docs" / "tables" / "cost-memory.csv"


@pytest.mark.slow
@pytest.mark.parametrize("engine", [pytest.param(name, marks=getattr(pytest.mark, name)) for name in history.STOCK])
def test_sizes_of_the_page_are_those_of_the_engine(engine, tmp_path):
    column = {"liggghts": "LIGGGHTS (bytes per contact)", "lammps": "LAMMPS"}[engine]
    with open(TABLE, newline="") as file:
        kept = {row["history"]: int(row[column]) for row in csv.DictReader(file) if row[column]}
    bench_engines.write_tables(tmp_path)
    assert {name: history.history(engine, tmp_path, name) for name in (*history.STOCK[engine], *history.OURS)} == kept
