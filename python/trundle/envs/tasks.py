"""The tasks."""

from __future__ import annotations

from typing import Any, ClassVar

from trundle.envs.push import Observation, Push

__all__ = ["LockedWheel", "PushAround", "PushDoor", "PushPath", "PushPose"]


class PushPose(Push):
    """Push an object to a pose.

    ## Description
    An object whose wheels may be locked, fixed or swivel stands within 0.5 m of the origin along x and y,
    at any heading. It is to be pushed to a pose 0.4 to 1 m away, turned by up to 0.8 rad.

    ## Rewards
    Each step: minus its time times (distance to the goal in m + 0.3 x heading error in rad), so that a
    return is minus the time integral of the error.

    Actions, observations (16, or 18 of several objects), ends and arguments: see `trundle.envs.Push`.

    ## Version History
    - v0: initial version
    """

    FIXED: ClassVar[dict[str, Any]] = {"task": "pose"}


class LockedWheel(PushPose):
    """Push an office table to a pose, without knowing which of its wheels is locked.

    ## Description
    As `PushPose`, the paper's object: a table of 1.2 m by 0.8 m and 22 kg stands on four wheels. Three roll
    freely; one is locked and resists with 60 to 300 N s/m, not alike in all directions. Which one, how
    firmly and along which axis is drawn with the episode. A gripper holds the middle of its rear edge.

    ## Version History
    - v0: initial version
    """

    FIXED: ClassVar[dict[str, Any]] = {"task": "pose", "hidden": "locked"}


class PushPath(Push):
    """Push an object along a path.

    ## Description
    A path of 2 m that bends at random begins at the object, which is to turn as the path does. The goal of
    an observation lies on the path 0.3 m ahead of the place that has been reached; two more points, 0.6 and
    0.9 m ahead, follow as four numbers (x, y; m).

    ## Rewards
    Each step: the length of path gained (m), minus its time times (distance from the path in m + 0.3 x
    heading error in rad). `info["distance"]` is the distance from the path.

    Actions, observations (20, or 22), ends (the goal is the path's end) and arguments: see
    `trundle.envs.Push`.

    ## Version History
    - v0: initial version
    """

    FIXED: ClassVar[dict[str, Any]] = {"task": "path"}


class PushAround(Push):
    """Push an object to a pose behind an obstacle.

    ## Description
    The paper's task: a box of 0.2 to 0.4 m by 0.3 to 0.8 m stands between the object and its goal. Six
    numbers follow in the observation: the box's middle (x, y; m), cosine and sine of its heading, and half
    its sides (m).

    ## Rewards
    Each step: minus its time times (distance to the goal in m, as the crow flies, + 0.3 x heading error in
    rad, + 1 if the object touched the box).

    Actions, observations (22, or 24), ends and arguments: see `trundle.envs.Push`.

    ## Version History
    - v0: initial version
    """

    FIXED: ClassVar[dict[str, Any]] = {"task": "around"}

    @staticmethod
    def seen_obstacles(observation: Observation) -> list[list[tuple[float, float]]]:
        """Return the box."""
        x, y, cos, sin, a, b = observation[-6:]
        return [_rectangle((x, y), (cos, sin), (-a, a), (-b, b))]


class PushDoor(Push):
    """Push an object through a doorway.

    ## Description
    A wall of 10 cm parts the arena. Its opening is 0.2 to 0.5 m wider than the narrow side of the object,
    which stands on one side and is to reach a pose on the other. Five numbers follow in the observation:
    the opening's middle (x, y; m), cosine and sine of the direction through it, and its width (m).

    ## Rewards
    As those of `PushAround`.

    Actions, observations (21, or 23), ends and arguments: see `trundle.envs.Push`.

    ## Version History
    - v0: initial version
    """

    FIXED: ClassVar[dict[str, Any]] = {"task": "door"}

    @staticmethod
    def seen_obstacles(observation: Observation) -> list[list[tuple[float, float]]]:
        """Return the wall on both sides of the opening."""
        x, y, cos, sin, width = observation[-5:]
        sides = ((width / 2, WALL_HALF_LENGTH_M), (-WALL_HALF_LENGTH_M, -width / 2))
        return [_rectangle((x, y), (cos, sin), (-0.05, 0.05), side) for side in sides]


WALL_HALF_LENGTH_M = 5.0
"""From the middle of the opening to beyond the arena, m."""

Pair = tuple[float, float]


def _rectangle(middle: Pair, way: Pair, along: Pair, across: Pair) -> list[Pair]:
    """Return a rectangle in a frame whose x is `way`."""
    (x, y), (cos, sin) = middle, way
    corners = [(along[0], across[0]), (along[1], across[0]), (along[1], across[1]), (along[0], across[1])]
    return [(float(x + cos * a - sin * b), float(y + sin * a + cos * b)) for a, b in corners]
