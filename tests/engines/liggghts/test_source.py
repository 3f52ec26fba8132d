"""LIGGGHTS with the models built in (DEMLAWS_LIGGGHTS_SOURCE names it) beside the stock one with the plugin."""

import numpy as np
import pytest
from inputs import ENERGY, LOAD_UNLOAD, moves_of, simulate
from spheres import continued, gas, save_law, spheres
from twins import LAWS, PLUGIN, SHEARS, SOURCE, assert_checked, assert_close, assert_sheared_alike, chooser

import demlaws.liggghts as lg
from demlaws.liggghts.run import built_in

ENGINE = "liggghts"


@pytest.fixture
def use(monkeypatch):
    return chooser(monkeypatch, ENGINE, built_in)


def test_it_passes_the_check_without_a_plugin(use):
    use(SOURCE)
    assert_checked(lg.check)


@pytest.mark.parametrize("shear", SHEARS)
@pytest.mark.parametrize("name", LAWS)
def test_a_sheared_contact_is_the_plugins_to_rounding(tmp_path, use, name, shear):
    assert_sheared_alike(use, ENGINE, tmp_path, name, shear)


@pytest.mark.parametrize("ranks", [1, 2])
def test_a_box_of_colliding_spheres_is_the_plugins(tmp_path, use, ranks):
    save_law(tmp_path, "rough")
    logs = []
    for way, count in ((PLUGIN, 1), (SOURCE, ranks)):
        use(way)
        text = "".join(gas(ENGINE, 0.5, "elastic", ranks=count)).replace("thermo 5000", "thermo 500")
        logs.append(simulate(ENGINE, tmp_path, text + "run 15000\n", count))
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
