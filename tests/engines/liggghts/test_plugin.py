"""The plugin inside LIGGGHTS: every law, sub-models, damping, energies, several tables, and everything it must refuse."""

import math
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest
from inputs_for_liggghts import modulus, sphere_mass, two_spheres

import demlaws as dl
from demlaws.curves import text as table_file
from demlaws.errors import DemlawsError
from demlaws.liggghts import run
from demlaws.liggghts.build import PLUGIN
from demlaws.liggghts.check import follow
from demlaws.make import example

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")

LOAD_UNLOAD = [(-0.2, 0, 5000), (0.2, 0, 3000), (-0.2, 0, 4000), (0.2, 0, 9000), (-0.2, 0, 4000)]
GRAN = "pair_style gran model demlaws/table tangential history "


def save(law, path, **options):
    law.tabulate(**options).save(path)
    return path.name


def simulate(folder, text, ranks=1):
    (folder / "in.case").write_text(text)
    return run(folder / "in.case", ranks)


def error_of(log, law):
    expected = law.follow(log["overlap"]).force
    return np.abs(log["force"] - expected).max() / expected.max()


def test_the_history_has_the_names_of_the_rules_states():
    """The plugin's names of a contact's values, in their order, against the record of each rule that C++ has."""
    source = (PLUGIN.sources / "normal_model_demlaws.h").read_text()
    names = re.findall(r'"demlaws_(\w+)"', source.split("STATE_NAMES[MOST_STATE]")[1].split(";")[0])
    most = int(re.search(r"MOST_STATE = (\d+)", source)[1])
    rules = [rule for rule in table_file.rules().values() if rule.number is not None]
    for rule in rules:
        camel = [re.sub(r"_(\w)", lambda found: found[1].upper(), name) for name in rule.state]
        assert camel == names[: len(camel)], rule.name
    assert most == len(names) == max(len(rule.state) for rule in rules)


@pytest.mark.parametrize(
    "name, unloading, options",
    [
        ("hertz", "elastic", {}),
        ("rms", "hertz", {}),
        ("pohrt-popov", "thornton", {}),
        ("goddard", "hertz", {"slope": 0.035}),
        ("rough-plastic", "hertz", {"yield_pressure": 1.66e9}),
        ("rough-plastic", "thornton", {"yield_pressure": 1.66e9, "loading": "pohrt-popov"}),
        ("bahrami", "elastic", {}),
        ("yip-venart", "elastic", {}),
        ("greenwood-tripp", "elastic", {}),
        ("pohrt-popov", "table", {}),
        pytest.param("yip-venart", "table", {}, marks=pytest.mark.slow),
        ("conical-damage", "thornton", {"strength": 0.5e9}),
        ("walton-braun", "linear", {}),
        ("eepa", "eepa", {}),
        ("jackson-green", "etsion", {"yield_strength": 0.1e9}),
    ],
)
def test_force_is_the_laws(granite_pair, name, unloading, options):
    law = example(name, granite_pair, unloading, **options)
    log, path = follow(law)
    assert path.overlap.max() > 1e-5
    assert np.abs(log["force"] - path.force).max() <= 1e-5 * path.force.max()


def test_unequal_spheres_and_sigma_by_type(tmp_path):
    """One table, σ from property/global surfaceRoughness."""
    material = dl.Material(young=60.6e9, poisson=0.25)
    any_contact = dl.Contact(radius=4e-3, modulus=32e9, roughness=1e-6, fractal_dimension=2.22)
    table = save(dl.law("pohrt-popov", any_contact, unloading="hertz"), tmp_path / "any.tbl", rtol=1e-8)
    log = simulate(tmp_path, two_spheres(GRAN + f"table {table} surfaceRoughness on", LOAD_UNLOAD, 10e-3, 17e-3))
    pair = dl.Contact.between(
        material, material, radius1=5e-3, radius2=8.5e-3, roughness1=1e-6, roughness2=2e-6, fractal_dimension=2.22
    )
    assert error_of(log, dl.law("pohrt-popov", pair, unloading="hertz")) <= 3e-8


