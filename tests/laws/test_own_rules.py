"""A rule for unloading that a user brings with a law of their own, from a file outside the package."""

import textwrap

import numpy as np
import pytest
from examples import GRANITE

import demlaws as dl
from demlaws.core.unloading import Rule, own_rule
from demlaws.laws import registry

SPRING = """
    from typing import NamedTuple

    import demlaws as dl
    from demlaws.core.dispatch import bind, energy, parts, virgin
    from demlaws.core.fastmath import kernel, sqrt
    from demlaws.core.hertz import hertz_coefficient, hertz_overlap
    from demlaws.core.unloading import Rule, own_rule
    from demlaws.laws.definition import Definition, Option

    class SpringShape(NamedTuple):
        stiffness: float
        lost: float  # share of the largest overlap that stays

    class SpringParams(NamedTuple):
        hertz_coefficient: float
        stiffness: float
        lost: float

    @kernel
    def _scale(shape, radius, modulus, roughness):
        return SpringParams(hertz_coefficient(radius, modulus), shape.stiffness, shape.lost)

    @kernel
    def _virgin(p, overlap):
        force = p.stiffness * overlap
        equivalent = hertz_overlap(p, force)
        return force, p.stiffness, equivalent, equivalent

    @kernel
    def _inverse(p, force):
        return force / p.stiffness

    @kernel
    def _energy(p, overlap):
        return 0.5 * p.stiffness * overlap * overlap

    bind(SpringShape, scale=_scale)
    bind(SpringParams, virgin=_virgin, inverse=_inverse, energy=_energy)

    class Slack(NamedTuple):
        '''Back along a straight line from (δmax, Pmax) to δp = lost δmax.'''

    @kernel
    def _step(rule, p, overlap, state):
        lost = parts(p)[1].lost
        positive = 0.0 if overlap <= 0.0 else overlap
        maximum, top = state
        if overlap >= state[0]:
            force, stiffness, _, _ = virgin(p, positive)
            maximum, top = overlap, force
        else:
            stiffness = top / (maximum * (1.0 - lost))
            elastic = positive - lost * maximum
            force = 0.0 if elastic <= 0.0 else stiffness * elastic
            stiffness = 0.0 if elastic <= 0.0 else stiffness
        if overlap <= 0.0:
            force, stiffness, maximum, top = 0.0, 0.0, 0.0, 0.0
        return force, stiffness, (maximum, top)

    @kernel
    def _energies(rule, p, overlap, state):
        if state[0] <= 0.0:
            return 0.0, 0.0
        lost = parts(p)[1].lost
        whole = state[0] * (1.0 - lost)
        elastic = max(overlap - lost * state[0], 0.0) if overlap > 0.0 else 0.0
        return 0.5 * state[1] * elastic * elastic / whole, energy(p, state[0]) - 0.5 * state[1] * whole

    @kernel
    def _unloaded(rule, p, force, state):
        lost = parts(p)[1].lost
        return state[0] * (lost + (1.0 - lost) * force / state[1])

    bind(Slack, step=_step, stored_and_dissipated=_energies, unloaded=_unloaded)
    STATE = ("maximum_overlap", "largest_force")
    SLACK = own_rule(Rule("slack", Slack(), STATE, "law", None, "straight back to a share of δmax"))

    dl.register(Definition(
        name="spring",
        prepare=lambda contact, stiffness=2e6, lost=0.4: SpringShape(float(stiffness), float(lost)),
        equation="P = k δ",
        source="a test",
        description="a spring with slack",
        limits=lambda contact, **options: [],
        length="radius",
        collapses=False,
        unloading=("elastic", "slack"),
        rules=(SLACK,),
        default_unloading="slack",
        label="spring",
        options={"stiffness": Option("N/m", "above 0", "k"), "lost": Option("", "0 to 1", "share that stays")},
    ))
"""
PATH = np.array([1e-5, 8e-6, 5e-6, 3e-6, 9e-6, 1e-5, 2e-5, 1.5e-5, 0.0, 1e-6])


@pytest.fixture(scope="module", autouse=True)
def spring(tmp_path_factory):
    """The law, from a file; it goes with the module."""
    file = tmp_path_factory.mktemp("laws") / "my_spring.py"
    file.write_text(textwrap.dedent(SPRING))
    with registry.restored():
        assert dl.load_laws(file) == ["spring"]
        yield


def expected(path, lost=0.4, stiffness=2e6):
    forces, maximum = [], 0.0
    for overlap in path:
        maximum = max(maximum, overlap) if overlap > 0.0 else 0.0
        slope = stiffness / (1.0 - lost)
        forces.append(stiffness * overlap if overlap == maximum else max(0.0, slope * (overlap - lost * maximum)))
    return np.array(forces)


def test_it_is_the_laws_default_and_follows_its_path():
    law = dl.law("spring", GRANITE)
    assert (law.unloading, law.state_names) == ("slack", ("maximum_overlap", "largest_force"))
    path = law.follow(PATH)
    np.testing.assert_allclose(path.force, expected(PATH), rtol=1e-12, atol=1e-12)
    assert path.dissipated[4] == pytest.approx(0.5 * 2e6 * 1e-10 * 0.4, rel=1e-12)
    batch, state = np.full(50, 1e-5), law.new_state(50)
    law.evaluate(batch, state)
    np.testing.assert_allclose(law.evaluate(0.8 * batch, state)[0], expected([1e-5, 8e-6])[1], rtol=1e-12)


def test_a_table_in_memory_has_it_too_but_no_file_does(tmp_path):
    law = dl.law("spring", GRANITE, lost=0.3)
    table = law.tabulate(1e-6)
    assert table.unloading == "slack"
    np.testing.assert_allclose(table.follow(PATH).force, expected(PATH, 0.3), rtol=1e-6, atol=1e-6)
    with pytest.raises(
        dl.DemlawsError, match=r"rule 'slack' of law 'spring' is its own and stands in no table file.*unloading=dl.law"
    ):
        table.save(tmp_path / "spring.tbl")
    assert list(tmp_path.iterdir()) == []
    assert dl.Table.load(table.joined("elastic").save(tmp_path / "elastic.tbl")).unloading == "elastic"


def test_no_other_law_is_offered_it():
    with pytest.raises(dl.DemlawsError, match="unknown unloading rule 'slack'"):
        dl.law("hertz", GRANITE, "slack")


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"name": "hertz"}, "another unloading rule 'hertz'"),
        ({"name": "linear"}, "another unloading rule 'linear'"),
        ({"state": ("a", "b", "c", "d")}, "remembers 4 numbers, engines keep 3"),
        ({"curve": "hertz"}, "curve must be 'law'"),
    ],
)
def test_rules_that_will_not_do(changes, text):
    good = Rule("other", (), ("maximum_overlap",), "law", None, "nothing")
    with pytest.raises(TypeError, match=text):
        own_rule(good._replace(**changes))
