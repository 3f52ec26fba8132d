"""Small-strain stiffness of packings: known lattices, power laws, LAMMPS, and the kept results."""

from pathlib import Path

import numpy as np
import pytest

from studies import paired
from studies.assembly import attenuation, probe, report, study
from studies.assembly.__main__ import main
from studies.assembly.packing import Contacts
from studies.assembly.stiffness import Linear, first_loading

DIAMETER, K, RATIO = 1e-3, 1e6, 0.8


def lattice(force=1.0, unloading=K, across=3):
    """`Contacts` of a simple cubic lattice in a periodic box, and the box [m]."""
    cells = np.argwhere(np.ones((across,) * 3))
    number = np.arange(across**3).reshape((across,) * 3)
    pairs, normals = [], []
    for axis in np.eye(3, dtype=int):
        pairs += [(number[tuple(cell)], number[tuple((cell + axis) % across)]) for cell in cells]
        normals += [axis] * len(cells)
    same = np.ones(len(pairs))
    contacts = Contacts(
        np.array(pairs), np.array(normals, float), DIAMETER * same, force * same, K * same, unloading * same, 0.0 * same
    )
    return contacts, np.full(3, across * DIAMETER)


def test_a_cubic_lattice_has_its_known_moduli():
    """M = K/d along its axes; G = K_t/(2 d): the grains turn by half the shear angle."""
    contacts, size = lattice()
    found = Linear(contacts, size, contacts.stiffness, RATIO * contacts.stiffness).moduli()
    assert found.along == pytest.approx(K / DIAMETER) and found.longitudinal == pytest.approx(K / DIAMETER)
    assert found.across == pytest.approx(0.5 * RATIO * K / DIAMETER) and found.bulk == pytest.approx(K / (3 * DIAMETER))


def test_forces_carried_soften_the_shear_of_a_lattice():
    """Simple shear γ turns the contacts along z: -P/d in addition to the shear springs, with grains that turn freely."""
    contacts, size = lattice(force=50.0)
    linear = Linear(contacts, size, contacts.stiffness, RATIO * contacts.stiffness, contacts.force)
    gradient = np.zeros((3, 3))
    gradient[0, 2] = 1.0
    assert linear.modulus(gradient) == pytest.approx(0.5 * RATIO * K / DIAMETER - 50.0 / DIAMETER**2)


def test_a_first_step_takes_the_stiffness_of_loading_where_contacts_close():
    contacts, size = lattice(unloading=3.0 * K)
    for sign, stiffness in ((-1.0, K), (1.0, 3.0 * K)):
        strain = sign * np.diag([0.0, 0.0, 1.0])
        assert first_loading(contacts, size, RATIO, strain) == pytest.approx(stiffness / DIAMETER)


def test_exponents_of_power_laws_are_found():
    pressure = np.geomspace(10.0, 1000.0, 5)
    rows = [{"kPa": p, "M": p**0.7, "G": 2.0 * p**0.5, "solid": 0.6} for p in pressure]
    assert report.exponent(rows, "M") == pytest.approx(0.7)
    assert report.exponent(rows, "G", report.LOW, speed=True) == pytest.approx(0.25)


