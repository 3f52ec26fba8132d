"""Stock edinburgh of LIGGGHTS on one contact."""

import numpy as np
import pytest
from natives import edinburgh_input, in_liggghts, until_free

import demlaws as dl
from demlaws.liggghts import run
from studies.trade.liggghts_oedometer import edinburgh_fit, edinburgh_lines


def test_edinburgh_is_what_its_formula_says(tmp_path, granite_pair):
    """The model fitted to a law, loading and unloading: P = k1 δ^n, but no more than k2 (δ^n - (1 - k1/k2) δmax^n), and no less
    than 0 (normal_model_edinburgh_stiffness.h of LIGGGHTS 3.8.0, without adhesion)."""
    law = dl.law("pohrt-popov", granite_pair, "hertz")
    fit = edinburgh_fit(law, 10.0)
    loading, unloading, exponent = (f"{value:.15g}" for value in (fit.stiffness, fit.ratio, fit.exponent))
    (tmp_path / "in.edinburgh").write_text(edinburgh_input(edinburgh_lines(f"1 {loading}", f"1 {unloading}", exponent)))
    young = 2.0 * granite_pair.modulus * (1.0 - 0.25**2)
    variables = {"young": repr(young), "radius": repr(2.0 * granite_pair.radius)}
    log = run(tmp_path / "in.edinburgh", 1, variables, plugin=False)
    overlap, force = log["overlap"], log["force"]
    top = int(np.argmax(overlap[: overlap.size // 3]))  # the first peak
    bottom = top + int(np.argmin(overlap[top : top + 100]))
    power, highest = overlap[top:bottom] ** fit.exponent, overlap[top] ** fit.exponent
    unloaded = fit.ratio * (power - (1.0 - 1.0 / fit.ratio) * highest)
    expected = fit.stiffness * np.maximum(np.minimum(power, unloaded), 0.0)
    assert np.max(np.abs(force[top:bottom] - expected)) < 1e-6 * force[top]
    loading = overlap[1:top]
    expected = fit.stiffness * np.maximum(loading, 0.0) ** fit.exponent
    assert np.max(np.abs(force[1:top] - expected)) < 1e-6 * force[top]


@pytest.mark.slow
def test_liggghts_own_and_ours_on_the_same_path():
    """Equal until the force is 0; below the plastic overlap stock moves it back with the bodies, and reloads from there."""
    law = dl.law("eepa", dl.Contact(4e-3, 32e9), softness=0.8, stiffness_ratio=2.5)
    overlap, theirs = in_liggghts(law, [6e-6, 4.5e-6, 1e-5, 7.5e-6, 5.5e-6, 9e-6])
    ours = law.follow(overlap).force
    assert np.count_nonzero(ours == 0.0) > 10 and until_free(ours) > 100
    first = slice(0, until_free(ours))
    assert np.max(np.abs(theirs - ours)[first]) <= 1e-13 * theirs.max()
    later = (np.arange(ours.size) > until_free(ours)) & (theirs > 0.0)
    assert np.max((theirs - ours)[later]) > 0.05 * theirs.max()
