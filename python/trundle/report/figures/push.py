"""A discriminating push: grasp point, direction, and the force and torque over time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from trundle.report.figures import lanes, marks
from trundle.report.figures.canvas import Figure, figure, label
from trundle.report.figures.curves import Curve, Lane, bounds
from trundle.report.figures.data import Data
from trundle.report.figures.object_map import draw_object
from trundle.report.figures.top_view import TopView
from trundle.report.location import finite_pair
from trundle.report.quantity import format_fixed, format_point
from trundle.report.series import Array, Series, finite
from trundle.report.svg import Child, Markup, join, tag

__all__ = ["draw"]

_MAP_HEIGHT, _ARROW, _TURN = 190.0, 64.0, 26.0
_CHANNELS = ((1, "force along the arrow, N"), (3, "torque, N·m"))


def draw(identity: str, number: int | None, push: Mapping[str, Any], series: Series) -> Figure | None:
    """Return the push on the object with its time course below; None without a grasp point.

    Parameters
    ----------
    identity
        Unique among the pushes of the page.
    number
        Number among several pushes, from 1; None for a single push.
    push
        `grasp` (x, y), m, and `direction`, rad, object frame; `knots`: rows of time, s, force along and
        across the direction, N, and torque, N·m, interpolated linearly.
    series
        For the shape of the object.
    """
    grasp, direction = finite_pair(push.get("grasp")), finite(push.get("direction"))
    if grasp is None or not series.footprint:
        return None
    knots = _knots(push.get("knots"))
    turns = len(knots) > 0 and not knots[:, 1:3].any()
    way = None if turns else direction
    view = TopView.around(
        [*series.footprint, *series.feet, grasp[None], *_arrow_tip(series, grasp, way)], _MAP_HEIGHT
    )
    framed = view.with_frame(
        draw_object(view, series), _arrow(view, grasp, way), _turn(view, grasp) if turns else None
    )
    graph, height = _time_course(knots)
    drawing: Child = [*framed, tag("g", graph, transform=f"translate(0 {view.total_height:.2f})")]
    text = _instruction(grasp, way, turns)
    title = "Discriminating push" if number is None else f"Discriminating push {number}"
    caption = "" if number is None else f"Push {number}. ", text
    data = Data(("time, s", "force along, N", "force across, N", "torque, N·m"), knots.tolist())
    return figure(f"push-{identity}", title, text, view.total_height + height, drawing, caption, data=data)


def _instruction(grasp: Array, way: float | None, turns: bool) -> str:
    at = f"Grasp at {format_point(grasp)}"
    if turns:
        return f"{at} and turn about that point (object frame)."
    return (
        f"{at} (object frame)."
        if way is None
        else f"{at} and push towards {format_fixed(_degrees(way), 0)}° (object frame)."
    )


def _degrees(angle: float) -> float:
    """Convert an angle from rad to degrees in (-180, 180]."""
    return -(float(np.degrees(-angle) + 180.0) % 360.0 - 180.0)


def _knots(given: object) -> Array:
    """Return the rows (n, 4) of a time course; an empty array if it is not valid."""
    rows = np.asarray(given if isinstance(given, list) else [], dtype=np.float64)
    whole = rows.ndim == 2 and rows.shape[1:] == (4,) and len(rows) > 1 and bool(np.isfinite(rows).all())
    return rows if whole and rows[-1, 0] > rows[0, 0] else np.empty((0, 4))


def _arrow_tip(series: Series, grasp: Array, direction: float | None) -> list[Array]:
    """Return the approximate end of the arrow, so that the map contains it."""
    if direction is None:
        return []
    length = 0.45 * float(np.ptp(np.concatenate(series.footprint), axis=0).max())
    return [(grasp + length * np.array([np.cos(direction), np.sin(direction)]))[None]]


def _arrow(view: TopView, grasp: Array, direction: float | None) -> list[Markup]:
    x, y = start = view.to_page(grasp[None])[0]
    dot = tag("circle", cx=x, cy=y, r=5.5, class_="grasp")
    below = y < view.height - 26.0
    name = label("grasp", min(max(x, 18.0), 342.0), y + 18.0 if below else y - 10.0, "halo", "middle")
    if direction is None:
        return [dot, name]
    end = start + _ARROW * np.array([np.cos(direction), -np.sin(direction)])
    return [marks.arrow(start, end, "mark", head=11.0), dot, name]


def _turn(view: TopView, grasp: Array) -> Markup:
    """Return a counter-clockwise arc with an arrow head about the grasp."""
    x, y = view.to_page(grasp[None])[0]
    arc = f"M{x + _TURN:.1f} {y:.1f}A{_TURN:.0f} {_TURN:.0f} 0 1 0 {x:.1f} {y + _TURN:.1f}"
    return tag("path", d=f"{arc}m-9 -5l9 5l-7 8", class_="mark")


def _time_course(knots: Array) -> tuple[Markup, float]:
    """Return force and torque over time, without channels that are zero throughout, and the height."""
    rows = [
        _lane(title, knots[:, 0], knots[:, column])
        for column, title in _CHANNELS
        if len(knots) and knots[:, column].any()
    ]
    return lanes.draw(rows, (float(knots[0, 0]), float(knots[-1, 0]))) if rows else (join([]), 0.0)


def _lane(title: str, t: Array, values: Array) -> Lane:
    limits = bounds([Curve("", t, values), Curve("", t[:1], np.zeros(1))])
    return Lane(title, (Curve("after", t, values),), limits)
