"""Shear of bodies that move and turn in LIGGGHTS and LAMMPS: against `moving_contact`, and a small grain between large ones."""

import inputs_for_liggghts
import moving_contact as reference
import numpy as np
import pytest
from inputs import modulus, part, simulate
from spheres import both

import demlaws as dl

RADIUS, OTHER, OVERLAP, FRICTION = 5e-4, 5e-3, 1e-5, 0.4
YOUNG, POISSON, TIMESTEP = 5e8, 0.25, 1e-6
RATIO = 2 * (1 - POISSON) / (2 - POISSON)
CORNERS = [(-0.05, -0.05, 0), (0.05, -0.05, 0), (0, 0.05, 0)]
FIRST = {"sphere": reference.sphere(OTHER), "plane": reference.plane((0, 0, 1)), "triangle": reference.triangle(CORNERS)}
WAYS = {
    ("liggghts", "sphere"): reference.Way(first=True, by_speed=True),
    ("liggghts", "plane"): reference.Way(first_share=1.0),
    ("liggghts", "triangle"): reference.Way(first_share=1.0),
    ("lammps", "sphere"): reference.Way(first=True, by_speed=True),
    ("lammps", "plane"): reference.Way(wall_share=0.0),
}
COLUMNS = [f"c_r{body}[{axis}]" for body in "ab" for axis in range(1, 7)]
SCENE = """\
{head}newton off
boundary f f f
region box block -0.03 0.03 -0.03 0.03 -0.2 0.03 units box
create_box 2 box
neighbor 2e-4 bin
neigh_modify delay 0 every 1 check yes
{contacts}
timestep {step!r}
{bodies}
set type 1 diameter {large!r} density 2500
set type 2 diameter {small!r} density 2500
group a type 1
group b type 2
{walls}
"""


def contacts_of(engine, friction, words="", more="", restitution=1.0):
    """The pair style of one table for all."""
    if engine == "lammps":
        return f"pair_style granular\npair_coeff * * {lammps_terms(friction, words, restitution)} {more}"
    properties = inputs_for_liggghts.properties(2, YOUNG, restitution, friction, POISSON)
    return f"{properties}\npair_style gran model demlaws/table tangential demlaws table law.tbl {words}\npair_coeff * *"


def lammps_terms(friction, words="", restitution=1.0):
    shear = f"tangential demlaws 0.0 {friction} damping demlaws/tangent"
    return f"demlaws/table law.tbl {YOUNG!r} {restitution} {POISSON} {words} {shear}"


def scene(engine, contacts, bodies, walls="", large=2 * OTHER, small=2 * RADIUS, step=TIMESTEP, ranks=1):
    head = f"{part(engine, 'run').HEAD}processors {ranks} 1 1\n"
    head = "\n".join(line for line in head.splitlines() if not line.startswith(("boundary", "newton"))) + "\n"
    lines = "\n".join(f"create_atoms {kind} single {x!r} {y!r} {z!r} units box" for kind, (x, y, z) in bodies)
    return SCENE.format(head=head, contacts=contacts, bodies=lines, walls=walls, large=large, small=small, step=step)


def save_law(folder, radius, rule="hertz"):
    law = dl.law("pohrt-popov", dl.Contact(radius, modulus(YOUNG, POISSON), 2e-7, 2.3), rule)
    law.tabulate(rtol=1e-6, max_force=float(law.follow([4 * OVERLAP]).force[0])).save(folder / "law.tbl")
    return dl.Table.load(folder / "law.tbl")


def wall_of(engine, kind, folder, words=""):
    if kind == "sphere":
        return ""
    if engine == "lammps":
        return f"fix w all wall/gran granular {lammps_terms(FRICTION, words)} zplane 0 NULL"
    if kind == "plane":
        return "fix w all wall/gran model demlaws/table tangential demlaws primitive type 1 zplane 0.0"
    corners = "".join(f"vertex {x} {y} {z}\n" for x, y, z in CORNERS)
    facet = f"facet normal 0 0 1\nouter loop\n{corners}endloop\nendfacet\n"
    (folder / "plate.stl").write_text(f"solid plate\n{facet}endsolid plate\n")
    return (
        "fix plate all mesh/surface file plate.stl type 1\n"
        "fix w all wall/gran model demlaws/table tangential demlaws mesh n_meshes 1 meshes plate"
    )


