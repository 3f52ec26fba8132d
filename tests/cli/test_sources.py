"""`demlaws lammps source`, `demlaws liggghts source`: files that the engines are built with (tools/machines builds LAMMPS)."""

from pathlib import Path

import pytest

import demlaws.lammps as lm
import demlaws.liggghts as lg
from demlaws.errors import DemlawsError
from demlaws.lammps.source import REGISTER, ROWS

ENGINES = {"lammps": lm, "liggghts": lg}
BESIDE = {"lammps": "granular_model.h", "liggghts": "normal_model_hertz.h"}


@pytest.fixture
def folder(engine, tmp_path):
    """One with a file of the engine's own, by which it is known."""
    (tmp_path / BESIDE[engine]).write_text("")
    return tmp_path


def written(engine, folder):
    lines = ENGINES[engine].source(folder).splitlines()
    return [Path(line.removeprefix("wrote ")) for line in lines if line.startswith("wrote ")]


@pytest.mark.parametrize("engine", ENGINES)
def test_sources_need_no_other_file_of_demlaws_and_are_written_once(engine, folder):
    files = written(engine, folder)
    stamps = {file: file.stat().st_mtime_ns for file in files}
    names = {file.name for file in files}
    for file in files:
        lines = file.read_text().splitlines()
        included = {line.split('"')[1] for line in lines if line.startswith('#include "')}
        assert {name for name in included if "demlaws" in name} <= names
        guards = [line for line in lines if line.startswith("#ifndef DEMLAWS_")]
        assert len(guards) == len(set(guards))
    assert written(engine, folder) == files
    assert stamps == {file: file.stat().st_mtime_ns for file in files}


@pytest.mark.parametrize("engine", ENGINES)
def test_a_folder_of_something_else_is_left_alone(engine, tmp_path):
    (tmp_path / "file").write_text("a file")
    for place in (tmp_path / "file", tmp_path, tmp_path / "absent"):
        with pytest.raises(DemlawsError, match=f"has no {BESIDE[engine]}"):
            written(engine, place)
    assert [file.name for file in tmp_path.iterdir()] == ["file"]


@pytest.mark.parametrize("engine", ENGINES)
def test_a_file_that_cannot_be_written_is_one_error(engine, folder):
    name = written(engine, folder)[0]
    name.unlink()
    name.mkdir()
    with pytest.raises(DemlawsError, match="cannot write to"):
        written(engine, folder)


@pytest.mark.parametrize("engine", ["liggghts"])
def test_liggghts_combines_no_model_of_ours_with_its_own(folder):
    """Its Make.sh reads the headers *_model_*.h."""
    assert not [file for file in written("liggghts", folder) if file.suffix == ".h"]


@pytest.mark.parametrize("engine", ["lammps"])
def test_a_lammps_with_a_register_needs_rows(folder):
    register = folder / REGISTER
    register.write_text("gran_sub_mod_table[] = {")
    text = lm.source(folder)
    assert f"add to {register}" in text and ROWS.rstrip() in text
    register.write_text(ROWS)
    assert str(register) not in lm.source(folder)
