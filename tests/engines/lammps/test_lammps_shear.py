"""Tangential model demlaws: force and energy against Python along a path; no energy from nothing; ranks, restart, walls."""

import numpy as np
import pytest
from inputs import ENERGY, moves_of, save
from inputs_for_lammps import simulate, two_spheres
from spheres import ROUGH, SHEARED, save_law, sheared_along

import demlaws as dl

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
def test_walls(tmp_path, shear, style):
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
