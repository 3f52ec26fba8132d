"""(Nested, named) tuples of numbers and arrays as fields of a record: a law's Shape in the record of a pair of surfaces, and
the numbers of its Params that are a contact's own in the contact's row.

A float, an integer and a boolean are one field each, None is no field, an array is its address and its lengths.
"""

import numpy as np
from numba import types
from numba.extending import overload

from demlaws.core.dispatch import function_of_text
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


class _Source:
    """Source text that reads a value from fields and writes it, with the names that it uses."""

    def __init__(self):
        self.names = {"array": array}

    def read(self, kind, place):
        if isinstance(kind, types.BaseTuple):
            items = "".join(f"{self.read(item, f'{place}_{n}')}, " for n, item in enumerate(kind))
            return self.tuple(kind, items)
        if isinstance(kind, types.NoneType):
            return "None"
        if isinstance(kind, types.Array):
            dtype = f"dtype{len(self.names)}"
            self.names[dtype] = np.dtype(kind.dtype.name)
            lengths = "".join(f"{place}_length{axis}, " for axis in range(kind.ndim))
            return f"array({place}, ({lengths}), {dtype})"
        return f"({place} != 0)" if isinstance(kind, types.Boolean) else place

    def tuple(self, kind, items):
        if not isinstance(kind, types.BaseNamedTuple):
            return f"({items})"
        cls = f"Class{len(self.names)}"
        self.names[cls] = kind.instance_class
        return f"{cls}({items})"

    def write(self, kind, place, value):
        if isinstance(kind, types.BaseTuple):
            return [line for n, item in enumerate(kind) for line in self.write(item, f"{place}_{n}", f"{value}[{n}]")]
        if isinstance(kind, types.NoneType):
            return []
        if isinstance(kind, types.Array):
            lengths = [f"{place}_length{axis} = {value}.shape[{axis}]" for axis in range(kind.ndim)]
            return [f"{place} = {value}.ctypes.data", *lengths]
        return [f"{place} = {value}"]


def shape_of(kind, pair):
    """The Shape of numba type `kind` whose fields are those of a pair of surfaces."""


@overload(shape_of, jit_options=INLINED)
def _shape_of(kind, pair):
    source = _Source()
    text = source.read(kind.instance_type, "pair.shape")
    return function_of_text("kind, pair", [f"return {text}"], source.names)


def _places(params_kind, kind):
    """(number, type, name of the Shape's field or None) of each field of Params: a field of the Shape's of the same name and
    type, at any depth, has the same value (the tests check this)."""
    places, level = {}, [(kind, "shape")]
    while level:
        deeper = []
        for owner, place in level:
            for n, (name, field) in enumerate(zip(owner.fields, owner.types, strict=True)):
                places.setdefault((name, field), f"{place}_{n}")
                if isinstance(field, types.BaseNamedTuple):
                    deeper.append((field, f"{place}_{n}"))
        level = deeper
    pairs = zip(params_kind.fields, params_kind.types, strict=True)
    return [(n, field, places.get((name, field))) for n, (name, field) in enumerate(pairs)]


def own_fields(params_kind, kind):
    """Fields of a law's Params that belong to one contact; the others are its Shape's."""
    own = [(n, field) for n, field, shared in _places(params_kind, kind) if shared is None]
    return [place for n, field in own for place in fields(field, f"own_{n}")]


def params_of_row(params_kind, kind, row, pair):
    """A law's Params from the fields that `keep_params` wrote to a row and those of the Shape in the pair."""


@overload(params_of_row, jit_options=INLINED)
def _params_of_row(params_kind, kind, row, pair):
    source, params = _Source(), params_kind.instance_type
    items = "".join(
        f"{source.read(field, f'row.own_{n}' if shared is None else f'pair.{shared}')}, "
        for n, field, shared in _places(params, kind.instance_type)
    )
    return function_of_text("params_kind, kind, row, pair", [f"return {source.tuple(params, items)}"], source.names)


def keep_params(kind, params, row):
    """Write what a contact's Params have beside its Shape, of numba type `kind`, to its row."""


@overload(keep_params, jit_options=INLINED)
def _keep_params(kind, params, row):
    source, lines = _Source(), ["pass"]
    for n, field, shared in _places(params, kind.instance_type):
        lines += source.write(field, f"row.own_{n}", f"params[{n}]") if shared is None else []
    return function_of_text("kind, params, row", lines, source.names)


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
