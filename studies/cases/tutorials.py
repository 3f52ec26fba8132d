"""LIGGGHTS's own tutorials with stock hertz and with demlaws/table, side by side.

python -m studies.cases.tutorials [FOLDER] [--steps 2000] [--only chute_wear packing] [--out out]

FOLDER: the tutorials (default: those of Debian's package liggghts-doc, or of one unpacked with `dpkg -x liggghts-doc*.deb F`:
F). Inputs are copied and changed in these places only: the model, hooke or hertz, of pair_style and walls; no dumps, which are
thousands of files; with --steps N no run is longer than N steps.
Three ways: LIGGGHTS's hertz; Hertz as a table, which must be the same; and a rough law with a history (Pohrt-Popov, Hertz
unloading, σ = 10 µm).
"""

import argparse
import re
import resource
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

import demlaws as dl
from demlaws.errors import DemlawsError
from demlaws.liggghts import build, run
from demlaws.plugins.convert import convert

TUTORIALS = (
    "chute_wear",
    "conveyor",
    "packing",
    "movingMeshGran",
    "heatTransfer_1",
    "heatTransfer_2",
    "multisphere_stone_restitution",
)
WAYS = ("stock hertz", "hertz table", "rough table")
INSTALL = "sudo apt install liggghts-doc (or unpack it: apt-get download liggghts-doc; dpkg -x liggghts-doc*.deb FOLDER)"


def find(folder=None):
    """Folder that holds the tutorials, one a folder."""
    if folder is None:
        listed = subprocess.run(["dpkg", "-L", "liggghts-doc"], capture_output=True, text=True).stdout.splitlines()
        inputs = [Path(line) for line in listed if "/in." in line]
    else:
        inputs = list(Path(folder).rglob("in.*"))
    found = {path.parent.parent for path in inputs if path.parent.name in TUTORIALS}
    if not found:
        raise DemlawsError(f"no tutorials of LIGGGHTS in {folder or 'package liggghts-doc'}: {INSTALL}, and name the folder")
    return min(found)


def tables(text, folder):
    """Write the tables of a tutorial's material: Hertz, and a rough law with a history."""
    young = float(re.search(r"youngsModulus\s+peratomtype\s+(\S+)", text)[1])
    poisson = float(re.search(r"poissonsRatio\s+peratomtype\s+(\S+)", text)[1])
    radii = [float(r) for r in re.findall(r"radius\s+constant\s+(\S+)", text)] or [0.005]
    material = dl.Material(young, poisson)
    contact = dl.Contact.between(
        material, material, radius1=min(radii), radius2=min(radii), roughness1=1e-5, roughness2=0.0, fractal_dimension=2.22
    )
    dl.law("hertz", contact).tabulate().save(folder / "hertz.tbl")
    dl.law("pohrt-popov", contact, unloading="hertz").tabulate().save(folder / "rough.tbl")


def with_hertz(text):
    """The input with hertz for hooke, whose place no table of another law takes."""
    return re.sub(r"\bmodel\s+hooke(?!/)\b", "model hertz", text)


def changed(text, way, longest=None):
    """The input with another contact model, without dumps. Shear is stock's, so that Hertz as a table is stock hertz."""
    text = with_hertz(text)
    if way != "stock hertz":
        table = f"{way.split()[0]}.tbl"
        text = convert(text, "liggghts", table).text.replace("tangential demlaws", "tangential history")
        text = text.replace(f"table {table}", f"table {table} extrapolation on")
    lines = []
    for line in text.replace("&\r\n", "&\n").splitlines():
        code = line.split("#")[0].rstrip()
        if code.startswith("dump"):
            continue
        if longest and code.split()[:1] == ["run"]:
            code = f"run {_shortened(lines, code.split(), longest)}"
        lines.append(code)
    return "\n".join(lines) + "\n"


def _shortened(lines, words, longest):
    """Steps of `run N`, `run N upto` or `run ${N}`, at most `longest`."""
    steps = int(words[1]) if words[1].isdigit() else longest
    before = sum(int(line.split()[1]) for line in lines if line.startswith("run ")) if "upto" in words else 0
    return max(0, min(steps - before, longest))


def measure(source, way, folder, longest=None):
    """Run one tutorial one way: its thermo table, processor seconds, and contact steps beyond the table."""
    shutil.copytree(source, folder)
    (folder / "post").mkdir(exist_ok=True)
    script = next(folder.glob("in.*"))
    text = script.read_text()
    tables(text, folder)
    if way != "stock hertz":
        build()  # compiled now, if need be, not in the time that is measured
    script.write_text(changed(text, way, longest))
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    log = run(script, plugin=way != "stock hertz")
    seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    said = (folder / "log.liggghts").read_text(errors="replace")
    beyond = sum(int(n) for n in re.findall(r"in this run (\d+) contact steps were beyond", said))
    return {"log": log, "seconds": seconds, "beyond": beyond}


def compare(source, out, longest=None):
    """All ways of one tutorial, one after another; rows of the table."""
    found = {way: measure(source, way, Path(out) / source.name / way.replace(" ", "_"), longest) for way in WAYS}
    stock = found["stock hertz"]
    rows = []
    for way, one in found.items():
        energy, reference = one["log"]["KinEng"], stock["log"]["KinEng"]
        n = min(len(energy), len(reference))
        off = np.abs(energy[:n] - reference[:n]) / max(reference.max(), 1e-300)
        rows.append({
            "tutorial": source.name, "way": way, "steps": int(one["log"]["Step"][-1]), "grains": int(one["log"]["Atoms"][-1]),
            "energy": float(energy[-1]), "peak": float(energy.max()),
            "first": float(off[: min(3, n)].max()), "worst": float(off.max()),
            "beyond": one["beyond"], "cost": one["seconds"] / stock["seconds"],
        })  # fmt: skip
    return rows


def table(rows):
    """The rows as text lines."""
    head = f"{'tutorial':30} {'way':12} {'steps':>7} {'grains':>7} {'KE end (J)':>11} {'KE peak':>10} "
    lines = [head + f"{'off, first':>10} {'off, most':>10} {'beyond':>9} {'cost':>5}"]
    for r in rows:
        lines.append(
            f"{r['tutorial']:30} {r['way']:12} {r['steps']:7d} {r['grains']:7d} {r['energy']:11.4g} {r['peak']:10.4g} "
            f"{r['first']:10.1e} {r['worst']:10.1e} {r['beyond']:9d} {r['cost']:5.2f}"
        )
    lines.append(
        "off: of the kinetic energy from the stock run's, over its peak: in the first rows, and in any (grains are chaotic)"
    )
    lines.append(
        "beyond: contact steps beyond the table's last row, extrapolated; cost: processor time over the stock run's, once each"
    )
    return lines


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", help="the tutorials, or a folder above them")
    parser.add_argument("--steps", type=int, metavar="N", help="no run longer than N steps (default: as the tutorials have it)")
    parser.add_argument("--only", nargs="+", choices=TUTORIALS, default=TUTORIALS, help="these only")
    parser.add_argument("--out", help="folder for inputs and logs (default: a temporary one)")
    options = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory() as scratch:
        try:
            folder = find(options.folder)
            rows = []
            for name in options.only:
                rows += compare(folder / name, options.out or scratch, options.steps)
                lines = table(rows)
                print("\n".join(lines[:-2] if len(rows) == len(WAYS) else lines[-2 - len(WAYS) : -2]), flush=True)
        except DemlawsError as error:
            print(f"tutorials: error: {error}", file=sys.stderr)
            return 2
    print("\n".join(table(rows)[-2:]))
    return 0


if __name__ == "__main__":
    sys.exit(main())
