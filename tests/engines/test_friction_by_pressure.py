"""`friction_pressure` in LIGGGHTS and LAMMPS: force and energy against Python, walls, restart, what is refused."""

import itertools

import numpy as np
import pytest
from examples import sealed, shared
from inputs import ENERGY, counts, refused, said_in, simulate
from spheres import DIAMETER, LAWS as ALL_LAWS, RATIO, ROUGH, STEP, both, gas, spheres

import demlaws as dl
from demlaws.core.shear import SPRINGS
from demlaws.shear import _pressure_along
from studies.shear.gas import HEADS

MU0, C1, C2 = 0.5, 0.4, 3e-9
WORDS = f"friction_pressure {C1} {C2!r}"
FRICTION = dl.PressureFriction(MU0, C1, C2)
SLID = [(-0.2, 0, 600), (0, 0.3, 600), (-0.2, 0.2, 300), (0.2, 0.3, 500), (0, -0.3, 1200), (-0.2, -0.3, 400)]
"""Press, slide, press on and lift off while it slides, slide back, press."""
LAWS = {**ALL_LAWS, "crushed": ("conical-damage", "thornton", {"strength": 0.5e9, "angle": 1.2})}
PATHS = shared(itertools.product(LAWS, ("elastic", "loading", "slip")), lambda path: path[0] == "rough" or path[1] == "slip")


def save_law(folder, name):
    law, rule, *options = LAWS[name]
    law = dl.law(law, ROUGH, rule, **(options[0] if options else {}))
    law.tabulate(rtol=1e-6, max_force=3e4 if name in ALL_LAWS else 200.0).save(folder / "law.tbl")
    return law


