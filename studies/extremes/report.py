"""The extremes inside the engines as text, and sentences on what fails."""

import math

from studies.extremes.extremes import DRIFT, PACKINGS
from studies.extremes.stability import EPS, TABLE, decades


def table(rows):
    """The figures as text, one line a case."""
    head = (
        f"{'engine':9}{'law':16}{'unloading':10}{'contact-':>9}{'not':>5}{'error':>9}{'force error (ε)':>20}{'later':>8}"
        f"{'reload':>7}{'broken':>7}{'energy drift':>17}{'momentum':>9}"
    )
    under = (
        f"{'':35}{'steps':>9}{'fin.':>5}{'to law':>9}{'<1e-9 to >1e-3 R':>20}{'(ε)':>8}"
        f"{'(ε)':>7}{'differ':>7}{'soft':>9}{'stiff':>8}{'error':>9}"
    )
    lines = [head, under]
    for r in rows:
        c = r.compared
        drift = [f"{r.packings[name].drift:.0e}" if name in r.packings else "-" for name in PACKINGS]
        bad = c.not_finite + sum(p.not_finite for p in r.packings.values())
        momentum = max((p.momentum for p in r.packings.values()), default=math.nan)
        lines.append(
            f"{r.engine:9}{r.law:16}{r.unloading:10}{r.pairs * r.steps:9d}{bad:5d}{c.to_law:9.1e}"
            f"{decades(c.decades, -9, -3):>20}{c.later:8.3g}{c.reload:7.2g}{c.broken:7d}"
            f"{drift[0]:>9}{drift[1]:>8}{momentum:9.0e}"
        )
    return "\n".join(lines)


def stops_table(engine, found):
    """What stopped an engine, as text: the beginning of each message."""
    lines = []
    for what, message in found:
        message = "not stopped" if message is None else message
        lines.append(f"{engine:9}{what:28}{message if len(message) < 110 else message[:107] + '...'}")
    return "\n".join(lines)


def failures(rows):
    """Failed checks, as sentences."""
    found = []
    for r in rows:
        c, label = r.compared, f"{r.engine}, {r.law}, {r.unloading}"
        if c.not_finite:
            found.append(f"{label}: {c.not_finite} forces are not finite")
        # a table's certificate holds from its first row on; Bahrami's is no exact power law below, at 1e-17 m and less
        allowed = 2.0 * TABLE if r.evaluation == "table" else 100.0 * EPS
        if not c.to_law <= allowed:
            found.append(f"{label}: forces of first loading are up to {c.to_law:.1e} from the law")
        worst = max(c.later, *c.decades.values())
        if not worst <= 1000.0:
            found.append(f"{label}: forces are up to {worst:.1e} ε from what Python computes")
        if not c.reload <= 16.0:
            found.append(f"{label}: the force at the maximum comes back {c.reload:.1e} ε away")
        if c.broken:
            found.append(f"{label}: {c.broken} contacts closed again differ from new ones, or act without touching")
        for name, p in r.packings.items():
            if p.not_finite or not p.drift <= DRIFT:
                found.append(f"{label}, {name} packing: energy changes by {p.drift:.1e}, {p.not_finite} balances not finite")
            if not p.momentum <= 1e-12:
                found.append(f"{label}, {name} packing: momentum changes by {p.momentum:.1e}")
    return found


def stop_failures(engine, found):
    """Faults that did not stop the engine, as sentences. An infinite position takes a particle out of the engine's box."""
    return [f"{engine}: {what} does not stop it" for what, message in found if message is None]
