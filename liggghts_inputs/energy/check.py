"""Energy balance of the bounces, and the same energies after a restart."""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent))
import common

from demlaws.liggghts import read_log

WALLS = ("primitive", "mesh")


def check(folder, unloading="hertz"):
    findings = []
    for wall in WALLS:
        log, again = (read_log(Path(folder) / f"log.{wall}{name}") for name in ("", ".again"))
        touching = (log["overlap"] > 0).astype(int)
        bounces = int((np.diff(touching) > 0).sum())
        begin = np.argmax(touching)
        place = log["place"][begin : begin + np.argmin(touching[begin:])]
        total = log["KinEng"] + log["height"] + log["stored"] + log["lost"]
        scale = log["stored"].max()
        print(f"{wall} wall: {bounces} bounces, stored up to {scale:.3g} J, plastic flow took {log['lost'][-1]:.3g} J")
        findings += [
            (f"{wall} wall: plastic flow took nothing", float(unloading != "elastic" and not log["lost"][-1] > 0.1 * scale), 0),
            (f"{wall} wall: bounces missing of 2", max(0, 2 - bounces), 0),
            (f"{wall} wall: first contact does not pass x = 0", float(not place.min() < 0 < place.max()), 0),
            (f"{wall} wall: kinetic + height + stored + dissipated, drift, of the largest stored", np.ptp(total) / scale, 1e-5),
            (f"{wall} wall: dissipation that went backwards", max(0.0, -np.diff(log["lost"]).min()) / scale, 1e-12),
        ]
        same = np.isin(log["Step"], again["Step"])
        findings.append((f"{wall} wall: rows missing in the restarted run", float(again["Step"].size - same.sum()), 0))
        for name in ("stored", "lost", "KinEng"):
            error = np.abs(log[name][same] - again[name]).max() / scale
            findings.append(
                (f"{wall} wall: {name} of the restarted run against the continued, of the largest stored", error, 1e-9)
            )
    return findings


if __name__ == "__main__":
    common.check_main(__file__, check)
