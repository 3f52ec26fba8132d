"""What imports what, and what neither an import nor a call for help may load."""

import ast
import importlib
import inspect
import sys

import pytest
from processes import PACKAGE, python

import demlaws
from demlaws.advice.choose import Choice
from demlaws.advice.fit import Fit
from demlaws.cli import COMMANDS
from demlaws.core.unloading import RULES
from demlaws.law import Path, State
from demlaws.laws import MODULES, names
from demlaws.laws.definition import Definition

COMPILED = [path.relative_to(PACKAGE).as_posix() for path in sorted((PACKAGE / "core").glob("*.py"))]
OUTSIDE = {"numpy", "numba", "llvmlite"}
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
    """numpy, numba, llvmlite, the standard library, and itself: no engine, no plot, nothing else of the package."""
    for module, _ in imports(PACKAGE / file):
        root = module.partition(".")[0]
        assert root in OUTSIDE | sys.stdlib_module_names or module.startswith(INSIDE), f"{file} imports {module}"


def test_every_law_has_one_file():
    files = {path.stem for path in (PACKAGE / "laws").glob("*.py") if "\nLAW = " in path.read_text()}
    assert files == set(MODULES)


def test_laws_are_meant_by_name_in_one_file():
    """Outside laws/ a law's name is one of laws/names.py; the same words stand for solvers' models, too."""
    written = {value for name, value in vars(names).items() if name.isupper()}
    assert written <= set(demlaws.laws())
    shared = {*RULES, "hertz", "eepa"}  # rules, and what engines call their own models
    others = {"solvers/axisymmetric.py": "models"}
    found = set()
    for path in PACKAGE.rglob("*.py"):
        where = path.relative_to(PACKAGE).as_posix()
        if not where.startswith("laws/") and where not in others:
            constants = [node.value for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.Constant)]
            found |= {(where, one) for one in constants if isinstance(one, str) and one in written - shared}
    assert not found, "say it with demlaws.laws.names"


def test_only_the_shell_knows_plots_and_engines():
    """matplotlib at import in plots.py only; scipy, tqdm and matplotlib inside functions everywhere else."""
    heavy = {"scipy", "matplotlib", "tqdm", "pandas", "yade", "liggghts", "SurfaceTopography", "mpmath", "pytest"}
    for path in PACKAGE.rglob("*.py"):
        where = path.relative_to(PACKAGE).as_posix()
        if where.startswith(("plots/", "yade/", "liggghts/")):
            continue
        at_import = {module.partition(".")[0] for module, top in imports_anywhere(path) if top}
        assert not at_import & heavy, f"{where} imports {at_import & heavy} when it is imported"


def imports_anywhere(path, names=False):
    """(module, whether importing the file imports it), also inside functions; `names`: with what is taken from the package."""
    for node in ast.walk(ast.parse(path.read_text())):
        top = getattr(node, "col_offset", 1) == 0
        if isinstance(node, ast.Import):
            yield from ((alias.name, top) for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            if names and node.module == "demlaws":
                yield from ((f"demlaws.{alias.name}", top) for alias in node.names)
            else:
                yield node.module, top


FLOORS = (
    "errors lazy processes",
    "core files units",
    "contact criterion points rule_object soundness",
    "given materials matching surface",
    "solvers",
    "laws",
    "law regime table_file defined",
    "joining driver",
    "table",
    "make",
    "checks granite yade liggghts lammps",
    "claims measure advice",
    "plots",
    "cli",
    "__init__ __main__",
)
"""The house from the ground up: a room uses its own floor and those below."""
UPWARD = {
    ("criterion.py", "solvers"): "a curve of the criterion is Greenwood & Tripp's solution, solved when it is asked for",
    ("table.py", "__init__"): "the version",
    ("liggghts/build.py", "__init__"): "the version",
    ("liggghts/export.py", "__init__"): "the version",
    ("lammps/build.py", "__init__"): "the version",
    ("lammps/export.py", "__init__"): "the version",
    ("cli/__init__.py", "__init__"): "the version",
    ("yade/run.py", "__init__"): "the folder that YADE is to find",
    ("yade/check.py", "__init__"): "run by YADE as a user's script is",
}


def rooms_used(path):
    """Rooms of the package that a file imports from, when it is imported or later."""
    for module, _ in imports_anywhere(path, names=True):
        parts = module.split(".")
        if parts[0] == "demlaws":
            known = len(parts) > 1 and ((PACKAGE / parts[1]).is_dir() or (PACKAGE / f"{parts[1]}.py").is_file())
            yield parts[1] if known else "__init__"


def test_arrows_go_one_way():
    floor = {room: number for number, rooms in enumerate(FLOORS) for room in rooms.split()}
    there = {path.stem for path in PACKAGE.glob("*.py")} | {path.parent.name for path in PACKAGE.glob("*/*.py")}
    assert set(floor) == there, "a new room needs its floor, one that went leaves none"
    upward = set()
    for path in PACKAGE.rglob("*.py"):
        where = path.relative_to(PACKAGE)
        room = where.parts[0] if len(where.parts) > 1 else path.stem
        if room != "__init__":
            upward |= {(where.as_posix(), other) for other in rooms_used(path) if floor[other] > floor[room]}
    assert upward == set(UPWARD)


def test_the_package_imports_no_study():
    """Studies are not in the wheel; what the package needs of them is kept in advice/kept.json."""
    for path in PACKAGE.rglob("*.py"):
        assert not [module for module, _ in imports_anywhere(path) if module.partition(".")[0] == "studies"], path.name


def test_no_engine_knows_another():
    engines = {"yade", "liggghts", "lammps"}
    for engine in engines:
        for path in (PACKAGE / engine).rglob("*.py"):
            assert not set(rooms_used(path)) & (engines - {engine}), path.name


def module_of(name):
    """The module of this name, None where it is something else's."""
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError:
        return None


def missing(path):
    """Names that a file takes from modules of the package, by import or by a dot, and that are not there."""
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
    *(f"studies.{study}.yade_" for study in ("costs", "extremes", "trade", "softening")),
    "studies.validation.in_yade",
)
"""What imports YADE when it is imported."""


