"""Curves on a grid: energies below the first node, kinks of many contacts."""

from pathlib import Path

import numpy as np
import pytest

import demlaws as dl
from demlaws.core.grid import Nodes, grid, shape_from_nodes
from demlaws.core.loops import bind_params, energy_loop, force_loop

TABLES = Path(__file__).parents[1] / "data" / "tables" / "good"


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


@pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")
@pytest.mark.parametrize("rule", ["hertz", "thornton", "table"])
def test_energies_where_the_plastic_overlap_is_negative(rule):
    """A curve that starts from a force unloads to overlap 0 with a force left: what is below is neither stored nor returned."""
    table = dl.Table.load(TABLES / "yip-venart-table.tbl").joined("elastic")
    smooth = dl.law("hertz", table.contact)
    law = table.joined(smooth) if rule == "table" else table.joined(rule)
    path = law.follow(1e-9 * np.concatenate([np.linspace(0.0, 1.0, 401)[1:], np.linspace(1.0, 1e-6, 401)]))
    assert law.unloading == rule and np.all(path.plastic_overlap < 0.0)
    top, foot = path.plastic_overlap[400], 1e-15
    stored = smooth.energy(1e-9 - top) - smooth.energy(foot - top)  # of the unloading curve above overlap 0
    assert path.stored[399] == pytest.approx(stored, rel=1e-6)
    np.testing.assert_allclose(path.stored + path.dissipated, path.work, atol=1e-4 * path.work.max())
    assert np.all(np.diff(path.dissipated) >= -1e-15 * path.work.max()) and path.dissipated[-1] > 0.0


def test_kinks_of_many_contacts_are_the_first_ones():
    radius = np.array([2e-3, 4e-3, 8e-3])
    contact = dl.Contact(radius=4e-3, modulus=32e9)
    many = dl.law("thornton-ning", contact.with_values(radius=radius), yield_pressure=1e9).kinks()
    one = dl.law("thornton-ning", contact.with_values(radius=radius[0]), yield_pressure=1e9).kinks()
    assert many == pytest.approx(one, rel=1e-12) and len(one) == 1
