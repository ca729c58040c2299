"""A table with a hidden locked wheel, to be pushed to a pose."""

from __future__ import annotations

from typing import Any, ClassVar

import gymnasium as gym
import numpy as np
from gymnasium.error import ResetNeeded
from numpy.typing import NDArray

from trundle._native import LockedWheel as NativeLockedWheel
from trundle._native import TrundleError
from trundle.envs import render

__all__ = ["LockedWheel"]

Observation = NDArray[np.float64]
Action = NDArray[np.float32]

OPTIONS = ("start", "goal", "grasp", "same_object")


class LockedWheel(gym.Env[Observation, Action]):
    """Push an office table to a pose, without knowing which of its wheels is locked.

    ## Description
    A table of 1.2 m by 0.8 m and 22 kg stands on four wheels. Three roll freely; one is locked and resists
    with 60 to 300 N s/m, not alike in all directions. Which one, how firmly and along which axis is drawn
    with the episode, and neither an observation nor `info` nor the picture tells. A gripper holds the table
    at the middle of its rear edge and pushes, pulls and turns it there.

    ## Action Space
    `Box(-1, 1, (3,), float32)`: the wrench at the grasp, in the axes of the gripper, which are those of
    the table. The arm reaches it within 20 ms and holds it until 50 ms after the action was given.

    | Num | Action               | Min | Max | A full action |
    |-----|----------------------|-----|-----|---------------|
    | 0   | force along table x  | -1  | 1   | 100 N         |
    | 1   | force along table y  | -1  | 1   | 100 N         |
    | 2   | torque               | -1  | 1   | 40 N m        |

    `LockedWheel.ACTION_SCALE` holds the last column. An action that is not in the space is an error; the
    wrapper `gymnasium.wrappers.ClipAction` cuts it.

    ## Observation Space
    `Box((16,), float64)`, world frame unless it says otherwise:

    | Num   | Observation                                         | Bound    | Unit  | Noise (sd) |
    |-------|-----------------------------------------------------|----------|-------|------------|
    | 0-1   | position of the table's middle                      | 3        | m     | 0.5 mm     |
    | 2-3   | cosine and sine of its heading                      | 1        | -     | 0.1 deg    |
    | 4-5   | velocity                                            | 4        | m/s   | 5 mm/s     |
    | 6     | spin                                                | 7        | rad/s | 0.01 rad/s |
    | 7-8   | goal position                                       | 3        | m     | -          |
    | 9-10  | cosine and sine of the goal heading                 | 1        | -     | -          |
    | 11-12 | wrist sensor: force on the table, table axes, tared | 120      | N     | 0.4 N      |
    | 13    | wrist sensor: torque about the grasp, tared         | 43       | N m   | 0.05 N m   |
    | 14-15 | grasp, table frame                                  | 0.6, 0.4 | m     | -          |

    ## Rewards
    Each step: -0.05 s x (distance to the goal in m + 0.3 x heading error in rad), so that a return is
    minus the time integral of the error. Losing the table costs 100.

    ## Starting State
    The table stands still within 0.5 m of the origin along x and y, at any heading. The goal is 0.4 to
    1 m away in any direction and turned by up to 0.8 rad.

    ## Episode End
    - Termination: the goal is reached (within 5 cm and 0.1 rad, slower than 0.1 m/s; `info["is_success"]`),
      or the table is lost (its middle more than 2.5 m from the origin along x or y, faster than 2 m/s or
      4 rad/s).
    - Truncation: after 300 steps, 15 s (by the `TimeLimit` of `gymnasium.make`).

    ## Information
    `info` holds `distance` (m), `heading_error` (rad, in (-pi, pi]) and `is_success`, all of the true pose,
    after each step; it is empty after a reset.

    ## Arguments
    ```python
    env = gymnasium.make("trundle/LockedWheel-v0", render_mode="rgb_array", noise=1.0)
    obs, info = env.reset(seed=0, options={"goal": (1.0, 0.0, 0.0), "same_object": True})
    ```

    | Argument | Default | Description                                                      |
    |----------|---------|------------------------------------------------------------------|
    | `noise`  | 1.0     | factor on all noise, 0 to 10; 0: sensor and tracker are perfect  |

    | Reset option  | Description                                                              |
    |---------------|--------------------------------------------------------------------------|
    | `start`       | pose (x, y, heading) of the table, |x|, |y| at most 2 m                  |
    | `goal`        | goal pose, the same bounds                                               |
    | `grasp`       | point (x, y) in the table frame, |x| at most 0.6 m, |y| at most 0.4 m    |
    | `same_object` | True: keep the hidden wheel of the episode before                        |

    The environment can be pickled and deep-copied at any time; a copy goes on exactly alike.

    ## Version History
    - v0: initial version
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 20}  # noqa: RUF012 (as Env declares it)
    ACTION_SCALE: ClassVar[NDArray[np.float64]] = np.array(NativeLockedWheel.FULL)
    """Wrench of a full action: N, N, N m."""

    def __init__(self, *, noise: float = 1.0, render_mode: str | None = None) -> None:
        if render_mode is not None and render_mode not in self.metadata["render_modes"]:
            raise TrundleError(f"render_mode = {render_mode!r}: choose 'rgb_array' or None")
        self.render_mode = render_mode
        self.action_space = gym.spaces.Box(-1.0, 1.0, (3,), np.float32)
        bounds = np.array(NativeLockedWheel.BOUNDS)
        self.observation_space = gym.spaces.Box(-bounds, bounds, dtype=np.float64)
        self._native = NativeLockedWheel(noise)
        self._trail: list[tuple[float, float]] = []

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode; see the class for the options."""
        super().reset(seed=seed)
        told = {} if options is None else options
        for key in told:
            if key not in OPTIONS:
                raise TrundleError(f"unknown reset option {key!r}; known are {', '.join(OPTIONS)}")
        observation = self._native.reset(
            int(self.np_random.integers(2**63)),
            start=_numbers("start", told.get("start"), 3),
            goal=_numbers("goal", told.get("goal"), 3),
            grasp=_numbers("grasp", told.get("grasp"), 2),
            same_object=bool(told.get("same_object", False)),
        )
        self._trail.clear()
        self._leave_trail()
        return observation, {}

    def step(self, action: Action) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Apply a wrench at the grasp for 50 ms."""
        wrench = self._checked(action) * self.ACTION_SCALE
        stepped = self._native.step(wrench)
        if stepped is None:
            raise ResetNeeded(
                "no episode is under way: call reset() before step(), and after an episode's end"
            )
        observation, reward, terminated, success, distance, heading_error = stepped
        self._leave_trail()
        info = {"is_success": success, "distance": distance, "heading_error": heading_error}
        return observation, reward, terminated, False, info

    def render(self) -> NDArray[np.uint8] | None:
        """Return a picture of 480 by 480 pixels, x to the right and y up, or None without `render_mode`."""
        if self.render_mode is None:
            gym.logger.warn("render() does nothing without render_mode='rgb_array' in gymnasium.make")
            return None
        view = self._native.view()
        if view is None:
            raise ResetNeeded("there is nothing to draw: call reset() before render()")
        body, goal, gripper, wrench = view
        return render.picture(render.View(body, goal, gripper, wrench, tuple(self._trail)))

    def start_recording(self) -> None:
        """Keep, from the next reset on, what sensor and tracker see; for `trundle.Record`."""
        self._native.record()

    def take_rows(self) -> dict[str, NDArray[np.float64]]:
        """Return what sensor and tracker saw since the last time, by column of a recording."""
        return self._native.take_rows()

    def recording_metadata(self, name: str) -> dict[str, Any]:
        """Return what a recording says of the object and the instruments."""
        return self._native.metadata(name)

    @property
    def object_count(self) -> int:
        """How many different objects there have been: a new number is a new hidden wheel."""
        return self._native.objects

    def _leave_trail(self) -> None:
        view = self._native.view() if self.render_mode is not None else None
        if view is not None:
            self._trail.append((view[0][0], view[0][1]))

    def _checked(self, action: Action) -> Action:
        array = np.asarray(action)
        if array.shape != (3,):
            raise TrundleError(
                f"an action has shape (3,), not {array.shape}: force x, force y and torque in [-1, 1]"
            )
        if not np.all(np.abs(array) <= 1.0):
            raise TrundleError(
                f"action {array}: each entry must lie in [-1, 1]; gymnasium.wrappers.ClipAction cuts it"
            )
        return array


def _numbers(key: str, value: Any, count: int) -> list[float] | None:
    if value is None:
        return None
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        array = np.empty(0)
    if array.shape != (count,):
        raise TrundleError(f"reset option {key!r} = {value!r}: give {count} numbers")
    return [float(entry) for entry in array]
