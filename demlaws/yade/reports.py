"""Messages about faults of contacts, laws and time steppers, and the text of a functor."""

import math
import platform

import numpy as np
import yade.config

from demlaws.errors import did_you_mean
from demlaws.units import RANGES, too_large_overlap
from demlaws.yade import layout, native
from demlaws.yade.omega import O, invalid_radius, real_contacts
from demlaws.yade.pairs import NOT_SERVED


def unlisted_text(binding, bodies, missing):
    """Message about two bodies of materials without a surface; missing: labels of surfaces that no material has."""
    borne = {body.material.label for body in O.bodies if body.material is not None}
    labels = [O.bodies[number].material.label for number in bodies]
    what = "no surface was given."
    if missing:
        what = f"no body's material has the label {' or '.join(map(repr, missing))}, for which a surface was given"
        what += did_you_mean(missing[0], borne)
    return (
        f"{what} Contact {bodies[0]}+{bodies[1]}, of materials labelled {labels[0]!r} and {labels[1]!r}, would be smooth "
        f"under the law {binding.pairs.name}. Labels of the bodies' materials: {', '.join(map(repr, sorted(borne)))}. Give "
        "surfaces={label: demlaws.Surface(...)} for those that are rough, or smooth=True if the others are meant smooth"
    )


OWN_SLIP = (
    f"it needs YADE's own contact step, whose slip is not ScGeom.shearInc in YADE {yade.config.version}; use 2023.02a or newer"
)
MESSAGES = {
    layout.NATIVE_STEP: (
        " has damping by en or es (give betan and betas instead), the physics of another contact (at a joint of a chain), or a "
        f"functor with an option: {OWN_SLIP}"
    ),
    layout.UNGUARDED: (
        " was computed by a functor that has no guard in the scene, and got no force: give the law to an InteractionLoop in "
        "O.engines (engines within an integrator are not served)"
    ),
    layout.LOST_ROW: (
        " has a history that this process does not have: its scene was saved or loaded without demlaws. Load it by O.load "
        "after `import demlaws.yade`, or let all contacts begin again: O.interactions.clear()"
    ),
    layout.CHANGED: (
        ": kno or kso was changed by the script; the law writes both in each step, from R, E* and surfaces. For another force "
        "give other materials or surfaces, for another K_t shear_ratio=, or use Law2_ScGeom_MindlinPhys_Mindlin"
    ),
    layout.SET_SHEAR: (
        ': its shearElastic was set by the script, which springs of shear="slip" cannot take over: use shear="elastic", or let '
        "contacts begin again, O.interactions.clear()"
    ),
    layout.NO_ROW: f" has no memory for its history: {native.MORE_MEMORY}",
    layout.FLAT_GAP: (
        " ({shapes}): flat on flat, whose radius of curvature is far above the bodies' R of {value:g} m, so that Hertz's "
        "contact has no R: give an upper bound, radius=demlaws.yade.Curvature(largest=…), or the measured edge radius in m, "
        "radius=…"
    ),
    layout.NO_CURVATURE: (
        ' ({shapes}): radius="curvature" needs level sets, spheres, facets, walls or boxes, and a contact point within two '
        "cells of the surface of a level set: give the measured edge radius in m, radius=…"
    ),
    layout.WRONG_CLASS: (
        " of {shapes} is described by {geometry} and {physics}: the law does not act on these, native Mindlin did. Use an Ig2 "
        "functor that makes ScGeom or a class derived from it, and Ip2_FrictMat_FrictMat_MindlinPhys"
    ),
    layout.FRICTION: (
        " has a friction that depends on the pressure (c1 = {value:g}) by materials that came after the law: give the law "
        'friction="materials", or make it when the materials are there'
    ),
    layout.WRONG_MODULUS: (
        f": its materials make E* = {{value:g}} Pa; {RANGES['modulus'].remedy} Materials: "
        "{0.label!r} young={0.young:g} Pa, poisson={0.poisson:g}, {1.label!r} young={1.young:g} Pa, poisson={1.poisson:g}"
    ),
    layout.WRONG_CONTACT: f" with R = {{value:g}} m: {NOT_SERVED}",
}
"""Kind of fault → message, as text to be formatted with both materials, the shapes, classes of the contact and the value."""


def fault_text(binding, kind, bodies, value):
    """Message about a fault of the contact of two bodies; value: overlap or R [m], or E* [Pa]."""
    wrong = next(filter(None, (invalid_radius(O.bodies[number]) for number in bodies)), None)
    if wrong is not None:
        return f": {wrong}"
    shapes = " on ".join(type(O.bodies[number].shape).__name__ for number in bodies)
    stones, contact = [O.bodies[number].material for number in bodies], O.interactions[bodies]
    geometry, physics = contact.geom, type(contact.phys).__name__
    if isinstance(geometry, yade.ScGeom) and geometry.refR1 == geometry.refR2 == 0.0:  # PotentialParticle
        return (
            f" of {shapes}: YADE's geometry has no radius (refR1 = refR2 = 0), so that the stiffness of MindlinPhys is not "
            "finite, also natively. Use level sets or polyhedra"
        )
    if kind in MESSAGES:
        return MESSAGES[kind].format(*stones, shapes=shapes, geometry=type(geometry).__name__, physics=physics, value=value)
    if kind == layout.TOO_DEEP:
        radius = float(binding.attachment.rows_of([contact])["radius"][0])
        return f": {too_large_overlap(value, radius)}. Of softened grains: a larger `young`"
    if kind == layout.TOO_ROUGH:
        labels = [stone.label for stone in stones]
        return f" ({labels[0]!r} on {labels[1]!r}): {binding.roughness_text(*labels, value)}"
    if value != value:
        places = " and ".join(f"{number} at {tuple(O.bodies[number].state.pos)} m" for number in bodies)
        return f": a position is not finite, bodies {places}: {remedy_of_motion(bodies)}"
    return (
        f" at overlap {value:g} m: the law gives no finite force there (a table or law ends, the overlap is infinite, or N_H "
        "or μ is outside the range of yip-venart or greenwood-tripp): make the table for larger forces, check hardness, "
        "roughness and modulus, or take a smaller time step"
    )


