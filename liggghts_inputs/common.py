"""What the cases share: the granite of the tests, tables, the command line of a run.py.

Every case folder has an input (in.*), a run.py that makes its tables, runs it and checks it, and a check.py that reads
the output: `python run.py [--quick] [-np N] [--out FOLDER]`, `python check.py FOLDER`.
"""

import argparse
import importlib.util
import shutil
import sys
import time
from pathlib import Path

import numpy as np

import demlaws as dl

GRANITE = dl.Material(young=60.6e9, poisson=0.25, hardness=6.266e9, density=2650.0)


def contact(radius1, radius2=float("inf"), roughness=1.7e-6, fractal_dimension=2.22, material=GRANITE):
    """Contact of two granite bodies of the same surface: σ = √2 × the rms roughness of one."""
    return dl.Contact.between(
        material,
        material,
        radius1=radius1,
        radius2=radius2,
        roughness1=roughness,
        roughness2=roughness,
        fractal_dimension=fractal_dimension,
    )


def table(folder, name, law, rtol=1e-5):
    """Write a table of `law` as folder/name and return the name."""
    law.tabulate(rtol=rtol).save(Path(folder) / name)
    return name


def copy_inputs(case, folder):
    """The case's own files, copied to where it runs."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "post").mkdir(exist_ok=True)
    for file in Path(case).parent.iterdir():
        if file.name.startswith("in.") or file.suffix in (".stl", ".inc"):
            shutil.copy(file, folder / file.name)
    return folder


def load(path):
    """A case's run.py or check.py as a module."""
    spec = importlib.util.spec_from_file_location(f"{Path(path).parent.name}_{Path(path).stem}", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def against_law(log, law, limit=1e-5, where="", history=()):
    """Findings: force and energies of a thermo log, and those columns of a contact's history, against the law's path along the
    log's overlaps."""
    path = law.follow(log["overlap"])

    def worst(found, expected, scale):
        return np.abs(found - expected).max() / scale.max()

    findings = [(f"{where}force against the law, of the maximum", worst(log["force"], path.force, path.force), limit)]
    touching = log["overlap"] > 0
    for column, expected in zip(history, (path.maximum_overlap, path.plastic_overlap), strict=False):
        error = worst(log[column][touching], expected[touching], path.maximum_overlap)
        findings.append((f"{where}history value {column} against the law, of the largest overlap", error, limit))
    for column, kind, expected in (("stored", "stored energy", path.stored), ("lost", "plastic dissipation", path.dissipated)):
        error = worst(log[column], expected, path.work)
        findings.append((f"{where}{kind} (compute demlaws/energy), of the largest work", error, limit))
    return findings


def report(findings):
    """Print (what, value, limit) lines; False if a value exceeds its limit."""
    good = True
    for what, value, limit in findings:
        passed = value <= limit
        good &= bool(passed)
        print(f"{'pass' if passed else 'FAIL'}  {what}: {value:.3g} (allowed {limit:g})")
    return good


def run_main(file, simulate, description):
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="a smaller size, as the tests run it")
    parser.add_argument("-np", type=int, default=1, help="number of MPI ranks")
    parser.add_argument("--figure", help="draw the result here (cases that have a picture)")
    parser.add_argument("--out", default=str(Path(file).parent / "out"), help="folder for tables and output")
    options = parser.parse_args()
    check = load(Path(file).parent / "check.py")
    if options.figure and not hasattr(check, "draw"):
        parser.error("this case has no picture: leave --figure out")
    begin = time.perf_counter()
    folder = copy_inputs(file, options.out)
    simulate(folder, options.np, options.quick)
    print(f"ran in {time.perf_counter() - begin:.1f} s, output in {folder}")
    good = report(check.check(folder))
    if options.figure:
        print(f"wrote {check.draw(folder, options.figure)}")
    sys.exit(0 if good else 1)


def check_main(file, check):
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(file).parent / "out"
    sys.exit(0 if report(check(folder)) else 1)
