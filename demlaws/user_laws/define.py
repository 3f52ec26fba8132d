"""A law from plain functions of one contact: `define` makes the types, kernels and `Definition` that a file of laws writes."""

import inspect
import keyword
import math
from collections import namedtuple
from collections.abc import Callable
from typing import Any

import numpy as np

from demlaws.contact import Contact, warn_of_roughness
from demlaws.core.cache import tag_of
from demlaws.core.dispatch import bind, function_of_text, scalar
from demlaws.core.fastmath import hertz_coefficient, hertz_overlap, kernel, root_finder
from demlaws.errors import DemlawsError, warn
from demlaws.laws.definition import (
    Advice,
    Definition,
    Drawing,
    Fitting,
    Loading,
    Numbers,
    Option,
    check_name,
    with_sigma,
)
from demlaws.units import number

_CONTACT = ("hertz_coefficient", "radius", "modulus", "sigma")
_OF_CONTACT = ("fractal_dimension", "hardness")
_END = ("max_force", "largest_overlap")
"""Fields of the Params of a law that ends at a force [N]; the first is one of its Shape, too."""
_X, _W = np.polynomial.legendre.leggauss(8)
_PANELS = 32  # an octave of overlap
_OCTAVES = 40
_MANY = 20
_tags: list[str] = []
"""Of the laws made so far: numba keeps their machine code."""


def define(
    name: str,
    force: Callable | None = None,
    stiffness: Callable | None = None,
    *,
    overlap: Callable | None = None,
    energy: Callable | None = None,
    options: dict[str, Any] | None = None,
    max_force: float | str | None = None,
    **facts: Any,
) -> Definition:
    """Definition of a law from functions that numba can compile.

    Parameters
    ----------
    name : str
        Name of the law.
    force : callable
        force(p, overlap) → P [N] at overlap > 0 [m], for one contact `p` and one number.
    stiffness : callable
        stiffness(p, overlap) → K = dP/dδ [N/m].
    overlap : callable, optional
        overlap(p, force) → δ [m]. Default: solved numerically.
    energy : callable, optional
        energy(p, overlap) → ∫P dδ [J]. Default: integrated numerically.
    options : dict, optional
        Name → default, or (default, unit, meaning); None for a required option.
    max_force : float, optional
        Largest force [N] of the law. Only up to there is it checked, also with its unloading; beyond, Python and YADE stop
        with an error, and its table ends below. Default: none.
    **facts
        Fields of `Definition` or of its `Loading`, `Fitting`, `Advice` and `Drawing`, for instance equation, source, limits,
        kinks, free, colour.

    Returns
    -------
    Definition
        For `demlaws.register`.

    Raises
    ------
    DemlawsError
        For functions or fields that are not valid.

    Notes
    -----
    `p` has the fields `radius` R [m], `modulus` E* [Pa], `sigma` σ [m], `hertz_coefficient` (4/3) E* √R [N/m^1.5],
    those of `needs`, and the options. A law whose functions read `sigma` needs it. One curve is valid for one contact,
    unless collapses=True with length="radius" or "roughness".

    Examples
    --------
    >>> def force(p, overlap):
    ...     return p.factor * overlap**1.7
    >>> def stiffness(p, overlap):
    ...     return 1.7 * p.factor * overlap**0.7
    >>> mine = dl.define("power", force, stiffness, options={"factor": (3e9, "N/m^1.7", "of the overlap")})
    >>> mine.name, list(mine.options)
    ('power', ['factor'])
    """
    check_name(name)
    for what, function in (("force", force), ("stiffness", stiffness), ("overlap", overlap), ("energy", energy)):
        pure = inspect.isfunction(function) or hasattr(function, "py_func")  # what numba can compile
        if not pure and not (function is None and what in ("overlap", "energy")):
            raise DemlawsError(
                f"law {name!r:.60}: {what} must be a Python function of a contact and a number, got {function!r:.60}"
            )
    entries = {n: _described(name, n, value) for n, value in dict(options or {}).items()}
    functions = force, stiffness, overlap, energy
    if old := any(_reads("roughness", f) for f in functions):
        warn_of_roughness()
    if old or any(_reads("sigma", f) for f in functions) or facts.get("length") == "roughness":
        facts["needs"] = tuple(dict.fromkeys((*facts.get("needs", ()), "sigma")))
    needs = tuple(facts.get("needs", ()))
    clash = [
        n
        for n in entries
        if n in (*_CONTACT, *_OF_CONTACT, *_END, "contact", "roughness") or not n.isidentifier() or keyword.iskeyword(n)
    ]
    if clash or any(n.startswith("_") for n in entries):
        raise DemlawsError(f"law {name!r}: options {', '.join(map(repr, entries))}: {clash or 'one of them'} cannot be a name")
    facts = _grouped(facts)
    if unknown := sorted(facts.keys() - set(Definition._fields) | ({"prepare", "options"} & facts.keys())):
        raise DemlawsError(f"law {name!r}: a Definition has no field {', '.join(unknown)} to be given here")
    end = math.nan if max_force is None else number(max_force, f"law {name!r}: max_force", "N")
    extra = (*[n for n in needs if n in _OF_CONTACT], *entries, *(() if max_force is None else _END[:1]))
    shape_type = _types(name, functions, extra, old)
    defaults = {n: default for n, (default, _) in entries.items()}

    def prepare(contact: Contact, **keywords: Any) -> Any:
        values = {n: end if n in _END else getattr(contact, n) for n in extra if n not in entries}
        values |= {n: keywords.get(n, default) for n, default in defaults.items()}
        return shape_type(*(math.nan if values[n] is None else float(values[n]) for n in extra))

    kind, required = inspect.Parameter.KEYWORD_ONLY, inspect.Parameter.empty
    parameters = [inspect.Parameter(n, kind, default=required if d is None else d) for n, d in defaults.items()]
    first = inspect.Parameter("contact", inspect.Parameter.POSITIONAL_OR_KEYWORD)
    prepare.__signature__ = inspect.Signature([first, *parameters])  # type: ignore[attr-defined]
    fallback = {"equation": "", "source": "", "description": "user-defined law", "collapses": False, "length": "radius"}
    records = {n: option for n, (_, option) in entries.items()}
    return with_sigma(Definition(name=name, prepare=prepare, **{**fallback, **facts}, options=records))


