"""Which law acts between which surfaces: from a user's arguments to the records that compiled code reads."""

import math
from numbers import Integral

import numba
import numpy as np

from demlaws.contact import Contact, Material, Surface, hardness_doubt, surface_of
from demlaws.core.dispatch import leaves, refuse_other_values
from demlaws.core.loops import clamped_roughness, loading_part, scale_contact
from demlaws.core.shear import CHOICES, DEFAULT, DEFAULT_LEVELS, LARGEST_SHEAR_RATIO, MOST_LEVELS, SLIP, SPRINGS
from demlaws.core.unloading import GIVEN, RULES
from demlaws.curves.closed import FormulaCurve
from demlaws.curves.unloading import UNKNOWN_AREA, BoundLaw, Unloading, knows_area, refuse_unless_passive
from demlaws.errors import DemlawsError, MissingQuantity, did_you_mean, quiet
from demlaws.laws import HERTZ
from demlaws.laws.definition import HERTZ_CURVE
from demlaws.laws.hertz import HertzShape
from demlaws.laws.registry import find, laws
from demlaws.units import number
from demlaws.yade import kernel, layout
from demlaws.yade.friction import ByPressure, Choice, Constant
from demlaws.yade.radii import Radii
from demlaws.yade.shear import MODES, Levels, Native

ALL_LABELS = "*"
"""In place of a label: every material whose label is not listed."""
FLATS = ("yade", "plane")
TYPICAL_RADIUS, TYPICAL_MODULUS = 5e-3, 30e9
"""Effective radius [m] and modulus [Pa] with which a law is made and tested, since contacts are not known yet; the kernels give
NaN where a contact does not fit."""

NOT_SERVED = (
    "no law was given for it: the surfaces of its materials are not listed, or the table or the measured map is that of "
    "another contact; list the surfaces, give the law of this R and E*"
)


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


def _bound_law(law):
    """The `Law` or `Table` that a user gave, read where it is the path of one; None for a law's name."""
    if isinstance(law, str) and law in laws():
        return None
    from demlaws.files import names_a_file
    from demlaws.law import Law, Table

    if names_a_file(law):
        return Table.load(law)
    if isinstance(law, str):
        return None
    if isinstance(law, Law):
        return law
    raise DemlawsError(f"law must be a law's name, a Law, a Table or the path of a table, got {law!r}")


def _has_numbers_only(kind):
    """Whether a numba type is a number, an array, None, or a tuple of those."""
    if isinstance(kind, numba.types.BaseTuple):
        return all(map(_has_numbers_only, kind))
    return isinstance(kind, numba.types.Number | numba.types.Boolean | numba.types.Array | numba.types.NoneType)


