"""Tables: the certificate holds, kinks are nodes, files come back bit for bit or not at all."""

import functools
import os
import re
import stat
import zlib

import numba
import numpy as np
import pytest
from examples import CONTACTS, GRANITE, SMOOTHER, SOFT, make, options_of, pairs, shared
from made_up import made_up_law

import demlaws as dl
from demlaws.core import loops
from demlaws.core.loops import leaves
from demlaws.curves import text as table_file
from demlaws.laws.registry import registry

SMOOTHER_ALIKE = SMOOTHER.with_values(fractal_dimension=GRANITE.fractal_dimension)

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")

LAWS = dl.laws()
PAIRS = pairs()
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
@pytest.mark.parametrize("contact", CONTACTS)
@pytest.mark.parametrize("rtol", [1e-3, 1e-5])
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
    overlap = overlap[overlap > 1e-10 * GRANITE.roughness]
    np.testing.assert_allclose(table.force(overlap), law.force(overlap), rtol=2e-5)
    np.testing.assert_allclose(table.stiffness(overlap), law.stiffness(overlap), rtol=2e-5)


@every_law
def test_tolerance_sets_the_size(name):
    if registry()[name].solved:
        with pytest.raises(dl.DemlawsError, match="comes from a solver"):
            make(name).tabulate(rtol=1e-6)
        return
    sizes = [table_of(name, "elastic", rtol).nodes.u.size for rtol in (1e-3, 1e-5, 1e-7)]
    assert sizes == sorted(sizes)
    assert table_of(name, "elastic", 1e-7).force_error <= 1e-7
    power = table_of(name, "elastic", 1e-3).force_error < 1e-13  # in s straight: a cell is exact, however wide
    assert power or sizes[0] < sizes[-1]


@pytest.mark.parametrize("name", ["pohrt-popov", "goddard", "rough-plastic", "bahrami"])
def test_kinks_are_nodes(name):
    table, law = table_of(name), make(name)
    kinks = np.array(law.kinks()) / table.length
    double = table.nodes.u[:-1][np.diff(table.nodes.u) == 0.0]
    inside = kinks[kinks < table.nodes.u[-1]]
    np.testing.assert_allclose(double, np.sort(inside), rtol=1e-12)
    for kink in inside * table.length:
        close = kink * (1.0 + np.array([-1e-7, -1e-11, 1e-11, 1e-7]))
        np.testing.assert_allclose(table.stiffness(close), law.stiffness(close), rtol=1e-5)
        np.testing.assert_allclose(table.force(close), law.force(close), rtol=1e-5)


# --- a table is a law


@pytest.mark.parametrize(("name", "unloading"), PAIRS)
def test_a_table_does_what_its_law_does(name, unloading, rng):
    table, law = table_of(name, unloading), make(name, unloading)
    assert isinstance(table, dl.Law)
    overlap = GRANITE.roughness * np.array([0.1, 1.0, 0.9, 5.0, 4.5, 4.0, 4.7, 6.0, -1.0, 2.0])
    a, b = table.follow(overlap), law.follow(overlap)
    scale = b.force.max()
    if unloading != "thornton":  # its unloading curve needs the contact radius, which a table gives only before yield
        np.testing.assert_allclose(a.force, b.force, rtol=2e-3, atol=3e-5 * scale)
        np.testing.assert_allclose(a.plastic_overlap, b.plastic_overlap, atol=2e-5 * overlap.max())
        np.testing.assert_allclose(a.work, b.work, rtol=3e-5, atol=1e-9 * b.work.max())
    force = law.force(GRANITE.roughness) * np.geomspace(0.1, 50.0, 40)
    np.testing.assert_allclose(table.overlap(force), law.overlap(force), rtol=2e-5)
    np.testing.assert_allclose(table.overlap(table.force(np.abs(overlap))), np.abs(overlap), rtol=1e-12)
    np.testing.assert_allclose(table.energy(overlap), law.energy(overlap), rtol=2e-5)
    state = table.new_state(100) if table.state_size else None
    batch = rng.uniform(0.0, 1e-5, 100)
    np.testing.assert_allclose(table.evaluate(batch, state)[0], law.force(batch), rtol=1.1e-5)
    for array in state.arrays[:1] if state is not None else ():
        np.testing.assert_array_equal(array, batch)
    assert table.energy(0.0) == table.force(0.0) == table.overlap(0.0) == 0.0


