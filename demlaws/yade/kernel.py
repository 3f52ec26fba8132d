"""What runs inside YADE at each contact and each step: compiled code that reads and writes memory, no Python, no YADE.

`respond` is the law: one contact, its pair of surfaces, its overlap and history in; force, tangent and new history out.
`act` is that law at work inside a native functor (see `native`). Addresses are 64-bit integers. All that `act` must
know it finds in the context, a block of words whose address stands behind the functor's table of virtual functions, so
that one piece of machine code, kept on disk by numba, serves every functor of a law.
"""

import math

import numba
import numpy as np
from llvmlite import ir
from numba import literal_unroll, types
from numba.extending import intrinsic, overload

from demlaws.core.dispatch import scale, step, stored_and_dissipated
from demlaws.core.fastmath import cbrt, from_bits
from demlaws.core.hertz import hertz_coefficient
from demlaws.core.numba_compat import INLINED, callback, kernel, loop
from demlaws.core.params import clamped_roughness
from demlaws.core.shear import CHOICES, shear_stiffness
from demlaws.core.unloading import without_own
from demlaws.laws.hertz import HertzParams, HertzShape
from demlaws.units import LARGEST_OVERLAP, SMALL_OVERLAP

# Words of the context.
GO = 0  # the native function that applies the forces
OVERLAP, RADIUS1, RADIUS2 = 1, 2, 3  # where ScGeom keeps its numbers [bytes]
KN, KNO, KSO, HISTORY, SPARE = 4, 5, 6, 7, 8  # where MindlinPhys keeps its numbers [bytes]
GEOMETRY, GEOMETRY_6D, PHYSICS = 9, 10, 11  # what the first word of an object of these classes is
BODY1, BODY2, BODY_BY_ID, MATERIAL, LABEL = 12, 13, 14, 15, 16
SURFACES, LABEL_HASHES, PAIRS, RECORDS, RECORD_BYTES = 17, 18, 19, 20, 21
RATIO = 22  # tangential over normal stiffness (a double); 0: as YADE's Ip2 functor has it
BANKED = 24  # dissipation of contacts that have ended [J] (a double)
ROWS, ROW_WORDS, CAPACITY, GENERATION = 25, 26, 27, 28  # the contacts' rows, their size, number, validity
ROWS_USED = 37
FAULTS, FAULT_KIND, FAULT_BODY1, FAULT_BODY2, FAULT_OVERLAP = 32, 33, 34, 35, 36  # a cache line apart from the above
ALARM = 38  # address of the guard's PyRunner.nDone, or 0: a zero written there makes it run before the next step's contacts
FLATS, SHAPE, FACET, WALL, BOX = 40, 41, 42, 43, 44  # FLATS 1: R of a sphere on one of these shapes is the sphere's radius
UNLISTED, UNLISTED_SEEN, UNLISTED_BODY1, UNLISTED_BODY2 = 45, 46, 47, 48  # contacts of materials without a surface
SHEAR_FORCE = 49  # where MindlinPhys keeps its elastic shear force [bytes]
DEEP = 50  # 1 once a contact was beyond SMALL_OVERLAP of its R
DEEP_RADIUS = 51  # R of the last contact that was beyond LARGEST_OVERLAP of it (a double)
CONTEXT_WORDS = 56

# A contact outside YADE's objects: its history as in MindlinPhys, and what the law answers.
CONTACT = np.dtype([(name, "f8") for name in ("overlap", "ratio", "tag", "radius", "modulus", "state0", "state1", "state2")])
RESPONSE = np.dtype([(name, "f8") for name in ("kno", "kso", "tangent")])
ENERGY = np.dtype([(name, "f8") for name in ("stored", "dissipated")])
STATE_OFFSET = CONTACT.fields["state0"][1]

# A contact's history in MindlinPhys.momentBend, momentTwist (6 doubles, which Mindlin's law without moments ignores):
# pair number + 1 (0: not seen yet), radius R [m], modulus E* [Pa], then up to three state values of the unloading rule;
# prevU[0] holds K_t/K, prevU[1] the number of the contact's row, negative for a smooth pair, prevU[2] the overlap of the last
# step, which ScGeom does not save. Rows are memory of this process,
# so the number carries a generation drawn at random: a row of another process or of a buffer since renewed is not taken.
TAG, RADIUS, MODULUS, STATE = 0, 8, 16, 24

