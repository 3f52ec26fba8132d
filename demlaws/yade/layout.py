"""Layout of the memory that compiled code and Python share: the context of a law, its records of pairs, rows, histories.

The address of the context is behind the functor's table of virtual functions, so that one piece of machine code, kept on disk
by numba, serves every functor of a law.
"""

import numpy as np

# Words of the context.
GO = 0  # address of the native function that applies the forces
OVERLAP, RADIUS1, RADIUS2 = 1, 2, 3  # offsets in ScGeom [bytes]
KN, KNO, KSO, MARK = 4, 5, 6, 7  # offsets in MindlinPhys [bytes]; MARK: of prevU[1], the contact's row
GEOMETRY, GEOMETRY_6D, PHYSICS = 9, 10, 11  # addresses of tables of virtual functions with which objects of these classes begin
BODY1, BODY2, BODY_BY_ID, MATERIAL, LABEL = 12, 13, 14, 15, 16
SURFACES, LABEL_HASHES, PAIRS, RECORDS, RECORD_BYTES = 17, 18, 19, 20, 21
OPEN = 23  # contacts that have begun and that the law has not seen end
BANKED = 24  # dissipation of contacts that have ended [J] (a double)
ROWS, ROW_WORDS, CAPACITY, GENERATION = 25, 26, 27, 28  # address of the contacts' rows, their size, number, mark
FREE, FREE_COUNT, FREE_TAKEN = 29, 30, 31  # address of the numbers of rows that may be used again, count, number taken
FAULTS, FAULT_KIND, FAULT_BODY1, FAULT_BODY2, FAULT_OVERLAP = 32, 33, 34, 35, 36  # a cache line apart from the above
ROWS_USED = 37
ALARM = 38  # address of the guard's PyRunner.nDone, or 0: a zero written there makes it run before the next step's contacts
FLATS, SHAPE, FACET, WALL, BOX = 40, 41, 42, 43, 44  # FLATS 1: R of a sphere on one of these shapes is the sphere's radius
UNLISTED, UNLISTED_SEEN, UNLISTED_BODY1, UNLISTED_BODY2 = 45, 46, 47, 48  # contacts of materials without a surface
SHEAR_FORCE = 49  # offset of the elastic shear force in MindlinPhys [bytes]
DEEP = 50  # 1 once a contact was beyond SMALL_OVERLAP of its R, 2 once this was reported
DEEP_RADIUS = 51  # R of the last contact that was beyond LARGEST_OVERLAP of it (a double)
FRICTION, NORMAL_FORCE = 52, 53  # offsets of the coefficient of friction and the normal force in MindlinPhys [bytes]
BANKED_SHEAR = 54  # energy of shear that contacts which have ended have lost [J] (a double)
DISPLACEMENT, STRETCH = 55, 56  # offsets of usTotal and usElastic in MindlinPhys [bytes]
NORMAL = 57  # offset of the normal in ScGeom [bytes]
INCREMENT = 58  # offset of shearInc in ScGeom [bytes]
ROTATE = 59  # address of ScGeom::rotate
SPRINGS, SPRING_COUNT = 60, 61  # offset in a row of the springs of partial slip [bytes], their number
# R of contacts whose shapes are not spheres, flats or grids (see `curvature` and `radii`)
RADIUS_MODE, EDGES, SHAPES, SHAPE_COUNT, SHAPES_STALE, LARGEST_RADIUS = 62, 63, 64, 65, 66, 67
BODY_STATE, POSITION, ORIENTATION, POINT = 68, 69, 70, 71  # offsets in Body, State and ScGeom [bytes]
ODD_SEEN, ODD_BODY1, ODD_BODY2 = 90, 91, 92  # a contact with R of a body of another shape; 2: reported
SHARED, SHARED_BODY1, SHARED_BODY2 = 95, 96, 97  # a contact with the physics of another one; 2: reported
NEW_CONTACTS = 93  # 1: contacts have begun whose R a Python function gives
GAP_RADIUS = 94  # address of `curvature.gap_radius`
ROUND_SHAPES = 119  # first words of objects of shapes with a radius of their own, 0 behind the last
BETAS = 98  # offset in MindlinPhys [bytes]
# A contact step without the native function (`shear.step_alone`).
ALONE = 100  # 1: where possible, 0: never
APPLY = 101  # address of LawFunctor::applyForceAtContactPoint
FUNCTOR = 102  # bytes from the start of the functor to `this`
SCENE, OPTIONS = 103, 104  # bytes from `this` to the pointer to the scene, and to four options of one byte
PERIODIC = 105  # offset of isPeriodic in Scene [bytes]
KS, SHEAR_SUM, SHEAR_VISCOUS, SLIDING = 106, 107, 108, 109  # offsets in MindlinPhys [bytes]
BETAN, DAMPING_KIND = 110, 111  # the same; DAMPING_KIND: of alpha or beta where MindlinPhys has one, else BETAN
PHYSICS_CAPILLARY = 75  # the same of MindlinCapillaryPhys, or of MindlinPhys where YADE has no such class
GEOMETRIES = 76  # first words of objects of further classes of geometry, 0 behind the last
CONTEXT_WORDS = 128