def lines_of(engine, kind, motion, each):
    """Lines that prescribe velocities and spins, one step at a time; of a mesh its spin, `each` steps at a time."""
    text, moving = [], False
    for step, (velocities, spins) in enumerate(zip(motion.velocity.tolist(), motion.spin.tolist(), strict=True)):
        for body in (0, 1) if kind == "sphere" else (1,):
            name, (v, w) = "ab"[body], (velocities[body], spins[body])
            text.append(f"velocity {name} set {v[0]!r} {v[1]!r} {v[2]!r} units box")
            words = "omega {!r} {!r} {!r}" if engine == "lammps" else "omegax {!r} omegay {!r} omegaz {!r}"
            text.append(f"set group {name} {words.format(*w)}")
        if kind == "triangle" and step % each == 0:
            speed = np.linalg.norm(spins[0])
            text += ["unfix turns"] * moving
            moving = bool(speed > 0.0)
            if moving:
                x, y, z = (np.array(spins[0]) / speed).tolist()
                way = f"rotate origin 0 0 0 axis {x!r} {y!r} {z!r} period {float(2 * np.pi / speed)!r}"
                text.append(f"fix turns all move/mesh mesh plate {way}")
        text.append("run 1" if kind == "triangle" and step % each == 0 else "run 1 pre no post no")
    return "\n".join(text)


def prescribed(engine, kind, motion, folder, each, words="", more="", ranks=1):
    """Forces [N] and torques [N m] on both bodies, arrays (steps, 2, 3); a wall's are left at zero."""
    bodies = [(k + 1, place) for k, place in enumerate(motion.start.tolist()) if k or kind == "sphere"]
    walls = wall_of(engine, kind, folder, words)
    text = scene(engine, contacts_of(engine, FRICTION, words, more), bodies, walls, ranks=ranks)
    names = "ab" if kind == "sphere" else "b"
    text += "fix move all nve/noforce\ncompute q all property/atom tqx tqy tqz\n"
    for name in names:
        text += f"compute r{name} {name} reduce sum fx fy fz c_q[1] c_q[2] c_q[3]\n"
    columns = [column for column in COLUMNS if column[3] in names]
    text += (
        f"thermo_style custom step {' '.join(columns)}\nthermo_modify format float %.17e lost ignore norm no\nthermo 1\nrun 0\n"
    )
    simulate(engine, folder, text + lines_of(engine, kind, motion, each) + "\n", ranks)
    rows = {}
    for line in (folder / f"log.{engine}").read_text().splitlines():
        words = line.split()
        if len(words) == len(columns) + 1 and words[0].isdigit():
            rows[int(words[0])] = [float(word) for word in words[1:]]
    found = np.zeros((len(motion.velocity), 2, 6))
    found[:, -len(names) :] = np.array([rows[step + 1] for step in range(len(found))]).reshape(len(found), len(names), 6)
    return found[..., :3], found[..., 3:]


def agreement(found, wanted, bodies=(0, 1)):
    """Largest error of forces and torques over their largest value, step by step."""
    errors = [
        np.linalg.norm(mine[:, body] - other[:, body], axis=-1) / np.abs(other[:, body]).max()
        for mine, other in zip(found, (wanted.force, wanted.torque), strict=True)
        for body in bodies
    ]
    return np.max(errors, axis=0)


