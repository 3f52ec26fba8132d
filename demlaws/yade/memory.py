"""Memory in compiled code: numbers at addresses (64-bit integers), atomic sums, calls through addresses, and (nested, named)
tuples as rows of 8-byte words.

A float, an integer and a boolean are one word each, None is no word, an array is its address and its shape.
"""

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from demlaws.core.numba_compat import populate_array

WORD, DOUBLE, BYTE = ir.IntType(64), ir.DoubleType(), ir.IntType(8)


def _accessors(numba_type, ir_type):
    @intrinsic
    def load(typing_context, address):
        def generate(context, builder, signature, arguments):
            return builder.load(builder.inttoptr(arguments[0], ir_type.as_pointer()))

        return numba_type(types.int64), generate

    @intrinsic
    def store(typing_context, address, value):
        def generate(context, builder, signature, arguments):
            builder.store(arguments[1], builder.inttoptr(arguments[0], ir_type.as_pointer()))
            return context.get_dummy_value()

        return types.void(types.int64, numba_type), generate

    return load, store


load_word, store_word = _accessors(types.int64, WORD)
load_double, store_double = _accessors(types.float64, DOUBLE)
load_int, _ = _accessors(types.int32, ir.IntType(32))
load_byte, store_byte = _accessors(types.uint8, BYTE)


@intrinsic
def add_double(typing_context, address, value):
    """Atomically add to the double at `address`: threads meet here."""

    def generate(context, builder, signature, arguments):
        builder.atomic_rmw("fadd", builder.inttoptr(arguments[0], DOUBLE.as_pointer()), arguments[1], "monotonic")
        return context.get_dummy_value()

    return types.void(types.int64, types.float64), generate


@intrinsic
def add_word(typing_context, address, value):
    """Atomically add to the word at `address`; returns its old value."""

    def generate(context, builder, signature, arguments):
        return builder.atomic_rmw("add", builder.inttoptr(arguments[0], WORD.as_pointer()), arguments[1], "monotonic")

    return types.int64(types.int64, types.int64), generate


@intrinsic
def call_go(typing_context, function, this, geom, phys, interaction):
    """bool Law2::go(shared_ptr<IGeom>&, shared_ptr<IPhys>&, Interaction*), through its address."""

    def generate(context, builder, signature, arguments):
        kind = ir.FunctionType(BYTE, [WORD] * 4)
        return builder.call(builder.inttoptr(arguments[0], kind.as_pointer()), arguments[1:])

    return types.uint8(*[types.int64] * 5), generate


@intrinsic
def call_body_by_id(typing_context, function, number, scene):
    """const shared_ptr<Body>& Body::byId(int, Scene*), through its address; scene 0: the current one."""

    def generate(context, builder, signature, arguments):
        kind = ir.FunctionType(WORD, [ir.IntType(32), WORD])
        return builder.call(builder.inttoptr(arguments[0], kind.as_pointer()), arguments[1:])

    return types.int64(types.int64, types.int32, types.int64), generate


@intrinsic
def on_stack(typing_context, vector):
    """Address of a copy of three doubles on the stack. The first two are written at once, as YADE reads them: a processor
    waits where it reads at once what was written in two parts."""

    def generate(context, builder, signature, arguments):
        pair = ir.VectorType(DOUBLE, 2)
        block = cgutils.alloca_once(builder, ir.ArrayType(DOUBLE, 3))
        place = builder.ptrtoint(block, WORD)
        items = [builder.extract_value(arguments[0], n) for n in range(3)]
        first = builder.insert_element(pair(ir.Undefined), items[0], ir.IntType(32)(0))
        first = builder.insert_element(first, items[1], ir.IntType(32)(1))
        builder.store(first, builder.inttoptr(place, pair.as_pointer()), align=8)
        builder.store(items[2], builder.inttoptr(builder.add(place, WORD(16)), DOUBLE.as_pointer()))
        return place

    return types.int64(types.UniTuple(types.float64, 3)), generate


@intrinsic
def call_rotate(typing_context, function, geom, place):
    """Vector3& ScGeom::rotate(Vector3&) const, through its address: turns the vector at `place` with the contact."""

    def generate(context, builder, signature, arguments):
        kind = ir.FunctionType(WORD, [WORD] * 2)
        return builder.call(builder.inttoptr(arguments[0], kind.as_pointer()), arguments[1:])

    return types.int64(*[types.int64] * 3), generate


@intrinsic
def call_apply_force(typing_context, function, functor, force, point, first, place1, second, place2):
    """void LawFunctor::applyForceAtContactPoint(force, point, id, position, id, position), through its address."""

    def generate(context, builder, signature, arguments):
        number = ir.IntType(32)
        kind = ir.FunctionType(ir.VoidType(), [WORD, WORD, WORD, number, WORD, number, WORD])
        builder.call(builder.inttoptr(arguments[0], kind.as_pointer()), arguments[1:])
        return context.get_dummy_value()

    word, number = types.int64, types.int32
    return types.void(word, word, word, word, number, word, number, word), generate


@intrinsic
def call_gap_radius(typing_context, function, first, place1, turn1, second, place2, turn2, point, normal, radius, largest):
    """`curvature.gap_radius` through its address."""
    kinds = [types.int64] * 8 + [types.float64] * 2

    def generate(context, builder, signature, arguments):
        kind = ir.FunctionType(DOUBLE, [WORD] * 8 + [DOUBLE] * 2)
        return builder.call(builder.inttoptr(arguments[0], kind.as_pointer()), arguments[1:])

    return types.float64(types.int64, *kinds), generate


# --- tuples as words


