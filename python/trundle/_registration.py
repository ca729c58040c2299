"""Registration of the environments with Gymnasium, without importing them."""

from __future__ import annotations

import warnings
from typing import Any

from gymnasium.envs.registration import register

__all__ = ["register_environments"]

TASKS = {
    "trundle.envs.tasks": ("LockedWheel", "PushPose", "PushPath", "PushAround", "PushDoor"),
    "trundle.envs.goal": ("PushPoseGoal", "PushPathGoal", "PushAroundGoal", "PushDoorGoal"),
}
"""Names of the environment classes by module."""


LEVELS = ("easy", "medium", "hard")
"""Levels, each of which is part of an id of every task in `LEVEL_TASKS`."""
LEVEL_TASKS = ("PushPose", "PushPath", "PushAround", "PushDoor")
MAX_EPISODE_STEPS = 300
"""Time limit of version 1."""
REWARD_THRESHOLDS = {
    "LockedWheel": -2.0,
    "PushPose": -2.0,
    "PushPath": 0.0,
    "PushAround": -12.0,
    "PushDoor": -8.0,
}
"""Mean returns above which a task of version 1 is solved; `AdaptiveAgent` exceeds them on a locked wheel."""


def register_environments() -> None:
    """Register every environment as ``trundle/NAME-v0`` and ``-v1``, alone and as a batch, and the levels."""
    # Version 0 is supported: its observations and rewards never change, and trained policies need it.
    warnings.filterwarnings("ignore", r".*trundle/\w+-v0 is out of date", DeprecationWarning)
    for module, names in TASKS.items():
        for name in names:
            points: dict[str, Any] = {
                "entry_point": f"{module}:{name}",
                "vector_entry_point": f"trundle.envs.vector:{name}Vec",
            }
            register(id=f"trundle/{name}-v0", **points)
            levels: dict[str, dict[str, str]] = {name: {}} | (
                {f"{name}{level.title()}": {"level": level} for level in LEVELS}
                if name in LEVEL_TASKS
                else {}
            )
            for title, chosen in levels.items():
                register(
                    id=f"trundle/{title}-v1",
                    **points,
                    kwargs={"version": 1, **chosen},
                    max_episode_steps=MAX_EPISODE_STEPS,
                    reward_threshold=REWARD_THRESHOLDS.get(name),
                )
