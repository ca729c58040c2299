"""Named fields of the observations of pushing environments."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from trundle._native import TrundleError
from trundle.display import Card, Displayed

__all__ = ["COMMON_ENTRIES", "Observation", "PlanarPose"]

Array: TypeAlias = NDArray[np.float64]
Scalar: TypeAlias = Any
"""A number for one observation, an array of shape (...) for a batch."""

# The order of `Episode::observe` in env/sim/src/task/episode/observation.rs.
POSE = slice(0, 4)
POSITION = slice(0, 2)
DIRECTION = slice(2, 4)
TWIST = slice(4, 7)
VELOCITY = slice(4, 6)
SPIN = 6
GOAL = slice(7, 11)
GOAL_POSITION = slice(7, 9)
GOAL_DIRECTION = slice(9, 11)
WRENCH = slice(11, 14)
FORCE = slice(11, 13)
TORQUE = 13
GRASP = slice(14, 16)
COMMON_ENTRIES = 16
"""Number of entries that the observations of all tasks share."""
HALF_SIZE = slice(16, 18)
MIDDLE = slice(18, 20)
OUTLINE = slice(20, 44)

# The fields of a task are at the end: an observation of varied objects has two entries more before them.
PATH_POINTS = slice(-4, None)
BOX_POSITION, BOX_DIRECTION, BOX_HALF_SIZE = slice(-6, -4), slice(-4, -2), slice(-2, None)
DOOR_POSITION, DOOR_DIRECTION, DOOR_WIDTH = slice(-5, -3), slice(-3, -1), -1


@dataclass(frozen=True, eq=False, slots=True, repr=False)
class PlanarPose(Displayed):
    """Named fields of planar poses that are given as position, cosine and sine.

    Attributes
    ----------
    vector : ndarray, shape (..., 4)
        x and y (m), cosine and sine of the heading. Fields are views of it, except `heading`.
    """

    vector: Array

    def _card(self) -> Card:
        return Card(f"trundle.envs.PlanarPose of shape {self.vector.shape[:-1]}")

    @property
    def position(self) -> Array:
        """Position, m; shape (..., 2)."""
        return self.vector[..., POSITION]

    @property
    def direction(self) -> Array:
        """Cosine and sine of the heading; shape (..., 2)."""
        return self.vector[..., DIRECTION]

    @property
    def heading(self) -> Scalar:
        """Heading, rad in [-pi, pi]; shape (...)."""
        return _angle(self.direction)


@dataclass(frozen=True, eq=False, slots=True, repr=False)
class Observation(Displayed):
    """Named fields of flat observations, of one environment or of a batch.

    The table in `trundle.envs.Push` lists entries, bounds and noise. Positions, velocities and directions are
    in world axes unless stated otherwise. A direction is the cosine and sine of an angle.

    A field with several entries is a view: assigning to ``field[:]`` changes `vector`. `heading`, `pose`,
    `goal_heading` and `goal_pose` are computed. Fields of one entry are numbers for one observation.

    Attributes
    ----------
    vector : ndarray, shape (..., entries)
        Observations of an environment or of a batch. Entries that a wrapper appends, such as
        `trundle.envs.Oracle`, must be removed before the fields of a task are read.

    Raises
    ------
    TrundleError
        If the last axis is shorter than the entries that all tasks share.

    Examples
    --------
    >>> import gymnasium, numpy, trundle
    >>> env = gymnasium.make("trundle/PushPose-v0")
    >>> seen = trundle.envs.Observation(env.reset(seed=0)[0])
    >>> bool(numpy.hypot(*(seen.goal_position - seen.position)) < 1.01)
    True
    """

    vector: Array

    def __post_init__(self) -> None:
        if self.vector.shape[-1:] < (COMMON_ENTRIES,):
            raise TrundleError(
                f"observation of shape {self.vector.shape}: the last axis must have at least "
                f"{COMMON_ENTRIES} entries"
            )

    def _card(self) -> Card:
        title = f"trundle.envs.Observation of shape {self.vector.shape}"
        if self.vector.ndim > 1:
            return Card(title)
        names = ("position", "heading", "goal_position", "goal_heading")
        return Card(title, [(name, str(np.round(getattr(self, name), 3))) for name in names])

    @property
    def position(self) -> Array:
        """Measured position of the object's frame, m; shape (..., 2)."""
        return self.vector[..., POSITION]

    @property
    def direction(self) -> Array:
        """Direction of the object's x axis; shape (..., 2)."""
        return self.vector[..., DIRECTION]

    @property
    def heading(self) -> Scalar:
        """Measured heading of the object, rad in [-pi, pi]; shape (...)."""
        return _angle(self.direction)

    @property
    def pose(self) -> Array:
        """Measured pose of the object: x, y (m), heading (rad); shape (..., 3)."""
        return _pose(self.position, self.heading)

    @property
    def pose_vector(self) -> Array:
        """Measured pose of the object as a `PlanarPose` vector; shape (..., 4)."""
        return self.vector[..., POSE]

    @property
    def velocity(self) -> Array:
        """Measured velocity of the object's origin, m/s; shape (..., 2)."""
        return self.vector[..., VELOCITY]

    @property
    def spin(self) -> Scalar:
        """Measured angular velocity of the object, rad/s; shape (...)."""
        return self.vector[..., SPIN][()]

    @property
    def twist(self) -> Array:
        """Velocity (m/s) and spin (rad/s) of the object; shape (..., 3)."""
        return self.vector[..., TWIST]

    @property
    def goal_position(self) -> Array:
        """Position of the goal, m; shape (..., 2)."""
        return self.vector[..., GOAL_POSITION]

    @property
    def goal_direction(self) -> Array:
        """Direction of the goal's x axis; shape (..., 2)."""
        return self.vector[..., GOAL_DIRECTION]

    @property
    def goal_heading(self) -> Scalar:
        """Heading of the goal, rad in [-pi, pi]; shape (...)."""
        return _angle(self.goal_direction)

    @property
    def goal_pose(self) -> Array:
        """Pose of the goal: x, y (m), heading (rad); shape (..., 3)."""
        return _pose(self.goal_position, self.goal_heading)

    @property
    def goal_vector(self) -> Array:
        """Pose of the goal as a `PlanarPose` vector; shape (..., 4)."""
        return self.vector[..., GOAL]

    @property
    def force(self) -> Array:
        """Tared force on the object, gripper axes, N; shape (..., 2)."""
        return self.vector[..., FORCE]

    @property
    def torque(self) -> Scalar:
        """Tared torque on the object about the gripper, N m; shape (...)."""
        return self.vector[..., TORQUE][()]

    @property
    def wrench(self) -> Array:
        """Force (N) and torque (N m); shape (..., 3)."""
        return self.vector[..., WRENCH]

    @property
    def grasp(self) -> Array:
        """Position of the gripper or the contact, object frame, m; shape (..., 2)."""
        return self.vector[..., GRASP]

    @property
    def half_size(self) -> Array:
        """Half the object's length and width, m; shape (..., 2). In v0 only if the object varies."""
        return self.vector[..., HALF_SIZE]

    @property
    def middle(self) -> Array:
        """Middle of the object's bounding box, object frame, m; shape (..., 2). Exists from v1 on."""
        return self.vector[..., MIDDLE]

    @property
    def outline_radii(self) -> Array:
        """Distances from `middle` to the outline every 15 degrees, m; shape (..., 24).

        Exists from v1 on with ``outline=True``.
        """
        return self.vector[..., OUTLINE]

    @property
    def path_points(self) -> Array:
        """Points 0.6 and 0.9 m ahead on the path, m; shape (..., 2, 2). Exists in `PushPath`."""
        entries = self.vector[..., PATH_POINTS]
        return entries.reshape(*entries.shape[:-1], 2, 2)

    @property
    def box_position(self) -> Array:
        """Centre of the obstacle, m; shape (..., 2). Exists in `PushAround`."""
        return self.vector[..., BOX_POSITION]

    @property
    def box_direction(self) -> Array:
        """Direction of the obstacle's x axis; shape (..., 2). Exists in `PushAround`."""
        return self.vector[..., BOX_DIRECTION]

    @property
    def box_half_size(self) -> Array:
        """Half the obstacle's sides, obstacle axes, m; shape (..., 2). Exists in `PushAround`."""
        return self.vector[..., BOX_HALF_SIZE]

    @property
    def door_position(self) -> Array:
        """Centre of the opening, m; shape (..., 2). Exists in `PushDoor`."""
        return self.vector[..., DOOR_POSITION]

    @property
    def door_direction(self) -> Array:
        """Direction through the opening; shape (..., 2). Exists in `PushDoor`."""
        return self.vector[..., DOOR_DIRECTION]

    @property
    def door_width(self) -> Scalar:
        """Width of the opening, m; shape (...). Exists in `PushDoor`."""
        return self.vector[..., DOOR_WIDTH][()]

    def without_goal(self) -> Array:
        """Return a copy of the vector without the four entries of the goal; shape (..., entries - 4)."""
        return np.concatenate([self.vector[..., : GOAL.start], self.vector[..., GOAL.stop :]], axis=-1)


def _angle(direction: Array) -> Scalar:
    return np.arctan2(direction[..., 1], direction[..., 0])


def _pose(position: Array, heading: Scalar) -> Array:
    return np.concatenate([position, np.asarray(heading)[..., None]], axis=-1)
