"""Scores of worlds by runs from rows of episodes, and their estimates."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from trundle.experiments.results import Row
from trundle.experiments.statistics import Estimate, Scores, iqm, rate, relative_excess

__all__ = [
    "MAX_QUICK_PUSHES",
    "is_untouched_success",
    "middle",
    "quick_success",
    "regret",
    "regret_iqm",
    "scores",
    "share",
    "success",
    "time_to_success",
    "untouched_success",
]

MAX_QUICK_PUSHES = 2
"""Largest number of learning pushes of a quick success."""

Figure = Callable[[Row], float]


def scores(rows: Sequence[Row], figure: Figure) -> Scores:
    """Return a figure of an agent's rows, shape (worlds, runs)."""
    seeds = {seed: k for k, seed in enumerate(dict.fromkeys(row["seed"] for row in rows))}
    runs = {run: k for k, run in enumerate(dict.fromkeys(row["run"] for row in rows))}
    found = np.full((len(seeds), len(runs)), np.nan)
    for row in rows:
        found[seeds[row["seed"]], runs[row["run"]]] = figure(row)
    return found


def share(rows: Sequence[Row], outcome: Figure) -> Estimate:
    """Return the rate of an outcome of an agent."""
    return rate(scores(rows, outcome))


def middle(rows: Sequence[Row], figure: Figure) -> Estimate:
    """Return the interquartile mean of a figure of an agent."""
    return iqm(scores(rows, figure))


def success(rows: Sequence[Row]) -> Estimate:
    """Return an agent's success rate."""
    return share(rows, lambda row: row["success"])


def untouched_success(rows: Sequence[Row]) -> Estimate:
    """Return an agent's rate of success without touching an obstacle."""
    return share(rows, is_untouched_success)


def is_untouched_success(row: Row) -> bool:
    """Return whether an episode reached the goal without touching an obstacle."""
    return bool(row["success"] and row["touches"] == 0)


def quick_success(rows: Sequence[Row], push: float) -> Estimate:
    """Return the rate of success after at most `MAX_QUICK_PUSHES` learning pushes of `push` s each."""
    return share(rows, lambda row: row["success"] and row["learning"] <= MAX_QUICK_PUSHES * push)


def time_to_success(row: Row) -> float:
    """Return the time of an episode's success, s; its time limit without success."""
    return float(row["seconds"] if row["success"] else row["limit"])


def negative_return(row: Row) -> float:
    """Return minus the return."""
    return -float(row["return"])


def regret(rows: Sequence[Row], oracle: Sequence[Row], figure: Figure = negative_return) -> Estimate:
    """Return the relative excess of a cost over the oracle's, both summed over all worlds."""
    return relative_excess(scores(rows, figure), scores(oracle, figure))


def regret_iqm(rows: Sequence[Row], oracle: Sequence[Row]) -> Estimate:
    """Return the interquartile mean over worlds of the relative excess of the cost over the oracle's."""
    costs = scores(oracle, negative_return)
    return iqm((scores(rows, negative_return) - costs) / np.abs(costs))