def along(log, every=2):
    """Overlaps and displacements [m] at the rows of a log of SLID, and which rows count; the log has the distance along x."""
    kept = np.append(np.diff(log["Step"]) > 0, True)  # each run begins with the last line of the one before
    across = np.concatenate([[0.0], *[np.full(steps // every, speed * every * STEP) for _, speed, steps in SLID]]).cumsum()
    return DIAMETER - np.hypot(DIAMETER - log["overlap"][kept], across), across, kept


@pytest.mark.parametrize(("name", "shear"), PATHS)
@both
def test_force_along_a_path_is_pythons(engine, tmp_path, name, shear):
    """Where the contact has slid for 60 steps the force is the limit at its pressure; everywhere it is Python's."""
    law = save_law(tmp_path, name)
    log = simulate(engine, tmp_path, spheres(engine, f"shear {shear} {WORDS}", SLID, every=1, **ENERGY))
    overlap, across, kept = along(log, every=1)
    normal, pressure = law.follow(overlap), _pressure_along(law, overlap)
    # springs are divided by what the curve leaves to one
    curve = dl.Table.load(tmp_path / "law.tbl") if shear == "slip" else law
    path = dl.driver.sheared(curve, overlap, across, RATIO, shear, friction=FRICTION, springs=SPRINGS)
    found = path.force * across / DIAMETER - log["side"][kept]  # the normal turns
    limit = FRICTION.coefficient(pressure) * path.force
    below = 0.01 if shear == "slip" else 1e-4  # springs that are divided while the load falls are below the limit at first
    slides = np.convolve(np.abs(path.shear_force) > (1.0 - below) * limit, np.ones(60))[: len(limit)] > 59.5
    assert slides.sum() > 100 and np.ptp(limit[slides] / path.force[slides]) > 0.02
    np.testing.assert_allclose(np.abs(found[slides]), limit[slides], rtol=below + 1e-3)
    np.testing.assert_allclose(found, path.shear_force, atol=3e-3 * limit.max())
    assert log["e[2]"][-1] == pytest.approx(normal.dissipated[-1] + path.dissipated[-1], rel=2e-2)
    assert log["e[1]"][-1] + log["e[2]"][-1] == pytest.approx(normal.work[-1] + path.work[-1], rel=3e-3)


@pytest.mark.parametrize("shear", ["elastic", "slip"])
@both
def test_a_gas_closes_its_balance_and_goes_on_from_a_restart_file(engine, tmp_path, shear):
    """Contacts with walls, too; the numbers are in LAMMPS's restart file, in LIGGGHTS the line is repeated."""
    save_law(tmp_path, "rough")
    start, contacts, rest = gas(engine, 0.2, f"{shear} friction_pressure 0.6 2e-9")
    one = simulate(engine, tmp_path, start + contacts + rest + "run 12000\nwrite_restart half.rst\nrun 12000\n")
    total = one["ke"] + one["er"] + one["stored"] + one["lost"]
    np.testing.assert_allclose(total, total[0], rtol=2e-3)
    assert one["lost"][-1] > 0.05 * total[0]
    head, contacts = (HEADS[engine], contacts) if engine == "liggghts" else ("comm_modify vel yes\n", "")
    again = simulate(engine, tmp_path, f"{head}read_restart half.rst\n{contacts}{rest}run 12000\n")
    plain = simulate(engine, tmp_path, "".join(gas(engine, 0.2, shear)) + "run 24000\n")
    for name in ("ke", "er", "stored", "lost"):
        assert again[name][-1] == pytest.approx(one[name][-1], rel=1e-7), name
    assert abs(plain["lost"][-1] / one["lost"][-1] - 1.0) > 1e-2


@both
def test_a_mean_pressure_above_the_hardness_is_reported_once_and_counted(engine, tmp_path):
    """As Python does (`driver.sheared`); constant friction, or a table without a hardness, has no such limit."""
    said = {}
    for name, words, hardness in (("with", WORDS, 0.4e9), ("constant", "", 0.4e9), ("unknown", WORDS, None)):
        law = dl.law("hertz", ROUGH.with_values(sigma=0.0, hardness=hardness), "elastic")
        law.tabulate().save(tmp_path / "law.tbl")
        log = simulate(engine, tmp_path, spheres(engine, words, SLID, every=1, **ENERGY))
        said[name] = said_in(engine, tmp_path)
        if name == "with":
            expected = int(np.sum(_pressure_along(law, along(log, every=1)[0]) > hardness))
    text, where = "is above the hardness 4e+08 Pa: the friction law is not known there", "above the hardness in mean pressure"
    assert [said[name].count(text) for name in said] == [1, 0, 0]
    assert expected > 100 and sum(counts(said["with"], where)) == pytest.approx(expected, abs=10)
    assert where not in said["constant"] + said["unknown"]


WALL = """{head}boundary f f f
region box block -0.01 0.01 -0.01 0.01 -0.01 0.03 units box
create_box 1 box
create_atoms 1 single 0 0 8.7e-3 units box
set group all diameter 17.4e-3 density 2650
pair_style granular
pair_coeff * * {model}
fix floor all wall/gran granular {model} zplane 0 NULL
fix move all nve/noforce
compute f all reduce sum fx fy fz x y z
thermo_style custom step c_f[*]
thermo_modify format float %.17e norm no
thermo 2
timestep 5e-8
"""


@pytest.mark.parametrize("shear", ["elastic", "slip"])
@pytest.mark.parametrize("engine", ["lammps"])
def test_force_at_a_wall_is_pythons(engine, tmp_path, shear):
    """LIGGGHTS: liggghts/test_mesh.py."""
    law = dl.law("pohrt-popov", ROUGH.with_values(radius=8.7e-3), "hertz")
    law.tabulate(rtol=1e-6).save(tmp_path / "law.tbl")
    model = f"demlaws/table law.tbl 60.6e9 0 0.25 shear {shear} {WORDS} tangential demlaws 0 {MU0} damping velocity"
    moves = "".join(f"velocity all set {along} 0 {up}\nrun {steps}\n" for up, along, steps in SLID)
    log = simulate(engine, tmp_path, WALL.format(head=HEADS[engine], model=model) + moves)
    kept = np.append(np.diff(log["Step"]) > 0, True)
    overlap, along = 8.7e-3 - log["f[6]"][kept], log["f[4]"][kept]
    path = dl.driver.sheared(law, overlap, along, RATIO, shear, friction=FRICTION, springs=SPRINGS)
    constant = dl.driver.sheared(law, overlap, along, RATIO, shear, friction=MU0, springs=SPRINGS)
    largest = path.shear_force.max()
    np.testing.assert_allclose(-log["f[1]"][kept], path.shear_force, atol=(3e-2 if shear == "slip" else 3e-3) * largest)
    assert np.abs(path.shear_force - constant.shear_force).max() > 0.2 * largest


@pytest.mark.parametrize(
    ("words", "named"),
    [
        ("friction_pressure -0.1 1e-9", "negative"),
        ("friction_pressure 0.1 -1e-9", "negative"),
        ("friction_pressure 0.1 high", "'high'"),
        ("friction_pressure 0.1 nan", "nan"),
    ],
)
@both
def test_words_that_are_refused(engine, tmp_path, words, named):
    save_law(tmp_path, "rough")
    assert named in refused(engine, tmp_path, spheres(engine, words, SLID[:1]))


@both
def test_a_table_without_the_area_of_its_law_is_refused(engine, tmp_path):
    """The same table with constant friction, and one with the law's own rule, run."""
    smooth = ROUGH.with_values(sigma=0.0)
    for rule, words in (("elastic", WORDS), ("elastic", ""), ("etsion", WORDS)):
        dl.law("kogut-etsion", smooth, rule, yield_strength=0.3e9).tabulate(rtol=1e-4, max_force=2e3).save(tmp_path / "law.tbl")
        text = spheres(engine, words, SLID[:1])
        if rule == "elastic" and words:
            assert "'friction_pressure' needs the contact area of the law" in refused(engine, tmp_path, text)
        else:
            simulate(engine, tmp_path, text)


@both
def test_a_table_of_a_former_version_is_refused(engine, tmp_path):
    """Without the key `area`, which a law with an area of its own lacked, too."""
    save_law(tmp_path, "hertz elastic")
    lines = (tmp_path / "law.tbl").read_bytes().splitlines()[:-1]
    (tmp_path / "law.tbl").write_bytes(sealed([line for line in lines if line != b"area: known"]))
    simulate(engine, tmp_path, spheres(engine, "", SLID[:1]))
    assert "make a table of a former version again" in refused(engine, tmp_path, spheres(engine, WORDS, SLID[:1]))


@both
def test_another_tangential_model_is_refused(engine, tmp_path):
    save_law(tmp_path, "rough")
    text = spheres(engine, WORDS, SLID[:1])
    old, new = ("tangential demlaws 1.0 0.5", "tangential mindlin NULL 1.0 0.5")
    old, new = (old, new) if engine == "lammps" else ("tangential demlaws", "tangential history")
    assert old in text
    assert "'friction_pressure' needs  tangential demlaws" in refused(engine, tmp_path, text.replace(old, new))


@pytest.mark.parametrize(
    ("words", "named"),
    [
        ("friction_pressure 0.1", "needs C1 and C2"),
        ("pairfriction_pressure 1 2 0.1", "needs two types"),
        ("pairfriction_pressure 1 7 0.1 1e-9", "'pairfriction_pressure' names type 7"),
        ("pairfriction_pressure 1 2 0.1 1e-9 pairfriction_pressure 2 1 0.2 1e-9", "twice for these types"),
    ],
)
@pytest.mark.parametrize("engine", ["liggghts"])
def test_words_that_liggghts_refuses(engine, tmp_path, words, named):
    save_law(tmp_path, "rough")
    assert named in refused(engine, tmp_path, spheres(engine, words, SLID[:1]))


@pytest.mark.parametrize("engine", ["liggghts"])
def test_a_pair_of_types_has_its_own(engine, tmp_path):
    """The spheres are of types 1 and 2."""
    save_law(tmp_path, "rough")
    words = ("friction_pressure 0 0 pairfriction_pressure 2 1 0.4 3e-9", WORDS, f"{WORDS} pairfriction_pressure 1 1 0 0", "")
    logs = [simulate(engine, tmp_path, spheres(engine, one, SLID)) for one in words]
    for log in logs[:3]:
        np.testing.assert_array_equal(log["side"], logs[0]["side"])
    assert np.abs(logs[3]["side"] - logs[0]["side"]).max() > 0.05 * np.abs(logs[0]["side"]).max()


@pytest.mark.parametrize("engine", ["liggghts"])
def test_a_wall_takes_over_that_of_the_pair_style(engine, tmp_path):
    """As if its own line had it; the line's own word goes first."""
    save_law(tmp_path, "rough")
    words = "friction_pressure 0.6 2e-9"
    start, contacts, rest = gas(engine, 0.2, f"elastic {words}")
    assert rest.count(words) == 6
    walls = words, "", "friction_pressure 0 0"
    logs = [simulate(engine, tmp_path, start + contacts + rest.replace(words, one) + "run 12000\n") for one in walls]
    np.testing.assert_array_equal(logs[0]["lost"], logs[1]["lost"])
    assert abs(logs[2]["lost"][-1] / logs[0]["lost"][-1] - 1.0) > 1e-3


@pytest.mark.parametrize("engine", ["lammps"])
def test_types_with_another_one_are_not_mixed(engine, tmp_path):
    save_law(tmp_path, "rough")
    text = spheres(engine, WORDS, SLID[:1])
    line = next(line for line in text.splitlines() if line.startswith("pair_coeff"))
    model = line.split(maxsplit=3)[3]
    lines = f"pair_coeff 1 1 {model}\npair_coeff 2 2 {model.replace(WORDS, '')}"
    assert "'friction_pressure' to be mixed" in refused(engine, tmp_path, text.replace(line, lines))
