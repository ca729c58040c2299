"""Evaluate a policy on fixed worlds."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import gymnasium as gym
import numpy as np

from trundle.envs.oracle import VectorOracle
from trundle.experiments.training.policy import Policy

__all__ = ["evaluate"]

ENDS = {
    "is_success": "success",
    "success_without_touching": "untouched",
    "lost": "lost",
    "distance": "distance",
    "heading_error": "heading",
}
"""Name in a result of each of the last infos of an episode."""


def evaluate(
    policy: Policy, env: str, env_kwargs: Mapping[str, Any], first: int, episodes: int
) -> dict[str, float]:
    """Run one episode in each of some worlds, in parallel.

    Parameters
    ----------
    policy : Policy
    env : str
        The environment's id.
    env_kwargs : mapping
        Its arguments.
    first, episodes : int
        The seeds are `first` to `first + episodes - 1`.

    Returns
    -------
    dict
        Means over the worlds: `success`, `untouched` (success without touching) and `lost` (rates), remaining
        `distance` (m) and `heading` (rad), `return` (of the environment's own reward), `length` (steps).
    """
    worlds: Any = gym.make_vec(env, episodes, "vector_entry_point", **env_kwargs)
    if policy.about.hidden:
        worlds = VectorOracle(worlds)
    observations, _ = worlds.reset(seed=first)
    under_way = np.ones(episodes, dtype=bool)
    gained, lengths = np.zeros(episodes), np.zeros(episodes)
    ends = {key: np.zeros(episodes) for key in ENDS}
    state = None
    while under_way.any():
        actions, state = policy.predict(observations, state)
        observations, rewards, terminated, truncated, infos = worlds.step(actions)
        gained[under_way] += rewards[under_way]
        lengths[under_way] += 1
        # An environment that has ended is reset; its further steps are not counted.
        ended = under_way & (terminated | truncated)
        for key, column in ends.items():
            column[ended] = np.abs(infos[key][ended])
        under_way &= ~ended
    worlds.close()
    means = {ENDS[key]: float(column.mean()) for key, column in ends.items()}
    return {**means, "return": float(gained.mean()), "length": float(lengths.mean())}
