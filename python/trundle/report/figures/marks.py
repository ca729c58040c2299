"""Marks on a map: points with their uncertainty, hints, arrows, and numbers that do not overlap."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from trundle.report.figures.canvas import WIDTH, label
from trundle.report.figures.top_view import TopView
from trundle.report.location import Point
from trundle.report.series import Array
from trundle.report.svg import Child, Markup, join, tag

__all__ = ["WITHIN_95", "arrow", "arrow_path", "cross", "diamond", "numbers", "plus", "ring"]

WITHIN_95 = 2.4477
"""Radius, in standard deviations, of the 95 % ellipse of a planar normal distribution."""

_CROSS_ARM = 9.0
_MIN_NUMBER_SPACING = 17.0


def cross(view: TopView, point: Point) -> list[Markup]:
    """Return a cross at a point, with its 95 % ellipse."""
    x, y = view.to_page(point.mean[None])[0]
    rx, ry = WITHIN_95 * point.sd * view.scale
    return [tag("ellipse", cx=x, cy=y, rx=rx, ry=ry, class_="likely"), plus(view, point.mean, "mark")]


def plus(view: TopView, place: Array, style: str) -> Markup:
    """Return an upright cross at a point (2,) in m."""
    (x, y), arm = view.to_page(place[None])[0], _CROSS_ARM
    arms = f"M{x - arm:.1f} {y:.1f}h{2 * arm:.0f}M{x:.1f} {y - arm:.1f}v{2 * arm:.0f}"
    return tag("path", d=arms, class_=style)


def diamond(view: TopView, place: Array) -> Markup:
    """Return the mark of a hint: a location that belongs to no named effect."""
    x, y = view.to_page(place[None])[0]
    return tag("path", d=f"M{x:.1f} {y - 10:.1f}l10 10l-10 10l-10 -10z", class_="hint")


def ring(view: TopView, place: Array) -> Markup:
    """Return the mark of an event on a path."""
    x, y = view.to_page(place[None])[0]
    return join([tag("circle", cx=x, cy=y, r=radius, class_="mark hollow") for radius in (3.5, 8.0)])


def arrow(start: Array, end: Array, style: str, head: float = 8.0, both: bool = False) -> Markup:
    """Return an arrow between two points (2,), user units; with `both`, it has a head at each end."""
    back = _head(end, start, head) if both else ""
    return tag("path", d=arrow_path(start, end, head) + back, class_=style)


def arrow_path(start: Array, end: Array, head: float) -> str:
    """Return the path data of an arrow with one head."""
    return f"M{start[0]:.1f} {start[1]:.1f}L{end[0]:.1f} {end[1]:.1f}{_head(start, end, head)}"


def _head(start: Array, end: Array, head: float) -> str:
    length = float(np.hypot(*(end - start)))
    if length <= 0.0:
        return ""
    back = -(end - start) / length * head
    aside = 0.45 * np.array([-back[1], back[0]])
    left, right = end + back + aside, end + back - aside
    return f"M{left[0]:.1f} {left[1]:.1f}L{end[0]:.1f} {end[1]:.1f}L{right[0]:.1f} {right[1]:.1f}"


def numbers(view: TopView, marked: Sequence[tuple[int, Array, float]]) -> Child:
    """Return numbers next to points, given as (number, point (2,) in m, radius of the mark in user units)."""
    taken: list[Array] = []
    found = []
    for number, point, reach in marked:
        position = _free_position(view, view.to_page(point[None])[0], max(reach, _CROSS_ARM) + 9.0, taken)
        taken.append(position)
        found.append(label(str(number), position[0], position[1] + 6.0, "number", "middle"))
    return found


def _free_position(view: TopView, at: Array, aside: float, taken: Sequence[Array]) -> Array:
    """Return the first position near a mark that is inside the frame and overlaps no other number."""
    aside = min(aside, 60.0)
    ways = [np.array(way) for way in ((1, 0), (-1, 0), (0, -1), (0, 1), (1, 1), (-1, 1), (1, -1), (-1, -1))]
    low, high = np.array([9.0, 11.0]), np.array([WIDTH - 9.0, view.height - 11.0])
    tries = [at + aside * factor * way for factor in (1.0, 1.8, 2.6) for way in ways]
    fits = (
        position
        for position in tries
        if (position >= low).all()
        and (position <= high).all()
        and all(np.abs(position - other).max() > _MIN_NUMBER_SPACING for other in taken)
    )
    clipped: Array = np.clip(at, low, high)
    return next(fits, clipped)