@pytest.mark.parametrize("loading", ["hertz", "pohrt-popov"])
def test_table_of_a_yielded_contact_unloads_by_thornton_as_its_law(loading):
    law = dl.law("rough-plastic", GRANITE, unloading="thornton", yield_pressure=0.5e9, loading=loading)
    table = law.tabulate(rtol=1e-5)
    path = GRANITE.roughness * np.array([4.0, 3.9, 3.7, 6.0, 5.8, 5.7])
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
        chosen = edges[1:] > 1e-4 * GRANITE.roughness
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
        with pytest.raises(dl.DemlawsError, match=r"beyond the table, which ends at .*make it with a larger max_force"):
            call()
    for bad in (0.0, 1.0, 1e-13, "fine", None):
        with pytest.raises(dl.DemlawsError, match="rtol"):
            make("pohrt-popov").tabulate(rtol=bad)
    with pytest.raises(dl.DemlawsError, match="max_force"):
        make("pohrt-popov").tabulate(max_force=-1.0)
    with pytest.raises(dl.DemlawsError, match=r"max_force = 1e\+09 N"):
        make("pohrt-popov").tabulate(max_force="1e6kN")


@pytest.mark.parametrize("name", [n for n, d in registry().items() if d.collapses])
def test_bound_to_another_contact(name, rng):
    """One curve serves every radius, modulus and roughness."""
    table = table_of(name)
    other = dl.law(name, SMOOTHER_ALIKE, **options_of(name))
    bound = table.bound_to(other.contact)
    overlap = np.exp(rng.uniform(np.log(1e-12), np.log(min(0.9 * bound.largest_overlap, 0.1 * SMOOTHER.radius)), 3000))
    np.testing.assert_allclose(bound.force(overlap), other.force(overlap), rtol=1.2e-5)
    np.testing.assert_allclose(bound.stiffness(overlap), other.stiffness(overlap), rtol=1.2e-5)
    many = GRANITE.with_values(radius=np.array([2e-3, 4e-3]), modulus=np.array([1e10, 3e10]), roughness=np.array([1e-6, 3e-6]))
    law = dl.law(name, many, **options_of(name))
    for several in (table.bound_to(many), law.tabulate(rtol=1e-5)):
        here = np.array([2e-6, 9e-6])
        np.testing.assert_allclose(several.force(here), law.force(here), rtol=1.2e-5)
        np.testing.assert_allclose(several.stiffness(here), law.stiffness(here), rtol=1.2e-5)


@pytest.mark.parametrize("name", [n for n, d in registry().items() if not d.collapses])
def test_a_curve_of_one_contact_is_not_lent(name):
    with pytest.raises(dl.DemlawsError, match="holds for the contact it was made for only"):
        table_of(name).bound_to(SOFT)
    many = GRANITE.with_values(radius=np.array([4e-3, 5e-3]))
    with pytest.raises(dl.DemlawsError, match=r"no single dimensionless curve|one pair of bodies"):
        dl.law(name, many, **options_of(name)).tabulate()


def test_a_surface_of_another_form_is_refused():
    """The curve of Df = 2.22 was taken for that of 2.6 without a word; an unloading curve keeps the surface it was made for."""
    table = table_of("pohrt-popov")
    with pytest.raises(dl.DemlawsError, match=r"for fractal_dimension = 2\.22, the contact has 2\.6"):
        table.bound_to(GRANITE.with_values(fractal_dimension=2.6))
    assert table.bound_to(GRANITE.with_values(fractal_dimension=None)).contact == GRANITE
    assert table.for_unloading(GRANITE.with_values(fractal_dimension=2.6)).contact == GRANITE
    assert table_of("rms").bound_to(GRANITE.with_values(fractal_dimension=2.6)).force(1e-6) == table_of("rms").force(1e-6)


def test_no_roughness_is_refused_where_the_table_scales_with_it():
    with pytest.raises(dl.DemlawsError, match="roughness = 0 m"):
        table_of("rms").bound_to(GRANITE.with_values(roughness=0.0))


# --- files


@pytest.mark.parametrize(("name", "unloading"), PAIRS)
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


@functools.cache
def small_file(unloading="hertz"):
    """Bytes of the smallest table with a kink."""
    import tempfile
    from pathlib import Path

    with tempfile.TemporaryDirectory() as folder:
        table = make("pohrt-popov", unloading).tabulate(rtol=0.05, max_force=100.0)
        return table.save(Path(folder) / "small.tbl").read_bytes()


def sealed(lines):
    """The file of these lines (without their check marks), marked anew: what a program that edits tables would write."""
    data = (lines[0] + "\n").encode()
    for line in lines[1:]:
        data += line.encode()
        data += b" %08x\n" % zlib.crc32(data)
    return data


