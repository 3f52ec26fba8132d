"""Tangential model demlaws in LIGGGHTS and LAMMPS: force and energy against Python; no energy from nothing; ranks, restart."""

import itertools

import numpy as np
import pytest
from examples import shared
from inputs import ENERGY, simulate
from spheres import DIAMETER, LAWS, SHEARED, both, gas, save_law, sheared_along, spheres

import demlaws as dl
from studies.shear.gas import HEADS

SHEARS = ["elastic", "loading", "slip", "slip springs 22"]
PATHS = shared(itertools.product(LAWS, SHEARS), lambda path: path[0] == "rough" or path[1] == "slip")


@pytest.mark.parametrize(("name", "shear"), PATHS)
@both
def test_force_along_a_path_is_pythons(engine, tmp_path, name, shear):
    law = save_law(tmp_path, name)
    log = simulate(engine, tmp_path, spheres(engine, f"shear {shear}", SHEARED, every=1, **ENERGY))
    # springs are divided by what the curve leaves to one
    curve = dl.Table.load(tmp_path / "law.tbl") if "slip" in shear else law
    path, normal, across, kept = sheared_along(curve, log, shear, every=1)
    found = path.force * across / DIAMETER - log["side"][kept]  # the normal turns
    np.testing.assert_allclose(found, path.shear_force, atol=3e-3 * 0.5 * path.force.max())
    assert log["e[2]"][-1] == pytest.approx(normal.dissipated[-1] + path.dissipated[-1], rel=2e-2)
    assert log["e[1]"][-1] + log["e[2]"][-1] == pytest.approx(normal.work[-1] + path.work[-1], rel=3e-3)


@pytest.mark.parametrize("shear", ["elastic", "slip"])
@both
def test_a_contact_that_carried_no_force_has_lost_its_shear(engine, tmp_path, shear):
    """Press, slide, lift off below the plastic overlap without parting, press again: no shear force is left."""
    law = save_law(tmp_path, "rough")
    plastic = law.follow([5.9e-6]).plastic_overlap[-1]
    assert plastic > 1e-6
    up = round((5.9e-6 - 0.5 * plastic) / 1e-8)
    log = simulate(
        engine,
        tmp_path,
        spheres(engine, f"shear {shear}", [(-0.2, 0, 600), (0, 0.02, 100), (0.2, 0, up), (-0.2, 0, up)], every=2),
    )
    largest, left = np.abs(log["side"]).max(), log["side"][-1]
    assert log["overlap"].min() < 0.6 * plastic and log["force"][-1] > 1.0
    assert abs(left - log["force"][-1] * 1e-7 / DIAMETER) < 1e-3 * largest


@pytest.mark.parametrize(
    ("name", "shear", "friction", "poisson"),
    [
        pytest.param("hertz elastic", "elastic", 100, 0.25, marks=pytest.mark.slow),
        ("rough elastic", "elastic", 100, 0.0),
        ("rough", "loading", 100, 0.4),
        pytest.param("rough elastic", "slip", 100, 0.25, marks=pytest.mark.slow),
        ("rough", "slip", 0.3, 0.25),
        pytest.param("thornton", "slip springs 10", 1, 0.25, marks=pytest.mark.slow),  # 11: more than a page of LIGGGHTS has
    ],
)
@both
def test_a_gas_gains_no_energy(engine, tmp_path, name, shear, friction, poisson):
    """The engines' own history models double this energy with rough elastic contacts. The losses are in the balance."""
    save_law(tmp_path, name)
    log = simulate(engine, tmp_path, "".join(gas(engine, friction, shear, poisson=poisson, newton="off")) + "run 100000\n")
    kept = log["ke"] + log["er"] + log["stored"]
    assert kept.max() <= 1.001 * kept[0]
    assert kept[-1] < 0.9 * kept[0]
    np.testing.assert_allclose(kept + log["lost"], kept[0], rtol=2e-3 if "slip" in shear else 1e-3)


