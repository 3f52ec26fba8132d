"""The contact step: compiled code that runs inside YADE at each contact, no Python, no YADE.

`respond` is the law: one contact, its pair of surfaces, its overlap and history in; force, tangent and new history out.
`act` is that law at work inside a native functor (see `native`). Addresses are 64-bit integers; `layout` describes the memory.
"""

import math

import numba
import numpy as np
from numba import types
from numba.extending import overload

from demlaws.admissible import LARGEST_ROUGHNESS, RANGES
from demlaws.core.cache import source_digest
from demlaws.core.dispatch import scale, step, stored_and_dissipated
from demlaws.core.fastmath import from_bits, hertz_coefficient
from demlaws.core.loops import clamped_roughness
from demlaws.core.numba_compat import INLINED, callback, kernel, loop
from demlaws.core.shear import shear_stiffness
from demlaws.core.unloading import rule_of, rule_of_smooth_contact
from demlaws.laws.hertz import HertzParams, HertzShape
from demlaws.units import LARGEST_OVERLAP, SMALL_OVERLAP
from demlaws.yade import layout as at
from demlaws.yade.memory import (
    add_double,
    add_word,
    call_gap_radius,
    call_go,
    load_byte,
    load_double,
    load_int,
    load_params,
    load_tuple,
    load_word,
    store_double,
    store_params,
    store_tuple,
    store_word,
)
from demlaws.yade.shear import Slip, before, body_of_number, compress, go, word

LOWEST_MODULUS = RANGES["modulus"].low
SHAPE_BYTES = at.SHAPE_RECORD.itemsize
SHAPE_AT, KIND_AT = at.OF_SHAPE["shape"], at.OF_SHAPE["kind"]


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
    """Force [N], tangent stiffness, the stiffness used to compute K_t [N/m], and new state."""
    force, stiffness, new = step(rule, p, overlap, state)
    return force, stiffness, shear_stiffness(shear, rule, p, overlap, force, stiffness, new), new


@kernel
def respond(kind, shear, rule, record, radius, modulus, overlap, state):
    """`answer` of a contact whose surfaces are the pair in `record`."""
    if modulus == 0.0:  # a marker: YADE's own law gives it no force
        return 0.0, 0.0, 0.0, state
    if load_word(record) != 0:
        return answer(shear, rule_of_smooth_contact(rule), scale(HertzShape(), radius, modulus, 0.0), overlap, state)
    return answer(shear, rule, params_of(kind, record, radius, modulus), overlap, state)


@kernel
def energies(kind, rule, record, radius, modulus, overlap, state):
    """Stored and dissipated energy [J] of a contact since it was made."""
    if modulus == 0.0:
        return 0.0, 0.0
    if load_word(record) != 0:
        return stored_and_dissipated(rule_of_smooth_contact(rule), scale(HertzShape(), radius, modulus, 0.0), overlap, state)
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
def effective_radius(radius1, radius2):
    """R as Ip2_FrictMat_FrictMat_MindlinPhys has it from ScGeom's two radii."""
    first = radius1 if radius1 > 0.0 else radius2
    return first * radius2 / (first + radius2)


@kernel
def body_of(context, interaction, body):
    """Address of one of the two bodies of a contact."""
    return body_of_number(context, load_int(interaction + word(context, body)), 0)


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
def deep(context, row, overlap):
    """TOO_DEEP for an overlap beyond LARGEST_OVERLAP of R, else 0. The guard reports the first one beyond SMALL_OVERLAP."""
    if load_double(row + at.MODULUS) == 0.0:
        return 0  # a marker
    if overlap > LARGEST_OVERLAP * load_double(row + at.RADIUS):
        store_double(context + 8 * at.DEEP_RADIUS, load_double(row + at.RADIUS))
        return at.TOO_DEEP
    if word(context, at.DEEP) == 0:
        store_word(context + 8 * at.DEEP, 1)
        alarm(context)
    return 0


@numba.njit(error_model="numpy", nogil=True)
def shared(context, interaction):
    """Note a contact that has the physics of another one: both get the force."""
    store_word(context + 8 * at.SHARED_BODY1, np.int64(load_int(interaction + word(context, at.BODY1))))
    store_word(context + 8 * at.SHARED_BODY2, np.int64(load_int(interaction + word(context, at.BODY2))))
    store_word(context + 8 * at.SHARED, 1)
    alarm(context)


