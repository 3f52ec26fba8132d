"""`python -m studies.shear`: oblique impacts, the closed gas, pictures of shear."""

import csv
import sys
from pathlib import Path

from demlaws import plots
from demlaws.cli import Parser, example, execute
from demlaws.cli.output import picture_file
from studies.shear import figure, gas, memory, springs, vibration
from studies.shear.cyclic import WORDS
from studies.shear.oblique import ANGLE, MEASURED, misfit, table


def parser():
    """The command line."""
    parser = Parser(
        prog="python -m studies.shear",
        description="Tangential restitution of oblique impacts compared with measurements; energy of a closed gas.",
        **example(
            "  python -m studies.shear --figure shear.png\n"
            "  python -m studies.shear --gas liggghts --friction 0.3 1 100 --poisson 0 0.1 0.25 0.4 > gas.csv\n"
            "  python -m studies.shear --summary gas.csv"
        ),
    )
    parser.add_argument("--gas", nargs="+", choices=sorted(gas.STOCK), help="CSV of every law with every rule in these engines")
    parser.add_argument("--summary", nargs="+", metavar="CSV", help="largest energy per engine and model in files of --gas")
    parser.add_argument("--friction", type=float, nargs="+", default=[100.0], help="coefficients, with --gas (default 100)")
    parser.add_argument("--poisson", type=float, nargs="+", default=[0.25], help="Poisson's ratios, with --gas (default 0.25)")
    parser.add_argument("--shear", nargs="+", default=["elastic", "slip"], help="with --gas (default elastic slip)")
    parser.add_argument("--steps", type=int, default=150_000, help="in 30 ms, with --gas (default 150,000)")
    parser.add_argument("--springs", type=int, nargs="+", help="errors of partial slip with these numbers of springs")
    parser.add_argument(
        "--memory", action="store_true", help="shear force kept, and creep, of a contact whose overlap vibrates"
    )
    parser.add_argument(
        "--vibrate", choices=[*vibration.SCENES, *vibration.IN_LIGGGHTS], help="run a scene under a vibrating load, or at rest"
    )
    parser.add_argument(
        "--shaken",
        type=int,
        nargs="+",
        default=[0],
        help="seeds of the places of grains, with --vibrate oedometer or rest (0 to 5)",
    )
    parser.add_argument("--engines", nargs="+", choices=sorted(vibration.OWN), default=["liggghts"], help="with --vibrate")
    parser.add_argument("--models", nargs="+", choices=[*WORDS], default=[*WORDS], help="with --vibrate")
    parser.add_argument("--cycles", type=int, default=300, help="with --vibrate (default 300)")
    parser.add_argument(
        "--out", type=Path, default=Path("vibration.jsonl"), help="rows of --vibrate; it goes on where it stopped"
    )
    parser.add_argument("--figure", type=picture_file, help="picture of loops and of oblique impacts")
    parser.add_argument("--creep", type=picture_file, help="picture of creep under vibration, with the runs of vibration.jsonl")
    parser.add_argument(
        "--neck", type=picture_file, help="picture of a small grain between large ones, with the runs of neck.csv"
    )
    parser.set_defaults(func=run)
    return parser


def run(arguments, _):
    """Print what the arguments ask, by default the oblique impacts."""
    if arguments.gas:
        gas.run_all(arguments.gas, arguments.friction, arguments.poisson, shears=arguments.shear, steps=arguments.steps)
        return
    if arguments.summary:
        print("| engine | shear | laws × rules | runs | refused | largest energy over the start | error of the balance |")
        print("|---|---|---|---|---|---|---|")
        for *counts, largest, balance in gas.summary(arguments.summary):
            print(f"| {' | '.join(map(str, counts))} | {largest:.5f} | {balance:.1e} |")
        return
    if arguments.creep is not None:
        print(plots.save(figure.draw_creep(), arguments.creep))
        return
    if arguments.neck is not None:
        print(plots.save(figure.draw_neck(), arguments.neck))
        return
    if arguments.memory:
        memory.print_table()
        return
    if arguments.vibrate:
        cases = arguments.vibrate, arguments.engines, arguments.models
        vibration.run_all(*cases, cycles=arguments.cycles, shaken=arguments.shaken, out=arguments.out)
        return
    if arguments.springs:
        print_springs(arguments.springs)
        return
    print("angle (degrees)     " + "".join(f"{angle:7.1f}" for angle in ANGLE) + "     rms")
    print("measured            " + "".join(f"{value:7.3f}" for value in MEASURED))
    for model, values in table().items():
        print(f"{model:20s}" + "".join(f"{value:7.3f}" for value in values) + f"{misfit(values):8.3f}")
    if arguments.figure is not None:
        print(plots.save(figure.draw(), arguments.figure))


def print_springs(counts):
    """CSV of a row per law and number of springs; to standard error the loss of Mindlin & Deresiewicz with each number."""
    shares = ", ".join(f"{share:g}" for share in springs.SHARES)
    for count in counts:
        force, losses = springs.mindlin(count)
        lost = ", ".join(f"{100 * loss:+.1f}" for loss in losses)
        print(f"{count} springs, Hertz: force {force:.1e} of μP; loss of a loop at {shares} μP {lost} %", file=sys.stderr)
    kinds, writer = list(springs.paths()), csv.writer(sys.stdout, lineterminator="\n")
    writer.writerow(["law, rule", "springs", *kinds])
    for name, rule in springs.LAWS:
        found = springs.errors(name, rule, counts)
        for place, count in enumerate(counts):
            writer.writerow([f"{name}, {rule}", count, *(f"{found[kind][place]:.1e}" for kind in kinds)])


def main(arguments=None):
    """Run with these arguments (default: the command line's); the exit status."""
    return execute(parser, arguments)


if __name__ == "__main__":
    sys.exit(main())
