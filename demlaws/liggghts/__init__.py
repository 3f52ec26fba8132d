"""The laws inside LIGGGHTS: tables and cases written, the plugin built, checked and run. Importing needs no LIGGGHTS.

import demlaws.liggghts as lg
lg.build()                                          # compile the plugin into the cache (seconds, once)
lg.check()                                          # prove it on this machine
lg.export("case", law="pohrt-popov", grains=[...])  # tables, input, runscript
log = lg.run("case/in.case", ranks=2)               # the stock binary with the plugin
"""

from demlaws.liggghts.build import build, header_folder
from demlaws.liggghts.check import check
from demlaws.liggghts.export import Case, Grain, export, stock_fit
from demlaws.liggghts.run import read_log, run

__all__ = ["Case", "Grain", "build", "check", "export", "header_folder", "read_log", "run", "stock_fit"]
