"""Tables: the certificate holds, kinks are nodes, files come back bit for bit or not at all."""

import functools
import math
import os
import stat
import tempfile
from pathlib import Path

import numpy as np
import pytest
from examples import CONTACTS, GRANITE, SMOOTHER, SOFT, make, options_of, pairs, sealed, shared, telling

import demlaws as dl
from demlaws import files
from demlaws.core.dispatch import leaves
from demlaws.curves import table_grammar as table_file
from demlaws.curves.closed import FormulaCurve
from demlaws.laws.registry import registry

SMOOTHER_ALIKE = SMOOTHER.with_values(fractal_dimension=GRANITE.fractal_dimension)

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")

LAWS = dl.laws()
every_pair = pytest.mark.parametrize(("name", "unloading"), shared(pairs(), telling))
every_law = pytest.mark.parametrize("name", LAWS)


@functools.cache
def table_of(name, unloading="elastic", rtol=1e-5, contact="granite"):
    return make(name, unloading, contact).tabulate(rtol=rtol)


def end_of(table):
    """Largest overlap at which the table is read here: its end, or before the radius, beyond which no law answers."""
    return min(float(table.largest_overlap), 0.99 * float(table.contact.radius))


def between(table, rng, count=20000):
    """Overlaps that the builder did not look at: anywhere in each octave, and next to every node."""
    low, high = table.nodes.u[0] * table.length, end_of(table)
    anywhere = np.exp(rng.uniform(np.log(low), np.log(high), count))
    nodes = table.nodes.u[1:-1] * table.length
    nodes = nodes[nodes < 0.99 * high]
    return np.concatenate([anywhere, nodes * (1 + 1e-6), nodes * (1 - 1e-6), low + (high - low) * rng.random(2000)])


# --- the certificate


@every_law
@pytest.mark.parametrize(("contact", "rtol"), [("granite", 1e-3), *((contact, 1e-5) for contact in CONTACTS)])
def test_certificate_holds_at_other_points(name, contact, rtol, rng):
    table, law = table_of(name, "elastic", rtol, contact), make(name, contact=contact)
    assert 0.0 < table.force_error <= rtol or name == "hertz"
    assert table.stiffness_error <= rtol
    overlap = between(table, rng)
    force = np.max(np.abs(table.force(overlap) / law.force(overlap) - 1))
    stiffness = np.max(np.abs(table.stiffness(overlap) / law.stiffness(overlap) - 1))
    # seven points a cell miss the worst place by little; two curves read from cells differ by rounding besides
    assert force <= 1.1 * table.force_error + 1e-13
    assert stiffness <= 1.1 * table.stiffness_error + 1e-12
    if not registry()[name].solved:  # a certificate is no idle number: errors of its size do occur
        assert force >= 0.3 * table.force_error - 1e-13
        assert stiffness >= 0.3 * table.stiffness_error - 1e-12


@every_law
def test_below_the_first_node_a_power_law_holds(name, rng):
    table, law = table_of(name), make(name)
    overlap = table.nodes.u[0] * table.length * 10.0 ** rng.uniform(-6, 0, 500)
    overlap = overlap[overlap > 1e-10 * GRANITE.sigma]
    np.testing.assert_allclose(table.force(overlap), law.force(overlap), rtol=2e-5)
    np.testing.assert_allclose(table.stiffness(overlap), law.stiffness(overlap), rtol=2e-5)


@every_law
def test_tolerance_sets_the_size(name):
    if registry()[name].solved:
        with pytest.raises(dl.DemlawsError):
            make(name).tabulate(rtol=1e-6)
        return
    sizes = [table_of(name, "elastic", rtol).nodes.u.size for rtol in (1e-3, 1e-5, 1e-7)]
    assert sizes == sorted(sizes)
    assert table_of(name, "elastic", 1e-7).force_error <= 1e-7
    power = table_of(name, "elastic", 1e-3).force_error <= 1e-13  # in s straight: a cell is exact, however wide
    assert power or sizes[0] < sizes[-1]


# --- a table is a law