def test_tables_of_pairs(tmp_path, granite_pair):
    law = dl.law("pohrt-popov", granite_pair, unloading="hertz")
    save(dl.law("hertz", granite_pair), tmp_path / "hertz.tbl")
    save(law, tmp_path / "rough.tbl", rtol=1e-8)
    log = simulate(tmp_path, two_spheres(GRAN + "table hertz.tbl pairtable 2 1 rough.tbl", LOAD_UNLOAD))
    contact = granite_pair.with_values(modulus=modulus())
    assert error_of(log, dl.law("pohrt-popov", contact, unloading="hertz")) <= 3e-8


@pytest.mark.parametrize("tangential", ["off", "no_history", "history"])
@pytest.mark.parametrize("rolling", ["off", "cdt", "epsd", "epsd2"])
def test_sub_models_leave_the_normal_force_alone(tmp_path, granite_pair, tangential, rolling):
    contact = granite_pair.with_values(modulus=modulus())
    law = dl.law("pohrt-popov", contact, unloading="hertz")
    table = save(law, tmp_path / "law.tbl", rtol=1e-8)
    style = f"pair_style gran model demlaws/table tangential {tangential} rolling_friction {rolling} table {table}"
    log = simulate(tmp_path, two_spheres(style, LOAD_UNLOAD, every=100))
    assert error_of(log, law) <= 3e-8


def test_tangential_stiffness_follows_the_normal_tangent(tmp_path, granite_pair):
    """Press, then slide by 1 nm: the shear force is (4 G*/E*) K times the slip, K of the branch the contact is on."""
    contact = granite_pair.with_values(modulus=modulus())
    law = dl.law("pohrt-popov", contact, unloading="hertz")
    table = save(law, tmp_path / "law.tbl", rtol=1e-8)
    moves = [(-0.2, 0, 5000), (0.2, 0, 1000), (0, 0.001, 100)]
    log = simulate(tmp_path, two_spheres(GRAN + f"table {table}", moves, every=100))
    stiffness = law.follow(log["overlap"]).stiffness[-1]
    shear = 60.6e9 / (2 * (1 + 0.25)) / (2 * (2 - 0.25))  # effective G* of two like bodies, as LIGGGHTS has it
    assert log["side"][-1] == pytest.approx(
        -4 * shear / modulus() * stiffness * 1e-9, rel=1e-3
    )  # the normal turns with the slip


@pytest.mark.parametrize("moves", [[(-0.2, 0, 5000)], [(-0.2, 0, 5000), (0.2, 0, 1000)]], ids=["loading", "unloading"])
@pytest.mark.parametrize("choice", ["elastic", "loading"])
def test_normal_stiffness_of_the_tangential_one(tmp_path, granite_pair, choice, moves):
    """Press, back or not, then slide by 1 nm."""
    law = dl.law("pohrt-popov", granite_pair.with_values(modulus=modulus()), unloading="hertz")
    table = save(law, tmp_path / "law.tbl", rtol=1e-8)
    log = simulate(tmp_path, two_spheres(GRAN + f"table {table} shear {choice}", [*moves, (0, 0.001, 100)], every=100))
    ratio = 2 * (1 - 0.25) / (2 - 0.25)
    path = law.follow(log["overlap"])
    expected = law.shear_stiffness(log["overlap"], ratio, choice)[-1]
    turned = path.force[-1] / 17.4e-3  # the normal turns with the slip
    assert -log["side"][-1] / 1e-9 == pytest.approx(expected - turned, rel=2e-3)
    if len(moves) == 1:
        assert abs(expected / (ratio * path.stiffness[-2]) - 1) > 0.05 or choice == "loading"


@pytest.mark.parametrize("word", ["secant", "tangent"])
def test_shear_is_one_of_three(tmp_path, granite_pair, word):
    save(dl.law("hertz", granite_pair), tmp_path / "law.tbl")
    message = refused(tmp_path, two_spheres(GRAN + f"table law.tbl shear {word}", LOAD_UNLOAD))
    assert f"'shear' must be elastic, loading or slip, got '{word}'" in message


