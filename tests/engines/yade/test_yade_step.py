"""The contact step without the native `go` against stock Mindlin, attribute by attribute, and against our step with it."""

import ctypes

import numpy as np
import pytest
from yade_scenes import (
    advance,
    engine_list,
    fixed_pair,
    functor,
    interaction_loop,
    material,
    set_engines,
    sphere,
    stops,
    under_yade,
    yade,
)

from demlaws.errors import DemlawsError

STEPS = 250
OPTIONS = [{"calcEnergy": True}, {"includeMoment": True}, {"neverErase": True}]
DAMPING = {"damped along the normal": {"en": 0.6, "es": 1.0}, "damped in shear": {"en": 1.0, "es": 0.6}}


def box_of_stones(law, physics=None, periodic=False):
    """Spheres and clumps that are shaken in a box of facets and walls; none is at rest, some slide, some part."""
    omega = yade.O
    omega.reset()
    stone, side, generator = material(friction=0.2), 0.1, np.random.default_rng(4)
    if periodic:
        omega.periodic = True
        omega.cell.hSize = yade.Matrix3(side, 0, 0, 0, side, 0, 0, 0, side)
    corners = [(0, 0), (side, 0), (side, side), (0, side)]
    for (x, y), (u, v) in [] if periodic else zip(corners, corners[1:] + corners[:1], strict=True):
        for flat in ([(x, y, 0), (u, v, 0), (u, v, side)], [(x, y, 0), (u, v, side), (x, y, side)]):
            omega.bodies.append(yade.utils.facet(flat, material=stone))
    for height, sense in () if periodic else ((0.0, 1), (side, -1)):
        omega.bodies.append(yade.utils.wall(height, 2, sense=sense, material=stone))
    place = 0.01002 + 0.01999 * np.arange(4)  # neighbours and walls touch
    for x in place:
        for y in place:
            for z in place:
                grain = [sphere((x, y, z), 0.01001, material=stone)]
                if z == place[-1] and x < 0.05:
                    grain.append(sphere((x, y, z + 0.01), 0.008, material=stone))
                body = omega.bodies.appendClumped(grain)[0] if len(grain) > 1 else omega.bodies.append(grain[0])
                omega.bodies[body].state.vel = generator.uniform(-1, 1, 3)
                omega.bodies[body].state.angVel = generator.uniform(-100, 100, 3)
    loop = interaction_loop(
        law,
        geometries=[yade.Ig2_Sphere_Sphere_ScGeom(), yade.Ig2_Facet_Sphere_ScGeom(), yade.Ig2_Wall_Sphere_ScGeom()],
        physics=physics and [physics],
    )
    omega.engines = engine_list(loop, bounds=[yade.Bo1_Facet_Aabb(), yade.Bo1_Wall_Aabb()])
    omega.dt = 2e-7
    return omega


def seen(omega, each_step=lambda number: None):
    """name → array over contacts, steps and components: attributes of contacts, forces and torques of bodies."""
    found = {}
    for step in range(STEPS):
        each_step(step)
        omega.step()
        if step % 10:
            continue
        for body in omega.bodies:
            found.setdefault("force", []).append(omega.forces.f(body.id))
            found.setdefault("torque", []).append(omega.forces.t(body.id))
        for pair, contact in sorted(((c.id1, c.id2), c) for c in omega.interactions if c.isReal):
            found.setdefault("pair", []).append(pair)
            for name, value in contact.phys.dict().items():
                if name != "prevU":  # which has the number of our row
                    found.setdefault(name, []).append(value)
    return {name: np.nan_to_num(np.array(values, float)) for name, values in found.items()}


def assert_same(mine, stock, tolerance=1e-9, flags=0.01):
    """Rounding grows: bodies collide."""
    assert mine.keys() == stock.keys()
    for name, values in stock.items():
        assert mine[name].shape == values.shape, name
        error = np.abs(mine[name] - values)
        if name == "isSliding":  # at Coulomb's limit rounding decides
            assert error.mean() < flags
        else:
            assert error.max() <= tolerance * np.abs(values).max(), name


