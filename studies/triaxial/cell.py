"""LAMMPS inputs of a triaxial cell: grains between six smooth walls, three of which move as pistons under their load.

The walls at 0 are fixed. Each of the other three has a mass and a dashpot, and moves by the force that its load exceeds that of
the grains: the sides carry p, the top p + q. There is no gravity and no friction at the walls. A periodic box would be simpler,
but `fix rigid/small` gives the spheres of a clump that lies across a side the velocity of one image (LAMMPS of 22 Jul 2025):
while the box deforms, its contacts slide without end.

Granite has its full modulus and density. Softer grains would not save steps: their cycles have larger strains, which must be
slower (the steps of a cycle follow from the sample's period over that of a contact, and neither changes).
"""

from pathlib import Path
from typing import NamedTuple

import numpy as np

import demlaws as dl
from demlaws.contact import GRANITE_YIELD_PRESSURE
from demlaws.errors import quiet
from demlaws.lammps.run import HEAD
from studies.trade.liggghts_oedometer import data_text

YOUNG, POISSON, DENSITY, RESTITUTION = 60.6e9, 0.25, 2650.0, 0.7
MODULUS = YOUNG / (2 * (1 - POISSON**2))
RADII, SHARES = (18e-3, 20e-3, 22e-3), (0.3, 0.4, 0.3)
"""Of the sphere of a grain's volume [m]."""
REACH = 0.06  # [m]: only spheres that begin so near to a wall can touch it within a part of a test
MASS, DELAY = 3.0, 3e-3  # [kg], [s] of a piston: a grain layer's mass; its dashpot is MASS/DELAY
LARGEST, YIELDING = 2e4, 5e3  # [N], of the tables: grains collide in a collapse; corners that yield are pressed flat before
MARGIN = 0.05  # [m] of LAMMPS's box beyond the walls

GROUND = """\
{head}boundary        f f f
newton          on
{start}
neighbor        2e-3 bin
neigh_modify    delay 0{exclude}
pair_style      granular
pair_coeff      * * demlaws/table pair.tbl {young:.10g} {restitution} {poisson} radius_tolerance 0.3 &
                tangential demlaws 1.0 {friction:g} damping demlaws/tangent
variable        wall string "demlaws/table wall.tbl {hard:.10g} {restitution} {poisson} &
                tangential demlaws 1.0 0.0 damping demlaws/tangent"
timestep        {dt:.10g}
fix             move all {move}
compute         moves all ke
compute         met all contact/atom
compute         contacts all reduce sum c_met
"""
WALLS = """\
region          low{a} block {low}
group           low{a} region low{a}
fix             low{a} low{a} wall/gran granular ${{wall}} {a}plane 0.0 NULL
region          high{a} block {high}
group           high{a} region high{a}
variable        d{a} equal 0.0
region          piston{a} plane {point} {normal} move {moved}
fix             press{a} high{a} wall/gran/region granular ${{wall}} region piston{a} contacts
compute         push{a} high{a} reduce sum f_press{a}[{column}]
"""
"""For each axis a; column: of the force along it."""
PISTONS = """\
reset_timestep  0
variable        x equal {x:.17g}+v_dx
variable        y equal {y:.17g}+v_dy
variable        z equal {z:.17g}+v_dz
variable        side equal {side}
variable        top equal {top}
variable        px equal -c_pushx/(v_y*v_z)
variable        py equal -c_pushy/(v_x*v_z)
variable        pz equal -c_pushz/(v_x*v_y)
# velocities at the last step, accelerations, velocities: sums over the steps are running means times their number
variable        ux equal f_sum[1]*step*dt
variable        uy equal f_sum[2]*step*dt
variable        uz equal f_sum[3]*step*dt
variable        ax equal -(c_pushx+v_side*v_y*v_z)/{mass:g}-v_ux/{delay:g}
variable        ay equal -(c_pushy+v_side*v_x*v_z)/{mass:g}-v_uy/{delay:g}
variable        az equal -(c_pushz+v_top*v_x*v_y)/{mass:g}-v_uz/{delay:g}
variable        vx equal v_ux+v_ax*dt
variable        vy equal v_uy+v_ay*dt
variable        vz equal v_uz+v_az*dt
variable        dx equal f_sum[4]*step*dt
variable        dy equal f_sum[5]*step*dt
variable        dz equal f_sum[6]*step*dt
fix             sum all ave/time 1 1 1 v_ax v_ay v_az v_vx v_vy v_vz ave running
{more}thermo_style    custom step v_dx v_dy v_dz v_px v_py v_pz v_top c_contacts c_moves
thermo_modify   norm no format float %.17g
thermo          {every}
run             {steps}
"""
MOLECULES = "fix             grain all property/atom mol ghost yes"
WRITE = "write_dump      all custom post/{} id mol diameter mass xu yu zu modify sort id format float %.17g\n"
COLLAPSE = """\
variable        left equal v_z
fix             stop all halt 50 v_left < {:.10g} error continue
"""

TETRAHEDRON = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) / 3**0.5
SHAPES = {"tetrapods": (0.72 * TETRAHEDRON, 0.6), "spheres": (np.zeros((1, 3)), 1.0)}
"""Places and radius of the members of a grain, before it is scaled to its volume."""


