"""Layers and imports: which module may import which, and what an import or a call for help must not load."""

import ast
import importlib
import inspect
import re
import sys
from typing import NamedTuple

import pytest
from processes import PACKAGE, python

import demlaws
from demlaws.advice.choose import Choice
from demlaws.advice.fit import Fit
from demlaws.batch import State
from demlaws.cli import COMMANDS
from demlaws.core.unloading import RULES
from demlaws.laws import MODULES, names
from demlaws.laws.definition import Definition
from demlaws.path import Path

PROJECT = PACKAGE.parent
CORE = [path.relative_to(PACKAGE).as_posix() for path in sorted((PACKAGE / "core").glob("*.py"))]
OUTSIDE = {"numpy", "numba", "llvmlite"}
INSIDE = ("demlaws.core", "demlaws.errors")
STRING_IMPORTERS = {"import_module", "__import__", "find_spec", "run_module"}


class Import(NamedTuple):
    """One import of a file."""

    module: str  # full name; with "*" for a part of a string that is not known before it runs
    on_load: bool  # whether importing the file imports it
    by_string: bool = False


def _checked_types_only(node):
    return isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING"


def _statements(node):
    """All nodes below, without the imports that only type checkers read."""
    for child in ast.iter_child_nodes(node):
        if not _checked_types_only(child):
            yield child
            yield from _statements(child)


def _text(node, module):
    """The text of an expression; "*" for what is not constant."""
    if isinstance(node, ast.Constant):
        return str(node.value)
    if isinstance(node, ast.JoinedStr):
        return "".join(_text(part.value if isinstance(part, ast.FormattedValue) else part, module) for part in node.values)
    if isinstance(node, ast.Name) and node.id in ("__name__", "__package__"):
        return module
    return "*"


