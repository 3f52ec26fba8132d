"""A plugin that some ranks lack: one line and an end within seconds, where they would wait for each other for ever."""

import subprocess

import pytest
from inputs import part
from spheres import LOAD_UNLOAD, save_law, spheres


@pytest.mark.slow
@pytest.mark.parametrize(("engine", "without"), [("liggghts", 0), ("liggghts", 1), ("lammps", 0), ("lammps", 1)])
def test_a_rank_without_the_plugin_ends_the_run(engine, tmp_path, without):
    save_law(tmp_path, "rough")
    (tmp_path / "in.case").write_text(spheres(engine, "", LOAD_UNLOAD))
    (tmp_path / "start.sh").write_text(
        f'#!/bin/sh\n[ "${{OMPI_COMM_WORLD_RANK:-$PMI_RANK}}" = {without} ] && unset LD_PRELOAD LAMMPS_PLUGIN_PATH\nexec "$@"\n'
    )
    (tmp_path / "start.sh").chmod(0o755)
    run = part(engine, "run")
    line, environment = run.command("in.case", 2)
    program = run.executable()
    at = line.index(str(getattr(program, "path", program)))
    line.insert(at, str(tmp_path / "start.sh"))
    result = subprocess.run(line, cwd=tmp_path, env=environment, capture_output=True, text=True, errors="replace", timeout=60)
    assert result.returncode != 0
    assert f"rank {1 - without} has waited for the others" in result.stdout + result.stderr
