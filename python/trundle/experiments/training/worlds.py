"""Environments of a training, with the interface of stable-baselines3; needs `trundle[rl]`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import (
    VecEnv,
    VecEnvWrapper,
    VecFrameStack,
    VecMonitor,
    VecNormalize,
)

from trundle._native import Pushing, TrundleError
from trundle.envs.oracle import Oracle, VectorOracle
from trundle.envs.sb3 import SB3VecEnv
from trundle.experiments.training.config import HER
from trundle.experiments.training.detours import DetourWrapper
from trundle.experiments.training.frames import entry_count, to_frame
from trundle.experiments.training.hindsight import goal_id
from trundle.experiments.training.settings import Settings

__all__ = ["Worlds", "make_worlds"]

ENV_LOSS_COST, ENV_HEADING_WEIGHT_M = 100.0, 0.3
"""Weights in the environments' reward: cost of a lost object, and of a radian of heading error (m)."""
NEAR_GOAL_M = 0.2
"""Scale of the error for `miss_cost`."""
SHAPED_KEYS = ("n_steps", "contact")
MONITOR_KEYS = ("episode_returns", "episode_lengths", "episode_count")
NORMALIZE_KEYS = ("obs_rms", "ret_rms", "returns", "old_obs", "old_reward")


class FrameWrapper(VecEnvWrapper):  # type: ignore[misc]
    """Converts observations to a frame, float32."""

    def __init__(self, venv: VecEnv, env: str, frame: str, hidden: int) -> None:
        shape = (entry_count(venv.observation_space.shape[0], frame),)
        super().__init__(venv, observation_space=gym.spaces.Box(-np.inf, np.inf, shape, np.float32))
        self._env, self._frame, self._hidden = env, frame, hidden

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
        return to_frame(observations, self._env, self._frame, self._hidden)


class ShapedRewardWrapper(VecEnvWrapper):  # type: ignore[misc]
    """Adds shaped rewards. An inner monitor records those of the environment."""

    def __init__(self, venv: VecEnv, settings: Settings, period: float) -> None:
        super().__init__(venv)
        self._aids, self._period, self._n_timesteps = settings.aids, period, settings.n_timesteps
        _, _, default = Pushing.default_costs(1)
        self._touch_cost = float(settings.env_kwargs.get("touch_cost", default))
        self.n_steps, self.contact = 0, np.zeros(venv.num_envs)

    def reset(self) -> Any:
        """Start episodes."""
        self.contact[:] = 0.0
        return self.venv.reset()

    def step_wait(self) -> tuple[Any, Any, Any, list[dict[str, Any]]]:
        """Step, and add the shaped rewards."""
        observations, rewards, dones, infos = self.venv.step_wait()
        turns = np.array([abs(info["heading_error"]) for info in infos])
        errors = np.array([info["distance"] for info in infos]) + ENV_HEADING_WEIGHT_M * turns
        cost = self._aids.miss_cost * np.tanh(errors / NEAR_GOAL_M) + self._aids.turn_cost * turns
        if self._aids.detour_cost:
            cost += self._aids.detour_cost * np.array([info["detour"] for info in infos])
        rewards = (rewards - self._period * cost + self._touch_refund(dones, infos)).astype(np.float32)
        for index in np.flatnonzero(dones):
            rewards[index] += self._aids.success_bonus * infos[index]["is_success"]
            rewards[index] += (ENV_LOSS_COST - self._aids.loss_cost) * infos[index]["lost"]
        return observations, rewards, dones, infos

    def _touch_refund(self, dones: NDArray[np.bool_], infos: list[dict[str, Any]]) -> Any:
        """Return the part of the cost of contact that is not charged yet."""
        self.n_steps += len(infos)
        if self._aids.touch_ramp is None:
            return 0.0
        first, last = self._aids.touch_ramp
        share = np.clip((self.n_steps / self._n_timesteps - first) / (last - first), 0.0, 1.0)
        contact = np.array([info["contact_time"] for info in infos])
        during, self.contact = contact - self.contact, np.where(dones, 0.0, contact)
        return (1.0 - share) * self._touch_cost * during


class Worlds(NamedTuple):
    """The layers of environments whose state a checkpoint holds; `top` is the outermost."""

    batch: SB3VecEnv
    detours: DetourWrapper | None
    monitor: VecMonitor
    shaped: ShapedRewardWrapper
    stack: VecFrameStack | None
    normalize: VecNormalize | None
    top: VecEnv

    def state(self) -> dict[str, Any]:
        """Return the state between two steps."""
        state = {
            "episodes": self.batch.env_method("snapshot"),
            "monitor": pick_attributes(self.monitor, MONITOR_KEYS),
            "shaped": pick_attributes(self.shaped, SHAPED_KEYS),
        }
        if self.detours is not None:
            state["detours"] = self.detours.first
        if self.stack is not None:
            state["stack"] = self.stack.stacked_obs.stacked_obs
        if self.normalize is not None:
            state["normalize"] = pick_attributes(self.normalize, NORMALIZE_KEYS)
        return state

    def restore(self, state: dict[str, Any]) -> None:
        """Restore a state of environments with the same settings."""
        for index, episode in enumerate(state["episodes"]):
            self.batch.env_method("restore", episode, indices=index)
        set_attributes(self.monitor, state["monitor"])
        set_attributes(self.shaped, state["shaped"])
        if self.detours is not None:
            self.detours.begin(state["detours"])
        if self.stack is not None:
            self.stack.stacked_obs.stacked_obs = state["stack"]
        if self.normalize is not None:
            set_attributes(self.normalize, state["normalize"])


def pick_attributes(owner: Any, names: tuple[str, ...]) -> dict[str, Any]:
    """Return the existing attributes of an object among `names`."""
    return {name: getattr(owner, name) for name in names if hasattr(owner, name)}


def set_attributes(owner: Any, values: Mapping[str, Any]) -> None:
    """Set the attributes of an object that `pick_attributes` returned."""
    for name, value in values.items():
        setattr(owner, name, value)


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
    hidden = len(Oracle.NAMES) if settings.privileged else 0
    replays_goals = isinstance(settings, HER)
    try:
        step = action_period(settings)
        vector = gym.make_vec(
            (goal_id(settings.env) or "") if replays_goals else settings.env,
            settings.n_envs,
            "vector_entry_point",
            autoreset_mode=AutoresetMode.DISABLED,
            **settings.env_kwargs,
        )
    except TypeError as error:
        raise TrundleError(f"env_kwargs = {settings.env_kwargs}: {error}") from None
    batch = SB3VecEnv(VectorOracle(vector) if hidden else vector)
    bottom: VecEnv = batch
    detours = None
    if settings.aids.detour_cost:
        bottom = detours = DetourWrapper(batch, settings.env, hidden, ENV_HEADING_WEIGHT_M)
    framed = bottom if replays_goals else FrameWrapper(bottom, settings.env, settings.frame, hidden)
    monitor = VecMonitor(framed)
    top: VecEnv = (shaped := ShapedRewardWrapper(monitor, settings, step))
    stack = normalize = None
    if settings.frame_stack > 1:
        top = stack = VecFrameStack(top, settings.frame_stack)
    if settings.normalize:
        gamma = settings.hyperparameters.get("gamma", 0.99)
        # Rewards of replayed goals are computed anew, and not normalised.
        top = normalize = VecNormalize(top, norm_reward=not replays_goals, gamma=gamma)
    return Worlds(batch, detours, monitor, shaped, stack, normalize, top)