# A row: the addresses of the contact's phys, geom and interaction and of its pair's record, then those numbers of its
# Params that are its own: derived numbers, which cost too much to derive at each step (a law that yields finds its yield
# point by bisection). Rows are made, and so stand, in the order in which YADE visits contacts: the addresses in the row
# after next say what will be needed soon. YADE's objects are scattered, and the processor cannot guess them.
ROW_PHYSICS, ROW_GEOMETRY, ROW_INTERACTION, ROW_RECORD, ROW_OWN = 0, 8, 16, 24, 32
AHEAD = 2  # rows; measured: 1 to 4 serve alike
LINES_OF_PHYSICS, LINES_OF_GEOMETRY, LINES_OF_INTERACTION = (32, 96, 160, 224, 288, 352), (0, 64, 128, 192), (0, 64)

SLACK = 1e-11

WRONG_CLASS, NOT_FINITE, WRONG_CONTACT, TOO_ROUGH, TOO_DEEP, WRONG_MODULUS = 1, 2, 3, 4, 5, 6

# A pair's record: smooth (0 or 1), roughness σ, the only R and E* that the law is for (0: any), then the shape.
RECORD_ROUGHNESS, RECORD_RADIUS, RECORD_MODULUS, RECORD_SHAPE = 8, 16, 24, 32

_WORD = ir.IntType(64)


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


load_word, store_word = _accessors(types.int64, _WORD)
load_double, store_double = _accessors(types.float64, ir.DoubleType())
load_int, _ = _accessors(types.int32, ir.IntType(32))
load_byte, _ = _accessors(types.uint8, ir.IntType(8))


@intrinsic
def add_double(typing_context, address, value):
    """Atomically add to the double at `address`: threads meet here."""

    def generate(context, builder, signature, arguments):
        builder.atomic_rmw("fadd", builder.inttoptr(arguments[0], ir.DoubleType().as_pointer()), arguments[1], "monotonic")
        return context.get_dummy_value()

    return types.void(types.int64, types.float64), generate


@intrinsic
def next_number(typing_context, address):
    """Atomically add 1 to the word at `address` and return what it was."""

    def generate(context, builder, signature, arguments):
        place = builder.inttoptr(arguments[0], _WORD.as_pointer())
        return builder.atomic_rmw("add", place, ir.Constant(_WORD, 1), "monotonic")

    return types.int64(types.int64), generate


@intrinsic
def prefetch(typing_context, address):
    """Ask for the cache line at `address`, which need not be valid."""

    def generate(context, builder, signature, arguments):
        pointer, flag = ir.IntType(8).as_pointer(), ir.IntType(32)
        kind = ir.FunctionType(ir.VoidType(), [pointer, flag, flag, flag])
        function = builder.module.globals.get("llvm.prefetch.p0i8") or ir.Function(builder.module, kind, "llvm.prefetch.p0i8")
        builder.call(function, [builder.inttoptr(arguments[0], pointer), flag(1), flag(3), flag(1)])
        return context.get_dummy_value()

    return types.void(types.int64), generate


@intrinsic
def call_go(typing_context, function, this, geom, phys, interaction):
    """bool Law2::go(shared_ptr<IGeom>&, shared_ptr<IPhys>&, Interaction*), through its address."""

    def generate(context, builder, signature, arguments):
        kind = ir.FunctionType(ir.IntType(8), [_WORD] * 4)
        return builder.call(builder.inttoptr(arguments[0], kind.as_pointer()), arguments[1:])

    return types.uint8(*[types.int64] * 5), generate


@intrinsic
def call_body_by_id(typing_context, function, number):
    """const shared_ptr<Body>& Body::byId(int, Scene* = nullptr): the current scene's body, through the function's address."""

    def generate(context, builder, signature, arguments):
        kind = ir.FunctionType(_WORD, [ir.IntType(32), _WORD])
        return builder.call(builder.inttoptr(arguments[0], kind.as_pointer()), [arguments[1], ir.Constant(_WORD, 0)])

    return types.int64(types.int64, types.int32), generate


