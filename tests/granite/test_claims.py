"""Claims: the logic of verdicts, the records, and the numbers that test them against formulas written out here."""

import math

import numpy as np
import pytest
from making import measured

import demlaws as dl
from demlaws import granite
from demlaws.granite import claims, quantities as q
from demlaws.granite.verdicts import (
    BUILT_IN,
    NOT_REPRODUCED,
    REPRODUCED,
    UNDECIDED,
    Claim,
    Criterion,
    built_in,
    counts,
    judge,
    near,
    undecided,
)
from studies.jamari.claims import CLAIMS, asperity_counts

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")
RECORDS = (*claims.SPHERES, *claims.CONES, *CLAIMS)
TEXT = q.GraniteLaws("text")


# --- logic


@pytest.mark.parametrize(
    ("criterion", "numbers", "expected"),
    [
        (near(73.0), {"": 71.8}, REPRODUCED),
        (near(73.0), {"": 80.31}, NOT_REPRODUCED),
        (near(73.0), {"": 65.69}, NOT_REPRODUCED),
        (Criterion(low=1.0), {"a": 1.0, "b": 7.0}, REPRODUCED),
        (Criterion(low=1.0), {"a": 0.999, "b": 7.0}, NOT_REPRODUCED),  # every number counts
        (Criterion(high=1.0), {"a": 1.001}, NOT_REPRODUCED),
        (Criterion(high=1.0), {"a": math.nan}, NOT_REPRODUCED),
        (built_in("by construction"), {"": 1e9}, BUILT_IN),
        (undecided(), {}, UNDECIDED),
    ],
)
def test_a_verdict_follows_from_every_number(criterion, numbers, expected):
    assert criterion.verdict(numbers) == expected


def test_a_criterion_states_its_range_and_reason():
    assert str(near(0.56)) == "at least 0.504 and at most 0.616: within 10% of 0.56"
    assert str(Criterion(high=0.09)) == "at most 0.09"
    assert str(undecided()) == "the measured points are not public"


def test_another_modulus_is_stated_where_it_changes_a_number():
    records = (
        Claim("§1", "a", "depends on E*", "x (N)", lambda source: {"": source, "twice": 2.0 * source}, Criterion(high=2.0)),
        Claim("§2", "b", "does not", "y", lambda source: {"": 3.0}, built_in("a rule")),
        Claim("§3", "c", "no number", "", None, undecided()),
    )
    first, second, third = judge(records, 1.0, 1.5)
    assert (first.gives, first.verdict) == ("x (N): 1, twice 2", REPRODUCED)
    assert (first.other_gives, first.other_verdict) == ("x (N): 1.5, twice 3", NOT_REPRODUCED)
    assert second[3:] == ("y: 3", BUILT_IN, "a rule", "", "") and third.gives == ""
    assert counts(c.verdict for c in (first, second, third)) == (
        "1 reproduced; 0 not reproduced; 1 built in; 1 cannot be decided"
    )


# --- records


def test_records_are_complete():
    """Each has a place and a criterion; what numbers decide has numbers and a finite end of the range."""
    for record in RECORDS:
        assert record.place and record.test and record.statement, record
        if record.criterion.fixed:
            assert record.criterion.reason, record
        else:
            assert record.numbers and record.quantity, record
            assert math.isfinite(record.criterion.low) or math.isfinite(record.criterion.high), record
    assert len({(r.test, r.statement) for r in RECORDS}) == len(RECORDS)


def test_claims_of_one_test():
    names = [t.name for t in granite.TESTS]
    for name in names:
        for claim in claims.granite_claims([name]):
            assert name in claims.concerned(claim.test)
    assert claims.concerned("rough spheres") == list(granite.ROUGH_SPHERES)
    assert claims.concerned("RFC10, FC5") == ["RFC10", "FC5"] and claims.concerned("all spheres") == names[:5]
    assert claims.concerned("RS, SS, VS(18-18)") == ["SS(18-18)", "SS(12-18)", "VS(18-18)", "RS(18-18)"]


def test_verdicts_with_both_moduli():
    """Numbers that depend on E*: those that the paper prints fit E/(2(1 - ν)) = 40.4 GPa, RFC10's yield does not."""
    found = {c.claim: (c.verdict, c.other_verdict) for c in claims.granite_claims()}
    changed = {claim for claim, (one, other) in found.items() if other not in ("", one)}
    assert {found[claim] for claim in changed} == {(NOT_REPRODUCED, REPRODUCED), (REPRODUCED, NOT_REPRODUCED)}
    for part in ("around 73 N", "field of view", "below 0.09 mm"):
        (claim,) = (claim for claim in changed if part in claim)
        assert found[claim] == (NOT_REPRODUCED, REPRODUCED)


