"""Shares, medians and interquartile means with intervals of 95 %.

Shares have Wilson's score interval (1927). Medians over seeds and interquartile means have percentile
bootstrap intervals. The latter follow rliable: Agarwal, Schwarzer, Castro, Courville and Bellemare, "Deep
Reinforcement Learning at the Edge of the Statistical Precipice", NeurIPS 2021. Scores are an array of worlds
by runs. Runs are the training runs of a policy; other agents have one. A bootstrap sample draws worlds and
runs with replacement. All agents get the same worlds, so that comparisons are paired. `scipy.stats.bootstrap`
is not used, because it resamples one axis only and does not take infinite values.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.stats import binomtest

__all__ = [
    "Estimate",
    "Interval",
    "Share",
    "calibration",
    "difference",
    "first_reached",
    "first_sustained",
    "improvement",
    "iqm",
    "median",
    "median_difference",
    "rate",
    "relative_excess",
    "share",
]

BOOTSTRAP_SAMPLES = 2000
LEVEL = 0.95

Scores = NDArray[np.float64]


@dataclass(frozen=True)
class Share:
    """A number of hits out of a total, with Wilson's interval of 95 %."""

    hits: int
    total: int

    @property
    def value(self) -> float:
        """The share; NaN for an empty sample."""
        return self.hits / self.total if self.total else math.nan

    @property
    def interval(self) -> tuple[float, float]:
        """Wilson's score interval (1927); [0, 1] for an empty sample."""
        if not self.total:
            return 0.0, 1.0
        low, high = binomtest(self.hits, self.total).proportion_ci(LEVEL, method="wilson")
        return float(low), float(high)

    def text(self) -> str:
        """Return `96.0 % [80 to 99], 24 of 25`."""
        if not self.total:
            return "no case"
        low, high = (100 * end for end in self.interval)
        return f"{100 * self.value:.1f} % [{low:.1f} to {high:.1f}], {self.hits} of {self.total}"


def share(outcomes: Iterable[bool]) -> Share:
    """Count outcomes."""
    found = list(outcomes)
    return Share(sum(found), len(found))


def calibration(
    answers: Sequence[tuple[float, bool]], edges: Sequence[float] = (0.0, 0.5, 0.7, 0.8, 0.9, 0.95, 0.99, 1.0)
) -> list[tuple[float, Share]]:
    """Return for each non-empty bin of probability the mean probability and the share of correct names."""
    rows = []
    for low, high in pairwise(edges):
        last = high == edges[-1]
        inside = [(p, right) for p, right in answers if low <= p < high or (last and p == high)]
        if inside:
            rows.append((sum(p for p, _ in inside) / len(inside), share(right for _, right in inside)))
    return rows


