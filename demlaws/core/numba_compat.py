"""Everything that numba does not promise, in one module, and the way without it.

With the releases of numba up to `TESTED`, kernels are compiled without wrappers, are always inlined, and their machine code is
kept in files of our own (see `cache`). With a later release, or with DEMLAWS_PLAIN_NUMBA=1 in the environment, the same
functions are compiled by documented options only and kept by numba's own cache: slower to start and to run, with the same
results. DEMLAWS_PLAIN_NUMBA=0 tries the first way with a later release, too.
"""

import functools
import gc
import os
import re
from types import FunctionType
from typing import Any

import numba
from llvmlite import ir
from numba import types
from numba.extending import intrinsic, overload

from demlaws.core import cache, notice
from demlaws.errors import DemlawsError

try:
    from numba.np.arrayobj import populate_array
except ImportError:  # of a release that has moved it: YADE's bridge, which alone uses it, then refuses tables
    populate_array = None

if numba.config.DISABLE_JIT:
    raise DemlawsError("NUMBA_DISABLE_JIT is set: the laws need numba's compiler; unset it")

TESTED = (0, 68)
"""The last release of numba (major, minor) whose internals these tests have run with."""


def _is_plain():
    setting = os.environ.get("DEMLAWS_PLAIN_NUMBA", "")
    release = tuple(int(n) for n in re.findall(r"\d+", numba.__version__)[:2])
    return setting != "0" if setting else release > TESTED


PLAIN = _is_plain()
"""Whether numba is used without its internals."""
_OPTIONS: dict[str, Any] = {"error_model": "numpy", "fastmath": {"contract"}, "nogil": True}
INLINED: dict[str, Any] = {"nogil": True} if PLAIN else {"forceinline": True, "no_cfunc_wrapper": True}
"""Options of what is compiled into its caller and called by nothing else."""
INLINED_KERNEL: dict[str, Any] = {**INLINED, **_OPTIONS}
"""The same for arithmetic. Of fastmath only ``contract`` (fused multiply-add): all of it would delete checks for NaN."""


def kernel(function):
    """Compile a scalar function that is inlined into the loop that calls it, so that the loop vectorises."""
    return _plain_kernel(function) if PLAIN else _kernel(function)


def loop(function):
    """Compile a loop over arrays and keep its machine code on disk; editing or upgrading a law never runs outdated code.

    Where no folder can be written, the loop is compiled in every process.
    """
    return _plain_loop(function) if PLAIN else _loop(function)


def calls(function, choose):
    """Let compiled code that calls `function` call the kernel that `choose` gives for the types of the arguments, if any."""
    if not PLAIN:
        template = type("Choice", (Choice,), {"key": function, "choose": staticmethod(choose), "kernels": {}})
        infer_global(function, types.Function(template))
        return

    @overload(function, jit_options=INLINED_KERNEL, strict=False)
    def chosen(*kinds):
        kernel = choose(*kinds)
        return kernel and kernel.py_func


def callback(signature, function, constants):
    """Compile a function that C++ code can call, at `.address`, and keep it on disk as `loop` does.

    constants: name → numba type or value that the function uses as a global; their values are part of the file's name.
    """
    bound = FunctionType(function.__code__, {**function.__globals__, **constants}, function.__name__)
    bound.__qualname__ = function.__qualname__
    return numba.cfunc(signature, **_OPTIONS)(bound) if PLAIN else _callback(signature, bound, constants)


# --- documented options only


def _plain_kernel(function):
    return numba.njit(**_OPTIONS)(function)


def _plain_loop(function):
    """A function that calls one of two dispatchers. numba's cache does not notice that a law has changed; the name of its
    folder stands for our own laws, while loops over the types of others are compiled in every process."""
    fresh = persistent = numba.njit(**_OPTIONS)(function)
    if cache.FOLDER:
        before, numba.config.CACHE_DIR = numba.config.CACHE_DIR, str(cache.FOLDER)
        try:
            persistent = numba.njit(cache=True, **_OPTIONS)(function)
        except RuntimeError:  # a function without a file
            persistent = fresh
        finally:
            numba.config.CACHE_DIR = before

    @functools.wraps(function)
    def call(*arguments):
        ours = all(cache.is_ours(cls.__module__) for cls in cache.classes(map(numba.typeof, arguments)))
        return (persistent if ours else fresh)(*arguments)

    call.py_func = function
    overload(call, jit_options=_OPTIONS, strict=False)(lambda *arguments: function)
    return call


# --- numba's internals

