"""Figures of a comparison's document."""

from __future__ import annotations

import math
import textwrap
from typing import TYPE_CHECKING, Literal

import numpy as np

from trundle.experiments import figure_style
from trundle.experiments.comparison.config import Settings
from trundle.experiments.comparison.results import Curves, Results
from trundle.experiments.comparison.scores import time_to_success, untouched_success

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

__all__ = ["curves", "profiles", "successes"]

MAIN, ORACLE = figure_style.COLOURS["pbr"], "#20262e"
OTHERS = ("#c04a00", "#b0186f", "#2e8b57", "#8a6d00", "#6a4fbf", "#3a9bb8", "#e0a070", "#d58ab4", "#7d8791")
DASHES: dict[str, Literal["-", "--", "-.", ":"]] = {
    "adaptive": "-",
    "policy": "--",
    "dynamics": "-.",
    "oracle": ":",
}
"""Line styles by kind of agent."""
TITLE_WIDTH = 32
"""Number of characters in a line of a panel's title."""
PANELS_PER_ROW = 3
"""Number of panels in a row."""


def colours(settings: Settings) -> dict[str, str]:
    """Return a colour for each agent."""
    kinds = {name: agent.kind for name, agent in settings.agents.items()}
    others = [name for name, kind in kinds.items() if kind != "oracle" and name != settings.main]
    found = {name: OTHERS[k % len(OTHERS)] for k, name in enumerate(others)}
    return {name: found.get(name, ORACLE if kind == "oracle" else MAIN) for name, kind in kinds.items()}


def successes(settings: Settings, results: Results) -> Figure:
    """Draw the rate of success without touching of each agent in each group of worlds, with intervals."""
    figure, axes = panels(settings, results, 0.8 + 0.2 * max(map(len, results.values())))
    chosen = colours(settings)
    for one, group in zip(axes, results.values(), strict=True):
        for down, (agent, rows) in enumerate(group.items()):
            found = untouched_success(rows)
            one.plot([found.low, found.high], [down, down], color=chosen[agent], linewidth=1.6)
            one.plot(found.value, down, "o", color=chosen[agent], markersize=4.5)
        one.set_yticks(range(len(group)), [settings.agents[agent].title for agent in group])
        one.set(xlim=(-0.03, 1.03), ylim=(len(group) - 0.4, -0.6), xlabel="success without touching")
    return figure


def profiles(settings: Settings, results: Results) -> Figure:
    """Draw the share of solved worlds over time."""
    figure, axes = panels(settings, results, 2.6)
    chosen = colours(settings)
    shown: dict[str, Line2D] = {}
    for one, group in zip(axes, results.values(), strict=True):
        end = max(row["limit"] for rows in group.values() for row in rows)
        for agent, rows in group.items():
            times = sorted(time_to_success(row) for row in rows if row["success"])
            x, y = [0.0, *times, end], [*range(len(times) + 1), len(times)]
            (line,) = one.step(x, np.array(y) / len(rows), where="post", color=chosen[agent], linewidth=1.3)
            line.set_linestyle(DASHES[settings.agents[agent].kind])
            shown.setdefault(settings.agents[agent].title, line)
        one.set(xlim=(0.0, end), ylim=(0.0, 1.02), xlabel="time, s", ylabel="share solved")
    figure_style.legend(
        figure, handles=list(shown.values()), labels=list(shown), loc="outside lower center", ncols=3
    )
    return figure


def curves(settings: Settings, found: Curves) -> Figure:
    """Draw success during training against environment steps, a line for each run."""
    figure, (axes,) = figure_style.sheet(1, 1, (6.0, 3.4))
    chosen = colours(settings)
    for name, agent in settings.agents.items():
        for k, run in enumerate(found.get(agent.curve, [])):
            label = agent.title if k == 0 else None
            steps, rates = ([point[key] for point in run["curve"]] for key in ("step", "success"))
            axes.plot(np.array(steps) / 1e6, rates, color=chosen[name], linewidth=1.0, alpha=0.8, label=label)
    axes.set(ylim=(-0.02, 1.02), xlabel="million steps of the environment", ylabel="success in evaluation")
    figure_style.legend(axes)
    return figure


def panels(settings: Settings, results: Results, height: float) -> tuple[Figure, list[Axes]]:
    """Return a figure with a panel for each group of worlds, and their axes."""
    across = min(PANELS_PER_ROW, len(results))
    down = math.ceil(len(results) / across)
    figure, axes = figure_style.sheet(down, across, (0.6 + 4.0 * across, (0.6 + height) * down))
    for spare in axes[len(results) :]:
        spare.set_visible(False)
    for one, name in zip(axes, results, strict=False):
        one.set_title("\n".join(textwrap.wrap(settings.worlds[name].title, TITLE_WIDTH)), fontsize=9)
    return figure, axes[: len(results)]
