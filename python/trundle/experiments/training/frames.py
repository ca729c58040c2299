"""Observations in the object's frame."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["TASKS", "entry_count", "to_frame", "to_object_frame"]

Array = NDArray[np.float64]

GOAL_INDEX, HEADING_INDEX = 7, 9
"""Indices of the goal's position and heading in an observation, two entries each."""
CLOSE_SCALE = 0.1
"""Offset (m or rad) at which a saturated goal entry is half of its limit."""
CLOSE_ENTRIES = 3
"""Number of saturated goal entries."""
TASKS: dict[str, tuple[tuple[int, ...], tuple[int, ...]]] = {
    "trundle/PushPose-v0": ((), ()),
    "trundle/LockedWheel-v0": ((), ()),
    "trundle/PushPath-v0": ((-4, -2), ()),
    "trundle/PushAround-v0": ((-6,), (-4,)),
    "trundle/PushDoor-v0": ((-5,), (-3,)),
}
"""Indices of the task's own positions and directions, counted from the end of an observation."""


def to_frame(observations: Array, task: str, frame: str) -> NDArray[np.float32]:
    """Return observations of shape (n, entries) in a frame, float32."""
    told = to_object_frame(observations, task) if frame == "object" else observations
    return np.asarray(told, dtype=np.float32)


def entry_count(entries: int, frame: str) -> int:
    """Return the number of entries of an observation in a frame."""
    return entries + CLOSE_ENTRIES if frame == "object" else entries


def to_object_frame(observations: Array, task: str) -> Array:
    """Return observations in the object's frame, without loss of information.

    The object's position is replaced by the world's origin in the object's frame. Its heading stays, because
    both together locate the boundary of the workspace. Velocity, goal and the task's own places are rotated.
    Three saturated entries of the goal's position and heading are appended, each divided by its size plus 0.1
    (m, rad), because a network learns centimetres slowly from entries in metres.

    Parameters
    ----------
    observations : ndarray, shape (n, entries)
        World frame, from the environment.
    task : str
        The environment's id.
    """
    told = observations.copy()
    place, cos, sin = observations[:, 0:2], observations[:, 2], observations[:, 3]
    points, directions = TASKS[task]

    def turned(vectors: Array) -> Array:
        x, y = vectors[:, 0], vectors[:, 1]
        return np.stack([cos * x + sin * y, cos * y - sin * x], axis=1)

    told[:, 0:2] = turned(-place)
    told[:, 4:6] = turned(observations[:, 4:6])
    for k in (GOAL_INDEX, *(observations.shape[1] + point for point in points)):
        told[:, k : k + 2] = turned(observations[:, k : k + 2] - place)
    for k in (HEADING_INDEX, *(observations.shape[1] + way for way in directions)):
        told[:, k : k + 2] = turned(observations[:, k : k + 2])
    goal = told[:, GOAL_INDEX : GOAL_INDEX + 2]
    turn = np.arctan2(told[:, HEADING_INDEX + 1], told[:, HEADING_INDEX])[:, None]
    near = goal / (np.hypot(goal[:, :1], goal[:, 1:]) + CLOSE_SCALE)
    return np.concatenate([told, near, turn / (np.abs(turn) + CLOSE_SCALE)], axis=1)