@pytest.mark.parametrize("restitution", [0.2, 0.8])
def test_viscous_damping(tmp_path, granite_pair, restitution):
    """The extra force at constant speed is 2 √(5/6) |β| √(K m) v, with our K; none at the first touch."""
    contact = granite_pair.with_values(modulus=modulus())
    law = dl.law("pohrt-popov", contact, unloading="elastic")
    table = save(law, tmp_path / "law.tbl", rtol=1e-8)
    log = simulate(tmp_path, two_spheres(GRAN + f"table {table}", [(-0.2, 0, 5000)], restitution=restitution, every=10))
    path = law.follow(log["overlap"])
    beta = math.log(restitution) / math.hypot(math.log(restitution), math.pi)
    damping = -2 * math.sqrt(5 / 6) * beta * np.sqrt(path.stiffness * sphere_mass(17.4e-3) / 2)
    expected = path.force + 0.2 * damping * (log["overlap"] > 0)
    assert np.abs(log["force"] - expected)[1:].max() <= 1e-6 * expected.max()
    assert np.all(log["force"][log["overlap"] <= 0][1:] == 0)
    touching = log["overlap"] > 0
    assert damping[touching][0] < 0.1 * damping.max()


def test_limit_force(tmp_path, granite_pair):
    """With strong damping a contact that opens pulls, unless limitForce is on."""
    law = dl.law("pohrt-popov", granite_pair, unloading="hertz")
    table = save(law, tmp_path / "law.tbl")
    force = {}
    for limit in ("off", "on"):
        style = GRAN + f"table {table} limitForce {limit}"
        force[limit] = simulate(tmp_path, two_spheres(style, LOAD_UNLOAD[:2], restitution=0.06))["force"]
    assert force["off"].min() < 0
    assert np.array_equal(force["on"], np.maximum(force["off"], 0))


def test_walls_take_the_tables_of_the_pair_style(tmp_path, granite_pair):
    law = dl.law("pohrt-popov", granite_pair.with_values(modulus=modulus(), radius=8.7e-3), unloading="hertz")
    table = save(law, tmp_path / "law.tbl", rtol=1e-8)
    text = two_spheres(GRAN + f"table {table}", [(0, 0, 10)], every=10)
    wall = "fix floor all wall/gran model demlaws/table tangential history primitive type 1 xplane -0.0087\n"
    text = text.replace("variable        overlap", wall + "variable        overlap")
    text = text.replace("-(xcm(right,x)-xcm(left,x))", "+0*xcm(left,x)").replace(
        "compute         pull right", "compute         pull left"
    )
    text = text.replace('"0.5*(0.0174+0.0174)+0*xcm(left,x)"', '"-xcm(left,x)"')
    text += "velocity left set -0.2 0 0\nrun 5000\nvelocity left set 0.2 0 0\nrun 2000\n"
    log = simulate(tmp_path, text)
    assert log["overlap"].max() > 9e-6
    assert error_of(log, law) <= 3e-8


@pytest.mark.parametrize(
    "tangential, rolling, first", [("off", "off", 1), ("history", "off", 4), ("history", "epsd2", 7), ("no_history", "epsd", 4)]
)
@pytest.mark.parametrize("unloading", ["hertz", "thornton"])
def test_columns_of_the_history(tmp_path, granite_pair, tangential, rolling, first, unloading):
    """compute pair/gran/local history: the tangential model's values, the rolling model's, then ours; see docs/liggghts.md."""
    law = example("rough-plastic", granite_pair.with_values(modulus=modulus()), unloading)
    table = save(law, tmp_path / "law.tbl")
    style = f"pair_style gran model demlaws/table tangential {tangential} rolling_friction {rolling} table {table}"
    text = two_spheres(style, LOAD_UNLOAD[:2], every=100)
    count = first + law.state_size  # the overlap stands behind the history
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
    assert row[:-1] == pytest.approx(kept, rel=1e-4)
    assert row[-1] == pytest.approx(log["overlap"][-1], rel=1e-4)


