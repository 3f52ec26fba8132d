"""YADE's C++ objects as records: dtypes with the offsets that `native.Layout` finds and proves when it is made.

Compiled code takes them from here when it is compiled, and `identity` is part of the key of machine code on disk.
"""

from demlaws.yade.records import record

VECTOR = ("f8", (3,))
AXES = ("orthonormal_axis", "twist_axis")
"""Members of ScGeom by which vectors turn with the contact: the change of its normal, and the turn about it."""
ScGeom = MindlinPhys = MindlinPhysCDM = Interaction = Body = State = Material = Functor = Scene = Cell = None


def define(**fields):
    """Set the dtypes: name of a class → {field: (format, offset)}."""
    globals().update({name: record(places) for name, places in fields.items()})


def identity():
    """Text that changes with any of the dtypes."""
    return repr((ScGeom, MindlinPhys, MindlinPhysCDM, Interaction, Body, State, Material, Functor, Scene, Cell))
