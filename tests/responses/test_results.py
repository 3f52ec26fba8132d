"""Results as tables, data frames and plots; laws as values; types of a user's script."""

import subprocess
import sys

import numpy as np
import pytest

import demlaws as dl
from demlaws.responses.contacts import Contacts

PAIR = dl.Contact(radius=4e-3, modulus=32e9, sigma=2e-6, fractal_dimension=2.2)


@pytest.fixture(scope="module")
def path():
    return dl.driver.force_controlled(dl.law("pohrt-popov", PAIR, unloading="hertz"), [10.0, 0.0], 20)


def test_parts_of_a_path(path):
    assert len(path) == 41 and path[20].force == pytest.approx(10.0)
    assert np.array_equal(path[:21].overlap, path.overlap[:21]) and isinstance(path[:21], type(path))


def test_a_path_is_an_array_and_a_sequence_of_points(path):
    """As it prints: a row per point, the same columns."""
    array = np.asarray(path)
    assert array.shape == (41, 5) and array.dtype == float
    for column, values in zip(array.T, path.columns().values(), strict=True):
        np.testing.assert_array_equal(column, values)
    np.testing.assert_array_equal(path["force"], path.force)
    np.testing.assert_array_equal(path["work"], path.stored + path.dissipated)
    points = list(path)
    assert [point.force for point in points] == list(path.force) and len(points[3]) == 1
    assert len(str(points[-1]).splitlines()) == 2
    with pytest.raises(dl.DemlawsError, match="did you mean 'force'"):
        path["froce"]


def test_a_path_is_a_test(path):
    best = dl.fit(path, PAIR, laws=["pohrt-popov"], free=["modulus"])[0]
    assert best.parameters["modulus"].value == pytest.approx(PAIR.modulus, rel=1e-6)
    table = dl.Table.from_points(path[5:21], PAIR, "elastic")
    assert table.force(path.overlap[15]) == pytest.approx(path.force[15], rel=0.01)


def test_contacts_have_columns_by_name():
    one, ones = np.array([1, 2, 3]), np.array([1.0, 2.0, 3.0])
    contacts = Contacts(one, one + 1, 1e-6 * ones, ones, stiffness=ones)
    np.testing.assert_array_equal(contacts["force"], ones)
    assert np.asarray(contacts).shape == (3, 5) and [c.force[0] for c in contacts] == [1.0, 2.0, 3.0]
    with pytest.raises(dl.DemlawsError, match="did you mean 'force'"):
        contacts["froce"]


def test_a_path_is_a_data_frame(path):
    pytest.importorskip("pandas")
    frame = path.to_dataframe()
    assert list(frame.columns)[:2] == ["overlap (m)", "force (N)"] and len(frame) == 41


def test_results_as_text(path):
    ranking = dl.fit(np.column_stack([path.overlap, path.force]), PAIR, laws=["hertz", "rms", "pohrt-popov"])
    for result in (path, ranking):
        assert len(str(result).splitlines()) <= 13
    assert ranking[0].name == "pohrt-popov"


def test_laws_and_paths_are_plotted(path):
    pytest.importorskip("matplotlib")
    law = dl.law("pohrt-popov", PAIR, unloading="hertz")
    axes = law.plot(unload_at=10.0)
    (curve,) = axes.lines
    assert curve.get_ydata().max() == pytest.approx(10.0) and "pohrt-popov" in curve.get_label()
    assert curve.get_ydata()[-1] == 0.0 and len(curve.get_xdata()) == 401  # loading and unloading
    assert path.plot(axes) is axes and len(axes.lines) == 2


def test_text_with_a_unit_is_an_overlap_or_a_force():
    law = dl.law("pohrt-popov", PAIR)
    assert law.force("1um") == law.force(1e-6) and law.overlap("0.05kN") == law.overlap(50.0)
    assert law.force(["1um", 2e-6]).tolist() == law.force([1e-6, 2e-6]).tolist()
    with pytest.raises(dl.DemlawsError):
        law.force("1 parsec")
    assert dl.Material("60600 N/mm²", 0.25).young == pytest.approx(60.6e9)
    assert dl.Contact("1cm", 1e10).radius == 0.01 and dl.Contact("1 inch", 1e10).radius == 0.0254


