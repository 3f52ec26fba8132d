"""Materials, surfaces and the contact of two bodies: the measured quantities that every law starts from."""

import math
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from demlaws.errors import DemlawsError
from demlaws.units import real

LOWEST_HARDNESS = 1e-6
"""Hardness over effective modulus below which one of them is in another unit: 1e-4 of sodium is the softest solid's."""


def _check(
    owner: Any,
    name: str,
    unit: str,
    remedy: str,
    *,
    low: float = 0.0,
    high: float = math.inf,
    allow_low: bool = False,
    scalar: bool = True,
    needed: bool = True,
) -> None:
    """Turn a field into a float (or, where allowed, a float array) and refuse what is out of range."""
    value = getattr(owner, name)
    if value is None and not needed:
        return
    array = real(value, name, unit, array=not scalar)
    bad = ~((array >= low) if allow_low else (array > low)) | (array > high) | ~np.isfinite(array)
    if np.any(bad):
        first = array if array.ndim == 0 else array[np.argmax(bad)]
        where = "" if array.ndim == 0 else f" (entry {int(np.argmax(bad))})"
        raise DemlawsError(f"{name} = {float(first):g} {unit}".rstrip() + f"{where}: {remedy}")
    object.__setattr__(owner, name, float(array) if array.ndim == 0 else array)


@dataclass(frozen=True)
class Material:
    """An elastic solid. Each quantity a number in SI units, or text with a unit: "60.6GPa".

    young: Young's modulus E [Pa]; poisson: ν, above -1 and up to 0.5; hardness: indentation hardness H_m [Pa], needed
    by laws with plastic asperities; density [kg/m³], needed where mass matters.

    >>> granite = dl.Material(young="60.6GPa", poisson=0.25, hardness=6.266e9)
    >>> granite.young, round(granite.plane_modulus / 1e9, 2)
    (60600000000.0, 64.64)
    """

    young: float
    poisson: float
    hardness: float | None = None
    density: float | None = None

    def __post_init__(self) -> None:
        _check(self, "young", "Pa", "Young's modulus must be positive")
        _check(self, "poisson", "", "Poisson's ratio must be above -1 and at most 0.5", low=-1.0, high=0.5)
        _check(self, "hardness", "Pa", "hardness must be positive (a Vickers number in kgf/mm² times 9.807e6)", needed=False)
        _check(self, "density", "kg/m³", "density must be positive", needed=False)

    @property
    def plane_modulus(self) -> float:
        """E/(1 - ν²) [Pa]."""
        return self.young / (1.0 - self.poisson**2)


@dataclass(frozen=True)
class Surface:
    """A measured surface: rms roughness Sq [m] (0: smooth), fractal dimension in [2, 3], hardness [Pa]; or text: "2.4um".

    >>> rough, smooth = dl.Surface("3um", 2.2, 6e9), dl.Surface(4e-6, 2.4, 5e9)
    >>> joined = rough.combined(smooth)
    >>> round(joined.roughness * 1e6, 9), round(joined.fractal_dimension, 9), joined.hardness
    (5.0, 2.3, 5000000000.0)
    """

    roughness: float = 0.0
    fractal_dimension: float | None = None
    hardness: float | None = None

    def __post_init__(self) -> None:
        _check(self, "roughness", "m", "rms roughness Sq cannot be negative", allow_low=True)
        _check_dimension(self)
        _check(self, "hardness", "Pa", "hardness must be positive", needed=False)

    def combined(self, other: "Surface") -> "Surface":
        """The surface that, against a smooth flat, stands for this one against `other`.

        σ = √(Sq1² + Sq2²); Df is the mean of the two (our choice: the papers do not say), the hardness the lower one.
        """
        if not isinstance(other, Surface):
            raise DemlawsError(f"a Surface is combined with another Surface, got {other!r:.60}")
        dimensions = [d for d in (self.fractal_dimension, other.fractal_dimension) if d is not None]
        hardnesses = [h for h in (self.hardness, other.hardness) if h is not None]
        return Surface(
            math.hypot(self.roughness, other.roughness),
            sum(dimensions) / len(dimensions) if dimensions else None,
            min(hardnesses) if hardnesses else None,
        )


