"""Compiled generic functions: which law runs is decided by the type of its parameters, when the caller is compiled.

A law hands its kernels to `bind`; any compiled code may then call `scale`, `first_loading`, `inverse`, `energy` with that law's
`Shape` or `Params` and LLVM sees one straight function. Dispatch on a type rather than on a function keeps numba's
on-disk cache valid from one process to the next. The names of these types go into the symbols of the machine code, so
each is unique in the package; a type from elsewhere is given a name of its own.
"""

import functools
import itertools

import numba
import numpy as np
from numba import types
from numba.extending import overload

from demlaws.core.cache import is_known, tag_of
from demlaws.core.fastmath import read_only
from demlaws.core.numba_compat import INLINED


def function_of_text(arguments, lines, names):
    """The function of these arguments (text) whose body is these lines (text) and whose globals are `names` (a dict).

    >>> function_of_text("x", ["y = factor * x", "return y + 1.0"], {"factor": 3.0})(2.0)
    7.0
    """
    names = dict(names)
    exec(f"def function({arguments}):\n" + "".join(f"    {line}\n" for line in lines), names)
    return names["function"]


_GENERIC = set()  # names of the functions that kernels may be bound to
_KERNELS = {}  # type of a law's Shape or Params, or of a rule's tag → {name of a generic function: kernel}


def generic(otherwise=None):
    """Decorator of a function that is generic: compiled code that calls it calls the kernel bound to its first argument's type.

    otherwise: gives, for the types of the arguments, the function that is compiled where no kernel is bound.
    """

    def decorate(function):
        name = function.__name__
        _GENERIC.add(name)

        def choose(*kinds):
            bound = kernel_of(kinds[0], name)
            return otherwise(*kinds) if bound is None and otherwise else getattr(bound, "py_func", bound)

        @functools.wraps(function)
        def call(*arguments):  # from Python
            return choose(*map(numba.typeof, arguments))(*arguments)

        call.py_func = function
        overload(call, jit_options=INLINED, strict=False)(choose)
        return call

    return decorate


def bind(cls, **functions):
    """Make `functions` (name of a generic function → kernel) answer for arguments whose type is the NamedTuple `cls`."""
    if unknown := sorted(functions.keys() - _GENERIC):
        names = ", ".join(sorted(_GENERIC))
        raise TypeError(
            f"{cls.__module__}.{cls.__name__}: no generic function is called {', '.join(unknown)}; there are {names}"
        )
    others = {other.__name__ for other in _KERNELS if other is not cls}
    if not is_known(cls.__module__) or cls.__module__ == "demlaws.user_laws.define":
        # symbols of two such types, of two users or of one file before and after it was edited, must not clash either
        numbers = itertools.count(2)
        name = cls.__name__ = f"{cls.__name__}_{tag_of(cls, *functions.values())}"
        while cls.__name__ in others:
            cls.__name__ = f"{name}_{next(numbers)}"
    elif cls.__name__ in others:
        raise TypeError(f"{cls.__module__}.{cls.__name__}: another law has a type of this name; rename it")
    _KERNELS.setdefault(cls, {}).update(functions)


def kernel_of(argument, name):
    """The kernel that answers for a generic function where an argument has this numba type, or None."""
    cls = getattr(argument, "instance_class", None)
    return _KERNELS.get(cls, {}).get(name)


@generic()
def scale(shape, radius, modulus, roughness):
    """Params of one contact: the law's `shape`, with R [m], E* [Pa] and σ [m] of the contact."""


@generic()
def first_loading(p, overlap):
    """First loading at overlap > 0 [m]: force P [N], tangent stiffness K [N/m], δ_H(P) [m], a²/R [m].

    δ_H(P) is the overlap at which a smooth contact carries P (the Hertz-equivalent overlap); a is the contact radius
    that an unloading rule starts from: a²/R = δ_H(P) unless the bulk has yielded.
    """


@generic()
def inverse(p, force):
    """Overlap [m] at which first loading carries `force` > 0 [N]."""


@generic(lambda *_: lambda p, force, equivalent: inverse(p, force))
def inverse_near(p, force, equivalent):
    """As `inverse`, from both the force > 0 [N] and its Hertz-equivalent overlap [m], and perhaps rough: one step of Newton's
    method with `first_loading` makes it exact. A law that binds nothing has its `inverse` called."""


@generic(lambda *_: lambda p: (p, p, 1.0))
def curves_of(p):
    """Params of first loading and of the given unloading curve, and the factor from a Hertz-equivalent overlap of the one
    to that of the other at equal force. A law without such a curve goes back along its own."""


@generic()
def energy(p, overlap):
    """Work [J] of first loading from 0 to overlap > 0 [m]."""


@generic()
def step(rule, p, overlap, state):
    """Force, tangent stiffness and new state of a contact at `overlap` [m]; pure: `state` is a tuple of floats."""


