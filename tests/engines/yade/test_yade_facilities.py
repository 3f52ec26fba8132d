"""What facilities of the engine mean under a law: energies, loading, time steppers, erased contacts, signals, MPI."""

import os
import signal
import subprocess
import sys
import types
import warnings
from pathlib import Path

import pytest
from yade_scenes import (
    OVERLAP,
    acting,
    advance,
    engine_list,
    expected,
    fixed_pair,
    force,
    functor,
    interaction_loop,
    material,
    set_engines,
    sphere,
    still,
    stops,
    yade,
)

import demlaws as dl
from demlaws import yade as dy
from demlaws.cli import main
from demlaws.yade import run

HERE = Path(__file__).parent


# --- energies


def slide(steps):
    """The upper sphere of `still` slides; it stops afterwards."""
    omega = yade.O
    omega.bodies[1].state.vel = (1, 0, 0)
    omega.dt = 1e-8
    advance(steps)
    omega.bodies[1].state.vel = (0, 0, 0)
    advance(1)


def test_energies_count_from_when_tracking_began_and_from_clear(omega):
    """As YADE's own: what was lost before, or while nothing was tracked, is not in O.energy; states are."""
    law = acting(functor())
    slide(300)
    first = law.totals()
    assert first.shear_dissipated > 0.0
    omega.trackEnergy = True
    assert omega.energy["demlawsShearLost"] == 0.0 and omega.energy["demlawsElastic"] == law.totals().stored
    slide(100)
    second = law.totals().shear_dissipated - first.shear_dissipated
    assert omega.energy["demlawsShearLost"] == pytest.approx(second, rel=1e-9) and second > 0.0
    omega.trackEnergy = False
    slide(100)
    omega.trackEnergy = True
    omega.trackEnergy = True
    assert omega.energy["demlawsShearLost"] == pytest.approx(second, rel=1e-9)
    omega.energy.clear()
    assert omega.energy["demlawsShearLost"] == 0.0
    slide(100)
    third = omega.energy["demlawsShearLost"]
    assert third > 0.0
    omega.saveTmp()
    omega.loadTmp()
    assert omega.energy["demlawsShearLost"] == pytest.approx(third, rel=1e-9)


# --- loading in a process that does not know the package


@pytest.mark.parametrize("first", ["", "import demlaws.yade"])
def test_a_scene_that_is_loaded_has_the_engines_of_its_script(omega, tmp_path, first):
    """The guard was in O.engines, and shifted the numbers that the script uses."""
    law = acting(functor())
    omega.save(str(tmp_path / "scene.yade"))
    goal = law.contacts().force[0]
    text = f"""
{first}
import yade
yade.O.load({str(tmp_path / "scene.yade")!r})
print("ENGINES", *[type(engine).__name__ for engine in yade.O.engines])
yade.O.run(3, True)
print("FORCE", yade.O.interactions[0, 1].phys.normalForce.norm().hex())
"""
    script = tmp_path / "load.py"
    script.write_text(text)
    done = run.run(script, capture_output=True, text=True, timeout=600, cwd=tmp_path, stdin=subprocess.DEVNULL)
    lines = {line.split()[0]: line.split()[1:] for line in done.stdout.splitlines() if line.strip()}
    assert lines["ENGINES"] == [type(engine).__name__ for engine in omega.engines], done.stdout + done.stderr
    assert float.fromhex(lines["FORCE"][0]) == pytest.approx(goal, rel=1e-12)


