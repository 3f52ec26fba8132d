"""What the plugins of LIGGGHTS and LAMMPS do alike: the forces of every law, damping, restart, ranks, limits, refusals."""

import math
import re

import inputs_for_lammps
import numpy as np
import pytest
from examples import ALIKE, shared
from inputs import (
    ENERGY,
    LOAD_UNLOAD,
    counts,
    energy_error_of,
    error_of,
    modulus,
    moves_of,
    part,
    refused,
    said_in,
    simulate,
    sphere_mass,
    started,
)
from spheres import DIAMETER, ROUGH, assert_goes_on, both, continued, spheres

import demlaws as dl
from demlaws.make import example_law

REFUSED = "began under another law|not the table that|different contact history model"
PRESS = [(-20, 0, 1000)]
"""1 mm in 50 µs, a quarter of the R = 4 mm of two spheres of 16 mm."""


def assert_same(log, path, limit):
    """Force, energies and, where it is shown, history of a contact in an engine against the law's."""
    assert path.overlap.max() > 1e-5
    assert np.abs(log["force"] - path.force).max() <= limit * path.force.max()
    touching = log["overlap"] > 0
    for column, expected in (("stored", path.stored), ("lost", path.dissipated)):
        assert np.abs(log[column] - expected).max() <= limit * path.work.max(), column
    if "kept[3]" in log:  # p13 to p15
        assert np.abs(log["kept[3]"] - path.stored)[touching].max() <= limit * path.work.max()
        if path.dissipated.any():
            assert np.abs(log["kept[1]"] - path.maximum_overlap)[touching].max() <= limit * path.overlap.max()
            assert np.abs(log["kept[2]"] - path.plastic_overlap)[touching].max() <= limit * path.overlap.max()


LAWS = [
    ("hertz", "elastic", {}),
    ("rms", "hertz", {}),
    ("pohrt-popov", "thornton", {}),
    ("pohrt-popov", "table", {}),
    ("goddard", "hertz", {"slope": 0.035}),
    ("rough-plastic", "hertz", {"yield_pressure": 1.66e9}),
    ("rough-plastic", "hertz", {"yield_pressure": 0.4e9, "yield_at": "load", "bulk_radius": 9e-3}),
    ("rough-plastic", "thornton", {"yield_pressure": 1.66e9, "loading": "pohrt-popov"}),
    ("bahrami", "elastic", {}),
    ("yip-venart", "table", {}),
    ("greenwood-tripp", "elastic", {}),
    ("conical-damage", "thornton", {"strength": 0.5e9}),
    ("walton-braun", "linear", {}),
    ("luding", "linear", {"plasticity_depth": 2e-4}),
    ("eepa", "eepa", {}),
    ("jackson-green", "etsion", {"yield_strength": 0.1e9}),
    ("kogut-etsion", "etsion", {"yield_strength": 0.1e9}),
    ("jackson-green", "jackson", {"yield_strength": 0.1e9}),
]


@pytest.mark.parametrize("name, unloading, options", shared(LAWS, lambda law: law[0] not in ALIKE[1:]))
@both
def test_force_and_energies_are_the_laws(engine, granite_pair, name, unloading, options):
    """In LAMMPS also what `compute pair/local` shows of the contact."""
    law = example_law(name, granite_pair, unloading, **options)
    assert_same(*part(engine, "check").run_path(law), limit=1e-5)


@pytest.mark.parametrize(("unloading", "ranks", "newton"), [("hertz", 1, "off"), ("hertz", 2, "off"), ("table", 2, "on")])
@pytest.mark.parametrize("engine", ["lammps"])
def test_ranks_and_pairs_of_two_ranks(engine, granite_pair, unloading, ranks, newton):
    law = example_law("pohrt-popov", granite_pair, unloading)
    assert_same(*part(engine, "check").run_path(law, rtol=1e-8, ranks=ranks, newton=newton, every=20), limit=1e-7)


@both
def test_unequal_spheres_and_roughness_of_types(engine, tmp_path):
    """One table; σ by type: property/global surfaceRoughness, or by LAMMPS's mixing of like pairs with √2 times as much."""
    dl.law("pohrt-popov", ROUGH.with_values(sigma=1e-6), "hertz").tabulate(1e-8).save(tmp_path / "law.tbl")
    text = spheres(engine, "surfaceRoughness on", d1=10e-3, d2=17e-3)
    if engine == "lammps":
        words = "pair_coeff {0} {0} demlaws/table law.tbl 60.6e9 1.0 0.25 roughness {1!r} " + inputs_for_lammps.SHEAR
        lines = "\n".join(words.format(kind, math.sqrt(2) * sq) for kind, sq in ((1, 1e-6), (2, 2e-6)))
        text = inputs_for_lammps.two_spheres(lines, LOAD_UNLOAD, d1=10e-3, d2=17e-3)
    stone = dl.Material(young=60.6e9, poisson=0.25)
    sizes = {"radius1": 5e-3, "radius2": 8.5e-3, "roughness1": 1e-6, "roughness2": 2e-6}
    law = dl.law("pohrt-popov", dl.Contact.between(stone, stone, **sizes, fractal_dimension=2.22), "hertz")
    assert error_of(simulate(engine, tmp_path, text), law) <= 3e-8