def test_energies_across_ranks(tmp_path, granite_pair):
    """compute demlaws/energy of a pair that lies on the border of two ranks."""
    law = dl.law("pohrt-popov", granite_pair.with_values(modulus=modulus()), unloading="hertz")
    table = save(law, tmp_path / "law.tbl", rtol=1e-8)
    text = two_spheres(GRAN + f"table {table}", LOAD_UNLOAD, every=100)
    text = text.replace("create_atoms    1 single 0 0 0", "create_atoms    1 single -0.0087 0 0")
    text = text.replace("single 0.0174001 0 0", "single 0.0087001 0 0").replace("neighbor ", "processors 2 1 1\nneighbor ", 1)
    text = text.replace("region          box", "processors      2 1 1\nregion          box").replace(
        "processors 2 1 1\nneighbor", "neighbor"
    )
    more = "compute e all demlaws/energy\nvariable stored equal c_e[1]\nvariable lost equal c_e[2]\n"
    more += "thermo_style custom step v_overlap v_force v_stored v_lost"
    log = simulate(tmp_path, text.replace("thermo_style    custom step v_overlap v_force v_side", more), ranks=2)
    path = law.follow(log["overlap"])
    assert np.abs(log["force"] - path.force).max() <= 3e-8 * path.force.max()
    assert np.abs(log["stored"] - path.stored).max() <= 1e-7 * path.work.max()
    assert np.abs(log["lost"] - path.dissipated).max() <= 1e-7 * path.work.max()


@pytest.mark.parametrize("unloading", ["elastic", "hertz"])
@pytest.mark.parametrize("way", [1, -1])
def test_a_slow_sphere_crosses_the_edge_of_a_mesh(tmp_path, unloading, way):
    """Within 1e-8 m of an edge both triangles claim the sphere: one force all the same, in both directions."""
    walls = Path(__file__).parents[3] / "liggghts_inputs" / "walls"
    law = dl.law("pohrt-popov", dl.Contact(6.05e-3, modulus(), 2.4e-6, 2.22), unloading=unloading)
    law.tabulate(rtol=1e-8).save(tmp_path / "granite.tbl")
    for name in ("mesh.inc", "plate.stl"):
        (tmp_path / name).write_text((walls / name).read_text())
    text = (walls / "in.walls").read_text().split("velocity        all set 0 0 -0.2")[0]
    text = text.replace("${wall}", "mesh.inc").replace("${every}", "10").replace("single 0.000507", f"single {-2.03e-8 * way}")
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


@pytest.mark.parametrize("ranks", [1, 2])
def test_dissipation_of_ended_contacts_comes_back_after_a_restart(tmp_path, granite_pair, ranks):
    """A pair loads, parts, and a restart file is written; a new process, on as many ranks or on one, goes on."""
    law = dl.law("pohrt-popov", granite_pair.with_values(modulus=modulus()), unloading="hertz")
    table = save(law, tmp_path / "law.tbl", rtol=1e-8)
    more = "compute e all demlaws/energy\nvariable stored equal c_e[1]\nvariable lost equal c_e[2]\n"
    more += "thermo_style custom step v_overlap v_stored v_lost"
    text = two_spheres(GRAN + f"table {table}", [], every=100)
    text = text.replace("thermo_style    custom step v_overlap v_force v_side", more)
    head, tail = text.split("region          box", 1)
    after = "\n".join(line for line in tail.splitlines()[1:] if not line.startswith(("create_", "set ")))
    part, again = "run 5000\nvelocity right set 0.2 0 0\nrun 9000\n", "velocity right set -0.2 0 0\n"
    first = text + again + part + "write_restart parted.restart\n" + again + part
    first = first.replace("region          box", f"processors {ranks} 1 1\nregion          box")
    whole = simulate(tmp_path, first, ranks)
    path = law.follow(whole["overlap"])
    assert np.abs(whole["lost"] - path.dissipated).max() <= 1e-7 * path.work.max()
    for later in {1, ranks}:
        second = simulate(tmp_path, f"{head}processors {later} 1 1\nread_restart parted.restart\n{after}\n{again}{part}", later)
        same = np.isin(whole["Step"], second["Step"])
        assert second["Step"].size == same.sum() == 141
        assert second["lost"][0] > 0.4 * path.dissipated[-1]  # the first contact's
        for name in ("stored", "lost"):
            assert np.abs(whole[name][same] - second[name]).max() <= 1e-12 * path.work.max()


