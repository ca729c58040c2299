"""Figures of a comparison's document."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np

from trundle.experiments import figure_style
from trundle.experiments.comparison.config import Settings
from trundle.experiments.comparison.curves import Curve
from trundle.experiments.comparison.results import Results
from trundle.experiments.comparison.scores import success, time_to_success

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

__all__ = ["curves", "profiles", "successes"]

MAIN, ORACLE = figure_style.COLOURS["pbr"], "#20262e"
OTHERS = ("#c04a00", "#b0186f", "#2e8b57", "#8a6d00", "#6a4fbf", "#3a9bb8", "#e0a070", "#d58ab4", "#7d8791")
DASHES: dict[str, Literal["-", "--", ":"]] = {"adaptive": "-", "policy": "--", "oracle": ":"}
"""Line styles by kind of agent."""
PANELS_PER_ROW = 3
"""Number of panels in a row."""


def colours(settings: Settings) -> dict[str, str]:
    """Return a colour for each agent."""
    kinds = {name: agent.kind for name, agent in settings.agents.items()}
    others = [name for name, kind in kinds.items() if kind != "oracle" and name != settings.main]
    found = {name: OTHERS[k % len(OTHERS)] for k, name in enumerate(others)}
    return {name: found.get(name, ORACLE if kind == "oracle" else MAIN) for name, kind in kinds.items()}


def successes(path: Path, settings: Settings, results: Results) -> None:
    """Draw the success rate of each agent in each group of worlds, with intervals."""
    playing = {name: [agent for agent, rows in group.items() if rows] for name, group in results.items()}
    figure, axes = panels(len(results), 0.8 + 0.2 * max(map(len, playing.values())))
    chosen = colours(settings)
    for one, (name, agents) in zip(axes, playing.items(), strict=True):
        for down, agent in enumerate(agents):
            found = success(results[name][agent])
            one.plot([found.low, found.high], [down, down], color=chosen[agent], linewidth=1.6)
            one.plot(found.value, down, "o", color=chosen[agent], markersize=4.5)
        one.set_yticks(range(len(agents)), [settings.agents[agent].title for agent in agents])
        one.set(xlim=(-0.03, 1.03), ylim=(len(agents) - 0.4, -0.6), xlabel="success")
        one.set_title(wrap_title(settings.worlds[name].title), fontsize=9)
    figure_style.save(figure, path)


def profiles(path: Path, settings: Settings, results: Results) -> None:
    """Draw the share of solved worlds over time."""
    figure, axes = panels(len(results), 2.6)
    chosen = colours(settings)
    shown: dict[str, Line2D] = {}
    for one, (name, group) in zip(axes, results.items(), strict=True):
        end = max(row["limit"] for rows in group.values() for row in rows)
        for agent, rows in group.items():
            if rows:
                times = sorted(time_to_success(row) for row in rows if row["success"])
                x, y = [0.0, *times, end], [*range(len(times) + 1), len(times)]
                line = one.step(x, np.array(y) / len(rows), where="post", color=chosen[agent], linewidth=1.3)[
                    0
                ]
                line.set_linestyle(DASHES[settings.agents[agent].kind])
                shown.setdefault(settings.agents[agent].title, line)
        one.set(xlim=(0.0, end), ylim=(0.0, 1.02), xlabel="time, s", ylabel="share solved")
        one.set_title(wrap_title(settings.worlds[name].title), fontsize=9)
    figure.legend(
        list(shown.values()), list(shown), loc="outside lower center", ncols=3, fontsize=8, frameon=False
    )
    figure_style.save(figure, path)


def curves(path: Path, settings: Settings, found: Mapping[str, Sequence[Curve]]) -> None:
    """Draw success during training against environment steps, a line for each run."""
    figure, (axes,) = figure_style.sheet(1, 1, (6.0, 3.4))
    chosen = colours(settings)
    for name, agent in settings.agents.items():
        for k, curve in enumerate(found.get(agent.curve, [])):
            label = agent.title if k == 0 else None
            axes.plot(curve.steps, curve.success, color=chosen[name], linewidth=1.0, alpha=0.8, label=label)
    axes.set(xscale="log", ylim=(-0.02, 1.02))
    axes.set(xlabel="steps of the environment", ylabel="success in evaluation")
    axes.legend(fontsize=8, frameon=False)
    figure_style.save(figure, path)


def panels(count: int, height: float) -> tuple[Figure, list[Axes]]:
    """Return a figure with `count` panels, and their axes."""
    across = min(PANELS_PER_ROW, count)
    down = math.ceil(count / across)
    figure, axes = figure_style.sheet(down, across, (0.6 + 4.0 * across, (0.6 + height) * down))
    for spare in axes[count:]:
        spare.set_visible(False)
    return figure, axes[:count]


def wrap_title(title: str) -> str:
    """Return a title broken into lines."""
    return "\n".join(textwrap.wrap(title, 40))
