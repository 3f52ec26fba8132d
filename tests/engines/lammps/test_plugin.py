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
    moves_of,
    save,
    simulate,
    sphere_mass,
    two_spheres,
)

import demlaws as dl
from demlaws.errors import DemlawsError, EngineStopped
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
    "name, unloading, options",
    [
        ("hertz", "elastic", {}),
        ("rms", "hertz", {}),
        ("goddard", "hertz", {"slope": 0.035}),
        ("rough-plastic", "hertz", {"yield_pressure": 1.66e9}),
        ("rough-plastic", "thornton", {"yield_pressure": 1.66e9, "loading": "pohrt-popov"}),
        ("bahrami", "elastic", {}),
        pytest.param("yip-venart", "table", {}, marks=pytest.mark.slow),
        ("greenwood-tripp", "elastic", {}),
        ("conical-damage", "thornton", {"strength": 0.5e9}),
        pytest.param("luding", "linear", {"plasticity_depth": 2e-4}, marks=pytest.mark.slow),
        ("eepa", "eepa", {}),
        ("kogut-etsion", "etsion", {"yield_strength": 0.1e9}),
    ],
)
def test_force_and_energies_are_the_laws(granite_pair, name, unloading, options):
    same(*follow(example(name, granite_pair, unloading, **options), every=20), limit=1e-5)


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


@pytest.mark.parametrize("choice", ["elastic", "loading"])
def test_normal_stiffness_of_the_tangential_one(tmp_path, granite_pair, choice):
    """Press, slide by 1 nm; and after going back a little. With Mindlin's K_t = 8 G* a, a = K/2 E*."""
    law = dl.law("pohrt-popov", granite_pair.with_values(modulus=modulus()), unloading="hertz")
    save(law, tmp_path / "law.tbl", rtol=1e-8)
    words = TABLE.replace(" tangential", f" shear {choice} tangential")
    ratio = 2 * (1 - 0.25) / (2 - 0.25)
    for moves in ([(-0.2, 0, 1000)], [(-0.2, 0, 1000), (0.2, 0, 200)]):
        log = simulate(tmp_path, two_spheres(words, [*moves, (0, 0.001, 20)]))
        path = law.follow(log["overlap"])
        found = -log["side"][-1] / 1e-9 + path.force[-1] / 17.4e-3  # the normal turns with the slip
        expected = law.shear_stiffness([*log["overlap"], log["overlap"][-1] * (1 - 1e-9)], ratio, choice)[-2:]
        assert found == pytest.approx(expected[0], rel=2e-3)
        assert expected[1] == pytest.approx(expected[0], rel=1e-6)
    for word in ("secant", "tangent"):
        with pytest.raises(EngineStopped, match=f"shear is elastic, loading or slip, not {word}"):
            simulate(tmp_path, two_spheres(words.replace(choice, word), [(-0.2, 0, 10)]))


@pytest.mark.parametrize("restitution", [0.2, 0.8])
def test_tangent_damping(tmp_path, granite_pair, restitution):
    """The extra force at constant speed is 2 √(5/6) |β| √(K m) v, with our K; none at the first touch."""
    law = dl.law("pohrt-popov", granite_pair.with_values(modulus=modulus()), unloading="elastic")
    save(law, tmp_path / "law.tbl", rtol=1e-8)
    log = simulate(tmp_path, two_spheres(TABLE.replace(" 1.0 0.25", f" {restitution} 0.25"), [(-0.2, 0, 1000)], every=2))
    path = law.follow(log["overlap"])
    beta = math.log(restitution) / math.hypot(math.log(restitution), math.pi)
    damping = -2 * math.sqrt(5 / 6) * beta * np.sqrt(path.stiffness * sphere_mass(17.4e-3) / 2)
    expected = path.force + 0.2 * damping * (log["overlap"] > 0)
    assert np.abs(log["force"] - expected)[1:].max() <= 1e-6 * expected.max()
    touching = log["overlap"] > 0
    assert damping[touching][0] < 0.1 * damping.max()


