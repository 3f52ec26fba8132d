"""The contact step: compiled code that runs inside YADE at each contact, no Python, no YADE.

`respond` is the law: one contact, its pair of surfaces, its overlap and history in; force, tangent and new history out.
`act` is that law at work inside a native functor (see `native`). Addresses are 64-bit integers; `layout` describes the memory.
"""

import math

import numba
import numpy as np
from numba import literal_unroll, types
from numba.extending import overload

from demlaws.core.dispatch import scale, step, stored_and_dissipated
from demlaws.core.fastmath import from_bits
from demlaws.core.hertz import hertz_coefficient
from demlaws.core.numba_compat import INLINED, callback, kernel, loop
from demlaws.core.params import clamped_roughness
from demlaws.core.shear import shear_stiffness
from demlaws.core.unloading import rule_of, without_own
from demlaws.laws.hertz import HertzParams, HertzShape
from demlaws.units import LARGEST_OVERLAP, SMALL_OVERLAP
from demlaws.yade import layout as at
from demlaws.yade.layout import LINES_OF_GEOMETRY, LINES_OF_INTERACTION, LINES_OF_PHYSICS
from demlaws.yade.memory import (
    add_double,
    add_word,
    call_body_by_id,
    call_go,
    load_byte,
    load_double,
    load_int,
    load_params,
    load_tuple,
    load_word,
    prefetch,
    store_double,
    store_own,
    store_tuple,
    store_word,
)

SLACK = 1e-11


def load_state(rule, address):
    """The rule's state values at `address`."""


@overload(load_state, jit_options=INLINED)
def _load_state(rule, address):
    kind = types.Tuple([types.float64] * len(rule_of(rule.instance_class).state))
    return lambda rule, address: load_tuple(kind, address)


# --- the law


@kernel
def params_of(kind, record, radius, modulus):
    """The law's Params for a contact whose surfaces are the pair in `record`."""
    roughness = clamped_roughness(load_double(record + at.RECORD_ROUGHNESS), radius)
    return scale(load_tuple(kind, record + at.RECORD_SHAPE), radius, modulus, roughness)


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
def kept_share(kso, overlap, old_kso, old_overlap):
    """Share of the shear force that stays: where K_t = kso √δ falls, the part of the contact that opens takes its force along.

    What is stored, F²/(2 K_t), then never grows without work (docs/shear.md). [our derivation]
    """
    old = old_kso * math.sqrt(old_overlap)
    now = kso * math.sqrt(overlap)
    return now / old if now < old * (1.0 - SLACK) else 1.0  # rounding is no fall


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
    return load_word(call_body_by_id(word(context, at.BODY_BY_ID), load_int(interaction + word(context, body))))


@kernel
def is_flat(context, body):
    """Whether a body's shape is a facet, a wall or a box."""
    shape = load_word(load_word(body + word(context, at.SHAPE)))
    return shape == word(context, at.FACET) or shape == word(context, at.WALL) or shape == word(context, at.BOX)


@numba.njit(error_model="numpy", nogil=True)
def surface_of(context, pointer):
    """Number of the surface whose label the body's material bears; 0 where no surface has that label."""
    label = load_word(pointer + word(context, at.MATERIAL)) + word(context, at.LABEL)
    text = load_word(label)
    value = np.uint64(0xCBF29CE484222325)
    for n in range(load_word(label + 8)):
        value = (value ^ np.uint64(load_byte(text + n))) * np.uint64(0x100000001B3)
    signed = np.int64(value)
    hashes = word(context, at.LABEL_HASHES)
    for number in range(1, word(context, at.SURFACES)):
        if load_word(hashes + 8 * number) == signed:
            return number
    return 0


@kernel
def alarm(context):
    """Have the guard run before the contacts of the next step."""
    if word(context, at.ALARM) != 0:
        store_word(word(context, at.ALARM), 0)


