"""Run `trundle compare` from its settings file to its document."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from trundle.experiments.comparison.config import Settings, Trial, read
from trundle.experiments.comparison.document import write_document
from trundle.experiments.comparison.episode import begin, play_unit
from trundle.experiments.comparison.results import write_costs, write_results
from trundle.experiments.execution import Execution
from trundle.experiments.results import Row
from trundle.experiments.runner import Unit
from trundle.recording import TrundleError

__all__ = ["compare"]


def compare(config: Path, execution: Execution, count: int | None = None) -> str:
    """Run the unfinished episodes of a comparison, and write its results and its document.

    Parameters
    ----------
    config : Path
        Settings file.
    execution : Execution
        The document, the results and `images/` are in its folder `out`.
    count : int, optional
        Largest number of worlds of each group, from the first on.

    Returns
    -------
    str
        The document.

    Raises
    ------
    TrundleError
        If the file is invalid, or an episode cannot run.
    """
    settings = read(config)
    if count is not None:
        worlds = {name: replace(one, count=min(one.count, count)) for name, one in settings.worlds.items()}
        settings = replace(settings, worlds=worlds)
    if not execution.redraw:
        digests = policy_digests(settings)
        check_players(config, settings)
        found = play_all(settings, digests, execution)
        folder = execution.out / settings.name
        rows = {trial: one["row"] for trial, one in found.items()}
        write_results(folder / "results.jsonl", settings, digests, rows)
        write_costs(folder / "costs.json", {trial: one["cost"] for trial, one in found.items()})
    return write_document(execution.out, settings, config)


def policy_digests(settings: Settings) -> dict[str, str]:
    """Return the SHA-256 of each policy file in use."""
    playing = {name for worlds in settings.worlds.values() for name in worlds.agents}
    files = [file for name in settings.agents if name in playing for file in settings.agents[name].files]
    return {file: hashlib.sha256(Path(file).read_bytes()).hexdigest() for file in files}


def check_players(config: Path, settings: Settings) -> None:
    """Let every agent decide once in each group of worlds, so that errors appear before hours of work."""
    for name, worlds in settings.worlds.items():
        for agent in worlds.agents:
            try:
                for run in settings.agents[agent].runs:
                    env, observation, playing = begin(worlds, settings.agents[agent], run, worlds.first)
                    action, _ = playing.predict(observation, episode_start=True)
                    env.step(action)
            except TrundleError as error:
                raise TrundleError(f"{config}: {agent} in [worlds.{name}]: {error}") from error


def play_all(settings: Settings, digests: Mapping[str, str], execution: Execution) -> dict[Trial, Row]:
    """Run the episodes without a result; return each one's row and cost.

    All first worlds run before all second ones, so that a part is a comparison too.
    """
    order = sorted(settings.trials, key=lambda trial: trial.seed - settings.worlds[trial.worlds].first)
    units = [episode_unit(settings, digests, trial) for trial in order]
    results = dict(zip(order, execution.run(settings.name, "playing", units), strict=True))
    return {trial: results[trial] for trial in settings.trials}


def episode_unit(settings: Settings, digests: Mapping[str, str], trial: Trial) -> Unit:
    """Return the unit of an episode. Its key holds the digest of a policy, not the path of its file."""
    worlds, agent = settings.worlds[trial.worlds], settings.agents[trial.agent]
    file = agent.files[trial.run] if agent.files else None
    arguments = {"worlds": worlds.identity, "agent": agent.identity, "seed": trial.seed}
    arguments["digest"] = digests.get(file or "")
    files = {} if file is None else {"file": Path(file)}
    name = f"{trial.agent} in {trial.worlds}, seed {trial.seed}, run {trial.run}"
    return Unit(name, play_unit, arguments, files)
