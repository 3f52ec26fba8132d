"""The plugin inside LAMMPS: every law, walls, ranks, types, damping, energies, restart, and everything it must refuse."""

import math

import numpy as np
import pytest
from inputs_for_lammps import (
    HEAD,
    LOAD_UNLOAD,
    SHEAR,
    continued,
    error_of,
    modulus,
    refused,
    save,
    simulate,
    two_spheres,
)

import demlaws as dl
from demlaws.errors import DemlawsError
from demlaws.lammps.check import WALL, follow
from demlaws.make import example

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")

RULES = ("elastic", "hertz", "thornton", "table")
ENERGY = "compute e all demlaws/energy"
TABLE = f"demlaws/table law.tbl 60.6e9 1.0 0.25 {SHEAR}"


def same(log, path, limit):
    """Force, stored energy, dissipation, and what `compute pair/local` or the wall shows, against the law's path."""
    assert path.overlap.max() > 1e-5
    assert np.abs(log["force"] - path.force).max() <= limit * path.force.max()
    assert np.abs(log["stored"] - path.stored).max() <= limit * path.work.max()
    assert np.abs(log["lost"] - path.dissipated).max() <= limit * path.work.max()


@pytest.mark.parametrize(
    "unloading, ranks, newton",
    [
        *((rule, 1, newton) for rule in RULES for newton in ("on", "off")),
        ("hertz", 2, "on"),
        ("hertz", 2, "off"),
        ("table", 2, "on"),
    ],
)
def test_every_rule_on_one_and_two_ranks(granite_pair, unloading, ranks, newton):
    law = example("pohrt-popov", granite_pair, unloading)
    log, path = follow(law, rtol=1e-8, ranks=ranks, newton=newton, every=20)
    same(log, path, 1e-7)
    touching = log["overlap"] > 0
    if unloading != "elastic":  # p13, p14 of compute pair/local
        for column, expected in (("kept[1]", path.maximum_overlap), ("kept[2]", path.plastic_overlap)):
            assert np.abs(log[column] - expected)[touching].max() <= 1e-7 * path.overlap.max()
    assert np.abs(log["kept[3]"] - path.stored)[touching].max() <= 1e-7 * path.work.max()


@pytest.mark.parametrize("unloading", RULES)
@pytest.mark.parametrize("wall", ["plane", "region"])
def test_walls(granite_pair, unloading, wall):
    law = example("pohrt-popov", granite_pair, unloading)
    same(*follow(law, text=WALL, rtol=1e-8, wall=wall, every=20), limit=1e-7)


@pytest.mark.parametrize(
    "wall, caps, side, curved",
    [
        ("zcylinder", "", -1, True),
        ("region", "", -1, True),
        ("region", " open 1 open 2", -1, True),
        ("region", "", 1, True),
        ("region", " open 1 open 2", 1, False),
    ],
)
def test_radius_at_cylinders(tmp_path, wall, caps, side, curved):
    """1/R = 1/r - 1/(2 ρ) within a cylinder of radius ρ, 1/r + 1/(2 ρ) outside, 1/r outside of an open one: stock LAMMPS's."""
    radius, cylinder, overlap = 5e-3, 20e-3, 10e-6
    contact = dl.Contact(radius=radius, modulus=modulus())
    save(dl.law("hertz", contact), tmp_path / "law.tbl", rtol=1e-6)
    granular = "granular demlaws/table law.tbl 60.6e9 1.0 0.25 tangential demlaws 0 0"
    text = f"""{HEAD}boundary f f f
region box block -0.06 0.06 -0.06 0.06 -0.02 0.02 units box
create_box 1 box
create_atoms 1 single {cylinder + side * (radius - overlap)!r} 0 0 units box
set atom 1 diameter {2 * radius!r} density 2650
neighbor 1e-4 bin
pair_style granular
pair_coeff * * demlaws/table law.tbl 60.6e9 1.0 0.25 tangential demlaws 0 0
region drum cylinder z 0 0 {cylinder} -0.02 0.02 side {"in" if side < 0 else "out"} units box{caps}
fix wall all wall/gran{f"/region {granular} region drum" if wall == "region" else f" {granular} zcylinder {cylinder}"}
compute pull all reduce sum fx
thermo_style custom step c_pull
thermo_modify format float %.17e norm no
run 0
"""
    force = abs(simulate(tmp_path, text)["pull"][0])
    seen = (0.75 * force / contact.modulus) ** 2 / overlap**3
    assert seen == pytest.approx(1.0 / (1.0 / radius + curved * side / (2.0 * cylinder)), rel=1e-5)


