"""The contact step: compiled code that runs inside YADE at each contact, no Python, no YADE.

`law_of_contact` is the law: a contact, its pair of surfaces, overlap and history in; force, tangent and new history out.
`go` is that law at work inside a native functor (see `native`): Mindlin's law with our force and stiffness (`mindlin`).
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numba import types

from demlaws.core.dispatch import first_loading, scale, step, stored_and_dissipated
from demlaws.core.fastmath import hertz_coefficient
from demlaws.core.loops import clamped_roughness
from demlaws.core.numba_compat import callback, kernel, loop
from demlaws.core.shear import mean_pressure, shear_stiffness
from demlaws.core.unloading import rule_of_smooth_contact
from demlaws.core.vectors import assign, vector
from demlaws.laws.hertz import HertzParams, HertzShape
from demlaws.units import LARGEST_OVERLAP, LARGEST_ROUGHNESS, RANGES, SMALL_OVERLAP
from demlaws.yade import layout, objects
from demlaws.yade.friction import apply as apply_friction, keep_radius
from demlaws.yade.layout import CONTEXT, SHAPE
from demlaws.yade.mindlin import Contact, body_of, native_go
from demlaws.yade.records import (
    add_float,
    add_integer,
    array,
    c_function,
    exchange_if,
    not_inlined,
    pointee,
    read_tuple,
    record_fault,
    request_guard,
    type_of,
    view,
    words_of,
    write_tuple,
)
from demlaws.yade.shear import Slip, apply_mindlin, compress, synchronise

LOWEST_MODULUS = RANGES["modulus"].low
call_gap_radius = c_function(types.float64, *[types.int64] * 8, *[types.float64] * 2)
"""`curvature.gap_radius`."""
call_map_memory = c_function(types.int64, types.int64, types.int64, *[types.int32] * 3, types.int64)
"""void* mmap(void* address, size_t size, int protection, int flags, int file, off_t offset)."""


# --- the law


class Law(NamedTuple):
    """The kind of law that code is compiled for: the numba types of Shape, Params and state, and what acts, as tags."""

    shape: types.Type
    params: types.Type
    state: types.Type
    rule: tuple  # of unloading
    shear: tuple  # how K_t is found
    mode: Any  # how the shear force follows K_t
    friction: Any


@loop
def write_shape(kind, shape, words):
    """Write a Shape to an array of 64-bit words, if it has room; returns how many words it takes."""
    size = words_of(kind)
    if size <= words.size:
        write_tuple(words.ctypes.data, kind, shape)
    return size


@kernel
def fill_params(law, row, pair):
    """Make the Params of a contact, once, from its R and E* and its pair's Shape; returns whether it is smooth, or a marker."""
    if pair.smooth != 0 or row.modulus == 0.0:
        row.hertz = hertz_coefficient(row.radius, row.modulus)
        return True
    params = scale(shape_of(law, pair), row.radius, row.modulus, clamped_roughness(pair.roughness, row.radius))
    write_tuple(row.params.ctypes.data, law.params, params)
    return False


@kernel
def shape_of(law, pair):
    """The law's Shape of a pair of surfaces."""
    return read_tuple(pair.shape.ctypes.data, law.shape)


@kernel
def params_of(law, contact):
    """The law's Params, which `fill_params` has made, of a contact that is not smooth."""
    return read_tuple(contact.params.ctypes.data, law.params)


@kernel
def state_of(law, contact):
    """State of the unloading rule in the history of a contact."""
    return read_tuple(contact.state.ctypes.data, law.state)


@kernel
def response(law, rule, shape, p, overlap, state):
    """Force [N], tangent stiffness, the stiffness used to compute K_t [N/m], and new state."""
    force, stiffness, new = step(rule, shape, p, overlap, state)
    return force, stiffness, shear_stiffness(law.shear, rule, shape, p, overlap, force, stiffness, new), new


@kernel
def energies(law, pair, contact, overlap, state):
    """Stored and dissipated energy [J] of a contact since it was made."""
    if contact.modulus == 0.0:
        return 0.0, 0.0
    if pair.smooth != 0:
        smooth = rule_of_smooth_contact(law.rule)
        return stored_and_dissipated(smooth, HertzShape(), HertzParams(contact.hertz), overlap, state)
    return stored_and_dissipated(law.rule, shape_of(law, pair), params_of(law, contact), overlap, state)


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
def is_flat(context, body):
    """Whether a body's shape is a facet, a wall or a box."""
    shape = type_of(pointee(body.shape))
    return shape == context.facet or shape == context.wall or shape == context.box


