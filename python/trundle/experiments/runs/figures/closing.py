"""Error of the estimated wheel and radius of its 95 % ellipse over time, on a logarithmic scale."""

from __future__ import annotations

import math

import numpy as np

from trundle.experiments.runs.figures.marks import WITHIN_95
from trundle.experiments.runs.history import Episode, Update
from trundle.report.figures.canvas import WIDTH, figure, label, polyline, ticks
from trundle.report.markup import Html, join, tag
from trundle.report.quantity import display_scale

__all__ = ["draw"]

LEFT, RIGHT, TOP, HEIGHT, FOOT = 50.0, 12.0, 18.0, 150.0, 34.0
MAX_RADIUS_M = 1.0
"""Radius drawn for an unknown position."""


def draw(identity: str, episode: Episode) -> Html | None:
    """Return the figure; None without a true or an estimated wheel."""
    found = [u for u in episode.updates if episode.off(u) is not None and radius(u) is not None]
    if not found:
        return None
    offs = np.array([episode.off(update) for update in found], dtype=float)
    radii = np.array([radius(update) for update in found], dtype=float)
    low = math.floor(math.log10(max(1e-4, min(offs.min(), radii.min()))))
    frame = Frame(float(episode.t[-1]), low, 0)
    time = np.array([update.time for update in found])
    steps = np.append(np.repeat(time, 2)[1:], episode.t[-1])
    drawing = [
        label("distance from the true wheel", LEFT, TOP - 5.0, "lane"),
        tag("rect", x=LEFT, y=TOP, width=WIDTH - LEFT - RIGHT, height=HEIGHT, class_="box"),
        frame.axes(),
        polyline(np.column_stack([frame.x(steps), frame.y(np.repeat(radii, 2))]), "believed"),
        [
            tag("circle", cx=x, cy=y, r=3.6, class_="off")
            for x, y in zip(frame.x(time), frame.y(offs), strict=True)
        ],
    ]
    caption = "Line: radius of the 95 % ellipse; points: error of the estimate."
    name = "Accuracy of the wheel's position"
    return figure(f"{identity}-closing", name, f"{name}. {caption}", TOP + HEIGHT + FOOT, drawing, caption)


def radius(update: Update) -> float | None:
    """Return the longer half axis of the 95 % ellipse, m."""
    if update.wheel_covariance is None:
        return None
    if not np.isfinite(update.wheel_covariance).all():
        return MAX_RADIUS_M
    return WITHIN_95 * math.sqrt(max(float(np.linalg.eigvalsh(update.wheel_covariance)[-1]), 0.0))


class Frame:
    """Axes with linear time and logarithmic distance."""

    def __init__(self, end: float, low: int, high: int) -> None:
        self._end, self._low, self._high = end, low, high

    def x(self, time: np.ndarray) -> np.ndarray:
        """Return the horizontal position of a time."""
        place: np.ndarray = LEFT + (WIDTH - LEFT - RIGHT) * time / self._end
        return place

    def y(self, metres: np.ndarray) -> np.ndarray:
        """Return the vertical position of a distance."""
        power = np.log10(np.clip(metres, 10.0**self._low, 10.0**self._high))
        place: np.ndarray = TOP + HEIGHT * (self._high - power) / (self._high - self._low)
        return place

    def axes(self) -> Html:
        """Return the grid lines and labels."""
        parts: list[Html] = []
        for power in range(self._low, self._high + 1):
            metres = 10.0**power
            y = float(self.y(np.array([metres]))[0])
            parts.append(tag("line", x1=LEFT, x2=WIDTH - RIGHT, y1=y, y2=y, class_="grid"))
            parts.append(
                label(display_scale("m", metres).text(metres, 1), LEFT - 5.0, y + 4.0, "tick", "end")
            )
        bottom = TOP + HEIGHT
        values, places = ticks(0.0, self._end, most=6)
        for value, x in zip(values, self.x(np.array(values)), strict=True):
            parts.append(tag("line", x1=x, x2=x, y1=bottom, y2=bottom + 4.0, class_="axis"))
            parts.append(label(f"{value:.{places}f}", float(x), bottom + 16.0, "tick", "middle"))
        parts.append(label("time, s", WIDTH - RIGHT, bottom + 30.0, "tick", "end"))
        return join(parts)
