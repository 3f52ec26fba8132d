"""`demlaws curve`: one law, one contact, any path."""

from demlaws.cli import example
from demlaws.cli.arguments import force, length, whole
from demlaws.cli.contact import add_law_arguments, describe, draw, law_from, unloads
from demlaws.cli.output import csv_file, picture_file
from demlaws.responses.results import PATH_COLUMNS


def register(add):
    """Add this command."""
    curve = add(
        description="Computes force and overlap of one contact along a path of forces or overlaps.",
        **example(
            "  demlaws curve --law pohrt-popov --radius 8.7mm 8.7mm --material granite --forces 50 0 100 0 --figure c.png\n"
            "  demlaws curve --law rough-plastic --option yield_pressure=1.66e9 --radius 2mm 2mm --modulus 32GPa \\\n"
            "      --sigma 5um --fractal-dimension 2.2 --unloading thornton --overlaps 2e-5 0 3e-5"
        ),
    )
    add_law_arguments(curve)
    way = curve.add_mutually_exclusive_group(required=True)
    way.add_argument("--forces", type=force, nargs="+", help="turning points of the force in N; the path starts at 0")
    way.add_argument("--overlaps", type=length, nargs="+", help="turning points of the overlap in m; the path starts at 0")
    curve.add_argument("--steps", type=whole(), default=200, help="steps per branch (default 200)")
    curve.add_argument(
        "--csv", type=csv_file(PATH_COLUMNS), help="CSV file of the curve, - for standard output (default: print 20 rows)"
    )
    curve.add_argument("--figure", type=picture_file, help="picture to draw (png, pdf, svg)")


def run(arguments, result):
    """Do what the command's arguments ask."""
    from demlaws import driver

    law = law_from(arguments)
    if arguments.forces is not None:
        path = driver.force_controlled(law, arguments.forces, arguments.steps)
    else:
        path = driver.displacement_controlled(law, arguments.overlaps, arguments.steps)
    result.print(f"{unloads(law)}; {describe(law.contact)}")
    result.values = {"law": law.name, "unloading": law.unloading, "contact": law.contact, "options": law.options}
    result.values |= {name: getattr(path, name) for name in PATH_COLUMNS.values()}
    if arguments.csv is not None:
        result.write_csv(arguments.csv, PATH_COLUMNS, path.csv_rows())
    else:
        result.print(f"{'overlap (µm)':>14} {'force (N)':>12} {'K (N/mm)':>12} {'plastic (µm)':>13} {'work (J)':>12}")
        every = max(1, path.overlap.size // 20)
        for row in list(zip(path.overlap, path.force, path.stiffness, path.plastic_overlap, path.work, strict=True))[::every]:
            result.print(f"{row[0] * 1e6:14.4f} {row[1]:12.5g} {row[2] / 1e3:12.5g} {row[3] * 1e6:13.4f} {row[4]:12.4g}")
    draw(result, arguments.figure, lambda plots: plots.path_figure(path, law, unloads(law)))
