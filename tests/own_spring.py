"""Files with a user-defined law, one with a rule of its own, outside the package; tests of several engines write that one."""

import contextlib
import textwrap

import numpy as np

import demlaws as dl
from demlaws.laws import registry

POWER = """
import demlaws as dl

def force(p, overlap):
    return p.factor * overlap**p.exponent

def stiffness(p, overlap):
    return p.factor * p.exponent * overlap**(p.exponent - 1)

options = {"factor": 3e9, "exponent": (1.7, "", "of the overlap")}
dl.register(dl.define("power", force, stiffness, options=options, description="power of the overlap"))
"""
SPRING = """
    from typing import NamedTuple

    import demlaws as dl
    from demlaws.core.dispatch import bind, energy, first_loading, unloading_curve
    from demlaws.core.fastmath import kernel, sqrt
    from demlaws.core.fastmath import hertz_coefficient, hertz_overlap
    from demlaws.core.unloading import Rule, own_rule
    from demlaws.laws.definition import Definition, Drawing, Option, Rules

    class SpringShape(NamedTuple):
        stiffness: float
        lost: float  # share of the largest overlap that stays

    class SpringParams(NamedTuple):
        hertz_coefficient: float

    @kernel
    def _scale(shape, radius, modulus, roughness):
        return SpringParams(hertz_coefficient(radius, modulus))

    @kernel
    def _first_loading(shape, p, overlap):
        force = shape.stiffness * overlap
        equivalent = hertz_overlap(p, force)
        return force, shape.stiffness, equivalent, equivalent

    @kernel
    def _inverse(shape, p, force):
        return force / shape.stiffness

    @kernel
    def _energy(shape, p, overlap):
        return 0.5 * shape.stiffness * overlap * overlap

    bind(SpringShape, scale=_scale)
    bind(SpringParams, first_loading=_first_loading, inverse=_inverse, energy=_energy)

    class Slack(NamedTuple):
        '''Back along a straight line from (δmax, Pmax) to δp = lost δmax.'''

    @kernel
    def _step(rule, shape, p, overlap, state):
        lost = unloading_curve(shape, p)[0].lost
        positive = 0.0 if overlap <= 0.0 else overlap
        maximum, top = state
        if overlap >= state[0]:
            force, stiffness, _, _ = first_loading(shape, p, positive)
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
    def _energies(rule, shape, p, overlap, state):
        if state[0] <= 0.0:
            return 0.0, 0.0
        lost = unloading_curve(shape, p)[0].lost
        whole = state[0] * (1.0 - lost)
        elastic = max(overlap - lost * state[0], 0.0) if overlap > 0.0 else 0.0
        return 0.5 * state[1] * elastic * elastic / whole, energy(shape, p, state[0]) - 0.5 * state[1] * whole

    @kernel
    def _unloaded(rule, shape, p, force, state):
        lost = unloading_curve(shape, p)[0].lost
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
        rules=Rules(default="slack", own=(SLACK,)),
        drawing=Drawing(),
        options={"stiffness": Option("N/m", "above 0", "k"), "lost": Option("", "0 to 1", "share that stays")},
    ))
"""


@contextlib.contextmanager
def restored():
    """Whatever is registered or loaded within goes again at its end."""
    known = (registry._user_laws, registry._homes, registry._checksums, registry._loaded)
    kept = [one.copy() for one in known]
    try:
        yield
    finally:
        for one, old in zip(known, kept, strict=True):
            one.clear()
            one.update(old)


@contextlib.contextmanager
def registered(folder, text=SPRING, name="my_spring.py"):
    """The file's law, as long as the block lasts; the path of the file."""
    file = folder / name
    file.write_text(textwrap.dedent(text))
    with restored():
        dl.load_laws(file)
        yield file


def expected(path, lost=0.4, stiffness=2e6):
    """Force [N] of the law along overlaps [m]."""
    forces, maximum = [], 0.0
    for overlap in path:
        maximum = max(maximum, overlap) if overlap > 0.0 else 0.0
        slope = stiffness / (1.0 - lost)
        forces.append(stiffness * overlap if overlap == maximum else max(0.0, slope * (overlap - lost * maximum)))
    return np.array(forces)
