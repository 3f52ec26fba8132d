"""Records that compiled code and Python share: the context of a law, its pairs of surfaces, its contacts' rows, bodies' shapes.

The address of the context is behind the functor's table of virtual functions, so that one piece of machine code, kept on disk,
serves every functor of a law. What YADE's own objects look like is in `objects`.
"""

import functools
import mmap

import numpy as np
from numpy.lib.recfunctions import repack_fields

FAULTS = 15
WRONG_CLASS, NOT_FINITE, WRONG_CONTACT, TOO_ROUGH, TOO_DEEP, WRONG_MODULUS = range(6)
NO_ROW, LOST_ROW, FLAT_GAP, NO_CURVATURE, CHANGED, SET_SHEAR, UNGUARDED, FRICTION, NATIVE_STEP = range(6, FAULTS)
UNLISTED, UNKNOWN_SHAPE, SHARED, DEEP, UNJUDGED = range(FAULTS, FAULTS + 5)
"""Kinds of notes of native code for the guard: faults, which stop the run, and others."""
NOTES = FAULTS + 5

BODY_RADIUS, BODY_RADIUS_MEANT, CURVATURE_RADIUS = 0, 1, 2
"""Values of `radius_mode`."""

ROUND, FLAT, NO_LEVER = 0, 1, 2
"""Values of `lever`, of a contact: both bodies have a radius, the first one is flat, one of them has neither."""

UNSEEN, SEEN, REPORTED = 0, 1, 2
"""Values of `seen` of a kind of notes; a fault that was reported is not noted again."""

MOST_CLASSES = 8
"""Classes of geometry or shapes of which a context can have the types."""

ROWS_BITS, BLOCKS_BITS = 14, 14
ROWS, BLOCKS = 2**ROWS_BITS, 2**BLOCKS_BITS
"""Rows of contacts in a block, and the largest number of blocks of a law."""
READ_AND_WRITE, OF_ITS_OWN = mmap.PROT_READ | mmap.PROT_WRITE, mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS
"""How a block of memory is mapped: used only where something is written."""

_FUNCTIONS = ("go", "body_by_id", "apply_force", "gap_radius")  # addresses; go: the native one
_CLASSES = (
    "physics",
    "capillary",
    "conical",
    "facet",
    "wall",
    "box",
)  # addresses of types
_TABLES = (
    "surfaces",  # number of surfaces: of labels, and the unlisted materials
    "labels",  # address of the surfaces' labels, in UTF-8, each filled up with zeros to `label_size` bytes
    "label_size",
    "pair_numbers",  # address of the numbers of pairs of two surfaces
    "pairs",
    "edges",  # address of the surfaces' edge radii [m]
    "blocks",  # address of the addresses of blocks of rows, 0 before the first block
    "map_memory",  # address of mmap of the C library, by which a block is made
    "free",  # address of numbers of rows that may be used again
    "free_count",
    "collect_at",  # number of a row, or place in `free`, at which the guard looks for rows of contacts that have ended
    "shapes",  # address of SHAPE of each body
    "shape_count",
    "functor_offset",  # bytes from the start of the functor to what the native `go` gets as `this`
    "guard_counter",  # address of the guard's PyRunner.nDone, or 0: a zero written there has it run before the next contacts
)
_CHOICES = (
    "plane_flats",  # 1: R of a sphere on a facet, wall or box is the sphere's radius
    "radius_mode",
    "own_step",  # 1: where possible a contact step without the native function (`mindlin`), 0: never, for tests
    "native_step",  # 1: the native function acts on the other contacts; 0: these are a fault
    "slip_of_yade",  # 1: the displacement of a step is not corrected, for the self-test
    "may_be_unlisted",  # 1: materials without a surface are meant so
    "by_pressure",  # 1: the code has the friction of MindlinPhysCDM
)


def _context():
    fields = [(name, "i8") for name in (*_FUNCTIONS, *_CLASSES, *_TABLES, *_CHOICES)]
    for name in ("geometry", "round_shape"):
        fields += [(f"{name}_classes", "i8", (MOST_CLASSES,)), (f"{name}_count", "i8")]
    fields += [
        ("largest_radius", "f8"),
        ("generation", "f8"),  # drawn at random, beside the address of a row: one of another process or law is not taken
        ("shear_ratio", "f8"),
        ("apart", "i8", (8,)),
    ]  # what threads write is a cache line apart
    fields += [("seen", "i8", (NOTES,)), ("bodies", "i8", (NOTES, 2)), ("values", "f8", (NOTES,))]  # notes, by their kind
    fields += [("shapes_stale", "i8"), ("apart_too", "i8", (8,))]
    # sums of all threads, each an array of one so that it has an address
    fields += [("open", "i8", (1,)), ("rows_used", "i8", (1,)), ("free_taken", "i8", (1,))]
    fields += [(name, "f8", (1,)) for name in ("banked", "banked_shear", "banked_viscous")]
    return np.dtype(fields)


