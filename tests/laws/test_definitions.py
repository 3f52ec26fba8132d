"""What every law declares in its own file, and that nothing elsewhere knows a law by name."""

import contextlib
import inspect
import math
import re

import numpy as np
import pytest
from examples import GRANITE, make, quiet

import demlaws as dl
from demlaws.curves.closed import FormulaCurve
from demlaws.curves.soundness import refuse_unless_collapses
from demlaws.errors import NotPassive
from demlaws.laws.definition import OF_CONTACT
from demlaws.laws.registry import find, registry


@pytest.mark.parametrize(("name", "option"), [(n, o) for n, d in registry().items() for o in d.options], ids="-".join)
def test_an_option_is_refused_outside_its_range(name, option):
    """Junk; a strength without its unit, of 1.66 GPa the number alone; nothing where a value is needed."""
    definition = find(name)
    example, record = definition.drawing.example, definition.options[option]
    wrong = [example | {option: value} for value in (math.nan, -1.0, "steep", object())]
    if option in example and record.unit == "Pa":
        wrong.append(example | {option: 1e-9 * example[option]})
    if "needed" in record.meaning:
        wrong.append({key: value for key, value in example.items() if key != option})
    for options in wrong:
        with pytest.raises(dl.DemlawsError):
            dl.law(name, GRANITE, **options)


@pytest.mark.parametrize("name", dl.laws())
def test_facts_agree_with_one_another(name):
    definition = find(name)
    assert definition.unloading[0] == "elastic"
    assert set(definition.unloading) <= set(definition.offered())
    assert definition.default_rule() in definition.unloading
    assert not set(definition.rules.refused) & set(definition.offered())
    assert set(definition.fitting.free) <= {"modulus", *definition.fitting.parameters}
    assert re.fullmatch(r"#[0-9a-f]{6}", definition.drawing.colour)
    taken = [p.name for p in inspect.signature(definition.prepare).parameters.values() if p.kind is not p.VAR_KEYWORD]
    assert list(definition.options) == taken[1:]
    for parameter, one in definition.fitting.parameters.items():
        low, high = one.bounds(GRANITE)
        assert all(low <= start <= high for start in np.atleast_1d(one.starts(GRANITE)))
        assert one.option == (parameter not in OF_CONTACT)
        if one.option:  # the law takes it
            shape = definition.shape(
                GRANITE, **{**definition.drawing.example, parameter: float(np.atleast_1d(one.starts(GRANITE))[0])}
            )
            assert type(shape) is type(make(name).shape)


def test_warnings_begin_where_their_reasons_state():
    """α = 5 and 1 of rms, p0' = 0.01 of bahrami, tips that crush at h > 5 A of conical-damage."""
    rough = GRANITE.with_values(hardness=None)
    for limit in find("rms").limits(rough):
        assert f"α > {rough.roughness_parameter(limit.minimum_force):.6g}:" in limit.reason
    (first,) = (limit for limit in find("bahrami").limits(GRANITE) if limit.minimum_force > 0.0)
    kappa = GRANITE.hardness / GRANITE.modulus * math.sqrt(GRANITE.radius / GRANITE.sigma)
    alpha = GRANITE.roughness_parameter(first.minimum_force)
    assert 1.0 / (1.0 + 1.22 * alpha * kappa**-0.16) == pytest.approx(0.01, rel=1e-9)
    strength = 2e9
    h = (0.5 * math.pi * strength / GRANITE.modulus) ** 2
    for share, warned in ((1.0 - 1e-6, True), (1.0 + 1e-6, False)):
        angle = math.asin(1.0 / (1.0 + share * h / 5.0))  # A = (1 - sin α)/sin α
        limits = find("conical-damage").limits(GRANITE, strength=strength, angle=angle)
        assert len(limits) == warned
    (limit,) = find("conical-damage").limits(GRANITE, strength=strength, angle=1.57)
    law = dl.law("conical-damage", GRANITE, "elastic", strength=strength, angle=1.57)
    assert limit.maximum_force == pytest.approx(quiet(law.force, law.params.yield_overlap), rel=1e-12)


