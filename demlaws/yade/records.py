"""Memory of this process as numba records: a structured dtype is a view of an object at an address, `view(address, dtype)`, and
its fields are read and written by name. The compiled code of an access is one load or store with the offset built in. Only this
file accesses memory by address.

Also what such code needs beside fields: sums that threads add to, and calls of functions at addresses.
"""

import ctypes

import numba
import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from demlaws.core.numba_compat import kernel
from demlaws.yade import layout

POINTER = np.dtype([("target", "i8")])
"""A C++ pointer, or the first 8 bytes of a shared pointer."""
_WORD, _DOUBLE = ir.IntType(64), ir.DoubleType()
_IR = {
    types.int64: _WORD,
    types.int32: ir.IntType(32),
    types.uint8: ir.IntType(8),
    types.float64: _DOUBLE,
    types.void: ir.VoidType(),
}


def record(fields):
    """dtype of an object; fields: name → (format, offset [bytes]), or (format, shape, offset)."""
    formats = [kind if not shape else (kind, *shape) for kind, *shape, _ in fields.values()]
    offsets = [offset for *_, offset in fields.values()]
    end = max(offset + np.dtype(kind).itemsize for kind, offset in zip(formats, offsets, strict=True))
    return np.dtype({"names": [*fields], "formats": formats, "offsets": offsets, "itemsize": -(-end // 8) * 8})


def memory_at(address, kind=ctypes.c_uint64):
    """The ctypes object of a kind at an address; `.value` reads and writes it."""
    return kind.from_address(address)


@intrinsic
def pointer(typing_context, address):
    """An address (a 64-bit integer) as a pointer that `numba.carray` takes."""

    def generate(context, builder, signature, arguments):
        return builder.inttoptr(arguments[0], context.get_value_type(types.voidptr))

    return types.voidptr(types.int64), generate


@kernel
def view(address, dtype):
    """The object at an address."""
    return numba.carray(pointer(address), 1, dtype)[0]


@kernel
def array(address, shape, dtype):
    """An array at an address, not copied."""
    return numba.carray(pointer(address), shape, dtype)


@kernel
def pointee(address):
    """What the pointer at an address points to."""
    return view(address, POINTER).target


@intrinsic
def read_tuple(typing_context, address, kind):
    """The (nested) tuple of a numba type, of numbers and arrays, that `write_tuple` has written at an address; its arrays are
    not counted as references."""
    result = kind.instance_type

    def generate(context, builder, signature, arguments):
        return _read(context, builder, result, _place(context, builder, result, arguments[0]))

    return result(types.int64, kind), generate


def _place(context, builder, kind, address):
    return builder.inttoptr(address, context.get_value_type(kind).as_pointer())


def _read(context, builder, kind, place):
    """One load for each number: where it is used, not where the tuple is."""
    if isinstance(kind, types.Array):
        source, array = (context.make_array(kind)(context, builder, ref=ref) for ref in (place, None))
        for name in ("nitems", "itemsize", "data", "shape", "strides"):
            setattr(array, name, getattr(source, name))
        return array._getvalue()
    if not isinstance(kind, types.BaseTuple):
        return builder.load(place)
    value = context.get_value_type(kind)(ir.Undefined)
    for n, item in enumerate(kind):
        part = builder.gep(place, [ir.IntType(32)(0), ir.IntType(32)(n)], inbounds=True)
        value = builder.insert_value(value, _read(context, builder, item, part), n)
    return value


@intrinsic
def write_tuple(typing_context, address, kind, values):
    """Write a (nested) tuple of a numba type at an address."""

    def generate(context, builder, signature, arguments):
        builder.store(arguments[2], _place(context, builder, kind.instance_type, arguments[0]))
        return context.get_dummy_value()

    return types.void(types.int64, kind, kind.instance_type), generate


@intrinsic
def words_of(typing_context, kind):
    """Number of 64-bit words that a tuple of a numba type takes in memory."""

    def generate(context, builder, signature, arguments):
        return _WORD(-(-context.get_abi_sizeof(context.get_value_type(kind.instance_type)) // 8))

    return types.int64(kind), generate


def _adder(numba_type, operation):
    @intrinsic
    def add(typing_context, address, value):
        def generate(context, builder, signature, arguments):
            place = builder.inttoptr(arguments[0], arguments[1].type.as_pointer())
            return builder.atomic_rmw(operation, place, arguments[1], "monotonic")

        return numba_type(types.int64, numba_type), generate

    return add


add_integer, add_float = _adder(types.int64, "add"), _adder(types.float64, "fadd")
"""Atomically add to the number at an address; return its old value."""


@intrinsic
def exchange_if(typing_context, address, expected, value):
    """Atomically write an integer at an address where `expected` is there; returns what was there."""

    def generate(context, builder, signature, arguments):
        place = builder.inttoptr(arguments[0], _WORD.as_pointer())
        old = builder.cmpxchg(place, arguments[1], arguments[2], "acq_rel", "acquire")
        return builder.extract_value(old, 0)

    return types.int64(types.int64, types.int64, types.int64), generate


def c_function(result, *arguments):
    """Compiled function that calls a C++ function of this signature: `call(address, arguments)`, arguments a tuple."""

    @intrinsic
    def call(typing_context, function, values):
        def generate(context, builder, signature, pair):
            kind = ir.FunctionType(_IR[result], [_IR[argument] for argument in arguments])
            items = [
                context.cast(builder, builder.extract_value(pair[1], n), given, wanted)
                for n, (given, wanted) in enumerate(zip(values, arguments, strict=True))
            ]
            value = builder.call(builder.inttoptr(pair[0], kind.as_pointer()), items)
            return context.get_dummy_value() if result is types.void else value

        return result(types.int64, values), generate

    return call


@intrinsic
def on_stack(typing_context, vector):
    """Address of a copy of three doubles on the stack. The first two are written at once, as YADE reads them: a processor
    waits where it reads at once what was written in two parts."""

    def generate(context, builder, signature, arguments):
        pair = ir.VectorType(_DOUBLE, 2)
        with builder.goto_entry_block():
            block = builder.alloca(ir.ArrayType(_DOUBLE, 3))
        place = builder.ptrtoint(block, _WORD)
        items = [builder.extract_value(arguments[0], n) for n in range(3)]
        first = builder.insert_element(pair(ir.Undefined), items[0], ir.IntType(32)(0))
        first = builder.insert_element(first, items[1], ir.IntType(32)(1))
        builder.store(first, builder.inttoptr(place, pair.as_pointer()), align=8)
        builder.store(items[2], builder.inttoptr(builder.add(place, _WORD(16)), _DOUBLE.as_pointer()))
        return place

    return types.int64(types.UniTuple(types.float64, 3)), generate


# --- notes for the guard

not_inlined = numba.njit(error_model="numpy", nogil=True)
"""Compile a function that few contacts call, not inlined."""


@kernel
def request_guard(context):
    """Have the guard run before the contacts of the next step."""
    if context.guard_counter != 0:
        array(context.guard_counter, 1, np.int64)[0] = 0


@kernel
def type_of(first_word):
    """Address of the type of an object of C++ that begins with this word."""
    return pointee(first_word - 8)


@not_inlined
def record_fault(context, kind, interaction, value):
    """Note something of a contact for the guard, which runs before the next step; a fault stops the run there."""
    if context.seen[kind] != layout.REPORTED:
        context.bodies[kind, 0] = interaction.id1
        context.bodies[kind, 1] = interaction.id2
        context.values[kind] = value
        context.seen[kind] = layout.SEEN
        request_guard(context)
