"""LIGGGHTS with the models built in (DEMLAWS_LIGGGHTS_SOURCE names it; docs/machines.md) beside the stock one with the plugin."""

import os

import numpy as np
import pytest
from inputs import ENERGY, LOAD_UNLOAD, moves_of, simulate
from spheres import SHEARED, continued, gas, save_law, spheres

import demlaws.liggghts as lg
from demlaws.liggghts.run import built_in

BUILT = os.environ.get("DEMLAWS_LIGGGHTS_SOURCE", "")
PLUGIN, SOURCE = "plugin", "source"
ENGINE = "liggghts"


@pytest.fixture
def use(monkeypatch):
    """A function that has runs take LIGGGHTS with the plugin, or with the models in it, from then on."""

    def choose(way):
        if way == SOURCE:
            monkeypatch.setenv("DEMLAWS_LIGGGHTS", BUILT)
        else:
            monkeypatch.delenv("DEMLAWS_LIGGGHTS", raising=False)
        assert built_in() == (way == SOURCE)

    return choose


def assert_close(found, expected, columns, rtol):
    for column in columns:
        scale = np.abs(expected[column]).max()
        assert scale > 0 and np.abs(found[column] - expected[column]).max() <= rtol * scale, column


def test_it_passes_the_check_without_a_plugin(use):
    use(SOURCE)
    lines = []
    lg.check(lines.append)
    assert "no plugin" in lines[1] and lines[-1] == "all good"


@pytest.mark.parametrize("shear", ["elastic", "loading", "slip", "elastic levels 5 shear_ratio 0.6"])
@pytest.mark.parametrize("name", ["rough elastic", "rough", "thornton", "yielded"])
def test_a_sheared_contact_is_the_plugins_to_rounding(tmp_path, use, name, shear):
    save_law(tmp_path, name)
    logs = []
    for way in (PLUGIN, SOURCE):
        use(way)
        logs.append(simulate(ENGINE, tmp_path, spheres(ENGINE, f"shear {shear}", SHEARED, restitution=0.8, **ENERGY)))
    assert_close(logs[1], logs[0], ("force", "side", "e[1]", "e[2]"), 1e-10)


@pytest.mark.parametrize("ranks", [1, 2])
def test_a_box_of_colliding_spheres_is_the_plugins(tmp_path, use, ranks):
    save_law(tmp_path, "rough")
    logs = []
    for way, count in ((PLUGIN, 1), (SOURCE, ranks)):
        use(way)
        text = "".join(gas(ENGINE, 0.5, "elastic", ranks=count)).replace("thermo 5000", "thermo 100")
        logs.append(simulate(ENGINE, tmp_path, text + "run 3000\n", count))
    assert_close(logs[1], logs[0], ("ke", "er", "stored", "lost"), 1e-7)


@pytest.mark.parametrize("written, read", [(SOURCE, SOURCE), (PLUGIN, SOURCE), (SOURCE, PLUGIN)])
def test_a_restart_file_goes_on_in_either(tmp_path, use, written, read):
    save_law(tmp_path, "rough")
    text = spheres(ENGINE, "", LOAD_UNLOAD[:2], **ENERGY)
    use(written)
    whole = simulate(ENGINE, tmp_path, text + "write_restart now.restart\n" + moves_of(LOAD_UNLOAD[2:]))
    use(read)
    rest = simulate(ENGINE, tmp_path, continued(ENGINE, text, LOAD_UNLOAD[2:], **ENERGY))
    rows = np.isin(whole["Step"], rest["Step"])
    assert rest["Step"].size == rows.sum() > 100
    assert_close(rest, {name: values[rows] for name, values in whole.items()}, ("force", "e[1]", "e[2]"), 1e-12)
