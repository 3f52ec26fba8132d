"""What a law declares besides its compiled kernels: all that fits, advice, measurements, figures and engines know of it."""

import functools
import inspect
import math
import re
from collections.abc import Callable, Collection, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from demlaws.contact import Contact, warn_of_roughness
from demlaws.core.unloading import GIVEN, RULES, Rule
from demlaws.errors import DemlawsError, MissingQuantity, did_you_mean, most_similar
from demlaws.units import number


class Limit(NamedTuple):
    """A range of force [N] outside which a law is not supported by its source, and why."""

    minimum_force: float
    maximum_force: float
    reason: str
    pressure: bool = False  # maximum_force is where the central pressure reaches 0.6 H_m: not proportional to √R σ^1.5


def bulk_yield(contact: Contact, **options: Any) -> list[Limit]:
    """Where the contact's hardness is known: the load at which p(0), lowered by roughness, reaches 0.6 H_m (`criterion`)."""
    if contact.hardness is None:
        return []
    from demlaws.solvers.criterion import transition_force

    reason = "the central pressure passes 0.6 H_m, so that the bulk yields; this law keeps it elastic (see rough-plastic)"
    yields = np.min(transition_force(contact.with_values(sigma=contact.sigma_or_zero)))
    return [Limit(0.0, float(yields), reason, pressure=True)]


def no_limits(contact: Contact, **options: Any) -> list[Limit]:
    """Of a law that claims no range."""
    return []


# --- advice


class Conditions(NamedTuple):
    """Conditions of a contact up to a load, from which a law decides whether it applies (`Advice.suits`)."""

    contact: Contact
    roughness_parameter: float  # largest α, at a hundredth of the load
    pressure_drop: float  # p(0)/p0 there
    yields: bool  # p(0)/H_m passes 0.6
    state: str  # that in words


def elastic_bulk(conditions: Conditions, fits: bool = True, reason: str = "") -> tuple[bool, str]:
    """Advice of a law that keeps the bulk elastic, and that fits otherwise unless `reason` says why it does not."""
    if conditions.yields:
        return False, f"{conditions.state}: the bulk yields and this law keeps it elastic"
    return fits, conditions.state if fits else reason


def elastic_asperities(conditions: Conditions, fits: bool = True, reason: str = "") -> tuple[bool, str]:
    """As `elastic_bulk`, of a law of rough surfaces whose asperities stay elastic."""
    fits, reason = elastic_bulk(conditions, fits, reason)
    return fits, f"{reason}; possible, if the asperities stay elastic" if fits else reason


def yielding_bulk(conditions: Conditions) -> tuple[bool, str]:
    """Advice of a law of a smooth sphere whose bulk yields."""
    if not conditions.yields:
        return False, f"{conditions.state}: the bulk is elastic; hertz or a rough law will do"
    smooth = conditions.pressure_drop > 0.95
    part = "the bulk yields" if smooth else "the bulk yields, but the surface is rough: see rough-plastic"
    return bool(smooth), f"{conditions.state}: {part}"


def plastic_from_the_start(conditions: Conditions) -> tuple[bool, str]:
    """Advice of a law whose parameters are calibrated on bulk tests, not measured on contacts."""
    return False, f"{conditions.state}: its stiffnesses are not those of a contact but calibrated on the bulk's behaviour"


def plastic_asperities(conditions: Conditions) -> tuple[bool, str]:
    """Advice of a law whose asperities yield at the hardness while the bulk stays elastic."""
    fits, reason = elastic_bulk(conditions, conditions.contact.hardness is not None, "needs a hardness")
    return fits, f"{reason}; possible, if the asperities yield" if fits else reason


# --- fits


class Parameter(NamedTuple):
    """A quantity that a fit may vary.

    >>> thickness = dl.Parameter("m", True, lambda contact: (1e-9, 1e-4), lambda contact: [1e-6])
    >>> thickness.unit, thickness.option
    ('m', False)
    """

    unit: str
    logarithmic: bool  # fitted and reported as ln(value): positive by nature
    bounds: Callable  # contact → (lowest, highest)
    starts: Callable  # contact → values to start from
    option: bool = False  # of the law, not of the contact
    unloading: bool = False  # first loading does not show it: no fit of an elastic contact varies it


