"""Grains that fall into a box: the study of what is left of motion."""

import pytest
from inputs import part

from demlaws.errors import DemlawsError
from studies.shear.rest import DROP, settle
from studies.shear.vibration import run_all

part("liggghts", "run")


@pytest.mark.parametrize("model", ["3 levels", "own"])
def test_before_they_touch_the_grains_fall_freely(model):
    """They start at 0.3 m/s; the walls carry nothing yet. Some touch one another early."""
    time, energy, missing = settle(model, steps=2000)[-1]
    assert energy == pytest.approx((0.3 + 9.81 * time) ** 2 / (2 * 9.81 * DROP), rel=0.05)
    assert missing == pytest.approx(1.0, abs=0.2)


def test_a_scene_of_liggghts_is_refused_in_another_engine(tmp_path):
    """It would run in LIGGGHTS, and its row would name the other one."""
    with pytest.raises(DemlawsError):
        run_all("rest", ["lammps"], ["own"], cycles=1, shaken=[0], out=tmp_path / "rows.jsonl")
    assert not (tmp_path / "rows.jsonl").exists()
