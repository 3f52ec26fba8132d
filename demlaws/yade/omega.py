"""YADE's engine list with guards: its own property `O.engines`, which `patches` replaces after this module is imported."""

import yade

O = yade.O  # noqa: E741  YADE's name
_engines = yade.wrapper.Omega.engines


def get_engines():
    """The engine list with guards."""
    return list(_engines.__get__(O))


def set_engines(engines):
    """Set the engine list, which includes guards; YADE then updates its variables named by labels."""
    _engines.__set__(O, engines)
