"""Tangential model demlaws: force and energy against Python along a path; no energy from nothing; ranks, restart, walls."""

import numpy as np
import pytest
from inputs_for_lammps import continued, moves_of, save, simulate, two_spheres
from spheres import RATIO, ROUGH, SHEARED, save_law

import demlaws as dl
from demlaws.errors import EngineStopped
from demlaws.lammps.check import HEAD
from demlaws.shear import sheared

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")
TANGENTIAL = "tangential demlaws 0.0 0.5 damping velocity"
ENERGY = {"more": "compute en all demlaws/energy", "columns": "c_en[1] c_en[2]"}


def terms(shear, tangential=TANGENTIAL):
    return f"demlaws/table law.tbl 60.6e9 0 0.25 shear {shear} {tangential}"


def along(moves, log, every):
    """Displacement across at each output of the log, and which outputs do not repeat the one before."""
    kept = np.append(np.diff(log["Step"]) > 0, True)
    return np.concatenate([[0.0], *[np.full(n // every, speed * 5e-8 * every) for _, speed, n in moves]]).cumsum(), kept


def test_an_energy_that_is_defined_later_begins_with_what_contacts_store(tmp_path):
    """Press and slide, define the compute, slide back and forth: before it only plastic flow and slip count from then on."""
    save_law(tmp_path, "hertz elastic")
    before, after = [(-0.2, 0, 600), (0, 0.02, 300)], [(0, 0.0, 20), (0, -0.02, 600)]
    late = "compute en all demlaws/energy\nthermo_style custom step v_force c_en[1] c_en[2]\n"
    late += "thermo_modify format float %.17e lost ignore norm no\n" + moves_of(after)
    whole = simulate(tmp_path, two_spheres(terms("slip"), before + after, **ENERGY))
    log = simulate(tmp_path, two_spheres(terms("slip"), before) + late)
    start = np.flatnonzero(np.isclose(whole["Step"], 900))[-1]
    assert log["en[1]"][0] == pytest.approx(whole["en[1]"][start], rel=1e-9)
    assert log["en[2]"][0] == pytest.approx(0.0, abs=1e-9 * log["en[1]"][0])
    assert log["en[2]"][-1] == pytest.approx(whole["en[2]"][-1] - whole["en[2]"][start], rel=1e-6)


def wall(shear, style):
    """A sphere pressed onto a plane and slid: the wall's forces by the sphere's."""
    model = f"granular {terms(shear)}"
    line = f"fix wall all {style} {model} " + ("region ground" if "region" in style else "xplane 0 NULL")
    return (
        HEAD
        + f"""boundary f f f
region box block -0.01 0.06 -0.03 0.03 -0.03 0.03 units box
create_box 1 box
neighbor 1e-4 bin
pair_style granular
pair_coeff * * {terms(shear)}
region ground plane 0 0 0 1 0 0 units box
create_atoms 1 single 8.7001e-3 0 0 units box
set group all diameter 17.4e-3 density 2650
timestep 5e-8
group right id 1
fix move all nve/noforce
{line}
compute pull right reduce sum fx fy
compute en all demlaws/energy
variable overlap equal "8.7e-3-xcm(right,x)"
variable force equal c_pull[1]
variable side equal c_pull[2]
thermo_style custom step v_overlap v_force v_side c_en[1] c_en[2]
thermo_modify format float %.17e lost ignore norm no
thermo 2
{moves_of(SHEARED)}"""
    )


@pytest.mark.parametrize("style", ["wall/gran", "wall/gran/region"])
@pytest.mark.parametrize("shear", ["elastic", "slip"])
def test_walls(tmp_path, shear, style):
    law = dl.law("pohrt-popov", ROUGH.with_values(radius=8.7e-3), "hertz")
    save(law, tmp_path / "law.tbl", rtol=1e-6, max_force=3e4)
    log = simulate(tmp_path, wall(shear, style))
    across, kept = along(SHEARED, log, 2)
    path = sheared(law, log["overlap"][kept], across, RATIO, shear, 0.5, 2000)
    np.testing.assert_allclose(-log["side"][kept], path.shear_force, atol=2e-2 * 0.5 * path.force.max())
    normal = law.follow(log["overlap"][kept])
    assert log["en[2]"][-1] == pytest.approx(normal.dissipated[-1] + path.dissipated[-1], rel=1e-2)
    assert log["en[1]"][-1] + log["en[2]"][-1] == pytest.approx(normal.work[-1] + path.work[-1], rel=3e-3)


def test_a_restart_between_two_spheres_goes_on_to_the_last_bit(tmp_path):
    save_law(tmp_path, "rough")
    whole = simulate(tmp_path, two_spheres(terms("slip springs 8"), SHEARED))
    simulate(tmp_path, two_spheres(terms("slip springs 8"), SHEARED[:3]) + "write_restart now.restart\n")
    again = simulate(tmp_path, continued(SHEARED[3:]))
    assert again["side"][-1] == whole["side"][-1] != 0.0


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


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (terms("slip", "tangential mindlin NULL 0 0.5 damping velocity"), "'shear slip' needs  tangential demlaws"),
        (terms("slip springs 7"), "springs must be an even number from 2 to 30"),
        (terms("slip", "tangential demlaws 0.0"), "needs XT MU"),
        (terms("slip", "tangential demlaws 0.0 high"), "friction of tangential demlaws is 'high'"),
        (terms("slip", "tangential demlaws 0.0 -1 damping velocity"), "must not be negative"),
        (terms("tangent"), "shear is elastic, loading or slip, not tangent"),
        ("hertz/material 60.6e9 0 0.25 tangential demlaws 0 0.5 damping velocity", "demlaws/table only"),
    ],
)
def test_wrong_words_are_named(tmp_path, words, message):
    save_law(tmp_path, "rough")
    with pytest.raises(EngineStopped) as stopped:
        simulate(tmp_path, two_spheres(words, SHEARED[:1]))
    assert message in str(stopped.value)


def test_slip_is_refused_where_unloading_has_no_springs(tmp_path):
    save(dl.law("eepa", ROUGH, "eepa", stiffness_ratio=5.0), tmp_path / "law.tbl", rtol=1e-5, max_force=1e3)
    with pytest.raises(EngineStopped, match="'shear slip' needs unloading"):
        simulate(tmp_path, two_spheres(terms("slip"), SHEARED[:1]))
