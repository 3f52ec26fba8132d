"""What facilities of the engine mean under a law: energies, loading, time steppers, erased contacts, signals, MPI."""

import math
import os
import pty
import select
import signal
import subprocess
import sys
import time
import types
import warnings
from pathlib import Path

import pytest
from processes import usual_signals
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
    under_yade,
    yade,
)

import demlaws as dl
from demlaws import yade as dy
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
    slide(100)
    assert law.totals().shear_dissipated > 0.0
    omega.save(str(tmp_path / "scene.yade"))
    goal = law.contacts().force[0]
    text = f"""
{first}
import yade
yade.O.load({str(tmp_path / "scene.yade")!r})
yade.O.trackEnergy = True
print("ENGINES", *[type(engine).__name__ for engine in yade.O.engines])
yade.O.run(3, True)
print("FORCE", yade.O.interactions[0, 1].phys.normalForce.norm().hex())
print("LOST", yade.O.energy["demlawsShearLost"], yade.O.energy["demlawsElastic"])
"""
    script = tmp_path / "load.py"
    script.write_text(text)
    done = run.run(script, capture_output=True, text=True, timeout=600, cwd=tmp_path, stdin=subprocess.DEVNULL)
    lines = {line.split()[0]: line.split()[1:] for line in done.stdout.splitlines() if line.strip()}
    assert lines["ENGINES"] == [type(engine).__name__ for engine in omega.engines], done.stdout + done.stderr
    assert float.fromhex(lines["FORCE"][0]) == pytest.approx(goal, rel=1e-12)
    assert float(lines["LOST"][0]) == 0.0 < float(lines["LOST"][1])  # what was lost before tracking began does not count


def test_engines_that_are_assigned_to_a_loaded_scene_are_checked(omega, tmp_path):
    """Before anything of the scene is read, by a script that does not import the package: another law would go on silently."""
    acting(functor())
    file = str(tmp_path / "scene.yade")
    omega.save(file)
    text = f"""
import yade
from yade import *
yade.O.load({file!r})
loop = InteractionLoop(
    [Ig2_Sphere_Sphere_ScGeom()], [Ip2_FrictMat_FrictMat_MindlinPhys()], [Law2_ScGeom_MindlinPhys_Mindlin()]
)
yade.O.engines = [ForceResetter(), InsertionSortCollider([Bo1_Sphere_Aabb()]), loop, NewtonIntegrator()]
"""
    script = tmp_path / "load.py"
    script.write_text(text)
    done = run.run(script, capture_output=True, text=True, timeout=600, cwd=tmp_path, stdin=subprocess.DEVNULL)
    assert done.returncode == 1 and "the law is switched while there are contacts (1)" in done.stdout + done.stderr


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


def test_a_scene_from_a_text_stops(omega):
    """O.sceneToString writes native Mindlin in place of the law, and no history: the guard notices."""
    acting(functor())
    omega.stringToScene(omega.sceneToString())
    stops("is not used in this scene", 101)


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
    with pytest.warns(dy.TimeStepWarning, match="targetDt = 0.0002 s, above the bound"):
        omega.engines = [*engines[:3], stepper, *engines[3:]]
    omega.dt = 1e-6
    advance(2000)
    assert omega.dt == pytest.approx(2e-4, rel=0.01)
    with warnings.catch_warnings():
        warnings.simplefilter("error", dy.TimeStepWarning)
        omega.interactions.clear()
        smaller = stepper_of(densityScaling=True, targetDt=0.9 * bound())
        omega.engines = [*dy.engines(functor("hertz", "elastic", None, smooth=True))[:3], smaller, engines[-1]]
        advance(3)


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


