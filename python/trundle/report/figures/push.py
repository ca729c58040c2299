"""A push to make: where to hold the object, which way to push, how force and torque go in time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from trundle.report.figures import lanes, marks
from trundle.report.figures.canvas import figure, label
from trundle.report.figures.lanes import Curve, Lane
from trundle.report.figures.place import body
from trundle.report.figures.plan import Plan
from trundle.report.given import Array, Series, finite
from trundle.report.markup import Child, Html, join, tag
from trundle.report.quantity import fixed
from trundle.report.where import pair

__all__ = ["draw"]

_MAP, _ARROW, _TURN = 190.0, 64.0, 26.0
_CHANNELS = ((1, "force along the arrow, N"), (3, "torque, N·m"))


def draw(identity: str, number: int | None, push: Mapping[str, Any], series: Series) -> Html | None:
    """Return the push on the object with its course below; None where the grasp point is not said.

    Parameters
    ----------
    identity
        Unique among the pushes of the page.
    number
        Its place among several.
    push
        `grasp` (x, y) m and `direction` rad, object frame; `knots`, rows of time s, force along and across
        the direction N, torque N·m, straight lines between.
    series
        For the object's shape.
    """
    grasp, direction = pair(push.get("grasp")), finite(push.get("direction"))
    if grasp is None or not series.footprint:
        return None
    knots = _knots(push.get("knots"))
    turns = len(knots) > 0 and not knots[:, 1:3].any()
    way = None if turns else direction
    plan = Plan.around([*series.footprint, *series.feet, grasp[None], *_room(series, grasp, way)], _MAP)
    view = plan.framed(body(plan, series), _arrow(plan, grasp, way), _turn(plan, grasp) if turns else None)
    graph, height = _course(knots)
    drawing: Child = [*view, tag("g", graph, transform=f"translate(0 {plan.total:.2f})")]
    text = _words(grasp, way, turns)
    title = "The push that would tell" if number is None else f"Push {number} of those that would tell"
    caption = [None if number is None else tag("b", f"Push {number}. "), text]
    return figure(f"push-{identity}", title, text, plan.total + height, drawing, caption)


def _words(grasp: Array, way: float | None, turns: bool) -> str:
    at = f"Hold at ({fixed(grasp[0], 2)}, {fixed(grasp[1], 2)})\N{NO-BREAK SPACE}m"
    if turns:
        return f"{at} and turn about there; object frame."
    return (
        f"{at}; object frame."
        if way is None
        else f"{at}, push towards {fixed(_degrees(way), 0)}°; object frame."
    )


def _degrees(angle: float) -> float:
    """Return an angle within (-180, 180] degrees."""
    return -(float(np.degrees(-angle) + 180.0) % 360.0 - 180.0)


def _knots(given: object) -> Array:
    """Return the rows (n, 4) of a course; none where it is not whole."""
    rows = np.asarray(given if isinstance(given, list) else [], dtype=np.float64)
    whole = rows.ndim == 2 and rows.shape[1:] == (4,) and len(rows) > 1 and bool(np.isfinite(rows).all())
    return rows if whole and rows[-1, 0] > rows[0, 0] else np.empty((0, 4))


def _room(series: Series, grasp: Array, direction: float | None) -> list[Array]:
    """Return about where the arrow ends, so that the map holds it."""
    if direction is None:
        return []
    length = 0.45 * float(np.ptp(np.concatenate(series.footprint), axis=0).max())
    return [(grasp + length * np.array([np.cos(direction), np.sin(direction)]))[None]]


def _arrow(plan: Plan, grasp: Array, direction: float | None) -> list[Html]:
    x, y = start = plan.at(grasp[None])[0]
    dot = tag("circle", cx=x, cy=y, r=5.5, class_="grasp")
    below = y < plan.height - 26.0
    name = label("hold", min(max(x, 18.0), 342.0), y + 18.0 if below else y - 10.0, "halo", "middle")
    if direction is None:
        return [dot, name]
    end = start + _ARROW * np.array([np.cos(direction), -np.sin(direction)])
    return [marks.arrow(start, end, "mark", head=11.0), dot, name]


def _turn(plan: Plan, grasp: Array) -> Html:
    """Return an arc about the grasp with a head at its end: to the left."""
    x, y = plan.at(grasp[None])[0]
    arc = f"M{x + _TURN:.1f} {y:.1f}A{_TURN:.0f} {_TURN:.0f} 0 1 0 {x:.1f} {y + _TURN:.1f}"
    return tag("path", d=f"{arc}m-9 -5l9 5l-7 8", class_="mark")


def _course(knots: Array) -> tuple[Html, float]:
    """Return force and torque in time, those that are not zero throughout, and their height."""
    rows = [
        _lane(title, knots[:, 0], knots[:, column])
        for column, title in _CHANNELS
        if len(knots) and knots[:, column].any()
    ]
    return lanes.draw(rows, (float(knots[0, 0]), float(knots[-1, 0]))) if rows else (join([]), 0.0)


def _lane(title: str, t: Array, values: Array) -> Lane:
    limits = lanes.bounds([Curve("", t, values), Curve("", t[:1], np.zeros(1))])
    return Lane(title, (Curve("after", t, values),), limits)
