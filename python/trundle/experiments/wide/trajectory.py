"""Ideal readings of a simulated motion."""

from __future__ import annotations

import numpy as np

from trundle.experiments.blind.instruments import GRID_STEP_S
from trundle.experiments.blind.push import CONTACT_TIME_S
from trundle.experiments.blind.readings import Readings, gripper_poses, interpolate
from trundle.experiments.sampling import Floats
from trundle.experiments.wide.scene import WideScene

__all__ = ["first_contact_time", "grasp_readings", "grid_readings"]


def grasp_readings(scene: WideScene, episode: int, t: Floats, pose: Floats, wrench: Floats) -> Readings:
    """Return the readings of a grasp whose wrench is given in its axes about its origin.

    A compliant grasp has no mass: the gripper is displaced in proportion to the wrench.
    """
    grasp = gripper_poses(pose, scene.pushes[episode].grasp)
    along, turn = scene.compliance
    c, s = np.cos(grasp[:, 2]), np.sin(grasp[:, 2])
    fx, fy = c * wrench[:, 0] - s * wrench[:, 1], s * wrench[:, 0] + c * wrench[:, 1]
    shift = along * np.column_stack([fx, fy])
    gripper = np.column_stack([grasp[:, :2] + shift, grasp[:, 2] + turn * wrench[:, 2]])
    # The gripper is shifted along the force, so the moment about its origin is that about the grasp.
    return grid_readings(scene, episode, t, pose, gripper, np.column_stack([fx, fy, wrench[:, 2]]))


def grid_readings(
    scene: WideScene, episode: int, t: Floats, pose: Floats, gripper: Floats, wrench: Floats
) -> Readings:
    """Return readings on the grid, with the rest before contact.

    Parameters
    ----------
    t, pose, gripper : array
        From contact on.
    wrench : array (n, 3)
        On the object: force in world axes, moment about the gripper's origin.
    """
    grid: Floats = GRID_STEP_S * np.arange(round(scene.seconds[episode] / GRID_STEP_S) + 1, dtype=np.float64)
    poses, grippers, world = (interpolate(t, values, grid) for values in (pose, gripper, wrench))
    c, s = np.cos(grippers[:, 2]), np.sin(grippers[:, 2])
    fx, fy = c * world[:, 0] + s * world[:, 1], c * world[:, 1] - s * world[:, 0]
    reading = np.column_stack([fx, fy, world[:, 2]])
    reading[grid < CONTACT_TIME_S] = 0.0
    grippers[grid < CONTACT_TIME_S] = resting_gripper(scene, episode, pose[0], gripper[0])
    return Readings(grid, poses, grippers, reading)


def resting_gripper(scene: WideScene, episode: int, pose: Floats, gripper: Floats) -> Floats:
    """Return the gripper's pose before contact."""
    return gripper if scene.strokes else gripper_poses(pose[None, :], scene.pushes[episode].grasp)[0]


def first_contact_time(seen: Readings) -> float:
    """Return the time of the first force, s; the end if there is none."""
    touches = np.flatnonzero(np.hypot(seen.wrench[:, 0], seen.wrench[:, 1]) > 1e-6)
    return float(seen.t[touches[0]] if len(touches) else seen.t[-1])