def imports(path, module="*"):
    """Every `Import` of a file. `module`: the name of the module, for imports of parts of itself by string."""
    for node in _statements(ast.parse(path.read_text())):
        on_load = getattr(node, "col_offset", 1) == 0
        if isinstance(node, ast.Import):
            yield from (Import(alias.name, on_load) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0 and node.module, f"{path}: relative import"
            yield from (Import(f"{node.module}.{alias.name}", on_load) for alias in node.names)
        elif isinstance(node, ast.Call) and node.args:
            called = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
            if called in STRING_IMPORTERS:
                yield Import(_text(node.args[0], module), False, by_string=True)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            for name in re.findall(r"(?:__import__|import_module)\(\W*([\w.]+)", node.value):  # code that others will run
                yield Import(name, False, by_string=True)


def modules_of(folder):
    """Full name → path of every module of a package."""
    found = {}
    for path in sorted(folder.rglob("*.py")):
        parts = path.relative_to(folder.parent).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


def import_graph(folder, lazy=()):
    """Module → the modules of the same package that it imports: when it is loaded, inside functions and, but for the files
    `lazy`, by string."""
    modules = modules_of(folder)
    graph = {}
    for name, path in modules.items():
        used = set()
        for found in imports(path, name):
            target = found.module
            if found.by_string and path.relative_to(folder).as_posix() in lazy:
                continue
            if "*" in target and target.strip("*."):
                pattern = re.compile(re.escape(target).replace(r"\*", r"\w+"))
                used |= {other for other in modules if pattern.fullmatch(other)}
            while target and target not in modules:  # a name that is taken from a module
                target = target.rpartition(".")[0]
            used |= {target} - {""}
        graph[name] = used - {name}
    return graph


def circles(graph):
    """Groups of modules that import one another, directly or through others: those that reach themselves."""

    def reached(start):
        found, todo = set(), [start]
        while todo:
            new = graph[todo.pop()] - found
            found |= new
            todo += new
        return found

    reach = {name: reached(name) for name in graph}
    return {frozenset(other for other in reach[name] if name in reach[other]) for name in graph if name in reach[name]}


STRINGS = {
    "lazy.py": "the lazy public names",
    "yade/__init__.py": "the lazy public names",
    "cli/__init__.py": "the table of commands",
    "laws/registry.py": "the table of laws: a law is imported when it is needed",
    "yade/scene.py": "a command that YADE runs in __main__",
}
"""Files that may import a module of the package by string, and why."""


def test_modules_are_imported_by_statement():
    """An import by string hides a circle from readers and tools."""
    found = set()
    for path in PACKAGE.rglob("*.py"):
        ours = [i for i in imports(path, "demlaws") if i.by_string and i.module.startswith(("demlaws", "*"))]
        found |= {path.relative_to(PACKAGE).as_posix()} if ours else set()
    assert found == set(STRINGS)


def test_no_import_circles():
    assert not [sorted(circle) for circle in circles(import_graph(PACKAGE, lazy=STRINGS))]


@pytest.mark.parametrize(
    ("files", "found"),
    [
        ({"a": "import demo.b", "b": "x = 1"}, set()),
        ({"a": "import demo.b", "b": "def f():\n    from demo.a import x"}, {"demo.a demo.b"}),
        ({"a": "from demo import b", "b": "import importlib\nimportlib.import_module('demo.a')"}, {"demo.a demo.b"}),
        ({"a": "from demo.b import x", "b": "__import__(f'demo.{name}')"}, {"demo.a demo.b"}),
        ({"a": "import demo.b", "b": "COMMAND = \"__import__('demo.a').a.run()\""}, {"demo.a demo.b"}),
        ({"a": "import demo.b", "b": "import demo.c", "c": "import demo.a"}, {"demo.a demo.b demo.c"}),
        ({"a": "import demo.b", "b": "TYPE_CHECKING = False\nif TYPE_CHECKING:\n    import demo.a"}, set()),
    ],
)
def test_circles_are_found(tmp_path, files, found):
    folder = tmp_path / "demo"
    folder.mkdir()
    (folder / "__init__.py").touch()
    for name, text in files.items():
        (folder / f"{name}.py").write_text(text + "\n")
    assert {" ".join(sorted(one)) for one in circles(import_graph(folder))} == found


@pytest.mark.parametrize("file", CORE)
def test_the_compiled_core_imports_nothing_else(file):
    """numpy, numba, llvmlite, the standard library and itself: no engine, no plot, nothing else of the package."""
    for module, *_ in imports(PACKAGE / file):
        root = module.partition(".")[0]
        assert root in OUTSIDE | sys.stdlib_module_names or module.startswith(INSIDE), f"{file} imports {module}"


def test_every_law_has_one_file():
    files = {path.stem for path in (PACKAGE / "laws").glob("*.py") if "\nLAW = " in path.read_text()}
    assert files == set(MODULES)


def test_names_of_laws_are_written_in_one_file():
    """Outside laws/ a law is named by a constant of laws/names.py. The same words also name solvers' models."""
    written = set(demlaws.laws())
    assert {value for name, value in vars(names).items() if name.isupper()} <= written
    shared = {*RULES, "hertz", "eepa"}  # rules, and what engines call their own models
    others = {"solvers/axisymmetric.py": "models"}
    found = set()
    for path in PACKAGE.rglob("*.py"):
        where = path.relative_to(PACKAGE).as_posix()
        if not where.startswith("laws/") and where not in others:
            constants = [node.value for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.Constant)]
            found |= {(where, one) for one in constants if isinstance(one, str) and one in written - shared}
    assert not found, "take the constant of demlaws.laws.names"


