"""The plugin inside LIGGGHTS: sub-models, columns, several tables, warnings."""

from pathlib import Path

import numpy as np
import pytest
from inputs import error_of, modulus, save
from inputs_for_liggghts import simulate, two_spheres

import demlaws as dl
from demlaws.make import example_law

pytestmark = pytest.mark.releases

LOAD_UNLOAD = [(-0.2, 0, 5000), (0.2, 0, 3000), (-0.2, 0, 4000), (0.2, 0, 9000), (-0.2, 0, 4000)]
GRAN = "pair_style gran model demlaws/table tangential history "


def test_tables_of_pairs(folder, law, granite_pair):
    save(dl.law("hertz", granite_pair), folder / "hertz.tbl")
    text = two_spheres(GRAN + "table hertz.tbl pairtable 2 1 law.tbl pairtable 1 2 law.tbl", LOAD_UNLOAD)
    assert error_of(simulate(folder, text), law) <= 3e-8


@pytest.mark.parametrize(
    "tangential, rolling",
    [("off", "off"), ("off", "epsd2"), ("no_history", "cdt"), *(("history", r) for r in ("off", "cdt", "epsd", "epsd2"))],
)
def test_sub_models_leave_the_normal_force_alone(folder, law, tangential, rolling):
    style = f"pair_style gran model demlaws/table tangential {tangential} rolling_friction {rolling} table law.tbl"
    assert error_of(simulate(folder, two_spheres(style, LOAD_UNLOAD, every=100)), law) <= 3e-8


def test_limit_force(folder):
    """With strong damping a contact that opens pulls, unless limitForce is on."""
    force = {}
    for limit in ("off", "on"):
        style = GRAN + f"table law.tbl limitForce {limit}"
        force[limit] = simulate(folder, two_spheres(style, LOAD_UNLOAD[:2], restitution=0.06))["force"]
    assert force["off"].min() < 0
    assert np.array_equal(force["on"], np.maximum(force["off"], 0))


@pytest.mark.parametrize(
    "tangential, rolling, first, unloading",
    [
        ("off", "off", 1, "hertz"),
        ("history", "off", 4, "thornton"),
        ("history", "epsd2", 7, "thornton"),
        ("no_history", "epsd", 4, "thornton"),
    ],
)
def test_columns_of_the_history(tmp_path, granite_pair, tangential, rolling, first, unloading):
    """compute pair/gran/local history: the tangential model's values, the rolling model's, then ours; see docs/liggghts.md."""
    law = example_law("rough-plastic", granite_pair.with_values(modulus=modulus()), unloading)
    table = save(law, tmp_path / "law.tbl")
    style = f"pair_style gran model demlaws/table tangential {tangential} rolling_friction {rolling} table {table}"
    text = two_spheres(style, LOAD_UNLOAD[:2], every=100)
    count = first + law.state_size + 1  # the mark of the law, and behind the history the overlap
    columns = " ".join(f"c_contacts[{n}]" for n in range(first, count + 1))
    text = text.replace("thermo_style ", "compute contacts all pair/gran/local history delta\nthermo_style ", 1)
    text += f"dump d all local 1 contacts.txt {columns}\nrun 0\n"
    log = simulate(tmp_path, text)
    row = np.loadtxt(tmp_path / "contacts.txt", skiprows=9, max_rows=1)
    state = law.new_state(1)
    law.follow(log["overlap"], state)
    kept = [state.maximum_overlap[0], state.plastic_overlap[0]]
    if unloading == "thornton":
        kept.append(row[2])
        assert row[2] >= 1.0
    assert row[:-2] == pytest.approx(kept, rel=1e-4) and row[-2] >= 1.0
    assert row[-1] == pytest.approx(log["overlap"][-1], rel=1e-4)


