"""Poses of a tracker, transformed to the object and sensor frames and projected to the floor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from trundle.importers.config import MapError
from trundle.importers.layout import Floats, SourceError
from trundle.importers.rotations import from_axes, from_rpy, heading, product, rotate, tilt
from trundle.importers.streams import Stream

__all__ = ["Axis", "Offset", "Poses", "World", "gripper_stream", "object_stream"]

Axis = Literal["x", "y", "z", "-x", "-y", "-z"]

MAX_LEAN_RAD = np.radians(20.0)
"""Maximum tilt of the object frame, rad; more indicates interchanged axes."""


@dataclass(frozen=True)
class Offset:
    """Constant pose of the frame to record, relative to the tracked frame.

    Attributes
    ----------
    translation : 3 floats
        In axes of the tracked frame, m.
    quaternion_wxyz : 4 floats
        Rotation from the frame to record to the tracked frame.
    rpy_deg : 3 floats
        The same rotation as roll, pitch, yaw in degrees, about fixed x, then y, then z. Give one of the two.
    """

    translation: tuple[float, float, float] = (0.0, 0.0, 0.0)
    quaternion_wxyz: tuple[float, float, float, float] | None = None
    rpy_deg: tuple[float, float, float] | None = None

    def rotation(self, where: str) -> Floats:
        """Return the unit quaternion, shape (4,)."""
        if self.quaternion_wxyz is not None and self.rpy_deg is not None:
            raise MapError(f"`{where}` has both `quaternion_wxyz` and `rpy_deg`; remove one")
        if self.rpy_deg is not None:
            return from_rpy(np.radians(self.rpy_deg))
        q = np.array(self.quaternion_wxyz or (1.0, 0.0, 0.0, 0.0))
        if abs(np.linalg.norm(q) - 1.0) > 1e-3:
            raise MapError(f"`{where}.quaternion_wxyz` has the length {np.linalg.norm(q):.4g}; it must be 1")
        return np.asarray(q / np.linalg.norm(q), dtype=np.float64)


@dataclass(frozen=True)
class World:
    """The world frame of the tracker.

    Attributes
    ----------
    plane : 2 axes
        Axes of the tracker that become x and y of the recording on the floor; up is their cross product.
        For a y-up tracker, use `["z", "x"]`.
    """

    plane: tuple[Axis, Axis] = ("x", "y")

    def rotation(self) -> Floats:
        """Return the unit quaternion recording-from-tracker, shape (4,)."""
        x, y = (_axis(name) for name in self.plane)
        if abs(x @ y) > 0.5:
            raise MapError(
                f"`world.plane` = {list(self.plane)} names one axis twice; give two different axes"
            )
        return from_axes(x, y)


@dataclass(frozen=True)
class Poses:
    """Poses of a tracked frame.

    Attributes
    ----------
    t : (n,) array
        s.
    position : (n, 3) array
        m.
    quaternion : (n, 4) array
        Unit, w first, world-from-frame.
    """

    t: Floats
    position: Floats
    quaternion: Floats

    @classmethod
    def checked(cls, source: Path | str, role: str, t: Floats, position: Floats, quaternion: Floats) -> Poses:
        """Return poses with normalised quaternions; raise `SourceError` if one is not of unit length."""
        norm = np.linalg.norm(quaternion, axis=1)
        wrong = np.flatnonzero(np.abs(norm - 1.0) > 1e-3)
        if len(wrong):
            at, length = t[wrong[0]], norm[wrong[0]]
            message = f"the quaternion of {role} at {at:.6f} s has the length {length:.4g}; it must be 1"
            raise SourceError(source, f"{message} (are its columns in the order w, x, y, z?)")
        return cls(t, position, quaternion / norm[:, None])

    def turned(self, rotation: Floats) -> Poses:
        """Return the poses in a world frame that is rotated by `rotation` (4,)."""
        return Poses(self.t, rotate(rotation, self.position), product(rotation, self.quaternion))

    def carried(self, translation: Sequence[float], rotation: Floats) -> Poses:
        """Return the poses of a frame that is fixed to the tracked frame at `translation` and `rotation`."""
        position = self.position + rotate(self.quaternion, np.asarray(translation, dtype=np.float64))
        return Poses(self.t, position, product(self.quaternion, rotation))


def object_stream(poses: Poses) -> Stream:
    """Return the planar stream of the object, whose frame must be upright within `MAX_LEAN_RAD`."""
    lean = float(np.median(tilt(poses.quaternion)))
    if lean > MAX_LEAN_RAD:
        raise MapError(
            f"the z axis of the object frame is tilted by {np.degrees(lean):.0f} degrees from up; set "
            "`world.plane` if the tracker is not z-up, and `object.offset` so that the object's z points up"
        )
    values = np.column_stack([poses.position[:, :2], heading(poses.quaternion)])
    return Stream(["object_x", "object_y", "object_theta"], poses.t, values)


def gripper_stream(poses: Poses, level_within: float) -> tuple[Stream, bool]:
    """Return the stream of the sensor frame, and whether the frame was flipped.

    Parameters
    ----------
    poses : Poses
        Poses of the sensor frame.
    level_within : float
        Maximum tilt of a level frame, rad. A level frame is stored as `gripper_theta`, others as seven
        columns.

    Returns
    -------
    stream : Stream
        Three planar or seven columns.
    turned : bool
        True if the sensor hangs level and upside down. Its frame was then rotated by 180° about its x axis,
        and the wrench must be rotated likewise (y and z change sign).
    """
    hanging = np.pi - tilt(poses.quaternion)
    turned = bool(len(hanging)) and bool(np.max(hanging) <= level_within)
    if turned:
        poses = poses.carried((0.0, 0.0, 0.0), np.array([0.0, 1.0, 0.0, 0.0]))
    if np.max(tilt(poses.quaternion), initial=0.0) <= level_within:
        names = ["gripper_x", "gripper_y", "gripper_theta"]
        return Stream(
            names, poses.t, np.column_stack([poses.position[:, :2], heading(poses.quaternion)])
        ), turned
    names = [f"gripper_{part}" for part in ("x", "y", "z", "qw", "qx", "qy", "qz")]
    return Stream(names, poses.t, np.column_stack([poses.position, poses.quaternion])), turned


def _axis(name: str) -> Floats:
    sign = -1.0 if name.startswith("-") else 1.0
    return np.asarray(sign * np.eye(3)["xyz".index(name[-1])], dtype=np.float64)