@numba.njit(error_model="numpy", nogil=True)
def serves(record, radius, modulus):
    """Whether the pair's law may be used at this R and E*: a table of a law that does not collapse is for one contact."""
    only_radius, only_modulus = load_double(record + at.RECORD_RADIUS), load_double(record + at.RECORD_MODULUS)
    return only_radius == 0.0 or (
        abs(radius - only_radius) <= 1e-6 * only_radius and abs(modulus - only_modulus) <= 1e-6 * only_modulus
    )


@kernel
def is_odd(context, body):
    """Whether a body's shape is neither a flat nor one with a radius of its own."""
    shape, number = load_word(load_word(body + word(context, at.SHAPE))), at.ROUND_SHAPES
    while word(context, number) != 0 and word(context, number) != shape:
        number += 1
    return word(context, number) == 0 and not is_flat(context, body)


@kernel
def shape_record(context, interaction, which, body):
    """Address of the `layout.SHAPE_RECORD` of a body; 0 where the table is not up to date."""
    number = np.int64(load_int(interaction + word(context, which)))
    if number >= word(context, at.SHAPE_COUNT):
        return 0
    record = word(context, at.SHAPES) + number * SHAPE_BYTES
    return record if load_word(record + SHAPE_AT) == load_word(body + word(context, at.SHAPE)) else 0


@numba.njit(error_model="numpy", nogil=True)
def curvature_radius(context, geom, interaction, body1, body2, radius):
    """R from the curvature of two bodies, or `radius`, which is YADE's, where this is not known yet; faults are noted."""
    first = shape_record(context, interaction, at.BODY1, body1)
    second = shape_record(context, interaction, at.BODY2, body2)
    if first == 0 or second == 0:
        store_word(context + 8 * at.SHAPES_STALE, 1)
        alarm(context)  # the guard reads the new shapes before the next step
        return radius
    result = math.nan
    if load_word(first + KIND_AT) != 0 and load_word(second + KIND_AT) != 0:
        state1 = load_word(body1 + word(context, at.BODY_STATE))
        state2 = load_word(body2 + word(context, at.BODY_STATE))
        position, orientation = word(context, at.POSITION), word(context, at.ORIENTATION)
        point, normal = geom + word(context, at.POINT), geom + word(context, at.NORMAL)
        result = call_gap_radius(
            word(context, at.GAP_RADIUS),
            first,
            state1 + position,
            state1 + orientation,
            second,
            state2 + position,
            state2 + orientation,
            point,
            normal,
            radius,
            from_bits(word(context, at.LARGEST_RADIUS)),
        )
    if not result > 0.0:
        fault(context, at.FLAT_GAP if result < 0.0 else at.NO_CURVATURE, interaction, radius)
        return radius
    return result


@numba.njit(error_model="numpy", nogil=True)
def chosen_radius(context, geom, interaction, body1, body2, first, second, radius):
    """R of a new contact by the user's choice; `radius`: as spheres and flats have it."""
    mode = word(context, at.RADIUS_MODE)
    if mode == at.FUNCTION_RADIUS:
        store_word(context + 8 * at.NEW_CONTACTS, 1)
        alarm(context)
        return radius
    odd1, odd2 = is_odd(context, body1), is_odd(context, body2)
    if not (odd1 or odd2) or mode == at.BODY_RADIUS_MEANT:
        return radius
    if mode == at.CURVATURE_RADIUS:
        return curvature_radius(context, geom, interaction, body1, body2, radius)
    edge1 = load_double(word(context, at.EDGES) + 8 * first) if odd1 else 0.0
    edge2 = load_double(word(context, at.EDGES) + 8 * second) if odd2 else 0.0
    unknown = (odd1 and edge1 == 0.0) or (odd2 and edge2 == 0.0)
    if unknown and word(context, at.ODD_SEEN) == 0:
        store_word(context + 8 * at.ODD_SEEN, 1)
        store_word(context + 8 * at.ODD_BODY1, np.int64(load_int(interaction + word(context, at.BODY1))))
        store_word(context + 8 * at.ODD_BODY2, np.int64(load_int(interaction + word(context, at.BODY2))))
        alarm(context)
    radius1, radius2 = load_double(geom + word(context, at.RADIUS1)), load_double(geom + word(context, at.RADIUS2))
    return edged_radius(radius, radius1, radius2, edge1, edge2, is_flat(context, body1) or is_flat(context, body2))


