"""The laws inside LAMMPS: the plugin built, checked and run, cases written. Importing needs no LAMMPS and no numba.

import demlaws.lammps as lm
lm.build()                                          # path of the plugin (from the wheel, or compiled into the cache)
lm.check()                                          # prove it on this machine
lm.export("case", law="pohrt-popov", grains=[...])  # tables, input, runscript
log = lm.run("case/in.case", ranks=2)               # the stock binary with the plugin
"""

import importlib
import sys
import types

_HOMES = {
    "build": "build",
    "check": "check",
    "export": "export",
    "plugin_folder": "build",
    "read_log": "run",
    "run": "run",
    "versions": "run",
}
"""Public name → the module that it is loaded from on first use: LAMMPS asks for `plugin_folder` whenever it starts."""

__all__ = list(_HOMES)


class _Package(types.ModuleType):
    """The package with its public names; import would set the sub-modules `build`, `run` … over the functions."""

    def __getattr__(self, name):
        if name not in _HOMES:
            raise AttributeError(f"module {self.__name__!r} has no attribute {name!r}")
        return getattr(importlib.import_module(f"{self.__name__}.{_HOMES[name]}"), name)

    def __setattr__(self, name, value):
        if name not in _HOMES or not isinstance(value, types.ModuleType):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package
