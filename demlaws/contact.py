"""Materials, surfaces and the contact of two bodies: the measured quantities that every law starts from."""

import math
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from demlaws.errors import DemlawsError, MissingQuantity, did_you_mean, warn
from demlaws.units import RANGES, as_float, as_given, as_typed, judge, number, outside, positive, refuse_plain_radius, typed

PER_CONTACT = ("radius", "modulus", "sigma")
"""Fields of a `Contact` that may have one entry per contact."""
_OPTIONAL = ("sigma", "roughness", "fractal_dimension", "hardness", "density", "edge_radius")
LOWEST_HARDNESS = 1e-6
"""Hardness or yield pressure over effective modulus below which one of them is in another unit: sodium's 1e-4 is the least."""
HIGHEST_HARDNESS = 10.0
"""Hardness over effective modulus above which a warning is issued. An elastic sphere's mean pressure is 4 E*/(3π), 0.42 E*,
where a = R; the hardest solids have about 0.3 E* (glass), and softening the modulus by s raises the ratio by s^(1/3)."""


def hardness_doubt(hardness: float | None, modulus: Any) -> str | None:
    """Text on a hardness [Pa] that no contact of this E* [Pa] reaches; None: nothing to say."""
    if hardness is None or not np.any(hardness > HIGHEST_HARDNESS * np.asarray(modulus)):
        return None
    return (
        f"hardness = {as_typed(hardness, 'Pa')} is {hardness / float(np.min(modulus)):.3g} times the effective modulus: no "
        "sphere reaches this pressure (0.42 E* where a = R), so that nothing deforms plastically; give the "
        "hardness of the softer body in Pa"
    )


def _check(owner: Any, *names: str, scalar: bool = True) -> None:
    """Turn fields into floats (or, where allowed, float arrays) and refuse what is not admissible; None stays."""
    for name in names:
        value = getattr(owner, name)
        if value is None and name in _OPTIONAL:
            continue
        array = as_float(value, name, RANGES[name].unit, array=not scalar)
        bad = np.flatnonzero(outside(name, array))
        if bad.size:
            where = f" (entry {bad[0]})" if array.ndim else ""
            text = judge(**{name: typed(array.flat[bad[0]], value, RANGES[name].unit)})[0].text
            raise DemlawsError(text.replace(":", f"{where}:", 1))
        object.__setattr__(owner, name, as_given(array))


def _refuse_lengths(values: dict) -> None:
    """Refuse arrays of several lengths."""
    try:
        np.broadcast_shapes(*map(np.shape, values.values()))
    except ValueError:
        sizes = {name: np.size(value) for name, value in values.items()}
        raise DemlawsError(f"one entry per contact is needed, got {sizes}; give arrays of one length") from None


def compliance(material: Any) -> float:
    """(1 - ν²)/E [1/Pa] of a material: an object with `young` and `poisson`, also YADE's."""
    return (1.0 - material.poisson**2) / material.young


def effective_modulus(material1: Any, material2: Any) -> float:
    """E* [Pa], 1/E* = (1-ν1²)/E1 + (1-ν2²)/E2."""
    return 1.0 / (compliance(material1) + compliance(material2))


def young_against_itself(modulus: float, poisson: float) -> float:
    """Young's modulus [Pa] of the material that against itself has this E* [Pa]."""
    return 2.0 * modulus * (1.0 - poisson**2)


def effective_radius(radius1: Any, radius2: Any) -> Any:
    """R [m] of two spheres, 1/R = 1/R1 + 1/R2; inf is a flat."""
    return 1.0 / (1.0 / radius1 + 1.0 / radius2)


def combined_roughness(roughness1: Any, roughness2: Any) -> Any:
    """σ = √(Sq1² + Sq2²) [m]; None where one of them is not given."""
    return None if roughness1 is None or roughness2 is None else np.hypot(roughness1, roughness2)