@intrinsic
def as_pointer(typing_context, address):
    """An address as a pointer, for compiled code."""

    def generate(context, builder, signature, arguments):
        return builder.inttoptr(arguments[0], ir.IntType(8).as_pointer())

    return types.voidptr(types.int64), generate


# --- tuples as words in memory


def pack(value, keep):
    """The words that `unpack` turns back into this (nested, named) tuple; arrays are appended to `keep`."""
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


def own_words(params_kind, kind):
    """Number of words of a law's Params that belong to one contact; the others are its Shape's."""
    return sum(_words(field) for _, field, shared in fields_of(params_kind, kind) if shared is None)


def _words(kind):
    return _read(kind, "", 0, {})[1] // 8


def fields_of(params_kind, kind):
    """(name, type, offset in the Shape or None) of each field of Params: a field of the Shape's of the same name and type,
    at any depth, holds the same value (the tests see to it)."""
    places, level = {}, [(kind, 0)]
    while level:
        deeper = []
        for owner, offset in level:
            for name, field in zip(owner.fields, owner.types, strict=True):
                places.setdefault((name, field), offset)
                if isinstance(field, types.BaseNamedTuple):
                    deeper.append((field, offset))
                offset += 8 * _words(field)
        level = deeper
    return [(name, field, places.get((name, field))) for name, field in zip(params_kind.fields, params_kind.types, strict=True)]


def store_own(kind, params, address):
    """Write to `address` what in a law's Params is not in its Shape, whose numba type is `kind`."""


@overload(store_own, jit_options=INLINED)
def _store_own(kind, params, address):
    lines, offset = [], 0
    for name, field, shared in fields_of(params, kind.instance_type):
        if shared is None:
            more, offset = _write(field, f"params.{name}", offset)
            lines += more
    names = {"store_word": store_word, "store_double": store_double}
    exec("def function(kind, params, address):\n" + "".join(f"    {line}\n" for line in lines) + "    return\n", names)
    return names["function"]


def _write(kind, expression, offset):
    """Statements that write a value of this numba type, and the offset behind it."""
    if isinstance(kind, types.BaseTuple):
        lines = []
        for n, item in enumerate(kind):
            more, offset = _write(item, f"{expression}[{n}]", offset)
            lines += more
        return lines, offset
    if isinstance(kind, types.NoneType):
        return [], offset
    if isinstance(kind, types.Array):
        values = [f"{expression}.ctypes.data", *(f"{expression}.shape[{axis}]" for axis in range(kind.ndim))]
        lines = [f"store_word(address + {offset + 8 * n}, {value})" for n, value in enumerate(values)]
        return lines, offset + 8 * len(values)
    if isinstance(kind, types.Float):
        return [f"store_double(address + {offset}, {expression})"], offset + 8
    return [f"store_word(address + {offset}, int({expression}))"], offset + 8


def unpack(kind, address):
    """The tuple of numba type `kind` (a TypeRef) that `pack` wrote to `address`."""


@overload(unpack, jit_options=INLINED)
def _unpack(kind, address):
    names = dict(_READERS)
    text, _ = _read(kind.instance_type, "address", 0, names)
    exec(f"def function(kind, address):\n    return {text}\n", names)
    return names["function"]


def read_params(params_kind, kind, own, shape):
    """A law's Params from what `store_own` wrote to `own` and `pack` to `shape`."""


@overload(read_params, jit_options=INLINED)
def _read_params(params_kind, kind, own, shape):
    names, items, offset = dict(_READERS), [], 0
    for _, field, shared in fields_of(params_kind.instance_type, kind.instance_type):
        if shared is None:
            text, offset = _read(field, "own", offset, names)
        else:
            text, _ = _read(field, "shape", shared, names)
        items.append(text + ", ")
    names["Params"] = params_kind.instance_type.instance_class
    exec(f"def function(params_kind, kind, own, shape):\n    return Params({''.join(items)})\n", names)
    return names["function"]


_READERS = {"load_word": load_word, "load_double": load_double, "carray": numba.carray, "as_pointer": as_pointer}


