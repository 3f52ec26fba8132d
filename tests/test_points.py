"""Measured points: which of them are first loading, and the files that they come in."""

import numpy as np
import pytest

import demlaws as dl
from demlaws import granite
from demlaws.errors import DemlawsError
from demlaws.points import Points, read_points

TEST = granite.find_test("SS(18-18)")


@pytest.fixture(scope="module")
def bound():
    return granite.bind("pohrt-popov", TEST, "hertz")


def measured(bound, turning_points, steps=40, noise=0.0):
    path = dl.driver.force_controlled(bound, turning_points, steps)
    scatter = noise * np.random.default_rng(1).standard_normal((2, path.force.size))
    return Points(path.overlap - 7e-6 + 1e-9 * scatter[0], path.force + scatter[1], "made")


@pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")
def test_a_loop_of_unloading_is_no_first_loading(bound):
    """Before: the loop counted, and the law that made the points missed them by 0.94 µm; without the loop by 0.10."""
    loop = measured(bound, [40.0, 0.0, 100.0])
    first = loop.first_loading()
    path_of_forces = loop.force[first]
    assert np.all(np.diff(path_of_forces) >= 0)
    assert path_of_forces.size == 66  # 0 to 40 N, and of the second branch what lies above 40 N
    several = measured(bound, [30.0, 10.0, 50.0, 20.0, 100.0, 60.0])
    assert np.all(np.diff(several.force[several.first_loading()]) >= 0)
    assert several.force[several.first_loading()][-1] == pytest.approx(100.0)


@pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")
def test_noise_is_no_unloading(bound):
    noisy = measured(bound, [100.0], 400, noise=0.02)
    assert np.sum(np.diff(noisy.force) < 0) == 0 or noisy.first_loading().all()
    dips = noisy._replace(force=noisy.force * (1 + 0.01 * (-1.0) ** np.arange(noisy.force.size)))
    assert np.sum(np.diff(dips.force) < 0) > 100
    assert dips.first_loading()[: int(np.argmax(dips.force)) + 1].mean() > 0.95


FILES = {
    "commas": "displacement (um),force (N)\n1.5,0.5\n2,1.5\n3,3\n",
    "semicolons and decimal commas": "Displacement (µm);Force (N)\n1,5;0,5\n2;1,5\n3,0;3\n",
    "semicolons and decimal points": "displacement [um]; force [N]\n1.5; 0.5\n2; 1.5\n3; 3\n",
    "tabs": "displacement_um\tforce_N\r\n1,5\t0,5\r\n2\t1.5\r\n3\t3\r\n",
    "blanks": "displacement (um)   force (N)\n  1.5   0.5\n  2.0   1.5\n3 3\n",
    "comments": "# machine 7\n% 2023\n// x\n\ndisplacement (um),force (N)\n# begins\n1.5,0.5\n2,1.5\n\n3,3\n# end\n",
    "titles in a comment": "# test 12\n# displacement (um),force (N)\n1.5,0.5\n2,1.5\n3,3\n",
    "more columns": "time (s),force (kN),note,displacement (mm)\n0,5e-4,,1.5e-3\n1,1.5e-3,x,2e-3\n2,3e-3,,3e-3\n",
    "quoted": '"displacement (um)","force (N)"\n"1.5","0.5"\n"2","1.5"\n"3","3"\n',
    "our own curve": "overlap (m),force (N),stiffness (N/m)\n1.5e-6,0.5,1\n2e-6,1.5,2\n3e-6,3,3\n",
    "other forces": "preload (N),loading rate (N/s),force (N),time under load (s),displacement (um)\n"
    "9,9,0.5,9,1.5\n9,9,1.5,9,2\n9,9,3,9,3\n",
    "millinewtons": "displacement (nm),force (mN)\n1500,500\n2000,1500\n3000,3000\n",
    "meganewtons": "displacement (UM),force (MN)\n1.5,5e-7\n2,1.5e-6\n3,3e-6\n",
}


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1"])
@pytest.mark.parametrize("text", FILES.values(), ids=FILES)
def test_files(tmp_path, text, encoding):
    """Before: commas alone were read, a comment was an error, and "force (MN)" was taken for mN, 10⁹ times too small."""
    file = tmp_path / "points.txt"
    file.write_bytes(text.encode(encoding))
    points = read_points(file)
    np.testing.assert_allclose(points.displacement, [1.5e-6, 2e-6, 3e-6], rtol=1e-12)
    np.testing.assert_allclose(points.force, [0.5, 1.5, 3.0], rtol=1e-12)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "# only a comment\n",
        "1,2\n2,3\n3,4\n",
        "displacement (um),force (mn)\n1,2\n2,3\n3,4\n",
        "displacement (N),force (N)\n1,2\n2,3\n3,4\n",
        "displacement,force\n1,2\n",
        "displacement (um),force (N)\n1,5,2,5\n2,5,3,5\n4,5,5,5\n",
        "displacement (um);force (N)\n1.234,5;2\n",
        "displacement (um),force (N)\n1,2\n3\n",
        "displacement (um),force (N)\n1,2\n2,inf\n",
        "displacement (um),force (N)\n1,2\n2,3\n",
        "\x00\x01\xff\xfe\x00",
        "force A (N),displacement (um),force B (N)\n1,2,3\n2,3,4\n3,4,5\n",
        "displacement (nm)\tforce (N)\n998\t2.5\n999\t3.5\n1,000\t5.5\n",
    ],
)
def test_bad_files(tmp_path, text):
    file = tmp_path / "points.csv"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(DemlawsError):
        read_points(file)
    with pytest.raises(DemlawsError, match="cannot read points"):
        read_points(tmp_path)