@pytest.mark.parametrize(("engine", "kind"), list(WAYS))
def test_forces_and_torques_of_a_moving_contact(engine, kind, tmp_path):
    """Approach, slide, roll, twist, turn as a whole by 180° about two axes, and back. One turn of 180° has 60 steps, of which
    an engine's series keep 3e-5; all else agrees to 1e-9."""
    first, each = FIRST[kind], 60
    radius = RADIUS * OTHER / (RADIUS + OTHER) if kind == "sphere" else RADIUS
    table = save_law(tmp_path, radius)
    motion = reference.motion(first, RADIUS, OVERLAP, each, TIMESTEP)
    wanted, former = (
        reference.follow(first, RADIUS, motion, table, ratio=RATIO, friction=FRICTION, way=way)
        for way in (WAYS[engine, kind], WAYS[engine, kind]._replace(half_step=False))
    )
    bodies = (0, 1) if kind == "sphere" else (1,)
    errors = agreement(prescribed(engine, kind, motion, tmp_path, each), wanted, bodies)
    turns = kind != "plane"  # whose normal does not
    assert errors[: 5 * each].max() <= 1e-9 and errors[10 * each :].max() <= 1e-9
    assert errors.max() <= (1e-4 if turns else 1e-9)
    if turns:
        assert np.abs(former.force - wanted.force).max() > 0.05 * np.abs(wanted.force).max()


@both
def test_a_turn_of_a_pair_about_its_normal_takes_the_forces_along(engine, tmp_path):
    """By 90°, 180° and 360°: also about the normal of a tilted pair, and with partial slip."""
    save_law(tmp_path, RADIUS * OTHER / (RADIUS + OTHER))
    first, each = FIRST["sphere"], 90
    for words in ("", "shear slip"):
        path = [reference.Leg(), reference.Leg(second=(2e-3, 3e-3, 0.0)), *[reference.Leg(whole=(0, 0, a)) for a in QUARTERS]]
        tilt = reference.rotation(np.array([0.3, -0.7, 0.4]))
        motion = reference.motion(first, RADIUS, OVERLAP, each, TIMESTEP, path=path)
        motion = motion._replace(start=motion.start @ tilt.T, velocity=motion.velocity @ tilt.T, spin=motion.spin @ tilt.T)
        forces = prescribed(engine, "sphere", motion, tmp_path, each, words)[0]
        start, normal, turned = forces[2 * each - 1, 1], tilt @ [0.0, 0.0, 1.0], 0.0
        along = start @ normal
        assert np.linalg.norm(start - along * normal) > 0.02 * along
        for leg, angle in enumerate(QUARTERS, 3):
            turned += angle
            expected = reference.rotation(turned * normal) @ start
            error = np.linalg.norm(forces[leg * each - 1, 1] - expected)
            assert error < 1e-4 * np.linalg.norm(start - along * normal)


@pytest.mark.parametrize("words", ["", "shear slip"])
@both
def test_a_pair_that_moves_to_another_rank_keeps_its_shear(engine, tmp_path, words):
    """The border of the ranks is the plane x = 0, through which the second sphere goes while it rolls and turns."""
    save_law(tmp_path, RADIUS * OTHER / (RADIUS + OTHER))
    motion = reference.motion(FIRST["sphere"], RADIUS, OVERLAP, 60, TIMESTEP)
    one, two = (prescribed(engine, "sphere", motion, tmp_path, 60, words, ranks=ranks) for ranks in (1, 2))
    assert np.ptp(np.sign((motion.start[1] + np.cumsum(TIMESTEP * motion.velocity[:, 1], axis=0))[:, 0])) == 2.0
    for here, there in zip(one, two, strict=True):
        assert np.abs(here - there).max() <= 1e-11 * np.abs(here).max()


QUARTERS = (0.5 * np.pi, 0.5 * np.pi, np.pi)
LARGE = 5e-3


