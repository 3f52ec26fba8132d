"""The laws inside YADE: `Law2_ScGeom_MindlinPhys_Demlaws`, in place of Law2_ScGeom_MindlinPhys_Mindlin.

    from demlaws.yade import Law2_ScGeom_MindlinPhys_Demlaws

Importing this package does not import YADE; importing one of its names does, and replaces some entry points of YADE
(`patches`), as do `O.engines` and `O.run` of a loaded scene that contains a law. Start scripts with `demlaws yade run SCRIPT`,
or with plain `yade SCRIPT` where this package is installed for YADE's Python.
"""

import functools
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


def watch_loaded():
    """Have `O.engines` and `O.run` install the replacements where the scene contains a law: before that it was loaded."""
    omega = sys.modules["yade"].wrapper.Omega
    engines, run = omega.engines, omega.run
    if hasattr(run, "native"):
        return

    def now(o, name, native):
        if any(tag.startswith("demlaws.") for tag in o.tags.keys()):  # noqa: SIM118  not a dict
            from demlaws.yade import patches

            patches.install()
            return vars(omega)[name]
        return native

    def get(o):
        return now(o, "engines", engines).__get__(o)

    @functools.wraps(run)
    def run_loaded(o, *arguments, **keywords):
        return now(o, "run", run)(o, *arguments, **keywords)

    get.native, run_loaded.native = engines, run
    omega.engines = property(get, lambda o, value: now(o, "engines", engines).__set__(o, value))
    omega.run = run_loaded


if hasattr(sys.modules.get("yade"), "wrapper"):
    watch_loaded()