@kernel
def is_among(kind, classes, count):
    """Whether a type is that of one of the classes."""
    for n in range(count):  # noqa: SIM110  compiled code has no generators
        if classes[n] == kind:
            return True
    return False


@kernel
def has_no_radius(context, body):
    """Whether a body's shape is neither a flat nor one with a radius of its own."""
    return not is_among(type_of(pointee(body.shape)), context.round_shape_classes, context.round_shape_count) and not is_flat(
        context, body
    )


@not_inlined
def surface_of(context, body):
    """Number of the surface whose label the body's material bears; 0 where no surface has that label."""
    material = view(body.material, objects.Material)
    label = array(material.label, material.label_length, np.uint8)
    labels = array(context.labels, (context.surfaces, context.label_size), np.uint8)
    for number in range(1, context.surfaces):
        same = label.size <= labels.shape[1]
        for n in range(labels.shape[1]):
            same &= labels[number, n] == (label[n] if n < label.size else 0)
        if same:
            return number
    return 0


# --- R of a contact


@not_inlined
def serves(pair, radius, modulus):
    """Whether the pair's law may be used at this R and E*: a table of a law that does not collapse is for one contact."""
    return pair.radius == 0.0 or (
        abs(radius - pair.radius) <= 1e-6 * pair.radius and abs(modulus - pair.modulus) <= 1e-6 * pair.modulus
    )


@not_inlined
def judged(pair, radius, modulus):
    """Whether the guard has judged the pair's law for this R and E*."""
    radii, moduli = pair.judged_radii, pair.judged_moduli
    return radii[0] <= radius <= radii[1] and moduli[0] <= modulus <= moduli[1]


@not_inlined
def curvature_radius(context, geom, interaction, body1, body2, radius):
    """R from the curvature of two bodies, or `radius`, which is YADE's, where this is not known yet; faults are noted."""
    shapes = array(context.shapes, context.shape_count, SHAPE)
    last = max(interaction.id1, interaction.id2)
    if last >= shapes.size or shapes[interaction.id1].shape != body1.shape or shapes[interaction.id2].shape != body2.shape:
        context.shapes_stale = 1
        request_guard(context)  # the guard reads the new shapes before the next step
        return radius
    first, second = shapes[interaction.id1], shapes[interaction.id2]
    result = math.nan
    if first.kind != 0 and second.kind != 0:
        state1, state2 = view(body1.state, objects.State), view(body2.state, objects.State)
        places1 = context.shapes + interaction.id1 * shapes.itemsize, state1.pos.ctypes.data, state1.ori.ctypes.data
        places2 = context.shapes + interaction.id2 * shapes.itemsize, state2.pos.ctypes.data, state2.ori.ctypes.data
        where = geom.contactPoint.ctypes.data, geom.normal.ctypes.data
        arguments = (*places1, *places2, *where, radius, context.largest_radius)
        result = call_gap_radius(context.gap_radius, arguments)
    if not result > 0.0:
        record_fault(context, layout.FLAT_GAP if result < 0.0 else layout.NO_CURVATURE, interaction, radius)
        return radius
    return result


@not_inlined
def chosen_radius(context, geom, interaction, body1, body2, first, second, radius):
    """R of a new contact by the user's choice; `radius`: as spheres and flats have it."""
    unknown1, unknown2 = has_no_radius(context, body1), has_no_radius(context, body2)
    if not (unknown1 or unknown2) or context.radius_mode == layout.BODY_RADIUS_MEANT:
        return radius
    if context.radius_mode == layout.CURVATURE_RADIUS:
        return curvature_radius(context, geom, interaction, body1, body2, radius)
    edges = array(context.edges, context.surfaces, np.float64)
    edge1 = edges[first] if unknown1 else 0.0
    edge2 = edges[second] if unknown2 else 0.0
    if (unknown1 and edge1 == 0.0) or (unknown2 and edge2 == 0.0):
        record_fault(context, layout.UNKNOWN_SHAPE, interaction, radius)
    flat = is_flat(context, body1) or is_flat(context, body2)
    return edged_radius(radius, geom.refR1, geom.refR2, edge1, edge2, flat)


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


