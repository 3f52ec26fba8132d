"""YADE's own entry points as they were before `patches` put anything of ours there: this module is imported before it."""

import yade

O = yade.O  # noqa: E741  YADE's name
engines = yade.wrapper.Omega.engines
functors = yade.LawDispatcher.functors


def get_engines():
    """The engine list as YADE has it, with what is hidden from users."""
    return list(engines.__get__(O))


def set_engines(wanted):
    """Give YADE an engine list as it is."""
    engines.__set__(O, wanted)
