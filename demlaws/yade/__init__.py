"""The laws inside YADE: `Law2_ScGeom_MindlinPhys_Demlaws`, put where a script has Law2_ScGeom_MindlinPhys_Mindlin.

    from demlaws.yade import Law2_ScGeom_MindlinPhys_Demlaws

Importing this package does not import YADE; asking it for one of its names does. Start scripts with
`demlaws yade run SCRIPT`, or with a Python that sees both YADE and this package.
"""

import importlib

from demlaws.errors import DemlawsError

_HOMES = {
    "Law2_ScGeom_MindlinPhys_Demlaws": "functor",
    "BridgeWarning": "functor",
    "ContactState": "functor",
    "Totals": "functor",
    "attached": "functor",
    "engines": "functor",
    "guard": "functor",
}

__all__ = [*_HOMES]


def public_step(label):
    """Called by a PyRunner of the public way, before the law acts."""
    from demlaws.yade import functor, public

    public.step(functor.attached(label))


def public_finish(label):
    """Called by a PyRunner of the public way, after the law has acted."""
    from demlaws.yade import functor, public

    public.finish(functor.attached(label))


def __getattr__(name):
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    try:
        import yade  # noqa: F401
    except ImportError as error:
        raise DemlawsError(
            f"{name} needs YADE in this Python ({error}): start the script with `demlaws yade run SCRIPT`"
        ) from error
    value = getattr(importlib.import_module(f"{__name__}.{_HOMES[name]}"), name)
    globals()[name] = value
    return value
