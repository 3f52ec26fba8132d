"""The elementary functions against mpmath, in ε; the errors are those that their docstrings quote."""

import math

import mpmath
import numba
import numpy as np
from references import EPS, errors

from demlaws.core.fastmath import cbrt, exp2, log2, power


def over(function):
    """A compiled loop over one or two arrays."""

    @numba.njit
    def one(x, out):
        for i in range(x.size):
            out[i] = function(x[i])

    @numba.njit
    def two(x, y, out):
        for i in range(x.size):
            out[i] = function(x[i], y[i])

    def call(*arrays):
        out = np.empty(arrays[0].size)
        (one if len(arrays) == 1 else two)(*arrays, out)
        return out

    return call


def test_cbrt(rng):
    x = np.concatenate([10.0 ** rng.uniform(-300, 300, 4000), 1 + rng.uniform(-1e-3, 1e-3, 500), np.arange(1.0, 200.0) ** 3])
    measured = errors(over(cbrt)(x), [mpmath.cbrt(mpmath.mpf(v)) for v in x])
    assert measured.max() <= 1.0
    assert measured.mean() <= 0.5


def test_cbrt_at_the_ends():
    values = over(cbrt)(np.array([0.0, math.inf, math.nan, np.finfo(float).max, np.finfo(float).tiny]))
    assert values[0] == 0.0
    assert values[1] == math.inf
    assert math.isnan(values[2])
    np.testing.assert_allclose(values[3:], np.cbrt([np.finfo(float).max, np.finfo(float).tiny]), rtol=4 * EPS)


def test_log2(rng):
    x = np.concatenate(
        [10.0 ** rng.uniform(-300, 300, 3000), 2.0 ** rng.uniform(-2, 2, 2000), 1 + rng.uniform(-1e-6, 1e-6, 500)]
    )
    exact = [mpmath.log(mpmath.mpf(v), 2) for v in x]
    values = over(log2)(x)
    mantissa, _ = np.frexp(x)
    mantissa = np.where(mantissa < math.sqrt(0.5), 2 * mantissa, mantissa)
    scale = np.maximum(np.abs(np.log2(x)), 0.5 * np.abs(np.log2(mantissa)))
    error = np.array([float(abs(mpmath.mpf(float(v)) - e)) for v, e in zip(values, exact, strict=True)])
    assert np.max(error[scale > 0] / scale[scale > 0]) <= 2.0 * EPS
    np.testing.assert_array_equal(over(log2)(2.0 ** np.arange(-1000.0, 1000.0)), np.arange(-1000.0, 1000.0))


def test_exp2(rng):
    x = np.concatenate([rng.uniform(-1020, 1023, 3000), rng.uniform(-1, 1, 2000), rng.uniform(-1e-9, 1e-9, 200)])
    measured = errors(over(exp2)(x), [mpmath.mpf(2) ** mpmath.mpf(v) for v in x])
    assert measured.max() <= 1.0
    whole = np.arange(-1020.0, 1023.0)
    np.testing.assert_array_equal(over(exp2)(whole), 2.0**whole)


def test_power(rng):
    x = 10.0 ** rng.uniform(-90, 90, 3000)
    exponent = rng.uniform(1e-3, 3.4, x.size)
    measured = errors(over(power)(x, exponent), [mpmath.mpf(a) ** mpmath.mpf(b) for a, b in zip(x, exponent, strict=True)])
    assert np.max(measured / (1.0 + np.abs(exponent * np.log(x)))) <= 1.0


def test_power_is_monotone_and_continuous_over_its_seams():
    for exponent in (0.3, 0.75, 1.5, 3.3):
        x = np.geomspace(1e-3, 1e3, 20001)
        assert np.all(np.diff(over(power)(x, np.full(x.size, exponent))) > 0)
    edge = math.sqrt(0.5) * (1 + EPS * np.arange(-8, 9))
    np.testing.assert_allclose(over(power)(edge, np.full(17, 1.7)), edge**1.7, rtol=4 * EPS)