@numba.njit(error_model="numpy", nogil=True)
def fault(context, kind, interaction, overlap):
    """Note a fault for the guard, which stops the simulation before the next step with a message about the last one."""
    alarm(context)
    store_word(context + 8 * at.FAULTS, 1)
    store_word(context + 8 * at.FAULT_KIND, kind)
    store_word(context + 8 * at.FAULT_BODY1, np.int64(load_int(interaction + word(context, at.BODY1))))
    store_word(context + 8 * at.FAULT_BODY2, np.int64(load_int(interaction + word(context, at.BODY2))))
    store_double(context + 8 * at.FAULT_OVERLAP, overlap)


@numba.njit(error_model="numpy", nogil=True)
def deep(context, history, overlap):
    """TOO_DEEP for an overlap beyond LARGEST_OVERLAP of R, else 0. The guard reports the first one beyond SMALL_OVERLAP."""
    if load_double(history + at.MODULUS) == 0.0:
        return 0  # a marker
    if overlap > LARGEST_OVERLAP * load_double(history + at.RADIUS):
        store_double(context + 8 * at.DEEP_RADIUS, load_double(history + at.RADIUS))
        return at.TOO_DEEP
    if word(context, at.DEEP) == 0:
        store_word(context + 8 * at.DEEP, 1)
        alarm(context)
    return 0


@numba.njit(error_model="numpy", nogil=True)
def serves(record, radius, modulus):
    """Whether the pair's law may be used at this R and E*: a table of a law that does not collapse is for one contact."""
    only_radius, only_modulus = load_double(record + at.RECORD_RADIUS), load_double(record + at.RECORD_MODULUS)
    return only_radius == 0.0 or (
        abs(radius - only_radius) <= 1e-6 * only_radius and abs(modulus - only_modulus) <= 1e-6 * only_modulus
    )


@kernel
def record_of(context, history):
    """Address of the record of the contact's pair of surfaces."""
    return word(context, at.RECORDS) + (np.int64(load_double(history + at.TAG)) - 1) * word(context, at.RECORD_BYTES)


@numba.njit(error_model="numpy", nogil=True)
def initialise_contact(context, geom, phys, interaction):
    """Write R, E*, K_t/K and the pair to the history of a new contact."""
    radius2 = load_double(geom + word(context, at.RADIUS2))
    radius = effective_radius(load_double(geom + word(context, at.RADIUS1)), radius2)
    native = load_double(phys + word(context, at.KNO))
    modulus = 0.75 * native / math.sqrt(radius)
    body1, body2 = body_of(context, interaction, at.BODY1), body_of(context, interaction, at.BODY2)
    if word(context, at.FLATS) != 0 and (is_flat(context, body1) or is_flat(context, body2)):
        radius = radius2  # YADE's own radius of a contact with a flat is half or two thirds of it
    history = phys + word(context, at.HISTORY)
    first, second = surface_of(context, body1), surface_of(context, body2)
    if (first == 0 or second == 0) and word(context, at.UNLISTED) == 0 and word(context, at.UNLISTED_SEEN) == 0:
        store_word(context + 8 * at.UNLISTED_BODY1, np.int64(load_int(interaction + word(context, at.BODY1))))
        store_word(context + 8 * at.UNLISTED_BODY2, np.int64(load_int(interaction + word(context, at.BODY2))))
        store_word(context + 8 * at.UNLISTED_SEEN, 1)
        alarm(context)
    pair = load_word(word(context, at.PAIRS) + 8 * (first * word(context, at.SURFACES) + second))
    record = word(context, at.RECORDS) + pair * word(context, at.RECORD_BYTES)
    store_double(history + at.RADIUS, radius)
    store_double(history + at.MODULUS, modulus)
    ratio = from_bits(word(context, at.RATIO))
    add_word(context + 8 * at.OPEN, 1)
    if native == 0.0:
        ratio = 0.0
    elif not 0.0 < native < math.inf:
        fault(context, at.WRONG_MODULUS, interaction, modulus)
        store_double(history + at.MODULUS, 0.0)  # a marker until the guard stops the run: no force
    elif not serves(record, radius, modulus):
        fault(context, at.WRONG_CONTACT, interaction, radius)
    elif load_double(record + at.RECORD_ROUGHNESS) > radius:
        fault(context, at.TOO_ROUGH, interaction, radius)
    elif ratio == 0.0:
        ratio = load_double(phys + word(context, at.KSO)) / (1.5 * native)
    store_double(phys + word(context, at.SPARE), ratio)
    store_double(history + at.TAG, pair + 1.0)


