"""Shear at a contact: how the elastic shear force follows K_t, and the energy of shear. Compiled code, as `kernel`.

`Levels`: the springs of a contact in levels (demlaws.core.levels). `Native` leaves the force as it is where K_t changes; `Slip`
sets it: a row of springs. YADE's geometry of the contact has the displacement of the step and how the normal turns.
"""

from typing import NamedTuple

from demlaws.core.dispatch import bind, generic
from demlaws.core.fastmath import sqrt
from demlaws.core.levels import energy_of_levels, follow_stiffness, force_of_levels, scale_levels
from demlaws.core.numba_compat import kernel
from demlaws.core.vectors import assign, cross, dot, minus_scaled, scaled, vector
from demlaws.yade import layout
from demlaws.yade.mindlin import (
    advance,
    image_of,
    limit_of_native_step,
    reduce_dashpot,
    together_within_limit,
    turned,
    velocity_apart,
)


class Levels(NamedTuple):
    """Springs in levels, which remember; passive. Coulomb's limit scales all."""


class Native(NamedTuple):
    """Mindlin's shear as YADE has it: the force is kept where K_t falls."""


class Slip(NamedTuple):
    """Partial slip by the method of dimensionality reduction (`demlaws.core.slip`); its code is in `slip`."""


# --- the displacement of a step


@generic(lambda *_: lambda mode, contact: None)
def synchronise(mode, contact):
    """Correct the displacement of the step, shearInc, which YADE has from spins ω of the half step and n of the full step.

    With h of the half step, along n - change/2, change = n - n_before, surfaces part at v2 - v1 - (r1 ω1 + r2 ω2) × h, of which
    the part in the plane of h counts; the levers r are those of the half step, too. Without this a small grain that spins about
    n is held between much larger ones. The springs turn about n by dt/2 (ω1 + ω2)·h, written to twist_axis; the displacement,
    of the half step, by half of that angle, else the turn adds or takes energy. [our derivation] `Native` is left out: it is
    Mindlin's law as YADE has it.
    """


@kernel
def _to_half_step(mode, contact):
    if contact.context.slip_of_yade != 0:
        return
    geom, dt, first, second = contact.geom, contact.scene.dt, contact.first, contact.second
    normal, spins = vector(geom.normal), minus_scaled(vector(first.angVel), -1.0, vector(second.angVel))
    change = cross(vector(geom.orthonormal_axis), normal)  # orthonormal_axis: n_before × n
    middle = minus_scaled(normal, 0.5, change)
    moved = vector(geom.shearInc)
    if contact.row.lever == layout.ROUND:
        apart = velocity_apart(contact, vector(first.vel), vector(second.vel))
        moved = between_spheres(dt, geom, apart, vector(first.angVel), spins, change, middle)
    elif contact.row.lever == layout.FLAT:
        moved = on_flat(contact, change, middle)
    angle = 0.5 * dt * dot(spins, middle)
    assign(geom.twist_axis, scaled(angle, normal))
    assign(geom.shearInc, turned_about(moved, normal, 0.5 * angle))


@kernel
def turned_about(a, normal, angle):
    """A vector across a normal, turned about it by an angle below 0.1, to the fourth power of the angle."""
    square = angle * angle
    return minus_scaled(scaled(1.0 - 0.5 * square, a), -angle * (1.0 - square / 6.0), cross(normal, a))


@kernel
def across(normal, a):
    """The part of a vector across a normal."""
    return minus_scaled(a, dot(a, normal), normal)


@kernel
def to_plane_of_now(apart, arms, normal, change, middle):
    """Velocity apart - arms × h [m/s] in the plane of h, brought to that of n."""
    lever = cross(arms, scaled(1.0 - 0.125 * dot(change, change), middle))
    return minus_scaled(across(normal, minus_scaled(apart, 1.0, lever)), -0.5 * dot(apart, middle), change)


@kernel
def between_spheres(dt, geom, apart, spin1, spins, change, middle):
    """shearInc of the half step [m] of two bodies with radii. Levers are radii or, without avoidGranularRatcheting, radii less
    half the overlap: the way that fits shearInc."""
    normal, overlap, total = vector(geom.normal), geom.penetrationDepth, geom.refR1 + geom.refR2
    arms = minus_scaled(scaled(geom.refR2, spins), geom.refR2 - geom.refR1, spin1)
    before = overlap + 0.5 * dt * dot(apart, middle)  # overlap of the half step
    half = minus_scaled(arms, 0.5 * overlap, spins)
    known = across(normal, minus_scaled(apart, 1.0, cross(half, normal)))
    other = across(normal, minus_scaled(scaled(overlap / (total - overlap), apart), 0.5 * overlap, cross(spins, normal)))
    found = minus_scaled(scaled(1.0 / dt, vector(geom.shearInc)), 1.0, known)
    if dot(found, other) > 0.5 * dot(other, other):
        found = minus_scaled(found, 1.0, other)
        now = to_plane_of_now(scaled(total / (total - before), apart), arms, normal, change, middle)
    else:
        now = to_plane_of_now(apart, minus_scaled(arms, 0.5 * before, spins), normal, change, middle)
    return scaled(dt, minus_scaled(now, -1.0, found))


