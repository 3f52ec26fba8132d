"""The entry points of YADE that this package replaces.

`O.engines` hides the guards; `O.energy` contains the laws' energies since `O.trackEnergy` was set or it was cleared; saving
writes the laws to the scene; `O.run` attaches the laws of a loaded scene, and `O.wait` raises the message of a guard that has
stopped the run before; `O.reset` returns the memory of contacts. Importing `demlaws.yade` in a YADE process installs the
replacements.
"""

import contextlib
import functools
import types

import yade

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
    calls = {"run": {"before": scene.begin}, "wait": {"after": scene.report_stop}, "reset": {"after": scene.end_laws}}
    for name, actions in {**calls, "save": {"during": scene.as_saved}, "saveTmp": {"during": scene.as_saved}}.items():
        setattr(omega, name, _around(getattr(omega, name), **actions))
    scene.attach()


def _track(native, omega, value):
    _ = omega.energy  # gets what was lost until now, if it tracks
    native(omega, value)


def _around(native, before=None, after=None, during=contextlib.nullcontext):
    """A method of YADE with calls of ours before and after it, within a context."""

    @functools.wraps(native)
    def method(omega, *arguments, **keywords):
        if before is not None:
            before()
        with during():
            result = native(omega, *arguments, **keywords)
        if after is not None:
            after()
        return result

    return method
