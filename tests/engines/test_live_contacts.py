"""A contact that is given another law while it is loaded stops the run: its overlaps belong to the law it began under."""

import inputs_for_lammps
import inputs_for_liggghts
import pytest
from inputs import moves_of, refused, simulate
from inputs_for_lammps import SHEAR, continued
from spheres import ROUGH, both, save_law

import demlaws as dl

PRESS, ON = [(-0.2, 0, 600)], "run 10\n"
LINE = f"demlaws/table {{}} {{}} 1.0 0.25 {SHEAR}"
LAW, OTHER = LINE.format("law.tbl", 60.6e9), LINE.format("other.tbl", 60.6e9)
REFUSED = "began under another law"


@pytest.fixture
def folder(tmp_path):
    save_law(tmp_path, "rough")
    dl.law("hertz", ROUGH, "hertz").tabulate(rtol=1e-4, max_force=3e4).save(tmp_path / "other.tbl")
    dl.law("hertz", ROUGH).tabulate(rtol=1e-4, max_force=3e4).save(tmp_path / "elastic.tbl")
    return tmp_path


def of_types(engine, first="law.tbl", second="other.tbl", moves=PRESS):
    """Two spheres of types 1 and 2; the second table is that of two grains of type 1."""
    tables = {"1 1": second, "1 2": first, "2 2": first}
    if engine == "lammps":
        lines = [f"pair_coeff {pair} {LINE.format(table, 60.6e9)}" for pair, table in tables.items()]
        return inputs_for_lammps.two_spheres("\n".join(lines), moves)
    words = " ".join(f"pairtable {pair} {table}" for pair, table in tables.items())
    style = f"pair_style gran model demlaws/table tangential demlaws {words}"
    return inputs_for_liggghts.two_spheres(style, moves, step=5e-8)


@pytest.mark.parametrize("first, second", [("law.tbl", "other.tbl"), ("elastic.tbl", "law.tbl"), ("law.tbl", "elastic.tbl")])
@both
def test_a_grain_in_contact_changes_its_type(engine, folder, first, second):
    text = of_types(engine, first, second)
    message = refused(engine, folder, text + "set atom 2 type 1\n" + ON)
    assert REFUSED in message and "particles" in message
    simulate(engine, folder, text + moves_of([(0.2, 0, 700)]) + "set atom 2 type 1\n" + moves_of(PRESS))  # it has parted


@both
def test_a_change_of_type_that_keeps_the_law(engine, folder):
    simulate(engine, folder, of_types(engine, "law.tbl", "law.tbl") + "set atom 2 type 1\n" + ON)


@pytest.mark.parametrize("line", [OTHER, LINE.format("law.tbl", 50e9), LAW.replace("0.25", "0.25 roughness 1e-6")])
@pytest.mark.parametrize("engine", ["lammps"])
def test_pair_coeff_gives_another_law(engine, folder, line):
    text = inputs_for_lammps.two_spheres(LAW, PRESS)
    assert REFUSED in refused(engine, folder, f"{text}pair_coeff * * {line}\n" + ON)


@both
def test_an_elastic_contact_keeps_nothing_of_its_law(engine, folder):
    """Another modulus in the middle of a contact: the force of the new law. It stopped the run of LAMMPS."""
    law = dl.law("hertz", ROUGH)
    if engine == "lammps":
        text = inputs_for_lammps.two_spheres(LINE.format("elastic.tbl", 60.6e9), PRESS)
        change = f"pair_coeff * * {LINE.format('elastic.tbl', 50e9)}\n"
    else:
        text = of_types(engine, "elastic.tbl", "elastic.tbl")
        change = "unfix m1\nfix m1 all property/global youngsModulus peratomtype 5e10 5e10\n"
    log = simulate(engine, folder, text + change + ON)
    assert log["Step"][-1] == 610
    softer = law.bound_to(ROUGH.with_values(modulus=ROUGH.modulus * 50 / 60.6))
    assert log["force"][-1] == pytest.approx(softer.force(log["overlap"][-1]), rel=1e-5)


@pytest.mark.parametrize("engine", ["lammps"])
def test_pair_coeff_may_change_friction_and_what_does_not_touch(engine, folder):
    rougher = LAW.replace("demlaws 1.0 0.5", "demlaws 1.0 0.1")
    assert rougher != LAW
    simulate(engine, folder, inputs_for_lammps.two_spheres(LAW, PRESS) + f"pair_coeff * * {rougher}\n" + ON)
    apart = inputs_for_lammps.two_spheres(LAW, [(0.2, 0, 10)])
    simulate(engine, folder, apart + f"pair_coeff * * {OTHER}\n" + moves_of(PRESS))


@pytest.mark.parametrize("engine", ["lammps"])
def test_pair_coeff_after_a_restart(engine, folder):
    simulate(engine, folder, inputs_for_lammps.two_spheres(LAW, PRESS) + "write_restart now.restart\n")
    simulate(engine, folder, continued([(0.2, 0, 10)], again=f"pair_coeff * * {LAW}"))
    assert REFUSED in refused(engine, folder, continued([(0.2, 0, 10)], again=f"pair_coeff * * {OTHER}"))


@pytest.mark.parametrize("engine", ["liggghts"])
def test_other_moduli_of_a_restart(engine, folder):
    text = of_types(engine, "law.tbl", "law.tbl")
    simulate(engine, folder, text + "write_restart now.restart\n")
    softer = ("youngsModulus peratomtype 60600000000.0 60600000000.0", "youngsModulus peratomtype 5e10 5e10")
    assert REFUSED in refused(engine, folder, inputs_for_liggghts.again(text, change=[softer]))
