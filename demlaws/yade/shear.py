"""Shear at a contact: changes of Mindlin's shear force, and the energy of shear. Compiled code, as `kernel`.

`Passive` reduces the force before the native law adds K_t ds, `Native` leaves it as it is, `Slip` sets it: a row of springs.
YADE's geometry of the contact has the relative displacement of the step, and turns vectors with the contact.
"""

import math
from typing import NamedTuple

from numba.extending import overload

from demlaws.core.numba_compat import INLINED, kernel
from demlaws.core.unloading import GIVEN
from demlaws.yade import layout as at
from demlaws.yade.memory import (
    call_apply_force,
    call_body_by_id,
    call_go,
    call_rotate,
    load_byte,
    load_double,
    load_int,
    load_word,
    on_stack,
    store_byte,
    store_double,
)

SLACK = 1e-11
SPRING_WORDS = 4
"""Words per spring behind FRAME_WORDS: G at its upper end, mean compression, two components of stretch."""
FRAME_WORDS = 8
"""Two tangents, the stiffness of a spring, one unused."""
SPRINGS = 12
SLIP_RULES = ("elastic", "hertz", "thornton", GIVEN, "etsion", "jackson")
"""Names of the rules that unload along a curve that does not depend on the history but for its place and its radius."""


class Passive(NamedTuple):
    """Where K_t falls, the part of the contact that opens takes its force along; Coulomb's limit acts last."""


class Native(NamedTuple):
    """Mindlin's shear as YADE has it: the force is kept where K_t falls."""


class Slip(NamedTuple):
    """Partial slip by the method of dimensionality reduction (`demlaws.core.slip`); its code is in `slip`."""


@kernel
def word(context, number):
    """Word `number` of the context."""
    return load_word(context + 8 * number)


@kernel
def load_vector(place):
    """Three doubles."""
    return load_double(place), load_double(place + 8), load_double(place + 16)


@kernel
def store_vector(place, vector):
    """Three doubles."""
    store_double(place, vector[0])
    store_double(place + 8, vector[1])
    store_double(place + 16, vector[2])


@kernel
def scaled(factor, a):
    """factor a."""
    return factor * a[0], factor * a[1], factor * a[2]


@kernel
def less(a, factor, b):
    """a - factor b."""
    return a[0] - factor * b[0], a[1] - factor * b[1], a[2] - factor * b[2]


@kernel
def dot(a, b):
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def cross(a, b):
    """Vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@kernel
def turned(context, geom, vector):
    """A tangential vector, turned with the contact in this step."""
    place = on_stack(vector)
    call_rotate(word(context, at.ROTATE), geom, place)
    return load_vector(place)


@kernel
def turned_here(context, geom, place):
    """The vector at `place`, after it was turned there."""
    call_rotate(word(context, at.ROTATE), geom, place)
    return load_vector(place)


@kernel
def is_plain(context, this, geom, phys, interaction, row):
    """Whether `step_alone` does what the native law would do: the contact is not new and has no viscous damping, the functor
    has no option, the scene no period."""
    return (
        word(context, at.ALONE) != 0
        and load_double(geom + word(context, at.OVERLAP)) > 0.0
        and load_double(row + at.LAST) > 0.0
        and load_word(row + at.ROW_INTERACTION) == interaction
        and load_double(phys + word(context, at.BETAN)) == 0.0
        and load_double(phys + word(context, at.BETAS)) == 0.0
        and load_double(phys + word(context, at.DAMPING_KIND)) == 0.0
        and load_int(this + word(context, at.OPTIONS)) == 0
        and load_byte(load_word(this + word(context, at.SCENE)) + word(context, at.PERIODIC)) == 0
    )


@kernel
def body_of_number(context, number, scene):
    """Address of a body; scene 0: the current one."""
    return load_word(call_body_by_id(word(context, at.BODY_BY_ID), number, scene))


@kernel
def position_of(context, number, scene):
    """Address of the position of a body."""
    return load_word(body_of_number(context, number, scene) + word(context, at.BODY_STATE)) + word(context, at.POSITION)


@kernel
def step_alone(context, this, geom, phys, interaction):
    """The native law for a contact that `is_plain`: shear, Coulomb's limit, forces, torques; every attribute."""
    overlap = load_double(geom + word(context, at.OVERLAP))
    root = math.sqrt(overlap)
    ks = load_double(phys + word(context, at.KSO)) * root
    size = load_double(phys + word(context, at.KNO)) * overlap * root
    along, step = load_vector(geom + word(context, at.NORMAL)), load_vector(geom + word(context, at.INCREMENT))
    normal = scaled(size, along)
    force = less(turned_here(context, geom, phys + word(context, at.SHEAR_FORCE)), ks, step)
    stretch = less(turned_here(context, geom, phys + word(context, at.STRETCH)), 1.0, step)
    total = less(turned_here(context, geom, phys + word(context, at.DISPLACEMENT)), 1.0, step)
    limit, square = load_double(phys + word(context, at.FRICTION)) * size, dot(force, force)
    sliding = square > limit * limit
    if sliding:
        share = limit / math.sqrt(square)
        force, stretch = scaled(share, force), scaled(share, stretch)
    store_byte(phys + word(context, at.SLIDING), sliding)
    store_double(phys + word(context, at.KS), ks)
    store_vector(phys + word(context, at.NORMAL_FORCE), normal)
    store_vector(phys + word(context, at.SHEAR_FORCE), force)
    store_vector(phys + word(context, at.SHEAR_SUM), force)
    store_vector(phys + word(context, at.SHEAR_VISCOUS), (0.0, 0.0, 0.0))
    store_vector(phys + word(context, at.STRETCH), stretch)
    store_vector(phys + word(context, at.DISPLACEMENT), total)
    scene = load_word(this + word(context, at.SCENE))
    first, second = load_int(interaction + word(context, at.BODY1)), load_int(interaction + word(context, at.BODY2))
    call_apply_force(
        word(context, at.APPLY),
        this - word(context, at.FUNCTOR),
        on_stack(less(scaled(-1.0, normal), 1.0, force)),
        geom + word(context, at.POINT),
        first,
        position_of(context, first, scene),
        second,
        position_of(context, second, scene),
    )
    return 1


