"""The command `demlaws granite`: tables, claims, CSV files and figures."""

import math
import shutil
import textwrap
import warnings
from pathlib import Path

from demlaws import granite, plots
from demlaws.errors import DemlawsError, ValidityWarning
from demlaws.files import save_csv
from demlaws.granite import claims
from demlaws.granite import figures as pictures
from demlaws.laws.registry import find
from demlaws.points import read_points

STAGE_TITLES = (
    "stage",
    "maximum force (N)",
    "reload stiffness (N/m)",
    "over Hertz",
    "stiffness at maximum (N/m)",
    "plastic overlap (m)",
)
"""Titles of the fields of a `StageRow`."""


def run(arguments):
    """Run the tests; returns a summary, the claims with verdicts and the files written."""
    from tqdm import tqdm

    if arguments.tables:
        print_printed_tables()
    if arguments.figures:
        _only_figures(arguments)
    if arguments.tables or arguments.figures:
        return {}

    tests = granite.TESTS if arguments.test is None else (granite.find_test(arguments.test),)
    names = granite.laws_for_tests() if arguments.law is None else [find(arguments.law).name]
    points = _points(arguments, tests)
    jobs = [(test, name) for test in tests for name in names]
    runs, notes = {}, {}
    with tqdm(jobs, desc="granite", unit="run", leave=False, disable=None) as progress:
        for test, name in progress:
            progress.set_postfix_str(f"{test.name} {name}")
            result, messages = granite.run_test(name, test)
            runs.setdefault(test.name, []).append(result)
            notes[test.name, name] = messages
    print_tables(tests, runs, notes, points, arguments.fit_compliance)
    chosen = None if arguments.test is None else [tests[0].name]
    found = [] if arguments.law else claims.granite_claims(points, chosen, arguments.fit_compliance)
    if found:
        print_claims(found)
    if any(test.name == "FC5" for test in tests):
        print_sensitivity(claims.cone_sensitivity())
    with warnings.catch_warnings():  # the notes have been printed with the tables
        warnings.simplefilter("ignore", ValidityWarning)
        summary, files = write_csv(arguments.out, tests, runs, notes, found)
        files += draw(arguments.out, tests, runs, points, whole=not (arguments.test or arguments.law))
    print(f"\n{len(files)} files written to {arguments.out}/")
    return {"tests": summary, "claims": found, "files": [str(file) for file in files]}


def _only_figures(arguments):
    if arguments.law is not None:
        raise DemlawsError("--figures draws the laws that the paper draws: leave out --law")
    tests = granite.TESTS if arguments.test is None else (granite.find_test(arguments.test),)
    draw_figures(pictures.FIGURES, arguments.figures, arguments.out, pictures.Paper(_points(arguments, tests)))


def print_printed_tables():
    """Tables 1 to 3 as printed, each with derived quantities."""
    stone = granite.GRANITE
    print("Table 1 (printed: relative density 2.68, ν 0.25, E 60.6 GPa, Shore hardness 77 = 639 kgf/mm² Vickers)")
    print(
        f"  computed: E* = {stone.plane_modulus / 2e9:.3f} GPa (granite on granite), G = "
        f"{stone.young / (2e9 * (1 + stone.poisson)):.2f} GPa, H = {stone.hardness / 1e9:.3f} GPa, H/E* = "
        f"{2 * stone.hardness / stone.plane_modulus:.3f}"
    )
    print("\nTable 2, spheres: of both stones and of the pair as printed, then computed from the stones")
    print(
        f"  {'test':10} {'radii (mm)':>13} {'Sq (µm)':>13} {'Df':>13} {'R (mm)':>7} {'σ (µm)':>7} | {'R':>6} {'σ':>6} "
        f"{'mean Df':>8} {'F (N)':>7} {'A0 (mm²)':>9} {'α 10 N':>7} {'α 100 N':>8}"
    )
    for test in granite.TESTS:
        if not test.bodies:
            continue
        (r1, s1, d1), (r2, s2, d2) = test.bodies
        radius, sigma = 1.0 / (1.0 / r1 + 1.0 / r2), math.hypot(s1, s2)
        contact = test.contact
        threshold = granite.threshold_force(test)
        area = math.pi * (0.75 * threshold * test.radius / contact.modulus) ** (2 / 3)
        flat = "flat" if math.isinf(r2) else f"{r2 * 1e3:.2f}"
        print(
            f"  {test.name:10} {f'{r1 * 1e3:.2f}/{flat}':>13} {f'{s1 * 1e6:.2f}/{s2 * 1e6:.2f}':>13} {f'{d1}/{d2}':>13} "
            f"{test.radius * 1e3:7.2f} {test.roughness * 1e6:7.2f} | {radius * 1e3:6.3f} {sigma * 1e6:6.3f} "
            f"{(d1 + d2) / 2:8.3f} {threshold:7.2f} {area * 1e6:9.4f} {contact.roughness_parameter(10.0):7.2f} "
            f"{contact.roughness_parameter(100.0):8.3f}"
        )
    print("\nTable 3 and text, cones: printed values; the rest is assumed and marked as such")
    for test in granite.TESTS:
        if test.bodies:
            continue
        loads = "; ".join(", ".join(f"{f:g}" for f in stage if f > 0.0) for stage in test.stages)
        print(f"  {test.name:6} R = {test.radius * 1e3:.2f} mm, loads to (N): {loads}")
        limit = test.contact.modulus
        print(
            f"         computed with p_y = {test.yield_pressure / 1e9:.2f} GPa: K_y = "
            f"{math.pi * test.radius * test.yield_pressure / 1e3:.0f} N/mm, a smooth tip yields at "
            f"{math.pi**3 * test.radius**2 * test.yield_pressure**3 / (6 * limit**2):.1f} N; {test.assumed}"
        )


