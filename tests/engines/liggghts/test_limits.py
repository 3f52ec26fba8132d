"""What leaves the range of a law is reported once, with its contact, and counted at the end of the run."""

import re

import pytest
from inputs_for_liggghts import modulus, two_spheres

import demlaws as dl
from demlaws.errors import DemlawsError
from demlaws.liggghts import run

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")

GRAN = "pair_style gran model demlaws/table tangential demlaws "
PRESS = [(-0.2, 0, 3000), (0.2, 0, 1500)]
CONTACT = dl.Contact(radius=4.35e-3, modulus=modulus(), roughness=2.4e-6, fractal_dimension=2.22, hardness=6.266e9)


def press(folder, words, moves=PRESS, change=("", ""), **options):
    """Log and text of the log of two spheres of 17.4 mm that are pressed together."""
    (folder / "in.case").write_text(two_spheres(GRAN + words, moves, every=1, **options).replace(*change))
    return run(folder / "in.case"), (folder / "log.liggghts").read_text()


def counted(text, words):
    return [int(n) for n in re.findall(rf"in this run (\d+) contact steps were {words}", text)]


def test_roughness_in_the_wrong_unit(tmp_path):
    """A tenth of R is warned of, half of R is refused, as in Python."""
    dl.law("pohrt-popov", CONTACT).tabulate().save(tmp_path / "law.tbl")
    words = "table law.tbl surfaceRoughness on"
    _, text = press(tmp_path, words, change=("1e-6 2e-6", "6e-4 2e-6"))
    assert text.count("WARNING: model demlaws/table") == text.count("0.138 of the radius 0.00435 m, above 0.1") == 1
    assert counted(text, "rougher than a tenth of R")
    with pytest.raises(DemlawsError, match="did you mean µm"):
        press(tmp_path, words, change=("1e-6 2e-6", "2.4 2e-6"))


def test_modulus_in_the_wrong_unit(tmp_path):
    dl.law("hertz", CONTACT).tabulate().save(tmp_path / "law.tbl")
    _, text = press(tmp_path, "table law.tbl", young=60.6e11)
    # LIGGGHTS itself refuses moduli below 5e6 Pa
    assert "100 times the effective modulus of law.tbl" in text


def test_particles_that_overlap_at_the_start_are_told_apart(tmp_path):
    dl.law("hertz", CONTACT).tabulate(max_force=100.0).save(tmp_path / "law.tbl")
    with pytest.raises(DemlawsError, match="move them apart") as caught:
        press(tmp_path, "table law.tbl", change=("create_atoms    2 single", "create_atoms    2 single 0.017 0 0 units box #"))
    assert "time step" not in str(caught.value)


def test_a_wall_with_a_stock_model_is_named(tmp_path):
    dl.law("hertz", CONTACT).tabulate().save(tmp_path / "law.tbl")
    walls = "".join(
        f"fix {name} all wall/gran model {model} tangential history primitive type 1 zplane -0.01\n"
        for name, model in (("old", "hertz"), ("new", "demlaws/table"))
    )
    _, text = press(tmp_path, "table law.tbl", change=("fix             move", walls + "fix             move"))
    assert text.count("fix old wall/gran has a model of LIGGGHTS") == 1 and "fix new wall/gran has" not in text


def test_negative_friction_is_refused(tmp_path):
    dl.law("hertz", CONTACT).tabulate().save(tmp_path / "law.tbl")
    with pytest.raises(DemlawsError, match="coefficientFriction"):
        press(tmp_path, "table law.tbl", change=("2 0.5 0.5 0.5 0.5", "2 0.5 -0.5 -0.5 0.5"))


HEAT = """\
fix heat all heat/gran initial_temperature 300. area_correction yes
fix t1 all property/global thermalConductivity peratomtype 5. 5.
fix t2 all property/global thermalCapacity peratomtype 10. 10.
fix t3 all property/global youngsModulusOriginal peratomtype 60.6e9 60.6e9
fix move"""


@pytest.mark.parametrize("name, served", [("hertz", True), ("pohrt-popov", False)])
def test_area_correction_holds_for_hertz_only(tmp_path, name, served):
    dl.law(name, CONTACT).tabulate().save(tmp_path / "law.tbl")
    change = ("fix             move", HEAT)
    if served:
        assert press(tmp_path, "table law.tbl", change=change)[0]["Step"][-1] == 4500
    else:
        with pytest.raises(DemlawsError, match="area_correction holds for Hertz"):
            press(tmp_path, "table law.tbl", change=change)