@dataclass(frozen=True)
class Material:
    """An elastic solid. Quantities are numbers in SI units, or strings with a unit ("60.6GPa").

    Parameters
    ----------
    young : float or str
        Young's modulus E [Pa].
    poisson : float
        Poisson's ratio ν, above -1 and at most 0.5.
    hardness : float or str, optional
        Indentation hardness H_m [Pa], required by laws with plastic asperities.
    density : float or str, optional
        Density [kg/m³], required where mass matters.
    surface : Surface, optional
        Usual surface of bodies of this material, taken where no other is given.

    Raises
    ------
    DemlawsError
        If a value is not admissible.

    Examples
    --------
    >>> granite = dl.Material(young="60.6GPa", poisson=0.25, hardness=6.266e9)
    >>> granite.young, round(granite.plane_modulus / 1e9, 2)
    (60600000000.0, 64.64)
    """

    young: float | Any  # any: text with a unit, which becomes a number
    poisson: float
    hardness: float | Any = None
    density: float | Any = None
    surface: "Surface | None" = None

    def __post_init__(self) -> None:
        _check(self, "young", "poisson", "hardness", "density")
        if not isinstance(self.surface, Surface | None):
            raise DemlawsError(f"surface must be a demlaws.Surface, got {self.surface!r:.60}")

    @property
    def plane_modulus(self) -> float:
        """E/(1 - ν²) [Pa]."""
        return 1.0 / compliance(self)


@dataclass(frozen=True)
class Surface:
    """A measured surface of one body. Quantities are numbers in SI units, or text with a unit ("2.4um").

    Parameters
    ----------
    roughness : float or str, optional
        Rms roughness Sq of this surface [m], required by laws of rough contacts; 0 is smooth.
    fractal_dimension : float, optional
        Fractal dimension Df, 2 to 3; Hurst exponent H = 3 - Df.
    hardness : float or str, optional
        Hardness of the surface [Pa], if it differs from that of the material.
    edge_radius : float or str, optional
        Radius of the edges of a grain [m], for polyhedra and level sets in YADE (page "Angular grains").

    Raises
    ------
    DemlawsError
        If a value is not admissible.

    Examples
    --------
    >>> rough, smooth = dl.Surface("3um", 2.2, 6e9), dl.Surface(4e-6, 2.4, 5e9)
    >>> joined = rough.combined(smooth)
    >>> round(joined.roughness * 1e6, 9), round(joined.fractal_dimension, 9), joined.hardness
    (5.0, 2.3, 5000000000.0)
    """

    roughness: float | Any = None
    fractal_dimension: float | None = None
    hardness: float | Any = None
    edge_radius: float | Any = None

    def __post_init__(self) -> None:
        _check(self, "roughness", "fractal_dimension", "hardness", "edge_radius")

    def combined(self, other: "Surface") -> "Surface":
        """The surface that, against a smooth flat, is equivalent to this one against `other`.

        σ = √(Sq1² + Sq2²) where both are given, Df is the mean of the two (our choice: the papers do not say), the hardness the
        lower one.

        Parameters
        ----------
        other : Surface
            The second body's surface.

        Returns
        -------
        Surface
        """
        if not isinstance(other, Surface):
            raise DemlawsError(f"a Surface is combined with another Surface, got {other!r:.60}")
        dimensions = [d for d in (self.fractal_dimension, other.fractal_dimension) if d is not None]
        hardnesses = [h for h in (self.hardness, other.hardness) if h is not None]
        return Surface(
            combined_roughness(self.roughness, other.roughness),
            sum(dimensions) / len(dimensions) if dimensions else None,
            min(hardnesses) if hardnesses else None,
        )


