"""The scene of `python -m studies.trade` in LIGGGHTS, what a law costs there, and stock edinburgh on one contact."""

import numpy as np
import pytest
from natives import edinburgh_input, in_liggghts, until_free

import demlaws as dl
from demlaws.liggghts import run
from studies.trade import peers
from studies.trade.liggghts_oedometer import edinburgh_lines


def test_edinburgh_is_what_its_formula_says(tmp_path, granite_pair):
    """The force that `peers` puts on the picture against stock LIGGGHTS, loading, unloading and reloading."""
    law = dl.law("pohrt-popov", granite_pair, "hertz")
    fit = peers.edinburgh_fit(law, 10.0)
    loading, unloading, exponent = (f"{value:.15g}" for value in (fit.stiffness, fit.ratio, fit.exponent))
    (tmp_path / "in.edinburgh").write_text(edinburgh_input(edinburgh_lines(f"1 {loading}", f"1 {unloading}", exponent)))
    young = 2.0 * granite_pair.modulus * (1.0 - 0.25**2)
    variables = {"young": repr(young), "radius": repr(2.0 * granite_pair.radius)}
    log = run(tmp_path / "in.edinburgh", 1, variables, plugin=False)
    overlap, force = log["overlap"], log["force"]
    top = int(np.argmax(overlap[: overlap.size // 3]))  # the first peak
    bottom = top + int(np.argmin(overlap[top : top + 100]))
    path = np.concatenate([[overlap[top]], overlap[top:bottom]])
    expected = peers.edinburgh_force(fit, path[None])[0, 1:]
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
