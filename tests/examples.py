"""Example contacts and laws. Tests iterate over the registry: a law is tested by existing."""

import functools
import itertools
import warnings
import zlib

import numpy as np
import pytest

import demlaws as dl
from demlaws.core.unloading import GIVEN
from demlaws.laws.registry import registry
from demlaws.make import example_law

GRANITE = dl.Contact(radius=4.35e-3, modulus=32.32e9, sigma=2.40e-6, fractal_dimension=2.22, hardness=6.266e9)
SMOOTHER = dl.Contact(radius=4.04e-3, modulus=32.32e9, sigma=0.15e-6, fractal_dimension=2.075, hardness=6.266e9)
SOFT = dl.Contact(radius=2e-4, modulus=3e8, sigma=1e-7, fractal_dimension=2.6, hardness=4e7)
PLASTIC = {
    "thornton-ning": {"yield_pressure": 1.66e9},
    "conical-damage": {"strength": 1.66e9, "angle": 1.2},
    "luding": {"loading_stiffness": 3e6, "stiffness_ratio": 5.0, "plasticity_depth": 0.005},
    "eepa": {"stiffness_ratio": 3.0, "softness": 0.7},
    "kogut-etsion": {"yield_strength": 1e9},
    "jackson-green": {"yield_strength": 1e9, "poisson": 0.32},
}
"""Laws that yield by themselves, with options for granite."""

CONTACTS = {"granite": GRANITE, "smoother": SMOOTHER, "soft": SOFT}


def options_of(name, contact=GRANITE):
    """What the law's definition asks to be made with; a yield pressure follows the contact's hardness."""
    options = dict(registry()[name].drawing.example)
    if "yield_pressure" in options:
        options["yield_pressure"] = 0.265 * contact.hardness
    strengths = {"strength": 0.265 * contact.hardness, "yield_strength": 0.265 / 1.6 * contact.hardness}
    strengths["loading_stiffness"] = 0.02134 * contact.modulus * contact.radius
    options |= {name: value for name, value in strengths.items() if name in options and contact is not GRANITE}
    return options


@functools.cache
def make(name, unloading="elastic", contact="granite"):
    """The law of this name for an example contact; made once in a test session."""
    one = CONTACTS[contact]
    return example_law(name, one, unloading, **options_of(name, one))


def overlaps(law, points=60):
    """Overlaps [m] from 1e-8 σ (1e-9 R of a smooth contact) to a tenth of the radius, less where the law's kinks lie."""
    contact = law.contact
    low = 1e-9 * contact.radius if contact.is_smooth else 1e-8 * contact.sigma
    values = np.geomspace(low, 0.1 * contact.radius, points)
    for kink in law.kinks():
        values = values[np.abs(values / kink - 1.0) > 1e-6]
    return values


@functools.cache
def accepted(name, unloading):
    """Whether the law takes this rule."""
    try:
        quiet(make, name, unloading)
    except dl.DemlawsError:
        return False
    return True


def rules_of(name):
    """Rules with which a law is tested: all that it is offered; one that unloads in a way of its own, elastic and that way,
    since what the others compile is compiled for other laws."""
    definition = registry()[name]
    return ["elastic", definition.default_rule()] if definition.has_own_rule else list(definition.offered())


def pairs(with_curves=("pohrt-popov", "yip-venart")):
    """(law, unloading rule) that are accepted; rule "table", which takes long to compile, with these laws."""
    rules = {name: [rule for rule in rules_of(name) if rule != GIVEN or name in with_curves] for name in dl.laws()}
    return [(name, unloading) for name in dl.laws() for unloading in rules[name] if accepted(name, unloading)]


def telling(pair):
    """Whether a (law, rule) pair compiles code that no other pair does: each law with the last rule that it takes except
    "table", and every rule with pohrt-popov. Loops, drivers, copies and shear, which use any law alike, are tested with these;
    closed paths and unloading curves with every pair in `make test-all` (core/test_unloading)."""
    name = pair[0]
    return name == "pohrt-popov" or pair == [p for p in pairs(with_curves=()) if p[0] == name][-1]


def shared(values, kept):
    """Parameters of a test: those that are kept run always, the others where slow tests do."""
    return [
        pytest.param(*(value if isinstance(value, tuple) else (value,)), marks=() if kept(value) else pytest.mark.slow)
        for value in values
    ]


def quiet(function, *arguments, **keywords):
    """Call without the warnings that a law gives outside its range."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", dl.ValidityWarning)
        return function(*arguments, **keywords)


ALIKE = ("hertz", "rms", "goddard", "bahrami", "yip-venart", "greenwood-tripp")
ALIKE += ("thornton-ning", "conical-damage", "kogut-etsion", "luding")
"""Laws whose compiled code has no part that another law's has not: where a test is of a loop or an engine, they are slow."""
each_law_and_rule = pytest.mark.parametrize(
    ("name", "unloading"), shared(filter(telling, pairs()), lambda pair: pair[0] not in ALIKE)
)


def sealed(lines):
    """A table file of these lines with a checksum that fits, as a program that edits tables would write it."""
    data = b"".join(line + b"\n" for line in lines)
    return data + b"crc: %08x\n" % zlib.crc32(data)


def work_along(law, corners):
    """∮P dδ from a virgin contact through `corners` [m], by Gauss's rule on the forces alone.

    Branches are cut where the force has a kink (largest overlap so far, plastic overlap, kinks of the law) and graded
    towards the cuts, where it goes as a power of 1.5.
    """
    kinks, curve = law.kinks(), law.unloading_law
    x, weights = np.polynomial.legendre.leggauss(20)
    x, weights = 0.5 * (x + 1.0), 0.5 * weights
    state = law.new_state(1)
    here, work = 0.0, []
    for corner in corners:
        low, high = sorted((here, corner))
        cuts = list(kinks)
        if law.state_size:
            maximum, plastic = float(state.maximum_overlap[0]), float(state.plastic_overlap[0])
            cuts += [maximum, plastic]
            if curve is not None:
                cuts += [plastic + kink for kink in curve.kinks()]
                cuts += [*(plastic + (maximum - plastic) * 0.5 ** np.arange(1, 40))]
        if low <= 0.0:
            cuts += [0.0]
        if low <= 0.0 or law.definition.solved:  # the curve of a measured map has features in every octave
            cuts += [*(high * 0.5 ** np.arange(1, 40))]
        edges = np.unique([low, high, *(c for c in cuts if low < c < high)])
        fine = np.concatenate([np.linspace(a, b, 9)[:-1] for a, b in itertools.pairwise(edges)] + [edges[-1:]])
        a, width = fine[:-1, None], np.diff(fine)[:, None]
        nodes = (a + width * x * x * (3.0 - 2.0 * x)).ravel()
        shares = (width * 6.0 * x * (1.0 - x) * weights).ravel()
        direction = 1.0 if corner > here else -1.0
        order = np.argsort(direction * nodes, kind="stable")
        force = quiet(law.follow, np.append(nodes[order], corner), state).force[:-1]
        work.append(direction * np.sum(force * shares[order]))
        here = corner
    return np.cumsum(work)
