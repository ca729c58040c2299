"""The page of a random search."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import tomli_w

from trundle.experiments.markdown import prose, table
from trundle.experiments.results import Row
from trundle.experiments.search.config import AgentTuning
from trundle.experiments.search.ranges import Search
from trundle.experiments.training.settings import Settings

__all__ = ["page"]

NONE = "–"
RESULTS = {
    "return": ("return", "{:.2f}"),
    "gain": ("gain over trial 0", "{:+.2f}"),
    "gain_error": ("standard error", "{:.2f}"),
    "untouched": ("success without touching", "{:.0%}"),
    "success": ("success", "{:.0%}"),
    "lost": ("lost", "{:.0%}"),
    "distance": ("distance error, m", "{:.4f}"),
    "turn": ("turn error, rad", "{:.4f}"),
}
"""Title and format of each result that a trial may have."""


def page(config: Path, settings: Settings | AgentTuning, search: Search, rows: Sequence[Row]) -> str:
    """Return the page: all trials, the best first, and the settings of the best one.

    Parameters
    ----------
    config : Path
        File of the search, for the command.
    settings : Settings or AgentTuning
    search : Search
    rows : sequence of dict
        `trial`, `values`, `score` and results of each trial.
    """
    ordered = sorted(rows, key=lambda row: float(row["score"]), reverse=True)
    best = ordered[0]
    results = [key for key in RESULTS if key in best]
    head = ["trial", *(RESULTS[key][0] for key in results), *(f"`{key}`" for key in search.ranges)]
    lines = []
    for row in ordered:
        values = [str(row["values"].get(key, NONE)) for key in search.ranges]
        found = [NONE if row[key] is None else RESULTS[key][1].format(row[key]) for key in results]
        lines.append([str(row["trial"]), *found, *values])
    budget = ""
    if isinstance(settings, Settings):
        steps = round(search.share * settings.n_timesteps)
        budget = f" A trial trains for {steps:,} steps, {search.share:.0%} of the training."
    chosen = "\n".join(f"{key} = {toml_value(value)}" for key, value in best["values"].items())
    text = prose(
        "search",
        "main",
        name=settings.name,
        config=config.as_posix(),
        trials=search.trials,
        episodes=search.episodes,
        first=search.first,
        last=search.worlds[-1],
        env=settings.env,
        env_kwargs=settings.env_kwargs,
        budget=budget,
        table=table(head, lines),
        best=best["trial"],
        chosen=chosen or "# the settings of the file",
    )
    return text + "\n"


def toml_value(value: object) -> str:
    """Return a value as in a TOML file."""
    return tomli_w.dumps({"value": value}).removeprefix("value = ").strip()
