"""How R of contacts is chosen for shapes that are neither spheres nor flats: body, curvature, edge radius or a function."""

import math
from numbers import Real
from typing import NamedTuple

import numpy as np

from demlaws.errors import DemlawsError, EngineStopped
from demlaws.yade import layout


class Curvature(NamedTuple):
    """radius="curvature" with an upper bound of the principal radii [m]: flat faces then have contacts with R up to it."""

    largest: float | None = None


class Radii:
    """How R of contacts is chosen, and the scene's shapes as compiled code reads them.

    choice: None (edge radii of surfaces, else the body's with a warning), "body", "curvature" (or `Curvature`), a number [m] or
    a function of the interaction. edges: edge radius [m] for each number of a surface, None if it is not given.
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
        elif callable(choice):
            self.mode = layout.FUNCTION_RADIUS
        else:
            raise DemlawsError(
                f'radius={choice!r}: give "body", "curvature", Curvature(largest=…), the edge radius in m, or a '
                "function of the interaction that returns R in m"
            )
        self.edges = edges
        self.known = {}  # (body, body) → step in which the contact began, sum of radii, for a function

    def is_new(self, contact):
        """Whether a contact has not been seen by this method, or not with these radii: true once."""
        key, start = (contact.id1, contact.id2), (contact.iterMadeReal, contact.geom.refR1 + contact.geom.refR2)
        new = self.known.get(key) != start
        self.known[key] = start
        return new

    def call(self, contact):
        """R [m] of a contact by the user's function."""
        value = self.choice(contact)
        if not (isinstance(value, Real) and 0.0 < value < math.inf):
            raise EngineStopped(
                f"radius= returned {value!r} for contact {contact.id1}+{contact.id2}: R must be a positive, finite length in m"
            )
        return float(value)

    def refresh(self, context):
        """Write the shapes of all bodies to where compiled code reads them."""
        if self.shapes is not None:
            self.shapes.refresh(context)

    def gap_address(self):
        """Address of `curvature.gap_radius` for compiled code; 0 for other choices."""
        return 0 if self.shapes is None else self.shapes.gap_address()
