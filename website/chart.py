"""Panels of inline SVG figures; the style sheet of the site sets their colours."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trundle.report.figures.canvas import label, polyline, ticks
from trundle.report.svg import Markup, join, tag

__all__ = ["Panel", "key", "svg"]

Points = NDArray[np.float64]


@dataclass(frozen=True)
class Panel:
    """A rectangle of a drawing with the scales of its two axes.

    Attributes
    ----------
    left, top, width, height : float
        Rectangle of the data, user units.
    x, y : tuple of float
        Lower and upper limit of the data shown.
    """

    left: float
    top: float
    width: float
    height: float
    x: tuple[float, float]
    y: tuple[float, float]

    @classmethod
    def equal(cls, left: float, top: float, width: float, height: float, points: Points) -> Panel:
        """Return a panel with equal scales that contains all points (n, 2) with a margin."""
        low, high = points.min(axis=0), points.max(axis=0)
        middle, span = (low + high) / 2, 1.08 * (high - low)
        scale = max(span[0] / width, span[1] / height)
        half = scale * np.array([width, height]) / 2
        (x0, y0), (x1, y1) = middle - half, middle + half
        return cls(left, top, width, height, (float(x0), float(x1)), (float(y0), float(y1)))

    def place(self, points: Points) -> Points:
        """Return points (n, 2) of the data in user units; y is clipped to the panel."""
        (x0, x1), (y0, y1) = self.x, self.y
        u = self.left + (points[:, 0] - x0) / (x1 - x0) * self.width
        v = self.top + (1 - (points[:, 1] - y0) / (y1 - y0)) * self.height
        return np.column_stack([u, np.clip(v, self.top, self.top + self.height)])

    def line(self, points: Points, style: str) -> Markup:
        """Return a line through points (n, 2)."""
        return polyline(self.place(points), style)

    def area(self, points: Points, style: str) -> Markup:
        """Return a polygon with corners (n, 2)."""
        corners = " ".join(f"{u:.1f},{v:.1f}" for u, v in self.place(points))
        return tag("polygon", points=corners, class_=style)

    def text(self, text: str, point: tuple[float, float], style: str) -> Markup:
        """Return text centred at a point of the data."""
        ((u, v),) = self.place(np.array([point]))
        return label(text, float(u), float(v) + 4, style, "middle")

    def axes(self, title: str, x_name: str | None, y_name: str) -> Markup:
        """Return grid, numbers and names of the axes."""
        bottom, right = self.top + self.height, self.left + self.width
        parts = [label(title, self.left, self.top - 8, "title")]
        values, decimals = ticks(*self.x, 7)
        for value in values:
            ((u, _),) = self.place(np.array([[value, self.y[0]]]))
            parts.append(tag("path", d=f"M{u:.1f} {self.top:.1f}V{bottom:.1f}", class_="grid"))
            if x_name is not None:
                parts.append(label(number(value, decimals), float(u), bottom + 15, "tick", "middle"))
        values, decimals = ticks(*self.y, 5)
        for value in values:
            ((_, v),) = self.place(np.array([[self.x[0], value]]))
            parts.append(tag("path", d=f"M{self.left:.1f} {v:.1f}H{right:.1f}", class_="grid"))
            parts.append(label(number(value, decimals), self.left - 6, float(v) + 4, "tick", "end"))
        parts.append(label(y_name, self.left, self.top + 13, "name"))
        if x_name is not None:
            parts.append(label(x_name, right, bottom - 6, "name", "end"))
        return join(parts)


def number(value: float, decimals: int) -> str:
    """Return a tick's number with a minus sign."""
    return f"{value:.{decimals}f}".replace("-", "−")


def key(entries: list[tuple[str, str]], right: float, baseline: float) -> Markup:
    """Return a legend on one line that ends at `right`: pairs of a style of a line and its name."""
    parts = []
    for style, name in reversed(entries):
        right -= 7.0 * len(name)
        parts += [label(name, right, baseline, "name"), line_sample(style, right - 24, baseline - 4)]
        right -= 36
    return join(parts)


def line_sample(style: str, left: float, v: float) -> Markup:
    """Return a short horizontal line."""
    return tag("path", d=f"M{left:.1f} {v:.1f}h18", class_=style)


def svg(width: float, height: float, description: str, parts: list[Markup]) -> str:
    """Return an SVG element for a page, which scrolls on narrow screens."""
    box = f"0 0 {width:g} {height:g}"
    drawing = join([tag("title", description), *parts])
    drawn = tag("svg", drawing, viewBox=box, role="img", class_="chart")
    return str(tag("div", drawn, class_="chart-scroll"))