@kernel
def edged_radius(radius, radius1, radius2, edge1, edge2, flat):
    """R with the edge radii (0: none) of two bodies; radius1, radius2: YADE's of them.

    An edge or a corner of r meets a face (R = r) or crosses another edge (two crossed cylinders of r: R = r). Of two edges the
    sharper one counts; beside a sphere 1/R = 1/r + 1/r_sphere. [our derivation]
    """
    if edge1 == 0.0 and edge2 == 0.0:
        return radius
    if edge1 > 0.0 and edge2 > 0.0:
        return min(edge1, edge2)
    edge = edge1 + edge2
    other = radius2 if edge1 > 0.0 else radius1
    return edge if flat or not other > 0.0 else edge * other / (edge + other)


@loop
def follow(kind, context, geom, interaction, row):
    """Renew R and the row of a contact whose bodies' curvature changes as it moves."""
    body1, body2 = body_of(context, interaction, at.BODY1), body_of(context, interaction, at.BODY2)
    modulus = load_double(row + at.MODULUS)
    if modulus == 0.0 or not (is_odd(context, body1) or is_odd(context, body2)):
        return
    old = load_double(row + at.RADIUS)
    radius = curvature_radius(context, geom, interaction, body1, body2, old)
    if abs(radius - old) <= 1e-12 * old:
        return
    record = load_word(row + at.ROW_RECORD)
    if not serves(record, radius, modulus):
        fault(context, at.WRONG_CONTACT, interaction, radius)
    elif load_double(record + at.RECORD_ROUGHNESS) > LARGEST_ROUGHNESS * radius:
        fault(context, at.TOO_ROUGH, interaction, radius)
    store_double(row + at.RADIUS, radius)
    if load_word(record) != 0:
        store_double(row + at.ROW_OWN, hertz_coefficient(radius, modulus))
    else:
        store_params(kind, params_of(kind, record, radius, modulus), row + at.ROW_OWN)


@kernel
def contact_radius(context, geom, body1, body2):
    """R [m] of a new contact as YADE's spheres and flats have it; see `chosen_radius` for other shapes."""
    radius2 = load_double(geom + word(context, at.RADIUS2))
    if word(context, at.FLATS) != 0 and (is_flat(context, body1) or is_flat(context, body2)):
        return radius2  # YADE's own radius of a contact with a flat is half or two thirds of it
    return effective_radius(load_double(geom + word(context, at.RADIUS1)), radius2)


@numba.njit(error_model="numpy", nogil=True)
def initialise_contact(context, row, geom, phys, interaction):
    """Write R, E*, K_t/K and the pair to the history of a new contact."""
    native = load_double(phys + word(context, at.KNO))
    in_yade = effective_radius(load_double(geom + word(context, at.RADIUS1)), load_double(geom + word(context, at.RADIUS2)))
    modulus = 0.75 * native / math.sqrt(in_yade)
    body1, body2 = body_of(context, interaction, at.BODY1), body_of(context, interaction, at.BODY2)
    radius = contact_radius(context, geom, body1, body2)
    first, second = surface_of(context, body1), surface_of(context, body2)
    if (first == 0 or second == 0) and word(context, at.UNLISTED) == 0 and word(context, at.UNLISTED_SEEN) == 0:
        store_word(context + 8 * at.UNLISTED_BODY1, np.int64(load_int(interaction + word(context, at.BODY1))))
        store_word(context + 8 * at.UNLISTED_BODY2, np.int64(load_int(interaction + word(context, at.BODY2))))
        store_word(context + 8 * at.UNLISTED_SEEN, 1)
        alarm(context)
    radius = chosen_radius(context, geom, interaction, body1, body2, first, second, radius)
    pair = load_word(word(context, at.PAIRS) + 8 * (first * word(context, at.SURFACES) + second))
    record = word(context, at.RECORDS) + pair * word(context, at.RECORD_BYTES)
    store_double(row + at.RADIUS, radius)
    store_double(row + at.MODULUS, modulus)
    ratio = 0.0
    add_word(context + 8 * at.OPEN, 1)
    if native == 0.0:
        pass  # a marker
    elif not LOWEST_MODULUS < modulus < math.inf:
        fault(context, at.WRONG_MODULUS, interaction, modulus)
        store_double(row + at.MODULUS, 0.0)  # a marker until the guard stops the run: no force
    elif not serves(record, radius, modulus):
        fault(context, at.WRONG_CONTACT, interaction, radius)
    elif load_double(record + at.RECORD_ROUGHNESS) > LARGEST_ROUGHNESS * radius:
        fault(context, at.TOO_ROUGH, interaction, radius)
    else:
        ratio = load_double(phys + word(context, at.KSO)) / (1.5 * native)
    store_double(row + at.RATIO_OF_ROW, ratio)
    store_double(row + at.TAG, pair + 1.0)


