"""Episodes on LockedWheel with a fixed model, the adaptive agent, or the true model."""

from __future__ import annotations

from typing import Any, NamedTuple

import gymnasium
import tomli_w

import trundle


class Episode(NamedTuple):
    """Duration (s) and return of an episode."""

    success: bool
    seconds: float
    reward: float


def truth(env: gymnasium.Env[Any, Any]) -> trundle.Model:
    """Return the hidden model of the environment."""
    source: Any = env.unwrapped
    return trundle.Model.from_toml(tomli_w.dumps(source.hidden_model()))


def play(seed: int, *, adapt: bool) -> Episode:
    """Play one episode."""
    env = gymnasium.make("trundle/LockedWheel-v0")
    observation, _ = env.reset(seed=seed)
    agent = trundle.AdaptiveAgent(env, trundle.AgentSettings(adapt=adapt))
    reward, steps, done = 0.0, 0, False
    info: dict[str, Any] = {}
    while not done:
        action, _ = agent.predict(observation)
        observation, gained, terminated, truncated, info = env.step(action)
        reward, steps, done = reward + float(gained), steps + 1, terminated or truncated
    return Episode(info["is_success"], 0.05 * steps, reward)
