"""PPO of stable-baselines3, trained in hidden worlds of the arena."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gymnasium
import numpy as np

from trundle._optional import require
from trundle.experiments.arena.planner import costs
from trundle.experiments.arena.world import make
from trundle.experiments.sampling import Floats

__all__ = ["load", "train"]

TABLE_PX = 512.0
SHAPING_PX = 50.0
"""Decrease of the planner's cost that earns a reward of 1."""
ENVIRONMENTS = 8


class Shaped(gymnasium.Wrapper[Any, Any, Any, Any]):
    """Scales observations and actions to about ±1, and adds the decrease of the planner's cost to rewards."""

    def __init__(self, env: gymnasium.Env[Any, Any]) -> None:
        super().__init__(env)
        self.observation_space = gymnasium.spaces.Box(-2.0, 2.0, (6,), np.float32)
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (2,), np.float32)
        self.cost = 0.0

    def reset(self, **options: Any) -> tuple[Floats, dict[str, Any]]:
        """Start an episode."""
        observation, info = self.env.reset(**options)
        self.cost = cost_of(observation)
        return scaled(observation), info

    def step(self, action: Floats) -> tuple[Floats, float, bool, bool, dict[str, Any]]:
        """Apply an action in [-1, 1]²."""
        observation, reward, terminated, truncated, info = self.env.step(to_table(action))
        before, self.cost = self.cost, cost_of(observation)
        earned = float(reward) + (before - self.cost) / SHAPING_PX
        return scaled(observation), earned, terminated, truncated, info


def cost_of(observation: Floats) -> float:
    """Return the planner's cost of a pose."""
    return float(costs(observation[None, None])[0])


def scaled(observation: Floats) -> Floats:
    """Return the input of the network (6,): positions about the middle, cosine and sine of the angle."""
    positions = 2 * observation[:4] / TABLE_PX - 1
    return np.array([*positions, np.cos(observation[4]), np.sin(observation[4])], dtype=np.float32)


def to_table(action: Floats) -> Floats:
    """Return the position on the table (2,), px, of an output of the network."""
    return np.asarray((np.clip(action, -1, 1) + 1) / 2 * TABLE_PX, dtype=np.float64)


def train(physics: str, steps: int, seed: int, path: Path) -> None:
    """Train PPO for a number of actions, and write the policy to `path`."""
    sb3 = require("stable_baselines3", "rl", "trained policies")
    require("torch", "rl", "trained policies").set_num_threads(1)
    envs = require("stable_baselines3.common.vec_env", "rl", "trained policies").DummyVecEnv(
        [lambda: Shaped(make(physics)) for _ in range(ENVIRONMENTS)]
    )
    model = sb3.PPO("MlpPolicy", envs, n_steps=256, batch_size=256, gamma=0.97, seed=seed, device="cpu")
    model.learn(steps)
    path.parent.mkdir(parents=True, exist_ok=True)
    model.save(path)


class TrainedAgent:
    """A policy of `train`."""

    def __init__(self, model: Any) -> None:
        self.model = model

    def act(self, observation: Floats) -> Floats:
        """Return the most probable action."""
        return to_table(self.model.predict(scaled(observation), deterministic=True)[0])

    def see(self, action: Floats, observation: Floats) -> None:
        """Do nothing: the policy has no memory."""


def load(path: Path) -> TrainedAgent:
    """Return the agent of a policy file."""
    return TrainedAgent(require("stable_baselines3", "rl", "trained policies").PPO.load(path, device="cpu"))
