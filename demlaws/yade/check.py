"""`demlaws yade check`, run under YADE: versions, what the bridge finds, a self-test of every law and unloading rule."""

import platform
import time

from demlaws.laws.names import HERTZ, USUAL

QUICK = ((HERTZ, "elastic"), (USUAL, "hertz"))


def main(quick=False):
    """Print versions, the bridge, and a self-test of each law; exit status 1 without the bridge."""
    started = time.perf_counter()
    import numba
    import numpy
    import yade
    import yade.config

    import demlaws as dl

    print(f"demlaws {dl.__version__}, YADE {yade.config.version}, Python {platform.python_version()}", end=", ")
    print(f"numba {numba.__version__}, numpy {numpy.__version__}, {platform.machine()}, {yade.O.numThreads} thread(s)")
    from demlaws.yade import native

    try:
        layout = native.layout()
    except native.BridgeUnavailable as error:
        print(f"native bridge: not available: {error}")
        print("scripts run by the public-API way, at some ten times the cost")
        return 1
    offset, index, _ = layout.slot
    print(f"native bridge: available; go is entry {index} of the table that the functor holds at byte {offset}")
    if layout.untested:
        print(layout.untested)
    if not quick:
        print(
            "every law and rule is tested now: seconds if this machine has compiled them before, else several minutes",
            flush=True,
        )
    failures = self_tests(dl, QUICK if quick else None)
    print(f"{'all self-tests passed' if not failures else f'{failures} self-tests FAILED'}", end=" ")
    print(f"in {time.perf_counter() - started:.1f} s (a law's first use on a machine compiles, later ones read the cache)")
    return 1 if failures else 0


def self_tests(dl, chosen=None):
    """Print a self-test of each law and rule, or of the chosen ones; the number of failures."""
    from demlaws.core.unloading import GIVEN
    from demlaws.laws.registry import find
    from demlaws.make import example
    from demlaws.yade import selftest
    from demlaws.yade.binding import Binding
    from demlaws.yade.pairs import Pairs, Span

    surfaces = {"granite": dl.Surface(roughness=2.4e-6, fractal_dimension=2.22, hardness=6.266e9)}
    print(f"{'law':18}{'unloading':11}{'steps':>6}{'|F - F_law|/F_max':>20}{'ready in':>10}")
    contact = dl.Contact(4.35e-3, 32.32e9, 2.4e-6 * 2**0.5, 2.22, 6.266e9)
    spans = {("granite", "granite"): Span((4.35e-3, 4.35e-3), (32.32e9, 32.32e9))}
    failures = 0
    for name, rule in chosen or [(law, rule) for law in dl.laws() for rule in find(law).offered()]:
        started = time.perf_counter()
        try:
            given, options, unloading = name, find(name).example, rule
            if rule == GIVEN:
                given, options, unloading = example(name, contact, rule), {}, None
            binding = Binding("check", Pairs(given, surfaces, unloading, options, spans), None, "native")
        except dl.DemlawsError as error:
            print(f"{name:18}{rule:11}  not joined: {str(error).split(': ', 1)[-1][:90]}")
            continue
        try:
            steps, error = selftest.run(binding)
        except dl.DemlawsError as error:
            failures += 1
            print(f"{name:18}{rule:11}  FAILED: {error}")
            continue
        print(f"{name:18}{rule:11}{steps:6d}{error:20.1e}{time.perf_counter() - started:8.2f} s", flush=True)
    return failures


if __name__ == "__main__":
    import os
    import sys

    status = main("--quick" in sys.argv)
    sys.stdout.flush()
    os._exit(status)  # YADE's own exit would lose the status
