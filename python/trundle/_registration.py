"""Registration of the environments with Gymnasium, without importing them."""

from __future__ import annotations

from gymnasium.envs.registration import register

__all__ = ["register_environments"]

TASKS = {
    "trundle.envs.tasks": ("LockedWheel", "PushPose", "PushPath", "PushAround", "PushDoor"),
    "trundle.envs.goal": ("PushPoseGoal", "PushPathGoal", "PushAroundGoal", "PushDoorGoal"),
}
"""Names of the environment classes by module."""


def register_environments() -> None:
    """Register every environment as ``trundle/NAME-v0``, alone and as a batch."""
    for module, names in TASKS.items():
        for name in names:
            register(
                id=f"trundle/{name}-v0",
                entry_point=f"{module}:{name}",
                vector_entry_point=f"trundle.envs.vector:{name}Vec",
            )
