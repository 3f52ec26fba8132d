"""A bed of ballast under cyclic load: known fits, a short run that continues after an interruption, kept results."""

import csv
from pathlib import Path

import numpy as np
import pytest
from making.apart import cells

from studies import paired
from studies.assembly.study import read
from studies.ballast import bed, beds, cycles, report
from studies.ballast.__main__ import QUICK, main


def test_a_case_has_its_rule_of_unloading(tmp_path):
    for rule in ("hertz", "elastic"):
        cycles.Case(law="pohrt-popov", sigma=2.4, rule=rule).contact.save(tmp_path / "pair.tbl")
        assert f"unloading: {rule}" in (tmp_path / "pair.tbl").read_text().splitlines()
    assert {case.rule for case in cycles.control()} == {"hertz", "elastic"}


def rows_of(settled, last=200):
    number = np.unique(np.round(np.geomspace(1, last, 40)))
    return [{"cycle": n, "cycles": last, "settlement_um": settled(n)} for n in number]


def test_laws_of_settlement_are_found():
    logarithmic = report.fit(rows_of(lambda n: 50.0 + 120.0 * np.log10(n)))
    assert logarithmic.slope == pytest.approx(120.0) and logarithmic.logarithmic < 1e-9 < 1e-2 < logarithmic.power
    power = report.fit(rows_of(lambda n: 40.0 * n**0.3))
    assert power.exponent == pytest.approx(0.3) and power.power < 1e-9 < 1e-2 < power.logarithmic


def test_the_exponent_of_a_known_modulus_is_found():
    pressures = 1e-3 * np.array(cycles.STAGES)
    stages = [
        {"cycle": 201, "cycles": 200, "high_kPa": p, "peak_kPa": p, "least_kPa": 20.0, "height_mm": 300.0}
        | {"resilient_um": 300.0 * (p - 20.0) / (10.0 * p**0.4)}
        for p in pressures
    ]
    assert report.modulus_exponent(stages) == pytest.approx(0.4)
    for row in stages:
        row["resilient_um"] = row["peak_kPa"] ** 0.55 - 20.0**0.55
    assert report.tangent_exponent(stages) == pytest.approx(0.45)


def test_solid_share_of_spheres_in_a_layer():
    """A sphere inside, one that the layer's lower face halves, one above."""
    grains = np.array([[n, 0.04, 2650.0, 0.1 * n, 0.0, z] for n, z in enumerate((0.1, 0.03, 0.3))])
    volume = np.pi / 6 * 0.04**3
    assert beds.solid(grains) == pytest.approx(1.5 * volume / (0.11 * 0.3**2))


def test_plastic_work_counts_contacts_that_end_and_begin_again(tmp_path):
    """Pair 1-2 flows by 3, ends, and begins again with 1; pair 1-3 was there with 5 and flows by 2."""
    frames = [["1 3 5"], ["1 3 5", "1 2 3"], ["1 3 7"], ["2 1 1"]]
    text = "".join(f"ITEM: TIMESTEP\n{n}\nITEM: ENTRIES c f\n" + "\n".join(lines) + "\n" for n, lines in enumerate(frames))
    (tmp_path / "flow.txt").write_text(text)
    assert cycles.plastic(tmp_path / "flow.txt") == pytest.approx([3.0, 2.0, 1.0])


@pytest.mark.slow
@pytest.mark.lammps
def test_without_damping_contacts_dissipate_the_whole_loss(tmp_path, monkeypatch):
    """The work of the plate, less what is stored, is friction and plastic flow."""
    monkeypatch.setattr(bed, "RESTITUTION", 1.0)
    for shear in ("default", "slip"):
        case = cycles.Case(law="pohrt-popov", sigma=2.4, shear=shear, cycles=2, count=80)
        rows = [row for row in cycles.run_case(case, tmp_path) if "rest_J" in row]
        assert len(rows) == 5
        for row in rows:
            assert 0.0 <= row["plastic_J"] < row["dissipated_J"]
            assert abs(row["rest_J"]) < 0.03 * row["dissipated_J"] + 1e-5


@pytest.fixture(scope="module")
def quick(tmp_path_factory):
    folder = tmp_path_factory.mktemp("ballast")
    line = ["--quick", "--results", str(folder / "cycles.csv"), "--store", str(folder)]
    assert main(line) == 0
    return line, folder


