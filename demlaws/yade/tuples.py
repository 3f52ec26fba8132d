"""A law's Shape as fields of the record of a pair of surfaces, and the state of its rule in the history of a contact.

A float, an integer and a boolean are one field each, None is no field, an array is its address and its lengths.
"""

import numpy as np
from numba import types
from numba.extending import overload

from demlaws.core.dispatch import function_of_text, tuple_text
from demlaws.core.numba_compat import INLINED
from demlaws.core.unloading import rule_of
from demlaws.yade.records import array


def fields(kind, name):
    """(name, format) of the fields of a value of this numba type; their names begin with `name`."""
    if isinstance(kind, types.BaseTuple):
        return [field for n, item in enumerate(kind) for field in fields(item, f"{name}_{n}")]
    if isinstance(kind, types.NoneType):
        return []
    if isinstance(kind, types.Array):
        return [(name, "i8"), *[(f"{name}_length{axis}", "i8") for axis in range(kind.ndim)]]
    if isinstance(kind, types.Float):
        return [(name, "f8")]
    if isinstance(kind, types.Integer | types.Boolean):
        return [(name, "i8")]
    raise TypeError(f"a law's shape contains {kind}, which cannot be passed to YADE")


def pack(value, record, name, keep):
    """Write a value to its fields of a record; arrays are appended to `keep`, which must outlive the use of the record."""
    if isinstance(value, tuple):
        for n, item in enumerate(value):
            pack(item, record, f"{name}_{n}", keep)
    elif isinstance(value, np.ndarray):
        kept = np.ascontiguousarray(value)
        keep.append(kept)
        record[name] = kept.ctypes.data
        for axis, length in enumerate(kept.shape):
            record[f"{name}_length{axis}"] = length
    elif value is not None:
        record[name] = value


def shape_of(kind, pair):
    """The Shape of numba type `kind` whose fields are those of a pair of surfaces."""


@overload(shape_of, jit_options=INLINED)
def _shape_of(kind, pair):
    names = {"array": array}

    def text(item, path):
        place = "_".join(("pair.shape", *map(str, path)))
        if isinstance(item, types.NoneType):
            return "None"
        if isinstance(item, types.Array):
            dtype = f"dtype{len(names)}"
            names[dtype] = np.dtype(item.dtype.name)
            lengths = "".join(f"{place}_length{axis}, " for axis in range(item.ndim))
            return f"array({place}, ({lengths}), {dtype})"
        return f"({place} != 0)" if isinstance(item, types.Boolean) else place

    return function_of_text("kind, pair", [f"return {tuple_text(kind.instance_type, text, names)}"], names)


def state_of(rule, contact):
    """State of the unloading rule, a tuple, from the history of a contact."""


@overload(state_of, jit_options=INLINED)
def _state_of(rule, contact):
    items = "".join(f"contact.state[{n}], " for n in range(len(rule_of(rule.instance_class).state)))
    return function_of_text("rule, contact", [f"return ({items})"], {})


def keep_state(state, contact):
    """Write the state of the unloading rule to the history of a contact."""


@overload(keep_state, jit_options=INLINED)
def _keep_state(state, contact):
    lines = [f"contact.state[{n}] = state[{n}]" for n in range(len(state))]
    return function_of_text("state, contact", ["pass", *lines], {})
