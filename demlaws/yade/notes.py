"""Notes of compiled code for the guard: faults, and what is to be warned of. Compiled code, as `kernel`."""

import numba
import numpy as np

from demlaws.core.numba_compat import kernel
from demlaws.units import LARGEST_OVERLAP
from demlaws.yade import layout
from demlaws.yade.layout import SEEN
from demlaws.yade.records import array

cold = numba.njit(error_model="numpy", nogil=True)
"""Compile a function that few contacts call, not inlined."""


@kernel
def alarm(context):
    """Have the guard run before the contacts of the next step."""
    if context.alarm != 0:
        array(context.alarm, 1, np.int64)[0] = 0


@cold
def note_fault(context, kind, interaction, value):
    """Note a fault for the guard, which stops the simulation before the next step with a message about the last one."""
    alarm(context)
    context.fault = 1
    context.fault_kind = kind
    context.fault_body1 = interaction.id1
    context.fault_body2 = interaction.id2
    context.fault_value = value


@cold
def note_shared(context, interaction):
    """Note a contact that has the physics of another one: both get the force."""
    context.shared_body1 = interaction.id1
    context.shared_body2 = interaction.id2
    context.shared = SEEN
    alarm(context)


@cold
def note_changed(context, interaction):
    """Note a contact of which something else has changed kno or kso, which the law writes."""
    context.changed_body1 = interaction.id1
    context.changed_body2 = interaction.id2
    context.changed = SEEN
    alarm(context)


@cold
def check_depth(context, row, overlap):
    """TOO_DEEP for an overlap beyond LARGEST_OVERLAP of R, else 0. The guard warns of the first one beyond SMALL_OVERLAP."""
    if row.modulus == 0.0:
        return 0  # a marker
    if overlap > LARGEST_OVERLAP * row.radius and row.hertz == 0.0:  # a smooth contact has Hertz's force, as in YADE's law
        context.deep_radius = row.radius
        return layout.TOO_DEEP
    if context.deep == layout.UNSEEN:
        context.deep = SEEN
        alarm(context)
    return 0
