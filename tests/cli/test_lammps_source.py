"""`demlaws lammps source`: files that LAMMPS can be built with; tests/machines/lammps_source.py builds it."""

import demlaws.lammps as lm
from demlaws.lammps.source import REGISTER, ROWS


def test_sources_need_no_other_file_of_demlaws_and_are_written_once(tmp_path):
    written = lm.source(tmp_path / "GRANULAR")
    stamps = {file: file.stat().st_mtime_ns for file in written.files}
    names = {file.name for file in written.files}
    for file in written.files:
        lines = file.read_text().splitlines()
        included = {line.split('"')[1] for line in lines if line.startswith('#include "')}
        assert {name for name in included if "demlaws" in name} <= names
        guards = [line for line in lines if line.startswith("#ifndef DEMLAWS_")]
        assert len(guards) == len(set(guards))
    assert lm.source(tmp_path / "GRANULAR").register is None
    assert stamps == {file: file.stat().st_mtime_ns for file in written.files}


def test_a_lammps_with_a_register_needs_rows(tmp_path):
    register = tmp_path / REGISTER
    register.write_text("gran_sub_mod_table[] = {")
    written = lm.source(tmp_path)
    assert written.register == register and ROWS.rstrip() in str(written)
    register.write_text(ROWS)
    assert lm.source(tmp_path).register is None
