"""What a search tunes: a training, or the settings of the adaptive agent."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import trundle
from trundle._native import TrundleError
from trundle.agent_settings import read_agent_settings
from trundle.experiments.search.ranges import Search, assigned, check_split
from trundle.experiments.training.config import ADAPTIVE, FORMAT, build
from trundle.experiments.training.settings import Settings, Task
from trundle.rules import EnvOptions
from trundle.settings import build_settings, parse_format

__all__ = ["AgentTuning", "agent_settings", "read", "training_table"]

TRIAL_SEED = 999
"""Seed of the training of every trial. No other training may have it."""


@dataclass(frozen=True, kw_only=True)
class AgentTuning:
    """Settings of a search for settings of `trundle.AdaptiveAgent`.

    Attributes
    ----------
    name : str
        By default the name of the file without its suffix.
    algorithm : {"Adaptive"}
    env : str
        The environment's id.
    env_kwargs : dict
        Arguments of the environment.
    agent : dict
        Fields of `trundle.AgentSettings`.
    search : Search
    """

    name: str
    algorithm: Literal["Adaptive"] = ADAPTIVE
    env: Task
    env_kwargs: EnvOptions = field(default_factory=dict)
    agent: dict[str, Any] = field(default_factory=dict)
    search: Search

    def __post_init__(self) -> None:
        check_split(self.env_kwargs)


def read(path: Path) -> tuple[Settings | AgentTuning, Search, dict[str, Any]]:
    """Read the file of a search, and check the settings of every trial.

    Returns
    -------
    settings : Settings or AgentTuning
    search : Search
    table : dict
        The parsed file without `[search]`.

    Raises
    ------
    TrundleError
        If a key is missing, unknown or of another type, a value is not allowed, or there is no `[search]`.
    """
    table = parse_format(path, FORMAT)
    if table.get("algorithm") == ADAPTIVE:
        tuning = build_settings(path, AgentTuning, {"name": path.stem, **table})
        for trial in range(tuning.search.trials + 1):
            agent_settings(path, tuning, trial)
        return tuning, tuning.search, table
    settings = build(path, table)
    search = settings.search
    if search is None:
        raise TrundleError(f"{path}: --search needs a table [search.ranges]")
    if TRIAL_SEED in settings.seeds:
        raise TrundleError(f"{path}: seeds: {TRIAL_SEED} is that of a search; choose another one")
    del table["search"]
    for trial in range(search.trials + 1):
        build(path, training_table(table, settings, search, trial))
    return settings, search, table


def agent_settings(path: Path, tuning: AgentTuning, trial: int) -> dict[str, Any]:
    """Return the checked settings of the agent in a trial."""
    settings = assigned(tuning.agent, tuning.search.values(trial))
    found = read_agent_settings(path, settings, "agent")
    try:
        trundle.Planner([-1.0] * 3, [1.0] * 3, **found.planner)
    except TrundleError as error:
        raise TrundleError(f"{path}: trial {trial}: {error}") from error
    return settings


def training_table(
    table: Mapping[str, Any], settings: Settings, search: Search, trial: int
) -> dict[str, Any]:
    """Return the file of the training of a trial: shorter, and evaluated at its end in the tuning worlds."""
    found = assigned(table, search.values(trial))
    steps = max(1, round(search.share * settings.n_timesteps))
    updates = getattr(settings, "n_updates", 0)
    every = steps
    if updates:
        every = found["n_updates"] = max(1, round(search.share * updates))
    found["evaluation"] = {"every": every, "first": search.first, "episodes": search.episodes}
    if "teacher" in found:
        found["teacher"] = found["teacher"].replace("{seed}", str(settings.seeds[0]))
    return {**found, "name": f"{settings.name}_{trial}", "n_timesteps": steps, "seeds": [TRIAL_SEED]}