LAYERS = (
    "errors lazy results",
    "admissible core files units",
    "contact criterion points soundness",
    "materials heightmap surface",
    "solvers",
    "laws",
    "regime defined unloading",
    "curves rule_object",
    "batch path response law",
    "driver make shear timestep",
    "convert engines grains",
    "checks yade liggghts lammps",
    "advice",
    "plots",
    "granite",
    "cli",
    "__init__ __main__",
)
"""Layers of the package, the lowest first: a module imports from its own layer and those below."""
UPWARD = {
    ("criterion.py", "solvers"): "a curve of the criterion is Greenwood & Tripp's solution, solved when it is asked for",
    ("response.py", "plots"): "the method plot of laws",
    ("path.py", "plots"): "the method plot of paths",
    ("curves/saved.py", "__init__"): "the version",
    ("engines.py", "__init__"): "the version",
    ("liggghts/export.py", "__init__"): "the version",
    ("lammps/export.py", "__init__"): "the version",
    ("cli/__init__.py", "__init__"): "the version",
    ("yade/run.py", "__init__"): "the folder that YADE is to find",
    ("yade/check.py", "__init__"): "run by YADE as a user's script is",
}


def units_used(path):
    """Top-level modules and folders of the package from which a file imports, when it is loaded or later."""
    for found in imports(path):
        parts = found.module.split(".")
        if parts[0] == "demlaws" and not found.by_string:
            known = len(parts) > 1 and ((PACKAGE / parts[1]).is_dir() or (PACKAGE / f"{parts[1]}.py").is_file())
            yield parts[1] if known else "__init__"


def test_imports_go_one_way():
    layer = {unit: number for number, units in enumerate(LAYERS) for unit in units.split()}
    present = {path.stem for path in PACKAGE.glob("*.py")} | {path.parent.name for path in PACKAGE.glob("*/*.py")}
    assert set(layer) == present, "each top-level module and folder needs a layer"
    upward = set()
    for path in PACKAGE.rglob("*.py"):
        where = path.relative_to(PACKAGE)
        unit = where.parts[0] if len(where.parts) > 1 else path.stem
        if unit != "__init__":
            upward |= {(where.as_posix(), other) for other in units_used(path) if layer[other] > layer[unit]}
    assert upward == set(UPWARD)


def test_no_engine_imports_another():
    engines = {"yade", "liggghts", "lammps"}
    for engine in engines:
        for path in (PACKAGE / engine).rglob("*.py"):
            assert not set(units_used(path)) & (engines - {engine}), path.name


def test_studies_import_the_package_and_not_the_reverse():
    """Studies are not in the wheel; the package keeps the fitted curves and costs that it needs in advice/kept.json."""
    for path in PACKAGE.rglob("*.py"):
        assert not [one.module for one in imports(path) if one.module.split(".")[0] in ("studies", "tests")], path.name
    for path in (PROJECT / "studies").rglob("*.py"):
        assert not [one.module for one in imports(path) if one.module.split(".")[0] == "tests"], path.name


def module_of(name):
    """The module of this name, None where it is something else's."""
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError:
        return None