CONTEXT = _context()

# A contact's history: overlap of the last step [m], K_t/K, pair number + 1 (0: no contact), R [m], E* [Pa], state of the
# unloading rule; K_t of the last step [N/m], the energy of shear that the contact stores and that it has lost, that it has lost
# by viscous damping [J]; kno + kso and the elastic shear force [N] as left by the last step; sum of the bodies' radii [m].
_HISTORY: list = [(name, "f8") for name in ("overlap", "ratio", "tag", "radius", "modulus")]
_HISTORY += [("state", "f8", (3,)), *[(name, "f8") for name in ("shear", "held", "lost", "viscous", "written")]]
_HISTORY += [("left", "f8", (3,)), ("reach", "f8")]
EVALUATED = np.dtype(
    [(name, "f8") for name in ("kno", "kso", "tangent", "force", "stored", "dissipated", "pressure", "yielded")]
)

PLANE, SPHERE, FIELD = 1, 2, 3
"""Kinds of shapes with a curvature."""
SHAPE = np.dtype(
    [(name, "i8") for name in ("shape", "kind", "index", "tensors")]
    + [("count", "i8", (3,)), ("low", "f8", (3,)), ("size", "f8")]
)
"""A body's shape. size: spacing of the grid of a level set, radius of a sphere [m]."""


@functools.cache  # YADE keeps the laws of scenes that are gone
def pair_dtype(words):
    """dtype of a pair of surfaces; words: of the law's Shape."""
    # fields that all pairs have come last: numba takes a record for another one that it begins with
    judged = [(name, "f8", (2,)) for name in ("judged_radii", "judged_moduli")]  # ranges for which the guard has judged the law
    numbers = [(name, "f8") for name in ("roughness", "radius", "modulus", "mu0", "c1", "c2")]
    return np.dtype([("shape", "i8", (words,)), ("smooth", "i8"), *numbers, *judged])


@functools.cache
def contact_dtype(floats):
    """dtype of a contact outside YADE's objects: its history and its Params, a number of floats (`hertz`: of a smooth one)."""
    return np.dtype([*_HISTORY, ("params", "f8", (floats,)), ("hertz", "f8")])


@functools.cache
def row_dtype(levels, floats, springs):
    """dtype of a contact's row in the memory of a law.

    phys, interaction: addresses of the contact's objects; pair: of its pair; lever: how its surfaces turn. The history; the
    levels of shear: upper bounds of their stiffness K_t [N/m] and stretches [m]; the floats of the contact's Params, made once
    (a law that yields finds its yield point by bisection), or `hertz` of a smooth contact; with partial slip its springs.
    MindlinPhys.prevU, which Mindlin's law does not use, has the address of the row, negative for a smooth pair, and the
    generation of the rows.
    """
    fields = [("params", "f8", (floats,)), ("phys", "i8"), ("interaction", "i8"), ("pair", "i8"), ("lever", "i8"), *_HISTORY]
    if levels:
        fields += [("bound", "f8", (levels,)), ("stretch", "f8", (levels, 3))]
    if springs:
        fields += [("tangent", "f8", (2, 3)), *[(name, "f8", (springs,)) for name in ("bound", "rest", "onset", "limit")]]
        fields += [("spring", "f8", (2, springs))]
    return np.dtype([*fields, ("hertz", "f8")])


SAVED = [name for name, *_ in _HISTORY]
SAVED += ["lever", "bound", "stretch", "tangent", "rest", "spring"]
"""Fields of a row that are saved with a scene."""


@functools.cache
def saved_dtype(row):
    """dtype of what a scene saves of rows of this dtype."""
    return repack_fields(row[[name for name in row.names if name in SAVED]])


class Context:
    """The record that `kernel.go` reads and writes: `context["open"]`."""

    def __init__(self):
        self.record = np.zeros(1, CONTEXT)
        self.address = self.record.ctypes.data

    def __getitem__(self, name):
        value = self.record[name][0]
        return value if np.ndim(value) == 0 else value[0] if len(value) == 1 else value

    def __setitem__(self, name, value):
        self.record[name][0] = value

    def pop_fault(self, kind, once=False):
        """Numbers of the two bodies of a note, which is cleared, or None; once: it is not made again until `clear_faults`."""
        if self["seen"][kind] != SEEN:
            return None
        self["seen"][kind] = REPORTED if once else UNSEEN
        return tuple(self["bodies"][kind].tolist())

    def clear_faults(self):
        """Clear all notes of native code."""
        self["seen"] = UNSEEN
        self["shapes_stale"] = 1