class Law(NamedTuple):
    """Contact law of grains: combined roughness [µm], rule, radius of the edges [mm] (0: that of the spheres).

    Force and yield on edges of radius R_e are those of spheres of radius R with E* √(R_e/R) and p_y R_e/R: so one table
    serves spheres [our derivation].
    """

    law: str = "hertz"
    sigma: float = 0.0
    rule: str = "hertz"
    edge: float = 0.0

    def softer(self, radius):
        """E* over granite's."""
        return (1e-3 * self.edge / radius) ** 0.5 if self.edge else 1.0

    def save(self, path, radius):
        """Write its table for contacts of this R [m]."""
        contact = dl.Contact(
            radius=radius, modulus=MODULUS * self.softer(radius), sigma=1e-6 * self.sigma, fractal_dimension=2.22
        )
        more = {} if self.law == "hertz" else {"unloading": self.rule}
        largest = LARGEST
        if self.law == "rough-plastic":
            share = 1e-3 * self.edge / radius if self.edge else 1.0
            more["yield_pressure"], largest = GRANITE_YIELD_PRESSURE * share, YIELDING
        with quiet():  # corners that yield are far beyond R/10 at the largest force
            dl.law(self.law, contact, **more).tabulate(rtol=1e-5, max_force=largest).save(path)


class Grains(NamedTuple):
    """Rows (molecule, diameter, density, place) of the spheres, volume of the grains [m³], edge of their box [m]."""

    rows: np.ndarray
    solid: float
    side: float


def volume(shape, samples=400_000):
    """Volume of a shape of `SHAPES`, by random points: within 0.3 %."""
    places, radius = SHAPES[shape]
    reach = np.abs(places).max() + radius
    points = np.random.default_rng(1).uniform(-reach, reach, (samples, 3))
    inside = (np.linalg.norm(points[:, None] - places, axis=2) < radius).any(axis=1)
    return float(inside.mean()) * (2 * reach) ** 3


def scale_of(shape):
    """What a shape is multiplied by to have the volume of a unit sphere."""
    return (4 / 3 * np.pi / volume(shape)) ** (1 / 3)


def contact_radius(shape):
    """R [m] of two members of grains of the middle size."""
    return 0.5 * scale_of(shape) * SHAPES[shape][1] * RADII[1]


def loose(shape, count, seed):
    """`Grains` on a lattice, turned at random; members have the density that gives a grain its mass."""
    from scipy.spatial.transform import Rotation

    places, member = SHAPES[shape]
    random, scale = np.random.default_rng(seed), scale_of(shape)
    radius = random.choice(RADII, count, p=SHARES)
    pitch = 2.04 * scale * (np.linalg.norm(places, axis=1).max() + member) * max(RADII)
    across = int(np.ceil(count ** (1 / 3)))
    cells = np.sort(random.permutation(across**3)[:count])
    centre = (np.stack(np.unravel_index(cells, (across,) * 3), 1) + 0.5) * pitch
    turns = Rotation.random(count, random_state=seed).as_matrix()
    spheres = centre[:, None] + np.einsum("nab,mb->nma", turns, places) * (scale * radius)[:, None, None]
    members = len(places)
    density = DENSITY * volume(shape) / (members * 4 / 3 * np.pi * member**3)
    size = np.repeat(2 * scale * member * radius, members)
    rows = [np.repeat(np.arange(count) + 1, members), size, np.full(size.size, density), spheres.reshape(-1, 3)]
    return Grains(np.column_stack(rows), float(np.sum(4 / 3 * np.pi * radius**3)), across * pitch)


def write_data(path, rows, box):
    """A data file of spheres."""
    ends = [(-MARGIN, side + MARGIN) for side in box]
    text = data_text(ends, [(1, *row[1:]) for row in rows], types=1)
    text += "\nMolecules\n\n" + "".join(f"{n} {int(row[0])}\n" for n, row in enumerate(rows, start=1))
    Path(path).write_text(text)


def read_dump(path):
    """Rows as of `Grains`."""
    rows = np.loadtxt(path, skiprows=9)[:, 1:]
    rows[:, 2] /= np.pi / 6 * rows[:, 1] ** 3
    return rows


def ground(law, shape, start, dt, box, friction, reach=REACH):
    """Input up to the walls; start: "data", or the name of a restart file; box: distances of the walls [m]."""
    read = {"data": f"{MOLECULES}\nread_data       start.data fix grain NULL Molecules"}
    text = GROUND.format(
        head=HEAD,
        start=read.get(start, f"read_restart    {start}\n{MOLECULES}"),
        exclude=" exclude molecule/intra all",
        young=YOUNG * law.softer(contact_radius(shape)),
        hard=YOUNG,
        restitution=RESTITUTION,
        poisson=POISSON,
        friction=friction,
        dt=dt,
        move="rigid/small molecule" if len(SHAPES[shape][0]) > 1 else "nve/sphere",
    )
    for n, axis in enumerate("xyz"):

        def along(value, other, n=n):
            return " ".join(str(value) if k == n else other for k in range(3))

        text += WALLS.format(
            a=axis,
            low=along(f"INF {reach:.10g}", "INF INF"),
            high=along(f"{box[n] - reach:.10g} INF", "INF INF"),
            point=along(f"{box[n]:.17g}", "0"),
            normal=along(-1, "0"),
            moved=along(f"v_d{axis}", "NULL"),
            column=n + 2,
        )
    return text


def pistons(box, side, top, steps, every, delay=DELAY, more=""):
    """Motion of the walls under the loads `side` and `top` [Pa], formulas of LAMMPS."""
    places = dict(zip("xyz", map(float, box), strict=True))
    return PISTONS.format(**places, side=side, top=top, mass=MASS, delay=delay, steps=steps, every=every, more=more)


def walls(log, box):
    """Distances of the walls [m] in each row: a row of LAMMPS has the sum up to it over one step more."""
    step = log["Step"]
    share = np.where(step > 0, (step + 1) / np.maximum(step, 1), 1.0)
    return np.array([box[n] + log[f"d{axis}"] * share for n, axis in enumerate("xyz")])
