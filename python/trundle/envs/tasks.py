"""Tasks of the pushing environments."""

from __future__ import annotations

from typing import Any, ClassVar

from trundle.envs.observation import Observation
from trundle.envs.push import Array, Push

__all__ = ["LockedWheel", "PushAround", "PushDoor", "PushPath", "PushPose"]


class PushPose(Push):
    """Push an object to a pose.

    Actions, starting state, episode end and arguments are those of `trundle.envs.Push`.

    ## Description
    The wheels of the object may be locked, fixed or casters. It starts within 0.5 m of the origin along x and
    y, at any heading. The goal is a pose 0.4 to 1 m away, turned by up to 0.8 rad.

    ## Rewards
    Each step: minus its duration times (distance to the goal in m + 0.3 x heading error in rad + 0.05 +
    0.02 x effort), so that a return is minus the time integral of the cost. Effort is the mean of the squared
    force / 100 N plus the squared torque / 40 N m at the grasp. `time_cost` and `effort_cost` change the two
    weights, which are 0 in v0.

    ## Version History
    - v1: observations hold the middle of the bounding box; costs of time, effort and seconds of contact;
      actions are clipped; `max_episode_steps` and levels
    - v0: initial version. Policies trained in v0, such as `configs/rl/ppo.toml`'s, remain valid in v0 only

    ## Example
    ```pycon
    >>> import gymnasium, trundle
    >>> env = gymnasium.make("trundle/PushPose-v0")
    >>> observation, info = env.reset(seed=0)
    >>> observation.shape
    (16,)

    ```
    """

    FIXED: ClassVar[dict[str, Any]] = {"task": "pose"}


class LockedWheel(PushPose):
    """Push an office table with one unknown locked wheel to a pose.

    ## Description
    As `PushPose`, with the object of the paper: a table of 1.2 m by 0.8 m and 22 kg on four wheels. Three
    wheels roll freely. One is locked and resists with 60 to 300 N s/m, depending on the direction. The
    locked wheel, its resistance and its axis are drawn for each episode. A gripper holds the middle of the
    rear edge.

    ## Version History
    - v1: observations hold the middle of the bounding box; costs of time, effort and seconds of contact;
      actions are clipped; `max_episode_steps` and levels
    - v0: initial version. Policies trained in v0, such as `configs/rl/ppo.toml`'s, remain valid in v0 only

    ## Example
    ```pycon
    >>> import gymnasium, trundle
    >>> env = gymnasium.make("trundle/LockedWheel-v0")
    >>> observation, info = env.reset(seed=0)
    >>> observation.shape
    (16,)

    ```
    """

    FIXED: ClassVar[dict[str, Any]] = {"task": "pose", "hidden": "locked"}


class PushPath(Push):
    """Push an object along a path.

    ## Description
    A path of 2 m with random bends starts at the object, whose heading must follow the path. The goal in the
    observation is the point on the path 0.3 m ahead of the current progress. The goal that ends an episode
    is the end of the path.

    ## Observation Space
    The numbers of the task are two more points of the path, 0.6 and 0.9 m ahead (x, y; m): 24 numbers in all
    (in v0 20, or 22 if the object varies).

    ## Rewards
    Each step: progress along the path (m), minus its duration times (distance from the path in m + 0.3 x
    heading error in rad + 0.05 + 0.02 x effort); see `PushPose` for the effort.
    `info["distance"]` is the distance from the path.

    ## Version History
    - v1: observations hold the middle of the bounding box; costs of time, effort and seconds of contact;
      actions are clipped; `max_episode_steps` and levels
    - v0: initial version. Policies trained in v0, such as `configs/rl/ppo.toml`'s, remain valid in v0 only

    ## Example
    ```pycon
    >>> import gymnasium, trundle
    >>> env = gymnasium.make("trundle/PushPath-v0")
    >>> observation, info = env.reset(seed=0)
    >>> observation.shape
    (20,)

    ```
    """

    FIXED: ClassVar[dict[str, Any]] = {"task": "path"}