def missing(path):
    """Names that a file takes from modules of the package, by import or as an attribute, and that do not exist."""
    tree, modules = ast.parse(path.read_text()), {}
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith(OURS):
            home = None if node.module.startswith(UNDER_YADE) else importlib.import_module(node.module)
            for alias in node.names if home else ():
                one = f"{node.module}.{alias.name}"
                if not hasattr(home, alias.name) and module_of(one) is None:
                    yield one
                elif inspect.ismodule(value := getattr(home, alias.name)):
                    modules[alias.asname or alias.name] = value
        elif isinstance(node, ast.Import):
            ours = [alias for alias in node.names if alias.name.startswith(OURS) and not alias.name.startswith(UNDER_YADE)]
            modules |= {alias.asname: module_of(alias.name) for alias in ours if alias.asname}
    bound = {node.arg for node in ast.walk(tree) if isinstance(node, ast.arg)}
    bound |= {node.id for node in ast.walk(tree) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id not in bound:
            module = modules.get(node.value.id)
            if module is not None and not hasattr(module, node.attr) and module_of(f"{module.__name__}.{node.attr}") is None:
                yield f"{module.__name__}.{node.attr}"


OURS = ("demlaws", "studies")
UNDER_YADE = (
    "demlaws.yade",
    *(f"studies.{study}.yade_" for study in ("costs", "extremes", "shear", "trade", "softening")),
    "studies.validation.in_yade",
)
"""Modules that import YADE when they are imported."""


def test_imported_names_exist():
    """Also in benchmarks, in scripts and inside functions, which few tests run."""
    places = (
        "demlaws",
        "studies",
        "yade_scripts",
        "liggghts_inputs",
        "lammps_inputs",
        "docs/making",
        "tests/benchmarks",
        "tests/machines",
    )
    files = [path for place in places for path in sorted((PROJECT / place).rglob("*.py"))]
    assert not {str(path.relative_to(PROJECT)): names for path in files if (names := sorted(set(missing(path))))}


def test_import_leaves_heavy_packages_alone():
    code = """
        import sys
        import demlaws
        print(*sorted({"scipy", "matplotlib", "tqdm", "pandas", "mpmath"} & set(sys.modules)))
    """
    # numba and numpy may load some of them themselves
    bare = python(code.replace("import demlaws", "import numba"))
    assert set(python(code).split()) <= set(bare.split())


def test_type_checkers_see_the_public_names():
    """They read the imports that do not run."""
    (block,) = [node for node in ast.parse((PACKAGE / "__init__.py").read_text()).body if isinstance(node, ast.If)]
    assert sorted(alias.name for node in block.body for alias in node.names) == demlaws.__all__
    assert (PACKAGE / "py.typed").is_file()


def signatures():
    """Public functions and the public methods of public classes that the package itself writes."""
    public = [getattr(demlaws, name) for name in demlaws.__all__] + [Definition, State, Path, Choice, Fit]
    public += [value for value in vars(demlaws.driver).values() if getattr(value, "__module__", "") == "demlaws.driver"]
    for value in public:
        if inspect.isfunction(value) and not value.__name__.startswith("_"):
            yield value
        elif inspect.isclass(value):
            for name, member in inspect.getmembers_static(value):
                member = member.fget if isinstance(member, property) else getattr(member, "__func__", member)
                written = inspect.isfunction(member) and member.__code__.co_filename.startswith(str(PACKAGE))
                if written and not name.startswith("_") and member.__name__ != "<lambda>":
                    yield member


def test_public_functions_are_annotated():
    found = {function.__qualname__: function for function in signatures()}
    assert {"law", "laws", "choose", "fit", "timestep", "impact", "Response.force", "Contact.between", "Table.load"} <= set(
        found
    )
    missing = []
    for name, function in found.items():
        wanted = {*inspect.signature(function).parameters, "return"} - {"self", "cls"}
        missing += [f"{name}: {one}" for one in sorted(wanted - set(function.__annotations__))]
    assert not missing


def test_the_citation_has_the_version_of_the_package():
    text = (PROJECT / "CITATION.cff").read_text()
    assert f"\nversion: {demlaws.__version__}\n" in text


def test_import_loads_neither_numba_nor_numpy():
    code = """
        import sys
        import demlaws as dl
        dir(dl), dl.__version__
        print(*sorted({"numba", "numpy"} & set(sys.modules)))
    """
    assert python(code) == ""


@pytest.mark.parametrize("arguments", [[], *([name] for name in COMMANDS)], ids=" ".join)
def test_help_loads_neither_numba_nor_numpy(arguments):
    """Neither the help of the whole command nor that of a part of it."""
    code = f"""
        import sys
        from demlaws.cli import main
        try:
            main({[*arguments, "--help"]})
        except SystemExit as end:
            assert end.code == 0
        print("loaded:", *sorted({{"numba", "numpy", "scipy", "matplotlib"}} & set(sys.modules)))
    """
    out = python(code)
    assert "usage: demlaws" in out
    assert out.splitlines()[-1] == "loaded:"


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
            if name not in ("driver", "plots", "regime", "surface"):  # modules
                assert pickle.loads(pickle.dumps(value)) is value, name
        assert importlib.import_module("demlaws.law").Law is dl.Law
        print(law("hertz", dl.Contact(radius=1e-2, modulus=1e10)).name, *laws())
    """
    assert python(code).split() == ["hertz", *demlaws.laws()]
