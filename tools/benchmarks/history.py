"""Bytes of history per contact in LIGGGHTS and LAMMPS, by option, ours and stock: values of eight bytes.

    python tools/benchmarks/history.py [liggghts] [lammps]

The number of the partner (four bytes in the neighbour list) is not part of it. LIGGGHTS is asked which columns a dump of the
history has. In LAMMPS two spheres touch, or are apart: the restart file of a contact is longer by what both of them store, the
number of the partner and the history.
"""

import sys
import tempfile
from importlib import import_module
from itertools import count, takewhile
from pathlib import Path

import bench_engines as bench

from demlaws.errors import DemlawsError
from studies.trade.liggghts_oedometer import data_text

OURS = {
    **{f"{n} level{'s' * (n > 1)}{' (default)' * (n == 3)}": f"levels {n}" for n in (1, 2, 3, 4, 8)},
    "partial slip": "shear slip",
}
STOCK = {
    "liggghts": {"stock, history": "hertz tangential history"},
    "lammps": {
        f"stock, {name}": f"hertz/material 6.06e8 100.0 0.25 tangential {name} NULL 1.0 0.5"
        for name in ("mindlin", "mindlin/force", "mindlin_rescale", "mindlin_rescale/force")
    },
}
TOUCHES, APART = 3.99e-3, 4.2e-3  # distance of the centres [m]


def run(engine, folder, name, distance=TOUCHES, more=""):
    """Run two spheres; size of the restart file [B]."""
    atoms = [(1, 4e-3, 2650.0, x, 0.0, 0.0) for x in (0.0, distance)]
    (folder / "block.data").write_text(data_text([(-0.01, 0.02)] * 3, atoms, [(0.0,) * 6] * 2, types=1))
    start = bench.LIGGGHTS if engine == "liggghts" else bench.LAMMPS
    (folder / "in.cost").write_text(start + more + bench.RUN)
    words = OURS.get(name)
    if words is None:
        model = STOCK[engine][name]
    elif engine == "liggghts":
        model = f"demlaws/table tangential demlaws table hysteretic.tbl {words}"
    else:
        model = f"demlaws/table hysteretic.tbl 6.06e8 100.0 0.25 {words} tangential demlaws 1.0 0.5"
    values = {"steps": 1, "warm": 1, "model": model, "ranks": 1}
    import_module(f"demlaws.{engine}.run").run(folder / "in.cost", variables=values, plugin=words is not None)
    return (folder / "state.restart").stat().st_size


def has_column(folder, name, number):
    """Whether LIGGGHTS dumps this column of the history."""
    try:
        run("liggghts", folder, name, more=f"compute h all pair/gran/local history\ndump d all local 1 h.txt c_h[{number}]\n")
    except DemlawsError as error:
        if "out-of-range" not in str(error):
            raise
        return False
    return True


def history(engine, folder, name):
    """Bytes of history of a contact, in a folder with the tables of `bench_engines`."""
    if engine == "liggghts":
        return 8 * sum(1 for _ in takewhile(lambda number: number == 1 or has_column(folder, name, number), count(1)))
    return (run(engine, folder, name) - run(engine, folder, name, APART)) // 2 - 8


def main():
    with tempfile.TemporaryDirectory() as scratch:
        bench.write_tables(Path(scratch))
        for engine in sys.argv[1:] or STOCK:
            for name in (*STOCK[engine], *OURS):
                print(f"{engine:10}{name:32}{history(engine, Path(scratch), name):6}", flush=True)


if __name__ == "__main__":
    main()