def test_verdicts_before_and_after():
    """The page's table has statements of the records, each with another verdict."""
    rows = [claim._asdict() for claim in claims.granite_claims()]
    table = [line for line in measured.judged_again(rows).splitlines() if line.startswith("| ")][1:]
    assert len(table) == len(measured.JUDGED_AGAIN) == 7
    for line, (test, claim, before, _) in zip(table, measured.JUDGED_AGAIN, strict=True):
        (now,) = (row["verdict"] for row in rows if (row["test"], row["claim"]) == (test, claim))
        assert before != now and f"| {claim} | {test} | {before} | {now} |" in line
    with pytest.raises(KeyError):
        measured.judged_again([row for row in rows if "Goddard" not in row["claim"]])


# --- numbers


def test_numbers_of_hertz():
    for name, modulus in (("text", 32.32e9), ("figures", 40.4e9)):
        numbers = q.hertz_radius((4.4e-3, 0.35e-3), 100.0, q.GraniteLaws(name))
        assert numbers == {
            f"R {1e3 * r:g} mm": pytest.approx(1e3 * (3 * 100 * r / (4 * modulus)) ** (1 / 3)) for r in (4.4e-3, 0.35e-3)
        }
    bound = q.GraniteLaws("figures").law("hertz", "FC5")
    assert bound.contact.modulus == pytest.approx(40.4e9)


def test_numbers_of_laws():
    """K of RMS by its derivative over K of Yip-Venart, and displacements."""
    numbers = q.stiffness(("rms",), "yip-venart", ("SS(18-18)", "SS(12-18)"), (1.0,), TEXT)
    assert numbers == {"SS(18-18)": pytest.approx(0.995, abs=6e-4), "SS(12-18)": pytest.approx(1.162, abs=6e-4)}
    contact = granite.find_test("SF(12)").contact
    law, hertz = (dl.law(name, contact) for name in ("pohrt-popov", "hertz"))
    gained = q.displacement(("hertz",), "pohrt-popov", ("SF(12)",), ((1.0, 50.0),), TEXT)
    expected = (hertz.overlap(50.0) - hertz.overlap(1.0)) / (law.overlap(50.0) - law.overlap(1.0))
    assert gained == {"": pytest.approx(expected, rel=1e-12)}
    axes = q.table(lambda test, span: len(test) * span[1], ("a", "bb"), ((0.1, 2.0), (1.0, 5.0)))
    assert axes == {"a 0.1 to 2 N": 2.0, "a 1 to 5 N": 5.0, "bb 0.1 to 2 N": 4.0, "bb 1 to 5 N": 10.0}


def test_only_one_pair_contradicts_its_stones():
    wrong = {label: value for label, value in q.pairs_of_stones(TEXT).items() if abs(value) > 0.5}
    assert wrong == {"SS(18-18) σ": pytest.approx((math.hypot(1.56, 1.84) - 2.40) / 0.01)}


def test_onset_of_too_stiff_behaviour():
    """RMS is as much stiffer than Yip-Venart from 10 to 40 N as at 70 and 100 N, Pohrt-Popov is not."""
    ratio = {p: q.stiffness(("rms",), "yip-venart", ("SS(18-18)",), (p,), TEXT)[""] for p in (10.0, 20.0, 40.0, 70.0, 100.0)}
    late = min(ratio[70.0], ratio[100.0])
    numbers = q.onset("rms", TEXT)
    assert numbers["SS(18-18) late"] == pytest.approx(late) and late > 1.0
    assert numbers["SS(18-18) late over early"] == pytest.approx(late / max(ratio[10.0], ratio[20.0], ratio[40.0])) and (
        numbers["SS(18-18) late over early"] < 1.0
    )
    assert min(q.onset("pohrt-popov", TEXT).values()) > 1.0


def test_real_area_of_elastic_asperities():
    """d ln F_1/d ln F_1.5, by differences of adaptive integrals."""
    from scipy.integrate import quad

    def moment(d, n):
        return quad(lambda z: (z - d) ** n * math.exp(-0.5 * z * z), d, d + 12.0, epsabs=0.0, epsrel=1e-10)[0]

    for d in (1.0, 3.0):
        rise = [math.log(moment(d - 1e-3, n) / moment(d + 1e-3, n)) for n in (1.0, 1.5)]
        assert q.real_area(TEXT)[f"d = {d:g} σ"] == pytest.approx(rise[0] / rise[1], rel=2e-4)