def test_unequal_spheres_roughness_of_types_and_mixing(tmp_path):
    """One table; the pair of unlike types comes from mixing: σ² is the mean of the squares of the like pairs'."""
    material = dl.Material(young=60.6e9, poisson=0.25)
    any_contact = dl.Contact(radius=4e-3, modulus=32e9, roughness=1e-6, fractal_dimension=2.22)
    save(dl.law("pohrt-popov", any_contact, unloading="hertz"), tmp_path / "law.tbl", rtol=1e-8)
    lines = "".join(
        f"pair_coeff {i} {i} demlaws/table law.tbl 60.6e9 1.0 0.25 roughness {math.sqrt(2) * sq!r} {SHEAR}\n"
        for i, sq in ((1, 1e-6), (2, 2e-6))
    )
    log = simulate(tmp_path, two_spheres(lines, LOAD_UNLOAD, 10e-3, 17e-3))
    pair = dl.Contact.between(
        material, material, radius1=5e-3, radius2=8.5e-3, roughness1=1e-6, roughness2=2e-6, fractal_dimension=2.22
    )
    assert error_of(log, dl.law("pohrt-popov", pair, unloading="hertz")) <= 3e-8


def shear_modulus(young1, poisson1, young2, poisson2):
    """G* of two bodies as Mindlin has it: 1/G* = (2 - ν1)/G1 + (2 - ν2)/G2."""
    shear1, shear2 = young1 / (2 * (1 + poisson1)), young2 / (2 * (1 + poisson2))
    return 1 / ((2 - poisson1) / shear1 + (2 - poisson2) / shear2)


@pytest.mark.parametrize("way", ["mixed", "against"])
def test_unlike_materials(tmp_path, granite_pair, way):
    """Granite on steel by mixing and by `against`: normal force and Mindlin's tangential stiffness, 8 G* a, are the pair's."""
    granite, steel = (60.6e9, 0.25), (210e9, 0.3)
    pair = dl.Contact.between(dl.Material(*granite), dl.Material(*steel), radius1=8.7e-3, radius2=8.7e-3)
    contact = granite_pair.with_values(modulus=pair.modulus)
    law = dl.law("pohrt-popov", contact, unloading="hertz")
    save(law, tmp_path / "law.tbl", rtol=1e-8)
    lines = "".join(
        f"pair_coeff {i} {i} demlaws/table law.tbl {e} 1.0 {nu} {SHEAR}\n" for i, (e, nu) in ((1, granite), (2, steel))
    )
    if way == "against":
        lines += f"pair_coeff 1 2 demlaws/table law.tbl {granite[0]} 1.0 {granite[1]} against {steel[0]} {steel[1]} {SHEAR}\n"
    log = simulate(tmp_path, two_spheres(lines, [(-0.2, 0, 1000), (0.2, 0, 200), (0, 0.001, 20)]))
    assert error_of(log, law) <= 3e-8
    stiffness = law.follow(log["overlap"]).stiffness[-1]
    tangential = 4 * shear_modulus(*granite, *steel) / pair.modulus * stiffness  # 8 G* a with a = K / 2 E*
    assert log["side"][-1] == pytest.approx(-tangential * 1e-9, rel=1e-3)  # the normal turns with the slip


