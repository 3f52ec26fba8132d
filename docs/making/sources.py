"""Where the pictures and tables of the documentation come from: python docs/making/sources.py [--write] [NAME ...].

Without names: all. `--write` makes them again, those of stored rows in seconds to a minute each. tests/docs/test_pictures.py
compares them, and finds pictures and tables that nothing here names.
"""

import argparse
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

DOCS = Path(__file__).resolve().parents[1]
ROOT = DOCS.parent

DRAWN = sorted(path.stem for path in (DOCS / "gallery").glob("*.py"))
"""Names of docs/pictures that a script of docs/gallery draws, also when the site is built."""

FOLLOWED = {
    "contact-regime": "laws",
    "scan": "surfaces",
    "fit": "tutorials/yade-oedometer",
    "quickstart": "tutorials/first",
}
"""Pictures that the listings of a page draw; tests/docs/test_pages.py follows and compares them."""

STORED = {
    "pictures/angular.png": "studies.shapes --figure {out}",
    "pictures/creep.png": "studies.shear --creep {out}",
    "pictures/grading.png": "studies.grading --report --figure {out}",
    "pictures/neck.png": "studies.shear --neck {out}",
    "pictures/shear.png": "studies.shear --figure {out}",
    "pictures/regime.png": "studies.jamari --figure {out}",
    "pictures/repeated.png": "studies.jamari --repeat isotropic --figure {out}",
    "validation/ballast.png": "studies.ballast --report --figure {out}",
    "validation/triaxial.png": "studies.triaxial --report --figure {out}",
    "validation/experiment.png": "studies.experiment --report --figure {out}",
    "validation/small-strain.png": "studies.assembly --report --figure {out}",
    "tables/angular-bed.csv": "studies.shapes --figure {scratch}/angular.png",
    "tables/angular-small-strain.csv": "studies.shapes --small",
    "tables/attenuation.csv": "studies.assembly --attenuation --report",
    "tables/ballast-beds.csv": "studies.ballast --beds --report",
    "tables/glass-beads.csv": "studies.experiment --report --figure {scratch}/experiment.png",
    "tables/grading-heap.csv": "studies.grading heap --report",
    "tables/grading-oedometer.csv": "studies.grading oedometer --report",
    "tables/shear-springs.csv": "studies.shear --springs 11 16 22 32",
    "tables/small-strain-probes.csv": "studies.assembly --probe --report",
    "tables/small-strain-settings.csv": "studies.assembly --sensitivity --report",
    "tables/trade-softening.csv": "studies.trade --softening",
}
"""Pictures, and tables that are printed, from rows that a study keeps: arguments of `python -m`."""

MEASURED = {
    "validation/asperity.png": "python docs/making/measured.py report",
    "validation/cones.png": "python docs/making/measured.py claims",
    "validation/crossover-ss-18-18.png": "python docs/making/measured.py claims",
    "validation/deviations.png": "python docs/making/measured.py report",
    "tables/ballast-control.csv": "python -m studies.ballast --report",
    "tables/case-ballast.csv": "python -m studies.cases ballast --rows docs/tables/case-ballast.csv",
    "tables/case-compression.csv": "python -m studies.cases compression --rows docs/tables/case-compression.csv",
    "tables/case-waves.csv": "python -m studies.cases waves --rows docs/tables/case-waves.csv",
    "tables/cost-instructions.csv": "python tools/benchmarks/cachegrind.py liggghts",
    "tables/cost-memory.csv": "python tools/benchmarks/history.py; YADE: sizes of its objects",
    "tables/cost-scale.csv": "make bench-scale",
    "tables/cost-steps.csv": "the command of each row",
    "tables/cost-targets.csv": "python tools/benchmarks/targets.py",
    "tables/cost-waits.csv": "python tools/benchmarks/ratios.py --only waits",
    "tables/fit-intervals.csv": "python tools/benchmarks/bench_fit.py",
    "tables/liggghts-checks.csv": "the command of each row",
    "tables/liggghts-restitution.csv": "the case impact of liggghts_inputs",
    "tables/liggghts-tutorials.csv": "python -m studies.cases.tutorials",
    "tables/mutations.csv": "make mutations TABLE=docs/tables/mutations.csv, and its last column by docs/inside/mutations.md",
    "tables/plastic-compared.csv": "read in the sources of each row",
    "tables/plastic-differences.csv": "the command or source of each row",
    "tables/shear-ratio.csv": "the command of each row",
    "tables/shear-rest.csv": "the command of each row",
    "tables/triaxial.csv": "python -m studies.triaxial --report",
    "tables/shear-slip-loss.csv": "studies.shear, and tests/test_shear.py",
    "tables/trade-contact.csv": "python -m studies.trade; demlaws yade run -x yade_scripts/cost.py",
    "tables/trade-extremes.csv": "make stability",
    "tables/trade-fits.csv": "demlaws fit, version 0.2.0",
    "tables/trade-natives.csv": "pytest tests/engines -k natives",
    "tables/trade-packing.csv": "python -m studies.trade --scene yade liggghts --stress 500kPa; --quick to 5 MPa",
    "tables/trade-steps.csv": "python -m studies.extremes, version 0.2.0",
    "tables/triaxial-effects.csv": "python -m studies.triaxial --report",
    "tables/yade-ballast.csv": "demlaws yade run -x yade_scripts/ballast.py",
    "tables/yade-examples.csv": "demlaws yade run -x yade_scripts/examples.py",
}
"""Results of runs that take minutes to hours, and of engines: not made again by a test."""

VIEWS = {"pictures/contacts.png": "python docs/making/contacts.py GRAINS CONTACTS {out}, of the dumps of lammps_inputs/ballast"}
"""Three-dimensional views of one state of a run, which no test compares."""


def command(name, out, scratch):
    """Words of the command of a stored picture or table."""
    return [sys.executable, "-m", *shlex.split(STORED[name].format(out=out, scratch=scratch))]


def make(name, out):
    """Make a stored picture or table again, as the file `out`."""
    with tempfile.TemporaryDirectory() as scratch:
        drawn = Path(scratch) / f"new{Path(name).suffix}"  # commands do not replace pictures that they did not draw
        done = subprocess.run(command(name, drawn, scratch), cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True)
        if name.endswith(".csv"):
            Path(out).write_text(done.stdout)
        else:
            shutil.copyfile(drawn, out)


def main():
    """List the sources, or make the stored ones again."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", help="as in the list (default: all)")
    parser.add_argument("--write", action="store_true", help="make those of stored rows again")
    arguments = parser.parse_args()
    if arguments.write:
        for name in arguments.names or STORED:
            make(name, DOCS / name)
            print(DOCS / name)
        return
    known = {f"pictures/{name}.png": f"docs/gallery/{name}.py" for name in DRAWN}
    known |= {f"pictures/{name}.png": f"listings of docs/{page}.md" for name, page in FOLLOWED.items()}
    known |= {name: "python -m " + text.format(out=f"docs/{name}", scratch="FOLDER") for name, text in STORED.items()}
    for name, text in sorted({**known, **MEASURED, **VIEWS}.items()):
        if not arguments.names or name in arguments.names:
            print(f"{name:34} {text}")


if __name__ == "__main__":
    main()
