"""Without numba's internals the results are the same."""

import numba
import numpy as np
import pytest
from processes import python

from demlaws.core import numba_compat

PROGRAM = """
    import ctypes
    import numpy as np
    from numba import types
    import demlaws as dl
    from demlaws.core import numba_compat
    from demlaws.core.numba_compat import callback, kernel, loop

    contact = dl.Contact(radius=4.35e-3, modulus=32.32e9, roughness=2.40e-6, fractal_dimension=2.22, hardness=6.266e9)
    several = contact.with_values(radius=np.array([4e-3, 5e-3, 6e-3]))
    found = []
    for name, unloading, options in (
        ("hertz", "elastic", {}), ("pohrt-popov", "hertz", {}), ("rough-plastic", "thornton", {"yield_pressure": 1.66e9})
    ):
        law = dl.law(name, contact, unloading, **options)
        overlap = np.array([1e-6, 5e-6, 4e-6, 0.0, 2e-6])
        found += [law.energy(1e-6), law.overlap(10.0), *law.force(overlap), *law.stiffness(overlap)]
        found += [*law.follow(overlap).force, *law.follow(overlap).dissipated, *law.shear_stiffness(overlap, 0.8)]
        found += [law.tabulate(rtol=1e-3).force(2e-6)]
        law = dl.law(name, several, unloading, **options)
        found += [*law.evaluate(overlap[:3], law.new_state(3) if law.state_size else None)[0]]

    @loop
    def twice(x):
        return 2.0 * x

    @kernel
    def four_times(x):
        return 2.0 * twice(x)

    FACTOR = None

    def scaled(x):
        return FACTOR * four_times(x)

    for factor in (2.0, 3.0):
        compiled = callback(types.float64(types.float64), scaled, {"FACTOR": factor})
        found.append(ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_double)(compiled.address)(10.0))
    print(numba_compat.PLAIN, *map(repr, map(float, found)))
"""


def test_results_are_the_same_without_numbas_internals():
    usual, plain = (python(PROGRAM, DEMLAWS_PLAIN_NUMBA=value).split() for value in ("0", "1"))
    assert (usual[0], plain[0]) == ("False", "True")
    expected = np.array(usual[1:], float)
    assert expected.size > 80 and np.isfinite(expected).all()
    assert list(expected[-2:]) == [80.0, 120.0]
    np.testing.assert_allclose(np.array(plain[1:], float), expected, rtol=1e-12)


@pytest.mark.parametrize(
    ("release", "forced", "plain"),
    [
        ("0.58.1", "", False),
        ("0.68.1", "", False),
        ("0.69.0rc1", "", True),
        ("1.0", "", True),
        ("1.0", "0", False),
        ("0.60", "1", True),
    ],
)
def test_internals_of_untested_releases_are_not_used(monkeypatch, release, forced, plain):
    monkeypatch.setattr(numba, "__version__", release)
    monkeypatch.setenv("DEMLAWS_PLAIN_NUMBA", forced)
    assert numba_compat._is_plain() is plain


def test_machine_code_that_cannot_be_kept_is_no_error(tmp_path):
    """An internal of numba that has changed costs the files, not the compilation."""
    code = """
        from numba.core.compiler import CompileResult
        del CompileResult._reduce
        import demlaws as dl
        print(dl.law("hertz", dl.Contact(radius=1e-2, modulus=1e10)).stiffness(1e-6))
    """
    assert float(python(code, NUMBA_CACHE_DIR=tmp_path)) == pytest.approx(2e6)
    assert not list(tmp_path.rglob("*.nbc"))
