"""Run one episode of an agent in a world, and return its results."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

import trundle
from trundle.experiments.comparison.config import Agent, Worlds
from trundle.experiments.comparison.world import Env, boundary_points, make_world
from trundle.experiments.results import Row
from trundle.experiments.runs.episode import count_onsets
from trundle.experiments.training import policy
from trundle.experiments.training.dynamics import model as dynamics_model
from trundle.experiments.training.dynamics.learner import dynamics_agent
from trundle.recording import TrundleError

__all__ = ["begin", "play", "play_unit"]


def make_player(agent: Agent, run: int, env: Env) -> trundle.AdaptiveAgent | policy.Policy:
    """Return an agent for a world at the start of an episode.

    Parameters
    ----------
    agent : Agent
    run : int
        Number of the file of a policy or a dynamics model.
    env : gymnasium.Env
        The oracle reads its hidden model.
    """
    source: Any = env.unwrapped
    if agent.kind == "policy":
        loaded = policy.load(agent.files[run])
        trained = loaded.about.env_kwargs.get("action", "wrench")
        if trained != source.mode:
            raise TrundleError(
                f'{agent.files[run]} was trained with action = "{trained}", not "{source.mode}": see options'
            )
        return loaded
    if agent.kind == "dynamics":
        return dynamics_agent(env, dynamics_model.load(agent.files[run]))
    settings, model = agent.agent_settings, None
    if agent.kind == "oracle":
        model = trundle.Model.from_toml(tomli_w.dumps(source.hidden_model()))
        settings = replace(settings, adapt=False)
    return trundle.AdaptiveAgent(env, settings, model=model)


def begin(worlds: Worlds, agent: Agent, run: int, seed: int) -> tuple[Env, Any, Any]:
    """Return the environment of an episode, its first observation, and the agent.

    The observations of a privileged policy contain the hidden parameters.
    """
    env, observation = make_world(worlds, seed, agent.options)
    player = make_player(agent, run, env)
    if isinstance(player, policy.Policy) and player.about.hidden:
        revealing = trundle.envs.Oracle(env)
        return revealing, revealing.observation(observation), player
    return env, observation, player


def play(worlds: Worlds, agent: Agent, run: int, seed: int) -> tuple[Row, Row]:
    """Run one episode.

    Returns
    -------
    row : dict
        `success`, `lost`, `touches` (number of collisions with obstacles), `contact` (their duration, s),
        `seconds` (duration), `limit` (time limit, s), `return`, remaining `distance` (m) and `heading` (rad,
        absolute), `radius` of the object (m, from its origin to its farthest corner). For an adaptive agent
        also `fits`, `learning` (time of the last fit, s), `regrasps`, and the `named` effects in order. The
        same arguments give the same row.
    timing : dict
        `decisions`, and the CPU seconds of all decisions and of the longest one: `total`, `longest`.
    """
    env, observation, player = begin(worlds, agent, run, seed)
    source: Any = env.unwrapped
    state, over, gained = None, False, 0.0
    costs: list[float] = []
    touched: list[bool] = []
    while not over:
        began = time.process_time()
        action, state = player.predict(observation, state, episode_start=not costs)
        costs.append(time.process_time() - began)
        observation, reward, terminated, truncated, info = env.step(action)
        gained, over = gained + float(reward), terminated or truncated
        touched.append(info["touched"])
    row = {
        "success": bool(info["is_success"]),
        "lost": bool(info["lost"]),
        "touches": count_onsets(touched),
        "contact": float(info["contact_time"]),
        "seconds": source.control * len(costs),
        "limit": time_limit(env) * source.control,
        "return": gained,
        "distance": float(info["distance"]),
        "heading": abs(float(info["heading_error"])),
        "radius": float(np.hypot(*boundary_points(source.hidden_model()["body"]).T).max()),
        **learning_summary(player),
    }
    env.close()
    return row, {"decisions": len(costs), "total": sum(costs), "longest": max(costs)}


def time_limit(env: Env) -> int:
    """Return the number of steps after which an episode is truncated."""
    source: Any = env.unwrapped
    limits = (source.horizon, (env.spec and env.spec.max_episode_steps) or 0)
    return min(limit for limit in limits if limit)


def learning_summary(agent: Any) -> Row:
    """Return a summary of an adaptive agent's fits; zeros for other agents."""
    beliefs = getattr(agent, "beliefs", ())
    if not beliefs:
        return {"fits": 0, "learning": 0.0, "regrasps": 0, "named": []}
    updates = beliefs[0].updates
    return {
        "fits": beliefs[0].fits,
        "learning": updates[-1].time if updates else 0.0,
        "regrasps": sum(update.regrasp is not None for update in updates),
        "named": list(dict.fromkeys(name for update in updates for name in update.named)),
    }


def play_unit(
    worlds: dict[str, Any], agent: dict[str, Any], seed: int, digest: str | None, file: Path | None = None
) -> Row:
    """Run one episode as a unit of work.

    Parameters
    ----------
    worlds, agent : dict
        `Worlds.identity` and `Agent.identity`.
    seed : int
    digest : str, optional
        SHA-256 of the file of a policy or a dynamics model: part of the unit's key.
    file : Path, optional
        This file.
    """
    files = [] if file is None else [str(file)]
    group = Worlds(title="", first=seed, count=1, agents=[], **worlds)
    row, timing = play(group, Agent(title="", files=files, **agent), 0, seed)
    return {"row": row, "cost": timing}
