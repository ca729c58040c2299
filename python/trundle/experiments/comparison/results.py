"""Results of a comparison: the definitions, then the episodes of each agent in each group, by column."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from statistics import median_high
from typing import Any

import trundle
from trundle.atomic import read_json, write_text
from trundle.experiments.comparison.config import Settings, Trial
from trundle.experiments.results import Row, read_headed
from trundle.recording import TrundleError

__all__ = ["Curves", "Results", "read_costs", "read_curves", "read_results", "write_costs", "write_results"]

Results = dict[str, dict[str, list[Row]]]
"""Rows by worlds and agent; without agents that have no episode."""
Curves = Mapping[str, list[Row]]
"""Learning curves of `trundle train` by training, in the order of their seeds."""
CURVE_KEYS = ("config", "seed", "simulated_seconds", "parameters", "flattened", "curve")


def write_results(
    path: Path, settings: Settings, digests: Mapping[str, str], rows: Mapping[Trial, Row]
) -> None:
    """Write the results, a line for each agent in each group; the same episodes give the same bytes."""
    lines: dict[tuple[str, str, int], dict[str, Any]] = {}
    for trial, row in rows.items():
        columns: dict[str, Any] = {name: [] for name in ("seed", *row)}
        line = lines.setdefault(trial[:3], trial._asdict() | columns)
        for name, value in {"seed": trial.seed, **row}.items():
            line[name].append(int(value) if isinstance(value, bool) else value)
    head = {"settings": definitions(settings), "policies": dict(digests), "trundle": trundle.__version__}
    text = "".join(json.dumps(line, separators=(",", ":")) + "\n" for line in [head, *lines.values()])
    write_text(path, text)


def read_results(path: Path, settings: Settings) -> Results:
    """Return the rows by worlds and agent, in the order of the settings.

    Raises
    ------
    TrundleError
        If there are no results, or their worlds or agents are defined differently.
    """
    found, lines = read_headed(path, ("worlds", "agent", "run"))
    for part, defined in definitions(settings).items():
        if not isinstance(found.get(part), dict):
            raise TrundleError(f"{path}: not results of a comparison: run without --redraw")
        for name, one in defined.items():
            if found[part].get(name, one) != one:
                raise TrundleError(
                    f"{path}: [{part}.{name}] differs from the given settings file: run without --redraw"
                )
    by_agent: dict[tuple[str, str], list[Row]] = {}
    for line in lines:
        by_agent.setdefault((line["worlds"], line["agent"]), []).extend(expand_rows(line))
    results = {
        name: {agent: by_agent[name, agent] for agent in worlds.agents if (name, agent) in by_agent}
        for name, worlds in settings.worlds.items()
    }
    return {name: group for name, group in results.items() if group}


def expand_rows(line: Row) -> list[Row]:
    """Return a row for each episode of a line."""
    names = [name for name, value in line.items() if isinstance(value, list)]
    episodes = zip(*(line[name] for name in names), strict=True)
    return [{**line, **dict(zip(names, episode, strict=True))} for episode in episodes]


def definitions(settings: Settings) -> dict[str, dict[str, Any]]:
    """Return the definitions of worlds and agents as JSON values."""
    both = {
        "worlds": {name: worlds.identity for name, worlds in settings.worlds.items()},
        "agents": {name: {**agent.identity, "files": agent.files} for name, agent in settings.agents.items()},
    }
    found: dict[str, dict[str, Any]] = json.loads(json.dumps(both))
    return found


def write_costs(path: Path, timings: Mapping[Trial, Row]) -> None:
    """Write the measured costs of decisions of each agent in each group of worlds."""
    groups: dict[str, list[Row]] = {}
    for trial, timing in timings.items():
        groups.setdefault(f"{trial.worlds}/{trial.agent}", []).append(timing)
    costs = {}
    for name, group in groups.items():
        decisions = sum(one["decisions"] for one in group)
        costs[name] = {
            "episodes": len(group),
            "decisions": decisions,
            "mean_ms": round(1e3 * sum(one["total"] for one in group) / decisions, 3),
            "longest_ms": round(1e3 * median_high(one["longest"] for one in group), 3),
        }
    write_text(path, json.dumps(costs, indent=1) + "\n")


def read_costs(path: Path) -> dict[str, dict[str, float]]:
    """Return the costs by `worlds/agent`; empty without a file."""
    found: dict[str, dict[str, float]] = read_json(path) if path.exists() else {}
    return found


def read_curves(folder: Path) -> Curves:
    """Return the learning curves in a folder, with `cpu_seconds` from `timing/` next to it.

    Raises
    ------
    TrundleError
        If a file is not a learning curve.
    """
    found: dict[str, list[Row]] = {}
    for path in sorted(folder.glob("*.json")):
        curve, timing = read_json(path), folder.parent / "timing" / path.name
        if not isinstance(curve, dict) or not curve.keys() >= set(CURVE_KEYS):
            keys = ", ".join(CURVE_KEYS)
            raise TrundleError(f"{path}: not a learning curve of `trundle train`, which has the keys {keys}")
        seconds = read_json(timing)["cpu_seconds"] if timing.exists() else math.nan
        found.setdefault(curve["config"], []).append({**curve, "cpu_seconds": seconds})
    return {name: sorted(curves, key=lambda one: int(one["seed"])) for name, curves in found.items()}
