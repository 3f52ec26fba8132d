"""The entry points of YADE that this package replaces.

`O.engines` hides the guards; `O.energy` contains the laws' energies since `O.trackEnergy` was set or it was cleared; saving
writes the laws to the scene; `O.run` attaches the laws of a loaded scene, and `O.wait` raises the message of a guard that has
stopped the run before; `O.reset` returns the memory of contacts. Importing `demlaws.yade` in a YADE process installs the
replacements.
"""

import functools
import types

import yade

from demlaws.errors import EngineStopped
from demlaws.yade import scene


def install():
    """Replace the entry points, and attach the laws of a scene that was loaded before."""
    omega = yade.wrapper.Omega
    if isinstance(omega.energy.fget, types.FunctionType):
        return
    omega.engines = property(lambda o: scene.get_visible(), lambda o, engines: scene.set_visible(engines))
    energy, tracking = omega.energy, omega.trackEnergy
    omega.energy = property(lambda o: scene.with_energies(energy.__get__(o)), energy.fset)
    omega.trackEnergy = property(tracking.fget, functools.partial(_track, tracking.fset))
    methods = {"run": _running, "wait": _waiting, "reset": _resetting, "save": _saving, "saveTmp": _saving}
    for name, replaced in methods.items():
        native = getattr(omega, name)
        setattr(omega, name, functools.wraps(native)(replaced(native)))
    scene.attach()


def _track(native, omega, value):
    _ = omega.energy  # gets what was lost until now, if it tracks
    native(omega, value)


def _running(native):
    def run(omega, nSteps=-1, wait=False):
        scene.begin()
        native(omega, nSteps, wait)

    return run


def _waiting(native):
    def wait(omega):
        native(omega)
        if scene.stops:
            raise EngineStopped(scene.stops[-1])

    return wait


def _resetting(native):
    def reset(omega):
        native(omega)
        scene.end_laws()

    return reset


def _saving(native):
    def save(omega, *arguments, **keywords):
        with scene.as_saved():
            return native(omega, *arguments, **keywords)

    return save
