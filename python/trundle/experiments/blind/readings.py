"""What instruments would say without noise."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from trundle.experiments.blind.push import Grasp

__all__ = ["Readings", "gripper_poses", "interpolate"]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Readings:
    """What the instruments would say without noise, on a fine grid over the whole episode.

    Attributes
    ----------
    t : array (n,)
        s.
    pose, gripper : array (n, 3)
        Of the tracked frames in the world.
    wrench : array (n, 3)
        Reading less the sensor's offset, gripper axes; zero before contact.
    """

    t: Floats
    pose: Floats
    gripper: Floats
    wrench: Floats

    def changed(self, **arrays: Floats) -> Readings:
        """Return it with some arrays replaced."""
        return replace(self, **arrays)


def interpolate(t: Floats, values: Floats, at: Floats) -> Floats:
    """Return columns of `values` at other times."""
    return np.column_stack([np.interp(at, t, column) for column in values.T])


def gripper_poses(pose: Floats, grasp: Grasp) -> Floats:
    """Return poses of the gripper on an object at `pose` (n, 3)."""
    c, s = np.cos(pose[:, 2]), np.sin(pose[:, 2])
    x = pose[:, 0] + c * grasp.x - s * grasp.y
    y = pose[:, 1] + s * grasp.x + c * grasp.y
    return np.column_stack([x, y, pose[:, 2] + grasp.angle])
