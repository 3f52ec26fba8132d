"""Layout of the memory that compiled code and Python share: the context of a law, its records of pairs, rows, histories.

The address of the context is behind the functor's table of virtual functions, so that one piece of machine code, kept on disk
by numba, serves every functor of a law.
"""

import numpy as np

# Words of the context.
GO = 0  # address of the native function that applies the forces
OVERLAP, RADIUS1, RADIUS2 = 1, 2, 3  # offsets in ScGeom [bytes]
KN, KNO, KSO, HISTORY, SPARE = 4, 5, 6, 7, 8  # offsets in MindlinPhys [bytes]
GEOMETRY, GEOMETRY_6D, PHYSICS = 9, 10, 11  # first word of an object of these classes
BODY1, BODY2, BODY_BY_ID, MATERIAL, LABEL = 12, 13, 14, 15, 16
SURFACES, LABEL_HASHES, PAIRS, RECORDS, RECORD_BYTES = 17, 18, 19, 20, 21
RATIO = 22  # tangential over normal stiffness (a double); 0: as YADE's Ip2 functor has it
OPEN = 23  # contacts that have begun and that the law has not seen end
BANKED = 24  # dissipation of contacts that have ended [J] (a double)
ROWS, ROW_WORDS, CAPACITY, GENERATION = 25, 26, 27, 28  # address of the contacts' rows, their size, number, validity
FAULTS, FAULT_KIND, FAULT_BODY1, FAULT_BODY2, FAULT_OVERLAP = 32, 33, 34, 35, 36  # a cache line apart from the above
ROWS_USED = 37
ALARM = 38  # address of the guard's PyRunner.nDone, or 0: a zero written there makes it run before the next step's contacts
FLATS, SHAPE, FACET, WALL, BOX = 40, 41, 42, 43, 44  # FLATS 1: R of a sphere on one of these shapes is the sphere's radius
UNLISTED, UNLISTED_SEEN, UNLISTED_BODY1, UNLISTED_BODY2 = 45, 46, 47, 48  # contacts of materials without a surface
SHEAR_FORCE = 49  # offset of the elastic shear force in MindlinPhys [bytes]
DEEP = 50  # 1 once a contact was beyond SMALL_OVERLAP of its R, 2 once this was reported
DEEP_RADIUS = 51  # R of the last contact that was beyond LARGEST_OVERLAP of it (a double)
CONTEXT_WORDS = 56

WRONG_CLASS, NOT_FINITE, WRONG_CONTACT, TOO_ROUGH, TOO_DEEP, WRONG_MODULUS = 1, 2, 3, 4, 5, 6
"""Kinds of faults."""

# A contact outside YADE's objects: its history as in MindlinPhys, and the law's response.
_CONTACT = ("overlap", "ratio", "tag", "radius", "modulus", "state0", "state1", "state2")
CONTACT = np.dtype([(name, "f8") for name in _CONTACT])
RESPONSE = np.dtype([(name, "f8") for name in ("kno", "kso", "tangent")])
ENERGY = np.dtype([(name, "f8") for name in ("stored", "dissipated")])
STATE_OFFSET = 8 * _CONTACT.index("state0")

# A contact's history in MindlinPhys.momentBend, momentTwist (6 doubles, which Mindlin's law without moments ignores):
# pair number + 1 (0: not seen yet), radius R [m], modulus E* [Pa], then up to three state values of the unloading rule;
# prevU[0] is K_t/K, prevU[1] the number of the contact's row, negative for a smooth pair, prevU[2] the overlap of the last
# step, which ScGeom does not save. Rows are memory of this process,
# so the number carries a generation drawn at random: a row of another process or of a buffer since renewed is not taken.
TAG, RADIUS, MODULUS, STATE = 0, 8, 16, 24

# A row: the addresses of the contact's phys, geom and interaction and of its pair's record, then those numbers of its
# Params that are its own: derived numbers, which cost too much to derive at each step (a law that yields finds its yield
# point by bisection). Rows are made, and so stored, in the order in which YADE visits contacts: the addresses in the row
# after next tell which memory will be needed soon. YADE's objects are scattered, and the processor cannot guess them.
ROW_PHYSICS, ROW_GEOMETRY, ROW_INTERACTION, ROW_RECORD, ROW_OWN = 0, 8, 16, 24, 32
AHEAD = 2  # rows; 1 to 4 are equally fast
LINES_OF_PHYSICS, LINES_OF_GEOMETRY, LINES_OF_INTERACTION = (32, 96, 160, 224, 288, 352), (0, 64, 128, 192), (0, 64)

# A pair's record: smooth (0 or 1), roughness σ, the only R and E* that the law is for (0: any), then the shape.
RECORD_ROUGHNESS, RECORD_RADIUS, RECORD_MODULUS, RECORD_SHAPE = 8, 16, 24, 32


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
        self.words[[FAULTS, UNLISTED_SEEN, DEEP]] = 0
