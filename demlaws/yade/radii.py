"""How R of contacts is chosen for shapes that are neither spheres nor flats: body, curvature or edge radius."""

import math
from numbers import Real
from typing import NamedTuple

import numpy as np

from demlaws.errors import DemlawsError
from demlaws.yade import layout


class Curvature(NamedTuple):
    """radius="curvature" with an upper bound of the principal radii [m]: flat faces then have contacts with R up to it."""

    largest: float | None = None


class Radii:
    """How R of contacts is chosen, and the scene's shapes as compiled code reads them.

    choice: None (edge radii of surfaces, else the body's with a warning), "body", "curvature" (or `Curvature`), or a number
    [m]. edges: edge radius [m] for each number of a surface, None if it is not given.
    """

    def __init__(self, choice, edges):
        self.choice, self.shapes = choice, None
        edges = np.array([edge or 0.0 for edge in edges])
        if choice is None or (isinstance(choice, str) and choice == "body"):
            self.mode = layout.BODY_RADIUS if choice is None else layout.BODY_RADIUS_MEANT
            if choice is not None:
                edges[:] = 0.0
        elif isinstance(choice, Curvature) or (isinstance(choice, str) and choice == "curvature"):
            self.mode = layout.CURVATURE_RADIUS
            largest = choice.largest if isinstance(choice, Curvature) else None
            if largest is not None and not (isinstance(largest, Real) and 0.0 < largest < math.inf):
                raise DemlawsError(f"Curvature(largest={largest!r}): the largest principal radius must be positive, in m")
            from demlaws.yade.curvature import Shapes

            self.shapes = Shapes(float(largest or 0.0))
        elif isinstance(choice, Real) and not isinstance(choice, bool) and 0.0 < choice < math.inf:
            self.mode = layout.BODY_RADIUS
            edges[edges == 0.0] = float(choice)
        else:
            raise DemlawsError(f'radius={choice!r}: give "body", "curvature", Curvature(largest=…) or the edge radius in m')
        self.edges = edges

    def refresh(self, context):
        """Write the shapes of all bodies to where compiled code reads them."""
        if self.shapes is not None:
            self.shapes.refresh(context)

    def gap_address(self):
        """Address of `curvature.gap_radius` for compiled code; 0 for other choices."""
        return 0 if self.shapes is None else self.shapes.gap_address()
