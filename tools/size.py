"""`make size`: how much there is to learn: statements, functions and classes, mechanisms, what a YADE script loads.

    python tools/size.py

Of files that git knows. Statements are those of Python's grammar without docstrings; the wheel's kB are its Python files.
"""

import ast
import graphlib
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

from test_boundaries import circle, import_graph, unit_graph

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "demlaws"
LONGEST = 600
LONGEST_FUNCTION = 60
BY_HAND = r"\b(inttoptr|ptrtoint|builder\.load|builder\.store|carray|from_address|string_at|load_\w+|store_\w+|memmove)\("
"""Accesses to memory by address instead of by the name of a field."""
BEHIND = r"\bos\.fork\b|[\"']fork[\"']|\brmtree\(|\bputenv\(|\benviron(\[[^]]+\] = |\.(setdefault|update|pop|clear)\()"
"""A process forked, a folder removed, the environment changed."""

MECHANISMS = {
    "dispatch on types": "core/dispatch.py",
    "machine code on disk": "core/cache.py",
    "tables: cells, files, certificates": "core/curve.py core/grid.py curves/t*.py",
    "curves of Gaussian asperities": "laws/family.py solvers/master_curves.py",
    "measured points as a law": "curves/points.py curves/user_curves.py",
    "functions as a law": "user_laws/*.py laws/registry.py curves/soundness.py",
    "shear: levels, partial slip": "core/shear.py core/levels.py core/slip.py yade/shear.py yade/slip.py",
    "YADE: native bridge": "yade/native.py yade/search.py yade/obj*.py yade/rec*.py yade/layout.py yade/kernel.py",
    "height maps": "surfaces/*.py solvers/contact.py solvers/scan.py solvers/ellipsoid.py solvers/summits.py laws/asperity.py",
    "choose, soften, fit": "advice/*.py",
    "conversion of inputs": "plugins/convert.py",
}
"""Mechanism → its files below demlaws/; one that is gone has none."""

SCRIPT = """
import json, sys, yade

def parts(value):
    yield value
    for name in ("fget", "fset", "func"):
        if hasattr(value, name):
            yield from parts(getattr(value, name))

import demlaws as dl
from demlaws.yade import Law2_ScGeom_MindlinPhys_Demlaws, engines
surface = dl.Surface(roughness=2.4e-6, fractal_dimension=2.2, hardness=6.27e9)
O.materials.append(FrictMat(young=60e9, poisson=0.25, density=2680, label="granite"))
O.bodies.append([sphere((0, 0, 0), 0.01, fixed=True), sphere((0, 0, 0.02), 0.01)])
law = Law2_ScGeom_MindlinPhys_Demlaws("pohrt-popov", "hertz", {"granite": surface})
O.engines = engines(law)
O.dt = 1e-7
O.run(10, True)
loaded = [m.__file__ for name, m in list(sys.modules.items()) if name.partition(".")[0] == "demlaws" and m.__file__]
owners = {"yade": yade, "wrapper": yade.wrapper}
owners |= {name: value for name, value in vars(yade.wrapper).items() if isinstance(value, type)}
replaced = [
    f"{owner}.{name}"
    for owner, place in owners.items()
    for name, value in vars(place).items()
    if any(getattr(one, "__globals__", {}).get("__name__", "").startswith("demlaws.") for one in parts(value))
]
found = {"loaded": loaded, "replaced": replaced}
open(sys.argv[-1], "w").write(json.dumps(found))
"""
"""A YADE script with one law: what it loads of demlaws, and which entry points of YADE are replaced, also before the script."""


def layers(graph):
    """Layers of a graph without circles, the lowest first: each imports only from those before it."""
    sorter, found = graphlib.TopologicalSorter(graph), []
    sorter.prepare()
    while sorter.is_active():
        found.append(sorter.get_ready())
        sorter.done(*found[-1])
    return found


def files(*patterns):
    """Paths of files that git knows."""
    text = subprocess.run(["git", "ls-files", "--", *patterns], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    return [ROOT / line for line in text.splitlines() if (ROOT / line).is_file()]


def statements(paths):
    """(statements without docstrings, functions and classes) of Python files."""
    nodes = [node for path in paths for node in ast.walk(ast.parse(path.read_text()))]
    named = [node for node in nodes if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef)]
    return sum(isinstance(node, ast.stmt) and not is_docstring(node) for node in nodes), len(named)