@kernel
def known_row(context, code, phys):
    """Address of the row that `code` names; 0 for a row of another contact or process."""
    if code >> 28 != word(context, at.GENERATION):
        return 0
    row = word(context, at.ROWS) + 8 * (code & 0xFFFFFFF) * word(context, at.ROW_WORDS)
    return row if load_word(row + at.ROW_PHYSICS) == phys else 0


@kernel
def free_row(context):
    """Number of a row that no contact has; -1: there is none."""
    if word(context, at.FREE_TAKEN) < word(context, at.FREE_COUNT):
        place = add_word(context + 8 * at.FREE_TAKEN, 1)
        if place < word(context, at.FREE_COUNT):
            return load_word(word(context, at.FREE) + 8 * place)
    number = add_word(context + 8 * at.ROWS_USED, 1)
    return number if number < word(context, at.CAPACITY) else -1


@loop
def fill_row(kind, context, row, number, phys, interaction):
    """Write what a row holds beside the history, and the row's number, negative for a smooth pair, to the contact."""
    record = word(context, at.RECORDS) + (np.int64(load_double(row + at.TAG)) - 1) * word(context, at.RECORD_BYTES)
    radius, modulus = load_double(row + at.RADIUS), load_double(row + at.MODULUS)
    store_word(row + at.ROW_PHYSICS, phys)
    store_word(row + at.ROW_INTERACTION, interaction)
    store_word(row + at.ROW_RECORD, record)
    code = (word(context, at.GENERATION) << 28) + number
    if load_word(record) != 0 or modulus == 0.0:
        code = -code
        store_double(row + at.ROW_OWN, hertz_coefficient(radius, modulus))
    else:
        store_params(kind, params_of(kind, record, radius, modulus), row + at.ROW_OWN)
    store_double(phys + word(context, at.MARK), float(code))
    return code


@loop
def make_row(kind, context, geom, phys, interaction):
    """The code of a new contact's row; 0: there is no room, or the contact's row is lost."""
    if load_double(phys + word(context, at.MARK)) != 0.0:
        fault(context, at.LOST_ROW, interaction, 0.0)
        return 0
    number = free_row(context)
    if number < 0:
        fault(context, at.NO_ROW, interaction, 0.0)
        return 0
    row = word(context, at.ROWS) + 8 * number * word(context, at.ROW_WORDS)
    for n in range(word(context, at.ROW_WORDS)):
        store_word(row + 8 * n, 0)
    initialise_contact(context, row, geom, phys, interaction)
    return fill_row(kind, context, row, number, phys, interaction)


@loop
def end_contact(kind, rule, context, row, state):
    """Bank the dissipation of a contact that ends, with the energy of shear that it stored."""
    radius, modulus, record = load_double(row + at.RADIUS), load_double(row + at.MODULUS), load_word(row + at.ROW_RECORD)
    add_double(context + 8 * at.BANKED, energies(kind, rule, record, radius, modulus, 0.0, state)[1])
    add_double(context + 8 * at.BANKED_SHEAR, load_double(row + at.SHEAR_LOST))
    store_double(row + at.SHEAR_LOST, 0.0)


@kernel
def knows(context, geometry, physics):
    """Whether objects that begin with these words are of classes that the law acts on."""
    if physics != word(context, at.PHYSICS) and physics != word(context, at.PHYSICS_CAPILLARY):
        return False
    if geometry == word(context, at.GEOMETRY) or geometry == word(context, at.GEOMETRY_6D):
        return True
    number = at.GEOMETRIES
    while word(context, number) != 0 and word(context, number) != geometry:
        number += 1
    return word(context, number) != 0


