"""Environments of a training, with the interface of stable-baselines3; needs `trundle[rl]`."""

from __future__ import annotations

from typing import Any, NamedTuple

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import (
    VecEnv,
    VecEnvWrapper,
    VecFrameStack,
    VecMonitor,
    VecNormalize,
)

from trundle._native import TrundleError
from trundle.envs.sb3 import SB3VecEnv
from trundle.experiments.training.config import RewardShaping, Settings
from trundle.experiments.training.frames import entry_count, to_frame

__all__ = ["Worlds", "make_worlds"]

ENV_LOSS_COST, ENV_HEADING_WEIGHT_M = 100.0, 0.3
"""Weights in the environments' reward: cost of a lost object, and of a radian of heading error (m)."""
NEAR_GOAL_M = 0.2
"""Scale of the error for `miss_cost`."""
MONITOR_KEYS = ("episode_returns", "episode_lengths", "episode_count")
NORMALIZE_KEYS = ("obs_rms", "ret_rms", "returns", "old_obs", "old_reward")


class FrameWrapper(VecEnvWrapper):  # type: ignore[misc]
    """Converts observations to a frame, float32."""

    def __init__(self, venv: VecEnv, task: str, frame: str) -> None:
        shape = (entry_count(venv.observation_space.shape[0], frame),)
        super().__init__(venv, observation_space=gym.spaces.Box(-np.inf, np.inf, shape, np.float32))
        self._task, self._frame = task, frame

    def reset(self) -> NDArray[np.float32]:
        """Start episodes."""
        return self._convert(self.venv.reset())

    def step_wait(self) -> tuple[Any, Any, Any, list[dict[str, Any]]]:
        """Step, and convert the observations."""
        observations, rewards, dones, infos = self.venv.step_wait()
        for index in np.flatnonzero(dones):
            last = infos[index]["terminal_observation"]
            infos[index]["terminal_observation"] = self._convert(last[None])[0]
        return self._convert(observations), rewards, dones, infos

    def _convert(self, observations: Any) -> NDArray[np.float32]:
        return to_frame(observations, self._task, self._frame)


class ShapedRewardWrapper(VecEnvWrapper):  # type: ignore[misc]
    """Adds shaped rewards. An inner monitor records those of the environment."""

    def __init__(self, venv: VecEnv, aids: RewardShaping, period: float) -> None:
        super().__init__(venv)
        self._aids, self._period = aids, period

    def reset(self) -> Any:
        """Start episodes."""
        return self.venv.reset()

    def step_wait(self) -> tuple[Any, Any, Any, list[dict[str, Any]]]:
        """Step, and add the shaped rewards."""
        observations, rewards, dones, infos = self.venv.step_wait()
        turns = np.array([abs(info["heading_error"]) for info in infos])
        errors = np.array([info["distance"] for info in infos]) + ENV_HEADING_WEIGHT_M * turns
        cost = self._aids.miss_cost * np.tanh(errors / NEAR_GOAL_M) + self._aids.turn_cost * turns
        rewards = (rewards - self._period * cost).astype(np.float32)
        for index in np.flatnonzero(dones):
            rewards[index] += self._aids.success_bonus * infos[index]["is_success"]
            rewards[index] += (ENV_LOSS_COST - self._aids.loss_cost) * infos[index]["lost"]
        return observations, rewards, dones, infos


class Worlds(NamedTuple):
    """The layers of environments whose state a checkpoint holds; `top` is the outermost."""

    batch: SB3VecEnv
    monitor: VecMonitor
    stack: VecFrameStack | None
    normalize: VecNormalize | None
    top: VecEnv

    def state(self) -> dict[str, Any]:
        """Return the state between two steps."""
        state = {
            "episodes": self.batch.env_method("snapshot"),
            "monitor": pick_attributes(self.monitor, MONITOR_KEYS),
        }
        if self.stack is not None:
            state["stack"] = self.stack.stacked_obs.stacked_obs
        if self.normalize is not None:
            state["normalize"] = pick_attributes(self.normalize, NORMALIZE_KEYS)
        return state

    def restore(self, state: dict[str, Any]) -> None:
        """Restore a state of environments with the same settings."""
        for index, episode in enumerate(state["episodes"]):
            self.batch.env_method("restore", episode, indices=index)
        vars(self.monitor).update(state["monitor"])
        if self.stack is not None:
            self.stack.stacked_obs.stacked_obs = state["stack"]
        if self.normalize is not None:
            vars(self.normalize).update(state["normalize"])


def pick_attributes(owner: Any, names: tuple[str, ...]) -> dict[str, Any]:
    """Return the existing attributes of an object among `names`."""
    return {name: getattr(owner, name) for name in names if hasattr(owner, name)}


def action_period(settings: Settings) -> float:
    """Return the time between two actions, s."""
    single: Any = gym.make(settings.env, **settings.env_kwargs).unwrapped
    return float(single.control)


def make_worlds(settings: Settings) -> Worlds:
    """Make the environments of a training.

    Raises
    ------
    TrundleError
        If the environment rejects its arguments.
    """
    try:
        step = action_period(settings)
        batch = SB3VecEnv.make(settings.env, settings.n_envs, **settings.env_kwargs)
    except TypeError as error:
        raise TrundleError(f"env_kwargs = {settings.env_kwargs}: {error}") from None
    monitor = VecMonitor(FrameWrapper(batch, settings.env, settings.frame))
    top: VecEnv = ShapedRewardWrapper(monitor, settings.aids, step)
    stack = normalize = None
    if settings.frame_stack > 1:
        top = stack = VecFrameStack(top, settings.frame_stack)
    if settings.normalize:
        gamma = settings.hyperparameters.get("gamma", 0.99)
        top = normalize = VecNormalize(top, gamma=gamma)
    return Worlds(batch, monitor, stack, normalize, top)