@dataclass(frozen=True)
class Interval:
    """A median over seeds with its interval; infinite if the runs do not reach the threshold."""

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

    Infinite values represent runs that do not reach the threshold. They are larger than any number.
    """
    found = np.asarray(values, dtype=float)
    indices = np.random.default_rng(0).integers(0, found.size, size=(BOOTSTRAP_SAMPLES, found.size))
    tail, draws = (1 - LEVEL) / 2, np.median(np.sort(found)[indices], axis=1)
    low, high = (float(np.quantile(draws, q, method="closest_observation")) for q in (tail, 1 - tail))
    return Interval(float(np.median(found)), low, high)


def median_difference(a: ArrayLike, b: ArrayLike) -> Interval:
    """Return the interval of the median over seeds of `a - b`, paired by seed.

    The difference is zero if both are infinite, because both are censored at the same count.
    """
    x, y = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
    both = np.isinf(x) & np.isinf(y)
    with np.errstate(invalid="ignore"):
        return median(np.where(both, 0.0, x - y))


def first_reached(counts: Sequence[int], scores: Sequence[float | None], threshold: float) -> float:
    """Return the smallest count whose score reaches the threshold; infinite if there is none."""
    reached = [n for n, score in zip(counts, scores, strict=True) if score is not None and score >= threshold]
    return float(min(reached, default=math.inf))


def first_sustained(counts: Sequence[int], scores: Sequence[float | None], threshold: float) -> float:
    """Return the smallest count from which on all scores reach the threshold; infinite if none."""
    kept = math.inf
    for n, score in sorted(zip(counts, scores, strict=True), reverse=True):
        if score is None or score < threshold:
            break
        kept = float(n)
    return kept


@dataclass(frozen=True)
class Estimate:
    """A figure and its interval of 95 %."""

    value: float
    low: float
    high: float

    def text(self, form: str = ".2f", scale: float = 1.0, unit: str = "") -> str:
        """Return `value unit [low, high]`."""
        value, low, high = (f"{scale * one:{form}}" for one in (self.value, self.low, self.high))
        return f"{value}{unit} [{low}, {high}]"


def iqm(scores: Scores) -> Estimate:
    """Return the interquartile mean."""
    return bootstrap_estimate(interquartile_mean, scores)


def rate(outcomes: Scores) -> Estimate:
    """Return the rate of an outcome.

    The interval is Wilson's, with the runs in one world counted as one trial. It is extended to the bootstrap
    interval if that is wider.
    """
    worlds, runs = outcomes.shape
    drawn = bootstrap_estimate(mean, outcomes)
    low, high = Share(round(drawn.value * worlds), worlds).interval
    if runs == 1:
        return Estimate(drawn.value, low, high)
    return Estimate(drawn.value, min(low, drawn.low), max(high, drawn.high))


def difference(a: Scores, b: Scores) -> Estimate:
    """Return the difference of the means of two agents' scores."""
    return bootstrap_estimate(lambda x, y: mean(x) - mean(y), a, b)


def improvement(a: Scores, b: Scores) -> Estimate:
    """Return the probability that one agent's score exceeds another's in the same world.

    Ties count half.
    """
    gaps = a[:, :, None] - b[:, None, :]
    return bootstrap_estimate(mean, ((1 + np.sign(gaps)) / 2).reshape(len(a), -1))


def relative_excess(a: Scores, b: Scores) -> Estimate:
    """Return the relative excess of the sum of one agent's scores over another's."""
    return bootstrap_estimate(lambda x, y: (mean(x) - mean(y)) / np.abs(mean(y)), a, b)


def bootstrap_estimate(figure: Callable[..., Scores], *scores: Scores) -> Estimate:
    """Return a figure of scores, which reduces the last axis, with the interval of its bootstrap draws."""
    value = figure(*(one.reshape(1, -1) for one in scores))[0]
    drawn = figure(*(bootstrap_samples(one).reshape(BOOTSTRAP_SAMPLES, -1) for one in scores))
    low, high = np.quantile(drawn, [(1 - LEVEL) / 2, (1 + LEVEL) / 2])
    return Estimate(float(value), float(low), float(high))


def bootstrap_samples(scores: Scores) -> Scores:
    """Return bootstrap samples, shape (draws, worlds, runs); the same worlds for the same number of them."""
    worlds, runs = scores.shape
    random = np.random.default_rng(0)
    rows = random.integers(0, worlds, size=(BOOTSTRAP_SAMPLES, worlds))
    columns = random.integers(0, runs, size=(BOOTSTRAP_SAMPLES, runs))
    drawn: Scores = scores[rows[:, :, None], columns[:, None, :]]
    return drawn


def interquartile_mean(values: Scores) -> Scores:
    """Return the mean of the middle half of the last axis."""
    count = values.shape[-1]
    cut = count // 4
    kept: Scores = np.sort(values, axis=-1)[..., cut : count - cut].mean(axis=-1)
    return kept


def mean(values: Scores) -> Scores:
    """Return the mean of the last axis."""
    found: Scores = values.mean(axis=-1)
    return found
