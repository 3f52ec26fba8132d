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
        if isinstance(choice, str) and choice == "curvature":
            choice = Curvature()
        self.choice, self.shapes, self.mode = choice, None, layout.BODY_RADIUS
        edges = np.array([edge or 0.0 for edge in edges])
        if isinstance(choice, Curvature):
            self.mode = layout.CURVATURE_RADIUS
            largest = choice.largest
            if largest is not None and not (isinstance(largest, Real) and 0.0 < largest < math.inf):
                raise DemlawsError(f"Curvature(largest={largest!r}): the largest principal radius must be positive, in m")
            from demlaws.yade.curvature import Shapes

            self.shapes = Shapes(float(largest or 0.0))
        elif isinstance(choice, str) and choice == "body":
            self.mode = layout.BODY_RADIUS_MEANT
            edges[:] = 0.0
        elif isinstance(choice, Real) and not isinstance(choice, bool) and 0.0 < choice < math.inf:
            edges[edges == 0.0] = float(choice)
        elif choice is not None:
            raise DemlawsError(f'radius={choice!r}: give "body", "curvature", Curvature(largest=…) or the edge radius in m')
        self.edges = edges

    def refresh(self, context):
        """Write the shapes of all bodies to where compiled code reads them."""
        if self.shapes is not None:
            self.shapes.refresh(context)

    def fill(self, context):
        """Write the choice to where compiled code reads it."""
        context["radius_mode"] = self.mode
        context["edges"] = self.edges.ctypes.data
        if self.shapes is not None:
            self.shapes.fill(context)