class LawSource:
    """What a user gave as a law: a name with options, a `Law`, a `Table`, or the path of a saved table.

    only: R [m] and E* [Pa] of the only contact that a measured map's law serves, or None. curve: the `LawSource` of the law to
    unload along, on a contact whose R, E* and σ are `ratios` of the law's own. (A table holds its own.)
    """

    def __init__(self, law, options):
        self.table, self.curve, self.ratios, self.only = None, None, (1.0, 1.0, 1.0), None
        bound = _bound_law(law)
        if bound is None:
            self.definition = find(law)
            self.name, self.options = law, self.definition.read_options(options)
            self.unloading = self.definition.default_rule(**self.options)
            return
        self.definition, self.name, self.unloading = bound.definition, bound.name, bound.unloading
        if bound.curve.tabulated:
            self.table, self.options = bound, dict(bound.options)
            if options:
                raise DemlawsError(f"a table takes no options, got {', '.join(options)}: give them when tabulating")
            if bound.contact.size is not None:
                raise DemlawsError("this table is bound to an array of contacts: bind it to one, table.bound_to(contact)")
            return
        self.options = self.definition.read_options({**bound.options, **options})
        if bound.contact.size is None and self.needs_one_contact:
            self.only = bound.contact.radius, bound.contact.modulus
        if self.unloading == GIVEN:
            self.curve, self.ratios = LawSource(bound.unloading_law, {}), tuple(bound.shape[2:])

    @property
    def needs_one_contact(self):
        """Whether the law's curve of first loading is solved for one R and E* alone: a height map's."""
        return any(definition.needs_map for definition in self._loading_definitions())

    def knows_area(self, unloading):
        """Whether a²/R of contacts with a rule is the law's."""
        return self.table is None or knows_area(self.table.curve, self.definition.rule(unloading))

    def definitions(self):
        """Those that take part: the law's, its loading's, the unloading curve's. (A table stands for itself.)"""
        return self._loading_definitions() + (self.curve.definitions() if self.curve is not None else [])

    def _loading_definitions(self):
        loading = self.options.get("loading")
        taking_part = [self.definition, *([find(loading)] if isinstance(loading, str) else [])]
        return taking_part if self.table is None else []

    def _bound(self, contact, unloading):
        """The law of a contact with a rule (a `Table`, or `BoundLaw`)."""
        if self.table is not None:
            from demlaws.make import unloading_for

            return unloading_for(self.table, contact)
        parts = Unloading(self.definition.rule(unloading))
        if unloading == GIVEN:
            if self.curve is None:
                raise DemlawsError(f"unloading {GIVEN!r} needs its curve: give a law or a table as `unloading`")
            changes = zip(("radius", "modulus", "sigma"), self.ratios, strict=True)
            curve_contact = contact.with_values(**{name: ratio * getattr(contact, name) for name, ratio in changes})
            along = self.curve._bound(curve_contact, "elastic")
            parts = parts._replace(curve=along.curve, contact=along.contact)
        return BoundLaw(contact, FormulaCurve(self.definition, contact, self.options), parts)

    def shape(self, surface, unloading, modulus):
        """The law's Shape for a combined surface, or None where the pair is Hertz; modulus: see `Pairs`."""
        if self.table is not None:
            return self._table_shape(surface, unloading)
        dimension = surface.fractal_dimension
        if surface.roughness == 0.0 and dimension is None:
            dimension = 2.0  # without roughness it does not matter, but the law wants one
        known = modulus is not None or self.serves_only()[1] > 0.0
        radius, modulus = self.contacts(surface, modulus)
        contact = Contact(radius, modulus, surface.roughness, dimension, surface.hardness)
        needs = self.definition.loading.needs + (() if self.curve is None else self.curve.definition.loading.needs)
        if surface.roughness == 0.0 and any(getattr(contact, name) is None for name in needs):
            return None
        bound = self._bound(contact, unloading)
        if known:  # else the first contact of each pair is checked with its E*
            refuse_unless_passive(bound)
        shape = bound.shape
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
            raise MissingQuantity.of(f"the table of {self.name!r}", "sigma")
        law_curve = "law" in {self.definition.rule(rule).curve for rule in (unloading, self.table.unloading)}
        table = self.table.joined(unloading) if law_curve and unloading != self.table.unloading else self.table
        for name, unit in (("fractal_dimension", ""), ("hardness", " Pa"), ("sigma", " m")):
            value, made_for = getattr(surface, "roughness" if name == "sigma" else name), getattr(contact, name)
            free = name == "sigma" and self.table.collapses
            if free or value is None or made_for is None:
                continue
            if not math.isclose(value, made_for, rel_tol=1e-6):
                raise DemlawsError(f"the table is for {name} = {made_for:g}{unit}, the surfaces have {value:g}{unit}")
        return table.shape

    def contacts(self, surface, modulus):
        """R [m] and E* [Pa] with which the law is made: those of its only contact, or two that differ, for any."""
        only = self.serves_only()
        if only[0] > 0.0:
            return only
        # both at most the radius of the bulk that an option gives; whether the law fits the bodies is seen when they meet
        tip = Contact(1e-12, TYPICAL_MODULUS)
        bulk = self.definition.bulk_radius(tip, **self.options)
        typical = min(TYPICAL_RADIUS, 0.5 * bulk) if bulk > tip.radius else TYPICAL_RADIUS
        radius = max(typical, 100.0 * (surface.roughness or 0.0))
        modulus = modulus or (5.0 * surface.hardness if surface.hardness else TYPICAL_MODULUS)
        return np.array([radius, 2.0 * radius]), np.full(2, modulus)

    def serves_only(self):
        """R [m] and E* [Pa] outside which this law may not be used; zeros: any."""
        for source, (of_radius, of_modulus) in ((self, (1.0, 1.0)), (self.curve, self.ratios[:2])):
            if source is None:
                continue
            if source.table is not None and not source.table.collapses:
                return source.table.contact.radius / of_radius, source.table.contact.modulus / of_modulus
            if source.only is not None:
                return source.only[0] / of_radius, source.only[1] / of_modulus
            if source.needs_one_contact:
                raise DemlawsError(
                    f"law {source.name!r} is solved for one contact: give the law of this contact, "
                    f"dl.law({source.name!r}, dl.Contact(radius=…, modulus=…, sigma=…), …), or its table"
                )
        return 0.0, 0.0


