"""Rollouts of agents in a pushing environment, for `trundle play`."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from trundle._native import TrundleError
from trundle._optional import require
from trundle.agent import AdaptiveAgent
from trundle.agent_settings import AgentSettings
from trundle.atomic import atomic_file
from trundle.experiments.training.policy import Policy, load

__all__ = ["Animation", "play", "select_agent"]

BUILT_IN_AGENTS = ("random", "adaptive")
"""Agents that need no policy file."""
RANDOM_ACTION_DURATION_S = 0.5
"""Duration of a random action, s. A force that changes faster hardly moves an object."""
MAX_RANDOM_ACTION = 0.4
"""Maximum entry of a random action. Larger forces throw light objects out of the arena."""


class Animation:
    """A GIF animation of an environment.

    Parameters
    ----------
    path : Path
        Output file with the suffix `.gif`, written atomically.

    Raises
    ------
    TrundleError
        If the suffix is another one, or the folder does not exist.
    """

    def __init__(self, path: Path) -> None:
        if path.suffix.lower() != ".gif":
            raise TrundleError(f"{path}: unknown suffix; use .gif for an animation")
        if not path.parent.is_dir():
            raise TrundleError(f"{path}: the folder {path.parent} does not exist")
        self._image = require("PIL.Image", "plots", "animations")
        self.path, self._period = path, 0.05
        self._frames: list[NDArray[np.uint8]] = []

    @property
    def length(self) -> int:
        """Number of frames."""
        return len(self._frames)

    def add_frame(self, env: gym.Env[Any, Any]) -> None:
        """Render the environment and append the frame."""
        self._frames.append(np.asarray(env.render()))
        self._period = 1 / env.metadata["render_fps"]

    def write(self) -> None:
        """Write the file."""
        first, *rest = [self._image.fromarray(frame).quantize(32) for frame in self._frames]
        with atomic_file(self.path) as part:
            first.save(part, "GIF", save_all=True, append_images=rest, duration=1000 * self._period, loop=0)


def select_agent(agent: str) -> str | Policy:
    """Return the name of a built-in agent, or load a trained policy from its file.

    Raises
    ------
    TrundleError
        If `agent` is neither.
    """
    if agent in BUILT_IN_AGENTS:
        return agent
    if not agent.endswith(".npz"):
        raise TrundleError(
            f"--agent {agent}: choose {', '.join(BUILT_IN_AGENTS)} or the .npz file of a policy"
        )
    return load(agent)


def play(
    env: gym.Env[Any, Any], agent: str | Policy, episodes: int, seed: int, animation: Animation | None = None
) -> Iterator[str]:
    """Run episodes and yield a line on the outcome of each.

    Parameters
    ----------
    env : gymnasium.Env
        A flat pushing environment.
    agent : {"random", "adaptive"} or Policy
        The agent, as `select_agent` returns it.
    episodes : int
        Number of episodes. The first is reset with `seed`, the others continue its random stream.
    seed : int
        Seed of the environment and of random actions.
    animation : Animation, optional
        Receives a frame at each step.
    """
    if episodes < 1:
        raise TrundleError(f"--episodes {episodes}: must be at least one")
    act = _policy_function(env, agent, seed)
    unwrapped: Any = env.unwrapped
    for number in range(episodes):
        observation, _ = env.reset(seed=seed if number == 0 else None)
        total_reward, steps, is_over = 0.0, 0, False
        info: dict[str, Any] = {}
        while not is_over:
            if animation:
                animation.add_frame(env)
            action = act(observation, steps)
            observation, reward, terminated, truncated, info = env.step(action)
            total_reward, steps, is_over = total_reward + float(reward), steps + 1, terminated or truncated
        if animation:
            animation.add_frame(env)
        yield _summary(info, total_reward, steps * unwrapped.control)


def _policy_function(env: gym.Env[Any, Any], agent: str | Policy, seed: int) -> Any:
    if isinstance(agent, Policy):
        return TrainedAgent(agent)
    if agent == "adaptive":
        adaptive = AdaptiveAgent(env, AgentSettings(seed=seed))
        return lambda observation, step: adaptive.predict(observation, episode_start=step == 0)[0]
    random = np.random.default_rng(seed)
    steps_per_action = max(1, round(RANDOM_ACTION_DURATION_S * env.metadata["render_fps"]))
    current: list[NDArray[np.float32]] = []
    shape = env.action_space.shape

    def act(_: Any, step: int) -> NDArray[np.float32]:
        if step % steps_per_action == 0:
            current[:] = [random.uniform(-MAX_RANDOM_ACTION, MAX_RANDOM_ACTION, shape).astype(np.float32)]
        return current[0]

    return act


class TrainedAgent:
    """A policy with its state in the current episode."""

    def __init__(self, policy: Policy) -> None:
        self._policy = policy
        self._state: Any = None

    def __call__(self, observation: Any, step: int) -> NDArray[np.float32]:
        """Return the next action."""
        action, self._state = self._policy.predict(observation, self._state, episode_start=step == 0)
        return action


def _summary(info: dict[str, Any], total_reward: float, seconds: float) -> str:
    end = "goal reached" if info["is_success"] else "object lost" if info["lost"] else "time up"
    return f"{end} after {seconds:.1f} s, {info['distance']:.2f} m off, return {total_reward:.2f}"