def neck(engine, ratio, step, words="", more="", wall=False, time=0.3):
    """A grain that falls between two fixed spheres of 10 mm, or between one and a wall; the height [m] of its centre."""
    small = LARGE / ratio
    y = 0.11 * small
    if wall:  # the plane x = 0 and a sphere that touches it
        spheres, x = [(LARGE, 0.0, 0.0)], small
        height = np.sqrt((LARGE + small) ** 2 - (LARGE - small) ** 2 - y**2)
    else:
        spheres, x = [(0.0, 0.0, 0.0), (2 * LARGE, 0.0, 0.0)], LARGE
        height = np.sqrt((LARGE + small) ** 2 - LARGE**2 - y**2)
    bodies = [(2, (x, y, float(height))), *[(1, place) for place in spheres]]
    walls = "fix frozen a freeze\nfix g b gravity 9.81 vector 0 0 -1\nfix move b nve/sphere\n"
    if wall and engine == "lammps":
        walls += f"fix w b wall/gran granular {lammps_terms(0.5, words, 0.5)} xplane 0 NULL\n"
    elif wall:
        walls += "fix w b wall/gran model demlaws/table tangential demlaws primitive type 1 xplane 0.0\n"
    contacts = contacts_of(engine, 0.5, words, more, 0.5)
    text = scene(engine, contacts, bodies, walls, large=2 * LARGE, small=2 * small, step=step)
    text += "compute z b reduce sum z\nthermo_style custom step c_z\nthermo_modify lost ignore norm no\n"
    return text + f"thermo 100000\nrun {round(time / step)}\n"


def fallen(engine, folder, *given, **options):
    return simulate(engine, folder, neck(engine, *given, **options))["z"][-1]


@pytest.mark.parametrize("words", ["", "shear slip"])
@pytest.mark.parametrize("wall", [False, True], ids=["pair", "wall"])
@pytest.mark.parametrize("ratio", [pytest.param(r, marks=[] if r == 20 else pytest.mark.slow) for r in (2, 5, 10, 20, 40)])
@both
def test_a_small_grain_falls_between_large_ones(engine, tmp_path, ratio, wall, words):
    """Alike with three steps. With the lever of today's normal it is held from a ratio of 20 on, or falls later."""
    law = dl.law("hertz", dl.Contact(1e-3, modulus(YOUNG, POISSON)))
    law.tabulate(max_force=10.0).save(tmp_path / "law.tbl")
    time = 0.4 if wall and ratio == 40 else 0.3
    heights = [fallen(engine, tmp_path, ratio, step * 20 / ratio, words, wall=wall, time=time) for step in (4e-6, 2e-6, 1e-6)]
    assert max(heights) < -0.01
    assert heights == pytest.approx([heights[-1]] * 3, rel=0.01)


def test_synchronized_verlet_changes_nothing_of_ours_but_the_normal(tmp_path):
    """LAMMPS's own cure is accepted beside tangential demlaws, and the half step is not taken twice."""
    first, each = FIRST["sphere"], 60
    save_law(tmp_path, RADIUS * OTHER / (RADIUS + OTHER))
    motion = reference.motion(first, RADIUS, OVERLAP, each, TIMESTEP)
    try:
        synchronized = prescribed("lammps", "sphere", motion, tmp_path, each, more="synchronized_verlet")
    except dl.DemlawsError as error:
        if "synchronized_verlet" in str(error) and "non-synchronized" not in str(error):
            pytest.skip("a LAMMPS of before 22 Jul 2025")
        raise
    plain = prescribed("lammps", "sphere", motion, tmp_path, each)
    places = np.cumsum(motion.velocity * TIMESTEP, axis=0) + motion.start
    apart, passed = places[:, 1] - places[:, 0], (motion.velocity[:, 1] - motion.velocity[:, 0]) * TIMESTEP
    normal, half = (a / np.linalg.norm(a, axis=-1, keepdims=True) for a in (apart, apart - 0.5 * passed))
    force = plain[0][:, 1]
    along = np.sum(force * normal, -1, keepdims=True)
    assert np.abs(synchronized[0][:, 1] - (force + along * (half - normal))).max() <= 1e-9 * np.abs(along).max()
    assert np.abs(along * (half - normal)).max() > 1e-3 * np.abs(along).max()
