"""The laws inside LIGGGHTS: tables and cases written, the plugin built, checked, run. Importing needs no LIGGGHTS, no numba.

import demlaws.liggghts as lg
lg.build()                                          # compile the plugin into the cache (half a minute, once)
lg.check()                                          # prove it on this machine
lg.export("case", law="pohrt-popov", grains=[...])  # tables, input, runscript
log = lg.run("case/in.case", ranks=2)               # the stock binary with the plugin
"""

from demlaws.lazy import load_lazily

_HOMES = {
    "Case": "demlaws.plugins.grains",
    "Grain": "demlaws.plugins.grains",
    "build": "demlaws.liggghts.build",
    "check": "demlaws.liggghts.check",
    "export": "demlaws.liggghts.export",
    "header_folder": "demlaws.liggghts.build",
    "read_log": "demlaws.liggghts.run",
    "run": "demlaws.liggghts.run",
    "source": "demlaws.liggghts.source",
    "stock_fit": "demlaws.liggghts.export",
}
"""Public name → the module that it is loaded from on first use: the plugin is built without numba."""

__all__ = list(_HOMES)

load_lazily(__name__, _HOMES)