class Counted:
    """How often a law calls the native `go`."""

    def __init__(self, law):
        context, self.calls = law.binding.attachment.context, 0
        kind = ctypes.CFUNCTYPE(ctypes.c_bool, *[ctypes.c_void_p] * 4)
        go = kind(int(context["go"]))

        def count(*arguments):
            self.calls += 1
            return go(*arguments)

        self.kept = kind(count)
        context["go"] = ctypes.cast(self.kept, ctypes.c_void_p).value


def hertz():
    """The functor of ours that must leave what stock Mindlin leaves."""
    return functor("hertz", "elastic", {}, shear="native", flats="yade")


def contact_steps(found):
    return 10 * len(found["pair"])


@pytest.mark.native_step
def test_hertz_leaves_what_stock_mindlin_leaves(omega):
    stock = seen(box_of_stones(yade.Law2_ScGeom_MindlinPhys_Mindlin()))
    law = hertz()
    calls = Counted(law)
    mine = seen(box_of_stones(law))
    assert_same(mine, stock)
    sliding = stock["isSliding"]
    assert 0.05 < sliding.mean() < 0.95 and np.abs(stock["torque"]).max() > 0.0
    pairs = {tuple(pair) for pair in stock["pair"].tolist()}
    assert len(pairs) > 150 and len(stock["pair"]) < len(pairs) * STEPS / 10  # some begin or end
    assert 0 < calls.calls < 0.1 * contact_steps(stock)  # of new contacts and those that end


@pytest.mark.native_step
@pytest.mark.parametrize("case", [*DAMPING, "periodic", "periodic and damped", *OPTIONS], ids=str)
def test_damped_periodic_and_where_the_native_go_acts(omega, case):
    """It acts with options of the functor, set while it runs; not with damping or in a periodic scene."""
    options = case if isinstance(case, dict) else {}
    damping = {} if options else DAMPING.get(case, {"en": 0.6, "es": 0.6} if "damped" in case else {})
    physics = yade.Ip2_FrictMat_FrictMat_MindlinPhys(**damping)
    periodic = not options and "periodic" in case

    def run(law):
        def turn_on(step):
            if step == 100:
                for name, value in options.items():
                    setattr(law, name, value)

        return seen(box_of_stones(law, physics, periodic), turn_on)

    stock, law = run(yade.Law2_ScGeom_MindlinPhys_Mindlin()), hertz()
    calls = Counted(law)
    assert_same(run(law), stock)
    share = calls.calls / contact_steps(stock)
    assert share > 0.55 if options else 0.0 < share < 0.1
    if damping:
        assert np.abs(stock["normalViscous"]).max() > 0.0 or np.abs(stock["shearViscous"]).max() > 0.0


@pytest.fixture
def own_slip(monkeypatch):
    """As YADE 2022.01a, whose native law does not read ScGeom.shearInc."""
    from demlaws.yade import native

    monkeypatch.setattr(native.find_layout(), "own_slip", True)


@pytest.mark.native_step
def test_a_native_law_with_a_slip_of_its_own_acts_on_no_contact(omega, own_slip):
    """It is asked only where a contact ends, and what our step leaves is what stock Mindlin leaves."""
    stock, law = seen(box_of_stones(yade.Law2_ScGeom_MindlinPhys_Mindlin())), hertz()
    calls = Counted(law)
    assert_same(seen(box_of_stones(law)), stock)
    assert 0 < calls.calls < 0.05 * contact_steps(stock)


@pytest.mark.parametrize("option", ["calcEnergy", "includeMoment", "neverErase"])
def test_options_that_need_a_native_step_with_another_slip_are_refused(omega, own_slip, option):
    refused = f"{option}=True cannot .* in this YADE: it needs YADE's own contact step, whose slip is not ScGeom.shearInc"
    with pytest.raises(DemlawsError, match=refused):
        functor(**{option: True})
    law = functor()
    omega.bodies.append(fixed_pair(material()))
    set_engines(law)
    advance(3)
    setattr(law, option, True)
    stops(refused)


