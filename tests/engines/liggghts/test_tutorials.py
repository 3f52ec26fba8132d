"""The script that runs LIGGGHTS's own tutorials, on an input of the same kind that we wrote ourselves."""

import importlib.util
from pathlib import Path

import pytest

from demlaws.errors import DemlawsError

SCRIPT = Path(__file__).parents[3] / "liggghts_inputs" / "tutorials.py"
INPUT = """\
#a heap that falls apart, written as the tutorials are
atom_style    granular
atom_modify   map array
boundary      f f f
newton        off
communicate   single vel yes
units         si
region        domain block -0.02 0.02 -0.02 0.02 -0.001 0.05 units box
create_box    1 domain
neighbor      0.002 bin
neigh_modify  delay 0 contact_distance_factor 1.01
fix  m1 all property/global youngsModulus peratomtype 5.e6
fix  m2 all property/global poissonsRatio peratomtype 0.45
fix  m3 all property/global coefficientRestitution peratomtypepair 1 0.3
fix  m4 all property/global coefficientFriction peratomtypepair 1 0.5
fix  m5 all property/global characteristicVelocity scalar 2.
pair_style  gran model {model} tangential history #without cohesion
pair_coeff  * *
timestep    0.00001
fix  gravi all gravity 9.81 vector 0.0 0.0 -1.0
fix  floor all wall/gran model {model} tangential history primitive type 1 zplane 0.0
create_atoms 1 single 0 0 0.0041 units box
create_atoms 1 single 0.001 0 0.0121 units box
set          group all diameter 0.008 density 2500
#a line that no test needs: radius constant 0.004
fix  integr all nve/sphere
thermo_style custom step atoms ke
thermo       100
variable     more equal 100000
run    1
dump   dmp all custom 1 post/heap_*.txt id x y z
run    1000 upto
run    ${{more}}
"""


@pytest.fixture(scope="module")
def script():
    spec = importlib.util.spec_from_file_location("tutorials", SCRIPT)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("model", ["hertz", "hooke"])
def test_three_ways_of_one_input(script, tmp_path, model):
    source = tmp_path / "Tutorials" / "chute_wear"
    source.mkdir(parents=True)
    (source / "in.chute_wear").write_text(INPUT.format(model=model))
    assert script.find(tmp_path) == source.parent
    stock, hertz, rough = script.compare(source, tmp_path / "out", 1500)
    assert [row["way"] for row in (stock, hertz, rough)] == list(script.WAYS)
    assert stock["steps"] == hertz["steps"] == rough["steps"] == 1000 + 1500  # one, up to a thousand, and the cap
    assert stock["grains"] == 2 and stock["worst"] == 0 and stock["beyond"] == hertz["beyond"] == 0
    assert hertz["worst"] < 1e-9 < 1e-4 < rough["worst"]
    assert not list((tmp_path / "out").rglob("heap_*"))
    lines = script.table([stock, hertz, rough])
    assert len(lines) == 1 + 3 + 2 and all("chute_wear" in line for line in lines[1:4])


def test_no_tutorials_is_told_with_the_way_to_them(script, tmp_path, capsys):
    with pytest.raises(DemlawsError, match="liggghts-doc"):
        script.find(tmp_path)
    assert script.main([str(tmp_path)]) == 2
    assert "liggghts-doc" in capsys.readouterr().err
