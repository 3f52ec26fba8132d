"""`demlaws yade check`, run under YADE: versions, processor, what the bridge finds, self-tests of laws and rules."""

import time

from demlaws.laws import HERTZ, USUAL


def chosen_pairs(words):
    """(law, rule) to test: two with --quick, all with --all, else every law with its default rule and every other rule with one
    law; each is a compilation of seconds."""
    from demlaws.laws.registry import registry

    offered = [(name, rule) for name, definition in registry().items() for rule in definition.offered()]
    if "--quick" in words:
        return [(HERTZ, "elastic"), (USUAL, "hertz")]
    if "--all" in words:
        return offered
    pairs = [(name, definition.default_rule()) for name, definition in registry().items()]
    for name, rule in sorted(offered, key=lambda pair: pair[0] != USUAL):
        if rule not in [tested for _, tested in pairs]:
            pairs.append((name, rule))
    return pairs


def main(words):
    """Print versions, the bridge, and self-tests of laws and rules; exit status 1 without the bridge."""
    start = time.perf_counter()
    import yade

    import demlaws as dl
    from demlaws.yade import native
    from demlaws.yade.reports import unavailable_text, versions

    print(f"demlaws {dl.__version__}, {versions()}, {yade.O.numThreads} thread(s)")
    try:
        layout = native.find_layout()
    except native.BridgeUnavailable as error:
        print(f"native bridge: not available: {unavailable_text(error)}")
        return 1
    offset, index, _ = layout.slot
    print(f"native bridge: available; go is entry {index} of the table that the functor holds at byte {offset}")
    pairs = chosen_pairs(words)
    print(f"{len(pairs)} laws with rules are tested, about 3 s each if this machine has not compiled them before", flush=True)
    failures = self_tests(dl, pairs)
    print(f"{'all self-tests passed' if not failures else f'{failures} self-tests FAILED'}", end=" ")
    print(f"in {time.perf_counter() - start:.1f} s (a law's first use on a machine compiles, later ones read the cache)")
    return 1 if failures else 0


def self_tests(dl, pairs):
    """Print a self-test of each (law, rule); the number of failures."""
    from demlaws.errors import NotPassive
    from demlaws.make import example_law
    from demlaws.yade import selftest
    from demlaws.yade.binding import Binding
    from demlaws.yade.pairs import Pairs

    surfaces = {"granite": dl.Surface(roughness=2.4e-6, fractal_dimension=2.22, hardness=6.266e9)}
    print(f"{'law':18}{'unloading':11}{'steps':>6}{'|F - F_law|/F_max':>20}{'ready in':>10}")
    contact = dl.Contact(4.35e-3, 32.32e9, 2.4e-6 * 2**0.5, 2.22, 6.266e9)
    failures = 0
    for name, rule in pairs:
        start = time.perf_counter()
        try:
            binding = Binding("check", Pairs(example_law(name, contact, rule), surfaces, None, {}))
            steps, error = selftest.run(binding)
        except NotPassive as error:
            print(f"{name:18}{rule:11}  not joined: {str(error).split(': ', 1)[-1][:90]}")
            continue
        except dl.DemlawsError as error:
            failures += 1
            print(f"{name:18}{rule:11}  FAILED: {error}")
            continue
        print(f"{name:18}{rule:11}{steps:6d}{error:20.1e}{time.perf_counter() - start:8.2f} s", flush=True)
    return failures


if __name__ == "__main__":
    import os
    import sys

    from demlaws.laws.registry import load_laws

    for word in sys.argv[1:]:
        if word.startswith("--law-file="):
            load_laws(word.partition("=")[2])
    status = main(sys.argv[1:])
    sys.stdout.flush()
    os._exit(status)  # YADE's own exit would lose the status
