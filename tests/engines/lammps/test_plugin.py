"""The plugin inside LAMMPS: walls, types, columns, range, restart, shear."""

import re

import numpy as np
import pytest
from inputs import ENERGY, LOAD_UNLOAD, error_of, modulus, moves_of, said_in, save
from inputs_for_lammps import HEAD, SHEAR, TABLE, continued, refused, simulate, two_spheres
from spheres import ROUGH, SHEARED, save_law, sheared_along

import demlaws as dl
from demlaws.lammps.check import WALL, run_path

pytestmark = pytest.mark.releases


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


@pytest.mark.parametrize("wall", ["plane", "region"])
def test_large_overlaps_at_walls(tmp_path, wall):
    """LAMMPS takes the distance of a centre behind a wall as one before it, so that R is the most a wall can see."""
    law = dl.law("hertz", dl.Contact(radius=4e-3, modulus=modulus(60.6e5)))
    soft = WALL.replace("right set -0.2 0 0\nrun             1200", "right set -20 0 0\nrun 1000")
    log, _ = run_path(law, soft, folder=tmp_path, radius=4e-3, wall=wall, every=1)
    said = said_in("lammps", tmp_path)
    assert re.search(r"particle 2 and the wall: overlap 0\.00040\d* m is 0\.1 of the effective radius R = 0\.004 m", said)
    runs = [int(found) for found in re.findall(r"in this run (\d+) contact steps were deeper", said)]
    assert sum(runs) == pytest.approx(np.sum(log["overlap"] > 0.4e-3), abs=3)
    assert said.count("reported once") == 1


def test_extrapolation_through_restarts_and_mixing(tmp_path, granite_pair):
    dl.law("pohrt-popov", granite_pair.with_values(modulus=modulus())).tabulate(max_force=10.0).save(tmp_path / "law.tbl")
    on = TABLE.replace("0.25", "0.25 extrapolation on", 1)
    simulate(tmp_path, two_spheres(on, [(-0.2, 0, 1000)]) + "write_restart now.restart\n")
    simulate(tmp_path, continued([(-0.2, 0, 100)]))
    lines = f"pair_coeff 1 1 {on}\npair_coeff 2 2 {TABLE}\n"  # mixed: only where both have it
    assert "beyond the last row" in refused(tmp_path, two_spheres(lines, [(-0.2, 0, 1000)]))


# --- what must stop, with LAMMPS's own error


def test_types_of_unlike_tables_are_not_mixed(folder, granite_pair):
    save(dl.law("hertz", granite_pair), folder / "hertz.tbl")
    lines = f"pair_coeff 1 1 {TABLE}\npair_coeff 2 2 {TABLE.replace('law.tbl', 'hertz.tbl')}\n"
    message = refused(folder, two_spheres(lines, LOAD_UNLOAD[:1]))
    assert all(words in message for words in ("cannot be mixed", "law.tbl", "hertz.tbl"))
    simulate(folder, two_spheres(lines + f"pair_coeff 1 2 {TABLE}\n", LOAD_UNLOAD[:1]))


def test_a_restart_with_another_table_of_the_same_name(folder, granite_pair):
    simulate(folder, two_spheres(TABLE, LOAD_UNLOAD[:1]) + "write_restart now.restart\n")
    simulate(folder, continued(LOAD_UNLOAD[1:2]))
    save(dl.law("hertz", granite_pair), folder / "law.tbl")
    assert "not the table that the restart file was written with" in refused(folder, continued(LOAD_UNLOAD[1:2]))


# --- tangential model demlaws

TANGENTIAL = "tangential demlaws 0.0 0.5 damping velocity"


def terms(shear, tangential=TANGENTIAL):
    return f"demlaws/table law.tbl 60.6e9 0 0.25 shear {shear} {tangential}"


def test_an_energy_that_is_defined_later_begins_with_what_contacts_store(tmp_path):
    """Press and slide, define the compute, slide back and forth: before it only plastic flow and slip count from then on."""
    save_law(tmp_path, "hertz elastic")
    before, after = [(-0.2, 0, 600), (0, 0.02, 300)], [(0, 0.0, 20), (0, -0.02, 600)]
    late = "compute e all demlaws/energy\nthermo_style custom step v_force c_e[1] c_e[2]\n"
    late += "thermo_modify format float %.17e lost ignore norm no\n" + moves_of(after)
    whole = simulate(tmp_path, two_spheres(terms("slip"), before + after, **ENERGY))
    log = simulate(tmp_path, two_spheres(terms("slip"), before) + late)
    start = np.flatnonzero(np.isclose(whole["Step"], 900))[-1]
    assert log["e[1]"][0] == pytest.approx(whole["e[1]"][start], rel=1e-9)
    assert log["e[2]"][0] == pytest.approx(0.0, abs=1e-9 * log["e[1]"][0])
    assert log["e[2]"][-1] == pytest.approx(whole["e[2]"][-1] - whole["e[2]"][start], rel=1e-6)


@pytest.mark.parametrize("style", ["wall/gran", "wall/gran/region"])
@pytest.mark.parametrize("shear", ["elastic", "slip"])
def test_shear_at_walls(tmp_path, shear, style):
    """The sphere is pressed onto a plane where the other one's surface was, and slid."""
    law = dl.law("pohrt-popov", ROUGH.with_values(radius=8.7e-3), "hertz")
    save(law, tmp_path / "law.tbl", rtol=1e-6, max_force=3e4)
    place = "region ground" if "region" in style else "xplane 8.7e-3 NULL"
    lines = ["set atom 1 diameter 1e-3", "region ground plane 8.7e-3 0 0 1 0 0 units box", ENERGY["more"]]
    lines.append(f"fix wall all {style} granular {terms(shear)} {place}")
    text = two_spheres(terms(shear), SHEARED, every=2, more="\n".join(lines), columns=ENERGY["columns"])
    log = simulate(tmp_path, text)
    path, normal, _, kept = sheared_along(law, log, shear)
    np.testing.assert_allclose(-log["side"][kept], path.shear_force, atol=2e-2 * 0.5 * path.force.max())
    assert log["e[2]"][-1] == pytest.approx(normal.dissipated[-1] + path.dissipated[-1], rel=1e-2)
    assert log["e[1]"][-1] + log["e[2]"][-1] == pytest.approx(normal.work[-1] + path.work[-1], rel=3e-3)


@pytest.mark.parametrize(
    ("model", "warned"), [("mindlin", True), ("mindlin_rescale", True), ("mindlin_rescale/force", False), ("demlaws", False)]
)
def test_models_that_create_energy_are_warned_of(tmp_path, model, warned):
    save_law(tmp_path, "rough")
    stiffness = "" if model == "demlaws" else "NULL "
    simulate(tmp_path, two_spheres(terms("elastic", f"tangential {model} {stiffness}0 0.5 damping velocity"), SHEARED[:1]))
    text = (tmp_path / "log.lammps").read_text()
    assert (f"tangential {model} creates energy" in text) is warned
    assert text.count("use 'tangential demlaws XT MU'") == warned
