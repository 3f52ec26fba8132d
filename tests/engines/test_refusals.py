"""What LIGGGHTS and LAMMPS must not run with, as the engine's own error that names what is wrong."""

import inputs_for_lammps
import pytest
from inputs import modulus, refused, said_in, simulate
from inputs_for_liggghts import two_spheres
from spheres import ROUGH, both, save_law, spheres

import demlaws as dl

pytestmark = pytest.mark.releases

PRESS = [(-0.2, 0, 1000)]
GRAN = "model demlaws/table tangential history"
WALL = f"fix floor all wall/gran {GRAN} primitive type 1 zplane -0.01 "
DEMLAWS = "model demlaws/table tangential demlaws surfaceRoughness on table"
HEAT = """\
fix heat all heat/gran initial_temperature 300. area_correction yes
fix t1 all property/global thermalConductivity peratomtype 5. 5.
fix t2 all property/global thermalCapacity peratomtype 10. 10.
fix t3 all property/global youngsModulusOriginal peratomtype 60.6e9 60.6e9
"""
TWICE, ORDER = "two tables", "wrong keyword order"
MODELS = "works with tangential off, no_history, history, demlaws"


@pytest.fixture
def folder(tmp_path):
    save_law(tmp_path, "rough")
    (tmp_path / "other.tbl").write_text((tmp_path / "law.tbl").read_text())
    dl.law("hertz", ROUGH).tabulate(max_force=100.0).save(tmp_path / "hertz.tbl")
    return tmp_path


LIGGGHTS = [  # pair style, line of a wall or (old, new) of the text, words of the message
    (GRAN, "", "table FILE"),
    (f"{GRAN} pairtable 1 1 law.tbl", "", "types 1 and 2"),
    (f"{GRAN} table law.tbl pairtable 1 3 law.tbl", "", "type 3"),
    (f"{GRAN} table law.tbl bogus on", "", "bogus"),
    (f"{GRAN} table law.tbl limitForce", "", "'limitForce' needs a value"),
    (f"{GRAN} table law.tbl radius_tolerance", "", "'radius_tolerance' needs a value"),
    ("model demlaws/table tangential", "", "'tangential' needs a value"),
    (f"{GRAN} table law.tbl", f"{WALL} limitForce", "'limitForce' needs a value"),
    (f"{GRAN} cohesion sjkr table law.tbl", "", MODELS),
    (f"{GRAN} rolling_friction epsd3 table law.tbl", "", MODELS),
    (f"{GRAN} surface multicontact table law.tbl", "", MODELS),
    ("model demlaws/table tangential tan_luding table law.tbl", "", MODELS),
    (f"{GRAN} table law.tbl table other.tbl", "", TWICE),
    (f"{GRAN} table law.tbl pairtable 1 2 law.tbl pairtable 2 1 other.tbl", "", TWICE),
    ("model demlaws/table table law.tbl tangential history", "", ORDER),
    (f"{GRAN} table law.tbl", f"{WALL} table law.tbl table other.tbl", TWICE),
    (f"{GRAN} table law.tbl", WALL.replace("primitive", "table law.tbl primitive"), ORDER),
    (f"{GRAN} table law.tbl", HEAT, "area_correction"),
    (f"{DEMLAWS} law.tbl", ("units           si", "units lj"), "units lj"),
    (f"{DEMLAWS} law.tbl", ("1e-6 2e-6", "2.4 2e-6"), "did you mean µm"),
    (f"{DEMLAWS} law.tbl", ("2 0.5 0.5 0.5 0.5", "2 0.5 -0.5 -0.5 0.5"), "coefficientFriction"),
    (f"{DEMLAWS} hertz.tbl", ("create_atoms    2 single", "create_atoms 2 single 0.014 0 0 units box #"), "move them apart"),
]


@pytest.mark.parametrize(("style", "change", "named"), LIGGGHTS)
@pytest.mark.parametrize("engine", ["liggghts"])
def test_liggghts(engine, folder, style, change, named):
    text = two_spheres(f"pair_style gran {style}", PRESS, more=change if isinstance(change, str) else "")
    if isinstance(change, tuple):
        assert change[0] in text
        text = text.replace(*change)
    message = refused(engine, folder, text)
    assert named in message and ("apart" not in named or "time step" not in message)


LAMMPS = f"demlaws/table law.tbl 60.6e9 1.0 0.25 {inputs_for_lammps.SHEAR}"
SLIP = "demlaws/table law.tbl 60.6e9 1.0 0.25 shear slip "


