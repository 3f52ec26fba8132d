"""Shear with levels in LIGGGHTS and LAMMPS: to rounding Python's, and kept while the overlap vibrates."""

import numpy as np
import pytest
from inputs import refused, simulate
from spheres import DIAMETER, RATIO, STEP, both, continued, save_law, spheres

import demlaws as dl

FRICTION = 0.5
WOBBLE = [(-0.2, 0.01, 6), (0.2, 0.02, 9), (-0.2, -0.015, 11), (0.2, 0.03, 8)]
OBLIQUE = [(-0.2, 0, 500), *6 * WOBBLE, (0.2, 0, 60), (0, -0.3, 200), *4 * WOBBLE, (-0.1, 0.05, 250), *2 * WOBBLE]
"""Press; vibrate and move aside; lift off partly, slide back past the limit; vibrate; press while sliding; vibrate."""


def kinematics(moves):
    """Overlap, displacement along the turning tangent, and the normal, of the second sphere after each step; the displacement
    of the half step, where the normal is n - d/2."""
    place, moved, rows = np.array([DIAMETER + 1e-7, 0.0]), 0.0, [(-1e-7, 0.0, 1.0, 0.0)]
    for along, across, steps in moves:
        for _ in range(steps):
            place = place + STEP * np.array([along, across])
            normal = place / np.hypot(*place)
            sideways, parting = across * normal[0] - along * normal[1], along * normal[0] + across * normal[1]
            d = STEP * sideways / np.hypot(*place)
            moved += STEP * (sideways + 0.5 * d * (parting - 0.5 * d * sideways))
            rows.append((DIAMETER - np.hypot(*place), moved, *normal))
    return np.array(rows).T


@pytest.mark.parametrize("words", ["levels 1", "levels 2", "", "levels 8", "shear loading", "levels 2 shear_ratio 0.3"])
@both
def test_an_oblique_path_is_pythons_to_rounding(engine, tmp_path, words):
    save_law(tmp_path, "rough")
    log = simulate(engine, tmp_path, spheres(engine, words, OBLIQUE, every=1))
    kept = np.append(np.diff(log["Step"]) > 0, True)  # each run begins with the last line of the one before
    overlap, moved, along, across = kinematics(OBLIQUE)
    given = words.split()
    options = {"levels": int(given[1])} if "levels" in given else {}
    options |= {"shear": "loading"} if "loading" in given else {}
    ratio = float(given[3]) if "shear_ratio" in given else RATIO
    table = dl.Table.load(tmp_path / "law.tbl")
    path = dl.driver.sheared(table, overlap, moved, ratio, friction=FRICTION, **options)
    slides = np.abs(path.shear_force) > 0.999 * FRICTION * path.force
    assert 60 < slides[path.force > 0].sum() < 0.7 * slides.size
    scale = path.force.max()
    for column, expected in (
        ("force", path.force * along + path.shear_force * across),
        ("side", path.force * across - path.shear_force * along),
    ):
        np.testing.assert_allclose(log[column][kept], expected, rtol=0.0, atol=1e-9 * scale, err_msg=column)


@pytest.mark.parametrize("name", ["rough elastic", "rough"])
@both
def test_vibration_leaves_the_shear_force(engine, tmp_path, name):
    """A thousand vibrations by 1 % of the overlap; one level loses all of it."""
    save_law(tmp_path, name)
    vibration = [(-0.2, 0, 5), *1000 * [(0.2, 0, 10), (-0.2, 0, 10)], (0.2, 0, 5)]
    left = {}
    for words in ("", "levels 1"):
        log = simulate(engine, tmp_path, spheres(engine, words, [(-0.2, 0, 520), (0, 0.04, 200), *vibration], every=5))
        step = log["Step"]
        turned = log["force"] * (200 * 0.04 * STEP) / DIAMETER  # the normal force has a part across
        sheared = (log["side"] - turned)[[np.flatnonzero(step == 720)[0], -1]]
        assert 0.2 < abs(sheared[0]) / (FRICTION * log["force"][-1]) < 0.8
        left[words] = sheared[1] / sheared[0]
    assert left[""] >= 0.98
    assert abs(left["levels 1"]) < 0.02


PRESSED, LATER = [(-0.2, 0, 600), (0, 0.05, 300)], [(0.2, 0.03, 200), (-0.2, -0.02, 300)]


WALL = "fix floor all wall/gran model demlaws/table tangential demlaws primitive type 1 zplane -0.02 {}\n"


@pytest.mark.parametrize("engine", ["liggghts"])
def test_a_restart_file_is_not_read_with_other_levels(engine, tmp_path):
    save_law(tmp_path, "rough")
    text = spheres(engine, "levels 4", PRESSED, more=WALL.format("levels 4"))
    simulate(engine, tmp_path, text + "write_restart now.restart\n")
    other = continued(engine, text.replace("-0.02 levels 4", "-0.02 levels 3"), LATER)
    assert "history_floor): restarted fix has incompatible data size" in refused(engine, tmp_path, other)
    other = continued(engine, text.replace("levels 4", "springs 3 shear slip"), LATER)  # as many values
    assert "or another line ('levels'" in refused(engine, tmp_path, other)
    simulate(engine, tmp_path, continued(engine, text, LATER))


@pytest.mark.parametrize("words", ["levels 3", "shear slip", "levels 1"])
@pytest.mark.parametrize("engine", ["lammps"])
def test_no_contact_of_a_wall_goes_on_with_other_levels(engine, tmp_path, words):
    """Walls are not in a restart file, their histories are; LAMMPS reads those of any size. Pairs: their lines are in it."""
    save_law(tmp_path, "rough")
    line = "demlaws/table law.tbl 60.6e9 1.0 0.25 {} tangential demlaws 1 0.5 damping demlaws/tangent"
    wall = f"fix floor all wall/gran granular {line} zplane {1e-6 - DIAMETER / 2!r} NULL\n"
    text = spheres(engine, "levels 2", PRESSED, more=wall.format("levels 2"))
    simulate(engine, tmp_path, text + "write_restart now.restart\n")
    simulate(engine, tmp_path, continued(engine, text, LATER, more=wall.format("levels 2")))
    message = refused(engine, tmp_path, continued(engine, text, LATER, more=wall.format(words)))
    assert "or another line ('levels'" in message and "and the wall: " in message
    pairs = f"pair_coeff * * {line.format(words)}\n"
    message = refused(engine, tmp_path, continued(engine, text, LATER, more=wall.format("levels 2") + pairs))
    assert "restart file" in message and "different numbers of history values" in message


@pytest.mark.parametrize("engine", ["liggghts"])
def test_a_wall_before_the_pair_style_has_its_levels(engine, tmp_path):
    save_law(tmp_path, "rough")
    text = spheres(engine, "levels 2", PRESSED)
    wall = WALL.format("table law.tbl")
    before = text.replace("pair_style", wall + "pair_style", 1)
    assert "define it below the pair_style line" in refused(engine, tmp_path, before)
    simulate(engine, tmp_path, before.replace("-0.02 table law.tbl", "-0.02 table law.tbl levels 2"))
