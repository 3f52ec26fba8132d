"""`demlaws lammps source`, `demlaws liggghts source`: files that the engines are built with (tests/machines builds LAMMPS)."""

import pytest

import demlaws.lammps as lm
import demlaws.liggghts as lg
from demlaws.errors import DemlawsError
from demlaws.lammps.source import REGISTER, ROWS

ENGINES = {"lammps": lm, "liggghts": lg}


def written(engine, folder):
    found = ENGINES[engine].source(folder)
    return found.files if engine == "lammps" else (found.file,)


@pytest.mark.parametrize("engine", ENGINES)
def test_sources_need_no_other_file_of_demlaws_and_are_written_once(engine, tmp_path):
    files = written(engine, tmp_path / "src")
    stamps = {file: file.stat().st_mtime_ns for file in files}
    names = {file.name for file in files}
    for file in files:
        lines = file.read_text().splitlines()
        included = {line.split('"')[1] for line in lines if line.startswith('#include "')}
        assert {name for name in included if "demlaws" in name} <= names
        guards = [line for line in lines if line.startswith("#ifndef DEMLAWS_")]
        assert len(guards) == len(set(guards))
    assert written(engine, tmp_path / "src") == files
    assert stamps == {file: file.stat().st_mtime_ns for file in files}


@pytest.mark.parametrize("engine", ENGINES)
def test_a_folder_that_cannot_be_written_is_one_error(engine, tmp_path):
    (tmp_path / "src").write_text("a file")
    with pytest.raises(DemlawsError, match="cannot write to"):
        written(engine, tmp_path / "src")


def test_liggghts_combines_no_model_of_ours_with_its_own(tmp_path):
    """Its Make.sh reads the headers *_model_*.h."""
    assert not [file for file in written("liggghts", tmp_path) if file.suffix == ".h"]


def test_a_lammps_with_a_register_needs_rows(tmp_path):
    register = tmp_path / REGISTER
    register.write_text("gran_sub_mod_table[] = {")
    written = lm.source(tmp_path)
    assert written.register == register and ROWS.rstrip() in str(written)
    register.write_text(ROWS)
    assert lm.source(tmp_path).register is None
