"""`python -m studies.jamari`: the tests and claims of Jamari & Schipper 2006 and 2008."""

import sys

from demlaws import plots
from demlaws.cli import Parser, example, execute
from demlaws.cli.output import picture_file
from demlaws.errors import quiet
from demlaws.granite.command import claim_lines
from studies.jamari.claims import jamari_claims
from studies.jamari.cycles import press, print_memories
from studies.jamari.figure import regime_map
from studies.jamari.published import LOAD, published_contact, published_ratios, swaps


def parser():
    """The command line."""
    parser = Parser(
        prog="python -m studies.jamari",
        description="The published tests with p(0)/H_m by the paper's own method and by its closed fit; the papers' claims; "
        "the repeated contact of 2008 on a synthetic map.",
        **example(
            "  python -m studies.jamari --figure regime.png\n"
            "  python -m studies.jamari --claims\n"
            "  python -m studies.jamari --repeat isotropic --figure repeated.png\n"
            "  python -m studies.jamari --memory"
        ),
    )
    parser.add_argument("--claims", action="store_true", help="what the papers of 2006 and 2008 say, and the verdicts")
    parser.add_argument("--repeat", choices=("isotropic", "anisotropic"), help="press on this surface of 2008 20 times")
    parser.add_argument("--memory", action="store_true", help="change in cycle 2 of ten maps, by what a pixel remembers")
    parser.add_argument("--figure", type=picture_file, help="picture to draw: of the tests, or of --repeat")
    parser.set_defaults(func=run)
    return parser


def run(arguments, _):
    """Print and draw what the arguments ask, by default the published tests."""
    if arguments.claims:
        with quiet():
            print(*claim_lines(jamari_claims(), verbose=True), sep="\n")
    if arguments.repeat:
        press(published_contact(arguments.repeat), LOAD, arguments.figure, arguments.repeat)
    elif arguments.memory:
        with quiet():
            print_memories()
    elif not arguments.claims:
        print_tests()
        if arguments.figure is not None:
            print(plots.save(regime_map(), arguments.figure))


def print_tests():
    """Print the published tests with α and p(0)/H_m, printed and computed."""
    rows = published_ratios()
    print(f"{'':18} {'':6} {'':7} {'α':>7} {'':>8} {'μ':>8} {'p(0)/H_m':>23}")
    print(
        f"{'test':18} {'P (N)':>6} {'σ (µm)':>7} {'comp.':>7} {'printed':>8} {'printed':>8} "
        f"{'at μ':>7} {'Eq. 4':>7} {'printed':>8}  seen"
    )

    def cell(value, text):
        return f"{'-':>{len(format(1.0, text))}}" if value != value else format(value, text)

    for row in rows:
        test = row.test
        print(
            f"{test.label:18} {test.load:6g} {test.contact.sigma * 1e6:7.2f} {row.alpha:7.2f} {cell(test.alpha, '8.2f')} "
            f"{cell(test.mu, '8.0f')} {cell(row.solved, '7.3f')} {row.fitted:7.3f} {cell(test.ratio, '8.2f')}  {test.seen}"
        )
    print("\nat μ: Greenwood & Tripp's solution at the printed μ, the paper's own method; Eq. 4: its closed fit; both computed")
    for column, name in (("solved", "by the solution"), ("fitted", "by Eq. 4")):
        count = swaps(rows, column)
        order = "the order is that of what was seen" if not count else f"{count} of the tests of 2006 stands out of order"
        print(f"  {name}: {order}")


def main(arguments=None):
    """Run the command; returns the exit status."""
    return execute(parser, arguments)


if __name__ == "__main__":
    sys.exit(main())
