"""What the validation report asks of YADE, once for a law whose yield load and stiffness after yield are its own."""

import math

import pytest

from demlaws.driver import impact
from studies.validation import engines
from studies.validation.jobs import collision_jobs, contact_of, impact_jobs
from studies.validation.published import bound, quiet


@pytest.mark.slow
def test_a_stiffness_after_yield_of_its_own_acts_in_yade():
    """Restitution and peak force of an impact: yielding at its load, softer after it than one p_y says, as in Python."""
    given = next(job for job in impact_jobs() if job["law"] == "rough-plastic" and not job["plane"])
    pressure = given["options"]["yield_pressure"]
    given["options"] = {**given["options"], "yield_at": "load", "post_yield_pressure": 0.7 * pressure}
    given["speed"] *= 5.0
    mass = 0.5 * 4.0 / 3.0 * math.pi * given["radius"] ** 3 * given["density"]
    here = quiet(
        impact, bound(given["law"], contact_of(given), given["unloading"], **given["options"]), mass, given["speed"], 8000
    )
    (there,) = engines.in_yade([given | {"dt": here.duration / 8000, "rounds": 12}])
    assert there["parted"]
    assert there["restitution"] == pytest.approx(here.restitution, rel=1e-5)
    assert there["peak"] == pytest.approx(here.peak_force, rel=1e-5)
    plain = quiet(impact, bound(given["law"], contact_of(given), given["unloading"], yield_pressure=pressure, loading="hertz"),
                  mass, given["speed"], 8000)  # fmt: skip
    assert here.restitution < plain.restitution - 0.05


@pytest.mark.parametrize("shear", ["elastic", "slip"])
def test_friction_limits_a_damped_contact_that_slides(shear):
    """The dashpot of the shear force is off while the contact slides, though the normal dashpot raises Coulomb's limit."""
    (job,) = [job for job in collision_jobs("YADE") if job["restitution"] == 0.9]
    (found,) = engines.in_yade([job | {"motions": job["motions"][-1:], "shear": shear}])
    _, away, spin = found[0]
    assert 0.95 < spin / (2.5 * job["friction"] * (5.0 + away)) < 1.005
