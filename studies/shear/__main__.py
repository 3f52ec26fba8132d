"""`python -m studies.shear`: oblique impacts, the closed gas, pictures of shear."""

import sys

from tqdm import tqdm

from demlaws import plots
from demlaws.cli import Parser, example, execute
from demlaws.cli.arguments import output
from demlaws.errors import DemlawsError
from demlaws.laws.registry import registry
from demlaws.make import example as example_law
from studies.shear import figure, gas, paths
from studies.shear.oblique import ANGLE, MEASURED, misfit, table

STOCK = {"liggghts": ("history",), "lammps": ("mindlin", "mindlin_rescale", "mindlin_rescale/force")}
OURS = {"liggghts": "demlaws", "lammps": "mindlin_rescale/force"}


def parser():
    """The command line."""
    parser = Parser(
        prog="python -m studies.shear",
        description="Tangential restitution of oblique impacts compared with measurements; energy of a closed gas.",
        **example(
            "  python -m studies.shear --figure shear.png\n"
            "  python -m studies.shear --paths 1000\n"
            "  python -m studies.shear --gas liggghts --friction 0.3 1 100 --poisson 0 0.1 0.25 0.4"
        ),
    )
    parser.add_argument("--gas", choices=sorted(STOCK), help="every law with every rule in this engine, some seconds per run")
    parser.add_argument("--friction", type=float, nargs="+", default=[100.0], help="coefficients, with --gas (default 100)")
    parser.add_argument("--poisson", type=float, nargs="+", default=[0.25], help="Poisson's ratios, with --gas (default 0.25)")
    parser.add_argument("--shear", nargs="+", default=["elastic", "slip"], help="with --gas (default elastic slip)")
    parser.add_argument("--paths", type=int, help="so many random paths of every law, rule and choice: work returned")
    parser.add_argument("--figure", type=output, help="picture of loops and of oblique impacts")
    parser.set_defaults(func=run)
    return parser


def run(arguments):
    """Print what the arguments ask, by default the oblique impacts."""
    if arguments.gas:
        print_gas(arguments)
        return
    if arguments.paths:
        print_paths(arguments.paths)
        return
    print("angle (degrees)     " + "".join(f"{angle:7.1f}" for angle in ANGLE) + "     rms")
    print("measured            " + "".join(f"{value:7.3f}" for value in MEASURED))
    for model, values in table().items():
        print(f"{model:20s}" + "".join(f"{value:7.3f}" for value in values) + f"{misfit(values):8.3f}")
    if arguments.figure is not None:
        print(plots.save(figure.draw(), arguments.figure))


def cases():
    """(law, rule) pairs that are accepted, with the law."""
    for name, definition in registry().items():
        for rule in definition.offered():
            try:
                yield name, rule, example_law(name, gas.CONTACT, rule)
            except DemlawsError:
                continue


def print_paths(count):
    """A row per law and rule: the largest work returned in a step and the largest excess over Coulomb's limit."""
    print(f"{count} paths: largest fall of the dissipated energy over the work, largest excess over Coulomb's limit")
    for name, rule, law in tqdm(list(cases()), disable=not sys.stderr.isatty()):
        for shear in ("elastic", "loading", "slip"):
            result = paths.worst(law, shear, count)
            print(f"{name}, {rule}, {shear}: {result.returned:.1e}, {result.excess:.1e}", flush=True)


def print_gas(arguments):
    """A row per run: largest gain of energy over the start, energy at the end, error of the balance."""
    engine = arguments.gas
    print("law, rule, tangential, friction, Poisson: largest gain, energy at the end, end of the balance")
    for friction in arguments.friction:
        for poisson in arguments.poisson:
            for tangential in STOCK[engine]:
                result = gas.simulate(engine, None, tangential, friction, poisson)
                print(
                    f"stock hertz, {tangential}, {friction:g}, {poisson:g}: {result.gain:.4f}, {result.kept[-1]:.4f}",
                    flush=True,
                )
            for name, rule, law in tqdm(list(cases()), disable=not sys.stderr.isatty()):
                for shear in arguments.shear:
                    label = f"{name}, {rule}, {OURS[engine]} {shear}, {friction:g}, {poisson:g}"
                    try:
                        result = gas.simulate(engine, law, OURS[engine], friction, poisson, f"shear {shear}")
                    except DemlawsError as error:
                        print(f"{label}: refused: {error}", flush=True)
                        continue
                    print(f"{label}: {result.gain:.4f}, {result.kept[-1]:.4f}, {result.balance[-1]:.5f}", flush=True)


def main(arguments=None):
    """Run with these arguments (default: the command line's); the exit status."""
    return execute(parser, arguments)


if __name__ == "__main__":
    sys.exit(main())
