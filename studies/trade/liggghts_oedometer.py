"""The scene of `studies.trade.packings` in LIGGGHTS: one run a way of computing it."""

import resource
from pathlib import Path
from typing import NamedTuple

import numpy as np

from demlaws.errors import quiet
from demlaws.liggghts.build import library_path
from demlaws.liggghts.export import table_words
from demlaws.liggghts.run import HEAD, run
from demlaws.plugins.grains import Case, Grain
from studies.trade import candidates

DRAG = 3e3  # of the smaller grain's speed [1/s]: the same for every law; damping in contacts differs, and edinburgh bears none

CASE = """\
processors      1 1 1
read_data       start.data
neighbor        4e-4 bin
neigh_modify    delay 0
fix             m1 all property/global youngsModulus peratomtype {young}
fix             m2 all property/global poissonsRatio peratomtype {poisson}
fix             m3 all property/global coefficientRestitution peratomtypepair {restitution}
fix             m4 all property/global coefficientFriction peratomtypepair {friction}
{more}pair_style      gran model {model} tangential history {words}
pair_coeff      * *
timestep        {dt:.10g}
fix             gravity all gravity 9.81 vector 0 0 -1
fix             drag all viscous {drag:.10g}
fix             floor all wall/gran model {model} tangential history primitive type 3 zplane 0.0 {words}
fix             left all wall/gran model {model} tangential history primitive type 3 xplane 0.0 {words}
fix             right all wall/gran model {model} tangential history primitive type 3 xplane {width:.10g} {words}
fix             front all wall/gran model {model} tangential history primitive type 3 yplane 0.0 {words}
fix             rear all wall/gran model {model} tangential history primitive type 3 yplane {width:.10g} {words}
fix             move all nve/sphere
compute         contacts all pair/gran/local force_normal
compute         places all property/atom z radius
variable        upper atom c_places[1]+c_places[2]
compute         top all reduce max v_upper
variable        top equal c_top
variable        centre equal xcm(all,z)
thermo_style    custom step v_centre v_top ke
thermo_modify   norm no lost ignore format float %.12g
thermo          1000
run             {settle}
variable        touching equal ${{top}}
fix             plate all mesh/surface/stress file plate.stl type 3 move 0 0 ${{touching}}
fix             press all wall/gran model {model} tangential history mesh n_meshes 1 meshes plate {words}
variable        stress equal f_plate[3]/{area:.10g}
variable        speed equal -{speed:.10g}
thermo_style    custom step v_stress v_touching v_centre v_speed
thermo_modify   norm no lost ignore format float %.12g
thermo          {every}
fix             drive all move/mesh mesh plate linear 0. 0. -{speed:.10g}
label           pressing
run             {every}
if              "${{stress}} >= {full:.10g}" then "jump SELF pressed"
jump            SELF pressing
label           pressed
unfix           drive
variable        speed equal 0.0
run             {hold}
variable        least equal 0.8*${{stress}}
dump            forces all local 1 post/forces.txt c_contacts[1] c_contacts[2] c_contacts[3]
run             0
undump          forces
variable        speed equal {back:.10g}
fix             drive all move/mesh mesh plate linear 0. 0. {back:.10g}
label           easing
run             {every}
if              "${{stress}} < ${{least}}" then "jump SELF eased"
jump            SELF easing
label           eased
"""
EVERY = 40  # steps between two readings of the plate


def data_text(ends, atoms, velocities=(), types=2):
    """A data file: ends of the box [m] along x, y, z; of each particle type, diameter, density, place; velocity and spin."""
    lines = ["data", "", f"{len(atoms)} atoms", f"{types} atom types", ""]
    lines += [f"{low:.17g} {high:.17g} {a}lo {a}hi" for a, (low, high) in zip("xyz", ends, strict=True)]
    for title, rows in (("Atoms", atoms), ("Velocities", velocities)):
        if rows:
            lines += ["", title, "", *(" ".join([str(n), *(f"{v:.17g}" for v in row)]) for n, row in enumerate(rows, start=1))]
    return "\n".join(lines) + "\n"


def data_of(centres, radii, width, density, types=3):
    """A data file; the type is the number of the radius, smallest first."""
    kinds = {radius: n + 1 for n, radius in enumerate(sorted(set(radii)))}
    side = -2.0 * max(radii), width + 2.0 * max(radii)
    atoms = [(kinds[radius], 2 * radius, density, *place) for place, radius in zip(centres, radii, strict=True)]
    return data_text((side, side, (side[0], centres[:, 2].max() + 6.0 * max(radii))), atoms, types=types)


def plate(width):
    """A mesh file: a square plate at height 0, of two triangles, 4 mm wider than the box of this width [m] on each side."""
    low, high = (f"{x:.9g}" for x in (-0.004, width + 0.004))
    facets = ""
    for third, second in ((f"{high} {high}", f"{high} {low}"), (f"{low} {high}", f"{high} {high}")):
        vertices = "".join(f"   vertex {place} 0\n" for place in (f"{low} {low}", second, third))
        facets += f" facet normal 0 0 1\n  outer loop\n{vertices}  endloop\n endfacet\n"
    return f"solid flat\n{facets}endsolid flat\n"


def grains(given):
    """One `Grain` a size, smallest first."""
    return [Grain(radius, candidates.GRANITE, candidates.SURFACE) for radius in sorted(set(given["radii"]))]


def pairwise(values):
    """A peratomtypepair property of three types as LIGGGHTS reads it, from the values of 11, 12, 22, 1-wall, 2-wall."""
    a, b, c, d, e = values
    return "3 " + " ".join(f"{v:.12g}" for v in (a, b, d, b, c, e, d, e, e))


