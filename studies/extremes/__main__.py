"""`python -m studies.extremes`: the extremes, measured."""

import sys

from tqdm import tqdm

from demlaws.cli import Parser, example, execute
from demlaws.cli.arguments import whole
from demlaws.laws.registry import find
from studies.engines import available
from studies.extremes import extremes, report, stability


def parser():
    """The command line."""
    parser = Parser(
        prog="python -m studies.extremes",
        description="Per law, unloading rule and evaluation: values not finite, paths that return work, rounding errors, "
        "ratcheting, kinks, impacts, and the stable time step. Exit status 1 if a check failed.",
        **example(
            "  python -m studies.extremes --law pohrt-popov --paths 1e6\n"
            "  python -m studies.extremes --paths 1e7\n"
            "  python -m studies.extremes --law hertz --paths 0 --yade --liggghts --lammps"
        ),
    )
    parser.add_argument("--law", action="append", help="only this law (may be repeated)")
    parser.add_argument("--unloading", action="append", help="only this rule (may be repeated)")
    parser.add_argument(
        "--paths",
        type=whole(0, 10**9),
        default=100_000,
        help="random load paths in all, shared by the cases; 0: engines only (default 1e5)",
    )
    parser.add_argument("--cycles", type=whole(100, 10**9), default=1_000_000, help="tiny cycles a case (default 1e6)")
    for engine in extremes.ENGINES:
        parser.add_argument(
            f"--{engine.lower()}", action="store_true", help=f"also inside {engine}: two spheres, and a thousand"
        )
    parser.add_argument("--engines", action="store_true", help="also inside the engines that are installed")
    parser.add_argument("--quick", action="store_true", help="engines: fewer and shorter paths, 200 spheres")
    parser.set_defaults(func=run)
    return parser


def run(arguments, _):
    """Do what the command's arguments ask."""
    laws = [find(n).name for n in arguments.law] if arguments.law else None
    problems = []
    if arguments.paths:
        problems += stability.failures(_laws(arguments, laws, arguments.paths, arguments.cycles))
    problems += _engines(arguments, laws)
    for problem in problems:
        print(f"FAILS: {problem}")
    return 1 if problems else 0


def show(progress, table, rows):
    """Print the last row of a table, the first one with the head."""
    lines = table(rows).split("\n")
    progress.write("\n".join(lines if len(rows) == 1 else lines[-1:]))


def _laws(arguments, laws, paths, cycles):
    """Figures of the compiled laws, printed as they come."""
    todo = stability.cases(laws, arguments.unloading)
    rows = []
    with tqdm(todo, desc="stability", unit="case", leave=False, disable=None) as progress:
        for case in progress:
            progress.set_postfix_str(", ".join(case))
            rows.append(stability.measure(case, max(1000, paths // len(todo)), cycles))
            show(progress, stability.table, rows)
    print(
        f"\n{sum(r.paths for r in rows)} paths; gain: largest energy gain of an impact, 1e-6 to 100 m/s, any phase of the step"
    )
    return rows


def _engines(arguments, laws):
    """Faults inside the engines that were asked for; figures are printed as they come."""
    problems = []
    for engine in extremes.ENGINES:
        if not getattr(arguments, engine.lower()):
            reason = available(engine.lower()) if arguments.engines else ""
            if reason:
                print(f"{engine}: not measured: {reason}")
            if reason is not None:
                continue
        count = len(extremes.cases(laws, arguments.unloading))
        own = []
        with tqdm(total=count + 1, desc=engine, unit="case", leave=False, disable=None) as progress:

            def ended(found, engine=engine, own=own, progress=progress):
                progress.update()
                if isinstance(found, list):
                    progress.write(report.stops_table(engine, found))
                    return
                own.append(found)
                show(progress, report.table, own)

            *_, stops = extremes.run(engine, laws, arguments.unloading, quick=arguments.quick, progress=ended)
        problems += report.stop_failures(engine, stops) + report.failures(own)
    return problems


def main(arguments=None):
    """Run the command; returns the exit status."""
    return execute(parser, arguments)


if __name__ == "__main__":
    sys.exit(main())
