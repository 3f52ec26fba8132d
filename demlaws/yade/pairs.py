"""Which law acts between which surfaces: from a user's arguments to the records that compiled code reads."""

import math
from numbers import Integral
from typing import NamedTuple

import numba
import numpy as np

from demlaws.contact import Contact, Material, Surface, surface_of
from demlaws.core.loops import clamped_roughness, loading_part, scale_contact
from demlaws.core.shear import CHOICES, DEFAULT, DEFAULT_LEVELS, LARGEST_SHEAR_RATIO, MOST_LEVELS, SLIP
from demlaws.core.unloading import GIVEN, RULES
from demlaws.errors import DemlawsError, MissingQuantity, did_you_mean, quiet
from demlaws.files import names_a_file
from demlaws.law import Law, Table
from demlaws.laws import HERTZ
from demlaws.laws.hertz import HertzShape
from demlaws.laws.registry import find
from demlaws.make import known_unloading, law, rebound
from demlaws.units import number
from demlaws.yade import kernel, layout, tuples
from demlaws.yade.radii import Radii
from demlaws.yade.shear import MODES, SPRINGS, Levels

EVERY = "*"
"""In place of a label: every material whose label is not listed."""
FLATS = ("yade", "plane")
NOMINAL = {"radius": (5e-3, 5e-3), "modulus": (30e9, 30e9)}
"""Effective radius [m] and modulus [Pa] with which a law is made and checked where YADE's contacts are not known yet."""

NOT_SERVED = (
    "no law was given for it: the surfaces of its materials are not listed, or a table of a law without a single "
    "dimensionless curve, or a solved curve, was made for other contacts; list the surfaces, make the law after the bodies"
)


class Span(NamedTuple):
    """Smallest and largest effective radius [m] and modulus [Pa] that a pair's contacts may have.

    meets: whether bodies of the two labels can meet by what is known of them (two walls cannot).
    """

    radius: tuple
    modulus: tuple
    meets: bool = True

    def widened(self):
        """At least 2 % of radius, so that laws that depend on it are made as families."""
        return self._replace(radius=(min(self.radius[0], self.radius[1] / 1.02), self.radius[1]))

    def around(self, roughness):
        """At least a hundred times the roughness: whether it fits the bodies is seen when they meet."""
        return self._replace(radius=tuple(max(r, 100.0 * roughness) for r in self.radius))

    def arguments(self):
        """Keyword arguments of a `Contact`: numbers, or the four corners of the span."""
        if self.radius[0] == self.radius[1] and self.modulus[0] == self.modulus[1]:
            return {"radius": self.radius[0], "modulus": self.modulus[0]}
        corners = [(r, e) for r in self.radius for e in self.modulus]
        return {"radius": np.array([r for r, _ in corners]), "modulus": np.array([e for _, e in corners])}


def _surface(label, value):
    if not isinstance(label, str) or not label:
        raise DemlawsError(f"surfaces: {label!r} is not a label; use the label of the YADE materials that have the surface")
    if isinstance(value, Material):
        value = surface_of(value)
    if isinstance(value, Surface):
        return value
    try:
        return Surface(**value)
    except TypeError as error:
        raise DemlawsError(f"surfaces[{label!r}] must be a demlaws.Surface, got {value!r} ({error})") from None