def pack(value, keep):
    """The words of a tuple as a list; arrays are appended to `keep`, which must outlive the use of the words."""
    if isinstance(value, tuple):
        return [word for item in value for word in pack(item, keep)]
    if value is None:
        return []
    if isinstance(value, np.ndarray):
        array = np.ascontiguousarray(value)
        keep.append(array)
        return [array.ctypes.data, *array.shape]
    if isinstance(value, float | np.floating):
        return [int(np.float64(value).view(np.int64))]
    return [int(value)]


def words_of(kind):
    """Number of words of a value of this numba type."""
    if isinstance(kind, types.BaseTuple):
        return sum(words_of(item) for item in kind)
    if isinstance(kind, types.NoneType):
        return 0
    if isinstance(kind, types.Array):
        return 1 + kind.ndim
    if isinstance(kind, types.Float | types.Integer | types.Boolean):
        return 1
    raise TypeError(f"a law's shape contains {kind}, which cannot be passed to YADE")


def fields_of(params_kind, kind):
    """(name, type, offset in the Shape or None) of each field of Params: a field of the Shape's of the same name and type,
    at any depth, has the same value (the tests check this)."""
    places, level = {}, [(kind, 0)]
    while level:
        deeper = []
        for owner, offset in level:
            for name, field in zip(owner.fields, owner.types, strict=True):
                places.setdefault((name, field), offset)
                if isinstance(field, types.BaseNamedTuple):
                    deeper.append((field, offset))
                offset += 8 * words_of(field)
        level = deeper
    return [(name, field, places.get((name, field))) for name, field in zip(params_kind.fields, params_kind.types, strict=True)]


def own_words(params_kind, kind):
    """Number of words of a law's Params that belong to one contact; the others are its Shape's."""
    return sum(words_of(field) for _, field, shared in fields_of(params_kind, kind) if shared is None)


def _read(context, builder, kind, address, offset):
    """The value of this numba type whose words begin `offset` bytes after `address`."""

    def word(number=0, ir_type=WORD):
        place = builder.add(address, WORD(offset + 8 * number))
        return builder.load(builder.inttoptr(place, ir_type.as_pointer()))

    if isinstance(kind, types.BaseTuple):
        items = []
        for item in kind:
            items.append(_read(context, builder, item, address, offset))
            offset += 8 * words_of(item)
        return context.make_tuple(builder, kind, items)
    if isinstance(kind, types.NoneType):
        return context.get_dummy_value()
    if isinstance(kind, types.Array):
        shape = [word(1 + axis) for axis in range(kind.ndim)]
        size = WORD(context.get_abi_sizeof(context.get_data_type(kind.dtype)))
        strides = [size]
        for length in reversed(shape[1:]):
            strides.insert(0, builder.mul(strides[0], length))
        array = context.make_array(kind)(context, builder)
        data = builder.inttoptr(word(), context.get_data_type(kind.dtype).as_pointer())
        populate_array(array, data=data, shape=shape, strides=strides, itemsize=size, meminfo=None)
        return array._getvalue()
    if isinstance(kind, types.Float):
        return word(ir_type=DOUBLE)
    if isinstance(kind, types.Boolean):
        return builder.icmp_signed("!=", word(), WORD(0))
    return word()


def _write(context, builder, kind, value, address, offset):
    """Write the words of a value of this numba type from `offset` bytes after `address` on."""

    def word(content, number=0):
        place = builder.add(address, WORD(offset + 8 * number))
        builder.store(content, builder.inttoptr(place, content.type.as_pointer()))

    if isinstance(kind, types.BaseTuple):
        for n, item in enumerate(kind):
            _write(context, builder, item, builder.extract_value(value, n), address, offset)
            offset += 8 * words_of(item)
    elif isinstance(kind, types.Array):
        array = context.make_array(kind)(context, builder, value)
        word(builder.ptrtoint(array.data, WORD))
        for axis in range(kind.ndim):
            word(builder.extract_value(array.shape, axis), 1 + axis)
    elif isinstance(kind, types.Float):
        word(value)
    elif not isinstance(kind, types.NoneType):
        word(context.cast(builder, value, kind, types.int64))


@intrinsic
def load_tuple(typing_context, kind, address):
    """The tuple of numba type `kind` (a TypeRef) whose words are at `address`."""

    def generate(context, builder, signature, arguments):
        return _read(context, builder, signature.return_type, arguments[1], 0)

    return kind.instance_type(kind, types.int64), generate


@intrinsic
def store_tuple(typing_context, value, address):
    """Write the words of a tuple to `address`."""

    def generate(context, builder, signature, arguments):
        _write(context, builder, value, arguments[0], arguments[1], 0)
        return context.get_dummy_value()

    return types.void(value, types.int64), generate


@intrinsic
def load_params(typing_context, params_kind, kind, own, shape):
    """A law's Params from the words that `store_params` wrote to `own` and those of its Shape at `shape`."""
    params = params_kind.instance_type

    def generate(context, builder, signature, arguments):
        items, offset = [], 0
        for _, field, shared in fields_of(params, kind.instance_type):
            if shared is None:
                items.append(_read(context, builder, field, arguments[2], offset))
                offset += 8 * words_of(field)
            else:
                items.append(_read(context, builder, field, arguments[3], shared))
        return context.make_tuple(builder, params, items)

    return params(params_kind, kind, types.int64, types.int64), generate


@intrinsic
def store_params(typing_context, kind, params, address):
    """Write the words of a law's Params that are not in its Shape, whose numba type is `kind`, to `address`."""

    def generate(context, builder, signature, arguments):
        offset = 0
        for n, (_, field, shared) in enumerate(fields_of(params, kind.instance_type)):
            if shared is None:
                _write(context, builder, field, builder.extract_value(arguments[1], n), arguments[2], offset)
                offset += 8 * words_of(field)
        return context.get_dummy_value()

    return types.void(kind, params, types.int64), generate