def test_the_impact_of_the_python_driver(tmp_path):
    """Head-on impact: peak force and rebound as dl.driver.impact has them."""
    material = dl.Material(young=60.6e9, poisson=0.25)
    contact = dl.Contact.between(
        material, material, radius1=8e-3, radius2=8e-3, roughness1=1.7e-6, roughness2=1.7e-6, fractal_dimension=2.22
    )
    law = dl.law("pohrt-popov", contact, unloading="hertz")
    table = save(law, tmp_path / "law.tbl", rtol=1e-9)
    from demlaws import driver

    expected = driver.impact(law, 0.5 * sphere_mass(16e-3), 0.2, 40000)
    text = two_spheres(GRAN + f"table {table} tangential_damping off", [], 16e-3, 16e-3, every=1)
    text = text.replace("nve/noforce", "nve/sphere").replace("timestep        1e-8", "timestep        2.5e-9")
    text = text.replace("v_side", "v_speed").replace(
        "variable        side equal c_side", 'variable speed equal "vcm(right,x)-vcm(left,x)"'
    )
    text += "velocity left set 0.1 0 0\nvelocity right set -0.1 0 0\nrun 50000\n"
    log = simulate(tmp_path, text)
    assert log["force"].max() == pytest.approx(expected.peak_force, rel=1e-6)
    assert log["speed"][-1] == pytest.approx(expected.rebound_speed, rel=1e-6)


# --- what must stop, with LIGGGHTS's own error


def refused(folder, text):
    with pytest.raises(DemlawsError) as caught:
        simulate(folder, text)
    message = str(caught.value)
    assert "ERROR" in message and "demlaws/table" in message, message
    return message


def test_missing_table_is_named(tmp_path):
    assert "nowhere.tbl" in refused(tmp_path, two_spheres(GRAN + "table nowhere.tbl", LOAD_UNLOAD))


def test_no_table_at_all(tmp_path):
    assert "table FILE" in refused(tmp_path, two_spheres(GRAN, LOAD_UNLOAD))


def test_bad_row_is_named_by_its_line(tmp_path, granite_pair):
    save(dl.law("pohrt-popov", granite_pair), tmp_path / "law.tbl")
    lines = (tmp_path / "law.tbl").read_text().splitlines(keepends=True)
    lines[40] = lines[40].replace(".", ",", 1)
    (tmp_path / "law.tbl").write_text("".join(lines))
    assert "line 41" in refused(tmp_path, two_spheres(GRAN + "table law.tbl", LOAD_UNLOAD))


def test_type_pair_without_table(tmp_path, granite_pair):
    save(dl.law("hertz", granite_pair), tmp_path / "law.tbl")
    message = refused(tmp_path, two_spheres(GRAN + "pairtable 1 1 law.tbl", LOAD_UNLOAD))
    assert "types 1 and 2" in message


def test_type_that_the_box_does_not_have(tmp_path, granite_pair):
    save(dl.law("hertz", granite_pair), tmp_path / "law.tbl")
    assert "type 3" in refused(tmp_path, two_spheres(GRAN + "table law.tbl pairtable 1 3 law.tbl", LOAD_UNLOAD))