class LawSource:
    """What a user gave as a law: a name with options, a `Law`, a `Table`, or the path of a saved table.

    curve: the `LawSource` of the law to unload along, on a contact whose R, E* and σ are `ratios` of the law's own. (A table
    holds its own.)
    """

    def __init__(self, law, options):
        self.table, self.curve, self.ratios = None, None, (1.0, 1.0, 1.0)
        if names_a_file(law):
            law = Table.load(law)
        if isinstance(law, Table):
            self.table, self.name, self.options = law, law.name, dict(law.options)
            if options:
                raise DemlawsError(f"a table takes no options, got {', '.join(options)}: give them when tabulating")
            if law.contact.size is not None:
                raise DemlawsError("this table is bound to an array of contacts: bind it to one, table.bound_to(contact)")
        elif isinstance(law, Law):
            self.name, self.options = law.name, law.definition.read({**law.options, **options})
        elif isinstance(law, str):
            self.name, self.options = find(law).name, find(law).read(options)
        else:
            raise DemlawsError(f"law must be a law's name, a Law, a Table or the path of a table, got {law!r}")
        self.definition = law.definition if isinstance(law, Law) else find(self.name)
        self.unloading = law.unloading if isinstance(law, Law) else self.definition.default_rule(**self.options)
        if self.table is None and self.unloading == GIVEN:
            self.curve, self.ratios = LawSource(law.unloading_law, {}), tuple(law.shape[2:])

    def unload_along(self, curve):
        """Unload along a law or a `Table`, on the contact's own surfaces."""
        if self.table is not None:
            self.table = self.table.joined(curve)
        else:
            self.curve, self.ratios = LawSource(curve, {}), (1.0, 1.0, 1.0)
        self.unloading = GIVEN

    @property
    def needs_span(self):
        """Whether the law's curve must be solved for the contacts that occur: their range must be known beforehand."""
        return self._any_states("solved")

    @property
    def needs_one_contact(self):
        """Whether the law's curve is solved for one R and E* alone: a height map's."""
        return self._any_states("needs_map")

    def definitions(self):
        """Those that take part: the law's, its loading's, the unloading curve's. (A table stands for itself.)"""
        loading = self.options.get("loading")
        taking_part = [self.definition, *([find(loading)] if isinstance(loading, str) else [])]
        return (taking_part if self.table is None else []) + (self.curve.definitions() if self.curve is not None else [])

    def _any_states(self, fact):
        """Whether a definition that takes part says so of itself."""
        return any(getattr(definition, fact) for definition in self.definitions())

    def _bound(self, contact, unloading):
        """The `Law` (or `Table`) of a contact with a rule."""
        if self.table is not None:
            return rebound(self.table, contact)
        if unloading == GIVEN:
            if self.curve is None:
                raise DemlawsError(f"unloading {GIVEN!r} needs its curve: give a law or a table as `unloading`")
            changes = zip(("radius", "modulus", "roughness"), self.ratios, strict=True)
            curve_contact = contact.with_values(**{name: ratio * getattr(contact, name) for name, ratio in changes})
            unloading = self.curve._bound(curve_contact, "elastic")
        return law(self.name, contact, unloading, **self.options)

    def shape(self, surface, unloading, span):
        """The law's Shape for a combined surface, or None where the pair is Hertz."""
        if self.table is not None:
            return self._table_shape(surface, unloading)
        dimension = surface.fractal_dimension
        if surface.roughness == 0.0 and dimension is None:
            dimension = 2.0  # without roughness it does not matter, but the law wants one
        contact = Contact(
            roughness=surface.roughness, fractal_dimension=dimension, hardness=surface.hardness, **span.arguments()
        )
        if contact.size is not None and self.needs_one_contact:
            (low, high), (soft, stiff) = span.radius, span.modulus
            raise DemlawsError(
                f"law {self.name!r} is solved for one contact, these may have R from {low:g} to {high:g} m and "
                f"E* from {soft:.6g} to {stiff:.6g} Pa: give its values, radii=(R, R) and moduli=(E, E)"
            )
        needs = self.definition.needs + (() if self.curve is None else self.curve.definition.needs)
        if surface.roughness == 0.0 and any(getattr(contact, name) is None for name in needs):
            return None
        shape = self._bound(contact, unloading).shape
        curve = getattr(shape, "unloading", HertzShape())
        if isinstance(loading_part(shape), HertzShape) and isinstance(curve, HertzShape) and self.ratios[:2] == (1.0, 1.0):
            return None
        return shape

    def _table_shape(self, surface, unloading):
        if unloading == GIVEN and self.table.unloading != GIVEN:
            raise DemlawsError(f"unloading {GIVEN!r} needs a curve: the table of {self.name!r} has none")
        contact = self.table.contact
        if surface.roughness == 0.0 and self.table.curve.shape.length_over_roughness:
            return None
        if surface.roughness is None and self.table.curve.shape.length_over_roughness:
            raise MissingQuantity(f"the table of {self.name!r}", "roughness")
        law_curve = "law" in {self.definition.rule(rule).curve for rule in (unloading, self.table.unloading)}
        table = self.table.joined(unloading) if law_curve and unloading != self.table.unloading else self.table
        for name, unit in (("fractal_dimension", ""), ("hardness", " Pa"), ("roughness", " m")):
            value, made_for = getattr(surface, name), getattr(contact, name)
            free = name == "roughness" and self.table.collapses
            if free or value is None or made_for is None:
                continue
            if not math.isclose(value, made_for, rel_tol=1e-6):
                raise DemlawsError(f"the table is for {name} = {made_for:g}{unit}, the surfaces have {value:g}{unit}")
        return table.shape

    def only_for(self, span):
        """R [m] and E* [Pa] outside which this law may not be used, being made for contacts of this span; zeros: any."""
        if self.needs_one_contact:
            return span.radius[1], span.modulus[1]
        for source, (of_radius, of_modulus) in ((self, (1.0, 1.0)), (self.curve, self.ratios[:2])):
            if source is not None and source.table is not None and not source.table.collapses:
                return source.table.contact.radius / of_radius, source.table.contact.modulus / of_modulus
        return 0.0, 0.0