def test_what_runs_seldom_uses_what_is_there():
    """Benchmarks, scripts, imports inside functions: a name that moved is missed here, not when it is wanted."""
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
    files = [path for place in places for path in sorted((PACKAGE.parent / place).rglob("*.py"))]
    assert len(files) > 150
    assert not {str(path.relative_to(PACKAGE.parent)): names for path in files if (names := sorted(set(missing(path))))}


def test_import_leaves_heavy_packages_alone():
    code = """
        import sys
        import demlaws
        print(*sorted({"scipy", "matplotlib", "tqdm", "pandas", "mpmath"} & set(sys.modules)))
    """
    # whatever numba and numpy themselves bring along is not ours
    bare = python(code.replace("import demlaws", "import numba"))
    assert set(python(code).split()) <= set(bare.split())


def test_type_checkers_see_the_public_names():
    """They read the imports that a running program leaves out."""
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
            for name, member in vars(value).items():
                member = member.fget if isinstance(member, property) else getattr(member, "__func__", member)
                written = inspect.isfunction(member) and member.__code__.co_filename.startswith(str(PACKAGE))
                if written and not name.startswith("_") and member.__name__ != "<lambda>":
                    yield member


def test_public_names_say_their_types():
    found = {function.__qualname__: function for function in signatures()}
    assert {"law", "laws", "choose", "fit", "timestep", "impact", "Law.force", "Contact.between", "Table.load"} <= set(found)
    missing = []
    for name, function in found.items():
        wanted = {*inspect.signature(function).parameters, "return"} - {"self", "cls"}
        missing += [f"{name}: {one}" for one in sorted(wanted - set(function.__annotations__))]
    assert not missing


def test_what_says_the_version_says_the_same():
    text = (PACKAGE.parent / "CITATION.cff").read_text()
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
    """The help of the whole command and of each part of it says what it has to say without them."""
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
    """`demlaws.law` and `demlaws.laws` are functions and folders' names at once; so are, later, `choose` and `fit`."""
    code = """
        import importlib, pickle
        import demlaws as dl
        import demlaws.laws.hertz, demlaws.law, demlaws.advice.choose, demlaws.advice.fit, demlaws.driver
        from demlaws import law, laws
        assert callable(law) and callable(laws) and callable(dl.choose) and callable(dl.fit)
        assert law is dl.law and law.__module__ == "demlaws.make" and set(dl.__all__) <= set(dir(dl))
        for name in dl.__all__:
            value = getattr(dl, name)
            if name != "driver":
                assert pickle.loads(pickle.dumps(value)) is value, name
        assert importlib.import_module("demlaws.law").Law is dl.Law
        print(law("hertz", dl.Contact(radius=1e-2, modulus=1e10)).name, *laws())
    """
    assert python(code).split() == ["hertz", *demlaws.laws()]
