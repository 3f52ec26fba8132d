"""A `Scene`: the grains and loads of a simulation, and samples of its contacts."""

import contextlib
import itertools
import math
import os
from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path

import numpy as np

from demlaws.advice.errors import QUANTITIES, Sample
from demlaws.contact import (
    DENSITY,
    Contact,
    Material,
    Surface,
    effective_modulus,
    effective_radius,
    softer_hardness,
    surface_of,
)
from demlaws.core.unloading import GIVEN
from demlaws.errors import DemlawsError, NotPassive, did_you_mean
from demlaws.files import as_path, names_a_file, read_text
from demlaws.law import Law
from demlaws.laws.registry import find
from demlaws.make import check_unloading, law as bind_law
from demlaws.timestep import shear_ratio, timestep
from demlaws.units import number, positive, refuse_plain_radius

ENGINES = ("python", "yade", "liggghts", "lammps")
PROCESSES = ("oedometer", "shear", "pour")
"""What a packing may undergo: it is pressed to its stress, strained by a given amount, or falls for a given time."""
_POINTS = 2800
TEMPLATE = Path(__file__).with_name("template.toml")
"""A scene file with every key and its meaning (`demlaws choose --template`)."""


@dataclass(frozen=True)
class Scene:
    """Grains and loads of a simulation, for `demlaws.choose`. One of force, pressure and speed is required.

    Parameters
    ----------
    radii : float or sequence
        Radius of the grains [m], or the smallest and largest.
    materials, surfaces : Material, Surface, or sequences
        One for all grains, or one entry per kind of grain; a material as a surface is its surface.
    force : (float, float)
        Smallest and largest normal force of interest [N].
    pressure : (float, float)
        Smallest and largest mean stress of a packing [Pa], from which forces follow.
    speed : float
        Fastest approach [m/s]; the peak force of an impact extends the range.
    cyclic : bool
        Whether contacts unload and reload.
    quantity : str
        Quantity of interest, a key of `QUANTITIES`.
    tolerance : float
        Its largest error.
    engine : str
        One of `ENGINES`.
    walls : bool
        Whether grains touch flats of the same kind.
    yield_pressure : float
        p_y [Pa], if the bulk may yield.
    reference, reference_options : str, dict
        Reference law; default: the most complete law that the quantities determine.
    porosity, coordination : float
        Of the packing, for pressure and time step.
    classes : tuple
        Radii [m] of grains that come in a few sizes, such as particle types, in place of `radii`.
    rate : float
        Fastest strain rate [1/s] that may be advised (`demlaws.advice.modulus`).
    process : str
        Process of the packing, one of `PROCESSES`.
    unloading : str, Law or path
        Actual unloading of the contacts, for cyclic scenes.
    name : str
        Name of the scene.

    Raises
    ------
    DemlawsError
        For unknown or missing quantities.

    Examples
    --------
    >>> granite = dl.Material(young=60.6e9, poisson=0.25, hardness=6.266e9, density=2680)
    >>> scene = dl.Scene(radii=(0.01, 0.03), materials=granite, surfaces=dl.Surface(1.7e-6, 2.22), force=(1, 500), cyclic=True)
    >>> scene.unloads, scene.effective_radii()
    (True, (0.005, 0.015))
    """

    radii: float | Sequence[float] = ()
    materials: Material | Sequence[Material] = ()
    surfaces: Surface | Sequence[Surface] | None = None
    force: Sequence[float] | None = None
    pressure: tuple | None = None
    speed: float = 0.0
    cyclic: bool = False
    quantity: str = "force"
    tolerance: float = 0.05
    engine: str = "python"
    walls: bool = False
    yield_pressure: float | None = None
    reference: str | None = None
    reference_options: dict = field(default_factory=dict)
    porosity: float = 0.4
    coordination: float = 6.0
    classes: tuple = ()
    rate: float | None = None
    process: str = ""
    unloading: str | Law | None = None
    name: str = ""

    def __post_init__(self):
        for label in ("radii", "classes"):
            refuse_plain_radius(label, getattr(self, label))
        classes = tuple(np.unique(positive(self.classes, "classes", "m")).tolist())
        radii = classes or np.atleast_1d(positive(self.radii, "radii", "m")).tolist()
        if not radii:
            raise DemlawsError("radii is empty: give one radius in m, or the smallest and the largest")
        if len(radii) > 2 and not classes:
            sizes = ", ".join(f"{r:g}" for r in radii)
            raise DemlawsError(
                f"radii = {sizes} m: give the smallest and the largest of a range; "
                f"grains of these sizes alone are classes=[{sizes}]"
            )
        for label in ("cyclic", "walls"):
            if not isinstance(getattr(self, label), bool | np.bool_):
                raise DemlawsError(f"{label} = {getattr(self, label)!r}: give true or false, without quotes")
        materials = _all_of(self.materials, Material, "materials")
        given = materials if self.surfaces is None else self.surfaces
        several = given if isinstance(given, list | tuple) else [given]
        surfaces = _all_of([surface_of(one) if isinstance(one, Material) else one for one in several], Surface, "surfaces")
        if any(surface.edge_radius is not None for surface in surfaces):
            raise DemlawsError("edge_radius: the contacts of a scene are those of spheres; give the edges' radius as radii")
        kinds = max(len(materials), len(surfaces))
        if {len(materials), len(surfaces)} - {1, kinds} or not kinds:
            raise DemlawsError(f"{len(materials)} materials and {len(surfaces)} surfaces: give one, or one per kind of grain")
        checked = {
            "classes": classes,
            "radii": (min(radii), max(radii)),
            "materials": materials * (kinds // len(materials)),
            "surfaces": surfaces * (kinds // len(surfaces)),
            "speed": number(self.speed, "speed", "m/s", allow_low=True),
        }
        for label, unit in (("force", "N"), ("pressure", "Pa")):
            if getattr(self, label) is not None:
                checked[label] = _range(getattr(self, label), label, unit)
        if self.force is None and self.pressure is None and not checked["speed"]:
            raise DemlawsError("the scene has no load: give force=(low, high) in N, pressure in Pa, or speed in m/s")
        for label, unit, high in (
            ("tolerance", "", 1.0),
            ("porosity", "", 0.95),
            ("coordination", "", 20.0),
            ("rate", "1/s", math.inf),
            ("yield_pressure", "Pa", math.inf),
        ):
            if getattr(self, label) is not None or high < math.inf:
                checked[label] = number(getattr(self, label), label, unit, 0.0, high)
        for label, words in (("quantity", QUANTITIES), ("engine", ENGINES), ("process", ("", *PROCESSES))):
            if not isinstance(getattr(self, label), str) or getattr(self, label) not in words:
                raise DemlawsError(f"{label} = {getattr(self, label)!r}: choose one of {', '.join(filter(None, words))}")
        if not isinstance(self.reference_options, dict):
            raise DemlawsError(f"reference_options = {self.reference_options!r:.60}: give a table of options by name")
        if self.reference_options and self.reference is None:
            raise DemlawsError("reference_options without reference: name the law whose options they are")
        if self.reference is not None:
            checked["reference_options"] = find(self.reference).read_options(self.reference_options)
        if self.unloading is not None:
            checked["unloading"] = self._checked_unloading()
        vars(self).update(checked)  # of a frozen dataclass

    def _checked_unloading(self):
        """A rule's name, or the law or table of `unloading`."""
        if not isinstance(self.unloading, str | os.PathLike | Law):
            raise DemlawsError(f"unloading = {self.unloading!r:.60}: give a rule's name, a law, a table, or a table's path")
        named = check_unloading(self.unloading)
        if not self.unloads:
            rule = GIVEN if isinstance(named, Law) else named
            raise DemlawsError(f"unloading = {rule!r}: contacts unload where cyclic = true, or quantity = 'restitution'")
        return named

    @classmethod
    def load(cls, path: str | os.PathLike) -> "Scene":
        """A scene from a TOML file ("-": standard input); its keys are the fields, see `demlaws choose --template`."""
        return _from_toml(as_path(path))

    @property
    def unloads(self) -> bool:
        """Whether the scene includes unloading."""
        return self.cyclic or self.quantity == "restitution"

    def contacts(self, radius: float | np.ndarray) -> list[Contact]:
        """One Contact per pair of kinds of grain, all of effective radius `radius` [m] (a number or an array)."""
        kinds = list(zip(self.materials, self.surfaces, strict=True))
        pairs = []
        for (m1, s1), (m2, s2) in itertools.combinations_with_replacement(kinds, 2):
            surface, hardness = s1.combined(s2), softer_hardness((m1, s1), (m2, s2))
            pairs.append(Contact(radius, effective_modulus(m1, m2), surface.roughness, surface.fractal_dimension, hardness))
        return pairs

    def effective_radii(self) -> tuple:
        """Smallest and largest effective radius [m]."""
        return 0.5 * self.radii[0], self.radii[1] if self.walls else 0.5 * self.radii[1]

    def pair_radii(self) -> list[float]:
        """Every effective radius [m] that grains of `classes` can have."""
        pairs = [effective_radius(*both) for both in itertools.combinations_with_replacement(self.classes, 2)]
        return sorted({*pairs, *(self.classes if self.walls else ())})

    def kinds(self) -> list[tuple[int, int]]:
        """Pairs of numbers of kinds of grain, in the order of `contacts`."""
        return list(itertools.combinations_with_replacement(range(len(self.materials)), 2))

    def grains(self) -> list:
        """A LIGGGHTS `Grain` for each kind and size: `classes`, or the smallest and the largest."""
        from demlaws.plugins.grains import Grain

        sizes = self.classes or tuple(dict.fromkeys(self.radii))
        return [Grain(r, m, s) for m, s in zip(self.materials, self.surfaces, strict=True) for r in sizes]

    def mass(self, radius: float | np.ndarray) -> float | np.ndarray:
        """Mass [kg] of the lightest kind of grain whose contact with its like has effective radius `radius` [m]."""
        density = min(DENSITY if m.density is None else m.density for m in self.materials)
        return density * 4.0 / 3.0 * math.pi * (2.0 * np.asarray(radius)) ** 3

    def mean_force(self, pressure: float, radius: float | np.ndarray) -> float | np.ndarray:
        """Mean normal force [N] of a packing of grains of one size: p π d²/((1 - porosity) Z) (Rothenburg & Bathurst 1989)."""
        return math.pi * (4.0 * np.asarray(radius)) ** 2 * pressure / ((1.0 - self.porosity) * self.coordination)

    def force_range(self, contact: Contact) -> tuple:
        """Smallest and largest normal force [N] that matter, one entry per contact."""
        ranges = []
        one = np.ones(np.shape(contact.radius))
        if self.force is not None:
            ranges.append((self.force[0] * one, self.force[1] * one))
        if self.pressure is not None:  # forces of a packing: an exponential tail to about 6 means, few below 0.05
            low, high = (self.mean_force(p, contact.radius) for p in self.pressure)
            ranges.append((0.05 * low, 6.0 * high))
        if self.speed:
            # Hertz impact of two grains: (5/4 m v²)^(3/5) k^(2/5) with m the reduced mass
            mass = 0.5 * self.mass(contact.radius)
            peak = (1.25 * mass * self.speed**2) ** 0.6 * (4 / 3 * contact.modulus * np.sqrt(contact.radius)) ** 0.4
            ranges.append((1e-3 * peak if not ranges else peak, peak))
        return np.min([r[0] for r in ranges], axis=0), np.max([r[1] for r in ranges], axis=0)


def _all_of(value, kind, label):
    """One or several Materials or Surfaces, as a tuple."""
    several = value if isinstance(value, list | tuple) else (value,)
    for one in several:
        if not isinstance(one, kind):
            raise DemlawsError(f"{label} must be one demlaws.{kind.__name__}, or a list of them, got {one!r:.60}")
    return tuple(several)


def _range(value, label, unit):
    """Smallest and largest, of which the first is a hundredth of the second where only that is given."""
    ends = np.atleast_1d(positive(value, label, unit)).tolist()
    if len(ends) == 1:
        ends = [0.01 * ends[0], ends[0]]
    if len(ends) != 2 or ends[0] > ends[1]:
        raise DemlawsError(f"{label} = {value!r}: give the smallest and the largest in {unit}")
    return tuple(ends)


def _from_toml(path):
    try:
        import tomllib
    except ImportError:  # Python 3.10
        import tomli as tomllib
    values, content = {}, read_text(path, "scene ")
    try:
        text = tomllib.loads(content)
        for key, kind in (("material", Material), ("surface", Surface)):
            section = text.pop(key, None) or text.pop(f"{key}s", None)  # [material] or [[materials]]
            if section is not None:
                entries = section if isinstance(section, list) else [section]
                values[f"{key}s"] = [kind(**_known(entry, kind, f"[{key}]")) for entry in entries]
        unloading = text.get("unloading")
        if names_a_file(unloading):  # beside the scene's
            text["unloading"] = str(path.parent.absolute() / unloading)
        return Scene(**values, **_known(text, Scene, "a scene"))
    except (tomllib.TOMLDecodeError, RecursionError) as error:  # of tables that are nested too deeply
        raise DemlawsError(f"{path} is not a scene file (demlaws choose --template): {error}") from None
    except (TypeError, ValueError) as error:
        raise DemlawsError(f"{path}: {error}") from None


def _known(entries, kind, where):
    """The keys and values of a part of a scene file; DemlawsError for a key that is not a field of `kind`."""
    if not isinstance(entries, dict):
        raise DemlawsError(f"{where} must have lines key = value, got {entries!r:.60} (demlaws choose --template)")
    names = [field.name for field in fields(kind) if field.init]
    for name in entries:
        if name not in names:
            raise DemlawsError(f"{where} has no key {name!r:.60}{did_you_mean(name, names)} Its keys are {', '.join(names)}")
    return entries


def unloading_rule(scene, name, options):
    """Unloading rule of law `name` in this scene: the scene's own, else the most complete one that the law accepts."""
    if scene.unloading is not None:
        return scene.unloading
    rules, contact = find(name).unloading, scene.contacts(scene.effective_radii()[0])[0]
    for rule in rules[:0:-1] if scene.unloads else ():
        with contextlib.suppress(NotPassive):
            bind_law(name, contact, rule, **options)
            return rule
    return rules[0]


def stable_step(scene, bind):
    """Safe step [s] of a scene with the law that `bind` makes of a contact.

    The smallest `timestep` of a packing over contacts of the extreme sizes with each other and with walls, of every pair of
    kinds, each with the mass of its smaller grain.
    """
    sizes = [*itertools.combinations_with_replacement(dict.fromkeys(scene.radii), 2)]
    sizes += [(scene.radii[0], math.inf)] if scene.walls else []
    ratios = [shear_ratio(scene.materials[i], scene.materials[j]) for i, j in scene.kinds()]
    steps = []
    for small, large in sizes:
        for contact, ratio in zip(scene.contacts(effective_radius(small, large)), ratios, strict=True):
            force, mass = float(scene.force_range(contact)[1]), float(scene.mass(0.5 * small))
            step = timestep(bind(contact), mass, force, coordination=scene.coordination, shear_ratio=ratio)
            steps.append(step)
    return min(steps)


def samples(scene):
    """One Sample per pair of kinds of grain: a grid over radii and loads."""
    result = []
    # of sizes that come in classes each pair has a sample, so that each may have a table
    spans = [(r, r) for r in scene.pair_radii()] or [scene.effective_radii()]
    for pair, (low, high) in itertools.product(scene.contacts(spans[0][0]), spans):
        sizes = 1 if low == high else 7
        contact = pair.with_values(radius=np.repeat(np.geomspace(low, high, sizes), _POINTS // sizes))
        smallest, largest = scene.force_range(contact)
        share = np.tile(np.linspace(0.0, 1.0, _POINTS // sizes), sizes)
        result.append(Sample(contact, smallest * (largest / smallest) ** share))
    return result