def test_the_tangent_stiffness_of_a_contact_is_shown(tmp_path, granite_pair):
    law = dl.law("pohrt-popov", granite_pair.with_values(modulus=modulus()), unloading="thornton")
    save(law, tmp_path / "law.tbl", rtol=1e-8)
    more = "compute c all pair/local p17 force cutoff radius\ncompute k all reduce sum c_c[1] c_c[2] inputs local"
    log = simulate(tmp_path, two_spheres(TABLE, LOAD_UNLOAD, more=more, columns="c_k[1] c_k[2]"))
    path = law.follow(log["overlap"])
    assert np.abs(log["k[1]"] - path.stiffness).max() <= 1e-6 * path.stiffness.max()
    assert np.abs(log["k[2]"] - path.force).max() <= 1e-7 * path.force.max()


@pytest.mark.parametrize("ranks", [1, 2])
def test_a_restart_in_mid_unloading_goes_on_to_the_last_bit(tmp_path, granite_pair, ranks):
    """Force, history, energies, and what ended contacts had lost; on as many ranks and on one; pair_style not repeated."""
    law = dl.law("pohrt-popov", granite_pair.with_values(modulus=modulus()), unloading="hertz")
    save(law, tmp_path / "law.tbl", rtol=1e-8)
    watch = {"more": ENERGY, "columns": "c_e[1] c_e[2]"}
    first, second = [*LOAD_UNLOAD, (0.2, 0, 200)], [(-0.2, 0, 600), (0.2, 0, 1800)]
    text = two_spheres(TABLE, first, left=-0.0087, **watch) + "write_restart now.restart\n" + moves_of(second)
    whole = simulate(tmp_path, text, ranks)
    path = law.follow(whole["overlap"])
    assert np.abs(whole["e[2]"] - path.dissipated).max() <= 1e-7 * path.work.max()
    for later in {1, ranks}:
        rest = simulate(tmp_path, continued(second, **watch), later)
        rows = np.isin(whole["Step"], rest["Step"])
        assert rest["Step"].size == rows.sum() == 121
        assert rest["e[2]"][0] > 1.1 * law.follow(np.array([whole["overlap"][rows].max()])).dissipated[0]
        for column in ("force", "side", "e[1]", "e[2]"):
            scale = np.abs(whole[column]).max()
            assert np.abs(whole[column][rows] - rest[column]).max() <= 1e-14 * scale, column


def test_the_impact_of_the_python_driver(tmp_path):
    material = dl.Material(young=60.6e9, poisson=0.25)
    contact = dl.Contact.between(
        material, material, radius1=8e-3, radius2=8e-3, roughness1=1.7e-6, roughness2=1.7e-6, fractal_dimension=2.22
    )
    law = dl.law("pohrt-popov", contact, unloading="hertz")
    save(law, tmp_path / "law.tbl", rtol=1e-9)
    expected = dl.driver.impact(law, 0.5 * sphere_mass(16e-3), 0.2, 40000)
    text = two_spheres(
        TABLE, [], 16e-3, 16e-3, every=1, more='variable speed equal "vcm(right,x)-vcm(left,x)"', columns="v_speed"
    )
    text = text.replace("nve/noforce", "nve/sphere").replace("timestep        5e-8", "timestep        2.5e-9")
    log = simulate(tmp_path, text + "velocity left set 0.1 0 0\nvelocity right set -0.1 0 0\nrun 50000\n")
    assert log["force"].max() == pytest.approx(expected.peak_force, rel=1e-6)
    assert log["speed"][-1] == pytest.approx(expected.rebound_speed, rel=1e-6)


# --- what must stop, with LAMMPS's own error


def refused(folder, text, ranks=1):
    with pytest.raises(DemlawsError) as caught:
        simulate(folder, text, ranks)
    message = str(caught.value)
    assert "ERROR" in message and "demlaws" in message, message
    return message


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