@kernel
def known_row(context, code):
    """Address of the row that `code` names; 0 where it is not a row of this process."""
    if code >> 28 != word(context, at.GENERATION):
        return 0
    return word(context, at.ROWS) + 8 * (code & 0xFFFFFFF) * word(context, at.ROW_WORDS)


@kernel
def prefetch_from(row):
    """Ask for the memory of the contact that `row` is about, if it still lives there."""
    phys, geom, interaction = (
        load_word(row + at.ROW_PHYSICS),
        load_word(row + at.ROW_GEOMETRY),
        load_word(row + at.ROW_INTERACTION),
    )
    for line in literal_unroll(LINES_OF_PHYSICS):
        prefetch(phys + line)
    for line in literal_unroll(LINES_OF_GEOMETRY):
        prefetch(geom + line)
    for line in literal_unroll(LINES_OF_INTERACTION):
        prefetch(interaction + line)


@loop
def make_row(kind, context, geom, phys, interaction):
    """The number of a row, made for a contact that has none in this process, negative for a smooth pair; 0: no room."""
    history = phys + word(context, at.HISTORY)
    if load_double(history + at.TAG) == 0.0:
        initialise_contact(context, geom, phys, interaction)
    number = add_word(context + 8 * at.ROWS_USED, 1)
    if number >= word(context, at.CAPACITY) >> 1:
        alarm(context)  # the guard makes a larger buffer before the next step
    if number >= word(context, at.CAPACITY):
        return 0
    row = word(context, at.ROWS) + 8 * number * word(context, at.ROW_WORDS)
    record, radius, modulus = record_of(context, history), load_double(history + at.RADIUS), load_double(history + at.MODULUS)
    store_word(row + at.ROW_PHYSICS, phys)
    store_word(row + at.ROW_GEOMETRY, geom)
    store_word(row + at.ROW_INTERACTION, interaction)
    store_word(row + at.ROW_RECORD, record)
    code = (word(context, at.GENERATION) << 28) + number
    if load_word(record) != 0 or modulus == 0.0:
        code = -code
        store_double(row + at.ROW_OWN, hertz_coefficient(radius, modulus))
    else:
        store_own(kind, params_of(kind, record, radius, modulus), row + at.ROW_OWN)
    store_double(phys + word(context, at.SPARE) + 8, float(code))
    return code


@loop
def respond_without_row(kind, shear, rule, context, history, overlap, state):
    """`respond` for the steps in which the buffer of rows is full."""
    record = record_of(context, history)
    return respond(
        kind, shear, rule, record, load_double(history + at.RADIUS), load_double(history + at.MODULUS), overlap, state
    )


@loop
def end_contact(kind, rule, context, history, state):
    """Bank the dissipation of a contact that ends."""
    radius, modulus = load_double(history + at.RADIUS), load_double(history + at.MODULUS)
    add_double(context + 8 * at.BANKED, energies(kind, rule, record_of(context, history), radius, modulus, 0.0, state)[1])


@kernel
def lessen_shear(context, phys, kso, overlap):
    """Reduce the shear force to the share that `kept_share` allows; phys is as the last step left it."""
    old_kso, old_overlap = load_double(phys + word(context, at.KSO)), load_double(phys + word(context, at.SPARE) + 16)
    if kso < old_kso * (1.0 - SLACK) or overlap < old_overlap:  # else K_t has not fallen
        share = kept_share(kso, overlap, old_kso, old_overlap)
        place = phys + word(context, at.SHEAR_FORCE)
        for axis in range(3):
            store_double(place + 8 * axis, share * load_double(place + 8 * axis))


