"""Compiled generic functions: which law runs is decided by the type of its parameters, when the caller is compiled.

A law is two tuples and four kernels. Its Shape holds what all its contacts share, of any content; its Params hold the numbers
of one contact, derived once by `scale`. A law hands its kernels to `bind`; any compiled code may then call `scale` with that
law's Shape, `first_loading`, `inverse` and `energy` with its Shape and Params, and LLVM sees one straight function. Dispatch on
a type rather than on a function keeps numba's on-disk cache valid from one process to the next. The names of these types go
into the symbols of the machine code, so each is unique in the package; a type from elsewhere is given a name of its own.
"""

import functools
import inspect
import itertools

import numba
import numpy as np
from numba import types
from numba.extending import overload

from demlaws.core.cache import is_known, tag_of
from demlaws.core.numba_compat import INLINED
from demlaws.errors import DemlawsError


def function_of_text(arguments, lines, names):
    """The function of these arguments (text) whose body is these lines (text) and whose globals are `names` (a dict).

    >>> function_of_text("x", ["y = factor * x", "return y + 1.0"], {"factor": 3.0})(2.0)
    7.0
    """
    names = dict(names)
    exec(f"def function({arguments}):\n" + "".join(f"    {line}\n" for line in lines), names)
    return names["function"]


_GENERIC = {}  # name of a function that kernels may be bound to → names of its arguments, number of the one that decides
_KERNELS = {}  # type of a law's Shape or Params, or of a rule's tag → {name of a generic function: kernel}
PARAMS = 1
"""Number of the argument that is a contact's Params."""


def generic(otherwise=None, by=0):
    """Decorator of a function that is generic: compiled code that calls it calls the kernel bound to the type of one argument.

    otherwise: gives, for the types of the arguments, the function that is compiled where no kernel is bound. by: number of the
    argument that decides.
    """

    def decorate(function):
        name = function.__name__
        _GENERIC[name] = tuple(inspect.signature(function).parameters), by

        def choose(*kinds):
            bound = _KERNELS.get(getattr(kinds[by], "instance_class", None), {}).get(name)
            return otherwise(*kinds) if bound is None and otherwise else getattr(bound, "py_func", bound)

        @functools.wraps(function)
        def call(*arguments):  # from Python
            return choose(*map(numba.typeof, arguments))(*arguments)

        call.py_func = function
        overload(call, jit_options=INLINED, strict=False)(choose)
        return call

    return decorate


