"""The scene of `studies.trade.packings` in LIGGGHTS: one run a way of computing it."""

import resource
from pathlib import Path

import numpy as np

from demlaws.grains import Case, Grain
from demlaws.liggghts.build import library_path
from demlaws.liggghts.export import table_words
from demlaws.liggghts.run import HEAD, run
from studies.trade.peers import edinburgh_fit

DRAG = 3e3  # of the smaller grain's speed [1/s]: the same for every law; damping in contacts differs, and edinburgh bears none

START = """\
processors      1 1 1
read_data       start.data
neighbor        4e-4 bin
neigh_modify    delay 0
"""
MATERIAL = """\
fix             m1 all property/global youngsModulus peratomtype {young}
fix             m2 all property/global poissonsRatio peratomtype {poisson}
fix             m3 all property/global coefficientRestitution peratomtypepair {types} {restitution}
fix             m4 all property/global coefficientFriction peratomtypepair {types} {friction}
{more}pair_style      gran model {model} tangential history {words}
pair_coeff      * *
timestep        {dt:.10g}
"""
CASE = """\
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
"""
FORCES = """\
dump            {name} all local 1 post/{name}.txt c_contacts[1] c_contacts[2] c_contacts[3]
run             0
undump          {name}
"""
TOUCHING = "variable        touching equal ${{top}}\n"
PRESS = (
    CASE
    + TOUCHING
    + """\
fix             plate all mesh/surface/stress file plate.stl type 3 move 0 0 ${{touching}}
fix             press all wall/gran model {model} tangential history mesh n_meshes 1 meshes plate {words}
variable        stress equal f_plate[3]/{area:.10g}
variable        touched equal ${{touching}}
variable        way equal -{speed:.10g}
thermo_style    custom step v_stress v_touched v_centre v_way
thermo_modify   norm no lost ignore format float %.12g
thermo          {every}
variable        turn loop {cycles}
label           again
variable        way equal -{speed:.10g}
fix             drive all move/mesh mesh plate linear 0. 0. -{speed:.10g}
label           pressing
run             {every}
if              "${{stress}} >= {full:.10g}" then "jump SELF pressed"
jump            SELF pressing
label           pressed
unfix           drive
variable        way equal 0.0
if              "${{turn}} > 1" then "jump SELF held"
run             {hold}
variable        least equal {least}
"""
    + FORCES.format(name="forces")
    + """\
label           held
variable        way equal {back:.10g}
fix             drive all move/mesh mesh plate linear 0. 0. {back:.10g}
label           easing
run             {every}
if              "${{stress}} < ${{least}}" then "jump SELF eased"
jump            SELF easing
label           eased
unfix           drive
next            turn
jump            SELF again
"""
)
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


def flat(axis, *spans):
    """A mesh file: a flat wall across `axis`, of two triangles; spans: (low, high) [m] along the other two axes."""
    (a, b), (c, d) = spans
    normal = " ".join(str(int(k == axis)) for k in range(3))
    facets = ""
    for three in (((a, c), (b, c), (b, d)), ((a, c), (b, d), (a, d))):
        places = [" ".join(f"{v:.9g}" for v in np.insert(place, axis, 0.0)) for place in three]
        vertices = "".join(f"   vertex {place}\n" for place in places)
        facets += f" facet normal {normal}\n  outer loop\n{vertices}  endloop\n endfacet\n"
    return f"solid flat\n{facets}endsolid flat\n"


EDGE = 0.004  # [m] by which a wall reaches beyond the packing


def grains(given):
    """One `Grain` a size, smallest first."""
    if "grains" in given:
        return given["grains"]
    from studies.trade import candidates

    return [Grain(radius, candidates.GRANITE, candidates.SURFACE) for radius in sorted(set(given["radii"]))]


def pairwise(values):
    """A peratomtypepair property of three types as LIGGGHTS reads it, from the values of 11, 12, 22, 1-wall, 2-wall."""
    a, b, c, d, e = values
    return "3 " + " ".join(f"{v:.12g}" for v in (a, b, d, b, c, e, d, e, e))