def test_a_clump_turns_as_one_body():
    """Two clumps of each two spheres, side by side: turned together, no spring elongates."""
    arms = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]] * 2)
    contacts = Contacts(
        np.array([[0, 2], [1, 3]]), np.eye(3)[[0, 0]], 2.0 * np.ones(2), *[np.ones(2)] * 4, np.array([0, 0, 1, 1]), arms, 1.0
    )
    linear = Linear(contacts, np.full(3, 10.0), contacts.stiffness, contacts.stiffness)
    spin = np.array([0.3, -0.2, 0.5])
    motion = np.zeros((2, 6))
    motion[:, 3:] = spin / np.sqrt(2.5)
    motion[:, :3] = np.cross(spin, [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    assert linear.matrix @ motion.ravel() == pytest.approx(0.0, abs=1e-12)
    motion[1, 3:] = 0.0
    assert np.abs(linear.matrix @ motion.ravel()).max() > 0.1


@pytest.mark.slow
def test_moduli_of_clumps_agree_with_small_strains(tmp_path):
    probe.run_probes(60, tmp_path / "probes.csv", tmp_path, [study.Series(bead=study.CLUMPS, law="pohrt-popov", sigma=0.5)])
    rows = study.read(tmp_path / "probes.csv")
    assert {row["modulus"] for row in rows} == set(probe.PUSHED)
    for row in rows:
        assert row["linear"] == pytest.approx(row["engine"], rel=2e-3)


@pytest.fixture(scope="module")
def quick(tmp_path_factory):
    folder = tmp_path_factory.mktemp("assembly")
    line = ["--quick", "--results", str(folder / "moduli.csv"), "--store", str(folder)]
    assert main(line) == 0
    return line, study.read(folder / "moduli.csv")


@pytest.mark.slow
def test_a_quick_run_with_the_contacts_kept_has_the_exponent_of_one_contact(quick):
    """1/3 with Hertz; below its threshold Pohrt-Popov has K ∝ P^(0.2567 Df). New contacts add to both."""
    for case, series in report.cases(quick[1]).items():
        found, (isotropic,) = report.exponents(series), [rows for (path, _), rows in series.items() if path == "isotropic"]
        single = 1 / 3 if case.law == "hertz" else 0.2567 * 2.2
        assert found["G_frozen"][0] == pytest.approx(single, abs=1e-3)
        assert found["G"][0] > found["G_frozen"][0]
        assert found["G_hertz"][0] == pytest.approx(1 / 3, abs=0.03)
        assert isotropic[-1]["side_kPa"] == pytest.approx(1000.0, rel=5e-3)


@pytest.mark.slow
def test_a_second_run_adds_nothing(quick, capsys):
    line, rows = quick
    assert main(line) == 0
    assert len(study.read(line[2])) == len(rows) == 4 * len(study.PRESSURES) and "| glass, hertz |" in capsys.readouterr().out


def test_a_state_is_in_balance_under_its_law(tmp_path):
    series = study.Series(law="pohrt-popov", sigma=0.5, count=200)
    ((pressure, packing),) = study.states(series, [10e3], tmp_path)
    assert packing.stress == pytest.approx(np.full(3, pressure), rel=5e-3)
    contacts = packing.carrying()
    force = series.bound().force(DIAMETER - contacts.length)  # after the last, tiny motion
    assert contacts.force == pytest.approx(force, abs=1e-3 * force.mean())
    assert contacts.shear.max() <= 1.0 + 1e-9


def test_moduli_of_other_shear_stiffness(tmp_path):
    """At the ratio of ν those of the state itself; a smaller ratio leaves less of the shear modulus than of M."""
    full = study.BEADS["granite"].shear_ratio
    (_, first, across), (_, less, turned) = study.at_ratios((full, 0.3), 60, tmp_path)
    (row,) = study.rows(study.Series(bead="granite", law="pohrt-popov", sigma=2.0, count=60), (1e5,), tmp_path)
    assert (first, across) == pytest.approx((row["M"], row["G"]))
    assert 0.3 / full < turned / across < less / first < 1.0


@pytest.mark.slow
@pytest.mark.lammps
def test_moduli_agree_with_small_strains_in_lammps(tmp_path):
    probe.run_probes(200, tmp_path / "probes.csv", tmp_path, [study.Series(law="pohrt-popov", sigma=0.5)])
    for row in study.read(tmp_path / "probes.csv"):
        assert row["exact"] == pytest.approx(row["engine"], rel=5e-4) and row["linear"] == pytest.approx(
            row["engine"], rel=2e-3
        )


def test_what_the_page_claims():
    """Smooth contacts and flattened asperities have exponents below the measured ones, elastic asperities reach them."""
    found = report.cases([row for row in study.read() if row["count"] == 1000])
    g0 = {case: report.exponents(s) for case, s in found.items() if any(path == "isotropic" for path, _ in s)}
    waves = {case: report.speeds(s) for case, s in found.items() if any(path == "oedometric" for path, _ in s)}
    low, high = report.ALLOWED["G0"]
    for case, values in g0.items():
        assert values["G_hertz"][0] < 0.41 < low, case
        assert values["G"][0] - values["G_frozen"][0] < (0.02 if case.packing == "dense" else 0.08), case
    rough = [values["G"][0] for case, values in g0.items() if case.law != "hertz"]
    assert min(rough) < low and max(rough) > high
    smooth = [values for case, values in waves.items() if case.law == "hertz"]
    for speed in ("c_L", "c_T"):
        assert max(values[speed][0] for values in smooth) < 0.2 < report.MEASURED[speed]
    measured = report.MEASURED["c_L"] - report.MEASURED["c_T"]
    assert max(values["c_L"][0] - values["c_T"][0] for values in waves.values()) < 0.07 < measured
    assert min(report.speeds(found[case], "_tenth")["ratio"][0] for case in waves) > 1.95


def test_exponents_of_attenuation_are_found():
    """α at one frequency is the share of a cycle over the speed."""
    pressures = np.array([10.0, 20.0, 100.0])
    about = [{"kPa": p, "seed": seed, "speed": 50.0 * p**0.2} for p in pressures for seed in (1, 2)]
    for kind, expected in (("pulse", -0.6), ("cycle", -0.8)):
        lines = [line | {"kind": kind, "share": line["seed"] * line["kPa"] ** -0.6} for line in about]
        assert attenuation.exponent(lines) == pytest.approx((expected, 0.0), abs=1e-12)


@pytest.mark.slow
@pytest.mark.lammps
def test_larger_waves_lose_a_larger_share(tmp_path):
    """Partial slip takes energy from a cycle of strain, more of a larger one; its modulus is that of the packing."""
    model = attenuation.Model(shear="slip")
    found = [row for row in attenuation.cycles(model, tmp_path, 60, (1e5,)) if row["axis"] == "z"]
    assert 0.0 < found[0]["share"] < found[1]["share"] < 2.0
    assert 0.0 < found[0]["dissipated"] < 0.05  # no stored energy is lost in a small cycle of a loaded packing
    packing = attenuation.at_rest(model, 1e5, tmp_path, 60)
    pulses = [attenuation.pulse(model, packing, 1e5, "z", speed) for speed in attenuation.SPEEDS]
    assert 0.0 < pulses[0]["share"] < pulses[1]["share"] < 0.1
    assert found[0]["modulus_MPa"] == pytest.approx(pulses[0]["modulus_MPa"], rel=0.3)


def test_attenuation_of_kept_waves():
    """The measured exponent is excluded, but in small pulses and in one larger cycle of rough elastic contacts."""
    found = {}
    for row in study.read(attenuation.RESULTS):
        found.setdefault(tuple(row[name] for name in attenuation.WAVE), []).append(row)
    estimates = attenuation.intervals(found)
    more = [estimates.pop(wave) for wave in list(estimates) if "springs" in wave[0]]
    assert len(more) == 4 and sum(one.high < attenuation.MEASURED for one in more) == 2
    assert len(estimates) == 39 and {one.samples for one in estimates.values()} == {4}
    flattened = {wave: one for wave, one in estimates.items() if wave[4] == "hertz"}
    assert len(flattened) == 8 and max(one.high for one in flattened.values()) < -0.35
    small = min(attenuation.SPEEDS)
    smooth = {wave: one for wave, one in estimates.items() if wave[1] == "hertz"}
    assert all((one.high < -0.19) == (wave[-1] != small) for wave, one in smooth.items())
    excluded = dict(zip(estimates, paired.clear(estimates.values()), strict=True))
    rough = [wave for wave in estimates if wave[1] != "hertz" and wave[4] == "elastic" and wave[0] == "cycle"]
    assert sum(not excluded[wave] for wave in rough) == 1
    assert {w: bool(clear) for w, clear in excluded.items()} == {w: one.high < -0.1879 for w, one in estimates.items()}
    assert sum(excluded.values()) == 30


def test_kept_waves_with_other_settings():
    """Twice as many springs, half the step and half the speed change small shares of cycles by a third at most."""
    shares = {}
    for row in study.read(attenuation.RESULTS):
        motion, _, setting = row["kind"].partition(", ")
        if row["shear"] == "slip" and row["seed"] == 1:
            wave = (motion, *(row[name] for name in ("law", "rule", "kPa", "axis", "amplitude")))
            shares.setdefault(wave, {})[setting] = row["share"]
    ratios = {}
    for found in shares.values():
        for setting, share in found.items():
            if setting and "" in found:
                ratios.setdefault(found[""] > 0.1, []).append(share / found[""])
    assert len(ratios[True]) == 12 and max(abs(ratio - 1.0) for ratio in ratios[True]) < 0.032
    assert len(ratios[False]) == 29 and max(abs(ratio - 1.0) for ratio in ratios[False]) < 0.31


def test_kept_probes_and_settings_agree():
    for row in study.read(probe.RESULTS):
        if row["bead"] == study.CLUMPS:
            assert row["linear"] == pytest.approx(row["engine"], rel=1e-3)
            continue
        assert row["exact"] == pytest.approx(row["engine"], rel=1.5e-4 if row["strain"] < 5e-6 else 1e-3)
        assert row["linear"] == pytest.approx(row["engine"], rel=1.6e-3)
    rows = study.read(study.SENSITIVITY)
    for packing, path in (("dense", "isotropic"), ("dense", "oedometric"), ("loose", "oedometric")):
        one = [
            [row for row in rows if (row["settings"], row["packing"], row["path"]) == (s, packing, path)]
            for s in study.SETTINGS
        ]
        for column in ("M", "G"):
            assert np.ptp([report.exponent(some, column) for some in one]) < 2.5e-3


def test_the_file_of_the_page_is_that_of_the_kept_runs(tmp_path):
    file = Path(__file__).parents[2] / "docs" / "validation" / "small-strain.csv"
    assert Path(report.save(study.read(), tmp_path / "exponents.csv")).read_text() == file.read_text()


def test_exponents_of_3000_spheres_are_those_of_1000():
    found = report.cases(study.read())
    large = [case for case in found if case.count == 3000]
    assert len(large) >= 6
    for case in large:
        more, fewer = (report.numbers(found[one]) for one in (case, case._replace(count=1000)))
        for name, limit in (("G0, tangent", 2e-3), ("c_L, tangent", 4e-3), ("c_T, tangent", 4e-3)):
            assert more[name][0] == pytest.approx(fewer[name][0], abs=limit), (case, name)


def test_the_picture_shows_all_laws():
    fig = report.draw([row for row in study.read() if row["count"] == 1000])
    labels = {text.get_text() for ax in fig.axes for text in (ax.get_legend().get_texts() if ax.get_legend() else ())}
    assert {"pohrt-popov, one contact", "rms, one contact", "hertz, dense packing", "glass, loose packing"} <= labels