@pytest.mark.parametrize(
    "words, named",
    [
        ("demlaws/table law.tbl 60.6e9", "FILE E eta nu"),
        (LAMMPS.replace("60.6e9", "sixty"), "E is 'sixty'"),
        (LAMMPS.replace("60.6e9", "-60.6e9"), "E = -6.06e+10 Pa: Young's modulus must be positive"),
        (LAMMPS.replace("60.6e9", "60.6"), "did you mean GPa"),
        (LAMMPS.replace("0.25", "0.75", 1), "Poisson's ratio"),
        (LAMMPS.replace("1.0 0.25", "1.5 0.25"), "coefficient of restitution"),
        (LAMMPS.replace("1.0 0.25", "0.25 0.4"), "eta and nu are exchanged"),
        (LAMMPS.replace("1.0 0.25", "1.0 0.25 roughness 0"), "roughness 0 m: must be positive"),
        (LAMMPS.replace("1.0 0.25", "1.0 0.25 roughness 2.4"), "did you mean µm"),
        (LAMMPS.replace("1.0 0.25", "1.0 0.25 against 1e9"), "against is"),
        (LAMMPS.replace("1.0 0.25", "1.0 0.25 extrapolation maybe"), "extrapolation is on or off, not maybe"),
        ("hertz/material 60.6e9 0.5 0.25 " + inputs_for_lammps.SHEAR, "demlaws/table only"),
        ("hertz/material 60.6e9 0 0.25 tangential demlaws 0 0.5 damping velocity", "demlaws/table only"),
        (SLIP + "tangential mindlin NULL 0 0.5 damping velocity", "'shear slip' needs  tangential demlaws"),
        (
            "demlaws/table law.tbl 60.6e9 1.0 0.25 shear_ratio 0.3 tangential mindlin NULL 0 0.5",
            "'shear_ratio' needs  tangential",
        ),
        (SLIP + "springs 1 tangential demlaws 0.0 0.5 damping velocity", "springs = 1: a whole number from 2 to 22"),
        (SLIP + "tangential demlaws 0.0", "needs XT MU"),
        (LAMMPS.replace("demlaws 1.0 0.5", "demlaws 1e308 0.5"), "at most 1000"),
        (SLIP + "tangential demlaws 0.0 high", "friction of tangential demlaws is 'high'"),
        (SLIP + "tangential demlaws 0.0 -1 damping velocity", "must not be negative"),
        (f"{LAMMPS}\ncompute e all demlaws/energy more", "compute demlaws/energy"),
        (f"{LAMMPS}\nunits lj", "metres"),
    ],
)
@pytest.mark.parametrize("engine", ["lammps"])
def test_lammps(engine, folder, words, named):
    text = inputs_for_lammps.two_spheres(words.removesuffix("\nunits lj"), PRESS)
    if words.endswith("units lj"):
        text = text.replace("units           si", "units lj")
    assert named in refused(engine, folder, text)


@pytest.mark.parametrize(
    ("words", "more", "named"),
    [
        ("shear secant", "", "secant"),
        ("shear tangent", "", "tangent"),
        ("levels 0", "", "from 1 to 8"),
        ("levels 9", "", "from 1 to 8"),
        ("levels 2.5", "", "from 1 to 8"),
        ("shear slip levels 3", "", "springs, not levels"),
        ("shear_ratio 0", "", "at most 4/3"),
        ("shear_ratio -0.3", "", "-0.3"),
        ("shear_ratio 2", "", "at most 4/3"),
        ("", "compute e right demlaws/energy", "compute demlaws/energy"),  # of some contacts
    ],
)
@both
def test_words_of_both(engine, folder, words, more, named):
    assert named in refused(engine, folder, spheres(engine, words, PRESS, more=more))


@pytest.mark.parametrize("engine", ["lammps"])
def test_a_friction_of_degrees_is_reported(engine, folder):
    for friction, reported in (("0.5", False), ("60", True)):
        simulate(engine, folder, inputs_for_lammps.two_spheres(LAMMPS.replace("1.0 0.5", f"1.0 {friction}"), PRESS))
        assert ("friction MU = 60" in said_in(engine, folder)) == reported


@pytest.mark.parametrize("engine", ["lammps"])
def test_energy_without_its_list_of_pairs(engine, folder):
    more = "compute e all demlaws/energy\nthermo_style custom c_e[1]\nuncompute demlaws_pairs\nrun 10\n"
    assert "demlaws_pairs, was deleted" in refused(engine, folder, inputs_for_lammps.two_spheres(LAMMPS, PRESS) + more)


@both
def test_slip_where_unloading_has_no_springs(engine, tmp_path):
    law = dl.law("eepa", ROUGH.with_values(modulus=modulus()), "eepa", stiffness_ratio=5.0)
    law.tabulate(rtol=1e-5, max_force=1e3).save(tmp_path / "law.tbl")
    assert "'shear slip' needs unloading" in refused(engine, tmp_path, spheres(engine, "shear slip", PRESS))


@both
def test_a_wall_left_with_a_stock_model_is_reported(engine, folder):
    """Beside one with the law, about which nothing is printed."""
    if engine == "liggghts":
        line = "fix {} all wall/gran model {} tangential history primitive type 1 zplane -0.01\n"
        models = "hertz", "demlaws/table"
    else:
        line = "fix {} all wall/gran granular {} 60.6e9 1.0 0.25 tangential linear_nohistory 1.0 0.5 zplane -0.0086 NULL\n"
        models = "hertz/material", "demlaws/table law.tbl"
    walls = "".join(line.format(*names) for names in zip(("old", "new"), models, strict=True))
    simulate(engine, folder, spheres(engine, "", PRESS, more=walls))
    said = said_in(engine, folder)
    named = {"liggghts": "fix old wall/gran has a model of LIGGGHTS", "lammps": "wall/gran has the stock model hertz/material"}
    assert said.count(named[engine]) == said.count(named[engine].partition(" has ")[2].rpartition(" ")[0]) == 1


@both
def test_walls_with_the_law_beside_stock_pairs_are_reported(engine, folder):
    """The reverse: it was not."""
    if engine == "liggghts":
        line = "fix new all wall/gran model demlaws/table tangential history primitive type 1 zplane -0.01 table law.tbl\n"
        text = spheres(engine, "", PRESS, more=line).replace(
            "model demlaws/table tangential demlaws table law.tbl", "model hertz tangential history", 1
        )
    else:
        line = f"fix new all wall/gran granular {LAMMPS} zplane -0.0086 NULL\n"
        text = inputs_for_lammps.two_spheres(inputs_for_lammps.STOCK, PRESS, more=line)
    simulate(engine, folder, text)
    assert said_in(engine, folder).count("a fix wall/gran has demlaws/table") == 1
    simulate(engine, folder, spheres(engine, "", PRESS, more=line))
    assert "a fix wall/gran has demlaws/table" not in said_in(engine, folder)
