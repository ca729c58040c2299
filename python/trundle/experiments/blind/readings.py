"""Readings of perfect instruments."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from trundle.experiments.blind.push import Grasp
from trundle.experiments.sampling import Floats

__all__ = ["Readings", "gripper_poses", "interpolate", "step_averages"]


@dataclass(frozen=True)
class Readings:
    """Readings without noise, on a fine grid over the whole episode.

    Attributes
    ----------
    t : array (n,)
        s.
    pose, gripper : array (n, 3)
        Of the tracked frames in the world.
    wrench : array (n, 3)
        Reading without the sensor's offset, gripper axes; zero before contact.
    """

    t: Floats
    pose: Floats
    gripper: Floats
    wrench: Floats

    def changed(self, **arrays: Floats) -> Readings:
        """Return the readings with some arrays replaced."""
        return replace(self, **arrays)


def interpolate(t: Floats, values: Floats, at: Floats) -> Floats:
    """Return the columns of `values` interpolated at other times."""
    return np.column_stack([np.interp(at, t, column) for column in values.T])


def step_averages(forces: Floats) -> Floats:
    """Return forces (n, 3) at the times of the steps. Each given force is constant over one step."""
    return np.vstack([forces[:1], (forces[1:] + forces[:-1]) / 2])


def gripper_poses(pose: Floats, grasp: Grasp) -> Floats:
    """Return the poses of the gripper on an object at `pose` (n, 3)."""
    c, s = np.cos(pose[:, 2]), np.sin(pose[:, 2])
    x = pose[:, 0] + c * grasp.x - s * grasp.y
    y = pose[:, 1] + s * grasp.x + c * grasp.y
    return np.column_stack([x, y, pose[:, 2] + grasp.angle])
