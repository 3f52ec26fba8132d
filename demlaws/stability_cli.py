"""`demlaws stability`: the extremes, measured."""

from pathlib import Path

from demlaws.cli import example


def register(subparsers):
    parser = subparsers.add_parser(
        "stability",
        help="measure every law at the extremes",
        description="Per law, unloading rule and evaluation: values not finite, paths that return work, rounding errors, "
        "ratcheting, kinks, impacts, and the stable time step. Exit status 1 if something is not as it must be.",
        **example("  demlaws stability --law pohrt-popov --paths 1e6\n  demlaws stability --paths 1e7 --csv stability.csv"),
    )
    parser.add_argument("--law", action="append", help="only this law (may be repeated)")
    parser.add_argument("--unloading", action="append", help="only this rule (may be repeated)")
    parser.add_argument("--evaluation", action="append", choices=("closed form", "table"), help="only this evaluation")
    parser.add_argument("--paths", type=float, default=1e5, help="random load paths in all, shared by the cases (default 1e5)")
    parser.add_argument("--cycles", type=float, default=1e6, help="tiny cycles a case (default 1e6)")
    parser.add_argument("--csv", type=Path, help="file to write every figure to")
    parser.add_argument("--figure", type=Path, help="picture to draw: energy gain by steps per contact, rounding by decade")
    parser.set_defaults(func=run)


def run(arguments):
    from tqdm import tqdm

    from demlaws import granite, plots, plots_choose, stability
    from demlaws.law import find
    from demlaws.laws.definition import number

    laws = [find(n).name for n in arguments.law] if arguments.law else None
    todo = stability.cases(laws, arguments.unloading, arguments.evaluation or ("closed form", "table"))
    paths = int(number(arguments.paths, "--paths", low=1.0, allow_low=True))
    cycles = int(number(arguments.cycles, "--cycles", low=100.0, allow_low=True))
    rows = []
    with tqdm(todo, desc="stability", unit="case", leave=False, disable=None) as progress:
        for case in progress:
            progress.set_postfix_str(", ".join(case))
            rows.append(stability.measure(case, max(1000, paths // len(todo)), cycles))
            lines = stability.table(rows).split("\n")
            progress.write("\n".join(lines if len(rows) == 1 else lines[-1:]))
    print(
        f"\n{sum(r.paths for r in rows)} paths; gain: largest energy gain of an impact, 1e-6 to 100 m/s, any phase of the step"
    )
    if arguments.csv is not None:
        print(granite.save_csv(arguments.csv, stability.TITLES, map(stability.csv_row, rows)))
    if arguments.figure is not None:
        print(plots.save(plots_choose.stability_figure(rows), arguments.figure))
    problems = stability.failures(rows)
    for problem in problems:
        print(f"FAILS: {problem}")
    return 1 if problems else 0
