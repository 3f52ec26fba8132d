"""Layers and imports: which module may import which, and what an import or a call for help must not load."""

import ast
import graphlib
import importlib
import inspect
import pkgutil
import re

import pytest
from processes import PACKAGE, python

import demlaws
from demlaws.cli import COMMANDS
from demlaws.core.unloading import RULES
from demlaws.laws import MODULES

PROJECT = PACKAGE.parent


def imports(path):
    """Full names that a file imports, when it is loaded or later, but for those that only type checkers read."""
    todo = [ast.parse(path.read_text())]
    while todo:
        node = todo.pop()
        if isinstance(node, ast.If) and getattr(node.test, "id", "") == "TYPE_CHECKING":
            continue
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0 and node.module, f"{path}: relative import"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
        todo += ast.iter_child_nodes(node)


def import_graph(folder):
    """Module → the modules of the same package that it imports."""
    paths = {path: path.relative_to(folder.parent).with_suffix("").parts for path in folder.rglob("*.py")}
    modules = {".".join(parts).removesuffix(".__init__"): path for path, parts in paths.items()}
    graph = {}
    for module, path in modules.items():
        used = set(imports(path))
        while found := used - set(modules):  # names that are taken from a module
            used = used - found | {name.rpartition(".")[0] for name in found} - {""}
        graph[module] = used - {module}
    return graph


def circle(graph):
    """Modules that import one another, directly or through others; empty if there are none."""
    try:
        graphlib.TopologicalSorter(graph).prepare()
    except graphlib.CycleError as error:
        return error.args[1]
    return []


STRINGS = {
    "lazy.py": "the lazy public names",
    "yade/__init__.py": "the lazy public names",
    "cli/__init__.py": "the table of commands",
    "laws/registry.py": "the table of laws, and entry points: a law is imported when it is needed",
    "yade/scene.py": "a command that YADE runs in __main__",
}
"""Files that may import a module of the package by string, and why: such an import hides a circle from readers and tools."""


def test_modules_are_imported_by_statement():
    by_string = re.compile(r"(?:import_module|__import__|run_module)\(|find_spec\(.demlaws")
    found = {path for path in PACKAGE.rglob("*.py") if by_string.search(path.read_text())}
    assert {path.relative_to(PACKAGE).as_posix() for path in found} == set(STRINGS)


@pytest.mark.parametrize("folder", [PACKAGE, PROJECT / "studies"], ids=lambda folder: folder.name)
def test_no_import_circles(folder):
    assert circle(import_graph(folder)) == []


def test_every_law_has_one_file():
    files = {path.stem for path in (PACKAGE / "laws").glob("*.py") if "\nLAW = " in path.read_text()}
    assert files == set(MODULES)


def test_names_of_laws_are_written_in_one_file():
    """Outside laws/ a law is named by a constant of laws/__init__.py. The same words also name solvers' models."""
    written = set(demlaws.laws())
    names = vars(importlib.import_module("demlaws.laws"))
    assert {value for name, value in names.items() if name.isupper() and value is not MODULES} <= written
    written -= {*RULES, "hertz", "eepa", "luding"}  # rules, and what engines call their own models
    for path in PACKAGE.rglob("*.py"):
        where = path.relative_to(PACKAGE).as_posix()
        if not where.startswith("laws/") and where != "solvers/master_curves.py":
            constants = {node.value for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.Constant)}
            assert not constants & written, f"{where}: take the constant of demlaws.laws"


FACTS = {
    r"poisson\*\*2\)|1\.0 / \(1\.0 / |hypot\((\*sq|self\.roughness|roughness1)": "contact.py",  # E*, R, σ
    r"[\"']/[\"'] in ": "files.py",  # whether a word names a file
}
"""Formulas and decisions → the only file of the package that has them."""


@pytest.mark.parametrize(("pattern", "home"), FACTS.items())
def test_facts_have_one_place(pattern, home):
    paths = [path for path in PACKAGE.rglob("*.py") if re.search(pattern, path.read_text())]
    assert [path.relative_to(PACKAGE).as_posix() for path in paths] == [home]


LEVELS = (
    "errors lazy",
    "core files units contact",
    "surfaces solvers surface laws",
    "curves regime",
    "responses law materials make shear timestep driver plots",
    "plugins yade user_laws lammps liggghts",
    "granite advice",
    "cli",
)
"""Levels of the package, the lowest first: a top-level module or folder imports from its own level and from those below."""


def unit(module):
    """Top-level module or folder of the package that a module is or lies in; `__init__` for the package itself."""
    return [*module.split("."), "__init__"][1]


def unit_graph(graph):
    """Top-level module or folder → those that it imports, from a graph of modules."""
    units = {unit(module): set() for module in graph}
    for module, used in graph.items():
        units[unit(module)] |= {unit(other) for other in used} - {unit(module)}
    return units


def test_imports_go_one_way():
    units = unit_graph(import_graph(PACKAGE))
    assert circle(units) == [], "folders import one another"
    level = {name: n for n, names in enumerate(LEVELS) for name in names.split()}
    upwards = [(name, other) for name in units for other in units[name] if level.get(name, len(LEVELS)) < level.get(other, -1)]
    assert not upwards
    for engine in (engines := {"yade", "liggghts", "lammps"}):
        assert not units[engine] & engines, f"{engine}: no engine imports another"


def test_studies_import_the_package_and_not_the_reverse():
    """Studies are not in the wheel; the package has the curves and costs that it needs in advice/measured_costs.json."""
    for folder, refused in ((PACKAGE, {"studies", "tests"}), (PROJECT / "studies", {"tests"})):
        for path in folder.rglob("*.py"):
            assert not {name.partition(".")[0] for name in imports(path)} & refused, path


