"""Batches are vectorised: a loop that stops being so costs several times more. Told by the compiled code, not by time."""

import re

import llvmlite.binding
import numba
import numpy as np
import pytest
from examples import GRANITE, make, pairs

import demlaws as dl
from demlaws.core import loops, numba_compat
from demlaws.laws.registry import registry

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")


def vector_operations(law):
    """Operations on several doubles at once in the compiled loop over a batch."""
    compiled = numba.njit(**numba_compat.OPTIONS)(loops.batch_loop.py_func)
    at = np.linspace(1e-5, 1e-3, 64) * law.contact.radius
    state, out = law.new_state(at.size), (np.zeros(at.size), np.zeros(at.size))
    compiled(law.rule_tag, law.params, at, state.arrays, loops.UNBOUNDED, loops.FINITE, *out)
    (text,) = compiled.inspect_llvm().values()
    return len(re.findall(r"= f\w+ (?:\w+ )*<\d+ x double>", text))


# the last rule that each law takes is the one that does most; the rest of the product is for `make test-all`
PAIRS = [pair for pair in pairs(with_curves=()) if not registry()[pair[0]].implicit]
LAST = {name: unloading for name, unloading in PAIRS}
SHOWN = [("pohrt-popov", LAST["pohrt-popov"]), ("bahrami", "elastic"), ("thornton-ning", LAST["thornton-ning"])]  # a kind each


# seen with numba 0.58: a law without a history is vectorised, one with it is not
with_history = pytest.mark.skipif(llvmlite.binding.llvm_version_info < (15,), reason="LLVM 14 makes no vectors of a history")


@pytest.mark.parametrize(
    ("name", "unloading"),
    [pytest.param(*p, marks=[pytest.mark.slow] * (p not in SHOWN) + [with_history] * (p[1] != "elastic")) for p in PAIRS],
)
def test_a_batch_is_vectorised(name, unloading):
    assert vector_operations(make(name, unloading)) > 10


@with_history
def test_a_batch_of_contacts_that_differ_is_vectorised():
    each = GRANITE.with_values(radius=np.linspace(1e-3, 9e-3, 64))
    assert vector_operations(dl.law("pohrt-popov", each, "hertz")) > 10


@with_history
def test_a_table_is_vectorised():
    assert vector_operations(dl.law("pohrt-popov", GRANITE, "hertz").tabulate(1e-3)) > 10
