"""Batches of environments that native code steps on all cores."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np
from gymnasium.error import ResetNeeded
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from trundle._native import Batch, NotFiniteError, Snapshot, TrundleError
from trundle.envs import goal, tasks
from trundle.envs.action_error import ActionError
from trundle.envs.goal import GoalSpace
from trundle.envs.observation import Observation
from trundle.envs.push import FACING, REACH, Push
from trundle.envs.push_options import default_horizon, reset_options
from trundle.envs.view import draw, require_episode

__all__ = ["PushGoalVec", "PushVec"]

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

COLUMNS: list[str] = Batch.COLUMNS
MAX_NUM_ENVS = 2**62
"""Upper bound on `num_envs` for the native module; no memory suffices for so many."""
BOOLEAN_INFOS = ("is_success", "lost", "touched", "success_without_touching", "action_clipped")


class PushVec(VectorEnv[Any, Any, Any]):
    """Base class of batches of pushing environments; use `gymnasium.make_vec`.

    Each environment is bit for bit equal to the single one with its seed, for any number of environments and
    threads.

    Parameters
    ----------
    num_envs : int
        Number of environments.
    autoreset_mode : AutoresetMode or str
        "NextStep", "SameStep" or "Disabled", as Gymnasium documents them; in "SameStep" `infos["final_obs"]`
        holds the last observations, of shape (num_envs, n), and `infos["final_info"]` the last infos, where
        `infos["_final_obs"]` is True.
    copy : bool
        Whether `step` and `reset` return copies of the observations. Otherwise the next call overwrites them.
    render_mode : {"rgb_array"}, optional
        With it, `render` returns a tuple of pictures.
    max_episode_steps : int, optional
        Gymnasium's name for `horizon`; in version 1 the smaller of both applies.
    **options
        Options of the single environment.

    Raises
    ------
    TrundleError
        If an option is invalid, or the batch does not fit into free memory.

    Examples
    --------
    >>> import gymnasium, trundle
    >>> envs = gymnasium.make_vec("trundle/PushDoor-v0", num_envs=64, object="household")
    >>> observations, infos = envs.reset(seed=0)
    >>> observations.shape
    (64, 23)
    """

    ENV: ClassVar[type[Push]] = Push
    """The single environment."""

    def __init__(
        self,
        num_envs: int = 1,
        *,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        copy: bool = True,
        render_mode: str | None = None,
        max_episode_steps: int | None = None,
        **options: Any,
    ) -> None:
        if max_episode_steps is not None:
            own = options.get("horizon")
            if own is not None and options.get("version", 0) == 0:
                raise TrundleError("max_episode_steps and horizon are the same option; give one of them")
            if own is None and options.get("action") == "push" and options.get("version", 0) > 0:
                own = default_horizon("push", 1)
            options["horizon"] = min(own, max_episode_steps) if own else max_episode_steps
        if num_envs < 1:
            raise TrundleError(f"num_envs = {num_envs}: at least one environment is needed")
        if render_mode not in (None, "rgb_array"):
            raise TrundleError(f"render_mode = {render_mode!r}: choose 'rgb_array' or None for a batch")
        # The single environment validates the options and defines the spaces.
        single = self.ENV(**options)
        self.num_envs, self.render_mode = num_envs, render_mode
        self.autoreset_mode = AutoresetMode(autoreset_mode)
        # Before the buffers below: it refuses batches that do not fit into memory.
        self._native = Batch(single._options, min(num_envs, MAX_NUM_ENVS), self.autoreset_mode.value)
        self.metadata = {
            **single.metadata,
            "render_modes": ["rgb_array"],
            "autoreset_mode": self.autoreset_mode,
        }
        self.dtype = single.dtype
        self.ACTION_SCALE = single.ACTION_SCALE
        self.single_action_space = single.action_space
        self.single_observation_space = single.observation_space
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self._copy = copy
        entries = len(single._native.bounds)
        self._seen, self._finals = np.zeros((num_envs, entries)), np.zeros((num_envs, entries))
        self._table = np.zeros((num_envs, len(COLUMNS)))
        self._ended: Flags = np.zeros(num_envs, dtype=np.bool_)

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Any, dict[str, Any]]:
        """Begin episodes of all environments, or of those in `options["reset_mask"]`; see `Push.reset`."""
        others = dict(options or {})
        mask = self._mask(others.pop("reset_mask", None))
        seeds = self._seeds(seed)
        chosen = [(one,) if wanted else None for one, wanted in zip(seeds, mask, strict=True)]
        self._native.reset(chosen, self._seen, **reset_options(others))
        self._ended[mask] = False
        return self._observed(self._seen), {}

    def step(self, actions: Any) -> tuple[Any, Array, Flags, Flags, dict[str, Any]]:
        """Apply the actions until the next ones are due."""
        if not self._native.ready:
            raise ResetNeeded(
                "an environment has no running episode: call reset() before step(), and after an episode ends"
            )
        try:
            self._native.step(actions, self._seen, self._finals, self._table)
        except NotFiniteError:
            raise
        except TrundleError as error:
            raise ActionError(str(error)) from None
        table = self._table
        terminated, truncated = self._ends(table[:, 1] != 0, table[:, 2] != 0)
        ended = terminated | truncated
        is_new = self._ended if self.autoreset_mode is AutoresetMode.NEXT_STEP else np.zeros_like(ended)
        self._ended = ended
        infos = self._infos(ended, is_new)
        return self._observed(self._seen), self._rewards(ended, is_new), terminated, truncated, infos

    def snapshot(self, index: int) -> Snapshot:
        """Return the state of one environment, as `Push.snapshot` does."""
        return self._native.snapshot(index)

    def restore(self, index: int, snapshot: Snapshot) -> None:
        """Restore the state of one environment; results that `step` returned before are not updated."""
        self._native.restore(index, snapshot)
        self._ended[index] = self._native.ended(index)

    def hidden_values(self) -> Array:
        """Return the numbers that `VectorOracle` adds to observations, shape (num_envs, 10)."""
        return self._native.hidden_values()

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """Return a picture of each environment, or None without `render_mode`."""
        if self.render_mode is None:
            return None
        return tuple(draw(require_episode(self._native.view(index))) for index in range(self.num_envs))

    def _seeds(self, seed: int | Sequence[int | None] | None) -> list[int | None]:
        """Return a seed for each environment; None continues its random stream."""
        if isinstance(seed, (int, np.integer)):
            super().reset(seed=int(seed))
            seed = [int(seed) + index for index in range(self.num_envs)]
        seeds = [None] * self.num_envs if seed is None else list(seed)
        if len(seeds) != self.num_envs:
            raise TrundleError(f"{len(seeds)} seeds for {self.num_envs} environments: give one for each")
        # Always draw all seeds, so that seeding one environment does not affect the others.
        drawn = self.np_random.integers(2**63, size=self.num_envs)
        given = [
            one if one is not None or known else draw
            for one, known, draw in zip(seeds, self._native.seeded, drawn, strict=True)
        ]
        if any(one is not None and one < 0 for one in given):
            raise TrundleError(f"seed = {seed}: must not be negative")
        return [None if one is None else int(one) % 2**64 for one in given]

    def _mask(self, mask: Any) -> Flags:
        if mask is None:
            return np.ones(self.num_envs, dtype=np.bool_)
        array = np.asarray(mask)
        if array.shape != (self.num_envs,) or array.dtype != np.bool_ or not array.any():
            raise TrundleError(
                f"reset_mask = {mask!r}: give {self.num_envs} booleans, at least one of them True"
            )
        return array

    def _observed(self, seen: Array) -> Any:
        if self.dtype != np.float64:
            return seen.astype(self.dtype)
        return seen.copy() if self._copy else seen

    def _ends(self, terminated: Flags, truncated: Flags) -> tuple[Flags, Flags]:
        return terminated, truncated

    def _rewards(self, ended: Flags, is_new: Flags) -> Array:
        return self._table[:, 0].copy()

    def _infos(self, ended: Flags, is_new: Flags) -> dict[str, Any]:
        columns = {
            key: self._table[:, k] != 0 if key in BOOLEAN_INFOS else self._table[:, k]
            for k, key in enumerate(COLUMNS)
            if k > 2
        }
        same = self.autoreset_mode is AutoresetMode.SAME_STEP
        if not (same and ended.any()):
            return _masked(columns, ~is_new)
        return {
            **_masked(columns, ~ended),
            "final_obs": self._observed(self._finals),
            "_final_obs": ended,
            "final_info": _masked(columns, ended),
            "_final_info": ended,
        }


def _masked(columns: dict[str, Any], mask: Flags) -> dict[str, Any]:
    """Return infos in Gymnasium's vector format: `_key` is the mask of the environments that have `key`."""
    if not mask.any():
        return {}
    kept = {
        key: column.copy() if mask.all() else np.where(mask, column, 0) for key, column in columns.items()
    }
    return {**kept, **{f"_{key}": mask.copy() for key in columns}}


