"""What learning is worth to the agent, and what it costs: success and time over hidden wheels.

python benches/adaptive_agent.py --episodes 20

The same planner pushes the same tables with three beliefs: one that it keeps (a table that rolls freely), one
that it fits as it goes, and the truth, which no agent can know.
"""

from __future__ import annotations

import argparse
from time import perf_counter
from typing import Any, NamedTuple

import gymnasium
import numpy as np
import tomli_w

import trundle

MASS = 22.0
"""Of the table, kg, as the environment's description has it."""
AGENTS = ("no adaptation", "adaptation", "oracle")


class Episode(NamedTuple):
    """How an episode went."""

    success: bool
    seconds: float
    reward: float
    computing: float


def truth(env: gymnasium.Env[Any, Any]) -> trundle.Model:
    """Return the model that the environment hides."""
    source: Any = env.unwrapped
    return trundle.Model.from_toml(tomli_w.dumps(source.hidden_model()))


def play(kind: str, seed: int) -> Episode:
    """Let one of the agents play one episode."""
    env = gymnasium.make("trundle/LockedWheel-v0")
    observation, _ = env.reset(seed=seed)
    model = truth(env) if kind == "oracle" else None
    agent = trundle.AdaptiveAgent(env, model=model, mass=MASS, adapt=kind == "adaptation")
    reward, steps, done, computing = 0.0, 0, False, 0.0
    while not done:
        begun = perf_counter()
        action, _ = agent.predict(observation)
        computing += perf_counter() - begun
        observation, gained, terminated, truncated, info = env.step(action)
        reward, steps, done = reward + float(gained), steps + 1, terminated or truncated
    return Episode(info["is_success"], 0.05 * steps, reward, computing)


def main() -> None:
    parser = argparse.ArgumentParser(description="What learning is worth to the agent.")
    parser.add_argument("--episodes", type=int, default=20)
    count = parser.parse_args().episodes
    print(f"{count} hidden wheels, seeds 0 to {count - 1}; mean and its standard error")
    print(f"{'':14}  success  episode, s    return          computing, s per s")
    for kind in AGENTS:
        episodes = [play(kind, seed) for seed in range(count)]
        success, seconds, reward, computing = np.array(episodes, dtype=float).T
        error = [np.std(x, ddof=1) / np.sqrt(count) for x in (seconds, reward)]
        print(
            f"{kind:14}  {success.mean():7.0%}  {seconds.mean():5.2f} ± {error[0]:4.2f}  "
            f"{reward.mean():6.2f} ± {error[1]:4.2f}   {computing.sum() / seconds.sum():.2f}"
        )


if __name__ == "__main__":
    main()