def test_friction_by_pressure_that_contacts_do_not_have_is_refused(omega):
    """FrictMatCDM with c1, which the contacts of Ip2_FrictMat_FrictMat_MindlinPhys do not have."""
    stone = yade.FrictMatCDM(young=60.6e9, poisson=0.25, frictionAngle=0.5, density=2650, label="granite")
    omega.materials.append(stone)
    omega.bodies.append(fixed_pair(stone, OVERLAP))
    set_engines(functor(), 1e-9)
    advance(3)
    assert force() == expected()
    stone.c1 = 0.1
    omega.engines = omega.engines
    stops("c1 = 0.1: a friction that depends on the pressure.*Ip2_FrictMatCDM_FrictMatCDM_MindlinPhysCDM.*set c1 = 0", 10)
    stone.c1 = 0.0
    omega.engines = omega.engines
    advance(10)
    assert force() == expected()


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
    stops("O.dt = nan s: give a positive time step")
    omega.dt = 1e-9
    advance(3)
    assert force() == expected()


def test_a_step_of_zero_is_warned_of(omega):
    still(functor())
    omega.dt = 0.0
    with pytest.warns(dl.ValidityWarning, match="O.dt = 0 s"):
        advance(3)
    assert force() == expected()


def test_a_smooth_contact_goes_on_beyond_the_radius(omega):
    """As in YADE's own law, with one warning."""
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


@pytest.mark.parametrize("rule", ["elastic", "hertz"])
def test_larger_young_is_the_remedy_of_a_large_overlap(omega, rule):
    """Of softened grains: two that meet so fast that they would overlap by more than R rebound if they are stiffer."""

    def impact(young):
        omega.reset()
        stone = material(young=young)
        omega.bodies.append(sphere((0, 0, 0), 0.01, fixed=True, material=stone))
        omega.bodies.append(sphere((0, 0, 0.02 + 1e-6), 0.01, material=stone))
        omega.bodies[1].state.vel = (0, 0, -10.0)
        set_engines(functor("pohrt-popov", rule), 0.05 * yade.utils.PWaveTimeStep())
        deepest = 0.0
        for _ in range(20_000):
            omega.step()
            deepest = max(deepest, 0.02 - omega.bodies[1].state.pos[2])
            if omega.bodies[1].state.vel[2] > 0.0 and not omega.interactions.countReal():
                return deepest
        raise AssertionError("no rebound")

    with pytest.raises(RuntimeError, match=r"contact 0\+1: overlap .* a larger `young`"):
        impact(1e5)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", dl.errors.LargeOverlap)
        assert 5e-4 < impact(1e8) < 5e-3


@pytest.mark.native_step
def test_a_restitution_of_zero_is_blamed_not_the_step(omega):
    """en = 0.5, es = 0: YADE's damping ratio of shear is not finite; the remedy of the message is done."""

    def slides(es):
        omega.reset()
        stone = material()
        omega.bodies.append([sphere((0, 0, z), 0.01, fixed=not z, material=stone) for z in (0.0, 0.02 - OVERLAP)])
        omega.bodies[1].state.vel = (0.1, 0.0, 0.0)
        set_engines(functor(), physics=yade.Ip2_FrictMat_FrictMat_MindlinPhys(en=0.5, es=es))
        advance(20)
        return omega.interactions[0, 1].phys

    with pytest.raises(
        RuntimeError, match=r"betan = 0\.2\d*, betas = (nan|inf) of contact 0\+1 .* give en and es .* above 0, at most 1"
    ):
        slides(0.0)
    phys = slides(0.01)
    assert math.isfinite(phys.betas) and phys.shearForce.norm() > 0.0


# --- how a run stops


STOP = """
import time
import demlaws as dl
from demlaws.yade import Law2_ScGeom_MindlinPhys_Demlaws as Law
O.materials.append(FrictMat(young=60e9, poisson=0.25, frictionAngle=0.5, density=2650, label="granite"))
O.bodies.append([sphere((0, 0, 0), 0.01, fixed=True), sphere((0, 0, 0.014), 0.01, fixed=True)])
law = Law("pohrt-popov", "hertz", dl.Surface(1e-6, 2.2))
loop = InteractionLoop([Ig2_Sphere_Sphere_ScGeom()], [Ip2_FrictMat_FrictMat_MindlinPhys()], [law])
O.engines = [ForceResetter(), InsertionSortCollider([Bo1_Sphere_Aabb()]), loop, NewtonIntegrator()]
O.dt = 1e-6
"""


