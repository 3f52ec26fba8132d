"""YADE's engine list with guards: its own property `O.engines`, which `patches` replaces after this module is imported; and
scenes of our own beside the user's."""

import contextlib

import yade

from demlaws.errors import DemlawsError

O = yade.O  # noqa: E741  YADE's name
_engines = yade.wrapper.Omega.engines


def get_engines():
    """The engine list with guards."""
    return list(_engines.__get__(O))


def set_engines(engines):
    """Set the engine list, which includes guards; YADE then updates its variables named by labels."""
    _engines.__set__(O, engines)


@contextlib.contextmanager
def scratch_scene():
    """An empty scene beside the user's, which is left as it is."""
    home = O.thisScene
    scratch = O.addScene()  # a new one each time: O.reset() drops them, and switching to a dropped one does nothing
    O.switchToScene(scratch)
    if O.thisScene != scratch or scratch == home or len(O.bodies) or get_engines():
        O.switchToScene(home)
        raise DemlawsError("YADE gave no scene of its own to a test")
    try:
        yield
    finally:
        O.resetThisScene()
        O.switchToScene(home)