def test_the_start_of_a_process_executes_the_systems_sitecustomize_and_joins_toolkits(tmp_path):
    """In a Python process without YADE: the file that ours hides, and mpl_toolkits beside the matplotlib that comes first."""
    for folder in ("a/matplotlib", "a/mpl_toolkits", "b"):
        (tmp_path / folder).mkdir(parents=True)
    (tmp_path / "b" / "sitecustomize.py").write_text(
        "import sys, types\nsys.hidden = True\n"
        "sys.modules['mpl_toolkits'] = types.ModuleType('mpl_toolkits')\nsys.modules['mpl_toolkits'].__path__ = ['/usr']\n"
    )
    startup = Path(run.__file__).parent / "startup"
    path = os.pathsep.join(map(str, (startup, tmp_path / "a", tmp_path / "b")))
    program = "import sys; print(sys.hidden, sys.modules['mpl_toolkits'].__path__[0])"
    done = subprocess.run(
        [sys.executable, "-c", program], env=os.environ | {"PYTHONPATH": path}, capture_output=True, text=True
    )
    assert done.stdout.split() == ["True", str(tmp_path / "a" / "mpl_toolkits")], done.stderr


# --- time steppers


def stepper_of(**options):
    return yade.GlobalStiffnessTimeStepper(timestepSafetyCoefficient=0.5, timeStepUpdateInterval=1, **options)


def bound():
    return 0.5 * 4 * yade.utils.PWaveTimeStep()


def test_the_bound_follows_bodies_that_grow_and_shrink(omega, monkeypatch):
    monkeypatch.setattr("demlaws.yade.scene.PERIOD", 2)
    law = functor("hertz", "elastic", None, smooth=True)
    omega.bodies.append(fixed_pair(material(), 1e-7, radius=1e-3))
    omega.engines = dy.engines(law, timestep=0.5)
    omega.dt = 1e-9
    stepper = next(e for e in omega.engines if isinstance(e, yade.GlobalStiffnessTimeStepper))
    advance(3)
    small = stepper.maxDt
    assert small == pytest.approx(bound(), rel=1e-12)
    for factor in (8.0, 0.25):
        yade.utils.growParticles(factor, True, False)
        advance(4)
        assert stepper.maxDt == pytest.approx(bound(), rel=1e-12)
    assert stepper.maxDt == pytest.approx(2 * small, rel=1e-9)
    omega.saveTmp()
    omega.loadTmp()
    stepper = next(e for e in omega.engines if isinstance(e, yade.GlobalStiffnessTimeStepper))
    yade.utils.growParticles(2.0, True, False)
    advance(4)
    assert stepper.maxDt == pytest.approx(bound(), rel=1e-12)


def test_a_maxdt_of_the_user_is_warned_of_and_kept(omega):
    """Each remedy that the message names is done."""
    law = functor("hertz", "elastic", None, smooth=True)
    still(law)
    stepper = stepper_of(maxDt=2e-4)
    with pytest.warns(dy.TimeStepWarning, match="maxDt = 0.0002 s, above the bound .* not changed. Give a smaller maxDt"):
        omega.engines = [*dy.engines(law), stepper]
    advance(3)
    assert stepper.maxDt == 2e-4
    with warnings.catch_warnings():
        warnings.simplefilter("error", dy.TimeStepWarning)
        omega.interactions.clear()
        law = functor("hertz", "elastic", None, smooth=True)
        omega.engines = [*dy.engines(law), stepper_of(maxDt=0.9 * bound())]
        advance(3)
        assert omega.engines[-1].maxDt == 0.9 * bound()


def test_density_scaling_has_its_step(omega):
    """Its targetDt is reached; the bound of unscaled grains would make it useless."""
    law = functor("hertz", "elastic", None, smooth=True)
    stone = material(young=5e8, poisson=0.2)
    omega.bodies.append(yade.utils.wall(0, 2, material=stone))
    omega.bodies.append([sphere((0, 0, 0.0099 + 0.0198 * n), 0.01, material=stone) for n in range(2)])
    stepper = stepper_of(densityScaling=True, targetDt=2e-4)
    engines = dy.engines(law, newton=yade.NewtonIntegrator(damping=0.4, gravity=(0, 0, -9.81)))
    with pytest.warns(dy.TimeStepWarning, match="densityScaling, whose targetDt = 0.0002 s"):
        omega.engines = [*engines[:3], stepper, *engines[3:]]
    omega.dt = 1e-6
    advance(2000)
    assert omega.dt == pytest.approx(2e-4, rel=0.01)