def resolved(name):
    """What a full name stands for; `...` where that does not exist."""
    try:
        return pkgutil.resolve_name(name)
    except (ImportError, AttributeError):
        return ...


def missing(path):
    """Names that a file takes from modules of ours, by import or as an attribute, and that do not exist."""
    nodes = list(ast.walk(ast.parse(path.read_text())))
    aliases = {}
    for node in nodes:
        if isinstance(node, (ast.Import, ast.ImportFrom)):
            home = f"{node.module}." if isinstance(node, ast.ImportFrom) else ""
            aliases |= {alias.asname or alias.name: home + alias.name for alias in node.names if home or alias.asname}
    bound = {node.id for node in nodes if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)}
    bound |= {node.arg for node in nodes if isinstance(node, ast.arg)}
    ours = {
        a: name for a, name in aliases.items() if name.startswith(("demlaws", "studies")) and not name.startswith(UNDER_YADE)
    }
    modules = {alias: name for alias, name in ours.items() if alias not in bound and inspect.ismodule(resolved(name))}
    taken = [n for n in nodes if isinstance(n, ast.Attribute) and isinstance(n.value, ast.Name) and n.value.id in modules]
    names = {*ours.values(), *(f"{modules[node.value.id]}.{node.attr}" for node in taken)}
    return sorted(name for name in names if resolved(name) is ...)


UNDER_YADE = (
    "demlaws.yade",
    *(f"studies.{study}.yade_" for study in ("cases", "extremes", "trade", "softening")),
    "studies.validation.in_yade",
)
"""Modules that import YADE when they are imported."""


def test_imported_names_exist():
    """Also in benchmarks, in scripts and inside functions, which few tests run."""
    places = ("demlaws", "studies", "yade_scripts", "docs/making", "tools/benchmarks", "tools/machines")
    files = [path for place in places for path in sorted((PROJECT / place).rglob("*.py"))]
    assert not {str(path.relative_to(PROJECT)): names for path in files if (names := missing(path))}


PUBLIC = "contact driver errors lammps law liggghts make regime shear surface timestep units yade"


@pytest.mark.parametrize("module", PUBLIC.split())
def test_public_addresses_are_importable(module):
    assert importlib.import_module(f"demlaws.{module}").__name__ == f"demlaws.{module}"


def test_type_checkers_see_the_public_names():
    """They read the imports that do not run."""
    body = ast.parse((PACKAGE / "__init__.py").read_text()).body
    (block,) = [node for node in body if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"]
    names = [alias.asname for node in block.body if isinstance(node, ast.ImportFrom) for alias in node.names]
    names += [node.target.id for node in block.body if isinstance(node, ast.AnnAssign)]
    assert sorted(name for name in names if name[0] != "_") == demlaws.__all__
    assert (PACKAGE / "py.typed").is_file()


def test_import_loads_neither_numba_nor_numpy():
    code = """
        import sys
        import demlaws as dl
        dir(dl), dl.__version__
        print(*sorted({"numba", "numpy", "scipy", "matplotlib", "tqdm", "pandas", "mpmath"} & set(sys.modules)))
    """
    assert python(code) == ""


def test_help_loads_neither_numba_nor_numpy():
    """Neither the help of the whole command nor that of a part of it."""
    code = f"""
        import contextlib, sys
        from demlaws.cli import main
        for words in {[[], *([name] for name in COMMANDS)]}:
            with contextlib.suppress(SystemExit):
                main([*words, "--help"])
            print("loaded:", *words, *sorted({{"numba", "numpy", "scipy", "matplotlib"}} & set(sys.modules)))
    """
    out = python(code)
    assert out.count("usage: demlaws") == 1 + len(COMMANDS)
    assert [line for line in out.splitlines() if line.startswith("loaded:")] == [
        "loaded:",
        *(f"loaded: {name}" for name in COMMANDS),
    ]


def test_only_public_names_are_listed():
    code = """
        import types
        import demlaws as dl
        assert [name for name in dir(dl) if not name.startswith("__")] == dl.__all__, dir(dl)
        dl.law
        public = [name for name in dir(dl.materials) if not name.startswith("__")]
        assert public == ["Typical", "Value", *sorted([*dl.materials.names(), "material", "names", "typical"])], public
        assert isinstance(dl.surface, types.ModuleType) and callable(dl.regime) and callable(dl.timestep)
    """
    python(code)


def test_a_public_name_that_its_module_lacks_is_an_error():
    code = """
        import demlaws as dl
        dl._homes["lwa"] = "demlaws.make"
        try:
            dl.lwa
        except AttributeError as error:
            print("lwa" in str(error))
    """
    assert python(code) == "True"


def test_importing_a_module_does_not_hide_a_function():
    """`law`, `laws`, `choose` and `fit` are public functions and names of modules or folders."""
    code = """
        import importlib, pickle
        import demlaws as dl
        import demlaws.laws.hertz, demlaws.law, demlaws.advice.choose, demlaws.advice.fit, demlaws.driver
        from demlaws import law, laws
        assert callable(law) and callable(laws) and callable(dl.choose) and callable(dl.fit)
        assert law is dl.law and law.__module__ == "demlaws.make" and set(dl.__all__) <= set(dir(dl))
        for name in dl.__all__:
            value = getattr(dl, name)
            if name not in ("driver", "materials", "plots", "surface"):  # modules
                assert pickle.loads(pickle.dumps(value)) is value, name
        assert importlib.import_module("demlaws.law").Law is dl.Law
        print(law("hertz", dl.Contact(radius=1e-2, modulus=1e10)).name, *laws())
    """
    assert python(code).split() == ["hertz", *demlaws.laws()]
