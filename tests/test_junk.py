"""Junk for every argument of every public function: a DemlawsError, never another exception, nor a result.

The functions are found by their names, their arguments in their signatures; a new function is tried by existing, and needs
an entry in GOOD only for an argument of a new name. Junk that an argument may be (0 for a roughness) is listed in
data/junk.csv; all other junk must be refused.
"""

import csv
import dataclasses
import functools
import importlib
import inspect
import math
import warnings
from pathlib import Path

import numpy as np
import pytest
from examples import shared

import demlaws as dl
from demlaws import shear, surface

MAP = surface.self_affine(64, 1e-6, 0.8, roughness=1e-6, seed=1)
GRANITE = dl.Material(60.6e9, 0.25, 6.266e9, 2650.0)
PAIR = dl.Contact(4.35e-3, 32.32e9, 2.4e-6, 2.22, 6.266e9)
# two laws alone, so that little is compiled
LAW = dl.law("hertz", PAIR, "hertz")
POINTS = np.column_stack([(np.arange(1.0, 13.0) / 1.5e9) ** (2 / 3), np.arange(1.0, 13.0)])
TABLE = dl.Table.from_points(POINTS, PAIR, "hertz", scales_with="radius", rtol=1e-2)

GOOD = {
    **dataclasses.asdict(GRANITE),
    **dataclasses.asdict(PAIR),
    **dict.fromkeys(("name", "laws"), "hertz"),
    **dict.fromkeys(("law", "bound"), LAW),
    **dict.fromkeys(("material1", "material2"), GRANITE),
    **dict.fromkeys(("force", "smallest", "low", "anisotropy"), 1.0),
    **dict.fromkeys(("largest", "max_force"), 10.0),
    **dict.fromkeys(("n", "steps"), 2),
    **dict.fromkeys(("order", "seed"), 1),
    **dict.fromkeys(("mass", "speed", "radius1"), 1e-3),
    **dict.fromkeys(("friction", "shear_ratio", "mu0", "c1"), 0.5),
    "c2": 1e-8,
    **dict.fromkeys(("coordination", "edge_radius"), 4.0),
    **dict.fromkeys(("sigma", "roughness", "roughness1", "pixel", "pixel_x", "pixel_y", "spacing"), 1e-6),
    **dict.fromkeys(("force_noise", "compliance", "roughness2", "shortest"), 0.0),
    **dict.fromkeys(("parallel", "tables", "periodic"), False),
    **dict.fromkeys(("scene", "form_order"), None),
    "options": {},
    "values": {},
    **dict.fromkeys(("steps_per_contact", "bins"), 20),
    "contact": PAIR,
    "unloading": "elastic",
    "overlap": np.array([1e-6, 2e-6]),
    "state": LAW.new_state(2),
    "out": (np.empty(2), np.empty(2)),
    "dtype": np.float64,
    "rtol": 1e-2,
    "path": "/nowhere/file.tbl",
    "turning_points": [1e-7, 0.0],
    "points": POINTS,
    "free": ("modulus",),
    "displacement_noise": 1e-8,
    "progress": iter,
    "forces": [1.0, 2.0],
    "radius2": math.inf,
    "other": dl.Surface(1e-6),
    "ratio": 0.6,
    "roughnesses": [1e-6, 2e-6],
    "roughness_parameter": 0.5,
    "text": "3mm",
    "heights": MAP.heights,
    "unit": "um",
    "wavelengths": (4e-6, 2e-5),
    "shape": 16,
    "hurst": 0.8,
    "longest": 1e-5,
    "size_ratio": 1.5,
    "description": "junk",
    "height": 1e-5,
    "centre": (3e-5, 3e-5),
    "high": 2.0,
    "uncertainty": None,
    "kinks": (),
    "largest_overlap": None,
    "shear": "elastic",
    "yield_pressure": 1e9,
}
RADII = {"radii": 1e-3, "materials": GRANITE, "surfaces": dl.Surface(1e-6), "pressure": None, "cyclic": True}
RADII |= {"quantity": "force", "tolerance": 0.05, "engine": "python", "walls": False, "yield_pressure": None, "reference": None}
RADII |= {"reference_options": {}, "porosity": 0.4, "coordination": 6.0, "classes": (), "force": (1.0, 2.0)}
RADII |= {"process": "oedometer", "rate": 1.0}


def spring(p, overlap):
    return 1e6 * overlap


