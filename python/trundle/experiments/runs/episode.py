"""Run one closed-loop episode and return its history as plain values."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable
from itertools import pairwise
from typing import Any

import gymnasium as gym
import numpy as np

import trundle
from trundle.envs.observation import Observation
from trundle.experiments.results import Row, rounded

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

__all__ = ["count_onsets", "play"]

FORMAT = "trundle-run-history/1"


def play(
    env: gym.Env[Any, Any], agent: trundle.AdaptiveAgent, seed: int, watch: Callable[[Row], None]
) -> Row:
    """Run one episode.

    Parameters
    ----------
    env : gymnasium.Env
        A pushing task of `trundle`, wrapped or not.
    agent : AdaptiveAgent
    seed : int
        Of the episode.
    watch : callable
        Called after each step with a row of the history, and with the belief's `update` if there is a new
        one.

    Returns
    -------
    dict
        `object` and `scene` as in recordings; `goal` (x, y m, heading rad; world frame), `control` (s between
        actions); `steps`, a row for each action; `updates`, the belief after each fit; `truth`, the tables of
        the hidden model; `outcome`. Poses and wrenches are measurements, distances are true.
    """
    source: Any = env.unwrapped
    observation, _ = env.reset(seed=seed)
    steps: list[Row] = []
    updates: list[Row] = []
    gained, over, info = 0.0, False, {"distance": None}
    belief, known = None, 0
    described = source.recording_metadata("episode")
    first = observation_row(observation)
    while not over:
        action, (now,) = agent.predict(observation, episode_start=not steps)
        known = known if now is belief else 0
        belief = now
        fresh = [update_row(each, len(steps) * source.control) for each in now.updates[known:]]
        known += len(fresh)
        updates += fresh
        observation, reward, terminated, truncated, info = env.step(action)
        gained, over = gained + float(reward), terminated or truncated
        outcome = {name: info[name] for name in ("distance", "heading_error", "touched")}
        at = (len(steps) + 1) * source.control
        steps.append(
            {
                "t": at,
                **observation_row(observation),
                **outcome,
                "action": list(action * source.ACTION_SCALE),
            }
        )
        watch({**steps[-1], "update": fresh[-1] if fresh else None})
    outcome = {name: info[name] for name in ("distance", "heading_error", "lost", "is_success")}
    ended = {
        "seconds": len(steps) * source.control,
        "return": gained,
        "touched": count_onsets(step["touched"] for step in steps),
    }
    kept: Row = rounded(
        {
            "format": FORMAT,
            "version": trundle.__version__,
            "seed": seed,
            "object": described["object"],
            "scene": described.get("scene", {}),
            "control": source.control,
            "first": first,
            "steps": steps,
            "updates": updates,
            "truth": source.hidden_model(),
            "outcome": {**outcome, **ended},
        }
    )
    return kept


def observation_row(observation: Any) -> Row:
    """Return pose, goal, wrench and grasp of an observation (see `trundle.envs.Push`); m, rad, N, N m."""
    fields = Observation(np.asarray(observation))
    return {
        "pose": list(fields.pose),
        "goal": list(fields.goal_pose),
        "wrench": list(fields.wrench),
        "grasp": list(fields.grasp),
    }


def update_row(update: Any, time: float) -> Row:
    """Return the belief from a time on, s; the model as the tables of its file."""
    return {
        "time": time,
        "estimate": [dict(entry) for entry in update.estimate],
        "named": list(update.named),
        "supposed": list(update.supposed),
        "regrasp": None if update.regrasp is None else list(update.regrasp),
        "model": None if update.model is None else tomllib.loads(update.model.to_toml()),
    }


def count_onsets(states: Iterable[bool]) -> int:
    """Return how often a condition becomes true."""
    return sum(now and not before for before, now in pairwise([False, *states]))
