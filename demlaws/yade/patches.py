"""The entry points of YADE that this package replaces.

`O.engines` hides the guards; a dispatcher's `functors` that are assigned in a scene get theirs; `O.energy` contains the laws'
energies since `O.trackEnergy` was set or it was cleared; saving writes the laws to the scene; `O.reset` returns the memory of
their contacts; methods that wait for a run raise the message with which a guard has stopped it. A loaded scene gets its laws at
its first step, or when one of these is read before. Importing a name from `demlaws.yade` installs the replacements.
"""

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
    yade.LawDispatcher.functors = property(scene.FUNCTORS.__get__, scene.set_functors)
    methods = {"reset": _resetting, "run": _running, "step": _stepping, "wait": _waiting}
    for name, replaced in (methods | dict.fromkeys(("save", "saveTmp", "sceneToString"), _saving)).items():
        native = getattr(omega, name)
        native = getattr(native, "native", native)  # `watch_loaded` has replaced it
        setattr(omega, name, functools.wraps(native)(replaced(native)))
    scene.attach_loaded()


def _track(native, omega, value):
    _ = omega.energy  # gets what was lost until now, if it tracks
    native(omega, value)


def _resetting(native):
    def reset(omega):
        native(omega)
        scene.end_laws()

    return reset


def _running(native):
    def run(omega, nSteps=-1, wait=False):
        scene.begin()
        if wait:
            scene.call_and_wait(native, omega, nSteps, wait)
        else:
            native(omega, nSteps, wait)

    return run


def _waiting(native):
    def wait(omega):
        scene.call_and_wait(native, omega)

    return wait


def _stepping(native):
    def step(omega):
        scene.begin()
        scene.call_and_wait(native, omega)

    return step


def _saving(native):
    def save(omega, *arguments, **keywords):
        def now():
            with scene.as_saved():
                return native(omega, *arguments, **keywords)

        laws = list(scene.laws_here().values())
        return laws[0].binding.between_engines(now) if laws else now()

    return save
