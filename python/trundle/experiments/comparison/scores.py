"""Figures of episodes: from rows to scores of worlds by runs, and to estimates."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from trundle.experiments.results import Row
from trundle.experiments.statistics import Estimate, Scores, iqm, rate, relative_excess

__all__ = [
    "MAX_QUICK_PUSHES",
    "negative_return",
    "quick_success",
    "regret",
    "regret_iqm",
    "scores",
    "success",
    "time_to_success",
]

MAX_QUICK_PUSHES = 2
"""Pushes of learning that a success may take to count as quick."""

Figure = Callable[[Row], float]


def scores(rows: Sequence[Row], figure: Figure) -> Scores:
    """Return a figure of an agent's rows, shape (worlds, runs)."""
    seeds = {seed: k for k, seed in enumerate(dict.fromkeys(row["seed"] for row in rows))}
    runs = {run: k for k, run in enumerate(dict.fromkeys(row["run"] for row in rows))}
    found = np.full((len(seeds), len(runs)), np.nan)
    for row in rows:
        found[seeds[row["seed"]], runs[row["run"]]] = figure(row)
    return found


def success(rows: Sequence[Row]) -> Estimate:
    """Return how often an agent succeeds."""
    return rate(scores(rows, lambda row: row["success"]))


def quick_success(rows: Sequence[Row], push: float) -> Estimate:
    """Return how often it succeeds after learning for few pushes, of `push` s each."""
    return rate(scores(rows, lambda row: row["success"] and row["learning"] <= MAX_QUICK_PUSHES * push))


def time_to_success(row: Row) -> float:
    """Return when an episode succeeded, s; one that did not counts as long as it might have lasted."""
    return float(row["seconds"] if row["success"] else row["limit"])


def negative_return(row: Row) -> float:
    """Return minus the return."""
    return -float(row["return"])


def regret(rows: Sequence[Row], oracle: Sequence[Row], figure: Figure = negative_return) -> Estimate:
    """Return by which share the sum of a cost over all worlds exceeds the oracle's."""
    return relative_excess(scores(rows, figure), scores(oracle, figure))


def regret_iqm(rows: Sequence[Row], oracle: Sequence[Row], figure: Figure = negative_return) -> Estimate:
    """Return the interquartile mean over worlds of the share by which a cost exceeds the oracle's."""
    theirs = scores(oracle, figure)
    return iqm((scores(rows, figure) - theirs) / np.abs(theirs))
