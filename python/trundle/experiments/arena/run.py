"""Play agents in the same hidden worlds of the arena, and compare their scores."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from trundle.experiments.arena.agents import AGENTS, make_agent
from trundle.experiments.arena.world import make
from trundle.experiments.backends import Backend
from trundle.experiments.markdown import table
from trundle.experiments.results import Row
from trundle.experiments.runner import Runner, Unit
from trundle.experiments.sampling import Floats
from trundle.experiments.statistics import difference, share
from trundle.experiments.versions import of_module

__all__ = ["EARLY_ACTIONS", "play", "summary", "tournament"]

EARLY_ACTIONS = 60
"""Coverage is reported after so many of the benchmark's 300 actions too: most agents succeed in the end."""


def play(agent: str, physics: str, seed: int, digest: str = "", policy: Path | None = None) -> Row:
    """Play one episode. The seed determines start, hidden parameters and the agent's random numbers.

    Returns
    -------
    dict
        `coverage` and `early`, the largest of the episode and of its first `EARLY_ACTIONS`; `success`;
        `actions`; `hidden`.
    """
    env = make(physics)
    observation, _ = env.reset(seed=seed)
    player = make_agent(agent, env.hidden, physics, observation, seed, policy)
    covered: list[float] = []
    terminated = truncated = False
    while not (terminated or truncated):
        action = player.act(observation)
        observation, _, terminated, truncated, info = env.step(action)
        player.see(action, observation)
        covered.append(float(info["coverage"]))
    return {
        **{"agent": agent, "physics": physics, "seed": seed, "hidden": asdict(env.hidden)},
        **{"coverage": max(covered), "early": max(covered[:EARLY_ACTIONS])},
        **{"success": bool(terminated), "actions": len(covered)},
    }


def tournament(
    physics: str, agents: Sequence[str], seeds: Sequence[int], work: Path, backend: Backend
) -> list[Row]:
    """Play the episodes that have no result in the folder `work`, and return all rows.

    The policy of the agent "ppo" is `work/ppo-PHYSICS.zip`.

    Raises
    ------
    TrundleError
        If gym-pusht or the policy is missing.
    """
    file = work / f"ppo-{physics}.zip"
    units = []
    for seed in seeds:
        for agent in agents:
            arguments: dict[str, Any] = {"agent": agent, "physics": physics, "seed": seed}
            folders: dict[str, Path] = {}
            if agent == "ppo" and file.exists():
                arguments["digest"] = hashlib.sha256(file.read_bytes()).hexdigest()
                folders = {"policy": file}
            units.append(Unit(f"{agent}, {physics}, seed {seed}", play, arguments, folders))
    return Runner(work / physics, of_module("arena/run"), backend).run(f"arena, {physics}", units)


def summary(rows: Sequence[Row]) -> str:
    """Return the table of a physics: scores, and differences to the oracle in the same worlds."""
    found = {name: [row for row in rows if row["agent"] == name] for name in AGENTS}
    lines = []
    for name, own in found.items():
        if not own:
            continue
        gaps = ["–", "–", "–"]
        if name != "oracle" and found["oracle"]:
            gaps = [
                difference(column(own, key), column(found["oracle"], key)).text(form)
                for key, form in (("coverage", "+.3f"), ("early", "+.3f"), ("actions", "+.0f"))
            ]
        means = [f"{column(own, key).mean():.3f}" for key in ("coverage", "early")]
        lines.append(
            [name, share(row["success"] for row in own).text(), means[0], gaps[0], means[1], gaps[1]]
        )
        lines[-1] += [f"{column(own, 'actions').mean():.0f}", gaps[2]]
    head = ["agent", "success", "coverage", "minus oracle", f"coverage in {EARLY_ACTIONS} actions"]
    return table([*head, "minus oracle", "actions", "minus oracle"], lines)


def column(rows: Sequence[Row], key: str) -> Floats:
    """Return a result of all worlds (worlds, 1), in the order of their seeds."""
    ordered = sorted(rows, key=lambda row: int(row["seed"]))
    return np.array([[float(row[key])] for row in ordered])