class EdinburghFit(NamedTuple):
    """Stock edinburgh/stiffness, P = k1 δ^n; ratio: k2/k1."""

    exponent: float
    stiffness: float
    ratio: float


def edinburgh_fit(law, load):
    """The model with the overlap and tangent of `law` (one contact) at `load` [N] of first loading, and its plastic overlap."""
    with quiet():
        overlap = float(law.overlap(load))
        exponent = float(law.stiffness(overlap)) * overlap / load
        plastic = float(law.follow(np.array([overlap])).plastic_overlap[0]) if law.state_size else 0.0
    kept = (max(plastic, 0.0) / overlap) ** exponent
    return EdinburghFit(exponent, load / overlap**exponent, 1.0 / (1.0 - kept))


def edinburgh(laws, load):
    """Property lines of stock edinburgh that follows the laws of the contacts 11, 12, 22, 1-wall, 2-wall near `load` [N].

    The model has one exponent for all pairs: that of the first.
    """
    fits = [edinburgh_fit(law, load) for law in laws]
    exponent = fits[0].exponent
    stiffness = [load / float(law.overlap(load)) ** exponent for law in laws]
    unloading = pairwise([f.ratio for f in fits])
    return edinburgh_lines(pairwise(stiffness), unloading, f"{exponent:.12g}", pairwise([0.0] * 5))


def edinburgh_lines(loading, unloading, exponent, none="1 0"):
    """Property lines of stock edinburgh without adhesion, of texts as LIGGGHTS reads them; none: 0 for every pair of types."""
    pairs = {
        "LoadingStiffness": loading,
        "UnloadingStiffness": unloading,
        **dict.fromkeys(("pullOffForce", "surfaceEnergy", "coefficientAdhesionStiffness"), none),
    }
    lines = [f"fix e_{name} all property/global {name} peratomtypepair {value}\n" for name, value in pairs.items()]
    scalars = {"overlapExponent": exponent, "adhesionExponent": "1"}
    lines += [f"fix e_{name} all property/global {name} scalar {value}\n" for name, value in scalars.items()]
    return "".join(lines)


def model_lines(folder, given, way):
    """(model, words, further property lines) of a way; its tables are written to `folder`."""
    two = grains(given)
    if way["model"] == "hertz":
        return "hertz", "tangential_damping on", ""
    if way["model"] == "edinburgh":
        contacts = [two[0].contact(two[0]), two[0].contact(two[1]), two[1].contact(two[1])]
        contacts += [g.contact(g, wall=True) for g in two]
        laws = [candidates.RICHEST.bind(contact) for contact in contacts]
        return "edinburgh/stiffness", "", edinburgh(laws, given["mean_force"])
    case = Case(way["law"], tuple(two), way["unloading"], dict(way["options"]), way["rtol"])
    words, _ = table_words(case, folder)
    return "demlaws/table", words, ""


def numbers(given):
    """Numbers of the test that inputs of LIGGGHTS and LAMMPS state alike."""
    return {
        "dt": given["dt"],
        "drag": DRAG * given["density"] * 4 / 3 * np.pi * min(given["radii"]) ** 3,
        "area": given["width"] ** 2,
        "settle": round(given["settle"] / given["dt"]),
        "speed": given["speed"],
        "back": given["back"],
        "full": given["stress"],
        "every": EVERY,
    }


def timed(function):
    """(result of a function, processor seconds of the programs that it starts)."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    result = function()
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return result, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def oedometer(folder, given, way):
    """One way through the test; what it wrote, as YADE's does (see studies.trade.packings.outcome)."""
    folder, radii = Path(folder), given["radii"]
    (folder / "post").mkdir(parents=True, exist_ok=True)
    (folder / "start.data").write_text(data_of(np.array(given["centres"]), radii, given["width"], given["density"]))
    (folder / "plate.stl").write_text(plate(given["width"]))
    model, words, lines = model_lines(folder, given, way)
    friction = given["friction"]
    values = {
        **numbers(given),
        "model": model,
        "words": words,
        "more": lines,
        "young": " ".join([f"{given['young']:.10g}"] * 3),
        "poisson": " ".join([f"{given['poisson']:.10g}"] * 3),
        "restitution": pairwise([1.0] * 5),
        "friction": pairwise([friction, friction, friction, 0.0, 0.0]),
        "width": given["width"],
        "hold": round(given["hold"] / given["dt"]),
    }
    path = folder / "in.oedometer"
    path.write_text((HEAD + CASE).format(**values))
    plugin = model == "demlaws/table"
    if plugin:
        library_path()  # compiled before the clock starts
    log, seconds = timed(lambda: run(path, plugin=plugin))
    forces = np.linalg.norm(np.loadtxt(folder / "post" / "forces.txt", skiprows=9), axis=1)
    height = log["touching"] + np.append(0.0, np.cumsum(log["speed"][1:] * np.diff(log["Step"]))) * given["dt"]
    rows, up = np.stack([height, log["stress"]], 1), int(np.argmax(log["speed"] > 0.0))
    held = {**held_state(given, forces), "plate": float(height[up - 1]), "stress": float(log["stress"][up - 1])}
    return {
        "height": float(log["centre"][0]),
        "branches": [rows[:up].tolist(), rows[up - 1 :].tolist()],
        "held": held,
        "steps": int(log["Step"][-1]),
        "seconds": seconds,
    }


def held_state(given, forces):
    """Forces [N] of the grains' contacts that carry one, and how many contacts a grain has."""
    forces = forces[forces > 0.0]
    return {"forces": forces.tolist(), "coordination": 2.0 * forces.size / len(given["radii"])}
