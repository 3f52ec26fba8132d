"""What `make bench` does with its ratios; they themselves are timings and decide no test."""

import json

import ratios
from ratios import Ratio


def test_slower_beyond_noise_is_said():
    kept = {"a": Ratio(1.00, 0.01), "b": Ratio(2.00, 0.01), "c": Ratio(2.0, 0.20), "gone": Ratio(1.0, 0.0)}
    found = {"a": Ratio(1.06, 0.00), "b": Ratio(2.07, 0.01), "c": Ratio(2.3, 0.0), "new": Ratio(9.0, 0.0)}
    (line,) = ratios.compare(kept, found)
    assert line.startswith("SLOWER by 6.0%: a: 1.000 → 1.060")


def test_faster_is_not_said_and_a_goal_is():
    assert ratios.compare({"a": Ratio(2.0, 0.0)}, {"a": Ratio(1.0, 0.0, goal=1.5)}) == []
    (line,) = ratios.compare({}, {"a": Ratio(1.6, 0.0, goal=1.5)})
    assert line == "misses its goal: a: 1.600, goal 1.5"


def test_ratio_and_noise_of_alternating_rounds():
    found = ratios.ratio_of([2.0, 2.2, 9.0, 9.0], [1.0, 1.0, 4.0, 4.0], goal=3.0)
    assert found.value == 2.0
    assert 0.09 < found.noise < 0.10 and found.goal == 3.0


def test_kept_by_machine(tmp_path):
    file = tmp_path / "ratios.json"
    ratios.keep(file, "one", {"a": Ratio(1.5, 0.01, 2.0)})
    ratios.keep(file, "other", {"a": Ratio(1.7, 0.02)})
    assert ratios.read(file, "one") == {"a": Ratio(1.5, 0.01, 2.0)}
    assert ratios.read(file, "other") == {"a": Ratio(1.7, 0.02)}
    assert ratios.read(file, "third") == {} == ratios.read(tmp_path / "absent.json", "one")
    assert [path.name for path in tmp_path.iterdir()] == ["ratios.json"]


def test_the_file_in_the_repository_can_be_read():
    for where, entry in json.loads(ratios.FILE.read_text()).items():
        assert set(entry) == {"measured", "load", "version", "ratios"}
        assert all(r.value > 0.0 and r.noise >= 0.0 for r in ratios.read(ratios.FILE, where).values())