class PushGoalVec(PushVec):
    """Base class of goal-conditioned batches: observations and `final_obs` are dictionaries of copies.

    Examples
    --------
    >>> import gymnasium, trundle
    >>> envs = gymnasium.make_vec("trundle/PushPoseGoal-v0", num_envs=8)
    >>> observations, infos = envs.reset(seed=0)
    >>> observations["achieved_goal"].shape
    (8, 4)
    """

    def __init__(self, num_envs: int = 1, *, reward_type: str = "sparse", **options: Any) -> None:
        self._goals = GoalSpace(reward_type, options.get("reach", REACH), options.get("facing", FACING))
        super().__init__(num_envs, **options)

    def compute_reward(self, achieved_goal: Array, desired_goal: Array, info: Any) -> Any:
        """Return the reward of goals of shape (4,) or (n, 4)."""
        return self._goals.compute_reward(achieved_goal, desired_goal)

    def _observed(self, seen: Array) -> Any:
        return self._goals.split(seen.astype(self.dtype, copy=False))

    def _ends(self, terminated: Flags, truncated: Flags) -> tuple[Flags, Flags]:
        return np.zeros_like(terminated), terminated | truncated

    def _rewards(self, ended: Flags, is_new: Flags) -> Array:
        last = self._seen
        if self.autoreset_mode is AutoresetMode.SAME_STEP:
            last = np.where(ended[:, None], self._finals, self._seen)
        fields = Observation(last)
        rewards = self._goals.reward(fields.pose_vector, fields.goal_vector)
        rewards[is_new] = 0.0
        return rewards


class LockedWheelVec(PushVec):
    """A batch of `LockedWheel`."""

    ENV = tasks.LockedWheel


class PushPoseVec(PushVec):
    """A batch of `PushPose`."""

    ENV = tasks.PushPose


class PushPathVec(PushVec):
    """A batch of `PushPath`."""

    ENV = tasks.PushPath


class PushAroundVec(PushVec):
    """A batch of `PushAround`."""

    ENV = tasks.PushAround


class PushDoorVec(PushVec):
    """A batch of `PushDoor`."""

    ENV = tasks.PushDoor


class PushPoseGoalVec(PushGoalVec):
    """A batch of `PushPoseGoal`."""

    ENV = goal.PushPoseGoal


class PushPathGoalVec(PushGoalVec):
    """A batch of `PushPathGoal`."""

    ENV = goal.PushPathGoal


class PushAroundGoalVec(PushGoalVec):
    """A batch of `PushAroundGoal`."""

    ENV = goal.PushAroundGoal


class PushDoorGoalVec(PushGoalVec):
    """A batch of `PushDoorGoal`."""

    ENV = goal.PushDoorGoal