class Pairs:
    """Laws between labelled surfaces. Number 0 stands for every material whose label is not listed: smooth.

    law: see `LawSource`, or a dict (label, label) → one of those, or a name and its options; "": unlisted. Of two surfaces
    σ² = Sq1² + Sq2² and so on as in `Surface.combined`. A pair of smooth surfaces is Hertz unless the law means more than
    roughness (a yielding bulk). encoded_labels, numbers (pair of surfaces → record) and records are what `kernel.go`
    reads; shapes and roughnesses are those of each record, None for Hertz. modulus: E* [Pa] with which pressures of the laws
    are compared, or None. smooth: materials without a surface are meant smooth; flats: "plane" or "yade", shear: one of
    `shear.MODES`, levels, shear_ratio, radius, friction: see the functor.
    """

    def __init__(
        self,
        law,
        surfaces,
        unloading,
        options,
        modulus=None,
        *,
        smooth=False,
        flats="plane",
        shear=DEFAULT,
        levels=None,
        shear_ratio=None,
        radius=None,
        friction=None,
    ):
        if isinstance(surfaces, Surface | Material):
            surfaces = {ALL_LABELS: surfaces}
        if not isinstance(surfaces, dict | None):
            raise DemlawsError(
                "surfaces must be one demlaws.Surface for all materials, or a dict from labels of YADE's materials to theirs "
                f'(surfaces={{"granite": demlaws.Surface(2.4e-6, 2.22)}}), by which contacts find them; got {surfaces!r}'
            )
        if flats not in FLATS:
            raise DemlawsError(f'flats must be "plane" (R of a sphere on a flat is its radius) or "yade", got {flats!r}')
        self.smooth, self.flats, self.modulus = bool(smooth), flats, modulus
        self._choose_shear(shear, levels, shear_ratio)
        self.surfaces = {label: _surface(label, value) for label, value in (surfaces or {}).items()}
        self.everywhere = self.surfaces.pop(ALL_LABELS, None)
        if isinstance(law, dict) and (self.smooth or self.everywhere is not None):
            named = [label for pair in law if isinstance(pair, tuple) for label in pair if isinstance(label, str) and label]
            self.surfaces = {label: self.everywhere or Surface(0.0) for label in named} | self.surfaces
        self.labels = ["", *self.surfaces]
        self.encoded_labels = np.array([label.encode() for label in self.labels])
        entries = [self.everywhere or Surface(0.0), *self.surfaces.values()]
        self.friction = Choice(friction, self.labels, ALL_LABELS)
        self.of_materials: dict = {}  # what `material_options` took
        self.radii = Radii(radius, [surface.edge_radius for surface in entries])
        if isinstance(law, dict):
            if not law:
                raise DemlawsError("law: an empty dict names no law; give a law, or a dict (label, label) → law")
            self.default = None
            self.by_pair = {self._key(pair): self._source(one, options) for pair, one in law.items()}
            rules = {source.unloading for source in self.by_pair.values()}
        else:
            self.default, self.by_pair = self._source(law, options), {}
            rules = {self.default.unloading}
            if isinstance(law, BoundLaw) and not (self.surfaces or self.everywhere or self.smooth):
                raise DemlawsError("give surfaces={label: demlaws.Surface(...)} for the materials that the law is for")
        if unloading is None and len(rules) > 1:
            raise DemlawsError(f"the laws have different unloading rules ({', '.join(sorted(rules))}): give unloading=…")
        self.unloading = rules.pop() if rules else "elastic"
        if unloading is not None and not (unloading == GIVEN and rules == {GIVEN}):
            self.unloading = unloading if isinstance(unloading, str) and unloading in RULES else self._unloading(unloading)
        records = {source.definition.rule(self.unloading) for source in self.sources}  # each law must take the rule
        rule = records.pop() if records else RULES["elastic"]
        self.state_names = rule.state
        if self.springs and rule.springs is None:
            raise DemlawsError(f"shear={SLIP!r} needs an unloading rule with springs, for instance 'hertz', not {rule.name!r}")
        self._make_records(entries, rule)

    def _choose_shear(self, shear, levels, ratio):
        if not isinstance(shear, str) or shear not in MODES:
            raise DemlawsError(f"shear must be {', '.join(map(repr, MODES))}, got {shear!r:.60}")
        self.shear_name = shear
        self.springs, in_levels = SPRINGS if shear == SLIP else 0, isinstance(MODES[shear], Levels)
        if not in_levels and levels is not None:
            raise DemlawsError(f"shear={shear!r} has no levels: leave out levels={levels!r}")
        count = DEFAULT_LEVELS if levels is None else levels
        if isinstance(count, bool) or not isinstance(count, Integral) or not 1 <= count <= MOST_LEVELS:
            raise DemlawsError(f"levels must be a whole number from 1 to {MOST_LEVELS}, got {levels!r:.60}")
        self.levels = int(count) if in_levels else 0
        self.shear_ratio = None if ratio is None else number(ratio, "shear_ratio", high=LARGEST_SHEAR_RATIO)

    def _unloading(self, unloading):
        """Name of a rule of a law, or GIVEN: every law then unloads along the given one."""
        from demlaws.make import check_unloading

        named = check_unloading(unloading)
        if isinstance(named, str):
            return named
        for source in self.sources:
            if source.table is not None:
                source.table = source.table.joined(named)
            else:
                source.curve, source.ratios = LawSource(named, {}), (1.0, 1.0, 1.0)
            source.unloading = GIVEN
        return GIVEN

    @staticmethod
    def _source(law, options):
        if isinstance(law, tuple) and len(law) == 2 and isinstance(law[1], dict):
            law, options = law[0], {**options, **law[1]}
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
                labels = ", ".join(map(repr, self.surfaces)) or "none"
                raise DemlawsError(
                    f"law: label {label!r} of the pair {pair!r} has no surface.{did_you_mean(label, self.surfaces)} Labels "
                    f"with one: {labels}. Give surfaces={{{label!r}: demlaws.Surface(…), …}}, or smooth=True if the others "
                    "are smooth"
                )
        return tuple(sorted(pair))

    def _make_records(self, surfaces, rule):
        count = len(surfaces)
        self.numbers = np.zeros((count, count), np.int64)
        self.shapes, self.roughnesses, self.combined, more = [], [], [], []
        for i in range(count):
            for j in range(i + 1):
                self.numbers[i, j] = self.numbers[j, i] = len(self.shapes)
                pair = surfaces[i].combined(surfaces[j])
                labels = self.labels[j], self.labels[i]
                self.combined.append((pair, self.by_pair.get(tuple(sorted(labels)), self.default)))
                shape, serves_only = self._pair(pair, labels)
                self.shapes.append(shape)
                more.append((*serves_only, *self.friction.of(*labels)))
                self.roughnesses.append(pair.roughness or 0.0)  # of a smooth law it need not be given
        kinds = {numba.typeof(shape) for shape in self.shapes if shape is not None}
        if len(kinds) > 1:
            names = ", ".join(sorted({source.name for source in self.sources}))
            raise DemlawsError(
                f"law: one functor computes one law, with options by pair, or tables of any laws, got {names}: give each pair "
                "a table, dl.law(...).tabulate()"
            )
        if not kinds and rule.curve == "law":
            raise DemlawsError(
                f"law {self.name}: no pair of surfaces has what the law needs, and a smooth contact has no such unloading. "
                "Give surfaces=demlaws.Surface(…) with the quantities of `demlaws laws` for this law"
            )
        example, number = next(
            ((shape, n) for n, shape in enumerate(self.shapes) if shape is not None), (HertzShape(), len(self.shapes) - 1)
        )
        radius, modulus = self.typical_contact(number)
        params = scale_contact(example, radius, modulus, clamped_roughness(self.roughnesses[number], radius))
        refuse_other_values(params)
        floats = len(list(leaves(params)))
        kinds = [numba.typeof(value) for value in (example, params, (0.0,) * len(rule.state))]
        shear = CHOICES[self.shear_name if self.shear_name in CHOICES else DEFAULT].tag
        self.law = kernel.Law(*kinds, rule.tag, shear, MODES[self.shear_name], self.friction.tag)
        self.row = layout.row_dtype(self.levels, floats, self.springs)
        self.contact = layout.contact_dtype(floats)
        self.saved = layout.saved_dtype(self.row)
        if not _has_numbers_only(self.law.shape):
            raise TypeError(f"a law's shape is {self.law.shape}, which cannot be passed to YADE")
        words = kernel.write_shape(self.law.shape, example, np.zeros(0, np.int64))
        self.records = np.zeros(len(self.shapes), layout.pair_dtype(max(words, 1)))
        for record, shape, roughness, numbers in zip(self.records, self.shapes, self.roughnesses, more, strict=True):
            record["smooth"], record["roughness"] = shape is None, roughness
            record["radius"], record["modulus"], record["mu0"], record["c1"], record["c2"] = numbers
            if shape is not None:
                kernel.write_shape(self.law.shape, shape, record["shape"])

    def pair_of_law(self):
        """Two labels whose pair the law is for, and its record: the last ones, which are listed if any is."""
        last = len(self.labels) - 1
        places = [(i, j, int(self.numbers[i, j])) for i in range(last, -1, -1) for j in range(i, -1, -1)]
        i, j, number = next((place for place in places if self.shapes[place[2]] is not None), places[0])
        return (self.labels[i], self.labels[j]), number

    def typical_contact(self, number):
        """R [m] and E* [Pa] of a contact that the law of this record serves."""
        surface, source = self.combined[number]
        if source is None:
            return TYPICAL_RADIUS, TYPICAL_MODULUS
        radius, modulus = source.contacts(surface, self.modulus)
        return float(np.min(radius)), float(np.min(modulus))

    def _pair(self, surface, labels):
        source = self.by_pair.get(tuple(sorted(labels)), self.default)
        complete = all(labels) or self.everywhere is not None or self.smooth
        if source is None:
            if surface.roughness == 0.0:
                return None, (0.0, 0.0)
            if not complete:
                return None, (math.nan, math.nan)
            raise DemlawsError(
                f"law has no entry for the pair {labels!r}, which is not known to be smooth: add it to the dict, even if such "
                "bodies do not meet"
            )
        if len(self.labels) == 1:
            names = "materials without a surface" if self.everywhere is None else "surface for all materials"
        else:
            names = " on ".join(repr(label) if label else "unlisted materials" for label in labels)
        try:
            shape = source.shape(surface, self.unloading, self.modulus)
        except DemlawsError as error:
            where = " to its Surface" if isinstance(error, MissingQuantity) else ""
            if not complete and len(self.labels) > 1:
                return None, (math.nan, math.nan)  # such a contact, should it occur, stops the simulation
            raise DemlawsError(f"{names}: {error}{where}") from None
        if isinstance(self.friction.tag, ByPressure) and not source.knows_area(self.unloading):
            raise DemlawsError(UNKNOWN_AREA.format(f"{names}: the table of law {source.name!r}"))
        return shape, (0.0, 0.0) if shape is None else source.serves_only()

    def number(self, first, second):
        """Record of two materials' labels."""
        return int(self.numbers[tuple(self.labels.index(x) if x in self.surfaces else 0 for x in (first, second))])

    # --- contacts outside YADE's objects

    def contacts_of(self, numbers, radius, modulus):
        """New contacts of pairs of these numbers, of R [m] and E* [Pa]: an array of `layout.contact_dtype`, K_t/K = 1."""
        contacts = np.zeros(len(numbers), self.contact)
        contacts["ratio"], contacts["tag"], contacts["radius"], contacts["modulus"] = 1.0, np.add(numbers, 1.0), radius, modulus
        kernel.fill_loop(self.law, self.records, contacts)
        return contacts

    def evaluate(self, contacts):
        """Response to the overlaps of an array of `layout.contact_dtype`, whose state is updated in place, and the energies of
        the state before: an array of `layout.EVALUATED`, and the first contact whose force is not finite, or -1.

        pressure: the mean one [Pa]; NaN where the law's table does not contain the area. yielded: 1 where the bulk has passed
        the law's yield point.
        """
        out, places = np.zeros(len(contacts), layout.EVALUATED), contacts["tag"].astype(int) - 1
        law = self.law._replace(mode=Native(), friction=Constant())
        bad = kernel.evaluate_loop(law, self.records, contacts, out)
        known = [source is None or source.knows_area(self.unloading) for _, source in self.combined]
        out["pressure"][~np.array(known)[places]] = math.nan
        out["yielded"] *= self.yields[places]
        return out, bad

    @property
    def yields(self):
        """Which records have a law whose bulk yields."""
        return np.array([source is not None and source.definition.loading.bulk is not None for _, source in self.combined])

    def limits(self, number, radius, modulus):
        """`Limit`s of the law of a record for a contact of this R [m] and E* [Pa]."""
        source = LawSource(HERTZ, {}) if self.shapes[number] is None else self.combined[number][1]
        with quiet():  # of roughness and radius
            return source.definition.limits(self._contact(number, radius, modulus), **source.options)

    def _contact(self, number, radius, modulus):
        """The contact of a record's surfaces of this R [m] and E* [Pa]."""
        surface, _ = self.combined[number]
        dimension = 2.0 if surface.fractal_dimension is None and surface.roughness == 0.0 else surface.fractal_dimension
        return Contact(radius, modulus, surface.roughness, dimension, surface.hardness)

    def doubt(self, number, radius, modulus):
        """Raise where the law of a record does not fit a contact of this R [m] and E* [Pa], as Python does; text of a warning
        that was not issued when the law was made, or None. (A table is checked when it is read.)"""
        surface, source = self.combined[number]
        if self.shapes[number] is None or source.table is not None:
            return None
        with quiet():
            bound = source._bound(self._contact(number, radius, modulus), self.unloading)
            refuse_unless_passive(bound)
            _ = bound.params
        if self.modulus and hardness_doubt(surface.hardness, self.modulus):
            return None
        return hardness_doubt(surface.hardness, modulus)

    def all_surfaces(self):
        """Label → surface, with `ALL_LABELS` for the materials that are not listed, if they have one."""
        return self.surfaces if self.everywhere is None else {**self.surfaces, ALL_LABELS: self.everywhere}

    @property
    def needs_no_judgement(self):
        """Whether the script has said how materials that are not listed are treated."""
        only_hertz = all(source.definition.loading.computed == HERTZ_CURVE for source in self.sources)
        return self.smooth or only_hertz or self.everywhere is not None

    @property
    def name(self):
        """What acts, in words."""
        sources = {source.name + (" (table)" if source.table else "") for source in self.sources}
        return f"{', '.join(sorted(sources))}, {self.unloading} unloading"