def test_a_contact_that_needs_a_native_step_with_another_slip_stops_the_run(omega, own_slip, monkeypatch):
    monkeypatch.setattr("demlaws.yade.native.OPTIONS", ())  # the guard does not look at them
    law = functor()
    omega.bodies.append(fixed_pair(material()))
    set_engines(law)
    advance(3)
    law.includeMoment = True
    stops("or a functor with an option: it needs YADE's own contact step")


@pytest.mark.native_step
@pytest.mark.parametrize("shear", ["elastic", "slip"])
def test_a_rough_law_with_and_without_the_native_go(omega, shear):
    """Attributes and totals of energy of a law with history."""

    def run(alone):
        law = functor("pohrt-popov", "hertz", shear=shear)
        law.binding.attachment.context["own_step"] &= alone
        found, totals = seen(box_of_stones(law)), law.totals()
        return found | {name: np.array([getattr(totals, name)]) for name in ("stored", "dissipated", "shear_stored")}, totals

    (with_go, totals), (without, mine) = run(0), run(1)
    # with springs the native go sets isSliding by its own limit, not by the springs that stick
    assert_same(without, with_go, flags=0.05 if shear == "slip" else 0.01)
    assert mine.shear_dissipated == pytest.approx(totals.shear_dissipated, rel=1e-9) and mine.shear_dissipated > 0.0


@pytest.mark.native_step
@pytest.mark.parametrize("periodic", [False, True])
def test_viscous_dissipation_is_that_of_yade(omega, periodic):
    """As YADE counts it with calcEnergy, in our step and in YADE's own."""
    damping = {"en": 0.6, "es": 0.6}
    stock = yade.Law2_ScGeom_MindlinPhys_Mindlin(calcEnergy=True)
    seen(box_of_stones(stock, yade.Ip2_FrictMat_FrictMat_MindlinPhys(**damping), periodic))
    expected = stock.normDampDissip + stock.shearDampDissip
    for options in ({}, {"calcEnergy": True}):
        law = functor("hertz", "elastic", {}, shear="native", flats="yade", **options)
        seen(box_of_stones(law, yade.Ip2_FrictMat_FrictMat_MindlinPhys(**damping), periodic))
        assert law.totals().viscous == pytest.approx(expected, rel=1e-9) and expected > 0.0


@pytest.mark.native_step
def test_sums_of_calcenergy_are_those_of_the_law(omega):
    """YADE's own bookkeeping holds for Mindlin's shear of a Hertz contact."""
    law = functor("pohrt-popov", "hertz", calcEnergy=True)
    seen(box_of_stones(law))
    totals = law.totals()
    assert (law.shearEnergy, law.frictionDissipation) == (totals.shear_stored, totals.shear_dissipated)
    assert min(totals.shear_stored, totals.shear_dissipated) > 0.0


@pytest.mark.native_step
def test_on_two_threads(tmp_path):
    under_yade(
        """
from test_yade_step import *
assert yade.O.numThreads == 2
stock = seen(box_of_stones(yade.Law2_ScGeom_MindlinPhys_Mindlin()))
assert_same(seen(box_of_stones(hertz())), stock)
print("SAME")
""",
        tmp_path,
        threads=2,
    ).stdout.index("SAME")


def test_a_step_that_differs_is_refused(tmp_path):
    """The self-test compares with YADE's own step, here with another mass of damped bodies. (In a process of its own: code that
    is compiled has the offsets built in.)"""
    done = under_yade(
        """
import demlaws
from test_yade_step import *
from demlaws.yade import native
find = native.Layout.find_members

def wrong():
    found = find()
    found["State"]["mass"] = found["State"]["vel"][0], found["State"]["vel"][-1]
    return found

native.Layout.find_members = staticmethod(wrong)
with pytest.raises(demlaws.DemlawsError, match="with .* a contact step leaves other values of .*normalViscous"):
    hertz()
print("REFUSED")
""",
        tmp_path,
    )
    assert "REFUSED" in done.stdout, done.stdout + done.stderr
