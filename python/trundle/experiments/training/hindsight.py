"""Hindsight experience replay: training on goal-conditioned environments, export for those with arrays.

A goal-conditioned environment splits the observation of its task into a part without the goal, the achieved
goal and the desired goal. The exported policy sees the observation of the task, so that it can be compared
with others.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from gymnasium import registry
from numpy.typing import NDArray

from trundle.envs.observation import GOAL, POSE
from trundle.experiments.training.network import Layer

__all__ = ["BUFFER_ARRAYS", "entry_count", "flat_layer", "flat_scales", "goal_id"]

BUFFER_ARRAYS = ("ep_start", "ep_length")
"""Further arrays of the replay buffer; the first axis is filled from the start."""
OBSERVATION, ACHIEVED, DESIRED = "observation", "achieved_goal", "desired_goal"


def goal_id(env: str) -> str | None:
    """Return the id of the goal-conditioned version of a task; None if there is none."""
    found = "Goal-v".join(env.rsplit("-v", 1))
    return found if found in registry else None


def entry_count(parts: Mapping[str, Any]) -> int:
    """Return the number of entries of the task's observation, given the spaces or arrays of its parts."""
    return int(parts[OBSERVATION].shape[-1] + parts[DESIRED].shape[-1])


def places(parts: Mapping[str, Any]) -> dict[str, NDArray[np.intp]]:
    """Return the entries of the task's observation that each part contains."""
    every = np.arange(entry_count(parts))
    return {OBSERVATION: np.delete(every, GOAL), ACHIEVED: every[POSE], DESIRED: every[GOAL]}


def flat_layer(layer: Layer, parts: Mapping[str, Any]) -> Layer:
    """Return the first layer of a network of all parts, in their order, as one of the task's observation."""
    weight, bias = layer
    flat = np.zeros((len(weight), entry_count(parts)), weight.dtype)
    where, start = places(parts), 0
    for name, part in parts.items():
        width = part.shape[-1]
        flat[:, where[name]] += weight[:, start : start + width]
        start += width
    return flat, bias


def flat_scales(parts: Mapping[str, NDArray[np.float64]]) -> NDArray[np.float64]:
    """Return statistics of the parts as those of the task's observation.

    The achieved goal has those of the pose in the observation, which are the same.
    """
    flat = np.zeros(entry_count(parts))
    for name in (OBSERVATION, DESIRED):
        flat[places(parts)[name]] = parts[name]
    return flat
