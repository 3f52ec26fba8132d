"""LAMMPS with the models built in (`make lammps-source`; DEMLAWS_LAMMPS_SOURCE names it) beside LAMMPS with the plugin."""

import itertools
import os
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest
from inputs import ENERGY, LOAD_UNLOAD, energy_error_of, said_in, save
from inputs_for_lammps import HEAD, TABLE, continued, refused, simulate, two_spheres
from spheres import ROUGH, save_law
from twins import LAWS, PLUGIN, SHEARS, SOURCE, assert_checked, assert_sheared_alike, built, chooser

import demlaws as dl
import demlaws.lammps as lm

DAMPED = "tangential demlaws 1.0 0.5 rolling sds 1e3 1.0 0.3 damping demlaws/tangent"
PACKING = f"""{HEAD}processors      1 1 *
boundary        p p f
lattice         sc 0.004 origin 0.5 0.5 0.5
region          box block 0 4 0 4 0 4
create_box      2 box
create_atoms    1 box
set             group all diameter 0.0041 density 2650
set             group all type/fraction 2 0.5 7
neighbor        4e-4 bin
pair_style      granular
pair_coeff      1 1 demlaws/table law.tbl 60.6e9 0.7 0.25 WORDS {DAMPED}
pair_coeff      2 2 demlaws/table law.tbl 30e9 0.7 0.25 WORDS {DAMPED}
fix             floor all wall/gran granular demlaws/table law.tbl 60.6e9 0.7 0.25 {DAMPED} zplane 0 NULL
region          lid plane 0 0 0.016 0 0 -1 units box
fix             lid all wall/gran/region granular demlaws/table law.tbl 60.6e9 0.7 0.25 {DAMPED} region lid
velocity        all create 1e16 5 loop all
fix             move all nve/sphere
compute         e all demlaws/energy
timestep        1e-7
thermo_style    custom step ke c_e[1] c_e[2]
thermo_modify   format float %.17e norm no
thermo          50
"""
DUMP = "write_dump all custom end.dump id x y z fx fy fz tqx tqy tqz modify sort id format float %.17g\n"


@pytest.fixture
def use(monkeypatch):
    return chooser(monkeypatch, "lammps", lambda: lm.versions().built_in)


def end_of(folder, text, ranks=1):
    log = simulate(folder, text + DUMP, ranks)
    return log, np.loadtxt(folder / "end.dump", skiprows=9)


def assert_atoms_close(found, expected, rtol):
    """Positions, forces and moments, each to their largest one."""
    for columns in (slice(1, 4), slice(4, 7), slice(7, 10)):
        scale = np.abs(expected[:, columns]).max()
        assert scale > 0 and np.abs(found[:, columns] - expected[:, columns]).max() <= rtol * scale


def test_it_passes_the_check_without_a_plugin(use):
    use(SOURCE)
    assert_checked(lm.check)


@pytest.mark.parametrize("shear", SHEARS)
@pytest.mark.parametrize("name", LAWS)
def test_a_sheared_contact_is_the_plugins_to_rounding(tmp_path, use, name, shear):
    assert_sheared_alike(use, "lammps", tmp_path, name, shear, every=2)


@pytest.mark.parametrize(
    "words", ["", "roughness 2e-6 levels 1", "shear slip springs 4", "extrapolation on radius_tolerance 0.5"]
)
def test_a_packing_is_the_plugins(tmp_path, use, words):
    """Two types that are mixed, rolling, a floor, a region wall, periodic sides; 200 steps of colliding spheres."""
    save_law(tmp_path, "rough")
    text = PACKING.replace("WORDS", words)
    ends = []
    for way in (PLUGIN, SOURCE):
        use(way)
        ends.append(end_of(tmp_path, text + "run 200\n"))
    (plugin_log, plugin), (source_log, source) = ends
    assert_atoms_close(source, plugin, 1e-9)
    for column in ("e[1]", "e[2]"):
        np.testing.assert_allclose(source_log[column], plugin_log[column], rtol=1e-9, err_msg=column)
    assert plugin_log["e[2]"][-1] > 0


