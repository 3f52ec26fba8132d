"""The command `demlaws granite`: tables, claims, CSV files and figures."""

import math

from demlaws import granite, plots
from demlaws.errors import quiet
from demlaws.files import save_csv, wrapped
from demlaws.granite import claims, figures as pictures
from demlaws.granite.verdicts import VERDICTS, counts
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
    runs = {}
    for test, name in tqdm(jobs, desc="granite", unit="run", leave=False, disable=None):
        runs.setdefault(test.name, []).append(granite.run_test(name, test))
    output.print(*(test_lines if arguments.verbose else overview_lines)(tests, runs))
    output.print("", *note_lines(tests, runs, arguments.verbose))
    test_names = None if arguments.test is None else [tests[0].name]
    judged = [] if arguments.law else claims.granite_claims(test_names)
    if judged:
        output.print(*claim_lines(judged, arguments.verbose, f"E* = {granite.MODULI['figures'] / 1e9:.1f} GPa"))
    with quiet():  # the notes have been printed with the tables
        files = write_csv(arguments.out, tests, runs, judged)
        if plots.available():
            files += draw(arguments.out, tests, runs, modulus, whole=not (arguments.test or arguments.law))
        else:
            output.print("no figures: matplotlib is missing (pip install 'demlaws[plots]')")
    output.print(f"{len(files)} files written to {arguments.out}/" + ("" if arguments.verbose else "; --verbose: all numbers"))


def overview_lines(tests, runs):
    """One table: displacement gained by each law in each test."""
    spans = ["{:g}-{:g} N".format(*granite.forces_of(test)[:2]) for test in tests]
    yield f"{'displacement (µm)':17}" + "".join(f"{test.name:>11}" for test in tests)
    yield " " * 17 + "".join(f"{span:>11}" for span in spans)
    for row in zip(*(runs[test.name] for test in tests), strict=True):
        yield f"  {row[0].law.name:15}" + "".join(f"{granite.gains(result)[0]:11.1f}" for result in row)


def test_lines(tests, runs):
    """A table for each test: displacement and stiffness of each law."""
    for test in tests:
        low, high, loads = granite.forces_of(test)
        yield (
            f"\n{test.name}: R = {test.radius * 1e3:.2f} mm, σ = {test.sigma * 1e6:.2f} µm, Df = {test.fractal_dimension}, "
            f"E* = {test.contact.modulus / 1e9:.2f} GPa, H = {test.contact.hardness / 1e9:.3f} GPa"
        )
        yield f"  {'law':16} {f'µm, {low:g} to {high:g} N':>17} " + "".join(f"{f'K {f:g} N':>10}" for f in loads) + "   (N/mm)"
        for result in runs[test.name]:
            displacement, stiffnesses = granite.gains(result)
            yield f"  {result.law.name:16} {displacement:17.1f} " + "".join(f"{k:10.0f}" for k in stiffnesses)
        for result in runs[test.name]:
            if test.cyclic and result.law.definition.before_yield()[0] is not None:
                yield from _stage_lines(result)


def note_lines(tests, runs, verbose):
    """Assumed quantities; each limit that is exceeded once, with its laws and loads over the tests, or how many there are."""
    for assumed in dict.fromkeys(test.assumed for test in tests if test.assumed):
        yield wrapped(f"{', '.join(test.name for test in tests if test.assumed == assumed)}: {assumed}")
    warned = {}
    for run in (run for test in tests for run in runs[test.name]):
        for breach in run.breaches:
            side = "above" if breach.value > breach.bound else "below"
            warned.setdefault((side, breach.reason), []).append((breach.bound, run.law.name))
    if warned and not verbose:
        yield f"{len(warned)} warnings of loads outside the range of a law: --verbose"
    for (side, reason), found in warned.items() if verbose else ():
        span = " to ".join(dict.fromkeys(f"{load:.3g}" for load, _ in (min(found), max(found))))
        yield wrapped(f"warning: {', '.join(dict.fromkeys(name for _, name in found))} {side} {span} N: {reason}")


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


def claim_lines(judged, verbose, other=""):
    """One line per claim, by verdict; verbose: with numbers and criterion; other: name of the other E*."""
    yield ""
    for verdict in VERDICTS:
        rows = [claim for claim in judged if claim.verdict == verdict]
        if rows:
            yield f"{verdict} ({len(rows)}):"
        for claim in rows:
            changed = "*" if claim.other_verdict not in ("", verdict) else " "
            yield f"{changed} {claim.place:11} {claim.test:20} {claim.claim}"
            if verbose:
                texts = [f"{claim.gives} [{claim.criterion}]" if claim.gives else f"[{claim.criterion}]"]
                texts += [f"with {other} {claim.other_verdict}: {claim.other_gives}"] if claim.other_gives else []
                yield from (wrapped(text, "      ", "        ") for text in texts)
    yield f"{len(judged)} claims: {counts(claim.verdict for claim in judged)}"
    if other:
        yield f"* another verdict with {other}:"
        yield f"  {counts(claim.other_verdict or claim.verdict for claim in judged)}"


def write_csv(out, tests, runs, judged):
    """Write paths, cycles, summary and claims as CSV; returns the files."""
    files, summary = [], []
    for test in tests:
        low, high, loads = granite.forces_of(test)
        for result in runs[test.name]:
            name, (displacement, stiffnesses) = result.law.name, granite.gains(result)
            k = dict(zip(loads, stiffnesses, strict=True))
            note = "; ".join(f"{name} {breach.range}: {breach.reason}" for breach in result.breaches)
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
    if judged:
        other = f" with E* = {granite.MODULI['figures'] / 1e9:.1f} GPa"
        titles = ["place", "test", "claim", "run gives", "verdict", "criterion", "run gives" + other, "verdict" + other]
        files.append(save_csv(out / "claims.csv", titles, judged))
    return files


def draw(out, tests, runs, modulus, whole):
    """Draw all figures of these tests, with the E* of this name; returns the files."""
    figures = []  # name, function that draws, its arguments
    for test in tests:
        figures.append((f"force-{test.key}", pictures.force, test, runs[test.name]))
        yielding = [run for run in runs[test.name] if test.cyclic and run.law.definition.before_yield()[0] is not None]
        figures += [(f"cycles-{test.key}", pictures.cycling, run) for run in yielding]
    if whole:
        named = {(run.test.name, run.law.name): run for test in tests for run in runs[test.name]}
        figures.append(("unloading-ss-12-18", pictures.unloading, named["SS(12-18)", POHRT_POPOV], modulus))
        figures += [(name, getattr(pictures, name), modulus) for name in ("stiffness", "roughness")]
        figures.append(("crossover-ss-18-18", pictures.crossover))
        figures.append(("cones", pictures.cones, named["RFC10", ROUGH_PLASTIC], named["FC5", ROUGH_PLASTIC]))
        figures.append(("effective-radius", pictures.radius, modulus))

    return [plots.save(picture(*arguments), out / f"{name}.png") for name, picture, *arguments in figures]
