"""The laws inside YADE: `Law2_ScGeom_MindlinPhys_Demlaws`, in place of Law2_ScGeom_MindlinPhys_Mindlin.

    from demlaws.yade import Law2_ScGeom_MindlinPhys_Demlaws

Importing this package does not import YADE; importing one of its names does. In a YADE process it replaces some entry points
of YADE (`patches`). Start scripts with `demlaws yade run SCRIPT`, which imports it (a script that loads a saved scene may not),
or with plain `yade SCRIPT` where this package is installed for YADE's Python.
"""

import importlib
import sys

from demlaws.errors import BridgeWarning, DemlawsError, ShapeWarning, TimeStepWarning

_HOMES = {
    "Law2_ScGeom_MindlinPhys_Demlaws": "functor",
    "Curvature": "radii",
    "Totals": "contacts",
    "attached": "scene",
    "engines": "scene",
    "guard": "scene",
}

__all__ = ["BridgeWarning", "ShapeWarning", "TimeStepWarning", *_HOMES]


def __getattr__(name):
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    try:
        import yade  # noqa: F401
    except ImportError as error:
        raise DemlawsError(
            f"{name} needs YADE in this Python ({error}): start the script with `demlaws yade run SCRIPT`"
        ) from error
    from demlaws.yade import patches

    patches.install()
    value = getattr(importlib.import_module(f"{__name__}.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


if hasattr(sys.modules.get("yade"), "wrapper"):
    from demlaws.yade import patches

    patches.install()