@kernel
def act(kind, params_kind, shear, rule, context, this, geom_pointer, phys_pointer, interaction):
    """The body of `go`: our force and stiffness as coefficients of Mindlin's law, which then does all the rest."""
    geom, phys = load_word(geom_pointer), load_word(phys_pointer)
    geom_class = load_word(geom)
    known = geom_class == word(context, at.GEOMETRY) or geom_class == word(context, at.GEOMETRY_6D)
    if not known or load_word(phys) != word(context, at.PHYSICS):
        fault(context, at.WRONG_CLASS, interaction, 0.0)
        return call_go(word(context, at.GO), this, geom_pointer, phys_pointer, interaction)
    overlap = load_double(geom + word(context, at.OVERLAP))
    history = phys + word(context, at.HISTORY)
    code = np.int64(load_double(phys + word(context, at.SPARE) + 8))
    old = load_state(rule, history + at.STATE)
    row = known_row(context, abs(code))
    if row == 0:
        code = make_row(kind, context, geom, phys, interaction)
        row = known_row(context, abs(code))
    if row == 0:
        force, stiffness, sideways, new = respond_without_row(kind, shear, rule, context, history, overlap, old)
    else:
        prefetch_from(row + at.AHEAD * 8 * word(context, at.ROW_WORDS))
        if code > 0:
            p = load_params(params_kind, kind, row + at.ROW_OWN, load_word(row + at.ROW_RECORD) + at.RECORD_SHAPE)
            force, stiffness, sideways, new = answer(shear, rule, p, overlap, old)
        elif load_double(row + at.ROW_OWN) != 0.0:
            p = HertzParams(load_double(row + at.ROW_OWN))
            force, stiffness, sideways, new = answer(shear, without_own(rule), p, overlap, old)
        else:
            force, stiffness, sideways, new = 0.0, 0.0, 0.0, old
    wrong = at.NOT_FINITE if force - force != 0.0 else 0
    if overlap > SMALL_OVERLAP * load_double(history + at.RADIUS):
        wrong = max(wrong, deep(context, history, overlap))
    if wrong != 0:
        fault(context, wrong, interaction, overlap)
        force, stiffness, sideways, new = math.nan, 0.0, 0.0, old
        if word(context, at.ALARM) != 0:  # without a guard, propagate NaN
            force = 0.0
    if overlap > 0.0:
        kno, kso = coefficients(force, sideways, overlap, load_double(phys + word(context, at.SPARE)))
        lessen_shear(context, phys, kso, overlap)
        store_double(phys + word(context, at.KNO), kno)
        store_double(phys + word(context, at.KSO), kso)
    else:
        end_contact(kind, rule, context, history, old)
        if overlap - overlap != 0.0:
            fault(context, at.NOT_FINITE, interaction, overlap)  # a body is infinitely far away
    store_tuple(new, history + at.STATE)
    keep = call_go(word(context, at.GO), this, geom_pointer, phys_pointer, interaction)
    if keep == 0:
        add_word(context + 8 * at.OPEN, -1)
    if overlap > 0.0:
        store_double(phys + word(context, at.SPARE) + 16, overlap)
        # Mindlin left 1.5 P/δ here; the time stepper needs the tangent
        store_double(phys + word(context, at.KN), stiffness)
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
        state = contacts.ctypes.data + i * contacts.itemsize + at.STATE_OFFSET
        old = load_state(rule, state)
        force, stiffness, sideways, new = respond(kind, shear, rule, record, c.radius, c.modulus, c.overlap, old)
        if force - force != 0.0 or c.overlap - c.overlap != 0.0:
            bad = i if bad < 0 else bad
            force, stiffness, sideways, new = 0.0, 0.0, 0.0, old
        store_tuple(new, state)
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
        state = load_state(rule, contacts.ctypes.data + i * contacts.itemsize + at.STATE_OFFSET)
        stored, dissipated = energies(kind, rule, record, c.radius, c.modulus, c.overlap, state)
        out[i].stored = stored
        out[i].dissipated = dissipated
