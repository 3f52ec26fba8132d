"""Tables: a dimensionless curve on a bit-indexed semi-logarithmic grid, with measured errors.

`core.curve` describes the grid and reads it; `curves.table_file` reads and writes the files of tables.
"""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from demlaws.contact import Contact, as_contact, contact_at
from demlaws.core.dispatch import scale
from demlaws.core.grid import Nodes, with_reverse
from demlaws.core.loops import clamped_roughness
from demlaws.core.table_types import BulkYield, TableShape
from demlaws.core.unloading import Rule
from demlaws.curves.closed import Certificate
from demlaws.errors import DemlawsError, MissingQuantity
from demlaws.laws.definition import Definition

if TYPE_CHECKING:
    from demlaws.curves.points import Knots


def plain_params(shape: Any, contact: Contact) -> Any:
    """Params of one contact as Python computes them: each sum and product rounded by itself, on every processor alike."""
    with np.errstate(all="ignore"):
        return scale(
            shape, float(contact.radius), float(contact.modulus), clamped_roughness(contact.sigma_or_zero, contact.radius)
        )


@dataclass(frozen=True, eq=False)
class TableCurve:
    """A curve of first loading that is read from rows."""

    definition: Definition
    options: dict
    shape: TableShape
    nodes: Nodes
    certificate: Certificate
    rtol: float
    made_for: Contact
    collapses: bool  # whether one dimensionless curve serves all contacts
    knots: "Knots | None" = None  # of a table made of points
    area_known: bool = True  # whether a²/R of the law is δ_H, or described by `shape.bulk`

    tabulated = True

    @property
    def bits(self) -> int:
        """2^bits cells of an octave."""
        return 52 - self.shape.grid.shift

    @property
    def starts_from_force(self) -> bool:
        """Whether the force at overlap 0+ is not 0: the curve is straight below the first row."""
        return self.shape.grid.seat > 0.0

    def kinks(self, p: Any) -> list[float]:
        """Overlaps [m] at which the stiffness of one contact's curve jumps or has a kink."""
        return list(self.nodes.kinks * p.length)

    def end(self, params: Any) -> float | np.ndarray:
        """Overlap [m] at which the curve ends, one per contact."""
        return self.shape.grid.highest * np.asarray(params.length)

    def largest_force(self, params: Any) -> float:
        """Force [N] at the end of the curve, the smallest of all contacts'."""
        scale = 0.75 * np.min(params.hertz_coefficient * np.asarray(params.length) ** 1.5)
        return float(scale * self.nodes.force[-1])

    def bulk(self, p: Any, hertz_coefficient: float, length: float, highest: float) -> BulkYield:
        """`BulkYield`, in units of the table's length."""
        return self.shape.bulk

    def unloading_shape(self) -> Any:
        """The Shape with which this table serves as an unloading curve."""
        return with_reverse(self.shape, self.nodes.kinks)

    def bound_to(self, contact: Contact, surface_matters: bool = True) -> Contact:
        """The contact, with what this curve was made for, to which the same curve applies; DemlawsError where it does not."""
        as_contact(contact)
        if not self.collapses:
            raise DemlawsError(
                f"the table of {self.definition.name!r} holds for the contact it was made for only: make one for this contact"
            )
        if self.shape.length_over_roughness and contact.sigma is None:
            raise MissingQuantity.of(f"the table of {self.definition.name!r}", "sigma")
        if self.shape.length_over_roughness and np.any(np.asarray(contact.sigma) == 0.0):
            raise DemlawsError("sigma = 0 m: this table scales with sigma; use law 'hertz' for a smooth contact")
        for name in ("fractal_dimension", "hardness"):  # what the curve's form depends on
            made_for, value = getattr(self.made_for, name), getattr(contact, name)
            if not surface_matters:
                contact = contact.with_values(**{name: made_for})
                continue
            if made_for is None or name not in self.definition.needed(**self.options):
                continue
            if value is not None and not math.isclose(value, made_for, rel_tol=1e-6):
                raise DemlawsError(f"the table is for {name} = {made_for:g}, the contact has {value:g}: make one for that")
            contact = contact.with_values(**{name: made_for})
        return contact

    # --- unloading

    def numbers_beside(self, rule: Rule, numbers: Any) -> Any:
        """The Shape that a rule of the law's own reads beside the table."""
        values = (float(numbers[key]) for key in rule.keys)
        return rule.shape(*values, self.shape.length_over_roughness, self.shape.length_over_radius)  # type: ignore[misc]

    def rule_parameters(self, contact: Contact, rule: Rule) -> Any:
        """The numbers that a rule of the law's own reads beside this table."""
        shape = self.definition.shape(contact, **self.options)
        if rule.shape is None:
            return shape  # the law itself
        one = contact_at(contact, 0)
        length, params = plain_params(self.shape, one).length, plain_params(shape, one)
        numbers: Any = self.definition.rules.numbers
        return self.numbers_beside(rule, numbers(params, length, sum(self.certificate)))

    @property
    def floor(self) -> float | None:
        """s where the power law of this curve ends below: an unloading curve's ends there, too, and stays the stiffer one."""
        return None if self.starts_from_force else float(self.shape.grid.cells[0, 1])