def _check_dimension(owner: Any) -> None:
    remedy = "the fractal dimension of a surface lies in [2, 3] (Hurst exponent H = 3 - Df)"
    _check(owner, "fractal_dimension", "", remedy, low=2.0, high=3.0, allow_low=True, needed=False)


@dataclass(frozen=True)
class Contact:
    """One contact, or an array of contacts that share a law.

    radius: effective radius R [m], 1/R = 1/R1 + 1/R2; modulus: effective modulus E* [Pa],
    1/E* = (1-ν1²)/E1 + (1-ν2²)/E2; roughness: combined rms roughness σ = √(Sq1² + Sq2²) [m]; each a number, text with a unit
    ("4.35mm") or a 1-D array with one entry a contact. fractal_dimension Df in [2, 3] and hardness H_m [Pa] are shared by
    all of them.

    >>> granite = dl.Material(young=60.6e9, poisson=0.25, hardness=6.266e9)
    >>> pair = dl.Contact.between(granite, granite, radius1=8.76e-3, radius2=8.63e-3, roughness1=1.56e-6, roughness2=1.84e-6)
    >>> print(f"R = {pair.radius * 1e3:.3f} mm, E* = {pair.modulus / 1e9:.2f} GPa, σ = {pair.roughness * 1e6:.3f} µm")
    R = 4.347 mm, E* = 32.32 GPa, σ = 2.412 µm
    >>> dl.Contact(radius=[1e-3, 2e-3], modulus=32e9).size
    2
    """

    radius: float | np.ndarray
    modulus: float | np.ndarray
    roughness: float | np.ndarray = 0.0
    fractal_dimension: float | None = None
    hardness: float | None = None

    def __post_init__(self) -> None:
        _check(self, "radius", "m", "the effective radius must be positive (two flats have no Hertz contact)", scalar=False)
        _check(self, "modulus", "Pa", "the effective modulus E* must be positive", scalar=False)
        remedy = "rms roughness cannot be negative"
        _check(self, "roughness", "m", remedy, allow_low=True, scalar=False)
        _check_dimension(self)
        _check(self, "hardness", "Pa", "hardness must be positive", needed=False)
        try:
            np.broadcast_shapes(*(np.shape(getattr(self, name)) for name in ("radius", "modulus", "roughness")))
        except ValueError:
            sizes = {name: np.size(getattr(self, name)) for name in ("radius", "modulus", "roughness")}
            raise DemlawsError(f"one entry a contact is needed, got {sizes}; give arrays of one length") from None
        if self.hardness is not None and np.any(self.hardness < LOWEST_HARDNESS * np.asarray(self.modulus)):
            share = self.hardness / float(np.max(self.modulus))
            raise DemlawsError(
                f"hardness = {self.hardness:g} Pa is {share:.1g} of the effective modulus: check the units (give Pa, or "
                '"6.3GPa"; a Vickers number in kgf/mm² times 9.807e6)'
            )
        rougher = np.asarray(self.roughness > np.asarray(self.radius))
        if np.any(rougher):
            worst = float(np.broadcast_to(self.roughness, rougher.shape)[rougher].max() if rougher.ndim else self.roughness)
            raise DemlawsError(f"roughness = {worst:g} m exceeds the effective radius: check the units (σ is usually µm, R mm)")

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Contact):
            return NotImplemented
        return all(np.array_equal(getattr(self, field.name), getattr(other, field.name)) for field in fields(self))

    @classmethod
    def between(
        cls,
        material1: Material,
        material2: Material,
        *,
        radius1: float | np.ndarray,
        radius2: float | np.ndarray = math.inf,
        roughness1: float | np.ndarray = 0.0,
        roughness2: float | np.ndarray = 0.0,
        fractal_dimension: float | None = None,
        hardness: float | None = None,
    ) -> "Contact":
        """Contact of two spheres of `radius1` and `radius2` [m] (inf: a flat).

        The hardness is the softer material's unless it is given. Radii and roughnesses may be arrays.
        """
        for name, material in (("material1", material1), ("material2", material2)):
            if not isinstance(material, Material):
                raise DemlawsError(f"{name} must be a demlaws.Material, got {material!r:.60}")
        given = {"radius1": radius1, "radius2": radius2, "roughness1": roughness1, "roughness2": roughness2}
        values = {name: real(value, name, "m", array=True) for name, value in given.items()}
        for name, value in values.items():
            if name.startswith("radius") and not np.all(value > 0):
                raise DemlawsError(f"{name} = {value} m: a radius must be positive (inf for a flat)")
            if not np.all(value >= 0):
                raise DemlawsError(f"{name} = {value} m: rms roughness Sq cannot be negative")
        try:
            np.broadcast_shapes(*(value.shape for value in values.values()))
        except ValueError:
            sizes = {name: value.size for name, value in values.items()}
            raise DemlawsError(f"one entry a contact is needed, got {sizes}; give arrays of one length") from None
        radius1, radius2, roughness1, roughness2 = values.values()
        if np.any(np.isinf(radius1) & np.isinf(radius2)):
            raise DemlawsError("radius1 and radius2 are both inf: two flats have no Hertz contact; give one a radius in m")
        hardnesses = [m.hardness for m in (material1, material2) if m.hardness is not None]
        if hardness is None and hardnesses:
            hardness = min(hardnesses)
        return cls(
            radius=1.0 / (1.0 / radius1 + 1.0 / radius2),
            modulus=1.0 / (1.0 / material1.plane_modulus + 1.0 / material2.plane_modulus),
            roughness=np.hypot(roughness1, roughness2),
            fractal_dimension=fractal_dimension,
            hardness=hardness,
        )

    @property
    def size(self) -> int | None:
        """Number of contacts, or None for a single one."""
        shape = np.broadcast_shapes(np.shape(self.radius), np.shape(self.modulus), np.shape(self.roughness))
        return shape[0] if shape else None

    @property
    def is_smooth(self) -> bool | np.ndarray:
        """Whether the roughness is at most SMOOTHEST times the radius: no effect in double precision; one entry per contact."""
        from demlaws.core.params import SMOOTHEST

        smooth = np.asarray(self.roughness) <= SMOOTHEST * np.asarray(self.radius)
        return bool(smooth) if smooth.ndim == 0 else smooth

    def representatives(self) -> list[int]:
        """Places of the contacts that checks look at: the relatively smoothest, the roughest and the middle of an array."""
        if self.size is None:
            return [0]
        order = np.argsort(np.broadcast_to(self.roughness, self.size) / self.radius)
        return sorted({int(order[0]), int(order[order.size // 2]), int(order[-1])})

    def with_values(self, **changes: Any) -> "Contact":
        """A copy with some fields changed."""
        unknown = changes.keys() - {field.name for field in fields(self)}
        if unknown:
            known = ", ".join(field.name for field in fields(self))
            raise DemlawsError(f"a contact has no {', '.join(sorted(unknown))}: its fields are {known}")
        return replace(self, **changes)

    def as_dict(self) -> dict:
        """Plain numbers and lists, for files."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        return {name: value.tolist() if isinstance(value, np.ndarray) else value for name, value in values.items()}

    def roughness_parameter(self, force: ArrayLike) -> float | np.ndarray:
        """α = σ (16 R E*²/(9 P²))^(1/3): roughness over Hertz overlap at `force` [N] (Greenwood, Johnson & Matsubara 1984)."""
        return self.roughness * (16.0 * self.radius * self.modulus**2 / (9.0 * real(force, "force", "N", array=True) ** 2)) ** (
            1 / 3
        )


def as_contact(value: Any) -> Contact:
    """The value, or a DemlawsError where it is not a `Contact`."""
    if not isinstance(value, Contact):
        raise DemlawsError(f"contact must be a demlaws.Contact, got {value!r:.60}")
    return value