@pytest.mark.parametrize("ranks", [2, 4])
def test_ranks_give_the_same_packing(tmp_path, use, ranks):
    use(SOURCE)
    save_law(tmp_path, "rough")
    text = PACKING.replace("WORDS", "") + "run 200\n"
    (one_log, one), (log, several) = end_of(tmp_path, text), end_of(tmp_path, text, ranks)
    assert_atoms_close(several, one, 1e-9)
    np.testing.assert_allclose(log["e[2]"], one_log["e[2]"], rtol=1e-9)


def releases():
    """Pairs that a restart file can go between: LAMMPS itself loses contacts' histories between some of its releases."""
    with pytest.MonkeyPatch.context() as patch:
        plugin = lm.versions().date
        patch.setenv("DEMLAWS_LAMMPS", built("lammps"))
        both = [(PLUGIN, SOURCE), (SOURCE, PLUGIN)]
        return [(SOURCE, SOURCE), *(both if lm.versions().date == plugin else [])]


@pytest.mark.parametrize("written, read", releases())
def test_a_restart_file_goes_on_in_either(tmp_path, use, written, read):
    law = save_law(tmp_path, "rough")
    use(written)
    simulate(tmp_path, two_spheres(TABLE, LOAD_UNLOAD[:2], **ENERGY) + "write_restart now.restart\n")
    use(read)
    log = simulate(tmp_path, continued(LOAD_UNLOAD[2:], **ENERGY), 2 if read == SOURCE else 1)
    whole = simulate(tmp_path, two_spheres(TABLE, LOAD_UNLOAD, **ENERGY))
    rows = np.isin(whole["Step"], log["Step"])
    assert rows.sum() > 100
    for column in ("force", "e[1]", "e[2]"):
        scale = np.abs(whole[column]).max()
        np.testing.assert_allclose(log[column], whole[column][rows], rtol=1e-12, atol=1e-12 * scale, err_msg=column)
    assert energy_error_of(whole, law) <= 1e-4


def test_renumbered_particles_are_refused(folder, use):
    use(SOURCE)
    text = two_spheres(TABLE, LOAD_UNLOAD[:1])
    assert "compress no" in refused(folder, text + "group none empty\ndelete_atoms group none\n")
    assert "reset_atoms id" in refused(folder, text + "reset_atoms id\n")
    simulate(folder, text + "group none empty\ndelete_atoms group none compress no\nrun 10\n")


def test_rerun_announces_whose_history_its_contacts_have(folder, use):
    use(SOURCE)
    text = two_spheres(TABLE, LOAD_UNLOAD[:1]) + "dump f all custom 100 frames.txt id type x y z\nrun 100\nundump f\n"
    simulate(folder, text + 2 * "rerun frames.txt dump x y z\n")
    assert said_in("lammps", folder).count("WARNING: rerun: contacts of every frame have") == 1


def test_errors_name_what_is_wrong(folder, use, granite_pair):
    use(SOURCE)
    save(dl.law("hertz", granite_pair), folder / "hertz.tbl")

    def message(old, new):
        return refused(folder, two_spheres(TABLE.replace(old, new, 1), LOAD_UNLOAD[:1]))

    assert "no.tbl" in message("law.tbl", "no.tbl")
    assert "FILE E eta nu" in message(" 0.25 tangential demlaws 1.0 0.5 damping demlaws/tangent", "")
    assert "nu is 'x', not a finite number" in message("0.25", "x")
    assert "shear is elastic, loading or slip" in message("0.25", "0.25 shear plastic")
    assert "Illegal pair_coeff command colour" in message("0.25", "0.25 colour red")
    assert "units si" in refused(folder, two_spheres(TABLE, LOAD_UNLOAD[:1]).replace("units           si", "units lj"))
    lines = f"pair_coeff 1 1 {TABLE}\npair_coeff 2 2 {TABLE.replace('law.tbl', 'hertz.tbl')}\n"
    assert "law.tbl and hertz.tbl cannot be mixed" in refused(folder, two_spheres(lines, LOAD_UNLOAD[:1]))
    other = TABLE.replace("tangential demlaws 1.0 0.5", "tangential mindlin NULL 1.0 0.5")
    lines = f"pair_coeff 1 1 {TABLE}\npair_coeff * 2 {other}\n"
    assert "different numbers of history values" in refused(folder, two_spheres(lines, LOAD_UNLOAD[:1]))