# --- what is counted, refused, reported


def test_erased_contacts_are_not_counted(omega):
    """Range warnings name contacts that exist."""
    law, stone = functor(), material()
    soft = functor(surfaces={"granite": dl.Surface(2.4e-6, 2.22, 1e9)})
    omega.bodies.append(fixed_pair(stone, 1e-6))
    for n in range(3):
        omega.bodies.append(fixed_pair(stone, 1e-4, x=0.1 + 0.1 * n))
    set_engines(soft, 1e-9)
    omega.step()
    for body in [b.id for b in omega.bodies if b.state.pos[0] > 0.15]:
        omega.bodies.erase(body)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        advance(20)
    texts = [str(one.message) for one in caught if "0.6 H_m" in str(one.message)]
    assert len(texts) == 1 and "1 of 2 contacts" in texts[0] and "2+3" in texts[0]
    assert law.binding.scene is None


def test_friction_that_depends_on_the_force_is_refused(omega):
    """FrictMatCDM with c1, c2, which the contacts of Mindlin's law do not have."""
    stone = yade.FrictMatCDM(young=60.6e9, poisson=0.25, frictionAngle=0.5, density=2650, label="granite")
    omega.materials.append(stone)
    omega.bodies.append(fixed_pair(stone, OVERLAP))
    set_engines(functor(), 1e-9)
    advance(3)
    assert force() == expected()
    stone.c1 = 0.1
    omega.engines = omega.engines
    stops("c1 = 0.1, c2 = 0: a friction that depends", 10)


def test_ranks_of_mpi_are_refused(omega, monkeypatch):
    acting(functor())
    monkeypatch.setitem(sys.modules, "yade.mpy", types.SimpleNamespace(numThreads=4))
    omega.engines[0].dead = False
    with pytest.raises(dl.DemlawsError, match="4 MPI ranks"):
        omega.engines = omega.engines
    stops("4 MPI ranks", 110)


def test_a_step_that_is_no_number_stops(omega):
    still(functor())
    omega.dt = float("nan")
    stops("O.dt = ")


def test_a_step_of_zero_is_warned_of(omega):
    still(functor())
    omega.dt = 0.0
    with pytest.warns(dl.ValidityWarning, match="O.dt = 0 s"):
        advance(3)
    assert force() == expected()


def test_a_smooth_contact_goes_on_beyond_the_radius(omega):
    """As in YADE's own law, with one warning; a rough one names the usual remedy, which is done."""
    omega.bodies.append(fixed_pair(material(), 6e-3))
    omega.engines = engine_list(interaction_loop(functor("hertz", "elastic", None)))
    omega.dt = 1e-9
    with pytest.warns(dl.errors.LargeOverlap):
        advance(5)
    ours = force()
    omega.reset()
    omega.bodies.append(fixed_pair(material(), 6e-3))
    omega.engines = engine_list(interaction_loop(yade.Law2_ScGeom_MindlinPhys_Mindlin()))
    omega.dt = 1e-9
    advance(5)
    assert ours == pytest.approx(force(), rel=1e-12)
    omega.reset()
    omega.bodies.append(fixed_pair(material(), 6e-3))
    set_engines(functor(), 1e-9)
    stops("larger `young`")


def test_a_signal_is_named(tmp_path, capfd):
    """YADE that crashes ended silently."""
    script = tmp_path / "crash.py"
    script.write_text("import os, signal\nos.kill(os.getpid(), signal.SIGSEGV)\n")
    assert main(["yade", "run", "-x", str(script)]) == 128 + signal.SIGSEGV
    assert "signal SIGSEGV" in capfd.readouterr().err