class PushAround(Push):
    """Push an object to a pose behind an obstacle.

    ## Description
    The task of the paper: a box of 0.2 to 0.4 m by 0.3 to 0.8 m is between the object and its goal.

    ## Observation Space
    The numbers of the task describe the box: its centre (x, y; m), cosine and sine of its heading, and half
    its sides (m): 26 numbers in all (in v0 22, or 24 if the object varies).

    ## Rewards
    Each step: minus its duration times (straight distance to the goal in m + 0.3 x heading error in rad +
    0.05 + 0.02 x effort), minus 10 per second of contact with the box; see `PushPose` for the effort.
    `time_cost`, `effort_cost` and `touch_cost` change the weights. In v0 they are 0, 0 and 1,
    and a step with any contact counts as contact during the whole step.

    ## Version History
    - v1: observations hold the middle of the bounding box; costs of time, effort and seconds of contact;
      actions are clipped; `max_episode_steps` and levels
    - v0: initial version. Policies trained in v0, such as `configs/rl/ppo.toml`'s, remain valid in v0 only

    ## Example
    ```pycon
    >>> import gymnasium, trundle
    >>> env = gymnasium.make("trundle/PushAround-v0")
    >>> observation, info = env.reset(seed=0)
    >>> observation.shape
    (22,)

    ```
    """

    FIXED: ClassVar[dict[str, Any]] = {"task": "around"}

    @staticmethod
    def seen_obstacles(observation: Array) -> list[list[tuple[float, float]]]:
        """Return the box."""
        fields = Observation(observation)
        a, b = fields.box_half_size
        return [_rectangle(fields.box_position, fields.box_direction, (-a, a), (-b, b))]


class PushDoor(Push):
    """Push an object through a doorway.

    ## Description
    A wall of 10 cm divides the arena. Its opening is 0.2 to 0.5 m wider than the narrow side of the object.
    The object starts on one side; the goal is a pose on the other.

    ## Observation Space
    The numbers of the task describe the opening: its centre (x, y; m), cosine and sine of the direction
    through it, and its width (m): 25 numbers in all (in v0 21, or 23 if the object varies).

    ## Rewards
    Each step: minus its duration times (straight distance to the goal in m + 0.3 x heading error in rad +
    0.05 + 0.02 x effort), minus 10 per second of contact with the wall; see `PushPose` for the effort.
    `time_cost`, `effort_cost` and `touch_cost` change the weights. In v0 they are 0, 0 and 1,
    and a step with any contact counts as contact during the whole step.

    ## Version History
    - v1: observations hold the middle of the bounding box; costs of time, effort and seconds of contact;
      actions are clipped; `max_episode_steps` and levels
    - v0: initial version. Policies trained in v0, such as `configs/rl/ppo.toml`'s, remain valid in v0 only

    ## Example
    ```pycon
    >>> import gymnasium, trundle
    >>> env = gymnasium.make("trundle/PushDoor-v0")
    >>> observation, info = env.reset(seed=0)
    >>> observation.shape
    (21,)

    ```
    """

    FIXED: ClassVar[dict[str, Any]] = {"task": "door"}

    @staticmethod
    def seen_obstacles(observation: Array) -> list[list[tuple[float, float]]]:
        """Return the wall on both sides of the opening."""
        fields = Observation(observation)
        half = fields.door_width / 2
        sides = ((half, WALL_HALF_LENGTH_M), (-WALL_HALF_LENGTH_M, -half))
        return [
            _rectangle(fields.door_position, fields.door_direction, (-0.05, 0.05), side) for side in sides
        ]


WALL_HALF_LENGTH_M = 5.0
"""Distance from the middle of the opening to the end of the wall, outside the arena, m."""

Pair = tuple[float, float]


def _rectangle(middle: Array, way: Array, along: Pair, across: Pair) -> list[Pair]:
    """Return a rectangle in a frame at `middle` whose x axis is `way`."""
    (x, y), (cos, sin) = middle, way
    corners = [(along[0], across[0]), (along[1], across[0]), (along[1], across[1]), (along[0], across[1])]
    return [(float(x + cos * a - sin * b), float(y + sin * a + cos * b)) for a, b in corners]