def test_walls_alone(tmp_path, use):
    """No pair style reads a table; a run has all that it needs beside the wall's model."""
    use(SOURCE)
    dl.law("hertz", ROUGH).tabulate().save(tmp_path / "law.tbl")
    wall = f"fix wall all wall/gran granular demlaws/table law.tbl 60.6e9 1.0 0.25 {DAMPED} xplane -1e-6 NULL\n"
    log = simulate(tmp_path, wall_scene(wall) + "run 200\n")
    assert log["e[1]"].max() > 0 and log["pull"].max() > 0
    simulate(
        tmp_path, wall_scene(wall.replace("demlaws/table law.tbl 60.6e9 1.0 0.25 " + DAMPED, STOCK_WALL), TABLE) + "run 2\n"
    )
    assert "has the stock model hertz/material" in said_in("lammps", tmp_path)


STOCK_WALL = "hertz/material 60.6e9 1.0 0.25 tangential mindlin NULL 1.0 0.5"


def wall_scene(wall, pair=""):
    style = f"pair_style granular\npair_coeff * * {pair}" if pair else "pair_style zero 0.02\npair_coeff * *"
    return f"""{HEAD}boundary f f f
region box block -0.01 0.05 -0.03 0.03 -0.03 0.03
create_box 1 box
create_atoms 1 single 8.7e-3 0 0
set group all diameter 17.4e-3 density 2650
{style}
{wall}
velocity all set -0.5 0 0
fix move all nve/sphere
compute pull all reduce sum fx
compute e all demlaws/energy
thermo_style custom step c_pull c_e[1] c_e[2]
thermo_modify format float %.17e norm no
thermo 1
timestep 1e-7
"""


# --- triangles (package GRANSURF of 4 Jul 2026)


def stl(path, corners, height):
    """A file of the squares between `corners` along x and y, cut into triangles, at z = height(x)."""
    lines = ["solid ground"]
    for (x1, x2), (y1, y2) in itertools.product(itertools.pairwise(corners), repeat=2):
        square = [(x, y, height(x)) for x, y in ((x1, y1), (x2, y1), (x2, y2), (x1, y2))]
        for triangle in ((0, 1, 2), (0, 2, 3)):
            a, b, c = (np.array(square[k]) for k in triangle)
            normal = np.cross(b - a, c - a) / np.linalg.norm(np.cross(b - a, c - a))
            points = [f"vertex {x:.12g} {y:.12g} {z:.12g}" for x, y, z in (a, b, c)]
            lines += [
                f"facet normal {normal[0]:.12g} {normal[1]:.12g} {normal[2]:.12g}",
                "outer loop",
                *points,
                "endloop",
                "endfacet",
            ]
    path.write_text("\n".join([*lines, "endsolid ground", ""]))


def rolling(folder, wall, model, start, speed, gravity=3000):
    """Log of a sphere of 10 mm that is pressed on a wall and moves along it: place, speed, spin, force. wall: with MODEL."""
    text = f"""{HEAD}boundary f f f
region box block -0.03 0.03 -0.03 0.03 -0.02 0.03 units box
create_box 2 box
create_atoms 1 single {start} units box
set group all diameter 0.01 density 2650
neighbor 1e-3 bin
neigh_modify delay 0 every 1 check yes
pair_style granular
pair_coeff * * {model}
{wall.replace("MODEL", f"granular {model}")}
fix weight all gravity {gravity} vector 0 0 -1
fix move all nve/sphere
velocity all set {speed}
compute e all demlaws/energy
compute p all property/atom x y z vx vy vz omegax omegay fx fy fz
compute s all reduce sum c_p[*]
thermo_style custom step c_e[1] c_e[2] c_s[*]
thermo_modify format float %.17e norm no
timestep 1e-7
thermo 20
run 30000
"""
    return simulate(folder, text)


def surfaces():
    """Programs with package GRANSURF."""
    found = []
    with pytest.MonkeyPatch.context() as patch:
        for name, program in ((PLUGIN, os.environ.get("DEMLAWS_LAMMPS")), (SOURCE, built("lammps"))):
            if program:
                patch.setenv("DEMLAWS_LAMMPS", program)
                found += [name] if "GRANSURF" in lm.versions().packages else []
    return found


