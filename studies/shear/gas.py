"""Total energy of a closed gas of 64 spheres without damping: a contact model that creates energy heats it."""

import tempfile
from pathlib import Path
from typing import NamedTuple

import numpy as np

import demlaws as dl
from demlaws import lammps, liggghts

CONTACT = dl.Contact(
    radius=4.35e-3, modulus=60.6e9 / (2 * (1 - 0.25**2)), roughness=2.4e-6, fractal_dimension=2.22, hardness=6.266e9
)
DIAMETER, BOX = 0.0174, 0.08
START = """\
{style}
atom_modify map array
boundary f f f
units si
{communication}
region box block -0.001 0.081 -0.001 0.081 -0.001 0.081 units box
create_box 1 box
{places}
set group all diameter 0.0174
set group all density 2650
neighbor 0.002 bin
{model}
timestep 2e-7
fix integr all nve/sphere
compute ke all ke
compute er all erotate/sphere
{energy}
thermo_style custom step c_ke c_er v_stored v_lost
thermo_modify norm no lost error format float %.17e
thermo {every}
run {steps}
"""
LIGGGHTS = """\
fix m1 all property/global youngsModulus peratomtype 60.6e9
fix m2 all property/global poissonsRatio peratomtype {poisson}
fix m3 all property/global coefficientRestitution peratomtypepair 1 1.0
fix m4 all property/global coefficientFriction peratomtypepair 1 {friction}
pair_style gran model {normal} tangential {tangential} {words}
pair_coeff * *
{walls}"""
LAMMPS = """\
pair_style granular
pair_coeff * * {normal} tangential {tangential} NULL 0 {friction} damping velocity
{walls}"""


class Result(NamedTuple):
    """Energies at each output over that of the start."""

    kept: np.ndarray  # kinetic, rotational and stored
    balance: np.ndarray  # with what the contacts report as dissipated; of stock models the same as kept

    @property
    def gain(self) -> float:
        """Largest gain of energy, 0 or more."""
        return float(self.kept.max() - 1.0)


def _places():
    random = np.random.default_rng(3)
    lines = []
    for n, (place, speed) in enumerate(
        zip(0.01 + 0.02 * np.argwhere(np.ones((4, 4, 4))), random.normal(0, 0.3, (64, 3)), strict=True)
    ):
        lines.append("create_atoms 1 single {:.2f} {:.2f} {:.2f} units box".format(*place))
        lines.append("set atom {} vx {:.6f} vy {:.6f} vz {:.6f}".format(n + 1, *speed))
    return "\n".join(lines)


def _simulate(engine, text, folder):
    (folder / "in.gas").write_text(text)
    log = engine.run(folder / "in.gas")
    names = {name.removeprefix("c_").removeprefix("v_"): values for name, values in log.items()}
    kept = names["ke"] + names["er"] + names["stored"]
    return Result(kept / kept[0], (kept + names["lost"]) / kept[0])


def simulate(engine, law, tangential, friction=100.0, poisson=0.25, words="", steps=150_000):
    """`Result` of 30 ms in "liggghts" or "lammps" with a law (None: the engine's own Hertz) and one of its tangential models.

    words: settings behind the table, such as "shear slip".
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        energy = "variable stored equal 0\nvariable lost equal 0"
        if law is not None:
            law.tabulate(rtol=1e-5, max_force=2e4).save(folder / "law.tbl")
            energy = 'compute en all demlaws/energy\nvariable stored equal "c_en[1]"\nvariable lost equal "c_en[2]"'
        if engine == "liggghts":
            normal = "hertz" if law is None else "demlaws/table"
            walls = "".join(
                f"fix {a}{i} all wall/gran model {normal} tangential {tangential.split()[0]} primitive type 1 {a}plane {p}\n"
                for a in "xyz"
                for i, p in (("l", 0.0), ("h", BOX))
            )
            model = LIGGGHTS.format(
                poisson=poisson,
                friction=friction,
                normal=normal,
                tangential=tangential,
                words="" if law is None else f"table law.tbl {words}",
                walls=walls,
            )
            style, communication = "atom_style granular", "newton off\ncommunicate single vel yes\nhard_particles yes"
        else:
            normal = f"{'hertz/material' if law is None else 'demlaws/table law.tbl'} 60.6e9 0 {poisson} {words}".strip()
            terms = f"granular {normal} tangential {tangential} NULL 0 {friction} damping velocity"
            walls = "".join(
                f"fix {a}{i} all wall/gran {terms} {a}plane {p}\n"
                for a in "xyz"
                for i, p in (("l", "0 NULL"), ("h", f"NULL {BOX}"))
            )
            model = LAMMPS.format(normal=normal, tangential=tangential, friction=friction, walls=walls)
            style, communication = "atom_style sphere", "comm_modify vel yes"
        text = START.format(
            style=style,
            communication=communication,
            places=_places(),
            model=model,
            energy=energy,
            every=steps // 6,
            steps=steps,
        )
        return _simulate({"liggghts": liggghts, "lammps": lammps}[engine], text, folder)