@pytest.mark.parametrize(
    "models",
    [
        "cohesion washino/capillary/viscous",
        "cohesion easo/capillary/viscous",
        "rolling_friction epsd3",
        "rolling_friction luding",
        "surface superquadric",
        "surface multicontact",
        "",
    ],
)
def test_unsupported_models_are_refused(tmp_path, granite_pair, models):
    save(dl.law("hertz", granite_pair), tmp_path / "law.tbl")
    models = f"tangential history {models}" if models else "tangential tan_luding"
    text = two_spheres(f"pair_style gran model demlaws/table {models} table law.tbl", LOAD_UNLOAD)
    assert "works with tangential off, no_history, history, demlaws" in refused(tmp_path, text)


def test_unknown_setting_is_named(tmp_path, granite_pair):
    save(dl.law("hertz", granite_pair), tmp_path / "law.tbl")
    with pytest.raises(DemlawsError, match="bogus"):
        simulate(tmp_path, two_spheres(GRAN + "table law.tbl bogus on", LOAD_UNLOAD))


def test_overlap_beyond_the_table_names_the_particles(tmp_path, granite_pair):
    save(dl.law("pohrt-popov", granite_pair), tmp_path / "law.tbl", max_force=10.0)
    message = refused(tmp_path, two_spheres(GRAN + "table law.tbl", LOAD_UNLOAD))
    assert "particles 1 and 2" in message and "law.tbl" in message


def test_a_law_that_does_not_collapse_holds_for_its_radius_and_modulus(tmp_path, granite_pair):
    contact = granite_pair.with_values(modulus=modulus())
    law = dl.law("rough-plastic", contact, unloading="hertz", yield_pressure=1.66e9)
    save(law, tmp_path / "law.tbl")
    assert error_of(simulate(tmp_path, two_spheres(GRAN + "table law.tbl", LOAD_UNLOAD)), law) <= 1e-5
    message = refused(tmp_path, two_spheres(GRAN + "table law.tbl", LOAD_UNLOAD, 17e-3, 12e-3))
    assert "radius" in message and "does not collapse" in message
    simulate(tmp_path, two_spheres(GRAN + "table law.tbl radius_tolerance 0.5", LOAD_UNLOAD, 17e-3, 12e-3))
    other = dl.law("rough-plastic", granite_pair.with_values(modulus=30e9), yield_pressure=1.66e9)
    save(other, tmp_path / "other.tbl")
    assert "modulus" in refused(tmp_path, two_spheres(GRAN + "table other.tbl", LOAD_UNLOAD))


def test_restart_without_the_pair_style_line(tmp_path, granite_pair):
    save(dl.law("pohrt-popov", granite_pair, unloading="hertz"), tmp_path / "law.tbl")
    simulate(tmp_path, two_spheres(GRAN + "table law.tbl", LOAD_UNLOAD[:1]) + "write_restart now.restart\n")
    text = two_spheres("", LOAD_UNLOAD[1:2])
    head, tail = text.split("region ", 1)
    tail = tail.split("create_box", 1)[1].split("\n", 1)[1]
    keep = [line for line in tail.splitlines() if not line.startswith(("create_atoms", "set "))]
    with pytest.raises(DemlawsError, match="can not restart"):
        simulate(tmp_path, head + "read_restart now.restart\n" + "\n".join(keep) + "\n")


def test_refusal_stops_every_rank(tmp_path, granite_pair):
    (tmp_path / "in.case").write_text(two_spheres(GRAN + "table nowhere.tbl", LOAD_UNLOAD))
    with pytest.raises(DemlawsError, match=r"nowhere\.tbl"):
        run(tmp_path / "in.case", 2)


def test_plain_preload_works(tmp_path, granite_pair):
    """What run.sh does: the unmodified binary with LD_PRELOAD."""
    from demlaws.liggghts import build

    save(dl.law("pohrt-popov", granite_pair), tmp_path / "law.tbl")
    (tmp_path / "in.case").write_text(two_spheres(GRAN + "table law.tbl", LOAD_UNLOAD[:1]))
    command = ["env", f"LD_PRELOAD={build()}", "liggghts", "-in", "in.case"]
    assert subprocess.run(command, cwd=tmp_path, capture_output=True).returncode == 0