def _grouped(facts: dict[str, Any]) -> dict[str, Any]:
    """Facts of a law, those of its records (`Loading`, `Fitting`, ...) in these; "fitted" means `Fitting.parameters`."""
    facts = {("parameters" if name == "fitted" else name): value for name, value in facts.items()}
    kinds: dict[str, Any] = {"loading": Loading, "fitting": Fitting, "advice": Advice, "drawing": Drawing}
    for name, kind in kinds.items():
        values = {field: facts.pop(field) for field in kind._fields if field in facts}
        if values:
            facts[name] = kind(**values)
    return facts


def _described(law, name, value):
    """(default, Option) of what was given for an option."""
    default, unit, meaning = (*value, "", "")[:3] if isinstance(value, tuple) else (value, "", "")
    if default is not None:
        default = number(default, f"law {law!r}: the default of {name}", unit, -math.inf)
    return default, Option(unit, Numbers(), meaning)


def _types(name, functions, extra, old):
    """Type of the law's Shape, with its Params bound to the kernels; the same type for the same functions again.

    old: they have σ also by its former name.
    """
    tag = tag_of(*functions, name, extra)
    contact = (*_CONTACT, "roughness") if old else _CONTACT
    stem = "".join(part.capitalize() for part in str(name).replace("_", "-").split("-") if part.isalnum())
    if known := globals().get(f"{stem}Shape_{tag}"):
        return known
    _tags.append(tag)
    if len(_tags) == _MANY:
        text = (
            f"{_MANY} laws of different functions are defined: each one that is used keeps about 10 MB until the process ends; "
        )
        warn(f"{text}give numbers that differ as options of one law", UserWarning)
    ends = "max_force" in extra
    shape_type, params_type = (
        namedtuple(f"{stem}{kind}_{tag}", fields, module=__name__)
        for kind, fields in (("Shape", extra), ("Params", (*contact, *extra, *(_END[1:] if ends else ()))))
    )
    for cls in (shape_type, params_type):
        globals()[cls.__qualname__] = cls  # where pickle and the machine code on disk look for it
    force, stiffness, overlap, energy = (None if f is None else _of_numbers(f) for f in functions)
    values = ", ".join(f"float(shape.{n})" for n in extra)
    made = f"Params(hertz_coefficient(R, E), R, E, {'s, s' if old else 's'}, {values}"
    names = {"Params": params_type, "hertz_coefficient": hertz_coefficient, "end_of": _end_of(force, stiffness)}
    lines = [f"p = {made}, R)", f"return {made}, end_of(p))"] if ends else [f"return {made})"]
    scale = function_of_text("shape, R, E, s", lines, names)
    end = _largest_overlap if ends else _no_end

    @kernel
    def first_loading(shape, p, overlap):
        load = force(p, overlap) if overlap <= end(p) else math.nan
        equivalent = hertz_overlap(p, load)
        return load, stiffness(p, overlap), equivalent, equivalent

    bind(shape_type, scale=kernel(scale))
    bind(
        params_type,
        first_loading=first_loading,
        inverse=_searched(force, stiffness, end) if overlap is None else _inverse_of(overlap, end),
        energy=_integrated(force, end) if energy is None else _energy_of(energy, end),
    )
    return shape_type


