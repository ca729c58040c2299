"""Goal-conditioned versions of the tasks, in the convention of Gymnasium-Robotics, for hindsight replay."""

from __future__ import annotations

from typing import Any, ClassVar

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from trundle._native import TrundleError
from trundle.envs.observation import Observation, PlanarPose
from trundle.envs.push import FACING, REACH, Action, Push
from trundle.envs.tasks import PushAround, PushDoor, PushPath, PushPose

__all__ = ["GoalSpace", "PushAroundGoal", "PushDoorGoal", "PushGoal", "PushPathGoal", "PushPoseGoal"]

Array = NDArray[np.float64]
GoalObservation = dict[str, Array]


class GoalSpace:
    """Split of observations into observation, achieved goal and desired goal, and the reward of goals.

    Parameters
    ----------
    reward_type : {"sparse", "dense"}
        -1 until the goal is reached, then 0; or minus (distance in m + 0.3 x heading error in rad).
    reach, facing : float
        Distance (m) and heading error (rad) within which the goal is reached.

    Raises
    ------
    TrundleError
        If `reward_type` is another one.
    """

    def __init__(self, reward_type: str, reach: float, facing: float) -> None:
        if reward_type not in ("sparse", "dense"):
            raise TrundleError(f"reward_type = {reward_type!r}: choose 'sparse' or 'dense'")
        self.reward_type, self.reach, self.facing = reward_type, reach, facing

    def space(self, flat: gym.spaces.Box) -> gym.spaces.Dict:
        """Return the space of split observations."""
        parts = self.split(np.asarray(flat.high))
        return gym.spaces.Dict(
            {key: gym.spaces.Box(-high, high, dtype=flat.dtype.type) for key, high in parts.items()}
        )

    def split(self, flat: Array) -> GoalObservation:
        """Return observations of shape (..., n) as dictionaries; the goals have shape (..., 4)."""
        fields = Observation(flat)
        return {
            "observation": fields.without_goal(),
            "achieved_goal": fields.pose_vector.copy(),
            "desired_goal": fields.goal_vector.copy(),
        }

    def reward(self, achieved: Array, desired: Array) -> Array:
        """Return the rewards of goals of shape (..., 4)."""
        pose, goal = PlanarPose(achieved), PlanarPose(desired)
        distance = np.hypot(*np.moveaxis(goal.position - pose.position, -1, 0))
        here, there = pose.direction, goal.direction
        cos = np.sum(here * there, axis=-1)
        sin = here[..., 0] * there[..., 1] - here[..., 1] * there[..., 0]
        turn = np.abs(np.arctan2(sin, cos))
        if self.reward_type == "sparse":
            return np.where((distance >= self.reach) | (turn >= self.facing), -1.0, 0.0)
        return np.asarray(-(distance + 0.3 * turn))

    def compute_reward(self, achieved: Any, desired: Any) -> Any:
        """Return the reward: a number for goals of shape (4,), an array (n,) for (n, 4)."""
        reward = self.reward(np.asarray(achieved), np.asarray(desired))
        return float(reward) if reward.ndim == 0 else reward