@not_inlined
def follow_radii(law, context, geom, interaction, row, pair):
    """Renew R and the row of a contact whose bodies have grown or shrunk; E* remains. The law may not serve it: a fault."""
    row.reach = geom.refR1 + geom.refR2
    body1, body2 = body_of(context, interaction.id1, 0), body_of(context, interaction.id2, 0)
    if row.modulus == 0.0 or has_no_radius(context, body1) or has_no_radius(context, body2):
        return
    radius = contact_radius(context, geom, body1, body2)
    if not radius > 0.0:  # the guard names the body
        return
    if not serves(pair, radius, row.modulus):
        record_fault(context, layout.WRONG_CONTACT, interaction, radius)
    elif pair.roughness > LARGEST_ROUGHNESS * radius:
        record_fault(context, layout.TOO_ROUGH, interaction, radius)
    elif not judged(pair, radius, row.modulus):
        record_fault(context, layout.UNJUDGED, interaction, radius)
    row.radius = radius
    fill_params(law, row, pair)


@kernel
def contact_radius(context, geom, body1, body2):
    """R [m] of a new contact as YADE's spheres and flats have it; see `chosen_radius` for other shapes."""
    if context.plane_flats != 0 and (is_flat(context, body1) or is_flat(context, body2)):
        return geom.refR2  # YADE's own radius of a contact with a flat is half or two thirds of it
    return effective_radius(geom.refR1, geom.refR2)


# --- rows


@loop
def fill_loop(law, pairs, contacts):
    """`fill_params` of an array of contacts, whose `tag` is the number of their pair + 1."""
    for i in range(contacts.size):
        fill_params(law, contacts[i], pairs[np.int64(contacts[i].tag) - 1])


@not_inlined
def initialise_contact(context, pairs, row, geom, phys, interaction):
    """Write R, E*, K_t/K and the pair to the history of a new contact; returns the number of the pair."""
    modulus = 0.75 * phys.kno / math.sqrt(effective_radius(geom.refR1, geom.refR2))
    body1, body2 = body_of(context, interaction.id1, 0), body_of(context, interaction.id2, 0)
    radius = contact_radius(context, geom, body1, body2)
    first, second = surface_of(context, body1), surface_of(context, body2)
    if (first == 0 or second == 0) and context.may_be_unlisted == 0:
        record_fault(context, layout.UNLISTED, interaction, radius)
    radius = chosen_radius(context, geom, interaction, body1, body2, first, second, radius)
    number = array(context.pair_numbers, (context.surfaces, context.surfaces), np.int64)[first, second]
    pair = pairs[number]
    row.radius, row.modulus, row.ratio, row.tag = radius, modulus, 0.0, number + 1.0
    round_bodies = not (has_no_radius(context, body1) or has_no_radius(context, body2))
    row.lever = layout.FLAT if is_flat(context, body1) else layout.ROUND if round_bodies else layout.NO_LEVER
    row.written = phys.kno + phys.kso
    row.reach = geom.refR1 + geom.refR2
    add_integer(context.open.ctypes.data, 1)
    if phys.kno == 0.0:
        return number  # a marker
    if not LOWEST_MODULUS < modulus < math.inf:
        record_fault(context, layout.WRONG_MODULUS, interaction, modulus)
        row.modulus = 0.0  # a marker until the guard stops the run: no force
    elif not serves(pair, radius, modulus):
        record_fault(context, layout.WRONG_CONTACT, interaction, radius)
    elif pair.roughness > LARGEST_ROUGHNESS * radius:
        record_fault(context, layout.TOO_ROUGH, interaction, radius)
    else:
        if not judged(pair, radius, modulus):
            record_fault(context, layout.UNJUDGED, interaction, radius)
        row.ratio = context.shear_ratio if context.shear_ratio > 0.0 else phys.kso / (1.5 * phys.kno)
    return number


@kernel
def free_row(context):
    """Number of a row that no contact has. The guard looks for rows to use again before new ones are taken."""
    if context.free_taken[0] < context.free_count:
        place = add_integer(context.free_taken.ctypes.data, 1)
        if place == context.collect_at:
            request_guard(context)
        if place < context.free_count:
            return array(context.free, context.free_count, np.int64)[place]
    number = add_integer(context.rows_used.ctypes.data, 1)
    if number >= context.collect_at and context.free_count == 0:
        request_guard(context)
    return number


