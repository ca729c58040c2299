"""Medians over seeds with bootstrap intervals, also of counts that a run may not reach."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["Interval", "first_reached", "median", "median_difference", "stays"]

DRAWS = 2000
"""Bootstrap samples."""
LEVEL = 0.95


@dataclass(frozen=True)
class Interval:
    """A median over seeds and its interval; infinite where a run of 50 was not enough."""

    middle: float
    low: float
    high: float

    def text(self, form: str = ".3g", unreached: str = "not reached") -> str:
        """Return `middle [low, high]`."""
        one = [format(v, form) if math.isfinite(v) else unreached for v in (self.middle, self.low, self.high)]
        if one[0] == unreached and one[1] == unreached:
            return unreached
        return f"{one[0]} [{one[1]}, {one[2]}]" if one[1] != one[2] else one[0]


def median(values: ArrayLike) -> Interval:
    """Return the median over seeds with its percentile bootstrap interval of 95 %.

    Infinite values stand for runs that did not get there: they are larger than any number, which is all
    that a median needs to know of them.
    """
    found = np.sort(np.asarray(values, dtype=float))
    return interval(middle_of(found), middles(found[resampled(found.size)]))


def median_difference(a: ArrayLike, b: ArrayLike) -> Interval:
    """Return the interval of the median over seeds of `a - b`, paired by seed.

    Where neither got there the difference is zero: both are censored at the same count.
    """
    x, y = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
    both = np.isinf(x) & np.isinf(y)
    with np.errstate(invalid="ignore"):
        return median(np.where(both, 0.0, x - y))


def first_reached(counts: Sequence[int], scores: Sequence[float | None], threshold: float) -> float:
    """Return the least count at which a score reaches the threshold; infinite if none does."""
    reached = [n for n, score in zip(counts, scores, strict=True) if score is not None and score >= threshold]
    return float(min(reached, default=math.inf))


def stays(counts: Sequence[int], scores: Sequence[float | None], threshold: float) -> float:
    """Return the least count from which on every score reaches the threshold; infinite if there is none."""
    kept = math.inf
    for n, score in sorted(zip(counts, scores, strict=True), reverse=True):
        if score is None or score < threshold:
            break
        kept = float(n)
    return kept


def interval(middle: float, draws: NDArray[np.float64]) -> Interval:
    """Return the interval of bootstrap draws around a middle."""
    tail = (1 - LEVEL) / 2
    low, high = (float(np.quantile(draws, q, method="closest_observation")) for q in (tail, 1 - tail))
    return Interval(middle, low, high)


def resampled(n: int) -> NDArray[np.int64]:
    """Return indices of bootstrap samples (DRAWS, n), the same for the same n."""
    return np.sort(np.random.default_rng(0).integers(0, n, size=(DRAWS, n)), axis=1)


def middles(rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the median of each row of sorted values."""
    n = rows.shape[1]
    low, high = rows[:, (n - 1) // 2], rows[:, n // 2]
    return np.where(low == high, high, (low + high) / 2)


def middle_of(values: NDArray[np.float64]) -> float:
    """Return the median of sorted values, also of infinite ones."""
    return float(middles(values[None, :])[0])
