"""The tests with known answers, and their calibration by GrainLearning (`pip install grainlearning`).

Both tests are made up from the law at TRUTH, the contact test with scatter, so that the result can be compared with the truth.
"""

from typing import NamedTuple

import numpy as np

import demlaws as dl
from demlaws.errors import DemlawsError
from studies.engines import under_yade

NAMES = ("sigma", "modulus")
UNITS = (1e-6, 1e9)  # samples are in µm and GPa
TRUTH = np.array([4.0, 32.32])
LOW, HIGH = (1.0, 15.0), (8.0, 60.0)
RADIUS, DIMENSION, POISSON = 8.7e-3, 2.25, 0.25  # of the grains; of the contact R = RADIUS/2
FORCES = np.geomspace(1.0, 1000.0, 25)  # [N]: beyond F = 100 N, up to which only one number of σ and E* shows
NOISE = 0.05e-6  # of the displacement [m]
STRESSES = np.geomspace(1.5e5, 3e6, 12)  # [Pa]
REFERENCE = 1e5  # stress [Pa] from which strains count


class Posterior(NamedTuple):
    """Mean and standard deviation of σ [µm] and modulus [GPa], and how many samples each iteration had."""

    mean: np.ndarray
    deviation: np.ndarray
    samples: int
    iterations: int


def contact_of(sample):
    """Contact of two grains at a sample (σ [µm], modulus [GPa])."""
    sigma, modulus = np.multiply(sample, UNITS)
    return dl.Contact(0.5 * RADIUS, modulus, sigma=sigma, fractal_dimension=DIMENSION)


def displacements(samples):
    """Overlap [µm] at each of FORCES, one row per sample."""
    return np.array([1e6 * dl.law("pohrt-popov", contact_of(s)).overlap(FORCES) for s in samples])


def contact_test(seed=1):
    """Displacement [µm] at each of FORCES, as measured: the law at TRUTH with scatter."""
    scatter = np.random.default_rng(seed).normal(0.0, 1e6 * NOISE, FORCES.size)
    return displacements([TRUTH])[0] + scatter


def strains(samples, packing=None):
    """(axial strain [1e-3] between REFERENCE and each of STRESSES, one row per sample; the packing), from one run of YADE."""
    given = {
        "samples": np.asarray(samples).tolist(),
        "radius": RADIUS,
        "dimension": DIMENSION,
        "poisson": POISSON,
        "stresses": [REFERENCE, *STRESSES],
        "packing": packing,
        "count": 60,
        "seed": 1,
    }
    found = under_yade("calibration/yade_press.py", given)
    rows = np.array(found["strain"])
    return 1e3 * (rows[:, 1:] - rows[:, :1]), found["packing"]


def calibrate(model, observed, control, *, samples, iterations, tolerance=1e-5):
    """`Posterior` of GrainLearning's iterative Bayesian filter; model: (n, 2) samples → (n, observations)."""
    try:
        from grainlearning import BayesianCalibration
    except ImportError as error:
        raise DemlawsError(f"GrainLearning is missing ({error}): pip install grainlearning") from error

    def run(calibration):
        calibration.system.set_sim_data([row[None, :] for row in model(calibration.system.param_data)])

    calibration = BayesianCalibration.from_dict(
        {
            "num_iter": iterations,
            "callback": run,
            "save_fig": -1,
            "system": {
                "param_min": list(LOW),
                "param_max": list(HIGH),
                "param_names": list(NAMES),
                "num_samples": samples,
                "obs_names": ["deformation"],
                "ctrl_name": "load",
                "obs_data": observed,
                "ctrl_data": control,
                "sim_name": "demlaws",
                "sigma_tol": tolerance,
            },
            "inference": {
                "Bayes_filter": {"ess_target": 0.3, "scale_cov_with_max": True},
                "sampling": {"max_num_components": 1, "n_init": 1, "random_state": 0, "slice_sampling": True},
                "initial_sampling": "halton",
            },
        }
    )
    calibration.run()
    mean = np.array(calibration.system.estimated_params[-1])
    deviation = mean * np.array(calibration.system.estimated_params_cv[-1])
    return Posterior(mean, deviation, samples, calibration.num_iter)


def fitted(observed):
    """The same two quantities of the contact test by `dl.fit`: a dict name → `Estimate`."""
    start = contact_of([3.0, 25.0])
    points = np.column_stack([1e-6 * observed, FORCES])
    ranking = dl.fit(points, start, "pohrt-popov", unloading="elastic", free=NAMES, displacement_noise=NOISE)
    return ranking.best.parameters