if not PLAIN:
    from numba.core import serialize
    from numba.core.ccallback import CFunc
    from numba.core.codegen import JITCodeLibrary
    from numba.core.compiler import CompileResult, Flags, compile_extra
    from numba.core.dispatcher import _FunctionCompiler
    from numba.core.registry import CPUDispatcher
    from numba.core.typing.templates import AbstractTemplate, infer_global

    class Choice(AbstractTemplate):
        """Type inference of a function in whose place a kernel is called. The function that numba's `overload` would compile
        around each kernel took a sixth of the time that compiling a loop takes."""

        def generic(self, arguments, keywords):
            """Signature of the kernel for these types."""
            if arguments not in self.kernels:
                self.kernels[arguments] = self.choose(*arguments)
            if self.kernels[arguments] is not None:
                return types.Dispatcher(self.kernels[arguments]).get_call_type(self.context, arguments, keywords)

        def get_impl_key(self, signature):
            """What numba's code generator finds the kernel by."""
            return self.kernels[signature.args].get_overload(signature.args)

    class InlinedCode(JITCodeLibrary):
        """Code that its callers optimise with their own and compile: alone it is neither optimised nor made machine code."""

        def _optimize_final_module(self):
            pass

        def _finalize_final_module(self):
            self._finalize_dynamic_globals()
            self._finalized = True

    class KernelCompiler(_FunctionCompiler):
        """Compiles a kernel as far as its callers need it."""

        def _compile_core(self, arguments, return_type):
            flags = Flags()
            self.targetdescr.options.parse_as_flags(flags, self.targetoptions)
            flags.no_compile = True
            typing, target = self.targetdescr.typing_context, self.targetdescr.target_context
            library = InlinedCode(target.codegen(), self.py_func.__qualname__)
            function = self.py_func, arguments, return_type
            return compile_extra(typing, target, *function, flags, self.locals, library, self.pipeline_class)

    class Loop(CPUDispatcher):
        """A compiled loop. numba makes objects by the million, which all live: looking for garbage meanwhile would take a tenth
        of the time that compiling takes."""

        def compile(self, signature):
            """Machine code for arguments of these types."""
            looks = gc.isenabled()
            gc.disable()
            try:
                return super().compile(signature)
            finally:
                if looks:
                    gc.enable()

    class Kernel(CPUDispatcher):
        """A kernel without the wrappers through which Python and C would call it, and without machine code of its own: compiled
        code needs neither. Called from Python, it is compiled once more with them."""

        def add_overload(self, result):
            """Keep the compiled code for callers; there is none that Python may call."""
            result = result._replace(entry_point=result.library)  # what callers find it by
            self.targetctx.insert_user_function(result.library, result.fndesc, [result.library])
            self.overloads[tuple(result.signature.args)] = result

        def _compile_for_args(self, *arguments, **keywords):
            return self._whole()

        def get_compile_result(self, signature):
            """The compiled code of a kernel that is passed on as a value."""
            return self._whole().get_compile_result(signature)

        def _whole(self):
            if "whole" not in self.__dict__:
                self.whole = numba.njit(forceinline=True, **_OPTIONS)(self.py_func)
            return self.whole


class CodeFiles:
    """What numba calls a cache: loads and saves the machine code of one function, in the files that `cache.place` names."""

    cache_path = str(cache.FOLDER)

    def __init__(self, function, constants=None):
        self.function, self.constants = function, constants or {}

    def _place(self, signature, codegen):
        key = (codegen.magic_tuple(), signature)
        arguments = getattr(signature, "args", signature)  # of a callback it is a Signature
        return cache.place(self.function, key, arguments, self.constants), key

    def load_overload(self, signature, context):
        """The machine code for these types from disk, or None: numba then compiles it."""
        try:
            context.refresh()
            path, key = self._place(signature, context.codegen())
            stored, payload = cache.read(path)
            if stored == key:
                return CompileResult._rebuild(context, *payload)
        except Exception:  # the file is absent, or corrupt in any of many ways
            pass
        notice.begin()
        return None

    def save_overload(self, signature, result):
        """Write machine code to disk. What cannot be written is compiled in every process."""
        notice.end()
        try:
            path, key = self._place(signature, result.codegen)
            if path is not None and not result.library.has_dynamic_globals:
                cache.write(path, serialize.dumps((key, result._reduce())))
        except Exception:  # a full disk, or an internal of another numba: the code in memory is all that counts
            return

    def flush(self):
        """Nothing to write: each file is complete."""


def _kernel(function):
    compiled = numba.njit(no_cpython_wrapper=True, **INLINED_KERNEL)(function)
    compiled.__class__, compiled._compiler.__class__ = Kernel, KernelCompiler
    return compiled


def _loop(function):
    dispatcher = numba.njit(no_cfunc_wrapper=True, **_OPTIONS)(function)
    dispatcher.__class__ = Loop
    if cache.FOLDER:
        dispatcher._cache = CodeFiles(function)
    return dispatcher


def _callback(signature, function, constants):
    compiled = CFunc(function, (signature.args, signature.return_type), {}, dict(_OPTIONS))
    if cache.FOLDER:
        compiled._cache = CodeFiles(function, constants)
    compiled.compile()
    return compiled


@intrinsic
def interleave(typing_context, count):
    """Ask LLVM to work on `count` (a literal) vectors at a time in the loop that follows this call.

    A law is one long chain of dependent operations; left alone LLVM interleaves two vectors, too few to keep the
    processor busy. The hint goes where LLVM looks for it, on the loop's backward jump, which numba writes later.
    """
    if not isinstance(count, types.IntegerLiteral):
        return None
    number = count.literal_value

    def generate(context, builder, signature, arguments):
        module, plain = builder.module, builder.branch

        def branch(target):
            jump = plain(target)
            if target.is_terminated:  # the jump goes back: `target` is the head of a loop
                key = ir.MetaDataString(module, "llvm.loop.interleave.count")
                hint = module.add_metadata([key, ir.Constant(ir.IntType(32), number)])
                mark = module.add_metadata([key, hint])
                mark.operands = (mark, hint)  # LLVM wants a loop's metadata to name itself first
                jump.set_metadata("llvm.loop", mark)
            return jump

        if not PLAIN:
            builder.branch = branch
        return context.get_dummy_value()

    return types.void(count), generate