def unsealed(data):
    first, *rest = data.decode().splitlines()
    return [first, *(line.rpartition(" ")[0] for line in rest)]


def test_a_table_is_given_a_curve_and_other_rules():
    """Loaded tables, too: the rows of first loading stay as they are, the curve gets rows in their scales."""
    table = table_of("pohrt-popov")
    joined = table.joined(make("pohrt-popov", "table").unloading_law)
    np.testing.assert_array_equal(joined.nodes, table.nodes)
    path = GRANITE.roughness * np.array([1.0, 0.9, 5.0, 4.7])
    expected = table_of("pohrt-popov", "table").follow(path)
    np.testing.assert_array_equal(joined.follow(path).force, expected.force)
    np.testing.assert_array_equal(
        joined.joined("hertz").follow(path).force, table_of("pohrt-popov", "hertz").follow(path).force
    )
    assert joined.joined("elastic").state_size == 0
    bound = joined.bound_to(SMOOTHER_ALIKE)
    curve = bound.unloading_law
    state = bound.new_state(1)
    path = bound.follow(SMOOTHER.roughness * np.array([3.0, 2.8]), state)
    assert path.force[1] == pytest.approx(curve.force(path.overlap[1] - path.plastic_overlap[1]), rel=1e-12)


def test_a_curve_that_ends_too_early_is_refused():
    curve = make("pohrt-popov", "table").unloading_law.tabulate(max_force=10.0)
    with pytest.raises(dl.DemlawsError, match="must reach beyond this table's"):
        dl.law("pohrt-popov", GRANITE, curve).tabulate(max_force=50.0)
    assert dl.law("pohrt-popov", GRANITE, curve).tabulate(max_force=5.0).unloading == "table"


def test_the_reader_needs_every_key_that_it_lists(tmp_path):
    """Each key left out is missed by name; the keys for people are not; and no other keys are written."""
    for unloading in ("hertz", "table"):
        lines = unsealed(small_file(unloading))
        keys = [line.partition(":")[0] for line in lines[1 : lines.index("overlap force stiffness")]]
        needed = [key.name for key in (*table_file.CURVE, *table_file.SHARED) if key.last_version == table_file.VERSIONS[-1]]
        needed += [f"unloading_{key.name}" for key in table_file.CURVE if unloading == "table" and f"{key.name}" != "contact"]
        assert set(needed) <= set(keys)
        for key in keys:
            data = sealed([line for line in lines if line.partition(":")[0] != key])
            if key in needed:
                assert f"lack {key!r}" in refuse(tmp_path / "a.tbl", data)[1]
            else:
                (tmp_path / "a.tbl").write_bytes(data)
                dl.Table.load(tmp_path / "a.tbl")


def refuse(path, data):
    path.write_bytes(data)
    with pytest.raises(dl.DemlawsError) as refusal:
        dl.Table.load(path)
    message = str(refusal.value)
    assert "\n" not in message
    assert "line " in message
    return int(message.split("line ")[1].split(":")[0].split(" ")[0]), message


@pytest.mark.parametrize("part", shared(range(4), (0).__eq__))
def test_truncated_at_any_byte(tmp_path, part):
    data = small_file()
    for length in range(part, len(data) - 1, 4):  # without its last newline nothing is missing yet
        number, message = refuse(tmp_path / "cut.tbl", data[:length])
        lines = data[:length].count(b"\n") + 1
        assert number in (lines, lines - 1), message
        assert number == 1 or "cut short" in message


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"\n",
        b"overlap,force\n0,0\n",
        b"\x7fELF\x02\x01\x01\x00",
        b"\xff\xfe# demlaws-table 1\n",
        b"# demlaws-table 1",
        b"{}",
        b"a newer version",
        b"text after the end",
    ],
)
def test_foreign_files(content, tmp_path):
    whole, line = small_file(), 1
    if content == b"a newer version":
        content = whole.replace(b"demlaws-table 3", b"demlaws-table 4", 1)
    elif content == b"text after the end":
        content, line = whole + b"1 2 3\n", whole.count(b"\n") + 1
    number, _ = refuse(tmp_path / "foreign.tbl", content)
    assert number == line or content == b"# demlaws-table 1"


