"""Height maps whose boundary-element solutions are in asperity_bem.csv (made by boundary_elements.py)."""

import csv
import math
from pathlib import Path

from demlaws.contact import Contact
from demlaws.solvers.contact import RoughContact
from demlaws.surface import self_affine

PIXELS, PIXEL, MODULUS = 256, 0.5e-6, 50e9


def cases():
    """Name, map, radius [m] (inf: flat, periodic)."""
    for name, roughness, hurst, radius in (
        ("smooth ball", 1e-15, 0.8, 3.175e-3),
        ("ball; fine", 0.1e-6, 0.8, 3.175e-3),
        ("ball; rough", 0.5e-6, 0.8, 3.175e-3),
        ("flat; H = 0.8", 0.5e-6, 0.8, math.inf),
        ("flat; H = 0.5", 0.5e-6, 0.5, math.inf),
    ):
        yield (
            name,
            self_affine(PIXELS, PIXEL, hurst, roughness=roughness, seed=7, shortest=4e-6, longest=40e-6, periodic=True),
            radius,
        )


def model(heights, radius):
    """The asperity model of a map pressed against a ball, or a flat."""
    flat = radius == math.inf
    pair = Contact(radius=1.0 if flat else radius, modulus=MODULUS, sigma=heights.sq)
    return RoughContact(heights, pair, flat=flat)


def read_csv(name):
    """Rows of a file beside this one, as dicts."""
    with open(Path(__file__).with_name(name), newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def load_ratios():
    """(case, load of the model computed now over the stored boundary-element load) at every stored overlap."""
    stored = read_csv("asperity_bem.csv")
    for name, heights, radius in cases():
        contact = model(heights, radius)
        for row in stored:
            if row["case"] == name:
                yield name, contact.at(float(row["overlap"])).force / float(row["bem_force"])
