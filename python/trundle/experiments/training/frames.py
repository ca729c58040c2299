"""Observations in the object's frame."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from trundle.envs.ids import task_of
from trundle.envs.observation import Observation
from trundle.envs.push import Push
from trundle.envs.tasks import LockedWheel, PushAround, PushDoor, PushPath, PushPose
from trundle.experiments.sampling import Floats

__all__ = ["entry_count", "to_frame", "to_object_frame"]


CLOSE_SCALE = 0.1
"""Offset (m or rad) at which a saturated goal entry is half of its limit."""
CLOSE_ENTRIES = 3
"""Number of saturated goal entries."""
TASKS: dict[type[Push], Callable[[Observation], tuple[Sequence[Floats], Sequence[Floats]]]] = {
    PushPose: lambda fields: ([], []),
    LockedWheel: lambda fields: ([], []),
    PushPath: lambda fields: (list(np.moveaxis(fields.path_points, -2, 0)), []),
    PushAround: lambda fields: ([fields.box_position], [fields.box_direction]),
    PushDoor: lambda fields: ([fields.door_position], [fields.door_direction]),
}
"""The task's own positions and directions in a batch of observations, as views of shape (n, 2)."""


def to_frame(observations: Floats, env: str, frame: str, hidden: int) -> NDArray[np.float32]:
    """Return observations of shape (n, entries) in a frame, float32.

    The last `hidden` entries are hidden parameters, in object axes already.
    """
    seen, parameters = np.split(observations, [observations.shape[1] - hidden], axis=1)
    converted = to_object_frame(seen, env) if frame == "object" else seen
    return np.concatenate([converted, parameters], axis=1).astype(np.float32)


def entry_count(entries: int, frame: str) -> int:
    """Return the number of entries of an observation in a frame."""
    return entries + CLOSE_ENTRIES if frame == "object" else entries


def to_object_frame(observations: Floats, env: str) -> Floats:
    """Return observations in the object's frame, without loss of information.

    The object's position is replaced by the world's origin in the object's frame. Its heading stays, because
    both together locate the boundary of the workspace. Velocity, goal and the task's own places are rotated.
    Three saturated entries of the goal's position and heading are appended, each divided by its size plus 0.1
    (m, rad), because a network learns centimetres slowly from entries in metres.

    Parameters
    ----------
    observations : ndarray, shape (n, entries)
        World frame, from the environment.
    env : str
        The environment's id.
    """
    origin = Observation(observations).position
    cos, sin = Observation(observations).direction.T
    fields = Observation(observations.copy())  # the fields are views: the assignments below change its vector
    points, directions = TASKS[task_of(env) or Push](fields)

    def rotated(vectors: Floats) -> Floats:
        x, y = vectors.T
        return np.stack([cos * x + sin * y, cos * y - sin * x], axis=1)

    fields.position[:] = rotated(-origin)
    for point in (fields.goal_position, *points):
        point[:] = rotated(point - origin)
    for vector in (fields.velocity, fields.goal_direction, *directions):
        vector[:] = rotated(vector)
    goal, turn = fields.goal_position, fields.goal_heading[:, None]
    near = goal / (np.hypot(goal[:, :1], goal[:, 1:]) + CLOSE_SCALE)
    return np.concatenate([fields.vector, near, turn / (np.abs(turn) + CLOSE_SCALE)], axis=1)