GOOD_OF = {
    "Scene": RADII,
    "Contact": {"roughness": None},
    "combined": {"other": dl.Surface(1e-6)},
    "HeightMap.with_heights": {"heights": MAP.heights},
    "HeightMap.contact": {"heights": MAP},
    "write": {"heights": MAP, "path": "/proc/nowhere/map.npy"},
    "read": {"path": "/nowhere/map.npy"},
    "follow": {"state": LAW.new_state(1)},
    "unloading_overlap": {"state": LAW.new_state(1)},
    "shear_stiffness": {"state": LAW.new_state(1)},
    "central_pressure": {"mu": 4.0},
    "isolated pair": {"other_mass": 1e-3},
    "define": {"name": "junk", "force": spring, "stiffness": lambda p, overlap: 1e6, "overlap": None},
    "register": {"definition": dl.define("junk", spring, lambda p, overlap: 1e6)},
    "Table.from_function": {"name": "junk", "force": lambda overlap: 1e6 * overlap},
    "Table.from_points": {"name": "junk", "points": POINTS},
    "load_laws": {"file": "/nowhere/laws.py"},
    "HeightMap.cropped": {"width": 1e-5},
    "soften": {"thing": PAIR, "factor": 10.0},
    "sheared": {"displacement": [0.0, 1e-7], "ratio": 0.8},
}
RECORDS = {"Definition", "Numbers", "Option", "Parameter"}  # hold what they are given; `register` and `define` look at it
LEFT_OUT = {
    "from_portable",
    "portable",
    "record",
    "unloading_shape",
    "joined",
    "bound_to",
    "__init__",
    "driver",
    "swaps",
    "box_correction",
    "published_contact",  # makes a large map; its arguments go to self_affine and RoughContact
}
JUNK = {
    "none": None,
    "text": "x",
    "a unit of something else": "3parsec",
    "nan": math.nan,
    "infinity": math.inf,
    "minus one": -1.0,
    "zero": 0,
    "huge": 1e300,
    "tiny": 1e-300,
    "a list": [1.0, "x"],
    "empty": [],
    "three dimensions": np.zeros((2, 2, 2)),
    "integers": np.array([1, 2, 3]),
    "complex": 1j,
    "a dictionary": {},
    "an object": object(),
    "a function": len,
    "masked": np.ma.array([1e-6, 2e-6], mask=[0, 1]),
    "a fraction": 2.5,
}
with open(Path(__file__).parent / "data" / "junk.csv", newline="") as file:
    ACCEPTED = {(row["function"], row["argument"]): row["accepted"].split("; ") for row in csv.DictReader(file)}


def functions():
    """Name → public function or method, bound to what it belongs to."""
    for name in dl.__all__:
        thing = getattr(dl, name)
        if (
            callable(thing)
            and not (inspect.isclass(thing) and issubclass(thing, Exception))
            and name not in {"Law", "Table"} | RECORDS
        ):
            yield name, thing
    regime = importlib.import_module("demlaws.regime")
    for module in (dl.driver, regime, shear, surface):
        for name, thing in vars(module).items():
            own = inspect.isfunction(thing) and thing.__module__ == module.__name__ and not hasattr(thing, "py_func")
            exported = module is regime and name in regime.__all__ and inspect.isfunction(thing)
            listed = name in dl.__all__  # as dl.regime
            if (own or exported) and not (listed or name.startswith("_") or name in LEFT_OUT):
                yield f"{module.__name__.rpartition('.')[2]}.{name}", thing
    for owner in (LAW, TABLE, PAIR, dl.Surface(1e-6), MAP, LAW.new_state(2)):
        for name in dir(type(owner)):
            static = inspect.getattr_static(type(owner), name)
            if (
                not name.startswith("_")
                and name not in LEFT_OUT
                and inspect.isroutine(static)
                and not isinstance(static, functools.cached_property)
            ):
                yield f"{type(owner).__name__}.{name}", getattr(owner, name)
    yield "isolated pair", lambda law, mass, max_force, other_mass: dl.timestep(law, mass, max_force, other_mass=other_mass)
    yield "surface.self_affine", surface.self_affine


FUNCTIONS = dict(functions())


def arguments_of(name, function):
    """Keyword arguments that are good."""
    short = name.rpartition(".")[2]
    own = {**GOOD, **GOOD_OF.get(short, {}), **GOOD_OF.get(name, {})}
    parameters = inspect.signature(function).parameters.values()
    named = [p for p in parameters if p.kind in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY, p.POSITIONAL_ONLY)]
    missing = [p.name for p in named if p.name not in own and p.default is p.empty]
    assert not missing, f"{name}: give tests/test_junk.py a good value for {', '.join(missing)}"
    if "scene" in {p.name for p in named}:
        own["scene"] = dl.Scene(**{k: v for k, v in RADII.items() if k != "pressure"})
    return {p.name: own[p.name] for p in named if p.name in own}


def call(function, arguments):
    positional = [p.name for p in inspect.signature(function).parameters.values() if p.kind == p.POSITIONAL_ONLY]
    named = {k: v for k, v in arguments.items() if k not in positional}
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        return function(*(arguments[k] for k in positional), **named)


HEAVY = {"choose"}  # its scene is tried in Scene


NOWHERE = {"load_laws", "surface.read", "surface.read_unchecked", "surface.write", "Table.load", "Table.save"}
"""Functions whose file or folder is not there: even the good call is refused."""
NAMED = ("Contact", "Material", "Surface", "Contact.between")
"""Classes whose errors name the field."""


@pytest.mark.parametrize("name", shared(FUNCTIONS, lambda name: name != "fit"))
def test_junk(name, tmp_path, monkeypatch, registered_here):
    monkeypatch.chdir(tmp_path)
    function = FUNCTIONS[name]
    good = arguments_of(name, function)
    wrong = []
    if name not in {*NOWHERE, *HEAVY}:
        call(function, good)
    for argument in good if name not in HEAVY else ["scene"]:
        for kind, junk in JUNK.items():
            if argument in ("progress", "dtype", "parallel", "tables", "options"):
                continue
            try:
                call(function, {**good, argument: junk})
            except dl.DemlawsError as error:
                assert len(str(error)) < 2000
                assert argument.rstrip("12") in str(error) or name not in NAMED
            except Exception as error:
                wrong.append(f"{name}({argument}={kind}): {type(error).__name__}: {error}")
            else:
                if kind not in ACCEPTED.get((name, argument), ()):
                    wrong.append(f"{name}({argument}={kind}): accepted")
    assert not wrong, "\n".join(wrong)
