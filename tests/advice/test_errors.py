"""What a law does on a sample, for every rule: against one contact's path, and against Hertz's closed form."""

import numpy as np
import pytest
from examples import GRANITE, make, quiet, shared

import demlaws as dl
from demlaws.advice.errors import FRACTIONS, QUANTITIES, Loaded, Sample, error_of
from demlaws.core.unloading import RULES
from demlaws.laws.registry import registry

MANY = GRANITE.with_values(radius=GRANITE.radius * np.linspace(0.7, 1.4, 7))
PEAK = np.geomspace(3.0, 300.0, 7)
SAMPLE = Sample(MANY, PEAK)


def on_sample(rule, contact=MANY):
    curve = contact.with_values(sigma=0.25 * GRANITE.sigma)
    return dl.law("pohrt-popov", contact, dl.law("pohrt-popov", curve) if RULES[rule].curve == "given" else rule)


@pytest.mark.parametrize("rule", shared(RULES, lambda rule: rule != "table"))
@pytest.mark.parametrize("form", ["closed form", "table"])
def test_unloading_and_energy_are_those_of_one_contact(rule, form):
    many = on_sample(rule)
    loaded = Loaded(many.tabulate(1e-5, 400.0) if form == "table" else many, PEAK)
    assert loaded.force == pytest.approx(PEAK, rel=2e-5)
    work, lost = loaded.energies()
    for fraction in FRACTIONS:
        assert loaded.at(loaded.unloaded(fraction * PEAK))[0] == pytest.approx(fraction * PEAK, rel=1e-7)
    for i in (0, 6):
        one = on_sample(rule, GRANITE.with_values(radius=float(MANY.radius[i])))
        path = one.follow([float(loaded.top[i]), float(loaded.top[i]) * (1 - 1e-13)])
        assert (work[i], lost[i]) == pytest.approx((path.work[0], path.dissipated[0]), rel=1e-4, abs=1e-7 * work[i])


@pytest.mark.parametrize("name", [name for name, definition in registry().items() if not definition.needs_map])
def test_overlap_of_work_is_the_inverse_of_energy(name):
    law = quiet(make, name)
    loaded = quiet(Loaded, law, PEAK)
    work = quiet(law.energy, quiet(law.overlap, np.geomspace(0.5, 200.0, 7)))
    assert quiet(law.energy, loaded.overlap_of_work(work)) == pytest.approx(work, rel=1e-11)


def test_work_beyond_the_end_of_a_table_has_no_overlap():
    law = make("pohrt-popov").tabulate(1e-4, 50.0)
    loaded = Loaded(law, np.array([10.0, 10.0]))
    work = np.array([1.0, 1e3]) * law.energy(law.overlap(20.0))
    found = loaded.overlap_of_work(work)
    assert law.energy(float(found[0])) == pytest.approx(work[0], rel=1e-11)
    assert np.isnan(found[1])


@pytest.mark.parametrize("quantity", QUANTITIES)
def test_a_law_has_no_error_against_itself_and_another_rule_has(quantity):
    law = on_sample("table")
    assert error_of(law, law, SAMPLE, quantity, True).max() < 1e-9
    assert error_of(on_sample("elastic"), law, SAMPLE, quantity, True).max() > 1e-3


def test_a_material_as_the_surface_of_a_scene_is_its_surface():
    granite = dl.materials.granite
    scene = {"radii": 0.01, "materials": granite, "force": 100.0}
    assert dl.Scene(**scene, surfaces=granite) == dl.Scene(**scene, surfaces=[granite.surface])
    with pytest.raises(dl.DemlawsError, match=r"surfaces must be one demlaws\.Surface"):
        dl.Scene(**scene, surfaces="granite")
