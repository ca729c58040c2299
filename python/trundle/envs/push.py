"""Environments in which an agent pushes an object with hidden effects."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from os import PathLike, fspath
from typing import Any, ClassVar

import gymnasium as gym
import numpy as np
import tomli_w
from gymnasium.error import InvalidAction, ResetNeeded
from numpy.typing import NDArray

from trundle._native import NotFiniteError, Pushing, Snapshot, TrundleError
from trundle.envs.view import draw, require_episode
from trundle.envs.window import Window

__all__ = ["ActionError", "Push"]

Array = NDArray[np.float64]
Action = NDArray[np.float32]

Names = str | PathLike[str] | Sequence[str | PathLike[str]]

RESET_OPTIONS = ("start", "goal", "grasp", "same_object")
RENDER_MODES = ("rgb_array", "human")
REACH, FACING = 0.05, 0.1
"""Default distance (m) and heading error (rad) within which a goal is reached."""


class ActionError(TrundleError, InvalidAction):
    """An action outside the action space; both an `InvalidAction` of Gymnasium and a `TrundleError`.

    Examples
    --------
    >>> import gymnasium, trundle
    >>> env = gymnasium.make("trundle/PushPose-v0", disable_env_checker=True)
    >>> observation, info = env.reset(seed=0)
    >>> env.step([2.0, 0.0, 0.0])
    Traceback (most recent call last):
        ...
    trundle.envs.push.ActionError: ...
    """


class Push(gym.Env[Array, Action]):
    """Base class of pushing environments; instantiate a subclass.

    ## Action Space
    `Box(-1, 1, (3,), float32)`, for "regrasp" `Box(-1, 1, (6,), float32)`. The argument `action` selects the
    meaning of an action; `ACTION_SCALE` contains the values of a full action. An action outside the space
    raises `InvalidAction`; the wrapper `gymnasium.wrappers.ClipAction` clips actions.

    | `action`   | 0                         | 1                         | 2                      | lasts |
    |------------|---------------------------|---------------------------|------------------------|-------|
    | "wrench"   | force, object x: 100 N    | force, object y: 100 N    | torque: 40 N m         | 50 ms |
    | "velocity" | gripper, world x: 0.3 m/s | gripper, world y: 0.3 m/s | spin: 0.6 rad/s        | 50 ms |
    | "push"     | where: pi rad             | lean: pi/3 rad            | speed: 0.15 + 0.15 m/s | 1 s   |
    | "regrasp"  | as "wrench"               | as "wrench"               | as "wrench"            | 50 ms |

    | `action`   | 3                         | 4                         | 5                            |
    |------------|---------------------------|---------------------------|------------------------------|
    | "regrasp"  | next x: half the length   | next y: half the width    | above 0: let go and go there |

    - "wrench": the wrench acts at the grasp point. It is reached within 20 ms and then constant.
    - "velocity": the velocity changes linearly over the 50 ms. The gripper holds the object through a
      compliant coupling (10 N/mm) and stalls at 100 N and 40 N m along the object's axes.
    - "push": a round tip of 2 cm touches the rim of the object. `where` is the direction from the mass
      centre, object frame. The tip moves along the inward normal, turned left by `lean`. It presses with at
      most 100 N, has a friction coefficient of 0.5 and may slip. After 0.8 s it is withdrawn.
    - "regrasp": if entry 5 is positive, the gripper releases the object and moves in a straight line to the
      next grasp point, which takes 1 s in whole actions. Entries 3 and 4 are the coordinates of that point
      relative to the bounding box of the object; a point outside the object is replaced by the nearest one
      on it. Meanwhile no wrench acts and actions are ignored; each still lasts 50 ms. Observations contain
      the position of the gripper. After the regrasp, the wrench of the next action rises from zero.

    ## Observation Space
    `Box(float64)`, world frame unless stated otherwise. A saturated instrument reads the bound.
    `trundle.envs.Observation` gives names to the entries.

    | Num   | Observation                                             | Bound | Unit  | Noise (sd) |
    |-------|---------------------------------------------------------|-------|-------|------------|
    | 0-1   | position of the object's frame                          | 3     | m     | 0.5 mm     |
    | 2-3   | cosine and sine of its heading                          | 1     | -     | 0.1 deg    |
    | 4-5   | velocity                                                | 4     | m/s   | 5 mm/s     |
    | 6     | spin                                                    | 7     | rad/s | 0.01 rad/s |
    | 7-8   | goal position                                           | 3     | m     | -          |
    | 9-10  | cosine and sine of the goal heading                     | 1     | -     | -          |
    | 11-12 | wrist sensor: force on the object, gripper axes, tared  | 120   | N     | 0.4 N      |
    | 13    | wrist sensor: torque about the gripper, tared           | 43    | N m   | 0.05 N m   |
    | 14-15 | position of gripper, grasp or contact, object frame     | 1.5   | m     | -          |

    If `object` may be any of several, two more numbers follow: half the object's length and width (m). Then
    the numbers of the task follow, all within 3 (m, or cosine and sine). Gripper axes are those of the
    object; for a push, x is the direction in which the tip moves, and the reading is the mean over the push.

    ## Starting State
    Object, hidden effects, start, goal and obstacles are drawn from the seed. Options of `reset`:

    - `start`: pose (x, y, heading) of the object, |x| and |y| at most 2 m
    - `goal`: goal pose, the same bounds; not for a path
    - `grasp`: grasp point (x, y) on the object, object frame
    - `same_object`: True keeps the object, its hidden effects and the obstacles

    ## Episode End
    - Termination: the goal is reached (within `reach` and `facing`, slower than 0.1 m/s), or the object is
      lost, which costs 100: its frame is more than 2.5 m from the origin along x or y, or it is faster than
      2 m/s or 4 rad/s.
    - Truncation: after `horizon` steps. The environment counts steps, so a snapshot includes the count.

    ## Information
    After each step `info` holds `is_success`, `lost`, `touched` (an obstacle), `distance` (m),
    `heading_error` (rad, in (-pi, pi]) and `progress` (share of a path), all of the true pose; it is empty
    after a reset.

    ## Arguments
    - `action` ("wrench"): "wrench", "velocity", "push" or "regrasp"
    - `object` ("office_table"): one of `trundle.envs.HOUSEHOLD`, an object file, "random" (generated),
      "household" (any of the ten), or a sequence of these, of which one is drawn
    - `hidden` ("wheels"): hidden effects, drawn with each object
        - "wheels": one wheel is locked (60 to 300 N s/m, depending on the direction), fixed, or a caster;
          the others roll with 3 to 12 N s/m; an object without wheels is in one of its configurations
        - "locked": one wheel is locked, the others roll freely
        - "configuration": one of those in the object file, with its friction varied by 30 %
        - "catalogue": as "wheels", and any one effect of the catalogue
        - "none": no effect
    - `effects` (()): additional effects, as tables of `model.toml` with all values
    - `noise` (1.0): factor on all noise, 0 to 10
    - `drop_out` (0.0): probability that the tracker loses a pose and repeats the last one
    - `reach` (0.05), `facing` (0.1): distance (m) and heading error (rad) within which the goal is reached
    - `horizon` (300, of pushes 30): steps after which an episode is truncated; 0: never
    - `step` (0.002), `substeps` (25): simulation step (s), and number of steps per action; a push has 20
      times as many
    - `render_mode` (None): "rgb_array" or "human"

    The environment can be pickled and deep-copied at any time; a copy continues identically. A planner can
    branch with `env.unwrapped.restore(env.unwrapped.snapshot())`.

    ## Example
    ```pycon
    >>> import gymnasium, trundle
    >>> env = gymnasium.make("trundle/PushPose-v0", object="household")
    >>> observation, info = env.reset(seed=0)
    >>> action = env.action_space.sample()
    >>> observation, reward, terminated, truncated, info = env.step(action)
    >>> sorted(info)
    ['distance', 'heading_error', 'is_success', 'lost', 'progress', 'touched']

    ```
    """

    metadata: dict[str, Any] = {"render_modes": list(RENDER_MODES), "render_fps": 20}  # noqa: RUF012 (as Env declares it)
    FIXED: ClassVar[dict[str, Any]] = {}
    """Options that are fixed in this task."""

    def __init__(
        self,
        *,
        action: str = "wrench",
        object: Names = "office_table",
        hidden: str | None = None,
        effects: Sequence[Mapping[str, Any]] = (),
        noise: float = 1.0,
        drop_out: float = 0.0,
        reach: float = REACH,
        facing: float = FACING,
        horizon: int | None = None,
        step: float = 0.002,
        substeps: int = 25,
        render_mode: str | None = None,
    ) -> None:
        if render_mode is not None and render_mode not in RENDER_MODES:
            raise TrundleError(f"render_mode = {render_mode!r}: choose 'rgb_array', 'human' or None")
        self.render_mode = render_mode
        self._options = options_toml(
            self.FIXED,
            action=action,
            object=object,
            hidden=hidden,
            effects=effects,
            noise=noise,
            drop_out=drop_out,
            reach=reach,
            facing=facing,
            horizon=horizon,
            step=step,
            substeps=substeps,
        )
        self._native = Pushing(self._options)
        self.mode = action
        """Meaning of an action."""
        self.varied = self._native.varied
        """Whether the object may be any of several; then observations contain its size."""
        self.horizon = self._native.horizon
        """Steps after which an episode is truncated; 0: never."""
        self.ACTION_SCALE = np.array(self._native.full)
        """Values of a full action."""
        self.metadata = {**self.metadata, "render_fps": max(1, round(1 / self._native.control))}
        self.action_space = gym.spaces.Box(-1.0, 1.0, self.ACTION_SCALE.shape, np.float32)
        bounds = np.array(self._native.bounds)
        self.observation_space = gym.spaces.Box(-bounds, bounds, dtype=np.float64)
        self.reveals = False
        """Whether pictures show the hidden wheels; `trundle.Oracle` sets it."""
        self._trail: list[tuple[float, float]] = []
        self._window: Window | None = None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Begin an episode; see the class for the options."""
        super().reset(seed=seed)
        if seed is None and not self._native.seeded:
            seed = int(self.np_random.integers(2**63))
        given = {} if options is None else options
        observation = self._native.reset(None if seed is None else seed % 2**64, **reset_options(given))
        self._trail.clear()
        self._draw()
        return observation, {}

    def step(self, action: Action) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Apply an action until the next one is due; see the class."""
        try:
            stepped = self._native.step(action)
        except NotFiniteError:
            raise
        except TrundleError as error:
            raise ActionError(str(error)) from None
        if stepped is None:
            raise ResetNeeded("no running episode: call reset() before step(), and after an episode ends")
        if self.render_mode is not None:
            self._draw()
        return stepped

    def snapshot(self) -> Snapshot:
        """Return the state of the episode, including random state and step count; it can be pickled."""
        return self._native.snapshot()

    def restore(self, snapshot: Snapshot) -> None:
        """Restore a snapshot of this environment or of another one with the same options.

        Raises
        ------
        TrundleError
            If the options differ, or this episode is being recorded.
        """
        self._native.restore(snapshot)
        self._trail.clear()

    def render(self) -> NDArray[np.uint8] | None:
        """Return a picture of 480 by 480 pixels, x to the right and y up; None in mode "human"."""
        if self.render_mode is None:
            gym.logger.warn("render() does nothing without render_mode in gymnasium.make")
            return None
        pixels = self._picture()
        if self.render_mode == "human":
            self._show(pixels)
            return None
        return pixels

    def close(self) -> None:
        """Close the window, if there is one."""
        if self._window is not None:
            self._window.close()
            self._window = None

    def hidden_model(self) -> dict[str, Any]:
        """Return the object with its hidden effects, as tables of a `model.toml`; not for the agent.

        Raises
        ------
        gymnasium.error.ResetNeeded
            Before the first reset.
        """
        return require_episode(self._native.hidden())

    def hidden_values(self) -> Array:
        """Return the numbers that `Oracle` adds to observations, shape (10,); NaN before the first reset."""
        return self._native.hidden_values()

    @staticmethod
    def seen_obstacles(observation: Array) -> list[list[tuple[float, float]]]:
        """Return the obstacles in an observation as polygons, world frame, m."""
        return []

    @property
    def control(self) -> float:
        """Time between two actions, s."""
        return self._native.control

    def start_recording(self) -> None:
        """Store the readings of sensor and tracker from the next reset on; for `trundle.Record`."""
        self._native.record()

    def take_rows(self) -> dict[str, Array]:
        """Return the readings since the last call, by column of a recording."""
        return self._native.take_rows()

    def recording_metadata(self, name: str) -> dict[str, Any]:
        """Return the content of `recording.toml`."""
        return self._native.metadata(name)

    @property
    def object_count(self) -> int:
        """Number of different objects so far; it increases when the hidden object changes."""
        return self._native.objects

    def _draw(self) -> None:
        if self.render_mode is None:
            return
        x, y, _ = require_episode(self._native.view())["object"]
        self._trail.append((x, y))
        if self.render_mode == "human":
            self._show(self._picture())

    def _show(self, pixels: NDArray[np.uint8]) -> None:
        if self._window is None:
            self._window = Window(f"trundle: {type(self).__name__}")
        self._window.show(pixels, self.metadata["render_fps"])

    def _picture(self) -> NDArray[np.uint8]:
        hidden = self._native.hidden() if self.reveals else None
        return draw(require_episode(self._native.view()), self._trail, hidden)

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_window": None}


def options_toml(
    fixed: Mapping[str, Any],
    *,
    action: str = "wrench",
    object: Names = "office_table",
    effects: Sequence[Mapping[str, Any]] = (),
    horizon: int | None = None,
    **others: Any,
) -> str:
    """Return options as TOML for the native module, without those that are None; `fixed` takes precedence."""
    for key, value in fixed.items():
        if others.get(key, value) not in (None, value):
            raise TrundleError(f"{key} = {others[key]!r}: this task has {value!r}; choose another task")
    names = [object] if isinstance(object, (str, PathLike)) else object
    if not isinstance(names, Sequence) or not all(isinstance(name, (str, PathLike)) for name in names):
        raise TrundleError(f"object = {object!r}: give the name of an object or a sequence of names")
    if isinstance(effects, str) or not all(isinstance(effect, Mapping) for effect in effects):
        raise TrundleError(f"effects = {effects!r}: give tables as in model.toml, such as {{'kind': …}}")
    options = {
        "action": action,
        "object": [fspath(name) for name in names],
        "effects": [dict(effect) for effect in effects],
        "horizon": (30 if action == "push" else 300) if horizon is None else horizon,
        **others,
        **fixed,
    }
    return tomli_w.dumps({key: _number(value) for key, value in options.items() if value is not None})


def _number(value: Any) -> Any:
    """Convert a NumPy number to a Python number."""
    return value.item() if isinstance(value, np.generic) else value


def reset_options(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return reset options as the native module expects them."""
    for key in given:
        if key not in RESET_OPTIONS:
            raise TrundleError(f"unknown reset option {key!r}; known are {', '.join(RESET_OPTIONS)}")
    return {
        "start": _numbers("start", given.get("start"), 3),
        "goal": _numbers("goal", given.get("goal"), 3),
        "grasp": _numbers("grasp", given.get("grasp"), 2),
        "same_object": _boolean("same_object", given.get("same_object", False)),
    }


def _boolean(key: str, value: Any) -> bool:
    if not isinstance(value, (bool, np.bool_)):
        raise TrundleError(f"reset option {key!r} = {value!r}: give True or False")
    return bool(value)


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