def bind(cls, **functions):
    """Make `functions` (name of a generic function → kernel) answer for arguments whose type is the NamedTuple `cls`.

    `scale` is bound to a law's Shape, all functions of a contact to its Params, whose fields are floats or the Params of the
    law that it builds on.
    """
    if unknown := sorted(functions.keys() - _GENERIC.keys()):
        names = ", ".join(sorted(_GENERIC))
        raise TypeError(
            f"{cls.__module__}.{cls.__name__}: no generic function is called {', '.join(unknown)}; there are {names}"
        )
    if any(_GENERIC[name][1] == PARAMS for name in functions):
        _refuse_other_fields(cls)
    for name, function in functions.items():
        given, wanted = inspect.signature(getattr(function, "py_func", function)).parameters, _GENERIC[name][0]
        if len(given) != len(wanted):
            raise TypeError(
                f"{cls.__module__}.{cls.__name__}: {name} takes ({', '.join(wanted)}), the kernel takes ({', '.join(given)})"
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


_BELONGS = (
    "Params hold floats of one contact (1.0 for 1), or the Params of the law that it builds on; what all contacts share is a "
    "field of the Shape"
)


def _refuse_other_fields(cls):
    """TypeError unless the annotations of a Params type are floats or NamedTuples, and `hertz_coefficient` is one of them."""
    if "hertz_coefficient" not in getattr(cls, "_fields", ()):
        raise TypeError(f"{cls.__module__}.{cls.__name__}: Params need the field hertz_coefficient, (4/3) E* √R in N/m^1.5")
    for name, kind in getattr(cls, "__annotations__", {}).items():
        nested = isinstance(kind, type) and issubclass(kind, tuple)
        if not nested and kind is not float and str(kind).rpartition(".")[2] not in ("float", "tuple"):
            described = getattr(kind, "__name__", kind)
            raise TypeError(f"{cls.__module__}.{cls.__name__}: its field {name!r} is annotated as {described}: {_BELONGS}")


def refuse_other_values(params, place=""):
    """DemlawsError unless all values of a contact's Params, as `scale` has made them, are floats."""
    for name, value in zip(getattr(params, "_fields", ("",) * len(params)), params, strict=True):
        if isinstance(value, tuple) and hasattr(value, "_fields"):
            refuse_other_values(value, f"{place}{name}.")
        elif not isinstance(value, float):
            what = (
                f"an array of shape {value.shape}" if isinstance(value, np.ndarray) else f"{type(value).__name__} {value!r:.40}"
            )
            raise DemlawsError(f"{type(params).__name__}: the field {place + name!r} of its Params is {what}: {_BELONGS}")


@generic()
def scale(shape, radius, modulus, roughness):
    """Params of one contact: the law's `shape`, with R [m], E* [Pa] and σ [m] of the contact."""


@generic(by=PARAMS)
def first_loading(shape, params, overlap):
    """First loading at overlap > 0 [m]: force P [N], tangent stiffness K [N/m], δ_H(P) [m], a²/R [m].

    δ_H(P) is the overlap at which a smooth contact carries P (the Hertz-equivalent overlap); a is the contact radius
    that an unloading rule starts from: a²/R = δ_H(P) unless the bulk has yielded.
    """


@generic(by=PARAMS)
def inverse(shape, params, force):
    """Overlap [m] at which first loading carries `force` > 0 [N]."""


@generic(lambda *_: lambda shape, params, force, equivalent: inverse(shape, params, force), by=PARAMS)
def inverse_near(shape, params, force, equivalent):
    """As `inverse`, from both the force > 0 [N] and its Hertz-equivalent overlap [m]; approximate, refined by one Newton step.
    A law that binds nothing has its `inverse` called."""


@generic(lambda *_: lambda shape, params: (shape, params, 1.0), by=PARAMS)
def unloading_curve(shape, params):
    """Shape and Params of the given unloading curve, and the factor from a Hertz-equivalent overlap of first loading to that of
    the curve at equal force. A law without such a curve goes back along its own."""


@generic(by=PARAMS)
def energy(shape, params, overlap):
    """Work [J] of first loading from 0 to overlap > 0 [m]."""


@generic()
def step(rule, shape, params, overlap, state):
    """Force, tangent stiffness and new state of a contact at `overlap` [m]; pure: `state` is a tuple of floats."""


@generic()
def stored_and_dissipated(rule, shape, params, overlap, state):
    """Energy [J] that a contact at `overlap` [m] can still return, and what it has dissipated since it was made."""


@generic()
def unloaded(rule, shape, params, force, state):
    """Overlap [m] at which the contact, below its maximum overlap, carries `force` ≥ 0 [N]."""


@generic(lambda *_: lambda rule, shape, params, overlap, area: area)
def contact_area(rule, shape, params, overlap, area):
    """a²/R [m] on first loading, from which a rule has the radius that it unloads with; one that binds none takes `area`."""


def _of_items(kind):
    """The function that gives a tuple of this numba type `with_pointers` of the tuples in it."""
    items = [f"{'with_pointers' * isinstance(item, types.BaseTuple)}(shape[{n}]), " for n, item in enumerate(kind)]
    name = "Class" * isinstance(kind, types.BaseNamedTuple)
    names = {"with_pointers": with_pointers, "Class": getattr(kind, "instance_class", None)}
    return function_of_text("shape", [f"return {name}({''.join(items)})"], names)


@generic(_of_items)
def with_pointers(shape):
    """A Shape whose grids are `fastmath.read_only` pointers, for use in a loop during which `shape` stays alive."""


@generic(lambda *_: lambda shape: shape)
def with_pointers_to_invert(shape):
    """The same of a curve that is inverted: `inverse` searches arrays, so that only Shapes with an `inverse_near` bind this."""


# --- arrays of contacts: (nested, named) tuples whose leaves are numbers, or 1-D arrays with one entry per contact


def tuple_text(kind, leaf, names, path=()):
    """Source text that rebuilds a (nested) tuple of this numba type; its classes are added to `names`.

    leaf: numba type and path (numbers of fields) of a value that is no tuple → its text.
    """
    if not isinstance(kind, types.BaseTuple):
        return leaf(kind, path)
    items = "".join(f"{tuple_text(item, leaf, names, (*path, n))}, " for n, item in enumerate(kind))
    if not isinstance(kind, types.BaseNamedTuple):
        return f"({items})"
    name = f"Class{len(names)}"
    names[name] = kind.instance_class
    return f"{name}({items})"


def leaves(values):
    """The numbers and arrays of a nested tuple, flat."""
    for value in values:
        if isinstance(value, tuple):
            yield from leaves(value)
        else:
            yield value


def map_leaves(function, values):
    """The same nested tuple with `function` applied to each number or array in it."""
    mapped = [map_leaves(function, v) if isinstance(v, tuple) else function(v) for v in values]
    return type(values)(*mapped) if hasattr(values, "_fields") else tuple(mapped)


def gather(arrays, i):
    """Contact i."""
    return map_leaves(lambda value: value[i] if isinstance(value, np.ndarray) else value, arrays)


def _place(path):
    return "".join(f"[{n}]" for n in path)


@overload(gather, jit_options=INLINED)
def _gather(arrays, i):
    names = {}
    text = tuple_text(
        arrays,
        lambda kind, path: f"float(arrays{_place(path)}[i])" if isinstance(kind, types.Array) else f"arrays{_place(path)}",
        names,
    )
    return function_of_text("arrays, i", [f"return {text}"], names)


def scatter(arrays, i, values):
    """Store contact i: the reverse of `gather`."""
    for array, value in zip(leaves(arrays), leaves(values), strict=True):
        array[i] = value


def _paths(kind, path=()):
    if not isinstance(kind, types.BaseTuple):
        return [path]
    return [one for n, item in enumerate(kind) for one in _paths(item, (*path, n))]


@overload(scatter, jit_options=INLINED)
def _scatter(arrays, i, values):
    lines = [f"arrays{_place(path)}[i] = values{_place(path)}" for path in _paths(arrays)]
    return function_of_text("arrays, i, values", [*lines, "return"], {})


def scalar(value):
    """A number, or the number in an array without dimensions (numba's np.where of numbers)."""
    return value[()] if isinstance(value, np.ndarray) else value


@overload(scalar, jit_options=INLINED)
def _scalar(value):
    return (lambda value: value[()]) if isinstance(value, types.Array) else (lambda value: value)
