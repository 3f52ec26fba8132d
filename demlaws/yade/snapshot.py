"""Contacts of a saved YADE scene, for `demlaws timestep`; run under YADE as snapshot.py SCENE RESULT (a JSON file)."""

import json
import os
import sys

import yade

from demlaws.contact import Material
from demlaws.errors import DemlawsError
from demlaws.timestep import rayleigh_step, shear_ratio


def _mass(body):
    """Mass [kg] of a sphere, inf of a body that does not move."""
    if not body.dynamic:
        return float("inf")
    if body.isClump or body.isClumpMember or not isinstance(body.shape, yade.Sphere):
        kind = "part of a clump" if body.isClump or body.isClumpMember else type(body.shape).__name__
        raise DemlawsError(f"body {body.id} is {kind}: exact limits are for single spheres (walls and fixed bodies may be any)")
    return body.state.mass


def _given_ratio():
    """K_t/K that the scene's law was given, or None: that of the materials."""
    texts = [value for tag in yade.O.tags.keys() if tag.startswith("demlaws.") for value in [yade.O.tags[tag]]]  # noqa: SIM118
    ratios = [json.loads(json.loads(text)["pairs"]).get("shear_ratio") for text in texts]
    return ratios[0] if ratios else None


def _stiffness(contact, bodies, given):
    """(K_n, K_t) [N/m]. On first loading of a law with history K_t follows the stiffness of unloading, which is the larger.

    given: K_t/K, or None."""
    phys = contact.phys
    if max(getattr(phys, "kr", 0.0), getattr(phys, "ktw", 0.0)) > 0.0:
        raise DemlawsError("its contacts resist rolling or twisting (kr, ktw), which the limit does not include")
    if getattr(phys, "tangensOfFrictionAngle", 1.0) == 0.0:
        return phys.kn, 0.0
    if isinstance(phys, yade.MindlinPhys):
        materials = [Material(m.young, m.poisson) for m in (bodies[contact.id1].mat, bodies[contact.id2].mat)]
        return max(phys.kn, phys.ks / (given or shear_ratio(*materials))), phys.ks
    return phys.kn, phys.ks


def snapshot():
    """Arguments of `from_contacts`, the present scene's step [s] and Rayleigh's [s], as lists and numbers."""
    bodies = {body.id: body for body in yade.O.bodies}
    number = {name: place for place, name in enumerate(bodies)}
    contacts = [c for c in yade.O.interactions if c.isReal and c.phys is not None and getattr(c.phys, "kn", 0.0) > 0.0]
    given = _given_ratio()
    grains = [b for b in bodies.values() if b.dynamic and isinstance(b.shape, yade.Sphere) and hasattr(b.mat, "poisson")]
    return {
        "pairs": [(number[c.id1], number[c.id2]) for c in contacts],
        "normals": [tuple(c.geom.normal) for c in contacts],
        "springs": [_stiffness(c, bodies, given) for c in contacts],
        "masses": [_mass(body) for body in bodies.values()],
        "blocked": [[axis in body.state.blockedDOFs for axis in "xyzXYZ"] for body in bodies.values()],
        "dt": yade.O.dt,
        "rayleigh": min(
            (rayleigh_step(b.shape.radius, b.mat.density, b.mat.young, poisson=b.mat.poisson) for b in grains), default=None
        ),
    }


if __name__ == "__main__":
    try:
        yade.O.load(sys.argv[1])
        result = snapshot()
    except (RuntimeError, AttributeError, DemlawsError) as error:
        result = {"error": str(error)}
    with open(sys.argv[2], "w") as file:
        json.dump(result, file)
    os._exit(0)