@kernel
def act(kind, params_kind, shear, mode, rule, context, this, geom_pointer, phys_pointer, interaction):
    """The body of `go`: our force and stiffness as coefficients of Mindlin's law, which does the rest (`shear.advance`)."""
    geom, phys = load_word(geom_pointer), load_word(phys_pointer)
    if not knows(context, load_word(geom), load_word(phys)):
        fault(context, at.WRONG_CLASS, interaction, 0.0)
        return call_go(word(context, at.GO), this, geom_pointer, phys_pointer, interaction)
    overlap = load_double(geom + word(context, at.OVERLAP))
    overlap = -1.0 if overlap == -math.inf else overlap  # newer YADE: level sets that do not overlap
    code = np.int64(load_double(phys + word(context, at.MARK)))
    row = known_row(context, abs(code), phys)
    if row == 0:
        code = make_row(kind, context, geom, phys, interaction)
        row = known_row(context, abs(code), phys)
    if row == 0:
        store_double(phys + word(context, at.KNO), 0.0 if word(context, at.ALARM) != 0 else math.nan)
        store_double(phys + word(context, at.KSO), 0.0)
        return call_go(word(context, at.GO), this, geom_pointer, phys_pointer, interaction)
    if load_word(row + at.ROW_INTERACTION) != interaction and word(context, at.SHARED) == 0:
        shared(context, interaction)
    if overlap > 0.0 and word(context, at.RADIUS_MODE) == at.CURVATURE_RADIUS:
        follow(kind, context, geom, interaction, row)
    old = load_state(rule, row + at.STATE)
    if code > 0:
        p = load_params(params_kind, kind, row + at.ROW_OWN, load_word(row + at.ROW_RECORD) + at.RECORD_SHAPE)
        force, stiffness, sideways, new = answer(shear, rule, p, overlap, old)
        compress(mode, rule, p, context, row, overlap, force, sideways, new)
    elif load_double(row + at.ROW_OWN) != 0.0:
        p = HertzParams(load_double(row + at.ROW_OWN))
        force, stiffness, sideways, new = answer(shear, rule_of_smooth_contact(rule), p, overlap, old)
        compress(mode, rule_of_smooth_contact(rule), p, context, row, overlap, force, sideways, new)
    else:
        force, stiffness, sideways, new = 0.0, 0.0, 0.0, old
    wrong = at.NOT_FINITE if force - force != 0.0 else at.UNGUARDED if word(context, at.ALARM) == 0 else 0
    if overlap > SMALL_OVERLAP * load_double(row + at.RADIUS):
        wrong = max(wrong, deep(context, row, overlap))
    if wrong != 0:
        fault(context, wrong, interaction, overlap)
        force, stiffness, sideways, new = math.nan, 0.0, 0.0, old
        if word(context, at.ALARM) != 0:  # without a guard, which would stop the run, propagate NaN
            force = 0.0
    across = 0.0
    if overlap > 0.0:
        kno, kso = coefficients(force, sideways, overlap, load_double(row + at.RATIO_OF_ROW))
        across = kso * math.sqrt(overlap)
        before(mode, context, phys, row, across)
        store_double(phys + word(context, at.KNO), kno)
        store_double(phys + word(context, at.KSO), kso)
    else:
        before(mode, context, phys, row, 0.0)
        if overlap - overlap != 0.0:
            fault(context, at.NOT_FINITE, interaction, overlap)  # NaN: a body's position is not finite
    store_tuple(new, row + at.STATE)
    keep = go(mode, context, this, geom_pointer, phys_pointer, interaction, row, across)
    store_double(row + at.LAST, overlap)
    if overlap > 0.0:
        # Mindlin left 1.5 P/δ here; the time stepper needs the tangent
        store_double(phys + word(context, at.KN), stiffness)
    else:
        end_contact(kind, rule, context, row, old)
    if keep == 0:
        add_word(context + 8 * at.OPEN, -1)
        store_double(row + at.TAG, 0.0)
        store_word(row + at.ROW_PHYSICS, 0)
        store_double(phys + word(context, at.MARK), 0.0)  # at a joint of a chain, another contact has the same phys
    return keep


KIND = PARAMS_KIND = SHEAR = MODE = RULE = BEHIND = None  # what `entry` gives to a copy of the function below


def _go(this, geom, phys, interaction):
    context = load_word(load_word(this) + BEHIND)
    return act(KIND, PARAMS_KIND, SHEAR, MODE, RULE, context, this, geom, phys, interaction)


def entry(kind, params_kind, shear, mode, rule, behind):
    """`act` for laws of this kind as native code (`.address`); the address of the context stands `behind` bytes after the
    functor's table of virtual functions."""
    code = None
    if isinstance(mode, Slip):
        from demlaws.yade import slip

        code = source_digest(slip.__file__)  # loaded too late for the cache to know that this code uses it
    constants = {
        "CODE": code,
        "KIND": kind,
        "PARAMS_KIND": params_kind,
        "SHEAR": shear,
        "MODE": mode,
        "RULE": rule,
        "BEHIND": behind,
    }
    return callback(types.uint8(*[types.int64] * 4), _go, constants | {"CODE": code})


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
        out[i].force = force
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
