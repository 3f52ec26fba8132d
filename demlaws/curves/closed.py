"""A curve of first loading that a law's compiled kernels compute."""

import math
from typing import Any, NamedTuple

import numpy as np

from demlaws.contact import Contact
from demlaws.core.table_types import NO_YIELD, BulkYield, TableShape
from demlaws.laws.definition import Definition
from demlaws.laws.registry import is_user_defined


class Certificate(NamedTuple):
    """Largest relative errors of a curve: of a table those measured between its nodes against the law itself."""

    force_error: float
    stiffness_error: float


class FormulaCurve:
    """A definition with its options, and the Shape that it prepares for a contact, on which a user's law must be admissible."""

    tabulated = False
    certificate = Certificate(0.0, 0.0)
    starts_from_force = False

    def __init__(self, definition: Definition, contact: Contact, options: dict):
        self.definition = definition
        self.shape = definition.shape(contact, **options)
        self.options = definition.read_options(options)
        self.collapses = definition.collapses  # one dimensionless curve serves all contacts
        if is_user_defined(definition) and not isinstance(self.shape, TableShape):
            from demlaws.curves.soundness import refuse_unsound

            refuse_unsound(definition, self.shape, contact, self.options)

    def kinks(self, p: Any) -> list[float]:
        """Overlaps [m] at which the stiffness of one contact's curve jumps or has a kink."""
        return list(self.definition.loading.kinks(p, **self.options))

    def end(self, params: Any) -> Any:
        """Overlap [m] at which the curve ends, one per contact: that of the Params of a law with a largest force."""
        return getattr(params, "largest_overlap", math.inf)

    def largest_force(self, params: Any) -> float:
        """Force [N] at the end of the curve."""
        return float(np.min(getattr(params, "max_force", math.inf)))

    def bulk(self, p: Any, hertz_coefficient: float, length: float, highest: float) -> BulkYield:
        """`BulkYield` in units of `length` [m], where the bulk yields below the dimensionless overlap `highest`."""
        if self.definition.loading.bulk is None or p.hertz_coefficient != hertz_coefficient:
            return NO_YIELD  # rows scale with R, the area of a blunter bulk does not
        overlap, area, slope = self.definition.loading.bulk.point(p)
        if not overlap / length < highest:
            return NO_YIELD
        return BulkYield(area / length, slope * p.hertz_coefficient * math.sqrt(length))

    def unloading_shape(self) -> Any:
        """The Shape with which this curve serves as an unloading curve: one whose inverse costs no search."""
        if not isinstance(self.shape, TableShape):
            return self.shape
        from demlaws.core.grid import with_reverse

        return with_reverse(self.shape)