def _points(arguments, tests):
    """Measured points by test name."""
    found = {}
    for given in arguments.data:
        name, separator, file = given.rpartition("=")
        if not separator and arguments.test is None:
            raise DemlawsError(f"--data {given}: say which test the points belong to: --data 'SS(18-18)={given}', or --test")
        test = granite.find_test(name) if separator else tests[0]
        if test.name in found:
            raise DemlawsError(f"--data {given}: {test.name} has points already ({found[test.name].source})")
        if test not in tests:
            raise DemlawsError(f"--data {given}: --test {arguments.test} leaves {test.name} out")
        found[test.name] = read_points(Path(file))
    return found


def print_sensitivity(rows):
    """Print what FC5's uncertain radius and fractal dimension do."""
    print("\nFC5, first loading by Pohrt-Popov: what its uncertain radius and fractal dimension do")
    print(f"  {'R (mm)':>7} {'Df':>6} {'µm, 0.1 to 7 N':>15} {'K at 7 N (N/mm)':>16} {'threshold F (N)':>16}")
    for r in rows:
        print(
            f"  {r.radius * 1e3:7.2f} {r.fractal_dimension:6.2f} {r.displacement * 1e6:15.2f} {r.stiffness / 1e3:16.0f} "
            f"{r.threshold:16.1f}"
        )


def print_tables(tests, runs, notes, points, compliance):
    """Print a table a test: displacement and stiffness of each law, with its misfit where points are given."""
    for test in tests:
        low, high, loads = granite.forces_of(test)
        print(
            f"\n{test.name}: R = {test.radius * 1e3:.2f} mm, σ = {test.roughness * 1e6:.2f} µm, Df = {test.fractal_dimension}, "
            f"E* = {test.contact.modulus / 1e9:.2f} GPa, H = {test.contact.hardness / 1e9:.3f} GPa"
        )
        if test.assumed:
            print(f"  note: {test.assumed}")
        print(f"  {'law':16} {f'µm, {low:g} to {high:g} N':>17} " + "".join(f"{f'K {f:g} N':>10}" for f in loads) + "   (N/mm)")
        measured = points.get(test.name)
        for row, result in zip(granite.table_of(test, runs[test.name], notes), runs[test.name], strict=True):
            misfit = _misfit(measured.fit(result.law, compliance), compliance) if measured else ""
            print(f"  {row.law:16} {row.displacement:17.1f} " + "".join(f"{k:10.0f}" for k in row.stiffness) + misfit)
        for result in runs[test.name]:
            if test.cyclic and result.law.definition.before_yield is not None:
                print_stages(result)
            for message in notes[test.name, result.law.name]:
                print(f"  warning: {message}")


def _misfit(fit, compliance):
    text = f"   misfit {fit.misfit * 1e6:.2f} ± {fit.uncertainty * 1e6:.2f} µm"
    return text + (f", compliance {fit.compliance * 1e6:.4f} µm/N" if compliance else "")