MODULUS = Parameter("Pa", True, lambda c: (c.modulus / 100, c.modulus * 100), lambda c: [c.modulus])
SIGMA = Parameter(
    "m",
    True,
    lambda c: (1e-7 * c.radius, 0.1 * c.radius),
    lambda c: np.clip(
        np.array([1.0, 0.2, 5.0, 25.0]) * (c.sigma or 3e-4 * c.radius),
        2e-7 * c.radius,
        0.09 * c.radius,
    ),
)
DIMENSION = Parameter("", False, lambda c: (2.0, 3.0), lambda c: [c.fractal_dimension or 2.25, 2.1, 2.5, 2.8])
HARDNESS = Parameter("Pa", True, lambda c: (1e-3 * c.modulus, 10 * c.modulus), lambda c: [c.hardness or 0.2 * c.modulus])


def pressure_option(lowest: float, highest: float, *starts: float) -> Parameter:
    """An option [Pa] that a fit varies from `lowest` to `highest`, beginning at `starts`, all over E*."""
    return Parameter(
        "Pa", True, lambda c: (lowest * c.modulus, highest * c.modulus), lambda c: c.modulus * np.array(starts), option=True
    )


OF_CONTACT = {"modulus": MODULUS, "sigma": SIGMA, "fractal_dimension": DIMENSION, "hardness": HARDNESS}
"""The contact's own quantities; a law names those that it depends on, and adds its options, in `Fitting.parameters`."""


class Numbers(NamedTuple):
    """The numbers that an option can be: above `low` (or from it, where `included`) and up to `high`.

    >>> print(dl.Numbers(0.0), dl.Numbers(0.0, 1.0, True), dl.Numbers(), sep="; ")
    above 0; 0 to 1; a finite number
    """

    low: float = -math.inf
    high: float = math.inf
    included: bool = False

    def __str__(self) -> str:
        low, high = (f"{end:.4g}".replace("e+0", "e").replace("e-0", "e-") for end in (self.low, self.high))
        if self.high < math.inf:
            return f"{low} to {high}" if self.included else f"above {low} to {high}"
        return "a finite number" if self.low == -math.inf else f"{'from' if self.included else 'above'} {low}"


POSITIVE = Numbers(0.0)
"""Of an option that is a length, a pressure, a stiffness."""


class Option(NamedTuple):
    """A law's option: `Definition.read_options` reads values by this record. Its default is in the signature of `prepare`.

    An option with a range (`Numbers`), or with a unit, is a number, or text with a unit. Any other one is what its `prepare`
    makes of it: a word, a file. One without a default is needed.

    >>> strength = dl.Option("Pa", dl.Numbers(0.0), "pressure at which the bulk yields")
    >>> strength.read("strength", "1.66GPa"), str(strength.values)
    (1660000000.0, 'above 0')
    """

    unit: str
    values: "Numbers | str"  # the range, or the words that it can be
    meaning: str
    softens: float | Callable | None = None  # see `advice.soften.softened_option`
    of_material: str | None = None  # attribute of YADE's materials with the value; of two materials the smaller one

    def read(self, name: str, value: Any) -> Any:
        """A value as `prepare` takes it; DemlawsError that names the option where it is inadmissible."""
        if isinstance(self.values, Numbers):
            return number(value, name, self.unit, self.values.low, self.values.high, self.values.included)
        if self.unit:
            return number(value, name, self.unit, -math.inf)
        return value.item() if isinstance(value, np.generic) else value


PRESSURE = -2 / 3
"""`Option.softens` of a pressure."""
STIFFNESS = -2 / 3
"""`Option.softens` of a stiffness [N/m], and of its growth with force [1/m]."""
LENGTH = 2 / 3
"""`Option.softens` of an overlap."""