@both
def test_a_damped_gas_closes_its_balance(engine, tmp_path):
    """With the work of both dashpots; the rest falls with the step."""
    save_law(tmp_path, "rough")
    errors = []
    for step in (4e-7, 2e-7):
        start, contacts, rest = gas(engine, 0.5, "elastic", restitution=0.7)
        text = start + contacts + rest.replace("timestep 2e-07", f"timestep {step!r}") + f"run {round(4e-3 / step)}\n"
        log = simulate(engine, tmp_path, text)
        total = log["ke"] + log["er"] + log["stored"] + log["lost"] + log["viscous"]
        assert log["viscous"][-1] > 0.1 * total[0]
        errors.append(abs(total[-1] / total[0] - 1.0))
    assert errors[1] < 0.55 * errors[0] and errors[1] < 2e-3 * log["viscous"][-1] / total[0]


@pytest.mark.parametrize("shear", ["elastic", "slip"])
@both
def test_ranks_and_restart_change_nothing(engine, tmp_path, shear):
    save_law(tmp_path, "rough")
    start, contacts, rest = gas(engine, 0.5, shear, restitution=0.9)
    one = simulate(engine, tmp_path, start + contacts + rest + "run 12000\nwrite_restart half.rst\nrun 12000\n")
    two = simulate(engine, tmp_path, "".join(gas(engine, 0.5, shear, ranks=2, restitution=0.9)) + "run 24000\n", 2)
    head, contacts = (HEADS[engine], contacts) if engine == "liggghts" else ("comm_modify vel yes\n", "")
    again = simulate(engine, tmp_path, f"{head}read_restart half.rst\n{contacts}{rest}run 12000\n")
    for log in (two, again):
        for name in ("ke", "er", "stored", "lost", "viscous"):
            assert log[name][-1] == pytest.approx(one[name][-1], rel=1e-7), name


@pytest.mark.parametrize("between", ["", "run 1\nrun 0\n", "uncompute en\ncompute en all demlaws/energy\n", "RESTART"])
@both
def test_energies_are_summed_from_their_compute_on(engine, tmp_path, between):
    """Contacts that store energy of shear then; also after a restart file that was written before."""
    save_law(tmp_path, "rough")
    start, contacts, rest = gas(engine, 0.5, "elastic")
    shown = rest[rest.index("compute en") :]
    before = start + contacts + rest[: rest.index("compute en")]
    if between == "RESTART":
        simulate(engine, tmp_path, before + "run 12000\nwrite_restart half.rst\n")
        head, contacts = (HEADS[engine], contacts) if engine == "liggghts" else ("comm_modify vel yes\n", "")
        text = f"{head}read_restart half.rst\n{contacts}{rest}"
    elif between.startswith("uncompute"):
        text = f"{before}compute en all demlaws/energy\nrun 12000\n{between}{shown.split(chr(10), 1)[1]}"
    else:
        text = f"{before}run 12000\n{shown}{between}"
    log = simulate(engine, tmp_path, text + "run 12000\n")
    kept = log["ke"] + log["er"] + log["stored"]
    start = next(n for n, step in enumerate(log["Step"]) if step >= 12000)
    assert kept[start] - kept[-1] > 0.05 * kept[start]
    np.testing.assert_allclose((kept + log["lost"])[start:], (kept + log["lost"])[start], rtol=1e-4)


@both
def test_nothing_is_dissipated_when_the_compute_is_defined(engine, tmp_path):
    """The work of shear that contacts store then was done before: it is stored, not yet taken."""
    save_law(tmp_path, "rough elastic")
    start, contacts, rest = gas(engine, 0.5, "elastic")
    defined = rest.index("compute en")
    log = simulate(engine, tmp_path, f"{start}{contacts}{rest[:defined]}run 7200\n{rest[defined:]}run 0\n")
    assert log["stored"][-1] > 1e-3 * log["ke"][-1]
    assert log["lost"][-1] == pytest.approx(0.0, abs=1e-9 * log["stored"][-1])
