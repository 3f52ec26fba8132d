"""What laws cost in a LIGGGHTS step: a close packing that stands still, every way in turn, round after round."""

import subprocess
import tempfile
from pathlib import Path

import numpy as np

from demlaws.engines import SHARED, compiler
from demlaws.errors import DemlawsError
from demlaws.liggghts.build import PLUGIN
from demlaws.liggghts.run import HEAD, run, timings
from studies.trade.liggghts_oedometer import MATERIAL, _data, model_lines, pairwise

# setforce keeps the grains still; fix freeze would keep them out of the list of neighbours
CASE = """\
processors      1 1 1
read_data       start.data
neighbor        {skin:.10g} bin
neigh_modify    delay 0 contact_distance_factor 1.01
{material}fix             gravity all gravity 9.81 vector 0 0 -1
fix             move all nve/sphere
fix             still all setforce 0. 0. 0.
thermo_style    custom step atoms ke
thermo          100000
run             20
run             {steps}
"""


def close_packing(side, radius, overlap):
    """Centres of side³ equal spheres, and the number of their contacts."""
    i, j, k = np.meshgrid(*[np.arange(side)] * 3, indexing="ij")
    x, y, z = 2 * i + (j + k) % 2, 3**0.5 * (j + (k % 2) / 3), 2 * 6**0.5 / 3 * k
    centres = np.stack([x, y, z], -1).reshape(-1, 3) * (radius - 0.5 * overlap)
    from scipy.spatial import cKDTree

    return centres, len(cKDTree(centres).query_pairs(2.0 * radius - 0.5 * overlap))


def header_cost(table, contact, largest, folder):
    """ns per contact of the law's step in the C++ header alone, at overlaps up to `largest` [m]."""
    program = Path(folder) / "cost"
    if not program.is_file():
        flags = [flag for flag in PLUGIN.flags if flag not in ("-fPIC", "-shared")]
        source = str(Path(__file__).parent / "cost.cpp")
        command = [compiler() or "g++", *flags, "-march=native", f"-I{SHARED}", source, "-o", str(program), "-ldl"]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            raise DemlawsError(f"cost.cpp did not compile: {done.stderr.strip()[:300]}")
    arguments = [table, contact.modulus, contact.radius, contact.roughness, largest, 4000, 200]
    done = subprocess.run([str(program), *map(str, arguments)], capture_output=True, text=True)
    if done.returncode:
        raise DemlawsError(f"the cost of {table} could not be measured: {done.stderr.strip()[:300]}")
    return float(done.stdout.split()[0])


def write(folder, given, way, centres, width, steps):
    """Input and tables of one way; whether it needs the plugin."""
    model, words, more = model_lines(folder, given, way)
    values = {"model": model, "words": words, "more": more, "types": 3, "dt": 1e-9}
    values["young"] = " ".join([f"{given['young']:.10g}"] * 3)
    values["poisson"] = " ".join([f"{given['poisson']:.10g}"] * 3)
    values["restitution"], values["friction"] = pairwise([1.0] * 5)[2:], pairwise([0.5] * 5)[2:]
    text = HEAD + CASE.format(material=MATERIAL.format(**values), steps=steps, skin=0.1 * given["radius"])
    (folder / "start.data").write_text(_data(centres, np.full(len(centres), given["radius"]), width, given["density"]))
    (folder / "in.cost").write_text(text)
    return model == "demlaws/table"


def measure(given, ways, side=12, rounds=5, steps=200, progress=lambda things: things, write=write, run=run, timings=timings):
    """One dict per way: contacts, ns per step (whole, pair loop), ns per contact of the law alone (None for the engine's own).

    write, run, timings: those of the engine.
    """
    radius, overlap = given["radius"], given["overlap"]
    centres, contacts = close_packing(side, radius, overlap)
    given = {**given, "radii": [radius, 1.01 * radius]}  # two types and the walls', as in the scene; one of them occurs
    with tempfile.TemporaryDirectory() as scratch:
        made = []
        for number, way in enumerate(ways):
            folder = Path(scratch) / str(number)
            folder.mkdir()
            ours = write(folder, given, way, centres, 3.0 * side * radius, steps)
            alone = None
            if ours:
                contact = given["contact"]
                alone = header_cost(sorted(folder.glob("*.tbl"))[0], contact, overlap, scratch)
            made.append((folder, ours, alone, []))
        for _ in progress(range(rounds)):
            for folder, ours, _, times in made:
                run(folder / "in.cost", plugin=ours, log="log.cost")
                times.append(timings(folder / "log.cost"))
        found = []
        for _, _, alone, times in made:
            step, pair = (1e9 * min(t[n] for t in times) / steps for n in (0, 1))
            found.append({"contacts": contacts, "step": step, "pair": pair, "alone": alone})
        return found