class PushGoal(Push):
    """Base class of goal-conditioned environments; instantiate a subclass.

    ## Description
    The goal is part of the observation as in Gymnasium-Robotics, so that a replay buffer can change it
    (hindsight replay). `compute_reward(achieved, desired, info)` returns the reward of one or several pairs,
    equal to that of `step`.

    ## Observation Space
    A dictionary: "observation" (the numbers above without the goal), "achieved_goal" and "desired_goal" (x,
    y, cosine and sine of the heading, as the tracker measures them).

    ## Rewards
    With `reward_type` "sparse": -1 until the goal is reached, then 0. With "dense": minus (distance in m +
    0.3 x heading error in rad). The reward depends on the measured pose; `info["is_success"]` depends on the
    true pose and requires a speed below 0.1 m/s.

    ## Episode End
    - Termination: never; reaching the goal does not end an episode.
    - Truncation: after `horizon` steps, or if the object leaves the workspace, because a reward of goals
      alone cannot penalise that.

    ## Arguments
    - `reward_type` ("sparse"): "sparse" or "dense"

    ## Version History
    - v1: observations hold the middle of the bounding box; costs of time, effort and seconds of contact;
      actions are clipped; `max_episode_steps` and levels
    - v0: initial version. Policies trained in v0, such as `configs/rl/ppo.toml`'s, remain valid in v0 only

    ## Example
    ```pycon
    >>> import gymnasium, trundle
    >>> env = gymnasium.make("trundle/PushPoseGoal-v0", reward_type="dense")
    >>> observation, info = env.reset(seed=0)
    >>> {key: part.shape for key, part in observation.items()}
    {'observation': (12,), 'achieved_goal': (4,), 'desired_goal': (4,)}

    ```
    """

    def __init__(self, *, reward_type: str = "sparse", **options: Any) -> None:
        super().__init__(**options)
        self._goals = GoalSpace(reward_type, options.get("reach", REACH), options.get("facing", FACING))
        self.observation_space = self._goals.space(self.observation_space)  # type: ignore[assignment, arg-type]

    def reset(  # type: ignore[override]
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[GoalObservation, dict[str, Any]]:
        """Begin an episode; see `Push` for the options."""
        flat, info = super().reset(seed=seed, options=options)
        return self._goals.split(flat), info

    def step(  # type: ignore[override]
        self, action: Action
    ) -> tuple[GoalObservation, float, bool, bool, dict[str, Any]]:
        """Apply an action until the next one is due."""
        flat, _, terminated, truncated, info = super().step(action)
        seen = self._goals.split(flat)
        reward = self._goals.reward(seen["achieved_goal"], seen["desired_goal"])
        return seen, float(reward), False, terminated or truncated, info

    def compute_reward(self, achieved_goal: Array, desired_goal: Array, info: Any) -> Any:
        """Return the reward of goals: a number for shape (4,), an array (n,) for (n, 4)."""
        return self._goals.compute_reward(achieved_goal, desired_goal)

    def compute_terminated(self, achieved_goal: Array, desired_goal: Array, info: dict[str, Any]) -> bool:
        """Return False: reaching a goal does not end an episode."""
        return False

    def compute_truncated(self, achieved_goal: Array, desired_goal: Array, info: dict[str, Any]) -> bool:
        """Return whether the object left the workspace; the time limit does not depend on goals."""
        return bool(info.get("lost", False))


class PushPoseGoal(PushGoal, PushPose):
    """`PushPose` with a goal that a replay buffer can change; see `PushGoal`.

    ## Example
    ```pycon
    >>> import gymnasium, trundle
    >>> env = gymnasium.make("trundle/PushPoseGoal-v0")
    >>> observation, info = env.reset(seed=0)
    >>> observation["observation"].shape
    (12,)

    ```
    """

    FIXED: ClassVar[dict[str, Any]] = {**PushPose.FIXED, "ends": False}


class PushPathGoal(PushGoal, PushPath):
    """`PushPath` with a goal that a replay buffer can change; see `PushGoal`.

    ## Description
    The goal is 0.3 m ahead on the path, so the sparse reward can be reached only at the end of the path.

    ## Example
    ```pycon
    >>> import gymnasium, trundle
    >>> env = gymnasium.make("trundle/PushPathGoal-v0")
    >>> observation, info = env.reset(seed=0)
    >>> observation["observation"].shape
    (16,)

    ```
    """

    FIXED: ClassVar[dict[str, Any]] = {**PushPath.FIXED, "ends": False}


class PushAroundGoal(PushGoal, PushAround):
    """`PushAround` with a goal that a replay buffer can change; see `PushGoal`.

    ## Example
    ```pycon
    >>> import gymnasium, trundle
    >>> env = gymnasium.make("trundle/PushAroundGoal-v0")
    >>> observation, info = env.reset(seed=0)
    >>> observation["observation"].shape
    (18,)

    ```
    """

    FIXED: ClassVar[dict[str, Any]] = {**PushAround.FIXED, "ends": False}


class PushDoorGoal(PushGoal, PushDoor):
    """`PushDoor` with a goal that a replay buffer can change; see `PushGoal`.

    ## Example
    ```pycon
    >>> import gymnasium, trundle
    >>> env = gymnasium.make("trundle/PushDoorGoal-v0")
    >>> observation, info = env.reset(seed=0)
    >>> observation["observation"].shape
    (17,)

    ```
    """

    FIXED: ClassVar[dict[str, Any]] = {**PushDoor.FIXED, "ends": False}