def test_equal_laws_are_equal():
    law = dl.law("pohrt-popov", PAIR, unloading="hertz")
    assert law == dl.law("pohrt-popov", PAIR, unloading="hertz") and hash(law) == hash(dl.law("pohrt-popov", PAIR, "hertz"))
    others = [
        dl.law("pohrt-popov", PAIR, "elastic"),
        dl.law("rms", PAIR, unloading="hertz"),
        dl.law("pohrt-popov", PAIR.with_values(sigma=3e-6), unloading="hertz"),
        law.tabulate(1e-3),
        "pohrt-popov",
    ]
    assert not any(law == other for other in others)
    assert law.tabulate(1e-3) == law.tabulate(1e-3) != law.tabulate(1e-4)


SCRIPT = """
import numpy as np

import demlaws as dl

granite = dl.Material(young="60.6GPa", poisson=0.25, hardness=6.266e9)
pair = dl.Contact.between(
    granite, granite, radius1=8.76e-3, radius2=8.63e-3, roughness1="1.56um", roughness2=0, fractal_dimension=2.22
)
radii = np.asarray(dl.Contact(radius=[1e-3, 2e-3], modulus="32GPa", sigma=dl.Surface("2um").roughness).radius)
law = dl.law("pohrt-popov", pair, unloading="hertz")
force: float = law.force("1um")
forces = law.force(np.linspace(0, 1e-6, 5))
print(force + 1, forces.max(), law.overlap(50.0), law.stiffness([1e-6]).size, law.energy(np.float64(1e-6)))
path = dl.driver.force_controlled(law, [50, 0, 100, 0])
print(path.overlap.max(), path.force[0], path.to_dataframe())
law.plot(unload_at=50.0)
table = law.tabulate(rtol=1e-5)
state = law.new_state(3)
print(table.evaluate([1e-6, 2e-6, 3e-6], state)[0], state.maximum_overlap)
print(dl.driver.impact(law, 1e-3, 0.1).restitution, dl.timestep(law, 1e-3, 10.0))
scene = dl.Scene(radii=[1e-3], materials=[granite], force=[1, 10])
print(dl.choose(scene).best.describe(), dl.laws(), dl.regime(pair, 10.0), dl.regime.transition_force(pair))
softer: dl.Law = dl.soften(law, 8)
load: float = dl.regime.transition_force(pair.with_values(hardness="6GPa"))
limit: float = dl.timestep.pair_limit(1e6, 1e-3, 1e-3)
basalt: float = dl.materials.basalt.poisson
print(dl.fit(np.column_stack([path.overlap, path.force]), pair).best.misfit)
"""
GIVEN = """import numpy as np
import demlaws as dl
granite = dl.materials.granite
pair = dl.Contact.between(granite, granite, radius1="8mm", radius2="flat")
law = dl.law("pohrt-popov", pair, unloading="hertz")
state = law.new_state()
path = law.follow([1e-6])
"""
WRONG = [
    "a1: float = dl.materials.granite",
    "a2 = dl.materials.granit",
    "a3: str = law.force(1e-6)",
    "a4: str = law.force('1um')",
    "a5: float = law.force(np.array([1e-6]))",
    "a6: float = law.force([1e-6])",
    "a7 = law.stiffness(1e-6)[0]",
    "a8: str = law.overlap(1.0)",
    "a9: float = law.energy([1e-6])",
    "b1: str = law.unloading_overlap(1.0, state)",
    "b2: float = law.shear_stiffness([1e-6], 0.8)",
    "b3: float = dl.soften(law, 8.0)",
    "b4: str = dl.fit(path, pair)[0]",
    "b5: float = path['force']",
    "b6: str = path[0]",
    "b7: str = dl.regime.transition_force(pair)",
    "b8: str = dl.regime.hertz_pressure(pair, 1.0)",
    "b9: str = granite.young",
    "c1: str = dl.choose(dl.Scene(radii=[1e-3], materials=[granite], force=[1, 10]))[0]",
]
"""Each line is an error to a type checker: a result that is typed Any would pass."""


@pytest.mark.slow
def test_a_users_script_passes_strict_types(tmp_path):
    pytest.importorskip("mypy")
    (tmp_path / "script.py").write_text(SCRIPT)
    command = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(tmp_path / "cache"), "script.py"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout
    (tmp_path / "script.py").write_text(GIVEN + "\n".join(WRONG))
    output = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True).stdout
    reported = {int(line.split(":")[1]) for line in output.splitlines() if ": error: " in line}
    first = len(GIVEN.splitlines()) + 1
    assert [line for number, line in enumerate(WRONG, first) if number not in reported] == [], output
    assert min(reported) >= first, output