def test_a_stop_ends_a_script(tmp_path):
    """The message is in what YADE prints, and in the error of the script."""
    done = under_yade(STOP + "O.run(100, True)", tmp_path)
    lines = (done.stdout + done.stderr).splitlines()
    assert done.returncode == 1 and len([line for line in lines if "contact 0+1: overlap 0.006 m is 1.2 times" in line]) > 0, (
        lines
    )


def test_a_stop_ends_the_step_and_its_cause_may_be_removed(omega):
    """Nothing has moved since; a cause that stays stops again, also where nothing waits but the last line."""
    omega.bodies.append(fixed_pair(material(), 6e-3))
    set_engines(functor(), 1e-9)
    stops("1.2 times")
    assert omega.iter == 1
    stops("1.2 times")
    omega.run(5)
    while omega.running:
        time.sleep(0.01)
    with pytest.raises(dl.errors.EngineStopped, match="undefined beyond R"):  # YADE's own returns where the run has ended
        omega.wait()
    omega.bodies[1].state.pos = (0, 0, 0.02 - OVERLAP)
    advance(5)
    omega.run(5, True)
    assert force() == expected()


@pytest.mark.parametrize("number, batch", [("SIGTERM", False), ("SIGHUP", False), ("SIGINT", False), ("SIGTERM", True)])
def test_signals_go_to_yade(tmp_path, number, batch):
    """The command ended, and YADE went on without it; of a batch its jobs, too."""
    script, note = tmp_path / "long.py", tmp_path / "pid"
    script.write_text(f"import os, time\nopen({str(note)!r}, 'w').write(f'{{os.getpid()}}.')\ntime.sleep(600)\n")
    (tmp_path / "table").write_text("x\n1\n")
    line = [sys.executable, "-m", "demlaws", "yade", "run", *(["--batch", "table"] if batch else ["-x"]), str(script)]
    environment = os.environ | {"PYTHONPATH": str(Path(dl.__file__).parents[1])}
    options = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "stdin": subprocess.DEVNULL, "text": True}
    # a session of its own: no terminal sends its signals to both
    options["preexec_fn"] = usual_signals
    with subprocess.Popen(line, env=environment, cwd=tmp_path, start_new_session=True, **options) as process:
        while not (note.exists() and note.read_text().endswith(".")):
            assert process.poll() is None
            time.sleep(0.05)
        process.send_signal(signal.Signals[number])
        output = process.stdout.read()
        status = process.wait(timeout=120)
    for _ in range(100):  # a job of a batch ends by itself
        left = Path(f"/proc/{note.read_text().strip('.')}")
        if not left.exists():
            break
        time.sleep(0.1)
    assert not left.exists()
    if number == "SIGINT":
        assert status == 1 and "KeyboardInterrupt" in output
    else:
        assert status != 0


@pytest.mark.slow
def test_ctrl_c_interrupts_yade_which_goes_on(tmp_path):
    """In a terminal, where both get the signal: the command killed YADE, and what was simulated was gone."""
    script = tmp_path / "long.py"
    script.write_text("import time\nprint('READY', flush=True)\ntime.sleep(600)\n")
    environment = os.environ | {"PYTHONPATH": str(Path(dl.__file__).parents[1]), "TERM": "dumb"}
    pid, terminal = pty.fork()
    if pid == 0:
        usual_signals()
        os.execve(sys.executable, [sys.executable, "-m", "demlaws", "yade", "run", str(script)], environment)

    def read_until(word):
        text = b""
        while word not in text:
            assert select.select([terminal], [], [], 120)[0], text
            text += os.read(terminal, 4096)

    try:
        read_until(b"READY")
        os.write(terminal, b"\x03")
        read_until(b"[1]:")
        os.write(terminal, b"print('SUM', 20 + 22)\r")
        read_until(b"SUM 42")
    finally:
        os.kill(pid, signal.SIGTERM)
        os.waitpid(pid, 0)
        os.close(terminal)
