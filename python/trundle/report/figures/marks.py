"""Marks on a map: points with their uncertainty, hints, arrows, and numbers that do not cover each other."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from trundle.report.figures.canvas import WIDTH, label
from trundle.report.figures.plan import Plan
from trundle.report.given import Array
from trundle.report.markup import Child, Html, join, tag
from trundle.report.where import Spot

__all__ = ["WITHIN_95", "arrow", "cross", "diamond", "numbers", "ring"]

WITHIN_95 = 2.4477
"""Radius in standard deviations of the ellipse that holds a planar normal with probability 0.95."""

_ARM = 9.0
_APART = 17.0


def cross(plan: Plan, spot: Spot) -> list[Html]:
    """Return a point with the ellipse that holds it with probability 0.95."""
    x, y = plan.at(spot.mean[None])[0]
    rx, ry = WITHIN_95 * spot.sd * plan.scale
    arms = f"M{x - _ARM:.1f} {y:.1f}h{2 * _ARM:.0f}M{x:.1f} {y - _ARM:.1f}v{2 * _ARM:.0f}"
    return [
        tag("ellipse", cx=x, cy=y, rx=rx, ry=ry, class_="likely"),
        tag("path", d=arms, class_="mark"),
    ]


def diamond(plan: Plan, place: Array) -> Html:
    """Return the mark of a place that is not an effect's: a hint."""
    x, y = plan.at(place[None])[0]
    return tag("path", d=f"M{x:.1f} {y - 10:.1f}l10 10l-10 10l-10 -10z", class_="hint")


def ring(plan: Plan, place: Array) -> Html:
    """Return the mark of a moment on a path."""
    x, y = plan.at(place[None])[0]
    return join([tag("circle", cx=x, cy=y, r=radius, class_="mark hollow") for radius in (3.5, 8.0)])


def arrow(start: Array, end: Array, style: str, head: float = 8.0, both: bool = False) -> Html:
    """Return an arrow from (2,) to (2,) in user units, with a head at each end if it has no sense."""
    parts = [f"M{start[0]:.1f} {start[1]:.1f}L{end[0]:.1f} {end[1]:.1f}", _head(start, end, head)]
    return tag("path", d="".join([*parts, _head(end, start, head)] if both else parts), class_=style)


def _head(start: Array, end: Array, head: float) -> str:
    length = float(np.hypot(*(end - start)))
    if length <= 0.0:
        return ""
    back = -(end - start) / length * head
    aside = 0.45 * np.array([-back[1], back[0]])
    left, right = end + back + aside, end + back - aside
    return f"M{left[0]:.1f} {left[1]:.1f}L{end[0]:.1f} {end[1]:.1f}L{right[0]:.1f} {right[1]:.1f}"


def numbers(plan: Plan, marked: Sequence[tuple[int, Array, float]]) -> Child:
    """Return numbers beside points; each is (number, point (2,) m, how far the mark reaches, user units)."""
    taken: list[Array] = []
    found = []
    for number, point, reach in marked:
        spot = _free(plan, plan.at(point[None])[0], max(reach, _ARM) + 9.0, taken)
        taken.append(spot)
        found.append(label(str(number), spot[0], spot[1] + 6.0, "number", "middle"))
    return found


def _free(plan: Plan, at: Array, aside: float, taken: Sequence[Array]) -> Array:
    """Return the first place beside a mark that lies in the frame and on no other number."""
    aside = min(aside, 60.0)
    ways = [np.array(way) for way in ((1, 0), (-1, 0), (0, -1), (0, 1), (1, 1), (-1, 1), (1, -1), (-1, -1))]
    low, high = np.array([9.0, 11.0]), np.array([WIDTH - 9.0, plan.height - 11.0])
    tries = [at + aside * factor * way for factor in (1.0, 1.8, 2.6) for way in ways]
    fits = (
        spot
        for spot in tries
        if (spot >= low).all()
        and (spot <= high).all()
        and all(np.abs(spot - other).max() > _APART for other in taken)
    )
    clipped: Array = np.clip(at, low, high)
    return next(fits, clipped)
