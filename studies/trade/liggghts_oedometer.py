"""The scene of `studies.trade.packings` in LIGGGHTS: one run a way of computing it."""

import resource
from pathlib import Path

import numpy as np

from demlaws.grains import Case, Grain
from demlaws.liggghts.build import library_path
from demlaws.liggghts.export import stock_fit, table_words
from demlaws.liggghts.run import HEAD, run

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
variable        touching equal ${{top}}
fix             plate all mesh/surface/stress file plate.stl type 3 move 0 0 ${{touching}}
fix             press all wall/gran model {model} tangential history mesh n_meshes 1 meshes plate {words}
fix             drive all move/mesh mesh plate linear 0. 0. -{speed:.10g}
variable        stress equal f_plate[3]/{area:.10g}
variable        touched equal ${{touching}}
thermo_style    custom step v_stress v_touched v_centre ke
thermo_modify   norm no lost ignore format float %.12g
thermo          {every}
label           pressing
run             {every}
if              "${{stress}} >= {full:.10g}" then "jump SELF pressed"
jump            SELF pressing
label           pressed
unfix           drive
run             {hold}
variable        least equal 0.8*${{stress}}
dump            forces all local 1 post/forces.txt c_contacts[1] c_contacts[2] c_contacts[3]
run             0
undump          forces
fix             drive all move/mesh mesh plate linear 0. 0. {back:.10g}
label           easing
run             {every}
if              "${{stress}} < ${{least}}" then "jump SELF eased"
jump            SELF easing
label           eased
"""
EVERY = 40  # steps between two readings of the plate


def _data(centres, radii, width, density, types=3):
    """A data file; the type is the number of the radius, smallest first."""
    kinds = {radius: n + 1 for n, radius in enumerate(sorted(set(radii)))}
    low, high = -2.0 * max(radii), width + 2.0 * max(radii)
    lines = ["start", "", f"{len(radii)} atoms", f"{types} atom types", ""]
    lines += [
        f"{low} {high} xlo xhi",
        f"{low} {high} ylo yhi",
        f"{low} {centres[:, 2].max() + 6.0 * max(radii)} zlo zhi",
        "",
        "Atoms",
        "",
    ]
    for n, (place, radius) in enumerate(zip(centres, radii, strict=True)):
        x, y, z = (f"{v:.17g}" for v in place)
        lines.append(f"{n + 1} {kinds[radius]} {2 * radius:.17g} {density:.17g} {x} {y} {z}")
    return "\n".join(lines) + "\n"


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
    fits = [stock_fit(law(contact), load, "edinburgh") for contact in contacts]
    exponent = fits[0].parameters["overlapExponent"]
    stiffness = [load / float(law(contact).overlap(load)) ** exponent for contact in contacts]
    unloading = pairwise([f.parameters["UnloadingStiffness"] for f in fits])
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
    (folder / "start.data").write_text(_data(centres, radii, width, given["density"]))
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


def oedometer(folder, given, way):
    """One way through the test; what it wrote, as YADE's does (see studies.trade.packings.outcome)."""
    path = Path(folder) / "in.oedometer"
    back = given["speed"] / 3
    plugin = prepare(path, given, way, np.array(given["centres"]), CASE, back=back, every=EVERY)
    log, forces, seconds = carry_out(path, plugin)
    steps = log["Step"]
    peak, held = turns(given, log, round(given["hold"] / given["dt"]))
    down = given["speed"] * (np.minimum(steps, steps[peak]) - steps[0]) * given["dt"]
    up = back * np.maximum(steps - steps[held], 0.0) * given["dt"]
    return outcome(log, log["touched"] - down + up, peak, held, forces, seconds)


def turns(given, log, hold):
    """Rows of a log in which the stress is reached and in which the hold of so many steps ends."""
    peak = int(np.argmax(log["stress"] >= given["stress"]))
    return peak, int(np.argmin(np.abs(log["Step"] - log["Step"][peak] - hold)))


def outcome(log, height, peak, held, forces, seconds):
    """Results of a test as `studies.trade.packings.outcome` reads them; height: of the plate, in each row of the log."""
    rows = np.stack([height, log["stress"]], 1)
    return {
        "height": float(log["centre"][0]),
        "plate": float(height[held]),
        "loading": rows[: peak + 1].tolist(),
        "stress": float(log["stress"][held]),
        "forces": forces.tolist(),
        "unloading": rows[held:].tolist(),
        "steps": int(log["Step"][-1]),
        "seconds": seconds,
    }
