"""Every public function and class says what it is; every public name of `demlaws` shows it in an example that runs."""

import doctest
import types
import warnings
from pathlib import Path

import pytest

import demlaws as dl

PACKAGE = Path(dl.__file__).parent


def examples(name):
    """Doctests of a public name: of a module those of its public functions, of a class its own and its methods'."""
    value = getattr(dl, name)
    if isinstance(value, types.ModuleType):
        functions = [
            f for n, f in vars(value).items() if not n.startswith("_") and getattr(f, "__module__", "") == value.__name__
        ]
        return [t for f in functions if isinstance(f, types.FunctionType) for t in doctest.DocTestFinder().find(f, f.__name__)]
    home = __import__("sys").modules[value.__module__]
    return [t for t in doctest.DocTestFinder().find(value, name, module=home) if t.examples]


@pytest.mark.parametrize("name", dl.__all__)
def test_public_names_show_an_example_that_runs(name, registered_here):
    found = [test for test in examples(name) if test.examples]
    assert found, f"demlaws.{name} shows no example"
    for test in found:
        test.globs = {"dl": dl}
        said = []
        runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", dl.ValidityWarning)
            runner.run(test, out=said.append)
        assert not runner.failures if hasattr(runner, "failures") else not said, "".join(said)


# what users call; Definition, Option and Parameter are for maintainers
FUNCTIONS = ["check_law", "choose", "define", "fit", "law", "load_laws", "register", "soften", "timestep"]
METHODS = {
    "Contact": ["between", "roughness_parameter", "with_values"],
    "Law": [
        "bound_to",
        "energy",
        "evaluate",
        "follow",
        "force",
        "joined",
        "new_state",
        "overlap",
        "plot",
        "stiffness",
        "tabulate",
    ],
    "Surface": ["combined"],
    "Table": ["from_function", "from_points", "load", "save", "uncertainty"],
    "driver": ["displacement_controlled", "elastic_contact", "force_controlled", "impact", "sheared"],
    "plots": ["plot"],
    "regime": ["advise", "assess", "pressure_map"],
    "surface": ["read", "self_affine", "write"],
    "timestep": ["chain_limit", "from_contacts", "packing_limit", "pair_limit", "rayleigh_step", "shear_ratio", "stiffest"],
}
NUMPYDOC = [
    *FUNCTIONS,
    "Contact",
    "Material",
    "Scene",
    "Surface",
    *(f"{home}.{name}" for home in METHODS for name in METHODS[home]),
]
FAULTS = {"GL03", "GL06", "GL07", "PR01", "PR02", "PR03", "PR06", "PR07", "RT01", "SS01", "SS03", "YD01"}


@pytest.mark.parametrize("name", NUMPYDOC)
def test_public_names_are_documented_in_numpydoc_form(name):
    """Checks of numpydoc's validator: every parameter, in order and described; Returns; order of the sections."""
    validate = pytest.importorskip("numpydoc.validate").validate
    assert [fault for fault in validate(f"demlaws.{name}")["errors"] if fault[0] in FAULTS] == []
