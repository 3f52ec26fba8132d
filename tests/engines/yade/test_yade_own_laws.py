"""A law of a user's file, and a table of a user-defined function, inside YADE: the force that was applied against both."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
from yade_scenes import GRANITE, MODULUS, Recorder, functor, material, set_engines, sphere, two_spheres

import demlaws as dl

PAGE = (Path(__file__).parents[3] / "docs" / "own-laws.md").read_text()
SMOOTH = {"granite": dl.Surface(0)}


@pytest.fixture
def page(tmp_path):
    """The files of the page, written as a reader would."""
    for name, text in re.findall(r"<!-- file: (\w+\.py) -->\n```python\n(.*?)```", PAGE, re.DOTALL):
        (tmp_path / name).write_text(text)
    return tmp_path


def recorded(law):
    two_spheres(law, radius=8e-3, sideways=0.02)
    recorder = Recorder()
    recorder.step(700)
    return recorder


def test_a_law_of_ones_own_is_exact(omega, page, registered_here):
    dl.load_laws(page / "my_law.py")
    recorder = recorded(functor("power", "hertz", SMOOTH, factor=0.9))
    wrong, tangent, steps = recorder.worst("power", "hertz", dl.Surface(0), factor=0.9)
    assert steps > 300 and wrong <= 1e-14 and tangent <= 1e-13


def test_answers_tell_laws_of_one_name_apart(omega, monkeypatch):
    """A saved scene knows a user's law by its name: what it answered is saved with it, and compared."""
    from demlaws.yade import saving
    from demlaws.yade.pairs import TYPICAL_MODULUS, TYPICAL_RADIUS
    from demlaws.yade.saving import pairs_from, pairs_text

    monkeypatch.setattr(saving, "home_of", lambda name: "mine.py" if name == "pohrt-popov" else "demlaws")
    made = functor().binding.pairs
    text = pairs_text(made)
    assert pairs_text(pairs_from(text)) == text
    omega.bodies.append(sphere((0, 0, 0), 0.03, material=material()))
    assert pairs_text(functor().binding.pairs, True) == pairs_text(made, True)  # whatever bodies have come
    content = json.loads(text)
    pair = dl.Contact(TYPICAL_RADIUS, TYPICAL_MODULUS, GRANITE.roughness * 2**0.5, GRANITE.fractal_dimension)
    answer = dl.law("pohrt-popov", pair, "hertz").force(4e-3 * TYPICAL_RADIUS)
    assert content["answers"][-1][-1] == pytest.approx(answer, rel=1e-9)
    content["answers"][-1][-1] *= 1 + 1e-6
    with pytest.raises(dl.DemlawsError, match=r"law 'pohrt-popov' is registered, but gives other forces"):
        pairs_from(json.dumps(content))
    content["default"]["law"] = "gone"
    with pytest.raises(dl.DemlawsError, match=r"saved with law 'gone', which is not registered"):
        pairs_from(json.dumps(content))


@pytest.mark.slow
def test_a_law_changed_under_its_name_is_another(omega, registered_here):

    def register(constant):
        dl.register(dl.define("spring", lambda p, x: constant * x**1.5, lambda p, x: 1.5 * constant * x**0.5))
        return functor("spring", "hertz", SMOOTH)

    recorded(register(1e9))
    assert omega.interactions.countReal() == 1
    set_engines(register(1e9))  # the same again
    changed = register(1.001e9)
    with pytest.raises(dl.DemlawsError, match="the law is switched"):
        set_engines(changed)


@pytest.mark.slow
def test_the_pages_script(page):
    line = [sys.executable, "-m", "demlaws", "yade", "run", "-x", "mine_yade.py"]
    done = subprocess.run(line, capture_output=True, text=True, cwd=page, timeout=600)
    assert done.returncode == 0, done.stdout + done.stderr
    overlap, force = map(float, re.search(r"at (\S+) m (\S+) N", done.stdout).groups())
    coefficient = 4 / 3 * MODULUS * 4e-3**0.5
    assert force == pytest.approx(coefficient * overlap**1.7, rel=1e-13)