def test_refusal_stops_every_rank(folder):
    assert "nowhere.tbl" in refused(folder, two_spheres(TABLE.replace("law.tbl", "nowhere.tbl"), LOAD_UNLOAD[:1]), 2)


def test_units_other_than_metres(folder):
    text = two_spheres(TABLE, LOAD_UNLOAD[:1]).replace("units           si", "units           lj")
    assert "metres" in refused(folder, text)


def test_bad_row_is_named_by_its_line(folder):
    lines = (folder / "law.tbl").read_text().splitlines(keepends=True)
    lines[40] = lines[40].replace(".", ",", 1)
    (folder / "law.tbl").write_text("".join(lines))
    assert "line 41" in refused(folder, two_spheres(TABLE, LOAD_UNLOAD[:1]))


def test_types_of_unlike_tables_are_not_mixed(folder, granite_pair):
    save(dl.law("hertz", granite_pair), folder / "hertz.tbl")
    lines = f"pair_coeff 1 1 {TABLE}\npair_coeff 2 2 {TABLE.replace('law.tbl', 'hertz.tbl')}\n"
    with pytest.raises(
        DemlawsError, match=r"cannot mix .* types 1 and 2.*law\.tbl and demlaws/table hertz\.tbl.*set explicitly"
    ):
        simulate(folder, two_spheres(lines, LOAD_UNLOAD[:1]))
    simulate(folder, two_spheres(lines + f"pair_coeff 1 2 {TABLE}\n", LOAD_UNLOAD[:1]))


def test_overlap_beyond_the_table_names_the_particles(tmp_path, granite_pair):
    save(dl.law("pohrt-popov", granite_pair), tmp_path / "law.tbl", max_force=10.0)
    message = refused(tmp_path, two_spheres(TABLE, LOAD_UNLOAD))
    assert "particles 1 and 2" in message or "particles 2 and 1" in message
    assert "law.tbl" in message and "beyond the last row" in message


def test_a_law_that_does_not_collapse_holds_for_its_radius_and_modulus(tmp_path, granite_pair):
    contact = granite_pair.with_values(modulus=modulus())
    law = dl.law("rough-plastic", contact, unloading="hertz", yield_pressure=1.66e9)
    save(law, tmp_path / "law.tbl")
    assert error_of(simulate(tmp_path, two_spheres(TABLE, LOAD_UNLOAD)), law) <= 1e-5
    message = refused(tmp_path, two_spheres(TABLE, LOAD_UNLOAD, 17e-3, 12e-3))
    assert "radius" in message and "does not collapse" in message
    wide = TABLE.replace("1.0 0.25", "1.0 0.25 radius_tolerance 0.5")
    simulate(tmp_path, two_spheres(wide, LOAD_UNLOAD, 17e-3, 12e-3))
    assert "effective modulus" in refused(tmp_path, two_spheres(TABLE.replace("60.6e9", "30e9"), LOAD_UNLOAD))
    rough = TABLE.replace("1.0 0.25", "1.0 0.25 roughness 1e-6")
    assert "its own roughness" in refused(tmp_path, two_spheres(rough, LOAD_UNLOAD))


def test_a_restart_with_another_table_of_the_same_name(folder, granite_pair):
    simulate(folder, two_spheres(TABLE, LOAD_UNLOAD[:1]) + "write_restart now.restart\n")
    simulate(folder, continued(LOAD_UNLOAD[1:2]))
    save(dl.law("hertz", granite_pair), folder / "law.tbl")
    assert "not the table that the restart file was written with" in refused(folder, continued(LOAD_UNLOAD[1:2]))


@pytest.mark.parametrize("words", ["all demlaws/energy more", "right demlaws/energy"])
def test_the_energy_takes_no_words_and_no_group(folder, words):
    assert "compute demlaws/energy" in refused(folder, two_spheres(TABLE, LOAD_UNLOAD[:1], more=f"compute e {words}"))
