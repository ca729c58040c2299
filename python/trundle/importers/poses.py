"""Poses as trackers give them, brought to the object's and the sensor's frame and into the floor's plane."""

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
"""An object frame that leans more than this has its axes mixed up."""


@dataclass(frozen=True)
class Offset:
    """Where the wanted frame is, seen from the tracked one; constant.

    Attributes
    ----------
    translation : 3 floats
        m, tracked frame's axes.
    quaternion_wxyz : 4 floats
        Rotation tracked-from-wanted.
    rpy_deg : 3 floats
        The same as roll, pitch, yaw in degrees (turned about fixed x, then y, then z); not both.
    """

    translation: tuple[float, float, float] = (0.0, 0.0, 0.0)
    quaternion_wxyz: tuple[float, float, float, float] | None = None
    rpy_deg: tuple[float, float, float] | None = None

    def rotation(self, where: str) -> Floats:
        """Return the unit quaternion, shape (4,)."""
        if self.quaternion_wxyz is not None and self.rpy_deg is not None:
            raise MapError(f"`{where}` has both `quaternion_wxyz` and `rpy_deg`; keep one")
        if self.rpy_deg is not None:
            return from_rpy(np.radians(self.rpy_deg))
        q = np.array(self.quaternion_wxyz or (1.0, 0.0, 0.0, 0.0))
        if abs(np.linalg.norm(q) - 1.0) > 1e-3:
            raise MapError(
                f"`{where}.quaternion_wxyz` has the length {np.linalg.norm(q):.4g}; a rotation has 1"
            )
        return np.asarray(q / np.linalg.norm(q), dtype=np.float64)


@dataclass(frozen=True)
class World:
    """The tracker's world.

    Attributes
    ----------
    plane : 2 axes
        Which of the tracker's axes become the recording's x and y on the floor; up is then their cross
        product. A y-up tracker has `["z", "x"]`.
    """

    plane: tuple[Axis, Axis] = ("x", "y")

    def rotation(self) -> Floats:
        """Return the unit quaternion recording-from-tracker, shape (4,)."""
        x, y = (_axis(name) for name in self.plane)
        if abs(x @ y) > 0.5:
            raise MapError(f"`world.plane` = {list(self.plane)} names one axis twice; a plane has two")
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
        """Return poses whose quaternions are unit length, or say which is not."""
        norm = np.linalg.norm(quaternion, axis=1)
        wrong = np.flatnonzero(np.abs(norm - 1.0) > 1e-3)
        if len(wrong):
            at, length = t[wrong[0]], norm[wrong[0]]
            trouble = f"the quaternion of {role} at {at:.6f} s has the length {length:.4g}; it must be 1"
            raise SourceError(source, f"{trouble} (are its columns in the order w, x, y, z?)")
        return cls(t, position, quaternion / norm[:, None])

    def turned(self, rotation: Floats) -> Poses:
        """Return the same poses seen in a world turned by `rotation` (4,)."""
        return Poses(self.t, rotate(rotation, self.position), product(rotation, self.quaternion))

    def carried(self, translation: Sequence[float], rotation: Floats) -> Poses:
        """Return the poses of a frame fixed to the tracked one at `translation`, turned by `rotation`."""
        position = self.position + rotate(self.quaternion, np.asarray(translation, dtype=np.float64))
        return Poses(self.t, position, product(self.quaternion, rotation))


def object_stream(poses: Poses) -> Stream:
    """Return the object's planar stream; its frame must stand about upright."""
    lean = float(np.median(tilt(poses.quaternion)))
    if lean > MAX_LEAN_RAD:
        raise MapError(
            f"the object frame's z leans {np.degrees(lean):.0f} degrees from up; set `world.plane` if the "
            "tracker's world is not z-up, and `object.offset` so that the object's own z points up"
        )
    values = np.column_stack([poses.position[:, :2], heading(poses.quaternion)])
    return Stream(["object_x", "object_y", "object_theta"], poses.t, values)


def gripper_stream(poses: Poses, level_within: float) -> tuple[Stream, bool]:
    """Return the sensor's stream and whether its frame was turned over.

    Parameters
    ----------
    poses : Poses
        Of the sensor frame.
    level_within : float
        rad; a frame that never leans more is level and becomes `gripper_theta`, else seven columns.

    Returns
    -------
    stream : Stream
        Planar or seven columns.
    turned : bool
        The sensor hangs level and upside down: its frame was turned by half a turn about its x, and
        so must be the wrench (y and z change sign).
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
