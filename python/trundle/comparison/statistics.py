"""Interquartile means and rates over worlds and runs, with intervals, after rliable.

Agarwal, Schwarzer, Castro, Courville and Bellemare, "Deep Reinforcement Learning at the Edge of the
Statistical Precipice", NeurIPS 2021. Scores stand in an array of worlds by runs: the runs are those of a
policy's training, one of any other agent. A bootstrap sample draws worlds, and runs, with replacement; all
agents get the same worlds, so that what is compared is paired.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trundle.proof.statistics import Share

__all__ = ["Estimate", "difference", "excess", "improvement", "iqm", "rate"]

DRAWS = 2000
"""Bootstrap samples."""
LEVEL = 0.95

Scores = NDArray[np.float64]


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
    return estimated(middle, scores)


def rate(outcomes: Scores) -> Estimate:
    """Return how often something is so.

    Wilson's interval, as if the runs in one world were one trial; where the bootstrap over runs reaches
    further, its end.
    """
    worlds, runs = outcomes.shape
    drawn = estimated(mean, outcomes)
    low, high = Share(round(drawn.value * worlds), worlds).interval
    if runs == 1:
        return Estimate(drawn.value, low, high)
    return Estimate(drawn.value, min(low, drawn.low), max(high, drawn.high))


def difference(a: Scores, b: Scores) -> Estimate:
    """Return by how much the mean of one agent's scores is greater than another's."""
    return estimated(lambda x, y: mean(x) - mean(y), a, b)


def improvement(a: Scores, b: Scores) -> Estimate:
    """Return the probability that one agent's score is greater than another's in the same world.

    Ties count half.
    """
    gaps = a[:, :, None] - b[:, None, :]
    return estimated(mean, ((1 + np.sign(gaps)) / 2).reshape(len(a), -1))


def excess(a: Scores, b: Scores) -> Estimate:
    """Return by which share the sum of one agent's scores is greater than another's."""
    return estimated(lambda x, y: (mean(x) - mean(y)) / np.abs(mean(y)), a, b)


def estimated(figure: Callable[..., Scores], *scores: Scores) -> Estimate:
    """Return a figure of scores, whose last axis it takes away, and the interval of its bootstrap draws."""
    value = figure(*(one.reshape(1, -1) for one in scores))[0]
    drawn = figure(*(resampled(one).reshape(DRAWS, -1) for one in scores))
    low, high = np.quantile(drawn, [(1 - LEVEL) / 2, (1 + LEVEL) / 2])
    return Estimate(float(value), float(low), float(high))


def resampled(scores: Scores) -> Scores:
    """Return bootstrap samples, shape (draws, worlds, runs): the same worlds for as many of them."""
    worlds, runs = scores.shape
    random = np.random.default_rng(0)
    rows = random.integers(0, worlds, size=(DRAWS, worlds))
    columns = random.integers(0, runs, size=(DRAWS, runs))
    drawn: Scores = scores[rows[:, :, None], columns[:, None, :]]
    return drawn


def middle(values: Scores) -> Scores:
    """Return the mean of the middle half of the last axis."""
    count = values.shape[-1]
    cut = count // 4
    kept: Scores = np.sort(values, axis=-1)[..., cut : count - cut].mean(axis=-1)
    return kept


def mean(values: Scores) -> Scores:
    """Return the mean of the last axis."""
    found: Scores = values.mean(axis=-1)
    return found
