"""Gymnasium environments, registered when `trundle` is imported.

========================== ==================================================================
id                         task
========================== ==================================================================
``trundle/LockedWheel-v0`` push a table, one wheel of which is locked, to a pose
========================== ==================================================================
"""

from gymnasium.envs.registration import register

from trundle.envs.locked_wheel import LockedWheel

__all__ = ["LockedWheel"]

register(
    id="trundle/LockedWheel-v0",
    entry_point="trundle.envs.locked_wheel:LockedWheel",
    max_episode_steps=300,
)