def slope_softens(value: Any, factor: float) -> float:
    """`Option.softens` of an angle [rad] whose tangent is a slope: normal lengths grow by s^(2/3), lateral ones by s^(1/3)."""
    return math.atan(float(np.cbrt(factor)) * math.tan(value))


def power_of(factor: float, exponent: float) -> float:
    """factor^exponent for exponents in thirds, exact where the cube root is."""
    root, thirds = float(np.cbrt(factor)), round(3 * exponent)
    if thirds % 3 == 0:
        return float(factor) ** (thirds // 3)
    return root**thirds if abs(thirds) < 3 else factor**exponent


SEATING = Option("", Numbers(1e-7, 1.0, True), "load over E* √R σ^1.5 below which the curve is continued as P ∝ δ^1.5")


def check_name(name: Any) -> None:
    """DemlawsError unless a law may have this name."""
    if not isinstance(name, str) or not re.fullmatch(r"[a-z][a-z0-9]*([-_][a-z0-9]+)*", name) or name in RULES:
        hint = f"no rule's ({', '.join(RULES)})"
        raise DemlawsError(
            f"law {name!r:.60}: a name consists of lower-case letters, digits and hyphens, begins with a letter, and is {hint}"
        )


class Fitting(NamedTuple):
    """What fits a law to measured points."""

    parameters: dict = {}  # noqa: RUF012  quantity that the law depends on, beside the modulus → Parameter
    free: tuple = ()  # those that a fit varies by default
    identifiable: bool = True  # whether tests on single contacts, as the granite ones, determine its parameters


class Advice(NamedTuple):
    """What `choose`, `regime` and `soften` know of a law."""

    suits: Callable = elastic_asperities  # Conditions → (whether the law's physics fits, reason)
    rank: int = 0  # `choose` takes the law of highest rank that a scene's quantities determine as its reference; 0: never
    smooth: bool = False  # of a smooth contact: it leaves roughness out
    candidate: bool = False  # `choose` tries it in place of its reference
    closed_form_is_cheapest: bool = False  # no table costs less
    native: dict = {}  # noqa: RUF012  engine → its own model that is this law
    rigid: str = ""  # why its contacts cannot be softened: a length of the law that does not scale (`demlaws.soften`)


class Drawing(NamedTuple):
    """How figures show a law, and with which options figures, tests and measurements make it."""

    colour: str = "#888888"
    line: str = "-"
    example: dict = {}  # noqa: RUF012  options, where it has no default
    example_curve: dict = {}  # noqa: RUF012  changes of these where the law is an example of an unloading curve


class Rules(NamedTuple):
    """Unloading of a law, beside the general rules that it may take."""

    default: str | Callable = "elastic"  # the rule where a user names none; or **options → it (`Definition.default_rule`)
    own: tuple = ()  # rules of its own (`own_rule`), which no other law is offered
    numbers: Callable | None = None  # params, length [m], a table's relative error → values of its own rules' `keys`, no units
    refused: dict = {}  # noqa: RUF012  general rule that the law does not take → what to do instead


class Bulk(NamedTuple):
    """Yield of a contact's bulk."""

    point: Callable  # params → δ_y [m], a²/R there [m], d(a²/R)/dP after it [m/N]
    radius: Callable | None = None  # contact, **options → R [m] of Hertz's unloading curve and of yield; None: the contact's
    before: Callable | None = None  # **options → (Definition, options) of the law that holds before the bulk yields


HERTZ_CURVE, CLOSED, ROOT, CELLS, MAP = "Hertz's curve", "closed form", "root", "cells", "cells of a map"
"""How the force of a law is computed (`Loading.computed`): by Hertz's power law, which has no length of its own; in closed
form; as the root of an equation; from cells, a table from the start, of a curve that a solver gave; of one height map."""


def no_kinks(params: Any, **options: Any) -> list[float]:  # no lambda: tables are pickled
    """Of a law whose stiffness is continuous and smooth: no overlaps."""
    return []


class Loading(NamedTuple):
    """What first loading is computed from, and how."""

    needs: tuple = ()  # names of Contact fields that must be given
    kinks: Callable = no_kinks  # params, **options → overlaps [m] where dK/dδ or K jumps: nodes of a table
    computed: str = CLOSED
    bulk: Bulk | None = None  # of a law whose bulk yields


_signature = functools.cache(inspect.signature)
_REQUIRED = inspect.Parameter.empty


class Definition(NamedTuple):
    """A law: `prepare(contact, **options)` checks input and returns the Shape that its kernels are bound to.

    >>> from demlaws.laws.registry import find
    >>> find("hertz").equation, find("pohrt-popov").needed()
    ('P = (4/3) E* √R δ^1.5', ('sigma', 'fractal_dimension'))
    """

    name: str
    prepare: Callable
    equation: str
    source: str
    description: str
    limits: Callable = bulk_yield  # contact, **options → [Limit]
    length: str = "roughness"  # the contact's length that makes the law's curve dimensionless: "roughness" or "radius"
    collapses: bool = True  # one dimensionless curve serves all radii, moduli and roughnesses
    loading: Loading = Loading()
    options: dict = {}  # noqa: RUF012  each option of `prepare` → Option
    unloading: tuple = ("elastic", "hertz")  # rules that it is fitted, chosen and measured with, the plainest first
    rules: Rules = Rules()
    fitting: Fitting = Fitting()
    advice: Advice = Advice()
    drawing: Drawing = Drawing()

    @property
    def solved(self) -> bool:
        """Whether the curve comes from a solver and is a table from the start."""
        return self.loading.computed in (CELLS, MAP)

    @property
    def needs_map(self) -> bool:
        """Whether the law is made from a height map, not from a roughness."""
        return self.loading.computed == MAP

    def read_options(self, options: Mapping[str, Any]) -> dict[str, Any]:
        """Options as numbers in SI units, each read by its record (`Option`), those of the law before yield by its records.

        Options of Python, commands, scenes, engines and files are read here. None counts as not given if the default is None or
        missing. An unknown option stays as it is: `shape` refuses it.
        """
        before, rest = self.before_yield(**options)
        inner = {} if before is None else before.read_options(rest)
        signature, values = _signature(self.prepare).parameters, {}
        for name, value in options.items():
            if value is None and name in signature and signature[name].default in (None, _REQUIRED):
                continue
            record = self.options.get(name)
            values[name] = inner.get(name, value) if record is None else record.read(name, value)
        return values

    def shape(self, contact: Contact, **options: Any) -> Any:
        """Shape of the law for a contact, its options read: an unknown one is a DemlawsError."""
        try:
            _signature(self.prepare).bind_partial(contact, **options)
        except TypeError as error:
            wrong = next((name for name in options if name not in self.options), None)
            text = f"{error}." if wrong is None else f"no option {wrong!r}{did_you_mean(wrong, self.options)}"
            known = f"Its options are {', '.join(self.options)}" if self.options else "It has no options"
            raise DemlawsError(f"law {self.name!r}: {text} {known} (demlaws laws {self.name})") from None
        options = self.read_options(options)
        self.refuse_missing(options)
        for field in self.loading.needs:
            if getattr(contact, field) is None:
                raise MissingQuantity.of(f"law {self.name!r}", field)
        try:
            return self.prepare(contact, **options)
        except TypeError as error:  # a list where a word belongs, or a fault of the function
            text = ", ".join(f"{name}={value!r:.60}" for name, value in options.items())
            raise DemlawsError(f"law {self.name!r}: its prepare(contact, {text}) raises TypeError: {error}") from error

    def refuse_missing(self, given: Collection[str]) -> None:
        """Raise DemlawsError unless all options without a default are among the `given` ones."""
        parameters = list(_signature(self.prepare).parameters.values())[1:]
        missing = [one.name for one in parameters if one.default is _REQUIRED and one.kind is not one.VAR_KEYWORD]
        missing = [name for name in missing if name not in given]
        if missing:
            records = [(name, self.options.get(name, Option("", "", "an option"))) for name in missing]
            texts = [f"{name}{one.unit and f' in {one.unit}'} ({one.meaning})" for name, one in records]
            ways = ", ".join(f"{name}=VALUE" for name in missing)
            typos = [name for name in given if name not in self.options and most_similar(name, missing)]
            typo = f"; {typos[0]!r} is not an option{did_you_mean(typos[0], missing)}" if typos else ""
            raise DemlawsError(f"law {self.name!r} needs {', '.join(texts)}: give {ways}{typo}")

    def default_rule(self, **options: Any) -> str:
        """Name of the unloading rule where a user names none, in Python, commands, scenes and engines.

        "hertz" of laws of rough contacts, the rule of its own of a law that has one, else "elastic".
        """
        rule = self.rules.default
        return rule if isinstance(rule, str) else rule(**options)

    @property
    def has_own_rule(self) -> bool:
        """Whether the default is a rule of plastic contacts: the law yields by itself."""
        return self.default_rule() not in ("elastic", "hertz")

    def offered(self) -> dict[str, Rule]:
        """Name → rule: the general ones but those that the law refuses, then its own."""
        general = {name: rule for name, rule in RULES.items() if name not in self.rules.refused}
        return general | {rule.name: rule for rule in self.rules.own}

    def rule(self, name: str) -> Rule:
        """The rule of this name; DemlawsError where the law does not take it."""
        available = self.offered()
        if isinstance(name, str) and name in available:
            return available[name]
        if isinstance(name, str) and name in self.rules.refused:
            raise DemlawsError(f"law {self.name!r} does not take {name!r} unloading: {self.rules.refused[name]}")
        named = [rule for rule in available if rule != GIVEN]
        rules = f"{did_you_mean(name, named)} The rules are {', '.join(named)} (law {self.name!r})"
        raise DemlawsError(f"unknown unloading rule {name!r}{rules}, or a law or table to unload along")

    def bulk_radius(self, contact: Contact, **options: Any) -> Any:
        """R [m] of the shape that yields and unloads, one per contact: the contact's, unless an option gives another."""
        radius = None if self.loading.bulk is None else self.loading.bulk.radius
        own = None if radius is None else radius(contact, **options)
        return contact.radius if own is None else own

    def before_yield(self, **options: Any) -> tuple:
        """(Definition, its options) of the law that holds before the bulk yields; (None, options) of other laws."""
        return (
            (None, options)
            if self.loading.bulk is None or self.loading.bulk.before is None
            else self.loading.bulk.before(**options)
        )

    def option_lines(self) -> Iterator[str]:
        """A line for each option: name, unit, range, default, meaning."""
        signature = _signature(self.prepare).parameters
        for name, option in self.options.items():
            default = signature[name].default if name in signature else None  # of the law before yield, by **options
            text = "needed" if default is _REQUIRED else "no default"
            if default not in (None, _REQUIRED):
                text = f"default {default if isinstance(default, str) else format(default, '.10g')}"
            unit = f" [{option.unit}]" if option.unit else ""
            yield f"{name}{unit}: {option.meaning}; {option.values}; {text}"

    def needed(self, **options: Any) -> tuple[str, ...]:
        """Names of Contact fields that must be given, those of the law before yield included."""
        definition, rest = self.before_yield(**options)
        if definition is None:
            return self.loading.needs
        return tuple(dict.fromkeys((*self.loading.needs, *definition.needed(**rest))))


def with_sigma(definition: Definition) -> Definition:
    """The definition, σ of the pair by its own name where it is called `roughness`, with a FutureWarning."""
    fitting = definition.fitting
    if "roughness" in definition.options or "roughness" not in {*definition.loading.needs, *fitting.free, *fitting.parameters}:
        return definition
    warn_of_roughness()

    def named(names: Any) -> tuple:
        return tuple(dict.fromkeys("sigma" if name == "roughness" else name for name in names))

    parameters = dict(zip(named(fitting.parameters), fitting.parameters.values(), strict=True))
    return definition._replace(
        loading=definition.loading._replace(needs=named(definition.loading.needs)),
        fitting=fitting._replace(parameters=parameters, free=named(fitting.free)),
    )
