"""Effects from runs that share what differs between samples: paired changes and intervals of means, by Student's t."""

from typing import NamedTuple

import numpy as np

LEVEL = 0.95
"""Confidence of an interval."""


class Estimate(NamedTuple):
    """A mean with the ends of its 95 % interval; NaN ends for one sample."""

    mean: float
    low: float
    high: float
    samples: int

    def excludes(self, value):
        """Whether the interval excludes a value."""
        return not np.isnan(self.low) and not self.low <= value <= self.high


def interval(values, deviation=None, freedom=None):
    """`Estimate` of the mean of independent values.

    deviation, freedom: a standard deviation pooled over like cases, and its degrees of freedom, in place of the values' own.
    """
    from scipy import stats

    values = np.asarray(list(values), float)
    if deviation is None:
        freedom = values.size - 1
        deviation = float(np.std(values, ddof=1)) if freedom else np.nan
    half = stats.t.ppf(0.5 + 0.5 * LEVEL, freedom) * deviation / np.sqrt(values.size) if freedom else np.nan
    mean = float(np.mean(values))
    return Estimate(mean, mean - half, mean + half, values.size)


def change(before, after):
    """`Estimate` of after/before - 1 of pairs: geometric mean of the ratios, Student's t on their logarithms."""
    found = interval(np.log(np.asarray(after, float) / np.asarray(before, float)))
    return Estimate(*(float(np.expm1(v)) for v in found[:3]), found.samples)


def pooled(groups):
    """Standard deviation within groups, and its degrees of freedom."""
    groups = [np.asarray(list(group), float) for group in groups]
    freedom = sum(group.size - 1 for group in groups)
    squares = sum(float(np.sum((group - group.mean()) ** 2)) for group in groups)
    return (float(np.sqrt(squares / freedom)), freedom) if freedom else (np.nan, 0)
