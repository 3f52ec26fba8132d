"""The laws inside LAMMPS: the plugin built, checked and run, cases written. Importing needs no LAMMPS and no numba.

import demlaws.lammps as lm
lm.build()                                          # path of the plugin (from the wheel, or compiled into the cache)
lm.check()                                          # prove it on this machine
lm.export("case", law="pohrt-popov", grains=[...])  # tables, input, runscript
log = lm.run("case/in.case", ranks=2)               # the stock binary with the plugin
"""

from demlaws.lazy import load_lazily

_HOMES = {
    "Case": "demlaws.plugins.grains",
    "Grain": "demlaws.plugins.grains",
    "build": "demlaws.lammps.build",
    "check": "demlaws.lammps.check",
    "export": "demlaws.lammps.export",
    "plugin_folder": "demlaws.lammps.build",
    "read_log": "demlaws.lammps.run",
    "run": "demlaws.lammps.run",
    "source": "demlaws.lammps.source",
    "versions": "demlaws.lammps.run",
}
"""Public name → the module that it is loaded from on first use: LAMMPS asks for `plugin_folder` whenever it starts."""

__all__ = list(_HOMES)

load_lazily(__name__, _HOMES)