@every_pair
def test_a_table_does_what_its_law_does(name, unloading, rng):
    table, law = table_of(name, unloading), make(name, unloading)
    assert isinstance(table, dl.Law)
    overlap = GRANITE.sigma * np.array([0.1, 1.0, 0.9, 5.0, 4.5, 4.0, 4.7, 6.0, -1.0, 2.0])
    a, b = table.follow(overlap), law.follow(overlap)
    scale = b.force.max()
    if unloading != "thornton":  # its unloading curve needs the contact radius, which a table gives only before yield
        np.testing.assert_allclose(a.force, b.force, rtol=2e-3, atol=3e-5 * scale)
        np.testing.assert_allclose(a.plastic_overlap, b.plastic_overlap, atol=2e-5 * overlap.max())
        np.testing.assert_allclose(a.work, b.work, rtol=3e-5, atol=1e-9 * b.work.max())
    force = law.force(GRANITE.sigma) * np.geomspace(0.1, 50.0, 40)
    np.testing.assert_allclose(table.overlap(force), law.overlap(force), rtol=2e-5)
    np.testing.assert_allclose(table.overlap(table.force(np.abs(overlap))), np.abs(overlap), rtol=1e-12)
    np.testing.assert_allclose(table.energy(overlap), law.energy(overlap), rtol=2e-5)
    state = table.new_state(100) if table.state_size else None
    batch = rng.uniform(0.0, 1e-5, 100)
    np.testing.assert_allclose(table.evaluate(batch, state)[0], law.force(batch), rtol=1.1e-5)
    for array in state.arrays[:1] if state is not None else ():
        np.testing.assert_array_equal(array, batch)
    assert table.energy(0.0) == table.force(0.0) == table.overlap(0.0) == 0.0


def test_table_of_a_yielded_contact_unloads_by_thornton_as_its_law():
    law = dl.law("rough-plastic", GRANITE, unloading="thornton", yield_pressure=0.5e9, loading="hertz")
    table = law.tabulate(rtol=1e-5)
    path = GRANITE.sigma * np.array([4.0, 3.9, 3.7, 6.0, 5.8, 5.7])
    a, b = table.follow(path), law.follow(path)
    np.testing.assert_allclose(a.force, b.force, rtol=1e-3)
    np.testing.assert_allclose(a.plastic_overlap, b.plastic_overlap, rtol=1e-3)


def test_energy_of_a_table_is_the_integral_of_its_own_force():
    for name in ("rms", "rough-plastic", "yip-venart"):
        table = table_of(name)
        x, weights = np.polynomial.legendre.leggauss(8)
        edges = np.unique(np.concatenate([table.nodes.u * table.length, np.geomspace(1e-12, 0.9 * end_of(table), 900)]))
        edges = np.append(0.0, edges[edges <= end_of(table)])
        half = 0.5 * np.diff(edges)
        work = np.cumsum(half * (table.force(edges[:-1, None] + half[:, None] * (1 + x)) @ weights))
        chosen = edges[1:] > 1e-4 * GRANITE.sigma
        # below the first node the energy is the power law's, the force that of the cells that stand for it (4e-8 of it)
        np.testing.assert_allclose(table.energy(edges[1:])[chosen], work[chosen], rtol=1e-7)
        well_above = edges[1:] > 1e3 * table.nodes.u[0] * table.length
        np.testing.assert_allclose(table.energy(edges[1:])[well_above], work[well_above], rtol=1e-10)


def test_range_errors():
    table = make("pohrt-popov", "hertz").tabulate(max_force=50.0)
    assert table.largest_force == pytest.approx(table.force(table.largest_overlap * (1 - 1e-12)), rel=1e-9)
    assert 50.0 <= table.largest_force < 400.0
    assert table.overlap(50.0) <= table.largest_overlap
    for call in (
        lambda: table.force(1.01 * table.largest_overlap),
        lambda: table.stiffness(1.01 * table.largest_overlap),
        lambda: table.follow([1.01 * table.largest_overlap]),
        lambda: table.evaluate(np.array([1e-6, 1.01 * table.largest_overlap]), table.new_state(2)),
        lambda: table.overlap(1.01 * table.largest_force),
    ):
        with pytest.raises(dl.DemlawsError):
            call()


@pytest.mark.parametrize("name", [n for n, d in registry().items() if d.collapses])
def test_bound_to_another_contact(name, rng):
    """One curve serves every radius, modulus and roughness."""
    table = table_of(name)
    other = dl.law(name, SMOOTHER_ALIKE, **options_of(name))
    bound = table.bound_to(other.contact)
    overlap = np.exp(rng.uniform(np.log(1e-12), np.log(min(0.9 * bound.largest_overlap, 0.1 * SMOOTHER.radius)), 3000))
    np.testing.assert_allclose(bound.force(overlap), other.force(overlap), rtol=1.2e-5)
    np.testing.assert_allclose(bound.stiffness(overlap), other.stiffness(overlap), rtol=1.2e-5)
    many = GRANITE.with_values(radius=np.array([2e-3, 4e-3]), modulus=np.array([1e10, 3e10]), sigma=np.array([1e-6, 3e-6]))
    law = dl.law(name, many, **options_of(name))
    for several in (table.bound_to(many), law.tabulate(rtol=1e-5)):
        here = np.array([2e-6, 9e-6])
        np.testing.assert_allclose(several.force(here), law.force(here), rtol=1.2e-5)
        np.testing.assert_allclose(several.stiffness(here), law.stiffness(here), rtol=1.2e-5)