@both
@pytest.mark.parametrize("restitution", [0.2, 0.8])
def test_damping_goes_by_the_tangent(engine, folder, law, restitution):
    """The extra force at constant speed is 2 √(5/6) |β| √(K m) v, with our K; none at the first touch."""
    elastic = law.joined("elastic")
    elastic.tabulate(rtol=1e-8).save(folder / "elastic.tbl")
    text = spheres(engine, "", [(-0.2, 0, 1000)], restitution=restitution, table="elastic.tbl", every=2)
    log = simulate(engine, folder, text)
    path = elastic.follow(log["overlap"])
    beta = math.log(restitution) / math.hypot(math.log(restitution), math.pi)
    damping = -2 * math.sqrt(5 / 6) * beta * np.sqrt(path.stiffness * sphere_mass(DIAMETER) / 2)
    touching = log["overlap"] > 0
    expected = path.force + 0.2 * damping * touching
    assert np.abs(log["force"] - expected)[1:].max() <= 1e-6 * expected.max()
    assert damping[touching][0] < 0.1 * damping.max()


@both
@pytest.mark.parametrize(
    ("rule", "ranks"), [("hertz", 1), ("hertz", 2), ("thornton", 2), pytest.param("table", 2, marks=pytest.mark.slow)]
)
def test_a_restart_in_mid_unloading_goes_on(engine, tmp_path, law, rule, ranks):
    """Force, energies, and what ended contacts had lost, of a pair on the border of two ranks."""
    law = example_law("pohrt-popov", law.contact, rule)
    law.tabulate(rtol=1e-8).save(tmp_path / "law.tbl")
    text = spheres(engine, "", [*LOAD_UNLOAD, (0.2, 0, 100)], left=-0.0087, ranks=ranks, **ENERGY)
    whole, rest = assert_goes_on(engine, tmp_path, text, [(-0.2, 0, 600), (0.2, 0, 1800)], ranks)
    assert energy_error_of(whole, law) <= 1e-7
    deepest = whole["overlap"][np.isin(whole["Step"], rest["Step"])].max()
    assert rest["e[2]"][0] > 1.1 * law.follow(np.array([deepest])).dissipated[0]


@both
def test_a_restart_file_within_a_run_has_its_last_step(engine, tmp_path, law):
    """LIGGGHTS saved the histories of the step before: the tangential force fell by its change in one step."""
    law.tabulate().save(tmp_path / "law.tbl")
    shear = (-0.05, 0.2, 300)
    text = spheres(engine, "", [(-0.2, 0, 1000)], **ENERGY)
    whole = simulate(engine, tmp_path, text + "restart 1100 now.*\n" + moves_of([shear]))
    (tmp_path / "now.1100").rename(tmp_path / "now.restart")
    rest = simulate(engine, tmp_path, continued(engine, text, [(*shear[:2], 200)], **ENERGY))
    rows = np.isin(whole["Step"], rest["Step"])
    for column in ("force", "side", "e[1]"):
        np.testing.assert_allclose(rest[column], whole[column][rows], rtol=1e-12, err_msg=column)


@both
def test_a_restart_with_a_table_made_again(engine, tmp_path, law):
    """The same law made again continues; another law, contact or range is refused."""
    table = tmp_path / "law.tbl"
    law.tabulate(max_force=100.0).save(table)
    text, moves = spheres(engine, "", [*LOAD_UNLOAD, (0.2, 0, 100)], **ENERGY), [(-0.2, 0, 600), (0.2, 0, 1800)]
    whole, rest = assert_goes_on(engine, tmp_path, text, moves, 1)
    first, contact = table.read_bytes(), law.contact
    again = dl.law(law.name, contact, law.unloading)
    again.tabulate(max_force=100.0).save(table)
    assert table.read_bytes() == first  # on every processor: tests/curves/test_same_bytes.py
    same = simulate(engine, tmp_path, continued(engine, text, moves, **ENERGY))
    np.testing.assert_allclose(same["force"], rest["force"], rtol=0, atol=1e-12 * whole["force"].max())
    others = {"sigma": 1.001 * contact.sigma, "modulus": 1.001 * contact.modulus, "fractal_dimension": 2.221}
    for other in (
        *(dl.law(law.name, contact.with_values(**{name: value}), law.unloading) for name, value in others.items()),
        dl.law(law.name, contact, "thornton"),
        dl.law("goddard", contact, "hertz", slope=0.035),
        dl.law("rough-plastic", contact, "hertz", yield_pressure=1.66e9),
    ):
        other.tabulate(max_force=100.0).save(table)
        assert re.search(REFUSED, refused(engine, tmp_path, continued(engine, text, moves)))
    law.tabulate(max_force=300.0).save(table)
    assert re.search(REFUSED, refused(engine, tmp_path, continued(engine, text, moves)))


