"""A batch of environments as a `VecEnv` of stable-baselines3; needs the extra `trundle[rl]`."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from numpy.typing import NDArray

from trundle._native import TrundleError
from trundle._optional import require

if TYPE_CHECKING:
    from stable_baselines3.common.vec_env import VecEnv
else:
    VecEnv = require("stable_baselines3.common.vec_env", "rl", "batches for stable-baselines3").VecEnv

__all__ = ["SB3VecEnv"]

Indices = int | Iterable[int] | None


class SB3VecEnv(VecEnv):  # type: ignore[misc]
    """Batch of environments, bit for bit equal to `make_vec_env` of stable-baselines3, but faster.

    An environment that has ended is reset in the same step; `infos[i]` then contains "terminal_observation".
    Infos of every step contain "TimeLimit.truncated", "is_success" and the other infos of the environment.
    Observations are float64, so a policy also works with single environments, and replayed goals have the
    rewards of `step`.

    `seed` and `set_options` act on the next `reset`, not on automatic resets. `env_method` supports
    "compute_reward", "hidden_values", "restore" and "snapshot". `VecMonitor` around the batch logs returns.

    Parameters
    ----------
    batch : gymnasium.vector.VectorEnv
        A batch with `autoreset_mode="Disabled"`, wrapped or not; `make` creates one.

    Raises
    ------
    TrundleError
        If the batch resets itself.

    Examples
    --------
    >>> environments = VecMonitor(SB3VecEnv.make("trundle/PushPose-v0", num_envs=64))  # doctest: +SKIP
    >>> PPO("MlpPolicy", environments).learn(1_000_000)  # doctest: +SKIP
    """

    def __init__(self, batch: VectorEnv[Any, Any, Any]) -> None:
        if batch.metadata.get("autoreset_mode") is not AutoresetMode.DISABLED:
            raise TrundleError(f"{batch} resets itself: make it with autoreset_mode='Disabled'")
        self._batch = batch
        super().__init__(batch.num_envs, batch.single_observation_space, batch.single_action_space)
        self.metadata, self.spec = dict(batch.metadata), batch.spec
        self._actions: Any = None

    @classmethod
    def make(cls, env_id: str, num_envs: int = 1, **options: Any) -> SB3VecEnv:
        """Make a batch by its id, with the options of `gymnasium.make_vec`."""
        options["autoreset_mode"] = AutoresetMode.DISABLED
        return cls(gym.make_vec(env_id, num_envs, "vector_entry_point", **options))

    def reset(self) -> Any:
        """Begin episodes, with the seeds and options that were set since the last reset."""
        seeds = None if all(seed is None for seed in self._seeds) else self._seeds
        for options, mask in _group_by_options(self._options):
            observations, infos = self._batch.reset(seed=seeds, options={**options, "reset_mask": mask})
            self._keep(infos, mask)
        self._reset_seeds()
        self._reset_options()
        return _copy(observations)

    def step_async(self, actions: Any) -> None:
        """Store the actions for `step_wait`."""
        self._actions = actions

    def step_wait(self) -> tuple[Any, NDArray[np.float32], NDArray[np.bool_], list[dict[str, Any]]]:
        """Step all environments, and reset those whose episode has ended."""
        observations, rewards, terminated, truncated, columns = self._batch.step(self._actions)
        infos, ended = _rows(columns, self.num_envs), terminated | truncated
        for info, late in zip(infos, (truncated & ~terminated).tolist(), strict=True):
            info["TimeLimit.truncated"] = late
        if ended.any():
            for index in np.flatnonzero(ended):
                infos[index]["terminal_observation"] = _copy(observations, index)
            observations, begun = self._batch.reset(options={"reset_mask": ended.copy()})
            self._keep(begun, ended)
        return _copy(observations), rewards.astype(np.float32), ended, infos

    def close(self) -> None:
        """Close the batch."""
        self._batch.close()

    def get_images(self) -> Sequence[Any]:
        """Return a picture of each environment, for `render` and `VecVideoRecorder`."""
        return self._batch.render() or [None] * self.num_envs

    def get_attr(self, attr_name: str, indices: Indices = None) -> list[Any]:
        """Return an attribute of the batch, repeated for each index; spaces are those of one environment."""
        name = f"single_{attr_name}" if attr_name in ("action_space", "observation_space") else attr_name
        owner = self._batch if hasattr(self._batch, name) else self._batch.unwrapped
        return [getattr(owner, name) for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Indices = None) -> None:
        """Set an attribute of the batch; all environments share it."""
        if set(self._get_indices(indices)) != set(range(self.num_envs)):
            raise TrundleError(f"all environments of a batch share {attr_name!r}: set it without indices")
        setattr(self._batch.unwrapped, attr_name, value)

    def env_method(self, method_name: str, *args: Any, indices: Indices = None, **kwargs: Any) -> list[Any]:
        """Call one of the methods that the class lists."""
        chosen, batch = list(self._get_indices(indices)), self.get_attr("unwrapped")[0]
        if method_name in ("restore", "snapshot"):
            return [getattr(batch, method_name)(index, *args, **kwargs) for index in chosen]
        if method_name == "hidden_values":
            return list(batch.hidden_values()[chosen])
        if method_name == "compute_reward":
            return [batch.compute_reward(*args, **kwargs)] * len(chosen)
        raise AttributeError(f"environments of a batch have no method {method_name!r}")

    def env_is_wrapped(self, wrapper_class: type, indices: Indices = None) -> list[bool]:
        """Return whether the batch has a wrapper of a class, repeated for each index."""
        layer, wrapped = self._batch, False
        while layer is not layer.unwrapped:
            wrapped |= isinstance(layer, wrapper_class)
            layer = layer.env  # type: ignore[attr-defined]
        return [wrapped for _ in self._get_indices(indices)]

    def _keep(self, infos: dict[str, Any], mask: NDArray[np.bool_]) -> None:
        rows = _rows(infos, self.num_envs)
        for index in np.flatnonzero(mask):
            self.reset_infos[index] = rows[index]


def _group_by_options(
    options: Sequence[dict[str, Any]],
) -> Iterable[tuple[dict[str, Any], NDArray[np.bool_]]]:
    """Yield options and the mask of their environments; options set for all at once are one object."""
    keys = np.array([id(one) if one else 0 for one in options])
    for key in dict.fromkeys(keys.tolist()):
        mask = keys == key
        yield options[int(mask.argmax())], mask


def _rows(infos: dict[str, Any], count: int) -> list[dict[str, Any]]:
    """Return the infos of a batch as one dictionary each; `_key` is the mask of those that have `key`."""
    rows: list[dict[str, Any]] = [{} for _ in range(count)]
    for key, column in infos.items():
        if key.startswith("_"):
            continue
        values = _rows(column, count) if isinstance(column, dict) else column.tolist()
        present = infos[f"_{key}"].tolist() if f"_{key}" in infos else [True] * count
        for row, value, there in zip(rows, values, present, strict=True):
            if there:
                row[key] = value
    return rows


def _copy(observations: Any, index: Any = ...) -> Any:
    """Return a copy of the observations, or of one of them."""
    if isinstance(observations, dict):
        return {key: part[index].copy() for key, part in observations.items()}
    return observations[index].copy()