def _read(kind, base, offset, names):
    """Source text that reads a value of this numba type at base + offset, and the offset behind it."""
    if isinstance(kind, types.BaseTuple):
        items = []
        for item in kind:
            text, offset = _read(item, base, offset, names)
            items.append(text + ", ")
        name = ""
        if isinstance(kind, types.BaseNamedTuple):
            name = f"Class{len(names)}"
            names[name] = kind.instance_class
        return f"{name}({''.join(items)})", offset
    if isinstance(kind, types.NoneType):
        return "None", offset
    if isinstance(kind, types.Array):
        sizes = "".join(f"load_word({base} + {offset + 8 * (axis + 1)}), " for axis in range(kind.ndim))
        name = f"dtype{len(names)}"
        names[name] = np.dtype(str(kind.dtype))
        return f"carray(as_pointer(load_word({base} + {offset})), ({sizes}), {name})", offset + 8 * (kind.ndim + 1)
    if isinstance(kind, types.Float):
        return f"load_double({base} + {offset})", offset + 8
    if isinstance(kind, types.Boolean):
        return f"(load_word({base} + {offset}) != 0)", offset + 8
    if isinstance(kind, types.Integer):
        return f"load_word({base} + {offset})", offset + 8
    raise TypeError(f"a law's shape holds {kind}, which cannot be handed to YADE")


def read_state(rule, address):
    """The rule's state values at `address`."""


@overload(read_state, jit_options=INLINED)
def _read_state(rule, address):
    names = {"load_double": load_double}
    items = "".join(f"load_double(address + {8 * n}), " for n in range(_state_size(rule)))
    exec(f"def function(rule, address):\n    return ({items})\n", names)
    return names["function"]


def write_state(rule, address, state):
    """Store the rule's state values at `address`."""


@overload(write_state, jit_options=INLINED)
def _write_state(rule, address, state):
    names = {"store_double": store_double}
    lines = "".join(f"    store_double(address + {8 * n}, state[{n}])\n" for n in range(_state_size(rule)))
    exec(f"def function(rule, address, state):\n{lines}    return\n", names)
    return names["function"]


def _state_size(rule):
    from demlaws.core.unloading import rule_of

    return len(rule_of(rule.instance_class).state)


# --- the law


@kernel
def params_of(kind, record, radius, modulus):
    """The law's Params for a contact whose surfaces are the pair in `record`."""
    roughness = clamped_roughness(load_double(record + RECORD_ROUGHNESS), radius)
    return scale(unpack(kind, record + RECORD_SHAPE), radius, modulus, roughness)


@kernel
def answer(shear, rule, p, overlap, state):
    """Force [N], tangent stiffness, the stiffness that K_t goes by [N/m], and new state."""
    force, stiffness, new = step(rule, p, overlap, state)
    return force, stiffness, shear_stiffness(shear, rule, p, overlap, force, stiffness, new), new


@kernel
def respond(kind, shear, rule, record, radius, modulus, overlap, state):
    """`answer` of a contact whose surfaces are the pair in `record`."""
    if modulus == 0.0:  # a marker: YADE's own law gives it no force
        return 0.0, 0.0, 0.0, state
    if load_word(record) != 0:
        return answer(shear, without_own(rule), scale(HertzShape(), radius, modulus, 0.0), overlap, state)
    return answer(shear, rule, params_of(kind, record, radius, modulus), overlap, state)


@kernel
def energies(kind, rule, record, radius, modulus, overlap, state):
    """Stored and dissipated energy [J] of a contact since it was made."""
    if modulus == 0.0:
        return 0.0, 0.0
    if load_word(record) != 0:
        return stored_and_dissipated(without_own(rule), scale(HertzShape(), radius, modulus, 0.0), overlap, state)
    return stored_and_dissipated(rule, params_of(kind, record, radius, modulus), overlap, state)


@kernel
def coefficients(force, shear, overlap, ratio):
    """kno and kso with which Mindlin's law gives this force, and a tangential stiffness of `ratio` times `shear`."""
    power = overlap * math.sqrt(overlap)
    if power > 1e-290:
        inverse = 1.0 / power  # of the overlap alone: ready before the force is
        return force * inverse, ratio * shear * (overlap * inverse)
    return 0.0, 0.0  # the force is below 1e-270 N; the quotient would overflow


