"""How demlaws uses numba: kernels, loops and callbacks, compiled with documented options and kept by numba's own cache.

With NUMBA_DISABLE_JIT=1 nothing is compiled and a debugger steps through loops and kernels, except in YADE.
"""

import contextlib
import functools
import os
import sys
import threading
from types import FunctionType
from typing import Any

import numba
import numpy as np
from numba.extending import lower_builtin, overload, register_jitable, type_callable

from demlaws.core import cache
from demlaws.errors import DemlawsError, warn

OPTIONS: dict[str, Any] = {"error_model": "numpy", "fastmath": {"contract"}, "nogil": True, "no_cfunc_wrapper": True}
"""Of fastmath only ``contract`` (fused multiply-add): all of it would delete checks for NaN."""
INLINED: dict[str, Any] = {**OPTIONS, "forceinline": True}
"""Options of what is compiled into its callers: loops vectorise only if nothing in them is a call."""
_NUMBERS = {float, int, bool, np.float64}
_compiling = threading.RLock()


# a child made while another thread compiles would inherit half of numba's state, locks included: the fork waits
os.register_at_fork(before=_compiling.acquire, after_in_parent=_compiling.release, after_in_child=_compiling.release)


def kernel(function):
    """Make a scalar function known to compiled code, into which it is inlined. Called from Python it is a Python function.

    That of a user is compiled for Python, too, and can be compiled again when one of its globals has changed.
    """
    if hasattr(function, "py_func"):  # it is one already
        return function
    if not (function.__module__ or "demlaws.").startswith("demlaws."):  # one made of text has none
        return numba.njit(**INLINED)(function)
    function.py_func = function
    return register_jitable(**INLINED)(function)


def native(function, result):
    """Decorator of a function that writes LLVM's instructions for `function` in compiled code.

    result: types of the arguments → signature.
    """

    def decorate(generate):
        type_callable(function)(lambda context: result)
        lower_builtin(function, numba.types.VarArg(numba.types.Any))(generate)
        return generate

    return decorate


def loop(function):
    """Compile a function of arrays for the types of its arguments when it is called with them, and keep the machine code."""
    if numba.config.DISABLE_JIT:
        return _stepped(function)
    compiled = {}

    @functools.wraps(function)
    def call(*arguments):
        key = tuple([_kind(value) for value in arguments])
        variant = compiled.get(key)
        if variant is None:
            kinds = tuple(map(numba.typeof, arguments))
            name = cache.name_of(function, kinds, {})
            variant = compiled[key] = _kept(function, name, lambda f, keep: numba.njit(kinds, cache=keep, **OPTIONS)(f))
        return variant(*arguments)

    call.py_func = function
    overload(call, jit_options=OPTIONS, strict=False)(lambda *arguments: function)  # called from compiled code
    return call


def _kind(value):
    """What numba's type of a value depends on, in a tenth of the time that numba needs."""
    kind = type(value)
    if kind in _NUMBERS:
        return kind
    if kind is np.ndarray:
        return value.dtype, value.ndim, value.flags.num & 0x503  # C, Fortran, aligned, writeable
    if isinstance(value, tuple):
        return (kind, *[_kind(item) for item in value])
    return numba.typeof(value)


def callback(signature, function, constants):
    """Compile a function that C++ code can call, at `.address`, and keep the machine code.

    constants: name → numba type or value that the function uses as a global.
    """
    if numba.config.DISABLE_JIT:
        raise DemlawsError("NUMBA_DISABLE_JIT is set: YADE calls compiled functions; unset it")
    bound = FunctionType(function.__code__, {**function.__globals__, **constants}, function.__name__)
    bound.__qualname__ = function.__qualname__
    name = cache.name_of(function, signature.args, constants)
    return _kept(bound, name, lambda f, keep: numba.cfunc(signature, cache=keep, **OPTIONS)(f))


def _kept(function, name, compiled):
    """compiled(function, keep): numba's dispatcher or callback, whose machine code is kept under this name, if there is one."""
    known = name is not None and cache.is_whole(name)  # loading may take long, too, on a busy machine
    with _compiling, contextlib.nullcontext() if known else announced():
        if name is not None:
            try:
                with cache.placed(function, name, known) as ours:
                    return compiled(ours, True)
            except OSError as error:  # a full disk
                warn(f"machine code cannot be kept, each process compiles it again: {error}", UserWarning)
        return compiled(function, False)


@functools.cache
def _say_once() -> None:
    print("demlaws: compiling laws for this machine (once, about 2 to 10 s)", file=sys.stderr, flush=True)


@contextlib.contextmanager
def announced():
    """A line to the standard error, once in a process, if what is compiled within takes longer than a second."""
    timer = threading.Timer(1.0, _say_once)
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


def _stepped(function):
    """A loop in Python: floats are numpy's, of which a division by 0 is infinite as in compiled code."""

    @functools.wraps(function)
    def call(*arguments):
        with np.errstate(all="ignore"):
            return function(*map(_as_numpy, arguments))

    call.py_func = function
    return call


def _as_numpy(value):
    if isinstance(value, tuple):
        items = map(_as_numpy, value)
        return type(value)(*items) if hasattr(value, "_fields") else tuple(items)
    return np.float64(value) if isinstance(value, float) else value