@not_inlined
def take_row(context, row_dtype):
    """Address of a row that no contact has, of zeros; 0: there is no memory for it."""
    number, size = free_row(context), array(context.blocks, 1, row_dtype).itemsize
    block_number = number >> layout.ROWS_BITS
    if block_number >= layout.BLOCKS:
        return 0
    block = array(context.blocks, layout.BLOCKS, np.int64)[block_number]
    if block == 0:
        how = layout.READ_AND_WRITE, layout.OF_ITS_OWN, -1, 0
        made = call_map_memory(context.map_memory, (0, layout.ROWS * size, *how))
        if made == -1:
            return 0
        other = exchange_if(context.blocks + block_number * 8, 0, made)  # of another thread; a second one remains unused
        block = made if other == 0 else other
    place = block + (number & (layout.ROWS - 1)) * size
    array(place, size // 8, np.int64)[:] = 0
    return place


@not_inlined
def make_row(law, context, pairs, row_dtype, geom, phys, interaction, phys_address, interaction_address):
    """Address of a new contact's row, negative for a smooth pair; 0: there is no memory for it, or its row is lost."""
    if phys.prevU[1] != 0.0:
        record_fault(context, layout.LOST_ROW, interaction, 0.0)
        return 0
    place = take_row(context, row_dtype)
    if place == 0:
        record_fault(context, layout.NO_ROW, interaction, 0.0)
        return 0
    if context.by_pressure == 0 and type_of(phys.vtable) == context.conical:
        c1 = view(phys_address, objects.MindlinPhysCDM).c1
        if c1 != 0.0:
            record_fault(context, layout.FRICTION, interaction, c1)
    row = view(place, row_dtype)
    pair = initialise_contact(context, pairs, row, geom, phys, interaction)
    row.phys, row.interaction, row.pair = phys_address, interaction_address, context.pairs + pair * pairs.itemsize
    row_address = -place if fill_params(law, row, pairs[pair]) else place
    phys.prevU[1], phys.prevU[2] = float(row_address), context.generation
    return row_address


@loop
def new_row(contexts, row_dtype):
    """`take_row` for Python."""
    return take_row(contexts[0], row_dtype)


@loop
def gather_rows(addresses, words):
    """Copy the rows at addresses, 0 for none, into an array of their 64-bit words."""
    for n in range(addresses.size):
        if addresses[n] != 0:
            words[n] = array(addresses[n], words.shape[1], np.int64)


@not_inlined
def end_contact(law, context, pair, row, state):
    """Bank the dissipation of a contact that ends, with the energy of shear that it stored."""
    dissipated = energies(law, pair, row, 0.0, state)[1]
    add_float(context.banked.ctypes.data, dissipated)
    add_float(context.banked_shear.ctypes.data, row.lost)
    add_float(context.banked_viscous.ctypes.data, row.viscous)
    row.lost = row.viscous = 0.0


# --- the step


@not_inlined
def without_row(context, pointers, phys):
    """The step of a contact that has no row: no force, or NaN without a guard, which would stop the run."""
    phys.kno = 0.0 if context.guard_counter != 0 else math.nan
    phys.kso = 0.0
    return native_go(context, pointers)


@not_inlined
def unknown_class(context, pointers, interaction):
    """The step of a contact of other classes: the native law's, and a fault."""
    record_fault(context, layout.WRONG_CLASS, interaction, 0.0)
    return native_go(context, pointers)


@kernel
def law_of_contact(law, context, phys, phys_address, rough, pair, row, overlap, old):
    """`response` of a contact by what its row has, with springs and friction set; rough: whether it has Params of the law.

    A marker, whose E* is 0, has no force: YADE's own law gives it none.
    """
    if rough:
        shape, p = shape_of(law, pair), params_of(law, row)
        force, stiffness, sideways, new = response(law, law.rule, shape, p, overlap, old)
        compress(law.mode, law.rule, shape, p, row, overlap, force, sideways, new)
        of_step = law.rule, shape, p, overlap, force, stiffness, new
        apply_friction(law.friction, context, phys, phys_address, pair, row, *of_step)
        return force, stiffness, sideways, new
    if row.hertz != 0.0:
        shape, p, smooth = HertzShape(), HertzParams(row.hertz), rule_of_smooth_contact(law.rule)
        force, stiffness, sideways, new = response(law, smooth, shape, p, overlap, old)
        compress(law.mode, smooth, shape, p, row, overlap, force, sideways, new)
        of_step = smooth, shape, p, overlap, force, stiffness, new
        apply_friction(law.friction, context, phys, phys_address, pair, row, *of_step)
        return force, stiffness, sideways, new
    return 0.0, 0.0, 0.0, old


@not_inlined
def is_too_deep(context, interaction, row, overlap):
    """Whether an overlap is beyond LARGEST_OVERLAP of R; the guard warns of the first one beyond SMALL_OVERLAP."""
    if row.modulus == 0.0:
        return False  # a marker
    record_fault(context, layout.DEEP, interaction, overlap)
    return overlap > LARGEST_OVERLAP * row.radius and row.hertz == 0.0  # a smooth contact has Hertz's force, as in YADE's law


@kernel
def is_faulty(context, interaction, row, overlap, force):
    """Whether a contact has no force that can be applied, of which a note is made."""
    if overlap > SMALL_OVERLAP * row.radius and is_too_deep(context, interaction, row, overlap):
        record_fault(context, layout.TOO_DEEP, interaction, overlap)
    elif context.guard_counter == 0:
        record_fault(context, layout.UNGUARDED, interaction, overlap)
    elif force - force != 0.0:
        record_fault(context, layout.NOT_FINITE, interaction, overlap)
    else:
        return False
    return True


@kernel
def go(law, pair_dtype, row_dtype, context, pointers):
    """The body of `go`: our force and stiffness as coefficients kno and kso of Mindlin's law, which then acts."""
    functor_address, geom_pointer, phys_pointer, interaction_address = pointers
    phys_address = pointee(phys_pointer)
    geom, phys = view(pointee(geom_pointer), objects.ScGeom), view(phys_address, objects.MindlinPhys)
    interaction = view(interaction_address, objects.Interaction)
    physics = type_of(phys.vtable)
    known = physics == context.physics or physics == context.capillary or physics == context.conical
    if not (known and is_among(type_of(geom.vtable), context.geometry_classes, context.geometry_count)):
        return unknown_class(context, pointers, interaction)
    overlap = -1.0 if geom.penetrationDepth == -math.inf else geom.penetrationDepth  # newer YADE: level sets apart
    row_address = np.int64(phys.prevU[1])
    # that of another contact, law or process is not its own
    if phys.prevU[2] != context.generation or view(abs(row_address), row_dtype).phys != phys_address:
        pairs = array(context.pairs, context.surfaces * (context.surfaces + 1) // 2, pair_dtype)
        row_address = make_row(law, context, pairs, row_dtype, geom, phys, interaction, phys_address, interaction_address)
        if row_address == 0:
            return without_row(context, pointers, phys)
    row = view(abs(row_address), row_dtype)
    pair = view(row.pair, pair_dtype)
    if row.interaction != interaction_address:
        record_fault(context, layout.SHARED, interaction, 0.0)
    if geom.refR1 + geom.refR2 != row.reach:
        follow_radii(law, context, geom, interaction, row, pair)
    old = state_of(law, row)
    of_contact = context, phys, phys_address, row_address > 0, pair, row, overlap, old
    force, stiffness, sideways, new = law_of_contact(law, *of_contact)
    if is_faulty(context, interaction, row, overlap, force):
        # without a guard, which would stop the run, propagate NaN
        force, stiffness, sideways, new = 0.0 if context.guard_counter != 0 else math.nan, 0.0, 0.0, old
    tangential = 0.0
    if abs(phys.kno + phys.kso - row.written) > 1e-9 * row.written:
        record_fault(context, layout.CHANGED, interaction, 0.0)
    if overlap > 0.0:
        phys.kno, phys.kso = coefficients(force, sideways, overlap, row.ratio)
        row.written = phys.kno + phys.kso
        tangential = phys.kso * math.sqrt(overlap)
        if physics == context.conical:
            keep_radius(law.rule, phys_address, row, overlap, new)
    elif overlap - overlap != 0.0:
        record_fault(context, layout.NOT_FINITE, interaction, overlap)  # NaN: a body's position is not finite
    write_tuple(row.state.ctypes.data, law.state, new)
    functor = view(functor_address - context.functor_offset, objects.Functor)
    first = view(body_of(context, interaction.id1, functor.scene).state, objects.State)
    second = view(body_of(context, interaction.id2, functor.scene).state, objects.State)
    of_scene = functor, view(functor.scene, objects.Scene), first, second
    contact = Contact(context, row, pointers, geom, phys, interaction, *of_scene)
    if overlap > 0.0:
        synchronise(law.mode, contact)
    keep = apply_mindlin(law.mode, contact, tangential)
    row.overlap = overlap
    assign(row.left, vector(phys.shearElastic))
    if overlap > 0.0:
        phys.kn = stiffness  # Mindlin left 1.5 P/δ here; the time stepper needs the tangent
    else:
        end_contact(law, context, pair, row, old)
    if keep == 0:
        add_integer(context.open.ctypes.data, -1)
        row.tag = 0.0
        row.phys = 0
        phys.prevU[1] = phys.prevU[2] = 0.0  # at a joint of a chain, another contact has the same phys
    return keep


# what `entry` gives to a copy of the function below
LAW = PAIR = ROW = CONTEXT_OFFSET = None


def _go(functor, geom_pointer, phys_pointer, interaction):
    context = view(pointee(pointee(functor) + CONTEXT_OFFSET), CONTEXT)
    return go(LAW, PAIR, ROW, context, (functor, geom_pointer, phys_pointer, interaction))


def entry(pairs, context_offset):
    """`go` for the kind of laws of `pairs` as native code (`.address`).

    The address of the context is `context_offset` bytes after the functor's table of virtual
    functions. The dtypes, with offsets in YADE's objects, are constants of the code.
    """
    if isinstance(pairs.law.mode, Slip):
        import demlaws.yade.slip  # noqa: F401  its code of `compress` and `apply_mindlin`
    constants = {
        "OBJECTS": objects.identity(),
        "LAW": pairs.law,
        "PAIR": pairs.records.dtype,
        "ROW": pairs.row,
        "CONTEXT_OFFSET": context_offset,
    }
    return callback(types.uint8(*[types.int64] * 4), _go, constants)


# --- batches: self-tests, reports, energies


@loop
def evaluate_loop(law, pairs, contacts, out):
    """The law, without springs and friction, for an array of contacts, whose state is updated in place.

    out: an array of `EVALUATED`. Returns the first contact whose force is not finite, or -1.
    """
    bad = -1
    for i in range(contacts.size):
        c = contacts[i]
        old = state_of(law, c)
        pair = pairs[np.int64(c.tag) - 1]
        rough = pair.smooth == 0 and c.modulus != 0.0
        force, stiffness, sideways, new = law_of_contact(law, 0, 0, 0, rough, pair, c, c.overlap, old)
        if force - force != 0.0 or c.overlap - c.overlap != 0.0:
            bad = i if bad < 0 else bad
            force, stiffness, sideways, new = 0.0, 0.0, 0.0, old
        write_tuple(c.state.ctypes.data, law.state, new)
        kno, kso = coefficients(force, sideways, c.overlap, c.ratio) if c.overlap > 0.0 else (0.0, 0.0)
        out[i].kno = kno
        out[i].kso = kso
        out[i].tangent = stiffness
        out[i].force = force
        out[i].stored, out[i].dissipated = energies(law, pair, c, c.overlap, old)
        if rough:
            shape, p = shape_of(law, pair), params_of(law, c)
            out[i].pressure = mean_pressure(law.rule, shape, p, c.modulus, c.overlap, force, stiffness, new)
            _, _, equivalent, area = first_loading(shape, p, max(c.overlap, c.state[0]))
            out[i].yielded = area > equivalent * (1.0 + 1e-9)  # a²/R is δ_H(P) before (`core.dispatch`)
        elif c.modulus != 0.0:
            hertz = HertzShape(), HertzParams(c.hertz), c.modulus
            out[i].pressure = mean_pressure(rule_of_smooth_contact(law.rule), *hertz, c.overlap, force, stiffness, new)
    return bad