@pytest.mark.parametrize(
    "start, speed", [("-0.011 -0.0123 0.00501", "0.8 1.0 -0.01"), ("-0.011 -0.011 0.00501", "0.8 0.8 -0.01")]
)
@pytest.mark.parametrize("way", surfaces())
def test_a_sphere_on_triangles_is_one_on_a_plane(tmp_path, use, way, start, speed):
    """Over edges, and over a corner and along an edge."""
    use(way)
    dl.law("pohrt-popov", ROUGH.with_values(radius=5e-3), "hertz").tabulate(rtol=1e-7).save(tmp_path / "law.tbl")
    model = "demlaws/table law.tbl 60.6e9 0.9 0.25 tangential demlaws 1.0 0.3 damping demlaws/tangent"
    stl(tmp_path / "ground.stl", np.linspace(-0.02, 0.02, 5), lambda x: 0.0)
    plane = rolling(tmp_path, "fix floor all wall/gran MODEL zplane 0 NULL", model, start, speed)
    ground = rolling(tmp_path, "fix floor all surface/global input stl 1 1 ground.stl model * * MODEL", model, start, speed)
    assert plane["e[1]"].max() > 0 and np.abs(plane["s[7]"]).max() > 10
    for column, values in plane.items():
        assert np.abs(ground[column] - values).max() <= 1e-9 * max(np.abs(values).max(), 1e-12), column


@pytest.mark.parametrize("way", surfaces())
def test_the_table_of_hertz_over_a_ridge_is_stock_hertz(tmp_path, use, way):
    use(way)
    dl.law("hertz", ROUGH.with_values(radius=5e-3)).tabulate(rtol=1e-10).save(tmp_path / "law.tbl")
    stl(tmp_path / "ground.stl", np.array([-0.02, -0.01, -0.003, 0.005, 0.02]), lambda x: -0.4 * abs(x + 0.003))
    words = "tangential linear_history 1e6 0.1 0.3 damping viscoelastic"
    wall, start, speed = (
        "fix floor all surface/global input stl 1 1 ground.stl model * * MODEL",
        "-0.0055 -0.0123 0.00441",
        "1.6 0.5 0.6",
    )
    stock = rolling(tmp_path, wall, f"hertz/material 60.6e9 0.3 0.25 {words}", start, speed, 100)
    table = rolling(tmp_path, wall, f"demlaws/table law.tbl 60.6e9 0.3 0.25 {words}", start, speed, 100)
    touches = np.abs(stock["s[9]"]) > 0
    assert stock["s[1]"][0] < -0.003 < stock["s[1]"][-1] and touches.sum() > 20
    for column in ("s[1]", "s[3]", "s[4]", "s[6]", "s[8]", "s[11]"):
        assert np.abs(table[column] - stock[column]).max() <= 1e-7 * np.abs(stock[column]).max(), column


@pytest.mark.parametrize("way", surfaces())
def test_a_sphere_on_triangles_that_are_particles(tmp_path, use, monkeypatch, way):
    """pair_style surf/granular, whose histories LAMMPS of 4 Jul 2026 drops whenever lists are built: refused by the plugin."""
    use(way)
    dl.law("pohrt-popov", ROUGH.with_values(radius=5e-3), "hertz").tabulate(rtol=1e-7).save(tmp_path / "law.tbl")
    model = "demlaws/table law.tbl 60.6e9 0.9 0.25 tangential demlaws 1.0 0.3 damping demlaws/tangent"
    stl(tmp_path / "ground.stl", np.linspace(-0.02, 0.02, 5), lambda x: 0.0)
    case = (tmp_path, "fix floor all wall/gran MODEL zplane 0 NULL", model, "-0.011 -0.0123 0.00501", "0.8 1.0 -0.01")
    plane = rolling(*case)
    wall = f"fix floor all wall/gran granular {model} zplane 0 NULL"
    changes = [
        ("atom_style      sphere", "atom_style      tri"),
        (f"pair_style granular\npair_coeff * * {model}\n{wall}", "pair_style hybrid granular surf/granular"),
        (
            "fix weight",
            f"pair_coeff 1 1 granular {model}\npair_coeff 1 2 surf/granular {model}\npair_coeff 2 2 none\nfix weight",
        ),
        (" density 2650", "\nset group all density 2650\ngroup ball type 1\nfix g all surface/local input stl 2 1 ground.stl"),
        ("compute e all demlaws/energy\n", ""),
        ("c_e[1] c_e[2] ", ""),
        *((f"{word} all", f"{word} ball") for word in ("weight", "move", "velocity", "compute p", "compute s")),
    ]

    def on_particles(folder, text, run=refused if way == PLUGIN else simulate):
        for old, new in changes:
            assert old in text
            text = text.replace(old, new)
        return run(folder, text)

    monkeypatch.setitem(rolling.__globals__, "simulate", on_particles)
    ground = rolling(*case)
    assert np.abs(plane["s[7]"]).max() > 10
    if way == PLUGIN:
        assert "drops the histories" in ground
        return
    for column in set(plane) - {"e[1]", "e[2]"}:
        assert np.abs(ground[column] - plane[column]).max() <= 1e-7 * np.abs(plane[column]).max(), column