# --- limits of laws and tables


@pytest.mark.parametrize("engine, ranks", [("liggghts", 1), ("lammps", 1), ("lammps", 2)])
def test_overlaps_that_no_law_holds_for_are_told(engine, tmp_path, ranks):
    """Beyond a tenth of R one warning, and a count in each run; on two ranks both have the pair. Beyond R a stop."""
    dl.law("hertz", dl.Contact(4e-3, modulus(60.6e5))).tabulate(rtol=1e-8).save(tmp_path / "law.tbl")
    soft = {"d1": 16e-3, "d2": 16e-3, "young": 60.6e5, "left": -8e-3, "ranks": ranks, "every": 1}
    if engine == "lammps":  # what a compute asks is not counted
        soft["more"] = "compute c all pair/local p13 force cutoff radius\ncompute k all reduce sum c_c[1] inputs local"
        soft["columns"] = "c_k"
    log = simulate(engine, tmp_path, spheres(engine, "", [*PRESS, (20, 0, 100), (0, 0, 50)], **soft), ranks)
    said = said_in(engine, tmp_path)
    found = counts(said, "deeper than a tenth of R")
    deep = np.sum(log["overlap"][1:1001] > 0.1 * 4e-3)
    assert (
        deep > 500
        and found[0] // deep in (1, ranks)
        and found[0] == pytest.approx(found[0] // deep * deep, abs=2)
        and found[1:] == [n * (found[0] // deep) for n in (100, 50)]
    )
    assert said.count("reported once") <= 1 and (ranks > 1 or "effective radius R = 0.004 m" in said)
    simulate(engine, tmp_path, spheres(engine, "", [(-20, 0, 10)], **soft), ranks)
    assert "deeper" not in said_in(engine, tmp_path)
    if ranks == 1:
        deeper = [(-20, 0, 5000)]
        message = refused(engine, tmp_path, spheres(engine, "", deeper, **soft))
        assert "times the effective radius R = 0.004 m" in message and "extrapolation on" in message
        log = simulate(engine, tmp_path, spheres(engine, "extrapolation on", deeper, **soft))
        overlap, force = (log[name][log["overlap"] > 0.004] for name in ("overlap", "force"))
        assert overlap.size > 100
        np.testing.assert_allclose(force, 4 / 3 * modulus(60.6e5) * np.sqrt(4e-3) * overlap**1.5, rtol=1e-7)


@pytest.mark.parametrize("name", ["rms", "hertz", "pohrt-popov", "bahrami"])
@both
def test_limits_of_the_law_are_those_of_python(engine, tmp_path, granite_pair, name):
    """As many steps as there are forces outside of `law.limits()`, and one warning per limit with its reason."""
    smooth = {"sigma": 0.0} if name == "hertz" else {}  # of a rough contact it has a second limit
    law = dl.law(name, granite_pair.with_values(modulus=modulus(), **smooth), unloading="elastic")
    law.tabulate().save(tmp_path / "law.tbl")
    yields = name in ("hertz", "pohrt-popov")
    where = "above the load at which the bulk yields" if yields else "below the range of force of their law"
    speed = 4.8 if yields else 0.2
    log = simulate(engine, tmp_path, spheres(engine, "", [(-speed, 0, 1000), (speed, 0, 500)], every=1))
    said, force = said_in(engine, tmp_path), log["force"][np.diff(log["Step"], prepend=-1.0) > 0]
    limits = [limit for limit in law.limits() if limit.reason in said]
    assert len(limits) == said.count("reported once") == (2 if name == "rms" else 1)
    outside = [(force > limit.maximum_force) | ((force > 0) & (force < limit.minimum_force)) for limit in limits]
    expected = sum(int(each.sum()) for each in outside)
    assert expected > 0 and sum(counts(said, where)) == pytest.approx(expected, abs=3)
    assert "worst: particles 1 and 2" in said


@both
def test_beyond_the_table_extrapolation_is_the_last_power_law(engine, tmp_path, law):
    """Refused with particles, file and remedies; where it is allowed, warned of once and counted."""
    elastic = law.joined("elastic")
    table = elastic.tabulate(max_force=10.0)
    table.save(tmp_path / "law.tbl")
    message = refused(engine, tmp_path, spheres(engine, "", LOAD_UNLOAD))
    assert re.search("particles (1 and 2|2 and 1)", message)
    assert all(words in message for words in ("law.tbl", "--max-force", "time step", "extrapolation on"))
    log = simulate(engine, tmp_path, spheres(engine, "extrapolation on", [(-0.2, 0, 1000)], every=1))
    last = float(table.overlap(table.largest_force))
    beyond = log["overlap"] > 1.001 * last
    exponent = float(table.stiffness(last)) * last / table.largest_force
    expected = table.largest_force * (log["overlap"][beyond] / last) ** exponent
    assert beyond.sum() > 100 and np.abs(log["force"][beyond] / expected - 1).max() < 1e-6
    said = said_in(engine, tmp_path)
    assert said.count("its last power law goes on") == 1
    assert sum(counts(said, "beyond the last row")) == pytest.approx(beyond.sum(), abs=3)


@both
def test_a_law_that_does_not_collapse_holds_for_its_radius_and_modulus(engine, tmp_path, granite_pair):
    contact = granite_pair.with_values(modulus=modulus())
    law = dl.law("rough-plastic", contact, unloading="hertz", yield_pressure=1.66e9)
    law.tabulate().save(tmp_path / "law.tbl")
    assert error_of(simulate(engine, tmp_path, spheres(engine)), law) <= 1e-5
    assert "does not collapse" in refused(engine, tmp_path, spheres(engine, d1=17e-3, d2=12e-3))
    simulate(engine, tmp_path, spheres(engine, "radius_tolerance 0.5", d1=17e-3, d2=12e-3))
    assert "modulus" in refused(engine, tmp_path, spheres(engine, young=30e9))
    rough = {"liggghts": "surfaceRoughness on", "lammps": "roughness 1e-6"}[engine]
    assert "roughness" in refused(engine, tmp_path, spheres(engine, rough))


@both
def test_a_box_so_thin_that_histories_are_mixed_up_is_told(engine, folder):
    """Two spheres of 17.4 mm that touch through both sides have two histories with the same two numbers."""
    for width, told in ((0.034, True), (0.036, False)):
        text = re.sub("boundary .*", "boundary f p f", spheres(engine, "", [(-0.2, 0, 2)]))
        text = text.replace("-0.02 0.02 -0.02 0.02 units box", f"{-width / 2} {width / 2} -0.02 0.02 units box")
        simulate(engine, folder, text)
        assert (f"the box is {width} long in y, where it is periodic" in said_in(engine, folder)) == told


# --- files


@both
@pytest.mark.parametrize(("file", "ranks"), [("nowhere.tbl", 1), ("/dev/null", 2), (".", 1)])
def test_what_is_no_table_stops_every_rank(engine, tmp_path, file, ranks):
    assert file in refused(engine, tmp_path, spheres(engine, "", LOAD_UNLOAD[:1], table=file, ranks=ranks), ranks)


@both
@pytest.mark.parametrize("case", ["rank 1 has none", "rank 1 has another", "rank 0 has none"])
def test_the_table_is_that_of_rank_0(engine, folder, granite_pair, case):
    """The pair lies on the border of the ranks. Where rank 0 has none, all stop: none hangs (the timeout is the test)."""
    text = spheres(engine, "", [(-0.2, 0, 500)], left=-0.0087, ranks=2, **({"newton": "off"} if engine == "lammps" else {}))
    dl.law("hertz", granite_pair).tabulate().save(folder / "other.tbl")
    elsewhere = {
        "rank 0 has none": {"in.case": text.encode()},
        "rank 1 has another": {"law.tbl": (folder / "other.tbl").read_bytes()},
    }
    done = started(engine, folder, text, 2, away=int(case != "rank 0 has none"), elsewhere=elsewhere.get(case))
    if case == "rank 0 has none":
        assert done.returncode and "law.tbl" in done.stdout + done.stderr
    else:
        assert done.returncode == 0, done.stdout[-800:] + done.stderr[-800:]
        force = part(engine, "run").read_log(folder / f"log.{engine}")["force"]
        assert np.array_equal(force, simulate(engine, folder, text, 2)["force"])
