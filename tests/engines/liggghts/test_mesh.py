"""Mesh walls: rims, holes, edges and nodes carry what the stock wall and a closed form say; tiled flats have no bump."""

import itertools
import math

import numpy as np
import pytest
from examples import shared
from inputs import modulus
from inputs_for_liggghts import properties

import demlaws as dl
from demlaws.errors import EngineStopped
from demlaws.liggghts import run
from demlaws.liggghts.run import HEAD
from demlaws.shear import sheared

RADIUS = 4e-3
CASE = (
    HEAD
    + """\
processors 1 1 1
region box block -0.03 0.03 -0.03 0.03 -0.02 0.04 units box
create_box 1 box
neighbor 1e-3 bin
neigh_modify delay 0
{properties}
pair_style gran model {model} tangential {tangential} {words}
pair_coeff * *
timestep 1e-7
create_atoms 1 single {at} units box
set atom 1 diameter 0.008 density 2650
group one id 1
fix plate all mesh/surface/stress file plate.stl type 1
fix w all wall/gran model {model} tangential {tangential} {support} {words}
fix move all nve/{mover}
compute f one reduce sum fx fy fz
compute x one reduce sum x y z
thermo_style custom step c_f[1] c_f[2] c_f[3] c_x[1] c_x[2] c_x[3]
thermo_modify format float %.15e lost ignore norm no
thermo {every}
"""
)
ON_MESH = "mesh n_meshes 1 meshes plate"
COLUMNS = ("f[1]", "f[2]", "f[3]", "x[1]", "x[2]", "x[3]")


def write_mesh(path, triangles):
    text = ""
    for triangle in triangles:
        corners = "".join(f"vertex {x:.17g} {y:.17g} {z:.17g}\n" for x, y, z in triangle)
        text += f"facet normal 0 0 1\nouter loop\n{corners}endloop\nendfacet\n"
    path.write_text(f"solid plate\n{text}endsolid plate\n")


def plate_with_hole(n, inner=3e-3, outer=12e-3):
    """Coplanar triangles around a regular n-sided hole of inradius `inner`."""

    def ring(apothem):
        radius = apothem / math.cos(math.pi / n)
        angles = [(2 * k + 1) * math.pi / n for k in range(n)]
        return [(radius * math.cos(a), radius * math.sin(a), 0.0) for a in angles]

    inside, outside = ring(inner), ring(outer)
    mesh = []
    for k in range(n):
        other = (k + 1) % n
        mesh += [(inside[k], outside[k], outside[other]), (inside[k], outside[other], inside[other])]
    return mesh


def tiled(side=6, width=2e-3, height=lambda x, y: 0.0):
    """Squares of two triangles around the origin, which is a node of six of them."""

    def node(i, j):
        x, y = width * (i - side / 2), width * (j - side / 2)
        return (x, y, height(x, y))

    mesh = []
    for i, j in itertools.product(range(side), repeat=2):
        a, b, c, d = node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)
        mesh += [(a, b, c), (a, c, d)]
    return mesh


@pytest.fixture(scope="module")
def tables(tmp_path_factory):
    folder = tmp_path_factory.mktemp("tables")
    contact = dl.Contact(radius=RADIUS, modulus=modulus(), sigma=2.4e-6, fractal_dimension=2.22)
    dl.law("hertz", contact).tabulate(rtol=1e-9).save(folder / "hertz.tbl")
    dl.law("pohrt-popov", contact, unloading="hertz").tabulate(rtol=1e-7).save(folder / "granite.tbl")
    return folder


def simulate(folder, mesh, at, commands="run 0\n", table=None, mover="noforce", every=1, words="", **shear):
    """[rows, 6] force on the sphere and its place; stock hertz without a table."""
    write_mesh(folder / "plate.stl", mesh)
    model, words = ("hertz", "") if table is None else ("demlaws/table", f"table {table} {words}")
    values = {"tangential": "history", "properties": properties(friction=0.0), "support": ON_MESH, **shear}
    place = " ".join(f"{a:.17g}" for a in at)
    text = CASE.format(model=model, words=words, at=place, mover=mover, every=every, **values) + commands
    (folder / "in.mesh").write_text(text)
    log = run(folder / "in.mesh", plugin=table is not None)
    return np.stack([log[name] for name in COLUMNS], -1)