def edinburgh(law, contacts, load):
    """Property lines of stock edinburgh that follows a law on the contacts 11, 12, 22, 1-wall, 2-wall near `load` [N].

    The model has one exponent for all pairs: that of the first.
    """
    fits = [edinburgh_fit(law(contact), load) for contact in contacts]
    exponent = fits[0].exponent
    stiffness = [load / float(law(contact).overlap(load)) ** exponent for contact in contacts]
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
    from studies.trade import candidates

    two = grains(given)
    if way["model"] == "hertz":
        return "hertz", "tangential_damping on", ""
    if way["model"] == "edinburgh":
        contacts = [two[0].contact(two[0]), two[0].contact(two[1]), two[1].contact(two[1])]
        contacts += [g.contact(g, wall=True) for g in two]

        def richest(contact):
            return candidates.RICHEST.bind(contact)

        return "edinburgh/stiffness", "", edinburgh(richest, contacts, given["mean_force"])
    case = Case(way["law"], tuple(two), way["unloading"], dict(way["options"]), way["rtol"])
    words, _ = table_words(case, folder)
    return "demlaws/table", words, ""


def prepare(path, given, way, centres, case, drag=DRAG, **more):
    """Write data, plate, tables and the input `path` of a test; whether it needs the plugin. more: other numbers of `case`."""
    folder = path.parent
    (folder / "post").mkdir(parents=True, exist_ok=True)
    radii, width, dt = given["radii"], given["width"], given["dt"]
    (folder / "start.data").write_text(data_of(centres, radii, width, given["density"]))
    (folder / "plate.stl").write_text(flat(2, (-EDGE, width + EDGE), (-EDGE, width + EDGE)))
    model, words, lines = model_lines(folder, given, way)
    friction, none = given["friction"], 0.0
    values = {
        "model": model,
        "words": words,
        "more": lines,
        "types": 3,
        "young": " ".join([f"{given['young']:.10g}"] * 3),
        "poisson": " ".join([f"{given['poisson']:.10g}"] * 3),
        "restitution": pairwise([1.0] * 5)[2:],
        "friction": pairwise([friction, friction, friction, none, none])[2:],
        "dt": dt,
        "drag": drag * given["density"] * 4 / 3 * np.pi * min(radii) ** 3,
        "width": width,
        "area": width * width,
        "settle": round(given["settle"] / dt),
        "speed": given["speed"],
        "full": given["stress"],
        "hold": round(given["hold"] / dt),
    }
    path.write_text((HEAD + START + MATERIAL + case).format(**values, **more))
    return model == "demlaws/table"


def carry_out(path, plugin):
    """(log, forces [N] of the contacts at the end of the hold, processor seconds) of an input."""
    if plugin:
        library_path()  # compiled before the clock starts
    log, seconds = timed(lambda: run(path, plugin=plugin))
    return log, contact_forces(path.parent / "post" / "forces.txt"), seconds


def timed(function):
    """(result of a function, processor seconds of the programs that it starts)."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    result = function()
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return result, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def contact_forces(path):
    """Normal forces [N] of the contacts that a local dump holds, those that carry one."""
    forces = np.linalg.norm(np.loadtxt(path, skiprows=9), axis=1)
    return forces[forces > 0.0]


def press(path, given, way, centres, drag=DRAG, **more):
    """Rest, compression, hold, unloading to `least`, repeated `cycles` times; returns the results like yade_oedometer.py."""
    log, forces, seconds = carry_out(path, prepare(path, given, way, centres, PRESS, drag, back=given["back"], **more))
    step, stress, speed = log["Step"], log["stress"], log["way"]
    height = log["touched"] + np.append(0.0, np.cumsum(speed[1:] * np.diff(step))) * given["dt"]
    turns = np.flatnonzero((speed[1:] != speed[:-1]) & (speed[1:] != 0.0)) + 1
    branches = [part.tolist() for part in np.split(np.stack([height, stress], 1), turns)]
    if len(branches) != 2 * more["cycles"]:
        raise RuntimeError(f"{len(branches)} branches of {more['cycles']} cycles")
    end = int(np.append(turns[0], np.flatnonzero(speed == 0.0))[-1])
    held = {**held_state(given, forces), "plate": float(height[end]), "stress": float(stress[end])}
    about = {"steps": int(step[-1]), "seconds": seconds}
    return {"height": float(log["centre"][0]), "branches": branches, "held": held, **about}


def held_state(given, forces):
    """Forces [N] between grains, and how many contacts a grain has."""
    return {"forces": forces.tolist(), "coordination": 2.0 * forces.size / len(given["radii"])}


def oedometer(folder, given, way):
    """One way through the test; what it wrote, as YADE's does (see studies.trade.packings.outcome)."""
    path, own = Path(folder) / "in.oedometer", {"least": "0.8*${stress}", "every": EVERY, "cycles": 1}
    found = press(path, given, way, np.array(given["centres"]), **own)
    found["branches"][1].insert(0, [found["held"]["plate"], found["held"]["stress"]])
    return found