@pytest.mark.parametrize("name", [n for n, d in registry().items() if not d.collapses])
def test_a_curve_of_one_contact_is_not_lent(name):
    with pytest.raises(dl.DemlawsError):
        table_of(name).bound_to(SOFT)
    many = GRANITE.with_values(radius=np.array([4e-3, 5e-3]))
    with pytest.raises(dl.DemlawsError):
        dl.law(name, many, **options_of(name)).tabulate()


def test_a_surface_of_another_form_is_refused():
    """The curve of Df = 2.22 was silently taken for that of 2.6; an unloading curve keeps the surface it was made for."""
    table = table_of("pohrt-popov")
    with pytest.raises(dl.DemlawsError):
        table.bound_to(GRANITE.with_values(fractal_dimension=2.6))
    assert table.bound_to(GRANITE.with_values(fractal_dimension=None)).contact == GRANITE
    assert table.bound_to(GRANITE.with_values(fractal_dimension=2.6), surface_matters=False).contact == GRANITE
    assert table_of("rms").bound_to(GRANITE.with_values(fractal_dimension=2.6)).force(1e-6) == table_of("rms").force(1e-6)
    with pytest.raises(dl.DemlawsError):
        table_of("rms").bound_to(GRANITE.with_values(sigma=0.0))


# --- files


@every_pair
def test_a_saved_table_comes_back_bit_for_bit(name, unloading, tmp_path, rng):
    table = table_of(name, unloading)
    path = table.save(tmp_path / "sub" / "law.tbl")
    loaded = dl.Table.load(path)
    assert (loaded.name, loaded.unloading, loaded.contact) == (name, unloading, GRANITE)
    assert loaded.options.keys() == table.options.keys()
    assert name == "asperity" or loaded.options == table.options  # its height map stays where it is
    assert (loaded.force_error, loaded.stiffness_error, loaded.rtol) == (table.force_error, table.stiffness_error, table.rtol)
    for a, b in zip(loaded.nodes, table.nodes, strict=True):
        np.testing.assert_array_equal(a, b)
    for a, b in zip(leaves(loaded.shape), leaves(table.shape), strict=True):
        np.testing.assert_array_equal(a, b)
    overlap = rng.uniform(0.0, 1e-5, 200)
    for quantity in ("force", "stiffness", "work", "plastic_overlap"):
        np.testing.assert_array_equal(getattr(loaded.follow(overlap), quantity), getattr(table.follow(overlap), quantity))
    again = loaded.save(tmp_path / "again.tbl")
    assert again.read_bytes() == path.read_bytes()


def small_file():
    """Bytes of the smallest table with a kink."""
    with tempfile.TemporaryDirectory() as folder:
        table = make("pohrt-popov", "hertz").tabulate(rtol=0.05, max_force=100.0)
        return table.save(Path(folder) / "small.tbl").read_bytes()


def test_a_table_is_given_a_curve_and_other_rules():
    """Loaded tables, too: the rows of first loading stay as they are, the curve gets rows in their scales."""
    table = table_of("pohrt-popov")
    joined = table.joined(make("pohrt-popov", "table").unloading_law)
    np.testing.assert_array_equal(joined.nodes, table.nodes)
    path = GRANITE.sigma * np.array([1.0, 0.9, 5.0, 4.7])
    expected = table_of("pohrt-popov", "table").follow(path)
    np.testing.assert_array_equal(joined.follow(path).force, expected.force)
    np.testing.assert_array_equal(
        joined.joined("hertz").follow(path).force, table_of("pohrt-popov", "hertz").follow(path).force
    )
    assert joined.joined("elastic").state_size == 0
    bound = joined.bound_to(SMOOTHER_ALIKE)
    curve = bound.unloading_law
    state = bound.new_state(1)
    path = bound.follow(SMOOTHER.sigma * np.array([3.0, 2.8]), state)
    assert path.force[1] == pytest.approx(curve.force(path.overlap[1] - path.plastic_overlap[1]), rel=1e-12)


