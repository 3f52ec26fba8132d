"""Batches are vectorised: a loop that is not costs several times more. Read from the compiled code, not from times.

The code is compiled for fixed processors, in a process for each, so that the outcome does not depend on the machine.
"""

import os
import pickle
import platform
import re
import subprocess
import sys
from pathlib import Path

import llvmlite.binding
import numba
import numpy as np
import pytest
from examples import GRANITE, make, pairs

import demlaws as dl
from demlaws.core import loops, numba_compat
from demlaws.laws.definition import CLOSED, HERTZ_CURVE
from demlaws.laws.registry import registry

pytestmark = [
    pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning"),
    # numba 0.58 has LLVM 14, which vectorises no loop with a history
    pytest.mark.skipif(llvmlite.binding.llvm_version_info < (15,), reason="LLVM 14 does not vectorise a history"),
    pytest.mark.skipif(platform.machine() != "x86_64", reason="the targets are x86-64 processors"),
]

CLOSED = [pair for pair in pairs(with_curves=()) if registry()[pair[0]].loading.computed in (HERTZ_CURVE, CLOSED)]


def arguments(law):
    """What the loop over a batch of 64 contacts is called with."""
    at = np.linspace(1e-5, 1e-3, 64) * np.max(law.contact.radius)
    state = law.new_state(at.size)
    path = at, state.arrays, loops.UNBOUNDED, loops.FINITE, np.zeros(at.size), np.zeros(at.size)
    return law.rule_tag, law.shape, law.params, *path


def laws_of_every_kind():
    """Name → law: with and without a history, with bulk yield, as a table, of contacts that differ."""
    names = [("pohrt-popov", "elastic"), ("rough-plastic", "hertz"), ("rough-plastic", "thornton")]
    laws = {" ".join(pair): make(*pair) for pair in names}
    laws["each"] = dl.law("pohrt-popov", GRANITE.with_values(radius=np.linspace(1e-3, 9e-3, 64)), "hertz")
    laws["table elastic"] = make("pohrt-popov", "elastic").tabulate(1e-3)
    laws["table hertz"] = make("pohrt-popov", "hertz").tabulate(1e-3)
    return laws


def vector_operations(kinds):
    """Operations on several doubles at once in the loop over a batch, compiled for arguments of these types, not called."""
    compiled = numba.njit(**numba_compat.OPTIONS)(loops.batch_loop.py_func)
    compiled.compile(kinds)
    (text,) = compiled.inspect_llvm().values()
    return len(re.findall(r"= f\w+ (?:\w+ )*<\d+ x double>", text))


def scalar(target, laws):
    """Names of the laws whose loop is not vectorised for a target, in a process whose compiler has that target."""
    environment = {**os.environ, "NUMBA_CPU_NAME": target, "NUMBA_CPU_FEATURES": ""}
    paths = [str(Path(__file__).parents[1]), *sys.path]
    environment["PYTHONPATH"] = os.pathsep.join(filter(None, paths))
    sent = pickle.dumps({name: arguments(law) for name, law in laws.items()})
    done = subprocess.run([sys.executable, __file__], env=environment, input=sent, capture_output=True)
    assert done.returncode == 0, done.stderr.decode()
    found = pickle.loads(done.stdout)
    assert found.keys() == laws.keys()
    return {name for name, number in found.items() if number < 10}


@pytest.mark.slow
def test_batches_are_vectorised_for_avx2():
    # AVX2 does not gather the rows of a table under a condition, which a history is
    assert scalar("haswell", laws_of_every_kind()) == {"table hertz"}


@pytest.mark.slow
def test_batches_are_vectorised_for_avx512():
    assert scalar("x86-64-v4", laws_of_every_kind()) == set()


@pytest.mark.slow
@pytest.mark.parametrize("target", ["x86-64-v2", "haswell", "znver3", "x86-64-v4"])
def test_every_law_with_every_rule_is_vectorised(target):
    laws = {" ".join(pair): make(*pair) for pair in CLOSED}
    # SSE4.2 does not store under a condition: there histories, and these two laws, are scalar
    without = {name for name in laws if not name.endswith(" elastic")} | {"thornton-ning elastic", "conical-damage elastic"}
    assert scalar(target, laws) == (without if target == "x86-64-v2" else set())


if __name__ == "__main__":
    received = pickle.loads(sys.stdin.buffer.read())
    kinds = {name: tuple(map(numba.typeof, values)) for name, values in received.items()}
    sys.stdout.buffer.write(pickle.dumps({name: vector_operations(kind) for name, kind in kinds.items()}))
