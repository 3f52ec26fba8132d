"""`python -m studies.trade`: cost against error."""

import sys
from dataclasses import replace
from pathlib import Path

from tqdm import tqdm

from demlaws import units
from demlaws.cli import Parser, example, execute
from demlaws.cli.arguments import pressure, whole
from demlaws.errors import DemlawsError
from demlaws.files import csv_text
from demlaws.laws.registry import find
from studies.softening import results, study
from studies.trade import candidates, packings, trade
from studies.trade.candidates import ENGINES, NAMES
from studies.trade.keep import keep

YIELDING = 5e6
"""Stress [Pa] at which leaving yield out shows in a packing of granite."""


def parser():
    """The command line."""
    parser = Parser(
        prog="python -m studies.trade",
        description="Measures, in one run, ns per contact and errors in force, stiffness, energy and rebound of every law × "
        "unloading × evaluation; marks the Pareto front. With --scene the errors of a whole packing; with --softening those of "
        "softer grains, faster loading and longer steps against their number of steps.",
        **example(
            "  python -m studies.trade --scene yade liggghts lammps\n"
            "  python -m studies.trade --softening                               (the kept rows)\n"
            "  python -m studies.trade --softening rows.jsonl --quick            (missing rows, in YADE)\n"
            "  python -m studies.trade --law hertz --law pohrt-popov"
        ),
    )
    parser.add_argument("--law", action="append", help="only this law (may be repeated)")
    parser.add_argument("--contacts", type=whole(1000), default=200_000, help="contacts of a batch (default 2e5)")
    parser.add_argument("--rounds", type=whole(), default=9, help="rounds of timing (default 9)")
    parser.add_argument(
        "--scene",
        nargs="+",
        choices=ENGINES,
        metavar="ENGINE",
        help="only this: 1,000 spheres settle and are compressed under each law in yade, liggghts or lammps, or in several",
    )
    parser.add_argument(
        "--softening",
        nargs="?",
        const="",
        metavar="FILE",
        help="only this: grains softer by 1 to 1000, with σ scaled and not, faster, in other steps; with FILE the study is run "
        "in YADE, hours, and goes on from the rows that FILE holds; without, kept rows are shown",
    )
    parser.add_argument(
        "--stress",
        type=pressure,
        default=YIELDING,
        help="stress that --scene compresses to (default 5 MPa, where contacts yield; at 500kPa roughness alone matters)",
    )
    parser.add_argument("--quick", action="store_true", help="150 spheres in the scene, fewer runs of softening")
    parser.add_argument(
        "--keep", action="store_true", help="write what demlaws choose reads: these costs, the kept study's curves"
    )
    parser.set_defaults(func=run)
    return parser


def _progress(things):
    return tqdm(things, desc="trade", leave=False, disable=None)


def run(arguments, _):
    """Do what the command's arguments ask."""
    if arguments.scene:
        return _scenes(arguments)
    if arguments.softening is not None:
        return _softening(arguments)
    laws = [find(n).name for n in arguments.law] if arguments.law else None
    if laws and arguments.keep:
        raise DemlawsError("--keep writes the costs of all laws: leave out --law")
    entries, floor = trade.measure(laws, arguments.contacts, arguments.rounds, _progress)
    print(trade.table(entries, floor))
    if arguments.keep:
        print(keep(entries))


def _scenes(arguments):
    setup = packings.QUICK if arguments.quick else packings.Setup()
    setup = replace(setup, stress=units.number(arguments.stress, "stress", "Pa", 1e4, 1e8, allow_low=True))
    for engine in arguments.scene:
        with tqdm(total=len(candidates.ways(engine)), desc=engine, leave=False, disable=None) as bar:
            found = packings.run(engine, setup, progress=lambda label, bar=bar: bar.update())
        print(f"{setup.count} granite spheres in {NAMES[engine]}, compressed to {setup.stress / 1e3:g} kPa")
        print(packings.table(found, setup) + "\n")


def _softening(arguments):
    path = Path(arguments.softening) if arguments.softening else study.KEPT
    if arguments.softening:
        runs = study.plan(arguments.quick)
        left = study.missing(runs, study.load(path))
        print(f"{len(runs)} runs, {len(left)} of them to be made")
        with tqdm(total=len(left), leave=False, disable=None) as bar:
            study.execute(runs, path, lambda run: bar.update())
    rows = study.load(path)
    points = results.points(rows)
    if not points:
        raise DemlawsError(f"{path} holds no rows of a study: python -m studies.trade --softening FILE makes them")
    table = [*results.rows_of_points(points), *results.rows_of_similarity(results.similarity(rows))]
    names = list(dict.fromkeys(name for row in table for name in row))
    print(csv_text(names, [[row.get(name, "") for name in names] for row in table]), end="")


def main(arguments=None):
    """Run the command; returns the exit status."""
    return execute(parser, arguments)


if __name__ == "__main__":
    sys.exit(main())
