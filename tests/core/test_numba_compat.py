"""Use of numba: documented options, with any release, and without compiling."""

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from examples import make
from processes import PACKAGE, python

TESTS = Path(__file__).parents[1]


@pytest.mark.slow
@pytest.mark.parametrize("chosen", ["recoverable and little", "yielded or small_grain or history_stays"])
def test_laws_are_the_same_with_a_later_numba(chosen):
    """Tests of loops, unloading, shear and tables, run with a version that numba will have."""
    files = [str(TESTS / name) for name in ("test_exactness.py", "test_law.py")]
    line = ["-q", "-n0", "-x", "-p", "no:cacheprovider", "-k", chosen, *files]
    code = f"import sys, numba; numba.__version__ = '0.99.0'; import pytest; sys.exit(pytest.main({line!r}))"
    done = subprocess.run([sys.executable, "-c", code], env={**os.environ}, cwd=TESTS.parent, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout


def test_few_files_use_numbas_internals():
    pattern = re.compile(r"^\s*(?:from|import) numba\.(?:core|np)\b", re.MULTILINE)
    found = [path.name for path in PACKAGE.rglob("*.py") for _ in pattern.findall(path.read_text())]
    assert len(found) <= 2, found


STEPPED = """
    import sys
    sys.path[:0] = [TESTS]
    import numpy as np
    from examples import GRANITE, make
    import demlaws as dl
    path = GRANITE.sigma * np.array([0.5, 2.0, 1.0, -0.1, 3.0])
    for law in (*[make(*pair) for pair in PAIRS], make("pohrt-popov", "hertz").tabulate(1e-3)):
        response = law.follow(path)
        print(*response.force, *response.stiffness, *response.stored, *law.overlap([1.0, 10.0]), law.force(1e-6))
"""
PAIRS = [("hertz", "elastic"), ("pohrt-popov", "thornton"), ("rough-plastic", "thornton"), ("rms", "table")]


@pytest.mark.slow
def test_without_compiling_the_numbers_are_the_same():
    """NUMBA_DISABLE_JIT=1, for a debugger: every line of a kernel runs in Python."""
    code = STEPPED.replace("TESTS", repr(str(TESTS))).replace("PAIRS", repr(PAIRS))
    compiled, stepped = (
        np.array([list(map(float, line.split())) for line in python(code, NUMBA_DISABLE_JIT=setting).splitlines()])
        for setting in (0, 1)
    )
    assert compiled.shape[0] == len(PAIRS) + 1
    np.testing.assert_allclose(stepped, compiled, rtol=1e-9)


def test_yade_says_why_it_needs_the_compiler():
    code = """
        from numba import types
        from demlaws.core.numba_compat import callback
        from demlaws.errors import DemlawsError
        try:
            callback(types.float64(types.float64), lambda x: x, {})
        except DemlawsError as error:
            print(error)
    """
    assert python(code, NUMBA_DISABLE_JIT=1).startswith("NUMBA_DISABLE_JIT is set")


def test_a_kernel_is_a_python_function_too():
    law = make("pohrt-popov", "hertz")
    from demlaws.core.dispatch import step

    overlap = 2.0 * law.contact.sigma
    force, stiffness, state = step(law.rule_tag, law.shape, law.params, overlap, (0.0, 0.0))
    path = law.follow([overlap])
    assert (force, stiffness) == pytest.approx((path.force[0], path.stiffness[0]), rel=1e-12)
    assert state == pytest.approx((path.maximum_overlap[0], path.plastic_overlap[0]), rel=1e-9)