@pytest.mark.slow
@pytest.mark.lammps
def test_the_plate_carries_its_load_and_energy_is_lost(quick):
    rows = read(quick[1] / "cycles.csv")
    assert {row["law"] for row in rows} == {"hertz", "pohrt-popov"}
    for row in rows:
        assert row["peak_kPa"] == pytest.approx(row["high_kPa"], rel=0.05)
        assert row["least_kPa"] == pytest.approx(20.0, abs=4.0)
        assert row["work_J"] > abs(row["loss_J"])
    for beds_of_kind in report.series(rows, least=5, count=80).values():
        for one in beds_of_kind.values():
            assert sum(row["loss_J"] for row in one) > 0.0
            assert 0.1 < report.modulus_exponent(one) < 0.6


@pytest.mark.slow
@pytest.mark.lammps
def test_an_interrupted_case_continues_with_the_same_result(quick, monkeypatch):
    line, folder = quick
    before, file = (folder / "cycles.csv").read_text(), folder / "cycles.csv"
    assert main(line) == 0 and file.read_text() == before  # nothing is missing, nothing is run

    def stop(text):
        if "cycle 5," in text:
            raise KeyboardInterrupt

    case = QUICK[0]
    (folder / "-".join(map(str, case)) / "state.json").unlink()
    with pytest.raises(KeyboardInterrupt):
        cycles.run_case(case, folder, stop)
    parts = []
    again = cycles.run_case(case, folder, parts.append)
    assert len(parts) == len(cycles.STAGES)  # those that the interruption left
    kept = [row for row in read(file) if row["law"] == "hertz"]
    assert [row["settlement_um"] for row in again] == pytest.approx([row["settlement_um"] for row in kept], rel=1e-4)


@pytest.mark.slow
@pytest.mark.lammps
def test_the_step_is_below_the_limit_of_the_loaded_bed(quick, capsys):
    assert main([*quick[0], "--limit"]) == 0
    limits = [float(line.split()[2]) for line in capsys.readouterr().out.splitlines() if line.startswith("exact limit")]
    assert len(limits) == len(QUICK) and all(1.2 * QUICK[0].dt < limit < 5.0 * QUICK[0].dt for limit in limits)


CLEAR = {
    "law: pohrt-popov, σ = 2.4 µm, for hertz": {"settlement, N = 1 (µm)"},
    "the same, clumps": {"settlement, N = 1 (µm)", "N = 1 to 200 (µm)", "dissipated in cycle 1 (mJ)"},
    "roughness: σ = 10 µm for 2.4 µm": {"dissipated in cycle 1 (mJ)", "later (mJ)"},
    "shape: clumps for spheres, hertz": {"N = 1 to 200 (µm)", "M (MPa)", "later (mJ)"},
    "shape: clumps for spheres, pohrt-popov": {"N = 1 to 200 (µm)", "M (MPa)", "later (mJ)"},
}
"""Effects that Benjamini & Hochberg's procedure finds."""


def test_what_the_page_claims():
    """Effects by pairs of beds that begin from the same places."""
    found = report.series(read(cycles.RESULTS))
    effects = {
        what: {n: report.effect(found, pairs, f) for n, f in report.MEASURES.items()} for what, pairs in report.EFFECTS.items()
    }
    names = [(what, measure) for what, measures in effects.items() for measure in measures]
    bold = paired.clear([effects[what][measure] for what, measure in names])
    found_clear = {}
    for (what, measure), is_clear in zip(names, bold, strict=True):
        if is_clear:
            found_clear.setdefault(what, set()).add(measure)
    assert found_clear == CLEAR
    first = effects["law: pohrt-popov, σ = 2.4 µm, for hertz"]["settlement, N = 1 (µm)"]
    assert first[:3] == pytest.approx((0.305, 0.258, 0.354), abs=5e-3) and first.samples == 3
    clumps = effects["the same, clumps"]["N = 1 to 200 (µm)"]
    assert clumps[:3] == pytest.approx((0.336, 0.280, 0.396), abs=5e-3)
    rough = [(a, b) for what in report.EFFECTS for a, b in report.EFFECTS[what] if "shear" not in what and a.sigma < b.sigma]
    later = report.MEASURES["later (mJ)"]
    more = [later(found[b][seed]) > later(found[a][seed]) for a, b in rough for seed in found[a].keys() & found[b].keys()]
    assert more == [True] * 8  # a rougher bed dissipates more in later cycles, in every pair
    for kind, beds_of_kind in found.items():
        for bed_of_kind in beds_of_kind.values():
            assert 0.33 < report.tangent_exponent(bed_of_kind) < 0.45
            shares = report.dissipation(bed_of_kind)
            assert np.isnan(shares.friction) or shares.friction > 85.0, kind


