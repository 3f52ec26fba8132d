"""`python -m studies.trade`: cost against error."""

import sys
from dataclasses import replace
from pathlib import Path

from tqdm import tqdm

from demlaws import units
from demlaws.cli import Parser, example, execute
from demlaws.cli.arguments import law_name, pressure, whole
from demlaws.errors import DemlawsError
from demlaws.laws.names import POHRT_POPOV
from demlaws.laws.registry import find
from studies.softening import results, study
from studies.trade import candidates, packings, peers, trade
from studies.trade.candidates import ENGINES, NAMES
from studies.trade.keep import keep

YIELDING = 5e6
"""Stress [Pa] at which leaving yield out shows in a packing of granite."""


def parser():
    """The command line."""
    parser = Parser(
        prog="python -m studies.trade",
        description="Measures, in one run, ns per contact and errors in force, stiffness, energy and rebound of every law × "
        "unloading × evaluation, and of the time step; marks the Pareto front. With --engines also the share of a YADE, "
        "LIGGGHTS or LAMMPS step that a law takes, and the engines' own models; with --scene the errors of a whole packing; "
        "with --softening those of softer grains, faster loading and longer steps against time to solution.",
        **example(
            "  python -m studies.trade --engines\n"
            "  python -m studies.trade --scene yade liggghts lammps\n"
            "  python -m studies.trade --softening                               (the kept rows)\n"
            "  python -m studies.trade --softening rows.jsonl --engines yade --quick (missing rows)\n"
            "  python -m studies.trade --law hertz --law pohrt-popov"
        ),
    )
    parser.add_argument("--law", type=law_name, action="append", help="only this law (may be repeated)")
    parser.add_argument("--contacts", type=whole(1000), default=200_000, help="contacts of a batch (default 2e5)")
    parser.add_argument("--rounds", type=whole(), default=9, help="rounds of timing (default 9)")
    parser.add_argument(
        "--engines",
        nargs="*",
        choices=ENGINES,
        metavar="ENGINE",
        help="also measure steps of yade, liggghts, lammps, with the engines' own models (default: those that are installed)",
    )
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
        "in the engines (--engines), hours, and goes on from the rows that FILE holds; without, kept rows are shown",
    )
    parser.add_argument(
        "--stress",
        type=pressure,
        default=YIELDING,
        help="stress that --scene compresses to (default 5 MPa, where contacts yield; at 500kPa roughness alone matters)",
    )
    parser.add_argument("--quick", action="store_true", help="150 spheres in the scene, fewer rounds or runs in the engines")
    parser.add_argument(
        "--peers",
        action="store_true",
        help="only this: each law that other codes have (--law: these) fitted to a granite reference, loading and unloading",
    )
    parser.add_argument(
        "--keep", action="store_true", help="write what demlaws choose reads: these costs, the kept study's curves"
    )
    parser.set_defaults(func=run)
    return parser


def _peers(arguments):
    laws = tuple(find(n).name for n in arguments.law) if arguments.law else peers.PEERS
    rows = peers.held_together(laws, progress=lambda jobs: tqdm(jobs, desc="peers", leave=False, disable=None))
    print(peers.held_table(rows))


def run(arguments):
    """Do what the command's arguments ask."""
    if arguments.scene:
        return _scenes(arguments)
    if arguments.softening is not None:
        return _softening(arguments)
    if arguments.peers:
        return _peers(arguments)
    engines = [] if arguments.engines is None else trade.installed(arguments.engines)
    laws = [find(n).name for n in arguments.law] if arguments.law else None

    def progress(things):
        return tqdm(things, desc="trade", leave=False, disable=None)

    entries, floor = trade.measure(laws, arguments.contacts, arguments.rounds, progress)
    print(trade.table(entries, floor))
    chosen = next((e for e in entries if e[:3] == (POHRT_POPOV, "hertz", "closed form")), None)
    if chosen is not None:
        print("\nimpacts of a granite sphere, 1e-3 to 1 m/s, any phase of the step, pohrt-popov with hertz unloading")
        print(trade.steps_table(trade.steps_trade(chosen.ns)))
    for engine in engines:
        found = trade.engine_trade(engine, arguments.quick, progress)
        print(f"\na step of {NAMES[engine]}, a close packing, one thread; force error against {trade.RICHEST[0]}")
        print(trade.engine_table(found))
    if arguments.keep:
        if laws:
            raise DemlawsError("--keep writes the costs of all laws: leave out --law")
        print(keep(entries))


def _scenes(arguments):
    setup = packings.QUICK if arguments.quick else packings.Setup()
    setup = replace(setup, stress=units.number(arguments.stress, "stress", "Pa", 1e4, 1e8, allow_low=True))
    for engine in trade.installed(arguments.scene):
        with tqdm(total=len(candidates.ways(engine)), desc=engine, leave=False, disable=None) as bar:
            found = packings.run(engine, setup, progress=lambda label, bar=bar: bar.update())
        print(f"{setup.count} granite spheres in {NAMES[engine]}, compressed to {setup.stress / 1e3:g} kPa")
        print(packings.table(found, setup) + "\n")


def _softening(arguments):
    path = Path(arguments.softening) if arguments.softening else study.KEPT
    if arguments.softening:
        unknown = set(arguments.engines or ()) - set(study.ENGINES)
        if unknown:
            raise DemlawsError(f"--softening runs in {' and '.join(study.ENGINES)}, not in {', '.join(sorted(unknown))}")
        for engine in trade.installed(arguments.engines or study.ENGINES):
            runs = study.plan(engine, arguments.quick)
            left = study.missing(runs, study.load(path))
            print(f"{NAMES[engine]}: {len(runs)} runs, {len(left)} of them to be made")
            with tqdm(total=len(left), desc=engine, leave=False, disable=None) as bar:
                study.execute(runs, path, lambda run, bar=bar: bar.update())
    points = results.points(study.load(path))
    if not points:
        raise DemlawsError(f"{path} holds no rows of a study: python -m studies.trade --softening FILE makes them")
    print(results.table(points))
    alike = results.similarity(study.load(path))
    if alike:
        print(results.similarity_table(alike) + "\n")


def main(arguments=None):
    """Run the command; returns the exit status."""
    return execute(parser, arguments)


if __name__ == "__main__":
    sys.exit(main())
