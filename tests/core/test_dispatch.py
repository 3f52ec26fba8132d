"""Generic functions that a type of parameters answers for, and tuples whose arrays hold one entry a contact."""

from typing import NamedTuple

import numpy as np
import pytest

from demlaws.core.dispatch import bind, gather, scatter
from demlaws.core.loops import energy_loop, inverse_loop
from demlaws.core.numba_compat import kernel, loop


class SpringOfTheseTests(NamedTuple):
    stiffness: float


@kernel
def _inverse(p, force):
    return force / p.stiffness


@kernel
def _energy(p, overlap):
    return 0.5 * p.stiffness * overlap**2


bind(SpringOfTheseTests, inverse=_inverse, energy=_energy)


class Inner(NamedTuple):
    a: np.ndarray
    b: float


class Outer(NamedTuple):
    inner: Inner
    c: np.ndarray
    table: np.ndarray  # 2-D: shared by all contacts


def test_the_type_of_the_parameters_decides():
    spring, out = SpringOfTheseTests(4.0), np.zeros(3)
    inverse_loop(spring, np.array([8.0, 0.0, -1.0]), out)
    np.testing.assert_array_equal(out, [2.0, 0.0, 0.0])
    energy_loop(spring, np.array([3.0, 0.0, -1.0]), out)
    np.testing.assert_array_equal(out, [18.0, 0.0, 0.0])


def test_parameters_of_one_contact_each():
    springs = SpringOfTheseTests(np.array([1.0, 2.0, 4.0]))
    out = np.zeros(3)
    inverse_loop(springs, np.full(3, 8.0), out)
    np.testing.assert_array_equal(out, [8.0, 4.0, 2.0])


def test_a_second_type_of_the_name_is_refused():
    """The name goes into the symbols of the machine code."""

    class Other(NamedTuple):
        k: float

    Other.__name__ = SpringOfTheseTests.__name__
    Other.__module__ = "demlaws.laws.made_up"  # a user's would be given another name
    with pytest.raises(TypeError, match=r"SpringOfTheseTests\w*: another law has a type of this name"):
        bind(Other, energy=_energy)


def test_binding_again_adds():
    bind(SpringOfTheseTests, inverse=_inverse)
    test_the_type_of_the_parameters_decides()


@loop
def _twice(source, target):
    for i in range(target.c.size):
        p = gather(source, i)
        scatter(target, i, Outer(Inner(2.0 * p.inner.a, p.inner.b), p.inner.b + p.c, p.table))
    return gather(source, 1).table[0, 1]


def test_gather_and_scatter_are_each_others_reverse():
    """1-D arrays go by contact, through tuples in tuples; numbers and tables are common to all contacts."""
    table = np.array([[1.0, 7.0]])
    source = Outer(Inner(np.array([1.0, 2.0, 3.0]), 0.5), np.array([10.0, 20.0, 30.0], np.float32), table)
    target = Outer(Inner(np.zeros(3), 0.0), np.zeros(3, np.float32), table)
    assert _twice(source, target) == 7.0
    np.testing.assert_array_equal(target.inner.a, [2.0, 4.0, 6.0])
    np.testing.assert_array_equal(target.c, np.array([10.5, 20.5, 30.5], np.float32))
    assert target.inner.b == 0.0 and target.table is table