def test_the_tangent_stiffness_of_a_contact_is_shown(tmp_path, granite_pair):
    law = dl.law("pohrt-popov", granite_pair.with_values(modulus=modulus()), unloading="thornton")
    save(law, tmp_path / "law.tbl", rtol=1e-8)
    more = "compute c all pair/local p17 force cutoff radius\ncompute k all reduce sum c_c[1] c_c[2] inputs local"
    log = simulate(tmp_path, two_spheres(TABLE, LOAD_UNLOAD, more=more, columns="c_k[1] c_k[2]"))
    path = law.follow(log["overlap"])
    assert np.abs(log["k[1]"] - path.stiffness).max() <= 1e-6 * path.stiffness.max()
    assert np.abs(log["k[2]"] - path.force).max() <= 1e-7 * path.force.max()


# --- what must stop, with LAMMPS's own error


@pytest.fixture
def folder(tmp_path, granite_pair):
    save(dl.law("pohrt-popov", granite_pair.with_values(modulus=modulus()), unloading="hertz"), tmp_path / "law.tbl")
    return tmp_path


@pytest.mark.parametrize(
    "words, named",
    [
        (TABLE.replace("law.tbl", "nowhere.tbl"), r"nowhere.tbl"),
        ("demlaws/table law.tbl 60.6e9", "FILE E eta nu"),
        (TABLE.replace("60.6e9", "sixty"), "E is 'sixty'"),
        (TABLE.replace("60.6e9", "-60.6e9"), "Young's modulus must be positive"),
        (TABLE.replace("0.25", "0.75", 1), "Poisson's ratio"),
        (TABLE.replace("1.0 0.25", "1.0 0.25 roughness 0"), "roughness must be positive"),
        (TABLE.replace("1.0 0.25", "1.0 0.25 against 1e9"), "against is"),
        (TABLE.replace("1.0 0.25", "1.5 0.25"), "coefficient of restitution"),
        ("hertz/material 60.6e9 0.5 0.25 " + SHEAR, "demlaws/table only"),
    ],
)
def test_wrong_words_are_named(folder, words, named):
    assert named in refused(folder, two_spheres(words, LOAD_UNLOAD[:1]))


def test_units_other_than_metres(folder):
    text = two_spheres(TABLE, LOAD_UNLOAD[:1]).replace("units           si", "units           lj")
    assert "metres" in refused(folder, text)


def test_types_of_unlike_tables_are_not_mixed(folder, granite_pair):
    save(dl.law("hertz", granite_pair), folder / "hertz.tbl")
    lines = f"pair_coeff 1 1 {TABLE}\npair_coeff 2 2 {TABLE.replace('law.tbl', 'hertz.tbl')}\n"
    with pytest.raises(
        DemlawsError, match=r"cannot mix .* types 1 and 2.*law\.tbl and demlaws/table hertz\.tbl.*set explicitly"
    ):
        simulate(folder, two_spheres(lines, LOAD_UNLOAD[:1]))
    simulate(folder, two_spheres(lines + f"pair_coeff 1 2 {TABLE}\n", LOAD_UNLOAD[:1]))


def test_a_restart_with_another_table_of_the_same_name(folder, granite_pair):
    simulate(folder, two_spheres(TABLE, LOAD_UNLOAD[:1]) + "write_restart now.restart\n")
    simulate(folder, continued(LOAD_UNLOAD[1:2]))
    save(dl.law("hertz", granite_pair), folder / "law.tbl")
    assert "not the table that the restart file was written with" in refused(folder, continued(LOAD_UNLOAD[1:2]))


@pytest.mark.parametrize("words", ["all demlaws/energy more", "right demlaws/energy"])
def test_the_energy_takes_no_words_and_no_group(folder, words):
    assert "compute demlaws/energy" in refused(folder, two_spheres(TABLE, LOAD_UNLOAD[:1], more=f"compute e {words}"))
