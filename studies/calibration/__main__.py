"""python -m studies.calibration contact|bulk [--samples N] [--iterations N]"""

import argparse
import contextlib
import io
import sys
import time

from demlaws.errors import DemlawsError
from studies.calibration import bayes


def lines(title, posterior):
    """A posterior as text."""
    print(f"{title}: {posterior.iterations} iterations of {posterior.samples} samples")
    for name, unit, truth, mean, deviation in zip(
        bayes.NAMES, ("µm", "GPa"), bayes.TRUTH, posterior.mean, posterior.deviation, strict=True
    ):
        print(f"  {name:10} {mean:7.3f} ± {deviation:.3f} {unit} (truth {truth:g})")


def main(arguments=None):
    """Calibrate from one of the tests."""
    parser = argparse.ArgumentParser(prog="python -m studies.calibration", description=bayes.__doc__.splitlines()[0])
    parser.add_argument("test", choices=("contact", "bulk"))
    parser.add_argument("--samples", type=int, help="per iteration (default: 40 of the contact, 16 of the packing)")
    parser.add_argument("--iterations", type=int, help="at most (default: 10 of the contact, 6 of the packing)")
    options = parser.parse_args(arguments)
    contact = options.test == "contact"
    samples, iterations = options.samples or (40 if contact else 16), options.iterations or (10 if contact else 6)
    started = time.perf_counter()
    try:
        if contact:
            observed, control, model = bayes.contact_test(), bayes.FORCES, bayes.displacements
        else:
            (observed,), packing = bayes.strains([bayes.TRUTH])
            control = bayes.STRESSES

            def model(chosen):
                return bayes.strains(chosen, packing)[0]

        with contextlib.redirect_stdout(io.StringIO()):  # GrainLearning prints every iteration
            posterior = bayes.calibrate(model, observed, control, samples=samples, iterations=iterations)
        lines(f"GrainLearning, {options.test} test", posterior)
        if contact:
            print("dl.fit, the same points")
            for name, unit, scale in zip(bayes.NAMES, ("µm", "GPa"), bayes.UNITS, strict=True):
                estimate = bayes.fitted(observed)[name]
                value, low, high = (v / scale for v in (estimate.value, estimate.low, estimate.high))
                print(f"  {name:10} {value:7.3f} [{low:.3f}, {high:.3f}] {unit} (95 %)")
    except DemlawsError as error:
        print(f"demlaws: error: {error}", file=sys.stderr)
        return 2
    print(f"{time.perf_counter() - started:.0f} s", file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