@kernel
def on_flat(contact, change, middle):
    """Displacement of the half step [m] on a flat first body, which turns about its position: with that lever, whatever
    Ig2_Wall_Sphere_ScGeom.noRatch is."""
    geom, first, second, dt = contact.geom, contact.first, contact.second, contact.scene.dt
    normal, half, point = vector(geom.normal), 0.5 * dt, vector(geom.contactPoint)
    place, spin1, spin2 = minus_scaled(point, 1.0, vector(first.pos)), vector(first.angVel), vector(second.angVel)
    arm = dot(minus_scaled(vector(second.pos), 1.0, image_of(contact, point)), normal)
    share = (geom.refR2 - arm) / geom.penetrationDepth  # of the overlap, by which the lever is shorter than the radius
    apart = velocity_apart(contact, vector(first.vel), vector(second.vel))
    deeper = half * share * dot(minus_scaled(apart, 1.0, cross(spin1, place)), middle)
    place = minus_scaled(minus_scaled(place, half, apart), -0.5 * arm, change)
    place = minus_scaled(place, -deeper, normal)
    apart = minus_scaled(apart, 1.0, cross(spin1, place))
    return scaled(dt, to_plane_of_now(apart, scaled(arm - deeper, spin2), normal, change, middle))


@kernel
def turn_of_step(geom):
    """How a tangential vector turns with the contact in this step: n, (n + n_before)/(1 + n n_before), cosine and sine of the
    turn about n."""
    normal, axis = vector(geom.normal), vector(geom.orthonormal_axis)
    cosine = sqrt(max(1.0 - dot(axis, axis), 0.0))
    middle = minus_scaled(normal, -1.0 / (1.0 + cosine), cross(normal, axis))
    half = 0.5 * dot(vector(geom.twist_axis), normal)
    half *= 1.0 + half * half / 3.0  # the tangent: a length is kept to rounding
    inverse = 1.0 / (1.0 + half * half)
    return normal, middle, (1.0 - half * half) * inverse, 2.0 * half * inverse


@kernel
def turned_with(turn, a):
    """A tangential vector, turned as a body; its length is kept."""
    normal, middle, cosine, sine = turn
    flat = minus_scaled(a, dot(a, normal), middle)
    return minus_scaled(scaled(cosine, flat), -sine, cross(normal, flat))


# --- levels


@kernel
def _energy_of_levels(mode, contact, stiffness):
    return energy_of_levels(contact.row.bound, contact.row.stretch)


@kernel
def _force_of_displaced_levels(mode, contact, increment):
    move_levels(contact.geom, contact.row, increment)
    return force_of_levels(contact.row.bound, contact.row.stretch)


@kernel
def move_levels(geom, row, increment):
    """Turn the stretches with the contact and add the displacement of the step."""
    turn = turn_of_step(geom)
    for level in range(len(row.bound)):
        assign(row.stretch[level], minus_scaled(turned_with(turn, vector(row.stretch[level])), 1.0, increment))


@kernel
def _scale_levels(mode, row, share):
    scale_levels(row.stretch, share)


@kernel
def _turn_in_advance(mode, contact):
    geom, phys = contact.geom, contact.phys
    wanted = turned_with(turn_of_step(geom), vector(phys.shearElastic))
    if phys.betas != 0.0 and geom.penetrationDepth > 0.0:
        limit = limit_of_native_step(contact)
        reduce_dashpot(mode, contact, minus_scaled(wanted, phys.ks, vector(geom.shearInc)), 1.0, limit)
    assign(phys.shearElastic, before_turn(geom, wanted))


@kernel
def before_turn(geom, wanted):
    """The vector that the turn of the contact, as ScGeom::rotate has it, makes the wanted one."""
    given = wanted
    for _ in range(12):
        given = minus_scaled(given, 1.0, minus_scaled(turned(geom, given), 1.0, wanted))
    return given


@kernel
def _follow_native_step(mode, contact):
    geom, phys, row = contact.geom, contact.phys, contact.row
    if not geom.penetrationDepth > 0.0:
        return
    move_levels(geom, row, vector(geom.shearInc))
    if phys.isSliding != 0:
        force, trial = vector(phys.shearElastic), force_of_levels(row.bound, row.stretch)
        scale_levels(row.stretch, sqrt(dot(force, force) / dot(trial, trial)))