def test_line_ends_of_another_system(tmp_path):
    """CR LF is read as LF, in every line or in some; a CR alone ends no line."""
    data = small_file()
    for ends in (b"\r\n", b"\r"):
        (tmp_path / "dos.tbl").write_bytes(data.replace(b"\n", ends))
        if ends == b"\r":
            refuse(tmp_path / "dos.tbl", data.replace(b"\n", ends))
            continue
        loaded = dl.Table.load(tmp_path / "dos.tbl")
        assert loaded.save(tmp_path / "again.tbl").read_bytes() == data
    (tmp_path / "mixed.tbl").write_bytes(data.replace(b"\n", b"\r\n", 7))
    assert dl.Table.load(tmp_path / "mixed.tbl").fingerprint == loaded.fingerprint


def test_the_fingerprint_is_the_last_check_mark(tmp_path):
    table = table_of("pohrt-popov", "hertz")
    mark = table.save(tmp_path / "a.tbl").read_text().split()[-1]
    assert f"{table.fingerprint:08x}" == mark == f"{dl.Table.load(tmp_path / 'a.tbl').fingerprint:08x}"
    assert table.fingerprint != table_of("pohrt-popov", "elastic").fingerprint


def test_a_law_that_is_not_here_is_its_table(tmp_path):
    """A table made with somebody's own law serves where that law is not installed, as it does in C++."""
    lines = unsealed(small_file())
    (tmp_path / "own.tbl").write_bytes(sealed([line.replace("law: pohrt-popov", "law: coulombs") for line in lines]))
    (tmp_path / "known.tbl").write_bytes(small_file())
    own, known = dl.Table.load(tmp_path / "own.tbl"), dl.Table.load(tmp_path / "known.tbl")
    assert own.name == "coulombs" and own.collapses and own.limits() == []
    overlap = own.largest_overlap * np.array([1e-3, 0.2, 0.9])
    np.testing.assert_array_equal(own.force(overlap), known.force(overlap))
    assert own.joined("elastic").bound_to(SMOOTHER).force(1e-8) == known.joined("elastic").bound_to(SMOOTHER_ALIKE).force(1e-8)


@pytest.mark.parametrize("said", ["yes", "no"])
def test_collapses_is_what_the_file_says(said, tmp_path):
    lines = [f"collapses: {said}" if line.startswith("collapses") else line for line in unsealed(small_file())]
    (tmp_path / "a.tbl").write_bytes(sealed(lines))
    table = dl.Table.load(tmp_path / "a.tbl")
    for one in (table, table.joined("elastic")):
        if said == "yes":
            one.bound_to(SMOOTHER_ALIKE)
        else:
            with pytest.raises(dl.DemlawsError, match="made for only"):
                one.bound_to(SMOOTHER_ALIKE)
    without = [line for line in lines if not line.startswith("collapses")]
    assert "lack 'collapses'" in refuse(tmp_path / "b.tbl", sealed(without))[1]


def test_missing_file_and_folder(tmp_path):
    with pytest.raises(dl.DemlawsError, match=r"cannot read table .*No such file"):
        dl.Table.load(tmp_path / "none.tbl")
    with pytest.raises(dl.DemlawsError, match=r"cannot read table .*directory"):
        dl.Table.load(tmp_path)
    (tmp_path / "file").write_text("")
    with pytest.raises(dl.DemlawsError, match="cannot write"):
        table_of("hertz").save(tmp_path / "file" / "a.tbl")


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
    path = tmp_path / "a.tbl"
    table_of("hertz").save(path)
    before = path.read_bytes()

    def full(*_):
        raise OSError(28, "No space left on device")

    for name in ("replace", "fdopen"):
        with monkeypatch.context() as patch:
            patch.setattr(os, name, full)
            with pytest.raises(dl.DemlawsError, match="No space left on device"):
                table_of("rms").save(path)
        assert path.read_bytes() == before
        assert os.listdir(tmp_path) == ["a.tbl"]


def test_saved_with_the_permissions_of_any_new_file(tmp_path):
    old = os.umask(0o027)
    try:
        path = table_of("hertz").save(tmp_path / "a.tbl")
    finally:
        os.umask(old)
    assert stat.S_IMODE(path.stat().st_mode) == 0o640


@pytest.mark.parametrize("bits", [1, 4, 7])
@pytest.mark.parametrize("place", [2.0, 2.0 * (1 + 1e-13), 2.0 * (1 - 1e-13), 2.1, 2.9999])
def test_a_kink_anywhere_in_the_grid(bits, place):
    """On a node, a hair beside one, or inside a cell: two straight lines that meet there are read as they are."""
    from demlaws.core.grid import Nodes, grid, shape_from_nodes
    from demlaws.core.loops import bind_params, evaluate_loop
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
    assert evaluate_loop(Elastic(), bind_params(shape, contact), points, (), force, stiffness)
    exact = np.minimum(points, place + 0.5 * (points - place))
    assert force / 1e6 == pytest.approx(exact**1.5, rel=1e-11)
    away = np.abs(points - place) > 1e-11
    tangent = 1.5 * np.sqrt(exact) * np.where(points < place, 1.0, 0.5)
    assert stiffness[away] / 1e6 == pytest.approx(tangent[away], rel=1e-9)


