"""The plugin inside LIGGGHTS: every law, sub-models, damping, energies, several tables, and everything it must refuse."""

import subprocess
from pathlib import Path

import numpy as np
import pytest
from inputs_for_liggghts import modulus, refused, simulate, two_spheres

import demlaws as dl
from demlaws.errors import DemlawsError
from demlaws.make import example

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")

LOAD_UNLOAD = [(-0.2, 0, 5000), (0.2, 0, 3000), (-0.2, 0, 4000), (0.2, 0, 9000), (-0.2, 0, 4000)]
GRAN = "pair_style gran model demlaws/table tangential history "


def save(law, path, **options):
    law.tabulate(**options).save(path)
    return path.name


def error_of(log, law):
    expected = law.follow(log["overlap"]).force
    return np.abs(log["force"] - expected).max() / expected.max()


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


# --- what must stop, with LIGGGHTS's own error


@pytest.mark.parametrize(
    "settings, named",
    [
        ("", "table FILE"),
        ("pairtable 1 1 law.tbl", "types 1 and 2"),
        ("table law.tbl pairtable 1 3 law.tbl", "type 3"),
    ],
)
def test_type_pairs_without_a_table_are_named(tmp_path, granite_pair, settings, named):
    save(dl.law("hertz", granite_pair), tmp_path / "law.tbl")
    assert named in refused(tmp_path, two_spheres(GRAN + settings, LOAD_UNLOAD))


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


def test_restart_without_the_pair_style_line(tmp_path, granite_pair):
    save(dl.law("pohrt-popov", granite_pair, unloading="hertz"), tmp_path / "law.tbl")
    simulate(tmp_path, two_spheres(GRAN + "table law.tbl", LOAD_UNLOAD[:1]) + "write_restart now.restart\n")
    text = two_spheres("", LOAD_UNLOAD[1:2])
    head, tail = text.split("region ", 1)
    tail = tail.split("create_box", 1)[1].split("\n", 1)[1]
    keep = [line for line in tail.splitlines() if not line.startswith(("create_atoms", "set "))]
    with pytest.raises(DemlawsError, match="can not restart"):
        simulate(tmp_path, head + "read_restart now.restart\n" + "\n".join(keep) + "\n")


def test_plain_preload_works(tmp_path, granite_pair):
    """What run.sh does: the unmodified binary with LD_PRELOAD."""
    from demlaws.liggghts import build

    save(dl.law("pohrt-popov", granite_pair), tmp_path / "law.tbl")
    (tmp_path / "in.case").write_text(two_spheres(GRAN + "table law.tbl", LOAD_UNLOAD[:1]))
    command = ["env", f"LD_PRELOAD={build()}", "liggghts", "-in", "in.case"]
    assert subprocess.run(command, cwd=tmp_path, capture_output=True).returncode == 0