class Pairs:
    """Laws between labelled surfaces. Number 0 stands for every material whose label is not listed: smooth.

    law: see `LawSource`, or a dict (label, label) → one of those, "" standing for unlisted materials. Of two surfaces
    σ² = Sq1² + Sq2² and so on as in `Surface.combined`. A pair of smooth surfaces is Hertz unless the law means more than
    roughness (a yielding bulk). labels, hashes, numbers (pair of surfaces → record) and records are what `kernel.act`
    reads; shapes and roughnesses are those of each record, None for Hertz. spans: (label, label) → `Span`, or a function of
    two labels, or None where nothing is known of the contacts. smooth: materials without a surface are meant smooth; flats:
    "plane" or "yade", shear: one of `shear.MODES`, levels, shear_ratio, radius: see the functor.
    """

    def __init__(
        self,
        law,
        surfaces,
        unloading,
        options,
        spans=None,
        *,
        smooth=False,
        flats="plane",
        shear=DEFAULT,
        levels=None,
        shear_ratio=None,
        radius=None,
    ):
        if isinstance(surfaces, Surface | Material):
            surfaces = {EVERY: surfaces}
        if not isinstance(surfaces, dict | None):
            raise DemlawsError(
                "surfaces must be one demlaws.Surface for all materials, or a dict from labels of YADE's materials to theirs "
                f'(surfaces={{"granite": demlaws.Surface(2.4e-6, 2.22)}}), by which contacts find them; got {surfaces!r}'
            )
        if flats not in FLATS:
            raise DemlawsError(f'flats must be "plane" (R of a sphere on a flat is its radius) or "yade", got {flats!r}')
        self.smooth, self.flats = bool(smooth), flats
        self._choose_shear(shear, levels, shear_ratio)
        self.surfaces = {label: _surface(label, value) for label, value in (surfaces or {}).items()}
        self.everywhere = self.surfaces.pop(EVERY, None)
        self.labels = ["", *self.surfaces]
        entries = [self.everywhere or Surface(0.0), *self.surfaces.values()]
        self.radii = Radii(radius, [surface.edge_radius for surface in entries])
        self._spans = spans if callable(spans) else (spans or {}).get if isinstance(spans, dict) else lambda pair: None
        self.spans = {}
        if isinstance(law, dict):
            if not law:
                raise DemlawsError("law: an empty dict names no law; give a law, or a dict (label, label) → law")
            self.default = None
            self.by_pair = {self._key(pair): self._source(one, options) for pair, one in law.items()}
            rules = {source.unloading for source in self.by_pair.values()}
        else:
            self.default, self.by_pair = self._source(law, options), {}
            rules = {self.default.unloading}
            if isinstance(law, Law) and not (self.surfaces or self.everywhere or self.smooth):
                raise DemlawsError("give surfaces={label: demlaws.Surface(...)} for the materials that the law is for")
        if unloading is None and len(rules) > 1:
            raise DemlawsError(f"the laws have different unloading rules ({', '.join(sorted(rules))}): give unloading=…")
        self.unloading = rules.pop() if rules else "elastic"
        if unloading is not None and not (unloading == GIVEN and rules == {GIVEN}):
            named = unloading if unloading == GIVEN else known_unloading(unloading)
            self.unloading = GIVEN if isinstance(named, Law) else named
            for source in self.sources if isinstance(named, Law) else ():
                source.unload_along(named)
        records = {source.definition.rule(self.unloading) for source in self.sources}  # each law must take the rule
        rule = records.pop() if records else RULES["elastic"]
        self.rule, self.state_names, self.rule_curve = rule.tag, rule.state, rule.curve
        if self.springs and rule.springs is None:
            raise DemlawsError(f"shear={SLIP!r} needs an unloading rule with springs, for instance 'hertz', not {rule.name!r}")
        if not self._make_records(entries, False) and not self._make_records(entries, True):
            raise DemlawsError("the pairs of surfaces need laws of one kind, or all tables")
        self.hashes = np.array([0] + [layout.label_hash(label) for label in self.surfaces], np.int64)

    def _choose_shear(self, shear, levels, ratio):
        if not isinstance(shear, str) or shear not in MODES:
            raise DemlawsError(f"shear must be {', '.join(map(repr, MODES))}, got {shear!r:.60}")
        self.shear_name, self.mode, self.shear = shear, MODES[shear], CHOICES[shear if shear in CHOICES else DEFAULT].tag
        self.springs, in_levels = SPRINGS if shear == SLIP else 0, isinstance(self.mode, Levels)
        if not in_levels and levels is not None:
            raise DemlawsError(f"shear={shear!r} has no levels: leave out levels={levels!r}")
        count = DEFAULT_LEVELS if levels is None else levels
        if isinstance(count, bool) or not isinstance(count, Integral) or not 1 <= count <= MOST_LEVELS:
            raise DemlawsError(f"levels must be a whole number from 1 to {MOST_LEVELS}, got {levels!r:.60}")
        self.levels = int(count) if in_levels else 0
        self.shear_ratio = None if ratio is None else number(ratio, "shear_ratio", high=LARGEST_SHEAR_RATIO)

    @staticmethod
    def _source(law, options):
        return law if isinstance(law, LawSource) else LawSource(law, options)

    @property
    def sources(self):
        """Every `LawSource`."""
        return [source for source in (self.default, *self.by_pair.values()) if source is not None]

    def _key(self, pair):
        if not isinstance(pair, tuple) or len(pair) != 2:
            raise DemlawsError(f"law: {pair!r} is not a pair of labels out of {self.labels}")
        for label in pair:
            if label not in self.labels:
                labels = ", ".join(map(repr, self.labels))
                raise DemlawsError(
                    f"law: unknown label {label!r} in {pair!r}{did_you_mean(label, self.labels)} Labels: {labels}"
                )
        return tuple(sorted(pair))

    def _make_records(self, surfaces, widened):
        """False where the pairs' laws turn out to be of different kinds."""
        count = len(surfaces)
        self.numbers = np.zeros((count, count), np.int64)
        self.shapes, self.roughnesses, self.only_for, self.combined = [], [], [], []
        for i in range(count):
            for j in range(i + 1):
                self.numbers[i, j] = self.numbers[j, i] = len(self.shapes)
                pair = surfaces[i].combined(surfaces[j])
                labels = self.labels[j], self.labels[i]
                self.combined.append((pair, self.by_pair.get(tuple(sorted(labels)), self.default)))
                shape, only_for = self._pair(pair, labels, widened)
                self.shapes.append(shape)
                self.only_for.append(only_for)
                self.roughnesses.append(pair.roughness or 0.0)  # of a smooth law it need not be given
        kinds = {numba.typeof(shape) for shape in self.shapes if shape is not None}
        if len(kinds) > 1:
            return False
        if not kinds and self.rule_curve == "law":
            raise DemlawsError(
                f"law {self.name}: no pair of surfaces has what the law needs, and a smooth contact has no such unloading. "
                "Give surfaces=demlaws.Surface(…) with the quantities of `demlaws laws` for this law"
            )
        example, number = next(
            ((shape, n) for n, shape in enumerate(self.shapes) if shape is not None), (HertzShape(), len(self.shapes) - 1)
        )
        self.kind = numba.typeof(example)
        radius, modulus = self.specimen(number)
        params = scale_contact(example, radius, modulus, clamped_roughness(self.roughnesses[number], radius))
        self.params_kind = numba.typeof(params)
        own = tuples.own_fields(self.params_kind, self.kind)
        self.row = layout.row_dtype(self.levels, own, self.springs)
        self.saved = layout.part(self.row, layout.saved_fields(self.row))
        self._keep = []
        self.records = np.zeros(len(self.shapes), layout.pair_dtype(tuples.fields(self.kind, "shape")))
        for record, shape, roughness, only_for in zip(self.records, self.shapes, self.roughnesses, self.only_for, strict=True):
            record["smooth"], record["roughness"] = shape is None, roughness
            record["radius"], record["modulus"] = only_for
            if shape is not None:
                tuples.pack(shape, record, "shape", self._keep)
        return True

    def of_a_law(self):
        """Two labels whose pair the law is for, and its record: the last ones, which are listed if any is."""
        last = len(self.labels) - 1
        places = [(i, j, int(self.numbers[i, j])) for i in range(last, -1, -1) for j in range(i, -1, -1)]
        i, j, number = next((place for place in places if self.shapes[place[2]] is not None), places[0])
        return (self.labels[i], self.labels[j]), number

    def specimen(self, number):
        """R [m] and E* [Pa] of a contact that the law of this record serves."""
        if self.only_for[number][0] > 0.0:
            return self.only_for[number]
        span = self.spans.get(number, Span(**NOMINAL))
        return span.radius[1], span.modulus[1]

    def _pair(self, surface, labels, widened):
        source = self.by_pair.get(tuple(sorted(labels)), self.default)
        complete = all(labels) or self.everywhere is not None or self.smooth
        if source is None:
            if surface.roughness == 0.0:
                return None, (0.0, 0.0)
            if not complete:
                return None, (math.nan, math.nan)
            raise DemlawsError(f"law has no entry for the pair {labels!r}, which is not known to be smooth")
        if len(self.labels) == 1:
            names = "materials without a surface" if self.everywhere is None else "surface for all materials"
        else:
            names = " on ".join(repr(label) if label else "unlisted materials" for label in labels)
        span = self._spans(labels)
        if span is None:
            if source.needs_span and surface.roughness != 0.0 and complete:
                raise DemlawsError(
                    f"{names}: the curve of law {source.name!r} is solved for the contacts that occur: make the law "
                    "after materials and bodies, or give radii=(smallest, largest) in m and moduli=(smallest, largest) in Pa"
                )
            span = Span(**NOMINAL).around(surface.roughness or 0.0)
            if source.needs_span:
                return None, (math.nan, math.nan)  # no such contact is expected, and none is served
        if not span.meets and source.needs_one_contact:
            return None, (math.nan, math.nan)
        span = span.widened() if widened else span
        self.spans[len(self.shapes)] = span
        try:
            shape = source.shape(surface, self.unloading, span)
        except DemlawsError as error:
            missing = isinstance(error, MissingQuantity)
            text = f"{names}: {error.given_by(f'Surface({error.quantity}=...)') if missing else error}"
            if not complete and len(self.labels) > 1:
                return None, (math.nan, math.nan)  # such a contact, should it occur, stops the simulation
            raise DemlawsError(text) from None
        return shape, (0.0, 0.0) if shape is None else source.only_for(span)

    def known_spans(self):
        """(labels, `Span`) of all pairs of which something is known."""
        for i, second in enumerate(self.labels):
            for first in self.labels[: i + 1]:
                span = self._spans((first, second))
                if span is not None:
                    yield (first, second), span

    def number(self, first, second):
        """Record of two materials' labels."""
        return int(self.numbers[tuple(self.labels.index(x) if x in self.surfaces else 0 for x in (first, second))])

    # --- contacts outside YADE's objects

    def respond(self, contacts):
        """What the law answers to an array of `layout.CONTACT`, whose state is updated in place: an array of
        `layout.RESPONSE`, and the first contact whose force is not finite, or -1."""
        out = np.zeros(len(contacts), layout.RESPONSE)
        return out, kernel.respond_loop(self.kind, self.shear, self.rule, self.records, contacts, out)

    def energies(self, contacts):
        """Stored and dissipated energy of an array of `layout.CONTACT`: an array of `layout.ENERGY`."""
        out = np.zeros(len(contacts), layout.ENERGY)
        kernel.energies_loop(self.kind, self.rule, self.records, contacts, out)
        return out

    def yielded(self, contacts, highest, energies):
        """Whether contacts have yielded: an array of bool. highest: largest overlaps so far [m]; energies: see above."""
        lost, stored = energies["dissipated"], energies["stored"]
        result = lost > 1e-9 * (stored + lost)
        laws = [source for _, source in self.combined]
        own = np.array([source is not None and source.definition.bulk is not None for source in laws])
        mine = own[contacts["tag"].astype(int) - 1] if len(contacts) else np.zeros(0, bool)
        if mine.any():
            bulk = np.zeros(len(contacts), bool)
            kernel.yielded_loop(self.kind, self.records, contacts, highest, bulk)
            result[mine] = bulk[mine]
        return result

    def limits(self, number, radius, modulus):
        """`Limit`s of the law of a record for a contact of this R [m] and E* [Pa]."""
        surface, source = self.combined[number]
        if self.shapes[number] is None:
            source = LawSource(HERTZ, {})
        dimension = 2.0 if surface.fractal_dimension is None and surface.roughness == 0.0 else surface.fractal_dimension
        with quiet():  # of the roughness
            contact = Contact(radius, modulus, surface.roughness, dimension, surface.hardness)
        return source.definition.limits(contact, **source.options)

    def serves(self, number, radius, modulus):
        """Whether the law of a record may be used at this R and E*."""
        return kernel.serves(self.records[number], radius, modulus)

    def all_surfaces(self):
        """Label → surface, with `EVERY` for the materials that are not listed, if they have one."""
        return self.surfaces if self.everywhere is None else {**self.surfaces, EVERY: self.everywhere}

    @property
    def needs_no_judgement(self):
        """Whether materials that are not listed are known to be meant as they are served."""
        return self.smooth or self.only_hertz or self.everywhere is not None

    @property
    def only_hertz(self):
        """Whether the law needs no surface, being Hertz for every pair."""
        return all(source.definition.hertzian for source in self.sources)

    @property
    def name(self):
        """What acts, in words."""
        sources = {source.name + (" (table)" if source.table else "") for source in self.sources}
        return f"{', '.join(sorted(sources))}, {self.unloading} unloading"
