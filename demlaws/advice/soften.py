"""Softer grains for longer steps, without a change of the law's branch: a stretch of overlaps at equal force.

Divide moduli by s and scale with them what a law compares overlaps, pressures and slopes with: σ grows by s^(2/3), H_m and p_y
fall by s^(-2/3), slopes grow by s^(1/3). That is one affine map of the surfaces: normal lengths × s^(2/3), lateral lengths
× s^(1/3), radii of curvature, densities and forces as they are. So P_new(δ) = P_old(δ/s^(2/3)) for every law and unloading
rule [our derivation]. With σ left as it is a contact slides to another branch instead.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np

from demlaws.contact import Contact, Material, Surface
from demlaws.errors import DemlawsError
from demlaws.law import Law, Table
from demlaws.laws.definition import PRESSURE, Option, power_of
from demlaws.laws.registry import find, registry
from demlaws.make import law as bind_law
from demlaws.units import number

EXPONENTS = {
    Material: {"young": -1.0, "poisson": 0.0, "hardness": PRESSURE, "density": 0.0},
    Surface: {"roughness": 2 / 3, "fractal_dimension": 0.0, "hardness": PRESSURE, "edge_radius": 0.0},
    Contact: {"radius": 0.0, "modulus": -1.0, "sigma": 2 / 3, "fractal_dimension": 0.0, "hardness": PRESSURE},
}
"""Exponent of the factor by which each measured quantity grows."""
_Thing = TypeVar("_Thing")


def soften(thing: _Thing, factor: float) -> _Thing:
    """Rescale contacts to a lower modulus on the same branch of their law.

    Parameters
    ----------
    thing : Contact, Material, Surface, Law, Table, Scene, Grain, Case, or a collection of these
        Rescaled with its options and its unloading curve.
    factor : float
        s, the divisor of the modulus; a value below 1 makes contacts stiffer.

    Returns
    -------
    same type as thing
        The softened object.

    Raises
    ------
    DemlawsError
        For objects that cannot be rescaled, with the reason.

    Notes
    -----
    P_new(δ) = P_old(δ/s^(2/3)): forces, the branch of the law, and the plastic share of the overlap are kept.
    Overlaps and energies grow by s^(2/3), stiffness falls by s^(-2/3), and the stable step grows by s^(1/3). Geometry is not
    kept, since overlap over diameter grows by s^(2/3).

    Examples
    --------
    >>> pair = dl.Contact(radius=4e-3, modulus=32e9, sigma=2e-6, fractal_dimension=2.2)
    >>> law = dl.law("pohrt-popov", pair)
    >>> softer = dl.soften(law, 8)
    >>> softer.contact.modulus, round(softer.contact.sigma * 1e6, 9), round(softer.overlap(10.0) / law.overlap(10.0), 6)
    (4000000000.0, 8.0, 4.0)
    """
    return Softening(factor).of(thing)


@dataclass(frozen=True)
class Softening:
    """Scale factors of all quantities for contacts softened by `factor` s."""

    factor: float

    def __post_init__(self):
        object.__setattr__(self, "factor", number(self.factor, "factor (by which moduli are divided)", ""))

    @property
    def overlap(self) -> float:
        """Factor of overlaps (also plastic ones), roughness, and energies: s^(2/3)."""
        return power_of(self.factor, 2 / 3)

    @property
    def stiffness(self) -> float:
        """Factor of the stiffness: s^(-2/3)."""
        return power_of(self.factor, -2 / 3)

    @property
    def step(self) -> float:
        """Factor of the stable time step, slopes, and speeds of equivalent impacts: s^(1/3)."""
        return power_of(self.factor, 1 / 3)

    def of(self, thing: Any) -> Any:
        """See `soften`."""
        from demlaws.advice.scene import Scene
        from demlaws.plugins.grains import Case, Grain

        kind = next((k for k in EXPONENTS if isinstance(thing, k)), None)
        if kind is not None:
            return self._scaled(thing, EXPONENTS[kind])
        if isinstance(thing, Law):
            return self._law(thing)
        if isinstance(thing, Grain):
            return replace(thing, material=self.of(thing.material), surface=self.of(thing.surface))
        if isinstance(thing, Case):
            unloading = self.of(thing.unloading) if isinstance(thing.unloading, Law) else thing.unloading
            return replace(
                thing, grains=self.of(thing.grains), unloading=unloading, options=self.options(thing.law, thing.options)
            )
        if isinstance(thing, Scene):
            return self._scene(thing)
        if isinstance(thing, Mapping):
            return {name: self.of(value) for name, value in thing.items()}
        if isinstance(thing, list | tuple):
            return type(thing)(self.of(value) for value in thing)
        raise DemlawsError(
            f"nothing to soften in {thing!r:.60}: give a Contact, Material, Surface, Law, Table, Scene, Grain or Case, "
            "or a list or dict of them"
        )

    def options(self, law: str, options: Mapping) -> dict:
        """Options of law `law` for the softened contacts; those of the law before yield among them."""
        definition = find(law)
        if definition.advice.rigid and self.factor != 1.0:
            raise DemlawsError(f"law {law!r} cannot be softened: {definition.advice.rigid}")
        options = definition.read_options(options)
        before, rest = definition.before_yield(**options)
        inner = {} if before is None else self.options(before.name, rest)
        records = definition.options
        outer = {n: softened_option(law, n, records[n], v, self.factor) for n, v in options.items() if n in records}
        unknown = {n: v for n, v in options.items() if n not in records and n not in inner}  # the law itself refuses them
        return {**unknown, **inner, **outer}

    def _scaled(self, thing, exponents):
        changes = {}
        for name, exponent in exponents.items():
            value = getattr(thing, name)
            if exponent and value is not None:
                changes[name] = value * power_of(self.factor, exponent)
        if isinstance(thing, Contact) and np.any(changes.get("sigma", 0.0) > np.asarray(thing.radius)):
            raise DemlawsError(
                f"factor = {self.factor:g} makes sigma {float(np.max(changes['sigma'])):g} m, more than the "
                f"effective radius of {float(np.min(thing.radius)):g} m: use a smaller factor"
            )
        if isinstance(thing, Material) and isinstance(thing.surface, Surface):
            changes["surface"] = self.of(thing.surface)
        return replace(thing, **changes)

    def _law(self, law):
        if law.name not in registry():
            raise DemlawsError(
                f"{law.name!r} is a table of a function, of points or of an unknown law, which cannot be rescaled: make "
                "another table, with overlaps times s^(2/3) at the same forces"
            )
        contact, along = self.of(law.contact), law.unloading_law
        if isinstance(law, Table) and law.curve.shape.length_over_roughness:
            # rows in multiples of σ, which is stretched as overlaps are: they stay as they are
            unloading = law.unloading_parts
            if unloading.curve is not None:
                unloading = unloading._replace(curve=self._curve(unloading.curve), contact=self.of(unloading.contact))
            return Table(contact, self._curve(law.curve), unloading)
        plain = bind_law(law.name, contact, "elastic", **self.options(law.name, law.options))
        if isinstance(law, Table):
            plain = plain.tabulate(law.rtol)
        return plain.joined(law.unloading if along is None else self.of(along))

    def _curve(self, curve):
        """The table of a curve whose rows stay as they are."""
        return replace(curve, options=self.options(curve.definition.name, curve.options), made_for=self.of(curve.made_for))

    def _scene(self, scene):
        pressure = scene.yield_pressure
        options = scene.reference_options
        return replace(
            scene,
            materials=self.of(scene.materials),
            surfaces=self.of(scene.surfaces),
            yield_pressure=None if pressure is None else pressure * power_of(self.factor, PRESSURE),
            reference_options=self.options(scene.reference, options) if scene.reference else options,
            unloading=self.of(scene.unloading) if isinstance(scene.unloading, Law) else scene.unloading,
        )

    # --- in words

    def effects(self) -> list[tuple[str, str, str]]:
        """(quantity, factor, power of s) of all quantities, also of those that are kept."""
        s, overlap, step = self.factor, self.overlap, self.step
        return [
            (
                "kept at equal force",
                "1",
                "branch, α, plastic share of overlap and work, radius, density, friction, Poisson's ratio, Df",
            ),
            ("Young's modulus E, effective modulus E*", f"{1 / s:.4g}", "s^-1"),
            ("roughness Sq and σ", f"{overlap:.4g}", "s^(2/3)"),
            ("hardness H_m, yield pressure p_y", f"{self.stiffness:.4g}", "s^(-2/3)"),
            ("slope tan β", f"{step:.4g}", "s^(1/3)"),
            ("overlap, plastic and tangential ones too; energy", f"{overlap:.4g}", "s^(2/3)"),
            ("stiffness", f"{self.stiffness:.4g}", "s^(-2/3)"),
            ("stable time step", f"{step:.4g}", "s^(1/3)"),
            ("speed of an impact with equal forces and restitution", f"{step:.4g}", "s^(1/3)"),
            ("geometric error, of the order of overlap over diameter", f"{overlap:.4g}", "s^(2/3)"),
        ]


def softened_option(law: str, name: str, option: Option, value: Any, factor: float) -> Any:
    """Value of a law's option where contacts are made softer by `factor` s (`demlaws.soften`).

    `Option.softens` is the exponent of s, or a function (value, s) → value. Without it a number without unit and a force
    stay as they are; anything else is refused, since a wrong guess would be silent.
    """
    if callable(option.softens):
        return option.softens(value, factor)
    exponent = option.softens
    if exponent is None:
        if option.unit not in ("", "N"):
            raise DemlawsError(
                f"law {law!r} cannot be softened: no scaling is defined for its option {name} [{option.unit}] "
                "(Option.softens in the law's file)"
            )
        exponent = 0.0
    if exponent == 0.0 or value is None:
        return value
    return number(value, name, option.unit) * power_of(factor, exponent)
