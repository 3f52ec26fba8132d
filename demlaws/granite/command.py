"""The command `demlaws granite`: tables, claims, CSV files and figures."""

import math

from demlaws import granite, plots
from demlaws.errors import quiet
from demlaws.files import save_csv, wrapped
from demlaws.granite import claims
from demlaws.granite import figures as pictures
from demlaws.granite.verdicts import counts
from demlaws.laws import POHRT_POPOV, ROUGH_PLASTIC
from demlaws.laws.registry import find
from demlaws.responses.results import PATH_COLUMNS

STAGE_TITLES = (
    "stage",
    "maximum force (N)",
    "reload stiffness (N/m)",
    "over Hertz",
    "stiffness at maximum (N/m)",
    "plastic overlap (m)",
)
"""Titles of the fields of a `StageRow`."""


def run(arguments, output):
    """Run the tests; print tables and claims, write CSV files and figures."""
    from tqdm import tqdm

    modulus = arguments.modulus
    tests = granite.tests_of(modulus) if arguments.test is None else (granite.find_test(arguments.test, modulus),)
    names = granite.laws_for_tests() if arguments.law is None else [find(arguments.law).name]
    jobs = [(test, name) for test in tests for name in names]
    runs, notes = {}, {}
    for test, name in tqdm(jobs, desc="granite", unit="run", leave=False, disable=None):
        result, messages = granite.run_test(name, test)
        runs.setdefault(test.name, []).append(result)
        notes[test.name, name] = messages
    output.print(*table_lines(tests, runs, notes))
    test_names = None if arguments.test is None else [tests[0].name]
    verdicts = [] if arguments.law else claims.granite_claims(test_names)
    if verdicts:
        output.print(*claim_lines(verdicts))
    with quiet():  # the notes have been printed with the tables
        files = write_csv(arguments.out, tests, runs, notes, verdicts)
        if plots.available():
            files += draw(arguments.out, tests, runs, modulus, whole=not (arguments.test or arguments.law))
        else:
            output.print("no figures: matplotlib is missing (pip install 'demlaws[plots]')")
    output.print(f"\n{len(files)} files written to {arguments.out}/")


def table_lines(tests, runs, notes):
    """A table for each test: displacement and stiffness of each law."""
    for test in tests:
        low, high, loads = granite.forces_of(test)
        yield (
            f"\n{test.name}: R = {test.radius * 1e3:.2f} mm, σ = {test.roughness * 1e6:.2f} µm, Df = {test.fractal_dimension}, "
            f"E* = {test.contact.modulus / 1e9:.2f} GPa, H = {test.contact.hardness / 1e9:.3f} GPa"
        )
        if test.assumed:
            yield f"  note: {test.assumed}"
        yield f"  {'law':16} {f'µm, {low:g} to {high:g} N':>17} " + "".join(f"{f'K {f:g} N':>10}" for f in loads) + "   (N/mm)"
        for result in runs[test.name]:
            displacement, stiffnesses = granite.gains(result)
            yield f"  {result.law.name:16} {displacement:17.1f} " + "".join(f"{k:10.0f}" for k in stiffnesses)
        for result in runs[test.name]:
            if test.cyclic and result.law.definition.before_yield is not None:
                yield from _stage_lines(result)
            for message in notes[test.name, result.law.name]:
                yield wrapped(f"  warning: {message}")


def _stage_lines(result):
    """Stiffness and plastic overlap of each stage of a cyclic test."""
    yield f"  {result.law.name}, {result.law.unloading} unloading, p_y = {result.test.yield_pressure / 1e9:.2f} GPa"
    yield f"    {'stage':>5} {'to (N)':>7} {'reload K/K_H':>13} {'K at maximum (N/mm)':>20} {'plastic overlap (µm)':>21}"
    for s in granite.stages_of(result):
        reload = f"{s.over_hertz:13.3f}" if math.isfinite(s.over_hertz) else f"{'first':>13}"
        yield (
            f"    {s.stage:5} {s.maximum_force:7.0f} {reload} {s.final_stiffness / 1e3:20.0f} {s.plastic_overlap * 1e6:21.2f}"
        )
    if result.beyond:
        yield f"    {result.beyond}"


def claim_lines(verdicts):
    """Each claim, what the runs give, the verdict, and how many of each."""
    yield "\nClaims of the paper against the runs"
    for claim in verdicts:
        yield wrapped(f"  {claim.test}: {claim.claim}")
        yield wrapped(claim.gives, "      ", "      ")
        yield wrapped(f"      → {claim.verdict}" + (f" ({claim.criterion})" if claim.criterion else ""), rest="        ")
        if claim.other_gives:
            yield wrapped(f"with {_other}: {claim.other_gives}", "      ", "      ")
            yield wrapped(f"      → {claim.other_verdict}", rest="        ")
    yield wrapped(f"  {counts(c.verdict for c in verdicts)}")
    yield wrapped(f"  with {_other}: {counts(c.other_verdict or c.verdict for c in verdicts)}")


_other = f"E* = {granite.MODULI['figures'] / 1e9:.1f} GPa"


def write_csv(out, tests, runs, notes, verdicts):
    """Write paths, cycles, summary and claims as CSV; returns the files."""
    files, summary = [], []
    for test in tests:
        low, high, loads = granite.forces_of(test)
        for result in runs[test.name]:
            name, (displacement, stiffnesses) = result.law.name, granite.gains(result)
            k = dict(zip(loads, stiffnesses, strict=True))
            note = "; ".join(notes[test.name, name])
            summary.append([test.name, name, f"{low:g}-{high:g}", displacement, k[1.0], k[10.0], note])
            for number, path in enumerate(result.paths, start=1):
                stage = f"-stage{number}" if len(result.paths) > 1 else ""
                files.append(save_csv(out / f"{test.key}-{name}{stage}.csv", PATH_COLUMNS, path.csv_rows()))
        if test.cyclic:
            for result in runs[test.name]:
                path = out / f"{test.key}-{result.law.name}-cycles.csv"
                files.append(save_csv(path, STAGE_TITLES, granite.stages_of(result)))
    titles = ["test", "law", "between (N)", "displacement (um)", "stiffness at 1 N (N/mm)", "stiffness at 10 N (N/mm)", "notes"]
    files.append(save_csv(out / "summary.csv", titles, summary))
    if verdicts:
        titles = ["test", "claim", "run gives", "verdict", "criterion", f"run gives with {_other}", f"verdict with {_other}"]
        files.append(save_csv(out / "claims.csv", titles, verdicts))
    return files


def draw(out, tests, runs, modulus, whole):
    """Draw all figures of these tests, with the E* of this name; returns the files."""
    figures = []  # name, function that draws, its arguments
    for test in tests:
        figures.append((f"force-{test.key}", pictures.force, test, runs[test.name]))
        for result in runs[test.name]:
            if test.cyclic and result.law.definition.before_yield is not None:
                figures.append((f"cycles-{test.key}", pictures.cycling, result))
    if whole:
        named = {(run.test.name, run.law.name): run for test in tests for run in runs[test.name]}
        figures.append(("unloading-ss-12-18", pictures.unloading, named["SS(12-18)", POHRT_POPOV]))
        figures += [(name, getattr(pictures, name), modulus) for name in ("stiffness", "roughness")]
        figures.append(("crossover-ss-18-18", pictures.crossover))
        figures.append(("cones", pictures.cones, named["RFC10", ROUGH_PLASTIC], named["FC5", ROUGH_PLASTIC]))
        figures.append(("effective-radius", pictures.radius, modulus))

    return [plots.save(picture(*arguments), out / f"{name}.png") for name, picture, *arguments in figures]