@pytest.mark.parametrize("share", [0.99, 1.01, 2.4])
def test_crushed_tips_unload_where_they_store_less_than_was_done(share):
    """A = `share` h/5; 2.4 is YADE's example HertzMindlinExtended_periodicSimpleShear.py, whose K is above Hertz's of R0."""
    contact, strength = dl.Contact(0.05, 1e7 / 1.82), 5e5
    h = (0.5 * math.pi * strength / contact.modulus) ** 2
    options = {"strength": strength, "angle": math.asin(1.0 / (1.0 + share * h / 5.0))}
    if share < 1.0:
        with pytest.raises(dl.errors.NotPassive):
            quiet(dl.law, "conical-damage", contact, "thornton", **options)
        return
    law = quiet(dl.law, "conical-damage", contact, "thornton", **options)
    assert quiet(law.tabulate, rtol=1e-5).unloading == "thornton"
    turns = 0.09 * contact.radius * np.random.default_rng(2).random(60)
    overlap = np.interp(np.linspace(0.0, 60.0, 60_001), np.arange(61), [*turns, 1e-9 * contact.radius])
    path, loading = quiet(law.follow, overlap), dl.law("conical-damage", contact, "elastic", **options)
    force = quiet(loading.force, overlap.max())
    smooth = dl.law("hertz", contact)
    assert quiet(loading.stiffness, overlap.max()) > 1.3 * quiet(smooth.stiffness, quiet(smooth.overlap, force))
    lost = np.sum(0.5 * (path.force[1:] + path.force[:-1]) * np.diff(overlap)) + path.stored[0] + path.dissipated[0]
    assert lost == pytest.approx(path.dissipated[-1], rel=1e-4) and path.dissipated[-1] > 0.0
    assert np.diff(path.dissipated).min() >= -1e-12 * path.dissipated.max()


REFUSED = {"bahrami": {"hertz"}}
"""Rules of a law that its example's contact would return work with."""


@pytest.mark.parametrize("name", dl.laws())
def test_an_offered_rule_is_taken_or_not_passive(name):
    """Examples are refused as NotPassive only: none with "elastic" and the law's default, with its other rules those named."""
    taken = {make(name).unloading}
    for rule in find(name).offered():
        with contextlib.suppress(NotPassive):
            taken.add(quiet(make, name, rule).unloading)
    assert {"elastic", find(name).default_rule(**find(name).drawing.example)} <= taken
    assert set(find(name).unloading) - taken == REFUSED.get(name, set())


def test_colours_and_ranks_differ():
    definitions = registry().values()
    assert len({d.drawing.colour for d in definitions}) == len(definitions)
    ranks = [d.advice.rank for d in definitions if d.advice.rank]
    assert len(set(ranks)) == len(ranks) >= 4


@pytest.mark.parametrize("name", [n for n, d in registry().items() if d.before_yield()[0] is not None])
def test_a_yielding_law_needs_what_its_rough_law_needs(name):
    definition = find(name)
    for loading in ("pohrt-popov", "yip-venart", "hertz"):
        assert set(definition.needed(**definition.drawing.example, loading=loading)) == {
            *definition.loading.needs,
            *find(loading).loading.needs,
        }


@pytest.mark.parametrize("name", [n for n, d in registry().items() if not d.solved and not d.needs_map])
def test_a_law_says_whether_it_collapses(name):
    """One dimensionless curve for all radii, moduli and roughnesses, or not: as measured, not only as declared."""
    law = make(name)
    measured = law.definition._replace(collapses=True)
    try:
        refuse_unless_collapses(FormulaCurve(measured, law.contact, law.options), law.contact)
        found = True
    except dl.DemlawsError:
        found = False
    assert law.definition.collapses == found


SPRING, YIELD = {"loading_stiffness": 3e6}, {"yield_pressure": 1e9}
BAD_OPTIONS = {  # what is more than one option's range
    "bahrami": [{"constant": 2.0}],
    "goddard": [{"slope": 1.5}, {"slope": 0.1, "steepness": 0.2}],
    "greenwood-tripp": [{"mu": 0.01}],
    "yip-venart": [{"seating_share": 2.0}],
    "walton-braun": [
        SPRING | {"stiffness_ratio": 2.0, "growth": 1.0},
        SPRING | {"stiffness_ratio": 0.9},
        SPRING | {"growth": -1.0},
    ],
    "rough-plastic": [
        YIELD | {"loading": "rms", "steepness": 0.2},
        # laws that yield by themselves
        *(YIELD | find(name).drawing.example | {"loading": name} for name in registry() if find(name).has_own_rule),
        YIELD | {"loading": "rough-plastic"},
    ],
    "conical-damage": [{"strength": 1e9, "angle": 1.6}],
    "luding": [SPRING | {"stiffness_ratio": 1.0, "plasticity_depth": 0.1}],
    "eepa": [{"stiffness_ratio": 0.5}],
    "jackson-green": [{"yield_strength": 1e9, "poisson": 0.6}],
}


@pytest.mark.parametrize(("name", "options"), [(name, one) for name, several in BAD_OPTIONS.items() for one in several])
def test_bad_options(name, options):
    with pytest.raises(dl.DemlawsError):
        dl.law(name, GRANITE, **options)