@generic()
def stored_and_dissipated(rule, p, overlap, state):
    """Energy [J] that a contact at `overlap` [m] can still return, and what it has dissipated since it was made."""


@generic()
def unloaded(rule, p, force, state):
    """Overlap [m] at which the contact, below its maximum overlap, carries `force` ≥ 0 [N]."""


@generic(lambda *_: lambda rule, p, overlap, area: area)
def contact_area(rule, p, overlap, area):
    """a²/R [m] on first loading, from which a rule has the radius that it unloads with; one that binds none takes `area`."""


class _Source:
    """Source text that rebuilds a (nested) tuple, with the classes that it names."""

    def __init__(self):
        self.names = {}

    def _tuple(self, kind, expression, text_of):
        items = "".join(f"{text_of(item, f'{expression}[{n}]')}, " for n, item in enumerate(kind))
        if not isinstance(kind, types.BaseNamedTuple):
            return f"({items})"
        name = f"Class{len(self.names)}"
        self.names[name] = kind.instance_class
        return f"{name}({items})"

    def read(self, kind, expression):
        """Element i of every 1-D array in `kind` (one entry per contact); anything else is shared by all contacts."""
        if isinstance(kind, types.BaseTuple):
            return self._tuple(kind, expression, self.read)
        return f"float({expression}[i])" if isinstance(kind, types.Array) and kind.ndim == 1 else expression

    def fix(self, kind, expression):
        """The same tuple with `read_only` pointers in place of 2-D arrays; parts that bind a `fix_tables` have it called."""
        if isinstance(kind, types.BaseNamedTuple) and kernel_of(kind, "fix_tables") is not None:
            return f"fix_tables({expression})"
        return self.fix_parts(kind, expression)

    def fix_parts(self, kind, expression):
        if isinstance(kind, types.BaseTuple):
            return self._tuple(kind, expression, self.fix)
        return f"read_only({expression})" if isinstance(kind, types.Array) and kind.ndim == 2 else expression

    def write(self, kind, target, value):
        """Statements that store into element i of every 1-D array in `kind`."""
        if isinstance(kind, types.BaseTuple):
            parts = [self.write(item, f"{target}[{n}]", f"{value}[{n}]") for n, item in enumerate(kind)]
            return [line for part in parts for line in part]
        return [f"{target}[i] = {value}"] if isinstance(kind, types.Array) and kind.ndim == 1 else []


def _fix_parts(params):
    source = _Source()
    source.names |= {"read_only": read_only, "fix_tables": fix_tables}
    return function_of_text("params", [f"return {source.fix_parts(params, 'params')}"], source.names)


@generic(_fix_parts)
def fix_tables(params):
    """Params whose tables are plain pointers, for use in a loop during which `params` stays alive."""


def fix_for_inverse(params):
    """`fix_tables` for a curve that is inverted: without an `inverse_near` it keeps its arrays, which `inverse` searches."""
    return params


@overload(fix_for_inverse, jit_options=INLINED)
def _fix_to_inverse_near(params):
    if kernel_of(params, "inverse_near") is None:
        return lambda params: params
    return lambda params: fix_tables(params)


def leaves(params):
    """The per-contact arrays and shared values of a nested tuple, flat."""
    for value in params:
        if isinstance(value, tuple):
            yield from leaves(value)
        else:
            yield value


def map_leaves(function, params):
    """The same nested tuple with `function` applied to each number or array in it."""
    values = [map_leaves(function, v) if isinstance(v, tuple) else function(v) for v in params]
    return type(params)(*values) if hasattr(params, "_fields") else tuple(values)


def gather(arrays, i):
    """Contact i of a (nested, named) tuple whose 1-D arrays have one entry per contact."""
    return map_leaves(lambda value: value[i] if isinstance(value, np.ndarray) and value.ndim == 1 else value, arrays)


@overload(gather, jit_options=INLINED)
def _gather(arrays, i):
    source = _Source()
    text = source.read(arrays, "arrays")
    return function_of_text("arrays, i", [f"return {text}"], source.names)


def scatter(arrays, i, values):
    """Store contact i: the reverse of `gather`."""
    for array, value in zip(leaves(arrays), leaves(values), strict=True):
        if isinstance(array, np.ndarray) and array.ndim == 1:
            array[i] = value


@overload(scatter, jit_options=INLINED)
def _scatter(arrays, i, values):
    return function_of_text("arrays, i, values", [*_Source().write(arrays, "arrays", "values"), "return"], {})


def scalar(value):
    """A number, or the number in an array without dimensions (numba's np.where of numbers)."""
    return value[()] if isinstance(value, np.ndarray) else value


@overload(scalar, jit_options=INLINED)
def _scalar(value):
    return (lambda value: value[()]) if isinstance(value, types.Array) else (lambda value: value)