def test_a_curve_that_ends_too_early_is_refused():
    curve = make("pohrt-popov", "table").unloading_law.tabulate(max_force=10.0)
    with pytest.raises(dl.DemlawsError):
        dl.law("pohrt-popov", GRANITE, curve).tabulate(max_force=50.0)
    assert dl.law("pohrt-popov", GRANITE, curve).tabulate(max_force=5.0).unloading == "table"


GOOD = Path(__file__).parents[1] / "data" / "tables" / "good"


def test_a_law_that_is_not_here_is_its_table(tmp_path):
    """A table made with somebody's own law serves where that law is not installed, as it does in C++."""
    own, data = dl.Table.load(GOOD / "law-of-others.tbl"), small_file()
    (tmp_path / "known.tbl").write_bytes(data)
    known = dl.Table.load(tmp_path / "known.tbl")
    assert own.name == "coulombs" and own.collapses and own.limits() == []
    overlap = own.largest_overlap * np.array([1e-3, 0.2, 0.9])
    np.testing.assert_allclose(own.force(overlap), known.force(overlap), rtol=1e-14)
    bound = own.joined("elastic").bound_to(SMOOTHER), known.joined("elastic").bound_to(SMOOTHER_ALIKE)
    assert bound[0].force(1e-8) == pytest.approx(bound[1].force(1e-8), rel=1e-14)
    # a file may say that its curve does not collapse
    lines = data.splitlines()[:-1]
    (tmp_path / "a.tbl").write_bytes(sealed([b"collapses: no" if b"collapses" in line else line for line in lines]))
    for table in (dl.Table.load(tmp_path / "a.tbl"), dl.Table.load(tmp_path / "a.tbl").joined("elastic")):
        with pytest.raises(dl.DemlawsError):
            table.bound_to(SMOOTHER_ALIKE)


def test_missing_file_and_folder(tmp_path):
    (tmp_path / "file").write_text("")
    for call in (
        lambda: dl.Table.load(tmp_path / "none.tbl"),
        lambda: dl.Table.load(tmp_path),
        lambda: table_of("hertz").save(tmp_path / "file" / "a.tbl"),
    ):
        with pytest.raises(dl.DemlawsError):
            call()


def test_devices_and_links_are_not_replaced_by_files(tmp_path):
    """Renaming a file over a device removes it: as root, /dev/null."""
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(dl.DemlawsError):
        table_of("hertz").save(tmp_path / "pipe")
    assert stat.S_ISFIFO((tmp_path / "pipe").stat().st_mode)
    (tmp_path / "link.tbl").symlink_to(tmp_path / "a.tbl")
    table_of("hertz").save(tmp_path / "link.tbl")
    assert (tmp_path / "link.tbl").is_symlink() and dl.Table.load(tmp_path / "a.tbl") == table_of("hertz")


def test_a_failed_save_leaves_the_old_file_and_no_other(tmp_path, monkeypatch):
    path, old = tmp_path / "a.tbl", os.umask(0o027)
    try:
        table_of("hertz").save(path)
    finally:
        os.umask(old)
    assert stat.S_IMODE(path.stat().st_mode) == 0o640
    before = path.read_bytes()

    def full(*_):
        raise OSError(28, "No space left on device")

    for place, name in ((os, "replace"), (files, "open")):
        with monkeypatch.context() as patch:
            patch.setattr(place, name, full, raising=False)
            with pytest.raises(dl.DemlawsError):
                table_of("rms").save(path)
        assert path.read_bytes() == before
        assert os.listdir(tmp_path) == ["a.tbl"]


@pytest.mark.parametrize("bits", [1, 4, 7])
@pytest.mark.parametrize("place", [2.0, 2.0 * (1 + 1e-13), 2.0 * (1 - 1e-13), 2.1, 2.9999])
def test_a_kink_anywhere_in_the_grid(bits, place):
    """On a node, a hair beside one, or inside a cell: two straight lines that meet there are read as they are."""
    from demlaws.core.grid import Nodes, grid, shape_from_nodes
    from demlaws.core.loops import FINITE, UNBOUNDED, batch_loop, bind_params
    from demlaws.core.unloading import Elastic

    u, _ = grid(0.5, 30.0, [place], bits)
    first, second = np.flatnonzero(u == place)
    s = np.minimum(u, place + 0.5 * (u - place))
    slope = np.where(np.arange(u.size) <= first, 1.0, 0.5)
    assert second == first + 1
    shape = shape_from_nodes(Nodes.from_curve(u, s, slope), bits, 0.0, 1.0)
    contact = dl.Contact(radius=1.0, modulus=0.75e6)  # so that P = s^1.5 MN
    points = np.sort(np.append(np.linspace(0.5, 29.9, 4001), [place * (1 - 1e-12), place * (1 + 1e-12)]))
    force, stiffness = np.empty(points.size), np.empty(points.size)
    assert batch_loop(Elastic(), shape, bind_params(shape, contact), points, (), UNBOUNDED, FINITE, force, stiffness)
    exact = np.minimum(points, place + 0.5 * (points - place))
    assert force / 1e6 == pytest.approx(exact**1.5, rel=1e-11)
    away = np.abs(points - place) > 1e-11
    tangent = 1.5 * np.sqrt(exact) * np.where(points < place, 1.0, 0.5)
    assert stiffness[away] / 1e6 == pytest.approx(tangent[away], rel=1e-9)


