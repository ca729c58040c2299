"""Ranges of settings, and the random draws from them."""

from __future__ import annotations

import copy
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from trundle.experiments.sampling import log_uniform
from trundle.rules import Count, Natural, Rule
from trundle.settings import SettingsError

__all__ = ["TUNING_SEEDS", "Range", "Search", "assigned", "check_split"]

TUNING_SEEDS = (500_000, 1_000_000)
"""First seed of tuning worlds, and the one after the last: comparisons use lower, trainings higher seeds."""
DIGITS = 3
"""Significant digits of a drawn number."""


@dataclass(frozen=True)
class Range:
    """The values of a setting: a range of numbers, or choices with equal probability.

    Attributes
    ----------
    low, high : float
        Ends of a range, which is uniform.
    log : bool
        Whether the range is uniform in the logarithm.
    integer : bool
        Whether values are whole numbers.
    schedule : bool
        Whether the value is the start of a linear schedule to zero, as "lin_0.001".
    choices : list
    """

    low: float | None = None
    high: float | None = None
    log: bool = False
    integer: bool = False
    schedule: bool = False
    choices: list[Any] | None = None

    def __post_init__(self) -> None:
        numbers = self.low, self.high
        if self.choices is not None:
            if not self.choices or numbers != (None, None) or self.log or self.integer or self.schedule:
                raise SettingsError("choices: give at least one, and no other key")
        elif self.low is None or self.high is None or not self.low < self.high:
            raise SettingsError("give low < high, or choices")
        elif self.log and self.low <= 0.0:
            raise SettingsError(f"log = true, low = {self.low}: low must be positive")

    def draw(self, random: np.random.Generator) -> Any:
        """Return a random value."""
        if self.choices is not None:
            return self.choices[int(random.integers(len(self.choices)))]
        low, high = self.low or 0.0, self.high or 0.0
        value = log_uniform(random, low, high) if self.log else float(random.uniform(low, high))
        if self.integer:
            return math.floor(value + 0.5)
        text = f"{value:.{DIGITS}g}"
        return f"lin_{text}" if self.schedule else float(text)


@dataclass(frozen=True)
class Search:
    """A random search (Bergstra & Bengio 2012).

    Attributes
    ----------
    ranges : dict of str to Range
        By setting; "policy_kwargs.log_std_init" is one in a table.
    trials : int
        Number of random trials, in addition to the settings of the file.
    share : float
        Share of the steps and updates of a training that a trial has.
    seed : int
        Seed of the draws. A trial does not depend on the number of trials.
    first, episodes : int
        The tuning worlds have the seeds `first` to `first + episodes - 1`.
    """

    ranges: Annotated[dict[str, Range], Rule(bool, "at least one range")]
    trials: Count = 10
    share: Annotated[float, Rule(lambda value: 0.0 < value <= 1.0, "a number above 0, at most 1")] = 0.05
    seed: Natural = 0
    first: int = 700_000
    episodes: Count = 100

    def __post_init__(self) -> None:
        low, high = TUNING_SEEDS
        if not low <= self.first <= high - self.episodes:
            raise SettingsError(f"first = {self.first}: tuning worlds have seeds from {low} to {high - 1}")

    @property
    def worlds(self) -> range:
        """Seeds of the tuning worlds."""
        return range(self.first, self.first + self.episodes)

    def values(self, trial: int) -> dict[str, Any]:
        """Return the drawn settings of a trial from 1 on; trial 0 has none."""
        if trial == 0:
            return {}
        random = np.random.default_rng([self.seed, trial])
        return {key: one.draw(random) for key, one in self.ranges.items()}


def assigned(table: Mapping[str, Any], values: Mapping[str, Any]) -> dict[str, Any]:
    """Return a table with other values; a key with dots is one in an inner table."""
    found = copy.deepcopy(dict(table))
    for key, value in values.items():
        *outer, last = key.split(".")
        inner = found
        for name in outer:
            inner = inner.setdefault(name, {})
        inner[last] = value
    return found


def check_split(env_kwargs: Mapping[str, Any]) -> None:
    """Refuse a search on test objects."""
    if env_kwargs.get("split", "train") != "train":
        raise SettingsError('env_kwargs: split = "test": a search uses training objects; set split = "train"')