def _reads(quantity: str, function: Any, seen: tuple = ()) -> bool:
    """Whether a function's code reads an attribute of this name, or that of a function that it calls."""
    function = getattr(function, "py_func", function)
    if not inspect.isfunction(function) or function in seen:
        return False
    names, cells = function.__code__.co_names, function.__closure__ or ()
    called = [*(function.__globals__.get(name) for name in names), *(cell.cell_contents for cell in cells)]
    return quantity in names or any(_reads(quantity, one, (*seen, function)) for one in called)


def _of_numbers(function):
    """A user's function compiled, its value a number also where numpy gives an array without dimensions (np.where)."""
    inner = function if hasattr(function, "py_func") else kernel(function)

    @kernel
    def outer(p, value):
        return scalar(inner(p, value))

    return outer


@kernel
def _largest_overlap(p):
    return p.largest_overlap


@kernel
def _no_end(p):
    return math.inf


def _inverse_of(overlap, end):
    """A user's overlap(p, force) as a kernel."""

    @kernel
    def inverse(shape, p, load):
        at = overlap(p, load)
        return at if at <= end(p) * (1.0 + 1e-12) else math.nan

    return inverse


def _energy_of(energy, end):
    """A user's energy(p, overlap) as a kernel."""

    @kernel
    def of_contact(shape, p, overlap):
        return energy(p, overlap) if overlap <= end(p) else math.nan

    return of_contact


def _finder(force, stiffness):
    """Kernel that finds the overlap of a force."""

    @kernel
    def curve(p, overlap):
        return force(p, overlap), stiffness(p, overlap)

    return root_finder(curve)


def _end_of(force, stiffness):
    """Kernel: the overlap [m], at most R, at which a contact carries `max_force`, found from below: beyond it may fall."""
    find = _finder(force, stiffness)

    @kernel
    def end_of(p):
        low = 0.0
        high = 1e-9 * p.radius
        while high < p.radius and force(p, high) < p.max_force:
            low, high = high, 1.05 * high
        return min(find(p, p.max_force, low, high, high, 2e-16), p.radius)

    return end_of


def _searched(force, stiffness, end):
    """The inverse of a rising curve, bracketed by doubling; NaN beyond its end."""
    find = _finder(force, stiffness)

    @kernel
    def inverse(shape, p, load):
        high = min(hertz_overlap(p, load), end(p))
        low = 0.0
        for _ in range(1100):
            if high >= end(p) or not force(p, high) < load:
                break
            low, high = high, min(2.0 * high, end(p))
        if force(p, high) < load * (1.0 - 1e-12):
            return math.nan
        return find(p, load, low, high, high, 2e-16)

    return inverse


def _integrated(force, end):
    """∫P dδ by Gauss's rule, panels a 32nd of an octave wide; NaN beyond the end of the curve."""

    @kernel
    def energy(shape, p, overlap):
        total = 0.0
        top = overlap
        for _ in range(_OCTAVES):
            width = 0.5 * top / _PANELS
            for n in range(_PANELS):
                for k in range(_X.size):
                    total += 0.5 * width * _W[k] * force(p, 0.5 * top + width * (n + 0.5 + 0.5 * _X[k]))
            top *= 0.5
        return total + 0.5 * top * force(p, top) if overlap <= end(p) else math.nan

    return energy


__all__ = ["define"]