# --- laws that are not the registry's


def made_up_law(contact, exponent=1.5, kinks=()):
    """P = C (σ^(1.5 - n) δ^n + 0.3 √σ Σ (δ - kink σ)), C = (4/3) E* √R, terms of the sum where they are positive."""
    places = (*map(float, kinks), math.inf)

    def force(p, overlap):
        u = overlap / p.sigma
        f = u**exponent
        for kink in places:
            f += 0.3 * max(u - kink, 0.0)
        return p.hertz_coefficient * p.sigma**1.5 * f

    def stiffness(p, overlap):
        u = overlap / p.sigma
        k = exponent * u ** (exponent - 1.0)
        for kink in places:
            k += 0.3 if u >= kink else 0.0
        return p.hertz_coefficient * p.sigma**0.5 * k

    facts = {"length": "roughness", "collapses": True, "kinks": lambda p, **_: [kink * contact.sigma for kink in kinks]}
    return dl.Law(contact, FormulaCurve(dl.define("made-up", force, stiffness, **facts), contact, {}))


def test_a_law_with_three_kinks_is_tabulated_to_its_certificate(tmp_path, rng):
    """Two kinks in one cell among them; as a file, too."""
    law = made_up_law(GRANITE, kinks=(0.3, 1.7, 1.72))
    table = law.tabulate(rtol=1e-4, max_force=100.0)
    np.testing.assert_allclose(table.nodes.kinks, [0.3, 1.7, 1.72], rtol=1e-12)
    loaded = dl.Table.load(table.save(tmp_path / "a.tbl"))
    overlap = between(table, rng, 4000)
    near = np.outer(table.nodes.kinks * table.length, 1.0 + np.array([-1e-9, -1e-13, 1e-13, 1e-9])).ravel()
    overlap = np.concatenate([overlap, near])
    for one in (table, loaded):
        force = np.max(np.abs(one.force(overlap) / law.force(overlap) - 1))
        stiffness = np.max(np.abs(one.stiffness(overlap) / law.stiffness(overlap) - 1))
        assert force <= 1.1 * table.force_error + 1e-13 <= 1.2e-4
        assert stiffness <= 1.1 * table.stiffness_error + 1e-12 <= 1.2e-4
    assert stiffness >= 0.3 * table.stiffness_error
    np.testing.assert_allclose(table.overlap(law.force(overlap)), overlap, rtol=2e-4)


def test_more_kinks_than_a_table_holds_are_refused():
    kinks = tuple(np.geomspace(0.1, 0.97, table_file.MOST_KINKS + 1))
    with pytest.raises(dl.DemlawsError):
        made_up_law(GRANITE, kinks=kinks).tabulate(max_force=50.0)


@pytest.mark.parametrize("exponent", [0.6, 0.75])
def test_a_flat_power_law_is_no_seating_load(exponent, tmp_path):
    """P ∝ δ^0.6 has no force at overlap 0 although its exponent is that of a law with a seat: the law's declaration decides."""
    law = made_up_law(GRANITE, exponent)
    table = law.tabulate(rtol=1e-3, max_force=50.0)
    loaded = dl.Table.load(table.save(tmp_path / "flat.tbl"))
    assert b"below: power\n" in (tmp_path / "flat.tbl").read_bytes()
    overlap = table.nodes.u[0] * table.length * 10.0 ** np.linspace(-10, 0, 60)
    for one in (table, loaded):
        np.testing.assert_allclose(one.force(overlap), law.force(overlap), rtol=2e-3)
        np.testing.assert_allclose(one.stiffness(overlap), law.stiffness(overlap), rtol=2e-3)
    edges = table.nodes.u[0] * table.length * np.array([1e-3, 1.0, 3.0])
    np.testing.assert_allclose(table.energy(edges), law.energy(edges), rtol=2e-3)