def test_printed_equations_of_bahrami():
    """Eq. 13's first branch is 1.605/√p0' in the law; with the printed √p0' it misses the second by half."""
    assert q.printed_branches(TEXT)[""] == pytest.approx(0.4722, abs=1e-4)
    test = granite.find_test("SF(12)")
    kappa = 32.32e9 / 6.266e9 * math.sqrt(6.05e-3 / 6.56e-6)
    alpha = 6.56e-6 / float(dl.law("hertz", test.contact).overlap(100.0))
    solved = dl.law("yip-venart", test.contact)
    ratio = q.printed_kappa(TEXT)["SF(12)"]
    from demlaws.solvers import master_curves

    hardness_number = 6.266e9 / 32.32e9 * math.sqrt(8 * 6.05e-3 / 6.56e-6)
    pressure = float(master_curves.central_pressure(solved.name, hardness_number, 4 / 3 * alpha**-1.5))
    assert ratio == pytest.approx(1 / (1 + 1.22 * alpha * kappa**-0.16) / pressure, rel=1e-3)
    mended = 1 / (1 + 1.22 * alpha * (6.266e9 / 32.32e9 * math.sqrt(6.05e-3 / 6.56e-6)) ** -0.16)
    assert abs(mended / pressure - 1) < 0.05 < ratio - 1


def test_goddard_against_pohrt_popov():
    """The nearest slope is no edge of those tried, and no other comes nearer by more than the grid's step."""
    contact = granite.find_test("SS(18-18)").contact
    load = np.geomspace(1.0, 100.0, 30)
    target = dl.law("pohrt-popov", contact)
    target = target.stiffness(target.overlap(load))

    def difference(slope):
        one = dl.law("goddard", contact, slope=slope)
        return float(np.abs(one.stiffness(one.overlap(load)) / target - 1.0).max())

    best = min(map(difference, np.geomspace(0.02, 0.1, 400)))
    assert best - 1e-12 <= q.nearest_goddard(TEXT)["SS(18-18)"] < best + 0.02
    assert q.goddard_rises(TEXT)[""] == pytest.approx(1 / 3, abs=1e-6)
    rms = dl.law("rms", contact)  # the criterion names its difference
    assert np.abs(rms.stiffness(rms.overlap(load)) / target - 1.0).max() == pytest.approx(0.21, abs=5e-3)


def test_plastic_deformation_of_the_cone():
    """Proportional would be one ratio of deformation to load: it falls to half."""
    run = granite.run_test("rough-plastic", granite.find_test("RFC10"))
    rows = granite.stages_of(run)
    ratio = np.array([row.plastic_overlap / row.maximum_force for row in rows])
    assert list(q.proportion(TEXT).values()) == pytest.approx(list(ratio / ratio.mean()), rel=1e-6)
    assert ratio.min() / ratio.max() == pytest.approx(0.49, abs=5e-3)
    line = np.polynomial.Polynomial.fit(
        load := [r.maximum_force for r in rows], plastic := [r.plastic_overlap for r in rows], 1
    )
    square = 1.0 - np.sum((line(np.array(load)) - plastic) ** 2) / np.sum((np.array(plastic) - np.mean(plastic)) ** 2)
    assert q.straightness(TEXT)[""] == pytest.approx(square, abs=1e-6)


def test_two_cones_and_reloading():
    small = granite.stages_of(granite.run_test("rough-plastic", granite.find_test("FC5")))
    cone = granite.stages_of(granite.run_test("rough-plastic", granite.find_test("RFC10")))
    deformed = {round(row.maximum_force): row.plastic_overlap for row in cone}
    fourth = {f"{row.maximum_force:.0f} N": row.plastic_overlap for row in small if row.stage == 4}
    expected = {label: pytest.approx(value / deformed[int(label[:-2])], rel=1e-6) for label, value in fourth.items()}
    assert q.two_cones(TEXT) == expected and len(expected) == 4
    assert list(q.reload(TEXT).values()) == pytest.approx([1.0] * 5, abs=1e-3)
    around = q.return_to_first_loading(TEXT)
    law = TEXT.law("rough-plastic", "RFC10")
    assert around["above"] == pytest.approx(float(law.stiffness(law.overlap(40.0))) / 1e3, rel=1e-6) and (
        around["below"] > around["above"]
    )


# --- Jamari & Schipper


def test_counts_of_asperities():
    """Figure 2 of 2008: summits become more at every deeper cut, patches merge to one."""
    summits, patches = asperity_counts()
    assert np.all(np.diff(summits) >= 0) and summits[-1] > 40
    assert patches[-1] == 1 < max(patches) < max(summits)


def test_numbers_of_jamari_and_schipper():
    numbers = {claim.statement: claim.numbers(None) for claim in CLAIMS if claim.numbers and "cycle" not in claim.quantity}
    ratio = numbers["plastic and elastic asperities differ very little"]
    assert max(ratio.values()) < 1.0 and ratio["Al_A"] < 0.62 < 0.94 < ratio["Br_B"]
    assert numbers["the mean pressure at first yield is about 0.4 H"][""] == pytest.approx(0.396, abs=5e-4)
    assert numbers["p0 = (16 P E²/(π³ R²))^(1/3)"]["2008 isotropic"] == pytest.approx(0.221 / 0.16, abs=5e-3)
