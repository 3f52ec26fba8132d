"""`python -m studies.jamari`: the tests, claims and figures of Jamari & Schipper 2006 and 2008."""

import sys
from pathlib import Path

from demlaws import plots, surface
from demlaws.cli import Parser, example, execute
from demlaws.cli.output import output
from demlaws.errors import quiet
from demlaws.granite.command import print_claims
from studies.jamari import figures as pictures
from studies.jamari.claims import jamari_claims
from studies.jamari.cycles import press
from studies.jamari.matching import change
from studies.jamari.published import published_contact, published_ratios, swaps


def parser():
    """The command line."""
    parser = Parser(
        prog="python -m studies.jamari",
        description="The published tests with p(0)/H_m by the paper's own method and by its closed fit; the papers' claims; "
        "their figures; the repeated contact of 2008 on a synthetic map.",
        **example(
            "  python -m studies.jamari --figure regime.png\n"
            "  python -m studies.jamari --claims\n"
            "  python -m studies.jamari --figures-2006 all --figures-2008 9 --out jamari\n"
            "  python -m studies.jamari --repeat isotropic --figure repeated.png\n"
            "  python -m studies.jamari --change before.asc after.asc --figure change.png"
        ),
    )
    parser.add_argument("--claims", action="store_true", help="what the papers of 2006 and 2008 say, and the verdicts")
    for year, known in ((2006, pictures.FIGURES_2006), (2008, pictures.FIGURES_2008)):
        numbers = ("all", *map(str, known))
        parser.add_argument(
            f"--figures-{year}", nargs="+", choices=numbers, metavar="N", help=f"{', '.join(numbers[1:])} or all"
        )
    parser.add_argument("--out", type=Path, default=Path("jamari"), help="folder for these (default: jamari)")
    parser.add_argument("--repeat", choices=("isotropic", "anisotropic"), help="press on this surface of 2008 20 times")
    parser.add_argument(
        "--change", nargs=2, metavar=("BEFORE", "AFTER"), help="lay the second height map over the first: what has changed"
    )
    parser.add_argument("--pixel", help="pixel size, for files that do not give it, with --change")
    parser.add_argument("--unit", default="m", help="unit of the heights in a file, with --change (default m)")
    parser.add_argument("--map", type=output, help="write the difference of the two maps of --change")
    parser.add_argument("--figure", type=output, help="picture to draw: of the tests, of --repeat, or of --change")
    parser.set_defaults(func=run)
    return parser


def draw_figures(known, chosen, out):
    """Draw figures of a paper, number → function that returns (figure, lines), and print their content."""
    for number in known if "all" in chosen else map(int, chosen):
        with quiet():
            picture, said = known[number]()
        print(f"Fig. {number}: {plots.save(picture, out / f'figure-{number:02}.png')}")
        for line in said:
            print(f"  {line}")


def run(arguments):
    """Print and draw what the arguments ask, by default the published tests."""
    if arguments.claims:
        with quiet():
            print_claims(list(jamari_claims()))
    for year, chosen in ((2006, arguments.figures_2006), (2008, arguments.figures_2008)):
        if chosen:
            draw_figures(getattr(pictures, f"FIGURES_{year}"), chosen, arguments.out / str(year))
    if arguments.repeat:
        press(published_contact(arguments.repeat), pictures.LOAD, arguments.figure, arguments.repeat)
    elif arguments.change:
        before, after = (surface.read(path, arguments.pixel, arguments.unit) for path in arguments.change)
        match = change(before, after, arguments.figure)
        if arguments.map is not None:
            print(surface.write(arguments.map, match.difference))
    elif not (arguments.claims or arguments.figures_2006 or arguments.figures_2008):
        print_tests()
        if arguments.figure is not None:
            print(plots.save(pictures.regime_map(), arguments.figure))


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
            f"{test.label:18} {test.load:6g} {test.contact.roughness * 1e6:7.2f} {row.alpha:7.2f} {cell(test.alpha, '8.2f')} "
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
