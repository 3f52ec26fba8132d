"""Writes the file that `choose` and `modulus` read: kept costs, and the curves of softened packings."""

import json
import statistics

from demlaws.advice.measured_costs import FILE
from demlaws.files import write_atomically
from studies.softening import study
from studies.softening.curves import fitted


def costs(entries) -> dict:
    """Evaluation → ns per contact: of closed forms by law and rule, of tables by rule (the median over laws and sizes)."""
    closed: dict = {}
    tables: dict = {}
    for e in entries:
        if e.evaluation == "closed form":
            closed.setdefault(e.law, {})[e.unloading] = e.ns
        elif e.evaluation == "table":
            tables.setdefault(e.unloading, []).append(e.ns)
    rounded = {law: {rule: float(f"{ns:.3g}") for rule, ns in rules.items()} for law, rules in closed.items()}
    return {"closed form": rounded, "table": {rule: float(f"{statistics.median(ns):.3g}") for rule, ns in tables.items()}}


def keep(entries, path=FILE):
    """Write the file from measured `trade.Entry`s and the kept rows of the softening study; returns its path."""
    content = {"cost": costs(entries), "curves": fitted(study.load())}
    lines = [
        f'"{part}": {{\n' + ",\n".join(f'"{k}": {json.dumps(v)}' for k, v in content[part].items()) + "}" for part in content
    ]
    return write_atomically(path, "{" + ",\n".join(lines) + "}\n")
