"""Curves on a grid: energies below the first node, kinks of many contacts."""

import numpy as np
import pytest

import demlaws as dl
from demlaws.core.grid import Nodes, grid, shape_from_nodes
from demlaws.core.loops import bind_params, energy_loop, force_loop


def test_energy_of_a_curve_that_starts_from_a_force():
    """Below the first node s = seat + slope u is straight, P = k (L s)^1.5: ∫P dδ in closed form."""
    contact = dl.Contact(radius=4e-3, modulus=32e9)
    seat, slope = 0.02, 0.5
    u, _ = grid(0.25, 2.0, [], 6)
    shape = shape_from_nodes(Nodes.from_curve(u, seat + slope * u, np.full(u.size, slope)), 6, 0.0, 1e-3, straight=True)
    assert shape.grid.seat == pytest.approx(seat) and shape.grid.lowest == 0.25
    params = bind_params(shape, contact)
    length, stiffness = 1e-3 * contact.radius, 4.0 / 3.0 * contact.modulus * contact.radius**0.5
    overlap = length * np.array([1e-3, 0.1, 0.24, 0.26, 1.0])
    power = (seat + slope * overlap / length) ** 2.5 - seat**2.5
    expected = stiffness * length**2.5 * power / (2.5 * slope)
    np.testing.assert_allclose(energy_loop(shape, params, overlap), expected, rtol=1e-6)
    force = stiffness * (length * (seat + slope * overlap / length)) ** 1.5
    np.testing.assert_allclose(force_loop(shape, params, overlap)[0], force, rtol=1e-10)


def test_kinks_of_many_contacts_are_the_first_ones():
    radius = np.array([2e-3, 4e-3, 8e-3])
    contact = dl.Contact(radius=4e-3, modulus=32e9)
    many = dl.law("thornton-ning", contact.with_values(radius=radius), yield_pressure=1e9).kinks()
    one = dl.law("thornton-ning", contact.with_values(radius=radius[0]), yield_pressure=1e9).kinks()
    assert many == pytest.approx(one, rel=1e-12) and len(one) == 1
