"""`demlaws trade`: cost against error."""

from pathlib import Path

from demlaws.cli import example


def register(subparsers):
    parser = subparsers.add_parser(
        "trade",
        help="measure cost against error of every law and evaluation",
        description="Measures, in one run, ns a contact and errors in force, stiffness, energy and rebound of every law × "
        "unloading × evaluation, and of the time step; marks the Pareto front.",
        **example(
            "  demlaws trade --csv trade.csv --figure trade.png\n"
            "  demlaws trade --law hertz --law pohrt-popov --yade yade_scripts/cost.py"
        ),
    )
    parser.add_argument("--law", action="append", help="only this law (may be repeated)")
    parser.add_argument("--contacts", type=float, default=2e5, help="contacts of a batch (default 2e5)")
    parser.add_argument("--rounds", type=int, default=9, help="rounds of timing (default 9)")
    parser.add_argument("--yade", type=Path, metavar="SCRIPT", help="also run yade_scripts/cost.py: our laws and YADE's own")
    parser.add_argument("--liggghts", type=Path, metavar="SCRIPT", help="also run tests/benchmarks/bench_liggghts.py (minutes)")
    parser.add_argument("--csv", type=Path, help="file to write every figure to")
    parser.add_argument("--figure", type=Path, help="picture to draw: error against cost with the Pareto front")
    parser.set_defaults(func=run)


def run(arguments):
    from tqdm import tqdm

    from demlaws import granite, plots, plots_choose, trade
    from demlaws.law import find
    from demlaws.laws.definition import number

    laws = [find(n).name for n in arguments.law] if arguments.law else None
    count = int(number(arguments.contacts, "--contacts", low=1000.0, allow_low=True))
    rounds = int(number(arguments.rounds, "--rounds", low=1.0, allow_low=True))

    def progress(things):
        return tqdm(things, desc="trade", leave=False, disable=None)

    entries, floor = trade.measure(laws, count, rounds, progress)
    print(trade.table(entries, floor))
    steps = []
    chosen = next((e for e in entries if e[:3] == ("pohrt-popov", "hertz", "closed form")), None)
    if chosen is not None:
        steps = trade.steps_trade(chosen.ns)
        print("\nimpacts of a granite sphere, 1e-3 to 1 m/s, any phase of the step, pohrt-popov with hertz unloading")
        print(trade.steps_table(steps))
    peers = {}
    for engine, script, measure, unit in (
        ("YADE", arguments.yade, trade.yade_costs, "ns a contact of the interaction loop"),
        ("LIGGGHTS", arguments.liggghts, trade.liggghts_costs, "µs a step"),
    ):
        if script is None:
            continue
        peers[engine] = measure(script)
        print(f"\n{engine}: {unit}, ratio to its own Hertz")
        for name, (cost, ratio) in peers[engine].items():
            print(f"  {name:44}{cost:10.1f}{ratio:8.3f}")
    if arguments.csv is not None:
        print(granite.save_csv(arguments.csv, trade.TITLES, map(trade.csv_row, entries)))
    if arguments.figure is not None:
        print(plots.save(plots_choose.trade_figure(entries, floor, steps, peers), arguments.figure))