# --- LAMMPS's own tests of granular models (unittest/granular), with the table of Hertz in the place of hertz/material


def tree():
    """The source that the program was built from."""
    cache = Path(built("lammps")).with_name("CMakeCache.txt").read_text()
    return Path(re.search(r"CMAKE_HOME_DIRECTORY:INTERNAL=(.*)", cache).group(1)).parent


def cases():
    files = sorted((tree() / "unittest/granular/tests").glob("dem*.yaml"))
    return [file for file in files if "hertz/material" in file.read_text()]


def blocks_of(text):
    """{key: lines} of such a file."""
    blocks, lines = {}, []
    for line in text.replace("\n...", "").splitlines():
        if found := re.match(r"(\w+):(.*)", line):
            lines = blocks[found.group(1)] = [found.group(2).strip()] if "!" not in found.group(2) else []
        else:
            lines.append(line.strip())
    return blocks


@pytest.mark.parametrize("file", cases(), ids=lambda file: file.stem)
@pytest.mark.parametrize("newton", ["on", "off"])
def test_a_case_of_lammps_with_the_table_of_hertz(tmp_path, use, file, newton):
    """Positions, velocities, torques and spins that LAMMPS's own test expects, to its own tolerance."""
    use(SOURCE)
    text = file.read_text().replace("units lj", "units si").replace("hertz/material", "demlaws/table law.tbl")
    case = blocks_of(text)
    values = dict(line.split(maxsplit=1) for line in case["variables"])
    modulus = float(values["emod"]) / (2 * (1 - float(values["poisson"]) ** 2))
    dl.law("hertz", dl.Contact(radius=0.25, modulus=modulus)).tabulate(rtol=1e-12).save(tmp_path / "law.tbl")
    lines = [f"newton {newton}", "atom_modify map array", *case["pre_commands"], f"pair_style {case['pair_style'][0]}"]
    lines += [f"pair_coeff {line}" for line in case["pair_coeff"]] + case["post_commands"]
    found = {"pos": "x y z", "vel": "vx vy vz", "torque": "tqx tqy tqz", "omega": "omegax omegay omegaz"}
    for segment, steps in enumerate(" ".join(case["run_segments"]).split()):
        dump = f"write_dump all custom end.{segment} id {' '.join(found.values())} modify sort id format float %.17g"
        lines += [f"run {steps}", dump]
    lines = [re.sub(r"\$\{(\w+)\}", lambda name: values[name.group(1)], line) for line in lines]
    simulate(tmp_path, "\n".join(lines) + "\n")
    for column, name in enumerate(found):
        for row in case[f"run_{name}"]:
            segment, number, *expected = map(float, row.split())
            ends = np.loadtxt(tmp_path / f"end.{segment:.0f}", skiprows=9, ndmin=2)
            vector = ends[int(number) - 1, 1 + 3 * column : 4 + 3 * column]
            np.testing.assert_allclose(vector, expected, rtol=float(case["epsilon"][0]), atol=1e-12, err_msg=f"{name} {row}")


def test_the_patch_for_lammps_applies():
    """upstream/lammps; a source without manual and examples has only some of its files."""
    patch = Path(dl.__file__).parents[1] / "upstream/lammps/granular_table.patch"
    text = patch.read_text()
    kept = "".join(
        part for part in re.split(r"(?=^diff --git )", text, flags=re.M) if re.match(r"diff --git a/(src|unittest)", part)
    )
    line = ["patch", "-p1", "--dry-run", "--force", "-d", str(tree())]
    done = subprocess.run(line, input=kept, capture_output=True, text=True)
    assert done.returncode == 0 and done.stdout.count("checking file") == kept.count("diff --git") == 9, done.stdout