@kernel
def kept_share(kno, kso, overlap, old_kno, old_kso, old_overlap):
    """The share of a shear force that stays when K_t falls by more than it does under Mindlin's law on the same path of forces.

    Mindlin's law adds K_t du, so that what is stored, F²/(2 K_t), grows when K_t falls; smooth spheres have K_t ∝ P^(1/3). The
    share lets it grow by the factor (P_old/P)^(1/3) at most, and not at all where P does not fall. [our derivation]
    """
    cubed = kso * kso * kso * old_kno  # K_t³/P is kso³/kno
    old = old_kso * old_kso * old_kso * kno
    if cubed >= old * (1.0 - SLACK):  # rounding is no fall
        return 1.0
    fall = kso * math.sqrt(overlap) / (old_kso * math.sqrt(old_overlap)) if old_overlap > 0.0 else 1.0
    more = old_kno * old_overlap * math.sqrt(old_overlap) / (kno * overlap * math.sqrt(overlap)) if kno > 0.0 else 0.0
    return min(fall * (cbrt(more) if more > 1.0 else 1.0), 1.0)


@kernel
def effective_radius(radius1, radius2):
    """R as Ip2_FrictMat_FrictMat_MindlinPhys has it from ScGeom's two radii."""
    first = radius1 if radius1 > 0.0 else radius2
    return first * radius2 / (first + radius2)


@kernel
def word(context, number):
    """Word `number` of the context."""
    return load_word(context + 8 * number)


@kernel
def body_of(context, interaction, body):
    """Address of one of the two bodies of a contact."""
    return load_word(call_body_by_id(word(context, BODY_BY_ID), load_int(interaction + word(context, body))))


@kernel
def is_flat(context, body):
    """Whether a body's shape is a facet, a wall or a box."""
    shape = load_word(load_word(body + word(context, SHAPE)))
    return shape == word(context, FACET) or shape == word(context, WALL) or shape == word(context, BOX)


@numba.njit(error_model="numpy", nogil=True)
def surface_of(context, pointer):
    """Number of the surface whose label the body's material bears; 0 where no surface has that label."""
    label = load_word(pointer + word(context, MATERIAL)) + word(context, LABEL)
    text = load_word(label)
    value = np.uint64(0xCBF29CE484222325)
    for n in range(load_word(label + 8)):
        value = (value ^ np.uint64(load_byte(text + n))) * np.uint64(0x100000001B3)
    signed = np.int64(value)
    hashes = word(context, LABEL_HASHES)
    for number in range(1, word(context, SURFACES)):
        if load_word(hashes + 8 * number) == signed:
            return number
    return 0


def label_hash(label):
    """FNV-1a of a material's label, as a signed 64-bit integer: what `surface_of` compares."""
    value = 0xCBF29CE484222325
    for byte in label.encode():
        value = (value ^ byte) * 0x100000001B3 % 2**64
    return value - 2**64 if value >= 2**63 else value


@kernel
def alarm(context):
    """Have the guard run before the contacts of the next step."""
    if word(context, ALARM) != 0:
        store_word(word(context, ALARM), 0)


@numba.njit(error_model="numpy", nogil=True)
def fault(context, kind, interaction, overlap):
    """Note a fault for the guard, which stops the simulation before the next step. The last one is told."""
    alarm(context)
    store_word(context + 8 * FAULTS, word(context, FAULTS) + 1)
    store_word(context + 8 * FAULT_KIND, kind)
    store_word(context + 8 * FAULT_BODY1, np.int64(load_int(interaction + word(context, BODY1))))
    store_word(context + 8 * FAULT_BODY2, np.int64(load_int(interaction + word(context, BODY2))))
    store_double(context + 8 * FAULT_OVERLAP, overlap)


@numba.njit(error_model="numpy", nogil=True)
def deep(context, history, overlap):
    """TOO_DEEP or 0 for an overlap beyond SMALL_OVERLAP of R, which the guard is told of once."""
    if load_double(history + MODULUS) == 0.0:
        return 0  # a marker
    if overlap > LARGEST_OVERLAP * load_double(history + RADIUS):
        store_double(context + 8 * DEEP_RADIUS, load_double(history + RADIUS))
        return TOO_DEEP
    if word(context, DEEP) == 0:
        store_word(context + 8 * DEEP, 1)
        alarm(context)
    return 0


