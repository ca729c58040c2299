"""Episodes of a pushing environment, one after another."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from trundle._native import TrundleError
from trundle.agent import AdaptiveAgent
from trundle.atomic import atomic_file
from trundle.experiments.training.policy import Policy, load

__all__ = ["Animation", "play", "select_agent"]

BUILT_IN_AGENTS = ("random", "adaptive")
"""Agents that need no file."""
RANDOM_ACTION_DURATION_S = 0.5
"""Time for which a random action is kept, s: a force that changes faster moves nothing."""
MAX_RANDOM_ACTION = 0.4
"""Largest entry of a random action: with more, light things fly."""


class Animation:
    """Pictures that become an animation.

    Parameters
    ----------
    path : Path
        A `.gif`; it is written whole or not at all.

    Raises
    ------
    TrundleError
        If it is to be another kind of file.
    """

    def __init__(self, path: Path) -> None:
        if path.suffix.lower() != ".gif":
            raise TrundleError(f"{path}: an animation is a .gif")
        if not path.parent.is_dir():
            raise TrundleError(f"{path.parent}: there is no such folder to write {path.name} to")
        self.path, self._frames, self._period = path, [], 0.05

    _frames: list[NDArray[np.uint8]]

    @property
    def length(self) -> int:
        """How many pictures there are."""
        return len(self._frames)

    def shoot(self, env: gym.Env[Any, Any]) -> None:
        """Take a picture of the environment as it is now."""
        self._frames.append(np.asarray(env.render()))
        self._period = 1 / env.metadata["render_fps"]

    def write(self) -> None:
        """Write the animation."""
        from PIL import Image

        first, *rest = [Image.fromarray(frame).quantize(32) for frame in self._frames]
        with atomic_file(self.path) as part:
            first.save(part, "GIF", save_all=True, append_images=rest, duration=1000 * self._period, loop=0)


def select_agent(agent: str) -> str | Policy:
    """Return who plays: the name of one of trundle's own, or a trained policy from its file.

    Raises
    ------
    TrundleError
        If it is neither.
    """
    if agent in BUILT_IN_AGENTS:
        return agent
    if not agent.endswith(".npz"):
        raise TrundleError(f"--agent {agent}: choose {', '.join(BUILT_IN_AGENTS)} or a policy's file.npz")
    return load(agent)


def play(
    env: gym.Env[Any, Any], agent: str | Policy, episodes: int, seed: int, film: Animation | None = None
) -> Iterator[str]:
    """Play episodes and yield how each ended, in a line.

    Parameters
    ----------
    env : gymnasium.Env
        A flat pushing environment.
    agent : {"random", "adaptive"} or Policy
        Who plays; `chosen` returns it.
    episodes : int
        How many; the first begins from `seed`, the others go on from there.
    seed : int
        Of the environment and of random actions.
    film : Film, optional
        Takes a picture of each step.
    """
    if episodes < 1:
        raise TrundleError(f"--episodes {episodes}: at least one")
    act = _policy_function(env, agent, seed)
    unwrapped: Any = env.unwrapped
    for number in range(episodes):
        observation, _ = env.reset(seed=seed if number == 0 else None)
        gained, steps, over = 0.0, 0, False
        info: dict[str, Any] = {}
        while not over:
            if film:
                film.shoot(env)
            action = act(observation, steps)
            observation, reward, terminated, truncated, info = env.step(action)
            gained, steps, over = gained + float(reward), steps + 1, terminated or truncated
        if film:
            film.shoot(env)
        yield _summary(info, gained, steps * unwrapped.control)


def _policy_function(env: gym.Env[Any, Any], agent: str | Policy, seed: int) -> Any:
    if isinstance(agent, Policy):
        return TrainedAgent(agent)
    if agent == "adaptive":
        adaptive = AdaptiveAgent(env, seed=seed)
        return lambda seen, step: adaptive.predict(seen, episode_start=step == 0)[0]
    random = np.random.default_rng(seed)
    held = max(1, round(RANDOM_ACTION_DURATION_S * env.metadata["render_fps"]))
    kept: list[NDArray[np.float32]] = []
    shape = env.action_space.shape

    def act(_: Any, step: int) -> NDArray[np.float32]:
        if step % held == 0:
            kept[:] = [random.uniform(-MAX_RANDOM_ACTION, MAX_RANDOM_ACTION, shape).astype(np.float32)]
        return kept[0]

    return act


class TrainedAgent:
    """A policy with what it has seen of the episode."""

    def __init__(self, policy: Policy) -> None:
        self._policy = policy
        self._state: Any = None

    def __call__(self, seen: Any, step: int) -> NDArray[np.float32]:
        """Return the next action."""
        action, self._state = self._policy.predict(seen, self._state, episode_start=step == 0)
        return action


def _summary(info: dict[str, Any], gained: float, seconds: float) -> str:
    end = "goal reached" if info["is_success"] else "object lost" if info["lost"] else "time up"
    return f"{end} after {seconds:.1f} s, {info['distance']:.2f} m off, return {gained:.2f}"