@pytest.mark.parametrize(
    "at",
    shared(
        ["hole", "rim", "outer corner", "inner corner", "fold", "ridge", "node", "edge"],
        ("hole", "rim", "fold", "node").__contains__,
    ),
)
def test_the_support_is_that_of_the_stock_wall(tmp_path, tables, at):
    """A hundred places about each feature of a mesh, Hertz as a table against stock hertz."""
    fold = {"fold": lambda x, y: abs(x) * 0.2, "ridge": lambda x, y: -abs(x) * 0.2}
    mesh = tiled(height=fold[at]) if at in fold else tiled() if at in ("node", "edge") else plate_with_hole(5)
    low, out = RADIUS - 5e-5, 1 / math.cos(math.pi / 5)
    places = {
        "hole": (0.0, 0.0, 2.62e-3), "rim": (3e-3, 0.0, low), "outer corner": (-12e-3 * out, 0.0, low),
        "inner corner": (-3e-3 * out, 0.0, low), "fold": (0.0, 1e-4, low), "ridge": (0.0, 1e-4, low),
        "node": (0.0, 0.0, low), "edge": (1e-3, 0.0, low),
    }  # fmt: skip
    x, y, z = places[at]
    rng = np.random.default_rng(5)
    shifts = rng.uniform(-4e-5, 4e-5, (100, 3)).tolist()
    commands = "".join(f"set atom 1 x {x + a:.17g} y {y + b:.17g} z {z + c:.17g}\nrun 1\n" for a, b, c in shifts)
    found = {}
    for table in (None, tables / "hertz.tbl"):
        (tmp_path / str(table is None)).mkdir()
        found[table] = simulate(tmp_path / str(table is None), mesh, (x, y, z), commands, table)
    stock, ours = found.values()
    assert len(stock) > 90 and np.count_nonzero(stock[:, 2] > 1.0) > 40
    assert np.abs(ours - stock)[:, :3].max() <= 1e-9 * np.abs(stock[:, :3]).max()


@pytest.mark.parametrize(
    "table, speed", [("hertz.tbl", 0.01), ("granite.tbl", 0.01), ("granite.tbl", -0.013), ("granite.tbl", 10.0)]
)
def test_no_bump_on_a_tiled_flat(tmp_path, tables, table, speed):
    """A sphere that slides over edges and nodes of a flat of tiles, slower and faster than the edges are wide."""
    depth, steps = 1e-5, 4000
    start = (-np.sign(speed) * 2e-6 if abs(speed) < 1 else -2e-3, 0.0, RADIUS - depth)
    # over the node, askew; at 0.01 m/s the mesh's 1e-8 m take ten steps
    commands = f"velocity all set {speed} {0.37 * speed} 0\nrun {steps}\n"
    rows = simulate(tmp_path, tiled(), start, commands, tables / table)
    force = rows[1:, :3]
    assert np.ptp(rows[:, 3]) > 3.9e-6 and rows[:, 3].min() < 0 < rows[:, 3].max()
    assert np.ptp(force[:, 2]) <= 1e-9 * force[0, 2]
    assert np.abs(force[:, :2]).max() <= 1e-9 * force[0, 2]


def test_springs_that_a_page_of_the_mesh_cannot_hold(tmp_path, tables):
    """LIGGGHTS would end with a segmentation fault."""
    own = {"words": "shear slip", "tangential": "demlaws", "properties": properties(), "support": ON_MESH}
    with pytest.raises(EngineStopped, match="neigh_modify page"):
        simulate(tmp_path, tiled(), (-0.5e-6, 0.0, RADIUS), "run 1\n", tables / "granite.tbl", **own)


@pytest.mark.parametrize("support", [ON_MESH, "primitive type 1 zplane 0.0"])
@pytest.mark.parametrize("shear", ["elastic", "slip springs 9", "elastic friction_pressure 0.4 3e-9"])
def test_passive_shear_at_walls(tmp_path, tables, shear, support):
    """Press, slide over a node of the mesh and back past Coulomb's limit, lift off partly: the force is Python's."""
    law = dl.law("pohrt-popov", dl.Contact(RADIUS, modulus(), 2.4e-6, 2.22), "hertz")
    moves = [(0.0, -0.1, 500), (0.05, -0.01, 200), (0.02, 0.05, 300), (-0.08, 0.0, 400), (0.0, -0.1, 200)]
    commands = "".join(f"velocity all set {along} 0 {up}\nrun {steps}\n" for along, up, steps in moves)
    own = {"words": f"shear {shear}", "tangential": "demlaws", "properties": properties(), "support": support}
    rows = simulate(tmp_path, tiled(), (-0.5e-6, 0.0, RADIUS), commands, tables / "granite.tbl", **own)
    force, x, height = rows[:, 0], rows[:, 3], rows[:, 5]
    assert x.min() < -1e-7 and x.max() > 1e-7
    friction = dl.PressureFriction(0.5, 0.4, 3e-9) if "friction" in shear else 0.5
    shear = shear.split()[0]
    path = sheared(law, RADIUS - height, x - x[0], 2 * (1 - 0.25) / (2 - 0.25), shear, friction=friction, springs=1000)
    np.testing.assert_allclose(-force, path.shear_force, atol=2e-2 * 0.5 * path.force.max())
    assert np.abs(force).max() > 0.1 * path.force.max()