def test_rolling_comes_before_the_shear_of_demlaws_in_the_history(tmp_path, granite_pair):
    """The torque of rolling, 0 in a straight impact, then the bounds of K_t: docs/reference/liggghts.md."""
    table = save(example_law("pohrt-popov", granite_pair.with_values(modulus=modulus()), "hertz"), tmp_path / "law.tbl")
    style = f"pair_style gran model demlaws/table tangential demlaws rolling_friction epsd2 table {table}"
    text = two_spheres(style, LOAD_UNLOAD[:1], every=100)
    text = text.replace("thermo_style ", "compute contacts all pair/gran/local history\nthermo_style ", 1)
    columns = " ".join(f"c_contacts[{n}]" for n in range(1, 19))
    simulate(tmp_path, text + f"dump d all local 1 contacts.txt {columns}\nrun 0\n")
    row = np.loadtxt(tmp_path / "contacts.txt", skiprows=9, max_rows=1)
    assert np.all(row[:3] == 0) and row[3] > 1e3 and np.linalg.norm(row[12:15]) == pytest.approx(1, abs=1e-4)
    assert 0 < row[16] < row[15] < 1e-4 and row[17] >= 1


@pytest.mark.parametrize("unloading", ["elastic", "hertz", "thornton"])
@pytest.mark.parametrize("way", [1, -1])
def test_a_slow_sphere_crosses_the_edge_of_a_mesh(tmp_path, unloading, way):
    """Within 1e-8 m of an edge both triangles claim the sphere: one force all the same, in both directions."""
    walls = Path(__file__).parents[3] / "liggghts_inputs" / "walls"
    law = dl.law("pohrt-popov", dl.Contact(6.05e-3, modulus(), 2.4e-6, 2.22), unloading=unloading)
    law.tabulate(rtol=1e-8).save(tmp_path / "granite.tbl")
    for name in ("mesh.inc", "plate.stl"):
        (tmp_path / name).write_text((walls / name).read_text())
    text = (walls / "in.walls").read_text().split("velocity        all set 0 0 -0.2")[0]
    text = text.replace("${wall}", "mesh").replace("${every}", "10").replace("single 0.000507", f"single {-2.03e-8 * way}")
    text += "velocity all set 0 0 -0.2\nrun 4000\nvelocity all set 0 0 0.2\nrun 1000\n"
    text += f"velocity all set {0.01 * way} 0 0\nrun 400\nvelocity all set {-0.01 * way} 0 0\nrun 200\n"
    # deeper than ever while both claim it, and out on the first triangle
    text += f"velocity all set 0 0 -0.2\nrun 2000\nvelocity all set {-0.01 * way} 0 0\nrun 200\n"
    text += "velocity all set 0 0 0.2\nrun 2000\n"
    log = simulate(tmp_path, text)
    path = law.follow(log["overlap"])
    assert np.abs(log["force"] - path.force).max() <= 3e-8 * path.force.max()
    assert np.abs(log["stored"] - path.stored).max() <= 1e-7 * path.work.max()
    assert np.abs(log["lost"] - path.dissipated).max() <= 1e-7 * path.work.max()


# --- warnings


PRESS = [(-0.2, 0, 3000), (0.2, 0, 1500)]


@pytest.mark.parametrize(
    ("roughness", "young", "named"),
    [
        ("6e-4 2e-6", 60.6e9, "0.138 times the radius 0.00435 m, above 0.1"),
        ("1e-6 2e-6", 60.6e11, "100 times the effective modulus of law.tbl"),  # LIGGGHTS itself refuses those below 5e6 Pa
    ],
)
def test_a_value_far_from_those_of_the_table_is_reported_once(folder, roughness, young, named):
    text = two_spheres(GRAN + "table law.tbl surfaceRoughness on", PRESS, every=1, young=young)
    simulate(folder, text.replace("1e-6 2e-6", roughness))
    said = (folder / "log.liggghts").read_text()
    assert said.count(named) == 1
    assert ("contact steps were rougher than a tenth of R" in said) == (young == 60.6e9)


def test_a_type_that_no_particle_has(folder):
    """The matrix of friction ends at the largest type of particles and walls; it was read up to that of the box."""
    text = two_spheres("pair_style gran model demlaws/table tangential demlaws table law.tbl", PRESS)
    log = simulate(folder, text.replace("create_atoms    2 single", "create_atoms    1 single"))
    assert log["Step"][-1] == 4500