# --- Mindlin's law with an account of energy


@generic(lambda *_: lambda mode, geom, force: turned(geom, force))
def turned_force(mode, geom, force):
    """A shear force of the last step [N] as it is after the turn of the contact."""


@kernel
def _turned_with_contact(mode, geom, force):
    return turned_with(turn_of_step(geom), force)


@generic(lambda *_: lambda mode, contact, stiffness: contact.row.held - stored_energy(mode, contact, stiffness))
def relax_shear(mode, contact, stiffness):
    """Change the shear force for K_t now, `stiffness` [N/m], before Mindlin's law acts; energy [J] that is lost by this."""


@kernel
def _relax_levels(mode, contact, stiffness):
    row = contact.row
    loss = follow_stiffness(row.bound, row.stretch, stiffness)
    assign(contact.phys.shearElastic, force_of_levels(row.bound, row.stretch))
    return loss


@generic(lambda *_: _energy_of_force)
def stored_energy(mode, contact, stiffness):
    """Energy of shear [J] that the contact stores."""


def _energy_of_force(mode, contact, stiffness):
    force = vector(contact.phys.shearElastic)
    return 0.5 * dot(force, force) / stiffness if stiffness > 0.0 else 0.0


@kernel
def is_changed(contact):
    """Whether something else has set the elastic shear force since the last step."""
    now, left = vector(contact.phys.shearElastic), vector(contact.row.left)
    return now[0] != left[0] or now[1] != left[1] or now[2] != left[2]


@generic(lambda *_: lambda mode, contact, stiffness, force: stored_energy(mode, contact, stiffness))
def set_shear_force(mode, contact, stiffness, force):
    """Take over an elastic shear force [N] that a script has set; energy [J] of the contact with it."""


@kernel
def _adopt_as_one_level(mode, contact, stiffness, force):
    row = contact.row
    if stiffness > 0.0:
        for level in range(len(row.bound)):
            assign(row.stretch[level], scaled(1.0 / stiffness, force))
        assign(contact.phys.shearElastic, force)
    return energy_of_levels(row.bound, row.stretch)


@kernel
def account(row, stiffness, stored, loss):
    """Write K_t [N/m], the energy of shear that the contact stores and the energy that it has lost in this step [J]."""
    row.shear = stiffness
    row.held = stored
    row.lost += loss


@kernel
def apply_with_account(mode, contact, stiffness):
    """Mindlin's law, with an account of the energy of shear."""
    geom, phys, row = contact.geom, contact.phys, contact.row
    given, changed = vector(phys.shearElastic), is_changed(contact)
    held, loss = row.held, relax_shear(mode, contact, stiffness)
    if changed:
        held, loss = set_shear_force(mode, contact, stiffness, given), 0.0
    first, old = held - loss, vector(phys.shearElastic)
    keep = advance(mode, contact)
    if not stiffness > 0.0:
        account(row, 0.0, 0.0, held)
        return keep
    last = stored_energy(mode, contact, stiffness)
    if phys.isSliding != 0 and first + last > 0.0:
        increment, new = vector(geom.shearInc), vector(phys.shearElastic)  # its work on the body is positive against the force
        old = turned_force(mode, geom, old)
        if dot(old, new) < 0.0:  # as in demlaws.core.levels; the limit may have fallen
            old = scaled(min(1.0, sqrt(dot(new, new) / dot(old, old))), old)
        loss -= 0.5 * (dot(old, increment) + dot(new, increment)) + (last - first)
    account(row, stiffness, last, loss)
    return keep


@generic(lambda *_: lambda mode, rule, shape, p, row, overlap, force, stiffness, state: None)
def compress(mode, rule, shape, p, row, overlap, force, stiffness, state):
    """Write the mean compressions [m] of the springs; stiffness: with which the contact would unload now [N/m]."""


@generic(lambda *_: apply_with_account.py_func)
def apply_mindlin(mode, contact, stiffness):
    """Mindlin's law; stiffness: K_t [N/m]. Returns whether the contact lasts."""


bind(
    Levels,
    synchronise=_to_half_step,
    trial_force=_force_of_displaced_levels,
    slide=_scale_levels,
    turned_force=_turned_with_contact,
    before_native_step=_turn_in_advance,
    after_native_step=_follow_native_step,
    relax_shear=_relax_levels,
    stored_energy=_energy_of_levels,
    set_shear_force=_adopt_as_one_level,
    within_limit=together_within_limit,
)
bind(Slip, synchronise=_to_half_step, within_limit=together_within_limit)
MODES = {"elastic": Levels(), "loading": Levels(), "native": Native(), "slip": Slip()}
"""Choice of `shear=` → how the shear force follows K_t."""
