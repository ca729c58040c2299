"""Run a random search from its file to its page."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from trundle._optional import require
from trundle.atomic import write_text
from trundle.experiments import versions
from trundle.experiments.comparison.config import Agent, Worlds
from trundle.experiments.comparison.episode import play_unit
from trundle.experiments.comparison.scores import is_untouched_success
from trundle.experiments.execution import Execution
from trundle.experiments.results import Row, rounded, write_lines
from trundle.experiments.runner import Unit
from trundle.experiments.search.config import (
    TRIAL_SEED,
    AgentTuning,
    agent_settings,
    read,
    training_table,
)
from trundle.experiments.search.page import page
from trundle.experiments.search.ranges import Search
from trundle.experiments.training.settings import Settings

__all__ = ["search"]


def search(config: Path, execution: Execution, device: str = "cpu") -> str:
    """Run the trials that have no result, and write `search/NAME.md`, `.jsonl` and `_costs.json`.

    Parameters
    ----------
    config : Path
        File of a training with a table `[search]`, or of the adaptive agent.
    execution : Execution
        `search/` is in its folder `out`.
    device : str
        Device of PyTorch.

    Returns
    -------
    str
        The page.

    Raises
    ------
    TrundleError
        If the file is invalid, or a trial fails.
    """
    settings, given, table = read(config)
    if isinstance(settings, AgentTuning):
        found = agent_rows(config, settings, execution)
    else:
        require("stable_baselines3", "rl", "trainings")
        require("sb3_contrib", "rl", "trainings")
        found = training_rows(table, settings, given, execution, device)
    rows = [{"trial": trial, "values": given.values(trial), **row} for trial, row in enumerate(found)]
    costs = [row.pop("cost_seconds") for row in rows]
    text = page(config, settings, given, rounded(rows))
    file = execution.out / "search" / settings.name
    spending = json.dumps({"cpu_seconds": rounded(costs)})
    write_lines(file.with_suffix(".jsonl"), rounded(rows))
    write_text(file.with_name(f"{settings.name}_costs.json"), spending + "\n")
    write_text(file.with_suffix(".md"), text)
    return text


def training_rows(
    table: dict[str, Any], settings: Settings, given: Search, execution: Execution, device: str
) -> list[Row]:
    """Return the results of the trainings of all trials."""
    from trundle.experiments.search.trial import training_trial

    # A finished training is not repeated, so that trainings of other code need another folder.
    folder = execution.work / f"{settings.name}_search" / versions.of_package()
    common = {"seed": TRIAL_SEED, "device": device}
    units = [
        Unit(
            f"trial {trial}",
            training_trial,
            {"table": training_table(table, settings, given, trial), **common},
            {"folder": folder},
        )
        for trial in range(given.trials + 1)
    ]
    found = execution.run(f"{settings.name}_search/units", settings.name, units)
    costs = [one.pop("cost") for one in found]
    return [{**one, "cost_seconds": cost["cpu_seconds"]} for one, cost in zip(found, costs, strict=True)]


def agent_rows(config: Path, tuning: AgentTuning, execution: Execution) -> list[Row]:
    """Return the results of the episodes of all trials. All trials have the same worlds."""
    given = tuning.search
    worlds = Worlds("", tuning.env, given.first, given.episodes, [], tuning.env_kwargs).identity
    units = []
    for trial in range(given.trials + 1):
        agent = Agent("", "adaptive", agent_settings(config, tuning, trial)).identity
        for seed in given.worlds:
            arguments = {"worlds": worlds, "agent": agent, "seed": seed, "digest": None}
            units.append(Unit(f"trial {trial}, seed {seed}", play_unit, arguments))
    found = execution.run(f"{tuning.name}_search/units", tuning.name, units)
    trials = [found[start : start + given.episodes] for start in range(0, len(found), given.episodes)]
    return [agent_row(trial, trials[0]) for trial in trials]


def agent_row(trial: Sequence[Row], first: Sequence[Row]) -> Row:
    """Return the results of the episodes of a trial, compared with those of trial 0 world by world."""
    episodes = [one["row"] for one in trial]
    returns, other = (np.array([one["row"]["return"] for one in part]) for part in (trial, first))
    gains = returns - other
    return {
        "score": float(returns.mean()),
        "return": float(returns.mean()),
        "gain": float(gains.mean()),
        "gain_error": float(gains.std(ddof=1) / math.sqrt(len(gains))) if len(gains) > 1 else None,
        "untouched": float(np.mean([is_untouched_success(row) for row in episodes])),
        "success": float(np.mean([row["success"] for row in episodes])),
        "lost": float(np.mean([row["lost"] for row in episodes])),
        "cost_seconds": float(sum(one["cost"]["total"] for one in trial)),
    }
