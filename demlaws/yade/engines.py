"""A whole engine list around a law."""

from numbers import Real

import yade

from demlaws.errors import DemlawsError


def engines(law, *, geometries=None, bounds=None, physics=None, before=(), after=(), newton=None, verlet=0.1, timestep=None):
    """A whole engine list for spheres, facets, walls and boxes: `O.engines = engines(law)`.

    geometries, bounds: functors in place of the usual ones; physics: an Ip2_FrictMat_FrictMat_MindlinPhys, for damping; before,
    after: engines before and behind the contacts (forces, boundaries); newton: a NewtonIntegrator (default: no damping);
    verlet: `InsertionSortCollider.verletDist` in units of the smallest radius; timestep: the part, up to 1, of the critical
    step for a GlobalStiffnessTimeStepper, None for a constant `O.dt`. The stepper's step stays below this part of 4
    PWaveTimeStep() of the bodies, later ones included: the present stiffness of a contact does not bound that of the next step,
    and 4 r √(ρ/E) is stable for a sphere with four contacts per side that have grown to 0.3 R, under every law.
    """
    if not isinstance(law, yade.LawFunctor):
        raise DemlawsError(f"engines(law): give the law functor, Law2_ScGeom_MindlinPhys_Demlaws(…), got {law!r}")
    bounds = bounds or [yade.Bo1_Sphere_Aabb(), yade.Bo1_Facet_Aabb(), yade.Bo1_Wall_Aabb(), yade.Bo1_Box_Aabb()]
    geometries = geometries or [
        yade.Ig2_Sphere_Sphere_ScGeom(),
        yade.Ig2_Facet_Sphere_ScGeom(),
        yade.Ig2_Wall_Sphere_ScGeom(),
        yade.Ig2_Box_Sphere_ScGeom(),
    ]
    stepper = []
    if timestep is not None:
        if not (isinstance(timestep, Real) and 0.0 < timestep <= 1.0):
            raise DemlawsError(f"timestep = {timestep!r}: a share of the critical step, above 0 and up to 1")
        stepper = [yade.GlobalStiffnessTimeStepper(timestepSafetyCoefficient=timestep, timeStepUpdateInterval=10)]
    if hasattr(law, "binding"):
        law.binding.share = timestep
    return [
        yade.ForceResetter(),
        yade.InsertionSortCollider(bounds, verletDist=-verlet),
        *before,
        yade.InteractionLoop(geometries, [physics or yade.Ip2_FrictMat_FrictMat_MindlinPhys()], [law]),
        *stepper,
        *after,
        newton or yade.NewtonIntegrator(damping=0),
    ]