def remedy_of_motion(bodies):
    """What to do where bodies of these numbers move to places that are not finite: the step, or damping of 0 restitution."""
    for contact in O.interactions:
        damping = getattr(contact.phys, "betan", 0.0), getattr(contact.phys, "betas", 0.0)
        if contact.isReal and {contact.id1, contact.id2} & set(bodies) and not all(map(math.isfinite, damping)):
            return (
                f"the damping ratios betan = {damping[0]:g}, betas = {damping[1]:g} of contact {contact.id1}+{contact.id2} are "
                "not finite: give en and es of Ip2_FrictMat_FrictMat_MindlinPhys above 0, at most 1"
            )
    return "take a smaller time step, or check what the script did to it"


def unavailable_text(failure, pairs=None):
    """Message about a YADE with which the bridge does not work; failure: of a proof, or of the self-test of laws of a user."""
    from demlaws.yade.saving import user_laws
    from demlaws.yade.selftest import SelfTestFailed

    if pairs is not None and isinstance(failure, SelfTestFailed) and user_laws(pairs):
        name = user_laws(pairs)[0]
        return (
            f"law {name!r} acts differently in YADE: {failure}. No law is applied, and YADE is unchanged. Compare the law in "
            f"YADE and in Python: demlaws laws {name} --law-file FILE --check"
        )
    tested = ", ".join(native.TESTED)
    return (
        f"demlaws does not work with this YADE: {failure}. No law is applied, and YADE is unchanged. This is {versions()}. Use "
        f"YADE {tested} on 64-bit x86, with a numpy and a numba that `pip install demlaws` chooses there; `demlaws yade check` "
        "repeats the tests. Without them the forces of a simulation can be computed afterwards in Python, from its overlaps: "
        "dl.law(...).evaluate, or a table"
    )


def versions():
    """Versions of YADE, Python, numba and numpy of this process, and the processor."""
    import numba

    python, machine = platform.python_version(), platform.machine()
    return f"YADE {yade.config.version}, Python {python}, numba {numba.__version__}, numpy {np.__version__}, {machine}"


def describe(binding):
    """One line: law, surfaces, counts."""
    surfaces = ", ".join(
        f"{label}: Sq {'not given' if s.roughness is None else f'{s.roughness:g} m'}"
        + ("" if s.fractal_dimension is None else f", Df {s.fractal_dimension:g}")
        for label, s in binding.pairs.all_surfaces().items()
    )
    count = O.interactions.countReal()
    if binding.scene is None:
        where = "in no scene"
    elif O.running:
        where = f"{count} contacts of all kinds, running"
    else:
        where = f"{int((binding.attachment.rows_of(real_contacts())['tag'] > 0).sum())} contacts of {count}"
    pairs = binding.pairs
    shear = f"shear {pairs.shear_name}" + (f" in {pairs.levels} levels" if pairs.levels else "")
    shear += "" if pairs.shear_ratio is None else f", K_t/K {pairs.shear_ratio:g}"
    smooth = ", meant smooth" if binding.pairs.smooth else ""
    return f"{binding.pairs.name}; {shear}; surfaces: {surfaces or 'none' + smooth}; {where}"


def stepper_text(stepper, bound, reach):
    """Message about a time stepper without a valid bound; bound: the valid one [s], which is its maxDt if the user gave none;
    None without spheres; reach: `binding.LARGEST_STEP_RATIO`."""
    why = "it uses the present stiffness of contacts, and a young contact is soft until the step in which it is not"
    if bound is None:
        return (
            f"GlobalStiffnessTimeStepper has no bound that is valid for the law: {why}. Without spheres YADE has no "
            "PWaveTimeStep() to compute a bound from: give it a maxDt"
        )
    why += f". The bound is {bound:.3g} s ({reach:g} PWaveTimeStep() of the bodies times its safety coefficient)"
    if stepper.maxDt == bound:
        return (
            f"GlobalStiffnessTimeStepper had no bound that is valid for the law: {why}, which is now its maxDt and follows "
            "the bodies; give it a maxDt to choose another, or use demlaws.yade.engines(law, timestep=…)"
        )
    name = "targetDt" if stepper.densityScaling else "maxDt"
    return (
        f"GlobalStiffnessTimeStepper has {name} = {getattr(stepper, name):.3g} s, above the bound that is valid for the law: "
        f"{why}; it is not changed. Give a smaller {name}"
    )
