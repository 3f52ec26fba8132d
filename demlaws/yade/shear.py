"""Shear at a contact: changes of Mindlin's shear force, and the energy of shear. Compiled code, as `kernel`.

`Passive` reduces the force before the native law adds K_t ds, `Native` leaves it as it is, `Slip` sets it: a row of springs.
The relative displacement of a step, and how the contact turns, is taken from the native law, which adds forces to bodies at
once. `probe` therefore calls it without stiffness, damping and moments: it adds nothing and leaves the displacement.
"""

from typing import NamedTuple

import numba
from numba.extending import overload

from demlaws.core.numba_compat import INLINED, kernel
from demlaws.core.unloading import GIVEN
from demlaws.yade import layout as at
from demlaws.yade.memory import call_go, load_double, load_word, scratch, store_double, store_word

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
def store_vector(place, x, y, z):
    """Three doubles."""
    store_double(place, x)
    store_double(place + 8, y)
    store_double(place + 16, z)


@kernel
def dot(a, b):
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def cross(a, b):
    """Vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@numba.njit(error_model="numpy", nogil=True)
def probe(context, this, geom_pointer, phys_pointer, interaction, x, y, z):
    """Tangential displacement of this step, positive along the shear force that it makes [m], and the tangential vector
    (x, y, z) turned with the contact as the native law turns it. Nothing else is changed."""
    phys = load_word(phys_pointer)
    block, backup = phys + word(context, at.BLOCK), scratch()
    for n in range(word(context, at.BLOCK_WORDS)):
        store_word(backup + 8 * n, load_word(block + 8 * n))
    number = at.PROBED
    while word(context, number) != 0:
        store_double(phys + word(context, number), 0.0)
        number += 1
    displacement, stretch = phys + word(context, at.DISPLACEMENT), phys + word(context, at.STRETCH)
    store_vector(stretch, x, y, z)
    call_go(word(context, at.GO), this, geom_pointer, phys_pointer, interaction)
    step, turned = load_vector(displacement), load_vector(stretch)
    for n in range(word(context, at.BLOCK_WORDS)):
        store_word(block + 8 * n, load_word(backup + 8 * n))
    return step, (turned[0] - step[0], turned[1] - step[1], turned[2] - step[2])


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
        x, y, z = load_vector(place)
        store_vector(place, share * x, share * y, share * z)


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
    """Call the native law and account for the energy of shear."""
    phys = load_word(phys_pointer)
    place = phys + word(context, at.SHEAR_FORCE)
    old, stored = load_vector(place), load_double(row + at.SHEAR_HELD)
    keep = call_go(word(context, at.GO), this, geom_pointer, phys_pointer, interaction)
    if not stiffness > 0.0:
        account(row, 0.0, 0.0, stored)
        return keep
    compliance = 0.5 / stiffness
    new, normal = load_vector(place), load_vector(phys + word(context, at.NORMAL_FORCE))
    friction = load_double(phys + word(context, at.FRICTION)) * (1.0 - SLACK)
    first, last = compliance * dot(old, old), compliance * dot(new, new)
    loss = stored - first
    if first + last > 0.0 and dot(new, new) >= friction * friction * dot(normal, normal):  # it slides
        step, turned = probe(context, this, geom_pointer, phys_pointer, interaction, old[0], old[1], old[2])
        loss += 0.5 * (dot(turned, step) + dot(new, step)) - (last - first)
    account(row, stiffness, last, loss)
    return keep


def compress(mode, rule, p, context, row, overlap, force, stiffness, state):
    """Write the mean compressions [m] of the springs; stiffness: with which the contact would unload now [N/m]."""


@overload(compress, jit_options=INLINED)
def _compress(mode, rule, p, context, row, overlap, force, stiffness, state):
    if mode.instance_class is not Slip:
        return lambda mode, rule, p, context, row, overlap, force, stiffness, state: None


def go(mode, context, this, geom_pointer, phys_pointer, interaction, row, stiffness):
    """Call the native law; stiffness: K_t [N/m]. Returns its answer."""


@overload(go, jit_options=INLINED)
def _go(mode, context, this, geom_pointer, phys_pointer, interaction, row, stiffness):
    if mode.instance_class is not Slip:
        return lambda mode, context, this, geom_pointer, phys_pointer, interaction, row, stiffness: go_as_one_spring(
            context, this, geom_pointer, phys_pointer, interaction, row, stiffness
        )


MODES = {"elastic": Passive(), "loading": Passive(), "native": Native(), "slip": Slip()}
"""Choice of `shear=` → change of Mindlin's shear force."""
