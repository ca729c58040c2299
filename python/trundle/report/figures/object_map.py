"""Map of the object, with the locations on it that the diagnosis gives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from trundle.report.figures import marks, wheels
from trundle.report.figures.canvas import Caption, Figure, figure, label
from trundle.report.figures.data import Data
from trundle.report.figures.top_view import TopView
from trundle.report.location import Place, Point, finite_pair, locate_effects
from trundle.report.quantity import format_point
from trundle.report.series import Array, Series
from trundle.report.svg import Child, Markup, tag

__all__ = ["draw", "draw_object", "hint_point"]


def draw(diagnosis: Mapping[str, Any], series: Series) -> Figure | None:
    """Return the map of footprint, support and located effects; None without a footprint (on a rail)."""
    if not series.footprint:
        return None
    missing = locate_effects(diagnosis.get("missing") or ())
    named = [(place, place.body) for place in missing if place.body is not None]
    hint = hint_point(diagnosis)
    fitted = wheels.known_wheels(diagnosis.get("nominal") or {})
    corners = np.concatenate(series.footprint)
    view = TopView.around(
        [
            corners,
            *series.feet,
            *_points_in_view(
                [*(point.mean for _, point in named), *(w.position for w in fitted)], hint, corners
            ),
        ]
    )
    drawing = view.with_frame(
        draw_object(view, series),
        [wheels.draw(view, wheel) for wheel in fitted],
        [marks.cross(view, point) for _, point in named],
        marks.numbers(view, [_number_mark(view, place, point) for place, point in named]),
        None if hint is None else marks.diamond(view, hint),
    )
    sentences = [f"{place.number}: {place.name} at {point}" for place, point in named]
    if hint is not None:
        sentences.append(f"the missing wrench acts near {format_point(hint)}")
    described = "; ".join(sentences) or "the diagnosis locates no effect on it"
    return figure(
        "object",
        "Top view of the object",
        f"Footprint in the object frame; {described}.",
        view.total_height,
        drawing,
        *_caption(named, hint, len(fitted), bool(series.feet)),
        data=_data(series, fitted, named, hint),
    )


def _data(
    series: Series,
    fitted: Sequence[wheels.Wheel],
    named: Sequence[tuple[Place, Point]],
    hint: Array | None,
) -> Data:
    """Return every point of the map: what it is, position and standard deviation, m, and angle, rad."""
    rows: list[tuple[str | float | None, ...]] = [
        ("corner", x, y, None, None, None) for polygon in series.footprint for x, y in polygon.tolist()
    ]
    rows += [("support", x, y, None, None, None) for x, y in series.support.tolist()]
    rows += [("wheel", *wheel.position.tolist(), None, None, wheel.angle) for wheel in fitted]
    rows += [(place.name, *point.mean.tolist(), *point.sd.tolist(), None) for place, point in named]
    rows += [] if hint is None else [("missing wrench", *hint.tolist(), None, None, None)]
    return Data(("mark", "x, m", "y, m", "sd of x, m", "sd of y, m", "angle, rad"), rows)


def hint_point(diagnosis: Mapping[str, Any]) -> Array | None:
    """Return the point (2,), m, object frame, near which an unexplained wrench acts; None otherwise."""
    if diagnosis.get("verdict") != "unexplained":
        return None
    return finite_pair((diagnosis.get("mismatch") or {}).get("body_point"))


def draw_object(view: TopView, series: Series) -> list[Child]:
    """Return the object in its own frame: outline, axes and support points."""
    return [
        [view.outline(polygon, "footprint") for polygon in series.footprint],
        _axes(view, np.concatenate(series.footprint)),
        [_support(view, foot) for foot in series.support],
    ]


def _number_mark(view: TopView, place: Place, point: Point) -> tuple[int, Array, float]:
    return place.number, point.mean, float(marks.WITHIN_95 * point.sd[0] * view.scale)


def _points_in_view(spots: Sequence[Array], hint: Array | None, corners: Array) -> list[Array]:
    """Return the points to show: those within twice the size of the object from its centre."""
    reach = 2.0 * float(np.ptp(corners, axis=0).max())
    found = [*spots] + ([] if hint is None else [hint])
    return [place[None] for place in found if np.abs(place - corners.mean(axis=0)).max() < reach]


def _axes(view: TopView, corners: Array) -> list[Markup]:
    """Return the axes of the object frame."""
    length = 0.22 * float(np.ptp(corners, axis=0).min())
    tips = np.array([[0.0, 0.0], [length, 0.0], [0.0, length]])
    origin, x, y = view.to_page(tips)
    arms = [marks.arrow(origin, tip, "axis", head=6.0) for tip in (x, y)]
    names = [
        label("x", x[0] + 5.0, x[1] + 4.0, "tick halo"),
        label("y", y[0], y[1] - 6.0, "tick halo", "middle"),
    ]
    return [*arms, *names]


def _support(view: TopView, foot: Array) -> Markup | None:
    if not np.isfinite(foot).all():
        return None
    x, y = view.to_page(foot[None])[0]
    return tag("circle", cx=x, cy=y, r=5.0, class_="support")


def _caption(
    named: Sequence[tuple[Place, Point]], hint: Array | None, fitted: int, feet: bool
) -> list[Caption]:
    ellipse = ", with its 95\N{NO-BREAK SPACE}% ellipse"
    lines = [
        (f"{place.number} ", f"{place.name}{ellipse if point.sd.all() else ''}. ") for place, point in named
    ]
    rest = []
    if hint is not None:
        rest.append("◇ point where the missing wrench acts.")
    if not named and hint is None:
        rest.append("The diagnosis locates no effect on the object.")
    if fitted:
        rest.append(f"▬ the fitted {'wheel' if fitted == 1 else 'wheels'}.")
    rest.append("Object frame.")
    rest += ["Circles: support points."] if feet else []
    return [*lines, ("", " ".join(rest))]
