"""Results of a comparison: the definitions, then the episodes of each agent in each group, by column."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import trundle
from trundle.atomic import write_text
from trundle.experiments.comparison.config import Settings
from trundle.experiments.results import Row, read_headed
from trundle.recording import TrundleError

__all__ = ["Results", "Trial", "read_costs", "read_results", "write_costs", "write_results"]

Trial = tuple[str, str, int, int]
"""Worlds, agent, training run, seed."""
Results = dict[str, dict[str, list[Row]]]
"""Rows by worlds and agent."""


def write_results(
    path: Path, settings: Settings, digests: Mapping[str, str], rows: Mapping[Trial, Row]
) -> None:
    """Write the results, a line for each agent in each group; the same episodes give the same bytes."""
    columns: dict[tuple[str, str, int], dict[str, list[Any]]] = {}
    for (worlds, agent, run, seed), row in rows.items():
        mine = columns.setdefault((worlds, agent, run), {})
        for name, value in {"seed": seed, **row}.items():
            mine.setdefault(name, []).append(int(value) if isinstance(value, bool) else value)
    head = {"settings": definitions(settings), "policies": dict(digests), "trundle": trundle.__version__}
    names = ("worlds", "agent", "run")
    lines = [head, *({**dict(zip(names, key, strict=True)), **mine} for key, mine in columns.items())]
    write_text(path, "".join(json.dumps(line, separators=(",", ":")) + "\n" for line in lines))


def read_results(path: Path, settings: Settings) -> Results:
    """Return the rows by worlds and agent, in the order of the settings.

    Raises
    ------
    TrundleError
        If there are no results, or their worlds or agents are defined differently.
    """
    found, lines = read_headed(path, ("worlds", "agent", "run"))
    if not all(isinstance(found.get(part), dict) for part in ("worlds", "agents")):
        raise TrundleError(f"{path}: not results of a comparison: run without --redraw")
    wanted = definitions(settings)
    for part in ("worlds", "agents"):
        for name, one in wanted[part].items():
            if name in found[part] and found[part][name] != one:
                raise TrundleError(
                    f"{path}: [{part}.{name}] differs from the given settings file: run without --redraw"
                )
    results: Results = {name: {agent: [] for agent in w.agents} for name, w in settings.worlds.items()}
    for line in lines:
        kept = results.get(line["worlds"], {}).get(line["agent"])
        if kept is not None:
            kept += expand_rows(line)
    return results


def expand_rows(line: Row) -> list[Row]:
    """Return a row for each episode of a line."""
    names = [name for name, value in line.items() if isinstance(value, list)]
    episodes = zip(*(line[name] for name in names), strict=True)
    return [{**line, **dict(zip(names, episode, strict=True))} for episode in episodes]


def definitions(settings: Settings) -> dict[str, Any]:
    """Return the definitions of worlds and agents as JSON values."""
    whole = {
        "worlds": {name: worlds.identity for name, worlds in settings.worlds.items()},
        "agents": {name: {**agent.identity, "files": agent.files} for name, agent in settings.agents.items()},
    }
    found: dict[str, Any] = json.loads(json.dumps(whole))
    return found


def write_costs(path: Path, timings: Mapping[Trial, Row]) -> None:
    """Write the measured costs of decisions of each agent in each group of worlds."""
    sums: dict[str, dict[str, Any]] = {}
    for (worlds, agent, _, _), timing in timings.items():
        one = sums.setdefault(f"{worlds}/{agent}", {"decisions": 0, "total": 0.0, "longest": []})
        one["decisions"] += timing["decisions"]
        one["total"] += timing["total"]
        one["longest"].append(timing["longest"])
    told = {
        name: {
            "episodes": len(one["longest"]),
            "decisions": one["decisions"],
            "mean_ms": round(1e3 * one["total"] / one["decisions"], 3),
            "longest_ms": round(1e3 * sorted(one["longest"])[len(one["longest"]) // 2], 3),
        }
        for name, one in sums.items()
    }
    write_text(path, json.dumps(told, indent=1) + "\n")


def read_costs(path: Path) -> dict[str, dict[str, float]]:
    """Return the costs by `worlds/agent`; empty without a file."""
    found: dict[str, dict[str, float]] = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    return found