@numba.njit(error_model="numpy", nogil=True)
def serves(record, radius, modulus):
    """Whether the pair's law may be used at this R and E*: a table of a law that does not collapse is for one contact."""
    only_radius, only_modulus = load_double(record + RECORD_RADIUS), load_double(record + RECORD_MODULUS)
    return only_radius == 0.0 or (
        abs(radius - only_radius) <= 1e-6 * only_radius and abs(modulus - only_modulus) <= 1e-6 * only_modulus
    )


@kernel
def record_of(context, history):
    """Address of the record of the contact's pair of surfaces."""
    return word(context, RECORDS) + (np.int64(load_double(history + TAG)) - 1) * word(context, RECORD_BYTES)


@numba.njit(error_model="numpy", nogil=True)
def first_sight(context, geom, phys, interaction):
    """Write down what the contact is made of: called once in a contact's life."""
    radius2 = load_double(geom + word(context, RADIUS2))
    radius = effective_radius(load_double(geom + word(context, RADIUS1)), radius2)
    native = load_double(phys + word(context, KNO))
    modulus = 0.75 * native / math.sqrt(radius)
    body1, body2 = body_of(context, interaction, BODY1), body_of(context, interaction, BODY2)
    if word(context, FLATS) != 0 and (is_flat(context, body1) or is_flat(context, body2)):
        radius = radius2  # YADE's own radius of a contact with a flat is half or two thirds of it
    history = phys + word(context, HISTORY)
    first, second = surface_of(context, body1), surface_of(context, body2)
    if (first == 0 or second == 0) and word(context, UNLISTED) == 0 and word(context, UNLISTED_SEEN) == 0:
        store_word(context + 8 * UNLISTED_BODY1, np.int64(load_int(interaction + word(context, BODY1))))
        store_word(context + 8 * UNLISTED_BODY2, np.int64(load_int(interaction + word(context, BODY2))))
        store_word(context + 8 * UNLISTED_SEEN, 1)
        alarm(context)
    pair = load_word(word(context, PAIRS) + 8 * (first * word(context, SURFACES) + second))
    record = word(context, RECORDS) + pair * word(context, RECORD_BYTES)
    store_double(history + RADIUS, radius)
    store_double(history + MODULUS, modulus)
    ratio = from_bits(word(context, RATIO))
    if native == 0.0:
        ratio = 0.0
    elif not 0.0 < native < math.inf:
        fault(context, WRONG_MODULUS, interaction, modulus)
        store_double(history + MODULUS, 0.0)  # a marker until the guard stops the run: no force
    elif not serves(record, radius, modulus):
        fault(context, WRONG_CONTACT, interaction, radius)
    elif load_double(record + RECORD_ROUGHNESS) > radius:
        fault(context, TOO_ROUGH, interaction, radius)
    elif ratio == 0.0:
        ratio = load_double(phys + word(context, KSO)) / (1.5 * native)
    store_double(phys + word(context, SPARE), ratio)
    store_double(history + TAG, pair + 1.0)


@kernel
def known_row(context, code):
    """Address of the row that `code` names; 0 where it is not a row of this process."""
    if code >> 28 != word(context, GENERATION):
        return 0
    return word(context, ROWS) + 8 * (code & 0xFFFFFFF) * word(context, ROW_WORDS)


@kernel
def prefetch_from(row):
    """Ask for the memory of the contact that `row` is about, if it still lives there."""
    phys, geom, interaction = load_word(row + ROW_PHYSICS), load_word(row + ROW_GEOMETRY), load_word(row + ROW_INTERACTION)
    for line in literal_unroll(LINES_OF_PHYSICS):
        prefetch(phys + line)
    for line in literal_unroll(LINES_OF_GEOMETRY):
        prefetch(geom + line)
    for line in literal_unroll(LINES_OF_INTERACTION):
        prefetch(interaction + line)