@kernel
def advance(context, this, geom_pointer, phys_pointer, interaction, row):
    """Mindlin's law with the coefficients in the contact's physics. Returns whether the contact lasts."""
    geom, phys = load_word(geom_pointer), load_word(phys_pointer)
    if is_plain(context, this, geom, phys, interaction, row):
        return step_alone(context, this, geom, phys, interaction)
    return call_go(word(context, at.GO), this, geom_pointer, phys_pointer, interaction)


@kernel
def kept_share(now, old):
    """Share of the shear force that stays: where K_t falls, the part of the contact that opens takes its force along.

    What is stored, F²/(2 K_t), then never grows without work (docs/shear.md). [our derivation]
    """
    return now / old if now < old * (1.0 - SLACK) else 1.0  # rounding is no fall


@kernel
def reduce_force(phys, context, now, old):
    """Reduce the shear force to `kept_share`; the native law then applies Coulomb's limit, with the normal dashpot in it."""
    share = kept_share(now, old)
    if share < 1.0:
        place = phys + word(context, at.SHEAR_FORCE)
        store_vector(place, scaled(share, load_vector(place)))


def before(mode, context, phys, row, stiffness):
    """Change the shear force before the native law acts; stiffness: K_t now [N/m]."""


@overload(before, jit_options=INLINED)
def _before(mode, context, phys, row, stiffness):
    if mode.instance_class is Passive:
        return lambda mode, context, phys, row, stiffness: reduce_force(
            phys, context, stiffness, load_double(row + at.SHEAR_STIFFNESS)
        )
    return lambda mode, context, phys, row, stiffness: None


@kernel
def account(row, stiffness, stored, loss):
    """Write K_t [N/m], the energy of shear that the contact stores and the energy that it has lost in this step [J]."""
    store_double(row + at.SHEAR_STIFFNESS, stiffness)
    store_double(row + at.SHEAR_HELD, stored)
    store_double(row + at.SHEAR_LOST, load_double(row + at.SHEAR_LOST) + loss)


@kernel
def go_as_one_spring(context, this, geom_pointer, phys_pointer, interaction, row, stiffness):
    """Mindlin's law, with an account of the energy of shear."""
    geom, phys = load_word(geom_pointer), load_word(phys_pointer)
    place = phys + word(context, at.SHEAR_FORCE)
    old, stored = load_vector(place), load_double(row + at.SHEAR_HELD)
    keep = advance(context, this, geom_pointer, phys_pointer, interaction, row)
    if not stiffness > 0.0:
        account(row, 0.0, 0.0, stored)
        return keep
    compliance = 0.5 / stiffness
    new, normal = load_vector(place), load_vector(phys + word(context, at.NORMAL_FORCE))
    friction = load_double(phys + word(context, at.FRICTION)) * (1.0 - SLACK)
    first, last = compliance * dot(old, old), compliance * dot(new, new)
    loss = stored - first
    if first + last > 0.0 and dot(new, new) >= friction * friction * dot(normal, normal):  # it slides
        step = load_vector(geom + word(context, at.INCREMENT))  # its work on the body is positive against the force
        loss -= 0.5 * (dot(turned(context, geom, old), step) + dot(new, step)) + (last - first)
    account(row, stiffness, last, loss)
    return keep


def compress(mode, rule, p, context, row, overlap, force, stiffness, state):
    """Write the mean compressions [m] of the springs; stiffness: with which the contact would unload now [N/m]."""


@overload(compress, jit_options=INLINED)
def _compress(mode, rule, p, context, row, overlap, force, stiffness, state):
    if mode.instance_class is not Slip:
        return lambda mode, rule, p, context, row, overlap, force, stiffness, state: None


def go(mode, context, this, geom_pointer, phys_pointer, interaction, row, stiffness):
    """Mindlin's law; stiffness: K_t [N/m]. Returns whether the contact lasts."""


@overload(go, jit_options=INLINED)
def _go(mode, context, this, geom_pointer, phys_pointer, interaction, row, stiffness):
    if mode.instance_class is not Slip:
        return lambda mode, context, this, geom_pointer, phys_pointer, interaction, row, stiffness: go_as_one_spring(
            context, this, geom_pointer, phys_pointer, interaction, row, stiffness
        )


MODES = {"elastic": Passive(), "loading": Passive(), "native": Native(), "slip": Slip()}
"""Choice of `shear=` → change of Mindlin's shear force."""
