"""Params of one contact or of an array of contacts: nested tuples whose leaves are numbers or 1-D arrays."""

import numpy as np
from numba.extending import register_jitable

from demlaws.core.loops import evaluate_loop, scale_loop, scale_one
from demlaws.core.numba_compat import INLINED
from demlaws.core.unloading import Elastic, JoinedParams, JoinedShape
from demlaws.errors import DemlawsError

SMOOTHEST = 1e-40
"""σ/R below which roughness counts as this: no effect left in double precision, and no division by zero at σ = 0."""


@register_jitable(**INLINED)
def clamped_roughness(roughness, radius):
    """Roughness [m] of one contact as laws take it: never below SMOOTHEST times the radius. For compiled code, too."""
    return max(roughness, SMOOTHEST * radius)


def leaves(params):
    """The per-contact arrays and shared values of a nested tuple, flat."""
    for value in params:
        if isinstance(value, tuple):
            yield from leaves(value)
        else:
            yield value


def map_leaves(function, params):
    """The same nested tuple with `function` applied to each number or array in it."""
    values = [map_leaves(function, v) if isinstance(v, tuple) else function(v) for v in params]
    return type(params)(*values) if hasattr(params, "_fields") else tuple(values)


def loading_part(params):
    """Of a law's Shape or Params what belongs to first loading: all of it, unless it has an unloading curve joined to it."""
    return params.loading if isinstance(params, JoinedShape | JoinedParams) else params


def first_loading(params, overlap, force, stiffness):
    """Force [N] and stiffness [N/m] of first loading at any overlaps [m], into arrays: whether all forces are finite."""
    return evaluate_loop(Elastic(), loading_part(params), overlap, (), force, stiffness)


def clamped_roughnesses(contact):
    """The same for a contact or an array of contacts."""
    return np.maximum(contact.roughness, SMOOTHEST * np.asarray(contact.radius))


def bind_params(shape, contact):
    """Params of a contact, or of an array of contacts: values that differ become arrays, the others stay numbers."""
    roughness = clamped_roughnesses(contact)
    if contact.size is None:
        return scale_one(shape, contact.radius, contact.modulus, float(roughness))
    # copies: loops are compiled once for arrays that may be written to, once more for others
    columns = [np.array(np.broadcast_to(v, contact.size), float) for v in (contact.radius, contact.modulus, roughness)]
    if contact.size == 0:
        raise DemlawsError("the contact's arrays are empty: give at least one contact")
    first = scale_one(shape, *(float(c[0]) for c in columns))
    arrays = map_leaves(lambda v: np.empty(contact.size) if isinstance(v, float) else v, first)
    scale_loop(shape, *columns, arrays)

    def shared(value):
        one = isinstance(value, np.ndarray) and value.ndim == 1 and np.all(value == value[0])
        return float(value[0]) if one else value

    return map_leaves(shared, arrays)


def one_of(params, index):
    """Params of contact `index` of an array of contacts (of a single one: its own)."""
    return map_leaves(lambda v: float(v[index]) if isinstance(v, np.ndarray) and v.ndim == 1 else v, params)
