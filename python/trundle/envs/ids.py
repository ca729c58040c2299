"""Ids of the environments whose observations are arrays."""

from __future__ import annotations

import re

from gymnasium import registry

from trundle.envs.push import Push
from trundle.envs.tasks import LockedWheel, PushAround, PushDoor, PushPath, PushPose

__all__ = ["FLAT", "flat_id", "flat_ids", "has_obstacles", "task_of"]

FLAT: tuple[type[Push], ...] = (LockedWheel, PushPose, PushPath, PushAround, PushDoor)
"""The tasks whose observations are arrays."""
ID = re.compile(rf"trundle/(?P<task>{'|'.join(task.__name__ for task in FLAT)})(Easy|Medium|Hard)?-v\d+")


def flat_ids() -> list[str]:
    """Return the registered ids, of all versions and levels."""
    return sorted(env_id for env_id in registry if ID.fullmatch(env_id))


def task_of(env_id: str) -> type[Push] | None:
    """Return the task of a registered id; None for others."""
    found = ID.fullmatch(env_id) if env_id in registry else None
    return found and next(task for task in FLAT if task.__name__ == found["task"])


def has_obstacles(env_id: str) -> bool:
    """Return whether the observations of a registered id contain obstacles."""
    task = task_of(env_id)
    return task is not None and task.seen_obstacles is not Push.seen_obstacles


def flat_id(name: str) -> str | None:
    """Return the id of a name such as "PushAround-v1", "PushAroundHard" or "PushAround"; None for others.

    Without a version the first one is chosen.
    """
    return next(
        (f"trundle/{name}{end}" for end in ("", "-v0", "-v1") if task_of(f"trundle/{name}{end}")), None
    )
