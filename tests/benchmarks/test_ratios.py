"""What `make bench` does with its ratios; they themselves are timings and decide no test."""

import ratios
from ratios import Ratio


def test_slower_beyond_noise_is_said():
    kept = {"a": Ratio(1.00, 0.01), "b": Ratio(2.00, 0.01), "c": Ratio(2.0, 0.20), "gone": Ratio(1.0, 0.0)}
    found = {"a": Ratio(1.06, 0.00), "b": Ratio(2.07, 0.01), "c": Ratio(2.3, 0.0), "new": Ratio(9.0, 0.0)}
    (line,) = ratios.compare(kept, found)
    assert line.startswith("SLOWER by 6.0%: a: 1.000 → 1.060")


def test_kept_by_machine(tmp_path):
    file = tmp_path / "ratios.json"
    ratios.keep(file, "one", {"a": Ratio(1.5, 0.01, 2.0)})
    ratios.keep(file, "other", {"a": Ratio(1.7, 0.02)})
    assert ratios.read(file, "one") == {"a": Ratio(1.5, 0.01, 2.0)}
    assert ratios.read(file, "other") == {"a": Ratio(1.7, 0.02)}
    assert ratios.read(file, "third") == {} == ratios.read(tmp_path / "absent.json", "one")
    assert [path.name for path in tmp_path.iterdir()] == ["ratios.json"]
