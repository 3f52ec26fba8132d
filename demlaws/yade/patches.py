"""What this package puts in place of YADE's own Python entry points: all of it here, and it can be taken back.

`O.engines` leaves out what is hidden and puts it back; saving writes the laws to the scene, loading puts them in place;
resetting ends scenes; erasing keeps the account of what ended contacts dissipated; a dispatcher's functors are not changed past
the guard. Asking `demlaws.yade` for its functor installs them.
"""

import yade

from demlaws.yade import scene
from demlaws.yade.omega import O

_originals = []  # (class, name, what stood there)


def install():
    """Put the patches in place; laws of a scene that was loaded before are put in place, too."""
    if _originals:
        return
    omega, bodies, contacts = yade.wrapper.Omega, yade.wrapper.BodyContainer, yade.wrapper.InteractionContainer
    _put(omega, "engines", property(lambda o: scene.get_visible(), lambda o, engines: scene.set_visible(engines)))
    _put(
        yade.LawDispatcher,
        "functors",
        property(yade.LawDispatcher.functors.__get__, lambda d, fs: scene.refuse_functors(d, fs)),
    )
    for name in ("save", "saveTmp", "sceneToString"):
        _wrap(omega, name, _saving)
    for name in ("load", "loadTmp", "reload", "stringToScene"):
        _wrap(omega, name, _loading)
    for name in ("resetThisScene", "resetCurrentScene"):
        _wrap(omega, name, _ending_one)
    for name in ("reset", "resetAllScenes"):
        _wrap(omega, name, _ending_all)
    for container, name, erased in (
        (bodies, "erase", _of_body),
        (bodies, "clear", _all),
        (contacts, "erase", _of_two),
        (contacts, "clear", _all),
    ):
        _wrap(container, name, lambda native, erased=erased: _erasing(native, erased))
    for name in ("deleteClumpBody", "deleteClumpMember", "replaceByClumps"):
        _wrap(bodies, name, _replacing)
    scene.attach_saved()


def remove():
    """Take them back: YADE is as it was, and laws at work are no longer guarded against what users do."""
    while _originals:
        owner, name, native = _originals.pop()
        setattr(owner, name, native)


def _put(owner, name, new):
    _originals.append((owner, name, getattr(owner, name)))
    setattr(owner, name, new)


def _wrap(owner, name, wrapper):
    native = getattr(owner, name, None)
    if native is not None:  # not every YADE has all of them
        new = wrapper(native)
        new.__doc__, new.native = native.__doc__, native
        _put(owner, name, new)


def _saving(native):
    def save(omega, *arguments, **keywords):
        def now():
            with scene.as_saved():
                return native(omega, *arguments, **keywords)

        laws = list(scene.laws_here().values())
        return laws[0].binding.between_engines(now) if laws else now()

    return save


def _loading(native):
    def load(omega, *arguments, **keywords):
        laws, token = scene.laws_here(), scene.token_here()
        result = native(omega, *arguments, **keywords)
        scene.scene_ended(token)
        scene.attach_saved(laws)
        return result

    return load


def _ending_one(native):
    def reset(omega, *arguments, **keywords):
        token = scene.token_here()
        result = native(omega, *arguments, **keywords)
        scene.scene_ended(token)
        return result

    return reset


def _ending_all(native):
    def reset(omega, *arguments, **keywords):
        result = native(omega, *arguments, **keywords)
        scene.all_scenes_ended()
        return result

    return reset


def _erasing(native, erased):
    """`native`, a function that erases, with the account of the contacts that it erases kept before."""

    def erase(container, *arguments, **keywords):
        for law in scene.laws_here().values():
            law.binding.bank(erased(container, *arguments, **keywords))
        return native(container, *arguments, **keywords)

    return erase


def _replacing(native):
    """`native`, a function that erases bodies of its own choice, with the account of their contacts kept."""

    def replace(container, *arguments, **keywords):
        def now():
            return native(container, *arguments, **keywords)

        laws = list(scene.laws_here().values())
        return laws[0].binding.account(now) if laws else now()

    return replace


def _of_body(bodies, number, eraseClumpMembers=False):
    body = bodies[number] if 0 <= number < len(bodies) else None
    if body is None:
        return []
    members = body.shape.members if eraseClumpMembers and isinstance(body.shape, yade.Clump) else ()
    return [contact for one in (number, *members) for contact in bodies[one].intrs()]


def _of_two(interactions, first, second):
    return [interactions[first, second]] if interactions.has(first, second) else []


def _all(container, *arguments):
    return O.interactions