def is_docstring(node):
    """Whether a statement is text alone: the docstring of a module, class, function or constant."""
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)


def lines(paths):
    """Lines of all the files."""
    return sum(path.read_bytes().count(b"\n") for path in paths)


def matches(pattern, paths):
    """Matches of a regular expression in all the files."""
    return sum(len(re.findall(pattern, path.read_text())) for path in paths)


def long_functions(paths):
    """Names of functions of more than LONGEST_FUNCTION lines, docstrings not counted."""
    found = []
    for path in paths:
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.FunctionDef):
                text = node.body[0].end_lineno - node.body[0].lineno + 1 if ast.get_docstring(node) else 0
                if node.end_lineno - node.lineno + 1 - text > LONGEST_FUNCTION:
                    found.append(f"{path.relative_to(ROOT)}: {node.name}")
    return found


def under_yade():
    """(modules that the script loads, their lines, replaced entry points), or dashes without YADE."""
    from demlaws.errors import DemlawsError
    from demlaws.yade.run import command, environment

    with tempfile.TemporaryDirectory() as folder:
        script, answer = Path(folder) / "script.py", Path(folder) / "found.json"
        script.write_text(SCRIPT)
        try:
            done = subprocess.run(command(script, [answer]), env=environment(), capture_output=True, text=True, cwd=folder)
        except DemlawsError as error:
            print(f"without YADE: {error}", file=sys.stderr)
            return "-", "-", "-"
        if not answer.is_file():
            raise SystemExit(f"YADE stopped: {done.stdout[-300:]}{done.stderr[-300:]}")
        found = json.loads(answer.read_text())
    return len(found["loaded"]), lines(map(Path, found["loaded"])), len(found["replaced"])


def figures():
    """(what, figure, goal) of each line."""
    wheel, studies, tests = (files(f"{folder}/*.py") for folder in ("demlaws", "studies", "tests"))
    source = files("*.cpp", "*.h")
    long = [path for path in wheel + studies if lines([path]) > LONGEST]
    modules, loaded, replaced = under_yade()
    graphs = [import_graph(PACKAGE), import_graph(ROOT / "studies")]
    units = unit_graph(graphs[0])
    of_wheel, functions = statements(wheel)
    return [
        ("Python in the wheel: statements", of_wheel, 13_900),
        ("functions and classes", functions, 1_750),
        ("Python in the wheel: kB", round(sum(path.stat().st_size for path in wheel) / 1000), 900),
        ("C++: lines", lines(path for path in source if "tests" not in path.parts), 6_000),
        ("tests: statements", statements(tests)[0], "-"),
        ("studies: statements", statements(studies)[0], "-"),
        ("a YADE script with one law: modules", modules, 45),
        ("a YADE script with one law: lines", loaded, 9_000),
        ("modules directly in demlaws", len(list(PACKAGE.glob("*.py"))), 14),
        ("layers of imports", len(layers(units)), 18),
        ("circles of imports, also in studies", sum(bool(circle(graph)) for graph in (*graphs, units)), 0),
        ("memory by hand in yade/ (calls)", matches(BY_HAND, files("demlaws/yade/*.py")), 20),
        ("imports of numba.core or numba.np", matches(r"(?m)^\s*(from|import) numba\.(core|np)\b", wheel), 2),
        ("forks, rmtree, environment writes", matches(BEHIND, wheel), 0),
        (f"functions over {LONGEST_FUNCTION} lines", len(long_functions(wheel + studies + tests)), 0),
        (f"files over {LONGEST} lines", len(long), 0),
        ("replaced entry points of YADE", replaced, 8),
        ("files with exec", sum(bool(re.search(r"\bexec\(", path.read_text())) for path in wheel), 1),
    ]


def main():
    """Print the figures, and which of them are above their goal."""
    for what, figure, goal in figures():
        above = isinstance(figure, int) and isinstance(goal, int) and figure > goal
        print(f"{what:38}{figure:>9}   goal {goal:>6}{'   above' if above else ''}")
    print(f"\n{'mechanism':38}{'statements':>11}{'names':>7}")
    for mechanism, patterns in MECHANISMS.items():
        paths = [path for pattern in patterns.split() for path in PACKAGE.glob(pattern)]
        print(f"{mechanism:38}{statements(paths)[0]:>11}{statements(paths)[1]:>7}" if paths else f"{mechanism:38}{'gone':>11}")


if __name__ == "__main__":
    main()
