"""Without numba's internals the results are the same."""

import os
import subprocess
import sys
from pathlib import Path

import numba
import pytest
from processes import python

from demlaws.core import numba_compat

TESTS = Path(__file__).parents[1]


@pytest.mark.parametrize(
    "chosen", ["recoverable and little", pytest.param("yielded or small_grain or history_stays", marks=pytest.mark.slow)]
)
def test_laws_are_the_same_without_numbas_internals(chosen):
    """Tests of loops, unloading, shear and tables, run with numba's documented options only."""
    files = [str(TESTS / name) for name in ("test_exactness.py", "test_law.py")]
    line = [sys.executable, "-m", "pytest", "-q", "-n0", "-x", "-p", "no:cacheprovider", "-k", chosen, *files]
    environment = {**os.environ, "DEMLAWS_PLAIN_NUMBA": "1"}
    done = subprocess.run(line, env=environment, cwd=TESTS.parent, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout


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