# --- laws that are not the registry's


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


@pytest.mark.slow
def test_an_unloading_curve_with_three_kinks():
    """The curve of a twice as stiff contact: a table unloads along it as its law does, through the kinks."""
    kinks = (0.3, 1.7, 3.0)
    law = made_up_law(GRANITE, kinks=kinks).joined(made_up_law(GRANITE.with_values(modulus=2.0 * GRANITE.modulus), kinks=kinks))
    table = law.tabulate(rtol=1e-3, max_force=100.0)
    np.testing.assert_allclose(table.unloading_law.nodes.kinks, kinks, rtol=1e-12)
    top = GRANITE.roughness * np.linspace(0.1, 4.0, 200)
    states = law.new_state(200), table.new_state(200)
    for part in (1.0, 0.97, 0.9, 0.8):
        exact, read = law.evaluate(part * top, states[0]), table.evaluate(part * top, states[1])
        assert np.max(np.abs(read[0] - exact[0]) / law.force(top)) <= 2e-3
        assert np.max(np.abs(states[1].plastic_overlap - states[0].plastic_overlap) / top) <= 1e-3


def test_a_table_with_many_kinks_is_vectorised():
    """A kink more is a comparison more for all contacts at once, no loop and no branch."""
    table = made_up_law(GRANITE, kinks=(0.3, 1.7, 3.0)).tabulate(rtol=1e-2, max_force=100.0)
    compiled = numba.njit(error_model="numpy", fastmath={"contract"}, nogil=True)(loops.batch_loop.py_func)
    overlap, force, stiffness = np.linspace(0.0, table.largest_overlap, 64), np.empty(64), np.empty(64)
    compiled(table.rule, table.params, overlap, (), loops.UNBOUNDED, loops.FINITE, force, stiffness)
    np.testing.assert_array_equal(force, table.force(overlap))
    (text,) = compiled.inspect_llvm().values()
    assert len(re.findall(r"= f\w+ (?:\w+ )*<\d+ x double>", text)) > 10


def test_more_kinks_than_a_table_holds_are_refused():
    kinks = tuple(np.geomspace(0.1, 0.97, table_file.MOST_KINKS + 1))
    with pytest.raises(dl.DemlawsError, match="33 kinks of the stiffness lie in the table's range: a table holds 32 at most"):
        made_up_law(GRANITE, kinks=kinks).tabulate(max_force=50.0)


@pytest.mark.parametrize("exponent", [0.6, 0.75])
def test_a_flat_power_law_is_no_seating_load(exponent, tmp_path):
    """P ∝ δ^0.6 has no force at overlap 0 although its exponent is that of a law with a seat: what the law declares counts."""
    law = made_up_law(GRANITE, exponent)
    table = law.tabulate(rtol=1e-3, max_force=50.0)
    loaded = dl.Table.load(table.save(tmp_path / "flat.tbl"))
    assert b"below_first_row: power " in (tmp_path / "flat.tbl").read_bytes()
    overlap = table.nodes.u[0] * table.length * 10.0 ** np.linspace(-10, 0, 60)
    for one in (table, loaded):
        np.testing.assert_allclose(one.force(overlap), law.force(overlap), rtol=2e-3)
        np.testing.assert_allclose(one.stiffness(overlap), law.stiffness(overlap), rtol=2e-3)
    edges = table.nodes.u[0] * table.length * np.array([1e-3, 1.0, 3.0])
    np.testing.assert_allclose(table.energy(edges), law.energy(edges), rtol=2e-3)


def test_a_replaced_file_is_named(tmp_path, recwarn):
    table, other = table_of("hertz"), table_of("rms")
    path = table.save(tmp_path / "law.tbl")
    table.save(path)
    assert not recwarn
    with pytest.warns(UserWarning, match=r"law\.tbl held a table of law 'hertz'.*replaced by law 'rms'"):
        other.save(path)
    (tmp_path / "notes.txt").write_text("notes")
    with pytest.warns(UserWarning, match="not a readable table"):
        table.save(tmp_path / "notes.txt")
