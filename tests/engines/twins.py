"""An engine with the models built in (DEMLAWS_<ENGINE>_SOURCE names it) beside the stock one with the plugin."""

import os

import numpy as np
from inputs import ENERGY, simulate
from spheres import SHEARED, save_law, spheres

PLUGIN, SOURCE = "plugin", "source"
SHEARS = ("elastic", "loading", "slip", "elastic levels 5 shear_ratio 0.6", "elastic friction_pressure 0.4 3e-9")
LAWS = ("rough elastic", "rough", "thornton", "yielded")


def built(engine):
    """The executable with the models in it."""
    return os.environ.get(f"DEMLAWS_{engine.upper()}_SOURCE", "")


def chooser(monkeypatch, engine, built_in):
    """A function that has runs take the engine with the plugin, or with the models in it, from then on."""
    variable = f"DEMLAWS_{engine.upper()}"
    plugin = os.environ.get(variable)

    def choose(way):
        if way == SOURCE or plugin:
            monkeypatch.setenv(variable, built(engine) if way == SOURCE else plugin)
        else:
            monkeypatch.delenv(variable, raising=False)
        assert built_in() == (way == SOURCE)

    return choose


def assert_close(found, expected, columns, rtol):
    """Columns of a log, each to its largest value."""
    for column in columns:
        scale = np.abs(expected[column]).max()
        assert scale > 0 and np.abs(found[column] - expected[column]).max() <= rtol * scale, column


def assert_checked(check):
    """Without a plugin the engine passes its check."""
    lines = []
    check(lines.append)
    assert "no plugin" in lines[1] and lines[-1] == "all good"


def assert_sheared_alike(use, engine, folder, name, shear, **more):
    """A sheared contact is the plugin's to rounding."""
    save_law(folder, name)
    logs = []
    for way in (PLUGIN, SOURCE):
        use(way)
        logs.append(simulate(engine, folder, spheres(engine, f"shear {shear}", SHEARED, restitution=0.8, **more, **ENERGY)))
    assert_close(logs[1], logs[0], ("force", "side", "e[1]", "e[2]"), 1e-10)
