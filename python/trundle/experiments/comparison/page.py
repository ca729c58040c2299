"""The page of a comparison: its document, with figures as inline SVG."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from trundle.experiments import document
from trundle.experiments.comparison.config import Settings
from trundle.experiments.comparison.results import Curves, Results
from trundle.experiments.comparison.scores import time_to_success, untouched_success
from trundle.experiments.results import Row
from trundle.report.figures.canvas import WIDTH, Figure, figure, label
from trundle.report.figures.curves import Curve, Lane
from trundle.report.figures.data import Data
from trundle.report.figures.lanes import lane_figure
from trundle.report.svg import Child, tag

__all__ = ["render"]

Rows = Sequence[Row]

_LEFT, _RIGHT, _ROW, _TOP = 8.0, 52.0, 34.0, 6.0
"""Margins and row height of the figure of success rates, user units."""


def render(text: str, settings: Settings, results: Results, curves: Curves) -> str:
    """Render the page of a comparison from its Markdown document.

    Parameters
    ----------
    text
        The document.
    settings, results, curves
        Data of its figures.
    """
    figures = {
        f"images/{settings.name}_successes.png": [
            _successes(index, settings, name, group) for index, (name, group) in enumerate(results.items())
        ],
        f"images/{settings.name}_profiles.png": [
            _profiles(index, settings, name, group) for index, (name, group) in enumerate(results.items())
        ],
        f"images/{settings.name}_curves.png": _learning(settings, curves),
    }
    return document.render(text, figures, "Comparison of agents on the same hidden worlds")


def _successes(index: int, settings: Settings, name: str, group: Mapping[str, Rows]) -> Figure:
    """Return the rate of success without touching of each agent in a group, with intervals of 95 %."""
    rates = {settings.agents[agent].title: untouched_success(rows) for agent, rows in group.items()}
    width, height = WIDTH - _LEFT - _RIGHT, _ROW * len(rates)
    drawing: list[Child] = [_share_axis(width, height)]
    for row, (title, rate) in enumerate(rates.items()):
        y = _TOP + _ROW * (row + 0.7)
        low, middle, high = (_LEFT + width * share for share in (rate.low, rate.value, rate.high))
        drawing += [
            label(title, _LEFT, y - 9.0, "halo"),
            tag("line", x1=low, x2=high, y1=y, y2=y, class_="range"),
            tag("circle", cx=middle, cy=y, r=4.5, class_="point"),
            label(f"{100.0 * rate.value:.0f}\N{NO-BREAK SPACE}%", WIDTH - 2.0, y + 4.0, "tick", "end"),
        ]
    worlds = settings.worlds[name].title
    text = f"Success without touching of each agent in {worlds}: points with intervals of 95 %."
    rows = [(title, rate.value, rate.low, rate.high) for title, rate in rates.items()]
    data = Data(("agent", "success without touching", "lower bound of 95 %", "upper bound of 95 %"), rows)
    total = _TOP + height + 34.0
    return figure(
        f"success-{index}",
        f"Success without touching in {worlds}",
        text,
        total,
        drawing,
        (worlds, ""),
        data=data,
    )


def _share_axis(width: float, height: float) -> Child:
    """Return grid lines and labels of shares from 0 to 1."""
    bottom = _TOP + height
    lines = [
        [
            tag("line", x1=x, x2=x, y1=_TOP, y2=bottom, class_="grid"),
            label(f"{100.0 * share:.0f}", x, bottom + 15.0, "tick", "middle"),
        ]
        for share in (0.0, 0.5, 1.0)
        for x in (_LEFT + width * share,)
    ]
    return [*lines, label("success without touching, %", _LEFT + width, bottom + 30.0, "tick", "end")]


def _profiles(index: int, settings: Settings, name: str, group: Mapping[str, Rows]) -> Figure:
    """Return the share of solved worlds over time, a lane for each agent."""
    end = max(row["limit"] for rows in group.values() for row in rows)
    lanes = []
    for agent, rows in group.items():
        times = sorted(time_to_success(row) for row in rows if row["success"])
        t = np.repeat(np.array([0.0, *times, end]), 2)[1:]
        solved = np.repeat(np.arange(len(times) + 1) / len(rows), 2)
        curve = Curve("after", t, np.append(solved, solved[-1])[: len(t)])
        lanes.append(Lane(settings.agents[agent].title, (curve,), (0.0, 1.02), 40.0))
    worlds = settings.worlds[name].title
    text = f"Share of solved worlds over time in {worlds}, a lane for each agent."
    return lane_figure(
        f"profile-{index}", f"Solved worlds in {worlds}", text, lanes, (0.0, float(end)), (worlds, "")
    )


def _learning(settings: Settings, curves: Curves) -> list[Figure]:
    """Return success during training, a figure for each policy and a lane for each run."""
    found = []
    for index, (name, agent) in enumerate(settings.agents.items()):
        lanes = [
            Lane(f"run {number}", (Curve("after", steps / 1e6, rates),), (-0.02, 1.02), 40.0)
            for number, run in enumerate(curves.get(agent.curve, []))
            for steps, rates in [
                tuple(np.array([p[key] for p in run["curve"]], float) for key in ("step", "success"))
            ]
        ]
        if lanes:
            end = max(float(lane.curves[0].t[-1]) for lane in lanes)
            text = f"Success of {agent.title} in evaluations during training, a lane for each run."
            title, caption = f"Training of {agent.title}", (agent.title, ": success in evaluations.")
            found.append(
                lane_figure(
                    f"training-{index}-{name}", title, text, lanes, (0.0, end), caption, axis="million steps"
                )
            )
    return found
