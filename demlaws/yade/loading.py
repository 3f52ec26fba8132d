"""Scenes that are loaded before a script has used this package: they get their laws as soon as they are loaded."""

import functools

LAW = "demlaws."
"""How the tags of a scene that describe laws begin."""


def watch():
    """Have the methods of YADE's `O` that load a scene import and install `patches` where the scene contains a law."""
    import yade

    omega = yade.wrapper.Omega
    for name in ("load", "loadTmp", "reload", "stringToScene"):
        native = getattr(omega, name)
        if not hasattr(native, "demlaws"):
            setattr(omega, name, functools.wraps(native)(_loading(native)))


def _loading(native):
    def load(omega, *arguments, **keywords):
        native(omega, *arguments, **keywords)
        if any(tag.startswith(LAW) for tag in omega.tags.keys()):  # noqa: SIM118  not a dict
            from demlaws.yade import patches

            patches.install()

    load.demlaws = True
    return load
