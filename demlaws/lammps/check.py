"""Prove the plugin on this machine: version, plugin, and contacts on a prescribed path inside LAMMPS."""

from demlaws.lammps.build import build
from demlaws.lammps.run import ENGINE, HEAD, executable, loaded, versions
from demlaws.plugins.engines import laws_to_check, moves, self_test

_WATCH = """\
group           left id 1
group           right id 2
fix             move all nve/noforce
compute         pull right reduce sum fx
compute         energy all demlaws/energy
compute         contacts all pair/local p13 p14 p15 p16 cutoff radius
compute         kept all reduce sum c_contacts[*] inputs local
variable        force equal c_pull
variable        stored equal c_energy[1]
variable        lost equal c_energy[2]
thermo_style    custom step v_overlap v_force v_stored v_lost c_kept[1] c_kept[2] c_kept[3] c_kept[4]
thermo_modify   format float %.17e lost ignore norm no
thermo          ${every}
timestep        5e-8
"""
_MODEL = "demlaws/table ${table} ${young} 1.0 0.25 tangential demlaws 1.0 0.5 damping demlaws/tangent"


def _scene(region, walls, others, gap, overlap):
    """Two spheres, of which the second, `gap` from the origin, moves along x."""
    return f"""\
{HEAD}\
boundary        f f f
newton          ${{newton}}
region          box block {region} units box
create_box      1 box
neighbor        1e-4 bin
neigh_modify    delay 0
pair_style      granular
pair_coeff      * * {_MODEL}
{walls}\
variable        gap equal {gap}+1e-7
variable        diameter equal 2*${{radius}}
create_atoms    1 single {others} units box
create_atoms    1 single ${{gap}} 0 0 units box
set             group all diameter ${{diameter}} density 2650
variable        overlap equal "{overlap}"
{_WATCH}{moves(5e-8)}"""


_WALLS = f"""\
variable        model string &
"granular {_MODEL}"
region          ground plane 0 0 0 1 0 0 units box
if "${{wall}} == plane" then "fix wall all wall/gran ${{model}} xplane 0 NULL" &
else "fix wall all wall/gran/region ${{model}} region ground"
"""
TWO_PARTICLES = _scene("-0.03 0.03 -0.02 0.02 -0.02 0.02", "", "0 0 0", "2*${radius}", "2*v_radius-(xcm(right,x)-xcm(left,x))")
WALL = _scene("-0.01 0.06 -0.03 0.03 -0.03 0.03", _WALLS, "0.05 0 0.02", "${radius}", "v_radius-xcm(right,x)")
"""A sphere against a wall at its left: a plane, or the same plane as a region; the first sphere lies far off."""


def run_path(law, text=TWO_PARTICLES, radius=None, every=4, newton="on", **options):
    """See `plugins.engines.Engine.run_path`; text=WALL: a sphere of the law's radius and a wall."""
    radius = law.contact.radius if radius is None and text is WALL else radius
    return ENGINE.run_path(law, text, radius, every=every, newton=newton, **options)


def check(report=print):
    """Version, plugin and self-test; prints the results, raises DemlawsError at the first failure."""
    version = versions()
    report(f"binary    {executable().path}: LAMMPS {version.date}")
    ways = [f"plugin    {build()} by {name}={value}" for name, value in loaded().items()]
    report(*ways or ["models    built into LAMMPS: no plugin is loaded"])
    for law, rtol, limit, name in laws_to_check():
        self_test(report, *run_path(law, rtol=rtol), f"two spheres, {name}", limit)
    for wall in ("plane", "region"):  # the last of these laws: hertz unloading, a fine table
        self_test(report, *run_path(law, WALL, rtol=rtol, wall=wall), f"{wall} wall, {name}", limit)
    report("all good")