WRONG_CLASS, NOT_FINITE, WRONG_CONTACT, TOO_ROUGH, TOO_DEEP, WRONG_MODULUS, NO_ROW, LOST_ROW, UNGUARDED = range(1, 10)
FLAT_GAP, NO_CURVATURE = 20, 21
"""Kinds of faults."""

BODY_RADIUS, BODY_RADIUS_MEANT, CURVATURE_RADIUS, FUNCTION_RADIUS = 0, 1, 2, 3
"""Values of RADIUS_MODE."""

# A row of a law's memory: the addresses of the contact's phys and interaction and of its pair's record; its history; the
# numbers of its Params that are its own (derived numbers, which cost too much to derive at each step: a law that yields finds
# its yield point by bisection); with partial slip, its springs. MindlinPhys.prevU[1], which Mindlin's law does not use, is the
# number of the contact's row, negative for a smooth pair. It carries a number drawn at random: a row of another process is not
# taken.
ROW_PHYSICS, ROW_INTERACTION, ROW_RECORD, ROW_HISTORY = 0, 8, 16, 24

# A contact's history: overlap of the last step [m], K_t/K, pair number + 1 (0: no contact), R [m], E* [Pa], up to three state
# values of the unloading rule; K_t of the last step [N/m], the energy of shear that it stores and that it has lost [J].
_CONTACT = ("overlap", "ratio", "tag", "radius", "modulus", "state0", "state1", "state2", "shear", "held", "lost")
CONTACT = np.dtype([(name, "f8") for name in _CONTACT])
RESPONSE = np.dtype([(name, "f8") for name in ("kno", "kso", "tangent", "force")])
ENERGY = np.dtype([(name, "f8") for name in ("stored", "dissipated")])
STATE_OFFSET = 8 * _CONTACT.index("state0")
OF_ROW = {name: ROW_HISTORY + 8 * n for n, name in enumerate(_CONTACT)}
LAST, RATIO_OF_ROW, TAG, RADIUS, MODULUS, STATE = (
    OF_ROW[name] for name in ("overlap", "ratio", "tag", "radius", "modulus", "state0")
)
SHEAR_STIFFNESS, SHEAR_HELD, SHEAR_LOST = (OF_ROW[name] for name in ("shear", "held", "lost"))
ROW_OWN = ROW_HISTORY + CONTACT.itemsize

# A pair's record: smooth (0 or 1), roughness σ, the only R and E* that the law is for (0: any), then the shape.
RECORD_ROUGHNESS, RECORD_RADIUS, RECORD_MODULUS, RECORD_SHAPE = 8, 16, 24, 32

PLANE, SPHERE, FIELD = 1, 2, 3
"""Kinds of shapes with a curvature."""
_SHAPE = ("shape", "kind", "index", "tensors", "n0", "n1", "n2", "low0", "low1", "low2", "size")
SHAPE_RECORD = np.dtype([(name, "f8" if name[:-1] == "low" or name == "size" else "i8") for name in _SHAPE])
"""A body's shape. size: spacing of the grid of a level set, radius of a sphere [m]."""
OF_SHAPE = {name: 8 * n for n, name in enumerate(_SHAPE)}


def label_hash(label):
    """FNV-1a of a material's label, as a signed 64-bit integer: `kernel.surface_of` compares it."""
    value = 0xCBF29CE484222325
    for byte in label.encode():
        value = (value ^ byte) * 0x100000001B3 % 2**64
    return value - 2**64 if value >= 2**63 else value


class Context:
    """The words that `kernel.act` reads and writes, for Python."""

    def __init__(self):
        self.words = np.zeros(CONTEXT_WORDS, np.int64)
        self.doubles = self.words.view(np.float64)
        self.address = self.words.ctypes.data

    def take_fault(self):
        """The last fault of native code as (kind, body, body, overlap [m]), or None; it is cleared."""
        if not self.words[FAULTS]:
            return None
        self.words[FAULTS] = 0
        return *self.words[FAULT_KIND:FAULT_OVERLAP].tolist(), float(self.doubles[FAULT_OVERLAP])

    def take_deep(self):
        """Whether a contact has gone beyond SMALL_OVERLAP of its R since `forget`: true once."""
        if self.words[DEEP] != 1:
            return False
        self.words[DEEP] = 2
        return True

    def take_unlisted(self):
        """Bodies of a contact of materials without a surface that has not been judged yet, or None; it is cleared."""
        if not self.words[UNLISTED_SEEN]:
            return None
        self.words[UNLISTED_SEEN] = 0
        return tuple(self.words[UNLISTED_BODY1 : UNLISTED_BODY2 + 1].tolist())

    def forget(self):
        """Clear all notes of native code."""
        self.words[[FAULTS, UNLISTED_SEEN, DEEP, ODD_SEEN, SHARED]] = 0
        self.words[[SHAPES_STALE, NEW_CONTACTS]] = 1