@loop
def make_row(kind, context, geom, phys, interaction):
    """The number of a row, made for a contact that has none in this process, negative for a smooth pair; 0: no room."""
    history = phys + word(context, HISTORY)
    if load_double(history + TAG) == 0.0:
        first_sight(context, geom, phys, interaction)
    number = next_number(context + 8 * ROWS_USED)
    if number >= word(context, CAPACITY) >> 1:
        alarm(context)  # the guard makes a larger buffer before the next step
    if number >= word(context, CAPACITY):
        return 0
    row = word(context, ROWS) + 8 * number * word(context, ROW_WORDS)
    record, radius, modulus = record_of(context, history), load_double(history + RADIUS), load_double(history + MODULUS)
    store_word(row + ROW_PHYSICS, phys)
    store_word(row + ROW_GEOMETRY, geom)
    store_word(row + ROW_INTERACTION, interaction)
    store_word(row + ROW_RECORD, record)
    code = (word(context, GENERATION) << 28) + number
    if load_word(record) != 0 or modulus == 0.0:
        code = -code
        store_double(row + ROW_OWN, hertz_coefficient(radius, modulus))
    else:
        store_own(kind, params_of(kind, record, radius, modulus), row + ROW_OWN)
    store_double(phys + word(context, SPARE) + 8, float(code))
    return code


@loop
def respond_without_row(kind, shear, rule, context, history, overlap, state):
    """`respond` for the steps in which the buffer of rows is full."""
    record = record_of(context, history)
    return respond(kind, shear, rule, record, load_double(history + RADIUS), load_double(history + MODULUS), overlap, state)


@loop
def end_contact(kind, rule, context, history, state):
    """Bank the dissipation of a contact that ends."""
    radius, modulus = load_double(history + RADIUS), load_double(history + MODULUS)
    add_double(context + 8 * BANKED, energies(kind, rule, record_of(context, history), radius, modulus, 0.0, state)[1])


def limit_shear(shear, context, phys, kno, kso, overlap):
    """Take from the shear force what `kept_share` does not leave it, for choices that are so limited."""


@overload(limit_shear, jit_options=INLINED)
def _limit_shear(shear, context, phys, kno, kso, overlap):
    if not next(choice.limited for choice in CHOICES.values() if type(choice.tag) is shear.instance_class):
        return lambda shear, context, phys, kno, kso, overlap: None

    def limit(shear, context, phys, kno, kso, overlap):
        # K_t = kso √δ has not fallen where neither has
        fallen = kso < load_double(phys + word(context, KSO)) * (1.0 - SLACK)
        if fallen or overlap < load_double(phys + word(context, SPARE) + 16):
            lessen_shear(context, phys, kno, kso, overlap)

    return limit


@numba.njit(error_model="numpy", nogil=True)
def lessen_shear(context, phys, kno, kso, overlap):
    """Of a contact whose K_t may have fallen; phys is as the last step left it."""
    old_kno, old_kso = load_double(phys + word(context, KNO)), load_double(phys + word(context, KSO))
    share = kept_share(kno, kso, overlap, old_kno, old_kso, load_double(phys + word(context, SPARE) + 16))
    if share < 1.0:
        place = phys + word(context, SHEAR_FORCE)
        for axis in range(3):
            store_double(place + 8 * axis, share * load_double(place + 8 * axis))


