"""Environments in which an agent pushes an object with hidden effects."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import gymnasium as gym
import numpy as np
from gymnasium.error import ResetNeeded
from numpy.typing import NDArray

from trundle._native import NotFiniteError, Pushing, Snapshot, TrundleError
from trundle.envs.action_error import ActionError
from trundle.envs.external_motion import ExternalMotion, Stepped
from trundle.envs.push_options import Names, options_toml, reset_options
from trundle.envs.recordable import RecordableEpisodes
from trundle.envs.view import draw, require_episode
from trundle.envs.window import Window

__all__ = ["Push"]

Array = NDArray[np.float64]
Action = NDArray[np.float32]

RENDER_MODES = ("rgb_array", "human")
DTYPES = ("float64", "float32")
REACH, FACING = 0.05, 0.1
"""Default distance (m) and heading error (rad) within which a goal is reached."""


class Push(ExternalMotion, RecordableEpisodes, gym.Env[Array, Action]):
    """Base class of pushing environments; instantiate a subclass.

    ## Action Space
    `Box(-1, 1, (3,), float32)`, for "regrasp" `Box(-1, 1, (6,), float32)`. The argument `action` selects the
    meaning of an action; `ACTION_SCALE` contains the values of a full action. Actions outside the space are
    clipped, and `info["action_clipped"]` is then True. In v0 they raise `InvalidAction`; the wrapper
    `gymnasium.wrappers.ClipAction` clips them.

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

    Then follow, in object axes and within 3 m: half the length and width of the bounding box, the x and y of
    its middle, and with `outline=True` 24 distances from the middle to the outermost point of the object, at
    angles of 0, 15, 30, ... degrees. In v0 only half the length and width follow, and only if `object` may be
    any of several. The numbers of the task come last, all within 3 (m, or cosine and sine). Gripper axes are
    those of the object; for a push, x is the direction in which the tip moves, and the reading is the mean
    over the push.

    All measurements are of the object and of the actual end effector, never of a command. Entries 14-15 are
    the grasp on the object, and 11-13 the wrench that the object feels.

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
    After each step `info` holds, of the true state; it is empty after a reset:

    - `is_success`: the goal is reached
    - `success_without_touching`: the goal is reached, and no obstacle was touched in the episode
    - `touched`: an obstacle exerted a force in this step; in v0 it was within 2 cm
    - `contact_time` (s), `contact_impulse` (N s): contact with obstacles in the episode so far; the impulse
      is the sum of magnitudes
    - `distance` (m), `heading_error` (rad, in (-pi, pi]), `progress` (share of a path)
    - `lost`: the object left the workspace or was too fast
    - `action_clipped`: an entry of the action was outside [-1, 1]
    - `duration` (s): longer than the control period if a decision takes longer

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
    - `level` (None): "easy", "medium" or "hard" draw objects from the sets of the level, not from `object`;
      ids such as "trundle/PushAroundHard-v1" set it. `split` ("train"): "train" or "test"
    - `mass` (None): range of the mass of `object="random"`, kg; (8, 60) by default
    - `friction` (None): range of the friction of a locked wheel, N s/m; (60, 300), or that of the level
    - `outline` (False): whether observations contain the outline
    - `arm` (None): properties of the arm, a mapping with some of
        - `lag` (0): time constant of a first-order lag, s, up to 2
        - `rate` (inf): largest rate of change of the command, full actions per second
        - `delay` (0): time until a command takes effect, s, up to 1
        - `saturation` (1): largest command, as a fraction of a full action
        - `noise` (0): standard deviation of the noise of each action, as a fraction of a full action
        - `wrist` (None): a soft wrist, a mapping with some of `stiffness` (2000 N/m), `damping` (60 N s/m),
          `twist_stiffness` (60 N m/rad), `twist_damping` (2 N m s/rad), `mass` (2 kg), `inertia` (0.02 kg m2)
    - `sensor_delay` (0): delay of pose, velocity, wrench and grasp in observations, s, up to 1
    - `realtime` (None): decision time, s, up to 1, during which the world goes on; or "measured"
    - `time_cost`, `effort_cost`, `touch_cost` (None): costs per second; see the rewards
    - `dtype` ("float64"): type of observations, or "float32"
    - `effects` (()): additional effects, as tables of `model.toml` with all values
    - `noise` (1.0): factor on all noise, 0 to 10
    - `drop_out` (0.0): probability that the tracker loses a pose and repeats the last one
    - `reach` (0.05), `facing` (0.1): distance (m) and heading error (rad) within which the goal is reached
    - `horizon` (0, of pushes 30; in v0 300 and 30): steps after which an episode is truncated; 0: never.
      `gymnasium.make` sets `max_episode_steps=300` in v1; the smaller limit applies
    - `step` (0.002), `substeps` (25): simulation step (s), and number of steps per action; a push has 20
      times as many
    - `render_mode` (None): "rgb_array" or "human"

    ## Timing of a Real Arm
    Times are rounded to simulation steps. Let T be the time between two observations (50 ms, of a push 1 s).

    - An action that follows the observation at time t takes effect at t + `realtime` + `arm["delay"]`. Until
      then the previous command acts; before the first one, none. The new command then ramps as without delay.
    - If `realtime` exceeds T, the step lasts the next multiple of T; `info["duration"]` and the reward
      account for it, and `horizon` counts multiples of T. "measured" takes the wall time between the return
      of `reset` or `step` and the next `step`, up to 10 s. Its episodes are not reproducible.
    - A command passes noise, saturation, decision time and delay, rate limit, lag and wrist, in this order.
      Noise is drawn once per action, from the seed.
    - With a soft wrist, "wrench" and "regrasp" command the wrench on a hand of `mass` and `inertia`, which
      holds the gripper through a spring and damper. "velocity" commands the velocity of the hand.
      "push" has no wrist.
    - An observation at time t shows the measurements of t - `sensor_delay`; before that, those at the start.
      Goal, path and obstacles are not delayed, nor is the mean wrench of a push.

    The environment can be pickled and deep-copied at any time; a copy continues identically. A planner can
    branch with `env.unwrapped.restore(env.unwrapped.snapshot())`.

    ## Example
    ```pycon
    >>> import gymnasium, trundle
    >>> env = gymnasium.make("trundle/PushPose-v0", object="household")
    >>> observation, info = env.reset(seed=0)
    >>> action = env.action_space.sample()
    >>> observation, reward, terminated, truncated, info = env.step(action)
    >>> info["is_success"], info["contact_time"]
    (False, 0.0)

    ```
    """

    metadata: dict[str, Any] = {"render_modes": list(RENDER_MODES), "render_fps": 20}  # noqa: RUF012 (as Env declares it)
    OBJECT_SETS = Pushing.OBJECT_SETS
    """Sets of the levels: level, split, outlines, mass range (kg), wheel layouts, friction range (N s/m)."""
    FIXED: ClassVar[dict[str, Any]] = {}
    """Options that are fixed in this task."""

    def __init__(
        self,
        *,
        action: str = "wrench",
        object: Names | None = None,
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
        level: str | None = None,
        split: str | None = None,
        mass: Sequence[float] | None = None,
        friction: Sequence[float] | None = None,
        outline: bool = False,
        arm: Mapping[str, Any] | None = None,
        sensor_delay: float = 0.0,
        realtime: float | str | None = None,
        time_cost: float | None = None,
        effort_cost: float | None = None,
        touch_cost: float | None = None,
        dtype: str = "float64",
        version: int = 0,
    ) -> None:
        if render_mode is not None and render_mode not in RENDER_MODES:
            raise TrundleError(f"render_mode = {render_mode!r}: choose 'rgb_array', 'human' or None")
        if dtype not in DTYPES:
            raise TrundleError(f"dtype = {dtype!r}: choose 'float64' or 'float32'")
        self.render_mode = render_mode
        self.dtype: np.dtype[Any] = np.dtype(dtype)
        """Type of observations."""
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
            level=level,
            split=split,
            mass=mass,
            friction=friction,
            outline=outline,
            arm=arm,
            sensor_delay=sensor_delay,
            realtime=realtime,
            time_cost=time_cost,
            effort_cost=effort_cost,
            touch_cost=touch_cost,
            version=version,
        )
        self._native = Pushing(self._options)
        self.mode = action
        """Meaning of an action."""
        self.substeps = substeps
        """Simulation steps per action."""
        self.varied = self._native.varied
        """Whether the object may be any of several; then observations contain its size."""
        self.version = version
        """Version of the environment."""
        self.has_outline = outline
        """Whether observations contain the outline."""
        self.ACTION_SCALE = np.array(self._native.full)
        """Values of a full action."""
        self.metadata = {**self.metadata, "render_fps": max(1, round(1 / self._native.control))}
        self.action_space = gym.spaces.Box(-1.0, 1.0, self.ACTION_SCALE.shape, np.float32)
        bounds = np.array(self._native.bounds, dtype=self.dtype)
        self.observation_space = gym.spaces.Box(-bounds, bounds, dtype=self.dtype.type)
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
        return observation.astype(self.dtype, copy=False), {}

    def step(self, action: Action) -> Stepped:
        """Apply an action until the next one is due; see the class."""
        try:
            stepped = self._native.step(action)
        except NotFiniteError:
            raise
        except TrundleError as error:
            raise ActionError(str(error)) from None
        return self._returned(stepped)

    def _returned(self, stepped: Stepped | None) -> Stepped:
        if stepped is None:
            raise ResetNeeded("no running episode: call reset() before step(), and after an episode ends")
        if self.render_mode is not None:
            self._draw()
        if self.dtype != np.float64:
            return stepped[0].astype(self.dtype), *stepped[1:]
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
    def horizon(self) -> int:
        """Steps after which an episode is truncated; 0: never."""
        limit = None if self.spec is None else self.spec.max_episode_steps
        return min((steps for steps in (self._native.horizon, limit or 0) if steps > 0), default=0)

    @property
    def control(self) -> float:
        """Time between two actions, s."""
        return self._native.control

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
