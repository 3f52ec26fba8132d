"""What LIGGGHTS and LAMMPS must not run with, as the engine's own error that names what is wrong."""

import inputs_for_lammps
import pytest
from inputs import modulus, refused, said_in, simulate
from inputs_for_liggghts import two_spheres
from spheres import ROUGH, both, save_law, spheres

import demlaws as dl

PRESS = [(-0.2, 0, 1000)]
GRAN = "model demlaws/table tangential history"
WALL = f"fix floor all wall/gran {GRAN} primitive type 1 zplane -0.01 "
SCENE = "model demlaws/table tangential demlaws"
TWICE, ORDER = "two tables", "wrong keyword order"
MODELS = "works with tangential off, no_history, history, demlaws"


@pytest.fixture
def folder(tmp_path):
    save_law(tmp_path, "rough")
    (tmp_path / "other.tbl").write_text((tmp_path / "law.tbl").read_text())
    return tmp_path


def of_liggghts(style, *changes, wall=""):
    text = two_spheres(f"pair_style gran {style}", PRESS, more=wall)
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    return text


@pytest.mark.parametrize(
    "style, named",
    [
        (GRAN, "table FILE"),
        (f"{GRAN} pairtable 1 1 law.tbl", "types 1 and 2"),
        (f"{GRAN} table law.tbl pairtable 1 3 law.tbl", "type 3"),
        (f"{GRAN} table law.tbl bogus on", "bogus"),
        (f"{GRAN} cohesion washino/capillary/viscous table law.tbl", MODELS),
        (f"{GRAN} rolling_friction epsd3 table law.tbl", MODELS),
        (f"{GRAN} surface multicontact table law.tbl", MODELS),
        ("model demlaws/table tangential tan_luding table law.tbl", MODELS),
        (f"{GRAN} table law.tbl table other.tbl", TWICE),
        (f"{GRAN} table law.tbl pairtable 1 2 law.tbl pairtable 2 1 other.tbl", TWICE),
        ("model demlaws/table table law.tbl tangential history", ORDER),
    ],
)
@pytest.mark.parametrize("engine", ["liggghts"])
def test_words_of_liggghts(engine, folder, style, named):
    assert named in refused(engine, folder, of_liggghts(style))


@pytest.mark.parametrize(
    "words, named",
    [
        (f"{WALL} table law.tbl table other.tbl", TWICE),
        (WALL.replace("primitive", "table law.tbl primitive"), ORDER),
    ],
)
@pytest.mark.parametrize("engine", ["liggghts"])
def test_words_of_a_wall_of_liggghts(engine, folder, words, named):
    assert named in refused(engine, folder, of_liggghts(f"{GRAN} table law.tbl", wall=words))


@pytest.mark.parametrize(
    "change, named",
    [
        (("units           si", "units lj"), "units lj"),
        (("1e-6 2e-6", "2.4 2e-6"), "did you mean µm"),
        (("2 0.5 0.5 0.5 0.5", "2 0.5 -0.5 -0.5 0.5"), "coefficientFriction"),
        (("create_atoms    2 single", "create_atoms    2 single 0.014 0 0 units box #"), "move them apart"),
    ],
)
@pytest.mark.parametrize("engine", ["liggghts"])
def test_scenes_of_liggghts(engine, folder, change, named):
    dl.law("hertz", ROUGH).tabulate(max_force=100.0).save(folder / "hertz.tbl")
    table = "hertz" if "apart" in named else "law"
    message = refused(engine, folder, of_liggghts(f"{SCENE} table {table}.tbl surfaceRoughness on", change))
    assert named in message and ("apart" not in named or "time step" not in message)


LAMMPS = f"demlaws/table law.tbl 60.6e9 1.0 0.25 {inputs_for_lammps.SHEAR}"
SLIP = "demlaws/table law.tbl 60.6e9 1.0 0.25 shear slip "


@pytest.mark.parametrize(
    "words, named",
    [
        ("demlaws/table law.tbl 60.6e9", "FILE E eta nu"),
        (LAMMPS.replace("60.6e9", "sixty"), "E is 'sixty'"),
        (LAMMPS.replace("60.6e9", "-60.6e9"), "Young's modulus must be positive"),
        (LAMMPS.replace("60.6e9", "60.6"), "did you mean GPa"),
        (LAMMPS.replace("0.25", "0.75", 1), "Poisson's ratio"),
        (LAMMPS.replace("1.0 0.25", "1.5 0.25"), "coefficient of restitution"),
        (LAMMPS.replace("1.0 0.25", "0.25 0.4"), "eta and nu are exchanged"),
        (LAMMPS.replace("1.0 0.25", "1.0 0.25 roughness 0"), "roughness must be positive"),
        (LAMMPS.replace("1.0 0.25", "1.0 0.25 roughness 2.4"), "did you mean µm"),
        (LAMMPS.replace("1.0 0.25", "1.0 0.25 against 1e9"), "against is"),
        (LAMMPS.replace("1.0 0.25", "1.0 0.25 extrapolation maybe"), "extrapolation is on or off, not maybe"),
        ("hertz/material 60.6e9 0.5 0.25 " + inputs_for_lammps.SHEAR, "demlaws/table only"),
        ("hertz/material 60.6e9 0 0.25 tangential demlaws 0 0.5 damping velocity", "demlaws/table only"),
        (SLIP + "tangential mindlin NULL 0 0.5 damping velocity", "'shear slip' needs  tangential demlaws"),
        (SLIP + "springs 7 tangential demlaws 0.0 0.5 damping velocity", "springs must be an even number from 2 to 30"),
        (SLIP + "tangential demlaws 0.0", "needs XT MU"),
        (SLIP + "tangential demlaws 0.0 high", "friction of tangential demlaws is 'high'"),
        (SLIP + "tangential demlaws 0.0 -1 damping velocity", "must not be negative"),
    ],
)
@pytest.mark.parametrize("engine", ["lammps"])
def test_words_of_lammps(engine, folder, words, named):
    assert named in refused(engine, folder, inputs_for_lammps.two_spheres(words, PRESS))


@pytest.mark.parametrize(
    "more, named",
    [
        ("compute e all demlaws/energy more", "compute demlaws/energy"),
        ("compute e right demlaws/energy", "compute demlaws/energy"),
        ("compute e all demlaws/energy\nthermo_style custom c_e[1]\nuncompute demlaws_pairs", "demlaws_pairs, was deleted"),
    ],
)
@pytest.mark.parametrize("engine", ["lammps"])
def test_energy_of_lammps(engine, folder, more, named):
    text = inputs_for_lammps.two_spheres(LAMMPS, PRESS)
    assert named in refused(engine, folder, text + f"{more}\nrun 10\n")


@pytest.mark.parametrize("engine", ["lammps"])
def test_units_of_lammps(engine, folder):
    text = inputs_for_lammps.two_spheres(LAMMPS, PRESS).replace("units           si", "units           lj")
    assert "metres" in refused(engine, folder, text)


@both
def test_shear_words(engine, folder):
    for word in ("secant", "tangent"):
        assert word in refused(engine, folder, spheres(engine, f"shear {word}", PRESS))


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