@kernel
def act(kind, params_kind, shear, rule, context, this, geom_pointer, phys_pointer, interaction):
    """The body of `go`: our force and stiffness as coefficients of Mindlin's law, which then does all the rest."""
    geom, phys = load_word(geom_pointer), load_word(phys_pointer)
    geom_class = load_word(geom)
    known = geom_class == word(context, GEOMETRY) or geom_class == word(context, GEOMETRY_6D)
    if not known or load_word(phys) != word(context, PHYSICS):
        fault(context, WRONG_CLASS, interaction, 0.0)
        return call_go(word(context, GO), this, geom_pointer, phys_pointer, interaction)
    overlap = load_double(geom + word(context, OVERLAP))
    history = phys + word(context, HISTORY)
    code = np.int64(load_double(phys + word(context, SPARE) + 8))
    old = read_state(rule, history + STATE)
    row = known_row(context, abs(code))
    if row == 0:
        code = make_row(kind, context, geom, phys, interaction)
        row = known_row(context, abs(code))
    if row == 0:
        force, stiffness, sideways, new = respond_without_row(kind, shear, rule, context, history, overlap, old)
    else:
        prefetch_from(row + AHEAD * 8 * word(context, ROW_WORDS))
        if code > 0:
            p = read_params(params_kind, kind, row + ROW_OWN, load_word(row + ROW_RECORD) + RECORD_SHAPE)
            force, stiffness, sideways, new = answer(shear, rule, p, overlap, old)
        elif load_double(row + ROW_OWN) != 0.0:
            p = HertzParams(load_double(row + ROW_OWN))
            force, stiffness, sideways, new = answer(shear, without_own(rule), p, overlap, old)
        else:
            force, stiffness, sideways, new = 0.0, 0.0, 0.0, old
    wrong = NOT_FINITE if force - force != 0.0 else 0
    if overlap > SMALL_OVERLAP * load_double(history + RADIUS):
        wrong = max(wrong, deep(context, history, overlap))
    if wrong != 0:
        fault(context, wrong, interaction, overlap)
        force, stiffness, sideways, new = math.nan, 0.0, 0.0, old
        if word(context, ALARM) != 0:  # else nobody watches: the number that is none shall be seen
            force = 0.0
    if overlap > 0.0:
        kno, kso = coefficients(force, sideways, overlap, load_double(phys + word(context, SPARE)))
        limit_shear(shear, context, phys, kno, kso, overlap)
        store_double(phys + word(context, KNO), kno)
        store_double(phys + word(context, KSO), kso)
    else:
        end_contact(kind, rule, context, history, old)
        if overlap - overlap != 0.0:
            fault(context, NOT_FINITE, interaction, overlap)  # a body is infinitely far away
    write_state(rule, history + STATE, new)
    keep = call_go(word(context, GO), this, geom_pointer, phys_pointer, interaction)
    if overlap > 0.0:
        store_double(phys + word(context, SPARE) + 16, overlap)
        # Mindlin left 1.5 P/δ here; the time stepper needs the tangent
        store_double(phys + word(context, KN), stiffness)
    return keep


KIND = PARAMS_KIND = SHEAR = RULE = BEHIND = None  # what `entry` gives to a copy of the function below


def _go(this, geom, phys, interaction):
    context = load_word(load_word(this) + BEHIND)
    return act(KIND, PARAMS_KIND, SHEAR, RULE, context, this, geom, phys, interaction)


def entry(kind, params_kind, shear, rule, behind):
    """`act` for laws of this kind as native code (`.address`); the address of the context stands `behind` bytes after the
    functor's table of virtual functions."""
    constants = {"KIND": kind, "PARAMS_KIND": params_kind, "SHEAR": shear, "RULE": rule, "BEHIND": behind}
    return callback(types.uint8(*[types.int64] * 4), _go, constants)


# --- batches: the public way, energies


@loop
def respond_loop(kind, shear, rule, records, record_bytes, contacts, out):
    """`respond` for an array of `CONTACT`, whose state is updated in place; out: an array of `RESPONSE`.

    Returns the first contact whose force is not finite, or -1.
    """
    bad = -1
    for i in range(contacts.size):
        c = contacts[i]
        record = records + (np.int64(c.tag) - 1) * record_bytes
        state = contacts.ctypes.data + i * contacts.itemsize + STATE_OFFSET
        old = read_state(rule, state)
        force, stiffness, sideways, new = respond(kind, shear, rule, record, c.radius, c.modulus, c.overlap, old)
        if force - force != 0.0 or c.overlap - c.overlap != 0.0:
            bad = i if bad < 0 else bad
            force, stiffness, sideways, new = 0.0, 0.0, 0.0, old
        write_state(rule, state, new)
        kno, kso = coefficients(force, sideways, c.overlap, c.ratio) if c.overlap > 0.0 else (0.0, 0.0)
        out[i].kno = kno
        out[i].kso = kso
        out[i].tangent = stiffness
    return bad


@loop
def energies_loop(kind, rule, records, record_bytes, contacts, out):
    """`energies` for an array of `CONTACT`; out: an array of `ENERGY`."""
    for i in range(contacts.size):
        c = contacts[i]
        record = records + (np.int64(c.tag) - 1) * record_bytes
        state = read_state(rule, contacts.ctypes.data + i * contacts.itemsize + STATE_OFFSET)
        stored, dissipated = energies(kind, rule, record, c.radius, c.modulus, c.overlap, state)
        out[i].stored = stored
        out[i].dissipated = dissipated