def print_stages(result):
    """Print stiffness and plastic overlap of each stage of a cyclic test."""
    print(f"  {result.law.name}, {result.law.unloading} unloading, p_y = {result.test.yield_pressure / 1e9:.2f} GPa")
    print(f"    {'stage':>5} {'to (N)':>7} {'reload K/K_H':>13} {'K at maximum (N/mm)':>20} {'plastic overlap (µm)':>21}")
    for s in granite.stages_of(result):
        reload = f"{s.over_hertz:13.3f}" if math.isfinite(s.over_hertz) else f"{'first':>13}"
        print(
            f"    {s.stage:5} {s.maximum_force:7.0f} {reload} {s.final_stiffness / 1e3:20.0f} {s.plastic_overlap * 1e6:21.2f}"
        )
    if result.beyond:
        print(f"    {result.beyond}")


def print_claims(found):
    """Print each claim, what the runs give, the verdict, and how many of each."""
    width = max(80, min(150, shutil.get_terminal_size((120, 24)).columns))
    print("\nClaims of the paper against the runs")
    for claim in found:
        print(f"  {claim.test}: {claim.claim}")
        for line in textwrap.wrap(claim.gives, width - 8):
            print(f"      {line}")
        print(f"      → {claim.verdict}")
    counts = {verdict: sum(c.verdict == verdict for c in found) for verdict in dict.fromkeys(c.verdict for c in found)}
    print("  " + "; ".join(f"{n} {verdict}" for verdict, n in counts.items()))


def draw_figures(known, chosen, out, *given):
    """Draw figures of a paper, number → function of `given` that returns (figure, lines), and print their content."""
    for number in chosen:
        with warnings.catch_warnings():  # the limits of each law are in the tables
            warnings.simplefilter("ignore", ValidityWarning)
            picture, said = known[number](*given)
        print(f"Fig. {number}: {plots.save(picture, out / f'figure-{number:02}.png')}")
        for line in said:
            print(f"  {line}")


def write_csv(out, tests, runs, notes, found):
    """Write paths, cycles, summary and claims as CSV; returns the files."""
    files, summary = [], []
    for test in tests:
        low, high, loads = granite.forces_of(test)
        for row, result in zip(granite.table_of(test, runs[test.name], notes), runs[test.name], strict=True):
            k = dict(zip(loads, row.stiffness, strict=True))
            summary.append([test.name, row.law, f"{low:g}-{high:g}", row.displacement, k[1.0], k[10.0], row.note])
            for number, path in enumerate(result.paths, start=1):
                stage = f"-stage{number}" if len(result.paths) > 1 else ""
                files.append(granite.save_path(out / f"{test.key}-{row.law}{stage}.csv", path))
        if test.cyclic:
            for result in runs[test.name]:
                path = out / f"{test.key}-{result.law.name}-cycles.csv"
                files.append(save_csv(path, STAGE_TITLES, granite.stages_of(result)))
    names = ("test", "law", "between", "displacement", "stiffness_1N", "stiffness_10N", "notes")
    titles = ["test", "law", "between (N)", "displacement (um)", "stiffness at 1 N (N/mm)", "stiffness at 10 N (N/mm)", "notes"]
    files.append(save_csv(out / "summary.csv", titles, summary))
    if found:
        files.append(save_csv(out / "claims.csv", ["test", "claim", "run gives", "verdict"], found))
    return [dict(zip(names, row, strict=True)) for row in summary], files


def draw(out, tests, runs, points, whole):
    """Draw all figures of these tests; returns the files."""
    if not plots.available():
        print("no figures: matplotlib is missing (pip install 'demlaws[plots]')")
        return []
    files = []

    def keep(name, figure):
        files.append(plots.save(figure, out / f"{name}.png"))

    paper = pictures.Paper(points, [run for name in runs for run in runs[name]])
    for test in tests:
        keep(f"force-{test.key}", pictures.force(test, runs[test.name], points.get(test.name)))
        for result in runs[test.name]:
            if test.cyclic and result.law.definition.before_yield is not None:
                keep(f"cycles-{test.key}", pictures.cycling(result, points.get(test.name)))
    numbered = {7: "unloading-ss-12-18"} if "SS(12-18)" in runs else {}
    if whole:
        numbered |= {8: "stiffness", 5: "crossover-ss-18-18", 9: "roughness", 13: "plastic-overlap", 4: "effective-radius"}
    for number, name in numbered.items():
        keep(name, pictures.FIGURES[number](paper)[0])
    return files
