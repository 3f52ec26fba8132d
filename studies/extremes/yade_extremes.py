"""The extremes inside YADE: how `demlaws.extremes` drives it. `python -m studies.extremes --yade` runs this file under YADE."""

import pickle

import numpy as np
import yade
import yade.utils

from demlaws.contact import GRANITE, Surface
from demlaws.laws import HERTZ
from demlaws.laws.registry import find
from demlaws.make import law as bind_law
from demlaws.yade import Law2_ScGeom_MindlinPhys_Demlaws
from studies.extremes import stability
from studies.extremes.extremes import results
from studies.extremes.stability import POISSON, Balance
from studies.under_yade import serve

O = yade.O  # noqa: E741  YADE's name


class Yade:
    """YADE, in this process."""

    name = "YADE"
    evaluation = "closed form"

    def _scene(self, case, contact, roughness):
        """An empty scene; returns its law functor and a function that gives the material of a modulus and roughness."""
        O.reset()
        labels = {float(s): f"surface{n}" for n, s in enumerate(np.unique(roughness))}
        hardness = GRANITE.hardness if contact.hardness is None else contact.hardness
        surfaces = {name: Surface(s, contact.fractal_dimension, hardness) for s, name in labels.items()}
        given, options = (case.law, case.unloading), case.options
        if find(case.law).needs_map:  # the others serve whatever comes
            given, options = (bind_law(case.law, contact, case.unloading, **options), None), {}
        law = Law2_ScGeom_MindlinPhys_Demlaws(*given, surfaces, **options)
        made = {}

        def material(modulus, sigma):
            key = float(modulus), float(sigma)
            if key not in made:
                young = 2.0 * key[0] * (1.0 - POISSON**2)
                made[key] = yade.FrictMat(young=young, poisson=POISSON, frictionAngle=0.0, density=1.0, label=labels[key[1]])
                O.materials.append(made[key])
            return made[key]

        return law, material

    @staticmethod
    def _sphere(material, radius, place, mass=1.0, free=False):
        body = yade.utils.sphere(tuple(map(float, place)), float(radius), material=material, fixed=not free)
        body.state.mass = float(mass)
        body.state.inertia = yade.Vector3.Ones * (0.4 * float(mass) * float(radius) ** 2)
        O.bodies.append(body)
        return body

    def _pairs(self, group):
        """A scene of pairs, the second sphere of each at x = 0, the first to its left; states of the second ones."""
        law, material = self._scene(group.case, group.contact, group.roughness)
        states, height = [], 0.0
        for n in range(group.size):
            stuff = material(group.modulus[n], group.roughness[n])
            large = max(group.radius1[n], group.radius2[n])
            height += 1.2 * large
            self._sphere(stuff, group.radius1[n], (-(group.radius1[n] + group.radius2[n]), height, 0.0))
            states.append(self._sphere(stuff, group.radius2[n], (0, height, 0)).state)
            height += 1.2 * large
        self._engines(law, 0.0, 1)
        return states

    @staticmethod
    def _engines(law, verlet, axis):
        O.engines = [
            yade.ForceResetter(),
            yade.InsertionSortCollider([yade.Bo1_Sphere_Aabb()], verletDist=verlet, sortAxis=axis),
            yade.InteractionLoop([yade.Ig2_Sphere_Sphere_ScGeom()], [yade.Ip2_FrictMat_FrictMat_MindlinPhys()], [law]),
            yade.NewtonIntegrator(damping=0),
        ]

    def two_spheres(self, group, wanted):
        """Overlaps [m] as YADE's arithmetic has them and forces [N] on the second spheres, [steps, pairs]."""
        states = self._pairs(group)
        O.dt = 1e-12
        vector, places = yade.Vector3, [state.pos for state in states]
        numbers = [2 * n + 1 for n in range(group.size)]
        left = -(group.radius1 + group.radius2)
        force = np.empty_like(wanted)
        for n, row in enumerate(wanted):
            for state, place, x in zip(states, places, row.tolist(), strict=True):
                state.pos = vector(-x, place[1], 0.0)
            O.step()
            force[n] = [O.forces.f(number)[0] for number in numbers]
        distance = -wanted - left
        return -left - np.sqrt(distance * distance), force

    def let_go(self, packing, stretches, steps, every):
        """`Balance`s of a periodic packing; each stretch starts with velocities of its own."""
        radius = packing.radius
        law, material = self._scene(packing.case, packing.law.contact, [packing.roughness])
        stuff = material(packing.modulus, packing.roughness)
        O.periodic = True
        O.cell.hSize = yade.Matrix3(packing.side, 0, 0, 0, packing.side, 0, 0, 0, packing.side)
        states = [
            self._sphere(stuff, r, x, m, True).state for r, x, m in zip(radius, packing.position, packing.mass, strict=True)
        ]
        self._engines(law, -0.5, 0)
        O.dt = packing.dt
        mass, found = packing.mass, []

        def velocities():
            return np.array([state.vel for state in states])

        for stretch in stretches:
            # leapfrog keeps velocities half a step behind positions: a shake sets those of the last half step
            for state, v in zip(states, stretch.tolist(), strict=True):
                state.vel = yade.Vector3(*v)
            rows = []
            for n in range(steps):
                if n % every and n < steps - 1:
                    O.step()
                    continue
                before = velocities()
                O.step()
                after = velocities()
                now = 0.5 * (before + after)
                total = law.totals()
                rows.append(
                    Balance(
                        0.5 * float(np.sum(mass[:, None] * now**2)),
                        total.stored,
                        total.dissipated,
                        np.sum(mass[:, None] * after, axis=0),
                        O.interactions.countReal(),
                    )
                )
            found.append(rows)
        return found

    def stopped_by(self, touching, where, value):
        """YADE's error after a fault (see `extremes.stops`), or None."""
        case, pair = stability.Case(HERTZ, "elastic", "closed form"), stability.GRANITE
        radius = 2.0 * pair.radius
        law, material = self._scene(case, pair, [1e-6])
        stuff = material(pair.modulus, 1e-6)
        spacing = 1.9999 * radius if touching else 3.0 * radius
        bodies = [self._sphere(stuff, radius, (n * spacing, 0, 0), 0.01, True) for n in range(4)]
        self._engines(law, -0.1, 0)
        O.dt = 1e-7
        O.step()
        O.step()
        wrong = yade.Vector3(float(value), 0.0, 0.0)
        if where == "position":
            bodies[2].state.pos = wrong
        else:
            bodies[2].state.vel = wrong
        try:
            for _ in range(250):
                O.step()
        except RuntimeError as error:
            return str(error).strip().split("\n")[-1].removeprefix("demlaws.errors.DemlawsError: ")
        return None


def answer(request):
    """Print each result as a line that `extremes.run` understands."""
    for found in results(Yade(), request):
        print("PROGRESS " + pickle.dumps(found).hex(), flush=True)


if __name__ == "__main__":
    serve(answer)
