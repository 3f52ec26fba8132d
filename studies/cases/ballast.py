"""Settlement of the bed of `ballast` with the cycles."""

import numpy as np

from studies.cases import defaults, prepared, run_input

QUICK = {"half": 0.08, "mean": 500, "amplitude": 400, "gain": 6e-3, "cycles": 160000}
SIZE = {"liggghts": {"height": 0.5, "count": 100}, "lammps": {"height": 0.56}}
"""A bed of 100 grains and four cycles."""


class Cycles:
    """A run: the log, its rows in the cycles, and at the end of each cycle settlement [m] and dissipated energy [J]."""

    def __init__(self, engine, folder, ranks=1, quick=False):
        script = prepared(engine, "ballast", folder) / "in.ballast"
        given = QUICK | SIZE[engine] if quick else {}
        self.log = log = run_input(engine, script, ranks, given)
        times = {name: int(value) for name, value in defaults(script).items() if name in ("settle", "press", "period")}
        step = log["Step"] - times["settle"] - times["press"]
        self.ends = ends = (step >= 0) & (step % times["period"] == 0)
        self.begun, self.cyclic = step >= 0, step > 0
        self.settlement = log["plate"][ends][0] - log["plate"][ends]
        self.dissipated = log["lost"][ends] - log["lost"][ends][0]

    def error(self):
        """Deviation of the load on the plate from the prescribed load, of the largest load."""
        return np.abs(self.log["carried"] - self.log["load"])[self.cyclic] / self.log["load"].max()

    def table(self):
        """The lines of the table."""
        height, load, count = self.log["bed"][0], self.log["load"], self.settlement.size - 1
        yield f"bed {height * 1e3:.0f} mm high under {load[self.cyclic].min():.0f} to {load.max():.0f} N"
        yield f"load: deviation {np.median(self.error()):.2%} (median), {np.quantile(self.error(), 0.95):.2%} (95 of 100 rows)"
        yield f"{'cycle':>6} {'settlement mm':>14} {'strain %':>9} {'dissipated J':>13}"
        for n in sorted({n for n in (1, 2, 3, 5, 10, 15, 20, count) if n <= count}):
            settled = self.settlement[n]
            yield f"{n:6d} {settled * 1e3:14.4f} {settled / height * 100:9.4f} {self.dissipated[n]:13.5f}"

    def rows(self):
        """Head and rows of the curve in the cycles; at the end of a cycle also its number."""
        yield "displacement (m)", "load (N)", "cycle"
        first = self.log["plate"][self.begun][0]
        numbers = np.where(self.ends, np.cumsum(self.ends) - 1, -1)[self.begun]
        for place, load, number in zip(self.log["plate"][self.begun], self.log["carried"][self.begun], numbers, strict=True):
            yield f"{first - place:.6g}", f"{load:.5g}", number if number >= 0 else ""
