"""What imports what, what an import costs, and that compiled code comes from the cache and never from yesterday."""

import ast
import os
import shutil
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import pytest

import demlaws
from demlaws.laws import MODULES

PACKAGE = Path(demlaws.__file__).parent
COMPILED = [path.relative_to(PACKAGE).as_posix() for path in sorted((PACKAGE / "core").glob("*.py"))]
OUTSIDE = {"numpy", "numba", "llvmlite"}
STANDARD = {"math", "typing", "types", "collections", "hashlib", "pathlib", "functools", "__future__"}
INSIDE = ("demlaws.core", "demlaws.errors")


def imports(path):
    """(module, whether it is imported by importing the file) of every import statement."""
    tree = ast.parse(path.read_text())
    top = {id(node) for node in tree.body}
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from ((alias.name, id(node) in top) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path.name}: relative import"
            yield node.module, id(node) in top


@pytest.mark.parametrize("file", COMPILED)
def test_the_compiled_core_imports_nothing_else(file):
    """numpy, numba, llvmlite, a little of the standard library, and itself: no engine, file or plot."""
    for module, _ in imports(PACKAGE / file):
        root = module.partition(".")[0]
        assert root in OUTSIDE | STANDARD or module.startswith(INSIDE), f"{file} imports {module}"


def test_every_law_has_one_file():
    files = {path.stem for path in (PACKAGE / "laws").glob("*.py") if "\nLAW = " in path.read_text()}
    assert files == set(MODULES)


def test_only_the_shell_knows_plots_and_engines():
    """matplotlib at import in plots.py only; scipy, tqdm and matplotlib inside functions everywhere else."""
    heavy = {"scipy", "matplotlib", "tqdm", "pandas", "yade", "liggghts", "SurfaceTopography", "mpmath", "pytest"}
    for path in PACKAGE.rglob("*.py"):
        where = path.relative_to(PACKAGE).as_posix()
        if where.startswith(("plots/", "yade/", "liggghts/", "measure/")):
            continue
        at_import = {module.partition(".")[0] for module, top in imports_anywhere(path) if top}
        assert not at_import & heavy, f"{where} imports {at_import & heavy} when it is imported"


def imports_anywhere(path):
    for node in ast.walk(ast.parse(path.read_text())):
        top = getattr(node, "col_offset", 1) == 0
        if isinstance(node, ast.Import):
            yield from ((alias.name, top) for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module, top


def python(code, folder=PACKAGE.parent, **changes):
    environment = {**os.environ, "PYTHONPATH": str(folder), **changes}
    if folder != PACKAGE.parent:  # a copy keeps its cache beside itself
        environment.pop("NUMBA_CACHE_DIR", None)
    result = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(code)],
        env=environment,
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert result.returncode == 0, result.stderr
    return result.stdout.strip()


def test_import_leaves_heavy_packages_alone():
    code = """
        import sys
        import demlaws
        print(*sorted({"scipy", "matplotlib", "tqdm", "pandas", "mpmath"} & set(sys.modules)))
    """
    # whatever numba and numpy themselves bring along is not ours
    bare = python(code.replace("import demlaws", "import numba"))
    assert set(python(code).split()) <= set(bare.split())


def test_import_costs_little_more_than_numba():
    """The goal is 1.3 times `import numba` (measured 1.1 to 1.2); 1.5 allows for a busy machine. Interleaved, best of 7."""
    best = {"numba": float("inf"), "demlaws": float("inf")}
    for _ in range(7):
        for name in best:
            start = time.perf_counter()
            python(f"import {name}")
            best[name] = min(best[name], time.perf_counter() - start)
    assert best["demlaws"] <= 1.5 * best["numba"], best


RUN_EVERYTHING = """
    import warnings
    warnings.simplefilter("ignore")
    from numba.core import event

    class Count(event.Listener):
        compiled = []
        def on_start(self, e):
            self.compiled.append(str(e.data.get("dispatcher")))
        def on_end(self, e):
            pass

    event.register("numba:compile", Count())
    import numpy as np
    import demlaws as dl
    from demlaws.laws.registry import registry
    from demlaws.make import example
    from demlaws.core.unloading import RULES
    contact = dl.Contact(radius=4.35e-3, modulus=32.32e9, roughness=2.40e-6, fractal_dimension=2.22, hardness=6.266e9)
    for name, definition in registry().items():
        for unloading in RULES if name == "pohrt-popov" else ("elastic", "hertz", "thornton"):
            try:
                law = example(name, contact, unloading)
            except dl.DemlawsError:
                continue
            overlap = np.linspace(1e-7, 1e-5, 100)
            law.force(1e-6), law.stiffness(1e-6), law.energy(1e-6), law.overlap(10.0)
            law.evaluate(overlap, law.new_state(100) if law.state_size else None)
            dl.driver.displacement_controlled(law, [1e-5, 5e-6])
            dl.driver.force_controlled(law, [50.0, 1.0])
            dl.driver.impact(law, 0.01, 0.05, 100)
            dl.timestep(law, 0.01, 50.0)
            if name == "pohrt-popov":
                law.tabulate(rtol=1e-3).evaluate(overlap, law.new_state(100) if law.state_size else None)
    print(len(Count.compiled), *Count.compiled[:5])
"""


def test_a_second_process_compiles_nothing():
    python(RUN_EVERYTHING)
    compiled, *which = python(RUN_EVERYTHING).split(maxsplit=1)
    assert compiled == "0", which


def test_the_count_of_compilations_can_fail(tmp_path):
    """With an empty cache the same count is far from 0."""
    code = RUN_EVERYTHING.replace("registry().items()", "list(registry().items())[:1]").replace('"hertz", "thornton"', "")
    assert int(python(code, NUMBA_CACHE_DIR=str(tmp_path)).split()[0]) > 3


def test_editing_a_law_is_noticed(tmp_path):
    """The loop that holds a law's machine code lives in another file than the law: its cache must follow the law."""
    shutil.copytree(PACKAGE, tmp_path / "demlaws", ignore=shutil.ignore_patterns("__pycache__"))
    code = """
        import demlaws as dl
        assert dl.__file__.startswith(FOLDER), dl.__file__
        law = dl.law("hertz", dl.Contact(radius=1e-2, modulus=1e10))
        print(repr(law.stiffness(1e-6)))
    """.replace("FOLDER", repr(str(tmp_path)))
    first = float(python(code, tmp_path))
    assert float(python(code, tmp_path)) == first
    file = tmp_path / "demlaws" / "laws" / "hertz.py"
    text = file.read_text()
    assert text.count("1.5 * stiffness") == 1
    file.write_text(text.replace("1.5 * stiffness", "3.0 * stiffness"))
    assert float(python(code, tmp_path)) == 2 * first
    # the files of the old law are gone, and what is there belongs to one tag of the core
    caches = [path.name for path in (tmp_path / "demlaws" / "core" / "__pycache__").glob("loops.batch_loop*.nbi")]
    assert len(caches) == 1, caches


def test_works_where_no_folder_takes_a_cache():
    """A package installed where its user may not write, who has no home to write to either: slower, not broken."""
    code = """
        import numba.core.caching
        assert numba.core.caching.CacheImpl._locator_classes
        numba.core.caching.CacheImpl._locator_classes = []
        import demlaws as dl
        print(dl.law("hertz", dl.Contact(radius=1e-2, modulus=1e10)).force(1e-6) > 0)
    """
    assert python(code) == "True"
