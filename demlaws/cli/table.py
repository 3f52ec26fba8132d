"""`demlaws table`: a law, or measured points, as a table with measured errors."""

import math
from pathlib import Path

from demlaws.cli import example
from demlaws.cli.arguments import force, length, plain
from demlaws.cli.contact import add_law_arguments, contact_from, describe, draw, law_from, unloads
from demlaws.cli.output import picture_file, table_file
from demlaws.errors import DemlawsError


def register(add):
    """Add the command `table`."""
    table = add(
        description="Writes a table of dimensionless force and stiffness of a law, or of a curve through measured points. The "
        "header of the file contains the measured errors.",
        **example(
            "  demlaws table --law pohrt-popov --unloading hertz --radius 8.7mm 8.7mm --material granite --out granite.tbl\n"
            "  demlaws table --law pohrt-popov --radius 8.7mm 8.7mm --material granite --out both.tbl --unloading hertz.tbl\n"
            "  demlaws table --points test.csv --unloading hertz --radius 8mm 8mm --modulus 32GPa --out measured.tbl\n\n"
            "test.csv: two columns with units in the header, for instance\n"
            "  overlap (um),force (N)"
        ),
    )
    add_law_arguments(table, law_required=False)
    points = table.add_argument_group("measured points in place of --law")
    points.add_argument(
        "--points",
        type=Path,
        help="text file with the points of first loading: overlap and force with units (-: standard input)",
    )
    points.add_argument(
        "--zero", type=length, default=0.0, help="displacement in m at first touch (default 0: the points are overlaps)"
    )
    points.add_argument("--force-noise", type=force, help="standard uncertainty of the force in N (default: from the scatter)")
    table.add_argument(
        "--rtol",
        type=plain,
        help="relative tolerance of force and stiffness (default 1e-5; for points 1e-3 of the smoothed curve)",
    )
    table.add_argument("--max-force", type=force, help="largest force of the table in N (default: force at an overlap of R/10)")
    table.add_argument("--out", type=table_file, required=True, help="file to write")
    table.add_argument(
        "--figure", type=picture_file, help="picture of the table and its errors, or of the points and the table"
    )


def measured_table(arguments, result):
    """The table of the points, and their (overlap, force) for a figure."""
    import numpy as np

    from demlaws.curves.point_files import read_points
    from demlaws.curves.points import FEWEST_FOR_UNCERTAINTY
    from demlaws.law import Table

    if arguments.law is not None or arguments.option or arguments.max_force is not None:
        raise DemlawsError("--points replaces --law, --option and --max-force: give one or the other")
    test = read_points(arguments.points)
    first = test.loading_mask()
    points = test.displacement[first] - arguments.zero, test.force[first]
    table = Table.from_points(
        np.column_stack(points),
        contact_from(arguments),
        unloading="elastic" if arguments.unloading is None else arguments.unloading,
        uncertainty=arguments.force_noise,
        rtol=1e-3 if arguments.rtol is None else arguments.rtol,
        description=f"points of {arguments.points.name}",
    )
    rest = int(test.force.size - np.count_nonzero(first))
    knots = table.knots
    result.print_wrapped(
        f"{arguments.points}: {knots.points} points of first loading; smoothing: {knots.smoothing}; points deviate by up to "
        f"{knots.departure:.3g} N from the curve"
    )
    if rest:
        result.print_wrapped(f"{rest} points of unloading and reloading are not used: demlaws fit takes them, too")
    k = int(np.argmax(knots.uncertainty / knots.force))
    share = 100.0 * knots.uncertainty[k] / knots.force[k]
    few = f"none from {knots.points} points: at least {FEWEST_FOR_UNCERTAINTY} overlaps are needed"
    most = f"at most {share:.2g} % (at {knots.force[k]:.3g} N)"
    result.print(f"standard uncertainty of the force: {few if math.isnan(share) else most}")
    return table, points


def run(arguments, result):
    """Do what the command's arguments ask."""
    points = law = None
    if arguments.points is not None:
        result.print(describe(contact_from(arguments)))
        table, points = measured_table(arguments, result)
    elif arguments.law is None:
        raise DemlawsError("give --law NAME, or measured points with --points FILE")
    else:
        law = law_from(arguments)
        result.print(f"{unloads(law)}; {describe(law.contact)}")
        table = law.tabulate(1e-5 if arguments.rtol is None else arguments.rtol, arguments.max_force)
    table.save(arguments.out)
    result.values = {"file": str(arguments.out), "rows": table.nodes.u.size, "largest_force": table.largest_force}
    result.values |= {"rtol": table.rtol, "force_error": table.force_error, "stiffness_error": table.stiffness_error}
    result.print_wrapped(
        f"{arguments.out}: {table.nodes.u.size} rows, {2**table.curve.bits} cells per octave, "
        f"to {table.largest_force:.4g} N; largest relative error: force {table.force_error:.1e}, "
        f"stiffness {table.stiffness_error:.1e}"
    )
    curve = table.unloading_law
    if curve is not None:
        result.print_wrapped(
            f"unloading along {curve.name!r}: {curve.nodes.u.size} rows, to {curve.largest_force:.4g} N; "
            f"largest relative error: force {curve.force_error:.1e}, stiffness {curve.stiffness_error:.1e}"
        )
    if table.collapses and arguments.max_force is not None:
        smaller = table.bound_to(table.contact.with_values(radius=0.1 * table.contact.radius))
        result.print_wrapped(
            f"for another contact the table ends at another force: with a tenth of this R at {smaller.largest_force:.3g} N"
        )
    if not table.collapses:
        result.print_wrapped(
            f"the curve of {table.name!r} depends on the radius or modulus: this table is valid for this contact only"
        )
    if points is None:
        draw(result, arguments.figure, lambda plots: plots.table_figure(table, law))
    else:
        draw(result, arguments.figure, lambda plots: plots.points_figure(table, *points))
