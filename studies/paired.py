"""Effects from runs that share what differs between samples: paired changes and intervals of means, by Student's t.

One rule for all studies: an effect is clear if Benjamini & Hochberg's procedure (1995) at 5 % finds it among all effects of its
table (`clear`), not if its own interval excludes no effect: of 48 intervals two or three do so by chance.
"""

from typing import NamedTuple

import numpy as np

LEVEL = 0.95
"""Confidence of an interval."""
FALSE = 0.05
"""Expected share of effects that are none among those called clear."""


class Estimate(NamedTuple):
    """A mean with the ends of its 95 % interval; NaN ends for one sample."""

    mean: float
    low: float
    high: float
    samples: int
    p: float  # two-sided, of no difference from the expected value; NaN for one sample


def interval(values, deviation=None, freedom=None, expected=0.0):
    """`Estimate` of the mean of independent values.

    deviation, freedom: a standard deviation pooled over like cases, and its degrees of freedom, in place of the values' own.
    """
    from scipy import stats

    values = np.asarray(list(values), float)
    if deviation is None:
        freedom = values.size - 1
        deviation = float(np.std(values, ddof=1)) if freedom else np.nan
    error = deviation / np.sqrt(values.size) if freedom else np.nan
    half, mean = stats.t.ppf(0.5 + 0.5 * LEVEL, freedom) * error, float(np.mean(values))
    with np.errstate(divide="ignore", invalid="ignore"):
        p = 2.0 * stats.t.sf(abs(np.divide(mean - expected, error)), freedom)
    return Estimate(mean, mean - half, mean + half, values.size, float(p))


def change(before, after):
    """`Estimate` of after/before - 1 of pairs: geometric mean of the ratios, Student's t on their logarithms."""
    found = interval(np.log(np.asarray(after, float) / np.asarray(before, float)))
    return Estimate(*(float(np.expm1(v)) for v in found[:3]), *found[3:])


def clear(estimates):
    """Which of a table's estimates are clear: the k smallest p, k the largest number with p_k ≤ 5 % k/n (None, NaN: not)."""
    p = np.array([np.nan if one is None else one.p for one in estimates])
    ranked = np.sort(p[~np.isnan(p)])
    below = ranked[ranked <= FALSE * np.arange(1, ranked.size + 1) / ranked.size]
    return p <= below.max(initial=-1.0)


def pooled(groups):
    """Standard deviation within groups, and its degrees of freedom."""
    groups = [np.asarray(list(group), float) for group in groups]
    freedom = sum(group.size - 1 for group in groups)
    squares = sum(float(np.sum((group - group.mean()) ** 2)) for group in groups)
    return (float(np.sqrt(squares / freedom)), freedom) if freedom else (np.nan, 0)