def test_what_the_page_claims_of_the_rule_of_unloading():
    found, first = report.series(read(cycles.CONTROL)), report.measures(cycles.SPLIT)["settlement, N = 1 (µm)"]
    changes = {what: report.effect(found, pairs, first) for what, pairs in report.CONTROL.items()}
    clumps = [changes[f"clumps: σ = 2.4 µm for smooth, rule {rule}"] for rule in ("hertz", "elastic")]
    assert [one[:3] for one in clumps] == [pytest.approx(span, abs=5e-3) for span in ((0.58, 0.46, 0.71), (0.17, 0.13, 0.21))]
    for rule in ("hertz", "elastic"):
        spheres = changes[f"spheres: σ = 2.4 µm for smooth, rule {rule}"]
        assert spheres.samples == 5 and spheres.low < 0.0 < spheres.high
    ratios = [
        [first(one[kind][seed]) for kind in (report.BASE, report.ROUGH)]
        for one in (report.series(read(cycles.RESULTS)), found)
        for seed in one[report.BASE].keys() & one[report.ROUGH].keys()
    ]
    together = paired.change(*np.transpose(ratios))  # not clear among 48: p is 0.02
    assert together[:5] == pytest.approx((0.19, 0.03, 0.38, 8, 0.02), abs=6e-3)
    smooth = [first(one) for one in found[report.BASE].values()]
    assert (min(smooth), max(smooth)) == pytest.approx((28, 85), abs=0.5)


def test_laws_fitted_to_200_cycles_fall_short_of_2000():
    for one in report.longest(read(cycles.RESULTS)).values():
        logarithmic, power = np.array(report.fit(one, 200.0).at(2000.0)) / report.settlement(one, 2000.0)
        assert logarithmic < 0.45 and 0.6 < power < 0.85
        law = report.fit(one)
        assert law.power < 0.05 < law.logarithmic and 0.45 < law.exponent < 0.9


def test_one_bed_of_clumps_settles_faster_and_faster():
    """Packings and shear as in the control."""
    found = report.longest(read(cycles.LONG))
    expected = {
        1: ((0.44, 1.86), 0.121, (0.14, 0.16), (7.9, 7.0), 1.28),
        2: ((0.48, 0.56), 0.312, (0.37, 0.46), (8.1, 7.6), 1.15),
    }
    assert list(found) == list(expected)
    for seed, (exponents, share, fits, counts, growth) in expected.items():
        one = found[seed]
        number, settled = report.main_cycles(one)
        assert number[-1] == 2000 and report.kind_of(cycles.case_of(one[0])) == report.ROUGH_CLUMPS
        for part, exponent in zip(((number >= 200) & (number <= 858), number >= 858), exponents, strict=True):
            assert np.polyfit(np.log(number[part]), np.log(settled[part]), 1)[0] == pytest.approx(exponent, abs=0.01)
        assert report.settlement(one, 200) / settled[-1] == pytest.approx(share, abs=2e-3)
        assert np.array(report.fit(one, 200.0).at(number[-1])) / settled[-1] == pytest.approx(fits, abs=6e-3)
        contacts, resilient = (
            [float(row[name]) for row in one if row["high_kPa"] == 200.0] for name in ("contacts", "resilient_um")
        )
        assert (contacts[0], contacts[-1]) == pytest.approx(counts, abs=0.05)
        assert resilient[-1] / resilient[0] == pytest.approx(growth, abs=0.02)
        before = report.series(read(cycles.CONTROL))[report.ROUGH_CLUMPS][seed]
        assert report.settlement(one, 30) == pytest.approx(report.settlement(before, 30), rel=0.02)  # other machine code


def test_file_and_table_of_the_page_are_those_of_the_kept_runs(tmp_path):
    file = Path(__file__).parents[2] / "docs" / "validation" / "ballast.csv"
    page = file.with_suffix(".md").read_text()
    assert report.effects(read(cycles.RESULTS)) in page
    control = report.effects(read(cycles.CONTROL), report.CONTROL, cycles.SPLIT).splitlines()
    with (file.parents[1] / "tables" / "ballast-control.csv").open() as table:
        assert [cells(line) for k, line in enumerate(control) if k != 1] == list(csv.reader(table))
    made = report.save(read(cycles.RESULTS), read(cycles.REPEATS), tmp_path / "beds.csv")
    assert Path(made).read_text() == file.read_text()
    labels = {row["settings"] for row in read(file)}
    assert labels == {*cycles.SENSITIVITY, "as in the study, repetition"}


def test_beds_differ_by_their_state():
    """From one state both models sink alike; a bed deposited with the default is looser."""
    kept = {(row["deposited"], row["loaded"]): row for row in read(beds.RESULTS)}
    assert kept["default", "default"]["solid"] < kept["mindlin", "mindlin"]["solid"]
    for deposited in beds.LOADED:
        sunk = [kept[deposited, loaded]["sunk_mm"] for loaded in beds.LOADED]
        assert max(sunk) < 1.25 * min(sunk)
