"""Cohesion beside the law: the stock models, with the area of the law's own contact."""

import math

import numpy as np
import pytest
from inputs import modulus
from inputs_for_liggghts import two_spheres

import demlaws as dl
from demlaws.liggghts import run

DENSITY = 3e6  # cohesion energy density [J/m³]
PROPERTY = f"fix m8 all property/global cohesionEnergyDensity peratomtypepair 2 {' '.join([str(DENSITY)] * 4)}\n"
CONTACT = dl.Contact(radius=4.35e-3, modulus=modulus(), roughness=2.4e-6, fractal_dimension=2.22)
WALLS_FORCE = {"more": "compute wall left reduce sum fx\nvariable wall equal c_wall", "columns": "v_wall"}
WALL = """\
fix floor all wall/gran model {model} tangential no_history cohesion {cohesion} primitive type 1 xplane -0.008695
fix move"""
AREAS = {  # of two spheres of radius r at the overlap d
    "sjkr": lambda r, d: -math.pi / 4 * (-d) * (4 * r - d) * (2 * r - d) ** 2 / (2 * r - d) ** 2,
    "sjkr2": lambda r, d: 2 * math.pi * r * d,
}


def forces(folder, model, cohesion, words="", moves=((-0.2, 0, 3000), (0.2, 0, 2500)), settings=""):
    pair = f"pair_style gran model {model} tangential no_history cohesion {cohesion}{settings}{words}"
    text = two_spheres(pair, moves, every=10, **WALLS_FORCE)
    text = text.replace("fix             move", WALL.format(model=model, cohesion=cohesion))
    (folder / "in.case").write_text(text.replace("fix             m7", PROPERTY + "fix             m7"))
    return run(folder / "in.case")


@pytest.mark.parametrize("cohesion", ["sjkr", "sjkr2"])
@pytest.mark.parametrize("settings", ["", " tangential_reduce on"])
def test_beside_hertz_it_is_stock(tmp_path, cohesion, settings):
    """Pair and wall; the left sphere overlaps the wall by 5 µm."""
    dl.law("hertz", CONTACT).tabulate(rtol=1e-10).save(tmp_path / "law.tbl")
    stock = forces(tmp_path, "hertz", cohesion, settings=settings)
    table = forces(tmp_path, "demlaws/table", cohesion, " table law.tbl", settings=settings)
    assert stock["wall"][0] > 1.0  # the wall's, before the spheres touch
    without = forces(tmp_path, "demlaws/table", "off", " table law.tbl")
    for column in ("force", "wall"):
        assert np.abs(table[column] - stock[column]).max() <= 1e-9 * np.abs(stock["force"]).max()
    assert np.abs(table["force"] - without["force"]).max() > 1e-3 * stock["force"].max()


@pytest.mark.parametrize("cohesion", ["sjkr", "sjkr2"])
@pytest.mark.parametrize("unloading", ["elastic", "hertz"])
def test_the_area_is_that_of_the_law(tmp_path, cohesion, unloading):
    """The stock area of the overlap at which Hertz's contact is as wide: a²/R, which of a rough law is (3P/4E*√R)^(2/3) under
    first loading; loading and unloading pull alike at one overlap."""
    law = dl.law("pohrt-popov", CONTACT, unloading=unloading)
    law.tabulate(rtol=1e-10).save(tmp_path / "law.tbl")
    log = forces(tmp_path, "demlaws/table", cohesion, " table law.tbl")
    overlap = np.maximum(log["overlap"], 0.0)
    wide = (0.75 * law.force(overlap) / (CONTACT.modulus * math.sqrt(CONTACT.radius))) ** (2 / 3)
    expected = law.follow(log["overlap"]).force - DENSITY * AREAS[cohesion](8.7e-3, wide)
    assert np.abs(log["force"] - expected).max() <= 1e-6 * expected.max()
    assert expected.min() < -1e-3 * expected.max() or unloading == "elastic"
