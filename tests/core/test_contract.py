"""What a law's Shape and Params may be, checked where they enter: by `bind`, and when a contact's Params are made."""

from typing import NamedTuple

import numpy as np
import pytest
from examples import GRANITE
from own_spring import restored

import demlaws as dl
from demlaws.core.dispatch import bind
from demlaws.core.fastmath import hertz_coefficient, hertz_overlap, kernel, sqrt
from demlaws.core.loops import bind_params


class CountShape(NamedTuple):
    factor: float
    rows: np.ndarray


class CountParams(NamedTuple):
    hertz_coefficient: float
    factor: float  # the name of a field of the Shape, with another value


@kernel
def _scale(shape, radius, modulus, roughness):
    return CountParams(hertz_coefficient(radius, modulus), shape.factor if radius < 6e-3 else 0.5 * shape.factor)


@kernel
def _first_loading(shape, p, overlap):
    root = shape.rows[1] * p.factor * p.hertz_coefficient * sqrt(overlap)
    equivalent = hertz_overlap(p, root * overlap)
    return root * overlap, 1.5 * root, equivalent, equivalent


@kernel
def _inverse(shape, p, force):
    return (force / (shape.rows[1] * p.factor * p.hertz_coefficient)) ** (2.0 / 3.0)


@kernel
def _energy(shape, p, overlap):
    return 0.4 * shape.rows[1] * p.factor * p.hertz_coefficient * overlap**2.5


KERNELS = {"first_loading": _first_loading, "inverse": _inverse, "energy": _energy}
bind(CountShape, scale=_scale)
bind(CountParams, **KERNELS)
TEXTS = {"equation": "", "source": "", "description": "a test", "length": "radius", "collapses": False}


@pytest.fixture
def count():
    with restored():
        yield dl.register(dl.Definition("count", lambda contact: CountShape(1.0, np.array([0.0, 0.5])), **TEXTS))


def test_a_field_of_params_with_the_name_of_a_field_of_the_shape(count):
    for radius, factor in ((4e-3, 0.5), (8e-3, 0.25)):
        contact = GRANITE.with_values(radius=radius)
        hertz = dl.law("hertz", contact).force(1e-6)
        assert dl.law("count", contact, "elastic").force(1e-6) == pytest.approx(factor * hertz, rel=1e-14)


@pytest.mark.parametrize("places", [(0, 1, 2), (2, 0, 1)])
def test_an_array_of_contacts_is_each_of_them(count, places):
    radius = np.array([4e-3, 8e-3, 1e-3])[list(places)]
    many = dl.law("count", GRANITE.with_values(radius=radius), "elastic")
    each = [dl.law("count", GRANITE.with_values(radius=r), "elastic").force(1e-6) for r in radius]
    np.testing.assert_array_equal(many.force(np.full(3, 1e-6)), each)


def of_kind(kind):
    """A Params type whose second field is annotated so."""
    return NamedTuple("OtherParams", [("hertz_coefficient", float), ("times", kind)])


@pytest.mark.parametrize("kind", [int, bool, np.ndarray, str, "int"])
def test_bind_refuses_other_fields_than_floats(kind):
    with pytest.raises(TypeError, match=r"OtherParams: its field 'times' is annotated as .*Params hold floats of one contact"):
        bind(of_kind(kind), **KERNELS)


def test_bind_refuses_params_without_hertz_coefficient():
    with pytest.raises(TypeError, match="need the field hertz_coefficient"):
        bind(NamedTuple("BareParams", [("factor", float)]), **KERNELS)


def test_bind_refuses_kernels_with_other_arguments():
    with pytest.raises(TypeError, match=r"inverse takes \(shape, params, force\), the kernel takes \(p, force\)"):
        bind(CountParams, inverse=kernel(lambda p, force: force))


@pytest.mark.parametrize("value", [1, True, "shape.rows", "(1.0, 2.0)"])
def test_values_other_than_floats_are_refused_by_name(value):
    """An annotation says nothing of what `scale` returns: an integer was that of the first contact for all of an array."""
    from demlaws.core.dispatch import function_of_text

    class WrongShape(NamedTuple):
        rows: np.ndarray

    class WrongParams(NamedTuple):
        hertz_coefficient: float
        times: float

    names = {"Params": WrongParams, "hertz_coefficient": hertz_coefficient}
    scale = function_of_text(
        "shape, radius, modulus, roughness", [f"return Params(hertz_coefficient(radius, modulus), {value})"], names
    )
    bind(WrongShape, scale=kernel(scale))
    with pytest.raises(dl.DemlawsError, match="the field 'times' of its Params is"):
        bind_params(WrongShape(np.zeros(2)), GRANITE)