@dataclass(frozen=True)
class Contact:
    """One contact of two bodies, or an array of contacts that share a law, by its effective quantities.

    Parameters
    ----------
    radius : float, str or ndarray, shape (n,)
        Effective radius R [m], 1/R = 1/R1 + 1/R2: half the radius for two equal spheres.
    modulus : float, str or ndarray, shape (n,)
        Effective modulus E* [Pa], 1/E* = (1-ν1²)/E1 + (1-ν2²)/E2.
    sigma : float, str or ndarray, shape (n,), optional
        Combined roughness of the pair, σ = √(Sq1² + Sq2²) [m]; 0 is smooth.
    fractal_dimension : float, optional
        Fractal dimension Df, 2 to 3, of all contacts.
    hardness : float or str, optional
        Hardness H_m of the softer body [Pa], of all contacts.
    roughness : float, str or ndarray, optional
        Former name of `sigma`, taken with a FutureWarning.

    Raises
    ------
    DemlawsError
        If a value is not admissible, or if arrays differ in length.

    Examples
    --------
    >>> granite = dl.Material(young=60.6e9, poisson=0.25, hardness=6.266e9)
    >>> pair = dl.Contact.between(granite, granite, radius1=8.76e-3, radius2=8.63e-3, roughness1=1.56e-6, roughness2=1.84e-6)
    >>> print(f"R = {pair.radius * 1e3:.3f} mm, E* = {pair.modulus / 1e9:.2f} GPa, σ = {pair.sigma * 1e6:.3f} µm")
    R = 4.347 mm, E* = 32.32 GPa, σ = 2.412 µm
    >>> dl.Contact(radius=[1e-3, 2e-3], modulus=32e9).size
    2
    """

    radius: float | np.ndarray | Any  # any: lists, text with a unit
    modulus: float | np.ndarray | Any
    sigma: float | np.ndarray | Any = None
    fractal_dimension: float | None = None
    hardness: float | Any = None

    def __init__(
        self,
        radius: Any,
        modulus: Any,
        sigma: Any = None,
        fractal_dimension: float | None = None,
        hardness: Any = None,
        *,
        roughness: Any = None,
    ) -> None:
        if roughness is not None:
            sigma = _as_sigma(sigma, roughness)
        values = (radius, modulus, sigma, fractal_dimension, hardness)
        for field, value in zip(fields(self), values, strict=True):
            object.__setattr__(self, field.name, value)
        _check(self, "radius", "modulus", "sigma", scalar=False)
        _check(self, "fractal_dimension", "hardness")
        _refuse_lengths({name: getattr(self, name) for name in PER_CONTACT})
        if self.hardness is not None:
            pressure_of(self, hardness, "hardness")
        text = hardness_doubt(self.hardness and typed(self.hardness, hardness, "Pa"), self.modulus)
        if text is not None:
            warn(text)
        # the relatively roughest contact and the largest one
        radii, heights = (np.atleast_1d(v) for v in np.broadcast_arrays(self.radius, self.sigma_or_zero))
        for place in {int(np.argmax(heights / radii)), int(np.argmax(radii))} if radii.size else ():
            for finding in judge(radius=typed(radii[place], radius, "m"), sigma=typed(heights[place], sigma, "m")):
                if not finding.admissible:
                    raise DemlawsError(finding.text)
                warn(finding.text)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Contact):
            return NotImplemented
        return all(np.array_equal(getattr(self, field.name), getattr(other, field.name)) for field in fields(self))

    def __hash__(self) -> int:
        values = [getattr(self, field.name) for field in fields(self)]
        return hash(tuple(tuple(v.tolist()) if isinstance(v, np.ndarray) else v for v in values))

    @classmethod
    def between(
        cls,
        material1: Material,
        material2: Material,
        *,
        radius1: Any,
        radius2: Any = None,
        roughness1: Any = None,
        roughness2: Any = None,
        fractal_dimension: float | None = None,
        hardness: float | None = None,
    ) -> "Contact":
        """Contact of two bodies by their materials, radii and surfaces.

        Parameters
        ----------
        material1, material2 : Material
            Materials of both bodies.
        radius1, radius2 : float, str or ndarray
            Radii of both spheres [m], both required; "flat" or inf is a flat.
        roughness1, roughness2 : float, str or ndarray, optional
            Rms roughness Sq of each surface [m]; default: that of the material's `surface`. Where one of the two is not known,
            the contact has no sigma: a law that uses it raises an error.
        fractal_dimension : float, optional
            Fractal dimension Df, 2 to 3; default: the mean of the materials' surfaces.
        hardness : float or str, optional
            Hardness [Pa]; default: that of the softer material.

        Returns
        -------
        Contact
            With the effective quantities.

        Raises
        ------
        DemlawsError
            If a value is not admissible, or if both bodies are flats.
        """
        for name, material in (("material1", material1), ("material2", material2)):
            if not isinstance(material, Material):
                raise DemlawsError(f"{name} must be a demlaws.Material, got {material!r:.60}")
        first, second = surface_of(material1), surface_of(material2)
        roughness1 = first.roughness if roughness1 is None else roughness1
        roughness2 = second.roughness if roughness2 is None else roughness2
        radius = joined_radius(radius1, radius2)
        sigma = joined_roughness(roughness1, roughness2, radius)
        if fractal_dimension is None:
            fractal_dimension = first.combined(second).fractal_dimension
        if hardness is None:
            hardness = softer_hardness((material1, first), (material2, second))
        modulus = effective_modulus(material1, material2)
        return cls(radius, modulus, sigma, fractal_dimension, hardness)

    @property
    def size(self) -> int | None:
        """Number of contacts, or None for a single one."""
        shape = np.broadcast_shapes(np.shape(self.radius), np.shape(self.modulus), np.shape(self.sigma_or_zero))
        return shape[0] if shape else None

    @property
    def sigma_or_zero(self) -> float | np.ndarray:
        """σ [m] for laws of smooth contacts, whose curve does not depend on it: 0 if it is not given."""
        return 0.0 if self.sigma is None else self.sigma

    @property
    def roughness(self) -> float | np.ndarray | None:
        """Former name of `sigma`, with a FutureWarning."""
        warn_of_roughness()
        return self.sigma

    @property
    def is_smooth(self) -> bool | np.ndarray:
        """Whether σ is at most SMOOTHEST times the radius, or not given: no effect in double precision."""
        from demlaws.core.loops import SMOOTHEST

        smooth = np.asarray(self.sigma_or_zero) <= SMOOTHEST * np.asarray(self.radius)
        return bool(smooth) if smooth.ndim == 0 else smooth

    def representatives(self) -> list[int]:
        """Indices of the contacts used by checks: the relatively smoothest, the roughest and the middle one of an array."""
        if self.size is None:
            return [0]
        order = np.argsort(np.broadcast_to(self.sigma_or_zero, self.size) / self.radius)
        return sorted({int(order[0]), int(order[order.size // 2]), int(order[-1])})

    def with_values(self, **changes: Any) -> "Contact":
        """A copy with some fields changed.

        Parameters
        ----------
        **changes
            Fields of the contact and their new values.

        Returns
        -------
        Contact
        """
        if "roughness" in changes:
            changes["sigma"] = _as_sigma(changes.get("sigma"), changes.pop("roughness"))
        unknown = changes.keys() - {field.name for field in fields(self)}
        if unknown:
            names = ", ".join(field.name for field in fields(self))
            wrong = sorted(unknown)[0]
            raise DemlawsError(f"a contact has no {wrong!r}{did_you_mean(wrong, names.split(', '))} Its fields are {names}")
        return replace(self, **changes)

    def roughness_parameter(self, force: ArrayLike) -> float | np.ndarray:
        """Ratio of the roughness to the Hertz overlap, α = σ (16 R E*²/(9 P²))^(1/3) (Greenwood, Johnson & Matsubara 1984).

        Parameters
        ----------
        force : float or array_like
            Force P [N], positive.

        Returns
        -------
        float or ndarray
        """
        if self.sigma is None:
            raise MissingQuantity.of("the roughness parameter α", "sigma")
        return self.sigma / smooth_overlap(self, positive(force, "force", "N"))


def warn_of_roughness() -> None:
    """Say which quantity a contact's `roughness` is, at the line of the user who wrote it."""
    text = "the roughness of a contact is σ = √(Sq1² + Sq2²) of the pair, not Sq of one surface: write sigma; "
    warn(f"{text}the next release refuses roughness here", FutureWarning)


def _as_sigma(sigma: Any, roughness: Any) -> Any:
    """σ as given by its former name, with a FutureWarning; DemlawsError if both are given."""
    if sigma is not None:
        raise DemlawsError(
            f"sigma = {sigma!r:.60} and roughness = {roughness!r:.60} are the same quantity of a contact: give sigma"
        )
    warn_of_roughness()
    return roughness


def smooth_overlap(contact: Contact, force: Any) -> Any:
    """Overlap [m] of a smooth contact under `force` > 0 [N], (9 P²/(16 R E*²))^(1/3)."""
    return (0.75 * force / (contact.modulus * np.sqrt(contact.radius))) ** (2 / 3)


def pressure_of(contact: Contact, value: Any, name: str) -> float:
    """A hardness, yield pressure or strength [Pa] of the bodies of a contact; DemlawsError if the unit is wrong."""
    pressure = number(value, name, "Pa")
    if np.any(pressure < LOWEST_HARDNESS * np.asarray(contact.modulus)):
        share = pressure / float(np.max(contact.modulus))
        raise DemlawsError(
            f"{name} = {as_typed(value, 'Pa')} is {share:.1g} of the effective modulus: check the units (give Pa, or "
            '"6.3GPa"; a Vickers number in kgf/mm² times 9.807e6)',
        )
    return pressure


def surface_of(material: Material) -> Surface:
    """The material's surface, or an empty Surface."""
    return material.surface or Surface()


def softer_hardness(*bodies: tuple[Material, Surface]) -> float | None:
    """Hardness [Pa] of the softer of two bodies: its surface's, else its material's; None where none is known."""
    hardnesses = (surface.hardness or material.hardness for material, surface in bodies)
    return min((hardness for hardness in hardnesses if hardness is not None), default=None)


def replace_unchecked(contact: Contact, changes: dict[str, float]) -> Contact:
    """A copy with fields that are known to be admissible numbers, for the many trials of a search; `with_values` checks."""
    copy = object.__new__(Contact)
    for name, value in vars(contact).items():
        object.__setattr__(copy, name, changes.get(name, value))
    return copy


def joined_radius(radius1: Any, radius2: Any, names: tuple[str, str] = ("radius1", "radius2")) -> Any:
    """R [m] of two bodies by their radii, of which a flat's is "flat" or inf; DemlawsError for inadmissible ones."""
    radii = [_radius_of_body(name, radius) for name, radius in zip(names, (radius1, radius2), strict=True)]
    _refuse_lengths(dict(zip(names, radii, strict=True)))
    if np.any(np.isinf(radii[0]) & np.isinf(radii[1])):
        raise DemlawsError(
            f"{' and '.join(dict.fromkeys(names))} = flat: two flats have no Hertz contact; give one a radius in m"
        )
    return effective_radius(*radii)


def _radius_of_body(name: str, radius: Any) -> Any:
    """Radius [m] of one body; a plain number above 1 m is refused."""
    if radius is None:
        raise DemlawsError(
            f'{name} is missing: give the radius of each body; for a sphere on a flat radius2="flat", for two equal spheres '
            "the same radius twice"
        )
    if isinstance(radius, str) and radius.strip() == "flat":
        return math.inf
    refuse_plain_radius(name, radius)
    value = as_float(radius, name, "m", array=True)
    for wrong in value[~(value > 0.0)][:1]:
        raise DemlawsError(f"{name} = {as_typed(typed(wrong, radius, 'm'), 'm')}: a radius must be positive (inf for a flat)")
    return value


def joined_roughness(
    roughness1: Any, roughness2: Any, radius: Any, names: tuple[str, str] = ("roughness1", "roughness2")
) -> Any:
    """σ [m] of two surfaces by their Sq, for a contact of effective radius `radius` [m]; None where one is not given.

    DemlawsError for a roughness that is negative, or too large for the radius.
    """
    pairs = zip(names, (roughness1, roughness2), strict=True)
    given = [(name, value, as_float(value, name, "m", array=True)) for name, value in pairs if value is not None]
    _refuse_lengths({"radius": radius, **{name: heights for name, _, heights in given}})
    for name, value, heights in given:
        sq, radii = np.broadcast_arrays(np.atleast_1d(heights), radius)
        for place in {int(np.argmin(sq)), int(np.argmax(sq / radii))} if sq.size else ():
            for finding in judge(roughness=typed(sq[place], value, "m"), radius=float(radii[place])):
                if not finding.admissible:
                    raise DemlawsError(finding.text.replace(finding.quantity, name, 1))
    return combined_roughness(*(heights for *_, heights in given)) if len(given) == 2 else None


def as_contact(value: Any) -> Contact:
    """The value, or a DemlawsError if it is not a `Contact`."""
    if not isinstance(value, Contact):
        raise DemlawsError(f"contact must be a demlaws.Contact, got {value!r:.60}")
    return value


def contact_at(contact: Contact, index: int) -> Contact:
    """The contact at this place in an array; a single one is at every place."""
    given = {name: value for name in PER_CONTACT if (value := getattr(contact, name)) is not None}
    values = {name: np.broadcast_to(value, contact.size or index + 1)[index] for name, value in given.items()}
    return replace(contact, **values)


DENSITY = 2680.0
"""Density [kg/m³] of granite, and of a material that states none."""
GRANITE = Material(young=60.6e9, poisson=0.25, hardness=639 * 9.80665e6, density=DENSITY)
"""Mount Sorrel granite: Table 1 of Altuhafi, Baudet & Coop 2023 (639 kgf/mm², 6.266 GPa)."""
GRANITE_YIELD_PRESSURE = 1.66e9
"""p_y [Pa] of the rough-plastic law for its spheres and the cone RFC10: 0.265 of the hardness."""
